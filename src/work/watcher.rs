//! Whoever waits for an operation.

use std::path::Path;

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
