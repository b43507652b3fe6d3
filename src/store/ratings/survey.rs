//! What the columns contain, which is known only when all rows have been read once. It determines which words stand for
//! missing values, and which columns of an unknown table are factors.

use std::collections::HashSet;

/// Maximum number of different numbers in a column that is a factor no matter how often each of them occurs.
const MAX_UNIQUE: usize = 20;

/// True if a cell has no value. Words that are only sometimes written for a missing value may name a level, so they are
/// missing only if all other values of the column are numbers (`among_numbers`).
pub(super) fn is_missing(text: &str, among_numbers: bool) -> bool {
    matches!(text, "" | "NA" | "NaN" | "nan" | "NULL" | "#N/A" | "n/a")
        || (among_numbers && matches!(text, "." | "None" | "null"))
}

/// The values of a column, in all files together.
#[derive(Clone, Debug, Default)]
pub(super) struct Contents {
    has_texts: bool,
    /// How many values are numbers.
    values: u64,
    /// The different numbers as bits, if they are kept.
    numbers: HashSet<u64>,
}

impl Contents {
    /// Adds a cell; `keep` says whether different numbers are kept, which takes memory.
    pub fn add(&mut self, text: &str, keep: bool) {
        if is_missing(text, true) {
            return;
        }
        let Some(number) = text.parse::<f64>().ok().filter(|number| !number.is_nan()) else {
            self.has_texts = true;
            return;
        };
        self.values += 1;
        if keep {
            self.numbers.insert(number.to_bits());
        }
    }

    /// Adds the cells of other files.
    pub fn absorb(&mut self, other: Self) {
        self.has_texts |= other.has_texts;
        self.values += other.values;
        self.numbers.extend(other.numbers);
    }

    /// True if all values are numbers.
    pub fn are_numbers(&self) -> bool {
        !self.has_texts && self.values > 0
    }

    /// Returns how many different numbers the column has, and in how many rows, if it is a measurement, such as an age or
    /// a time, and not a factor: more than 20, which occur less than twice on average.
    pub fn measurement(&self) -> Option<(usize, u64)> {
        let different = self.numbers.len();
        let is_unique = different > MAX_UNIQUE && self.values < 2 * different as u64;
        (self.are_numbers() && is_unique).then_some((different, self.values))
    }
}

/// What the columns that are read contain.
#[derive(Clone, Debug, Default)]
pub(super) struct Survey {
    /// For each factor, in the order of the shape.
    pub factors: Vec<Contents>,
    pub response: Contents,
}

impl Survey {
    pub fn new(factors: usize) -> Self {
        Self { factors: vec![Contents::default(); factors], response: Contents::default() }
    }

    /// Adds the rows of other files.
    pub fn absorb(&mut self, other: Self) {
        self.factors.iter_mut().zip(other.factors).for_each(|(all, one)| all.absorb(one));
        self.response.absorb(other.response);
    }
}
