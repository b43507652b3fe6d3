//! Tables of typed values.

use std::{borrow::Cow, cmp::Ordering, fmt};

use jiff::Timestamp;
use serde::{Serialize as _, Serializer};
use serde_json::{Map, Value};

/// A typed value. [`Display`](fmt::Display) writes it as the cell of a CSV file.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Cell {
    /// An empty cell; null in JSON.
    #[default]
    Missing,
    /// A whole number; large enough for every seed.
    Whole(i128),
    /// A number, which may be infinite.
    Number(f64),
    /// A word, an ID or a sentence.
    Text(String),
    /// A level of a factor as it was written, and its number if the levels of the factor are numbers.
    Level(String, Option<f64>),
    /// A point in time.
    Time(Timestamp),
}

impl Cell {
    /// Returns the number by which the value is sorted and drawn; `None` if it is not a number.
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Whole(whole) => Some(*whole as f64),
            Self::Number(number) | Self::Level(_, Some(number)) => Some(*number),
            Self::Missing | Self::Text(_) | Self::Level(_, None) | Self::Time(_) => None,
        }
    }

    /// Returns the order of two values: numbers come first, then other values by their text, then missing ones.
    pub fn compare(&self, other: &Self) -> Ordering {
        let rank = |cell: &Self| match cell {
            Self::Missing => 2,
            cell => u8::from(cell.as_number().is_none()),
        };
        rank(self).cmp(&rank(other)).then_with(|| match (self.as_number(), other.as_number()) {
            (Some(own), Some(other)) => own.total_cmp(&other),
            _ => self.to_string().cmp(&other.to_string()),
        })
    }

    /// Returns the value in JSON: finite numbers are numbers, missing values are null, and everything else is the text
    /// of the CSV cell.
    pub fn json(&self) -> Value {
        match self {
            Self::Missing => Value::Null,
            Self::Whole(whole) => {
                let unsigned = u64::try_from(*whole).map(Value::from);
                unsigned
                    .or_else(|_| i64::try_from(*whole).map(Value::from))
                    .unwrap_or_else(|_| whole.to_string().into())
            }
            Self::Number(number) if number.is_finite() => Value::from(*number),
            Self::Number(_) | Self::Text(_) | Self::Level(..) | Self::Time(_) => self.to_string().into(),
        }
    }
}

impl fmt::Display for Cell {
    /// Numbers are written so that they read back exactly; very small and very large ones have an exponent.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => Ok(()),
            Self::Whole(whole) => whole.fmt(f),
            Self::Number(number) => match number.abs() {
                magnitude if magnitude > 0.0 && !(1e-4..1e15).contains(&magnitude) && magnitude.is_finite() => {
                    write!(f, "{number:e}")
                }
                _ => number.fmt(f),
            },
            Self::Text(text) | Self::Level(text, _) => f.write_str(text),
            Self::Time(time) => write!(f, "{time:.3}"),
        }
    }
}

impl From<f64> for Cell {
    /// NaN is a missing value, and −0 is 0.
    fn from(number: f64) -> Self {
        if number.is_nan() { Self::Missing } else { Self::Number(number + 0.0) }
    }
}

macro_rules! whole {
    ($($kind:ty)*) => {$(
        impl From<$kind> for Cell {
            fn from(whole: $kind) -> Self {
                Self::Whole(whole as i128)
            }
        }
    )*};
}
whole! { u16 u32 u64 usize }

impl From<String> for Cell {
    /// An empty text is a missing value.
    fn from(text: String) -> Self {
        if text.is_empty() { Self::Missing } else { Self::Text(text) }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

/// Serializes a number as the JSON of its cell, so that infinity is a word; serde's would be null, as a missing value is.
pub(crate) fn as_cell<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Cell::from(*number).json().serialize(serializer)
}

/// Makes a text safe for spreadsheets: if a spreadsheet would treat it as a formula (it begins with `=`, `+`, `-`, `@`, a
/// tab or a carriage return, and is not a number), it is prefixed with an apostrophe, which marks it as text.
pub fn inert(cell: &str) -> Cow<'_, str> {
    if is_formula(cell) { Cow::Owned(format!("'{cell}")) } else { Cow::Borrowed(cell) }
}

/// True if a spreadsheet would evaluate a cell instead of showing it.
pub fn is_formula(cell: &str) -> bool {
    cell.starts_with(['=', '+', '-', '@', '\t', '\r']) && cell.parse::<f64>().is_err()
}

/// The values of one kind, with their name, unit and meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The name in headers.
    pub name: String,
    /// The unit; empty if there is none.
    pub unit: String,
    /// What the column contains, in one sentence.
    pub description: String,
    /// The values, one per row.
    pub cells: Vec<Cell>,
}

/// Columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    pub columns: Vec<Column>,
}

impl Column {
    /// Describes a column, which has no values yet.
    pub fn new(name: impl Into<String>, unit: &str, description: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.to_owned(), description: description.into(), cells: Vec::new() }
    }
}

impl Table {
    /// Fills columns with rows that have a cell for each of them.
    pub fn new(mut columns: Vec<Column>, rows: impl IntoIterator<Item = Vec<Cell>>) -> Self {
        for row in rows {
            debug_assert_eq!(row.len(), columns.len());
            columns.iter_mut().zip(row).for_each(|(column, cell)| column.cells.push(cell));
        }
        Self { columns }
    }

    /// Returns the column with this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Returns the rows in order.
    pub fn rows(&self) -> impl Iterator<Item = Vec<&Cell>> {
        let rows = self.columns.first().map_or(0, |column| column.cells.len());
        (0..rows).map(|row| self.columns.iter().map(|column| &column.cells[row]).collect())
    }

    /// Writes the table as CSV in UTF-8. Missing values are empty, and texts that a spreadsheet would evaluate are [`inert`].
    pub fn csv(&self) -> Vec<u8> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        // Writing to memory does not fail, and all rows have as many cells as the header.
        let _ = writer.write_record(self.columns.iter().map(|column| inert(&column.name).into_owned()));
        for row in self.rows() {
            let _ = writer.write_record(row.into_iter().map(|cell| inert(&cell.to_string()).into_owned()));
        }
        writer.into_inner().unwrap_or_default()
    }

    /// Returns an object with the description of each column and its unit, if it has one.
    pub fn described(&self) -> Value {
        let about = |column: &Column| {
            let unit = (!column.unit.is_empty()).then_some(("unit", &column.unit));
            let about = [("description", &column.description)].into_iter().chain(unit);
            let about: Map<_, _> = about.map(|(key, text)| (key.to_owned(), Value::from(text.as_str()))).collect();
            (column.name.clone(), Value::from(about))
        };
        self.columns.iter().map(about).collect()
    }

    /// Returns an object for each row.
    pub fn json(&self) -> Vec<Map<String, Value>> {
        let object = |row: Vec<&Cell>| {
            self.columns.iter().zip(row).map(|(column, cell)| (column.name.clone(), cell.json())).collect()
        };
        self.rows().map(object).collect()
    }
}
