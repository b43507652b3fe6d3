//! Models of how a display's light rises with the encoded value, fitted by weighted least squares.
//!
//! For a given shape, black and the ranges follow in closed form. The shape's own parameters, at most two, are fitted
//! by the Levenberg–Marquardt method. The monotone table is a curve whose encoded values are shifted, level by level, to
//! meet the readings. Between levels, the shift changes linearly, so the table bends like the curve and has no corners.

use nalgebra::{Matrix2, Vector2};

use super::readings::{Readings, is_same_level};
use crate::{
    display::channel::Channel,
    light::{Transfer, TransferTable},
    text::names::named,
};

/// The noise assumed for the weights, relative to the light: a photometer's noise is roughly proportional to its
/// reading.
pub(super) const ASSUMED_NOISE: f64 = 0.01;
/// Noise below this, relative to the largest reading, counts as 0.
const MIN_NOISE: f64 = 1e-8;
/// The ranges of exponents and offsets to search.
const RANGES: [(f64, f64); 2] = [(0.3, 6.0), (-0.6, 0.4)];
/// Pairs of exponent and offset to start from.
const STARTS: [[f64; 2]; 2] = [[2.2, 0.03], [2.2, -0.03]];
const MAX_STEPS: usize = 80;
/// A relative improvement of the weighted sum of squares at or below this counts as 0.
const CONVERGED: f64 = 1e-13;
/// The damping at which the fit stops because no step improves it.
const STUCK: f64 = 1e12;

named! {
    /// A family of curves; the simplest come first.
    Family, FamilyError {
        /// The curve of sRGB.
        Srgb = "srgb",
        /// A power, V^γ.
        Gamma = "gamma",
        /// Gain, offset and gamma, (gain·V + offset)^γ with gain + offset = 1.
        Gog = "gog",
        /// A monotone table through the readings.
        Table = "table",
    }
}

impl Family {
    /// The number of free parameters of the shape.
    fn free(self) -> usize {
        match self {
            Self::Srgb => 0,
            Self::Gamma => 1,
            Self::Gog | Self::Table => 2,
        }
    }

    /// Returns the shape with these parameters; a table starts from the shape of gain, offset and gamma.
    fn transfer(self, [gamma, offset]: [f64; 2]) -> Transfer {
        let made = match self.free() {
            0 => Ok(Transfer::Srgb),
            1 => Transfer::gamma(gamma),
            _ => Transfer::gog(gamma, 1.0 - offset, offset),
        };
        // Within [`RANGES`], every shape is plausible for a display.
        made.unwrap_or(Transfer::Srgb)
    }
}

/// The light of one channel, L = black + range·transfer(V).
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The light at V = 0, cd/m².
    pub black_cd_m2: f64,
    /// The light that V = 1 adds to black, cd/m².
    pub range_cd_m2: f64,
    /// The shape of the curve between the two.
    pub transfer: Transfer,
    /// Standard error of γ, if the curve has one and the noise is as large as the residuals of the fit.
    pub gamma_se: Option<f64>,
}

impl Curve {
    /// Returns the luminance of the encoded value `v`, 0…1, in cd/m².
    pub fn cd_m2(&self, v: f64) -> f64 {
        self.black_cd_m2 + self.range_cd_m2 * self.transfer.linear_from_encoded(v)
    }

    /// Returns the encoded value that gives a luminance; 0 for black and below. Above white, where noise can put a
    /// reading, the curve continues as a straight line.
    pub fn encoded(&self, cd_m2: f64) -> f64 {
        let light = (cd_m2 - self.black_cd_m2) / self.range_cd_m2;
        let last = 1.0 / 255.0;
        let slope = (1.0 - self.transfer.linear_from_encoded(1.0 - last)) / last;
        if light > 1.0 { 1.0 + (light - 1.0) / slope } else { self.transfer.encoded_from_linear(light) }
    }

    /// The exponent, if the curve has one.
    pub fn gamma(&self) -> Option<f64> {
        match &self.transfer {
            Transfer::Gamma(gamma) => Some(*gamma),
            Transfer::Gog(gog) => Some(gog.gamma),
            _ => None,
        }
    }

    /// Gain and offset, if the curve has them.
    pub fn gain_and_offset(&self) -> Option<(f64, f64)> {
        match &self.transfer {
            Transfer::Gog(gog) => Some((gog.gain, gog.offset)),
            _ => None,
        }
    }
}

/// One reading, as used in the fit.
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

/// The readings that are fitted together.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub channels: Vec<Channel>,
    pub points: Vec<Point>,
}

impl Sample {
    /// The weights come from a first fit, so that readings that are too dark because of noise do not get more weight.
    pub fn new(readings: &Readings) -> Self {
        // The noise in the dark is the rounding to the photometer's last digit.
        let floor = (readings.resolution_cd_m2() / 12f64.sqrt()).max(MIN_NOISE * readings.largest_cd_m2());
        let sd = |cd_m2: f64| (ASSUMED_NOISE * cd_m2).hypot(floor);
        let points = readings.all().iter().map(|one| {
            let y = one.luminance_cd_m2;
            Point { channel: one.channel, v: one.level, y, sd: sd(y) }
        });
        let mut sample = Self { channels: readings.channels().to_vec(), points: points.collect() };
        let first = fit(Family::Gog, false, &sample, None);
        let sds: Vec<f64> = sample.pairs(&first.curves).map(|(point, curve)| sd(curve.cd_m2(point.v))).collect();
        sample.points.iter_mut().zip(sds).for_each(|(point, sd)| point.sd = sd);
        sample
    }

    /// Pairs each point with its channel's curve.
    fn pairs<'a>(&'a self, curves: &'a [Curve]) -> impl Iterator<Item = (&'a Point, &'a Curve)> {
        self.points.iter().map(|point| (point, &curves[self.index(point)]))
    }

    fn index(&self, point: &Point) -> usize {
        self.channels.iter().position(|channel| *channel == point.channel).unwrap_or(0)
    }

    /// Returns the points of a channel, including the black of all channels, which is the same patch.
    fn of(&self, channel: Channel) -> Self {
        let own = self.points.iter().filter(|point| point.channel == channel || point.v == 0.0);
        Self { channels: vec![channel], points: own.map(|point| Point { channel, ..*point }).collect() }
    }

    /// Returns the points at all other levels.
    pub fn without(&self, levels: &[f64]) -> Self {
        let is_left_out = |v: f64| {
            // A level that differs only by rounding is next to its place in the order.
            let at = levels.partition_point(|level| *level < v);
            levels[at.saturating_sub(1)..levels.len().min(at + 1)].iter().any(|level| is_same_level(v, *level))
        };
        let rest = self.points.iter().filter(|point| !is_left_out(point.v));
        Self { channels: self.channels.clone(), points: rest.copied().collect() }
    }

    /// Returns the levels strictly between 0 and 1, in ascending order.
    pub fn inner_levels(&self) -> Vec<f64> {
        let mut levels: Vec<f64> = self.points.iter().map(|point| point.v).filter(|v| *v > 0.0 && *v < 1.0).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|a, b| is_same_level(*a, *b));
        levels
    }

    /// Returns the mean of a channel's points at a level, and the standard error of that mean; `None` if there are no
    /// such points. Black is the same patch in every channel.
    pub fn mean(&self, channel: Channel, level: f64) -> Option<(f64, f64)> {
        let is_wanted = |point: &&Point| is_same_level(point.v, level) && (level == 0.0 || point.channel == channel);
        let points: Vec<&Point> = self.points.iter().filter(is_wanted).collect();
        let n = points.len() as f64;
        Some((points.iter().map(|point| point.y).sum::<f64>() / n, points.first()?.sd / n.sqrt()))
    }
}

/// A model fitted to a sample.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// The curves, in the order of the sample's channels.
    pub curves: Vec<Curve>,
    /// Weighted residual sum of squares, divided by the degrees of freedom.
    pub variance: f64,
    /// γ and offset of each shape.
    shapes: Vec<[f64; 2]>,
}

/// Fits a model: one shape and one black for all channels if `shared`, otherwise a separate shape and black for each
/// channel; a table is made from them. Starts from another fit of the same model, if given.
pub(super) fn fit(family: Family, shared: bool, sample: &Sample, start: Option<&Fit>) -> Fit {
    let parts = match shared {
        true => vec![sample.clone()],
        false => sample.channels.iter().map(|channel| sample.of(*channel)).collect(),
    };
    let mut all = Fit { curves: Vec::new(), variance: 0.0, shapes: Vec::new() };
    for (index, part) in parts.iter().enumerate() {
        let starts = start.map_or(&STARTS[..], |fit| &fit.shapes[index..=index]);
        let fits = starts.iter().map(|start| descend(family, part, *start));
        let Some(best) = fits.reduce(|a, b| if b.variance < a.variance { b } else { a }) else { continue };
        all.curves.extend(best.curves);
        all.shapes.extend(best.shapes);
        all.variance += best.variance / parts.len() as f64;
    }
    if family == Family::Table {
        all.curves = tables(sample, &all.curves, shared);
    }
    all
}

/// Returns the curves of the shape `transfer` with the black and the ranges that fit best.
fn curves(transfer: &Transfer, sample: &Sample) -> Vec<Curve> {
    // For each channel, the weighted sums of 1, y, t, t², and t·y, where t is the light of the shape.
    let mut sums = vec![[0.0; 5]; sample.channels.len()];
    for point in &sample.points {
        let (t, weight) = (transfer.linear_from_encoded(point.v), point.sd.powi(-2));
        let values = [1.0, point.y, t, t * t, t * point.y];
        sums[sample.index(point)].iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    }
    let over: f64 = sums.iter().map(|[_, y, t, tt, ty]| y - t * ty / tt).sum();
    let under: f64 = sums.iter().map(|[n, _, t, tt, _]| n - t * t / tt).sum();
    let black_cd_m2 = (over / under).max(0.0);
    let range = |[_, _, t, tt, ty]: &[f64; 5]| ((ty - black_cd_m2 * t) / tt).max(f64::MIN_POSITIVE);
    let curve = |sums| Curve { black_cd_m2, range_cd_m2: range(sums), transfer: transfer.clone(), gamma_se: None };
    sums.iter().map(curve).collect()
}

fn descend(family: Family, sample: &Sample, start: [f64; 2]) -> Fit {
    // The distance of each point from its channel's curve, in standard deviations.
    let residuals = |shape: Vector2<f64>| -> Vec<f64> {
        let curves = curves(&family.transfer(shape.into()), sample);
        sample.pairs(&curves).map(|(point, curve)| (point.y - curve.cd_m2(point.v)) / point.sd).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let free = family.free();
    let mut shape = Vector2::from(start);
    let mut left = residuals(shape);
    let mut damping = 1e-4;
    let mut normal = Matrix2::identity();
    for _ in 0..MAX_STEPS {
        // The decrease of the residuals per unit of each parameter.
        let h = 1e-6;
        let slopes: Vec<Vec<f64>> = (0..free)
            .map(|parameter| {
                let moved = |by: f64| residuals(shape + Vector2::ith(parameter, by));
                moved(-h).iter().zip(moved(h)).map(|(down, up)| (down - up) / (2.0 * h)).collect()
            })
            .collect();
        let mut gradient = Vector2::zeros();
        for i in 0..free {
            gradient[i] = dot(&slopes[i], &left);
            (0..free).for_each(|j| normal[(i, j)] = dot(&slopes[i], &slopes[j]));
        }
        let before = dot(&left, &left);
        let mut gained = None;
        while gained.is_none() && damping < STUCK {
            let damped = normal + Matrix2::from_diagonal(&(normal.diagonal() * damping));
            let by = damped.try_inverse().unwrap_or_else(Matrix2::zeros) * gradient;
            let next = Vector2::from_fn(|i, _| (shape[i] + by[i]).clamp(RANGES[i].0, RANGES[i].1));
            let after = residuals(next);
            if dot(&after, &after) < before {
                gained = Some(before - dot(&after, &after));
                (shape, left) = (next, after);
                damping = (damping * 0.1).max(1e-15);
            } else {
                damping *= 10.0;
            }
        }
        if gained.is_none_or(|gain| gain <= CONVERGED * before) {
            break;
        }
    }
    let parameters = free + sample.channels.len() + 1;
    let variance = dot(&left, &left) / (left.len() as f64 - parameters as f64).max(1.0);
    let gamma_se = normal.try_inverse().filter(|_| free > 0).map(|inverse| (variance * inverse[(0, 0)]).sqrt());
    let mut curves = curves(&family.transfer(shape.into()), sample);
    curves.iter_mut().for_each(|curve| curve.gamma_se = gamma_se.filter(|se| se.is_finite()));
    Fit { curves, variance, shapes: vec![shape.into()] }
}

/// Points of a table: one per 8-bit code.
const POINTS: usize = 256;
/// Minimum rise from point to point, so that a table can be inverted.
const MIN_RISE: f64 = 1e-9;
/// A reading this close to black, in standard deviations, carries no information about the encoded value.
const CLEAR: f64 = 3.0;

/// An encoded value, the shifted value at which the curve gives the light that was read, and its weight.
#[derive(Clone, Copy)]
struct Knot {
    v: f64,
    moved: f64,
    weight: f64,
}

/// Makes the tables of the sample's channels from the curves of a fit. The tables pass through the black and the white
/// that were read; in between, all channels have the same table if `shared`.
fn tables(sample: &Sample, curves: &[Curve], shared: bool) -> Vec<Curve> {
    let levels = sample.inner_levels();
    let mut ends = Vec::new();
    let mut knots: Vec<Vec<Knot>> = Vec::new();
    for (channel, curve) in sample.channels.iter().zip(curves) {
        let black_cd_m2 = sample.mean(*channel, 0.0).map_or(curve.black_cd_m2, |(black, _)| black);
        let white_cd_m2 = sample.mean(*channel, 1.0).map_or_else(|| curve.cd_m2(1.0), |(white, _)| white);
        let (range_cd_m2, transfer) = (white_cd_m2 - black_cd_m2, curve.transfer.clone());
        let curve = Curve { black_cd_m2, range_cd_m2, transfer, gamma_se: None };
        let knot = |v: &f64| {
            let (y, sd) = sample.mean(*channel, *v)?;
            let spread = 0.5 * (curve.encoded(y + sd) - curve.encoded(y - sd));
            let is_clear = y - black_cd_m2 > CLEAR * sd && spread > 0.0;
            is_clear.then(|| Knot { v: *v, moved: curve.encoded(y).min(1.0), weight: spread.powi(-2) })
        };
        knots.push(levels.iter().filter_map(knot).collect());
        ends.push(curve);
    }
    let all = joined(knots.concat());
    let own = knots.iter().map(|own| if shared { &all } else { own });
    ends.into_iter().zip(own).map(|(curve, own)| Curve { transfer: table(&curve.transfer, own), ..curve }).collect()
}

/// Returns the weighted mean of the knots at each level, in ascending order of level.
fn joined(mut knots: Vec<Knot>) -> Vec<Knot> {
    knots.sort_by(|a, b| a.v.total_cmp(&b.v));
    let levels = knots.chunk_by(|a, b| is_same_level(a.v, b.v));
    levels.filter_map(|level| level.iter().copied().reduce(pooled)).collect()
}

fn pooled(a: Knot, b: Knot) -> Knot {
    let weight = a.weight + b.weight;
    Knot { v: a.v, moved: (a.moved * a.weight + b.moved * b.weight) / weight, weight }
}

fn table(base: &Transfer, knots: &[Knot]) -> Transfer {
    let end = |at: f64| Knot { v: at, moved: at, weight: 1.0 };
    let mut knots = [&[end(0.0)], knots, &[end(1.0)]].concat();
    make_monotone(&mut knots);
    let encoded: Vec<f64> = (0..POINTS).map(|i| i as f64 / (POINTS - 1) as f64).collect();
    let mut linear: Vec<f64> = encoded.iter().map(|v| base.linear_from_encoded(between(&knots, *v))).collect();
    linear[0] = 0.0;
    for i in 1..POINTS {
        linear[i] = linear[i].max(linear[i - 1] + MIN_RISE);
    }
    let top = linear[POINTS - 1];
    linear.iter_mut().for_each(|light| *light /= top);
    TransferTable::new(encoded, linear).map_or_else(|_| base.clone(), Transfer::Table)
}

/// Interpolates the shifted value at the encoded value `v`.
fn between(knots: &[Knot], v: f64) -> f64 {
    let above = knots.partition_point(|knot| knot.v <= v).clamp(1, knots.len() - 1);
    let (low, high) = (knots[above - 1], knots[above]);
    low.moved + (high.moved - low.moved) * (v - low.v) / (high.v - low.v)
}

/// Makes the shifted values monotone by pooling adjacent knots whose shifted values fall.
fn make_monotone(knots: &mut [Knot]) {
    let mut blocks: Vec<(Knot, usize)> = Vec::with_capacity(knots.len());
    for knot in knots.iter() {
        let mut block = (*knot, 1);
        while let Some((last, n)) = blocks.pop_if(|(last, _)| last.moved > block.0.moved) {
            block = (pooled(last, block.0), n + block.1);
        }
        blocks.push(block);
    }
    let moved = blocks.iter().flat_map(|(block, n)| std::iter::repeat_n(block.moved, *n));
    knots.iter_mut().zip(moved).for_each(|(knot, moved)| knot.moved = moved);
}
