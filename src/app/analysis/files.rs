//! The files of an analysis, as they were when they were read.

use std::{path::PathBuf, time::SystemTime};

use crate::{store::ratings::with_files, system::found, work::Analyze};

/// Files that were read, and how.
pub struct Files {
    pub asked: Analyze,
    seen: Seen,
}

/// The size of each file and when it was last changed, or why that is not known.
type Seen = Result<Vec<(PathBuf, Option<(u64, Option<SystemTime>)>)>, String>;

impl Files {
    /// Looks at the files. Call this before they are read, so that no change is missed.
    pub fn of(asked: Analyze) -> Self {
        Self { seen: seen(&asked), asked }
    }

    /// Returns whether the files are now others, or have changed.
    pub fn have_changed(&self) -> bool {
        self.seen != seen(&self.asked)
    }
}

fn seen(asked: &Analyze) -> Seen {
    let files = with_files(asked.ratings.paths.clone()).map_err(|error| error.to_string())?;
    let state = |path: PathBuf| {
        let metadata = found(&path).map_err(|error| error.to_string())?;
        // The time of a folder also changes when something else is written into it.
        let file = metadata.filter(|metadata| !metadata.is_dir());
        Ok((path, file.map(|file| (file.len(), file.modified().ok()))))
    };
    files.into_iter().map(state).collect()
}
