//! From trials, or counts of them, to what is kept. Memory grows with the distinct combinations of subject and
//! condition, not with the rows.

use std::{
    cmp::Ordering,
    collections::{BTreeMap, HashMap},
};

use super::{
    measured::{Measured, RetestPair, TimeCount},
    table::{CountError, CountRow, Counts, Factor},
};
use crate::{
    analysis::{levels, times},
    experiment::RatingRow,
};

/// As [`MeasuredBuilder`], for counts alone.
#[derive(Clone, Debug)]
pub struct CountsBuilder(MeasuredBuilder);

impl CountsBuilder {
    /// As [`MeasuredBuilder::new`].
    pub fn new<S: AsRef<str>>(factors: &[S]) -> Self {
        Self(MeasuredBuilder::new(factors))
    }

    /// As [`MeasuredBuilder::with_categories`].
    #[must_use]
    pub fn with_categories<S: AsRef<str>>(self, categories: &[S]) -> Self {
        Self(self.0.with_categories(categories))
    }

    /// Adds `count` equal ratings; an empty text among `values` is a missing value.
    ///
    /// # Errors
    /// As [`MeasuredBuilder::add`].
    pub fn add<S: AsRef<str>>(
        &mut self,
        subject: &str,
        values: &[S],
        rating: &str,
        count: u64,
    ) -> Result<(), CountError> {
        let values: Vec<&str> = values.iter().map(AsRef::as_ref).collect();
        self.0.add(&RatingRow { subject, values: &values, rating, count, place: None, response_time_s: None })
    }

    /// The table, sorted.
    pub fn finish(self) -> Counts {
        self.0.finish().counts
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
    index: HashMap<Box<[u8]>, u32>,
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
            index: HashMap::new(),
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
    pub fn add(&mut self, observation: &RatingRow<'_>) -> Result<(), CountError> {
        let RatingRow { subject, values, rating, count, place, response_time_s } = *observation;
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
        let Self { index, cells, key, .. } = self;
        let number = index.get(&key[..]).copied().unwrap_or_else(|| {
            let number = cells.len() as u32;
            let key: Box<[u8]> = key.as_slice().into();
            index.insert(key.clone(), number);
            cells.push(Cell { key, counts: Vec::new(), times: Vec::new(), earliest: Earliest::default() });
            number
        });
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
        let (subjects, values): (Vec<&str>, Vec<Vec<&str>>) = self.cells.iter().map(|cell| cell.parts(&varied)).unzip();
        let (subjects, subject_of) = levels::rank(&subjects.into_iter().map(Some).collect::<Vec<_>>());
        let names = self.factors.iter().zip(&varied).filter(|(_, varied)| **varied).map(|(name, _)| name);
        let mut conditions: Vec<Vec<Option<u32>>> = vec![Vec::new(); self.cells.len()];
        let mut factors = Vec::new();
        for (index, name) in names.enumerate() {
            // An empty text is a missing value.
            let texts: Vec<Option<&str>> =
                values.iter().map(|values| Some(values[index]).filter(|text| !text.is_empty())).collect();
            let (levels, level_of) = levels::rank(&texts);
            conditions.iter_mut().zip(level_of).for_each(|(condition, level)| condition.push(level));
            factors.push(Factor { name: name.clone(), numbers: levels::numbers_of(&levels), levels });
        }
        let condition_of = conditions.clone();
        conditions.sort_unstable();
        conditions.dedup();
        let ratings: Vec<Option<&str>> = self.ratings.iter().map(|text| Some(text.as_str())).collect();
        let (categories, category_of) = match &self.declared {
            Some(declared) => (declared.clone(), (0..declared.len() as u32).map(Some).collect()),
            None => levels::rank(&ratings),
        };
        let category = |rating: usize| category_of[rating].unwrap_or_default() as u8;
        // Two spellings of a level, 0.4 and 0.40, are two cells here and one condition.
        let mut counts: BTreeMap<(u32, u32, u8), u64> = BTreeMap::new();
        let mut times: BTreeMap<(u32, u32, u8, u16), u64> = BTreeMap::new();
        let mut earliest: BTreeMap<(u32, u32), Earliest> = BTreeMap::new();
        for ((cell, subject), levels) in self.cells.iter().zip(subject_of).zip(&condition_of) {
            let subject = subject.unwrap_or_default();
            let condition = conditions.partition_point(|known| known < levels) as u32;
            for (rating, &count) in cell.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
                *counts.entry((subject, condition, category(rating))).or_insert(0) += count;
            }
            for &(bin, rating, count) in &cell.times {
                *times.entry((subject, condition, category(rating.into()), bin)).or_insert(0) += count;
            }
            let known = earliest.entry((subject, condition)).or_default();
            for placed in cell.earliest.0.iter().flatten() {
                known.place(&placed.session, placed.repetition, placed.rating);
            }
        }
        let rows = (counts.into_iter()).map(|((subject, condition, rating), count)| CountRow {
            subject,
            condition,
            rating,
            count,
        });
        let times = (times.into_iter()).map(|((subject, condition, rating, bin), count)| TimeCount {
            subject,
            condition,
            rating,
            bin,
            count,
        });
        let retests = earliest.into_iter().filter_map(|((subject, condition), earliest)| {
            let [Some(first), Some(second)] = earliest.0 else { return None };
            let (first, second) = (category(first.rating.into()), category(second.rating.into()));
            Some(RetestPair { subject, condition, first, second })
        });
        Measured {
            retests: retests.collect(),
            times: times.collect(),
            counts: Counts { subjects, factors, conditions, categories, rows: rows.collect() },
        }
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

    #[test]
    fn rows_are_sorted_merged_and_independent_of_their_order() {
        let rows = [("s10", "0.4", "1", 2), ("s9", "0.1", "0", 1), ("s10", "0.40", "1", 3), ("s9", "", "3", 1)];
        let build = |order: &[usize]| {
            let mut builder = CountsBuilder::new(&["width"]);
            for &index in order {
                let (subject, width, rating, count) = rows[index];
                builder.add(subject, &[width], rating, count).unwrap();
            }
            builder.finish()
        };
        let counts = build(&[0, 1, 2, 3]);
        assert_eq!(counts, build(&[3, 2, 1, 0]));
        assert_eq!(counts.factors[0].levels, ["0.1", "0.4"]);
        assert_eq!(counts.categories, ["0", "1", "3"]);
        assert_eq!(counts.conditions, [vec![None], vec![Some(0)], vec![Some(1)]]);
        assert_eq!(counts.rows.len(), 3);
        assert_eq!(counts.rows.iter().map(|row| row.count).max(), Some(5));
        assert_eq!(counts.total(), 7);
    }

    #[test]
    fn declared_categories_refuse_others_and_keep_empty_ones() {
        let mut builder = CountsBuilder::new(&["width"]).with_categories(&["0", "1", "2", "3"]);
        builder.add("s1", &["0.1"], "2.0", 1).unwrap();
        let error = builder.add("s1", &["0.1"], "4", 1).unwrap_err();
        assert_eq!(error.to_string(), "rating 4; expected one of 0, 1, 2, 3");
        assert_eq!(builder.add("s1", &["0.1"], "", 1), Err(CountError::NoRating));
        assert_eq!(builder.add("", &["0.1"], "1", 1), Err(CountError::NoSubject));
        assert_eq!(builder.finish().category_totals(), [0, 0, 1, 0]);
    }

    fn row<'a>(subject: &'a str, values: &'a [&'a str], rating: &'a str, repetition: u32) -> RatingRow<'a> {
        let response_time_s = Some(0.5 * f64::from(repetition));
        RatingRow { subject, values, rating, count: 1, place: Some(("1", repetition)), response_time_s }
    }

    fn rows() -> Vec<RatingRow<'static>> {
        vec![
            row("S2", &["0.4", "1"], "3", 2),
            row("S2", &["0.40", "1"], "1", 1),
            row("S1", &["0.1", "1"], "0", 1),
            row("S10", &["0.1", "1"], "2.0", 1),
            row("S2", &["0.4", "1"], "2", 3),
            row("S1", &["0.1", "1"], "1", 2),
        ]
    }

    fn build(rows: &[RatingRow<'_>]) -> MeasuredBuilder {
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
