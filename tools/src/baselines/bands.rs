//! Finds the bands in a model's response.

use super::model::Mark;
use machband::vision::vertex;

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

/// `marks` in the order of their positions, without those that have no strength.
pub fn sorted(mut marks: Vec<Mark>) -> Vec<Mark> {
    marks.retain(|mark| mark.strength > 0.0 && mark.strength.is_finite());
    marks.sort_by(|a, b| a.at_deg.total_cmp(&b.at_deg));
    marks
}

/// Degrees from the middle of a profile of `len` samples to the position `at`, in samples.
pub fn degrees(at: f64, len: usize, px_per_deg: f64) -> f64 {
    (at - (len as f64 - 1.0) / 2.0) / px_per_deg
}

/// Whether the light itself has an extremum at `at` (a maximum if `bright`): `near_px` samples away on both sides, it is
/// lower (or higher). At the knee of a ramp, one side is a plateau at the same height.
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

/// The range of `values`.
pub fn range(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    high - low
}
