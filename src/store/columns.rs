//! A table in memory, such as a data frame, and columns in which equal texts are stored once.

use std::collections::HashMap;

use super::FileErrors;

/// The columns of a table in memory, with their names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns(Vec<(String, Texts)>);

impl Columns {
    /// Adds a column of whole numbers.
    #[must_use]
    pub fn with_whole(self, name: &str, numbers: &[i64]) -> Self {
        self.with(name, Texts::of(numbers.iter().map(i64::to_string)))
    }

    /// Adds a column of text of which each different text is given once, with its index in each row; an index without a
    /// text is a missing value.
    #[must_use]
    pub fn with_levels<S: AsRef<str>>(self, name: &str, levels: &[S], cells: &[i64]) -> Self {
        let mut texts = Interner::default();
        let index: Vec<u32> = levels.iter().map(|level| texts.index(level.as_ref().trim())).collect();
        let missing = texts.index("");
        let of = |cell: &i64| usize::try_from(*cell).ok().and_then(|cell| index.get(cell)).copied().unwrap_or(missing);
        texts.cells = cells.iter().map(of).collect();
        self.with(name, texts.finish())
    }

    /// Adds a column of numbers, each written in the shortest form that reads back as the same number. NaN is a missing
    /// value.
    #[must_use]
    pub fn with_numbers(self, name: &str, numbers: impl IntoIterator<Item = f64>) -> Self {
        // The sum turns −0 into 0.
        let text = |number: f64| if number.is_nan() { String::new() } else { (number + 0.0).to_string() };
        self.with(name, Texts::of(numbers.into_iter().map(text)))
    }

    fn with(mut self, name: &str, column: Texts) -> Self {
        self.0.push((name.to_owned(), column));
        self
    }

    /// Checks that there are columns, and that all of them have the same number of rows.
    pub(super) fn check(&self, name: &str) -> Result<(), FileErrors> {
        let rows = self.rows();
        let other = self.0.iter().find(|(_, column)| column.cells.len() != rows);
        match (other, self.0.first()) {
            (_, None) => Err(FileErrors::whole(name, "has no columns; expected columns with names")),
            (Some((other, column)), Some((first, _))) => {
                let message =
                    format!("the column {other} has {} rows; expected {rows}, as in {first}", column.cells.len());
                Err(FileErrors::whole(name, message))
            }
            (None, Some(_)) => Ok(()),
        }
    }

    /// Returns the names of the columns.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// Returns the number of rows.
    pub(super) fn rows(&self) -> usize {
        self.0.first().map_or(0, |(_, column)| column.cells.len())
    }

    /// Returns a column.
    pub(super) fn texts(&self, column: usize) -> &Texts {
        &self.0[column].1
    }
}

/// A column of texts. Equal texts are stored once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Texts {
    /// The different texts, in the order in which they first occur.
    pub texts: Vec<Box<str>>,
    /// For each row, the index of its text.
    pub cells: Vec<u32>,
}

impl Texts {
    fn of(cells: impl Iterator<Item = String>) -> Self {
        let mut texts = Interner::default();
        cells.for_each(|cell| texts.push(&cell));
        texts.finish()
    }

    /// Returns the text in a row.
    pub fn get(&self, row: usize) -> &str {
        &self.texts[self.cells[row] as usize]
    }

    /// Interprets each of the different texts once.
    pub fn map<'a, T>(&'a self, of: impl FnMut(&'a str) -> T) -> Mapped<'a, T> {
        Mapped { values: self.texts.iter().map(AsRef::as_ref).map(of).collect(), cells: &self.cells }
    }
}

/// What the cells of a column mean.
pub(super) struct Mapped<'a, T> {
    values: Vec<T>,
    cells: &'a [u32],
}

impl<T> Mapped<'_, T> {
    /// Returns the value in a row.
    pub fn get(&self, row: usize) -> &T {
        &self.values[self.cells[row] as usize]
    }

    /// Returns the values of all rows.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.cells.iter().map(|cell| &self.values[*cell as usize])
    }
}

/// Collects the texts of a column.
#[derive(Debug, Default)]
pub(super) struct Interner {
    index: HashMap<Box<str>, u32>,
    cells: Vec<u32>,
}

impl Interner {
    /// Adds the text of the next row.
    pub fn push(&mut self, text: &str) {
        let cell = self.index(text);
        self.cells.push(cell);
    }

    /// Returns the index of a text.
    fn index(&mut self, text: &str) -> u32 {
        self.index.get(text).copied().unwrap_or_else(|| {
            let new = self.index.len() as u32;
            self.index.insert(text.into(), new);
            new
        })
    }

    /// Returns the column.
    pub fn finish(self) -> Texts {
        let mut texts = vec![Box::default(); self.index.len()];
        self.index.into_iter().for_each(|(text, index)| texts[index as usize] = text);
        Texts { texts, cells: self.cells }
    }
}
