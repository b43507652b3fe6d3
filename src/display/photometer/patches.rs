//! The order in which patches are shown.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

use super::checks::LEAST_LEVELS;
use crate::{display::channel::Channel, light::random::shuffle};

/// Patches between two readings of white, which show drift.
const BETWEEN_WHITES: usize = 16;
/// The largest code of a channel.
const LARGEST_CODE: u8 = 255;

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchSettings {
    /// The channels, each once.
    pub channels: Vec<Channel>,
    /// Levels of each channel, evenly spaced in encoded value, including 0 and 1.
    pub levels: usize,
    /// Readings of each patch.
    pub repeats: usize,
    /// Seed of the order.
    pub seed: u64,
}

impl Default for PatchSettings {
    fn default() -> Self {
        Self { channels: Channel::ALL.to_vec(), levels: 17, repeats: 1, seed: 1 }
    }
}

/// Why settings give no profile.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingsError {
    /// Without all three channels and without gray, or with one channel twice.
    #[error("the channels give no profile; expected red, green and blue, or gray, each once")]
    Channels,
    /// Too few or too many levels.
    #[error("{0} levels; expected {LEAST_LEVELS} to 256")]
    Levels(usize),
    /// No repeats, or too many.
    #[error("{0} readings of each patch; expected 1 to 20")]
    Repeats(usize),
}

/// One patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The lit channels.
    pub channel: Channel,
    /// Their code.
    pub code: u8,
    /// Their encoded value, 0…1: the code divided by the largest code.
    pub level: f64,
}

/// The patches in the order of measurement; equal settings give the same order.
///
/// Every patch comes once in random order, then all again for each repeat, so that drift of the screen or the photometer
/// affects all levels and channels alike. Black is the same patch in every channel and comes once a repeat. White comes
/// first, last and after every 16 patches: its change is the drift.
///
/// # Errors
/// [`SettingsError`] where the settings give no profile.
pub fn patches(settings: &PatchSettings) -> Result<Vec<Patch>, SettingsError> {
    let white_channel = check(settings)?;
    let patch = |channel: Channel, step: usize| {
        let code = (f64::from(LARGEST_CODE) * step as f64 / (settings.levels - 1) as f64).round();
        Patch { channel, code: code as u8, level: code / f64::from(LARGEST_CODE) }
    };
    let white = patch(white_channel, settings.levels - 1);
    let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
    let mut patches = vec![white];
    for _ in 0..settings.repeats {
        let mut round: Vec<Patch> = (settings.channels.iter())
            .flat_map(|channel| (1..settings.levels).map(|step| patch(*channel, step)))
            .filter(|patch| *patch != white)
            .collect();
        round.push(patch(white_channel, 0));
        shuffle(&mut round, &mut rng);
        for between in round.chunks(BETWEEN_WHITES) {
            patches.extend(between);
            patches.push(white);
        }
    }
    Ok(patches)
}

/// The channel that white is shown in.
fn check(settings: &PatchSettings) -> Result<Channel, SettingsError> {
    if !Channel::make_a_profile(&settings.channels) {
        return Err(SettingsError::Channels);
    }
    if !(LEAST_LEVELS..=256).contains(&settings.levels) {
        return Err(SettingsError::Levels(settings.levels));
    }
    if !(1..=20).contains(&settings.repeats) {
        return Err(SettingsError::Repeats(settings.repeats));
    }
    Ok(if settings.channels.contains(&Channel::Gray) { Channel::Gray } else { Channel::Green })
}
