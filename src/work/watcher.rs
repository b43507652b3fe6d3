//! Whoever waits for an operation, and what it learns about files.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use crate::store::StoreError;

/// Learns how far an operation is, and may end it. A skin shows what it learns in its own way.
pub trait Watcher: Sync {
    /// Learns what is being done now, such as `reading`.
    fn stage(&self, _what: &'static str) {}
    /// Learns that `done` of `total` steps are done. Steps may end out of order.
    fn progress(&self, _done: u64, _total: u64) {}
    /// Receives a warning.
    fn warn(&self, _warning: &str) {}
    /// Learns something about a file as soon as it is known.
    ///
    /// # Errors
    /// The operation should end.
    fn found(&self, _file: &Path, _sentence: &str) -> anyhow::Result<()> {
        Ok(())
    }
    /// Says whether to continue; `place` is where the results so far are.
    ///
    /// # Errors
    /// The operation should end.
    fn check(&self, _place: &Path) -> anyhow::Result<()> {
        Ok(())
    }
}

/// Nobody waits.
impl Watcher for () {}

/// A sentence about each file, and everything that is wrong.
#[derive(Debug, Default)]
pub struct Found {
    pub files: Vec<(PathBuf, String)>,
    /// The data files of the sessions in which something is wrong.
    pub wrong: BTreeSet<PathBuf>,
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
