//! The monotone table: the best curve, bent to the readings where they ask for it.
//!
//! Readings joined by lines would carry their noise into the table: 1 % of the light is 1.2 codes of 8 bits. Instead, the
//! table is the fitted curve of an encoded value that is shifted a little, T(V + d(V)). The shift d is a Gaussian process
//! (Rasmussen & Williams 2006, Gaussian Processes for Machine Learning, §5.4): how far and how fast it may change is what
//! makes the readings most likely. Where the curve alone makes them as likely, d is 0 and the table is the curve.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::{
    sample::Sample,
    shape::{Curve, Shape},
};

/// How far d changes together, in encoded values.
const LENGTHS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];
/// How large d is, relative to the noise of a reading in encoded values.
const SIZES: [f64; 9] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 64.0, 256.0, 4096.0];
/// Twice the gain in the log-likelihood that bending must bring.
const GAIN: f64 = 14.0;
/// Shifts below this are none: a thousandth of an 8-bit code.
const NONE: f64 = 1e-3 / 255.0;
/// Below this encoded value, d is held to 0 at black.
const DARK: f64 = 0.05;
/// A reading so near to black, in standard deviations, says nothing of the encoded value.
const CLEAR: f64 = 3.0;

/// What a level says of the shift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shift {
    v: f64,
    d: f64,
    sd: f64,
}

/// How the shift may change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stiffness {
    /// One shift for all channels.
    pub common: bool,
    length: f64,
    size: f64,
}

/// A shift as a function of the encoded value.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Bend {
    at: Vec<f64>,
    weights: Vec<f64>,
    length: f64,
}

impl Bend {
    /// The shift at an encoded value.
    pub(super) fn shift(&self, v: f64) -> f64 {
        self.at.iter().zip(&self.weights).map(|(at, weight)| weight * covariance(v, *at, self.length)).sum()
    }
}

/// Matérn's covariance of smoothness 5/2, which fades toward black.
fn covariance(a: f64, b: f64, length: f64) -> f64 {
    let far = 5f64.sqrt() * (a - b).abs() / length;
    let fade = |v: f64| v / (v + DARK);
    fade(a) * fade(b) * (1.0 + far + far * far / 3.0) * (-far).exp()
}

/// The curves that readings are bent against: their black is what was read.
pub(super) fn with_read_black(sample: &Sample, curves: &[Curve]) -> Vec<Curve> {
    let black = |channel: Option<usize>| {
        let dark = sample.points.iter().filter(|p| p.v == 0.0 && channel.is_none_or(|channel| p.channel == channel));
        let (sum, n) = dark.fold((0.0, 0.0), |(sum, n), p| (sum + p.y, n + 1.0));
        (n > 0.0).then(|| sum / n)
    };
    let same = curves.iter().all(|curve| curve.black_cd_m2 == curves[0].black_cd_m2);
    let of = |(channel, curve): (usize, &Curve)| {
        let read = black((!same).then_some(channel)).unwrap_or(curve.black_cd_m2);
        Curve { black_cd_m2: read, range_cd_m2: curve.cd_m2(1.0) - read, ..*curve }
    };
    curves.iter().enumerate().map(of).collect()
}

/// What each level of each channel says of the shift.
pub(super) fn shifts(sample: &Sample, curves: &[Curve]) -> Vec<Vec<Shift>> {
    let of = |(channel, curve): (usize, &Curve)| {
        let mut points: Vec<_> = sample.points.iter().filter(|p| p.channel == channel && p.v > 0.0).collect();
        points.sort_by(|a, b| a.v.total_cmp(&b.v));
        let levels = points.chunk_by(|a, b| (a.v - b.v).abs() < 1e-6);
        levels
            .filter_map(|level| {
                let n = level.len() as f64;
                let y = level.iter().map(|p| p.y).sum::<f64>() / n;
                let (v, sd) = (level[0].v, level[0].sd / n.sqrt());
                let encoded = |y: f64| curve.encoded(y);
                let spread = 0.5 * (encoded(y + sd) - encoded(y - sd));
                (y - curve.black_cd_m2 > CLEAR * sd && spread > 0.0).then(|| Shift { v, d: encoded(y) - v, sd: spread })
            })
            .collect()
    };
    curves.iter().enumerate().map(of).collect()
}

/// The stiffness that makes the readings most likely; `None` where they need no bending.
pub(super) fn stiffness(shifts: &[Vec<Shift>]) -> Option<Stiffness> {
    let all: Vec<Shift> = shifts.iter().flatten().copied().collect();
    if all.len() < 4 || all.iter().all(|shift| shift.d.abs() < NONE) {
        return None;
    }
    let mut noise: Vec<f64> = all.iter().map(|shift| shift.sd).collect();
    noise.sort_by(f64::total_cmp);
    let typical = noise[noise.len() / 2];
    let straight = likelihood(shifts, None)?;
    let modes: &[bool] = if shifts.len() > 1 { &[true, false] } else { &[false] };
    let mut best: Option<(f64, Stiffness)> = None;
    for &common in modes {
        for length in LENGTHS {
            for size in SIZES {
                let stiffness = Stiffness { common, length, size: size * typical };
                let Some(likely) = likelihood(shifts, Some(stiffness)) else { continue };
                if best.is_none_or(|(most, _)| likely > most) {
                    best = Some((likely, stiffness));
                }
            }
        }
    }
    best.filter(|(likely, _)| 2.0 * (likely - straight) > GAIN).map(|(_, stiffness)| stiffness)
}

/// The shifts of the channels at a stiffness.
pub(super) fn bends(shifts: &[Vec<Shift>], stiffness: Stiffness) -> Option<Vec<Bend>> {
    let of = |shifts: &[Shift]| {
        let solved = factor(shifts, Some(stiffness))?.solve(&values(shifts));
        let weights = solved.iter().map(|weight| weight * stiffness.size.powi(2)).collect();
        Some(Bend { at: shifts.iter().map(|shift| shift.v).collect(), weights, length: stiffness.length })
    };
    if stiffness.common {
        let bend = of(&joined(shifts).0)?;
        return Some(vec![bend; shifts.len()]);
    }
    shifts.iter().map(|shifts| of(shifts)).collect()
}

/// Log-likelihood up to a constant, at the noise that makes it highest.
fn likelihood(shifts: &[Vec<Shift>], stiffness: Option<Stiffness>) -> Option<f64> {
    let n: usize = shifts.iter().map(Vec::len).sum();
    let (mut square, mut ln_det) = (0.0, 0.0);
    let mut add = |shifts: &[Shift]| {
        let factor = factor(shifts, stiffness)?;
        let values = values(shifts);
        square += values.dot(&factor.solve(&values));
        ln_det += 2.0 * factor.l_dirty().diagonal().iter().map(|pivot| pivot.ln()).sum::<f64>();
        Some(())
    };
    if stiffness.is_some_and(|stiffness| stiffness.common) {
        let (joined, within, ln_within) = joined(shifts);
        add(&joined)?;
        (square, ln_det) = (square + within, ln_det + ln_within);
    } else {
        for shifts in shifts.iter().filter(|shifts| !shifts.is_empty()) {
            add(shifts)?;
        }
    }
    Some(-0.5 * (n as f64 * (square / n as f64).ln() + ln_det))
}

/// The mean shift of each level over the channels; with it the weighted square and the logarithm of the variances of
/// what the channels differ by.
fn joined(shifts: &[Vec<Shift>]) -> (Vec<Shift>, f64, f64) {
    let mut all: Vec<Shift> = shifts.iter().flatten().copied().collect();
    all.sort_by(|a, b| a.v.total_cmp(&b.v));
    let (mut square, mut ln_det) = (0.0, 0.0);
    let levels = all.chunk_by(|a, b| (a.v - b.v).abs() < 1e-6).map(|level| {
        let weight: f64 = level.iter().map(|one| one.sd.powi(-2)).sum();
        let d = level.iter().map(|one| one.d * one.sd.powi(-2)).sum::<f64>() / weight;
        square += level.iter().map(|one| ((one.d - d) / one.sd).powi(2)).sum::<f64>();
        ln_det += level.iter().map(|one| 2.0 * one.sd.ln()).sum::<f64>() + weight.ln();
        Shift { v: level[0].v, d, sd: weight.powf(-0.5) }
    });
    let levels = levels.collect();
    (levels, square, ln_det)
}

fn values(shifts: &[Shift]) -> DVector<f64> {
    DVector::from_iterator(shifts.len(), shifts.iter().map(|shift| shift.d))
}

fn factor(shifts: &[Shift], stiffness: Option<Stiffness>) -> Option<Cholesky<f64, Dyn>> {
    let between = |i: usize, j: usize| {
        let bending = stiffness
            .map_or(0.0, |stiffness| stiffness.size.powi(2) * covariance(shifts[i].v, shifts[j].v, stiffness.length));
        if i == j { bending + shifts[i].sd.powi(2) } else { bending }
    };
    DMatrix::from_fn(shifts.len(), shifts.len(), between).cholesky()
}

/// Points of a table: one for each 8-bit code.
pub(super) const POINTS: usize = 256;
/// Least rise from point to point, so that a table can be turned round.
const LEAST_RISE: f64 = 1e-9;

/// The bent curve as a table from 0 to 1, rising: the light of i/255; and the light at 1 relative to the straight curve's.
pub(super) fn table(shape: Shape, bend: &Bend) -> (Vec<f64>, f64) {
    let mut moved: Vec<f64> = (0..POINTS)
        .map(|i| {
            let v = i as f64 / (POINTS - 1) as f64;
            (v + bend.shift(v)).max(0.0)
        })
        .collect();
    isotonic(&mut moved);
    let mut light: Vec<f64> = moved.iter().map(|v| shape.light(*v)).collect();
    let (dark, white) = (light[0], light[POINTS - 1]);
    light[0] = 0.0;
    for i in 1..POINTS {
        light[i] = ((light[i] - dark) / (white - dark)).max(light[i - 1] + LEAST_RISE);
    }
    let top = light[POINTS - 1];
    light.iter_mut().for_each(|light| *light /= top);
    (light, white)
}

/// The nearest sequence that never falls, by pooling adjacent violators.
fn isotonic(values: &mut [f64]) {
    let mut blocks: Vec<(f64, usize)> = Vec::with_capacity(values.len());
    for value in values.iter() {
        let mut block = (*value, 1);
        while let Some(&(mean, n)) = blocks.last()
            && mean > block.0
        {
            blocks.pop();
            block = ((mean * n as f64 + block.0 * block.1 as f64) / (n + block.1) as f64, n + block.1);
        }
        blocks.push(block);
    }
    let pooled = blocks.iter().flat_map(|(mean, n)| std::iter::repeat_n(*mean, *n));
    values.iter_mut().zip(pooled).for_each(|(value, pooled)| *value = pooled);
}
