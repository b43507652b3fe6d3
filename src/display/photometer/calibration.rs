//! Everything that readings say of a display.

use super::{
    additivity::Additivity,
    bend,
    fit::Fit,
    model::Black,
    noise::{self, Noise},
    note::{self, Note},
    plan::Drift,
    reading::Channel,
    readings::Readings,
    response::Response,
    sample::Sample,
    select::Families,
    shape::{Family, Shape},
    validation::{self, CrossValidation},
};
use crate::{
    display::profile::{DisplayProfile, LuminanceRange, Measurement},
    light::{TransferError, Transfers},
};

/// A model fitted to readings.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedModel {
    /// Which curves.
    pub family: Family,
    /// Whether the channels share one shape.
    pub common_shape: bool,
    /// For a table: whether it differs from the best curve.
    pub bent: bool,
    /// The channels that were read, in the order of [`Readings::channels`].
    pub channels: Vec<FittedChannel>,
    /// Prediction of levels left out; `None` where none lies between 0 and 1.
    pub validation: Option<CrossValidation>,
}

/// One channel of a fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedChannel {
    /// Which one.
    pub channel: Channel,
    /// The fitted light.
    pub response: Response,
    /// Of a curve: γ, gain and offset.
    pub shape: Option<Shape>,
    /// Standard error of γ, where there is one.
    pub gamma_se: Option<f64>,
    /// 1 − Σ(L − fit)²/Σ(L − mean)², luminances in cd/m².
    pub r_squared: f64,
    /// Largest difference of a reading from the curve, 8-bit codes.
    pub largest_codes: f64,
    /// Largest difference of a reading from the curve, cd/m².
    pub largest_cd_m2: f64,
}

/// A display as measured with a photometer.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// What it was made from.
    pub readings: Readings,
    /// Noise of the readings.
    pub noise: Noise,
    /// sRGB, gamma, GOG, table.
    pub models: Vec<FittedModel>,
    /// The model to use: the simplest that the readings do not speak against.
    pub chosen: Family,
    /// The model that cross-validation calls better, by the rule of one standard error.
    pub better: Family,
    /// Gray against the sum of the channels, where all were read.
    pub additivity: Option<Additivity>,
    /// Black and white.
    pub luminance: LuminanceRange,
    /// Change of white during the measurement, where it was read again.
    pub drift: Option<Drift>,
    /// What the reader should know.
    pub notes: Vec<Note>,
}

impl Calibration {
    /// Fits all models to readings.
    ///
    /// # Errors
    /// When a fitted curve is no display's.
    pub fn new(readings: &Readings) -> Result<Self, TransferError> {
        let mut sample = Sample::new(readings);
        let noise = noise::weigh(&mut sample);
        let families = Families::new(&sample);
        let best = families.best();
        let curves = bend::with_read_black(&sample, &best.curves);
        let stiffness = bend::stiffness(&bend::shifts(&sample, &curves));
        let mut models: Vec<FittedModel> = [Family::Srgb, Family::Gamma, Family::Gog]
            .map(|family| curve_model(readings, &sample, families.of(family)))
            .into();
        models.push(table_model(readings, &sample, best, stiffness)?);
        let validations: Vec<_> = models.iter().map(|model| (model.family, model.validation.as_ref())).collect();
        let chosen = if stiffness.is_some() { Family::Table } else { best.model.family };
        let better = validation::better(&validations).unwrap_or(chosen);
        let own_black = matches!(best.model.black, Black::Own | Black::OwnOffset);
        let mut calibration = Self {
            readings: readings.clone(),
            noise,
            models,
            chosen,
            better,
            additivity: Additivity::new(readings),
            luminance: LuminanceRange { black_cd_m2: 0.0, white_cd_m2: 0.0 },
            drift: Drift::of(readings),
            notes: Vec::new(),
        };
        calibration.luminance = calibration.luminance_of(chosen);
        calibration.notes = note::all(&calibration, own_black);
        Ok(calibration)
    }

    /// A fitted model.
    #[must_use]
    pub fn model(&self, family: Family) -> &FittedModel {
        // The order is that of Family::ALL.
        &self.models[Family::ALL.iter().position(|one| *one == family).unwrap_or(0)]
    }

    /// Black and white by a model, cd/m².
    #[must_use]
    pub fn luminance_of(&self, family: Family) -> LuminanceRange {
        let channels = &self.model(family).channels;
        let gray = channels.iter().find(|one| one.channel == Channel::Gray);
        let black_cd_m2 = match gray {
            Some(gray) => gray.response.black_cd_m2(),
            None => channels.iter().map(|one| one.response.black_cd_m2()).sum::<f64>() / channels.len() as f64,
        };
        let range: f64 = match gray {
            Some(gray) => gray.response.range_cd_m2(),
            None => channels.iter().map(|one| one.response.range_cd_m2()).sum(),
        };
        LuminanceRange { black_cd_m2, white_cd_m2: black_cd_m2 + range }
    }

    /// The transfer functions of a model. A channel that was not read has gray's.
    ///
    /// # Errors
    /// When a fitted curve is no display's.
    pub fn transfers(&self, family: Family) -> Result<Transfers, TransferError> {
        let model = self.model(family);
        let of = |channel: Channel| {
            let read = |wanted: Channel| model.channels.iter().find(|one| one.channel == wanted);
            match read(channel).or_else(|| read(Channel::Gray)) {
                Some(one) => one.response.transfer(),
                None => Shape::Srgb.transfer(),
            }
        };
        Ok(Transfers::new([of(Channel::Red)?, of(Channel::Green)?, of(Channel::Blue)?]))
    }

    /// The display profile by a model.
    ///
    /// # Errors
    /// When a fitted curve is no display's.
    pub fn profile(&self, family: Family, name: &str, measured: Measurement) -> Result<DisplayProfile, TransferError> {
        Ok(DisplayProfile {
            name: name.to_owned(),
            transfers: self.transfers(family)?,
            luminance: Some(self.luminance_of(family)),
            measured: Some(measured),
            ..DisplayProfile::default()
        })
    }
}

fn curve_model(readings: &Readings, sample: &Sample, fit: &Fit) -> FittedModel {
    let scale = (fit.deviance / fit.freedom().max(1.0)).sqrt();
    let covariance = fit.covariance(sample, scale);
    let channels = (fit.curves.iter().zip(readings.channels()).enumerate())
        .map(|(index, (curve, channel))| {
            let gamma_se =
                fit.model.gamma_at(index).zip(covariance.as_ref()).map(|(at, all)| all[(at, at)].max(0.0).sqrt());
            fitted(sample, index, *channel, Response::Curve(*curve), Some(curve.shape), gamma_se)
        })
        .collect();
    FittedModel {
        family: fit.model.family,
        common_shape: fit.model.pooled,
        bent: false,
        channels,
        validation: validation::validate(sample, fit),
    }
}

fn table_model(
    readings: &Readings,
    sample: &Sample,
    best: &Fit,
    stiffness: Option<bend::Stiffness>,
) -> Result<FittedModel, TransferError> {
    let curves = bend::with_read_black(sample, &best.curves);
    let bent = stiffness.and_then(|stiffness| validation::bent(sample, &curves, stiffness));
    let responses = match &bent {
        Some(bent) => bent.clone(),
        None => {
            let straight = best.curves.iter().map(|curve| Response::bent(curve, &bend::Bend::default()));
            straight.collect::<Result<_, _>>()?
        }
    };
    let channels = (responses.into_iter().zip(readings.channels()).enumerate())
        .map(|(index, (response, channel))| fitted(sample, index, *channel, response, None, None))
        .collect();
    let validation = match stiffness {
        Some(stiffness) => validation::validate_bent(sample, best, stiffness),
        None => validation::validate(sample, best),
    };
    let common_shape = best.model.pooled && stiffness.is_none_or(|stiffness| stiffness.common);
    Ok(FittedModel { family: Family::Table, common_shape, bent: bent.is_some(), channels, validation })
}

fn fitted(
    sample: &Sample,
    index: usize,
    channel: Channel,
    response: Response,
    shape: Option<Shape>,
    gamma_se: Option<f64>,
) -> FittedChannel {
    let read: Vec<(f64, f64)> =
        sample.points.iter().filter(|point| point.channel == index).map(|point| (point.v, point.y)).collect();
    let mean = read.iter().map(|(_, y)| y).sum::<f64>() / read.len() as f64;
    let (mut left, mut all) = (0.0, 0.0);
    let (mut largest_codes, mut largest_cd_m2) = (0.0f64, 0.0f64);
    for (v, y) in read {
        let error = y - response.cd_m2(v);
        (left, all) = (left + error * error, all + (y - mean).powi(2));
        largest_cd_m2 = largest_cd_m2.max(error.abs());
        largest_codes = largest_codes.max(255.0 * (response.encoded(y) - v).abs());
    }
    FittedChannel { channel, response, shape, gamma_se, r_squared: 1.0 - left / all, largest_codes, largest_cd_m2 }
}
