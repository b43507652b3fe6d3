//! Readings as numbers to fit.

use super::{
    models::Curve,
    readings::{Reading, Readings, is_same_level},
};
use crate::display::channel::Channel;

/// Noise that is assumed for the weights, relative to the light: a photometer's noise is about proportional to what it
/// reads.
pub(super) const ASSUMED_NOISE: f64 = 0.01;
/// Noise below this, relative to the largest reading, is none.
const LEAST_NOISE: f64 = 1e-8;

/// One reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub channel: Channel,
    /// Encoded value, 0…1.
    pub v: f64,
    /// Luminance, cd/m².
    pub y: f64,
    /// Assumed standard deviation of `y`, cd/m².
    pub sd: f64,
}

/// What is fitted together.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub channels: Vec<Channel>,
    pub points: Vec<Point>,
    /// Noise in the dark, cd/m²: that of the photometer's last digit.
    floor: f64,
}

fn assumed_sd(cd_m2: f64, floor: f64) -> f64 {
    (ASSUMED_NOISE * cd_m2).hypot(floor)
}

impl Sample {
    pub fn new(readings: &Readings) -> Self {
        let floor = (readings.resolution_cd_m2() / 12f64.sqrt()).max(LEAST_NOISE * readings.largest_cd_m2());
        let point = |one: &Reading| {
            let y = one.luminance_cd_m2;
            Point { channel: one.channel, v: one.level, y, sd: assumed_sd(y, floor) }
        };
        Self { channels: readings.channels().to_vec(), points: readings.all().iter().map(point).collect(), floor }
    }

    /// Takes the weights from a fit: a reading that noise made too dark must not weigh more for it.
    pub fn weigh(&mut self, curves: &[Curve]) {
        for point in &mut self.points {
            let of_channel = self.channels.iter().zip(curves).find(|(channel, _)| **channel == point.channel);
            point.sd = assumed_sd(of_channel.map_or(point.y, |(_, curve)| curve.cd_m2(point.v)), self.floor);
        }
    }

    /// The points of a channel; black is the same patch in all of them.
    pub fn of(&self, channel: Channel) -> Self {
        let own = self.points.iter().filter(|point| point.channel == channel || point.v == 0.0);
        let points = own.map(|point| Point { channel, ..*point }).collect();
        Self { channels: vec![channel], points, floor: self.floor }
    }

    /// All points but those at a level, and the points at it.
    pub fn split_at(&self, level: f64) -> (Self, Self) {
        let (at, rest) = self.points.iter().partition(|point| is_same_level(point.v, level));
        (Self { points: rest, ..self.clone() }, Self { points: at, ..self.clone() })
    }

    /// The levels strictly between 0 and 1, rising.
    pub fn inner_levels(&self) -> Vec<f64> {
        let mut levels: Vec<f64> = self.points.iter().map(|point| point.v).filter(|v| *v > 0.0 && *v < 1.0).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|a, b| is_same_level(*a, *b));
        levels
    }

    /// Mean and standard deviation of the mean of the points that satisfy a condition; `None` where there are none.
    pub fn mean(&self, keep: impl Fn(&Point) -> bool) -> Option<(f64, f64)> {
        let kept: Vec<&Point> = self.points.iter().filter(|point| keep(point)).collect();
        let n = kept.len() as f64;
        Some((kept.iter().map(|point| point.y).sum::<f64>() / n, kept.first()?.sd / n.sqrt()))
    }

    /// How far each point is from its channel's curve, in standard deviations.
    pub fn residuals(&self, curves: &[Curve]) -> Vec<f64> {
        let of = |point: &Point| {
            let at = self.channels.iter().position(|channel| *channel == point.channel)?;
            Some((point.y - curves[at].cd_m2(point.v)) / point.sd)
        };
        self.points.iter().filter_map(of).collect()
    }
}
