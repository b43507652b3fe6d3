//! Tables as arrays, and columns of tables in memory.

use machband::{
    store::Columns,
    text::{Cell, Table},
};
use numpy::{IntoPyArray as _, PyReadonlyArray1};
use pyo3::{prelude::*, types::PyDict};

/// A dict of arrays; and for each column its name, its unit and its description.
pub type Described<'py> = (Bound<'py, PyDict>, Vec<(String, String, String)>);

/// Returns a table as arrays.
pub fn described(py: Python<'_>, table: Table) -> PyResult<Described<'_>> {
    let columns = PyDict::new(py);
    for column in &table.columns {
        columns.set_item(&column.name, array(py, &column.cells)?)?;
    }
    let about = table.columns.into_iter().map(|column| (column.name, column.unit, column.description));
    Ok((columns, about.collect()))
}

/// Returns cells as an array of the narrowest type: whole numbers; numbers, of which missing ones are NaN; times in
/// milliseconds; or texts, of which missing ones are `None`.
fn array<'py>(py: Python<'py>, cells: &[Cell]) -> PyResult<Bound<'py, PyAny>> {
    let whole = |cell: &Cell| match cell {
        Cell::Whole(whole) => Some(*whole),
        Cell::Level(text, number) => number_of(text, *number).and_then(|_| text.parse().ok()),
        _ => None,
    };
    let time = |cell: &Cell| if let Cell::Time(time) = cell { Some(time.as_millisecond()) } else { None };
    let number = |cell: &Cell| match cell {
        Cell::Missing => Some(f64::NAN),
        Cell::Level(text, number) => number_of(text, *number),
        cell => cell.as_number(),
    };
    if let Some(numbers) = all(cells, |cell| i64::try_from(whole(cell)?).ok()) {
        return Ok(numbers.into_pyarray(py).into_any());
    }
    // Seeds may be above `i64::MAX`.
    if let Some(numbers) = all(cells, |cell| u64::try_from(whole(cell)?).ok()) {
        return Ok(numbers.into_pyarray(py).into_any());
    }
    if let Some(times) = all(cells, time) {
        return times.into_pyarray(py).call_method1("view", ("datetime64[ms]",));
    }
    if let Some(numbers) = cells.iter().map(number).collect::<Option<Vec<f64>>>() {
        return Ok(numbers.into_pyarray(py).into_any());
    }
    let text =
        |cell: &Cell| Ok((*cell != Cell::Missing).then(|| cell.to_string()).into_pyobject(py)?.into_any().unbind());
    let texts: Vec<Py<PyAny>> = cells.iter().map(text).collect::<PyResult<_>>()?;
    Ok(texts.into_pyarray(py).into_any())
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
