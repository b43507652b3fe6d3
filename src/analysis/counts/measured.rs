//! What is kept of any number of trials: counts of ratings, repeated ratings, response times.

use std::collections::BTreeSet;

use super::table::{CountRow, Counts, Factor};
use crate::analysis::{levels, retest::Retest, times::Times};

/// The ratings of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// How often each subject gave each rating in each condition.
    pub counts: Counts,
    /// First and second rating of the conditions that a subject rated more than once.
    pub retests: Vec<RetestPair>,
    /// Response times.
    pub times: Vec<TimeCount>,
}

/// A subject's first and second rating of a condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RetestPair {
    /// Index into [`Counts::subjects`].
    pub subject: u32,
    /// Index into [`Counts::conditions`].
    pub condition: u32,
    /// Index into [`Counts::categories`] of the first rating.
    pub first: u8,
    /// Of the second.
    pub second: u8,
}

/// How many answers took about as long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeCount {
    /// Index into [`Counts::subjects`].
    pub subject: u32,
    /// Index into [`Counts::conditions`].
    pub condition: u32,
    /// Index into [`Counts::categories`].
    pub rating: u8,
    pub(super) bin: u16,
    pub(super) count: u64,
}

impl Measured {
    /// Response times by group: each trial in the group that `group_of` names, if any.
    pub fn times_by(&self, groups: usize, group_of: impl Fn(&TimeCount) -> Option<usize>) -> Vec<Times> {
        let mut times = vec![Times::default(); groups];
        for row in &self.times {
            if let Some(group) = group_of(row) {
                times[group].add(row.bin, row.count);
            }
        }
        times
    }

    /// First against second ratings of every subject.
    pub fn retests(&self) -> Vec<Retest> {
        let mut retests = vec![Retest::new(self.counts.categories.len()); self.counts.subjects.len()];
        for pair in &self.retests {
            retests[pair.subject as usize].add(pair.first.into(), pair.second.into());
        }
        retests
    }

    /// What is left of some subjects and some conditions. Levels and subjects without ratings are gone; categories
    /// stay.
    #[must_use]
    pub fn filtered(&self, subject: impl Fn(u32) -> bool, condition: impl Fn(&[Option<u32>]) -> bool) -> Self {
        let counts = &self.counts;
        let kept: Vec<bool> = counts.conditions.iter().map(|levels| condition(levels)).collect();
        let keep = |s: u32, c: u32| subject(s) && kept[c as usize];
        let rows: Vec<CountRow> = counts.rows.iter().filter(|row| keep(row.subject, row.condition)).copied().collect();
        let subjects = Kept::new(rows.iter().map(|row| row.subject));
        let conditions = Kept::new(rows.iter().map(|row| row.condition));
        let levels: Vec<Kept> = (0..counts.factors.len())
            .map(|factor| Kept::new(conditions.0.iter().filter_map(|&c| counts.conditions[c as usize][factor])))
            .collect();
        let factors = counts.factors.iter().zip(&levels).map(|(factor, kept)| {
            let levels: Vec<String> = kept.of(&factor.levels);
            Factor { name: factor.name.clone(), numbers: levels::numbers_of(&levels), levels }
        });
        let renumbered = |levels_of: &Vec<Option<u32>>| {
            levels_of.iter().zip(&levels).map(|(level, kept)| level.map(|level| kept.index(level))).collect()
        };
        let moved = |s: u32, c: u32| (subjects.index(s), conditions.index(c));
        Self {
            counts: Counts {
                subjects: subjects.of(&counts.subjects),
                factors: factors.collect(),
                conditions: conditions.of(&counts.conditions).iter().map(renumbered).collect(),
                categories: counts.categories.clone(),
                rows: (rows.iter())
                    .map(|row| {
                        let (subject, condition) = moved(row.subject, row.condition);
                        CountRow { subject, condition, ..*row }
                    })
                    .collect(),
            },
            retests: (self.retests.iter().filter(|pair| keep(pair.subject, pair.condition)))
                .map(|pair| {
                    let (subject, condition) = moved(pair.subject, pair.condition);
                    RetestPair { subject, condition, ..*pair }
                })
                .collect(),
            times: (self.times.iter().filter(|row| keep(row.subject, row.condition)))
                .map(|row| {
                    let (subject, condition) = moved(row.subject, row.condition);
                    TimeCount { subject, condition, ..*row }
                })
                .collect(),
        }
    }
}

/// The indices that stay, in order.
struct Kept(Vec<u32>);

impl Kept {
    fn new(indices: impl Iterator<Item = u32>) -> Self {
        Self(indices.collect::<BTreeSet<_>>().into_iter().collect())
    }

    /// The new index of one that stays.
    fn index(&self, old: u32) -> u32 {
        self.0.partition_point(|kept| *kept < old) as u32
    }

    /// What stays of a list.
    fn of<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.0.iter().map(|&index| all[index as usize].clone()).collect()
    }
}
