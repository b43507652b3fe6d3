//! What the model of vision predicts for stimuli, and how it compares pictures.

use machband::{
    light::{CodeImage, LinearImage, Samples},
    stimulus::Visible,
    work::{
        compare::{Compare, Given as Picture},
        predict::Predict,
    },
};
use numpy::{IntoPyArray as _, PyArrayMethods as _, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::{
    Fields, error,
    job::{self, Job},
    light::{Given, codes_array, stimulus_of},
    request,
};

/// A picture of shape (height, width, 3), as codes or as linear light.
#[derive(FromPyObject)]
pub enum Shown<'py> {
    Eight(PyReadonlyArray3<'py, u8>),
    Sixteen(PyReadonlyArray3<'py, u16>),
    Light(PyReadonlyArray3<'py, f32>),
}

impl Shown<'_> {
    fn picture(self) -> PyResult<Picture> {
        let codes = |shape: &[usize], samples| {
            Picture::Codes(CodeImage { width: shape[1] as u32, height: shape[0] as u32, samples })
        };
        Ok(match self {
            Self::Eight(array) => codes(array.shape(), Samples::Eight(array.as_slice()?.to_vec())),
            Self::Sixteen(array) => codes(array.shape(), Samples::Sixteen(array.as_slice()?.to_vec())),
            Self::Light(array) => {
                let (data, shape) = (array.as_slice()?.to_vec(), array.shape());
                Picture::Light(LinearImage { width: shape[1] as u32, height: shape[0] as u32, data })
            }
        })
    }
}

/// A prediction: of a ramp, the bright and the dark band, the blur of the nearest smooth edge and the places of the bands, in
/// degrees; the contrast of the picture; the difference of a mesh from the smooth surface; and the rating.
type Predicted = (Option<(f64, f64, f64, (f64, f64))>, f64, Option<f64>, Option<f64>);

/// Predicts the bands and the detection of a stimulus.
#[pyfunction]
pub fn predict(py: Python<'_>, fields: Fields, kind: &str, parameters: Given) -> PyResult<Predicted> {
    let (request, stimulus) = (request::<Predict>(fields)?, stimulus_of(kind, parameters)?);
    let (found, _) = job::run(py, None, false, move |job| request.one(Some(stimulus), job))?;
    let (ramp, difference) = match found.visible {
        Visible::Ramp(bands) => (Some((bands.bright, bands.dark, bands.blur_deg, bands.at_deg.into())), None),
        Visible::Surface(difference) => (None, Some(difference)),
        Visible::Unknown => (None, None),
    };
    Ok((ramp, found.detection, difference, found.rating))
}

/// Compares two pictures in memory, or otherwise the two files that the fields name, and returns the JSON of the command and
/// the map. If the fields ask for the steps of a picture, judges these, and returns the JSON and the dithered picture.
#[pyfunction]
pub fn compare<'py>(py: Python<'py>, fields: Fields, given: Vec<Shown<'py>>) -> PyResult<(String, Bound<'py, PyAny>)> {
    let request = request::<Compare>(fields)?;
    let mut given = given.into_iter().map(Shown::picture).collect::<PyResult<Vec<_>>>()?;
    if request.steps {
        let codes = given.pop().and_then(|it| if let Picture::Codes(codes) = it { Some(codes) } else { None });
        let found = job::run(py, None, false, move |job| request.steps(codes, job))?;
        job::warn(py, found.note().as_slice())?;
        return Ok((serde_json::to_string(&found).map_err(error)?, codes_array(py, found.picture_dithered)?));
    }
    let given: Option<[Picture; 2]> = given.try_into().ok();
    let work = move |job: &Job| request.pair(given, job).map(|found| (found.map.enlarged(), found));
    let (map, found) = job::run(py, None, false, work)?;
    job::warn(py, found.note().as_slice())?;
    let [width, height] = found.map.size;
    let map = map.into_pyarray(py).reshape([height, width])?;
    Ok((serde_json::to_string(&found).map_err(error)?, map.into_any()))
}
