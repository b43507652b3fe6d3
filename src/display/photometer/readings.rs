//! A set of readings that a profile can be made from.

use super::{
    checks,
    fault::ReadingFault,
    reading::{Channel, LevelMean, Reading, means},
};

/// Readings that were checked: enough of them, each possible, the light rising with the level, the channels what they
/// are called. In the order in which they were taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    all: Vec<Reading>,
    channels: Vec<Channel>,
}

/// A fault of readings, and which of them has it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{fault}")]
pub struct Fault {
    /// Index of the reading, from 0; `None` for a fault of the set.
    pub index: Option<usize>,
    /// What is wrong.
    pub fault: ReadingFault,
}

impl Readings {
    /// Checks readings, given in the order in which they were taken.
    ///
    /// # Errors
    /// Every fault of single readings; where there is none, every fault of the set.
    pub fn new(readings: Vec<Reading>) -> Result<Self, Vec<Fault>> {
        let faults = checks::each(&readings);
        if !faults.is_empty() {
            return Err(faults);
        }
        let channels: Vec<Channel> =
            Channel::ALL.into_iter().filter(|channel| readings.iter().any(|one| one.channel == *channel)).collect();
        let set = Self { all: readings, channels };
        let faults = checks::together(&set);
        if faults.is_empty() { Ok(set) } else { Err(faults) }
    }

    /// All readings in the order in which they were taken.
    #[must_use]
    pub fn all(&self) -> &[Reading] {
        &self.all
    }

    /// The channels that were read.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Whether a channel was read.
    #[must_use]
    pub fn has(&self, channel: Channel) -> bool {
        self.channels.contains(&channel)
    }

    /// The mean of each level of a channel, from dark to light.
    #[must_use]
    pub fn means(&self, channel: Channel) -> Vec<LevelMean> {
        means(self.all.iter().copied().filter(|one| one.channel == channel))
    }

    /// Luminance of black, cd/m²: the mean of the readings at level 0, which is the same patch in every channel.
    #[must_use]
    pub fn black_cd_m2(&self) -> f64 {
        means(self.all.iter().copied()).first().map_or(0.0, |black| black.luminance_cd_m2)
    }

    /// The largest luminance that was read, cd/m².
    #[must_use]
    pub fn largest_cd_m2(&self) -> f64 {
        self.all.iter().map(|one| one.luminance_cd_m2).fold(0.0, f64::max)
    }

    /// The step of the photometer's display, cd/m²: the largest power of ten of which every reading is a multiple; 0
    /// where there is none down to 10⁻⁵.
    #[must_use]
    pub fn resolution_cd_m2(&self) -> f64 {
        let multiple = |step: f64| {
            self.all.iter().all(|one| {
                let steps = one.luminance_cd_m2 / step;
                (steps - steps.round()).abs() <= 1e-9 * steps.abs().max(1.0)
            })
        };
        (-2..=5).map(|digits| 10f64.powi(-digits)).find(|step| multiple(*step)).unwrap_or(0.0)
    }
}
