//! A display measured with a photometer: the fitted models, the chosen model, and warnings.

use super::{
    fit::{ASSUMED_NOISE, Curve, Family, Sample, fit},
    readings::{Readings, additivity, drift_percent},
};
use crate::{
    display::{
        channel::Channel,
        profile::{DisplayProfile, LuminanceRange, Measurement},
    },
    light::{Transfer, Transfers},
    statistics::Z_95,
};

/// The standard error of γ above which more readings are advised.
const UNCERTAIN_GAMMA: f64 = 0.01;
/// The misfit above which readings are unsteady.
const UNSTEADY: f64 = 0.03;
/// The deviation from additivity, in percent of white, above which the channels of a display are not independent.
const ADDITIVE_PERCENT: f64 = 5.0;
/// The change of white, in percent, above which a longer warm-up is advised.
const DRIFT_PERCENT: f64 = 2.0;
/// The expected squared error of a table at a level that was left out, relative to the noise: 1 from the reading
/// itself, and 0.5 from the mean of its two neighbors.
const TABLE_SQUARE: f64 = 1.5;
/// The maximum error of a simpler model, relative to the smallest error. It applies regardless of the standard error,
/// which is poorly known if there are few levels.
const MAX_ERROR_RATIO: f64 = 1.5;
/// Mean squared errors below this, in units of the assumed noise, count as 0.
const EXACT: f64 = 1e-8;

/// Maximum number of readings × fits in the validation of a model, which keeps its time constant. One reading at each
/// of 256 levels, or two at 50 levels of four channels, stay within this limit. With more readings, several levels that
/// are far apart are left out at once.
const MAX_VALIDATION: usize = 100_000;

/// A model fitted to readings.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedModel {
    /// The family of its curves.
    pub family: Family,
    /// The channels that were read, in the order of [`Readings::channels`].
    pub channels: Vec<FittedChannel>,
    /// How well the model predicts levels that it was not fitted to: root mean square error, in 8-bit codes. Each level
    /// except 0 and 1 is left out in turn, because no model can predict black and white without readings.
    pub rms_codes: f64,
    /// The squared error at each of these levels of each channel, in a fixed order and in units of the assumed noise.
    squares: Vec<f64>,
    /// How far the readings are from this model: the root mean square, relative to the light. It is their noise if the
    /// model is correct.
    pub misfit: f64,
}

/// One channel of a fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedChannel {
    /// The channel.
    pub channel: Channel,
    /// The fitted curve.
    pub curve: Curve,
    /// R² = 1 − Σ(L − fit)²/Σ(L − mean)², with luminances in cd/m².
    pub r_squared: f64,
    /// Largest difference between a reading and the curve, in 8-bit codes.
    pub largest_codes: f64,
}

/// A display as measured with a photometer.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    pub readings: Readings,
    /// One model of each family, in the order of [`Family::ALL`].
    pub models: Vec<FittedModel>,
    /// The model to use: the one that cross-validation prefers.
    pub chosen: Family,
    /// How far gray is from the sum of the channels, in percent, level by level, if all were read.
    pub additivity: Vec<f64>,
    /// Change of white during the measurement in percent, if it was read repeatedly.
    pub drift_percent: Option<f64>,
    /// Warnings that do not prevent the profile from being used.
    pub notes: Vec<String>,
}

impl Calibration {
    /// Fits all models to the readings and chooses one.
    pub fn new(readings: &Readings) -> Self {
        let sample = Sample::new(readings);
        // One shape for all channels, or one for each, whichever predicts better.
        let best = |family: &Family| {
            let is_one = *family == Family::Srgb || sample.channels.len() == 1;
            let variants: &[bool] = if is_one { &[true] } else { &[true, false] };
            let mut models: Vec<_> = variants.iter().map(|shared| model(*family, *shared, &sample)).collect();
            models.swap_remove(simplest_of_the_best(&models))
        };
        let models: Vec<FittedModel> = Family::ALL.iter().map(best).collect();
        let mut calibration = Self {
            readings: readings.clone(),
            chosen: models[simplest_of_the_best(&models)].family,
            models,
            additivity: additivity(readings),
            drift_percent: drift_percent(readings),
            notes: Vec::new(),
        };
        calibration.notes = notes(&calibration);
        calibration
    }

    pub fn model(&self, family: Family) -> &FittedModel {
        // `models` has one model of each family, in this order.
        &self.models[Family::ALL.iter().position(|one| *one == family).unwrap_or(0)]
    }

    /// Returns why there is no profile unless a table was asked for: the light hardly rises at the top. That may be how the
    /// screen is, or a fault.
    pub fn refusal(&self, asked: Option<Family>) -> Option<String> {
        let hardly = self.readings.hardly_rising().join("; ");
        let is_refused = asked != Some(Family::Table) && !hardly.is_empty();
        is_refused.then(|| {
            format!(
                "{hardly}; expected more (lower the screen's contrast, turn off dynamic contrast, or set the photometer to a \
                 wider range), or --model table of machband calibrate, if the screen is like that"
            )
        })
    }

    /// Returns black and white according to a model, in cd/m².
    pub fn luminance_of(&self, family: Family) -> LuminanceRange {
        let channels = &self.model(family).channels;
        if let Some(gray) = channels.iter().find(|one| one.channel == Channel::Gray) {
            return LuminanceRange { black_cd_m2: gray.curve.black_cd_m2, white_cd_m2: gray.curve.cd_m2(1.0) };
        }
        let sum = |of: fn(&Curve) -> f64| channels.iter().map(|one| of(&one.curve)).sum::<f64>();
        let black_cd_m2 = sum(|curve| curve.black_cd_m2) / channels.len() as f64;
        LuminanceRange { black_cd_m2, white_cd_m2: black_cd_m2 + sum(|curve| curve.range_cd_m2) }
    }

    /// Returns the transfer functions of a model. A channel that was not read gets the transfer function of gray.
    pub fn transfers(&self, family: Family) -> Transfers {
        let channels = &self.model(family).channels;
        let read = |wanted: Channel| channels.iter().find(|one| one.channel == wanted);
        let of = |channel: Channel| {
            let found = read(channel).or_else(|| read(Channel::Gray));
            found.map_or(Transfer::Srgb, |one| one.curve.transfer.clone())
        };
        Transfers::new([of(Channel::Red), of(Channel::Green), of(Channel::Blue)])
    }

    /// Returns the display profile according to a model.
    pub fn profile(&self, family: Family, name: &str, measured: Measurement) -> DisplayProfile {
        DisplayProfile {
            name: name.to_owned(),
            transfers: self.transfers(family),
            luminance: Some(self.luminance_of(family)),
            measured: Some(measured),
            ..DisplayProfile::default()
        }
    }
}

/// Fits the model of a family, with one shape for all channels if `shared`, and otherwise one for each.
fn model(family: Family, shared: bool, sample: &Sample) -> FittedModel {
    let full = fit(family, shared, sample, None);
    let (codes, squares) = validate(sample, |rest| fit(family, shared, rest, Some(&full)).curves);
    let square = if family == Family::Table { mean(&squares) / TABLE_SQUARE } else { full.variance };
    let channels = sample.channels.iter().zip(&full.curves);
    FittedModel {
        family,
        channels: channels.map(|(channel, curve)| fitted_channel(sample, *channel, curve)).collect(),
        rms_codes: mean(&codes).sqrt(),
        squares,
        misfit: ASSUMED_NOISE * square.sqrt(),
    }
}

/// Leaves out one level at a time, or several if there are very many, and predicts it; `fitted_to` fits the model to
/// the rest. Returns the squared errors in codes, and in units of the assumed noise.
fn validate(sample: &Sample, fitted_to: impl Fn(&Sample) -> Vec<Curve>) -> (Vec<f64>, Vec<f64>) {
    let (mut codes, mut squares) = (Vec::new(), Vec::new());
    let levels = sample.inner_levels();
    let fits = (MAX_VALIDATION / sample.points.len().max(1)).clamp(10, levels.len().max(10));
    for fit in 0..fits.min(levels.len()) {
        let left_out: Vec<f64> = levels.iter().skip(fit).step_by(fits).copied().collect();
        let curves = fitted_to(&sample.without(&left_out));
        let cells = left_out.iter().flat_map(|level| sample.channels.iter().zip(&curves).map(move |one| (*level, one)));
        for (level, (channel, curve)) in cells {
            let Some((y, sd)) = sample.mean(*channel, level) else { continue };
            codes.push((255.0 * (curve.encoded(y) - level)).powi(2));
            squares.push(((y - curve.cd_m2(level)) / sd).powi(2));
        }
    }
    (codes, squares)
}

/// Returns the index of the model to use; `models` are in order of complexity, starting with the simplest. It is the
/// simplest model whose error is within one standard error of the smallest error (Hastie, Tibshirani & Friedman 2009,
/// The Elements of Statistical Learning, §7.10) and at most [`MAX_ERROR_RATIO`] times the smallest. The standard error
/// is the standard error of the difference at the same levels.
fn simplest_of_the_best(models: &[FittedModel]) -> usize {
    let Some(least) = models.iter().min_by(|a, b| mean(&a.squares).total_cmp(&mean(&b.squares))) else { return 0 };
    let bound = MAX_ERROR_RATIO.powi(2) * mean(&least.squares).max(EXACT);
    let is_as_good = |model: &FittedModel| {
        let differences: Vec<f64> = model.squares.iter().zip(&least.squares).map(|(a, b)| a - b).collect();
        let (n, excess, square) = (differences.len() as f64, mean(&differences), mean(&model.squares));
        let variance = differences.iter().map(|d| (d - excess).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        square <= EXACT || excess <= (variance / n).sqrt() && square <= bound
    };
    models.iter().position(is_as_good).unwrap_or(0)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn fitted_channel(sample: &Sample, channel: Channel, curve: &Curve) -> FittedChannel {
    let read = || sample.points.iter().filter(|point| point.channel == channel);
    let mean = read().map(|point| point.y).sum::<f64>() / read().count() as f64;
    let square = |of: &dyn Fn(f64, f64) -> f64| read().map(|point| of(point.v, point.y).powi(2)).sum::<f64>();
    let codes = read().map(|point| 255.0 * (curve.encoded(point.y) - point.v).abs());
    FittedChannel {
        channel,
        r_squared: 1.0 - square(&|v, y| y - curve.cd_m2(v)) / square(&|_, y| y - mean),
        largest_codes: codes.fold(0.0, f64::max),
        curve: curve.clone(),
    }
}

fn notes(calibration: &Calibration) -> Vec<String> {
    let mut notes = calibration.readings.hardly_rising();
    let read = calibration.readings.channels();
    let unread: Vec<&str> =
        Channel::ALL[..3].iter().filter(|channel| !read.contains(channel)).map(|channel| channel.name()).collect();
    if !unread.is_empty() {
        notes.push(format!("{} not measured: assumed to have the curve of gray", unread.join(", ")));
    }
    let white = calibration.additivity.last().copied();
    if let Some(percent) = white.filter(|percent| percent.abs() > ADDITIVE_PERCENT) {
        notes.push(format!(
            "channels not additive: white differs from red + green + blue by {percent:+.1} %; colors other than grays will be off (limit {ADDITIVE_PERCENT} %)"
        ));
    }
    if let Some(percent) = calibration.drift_percent.filter(|percent| percent.abs() > DRIFT_PERCENT) {
        notes.push(format!(
            "white changed by {percent:+.1} % during the measurement: let the screen warm up for half an hour"
        ));
    }
    if calibration.chosen == Family::Table {
        notes.push("no curve fits the readings within their noise, so the table is used".to_owned());
    }
    let chosen = calibration.model(calibration.chosen);
    let errors = chosen.channels.iter().filter_map(|channel| channel.curve.gamma_se);
    let largest = errors.fold(0.0, f64::max);
    if largest > UNCERTAIN_GAMMA {
        notes.push(format!(
            "gamma is uncertain by ±{:.3} (95 %): use more levels, or several readings per level",
            Z_95 * largest
        ));
    }
    if chosen.misfit > UNSTEADY {
        notes.push(format!(
            "readings differ from the chosen model by {:.1} %: use a steadier photometer, or take several readings per level",
            100.0 * chosen.misfit
        ));
    }
    notes
}
