//! Columns of tables.

use std::path::PathBuf;

use machband::experiment::CellValue;
use numpy::{IntoPyArray as _, PyReadonlyArray1};
use pyo3::{prelude::*, types::PyDict};

use crate::error;

/// A column: whole numbers; numbers, of which missing ones are NaN; times in milliseconds since 1970; or texts, of which
/// missing ones are `None`.
pub enum Column {
    Whole(Vec<i64>),
    /// Whole numbers of which one is above `i64::MAX`, such as seeds.
    Large(Vec<u64>),
    Number(Vec<f64>),
    Time(Vec<i64>),
    Text(Vec<Option<String>>),
}

impl Column {
    /// Chooses the narrowest type for these values.
    pub fn of(values: &[CellValue]) -> Self {
        let all = |is: fn(&CellValue) -> bool| !values.is_empty() && values.iter().all(is);
        if all(|value| matches!(value, CellValue::Whole(_))) {
            let whole = values.iter().map(|value| if let CellValue::Whole(n) = value { *n } else { 0 });
            if let Some(numbers) = whole.clone().map(|n| n.try_into().ok()).collect() {
                return Self::Whole(numbers);
            }
            if let Some(numbers) = whole.map(|n| n.try_into().ok()).collect() {
                return Self::Large(numbers);
            }
        }
        if all(|value| matches!(value, CellValue::Time(_))) {
            let milliseconds =
                |value: &CellValue| if let CellValue::Time(time) = value { time.as_millisecond() } else { 0 };
            return Self::Time(values.iter().map(milliseconds).collect());
        }
        let number = |value: &CellValue| match value {
            CellValue::Missing => Some(f64::NAN),
            CellValue::Whole(n) => Some(*n as f64),
            CellValue::Number(number) => Some(*number),
            CellValue::Text(_) | CellValue::Time(_) => None,
        };
        match values.iter().map(number).collect() {
            Some(numbers) => Self::Number(numbers),
            None => Self::Text(values.iter().map(text).collect()),
        }
    }

    /// Reads the cells of a table in the same way as programs for statistics do: as numbers if all of them are. `names`
    /// of people stay texts.
    pub fn parse(cells: &[&str], names: bool) -> Self {
        let value = |cell: &&str| match cell.parse::<f64>() {
            _ if cell.is_empty() => Some(CellValue::Missing),
            // A name with leading zeros would lose them.
            _ if cell.len() > 1 && cell.starts_with('0') && !cell.contains(['.', 'e']) => None,
            _ if cell.eq_ignore_ascii_case("nan") => None,
            Ok(number) => Some(cell.parse().map_or(CellValue::Number(number), CellValue::Whole)),
            Err(_) => None,
        };
        let texts = || Self::Text(cells.iter().map(|cell| (!cell.is_empty()).then(|| (*cell).to_owned())).collect());
        if names || cells.iter().all(|cell| cell.is_empty()) {
            return texts();
        }
        cells.iter().map(value).collect::<Option<Vec<_>>>().map_or_else(texts, |values| Self::of(&values))
    }

    pub fn into_array(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(match self {
            Self::Whole(numbers) => numbers.into_pyarray(py).into_any(),
            Self::Large(numbers) => numbers.into_pyarray(py).into_any(),
            Self::Number(numbers) => numbers.into_pyarray(py).into_any(),
            Self::Time(times) => times.into_pyarray(py).call_method1("view", ("datetime64[ms]",))?,
            Self::Text(texts) => {
                let texts: Vec<Py<PyAny>> = texts
                    .into_iter()
                    .map(|text| Ok(text.into_pyobject(py)?.into_any().unbind()))
                    .collect::<PyResult<_>>()?;
                texts.into_pyarray(py).into_any()
            }
        })
    }
}

fn text(value: &CellValue) -> Option<String> {
    match value {
        CellValue::Missing => None,
        CellValue::Whole(number) => Some(number.to_string()),
        CellValue::Number(number) => Some(number.to_string()),
        CellValue::Text(text) => Some(text.clone()),
        CellValue::Time(time) => Some(format!("{time:.3}")),
    }
}

/// Returns a table as a dict of arrays.
pub fn columns<'py>(
    py: Python<'py>,
    columns: impl IntoIterator<Item = (String, Column)>,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (name, column) in columns {
        all.set_item(name, column.into_array(py)?)?;
    }
    Ok(all)
}

/// Returns a table that the library wrote as CSV as a dict of arrays.
#[pyfunction]
pub fn read_table<'py>(py: Python<'py>, content: &[u8]) -> PyResult<Bound<'py, PyDict>> {
    let mut reader = csv::Reader::from_reader(content);
    let header = reader.headers().map_err(error)?.clone();
    let rows = reader.records().collect::<Result<Vec<_>, _>>().map_err(error)?;
    let column = |i: usize, name: &str| {
        let cells: Vec<&str> = rows.iter().map(|row| row.get(i).unwrap_or_default()).collect();
        (name.to_owned(), Column::parse(&cells, name == "subject_id"))
    };
    columns(py, header.iter().enumerate().map(|(i, name)| column(i, name)))
}

/// A column to write.
#[derive(FromPyObject)]
pub enum Written<'py> {
    Whole(PyReadonlyArray1<'py, i64>),
    Number(PyReadonlyArray1<'py, f64>),
    Text(Vec<String>),
}

/// Writes columns of equal length as a CSV file. Numbers are written in their shortest form; NaN is an empty cell.
#[pyfunction]
pub fn write_table(path: PathBuf, names: Vec<String>, columns: Vec<Written<'_>>) -> PyResult<()> {
    let texts = columns
        .into_iter()
        .map(|column| {
            Ok(match column {
                Written::Whole(numbers) => numbers.as_slice()?.iter().map(i64::to_string).collect(),
                Written::Number(numbers) => {
                    let text = |number: &f64| if number.is_nan() { String::new() } else { (number + 0.0).to_string() };
                    numbers.as_slice()?.iter().map(text).collect()
                }
                Written::Text(texts) => texts,
            })
        })
        .collect::<PyResult<Vec<Vec<String>>>>()?;
    let mut writer = csv::Writer::from_path(&path).map_err(error)?;
    writer.write_record(&names).map_err(error)?;
    for row in 0..texts.first().map_or(0, Vec::len) {
        writer.write_record(texts.iter().map(|column| &column[row])).map_err(error)?;
    }
    Ok(writer.flush()?)
}
