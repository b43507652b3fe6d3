//! Whether files are as machband expects them.

use std::path::PathBuf;

use serde::Serialize;

use super::{Found, Watcher};
use crate::store::{
    check::{check_large, session_of_frames},
    image::MAX_PIXELS,
};

/// Check definitions, result files, display profiles, readings, observers, scenes and images, and report every error.
///
/// Prints a warning to stderr, but no error, for a display profile that is old or dated in the future, for texts for which
/// this computer has no font, and for the incomplete last line of a session that was interrupted.
#[derive(Clone, Debug, PartialEq, Eq, clap::Args, Serialize)]
#[command(after_help = "Example: machband check my-study.toml results/quick/data/*.csv")]
pub struct Check {
    /// Files, or names of built-in definitions.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Also check images of more than 4096 × 4096 pixels, which needs more time and memory.
    #[arg(long)]
    pub large: bool,
}

impl Check {
    /// Describes each file in a sentence, or finds every error in it. The watcher is warned of what is no error.
    ///
    /// # Errors
    /// The watcher ended it.
    pub fn check(&self, watcher: &dyn Watcher) -> anyhow::Result<Found> {
        let pixels = if self.large { u64::MAX } else { MAX_PIXELS };
        let mut all = Found::default();
        for file in &self.files {
            // A pattern such as `data/*.csv` names both files of a session.
            if let Ok(Some(csv)) = session_of_frames(file)
                && self.files.contains(&csv)
            {
                all.add(file, format!("frames; checked with {}", csv.display()), watcher)?;
                continue;
            }
            match check_large(file, pixels) {
                Ok(found) => {
                    let warning = found.warning.map(|warning| format!("{}: {warning}", file.display()));
                    warning.iter().for_each(|warning| watcher.warn(warning));
                    all.add(file, found.sentence, watcher)?;
                }
                Err(error) => all.errors.push(error),
            }
        }
        Ok(all)
    }
}
