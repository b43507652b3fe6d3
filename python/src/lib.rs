//! The extension module of the Python package `machband`: thin functions over the library, which take and return NumPy
//! arrays. The package in `machband/` documents them, names their arguments and builds data frames.
//!
//! Every function that computes runs on threads of its own (`job`), without the interpreter's lock.

mod definition;
mod job;
mod light;
mod study;
mod table;
mod vision;

use std::{
    collections::{BTreeSet, HashMap},
    ffi::OsString,
    io::Write as _,
};

use machband::{
    store::{FileErrors, StoreError},
    work::{Request, from_names, told},
};
use numpy::IntoPyArray as _;
use pyo3::{create_exception, exceptions::PyValueError, prelude::*};

create_exception!(machband, Error, PyValueError, "A value, file or data set is not as machband expects it.");
create_exception!(
    machband,
    DataError,
    Error,
    "Data that cannot be analyzed. The attribute `rows` has the rows of the table that are wrong, counted from 0."
);

/// Turns any error of the library into a Python exception with the same words.
fn error(error: impl std::fmt::Display) -> PyErr {
    Error::new_err(error.to_string())
}

/// Turns an error of an operation into a Python exception; one about data knows the rows of their table.
fn raised(py: Python<'_>, failed: &anyhow::Error) -> PyErr {
    // The order of levels is an argument of `factors`.
    let message = told(failed, |field| if field == "levels" { "factors" } else { field }.to_owned());
    let errors = match (failed.downcast_ref(), failed.downcast_ref()) {
        (Some(FileErrors(errors)), _) | (_, Some(StoreError::FileErrors(FileErrors(errors)))) => errors,
        _ => return error(message),
    };
    let rows: BTreeSet<usize> = errors.iter().flat_map(|error| error.rows.iter().copied()).collect();
    let found = DataError::new_err(message);
    let rows: Vec<i64> = rows.into_iter().map(|row| row as i64).collect();
    found.value(py).setattr("rows", rows.into_pyarray(py)).err().unwrap_or(found)
}

/// A value of a request's field.
#[derive(FromPyObject)]
enum Field {
    Flag(bool),
    Text(String),
    List(Vec<String>),
}

/// The fields of a request by name; the others have their defaults.
type Fields = HashMap<String, Field>;

/// Makes a request.
fn request<T: Request>(fields: Fields) -> PyResult<T> {
    let value = |field| match field {
        Field::Flag(flag) => flag.into(),
        Field::Text(text) => text.into(),
        Field::List(texts) => texts.into(),
    };
    from_names(&fields.into_iter().map(|(name, field)| (name, value(field))).collect()).map_err(error)
}

/// Runs the program with these arguments, of which the first is the program's name, and returns the exit status.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| {
        let status = machband::cli::run_with(arguments);
        let _ = std::io::stdout().flush();
        status
    })
}

/// The functions and classes.
#[pymodule]
mod _machband {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::{
        DataError, Error,
        definition::{Definition, simulate},
        light::{
            encode, interpolate, kinds, light, mesh, parameters, profile, save_stimulus, shade, stimulus, visual_angle,
        },
        main,
        study::{Analysis, analyze, export, read_results, verify, write_analysis},
        vision::{compare, predict},
    };

    /// Loads NumPy now, so that nothing can interrupt it later.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) {
        let _ = numpy::PyArray1::<f64>::zeros(module.py(), 1, false);
    }

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    /// Largest side of a picture in pixels.
    #[pymodule_export]
    const MAX_SIZE: u32 = machband::stimulus::recipe::MAX_SIZE;
}
