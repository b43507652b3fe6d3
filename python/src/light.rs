//! Stimuli and shaded meshes as arrays, and the functions that turn light into codes.

use std::path::PathBuf;

use glam::DVec3;
use machband::{
    display::{Screen, Viewing},
    light::{CodeImage, Depth, LinearImage, Quantizer, Samples, TANH_K, Transfer},
    stimulus::{ParameterValue, Stimulus, catalog, recipe::Recipe},
    store::{
        self, Writer,
        mesh::{MeshFile, from_arrays},
    },
    work::{
        Encoding, Image,
        shade::{Shade, Wanted},
    },
};
use numpy::{IntoPyArray as _, PyArrayDyn, PyArrayMethods as _, PyReadonlyArray2, PyReadonlyArrayDyn};
use pyo3::{IntoPyObjectExt as _, prelude::*};

use crate::{
    Fields, error, job, request,
    table::{Described, described},
};

/// Parameters of a stimulus: names and values.
pub type Given = Vec<(String, String)>;

/// Makes a stimulus from its kind and its parameters.
pub fn stimulus_of(kind: &str, given: Given) -> PyResult<Stimulus> {
    let given = given.iter().map(|(name, text)| (name.as_str(), text.as_str()));
    Stimulus::with_parameters(kind, given).map_err(|errors| {
        let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
        error(errors.join("\n"))
    })
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
    let depth: Depth = depth.parse().map_err(error)?;
    map(py, &u, |u| if u.is_nan() { u } else { depth.interpolation(u, TANH_K) })
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

/// A mesh as arrays: positions, triangles, and normals.
#[derive(FromPyObject)]
pub struct Arrays<'py>(PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, u32>, Option<PyReadonlyArray2<'py, f64>>, f64);

fn triples<T: Copy + numpy::Element>(array: &PyReadonlyArray2<'_, T>) -> PyResult<Vec<[T; 3]>> {
    Ok(array.as_slice()?.as_chunks::<3>().0.to_vec())
}

/// Copies arrays, which have three columns. Returns what makes their mesh without the interpreter's lock.
fn mesh_of(
    Arrays(positions, triangles, normals, crease_deg): &Arrays<'_>,
) -> PyResult<impl FnOnce() -> anyhow::Result<MeshFile> + Send + 'static> {
    let normals = normals.as_ref().map(triples).transpose()?;
    let (positions, triangles, crease_deg) = (triples(positions)?, triples(triangles)?, *crease_deg);
    Ok(move || {
        let vectors = |rows: Vec<[f64; 3]>| rows.into_iter().map(DVec3::from_array).collect::<Vec<_>>();
        let normals = normals.map(vectors);
        Ok(from_arrays("mesh", &vectors(positions), &triangles, normals.as_deref(), crease_deg)?)
    })
}

/// Returns the positions, triangles and normals of the mesh that the command's options name.
#[pyfunction]
pub fn mesh(py: Python<'_>, fields: Fields) -> PyResult<[Bound<'_, PyAny>; 3]> {
    let request: Shade = request(fields)?;
    let path = request.one.mesh.clone();
    let file = job::run(py, None, false, move |_| request.one.mesh())?;
    job::warn(py, file.note(&path).as_slice())?;
    let mesh = file.mesh;
    let vectors = |of: fn(&machband::shading::Vertex) -> DVec3| {
        let flat: Vec<f64> = mesh.vertices.iter().flat_map(|vertex| of(vertex).to_array()).collect();
        Ok::<_, PyErr>(flat.into_pyarray(py).reshape([mesh.vertices.len(), 3])?.into_any())
    };
    let triangles: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    let triangles = triangles.into_pyarray(py).reshape([mesh.triangles.len(), 3])?.into_any();
    Ok([vectors(|vertex| vertex.position)?, triangles, vectors(|vertex| vertex.normal)?])
}

/// Shades a mesh or a scene. Returns the codes, and the measurements as JSON if they are wanted.
#[pyfunction]
pub fn shade<'py>(
    py: Python<'py>,
    fields: Fields,
    mesh: Option<Arrays<'py>>,
    measure: bool,
) -> PyResult<(Bound<'py, PyAny>, Option<String>)> {
    let request: Shade = request(fields)?;
    let given = mesh.as_ref().map(mesh_of).transpose()?;
    let wanted = Wanted { picture: true, metrics: measure };
    let shaded = job::run(py, None, false, move |job| request.shade(given.map(|of| of()).transpose()?, wanted, job))?;
    job::warn(py, &shaded.notes)?;
    let codes = shaded.picture.ok_or_else(|| error("no picture; expected one"))?;
    let metrics = shaded.metrics.as_ref().map(serde_json::to_string).transpose().map_err(error)?;
    Ok((codes_array(py, codes)?, metrics))
}
