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
    /// Returns the ratings that have values of these factors, given by index, unless none would be left. The others are
    /// recorded as excluded.
    #[must_use]
    pub(in crate::analysis) fn complete(mut self, factors: &[usize]) -> Self {
        for &factor in factors {
            let is_missing = |row: &&CountRow| self.counts.conditions[row.condition as usize][factor].is_none();
            let missing: Vec<&CountRow> = self.counts.rows.iter().filter(is_missing).collect();
            if missing.is_empty() || missing.len() == self.counts.rows.len() {
                continue;
            }
            let excluded = Excluded {
                what: Part::Missing(self.counts.factors[factor].name.clone()),
                ratings: missing.iter().map(|row| row.count).sum(),
                participants: missing.iter().map(|row| row.subject).collect::<BTreeSet<_>>().len() as u64,
            };
            self = self.filtered(|_| true, |levels| levels[factor].is_some());
            self.excluded.push(excluded);
        }
        self
    }

    /// Returns the ratings without what is to be excluded.
    ///
    /// # Errors
    /// A name is not known, or no ratings are left.
    pub fn narrowed(&self, exclusions: &Exclusions) -> Result<Self, ExclusionError> {
        let counts = &self.counts;
        let people = people(counts, &exclusions.exclude)?;
        let only: Vec<(usize, &[String])> =
            exclusions.only.iter().map(|(name, kept)| levels(counts, name, kept)).collect::<Result<_, _>>()?;
        let level_of = |levels: &[Option<u32>], factor: usize| {
            levels[factor].map_or(MISSING, |level| counts.factors[factor].levels[level as usize].as_str())
        };
        let is_kept = |levels: &[Option<u32>], (factor, kept): &(usize, &[String])| {
            kept.iter().any(|name| name == level_of(levels, *factor))
        };
        // Each rating is counted once: for its participant, or else for the first factor that excludes it.
        let participants = people.iter().map(|&index| Part::Participant(counts.subjects[index as usize].clone()));
        let levels = only.iter().map(|&(factor, kept)| {
            let factor = counts.factors[factor].name.clone();
            Part::Levels { factor, kept: kept.to_vec() }
        });
        let parts = participants.chain(levels);
        let mut excluded: Vec<_> = parts.map(|what| Excluded { what, ratings: 0, participants: 0 }).collect();
        let mut seen = BTreeSet::new();
        for row in &counts.rows {
            let levels = &counts.conditions[row.condition as usize];
            let reason = (people.iter().position(|person| *person == row.subject))
                .or_else(|| only.iter().position(|one| !is_kept(levels, one)).map(|index| people.len() + index));
            let Some(reason) = reason else { continue };
            excluded[reason].ratings += row.count;
            excluded[reason].participants += u64::from(seen.insert((reason, row.subject)));
        }
        let left =
            self.filtered(|subject| !people.contains(&subject), |levels| only.iter().all(|one| is_kept(levels, one)));
        if left.counts.total() == 0 && counts.total() > 0 {
            return Err(ExclusionError::Nothing);
        }
        Ok(Self { excluded: [left.excluded, excluded].concat(), ..left })
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
            levels(self, name, &texts).map(drop)
        })
    }
}

/// Returns the indices of participants, each once.
fn people(counts: &Counts, ids: &[String]) -> Result<Vec<u32>, ExclusionError> {
    let mut people = Vec::new();
    for id in ids {
        let index = counts
            .subjects
            .iter()
            .position(|known| known == id)
            .ok_or_else(|| ExclusionError::Participant { id: id.clone(), known: counts.subjects.clone() })?;
        if !people.contains(&(index as u32)) {
            people.push(index as u32);
        }
    }
    Ok(people)
}

/// Returns the index of a factor, and checks its levels.
fn levels<'a>(counts: &Counts, name: &str, kept: &'a [String]) -> Result<(usize, &'a [String]), ExclusionError> {
    let (index, _) = counts.factor(name).ok_or_else(|| ExclusionError::Factor {
        name: name.to_owned(),
        known: counts.factors.iter().map(|factor| factor.name.clone()).collect(),
    })?;
    let known = counts.selectable_levels(index);
    match kept.iter().find(|level| !known.contains(level)) {
        Some(level) => Err(ExclusionError::Level { factor: name.to_owned(), level: level.clone(), known }),
        None => Ok((index, kept)),
    }
}
