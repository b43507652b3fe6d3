//! Tables of typed values.

use serde_json::{Map, Value};

use super::cell::{Cell, inert};

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
