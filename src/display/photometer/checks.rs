//! Checks whether readings are plausible for a display and agree with each other, and describes the errors.

use super::readings::{LevelMean, Reading, Readings, is_same_level};
use crate::display::{channel::Channel, profile::LuminanceRange};

/// Minimum number of levels per channel, including 0 and 1.
pub const MIN_LEVELS: usize = 5;
/// The decrease that noise could explain: a share of the reading, steps of the photometer, and a share of the maximum
/// light.
const NOISE_FALL: (f64, f64, f64) = (0.05, 3.0, 5e-5);
/// The rise that noise could not hide, as a natural logarithm.
const CLEAR_RISE: f64 = 0.1;
/// The light has stopped rising if it rises by less than this share of the rise predicted from the levels below.
const STOPPED: f64 = 0.3;
/// What to do about light that rises too little at the top.
pub(super) const RAISE: &str =
    "lower the screen's contrast, turn off dynamic contrast, or set the photometer to a wider range";
/// The ratio by which the channel that should be dimmer must be brighter to indicate swapped channels.
const SWAPPED: f64 = 1.05;

/// The readings to which an error refers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ErrorLocation {
    /// The level of one reading, by its index.
    Level(usize),
    /// The luminance of one reading, by its index.
    Luminance(usize),
    /// Two levels of a channel, which may have been misread.
    Levels(Channel, [f64; 2]),
    /// All readings.
    All,
}

/// Why a profile cannot be made from the readings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ReadingsError {
    /// The readings that the error is about.
    pub location: ErrorLocation,
    /// The error, and what is expected instead.
    pub message: String,
}

impl ReadingsError {
    fn new(location: ErrorLocation, message: impl Into<String>) -> Self {
        Self { location, message: message.into() }
    }
}

impl Readings {
    /// Checks readings, given in the order in which they were taken.
    ///
    /// # Errors
    /// Returns all errors in single readings. If there are none, returns all errors from the first check of the whole
    /// set that fails.
    pub fn new(readings: Vec<Reading>) -> Result<Self, Vec<ReadingsError>> {
        let mut errors = reading_errors(&readings);
        let readings = Self::unchecked(readings);
        // Each check relies on the previous one.
        for check in [set_errors, curve_errors, order_errors] {
            if errors.is_empty() {
                errors = check(&readings);
            }
        }
        if errors.is_empty() { Ok(readings) } else { Err(errors) }
    }

    /// Says for each channel how far the light rises at the top, where it rises too little for a screen.
    pub fn hardly_rising(&self) -> Vec<String> {
        let said = |channel: &Channel| {
            let means = self.means(*channel);
            let (lowest, white) = (saturated_from(&means, self.black_cd_m2(), self.resolution_cd_m2())?, means.last()?);
            let percent = 100.0 * (white.luminance_cd_m2 / lowest.luminance_cd_m2 - 1.0);
            let level = (1e4 * lowest.level).round() / 1e4;
            Some(format!("{channel}: the light rises by only {percent:.1} % above level {level}"))
        };
        self.channels().iter().filter_map(said).collect()
    }
}

/// Returns the errors in single readings.
fn reading_errors(readings: &[Reading]) -> Vec<ReadingsError> {
    let codes = readings.iter().all(|one| (0.0..=255.0).contains(&one.level) && one.level.fract() == 0.0);
    let [darkest, brightest] = LuminanceRange::WHITE_CD_M2;
    let mut errors = Vec::new();
    for (index, Reading { level, luminance_cd_m2: light, .. }) in readings.iter().enumerate() {
        if !(0.0..=1.0).contains(level) {
            let message = match codes {
                true => format!(
                    "level {level} looks like a code of 0…255; expected a level of 0…1, the code divided by 255 ({:.4})",
                    level / 255.0
                ),
                false => format!("level {level} is outside 0…1; expected the code divided by the largest code"),
            };
            errors.push(ReadingsError::new(ErrorLocation::Level(index), message));
        }
        if !(0.0..=brightest).contains(light) {
            let message = format!("luminance {light} is not that of a screen; expected cd/m², 0 to {brightest}");
            errors.push(ReadingsError::new(ErrorLocation::Luminance(index), message));
        }
    }
    if readings.is_empty() {
        let message =
            format!("there are no readings; expected red, green and blue, or gray, at {MIN_LEVELS} levels or more");
        errors.push(ReadingsError::new(ErrorLocation::All, message));
    } else if readings.iter().all(|one| one.luminance_cd_m2 < darkest) {
        let message = format!(
            "every reading is below {darkest} cd/m²; expected light: is the photometer on the screen, and is its cap off?"
        );
        errors.push(ReadingsError::new(ErrorLocation::All, message));
    }
    errors
}

/// Returns an error for each missing channel or level.
fn set_errors(readings: &Readings) -> Vec<ReadingsError> {
    let expected = "expected red, green and blue, or gray, each from level 0 to 1";
    let read = readings.channels();
    let mut messages = Vec::new();
    match *read {
        _ if read.contains(&Channel::Gray) => {}
        [only] => messages
            .push(format!("single channel: only {only} was read, which does not determine the other two; {expected}")),
        [first, second] => {
            let missing = Channel::ALL.into_iter().find(|channel| !read.contains(channel)).unwrap_or(first);
            messages.push(format!("channel {missing} is missing: only {first} and {second} were read; {expected}"));
        }
        _ => {}
    }
    if !readings.all().iter().any(|one| one.level == 0.0) {
        messages.push("no reading at level 0; expected the screen's black, where every curve starts".to_owned());
    }
    for channel in read {
        let means = readings.means(*channel);
        if means.len() < MIN_LEVELS {
            messages.push(format!(
                "{channel}: too few levels: {}; expected {MIN_LEVELS} or more (9 are good, 17 better), including 0 and 1",
                means.len()
            ));
        }
        if let Some(LevelMean { level, .. }) = means.last().filter(|last| last.level != 1.0) {
            messages.push(format!(
                "{channel}: no reading at level 1 (the highest is {level}); expected the maximum luminance of the \
                    channel"
            ));
        }
    }
    messages.into_iter().map(|message| ReadingsError::new(ErrorLocation::All, message)).collect()
}

/// Returns an error for each channel whose light falls, or is the same at some level and at the highest one.
fn curve_errors(readings: &Readings) -> Vec<ReadingsError> {
    let black_cd_m2 = readings.black_cd_m2();
    let (share, steps, of_largest) = NOISE_FALL;
    let still = steps * readings.resolution_cd_m2() + of_largest * readings.largest_cd_m2();
    let mut errors = Vec::new();
    for channel in readings.channels() {
        let means = readings.means(*channel);
        let white_cd_m2 = means.last().map_or(0.0, |white| white.luminance_cd_m2);
        if white_cd_m2 <= black_cd_m2 * (1.0 + share) + still {
            let message = format!(
                "{channel}: level 1 gives {white_cd_m2} cd/m², no more than black ({black_cd_m2} cd/m²); expected light"
            );
            errors.push(ReadingsError::new(ErrorLocation::All, message));
            continue;
        }
        let falls = |pair: &&[LevelMean]| pair[1].luminance_cd_m2 < pair[0].luminance_cd_m2 * (1.0 - share) - still;
        let falling: Vec<&[LevelMean]> = means.windows(2).filter(falls).collect();
        for pair in &falling {
            let [(lower, lower_cd_m2), (upper, upper_cd_m2)] =
                [pair[0], pair[1]].map(|at| (at.level, at.luminance_cd_m2));
            let message = format!(
                "{channel}: not monotone: level {upper} gives {upper_cd_m2} cd/m², less than the {lower_cd_m2} cd/m² of level {lower}; expected more light at every higher level: measure both again"
            );
            errors.push(ReadingsError::new(ErrorLocation::Levels(*channel, [lower, upper]), message));
        }
        if falling.is_empty()
            && let Some(lowest) = saturated_from(&means, black_cd_m2, readings.resolution_cd_m2())
            && !means
                .iter()
                .skip_while(|one| one.level < lowest.level)
                .is_sorted_by(|a, b| a.luminance_cd_m2 < b.luminance_cd_m2)
        {
            let message = format!(
                "{channel}: saturated: the light stops rising at level {}, {} cd/m² there and {white_cd_m2} cd/m² at level 1; expected it to rise up to level 1: {RAISE}",
                lowest.level, lowest.luminance_cd_m2
            );
            errors.push(ReadingsError::new(ErrorLocation::Levels(*channel, [lowest.level, 1.0]), message));
        }
    }
    errors
}

/// Returns the lowest level at which the light has stopped rising, if any.
fn saturated_from(means: &[LevelMean], black_cd_m2: f64, resolution: f64) -> Option<LevelMean> {
    let (white, below) = means.split_last()?;
    let light = |at: &LevelMean| at.luminance_cd_m2 - black_cd_m2;
    let stopped = |at: &&LevelMean| {
        let is_half = |one: &&LevelMean| one.level > 0.0 && one.level <= at.level * 0.6 && light(one) > 0.0;
        let Some(half) = means.iter().rfind(is_half) else { return false };
        // The exponent of the rise up to this level, at least 1, which is the exponent of a linear display.
        let exponent = ((light(at) / light(half)).ln() / (at.level / half.level).ln()).clamp(1.0, 3.0);
        let promised = exponent * (1.0 / at.level).ln();
        // The readings are equal to the last digit, although a rise would have been visible.
        let same = white.luminance_cd_m2 == at.luminance_cd_m2 && promised * light(at) > 5.0 * resolution;
        same || promised >= CLEAR_RISE && (light(white) / light(at)).ln() < STOPPED * promised
    };
    // Only a flat top is saturation, so the search runs down from the highest level.
    let is_lit = |one: &&LevelMean| one.level > 0.0 && light(one) > 0.0;
    let level = below.iter().rev().take_while(is_lit).find(stopped)?;
    let lowest = below.iter().find(|one| (light(white) / light(one)).ln() < STOPPED * CLEAR_RISE);
    Some(*lowest.unwrap_or(level))
}

/// Returns an error if the channels' luminances at level 1 are not in the order gray > green > red > blue.
fn order_errors(readings: &Readings) -> Vec<ReadingsError> {
    let falling = [Channel::Gray, Channel::Green, Channel::Red, Channel::Blue];
    let whites: Vec<(Channel, f64)> = (falling.into_iter())
        .filter_map(|channel| Some((channel, readings.means(channel).last()?.luminance_cd_m2)))
        .collect();
    if whites.windows(2).all(|pair| pair[1].1 <= pair[0].1 * SWAPPED) {
        return Vec::new();
    }
    let mut sorted = whites.clone();
    sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
    let moved = whites.iter().zip(&sorted).filter(|(named, is)| named.0 != is.0).map(|(named, _)| named.0);
    let question = match moved.collect::<Vec<_>>()[..] {
        [one, other] => format!(": are {one} and {other} swapped?"),
        _ => String::new(),
    };
    let each: Vec<String> = whites.iter().map(|(channel, light)| format!("{channel} {light}")).collect();
    let message = format!(
        "swapped channels: level 1 gives {} cd/m²; expected more light from gray than from green, from green than from red, and from red than from blue, as on every screen{question}",
        each.join(", ")
    );
    vec![ReadingsError::new(ErrorLocation::All, message)]
}

/// Gray at one level, compared with the sum of its channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sum {
    /// Encoded value, 0…1.
    pub level: f64,
    /// The reading of gray, cd/m².
    pub gray_cd_m2: f64,
    /// Red + green + blue − 2·black, cd/m².
    pub sum_cd_m2: f64,
}

impl Sum {
    /// Gray minus the sum, cd/m².
    pub fn deviation_cd_m2(&self) -> f64 {
        self.gray_cd_m2 - self.sum_cd_m2
    }

    /// Gray minus the sum, in percent of gray.
    pub fn deviation_percent(&self) -> f64 {
        100.0 * self.deviation_cd_m2() / self.gray_cd_m2
    }
}

/// Compares gray with the sum of its channels at every level above 0 at which all four were read, from dark to light.
pub fn additivity(readings: &Readings) -> Vec<Sum> {
    let [red, green, blue, gray] = Channel::ALL.map(|channel| readings.means(channel));
    let black = readings.black_cd_m2();
    let sum = |gray: &LevelMean| {
        let at = |means: &[LevelMean]| {
            means.iter().find(|mean| is_same_level(mean.level, gray.level)).map(|mean| mean.luminance_cd_m2)
        };
        let sum_cd_m2 = at(&red)? + at(&green)? + at(&blue)? - 2.0 * black;
        Some(Sum { level: gray.level, gray_cd_m2: gray.luminance_cd_m2, sum_cd_m2 })
    };
    gray.iter().filter(|gray| gray.level > 0.0 && gray.luminance_cd_m2 > 0.0).filter_map(sum).collect()
}

/// Returns the deviation farthest from 0; 0 if `sums` is empty.
pub fn largest(sums: &[Sum], deviation: fn(&Sum) -> f64) -> f64 {
    sums.iter().map(deviation).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0)
}

/// Returns the change of white over the measurement in percent of its mean, from a straight line fitted to all readings
/// of white; `None` unless level 1 of some channel was read at least three times, spread over the measurement.
pub fn drift_percent(readings: &Readings) -> Option<f64> {
    let all = readings.all();
    let whites = |channel: &Channel| -> Vec<(f64, f64)> {
        let at = all.iter().enumerate().filter(|(_, one)| one.channel == *channel && one.level == 1.0);
        at.map(|(index, one)| (index as f64, one.luminance_cd_m2)).collect()
    };
    let whites = readings.channels().iter().map(whites).max_by_key(Vec::len)?;
    let n = whites.len() as f64;
    if n < 3.0 || whites.first()?.0 + n > whites.last()?.0 {
        return None;
    }
    let mean = |of: fn(&(f64, f64)) -> f64| whites.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|white| white.0), mean(|white| white.1));
    let spread: f64 = whites.iter().map(|white| (white.0 - x).powi(2)).sum();
    let slope = whites.iter().map(|white| (white.0 - x) * (white.1 - y)).sum::<f64>() / spread;
    Some(100.0 * slope * (all.len() - 1) as f64 / y)
}
