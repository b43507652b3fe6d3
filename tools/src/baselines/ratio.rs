//! Wallis and Georgeson 2012: a band is a peak of the second derivative over position and scale. It is visible if the
//! second derivative is large relative to the first.
//!
//! Wallis and Georgeson, *Mach bands and multiscale models of spatial vision*, Journal of Vision 12(13):18.

use std::f64::consts::PI;

use rustfft::num_complex::Complex;

use super::profile::{Baseline, Mark, Spectrum, degrees, gaussian, is_profile, range, sorted};
use machband::vision::vertex;

/// Gaussian derivatives of first and second order at many scales σ, each multiplied by a power of σ:
/// `N_k = σ^α_k · ∂^k(G_σ ∗ I)`.
///
/// A bright band is where −N₂ peaks over position **and** scale; a dark band is where N₂ does. The strength is
/// |N₂|/|N₁| at the peak, a dimensionless number that does not depend on contrast nor, if α₂ = α₁ + 1, on size. A
/// Gaussian-blurred edge, where nobody sees bands, has a strength of √(α₂/2). A peak of this strength or less is not a
/// band.
///
/// A step has no peak: its response only grows as the scale decreases. A peak is not a Mach band either if the blurred
/// light itself has an extremum (its first derivative changes sign) within σ: that is a bar in the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondDerivativeRatio {
    /// Power of σ on the first derivative.
    pub first_power: f64,
    /// Power of σ on the second derivative, above 1 and below 2. At 1, the corner of a ramp has no scale of its own; at
    /// 2, a blurred edge has none.
    pub second_power: f64,
    /// Smallest scale σ, in degrees. If the profile is too coarse for it, the smallest scale is 1½ samples.
    pub smallest_deg: f64,
    /// Largest scale σ, in degrees, and at most the length of the profile. A band is found only if its scale is inside
    /// the range; the scale is about 0.55 of a ramp's width.
    pub largest_deg: f64,
    /// Scales per octave.
    pub per_octave: u32,
    /// Largest ratio at which a peak is not seen as a band.
    pub criterion: f64,
}

impl SecondDerivativeRatio {
    /// α₁ = ½. The first derivative of an edge that is blurred by σ then peaks at the scale σ: Lindeberg (Int. J.
    /// Computer Vision 30:117, 1998, γ = ½ for edges), as in Georgeson, May, Freeman and Hesse's N₁ (J. Vision 7(13):7,
    /// 2007).
    pub const FIRST_POWER: f64 = 0.5;
    /// α₂ = 3⁄2. The second derivative of a Gaussian bar of width σ then peaks at the scale σ: Lindeberg 1998,
    /// γ = ¾ for ridges.
    pub const SECOND_POWER: f64 = 1.5;
    /// How far a peak must exceed the ratio of a Gaussian edge. This is our value; it is above the effect of sampling
    /// on the ratio.
    pub const MARGIN: f64 = 5e-4;

    /// Minimum height of a peak, |N₂|·σ^(2−α₂) divided by the profile's range of light. This is our value; it excludes
    /// fluctuations that no eye could see. At the end of a ramp, the height is about 0.3.
    pub const MIN_HEIGHT: f64 = 1e-4;

    /// |N₂|/|N₁| at the peaks of an edge blurred by a Gaussian, for any blur and contrast, if α₂ = α₁ + 1:
    /// √(α₂/2), 0.866 for α₂ = 3⁄2. (At scale σ and blur b the peak is at x = s, s² = σ² + b², and the ratio σx/s²; it
    /// is largest over σ at σ²/s² = α₂/2.)
    #[must_use]
    pub fn of_blurred_edge(second_power: f64) -> f64 {
        (second_power / 2.0).sqrt()
    }

    /// The scales σ, in degrees and ascending, for a profile of `len` samples with `px_per_deg` samples per degree.
    fn scales(&self, len: usize, px_per_deg: f64) -> Vec<f64> {
        let first = self.smallest_deg.max(1.5 / px_per_deg);
        // A band whose scale is larger than the profile lies outside it.
        let last = self.largest_deg.min(len as f64 / px_per_deg);
        let steps = (f64::from(self.per_octave) * (last / first).log2()).floor().max(0.0) as u32;
        (0..=steps).map(|step| first * (f64::from(step) / f64::from(self.per_octave)).exp2()).collect()
    }

    /// N₁ and N₂ of the profile at the scale `sigma_deg`.
    fn derivatives(&self, spectrum: &Spectrum, sigma_deg: f64) -> [Vec<f64>; 2] {
        let (first, second) = (sigma_deg.powf(self.first_power), sigma_deg.powf(self.second_power));
        spectrum.filtered(|f| {
            let (blur, turn) = (gaussian(sigma_deg, f), 2.0 * PI * f);
            [Complex::new(0.0, first * turn * blur), Complex::from(-second * turn * turn * blur)]
        })
    }
}

impl Default for SecondDerivativeRatio {
    /// The published powers, and scales from 1 minute of arc (about the blur of the eye) to 8 degrees. This range is
    /// our choice; it is wide enough not to affect ramps of 0.05 to 12 degrees.
    fn default() -> Self {
        Self {
            first_power: Self::FIRST_POWER,
            second_power: Self::SECOND_POWER,
            smallest_deg: 1.0 / 60.0,
            largest_deg: 8.0,
            per_octave: 12,
            criterion: Self::of_blurred_edge(Self::SECOND_POWER) + Self::MARGIN,
        }
    }
}

/// A peak over position at one scale.
#[derive(Clone, Copy, Debug)]
struct Crest {
    /// Position in samples.
    at: f64,
    /// Height of the peak: |N₂|.
    height: f64,
    /// |N₂|/|N₁| there.
    ratio: f64,
    /// Whether the blurred light itself has an extremum nearby.
    lit: bool,
}

impl Baseline for SecondDerivativeRatio {
    fn name(&self) -> &'static str {
        "second-derivative ratio"
    }

    fn marks(&self, light: &[f64], px_per_deg: f64) -> Vec<Mark> {
        if !is_profile(light, px_per_deg) || range(light) <= 1e-9 * light[0].abs() {
            return Vec::new();
        }
        let scales = self.scales(light.len(), px_per_deg);
        let spectrum = Spectrum::new(light, px_per_deg, 6.0 * scales[scales.len() - 1]);
        let least = |sigma: f64| Self::MIN_HEIGHT * range(light) * sigma.powf(self.second_power - 2.0);
        let mut crests = [Vec::new(), Vec::new()];
        for &sigma in &scales {
            let [first, second] = self.derivatives(&spectrum, sigma);
            for (list, sign) in crests.iter_mut().zip([-1.0, 1.0]) {
                list.push(crests_of(&first, &second, sign, least(sigma), sigma * px_per_deg));
            }
        }
        let mut marks = Vec::new();
        for (list, bright) in crests.iter().zip([true, false]) {
            for peak in peaks_over_scale(list, &scales, px_per_deg) {
                if peak.ratio > self.criterion && !peak.lit {
                    let at_deg = degrees(peak.at, light.len(), px_per_deg);
                    marks.push(Mark { at_deg, bright, strength: peak.ratio });
                }
            }
        }
        sorted(marks)
    }
}

/// The peaks over position of `sign`·N₂ above `floor`, at a scale of `sigma_px` samples.
fn crests_of(first: &[f64], second: &[f64], sign: f64, floor: f64, sigma_px: f64) -> Vec<Crest> {
    let reach = sigma_px.round() as usize;
    let rounding = 1e-9 * first.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let lit = |i: usize| {
        let (before, after) = (first[i.saturating_sub(reach)], first[(i + reach).min(first.len() - 1)]);
        before * after < 0.0 && before.abs().min(after.abs()) > rounding
    };
    let value = |i: usize| sign * second[i];
    let is_crest = |i: &usize| value(*i) > floor && value(*i) > value(*i - 1) && value(*i) >= value(*i + 1);
    let crest = |i: usize| {
        let (a, b, c) = (value(i - 1), value(i), value(i + 1));
        let off = vertex(a, b, c);
        let height = through([a, b, c], off);
        // The gradient is curved too, but it is nearly straight over one sample.
        let slope = through([first[i - 1], first[i], first[i + 1]], off);
        Crest { at: i as f64 + off, height, ratio: height / slope.abs(), lit: lit(i) }
    };
    (1..second.len() - 1).filter(is_crest).map(crest).collect()
}

/// The peaks over scale along the lines that connect the peaks over position from scale to scale. The first and last
/// points of a line are not peaks.
fn peaks_over_scale(crests: &[Vec<Crest>], scales: &[f64], px_per_deg: f64) -> Vec<Crest> {
    let mut found = Vec::new();
    for scale in 1..crests.len().saturating_sub(1) {
        // From one scale to the next, a line moves by less than the scale.
        let reach = scales[scale] * px_per_deg;
        for &here in &crests[scale] {
            let (Some(fine), Some(coarse)) =
                (nearest(&crests[scale - 1], here, reach), nearest(&crests[scale + 1], here, reach))
            else {
                continue;
            };
            if here.height > fine.height && here.height >= coarse.height {
                found.push(between(fine, here, coarse));
            }
        }
    }
    found
}

/// The crest nearest to `here`, within `reach` samples.
fn nearest(crests: &[Crest], here: Crest, reach: f64) -> Option<Crest> {
    let away = |crest: &Crest| (crest.at - here.at).abs();
    crests.iter().copied().filter(|crest| away(crest) <= reach).min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// Position, height and ratio where the height is largest between neighboring scales.
fn between(fine: Crest, here: Crest, coarse: Crest) -> Crest {
    let off = vertex(fine.height, here.height, coarse.height);
    let at = |get: fn(Crest) -> f64| through([get(fine), get(here), get(coarse)], off);
    Crest { at: at(|crest| crest.at), height: at(|crest| crest.height), ratio: at(|crest| crest.ratio), lit: here.lit }
}

/// The parabola through (−1, a), (0, b) and (1, c), at `off`.
fn through([a, b, c]: [f64; 3], off: f64) -> f64 {
    b + 0.5 * off * (c - a) + 0.5 * off * off * (a + c - 2.0 * b)
}
