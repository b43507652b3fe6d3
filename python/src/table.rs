//! Columns of tables.

use machband::{store::Columns, text::Cell};
use numpy::{IntoPyArray as _, PyReadonlyArray1};
use pyo3::{prelude::*, types::PyDict};

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
    pub fn of(values: &[Cell]) -> Self {
        let whole = |cell: &Cell| match cell {
            Cell::Whole(whole) => i64::try_from(*whole).ok(),
            Cell::Level(text, number) => number_of(text, *number).and_then(|_| text.parse().ok()),
            _ => None,
        };
        let large = |cell: &Cell| if let Cell::Whole(whole) = cell { u64::try_from(*whole).ok() } else { None };
        let time = |cell: &Cell| if let Cell::Time(time) = cell { Some(time.as_millisecond()) } else { None };
        let number = |cell: &Cell| match cell {
            Cell::Missing => Some(f64::NAN),
            Cell::Level(text, number) => number_of(text, *number),
            cell => cell.as_number(),
        };
        let text = |cell: &Cell| (*cell != Cell::Missing).then(|| cell.to_string());
        all(values, whole)
            .map(Self::Whole)
            .or_else(|| all(values, large).map(Self::Large))
            .or_else(|| all(values, time).map(Self::Time))
            .or_else(|| values.iter().map(number).collect::<Option<_>>().map(Self::Number))
            .unwrap_or_else(|| Self::Text(values.iter().map(text).collect()))
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

/// Returns what `of` makes of every value; `None` if there are no values, or one is something else.
fn all<T>(values: &[Cell], of: impl Fn(&Cell) -> Option<T>) -> Option<Vec<T>> {
    if values.is_empty() { None } else { values.iter().map(of).collect() }
}

/// Returns the number of a level, unless its text has leading zeros, which belong to a name.
fn number_of(text: &str, number: Option<f64>) -> Option<f64> {
    let digits = text.trim_start_matches(['-', '+']);
    number.filter(|_| digits.len() < 2 || !digits.starts_with('0') || digits.contains(['.', 'e', 'E']))
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

/// The cells of a column.
#[derive(FromPyObject)]
pub enum Given<'py> {
    Whole(PyReadonlyArray1<'py, i64>),
    Number(PyReadonlyArray1<'py, f64>),
    /// The different texts, and for each row the index of its text, or −1 if it is missing.
    Levels(Vec<String>, PyReadonlyArray1<'py, i64>),
}

/// Returns columns as a table of the library.
pub fn given(columns: &[(String, Given<'_>)]) -> PyResult<Columns> {
    columns.iter().try_fold(Columns::default(), |table, (name, column)| {
        Ok(match column {
            Given::Whole(numbers) => table.with_whole(name, numbers.as_slice()?),
            Given::Number(numbers) => table.with_numbers(name, numbers.as_slice()?.iter().copied()),
            Given::Levels(levels, cells) => table.with_levels(name, levels, cells.as_slice()?),
        })
    })
}
