//! In which order patches are shown, and what repeated whites say.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

use super::{
    fault::LEAST_LEVELS,
    reading::{Channel, Reading},
    readings::Readings,
};
use crate::light::shuffle::shuffle;

/// How an order follows from a seed. Changing what this names changes the order.
pub const GENERATOR: &str = "ChaCha8, seed_from_u64(seed), Fisher-Yates from the end, rejection sampling";

/// Patches between two whites that show drift.
const BETWEEN_WHITES: usize = 16;

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanSettings {
    /// The channels, each once.
    pub channels: Vec<Channel>,
    /// Levels of each, evenly spaced in encoded value, 0 and 1 among them.
    pub levels: usize,
    /// Readings of each patch.
    pub repeats: usize,
    /// Largest code a channel: levels are whole codes.
    pub largest_code: u16,
    /// Of the order.
    pub seed: u64,
}

impl Default for PlanSettings {
    /// Red, green, blue and gray at 17 levels, once, 8 bits.
    fn default() -> Self {
        Self { channels: Channel::ALL.to_vec(), levels: 17, repeats: 1, largest_code: 255, seed: 1 }
    }
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// Channels that give no profile.
    #[error("these channels give no profile; expected red, green and blue, or gray, each once")]
    Channels,
    /// Too few or too many levels.
    #[error("{0} levels; expected {LEAST_LEVELS} to 256, no more than there are codes")]
    Levels(usize),
    /// No readings.
    #[error("{0} readings of each patch; expected 1 to 20")]
    Repeats(usize),
}

/// A patch to show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The lit channels.
    pub channel: Channel,
    /// Their code.
    pub code: u16,
    /// Their encoded value, 0…1: the code divided by the largest code.
    pub level: f64,
}

impl Patch {
    /// Codes of red, green and blue.
    #[must_use]
    pub fn codes(&self) -> [u16; 3] {
        match self.channel {
            Channel::Red => [self.code, 0, 0],
            Channel::Green => [0, self.code, 0],
            Channel::Blue => [0, 0, self.code],
            Channel::Gray => [self.code; 3],
        }
    }
}

/// The patches in the order of measurement.
///
/// Every patch once in random order, then all again for each repeat, so that drift of the screen or the photometer falls
/// on all levels and channels alike. Black is the same patch in every channel and comes once a repeat. White comes first,
/// last and after every 16 patches: what it changes by is the drift.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// In order.
    pub patches: Vec<Patch>,
}

impl Plan {
    /// The order for settings; equal settings give the same order.
    ///
    /// # Errors
    /// [`PlanError`] where the settings give no profile.
    pub fn new(settings: &PlanSettings) -> Result<Self, PlanError> {
        let white = check(settings)?;
        let white = patch(settings, white, settings.levels - 1);
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        let mut patches = vec![white];
        for _ in 0..settings.repeats {
            let mut round: Vec<Patch> = (settings.channels.iter())
                .flat_map(|channel| (1..settings.levels).map(|step| patch(settings, *channel, step)))
                .filter(|patch| *patch != white)
                .collect();
            round.push(patch(settings, white.channel, 0));
            shuffle(&mut round, &mut rng);
            for patches_between in round.chunks(BETWEEN_WHITES) {
                patches.extend(patches_between);
                patches.push(white);
            }
        }
        Ok(Self { patches })
    }

    /// How long it takes at least, seconds, if each reading takes `reading_s` after `settle_s`.
    #[must_use]
    pub fn duration_s(&self, settle_s: f64, reading_s: f64) -> f64 {
        self.patches.len() as f64 * (settle_s + reading_s)
    }
}

/// The channel that white is shown in.
fn check(settings: &PlanSettings) -> Result<Channel, PlanError> {
    let has = |channel| settings.channels.iter().filter(|one| **one == channel).count();
    let colors = [Channel::Red, Channel::Green, Channel::Blue];
    let complete = has(Channel::Gray) == 1 || colors.into_iter().all(|channel| has(channel) == 1);
    if !complete || Channel::ALL.into_iter().any(|channel| has(channel) > 1) {
        return Err(PlanError::Channels);
    }
    if !(LEAST_LEVELS..=256.min(usize::from(settings.largest_code) + 1)).contains(&settings.levels) {
        return Err(PlanError::Levels(settings.levels));
    }
    if !(1..=20).contains(&settings.repeats) {
        return Err(PlanError::Repeats(settings.repeats));
    }
    Ok(if has(Channel::Gray) == 1 { Channel::Gray } else { Channel::Green })
}

fn patch(settings: &PlanSettings, channel: Channel, step: usize) -> Patch {
    let largest = f64::from(settings.largest_code);
    let code = (largest * step as f64 / (settings.levels - 1) as f64).round();
    Patch { channel, code: code as u16, level: code / largest }
}

/// How the most light of a channel changed from its first reading to its last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// The channel whose level 1 was read again.
    pub channel: Channel,
    /// How often it was read.
    pub readings: usize,
    /// Change over all readings by a straight line, percent of the mean.
    pub percent: f64,
}

impl Drift {
    /// From readings in the order in which they were taken; `None` where no channel's level 1 was read three times, apart
    /// from each other.
    #[must_use]
    pub fn of(readings: &Readings) -> Option<Self> {
        let all = readings.all();
        let whites = |channel: Channel| -> Vec<(f64, f64)> {
            let is_white = |one: &Reading| one.channel == channel && one.level == 1.0;
            let at = all.iter().enumerate().filter(|(_, one)| is_white(one));
            at.map(|(index, one)| (index as f64, one.luminance_cd_m2)).collect()
        };
        let (channel, whites) = readings
            .channels()
            .iter()
            .map(|channel| (*channel, whites(*channel)))
            .max_by_key(|(_, whites)| whites.len())?;
        let n = whites.len();
        let apart = whites.first()?.0 + (n as f64) <= whites.last()?.0;
        if n < 3 || !apart {
            return None;
        }
        let mean = |of: fn(&(f64, f64)) -> f64| whites.iter().map(of).sum::<f64>() / n as f64;
        let (x, y) = (mean(|white| white.0), mean(|white| white.1));
        let spread: f64 = whites.iter().map(|white| (white.0 - x).powi(2)).sum();
        let slope = whites.iter().map(|white| (white.0 - x) * (white.1 - y)).sum::<f64>() / spread;
        Some(Self { channel, readings: n, percent: 100.0 * slope * (all.len() - 1) as f64 / y })
    }
}
