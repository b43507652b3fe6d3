//! The patches, in the order in which they are shown, and their readings: one luminance per patch. Readings are checked,
//! whether they are plausible for a display and agree with each other.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

use crate::{
    display::{channel::Channel, profile::LuminanceRange},
    statistics::shuffle,
};

/// One reading of one patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The lit channel, or all three for gray.
    pub channel: Channel,
    /// The encoded value, 0…1: the code divided by the largest code.
    pub level: f64,
    /// The photometer's reading, cd/m².
    pub luminance_cd_m2: f64,
}

impl Reading {
    /// Checks that a screen can give this reading.
    ///
    /// # Errors
    /// Returns the field that is wrong, and what is wrong with it.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let (level, light, [_, brightest]) = (self.level, self.luminance_cd_m2, LuminanceRange::WHITE_CD_M2);
        if !(0.0..=1.0).contains(&level) {
            let expected = "expected the code divided by the largest code";
            return Err(("level", format!("level {level} is outside 0…1; {expected}")));
        }
        if !(0.0..=brightest).contains(&light) {
            let expected = format!("expected cd/m², 0 to {brightest}");
            return Err(("luminance_cd_m2", format!("luminance {light} is not that of a screen; {expected}")));
        }
        Ok(())
    }
}

/// Levels closer than this are the same patch, entered twice.
const SAME_LEVEL: f64 = 1e-6;

/// True if two levels are the same patch.
pub fn is_same_level(a: f64, b: f64) -> bool {
    (a - b).abs() < SAME_LEVEL
}

/// Readings that passed the checks of [`Readings::new`]: there are enough of them, each is plausible, and the light
/// rises with the level. They are in the order in which they were taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    all: Vec<Reading>,
    channels: Vec<Channel>,
}

impl Readings {
    /// All readings in the order in which they were taken.
    pub fn all(&self) -> &[Reading] {
        &self.all
    }

    /// The channels that were read.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The mean at each level of a channel, from dark to light.
    pub fn means(&self, channel: Channel) -> Vec<Reading> {
        means(self.all.iter().filter(|one| one.channel == channel))
    }

    /// Luminance of black, cd/m²: the mean of the readings at level 0, which is the same patch in every channel.
    pub fn black_cd_m2(&self) -> f64 {
        means(self.all.iter()).first().map_or(0.0, |black| black.luminance_cd_m2)
    }

    /// The largest luminance, cd/m².
    pub fn largest_cd_m2(&self) -> f64 {
        self.all.iter().map(|one| one.luminance_cd_m2).fold(0.0, f64::max)
    }

    /// The step of the photometer's display, cd/m²: the largest power of ten, up to 100, of which every reading is a
    /// multiple; 0 if there is none down to 10⁻⁵.
    pub fn resolution_cd_m2(&self) -> f64 {
        let is_multiple = |steps: f64| (steps - steps.round()).abs() <= 1e-9 * steps.abs().max(1.0);
        let fits = |step: &f64| self.all.iter().all(|one| is_multiple(one.luminance_cd_m2 / step));
        (-2..=5).map(|digits| 10f64.powi(-digits)).find(fits).unwrap_or(0.0)
    }
}

/// Returns the mean at each level, from dark to light; the readings may be in any order.
fn means<'a>(readings: impl Iterator<Item = &'a Reading>) -> Vec<Reading> {
    let mut sorted: Vec<&Reading> = readings.collect();
    sorted.sort_by(|a, b| a.level.total_cmp(&b.level));
    let same = sorted.chunk_by(|a, b| is_same_level(a.level, b.level));
    same.map(|level| {
        let sum: f64 = level.iter().map(|one| one.luminance_cd_m2).sum();
        Reading { luminance_cd_m2: sum / level.len() as f64, ..*level[0] }
    })
    .collect()
}

/// The number of patches between two readings of white, which reveal drift.
const BETWEEN_WHITES: usize = 16;

/// A patch that the screen shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The lit channel, or all three for gray.
    pub channel: Channel,
    pub code: u8,
}

impl Patch {
    /// Returns the reading of this patch.
    pub fn reading(self, luminance_cd_m2: f64) -> Reading {
        Reading { channel: self.channel, level: f64::from(self.code) / 255.0, luminance_cd_m2 }
    }
}

/// Returns the patches in the order of measurement, which is always the same: every channel at `levels` levels, 2 to 256,
/// evenly spaced in encoded value, including 0 and 1; and each patch `repeats` times.
///
/// Every repeat shows each patch once, in a new random order, so that drift of the screen or the photometer affects all
/// levels and channels alike. Black is the same patch in every channel and comes once per repeat. White comes first,
/// last and after every 16 patches; its change is the drift.
///
/// # Errors
/// Returns an error if a profile cannot be made with these settings.
pub fn patches(channels: &[Channel], levels: usize, repeats: usize) -> Result<Vec<Patch>, String> {
    Channel::check_for_profile(channels)?;
    let code = |step: usize| (255.0 * step as f64 / (levels - 1) as f64).round() as u8;
    let patch = |channel: Channel, step: usize| Patch { channel, code: code(step) };
    let white_channel = if channels.contains(&Channel::Gray) { Channel::Gray } else { Channel::Green };
    let white = patch(white_channel, levels - 1);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut patches = vec![white];
    for _ in 0..repeats {
        let all = channels.iter().flat_map(|channel| (1..levels).map(|step| patch(*channel, step)));
        let mut round: Vec<Patch> = all.filter(|patch| *patch != white).collect();
        round.push(patch(white_channel, 0));
        shuffle(&mut round, &mut rng);
        for between in round.chunks(BETWEEN_WHITES) {
            patches.extend(between);
            patches.push(white);
        }
    }
    Ok(patches)
}

/// Minimum number of levels per channel, including 0 and 1.
pub const MIN_LEVELS: usize = 5;
/// The decrease that noise could explain: a share of the reading, steps of the photometer, and a share of the maximum
/// light.
const NOISE_FALL: (f64, f64, f64) = (0.05, 3.0, 5e-5);
/// The light has stopped rising at the top if its exponent there, which is 1 on a linear screen, is less than this. Levels
/// nearer to 1 than the second number do not tell it from noise.
const STOPPED: (f64, f64) = (0.35, 0.05);
/// The ratio by which the channel that should be dimmer must be brighter to indicate swapped channels.
const SWAPPED: f64 = 1.05;

impl Readings {
    /// Checks readings, given in the order in which they were taken.
    ///
    /// # Errors
    /// Returns all errors from the first check that fails: why a profile cannot be made, and what is expected.
    pub fn new(readings: Vec<Reading>) -> Result<Self, Vec<String>> {
        let read = |channel: &Channel| readings.iter().any(|one| one.channel == *channel);
        let readings = Self { channels: Channel::ALL.iter().copied().filter(read).collect(), all: readings };
        // Each check relies on the previous one.
        let checks = [reading_errors, set_errors, curve_errors, order_errors];
        let errors = checks.iter().map(|check| check(&readings)).find(|errors| !errors.is_empty());
        errors.map_or(Ok(readings), Err)
    }

    /// Says for each channel how far the light rises at the top, where it rises too little for a screen.
    pub fn hardly_rising(&self) -> Vec<String> {
        let said = |channel: &Channel| {
            let (means, (exponent, apart)) = (self.means(*channel), STOPPED);
            let (white, below) = (means.last()?, means.iter().rfind(|one| one.level <= 1.0 - apart)?);
            let [top, light] = [white, below].map(|at| at.luminance_cd_m2 - self.black_cd_m2());
            let percent = 100.0 * (white.luminance_cd_m2 / below.luminance_cd_m2 - 1.0);
            let level = (1e4 * below.level).round() / 1e4;
            let is_flat = (top / light).ln() < exponent * below.level.recip().ln();
            is_flat.then(|| format!("{channel}: the light rises by only {percent:.1} % above level {level}"))
        };
        self.channels().iter().filter_map(said).collect()
    }
}

/// Returns the errors in single readings, or an error if there is no light.
fn reading_errors(readings: &Readings) -> Vec<String> {
    let [darkest, _] = LuminanceRange::WHITE_CD_M2;
    let wrong = readings.all().iter().filter_map(|one| one.check().err());
    let mut errors: Vec<String> = wrong.map(|(_, message)| message).collect();
    if readings.all().is_empty() {
        errors.push(format!(
            "there are no readings; expected red, green and blue, or gray, at {MIN_LEVELS} levels or more"
        ));
    } else if readings.all().iter().all(|one| one.luminance_cd_m2 < darkest) {
        errors.push(format!(
            "every reading is below {darkest} cd/m²; expected light: is the photometer on the screen, and is its cap off?"
        ));
    }
    errors
}

/// Returns an error for each missing channel or level.
fn set_errors(readings: &Readings) -> Vec<String> {
    let expected = "expected red, green and blue, or gray, each from level 0 to 1";
    let read = readings.channels();
    let mut messages = Vec::new();
    if !read.contains(&Channel::Gray) && read.len() < 3 {
        let names: Vec<&str> = read.iter().map(|channel| channel.name()).collect();
        messages.push(format!("only these channels were read: {}; {expected}", names.join(", ")));
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
        if let Some(Reading { level, .. }) = means.last().filter(|last| last.level != 1.0) {
            messages.push(format!(
                "{channel}: no reading at level 1 (the highest is {level}); expected the maximum luminance of the \
                    channel"
            ));
        }
    }
    messages
}

/// Returns an error for each channel whose light falls, or does not rise at all.
fn curve_errors(readings: &Readings) -> Vec<String> {
    let black_cd_m2 = readings.black_cd_m2();
    let (share, steps, of_largest) = NOISE_FALL;
    let still = steps * readings.resolution_cd_m2() + of_largest * readings.largest_cd_m2();
    let mut errors = Vec::new();
    for channel in readings.channels() {
        let means = readings.means(*channel);
        let white_cd_m2 = means.last().map_or(0.0, |white| white.luminance_cd_m2);
        if white_cd_m2 <= black_cd_m2 * (1.0 + share) + still {
            errors.push(format!(
                "{channel}: level 1 gives {white_cd_m2} cd/m², no more than black ({black_cd_m2} cd/m²); expected light"
            ));
            continue;
        }
        let falls = |pair: &&[Reading]| pair[1].luminance_cd_m2 < pair[0].luminance_cd_m2 * (1.0 - share) - still;
        for pair in means.windows(2).filter(falls) {
            let [(lower, lower_cd_m2), (upper, upper_cd_m2)] =
                [pair[0], pair[1]].map(|at| (at.level, at.luminance_cd_m2));
            errors.push(format!(
                "{channel}: not monotone: level {upper} gives {upper_cd_m2} cd/m², less than the {lower_cd_m2} cd/m² of level {lower}; expected more light at every higher level: measure both again"
            ));
        }
    }
    errors
}

/// Returns an error if the channels' luminances at level 1 are not in the order gray > green > red > blue.
fn order_errors(readings: &Readings) -> Vec<String> {
    let falling = [Channel::Gray, Channel::Green, Channel::Red, Channel::Blue];
    let whites: Vec<(Channel, f64)> = (falling.into_iter())
        .filter_map(|channel| Some((channel, readings.means(channel).last()?.luminance_cd_m2)))
        .collect();
    if whites.windows(2).all(|pair| pair[1].1 <= pair[0].1 * SWAPPED) {
        return Vec::new();
    }
    let each: Vec<String> = whites.iter().map(|(channel, light)| format!("{channel} {light}")).collect();
    vec![format!(
        "swapped channels: level 1 gives {} cd/m²; expected more light from gray than from green, from green than from red, and from red than from blue, as on every screen",
        each.join(", ")
    )]
}

/// Returns the difference of gray from red + green + blue − 2·black, in percent of gray, at every level above 0 at which all
/// four were read, from dark to light.
pub fn additivity(readings: &Readings) -> Vec<f64> {
    let [red, green, blue, gray] =
        [Channel::Red, Channel::Green, Channel::Blue, Channel::Gray].map(|channel| readings.means(channel));
    let black = readings.black_cd_m2();
    let percent = |gray: &Reading| {
        let at = |means: &[Reading]| {
            means.iter().find(|mean| is_same_level(mean.level, gray.level)).map(|mean| mean.luminance_cd_m2)
        };
        let sum_cd_m2 = at(&red)? + at(&green)? + at(&blue)? - 2.0 * black;
        Some(100.0 * (gray.luminance_cd_m2 - sum_cd_m2) / gray.luminance_cd_m2)
    };
    gray.iter().filter(|gray| gray.level > 0.0 && gray.luminance_cd_m2 > 0.0).filter_map(percent).collect()
}

/// Returns the number farthest from 0; 0 if there is none.
pub fn largest_percent(percents: &[f64]) -> f64 {
    percents.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0)
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
