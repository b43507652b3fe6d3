//! The patches, in the order in which they are shown, and their readings: one luminance per patch.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

use crate::{display::channel::Channel, statistics::shuffle};

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

/// The readings of one channel at one level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelMean {
    /// Encoded value, 0…1.
    pub level: f64,
    /// Mean of the readings, cd/m².
    pub luminance_cd_m2: f64,
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
    pub(super) fn unchecked(all: Vec<Reading>) -> Self {
        let read = |channel: &Channel| all.iter().any(|one| one.channel == *channel);
        Self { channels: Channel::ALL.into_iter().filter(read).collect(), all }
    }

    /// All readings in the order in which they were taken.
    pub fn all(&self) -> &[Reading] {
        &self.all
    }

    /// The channels that were read.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The mean at each level of a channel, from dark to light.
    pub fn means(&self, channel: Channel) -> Vec<LevelMean> {
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
fn means<'a>(readings: impl Iterator<Item = &'a Reading>) -> Vec<LevelMean> {
    let mut sorted: Vec<&Reading> = readings.collect();
    sorted.sort_by(|a, b| a.level.total_cmp(&b.level));
    let same = sorted.chunk_by(|a, b| is_same_level(a.level, b.level));
    same.map(|level| {
        let sum: f64 = level.iter().map(|one| one.luminance_cd_m2).sum();
        LevelMean { level: level[0].level, luminance_cd_m2: sum / level.len() as f64 }
    })
    .collect()
}

/// The number of patches between two readings of white, which reveal drift.
const BETWEEN_WHITES: usize = 16;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The lit channel, or all three for gray.
    pub channel: Channel,
    pub code: u8,
    /// The encoded value, 0…1: the code divided by the largest code.
    pub level: f64,
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
    let patch = |channel: Channel, step: usize| {
        let code = (255.0 * step as f64 / (levels - 1) as f64).round();
        Patch { channel, code: code as u8, level: code / 255.0 }
    };
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
