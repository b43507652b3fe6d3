//! Stimuli as arrays, and the functions that turn light into codes.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

use machband::{
    display::{Screen, Viewing},
    light::{Bits, CodeImage, Depth, Dither, Interpolation, LinearImage, Quantizer, Samples, Transfer},
    stimulus::{ParameterValue, Stimulus, catalog, recipe::Recipe},
    store::{self, Writer, curve},
    work::{Encoding, Image},
};
use numpy::{IntoPyArray as _, PyArray1, PyArrayMethods as _, PyReadonlyArray1};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    Fields, error,
    job::{self, Warnings},
    request,
    table::{self, Column},
};

/// Parameters of a stimulus: names and values.
pub type Given = Vec<(String, Value)>;

/// A number or text.
#[derive(FromPyObject, IntoPyObject)]
pub enum Value {
    Number(f64),
    Text(String),
}

impl From<Value> for ParameterValue {
    fn from(value: Value) -> Self {
        match value {
            Value::Number(number) if number == f64::INFINITY => Self::Text("inf".to_owned()),
            Value::Number(number) => Self::Number(number),
            Value::Text(text) => text.parse().unwrap_or_else(|never| match never {}),
        }
    }
}

/// Makes a stimulus from its kind and its parameters.
pub fn stimulus_of(kind: &str, given: Given) -> PyResult<Stimulus> {
    let given: Vec<(String, ParameterValue)> = given.into_iter().map(|(name, value)| (name, value.into())).collect();
    let given = given.iter().map(|(name, value)| (name.as_str(), value.clone()));
    Stimulus::with_parameters(kind, given).map_err(|errors| error(errors.join("\n")))
}

/// Returns the quantizer for a recipe. The last one is kept, because the next stimulus is mostly for the same display.
fn quantizer(recipe: &Recipe) -> Arc<Quantizer> {
    static LAST: Mutex<Option<Arc<Quantizer>>> = Mutex::new(None);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    match last.as_ref().filter(|last| last.bits() == recipe.bits && *last.transfers() == recipe.transfers) {
        Some(last) => Arc::clone(last),
        None => Arc::clone(last.insert(Arc::new(recipe.quantizer()))),
    }
}

/// Largest side of a stimulus that is drawn on the calling thread, pixels: it takes a few milliseconds.
const QUICK_PX: u32 = 2048;

/// Returns codes as an array of shape (height, width, 3), without a copy.
pub fn codes_array(py: Python<'_>, image: CodeImage) -> PyResult<Bound<'_, PyAny>> {
    let shape = [image.height as usize, image.width as usize, 3];
    Ok(match image.samples {
        Samples::Eight(codes) => codes.into_pyarray(py).reshape(shape)?.into_any(),
        Samples::Sixteen(codes) => codes.into_pyarray(py).reshape(shape)?.into_any(),
    })
}

/// Returns the recipe of an image of a stimulus.
fn recipe(py: Python<'_>, kind: &str, parameters: Given, image: Fields) -> PyResult<Recipe> {
    let (stimulus, image) = (stimulus_of(kind, parameters)?, request::<Image>(image)?);
    let warnings = Warnings::default();
    let recipe = image.recipe(stimulus, &warnings).map_err(error)?;
    warnings.issue(py)?;
    Ok(recipe)
}

/// Returns the codes of a stimulus.
#[pyfunction]
pub fn stimulus<'py>(py: Python<'py>, kind: &str, parameters: Given, image: Fields) -> PyResult<Bound<'py, PyAny>> {
    let recipe = recipe(py, kind, parameters, image)?;
    // Another thread would take longer than such a stimulus, mostly to get its memory.
    let is_quick = recipe.size <= QUICK_PX
        && recipe.bits == Bits::Eight
        && recipe.dither == Dither::None
        && recipe.stimulus.is_line();
    if is_quick {
        return codes_array(py, py.detach(|| recipe.codes(&quantizer(&recipe))));
    }
    codes_array(py, job::run(py, None, false, move |_| Ok(recipe.codes(&quantizer(&recipe))))?)
}

/// Returns the light of a stimulus.
#[pyfunction]
pub fn light<'py>(py: Python<'py>, kind: &str, parameters: Given, image: Fields) -> PyResult<Bound<'py, PyAny>> {
    let (stimulus, Image { size, .. }) = (stimulus_of(kind, parameters)?, request(image)?);
    let LinearImage { width, height, data } = job::run(py, None, false, move |_| Ok(stimulus.linear(size)))?;
    Ok(data.into_pyarray(py).reshape([height as usize, width as usize, 3])?.into_any())
}

/// Returns the columns of the profile that the command `stimulus --profile` writes.
#[pyfunction]
pub fn profile<'py>(py: Python<'py>, kind: &str, parameters: Given, image: Fields) -> PyResult<Bound<'py, PyDict>> {
    let recipe = recipe(py, kind, parameters, image)?;
    let samples = job::run(py, None, false, move |_| Ok(curve::samples(&recipe, &quantizer(&recipe))))?;
    let columns = curve::table(&samples).columns.into_iter();
    table::columns(py, columns.map(|column| (column.name, Column::of(&column.cells))))
}

/// Writes the image that the command `stimulus` writes.
#[pyfunction]
pub fn save_stimulus(
    py: Python<'_>,
    kind: &str,
    parameters: Given,
    image: Fields,
    path: PathBuf,
    force: bool,
) -> PyResult<()> {
    let recipe = recipe(py, kind, parameters, image)?;
    job::run(py, None, true, move |_| {
        Ok(store::image::write_recipe(&Writer::new([], force), &path, &recipe, &quantizer(&recipe))?)
    })
}

/// Returns the kinds of stimulus, and a sentence about each.
#[pyfunction]
pub fn kinds() -> Vec<(&'static str, &'static str)> {
    catalog::all().iter().map(|entry| (entry.kind, entry.about)).collect()
}

/// A parameter: its name, value, unit, meaning and range, and all its values if they are a few names.
type Described = (&'static str, Option<Value>, &'static str, &'static str, &'static str, &'static [&'static str]);

/// Returns the parameters of a stimulus; those that are not given have their defaults.
#[pyfunction]
pub fn parameters(kind: &str, given: Given) -> PyResult<Vec<Described>> {
    let stimulus = stimulus_of(kind, given)?;
    let value = |name| {
        stimulus.get(name).map(|value| match value {
            ParameterValue::Number(number) => Value::Number(number),
            ParameterValue::Text(text) => Value::Text(text),
        })
    };
    let all = stimulus.parameters().iter();
    Ok(all.map(|p| (p.name, value(p.name), p.unit, p.description, p.expected, p.choices)).collect())
}

/// Applies `f` to every element.
fn map<'py>(
    py: Python<'py>,
    values: &PyReadonlyArray1<'py, f64>,
    f: impl Fn(f64) -> f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    Ok(values.as_slice()?.iter().map(|value| f(*value)).collect::<Vec<_>>().into_pyarray(py))
}

/// Returns I_n of every element.
#[pyfunction]
pub fn interpolate<'py>(
    py: Python<'py>,
    u: PyReadonlyArray1<'py, f64>,
    depth: Value,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let depth = ParameterValue::from(depth).to_string();
    let interpolation = Interpolation::new(depth.parse::<Depth>().map_err(error)?);
    map(py, &u, |u| if u.is_nan() { u } else { interpolation.value(u) })
}

/// Encodes light, or decodes encoded values, in rows of this width. If the channels of the display differ, each row has red,
/// green and blue.
#[pyfunction]
pub fn encode<'py>(
    py: Python<'py>,
    values: PyReadonlyArray1<'py, f64>,
    width: usize,
    encoding: Fields,
    inverse: bool,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let warnings = Warnings::default();
    let transfers = request::<Encoding>(encoding)?.read(&warnings).map_err(error)?.transfers;
    warnings.issue(py)?;
    if transfers.uniform().is_none() && width != 3 {
        return Err(error("the channels of the display differ; expected values of shape (…, 3)"));
    }
    let code = |transfer: &Transfer, value: f64| {
        if inverse { transfer.linear_from_encoded(value) } else { transfer.encoded_from_linear(value) }
    };
    let values = values.as_slice()?.iter().zip(transfers.channels().iter().cycle());
    Ok(values.map(|(value, transfer)| code(transfer, *value)).collect::<Vec<_>>().into_pyarray(py))
}

/// Returns the visual angle, the size and the number of pixels of lengths that are given in one of these units, and the
/// pixels per degree at the center of the screen.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn visual_angle<'py>(
    py: Python<'py>,
    values: PyReadonlyArray1<'py, f64>,
    unit: &str,
    screen: (u32, f64),
    distance_cm: f64,
) -> PyResult<([Bound<'py, PyArray1<f64>>; 3], f64)> {
    let screen = Screen::new(screen.0, screen.0, screen.1).map_err(error)?;
    let viewing = Viewing::new(screen, distance_cm).map_err(error)?;
    let px = |value: f64| match unit {
        "deg" => viewing.px_from_deg(value),
        "cm" => value * screen.px_per_cm(),
        _ => value,
    };
    let deg = map(py, &values, |value| if unit == "deg" { value } else { viewing.deg_from_px(px(value)) })?;
    let cm = map(py, &values, |value| if unit == "cm" { value } else { px(value) / screen.px_per_cm() })?;
    Ok(([deg, cm, map(py, &values, px)?], viewing.px_per_degree()))
}
