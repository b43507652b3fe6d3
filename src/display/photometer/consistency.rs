//! Whether readings agree with each other: red, green and blue with gray, and white with white.

use super::readings::{LevelMean, Reading, Readings, is_same_level};
use crate::display::channel::Channel;

/// Percent of white beyond which a display's channels are not independent.
pub const ADDITIVE_PERCENT: f64 = 5.0;

/// Gray at one level, and what its channels add up to.
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

impl Additivity {
    /// `None` where no level above 0 was read of red, green, blue and gray.
    #[must_use]
    pub fn new(readings: &Readings) -> Option<Self> {
        let [red, green, blue, gray] = Channel::ALL.map(|channel| readings.means(channel));
        let black = readings.black_cd_m2();
        let sum = |gray: &LevelMean| {
            let at = |means: &[LevelMean]| {
                let found = means.iter().find(|mean| is_same_level(mean.level, gray.level))?;
                Some(found.luminance_cd_m2)
            };
            let sum_cd_m2 = at(&red)? + at(&green)? + at(&blue)? - 2.0 * black;
            Some(Sum { level: gray.level, gray_cd_m2: gray.luminance_cd_m2, sum_cd_m2 })
        };
        let lit = gray.iter().filter(|gray| gray.level > 0.0 && gray.luminance_cd_m2 > 0.0);
        let sums: Vec<Sum> = lit.filter_map(sum).collect();
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

/// The change of white from its first reading to its last, by a straight line through all of them, in percent of its
/// mean; `None` where no channel's level 1 was read at least three times, spread over the measurement.
#[must_use]
pub fn drift_percent(readings: &Readings) -> Option<f64> {
    let all = readings.all();
    let whites = |channel: &Channel| -> Vec<(f64, f64)> {
        let is_white = |one: &Reading| one.channel == *channel && one.level == 1.0;
        let at = all.iter().enumerate().filter(|(_, one)| is_white(one));
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
