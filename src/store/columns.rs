//! A table in memory, such as a data frame.

use std::collections::HashMap;

use super::FileErrors;

/// The columns of a table in memory. Equal cells of a column are stored once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns(Vec<Column>);

#[derive(Clone, Debug, PartialEq)]
struct Column {
    name: String,
    /// The different texts, in the order in which they first occur.
    texts: Vec<String>,
    /// For each row, the index of its text.
    cells: Vec<u32>,
}

impl Columns {
    /// Adds a column of text. An empty text is a missing value.
    #[must_use]
    pub fn with_texts<S: AsRef<str>>(mut self, name: &str, cells: impl IntoIterator<Item = S>) -> Self {
        let mut index: HashMap<String, u32> = HashMap::new();
        let mut texts = Vec::new();
        let mut find = |text: &str| {
            index.get(text).copied().unwrap_or_else(|| {
                texts.push(text.to_owned());
                index.insert(text.to_owned(), texts.len() as u32 - 1);
                texts.len() as u32 - 1
            })
        };
        let cells = cells.into_iter().map(|cell| find(cell.as_ref())).collect();
        self.0.push(Column { name: name.to_owned(), texts, cells });
        self
    }

    /// Adds a column of numbers, each written in the shortest form that reads back as the same number. NaN is a missing
    /// value.
    #[must_use]
    pub fn with_numbers(self, name: &str, numbers: impl IntoIterator<Item = f64>) -> Self {
        let text = |number: f64| if number.is_nan() { String::new() } else { number.to_string() };
        self.with_texts(name, numbers.into_iter().map(text))
    }

    /// Checks that there are columns and that all of them have the same number of rows.
    pub(super) fn check(&self, name: &str) -> Result<(), FileErrors> {
        let rows = self.rows();
        let other = self.0.iter().find(|column| column.cells.len() != rows);
        match (other, self.0.first()) {
            (_, None) => Err(FileErrors::whole(name, "has no columns; expected columns with names")),
            (Some(other), Some(first)) => {
                let (name_of, found) = (&other.name, other.cells.len());
                let message = format!("the column {name_of} has {found} rows; expected {rows}, as in {}", first.name);
                Err(FileErrors::whole(name, message))
            }
            (None, Some(_)) => Ok(()),
        }
    }

    /// Returns the names of the columns.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|column| column.name.as_str())
    }

    /// Returns the number of rows.
    pub(super) fn rows(&self) -> usize {
        self.0.first().map_or(0, |column| column.cells.len())
    }

    /// Returns the cells of a row, counted from 0.
    pub(super) fn row(&self, row: usize) -> impl Iterator<Item = &str> {
        self.0.iter().map(move |column| column.texts[column.cells[row] as usize].as_str())
    }
}
