//! Reduces trials to counts and response times.

use std::{
    cmp::Ordering,
    collections::{BTreeSet, HashMap},
};

use super::table::{CountRow, Counts, Factor, Measured, Trial, summed};
use crate::{analysis::levels, experiment::RatingRow};

/// Collects trials, which can come in any order, into [`Measured`].
#[derive(Clone, Debug, Default)]
pub struct MeasuredBuilder {
    factors: Vec<String>,
    declared: Option<Vec<String>>,
    /// Names of the factors that are directions.
    pub directions: Vec<String>,
    /// Factors with the order of their levels. Levels that are not among them follow, in their own order.
    pub levels: Vec<(String, Vec<String>)>,
    /// Whether to drop every factor that turns out to have only one level.
    pub only_varied: bool,
    /// Texts of the ratings, in the order of their first appearance.
    ratings: Vec<String>,
    /// For each participant and condition, as written in the file and each text followed by [`END`], its ratings.
    cells: HashMap<Box<[u8]>, Cell>,
    /// The number of each session, by name.
    sessions: HashMap<Box<str>, u32>,
    key: Vec<u8>,
}

/// The ratings of a participant in a condition.
#[derive(Clone, Debug, Default)]
struct Cell {
    /// Number of ratings, by index into [`MeasuredBuilder::ratings`].
    counts: Vec<u64>,
    /// Trials that are known one by one, with the index of their rating, and without participant and condition.
    trials: Vec<Trial>,
}

/// The byte that ends each text within a key. It cannot occur in UTF-8, and therefore not in any text of a CSV file.
const END: u8 = 0xff;

impl MeasuredBuilder {
    /// Creates a builder for trials with these factors. The categories are the ratings that occur, in natural order.
    pub fn new<S: AsRef<str>>(factors: &[S]) -> Self {
        Self { factors: factors.iter().map(|name| name.as_ref().to_owned()).collect(), ..Self::default() }
    }

    /// Declares the ordered categories, starting with the lowest. Any other rating is then an error.
    #[must_use]
    pub fn with_categories<S: AsRef<str>>(mut self, categories: &[S]) -> Self {
        let declared: Vec<String> = categories.iter().map(|name| name.as_ref().to_owned()).collect();
        self.ratings.clone_from(&declared);
        self.declared = Some(declared);
        self
    }

    /// Adds a row with a value for each factor: one rating, or several equal ratings. A count of 0 adds nothing.
    ///
    /// # Errors
    /// Says that the participant or the rating is empty, that the rating is not a declared category, or that there are too
    /// many different ratings, and what is expected.
    pub fn add(&mut self, observation: &RatingRow<'_>) -> Result<(), String> {
        let RatingRow { subject, values, rating, count, session, repetition, position, response_time_s } = *observation;
        debug_assert_eq!(values.len(), self.factors.len(), "a value for each factor");
        if subject.is_empty() {
            return Err("no participant; expected a name".to_owned());
        }
        let rating = self.rating_index(rating)?;
        if count == 0 {
            return Ok(());
        }
        self.key.clear();
        for text in std::iter::once(&subject).chain(values) {
            self.key.extend_from_slice(text.as_bytes());
            self.key.push(END);
        }
        let is_placed = position.is_some() || repetition.is_some();
        let is_one = count == 1 && (response_time_s.is_some() || is_placed);
        let trial = Trial {
            rating,
            seconds: response_time_s,
            session: if is_placed { self.session(session) } else { 0 },
            position,
            repetition,
            ..Trial::default()
        };
        let cell = self.cells.entry(self.key.as_slice().into()).or_default();
        let rating = usize::from(rating);
        cell.counts.resize(cell.counts.len().max(rating + 1), 0);
        cell.counts[rating] += count;
        cell.trials.extend(is_one.then_some(trial));
        Ok(())
    }

    /// Adds `count` equal ratings without times. An empty text in `values` is a missing value.
    ///
    /// # Errors
    /// Returns the same errors as [`Self::add`].
    pub fn add_counts<S: AsRef<str>>(
        &mut self,
        subject: &str,
        values: &[S],
        rating: &str,
        count: u64,
    ) -> Result<(), String> {
        let values: Vec<&str> = values.iter().map(AsRef::as_ref).collect();
        self.add(&RatingRow { subject, values: &values, rating, count, ..RatingRow::default() })
    }

    /// Returns the number of a session.
    fn session(&mut self, name: &str) -> u32 {
        let number = self.sessions.len() as u32;
        self.sessions.get(name).copied().unwrap_or_else(|| *self.sessions.entry(name.into()).or_insert(number))
    }

    fn rating_index(&mut self, text: &str) -> Result<u8, String> {
        if let Some(index) = self.ratings.iter().position(|known| known == text) {
            return Ok(index as u8);
        }
        let trimmed = text.trim();
        if trimmed.is_empty() {
            return Err("no rating; expected one of the ordered categories".to_owned());
        }
        // Both "2.0" and " 2" mean the category "2".
        let number = levels::number_of(trimmed);
        let same = |known: &String| known == trimmed || (number.is_some() && levels::number_of(known) == number);
        if let Some(index) = self.ratings.iter().position(same) {
            return Ok(index as u8);
        }
        if let Some(categories) = &self.declared {
            return Err(format!("rating {trimmed}; expected one of {}", categories.join(", ")));
        }
        if self.ratings.len() >= 255 {
            return Err("more than 255 different ratings; expected a scale of ordered categories".to_owned());
        }
        self.ratings.push(trimmed.to_owned());
        Ok(self.ratings.len() as u8 - 1)
    }

    /// Returns everything that was collected, in natural order.
    pub fn finish(mut self) -> Measured {
        let cells: Vec<(Box<[u8]>, Cell)> = std::mem::take(&mut self.cells).into_iter().collect();
        let (subjects, values): (Vec<&str>, Vec<Vec<&str>>) = cells.iter().map(|(key, _)| parts(key)).unzip();
        let (subjects, subject_of) = levels::rank(&[], &subjects.into_iter().map(Some).collect::<Vec<_>>());
        let mut conditions: Vec<Vec<Option<u32>>> = vec![Vec::new(); cells.len()];
        let mut factors = Vec::new();
        for (index, name) in self.factors.iter().enumerate() {
            // An empty text is a missing value.
            let texts: Vec<Option<&str>> =
                values.iter().map(|values| Some(values[index]).filter(|text| !text.is_empty())).collect();
            let declared = self.levels.iter().find(|(factor, _)| factor == name).map_or(&[][..], |(_, levels)| levels);
            let (levels, level_of) = levels::rank(declared, &texts);
            if self.only_varied && level_of.windows(2).all(|pair| pair[0] == pair[1]) {
                continue;
            }
            conditions.iter_mut().zip(level_of).for_each(|(condition, level)| condition.push(level));
            factors.push(Factor::new(name, levels, self.directions.contains(name)));
        }
        drop(values);
        let condition_of = conditions;
        let mut conditions: BTreeSet<&Vec<Option<u32>>> = BTreeSet::new();
        conditions.extend(&condition_of);
        let conditions: Vec<Vec<Option<u32>>> = conditions.into_iter().cloned().collect();
        let ratings: Vec<Option<&str>> = self.ratings.iter().map(|text| Some(text.as_str())).collect();
        let (categories, category_of) = match &self.declared {
            Some(declared) => (declared.clone(), (0..declared.len() as u32).map(Some).collect()),
            None => {
                // Which form of a number came first must not matter.
                let (names, category_of) = levels::rank(&[], &ratings);
                let plain = levels::numbers_of(&names);
                (
                    plain.map_or(names, |numbers| numbers.iter().map(|number| (number + 0.0).to_string()).collect()),
                    category_of,
                )
            }
        };
        let category = |rating: usize| category_of[rating].unwrap_or_default() as u8;
        let mut rows = Vec::new();
        let mut sessions: Vec<(&Box<str>, u32)> = self.sessions.iter().map(|(name, number)| (name, *number)).collect();
        sessions.sort_by(|l, r| levels::compare_mixed(l.0, r.0));
        let mut session_of = vec![0; sessions.len().max(1)];
        (0..).zip(sessions).for_each(|(place, (_, number))| session_of[number as usize] = place);
        let mut trials = Vec::new();
        // Each cell is dropped as soon as it is counted.
        for (((_, cell), subject), levels) in cells.into_iter().zip(subject_of).zip(&condition_of) {
            let subject = subject.unwrap_or_default();
            let condition = conditions.partition_point(|known| known < levels) as u32;
            let given = cell.counts.iter().enumerate().filter(|(_, count)| **count > 0);
            rows.extend(given.map(|(rating, &count)| CountRow { subject, condition, rating: category(rating), count }));
            trials.extend(cell.trials.into_iter().map(|trial| {
                let (rating, session) = (category(trial.rating.into()), session_of[trial.session as usize]);
                Trial { subject, condition, rating, session, ..trial }
            }));
        }
        // Not in the order in which they were added.
        trials.sort_unstable_by(|l: &Trial, r| {
            let cell = |trial: &Trial| (trial.subject, trial.condition, trial.rating);
            let rest = |trial: &Trial| (trial.seconds, trial.session, trial.position, trial.repetition);
            // Times and places are never NaN.
            cell(l).cmp(&cell(r)).then(rest(l).partial_cmp(&rest(r)).unwrap_or(Ordering::Equal))
        });
        Measured {
            trials,
            excluded: Vec::new(),
            counts: Counts { subjects, factors, conditions, categories, rows: summed(rows) },
        }
    }
}

/// Returns the participant and the values of the factors in a key.
fn parts(key: &[u8]) -> (&str, Vec<&str>) {
    let mut texts = key.split(|&byte| byte == END).map(|text| std::str::from_utf8(text).unwrap_or_default());
    // The text after the last END is empty and is not used.
    let subject = texts.next().unwrap_or_default();
    (subject, texts.map(str::trim).collect())
}
