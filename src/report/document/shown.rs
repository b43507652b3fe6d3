//! What a reader sees of a value, together with the value, by which tables are sorted.

use std::{fmt, ops::Deref};

use crate::text::Cell;

/// A formatted value. It is used like the text that it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    text: String,
    value: Cell,
}

impl Shown {
    /// Shows a value as this text.
    pub fn new(value: impl Into<Cell>, text: impl Into<String>) -> Self {
        Self { text: text.into(), value: value.into() }
    }

    /// Returns what is shown.
    pub fn value(&self) -> &Cell {
        &self.value
    }
}

impl Deref for Shown {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl AsRef<str> for Shown {
    fn as_ref(&self) -> &str {
        self
    }
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self)
    }
}

impl PartialEq<&str> for Shown {
    fn eq(&self, other: &&str) -> bool {
        self.text == *other
    }
}

impl<T: Into<String>> From<T> for Shown {
    /// Shows a text.
    fn from(text: T) -> Self {
        let text = text.into();
        Self { value: Cell::from(text.as_str()), text }
    }
}
