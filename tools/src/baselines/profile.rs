//! Code that the one-dimensional models share: their interface, the search for bands in a response, and filters in the
//! frequency domain.

use std::{f64::consts::PI, sync::Arc};

use machband::vision::{
    fft::{self, next_fast_length},
    vertex,
};
use rustfft::{Fft, num_complex::Complex};

/// A band that a one-dimensional model predicts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Position in degrees of visual angle from the middle of the profile, positive toward its end.
    pub at_deg: f64,
    /// Whether it looks brighter than its surround; otherwise, it looks darker.
    pub bright: bool,
    /// Strength in the model's own unit, above 0.
    pub strength: f64,
}

/// A model that predicts bands.
pub trait Baseline {
    /// The model's name, for tables and figures.
    fn name(&self) -> &'static str;

    /// The bands of a profile of linear light, in the order of their position.
    ///
    /// `light` contains samples at pixel centers, `px_per_deg` of them per degree. Beyond its ends, the profile is
    /// constant. There are no bands if the profile has fewer than three samples or a value that is not finite, or if
    /// `px_per_deg` is not above 0 and at most 100 000.
    fn marks(&self, light: &[f64], px_per_deg: f64) -> Vec<Mark>;
}

/// Maximum samples per degree: far beyond the resolution of any eye, but a continued profile still fits into memory.
const MAX_PX_PER_DEG: f64 = 1e5;

/// Whether a model can process this profile at all.
pub fn is_profile(light: &[f64], px_per_deg: f64) -> bool {
    light.len() >= 3 && px_per_deg > 0.0 && px_per_deg <= MAX_PX_PER_DEG && light.iter().all(|value| value.is_finite())
}

/// An extremum below this fraction of the response's range is a rounding error, not a band.
const OF_RESPONSE: f64 = 1e-7;
/// A response below this fraction of the light level is entirely rounding error.
const OF_LIGHT: f64 = 1e-12;

/// A local maximum of a response: a run of equal samples between lower ones.
struct Peak {
    /// Its first sample.
    first: usize,
    /// Its last sample.
    last: usize,
    /// How far the response falls before it rises above the maximum or ends, on the side where it falls less.
    prominence: f64,
}

/// The bands of a profile whose predicted brightness is `response`.
///
/// A bright band is a local maximum inside the profile; a dark band is a local minimum. To the left and right of the
/// maximum, take the lowest value before a higher maximum or the end of the profile. The strength is the height of the
/// maximum above the higher of these two values; for a ramp between plateaus, this is the height above the adjacent
/// plateau. `strength` converts that height, at the given sample, into the model's unit. If the light itself has an
/// extremum within `near_px` samples, there is no band.
pub fn overshoots(
    light: &[f64],
    response: &[f64],
    px_per_deg: f64,
    near_px: f64,
    strength: impl Fn(usize, f64) -> f64,
) -> Vec<Mark> {
    let level = light.iter().fold(0.0, |level: f64, value| level.max(value.abs()));
    let floor = (OF_RESPONSE * range(response)).max(OF_LIGHT * level);
    let mut marks = Vec::new();
    for bright in [true, false] {
        let sign = if bright { 1.0 } else { -1.0 };
        let upright: Vec<f64> = response.iter().map(|value| sign * value).collect();
        for peak in peaks(&upright) {
            let middle = usize::midpoint(peak.first, peak.last);
            if peak.prominence > floor && !lit(light, middle as f64, near_px, bright) {
                let at = if peak.first == peak.last { summit(&upright, middle) } else { center(&peak) };
                let at_deg = degrees(at, light.len(), px_per_deg);
                marks.push(Mark { at_deg, bright, strength: strength(middle, peak.prominence) });
            }
        }
    }
    sorted(marks)
}

/// Sorts `marks` by position and drops any whose strength is not positive and finite.
pub fn sorted(mut marks: Vec<Mark>) -> Vec<Mark> {
    marks.retain(|mark| mark.strength > 0.0 && mark.strength.is_finite());
    marks.sort_by(|a, b| a.at_deg.total_cmp(&b.at_deg));
    marks
}

/// Degrees from the middle of a profile of `len` samples to the position `at`, in samples.
pub fn degrees(at: f64, len: usize, px_per_deg: f64) -> f64 {
    (at - (len as f64 - 1.0) / 2.0) / px_per_deg
}

/// Whether the light itself has an extremum at `at` (a maximum if `bright`): `near_px` samples away on both sides, it
/// is lower (or higher). At the knee of a ramp, one side is a plateau at the same height.
fn lit(light: &[f64], at: f64, near_px: f64, bright: bool) -> bool {
    let end = light.len() - 1;
    // At least one sample; otherwise, a coarse profile would have no neighbors.
    let near = near_px.max(1.0);
    let value = |at: f64| light[(at.round().max(0.0) as usize).min(end)];
    let least = 1e-9 * range(light);
    let here = value(at);
    let beyond = |other: f64| if bright { here - other > least } else { other - here > least };
    beyond(value(at - near)) && beyond(value(at + near))
}

/// The local maxima inside `values`, in order. An end is not a maximum, because the profile is constant beyond it.
fn peaks(values: &[f64]) -> Vec<Peak> {
    let mut found = Vec::new();
    let mut first = 1;
    while first + 1 < values.len() {
        let height = values[first];
        let last = first + values[first..].iter().take_while(|value| **value == height).count() - 1;
        if values[first - 1] < height && last + 1 < values.len() && values[last + 1] < height {
            let left = lowest(height, values[..first].iter().rev());
            let right = lowest(height, values[last + 1..].iter());
            found.push(Peak { first, last, prominence: height - left.max(right) });
        }
        first = last + 1;
    }
    found
}

/// The lowest value before the first one that is higher than `height`.
fn lowest<'a>(height: f64, values: impl Iterator<Item = &'a f64>) -> f64 {
    values.take_while(|value| **value <= height).fold(height, |lowest, value| lowest.min(*value))
}

fn center(peak: &Peak) -> f64 {
    f64::midpoint(peak.first as f64, peak.last as f64)
}

/// Where the parabola through a maximum and its neighbors is highest.
fn summit(values: &[f64], at: usize) -> f64 {
    at as f64 + vertex(values[at - 1], values[at], values[at + 1])
}

/// The difference between the largest and the smallest value.
pub fn range(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    high - low
}

/// A one-dimensional profile, extended at both ends by its end values, ready to be filtered.
pub struct Spectrum {
    values: Vec<Complex<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// The number of samples in the profile, and the number of extension samples before them.
    len: usize,
    before: usize,
    px_per_deg: f64,
}

impl Spectrum {
    /// The spectrum of `light`, with `px_per_deg` samples per degree, for filters that extend `reach_deg` degrees.
    ///
    /// The extended profile is treated as periodic: it jumps from its end to its beginning. The extension is so long
    /// that this jump does not affect any filter inside the profile.
    pub fn new(light: &[f64], px_per_deg: f64, reach_deg: f64) -> Self {
        let before = (reach_deg * px_per_deg).ceil().max(1.0) as usize;
        let size = next_fast_length(light.len() + 2 * before);
        let at = |i: usize| light[i.saturating_sub(before).min(light.len() - 1)];
        // Half of the extra samples extend the end, and half the beginning.
        let mut values: Vec<_> = (0..size).map(|i| Complex::new(at(i), 0.0)).collect();
        fft::forward(size).process(&mut values);
        Self { values, inverse: fft::inverse(size), len: light.len(), before, px_per_deg }
    }

    /// Applies two filters at once. `transfer(f)` is their transfer function at f cycles per degree, for both signs of
    /// f. Both filters are real, so the first result can be the real part and the second the imaginary part.
    pub fn filtered(&self, transfer: impl Fn(f64) -> [Complex<f64>; 2]) -> [Vec<f64>; 2] {
        let size = self.values.len();
        let step = self.px_per_deg / size as f64;
        let mut values: Vec<_> = (0..size)
            .map(|i| {
                // The Nyquist frequency has no sign, so an odd filter has no response there.
                let signed = if 2 * i > size { i as f64 - size as f64 } else { i as f64 };
                let [a, b] = transfer(signed * step);
                (a + b * Complex::i()) * self.values[i]
            })
            .collect();
        self.inverse.process(&mut values);
        let inside = &values[self.before..self.before + self.len];
        let scale = 1.0 / size as f64;
        [inside.iter().map(|v| v.re * scale).collect(), inside.iter().map(|v| v.im * scale).collect()]
    }
}

/// The transfer function at `f` cycles per degree of a Gaussian with standard deviation `sigma_deg` degrees and area 1.
pub fn gaussian(sigma_deg: f64, f: f64) -> f64 {
    let turn = 2.0 * PI * sigma_deg * f;
    (-0.5 * turn * turn).exp()
}
