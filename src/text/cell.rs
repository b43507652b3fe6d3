//! One value of a table.

use std::{borrow::Cow, cmp::Ordering, fmt};

use jiff::Timestamp;
use serde_json::Value;

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

/// Makes a text safe for spreadsheets: if a spreadsheet would treat it as a formula (it begins with `=`, `+`, `-`, `@`, a
/// tab or a carriage return, and is not a number), it is prefixed with an apostrophe, which marks it as text.
pub fn inert(cell: &str) -> Cow<'_, str> {
    if is_formula(cell) { Cow::Owned(format!("'{cell}")) } else { Cow::Borrowed(cell) }
}

/// True if a spreadsheet would evaluate a cell instead of showing it.
pub fn is_formula(cell: &str) -> bool {
    cell.starts_with(['=', '+', '-', '@', '\t', '\r']) && cell.parse::<f64>().is_err()
}
