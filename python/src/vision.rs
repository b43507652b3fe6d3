//! What the model of vision predicts for stimuli, and how it compares pictures.

use machband::{
    light::{CodeImage, LinearImage, Samples},
    stimulus::Visible,
    work::{
        compare::{Compare, Compared, Given as Picture, Steps},
        predict::Predict,
    },
};
use numpy::{IntoPyArray as _, PyArrayMethods as _, PyReadonlyArray1};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    Fields, error, job,
    light::{Given, stimulus_of},
    request,
};

/// A picture with its height and width, red, green and blue for each pixel, as codes or as linear light.
#[derive(FromPyObject)]
pub enum Shown<'py> {
    Eight(PyReadonlyArray1<'py, u8>, (u32, u32)),
    Sixteen(PyReadonlyArray1<'py, u16>, (u32, u32)),
    Light(PyReadonlyArray1<'py, f32>, (u32, u32)),
}

impl Shown<'_> {
    fn picture(self) -> PyResult<Picture> {
        let codes = |(height, width), samples| Picture::Codes(CodeImage { width, height, samples });
        Ok(match self {
            Self::Eight(array, shape) => codes(shape, Samples::Eight(array.as_slice()?.to_vec())),
            Self::Sixteen(array, shape) => codes(shape, Samples::Sixteen(array.as_slice()?.to_vec())),
            Self::Light(array, (height, width)) => {
                Picture::Light(LinearImage { width, height, data: array.as_slice()?.to_vec() })
            }
        })
    }
}

/// Predicts the bands and the detection of a stimulus.
#[pyfunction]
pub fn predict<'py>(py: Python<'py>, fields: Fields, kind: &str, parameters: Given) -> PyResult<Bound<'py, PyDict>> {
    let (request, stimulus) = (request::<Predict>(fields)?, stimulus_of(kind, parameters)?);
    let found = job::run(py, None, false, move |job| request.one(Some(&stimulus), job))?;
    let (bands, difference) = match found.visible {
        Visible::Ramp(bands) => (Some(bands), None),
        Visible::Surface(difference) => (None, Some(difference)),
        Visible::Unknown => (None, None),
    };
    let dict = PyDict::new(py);
    dict.set_item("band_bright", bands.as_ref().map(|bands| bands.bright))?;
    dict.set_item("band_dark", bands.as_ref().map(|bands| bands.dark))?;
    dict.set_item("detection", found.detection)?;
    dict.set_item("difference", difference)?;
    dict.set_item("predicted_rating", found.rating)?;
    dict.set_item("blur_deg", bands.as_ref().map(|bands| bands.blur_deg))?;
    dict.set_item("at_deg", bands.map(|bands| (bands.at_deg[0], bands.at_deg[1])))?;
    Ok(dict)
}

/// Compares two pictures in memory, or otherwise the two files that the fields name.
#[pyfunction]
pub fn compare<'py>(
    py: Python<'py>,
    fields: Fields,
    given: Option<(Shown<'py>, Shown<'py>)>,
) -> PyResult<Bound<'py, PyDict>> {
    let request = request::<Compare>(fields)?;
    let given = given.map(|(a, b)| PyResult::Ok([a.picture()?, b.picture()?])).transpose()?;
    let found = job::run(py, None, false, move |job| request.pair(given, job))?;
    job::warn(py, found.note().as_slice())?;
    let Compared { times_threshold, center, places, map, size: [width, height], light, mean_ratio, .. } = found;
    let dict = PyDict::new(py);
    dict.set_item("times_threshold", times_threshold)?;
    dict.set_item("center", center)?;
    dict.set_item("places", places.iter().map(|at| (at.x, at.y, at.times_threshold)).collect::<Vec<_>>())?;
    dict.set_item("mean_ratio", mean_ratio)?;
    dict.set_item("map", map.into_pyarray(py).reshape([height, width])?)?;
    dict.set_item("light", light)?;
    Ok(dict)
}

/// Judges the steps between the codes of a picture in memory, or otherwise of the file that the fields name.
#[pyfunction]
pub fn steps<'py>(py: Python<'py>, fields: Fields, given: Option<Shown<'py>>) -> PyResult<Bound<'py, PyDict>> {
    let request = request::<Compare>(fields)?;
    let given = match given.map(Shown::picture).transpose()? {
        Some(Picture::Light(_)) => {
            return Err(error("picture is light, which has no codes; expected codes as uint8 or uint16"));
        }
        Some(Picture::Codes(codes)) => Some(codes),
        None => None,
    };
    let found = job::run(py, None, false, move |job| request.steps(given, job))?;
    job::warn(py, found.note().as_slice())?;
    let Steps { steps, rounded, dithered, picture_dithered, light, .. } = found;
    let dict = PyDict::new(py);
    dict.set_item("steps", steps)?;
    dict.set_item("rounded", rounded)?;
    dict.set_item("dithered", dithered)?;
    let shape = [picture_dithered.height as usize, picture_dithered.width as usize, 3];
    if let Samples::Eight(codes) = picture_dithered.samples {
        dict.set_item("picture", codes.into_pyarray(py).reshape(shape)?)?;
    }
    dict.set_item("light", light)?;
    Ok(dict)
}
