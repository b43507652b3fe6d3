//! ODOG: oriented differences of Gaussians, Blakeslee and McCourt 1999 (Vision Research 39:4361), as Robinson,
//! Hammon and de Sa 2007 (Vision Research 47:1631) made it a program.
//!
//! Seven sizes of filter in octaves at six orientations. Each filter is a round Gaussian center less a surround
//! twice as long along one axis. The sizes of one orientation are added up with weights that rise as f^0.1, each
//! orientation's sum is divided by its root mean square over the whole picture, and the six are added.

use std::f64::consts::{PI, SQRT_2};

use rayon::prelude::*;
use rustfft::num_complex::Complex;

use super::bands::{overshoots, range};
use super::model::{Baseline, Mark, is_profile};
use super::picture::Bank;
use super::spectrum::{Spectrum, gaussian};

/// Part of a picture's range of light below which the response of an orientation is rounding, not a response.
const ROUNDING: f64 = 1e-9;

/// What lies beyond a picture's border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beyond {
    /// The same light everywhere, 0…1.
    Light(f64),
    /// The light of the nearest pixel: the picture goes on as it ends.
    Nearest,
}

/// The model. A picture's response is its predicted brightness, 0 in the mean of an orientation's far field, in units
/// of the orientations' root mean squares: it knows no contrast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odog {
    /// Space constant of the smallest center, degrees: where it has fallen to 1/e. √2 standard deviations.
    pub finest_deg: f64,
    /// Sizes of filter, each twice the one before.
    pub sizes: u32,
    /// Orientations, evenly spread over half a turn.
    pub orientations: u32,
    /// Length of the surround over the center's along the orientation's axis.
    pub surround: f64,
    /// Power of a filter's frequency that is its weight.
    pub slope: f64,
    /// What lies beyond a picture's border; a profile always goes on as it ends.
    pub beyond: Beyond,
}

impl Odog {
    /// Space constants 0.047 to 3 degrees in octaves: Blakeslee and McCourt 1999, table 1, by way of Robinson et al.
    /// 2007 (1.5 to 96 pixels at 32 pixels a degree).
    pub const FINEST_DEG: f64 = 0.046_875;
    /// Blakeslee and McCourt 1999.
    pub const SIZES: u32 = 7;
    /// Blakeslee and McCourt 1999: every 30°.
    pub const ORIENTATIONS: u32 = 6;
    /// Blakeslee and McCourt 1999: center to surround 1:2 along one axis, 1:1 along the other.
    pub const SURROUND: f64 = 2.0;
    /// Blakeslee and McCourt 1999: after the low-frequency fall of the suprathreshold contrast sensitivity function.
    pub const SLOPE: f64 = 0.1;
    /// Robinson et al. 2007: mid gray around the picture.
    pub const BEYOND: Beyond = Beyond::Light(0.5);

    /// The predicted brightness of a picture of linear light, `width` × `height` pixels in rows from the top left,
    /// `px_per_deg` pixels a degree.
    ///
    /// Filters are as large as the picture, and one of an even number of pixels has its middle between two of them,
    /// as in Robinson et al.'s program: along an even side the response of a pixel is that half a pixel on.
    ///
    /// Empty where `light` is not a picture of that size or a value is not finite. Memory: about 450 bytes a pixel.
    #[must_use]
    pub fn respond(&self, light: &[f32], width: usize, height: usize, px_per_deg: f64) -> Vec<f32> {
        self.filters(width, height, px_per_deg).map_or_else(Vec::new, |filters| filters.respond(light))
    }

    /// The filters for pictures of one size, for many of them; `None` where a side or `px_per_deg` is not positive.
    #[must_use]
    pub fn filters(&self, width: usize, height: usize, px_per_deg: f64) -> Option<OdogFilters> {
        if width == 0 || height == 0 || !(px_per_deg.is_finite() && px_per_deg > 0.0) {
            return None;
        }
        let kernels: Vec<_> = (0..self.orientations)
            .into_par_iter()
            .map(|orientation| self.kernel(width, height, px_per_deg, self.angle(orientation)))
            .collect();
        Some(OdogFilters { bank: Bank::new(&kernels, width, height), beyond: self.beyond })
    }

    /// An orientation's angle, radians.
    fn angle(&self, orientation: u32) -> f64 {
        PI * f64::from(orientation) / f64::from(self.orientations)
    }

    /// Standard deviation of each size's center, degrees, and its weight in the sum.
    fn sizes(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let (finest, slope) = (self.finest_deg, self.slope);
        // The response knows no common factor, so frequency may be 1/size.
        (0..self.sizes).map(move |size| {
            let octaves = f64::from(size);
            (finest * octaves.exp2() / SQRT_2, (-slope * octaves).exp2())
        })
    }

    /// The weighted sum of the filters of all sizes at one angle, `width` × `height` samples, row by row.
    fn kernel(&self, width: usize, height: usize, px_per_deg: f64, angle: f64) -> Vec<f64> {
        let mut kernel = vec![0.0; width * height];
        for (sigma, weight) in self.sizes() {
            let sigma_px = sigma * px_per_deg;
            add_gaussian(&mut kernel, width, height, [sigma_px, sigma_px], angle, weight);
            add_gaussian(&mut kernel, width, height, [sigma_px, self.surround * sigma_px], angle, -weight);
        }
        kernel
    }

    /// The predicted brightness of a profile that goes on unchanged across its own direction, without end.
    ///
    /// This is exactly the picture's response there, the borders apart: a filter's integral across the profile is a
    /// Gaussian less a Gaussian, for a surround at angle θ of variance σ²(cos²θ + 4 sin²θ). The orientation along
    /// the profile (θ = 0) answers nothing and drops out. Root mean squares are over the samples given.
    fn respond_to_profile(&self, light: &[f64], px_per_deg: f64) -> Vec<f64> {
        let widest = self.finest_deg * f64::from(self.sizes).exp2() / (2.0 * SQRT_2);
        let spectrum = Spectrum::new(light, px_per_deg, 6.0 * self.surround * widest);
        let mut sum = vec![0.0; light.len()];
        for pair in (0..self.orientations).collect::<Vec<_>>().chunks(2) {
            let transfer = |orientation: u32, f: f64| Complex::from(self.across(self.angle(orientation), f));
            let responses = spectrum.filtered(|f| [transfer(pair[0], f), transfer(pair[pair.len() - 1], f)]);
            for response in responses.iter().take(pair.len()) {
                let rms = root_mean_square(response.iter().copied());
                if rms > ROUNDING * range(light) {
                    sum.iter_mut().zip(response).for_each(|(sum, value)| *sum += value / rms);
                }
            }
        }
        sum
    }

    /// What an orientation's summed filters, integrated across the profile, leave of `f` cycles a degree.
    fn across(&self, angle: f64, f: f64) -> f64 {
        let (sin, cos) = angle.sin_cos();
        let wider = (cos * cos + (self.surround * sin).powi(2)).sqrt();
        self.sizes().map(|(sigma, weight)| weight * (gaussian(sigma, f) - gaussian(wider * sigma, f))).sum()
    }
}

impl Default for Odog {
    fn default() -> Self {
        Self {
            finest_deg: Self::FINEST_DEG,
            sizes: Self::SIZES,
            orientations: Self::ORIENTATIONS,
            surround: Self::SURROUND,
            slope: Self::SLOPE,
            beyond: Self::BEYOND,
        }
    }
}

impl Baseline for Odog {
    fn name(&self) -> &'static str {
        "ODOG"
    }

    /// A band's strength is the overshoot of predicted brightness over the plateau beside it, in root mean squares.
    fn marks(&self, light: &[f64], px_per_deg: f64) -> Vec<Mark> {
        if !is_profile(light, px_per_deg) || range(light) <= ROUNDING * light[0].abs() {
            return Vec::new();
        }
        let response = self.respond_to_profile(light, px_per_deg);
        overshoots(light, &response, px_per_deg, self.finest_deg * px_per_deg, |_, over| over)
    }
}

/// The model's filters for pictures of one size.
#[derive(Debug)]
pub struct OdogFilters {
    bank: Bank,
    beyond: Beyond,
}

impl OdogFilters {
    /// As [`Odog::respond`], for a picture of these filters' size.
    #[must_use]
    pub fn respond(&self, light: &[f32]) -> Vec<f32> {
        let (low, high) = light.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        if light.len() != self.bank.len() || light.iter().any(|value| !value.is_finite()) {
            return Vec::new();
        }
        let (outside, mut deviation) = match self.beyond {
            Beyond::Light(outside) => (Some(outside), f64::from(high.abs().max(low.abs())).max(outside.abs())),
            Beyond::Nearest => (None, f64::from(high - low)),
        };
        // A uniform picture on its own light has no response at all.
        deviation = deviation.max(f64::MIN_POSITIVE);
        let mut sum = vec![0.0; light.len()];
        for response in self.bank.filtered(light, outside) {
            let rms = root_mean_square(response.iter().copied());
            if rms > ROUNDING * deviation {
                sum.iter_mut().zip(&response).for_each(|(sum, value)| *sum += value / rms);
            }
        }
        sum.into_iter().map(|value| value as f32).collect()
    }
}

/// Adds `weight` times a Gaussian of area 1 to `kernel`, of `width` samples a row. `sigma_px`: its standard deviations
/// along its two axes, the first of which stands at `angle` to the rows. Area is over the samples there are.
fn add_gaussian(kernel: &mut [f64], width: usize, height: usize, sigma_px: [f64; 2], angle: f64, weight: f64) {
    let (sin, cos) = angle.sin_cos();
    let [p, q] = sigma_px.map(|sigma| 0.5 / (sigma * sigma));
    let (xx, yy) = (p * cos * cos + q * sin * sin, p * sin * sin + q * cos * cos);
    let xy = 2.0 * (q - p) * sin * cos;
    // Beyond ten standard deviations there is less than rounding.
    let reach = 10.0 * sigma_px[0].max(sigma_px[1]);
    let (columns, rows) = (within(width, reach), within(height, reach));
    let mut values = vec![0.0; columns.len() * rows.len()];
    for (row, line) in rows.clone().zip(values.chunks_mut(columns.len())) {
        let y = off(height, row);
        bell(line, off(width, columns.start), [xx, xy * y, yy * y * y]);
    }
    let scale = weight / values.iter().sum::<f64>();
    for (row, values) in rows.zip(values.chunks(columns.len())) {
        let line = &mut kernel[row * width..][columns.clone()];
        line.iter_mut().zip(values).for_each(|(sum, value)| *sum += scale * value);
    }
}

/// Fills `line` with exp(−(ax² + bx + c)) for x = `first`, `first` + 1 and so on; a > 0.
fn bell(line: &mut [f64], first: f64, [a, b, c]: [f64; 3]) {
    let exponent = |x: f64| -((a * x + b) * x + c);
    // From its top down both sides: each value is a factor times the last, and the factor itself falls by a factor.
    let walk = |values: &mut dyn Iterator<Item = &mut f64>, x: f64, step: f64| {
        let (mut value, mut factor) = (exponent(x).exp(), (exponent(x + step) - exponent(x)).exp());
        let bend = (-2.0 * a).exp();
        for target in values {
            *target = value;
            value *= factor;
            factor *= bend;
        }
    };
    let top = ((-0.5 * b / a - first).round().max(0.0) as usize).min(line.len() - 1);
    let (before, after) = line.split_at_mut(top);
    walk(&mut after.iter_mut(), first + top as f64, 1.0);
    walk(&mut before.iter_mut().rev(), first + top as f64 - 1.0, -1.0);
}

/// How far the `i`-th of `len` samples is from their middle.
fn off(len: usize, i: usize) -> f64 {
    i as f64 - (len as f64 - 1.0) / 2.0
}

/// The samples of `len` within `reach` of their middle; always the middle one or two.
fn within(len: usize, reach: f64) -> std::ops::Range<usize> {
    let half = (len as f64 - 1.0) / 2.0;
    let first = (half - reach.max(0.5)).ceil().max(0.0) as usize;
    first..len - first
}

/// Root mean square of `values`; 0 without any.
fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}
