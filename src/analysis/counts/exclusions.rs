//! Excludes participants and levels on request, and records what was excluded.

use std::collections::BTreeSet;

use thiserror::Error;

use super::table::{CountRow, Counts, Excluded, Measured, Part};
use crate::{analysis::levels::number_of, text::names::expected_one_of};

/// The word for a missing level in [`Exclusions::only`]. No level has this name.
pub const MISSING: &str = "NA";

/// What to exclude.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Exclusions {
    /// Participants to leave out.
    pub exclude: Vec<String>,
    /// Factors, each with the levels to keep. `NA` stands for a missing value.
    pub only: Vec<(String, Vec<String>)>,
}

/// The reason why an exclusion is impossible.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ExclusionError {
    /// There is no such participant.
    #[error("{id} is not a participant; {}", expected_one_of(.id, .known))]
    Participant {
        /// The name that was given.
        id: String,
        /// All participants.
        known: Vec<String>,
    },
    /// There is no such factor.
    #[error("{name} is not a factor; {}", expected_one_of(.name, .known))]
    Factor {
        /// The name that was given.
        name: String,
        /// All factors.
        known: Vec<String>,
    },
    /// The factor has no such level.
    #[error(
        "{level} is not a level of {factor}; {}{}",
        expected_one_of(.level, .known),
        if .level.contains('=') { "; repeat the option for another factor" } else { "" }
    )]
    Level {
        /// Name of the factor.
        factor: String,
        /// The level that was given.
        level: String,
        /// All levels.
        known: Vec<String>,
    },
    /// Nothing is left.
    #[error("no ratings are left; expected to keep some participants and levels")]
    Nothing,
}

impl Counts {
    /// Returns the number of conditions in which every factor has a value.
    pub fn complete_conditions(&self) -> u64 {
        (0..self.conditions.len() as u32).filter(|condition| self.is_complete(*condition)).count() as u64
    }

    /// Returns whether every factor has a value in a condition.
    pub(in crate::analysis) fn is_complete(&self, condition: u32) -> bool {
        self.conditions[condition as usize].iter().all(Option::is_some)
    }

    /// Returns the levels of a factor, and `NA` if it has missing values.
    pub fn selectable_levels(&self, factor: usize) -> Vec<String> {
        let is_missing = self.conditions.iter().any(|levels| levels[factor].is_none());
        self.factors[factor].levels.iter().cloned().chain(is_missing.then(|| MISSING.to_owned())).collect()
    }
}

impl Measured {
    /// Returns the ratings that are kept; the others are recorded as excluded.
    fn keeping(&self, what: Part, subject: impl Fn(u32) -> bool, levels: impl Fn(&[Option<u32>]) -> bool) -> Self {
        let counts = &self.counts;
        let is_out = |row: &&CountRow| !subject(row.subject) || !levels(&counts.conditions[row.condition as usize]);
        let out: Vec<&CountRow> = counts.rows.iter().filter(is_out).collect();
        let participants = out.iter().map(|row| row.subject).collect::<BTreeSet<_>>().len() as u64;
        let excluded = Excluded { what, ratings: out.iter().map(|row| row.count).sum(), participants };
        let mut left = self.filtered(subject, levels);
        left.excluded.push(excluded);
        left
    }

    /// Returns the ratings that have values of these factors, given by index, unless none would be left. The others are
    /// recorded as excluded.
    #[must_use]
    pub(in crate::analysis) fn complete(mut self, factors: &[usize]) -> Self {
        for &factor in factors {
            let has = |row: &&CountRow| self.counts.conditions[row.condition as usize][factor].is_some();
            let kept = self.counts.rows.iter().filter(has).count();
            if kept > 0 && kept < self.counts.rows.len() {
                let what = Part::Missing(self.counts.factors[factor].name.clone());
                self = self.keeping(what, |_| true, |levels| levels[factor].is_some());
            }
        }
        self
    }

    /// Returns the ratings without what is to be excluded. Each rating is counted once: for its participant, or else for the
    /// first factor that excludes it.
    ///
    /// # Errors
    /// A name is not known, or no ratings are left.
    pub fn narrowed(&self, Exclusions { exclude, only }: &Exclusions) -> Result<Self, ExclusionError> {
        let known = &self.counts.subjects;
        if let Some(id) = exclude.iter().find(|id| !known.contains(id)) {
            return Err(ExclusionError::Participant { id: id.clone(), known: known.clone() });
        }
        only.iter().try_for_each(|(name, kept)| levels(&self.counts, name, kept))?;
        let mut left = self.clone();
        for id in exclude {
            // Someone who is named twice is already left out.
            if let Some(index) = left.counts.subjects.iter().position(|own| own == id) {
                left = left.keeping(Part::Participant(id.clone()), |subject| subject as usize != index, |_| true);
            }
        }
        for (name, kept) in only {
            let Some((index, factor)) = left.counts.factor(name) else { continue };
            let level_of = |level: u32| factor.levels[level as usize].as_str();
            let is_kept =
                |levels: &[Option<u32>]| kept.iter().any(|own| own == levels[index].map_or(MISSING, level_of));
            left = left.keeping(Part::Levels { factor: name.clone(), kept: kept.clone() }, |_| true, is_kept);
        }
        if left.counts.total() == 0 && self.counts.total() > 0 {
            return Err(ExclusionError::Nothing);
        }
        Ok(left)
    }
}

impl Counts {
    /// Checks the names of factors and of their levels.
    ///
    /// # Errors
    /// A name is not known.
    pub fn check_levels(&self, named: &[(String, Vec<String>)]) -> Result<(), ExclusionError> {
        named.iter().try_for_each(|(name, own)| {
            let factor = self.factors.iter().find(|factor| factor.name == *name);
            let numbers: Vec<f64> =
                factor.iter().flat_map(|factor| &factor.levels).filter_map(|level| number_of(level)).collect();
            // A number names a level however it is written: 2.0 is 2.
            let is_number = |level: &&String| number_of(level).is_some_and(|number| numbers.contains(&number));
            let texts: Vec<String> = own.iter().filter(|level| !is_number(level)).cloned().collect();
            levels(self, name, &texts)
        })
    }
}

/// Checks the name of a factor and of its levels.
fn levels(counts: &Counts, name: &str, kept: &[String]) -> Result<(), ExclusionError> {
    let (index, _) = counts.factor(name).ok_or_else(|| ExclusionError::Factor {
        name: name.to_owned(),
        known: counts.factors.iter().map(|factor| factor.name.clone()).collect(),
    })?;
    let known = counts.selectable_levels(index);
    match kept.iter().find(|level| !known.contains(level)) {
        Some(level) => Err(ExclusionError::Level { factor: name.to_owned(), level: level.clone(), known }),
        None => Ok(()),
    }
}
