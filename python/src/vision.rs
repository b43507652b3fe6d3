//! Predicted visibility.

use machband::{
    light::{CodeImage, LinearImage, Samples},
    stimulus::StimulusPrediction,
    vision::{Polarity, Visibility},
    work::predict::{Predict, Prediction, Shown},
};
use numpy::{IntoPyArray as _, PyArrayMethods as _, PyReadonlyArray1};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    Fields, job,
    light::{Given, stimulus_of},
    request,
};

/// A band of a line that is less visible than this is rounding error.
const LEAST: f64 = 0.01;

/// What is shown: a kind with its parameters; or an image with its height and width, red, green and blue for each pixel,
/// as codes or as linear light.
#[derive(FromPyObject)]
pub enum Subject<'py> {
    Stimulus(String, Given),
    Eight(PyReadonlyArray1<'py, u8>, (u32, u32)),
    Sixteen(PyReadonlyArray1<'py, u16>, (u32, u32)),
    Light(PyReadonlyArray1<'py, f32>, (u32, u32)),
}

impl Subject<'_> {
    fn shown(self) -> PyResult<Shown> {
        let codes = |(height, width), samples| Shown::Codes(CodeImage { width, height, samples });
        Ok(match self {
            Self::Stimulus(kind, parameters) => Shown::Stimulus(stimulus_of(&kind, parameters)?),
            Self::Eight(array, shape) => codes(shape, Samples::Eight(array.as_slice()?.to_vec())),
            Self::Sixteen(array, shape) => codes(shape, Samples::Sixteen(array.as_slice()?.to_vec())),
            Self::Light(array, (height, width)) => {
                Shown::Light(LinearImage { width, height, data: array.as_slice()?.to_vec() })
            }
        })
    }
}

/// Predicts the bands in what is given, or otherwise in the image file that the fields name.
#[pyfunction]
pub fn predict<'py>(py: Python<'py>, fields: Fields, given: Option<Subject<'py>>) -> PyResult<Bound<'py, PyDict>> {
    let (request, shown) = (request::<Predict>(fields)?, given.map(Subject::shown).transpose()?);
    let found = job::run(py, None, false, move |job, _| request.one(shown, job))?;
    let both = |Visibility { bright, dark }| (bright, dark);
    let dict = PyDict::new(py);
    dict.set_item("visibility", found.view.visibility().max())?;
    dict.set_item("detection", found.detection)?;
    dict.set_item("predicted_rating", found.rating)?;
    dict.set_item("bands", both(found.view.visibility()))?;
    dict.set_item("lines", both(found.view.lines()))?;
    let Prediction { view, size: [width, height], .. } = found;
    let (along, map) = match view {
        StimulusPrediction::Line(view) => {
            let bands = view.bands.into_iter().filter(|band| band.strength >= LEAST);
            let bands = bands.map(|band| (band.at_deg, band.strength, band.polarity == Polarity::Bright));
            (Some(bands.collect::<Vec<_>>()), None)
        }
        StimulusPrediction::Picture(view) => {
            let array = |map: Vec<f64>| map.into_pyarray(py).reshape([height as usize, width as usize]);
            (None, Some((array(view.map.bright)?, array(view.map.dark)?)))
        }
    };
    dict.set_item("along", along)?;
    dict.set_item("map", map)?;
    Ok(dict)
}
