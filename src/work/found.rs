//! What an operation found out about files.

use std::path::{Path, PathBuf};

use super::Watcher;
use crate::store::StoreError;

/// A sentence about each file, and everything that is wrong.
#[derive(Debug, Default)]
pub struct Found {
    pub files: Vec<(PathBuf, String)>,
    pub errors: Vec<StoreError>,
}

impl Found {
    /// Adds a sentence about a file, of which the watcher learns at once.
    ///
    /// # Errors
    /// The watcher ends the operation.
    pub(super) fn add(&mut self, file: &Path, sentence: String, watcher: &dyn Watcher) -> anyhow::Result<()> {
        watcher.found(file, &sentence)?;
        self.files.push((file.to_owned(), sentence));
        Ok(())
    }
}
