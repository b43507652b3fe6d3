//! A ramp, quantised: the few places across it where a code changes.

use super::mach_band::{Ramp, light};
use crate::light::{Interpolation, Quantizer};

/// Doubt about where a step lies, in u: the interpolation's last digits may wobble by this much.
/// Far more than they do.
const DOUBT_U: f64 = 1e-14;
/// Doubt about where a pixel lies, in window sides: a few roundings of numbers below 1.
const DOUBT_X: f64 = 4e-15;

/// A change of codes: before `x` (window sides across the ramp), the codes of the step before;
/// after it, `after`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Step {
    pub x: f64,
    pub after: [u8; 3],
}

/// The codes across the ramp, from the darker side to the brighter, or the other way round.
///
/// True for every pixel further from all steps than `doubt`. Nearer than that, the pixel itself
/// must be asked.
#[derive(Clone, Debug)]
pub(super) struct Staircase {
    pub first: [u8; 3],
    /// In order of x, which never repeats.
    pub steps: Vec<Step>,
    /// In window sides.
    pub doubt: f64,
}

/// Codes of a pixel of relative luminance `luminance`. `quantizer` has 8 bits.
#[inline]
pub(super) fn codes(weights: [f64; 3], luminance: f64, quantizer: &Quantizer) -> [u8; 3] {
    quantizer.codes(light(weights, luminance)).map(|code| code as u8)
}

impl Staircase {
    pub fn new(ramp: &Ramp, weights: [f64; 3], quantizer: &Quantizer) -> Self {
        let first = codes(weights, ramp.low, quantizer);
        let end = codes(weights, ramp.high, quantizer);
        if ramp.width == 0.0 {
            let steps = if first == end { vec![] } else { vec![Step { x: 0.0, after: end }] };
            return Self { first, steps, doubt: DOUBT_X };
        }
        let doubt_u = doubt_u(&ramp.interpolation);
        let transfers = quantizer.transfers().channels();
        let alike = |a: usize, b: usize| weights[a] == weights[b] && transfers[a] == transfers[b];
        let mut changes: Vec<(f64, usize, u8)> = Vec::new();
        for channel in 0..3 {
            // Channels that are alike change together: the first of them stands for all.
            if (0..channel).all(|before| !alike(before, channel)) {
                // A display with a dark toe skips codes: they have one threshold, and must have one place.
                let (mut last, mut u) = (None, 0.0);
                changes.extend((first[channel]..end[channel]).map(|code| {
                    let threshold = quantizer.channel(channel).threshold(u16::from(code) + 1);
                    if last != Some(threshold) {
                        // Never before the code below, whatever the last digits do.
                        u = reach(ramp, weights[channel], threshold, doubt_u, u).max(u);
                        last = Some(threshold);
                    }
                    (u, channel, code + 1)
                }));
            }
        }
        // By u; where several codes of a channel share one, the largest comes last and stays.
        changes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let mut steps: Vec<Step> = Vec::with_capacity(changes.len());
        let mut after = first;
        for (u, channel, code) in changes {
            for (twin, after) in after.iter_mut().enumerate() {
                if alike(twin, channel) {
                    *after = code;
                }
            }
            let x = (u - 0.5) * ramp.width;
            match steps.last_mut() {
                Some(step) if step.x == x => step.after = after,
                _ => steps.push(Step { x, after }),
            }
        }
        Self { first, steps, doubt: doubt_u * ramp.width + DOUBT_X }
    }

    /// The staircase along −x.
    pub fn reversed(&self) -> Self {
        let first = self.before(self.steps.len());
        let steps = (0..self.steps.len()).rev();
        let steps = steps.map(|k| Step { x: -self.steps[k].x, after: self.before(k) }).collect();
        Self { first, steps, doubt: self.doubt }
    }

    /// The codes before step `k`; after the last one if `k` is their number.
    pub fn before(&self, k: usize) -> [u8; 3] {
        if k == 0 { self.first } else { self.steps[k - 1].after }
    }
}

/// How far from a step the interpolation may still be on its other side, in u.
fn doubt_u(interpolation: &Interpolation) -> f64 {
    // Finite depths rise by at least 1/e for every e-fold of u or of 1 − u, so their rounding is as
    // small in u. A tanh may be as flat as its k is small.
    let middle_slope = interpolation.slope(0.5);
    if middle_slope < 1.0 { DOUBT_U / middle_slope } else { DOUBT_U }
}

/// The u, to within half of `doubt`, from which the channel of weight `weight` has at least the
/// light `threshold`: sooner if it is near `near`. The lower plateau has less, the upper one at least as much.
fn reach(ramp: &Ramp, weight: f64, threshold: f32, doubt: f64, near: f64) -> f64 {
    // The rounding to f32 is part of the definition, so the function itself decides.
    let reached = |u: f64| (weight * ramp.luminance_at_u(u)) as f32 >= threshold;
    // Half-way to the float below: from there on rounding ends at the threshold.
    let rounds_up = 0.5 * (f64::from(threshold) + f64::from(threshold.next_down()));
    let part = (rounds_up / weight - ramp.low) / (ramp.high - ramp.low);
    let guess = ramp.interpolation.inverse_near(part, near);
    if reached(guess + 0.5 * doubt) && !reached(guess - 0.5 * doubt) {
        return guess;
    }
    // In flat parts the roundings of L move the step away from where algebra has it.
    let (mut below, mut above) = (-f64::EPSILON, 1.0);
    while above - below > 0.25 * doubt {
        let middle = 0.5 * (below + above);
        if middle <= below || middle >= above {
            break;
        }
        if reached(middle) { above = middle } else { below = middle }
    }
    above
}
