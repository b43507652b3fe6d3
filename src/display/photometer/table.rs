//! The monotone table: a curve whose encoded values are shifted, level by level, to meet the readings.
//!
//! Between levels, the shift changes linearly, so the table bends like the curve and has no corners.

use super::{
    fit::{Curve, Sample},
    readings::is_same_level,
};
use crate::light::{Transfer, TransferTable};

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
pub(super) fn tables(sample: &Sample, curves: &[Curve], shared: bool) -> Vec<Curve> {
    let levels = sample.inner_levels();
    let mut ends = Vec::new();
    let mut knots: Vec<Vec<Knot>> = Vec::new();
    for (channel, curve) in sample.channels.iter().zip(curves) {
        let black_cd_m2 = sample.mean(*channel, 0.0).map_or(curve.black_cd_m2, |(black, _)| black);
        let white_cd_m2 = sample.mean(*channel, 1.0).map_or_else(|| curve.cd_m2(1.0), |(white, _)| white);
        let curve = Curve { black_cd_m2, range_cd_m2: white_cd_m2 - black_cd_m2, transfer: curve.transfer.clone() };
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
