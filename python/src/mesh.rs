//! Shaded meshes.

use glam::DVec3;
use machband::{
    store::mesh::{MeshFile, from_arrays},
    work::shade::{Shade, Wanted},
};
use numpy::{IntoPyArray as _, PyArrayMethods as _, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::{Fields, error, job, light::codes_array, request};

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
