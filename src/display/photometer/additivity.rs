//! Whether red, green and blue together give the light that each gives alone.

use super::{
    reading::{Channel, LevelMean},
    readings::Readings,
};

/// Gray at one level against what its channels add up to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sum {
    /// Encoded value, 0…1.
    pub level: f64,
    /// Gray as it was read, cd/m².
    pub gray_cd_m2: f64,
    /// Red + green + blue − 2·black, cd/m².
    pub sum_cd_m2: f64,
}

impl Sum {
    /// Gray less the sum, cd/m².
    #[must_use]
    pub fn deviation_cd_m2(&self) -> f64 {
        self.gray_cd_m2 - self.sum_cd_m2
    }

    /// The same in percent of gray.
    #[must_use]
    pub fn deviation_percent(&self) -> f64 {
        100.0 * self.deviation_cd_m2() / self.gray_cd_m2
    }
}

/// Additivity of the channels at every level that was read of all four.
#[derive(Clone, Debug, PartialEq)]
pub struct Additivity {
    /// From dark to light; never empty.
    pub sums: Vec<Sum>,
}

/// Percent beyond which a display's channels are not independent.
pub const ADDITIVE_PERCENT: f64 = 5.0;

impl Additivity {
    /// `None` where no level above 0 was read of red, green, blue and gray.
    #[must_use]
    pub fn new(readings: &Readings) -> Option<Self> {
        let [red, green, blue, gray] = Channel::ALL.map(|channel| readings.means(channel));
        let at = |means: &[LevelMean], level: f64| {
            means.iter().find(|mean| (mean.level - level).abs() < 1e-6).map(|mean| mean.luminance_cd_m2)
        };
        let black = readings.black_cd_m2();
        let sum = |gray: &LevelMean| {
            let parts = [at(&red, gray.level)?, at(&green, gray.level)?, at(&blue, gray.level)?];
            let sum_cd_m2 = parts.iter().sum::<f64>() - 2.0 * black;
            Some(Sum { level: gray.level, gray_cd_m2: gray.luminance_cd_m2, sum_cd_m2 })
        };
        let sums: Vec<Sum> =
            gray.iter().filter(|gray| gray.level > 0.0 && gray.luminance_cd_m2 > 0.0).filter_map(sum).collect();
        (!sums.is_empty()).then_some(Self { sums })
    }

    /// The level with the largest deviation in percent.
    #[must_use]
    pub fn largest_percent(&self) -> Sum {
        self.largest(|sum| sum.deviation_percent().abs())
    }

    /// The level with the largest deviation in cd/m².
    #[must_use]
    pub fn largest_cd_m2(&self) -> Sum {
        self.largest(|sum| sum.deviation_cd_m2().abs())
    }

    /// Whether white is the sum of its channels, within [`ADDITIVE_PERCENT`].
    #[must_use]
    pub fn holds(&self) -> bool {
        self.sums.last().is_none_or(|white| white.deviation_percent().abs() <= ADDITIVE_PERCENT)
    }

    fn largest(&self, by: impl Fn(&Sum) -> f64) -> Sum {
        self.sums.iter().copied().fold(self.sums[0], |most, sum| if by(&sum) > by(&most) { sum } else { most })
    }
}
