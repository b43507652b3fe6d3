//! Stimuli as arrays, and the functions that turn light into codes.

use std::{convert::Infallible, path::PathBuf};

use machband::{
    display::{Screen, Viewing},
    light::{CodeImage, Depth, Interpolation, LinearImage, Quantizer, Samples, Transfer},
    stimulus::{ParameterValue, Stimulus, catalog, recipe::Recipe},
    store::{self, Writer},
    work::{Encoding, Image},
};
use numpy::{IntoPyArray as _, PyArrayDyn, PyArrayMethods as _, PyReadonlyArrayDyn};
use pyo3::{IntoPyObjectExt as _, prelude::*};

use crate::{
    Fields, error, job, request,
    table::{Described, described},
};

/// Parameters of a stimulus: names and values.
pub type Given = Vec<(String, String)>;

/// Makes a stimulus from its kind and its parameters.
pub fn stimulus_of(kind: &str, given: Given) -> PyResult<Stimulus> {
    let value = |text: &String| text.parse().unwrap_or_else(|never: Infallible| match never {});
    Stimulus::with_parameters(kind, given.iter().map(|(name, text)| (name.as_str(), value(text))))
        .map_err(|errors| error(errors.join("\n")))
}

/// Returns codes as an array of shape (height, width, 3), without a copy.
pub fn codes_array(py: Python<'_>, image: CodeImage) -> PyResult<Bound<'_, PyAny>> {
    let shape = [image.height as usize, image.width as usize, 3];
    Ok(match image.samples {
        Samples::Eight(codes) => codes.into_pyarray(py).reshape(shape)?.into_any(),
        Samples::Sixteen(codes) => codes.into_pyarray(py).reshape(shape)?.into_any(),
    })
}

/// Makes something from the recipe of an image of a stimulus; `writes` says whether it is a file.
fn made<T: Send + 'static>(
    py: Python<'_>,
    (kind, parameters, image): (&str, Given, Fields),
    writes: bool,
    of: impl FnOnce(&Recipe, &Quantizer) -> anyhow::Result<T> + Send + 'static,
) -> PyResult<T> {
    let (stimulus, image) = (stimulus_of(kind, parameters)?, request::<Image>(image)?);
    job::run(py, None, writes, move |job| {
        let recipe = image.recipe(stimulus, job)?;
        of(&recipe, &recipe.quantizer())
    })
}

/// Returns the codes of a stimulus.
#[pyfunction]
pub fn stimulus<'py>(py: Python<'py>, kind: &str, parameters: Given, image: Fields) -> PyResult<Bound<'py, PyAny>> {
    let codes = |recipe: &Recipe, quantizer: &Quantizer| Ok(recipe.codes(quantizer));
    codes_array(py, made(py, (kind, parameters, image), false, codes)?)
}

/// Returns the light of a stimulus.
#[pyfunction]
pub fn light<'py>(py: Python<'py>, kind: &str, parameters: Given, image: Fields) -> PyResult<Bound<'py, PyAny>> {
    let (stimulus, Image { size, .. }) = (stimulus_of(kind, parameters)?, request(image)?);
    let LinearImage { width, height, data } = job::run(py, None, false, move |_| Ok(stimulus.linear(size)))?;
    Ok(data.into_pyarray(py).reshape([height as usize, width as usize, 3])?.into_any())
}

/// Returns the profile that the command `stimulus --profile` writes.
#[pyfunction]
pub fn profile<'py>(py: Python<'py>, kind: &str, parameters: Given, image: Fields) -> PyResult<Described<'py>> {
    let table = |recipe: &Recipe, quantizer: &Quantizer| Ok(recipe.profile(quantizer));
    described(py, made(py, (kind, parameters, image), false, table)?)
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
    made(py, (kind, parameters, image), true, move |recipe, quantizer| {
        Ok(store::image::write_recipe(&Writer::new([], force), &path, recipe, quantizer)?)
    })
}

/// Returns the kinds of stimulus, and a sentence about each.
#[pyfunction]
pub fn kinds() -> Vec<(&'static str, &'static str)> {
    catalog::all().iter().map(|entry| (entry.kind, entry.about)).collect()
}

/// A parameter: its name, value, unit, meaning and range, and all its values if they are a few names.
type About = (&'static str, Py<PyAny>, &'static str, &'static str, &'static str, &'static [&'static str]);

/// Returns the parameters of a stimulus; those that are not given have their defaults.
#[pyfunction]
pub fn parameters(py: Python<'_>, kind: &str, given: Given) -> PyResult<Vec<About>> {
    let stimulus = stimulus_of(kind, given)?;
    let value = |name| match stimulus.get(name) {
        Some(ParameterValue::Number(number)) => number.into_py_any(py),
        Some(ParameterValue::Text(text)) => text.into_py_any(py),
        None => Ok(py.None()),
    };
    let all = stimulus.parameters().iter();
    all.map(|p| Ok((p.name, value(p.name)?, p.unit, p.description, p.expected, p.choices))).collect()
}

/// Numbers of any shape.
type Numbers<'py> = PyReadonlyArrayDyn<'py, f64>;

/// Applies `f` to every element, row by row, without the interpreter's lock, until Ctrl+C.
fn map<'py>(
    py: Python<'py>,
    values: &Numbers<'py>,
    mut f: impl FnMut(f64) -> f64 + Send,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let mut values = values.as_array().to_owned();
    py.detach(|| {
        values.iter_mut().enumerate().try_for_each(|(i, value)| {
            *value = f(*value);
            if i % 65_536 == 0 { Python::attach(|py| py.check_signals()) } else { Ok(()) }
        })
    })?;
    Ok(values.into_pyarray(py))
}

/// Returns I_n of every element.
#[pyfunction]
pub fn interpolate<'py>(py: Python<'py>, u: Numbers<'py>, depth: &str) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let interpolation = Interpolation::new(depth.parse::<Depth>().map_err(error)?);
    map(py, &u, |u| if u.is_nan() { u } else { interpolation.value(u) })
}

/// Encodes light, or decodes encoded values. If the channels of the display differ, each row has red, green and blue.
#[pyfunction]
pub fn encode<'py>(
    py: Python<'py>,
    values: Numbers<'py>,
    encoding: Fields,
    inverse: bool,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let encoding = request::<Encoding>(encoding)?;
    let transfers = job::run(py, None, false, move |job| Ok(encoding.read(job)?.transfers))?;
    if transfers.uniform().is_none() && values.as_array().shape().last() != Some(&3) {
        return Err(error("the channels of the display differ; expected values of shape (…, 3)"));
    }
    let code = if inverse { Transfer::linear_from_encoded } else { Transfer::encoded_from_linear };
    let mut channels = transfers.channels().iter().cycle();
    map(py, &values, |value| channels.next().map_or(value, |of| code(of, value)))
}

/// The visual angle, the size and the number of pixels of lengths; and the pixels per degree.
type Lengths<'py> = ([Bound<'py, PyArrayDyn<f64>>; 3], f64);

/// Returns lengths that are given in one of these units in all of them, and the pixels per degree at the center of the
/// screen.
#[pyfunction]
pub fn visual_angle<'py>(
    py: Python<'py>,
    values: Numbers<'py>,
    unit: &str,
    screen: (u32, f64),
    distance_cm: f64,
) -> PyResult<Lengths<'py>> {
    let screen = Screen::new(screen.0, screen.0, screen.1).map_err(error)?;
    let viewing = Viewing::new(screen, distance_cm).map_err(error)?;
    let px = |value: f64| match unit {
        "deg" => viewing.px_from_deg(value),
        "cm" => value * screen.px_per_cm(),
        _ => value,
    };
    let deg = map(py, &values, |value| viewing.deg_from_px(px(value)))?;
    let cm = map(py, &values, |value| px(value) / screen.px_per_cm())?;
    Ok(([deg, cm, map(py, &values, px)?], viewing.px_per_degree()))
}
