//! The order in which patches are shown.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

use crate::{display::channel::Channel, statistics::shuffle};

/// The number of patches between two readings of white, which reveal drift.
const BETWEEN_WHITES: usize = 16;

/// The measurement settings.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchSettings {
    /// The channels, each once.
    pub channels: Vec<Channel>,
    /// The number of levels of each channel, 2 to 256, evenly spaced in encoded value, including 0 and 1.
    pub levels: usize,
    /// The number of readings of each patch.
    pub repeats: usize,
    /// The seed of the random order.
    pub seed: u64,
}

impl Default for PatchSettings {
    fn default() -> Self {
        Self { channels: Channel::ALL.to_vec(), levels: 17, repeats: 1, seed: 1 }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The lit channel, or all three for gray.
    pub channel: Channel,
    pub code: u8,
    /// The encoded value, 0…1: the code divided by the largest code.
    pub level: f64,
}

/// Returns the patches in the order of measurement; equal settings give the same order.
///
/// Every repeat shows each patch once, in a new random order, so that drift of the screen or the photometer affects all
/// levels and channels alike. Black is the same patch in every channel and comes once per repeat. White comes first,
/// last and after every 16 patches; its change is the drift.
///
/// # Errors
/// Returns an error if a profile cannot be made with these settings.
pub fn patches(settings: &PatchSettings) -> Result<Vec<Patch>, String> {
    let PatchSettings { channels, levels, repeats, seed } = settings;
    Channel::check_for_profile(channels)?;
    let patch = |channel: Channel, step: usize| {
        let code = (255.0 * step as f64 / (levels - 1) as f64).round();
        Patch { channel, code: code as u8, level: code / 255.0 }
    };
    let white_channel = if channels.contains(&Channel::Gray) { Channel::Gray } else { Channel::Green };
    let white = patch(white_channel, levels - 1);
    let mut rng = ChaCha8Rng::seed_from_u64(*seed);
    let mut patches = vec![white];
    for _ in 0..*repeats {
        let all = channels.iter().flat_map(|channel| (1..*levels).map(|step| patch(*channel, step)));
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
