//! Readings as numbers to fit, with their noise.

use super::{
    reading::{Channel, Reading},
    readings::Readings,
};

/// One reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Index of the channel in [`Sample::channels`].
    pub channel: usize,
    /// Encoded value, 0…1.
    pub v: f64,
    /// Luminance, cd/m².
    pub y: f64,
    /// Its standard deviation, cd/m².
    pub sd: f64,
}

/// What is fitted.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub points: Vec<Point>,
    pub channels: Vec<Channel>,
    pub resolution: f64,
}

/// Noise that is assumed until it is known, relative to the reading.
const FIRST_GUESS: f64 = 0.01;
/// Noise below this, relative to the largest reading, is none.
pub(super) const NONE: f64 = 1e-8;

impl Sample {
    pub fn new(readings: &Readings) -> Self {
        let channels = readings.channels().to_vec();
        let largest = readings.largest_cd_m2();
        let resolution = readings.resolution_cd_m2();
        let floor = (resolution / 12f64.sqrt()).max(NONE * largest);
        let point = |one: &Reading| {
            let channel = channels.iter().position(|channel| *channel == one.channel)?;
            let sd = (FIRST_GUESS * one.luminance_cd_m2).hypot(floor);
            Some(Point { channel, v: one.level, y: one.luminance_cd_m2, sd })
        };
        Self { points: readings.all().iter().filter_map(point).collect(), channels, resolution }
    }

    /// Number of channels.
    pub fn width(&self) -> usize {
        self.channels.len()
    }

    /// The points that satisfy a condition.
    pub fn filtered(&self, keep: impl Fn(&Point) -> bool) -> Self {
        Self { points: self.points.iter().copied().filter(keep).collect(), ..self.clone() }
    }

    /// The largest luminance.
    pub fn largest(&self) -> f64 {
        self.points.iter().map(|point| point.y).fold(0.0, f64::max)
    }

    /// The levels strictly between 0 and 1, each once, rising.
    pub fn inner_levels(&self) -> Vec<f64> {
        let mut levels: Vec<f64> = self.points.iter().map(|point| point.v).filter(|v| *v > 0.0 && *v < 1.0).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        levels
    }
}
