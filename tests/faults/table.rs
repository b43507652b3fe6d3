//! What the faults caused, counted.

use std::collections::BTreeMap;

/// The counts of a session: what was counted, and the number.
pub type Counts = Vec<(&'static str, usize)>;

#[derive(Debug, Default)]
pub struct Table(BTreeMap<&'static str, usize>);

impl Table {
    pub fn add(&mut self, counts: Counts) {
        counts.into_iter().for_each(|(what, n)| *self.0.entry(what).or_default() += n);
    }

    pub fn total(&self, what: &str) -> usize {
        self.0.get(what).copied().unwrap_or_default()
    }
}
