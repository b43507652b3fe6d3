//! The bright and the dark band of a ramp: how visible it is that the ramp is not a smooth edge.

use super::{error::VisionError, judge::Judge};
use statrs::function::erf::erf;

/// The nearest smooth edge is sought among those with up to this multiple of the blur that suits the places at which the
/// ramp rises, and down to the same part of it ...
const REACH: f64 = 1.25;
/// ... in this number of equal ratios to either side.
const STEPS: i32 = 4;
/// Edges count with this power of the inverse of their difference, so that the result moves from one to the next without
/// a jump.
const NEARNESS: f64 = 12.0;
/// They are compared at this contrast: what is nearest depends on the shape of the ramp alone.
const CONTRAST: f64 = 0.5;
/// The mean logarithm of the distance from the middle of a Gaussian with σ = 1.
const LOG_DISTANCE: f64 = -0.635_181_422_730_739;
/// The smallest blur, pixels: the edge is as good as a step.
const SHARP_PX: f64 = 1e-3;

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
    ///
    /// # Panics
    /// Panics if the line does not have the judge's size.
    pub fn of(judge: &Judge, light: &[f64]) -> Result<RampBands, VisionError> {
        let (first, last) = (light[0], light[light.len() - 1]);
        if first == last {
            return Ok(RampBands::default());
        }
        let size = light.len() as f64;
        let px = judge.grid.extent[0] / size;
        let rise = (last - first).signum();
        let shares: Vec<f64> = light.iter().map(|value| (value - first) / (last - first)).collect();
        // The edge has as much light as the ramp.
        let center = shares.iter().map(|share| 1.0 - share).sum::<f64>().clamp(0.0, size);
        let edge = |blur: f64| -> Vec<f64> {
            let risen = |at: usize| integral_of_edge(at as f64 - center, blur);
            (0..light.len()).map(|i| risen(i + 1) - risen(i)).collect()
        };
        let middle = 0.5 * (first + last);
        let weak = |shares: &[f64]| -> Vec<f64> {
            let of = |share: &f64| middle * (1.0 + CONTRAST * rise * (2.0 * share - 1.0)).max(1.0 - CONTRAST);
            shares.iter().map(of).collect()
        };
        let (about, ramp) = (suitable_blur(&shares, center).min(size), weak(&shares));
        let try_one = |step: i32| {
            let blur = about * REACH.powf(f64::from(step) / f64::from(STEPS));
            Ok((blur.ln(), judge.unmasked(&ramp, &weak(&edge(blur)))?.map().largest().max(f64::MIN_POSITIVE)))
        };
        let tried = (-STEPS..=STEPS).map(try_one).collect::<Result<Vec<(f64, f64)>, VisionError>>()?;
        let least = tried.iter().map(|(_, far)| *far).fold(f64::INFINITY, f64::min);
        let weighted = tried.iter().map(|(log, far)| (log, (least / far).powf(NEARNESS)));
        let (sum, weights) = weighted.fold((0.0, 0.0), |(sum, all), (log, weight)| (sum + log * weight, all + weight));
        let blur = (sum / weights).exp();
        let reference: Vec<f64> = edge(blur).into_iter().map(|share| first + (last - first) * share).collect();
        let difference = judge.difference(light, &reference, None)?;
        let is_light = |x: f64| (x * size - center) * rise > 0.0;
        let bright = difference.map_of(|x, response| if is_light(x) { response.max(0.0) } else { 0.0 });
        let dark = difference.map_of(|x, response| if is_light(x) { 0.0 } else { (-response).max(0.0) });
        let at_deg = [&bright, &dark].map(|map| {
            let peak = map.peaks(1, 1.0);
            peak.first().map_or(0.0, |peak| (peak.x as f64 + 0.5 - 0.5 * size) * px)
        });
        Ok(RampBands { bright: bright.largest(), dark: dark.largest(), blur_deg: blur * px, at_deg })
    }
}

/// Returns the integral, from far on its dark side to `x`, of an edge that rises from 0 to 1 around 0 with this `blur`.
fn integral_of_edge(x: f64, blur: f64) -> f64 {
    let z = x / blur;
    let density = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    0.5 * x * (1.0 + erf(z * std::f64::consts::FRAC_1_SQRT_2)) + blur * density
}

/// Returns the blur of the edge that rises at the same mean logarithmic distance from `center` as the line that has these
/// shares of its light, in pixels.
fn suitable_blur(shares: &[f64], center: f64) -> f64 {
    // Light rises evenly between the middles of two pixels.
    let integral = |x: f64| if x == 0.0 { 0.0 } else { x * x.abs().ln() - x };
    let square = |share: &dyn Fn(usize) -> f64| {
        let rise = |i: usize| {
            let at = i as f64 - center;
            (share(i) - share(i - 1)) * (integral(at + 0.5) - integral(at - 0.5))
        };
        (2.0 * ((1..shares.len()).map(rise).sum::<f64>() - LOG_DISTANCE)).exp()
    };
    // Less what a step would have in these pixels.
    let step = |i: usize| (i as f64 + 1.0 - center).clamp(0.0, 1.0);
    (square(&|i| shares[i]) - square(&step)).max(SHARP_PX * SHARP_PX).sqrt()
}
