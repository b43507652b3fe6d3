//! From a model's response to the bands in it.

use super::model::Mark;
use machband::vision::vertex;

/// Part of a response's range below which an extremum is rounding, not a band.
const OF_RESPONSE: f64 = 1e-7;
/// Part of the light's level below which a response is rounding altogether.
const OF_LIGHT: f64 = 1e-12;

/// A local maximum of a response: a stretch of equal samples between lower ones.
struct Peak {
    /// Its first sample.
    first: usize,
    /// Its last sample.
    last: usize,
    /// How far the response falls, on the side where it falls less, before it is higher again or ends.
    prominence: f64,
}

/// The bands of a profile whose predicted brightness is `response`.
///
/// A bright band is a local maximum inside the profile, a dark one a minimum. Its strength is the maximum's
/// height over the higher of the two lowest places that lie, left and right, between it and a higher one or the
/// profile's end: over the plateau beside it, for a ramp between plateaus. `strength` turns that height, at the
/// sample given, into the model's unit. Where the light itself has its extremum, within `near_px` samples, there
/// is no band.
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

/// `marks` in the order of their position, those of no strength left out.
pub fn sorted(mut marks: Vec<Mark>) -> Vec<Mark> {
    marks.retain(|mark| mark.strength > 0.0 && mark.strength.is_finite());
    marks.sort_by(|a, b| a.at_deg.total_cmp(&b.at_deg));
    marks
}

/// Degrees from the middle of a profile of `len` samples to the place `at`, counted in samples.
pub fn degrees(at: f64, len: usize, px_per_deg: f64) -> f64 {
    (at - (len as f64 - 1.0) / 2.0) / px_per_deg
}

/// Whether the light at `at` is itself an extremum, a maximum where `bright`: past it on both sides, `near_px`
/// samples away, it is lower (higher). At the knee of a ramp one side is a plateau, at the same height.
fn lit(light: &[f64], at: f64, near_px: f64, bright: bool) -> bool {
    let end = light.len() - 1;
    // Never less than a sample, or a coarse profile would have no neighbors.
    let near = near_px.max(1.0);
    let value = |at: f64| light[(at.round().max(0.0) as usize).min(end)];
    let least = 1e-9 * range(light);
    let here = value(at);
    let beyond = |other: f64| if bright { here - other > least } else { other - here > least };
    beyond(value(at - near)) && beyond(value(at + near))
}

/// The local maxima inside `values`, in order. An end is no maximum: the profile goes on there as it ends.
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

/// The lowest of the values up to the first that is higher than `height`.
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

/// Largest less smallest of `values`.
pub fn range(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    high - low
}
