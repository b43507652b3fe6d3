//! What a photometer read: one luminance a patch.

pub use crate::display::channel::{Channel, UnknownChannel};

/// One reading of one patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The lit channels.
    pub channel: Channel,
    /// Their encoded value, 0…1: the code divided by the largest code.
    pub level: f64,
    /// What the photometer showed, cd/m².
    pub luminance_cd_m2: f64,
}

/// The readings of one channel at one level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelMean {
    /// Encoded value, 0…1.
    pub level: f64,
    /// Mean of the readings, cd/m².
    pub luminance_cd_m2: f64,
    /// How many there are.
    pub readings: usize,
}

/// Levels nearer than this are the same patch typed twice.
const SAME_LEVEL: f64 = 1e-6;

/// The mean of each level, from dark to light, of readings in any order.
pub(super) fn means(readings: impl Iterator<Item = Reading>) -> Vec<LevelMean> {
    let mut sorted: Vec<Reading> = readings.collect();
    sorted.sort_by(|a, b| a.level.total_cmp(&b.level));
    let mut means: Vec<LevelMean> = Vec::new();
    for Reading { level, luminance_cd_m2, .. } in sorted {
        match means.last_mut() {
            Some(last) if level - last.level < SAME_LEVEL => {
                last.readings += 1;
                last.luminance_cd_m2 += (luminance_cd_m2 - last.luminance_cd_m2) / last.readings as f64;
            }
            _ => means.push(LevelMean { level, luminance_cd_m2, readings: 1 }),
        }
    }
    means
}
