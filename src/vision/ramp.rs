//! The bright and the dark band of a ramp: how visible it is that the ramp is not a smooth edge.

use super::{error::VisionError, judge::Judge};
use statrs::function::erf::erf;

/// The nearest smooth edge is sought among those with up to this multiple of the blur that has the ramp's spread, and
/// down to the same part of it.
const REACH: f64 = 4.0;
/// Number of blurs that are tried first, at equal ratios.
const FIRST: u32 = 7;
/// The nearest blur is found to within this proportion.
const PRECISION: f64 = 4e-3;
/// The smallest blur, pixels: the edge is as good as a step.
const SHARP_PX: f64 = 0.05;

/// How visible the bands of a ramp are: the difference from the nearest smooth edge, in times threshold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RampBands {
    /// On the light side, where the ramp looks brighter than the edge.
    pub bright: f64,
    /// On the dark side, where it looks darker.
    pub dark: f64,
    /// σ of the nearest smooth edge, degrees: the Gaussian blur of a step.
    pub blur_deg: f64,
    /// The places of the bright and of the dark band, degrees from the middle of the line.
    pub at_deg: [f64; 2],
}

impl RampBands {
    /// Judges the bands of a line that rises from one plateau to another, or falls, in cd/m². The reference is the
    /// step between the plateaus with the Gaussian blur at which the unmasked difference is smallest, as people's
    /// judgments of blur suggest (Georgeson, May, Freeman & Hesse 2007, J. Vision 7(13):7). A line without a rise has no
    /// bands.
    ///
    /// # Errors
    /// As for [`Judge::difference`].
    pub fn of(judge: &Judge, light: &[f64]) -> Result<RampBands, VisionError> {
        let (Some(first), Some(last)) = (light.first().copied(), light.last().copied()) else {
            return Err(VisionError::TooSmall { width: 0, height: 1, least: 1 });
        };
        if first == last {
            return Ok(RampBands::default());
        }
        let px = judge.extent_deg() / light.len() as f64;
        let middle = 0.5 * (first + last);
        let rise = (last - first).signum();
        let center =
            light.windows(2).position(|pair| (pair[0] - middle) * rise <= 0.0 && (pair[1] - middle) * rise > 0.0);
        let center = center
            .map_or(0.5 * light.len() as f64, |i| i as f64 + 0.5 + (middle - light[i]) / (light[i + 1] - light[i]));
        let edge = |blur: f64| -> Vec<f64> {
            let at = |i: usize| (i as f64 + 0.5 - center) * px / (blur * std::f64::consts::SQRT_2);
            (0..light.len()).map(|i| middle + 0.5 * (last - first) * erf(at(i))).collect()
        };
        let far = |log: f64| Ok(judge.unmasked(light, &edge(log.exp()))?.map().largest());
        let log = nearest(far, (spread(light) * px).ln())?;
        let reference = edge(log.exp());
        let difference = judge.difference(light, &reference, None)?;
        let is_light = |x: f64| (x * light.len() as f64 - center) * rise > 0.0;
        let bright = difference.map_of(|x, response| if is_light(x) { response.max(0.0) } else { 0.0 });
        let dark = difference.map_of(|x, response| if is_light(x) { 0.0 } else { (-response).max(0.0) });
        let at_deg = [&bright, &dark].map(|map| {
            let peak = map.peaks(1, 1.0);
            peak.first().map_or(0.0, |peak| (peak.x as f64 + 0.5 - 0.5 * light.len() as f64) * px)
        });
        Ok(RampBands { bright: bright.largest(), dark: dark.largest(), blur_deg: log.exp(), at_deg })
    }
}

/// Returns the standard deviation of the places at which the line rises or falls, pixels.
fn spread(light: &[f64]) -> f64 {
    let steps = || light.windows(2).map(|pair| (pair[1] - pair[0]).abs()).enumerate();
    let total: f64 = steps().map(|(_, step)| step).sum();
    let mean = steps().map(|(i, step)| i as f64 * step).sum::<f64>() / total;
    let square = steps().map(|(i, step)| (i as f64 - mean).powi(2) * step).sum::<f64>() / total;
    square.sqrt().max(SHARP_PX)
}

/// Returns the logarithm of the blur at which `far` is smallest, near the logarithm `about`.
fn nearest(far: impl Fn(f64) -> Result<f64, VisionError>, about: f64) -> Result<f64, VisionError> {
    let step = 2.0 * REACH.ln() / f64::from(FIRST - 1);
    let least = about - REACH.ln();
    let first = (0..FIRST).map(|i| least + step * f64::from(i));
    let tried = first.map(|log| Ok((log, far(log)?))).collect::<Result<Vec<_>, VisionError>>()?;
    let best = tried.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(least, |(log, _)| *log);
    // Golden section.
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (best - step, best + step);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (far(left)?, far(right)?);
    while high - low > PRECISION {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - ratio * (high - low);
            at_left = far(left)?;
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + ratio * (high - low);
            at_right = far(right)?;
        }
    }
    Ok(0.5 * (low + high))
}
