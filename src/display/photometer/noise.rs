//! How noisy the readings are. A photometer's noise is about proportional to what it reads, with a floor in the dark:
//! sd² = (c·L)² + f².

use super::{
    fit::Fit,
    model::{Black, Model},
    sample::{NONE, Sample},
    shape::{Curve, Family},
};

/// The noise of readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Relative to the luminance: the coefficient of variation.
    pub relative: f64,
    /// In the dark, cd/m².
    pub floor_cd_m2: f64,
}

impl Noise {
    /// Standard deviation of readings of a luminance, cd/m².
    #[must_use]
    pub fn sd_cd_m2(&self, cd_m2: f64) -> f64 {
        (self.relative * cd_m2).hypot(self.floor_cd_m2)
    }
}

/// Gain in the log-likelihood that a floor above the photometer's resolution must bring.
const FLOOR_GAIN: f64 = 3.0;
/// Rounds of fitting and weighing.
const ROUNDS: usize = 3;

/// Weighs the readings: fits the curve with most freedom, takes the noise from what is left, and begins again.
pub(super) fn weigh(sample: &mut Sample) -> Noise {
    let model = Model { family: Family::Gog, pooled: true, black: Black::Own };
    let mut fit = Fit::new(model, sample);
    let mut noise = of(sample, &fit);
    for _ in 0..ROUNDS {
        apply(sample, &fit.curves, noise);
        fit = Fit::from(model, sample, fit.parameters);
        noise = of(sample, &fit);
    }
    // Where channels differ much in shape, the curves of each are nearer to the light.
    let own = Fit::new(Model { pooled: false, ..model }, sample);
    let better = if own.freedom() > 0.0 && own.deviance / own.freedom() < 0.5 * fit.deviance / fit.freedom() {
        own
    } else {
        fit
    };
    noise = of(sample, &better);
    apply(sample, &better.curves, noise);
    noise
}

fn apply(sample: &mut Sample, curves: &[Curve], noise: Noise) {
    for point in &mut sample.points {
        point.sd = noise.sd_cd_m2(curves[point.channel].cd_m2(point.v));
    }
}

/// The most likely noise, given what a fit leaves.
fn of(sample: &Sample, fit: &Fit) -> Noise {
    let left: Vec<(f64, f64)> = (sample.points.iter())
        .map(|point| {
            let light = fit.curves[point.channel].cd_m2(point.v);
            (light, point.y - light)
        })
        .collect();
    let spent = left.len() as f64 / fit.freedom().max(1.0);
    let lowest = (sample.resolution / 12f64.sqrt()).max(NONE * sample.largest());
    let best_of = |floor_cd_m2: f64| {
        let of = |ln_relative: f64| likelihood(&left, spent, Noise { relative: ln_relative.exp(), floor_cd_m2 });
        let ln_relative = highest(of, -18.0, -0.7);
        (of(ln_relative), Noise { relative: ln_relative.exp(), floor_cd_m2 })
    };
    let without = best_of(lowest);
    let floors = (1..=9).map(|i| best_of(lowest.max(1e-6 * sample.largest()) * 2.5f64.powi(i)));
    let with = floors.max_by(|a, b| a.0.total_cmp(&b.0));
    with.filter(|with| with.0 > without.0 + FLOOR_GAIN).unwrap_or(without).1
}

/// Where a function with one peak has it, by golden sections.
fn highest(of: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let (mut left, mut right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut of_left, mut of_right) = (of(left), of(right));
    while high - low > 0.02 {
        if of_left > of_right {
            (high, right, of_right) = (right, left, of_left);
            left = high - GOLDEN * (high - low);
            of_left = of(left);
        } else {
            (low, left, of_left) = (left, right, of_right);
            right = low + GOLDEN * (high - low);
            of_right = of(right);
        }
    }
    0.5 * (low + high)
}

fn likelihood(left: &[(f64, f64)], spent: f64, noise: Noise) -> f64 {
    let of = |(light, left): &(f64, f64)| {
        let sd = noise.sd_cd_m2(*light);
        -sd.ln() - 0.5 * spent * (left / sd).powi(2)
    };
    left.iter().map(of).sum()
}
