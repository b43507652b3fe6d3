//! Predicted visibility.

use std::path::PathBuf;

use machband::{
    light::{CodeImage, LinearImage, Samples, Transfers},
    stimulus::{StimulusPrediction, ViewingConditions},
    store,
    vision::{BandMap, Criterion, PicturePrediction, Polarity, Visibility},
};
use numpy::{IntoPyArray as _, PyArrayMethods as _, PyReadonlyArray1};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    error, job,
    light::{Given, stimulus_of, transfers_of},
};

/// The width of the picture in degrees, or the pixels per degree; the luminance of white; and a display profile, which
/// may have one.
#[derive(FromPyObject)]
pub struct View(Option<f64>, Option<f64>, Option<f64>, Option<PathBuf>);

impl View {
    /// Returns the conditions for a picture of this width.
    fn conditions(&self, width_px: u32) -> PyResult<ViewingConditions> {
        let View(window_deg, ppd, white, ref display) = *self;
        for (name, value) in [("window_deg", window_deg), ("ppd", ppd), ("white", white)] {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(error(format!("{name} {value} is invalid; expected a number above 0")));
            }
        }
        let of_ppd = ppd.map(|ppd| f64::from(width_px) / ppd);
        let profile = display.as_deref().map(store::profile::open).transpose().map_err(error)?;
        let of_profile = profile.and_then(|profile| profile.luminance).map(|range| range.white_cd_m2);
        Ok(ViewingConditions {
            window_deg: window_deg.or(of_ppd).unwrap_or(10.0),
            white_cd_m2: white.or(of_profile).unwrap_or(ViewingConditions::WHITE_CD_M2),
        })
    }
}

/// A band of a line that is less visible than this is rounding error.
const LEAST: f64 = 0.01;

/// What is predicted for a stimulus or an image.
struct Predicted {
    visibility: Visibility,
    lines: Visibility,
    detection: f64,
    /// Of a line: position, strength and sign of each band.
    bands: Option<Vec<(f64, f64, bool)>>,
    map: Option<(BandMap, [usize; 2])>,
}

impl Predicted {
    fn of_picture(view: PicturePrediction, detection: f64, shape: [usize; 2]) -> Self {
        let PicturePrediction { visibility, lines, map, .. } = view;
        Self { visibility, lines, detection, bands: None, map: Some((map, shape)) }
    }

    fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let dict = PyDict::new(py);
        let strongest = self.visibility.max();
        dict.set_item("visibility", strongest)?;
        dict.set_item("detection", self.detection)?;
        dict.set_item("predicted_rating", Criterion::default().mean(strongest))?;
        dict.set_item("bands", (self.visibility.bright, self.visibility.dark))?;
        dict.set_item("lines", (self.lines.bright, self.lines.dark))?;
        dict.set_item("along", self.bands)?;
        let map = self.map.map(|(BandMap { bright, dark }, shape)| {
            let array = |map: Vec<f64>| map.into_pyarray(py).reshape(shape);
            Ok::<_, PyErr>((array(bright)?, array(dark)?))
        });
        dict.set_item("map", map.transpose()?)?;
        Ok(dict)
    }
}

/// Predicts the bands in a stimulus; without a size, in the one that the command chooses.
#[pyfunction]
pub fn predict_stimulus<'py>(
    py: Python<'py>,
    kind: &str,
    parameters: Given,
    size: Option<u32>,
    view: View,
) -> PyResult<Bound<'py, PyDict>> {
    let stimulus = stimulus_of(kind, parameters)?;
    let most =
        if stimulus.is_line() { machband::stimulus::recipe::MAX_SIZE } else { ViewingConditions::MAX_PICTURE_PX };
    let size = size.unwrap_or_else(|| ViewingConditions::px(&stimulus));
    if !(16..=most).contains(&size) {
        return Err(error(format!("size {size} is outside 16…{most} for {}; expected pixels", stimulus.kind())));
    }
    let viewing = view.conditions(size)?;
    let predicted = job::run(py, None, false, move |_, _| {
        let wrong = |error| anyhow::anyhow!("{}: {error}", stimulus.kind());
        let detection = viewing.detection(&stimulus).map_err(wrong)?;
        Ok(match viewing.predict(&stimulus, size).map_err(wrong)? {
            StimulusPrediction::Picture(view) => Predicted::of_picture(*view, detection, [size as usize; 2]),
            StimulusPrediction::Line(view) => Predicted {
                visibility: view.visibility,
                lines: view.lines,
                detection,
                bands: Some(
                    view.bands
                        .iter()
                        .filter(|band| band.strength >= LEAST)
                        .map(|band| (band.at_deg, band.strength, band.polarity == Polarity::Bright))
                        .collect(),
                ),
                map: None,
            },
        })
    })?;
    predicted.into_dict(py)
}

/// Codes of 8 or 16 bits.
#[derive(FromPyObject)]
pub enum Codes<'py> {
    Eight(PyReadonlyArray1<'py, u8>),
    Sixteen(PyReadonlyArray1<'py, u16>),
}

/// Predicts the bands in an image of codes, red, green and blue for each pixel.
#[pyfunction]
pub fn predict_codes<'py>(
    py: Python<'py>,
    codes: Codes<'py>,
    shape: (u32, u32),
    transfer: Option<String>,
    view: View,
) -> PyResult<Bound<'py, PyDict>> {
    let (transfers, _) = transfers_of(transfer.as_deref(), view.3.as_ref())?;
    let samples = match codes {
        Codes::Eight(codes) => Samples::Eight(codes.as_slice()?.to_vec()),
        Codes::Sixteen(codes) => Samples::Sixteen(codes.as_slice()?.to_vec()),
    };
    let image = CodeImage { width: shape.1, height: shape.0, samples };
    picture(py, view.conditions(shape.1)?, transfers, move |transfers| Ok(image.light(&transfers)))
}

/// Predicts the bands in an image of linear light, red, green and blue for each pixel.
#[pyfunction]
pub fn predict_light<'py>(
    py: Python<'py>,
    light: PyReadonlyArray1<'py, f32>,
    shape: (u32, u32),
    view: View,
) -> PyResult<Bound<'py, PyDict>> {
    let image = LinearImage { width: shape.1, height: shape.0, data: light.as_slice()?.to_vec() };
    picture(py, view.conditions(shape.1)?, transfers_of(None, None)?.0, move |_| Ok(image))
}

/// Predicts the bands in an image file. Unless the codes' meaning is given, it is what the file says.
#[pyfunction]
pub fn predict_file<'py>(
    py: Python<'py>,
    path: PathBuf,
    transfer: Option<String>,
    view: View,
    most_pixels: u64,
) -> PyResult<Bound<'py, PyDict>> {
    let is_given = transfer.is_some() || view.3.is_some();
    let (transfers, _) = transfers_of(transfer.as_deref(), view.3.as_ref())?;
    let width = store::image::width(&path).map_err(error)?;
    let read =
        move |transfers: Transfers| Ok(store::image::read_light(&path, is_given.then_some(&transfers), most_pixels)?);
    picture(py, view.conditions(width)?, transfers, read)
}

fn picture<'py>(
    py: Python<'py>,
    viewing: ViewingConditions,
    transfers: Transfers,
    image: impl FnOnce(Transfers) -> anyhow::Result<LinearImage> + Send + 'static,
) -> PyResult<Bound<'py, PyDict>> {
    let predicted = job::run(py, None, false, move |_, _| {
        let image = image(transfers)?;
        let wrong = |error| anyhow::anyhow!("image: {error}");
        let view = viewing.predict_image(&image).map_err(wrong)?;
        let detection = viewing.detection_of_image(&image).map_err(wrong)?;
        Ok(Predicted::of_picture(view, detection, [image.height as usize, image.width as usize]))
    })?;
    predicted.into_dict(py)
}
