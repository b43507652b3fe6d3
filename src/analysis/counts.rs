//! The sufficient statistic of every model here: how often each subject gave each rating in each condition. Fitting on
//! these counts costs the same for a thousand rows as for a billion.

use std::collections::HashMap;

use thiserror::Error;

use super::levels;

/// A factor of the design and its levels, in natural order.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// The column's name.
    pub name: String,
    /// Level names in natural order: numbers ascending with `inf` last, otherwise texts by their bytes.
    pub levels: Vec<String>,
    /// The levels as numbers where all of them are numbers; infinite for `inf`.
    pub numbers: Option<Vec<f64>>,
}

/// One row of the table: `count` equal ratings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CountRow {
    /// Index into [`Counts::subjects`].
    pub subject: u32,
    /// Index into [`Counts::conditions`].
    pub condition: u32,
    /// Index into [`Counts::categories`], 0 the lowest.
    pub rating: u8,
    /// How often, at least 1.
    pub count: u64,
}

/// Subject × condition × rating counts. Rows are sorted and unique, whatever the order they were added in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Subjects' names in natural order.
    pub subjects: Vec<String>,
    /// The factors, in the order they were named.
    pub factors: Vec<Factor>,
    /// The distinct conditions: for every factor the index of its level, or None where the value is missing.
    pub conditions: Vec<Vec<Option<u32>>>,
    /// Names of the ordered categories, the lowest first. A category may have no ratings.
    pub categories: Vec<String>,
    /// The table, by subject, condition and rating.
    pub rows: Vec<CountRow>,
}

/// What a row must have to be counted.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum CountError {
    /// The row names another number of factor values than there are factors.
    #[error("{found} factor values; expected {expected}")]
    Width {
        /// Factors of the table.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// The subject's name is empty.
    #[error("no subject; expected a name")]
    NoSubject,
    /// The rating is empty.
    #[error("no rating; expected one of the ordered categories")]
    NoRating,
    /// The rating is not one of the categories that were declared.
    #[error("rating {rating}; expected one of {}", .categories.join(", "))]
    UnknownRating {
        /// The rating as it was given.
        rating: String,
        /// The declared categories.
        categories: Vec<String>,
    },
    /// More ordered categories than a rating scale has.
    #[error("more than 255 different ratings; expected a scale of ordered categories")]
    TooManyCategories,
}

/// Collects ratings one by one, or counts of them, into [`Counts`]. Memory grows with the distinct combinations only.
#[derive(Clone, Debug, Default)]
pub struct CountsBuilder {
    factors: Vec<String>,
    declared: Option<Vec<String>>,
    subjects: Interner,
    values: Vec<Interner>,
    ratings: Interner,
    conditions: HashMap<Vec<u32>, u32>,
    table: HashMap<(u32, u32, u32), u64>,
}

/// Texts by index in order of first appearance.
#[derive(Clone, Debug, Default)]
struct Interner {
    texts: Vec<String>,
    index: HashMap<String, u32>,
}

impl Interner {
    fn intern(&mut self, text: &str) -> u32 {
        if let Some(&index) = self.index.get(text) {
            return index;
        }
        let index = self.texts.len() as u32;
        self.texts.push(text.to_owned());
        self.index.insert(text.to_owned(), index);
        index
    }

    /// The texts, an empty one as a missing value.
    fn optional(&self) -> Vec<Option<&str>> {
        self.texts.iter().map(|text| (!text.is_empty()).then_some(text.as_str())).collect()
    }
}

impl CountsBuilder {
    /// A table with these factors, whose categories are the ratings that occur, in natural order.
    pub fn new<S: AsRef<str>>(factors: &[S]) -> Self {
        let factors: Vec<String> = factors.iter().map(|name| name.as_ref().to_owned()).collect();
        let values = vec![Interner::default(); factors.len()];
        Self { factors, values, ..Self::default() }
    }

    /// Declares the ordered categories, the lowest first: a rating outside them is an error, and one that never occurs
    /// is still a category of the table.
    #[must_use]
    pub fn with_categories<S: AsRef<str>>(mut self, categories: &[S]) -> Self {
        let declared: Vec<String> = categories.iter().map(|name| name.as_ref().to_owned()).collect();
        self.ratings = Interner::default();
        for name in &declared {
            self.ratings.intern(name);
        }
        self.declared = Some(declared);
        self
    }

    /// Adds `count` equal ratings; an empty text among `values` is a missing value. Nothing is added for a count of 0.
    ///
    /// # Errors
    /// A wrong number of values, an empty subject or rating, a rating that was not declared.
    pub fn add<S: AsRef<str>>(
        &mut self,
        subject: &str,
        values: &[S],
        rating: &str,
        count: u64,
    ) -> Result<(), CountError> {
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
        let subject = self.subjects.intern(subject);
        let key: Vec<u32> = self
            .values
            .iter_mut()
            .zip(values)
            .map(|(interner, value)| interner.intern(value.as_ref().trim()))
            .collect();
        let fresh = self.conditions.len() as u32;
        let condition = *self.conditions.entry(key).or_insert(fresh);
        *self.table.entry((subject, condition, rating)).or_insert(0) += count;
        Ok(())
    }

    fn rating_index(&mut self, rating: &str) -> Result<u32, CountError> {
        let rating = rating.trim();
        if rating.is_empty() {
            return Err(CountError::NoRating);
        }
        if let Some(categories) = &self.declared
            && !self.ratings.index.contains_key(rating)
        {
            // "2.0" is the category "2".
            let number = levels::number_of(rating);
            let same = categories.iter().position(|name| number.is_some() && levels::number_of(name) == number);
            return same.map(|index| index as u32).ok_or_else(|| CountError::UnknownRating {
                rating: rating.to_owned(),
                categories: categories.clone(),
            });
        }
        let index = self.ratings.intern(rating);
        if index >= 255 { Err(CountError::TooManyCategories) } else { Ok(index) }
    }

    /// The table, sorted.
    pub fn finish(self) -> Counts {
        let (subjects, subject_of) = levels::rank(&self.subjects.optional());
        let (categories, category_of) = match self.declared {
            Some(declared) => {
                let identity = (0..declared.len() as u32).map(Some).collect();
                (declared, identity)
            }
            None => levels::rank(&self.ratings.optional()),
        };
        let ranked: Vec<_> = self.values.iter().map(|interner| levels::rank(&interner.optional())).collect();
        let (conditions, condition_of) = rank_conditions(&self.conditions, &ranked);
        let factors = (self.factors.into_iter().zip(ranked))
            .map(|(name, (levels, _))| Factor { numbers: levels::numbers_of(&levels), name, levels })
            .collect();
        let mut merged: HashMap<(u32, u32, u8), u64> = HashMap::new();
        for ((subject, condition, rating), count) in self.table {
            let (Some(subject), Some(rating)) = (subject_of[subject as usize], category_of[rating as usize]) else {
                continue;
            };
            *merged.entry((subject, condition_of[condition as usize], rating as u8)).or_insert(0) += count;
        }
        let mut rows: Vec<CountRow> = (merged.into_iter())
            .map(|((subject, condition, rating), count)| CountRow { subject, condition, rating, count })
            .collect();
        rows.sort_unstable();
        Counts { subjects, factors, conditions, categories, rows }
    }
}

/// Conditions by the natural order of their levels, a missing value first, and the new index of every old one.
#[allow(clippy::type_complexity)]
fn rank_conditions(
    conditions: &HashMap<Vec<u32>, u32>,
    ranked: &[(Vec<String>, Vec<Option<u32>>)],
) -> (Vec<Vec<Option<u32>>>, Vec<u32>) {
    let mut old: Vec<(Vec<Option<u32>>, u32)> = (conditions.iter())
        .map(|(key, &index)| {
            (key.iter().zip(ranked).map(|(&value, (_, indices))| indices[value as usize]).collect(), index)
        })
        .collect();
    old.sort_unstable();
    let mut distinct: Vec<Vec<Option<u32>>> = Vec::new();
    let mut new_index = vec![0; old.len()];
    for (levels, index) in old {
        if distinct.last() != Some(&levels) {
            distinct.push(levels);
        }
        new_index[index as usize] = distinct.len() as u32 - 1;
    }
    (distinct, new_index)
}

impl Counts {
    /// Ratings in the table.
    pub fn total(&self) -> u64 {
        self.rows.iter().map(|row| row.count).sum()
    }

    /// The factor of this name, and its index.
    pub fn factor(&self, name: &str) -> Option<(usize, &Factor)> {
        self.factors.iter().enumerate().find(|(_, factor)| factor.name == name)
    }

    /// Names of a condition's levels, in the order of the factors; empty where a value is missing.
    pub fn level_names(&self, condition: u32) -> Vec<&str> {
        (self.conditions[condition as usize].iter().zip(&self.factors))
            .map(|(level, factor)| level.map_or("", |level| factor.levels[level as usize].as_str()))
            .collect()
    }

    /// For finding subjects, conditions and categories by their names.
    pub(super) fn index(&self) -> Index<'_> {
        let index = |names: &'_ [String]| names.iter().cloned().zip(0_u32..).collect::<HashMap<_, _>>();
        Index {
            counts: self,
            subjects: index(&self.subjects),
            levels: self.factors.iter().map(|factor| index(&factor.levels)).collect(),
            conditions: self.conditions.iter().map(Vec::as_slice).zip(0..).collect(),
        }
    }

    /// Ratings in each category.
    pub fn category_totals(&self) -> Vec<u64> {
        let mut totals = vec![0; self.categories.len()];
        for row in &self.rows {
            totals[row.rating as usize] += row.count;
        }
        totals
    }
}

/// Finds what a table has by the names that were added.
pub(super) struct Index<'a> {
    counts: &'a Counts,
    subjects: HashMap<String, u32>,
    levels: Vec<HashMap<String, u32>>,
    conditions: HashMap<&'a [Option<u32>], u32>,
}

impl Index<'_> {
    /// Index of a subject.
    pub fn subject(&self, name: &str) -> Option<u32> {
        let number = || find_number(&self.counts.subjects, name);
        self.subjects.get(name).copied().or_else(number)
    }

    /// Index of the condition with these levels.
    pub fn condition(&self, values: &[&str]) -> Option<u32> {
        let level = |factor: usize, text: &str| {
            let levels = &self.counts.factors[factor].levels;
            self.levels[factor].get(text).copied().or_else(|| find_number(levels, text))
        };
        let key: Option<Vec<Option<u32>>> = (values.iter().enumerate())
            .map(|(factor, text)| if text.is_empty() { Some(None) } else { level(factor, text).map(Some) })
            .collect();
        self.conditions.get(key?.as_slice()).copied()
    }

    /// Index of a category.
    pub fn category(&self, name: &str) -> Option<u8> {
        let categories = &self.counts.categories;
        let exact = categories.iter().position(|known| known == name).map(|index| index as u32);
        exact.or_else(|| find_number(categories, name)).map(|index| index as u8)
    }
}

/// Index of the name that means the same number.
fn find_number(names: &[String], text: &str) -> Option<u32> {
    let number = levels::number_of(text)?;
    names.iter().position(|name| levels::number_of(name) == Some(number)).map(|index| index as u32)
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
}
