//! The table of counts.

use thiserror::Error;

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

    /// Ratings in each category.
    pub fn category_totals(&self) -> Vec<u64> {
        let mut totals = vec![0; self.categories.len()];
        for row in &self.rows {
            totals[row.rating as usize] += row.count;
        }
        totals
    }
}
