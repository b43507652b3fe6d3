//! What is kept of any number of trials: counts of ratings, repeated ratings, response times. Memory grows with the
//! distinct combinations of subject and condition, not with the rows.

use std::{cmp::Ordering, collections::HashMap, hash::BuildHasher as _};

use hashbrown::{DefaultHashBuilder, HashTable, hash_table::Entry};

use super::{
    agreement::Retest,
    counts::{CountError, Counts, CountsBuilder},
    levels,
    times::{self, Times},
};

/// One trial, or `count` trials alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation<'a> {
    /// Who.
    pub subject: &'a str,
    /// The level of each factor; empty where it is missing.
    pub values: &'a [&'a str],
    /// The rating as it is written.
    pub rating: &'a str,
    /// How often.
    pub count: u64,
    /// Session and repetition, in whose natural order a condition's first rating is told from its second. None where
    /// they are not known: such ratings are in no pair.
    pub place: Option<(&'a str, u32)>,
    /// From onset to rating, seconds, where it is known.
    pub response_time_s: Option<f64>,
}

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
    bin: u16,
    count: u64,
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
        let names: Vec<&str> = counts.factors.iter().map(|factor| factor.name.as_str()).collect();
        let mut builder = CountsBuilder::new(&names).with_categories(&counts.categories);
        for row in counts.rows.iter().filter(|row| keep(row.subject, row.condition)) {
            let values = counts.level_names(row.condition);
            let (who, rating) = (&counts.subjects[row.subject as usize], &counts.categories[row.rating as usize]);
            // What was counted once is counted again.
            let _ = builder.add(who, &values, rating, row.count);
        }
        let rest = builder.finish();
        let index = rest.index();
        let subjects: Vec<_> = counts.subjects.iter().map(|name| index.subject(name)).collect();
        let conditions: Vec<_> =
            (0..counts.conditions.len() as u32).map(|c| index.condition(&counts.level_names(c))).collect();
        let moved = |s: u32, c: u32| {
            if keep(s, c) { subjects[s as usize].zip(conditions[c as usize]) } else { None }
        };
        let retests = (self.retests.iter())
            .filter_map(|pair| {
                moved(pair.subject, pair.condition).map(|(subject, condition)| RetestPair {
                    subject,
                    condition,
                    ..*pair
                })
            })
            .collect();
        let times = (self.times.iter())
            .filter_map(|row| {
                moved(row.subject, row.condition).map(|(subject, condition)| TimeCount { subject, condition, ..*row })
            })
            .collect();
        drop(index);
        Self { counts: rest, retests, times }
    }
}

/// Collects trials into [`Measured`], in any order and in as many parts as there are threads.
#[derive(Clone, Debug)]
pub struct MeasuredBuilder {
    factors: Vec<String>,
    declared: Option<Vec<String>>,
    /// Drops the factors that have one level only.
    only_varied: bool,
    /// Texts of ratings in order of first appearance.
    ratings: Vec<String>,
    hasher: DefaultHashBuilder,
    index: HashTable<u32>,
    cells: Vec<Cell>,
    key: Vec<u8>,
}

/// A subject and a condition, as they are written.
#[derive(Clone, Debug)]
struct Cell {
    /// Subject and values, each followed by [`END`].
    key: Box<[u8]>,
    /// By index into the builder's ratings.
    counts: Vec<u64>,
    /// (bin, rating) and how often.
    times: Vec<(u16, u8, u64)>,
    earliest: Earliest,
}

/// The two earliest ratings.
#[derive(Clone, Debug, Default)]
struct Earliest([Option<Placed>; 2]);

/// A rating and its place in time.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Placed {
    session: Box<str>,
    repetition: u32,
    rating: u8,
}

/// Ends a text within a key: no text of a CSV file in UTF-8 has this byte.
const END: u8 = 0xff;

impl MeasuredBuilder {
    /// Trials with these factors, whose categories are the ratings that occur, in natural order.
    pub fn new<S: AsRef<str>>(factors: &[S]) -> Self {
        Self {
            factors: factors.iter().map(|name| name.as_ref().to_owned()).collect(),
            declared: None,
            only_varied: false,
            ratings: Vec::new(),
            hasher: DefaultHashBuilder::default(),
            index: HashTable::new(),
            cells: Vec::new(),
            key: Vec::new(),
        }
    }

    /// Declares the ordered categories, the lowest first: a rating outside them is an error.
    #[must_use]
    pub fn with_categories<S: AsRef<str>>(mut self, categories: &[S]) -> Self {
        let declared: Vec<String> = categories.iter().map(|name| name.as_ref().to_owned()).collect();
        self.ratings.clone_from(&declared);
        self.declared = Some(declared);
        self
    }

    /// Leaves out, at the end, every factor that has one level only.
    #[must_use]
    pub fn only_varied_factors(mut self) -> Self {
        self.only_varied = true;
        self
    }

    /// Adds a trial, or some alike; nothing for a count of 0.
    ///
    /// # Errors
    /// A wrong number of values, an empty subject or rating, a rating that was not declared.
    pub fn add(&mut self, observation: &Observation<'_>) -> Result<(), CountError> {
        let Observation { subject, values, rating, count, place, response_time_s } = *observation;
        if values.len() != self.factors.len() {
            return Err(CountError::Width { expected: self.factors.len(), found: values.len() });
        }
        if subject.is_empty() {
            return Err(CountError::NoSubject);
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
        let cell = self.cell();
        cell.count(rating, count);
        if let Some(seconds) = response_time_s {
            cell.time(times::bin(seconds), rating, count);
        }
        if let Some((session, repetition)) = place {
            cell.earliest.place(session, repetition, rating);
        }
        Ok(())
    }

    /// The cell of `self.key`, a new one if need be.
    fn cell(&mut self) -> &mut Cell {
        let Self { hasher, index, cells, key, .. } = self;
        let entry = index.entry(
            hasher.hash_one(&key[..]),
            |&cell| *cells[cell as usize].key == key[..],
            |&cell| hasher.hash_one(&cells[cell as usize].key[..]),
        );
        let number = match entry {
            Entry::Occupied(entry) => *entry.get(),
            Entry::Vacant(entry) => {
                let number = cells.len() as u32;
                entry.insert(number);
                cells.push(Cell {
                    key: key.clone().into_boxed_slice(),
                    counts: Vec::new(),
                    times: Vec::new(),
                    earliest: Earliest::default(),
                });
                number
            }
        };
        &mut cells[number as usize]
    }

    fn rating_index(&mut self, text: &str) -> Result<u8, CountError> {
        if let Some(index) = self.ratings.iter().position(|known| known == text) {
            return Ok(index as u8);
        }
        let trimmed = text.trim();
        if trimmed.is_empty() {
            return Err(CountError::NoRating);
        }
        // "2.0" and " 2" are the category "2".
        let number = levels::number_of(trimmed);
        let same = |known: &String| known == trimmed || (number.is_some() && levels::number_of(known) == number);
        if let Some(index) = self.ratings.iter().position(same) {
            return Ok(index as u8);
        }
        if let Some(categories) = &self.declared {
            return Err(CountError::UnknownRating { rating: trimmed.to_owned(), categories: categories.clone() });
        }
        if self.ratings.len() >= 255 {
            return Err(CountError::TooManyCategories);
        }
        self.ratings.push(trimmed.to_owned());
        Ok(self.ratings.len() as u8 - 1)
    }

    /// Distinct combinations of subject and condition so far.
    pub fn cells(&self) -> usize {
        self.cells.len()
    }

    /// Takes over what another part has collected with the same factors and categories.
    ///
    /// # Errors
    /// More different ratings than a scale has.
    pub fn absorb(&mut self, other: Self) -> Result<(), CountError> {
        let ratings: Vec<u8> = other.ratings.iter().map(|text| self.rating_index(text)).collect::<Result<_, _>>()?;
        for from in other.cells {
            self.key.clear();
            self.key.extend_from_slice(&from.key);
            let cell = self.cell();
            for (&rating, count) in ratings.iter().zip(from.counts) {
                cell.count(rating, count);
            }
            for (bin, rating, count) in from.times {
                cell.time(bin, ratings[usize::from(rating)], count);
            }
            for placed in from.earliest.0.into_iter().flatten() {
                cell.earliest.place(&placed.session, placed.repetition, ratings[usize::from(placed.rating)]);
            }
        }
        Ok(())
    }

    /// Everything in natural order.
    pub fn finish(self) -> Measured {
        let varied = self.varied();
        let names: Vec<&str> =
            (self.factors.iter().zip(&varied)).filter(|(_, v)| **v).map(|(n, _)| n.as_str()).collect();
        let mut builder = CountsBuilder::new(&names);
        if let Some(declared) = &self.declared {
            builder = builder.with_categories(declared);
        }
        let parts: Vec<(&str, Vec<&str>)> = self.cells.iter().map(|cell| cell.parts(&varied)).collect();
        for (cell, (subject, values)) in self.cells.iter().zip(&parts) {
            for (text, &count) in self.ratings.iter().zip(&cell.counts) {
                // Every part was looked at when it was added.
                let _ = builder.add(subject, values, text, count);
            }
        }
        let counts = builder.finish();
        let index = counts.index();
        let category = |rating: u8| index.category(&self.ratings[usize::from(rating)]);
        // Two spellings of a level, 0.4 and 0.40, are two cells here and one condition.
        let mut earliest: HashMap<(u32, u32), Earliest> = HashMap::new();
        let mut times: HashMap<(u32, u32, u8, u16), u64> = HashMap::new();
        for (cell, (subject, values)) in self.cells.iter().zip(&parts) {
            let Some((subject, condition)) = index.subject(subject).zip(index.condition(values)) else { continue };
            let known = earliest.entry((subject, condition)).or_default();
            for placed in cell.earliest.0.iter().flatten() {
                known.place(&placed.session, placed.repetition, placed.rating);
            }
            for &(bin, rating, count) in &cell.times {
                if let Some(rating) = category(rating) {
                    *times.entry((subject, condition, rating, bin)).or_insert(0) += count;
                }
            }
        }
        let mut retests: Vec<RetestPair> = (earliest.into_iter())
            .filter_map(|((subject, condition), earliest)| {
                let [Some(first), Some(second)] = earliest.0 else { return None };
                let (first, second) = category(first.rating).zip(category(second.rating))?;
                Some(RetestPair { subject, condition, first, second })
            })
            .collect();
        retests.sort_unstable_by_key(|pair| (pair.subject, pair.condition));
        let mut times: Vec<TimeCount> = (times.into_iter())
            .map(|((subject, condition, rating, bin), count)| TimeCount { subject, condition, rating, bin, count })
            .collect();
        times.sort_unstable_by_key(|row| (row.subject, row.condition, row.rating, row.bin));
        drop(index);
        Measured { counts, retests, times }
    }

    /// For each factor whether it stays.
    fn varied(&self) -> Vec<bool> {
        if !self.only_varied {
            return vec![true; self.factors.len()];
        }
        let all = vec![true; self.factors.len()];
        let mut first: Option<Vec<&str>> = None;
        let mut varied = vec![false; self.factors.len()];
        for cell in &self.cells {
            let (_, values) = cell.parts(&all);
            match &first {
                None => first = Some(values),
                Some(first) => varied.iter_mut().zip(first.iter().zip(&values)).for_each(|(v, (a, b))| *v |= a != b),
            }
        }
        varied
    }
}

impl Cell {
    fn count(&mut self, rating: u8, count: u64) {
        let rating = usize::from(rating);
        if self.counts.len() <= rating {
            self.counts.resize(rating + 1, 0);
        }
        self.counts[rating] += count;
    }

    fn time(&mut self, bin: u16, rating: u8, count: u64) {
        match self.times.iter_mut().find(|(b, r, _)| (*b, *r) == (bin, rating)) {
            Some((.., n)) => *n += count,
            None => self.times.push((bin, rating, count)),
        }
    }

    /// The subject, and the values of the factors that stay.
    fn parts(&self, varied: &[bool]) -> (&str, Vec<&str>) {
        let mut texts = self.key.split(|&byte| byte == END).map(|text| std::str::from_utf8(text).unwrap_or_default());
        let subject = texts.next().unwrap_or_default();
        (subject, texts.zip(varied).filter(|(_, varied)| **varied).map(|(text, _)| text.trim()).collect())
    }
}

impl Earliest {
    /// Keeps the two earliest ratings; of two at the same place the lower, whatever order they come in.
    fn place(&mut self, session: &str, repetition: u32, rating: u8) {
        let before = |placed: &Option<Placed>| match placed {
            None => true,
            Some(placed) => {
                let order = levels::compare_mixed(session, &placed.session)
                    .then(repetition.cmp(&placed.repetition))
                    .then(rating.cmp(&placed.rating));
                order == Ordering::Less
            }
        };
        let new = || Some(Placed { session: session.into(), repetition, rating });
        if before(&self.0[0]) {
            self.0[1] = std::mem::replace(&mut self.0[0], new());
        } else if before(&self.0[1]) {
            self.0[1] = new();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row<'a>(subject: &'a str, values: &'a [&'a str], rating: &'a str, repetition: u32) -> Observation<'a> {
        let response_time_s = Some(0.5 * f64::from(repetition));
        Observation { subject, values, rating, count: 1, place: Some(("1", repetition)), response_time_s }
    }

    fn rows() -> Vec<Observation<'static>> {
        vec![
            row("S2", &["0.4", "1"], "3", 2),
            row("S2", &["0.40", "1"], "1", 1),
            row("S1", &["0.1", "1"], "0", 1),
            row("S10", &["0.1", "1"], "2.0", 1),
            row("S2", &["0.4", "1"], "2", 3),
            row("S1", &["0.1", "1"], "1", 2),
        ]
    }

    fn build(rows: &[Observation<'_>]) -> MeasuredBuilder {
        let mut builder = MeasuredBuilder::new(&["width", "depth"]).with_categories(&["0", "1", "2", "3"]);
        for row in rows {
            builder.add(row).unwrap();
        }
        builder
    }

    #[test]
    fn order_and_parts_do_not_matter() {
        let rows = rows();
        let whole = build(&rows).finish();
        let reversed: Vec<_> = rows.iter().rev().copied().collect();
        assert_eq!(build(&reversed).finish(), whole);
        for cut in 0..=rows.len() {
            let mut first = build(&rows[..cut]);
            first.absorb(build(&rows[cut..])).unwrap();
            assert_eq!(first.finish(), whole, "cut at {cut}");
        }
        assert_eq!(whole.counts.total(), 6);
        assert_eq!(whole.times_by(1, |_| Some(0))[0].n(), 6);
    }

    /// `0.40` is `0.4`, so S2 has one condition; its first two ratings are those of repetitions 1 and 2.
    #[test]
    fn the_two_earliest_ratings_are_a_pair() {
        let measured = build(&rows()).finish();
        let pairs: Vec<_> = measured.retests.iter().map(|p| (p.subject, p.first, p.second)).collect();
        assert_eq!(measured.counts.subjects, ["S1", "S10", "S2"]);
        assert_eq!(pairs, [(0, 0, 1), (2, 1, 3)]);
        assert_eq!(measured.retests()[2].pairs(), 1);
        let slow = measured.times_by(4, |row| Some(row.rating.into()))[3].quartiles().unwrap();
        assert!((slow.median - 1.0).abs() < 0.03, "{slow:?}");
    }

    #[test]
    fn what_does_not_vary_can_be_left_out_and_what_is_filtered_is_gone() {
        let mut builder = MeasuredBuilder::new(&["width", "depth"]).only_varied_factors();
        for row in rows() {
            builder.add(&row).unwrap();
        }
        assert_eq!(builder.finish().counts.factors.iter().map(|f| &f.name).collect::<Vec<_>>(), ["width"]);
        let measured = build(&rows()).finish();
        let rest = measured.filtered(|subject| subject != 0, |levels| levels[0] == Some(0));
        assert_eq!(rest.counts.subjects, ["S10"]);
        assert_eq!((rest.counts.total(), rest.counts.categories.len()), (1, 4));
        assert_eq!((rest.times_by(1, |_| Some(0))[0].n(), rest.retests.len()), (1, 0));
        assert_eq!(measured.filtered(|_| true, |_| true), measured);
    }
}
