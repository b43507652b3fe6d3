//! ODOG: oriented differences of Gaussians, Blakeslee and McCourt 1999 (Vision Research 39:4361), as implemented by
//! Robinson, Hammon and de Sa 2007 (Vision Research 47:1631).
//!
//! There are seven filter sizes, one octave apart, at six orientations. Each filter is a round Gaussian center minus a
//! surround that is twice as long along one axis. The responses of all sizes at one orientation are added with weights
//! that increase as f^0.1. Each orientation's sum is divided by its root mean square over the whole image, and the six
//! are added.

use std::{
    f64::consts::{PI, SQRT_2},
    fmt,
    sync::Arc,
};

use machband::vision::fft::{self, next_fast_length};
use rayon::prelude::*;
use rustfft::{Fft, num_complex::Complex};

use super::profile::{Baseline, Mark, Spectrum, gaussian, is_profile, overshoots, range};

/// A response of an orientation below this fraction of the image's range of light is rounding error.
const ROUNDING: f64 = 1e-9;

/// The light beyond the border of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beyond {
    /// The same light everywhere, 0…1.
    Light(f64),
    /// The light of the nearest pixel: the border pixels are repeated.
    Nearest,
}

/// The model. The response to an image is its predicted brightness, in units of the orientations' root mean squares;
/// the mean far from the image is 0. It does not depend on contrast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odog {
    /// Space constant of the smallest center, in degrees: the distance at which it has fallen to 1/e, √2 standard
    /// deviations.
    pub finest_deg: f64,
    /// Number of filter sizes, each twice the previous one.
    pub sizes: u32,
    /// Number of orientations, evenly spaced over half a turn.
    pub orientations: u32,
    /// Length of the surround divided by the length of the center, along the axis of the orientation.
    pub surround: f64,
    /// Exponent: the weight of a filter is its frequency to this power.
    pub slope: f64,
    /// The light beyond the border of an image. A profile is always extended by its end values.
    pub beyond: Beyond,
}

impl Odog {
    /// Space constants from 0.047 to 3 degrees in octaves: Blakeslee and McCourt 1999, table 1, as given by Robinson et
    /// al. 2007 (1.5 to 96 pixels at 32 pixels per degree).
    pub const FINEST_DEG: f64 = 0.046_875;
    /// Blakeslee and McCourt 1999.
    pub const SIZES: u32 = 7;
    /// Blakeslee and McCourt 1999: every 30°.
    pub const ORIENTATIONS: u32 = 6;
    /// Blakeslee and McCourt 1999: center to surround 1:2 along one axis, 1:1 along the other.
    pub const SURROUND: f64 = 2.0;
    /// Blakeslee and McCourt 1999: follows the low-frequency falloff of suprathreshold contrast sensitivity.
    pub const SLOPE: f64 = 0.1;
    /// Robinson et al. 2007: mid-gray around the image.
    pub const BEYOND: Beyond = Beyond::Light(0.5);

    /// The predicted brightness of an image in linear light, with `width` × `height` pixels in rows from the top left
    /// and `px_per_deg` pixels per degree.
    ///
    /// Filters are as large as the image. If a side has an even number of pixels, the center of the filter is between
    /// two pixels, as in Robinson et al.'s program, so the response along that side is shifted by half a pixel.
    ///
    /// The result is empty if `light` does not have that size or contains a value that is not finite. Memory: about 450
    /// bytes per pixel.
    #[must_use]
    pub fn respond(&self, light: &[f32], width: usize, height: usize, px_per_deg: f64) -> Vec<f32> {
        self.filters(width, height, px_per_deg).map_or_else(Vec::new, |filters| filters.respond(light))
    }

    /// The filters for many images of one size; `None` if a side or `px_per_deg` is not positive.
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

    /// Angle of an orientation, in radians.
    fn angle(&self, orientation: u32) -> f64 {
        PI * f64::from(orientation) / f64::from(self.orientations)
    }

    /// Standard deviation of the center for each size, in degrees, and its weight in the sum.
    fn sizes(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let (finest, slope) = (self.finest_deg, self.slope);
        // A common factor does not change the response, so frequency can be 1/size.
        (0..self.sizes).map(move |size| {
            let octaves = f64::from(size);
            (finest * octaves.exp2() / SQRT_2, (-slope * octaves).exp2())
        })
    }

    /// The weighted sum of the filters of all sizes at one angle: `width` × `height` samples, row by row.
    fn kernel(&self, width: usize, height: usize, px_per_deg: f64, angle: f64) -> Vec<f64> {
        let mut kernel = vec![0.0; width * height];
        for (sigma, weight) in self.sizes() {
            let sigma_px = sigma * px_per_deg;
            add_gaussian(&mut kernel, width, height, [sigma_px, sigma_px], angle, weight);
            add_gaussian(&mut kernel, width, height, [sigma_px, self.surround * sigma_px], angle, -weight);
        }
        kernel
    }

    /// The predicted brightness of an unbounded image that varies only along this profile.
    ///
    /// Except near borders, this is exactly the response to the image. The integral of a filter across the profile is a
    /// difference of two Gaussians; the surround at angle θ has the variance σ²(cos²θ + 4 sin²θ). The orientation along
    /// the profile (θ = 0) has no response and drops out. Root mean squares are over the given samples.
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

    /// The transfer function at `f` cycles per degree of an orientation's summed filters, integrated across the
    /// profile.
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

    /// The strength of a band is the overshoot of predicted brightness above the adjacent plateau, in root mean
    /// squares.
    fn marks(&self, light: &[f64], px_per_deg: f64) -> Vec<Mark> {
        if !is_profile(light, px_per_deg) || range(light) <= ROUNDING * light[0].abs() {
            return Vec::new();
        }
        let response = self.respond_to_profile(light, px_per_deg);
        overshoots(light, &response, px_per_deg, self.finest_deg * px_per_deg, |_, over| over)
    }
}

/// The model's filters for images of one size.
#[derive(Debug)]
pub struct OdogFilters {
    bank: Bank,
    beyond: Beyond,
}

impl OdogFilters {
    /// Returns what [`Odog::respond`] returns, for an image of the filters' size.
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
        // A uniform image with a surround of the same light has no response.
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

/// Adds `weight` times a Gaussian of area 1 to `kernel`, which has `width` samples per row. `sigma_px` contains the
/// standard deviations along its two axes; the first axis is at `angle` to the rows. The area is the sum over the
/// existing samples.
fn add_gaussian(kernel: &mut [f64], width: usize, height: usize, sigma_px: [f64; 2], angle: f64, weight: f64) {
    let (sin, cos) = angle.sin_cos();
    let [p, q] = sigma_px.map(|sigma| 0.5 / (sigma * sigma));
    let (xx, yy) = (p * cos * cos + q * sin * sin, p * sin * sin + q * cos * cos);
    let xy = 2.0 * (q - p) * sin * cos;
    // Values beyond ten standard deviations are below rounding error.
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

/// Fills `line` with exp(−(ax² + bx + c)) for x = `first`, `first` + 1, and so on; a > 0.
fn bell(line: &mut [f64], first: f64, [a, b, c]: [f64; 3]) {
    let exponent = |x: f64| -((a * x + b) * x + c);
    // From the peak down both sides: each value is the previous one times a factor, which itself decreases by a factor.
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

/// Distance of the `i`-th of `len` samples from their middle.
fn off(len: usize, i: usize) -> f64 {
    i as f64 - (len as f64 - 1.0) / 2.0
}

/// The indices, among `len` samples, within `reach` of the middle. The middle one or two are always included.
fn within(len: usize, reach: f64) -> std::ops::Range<usize> {
    let half = (len as f64 - 1.0) / 2.0;
    let first = (half - reach.max(0.5)).ceil().max(0.0) as usize;
    first..len - first
}

/// Root mean square of `values`; 0 if there are none.
fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}

/// Filters of one size, ready for images of the same size.
struct Bank {
    width: usize,
    height: usize,
    plane: Plane,
    /// Spectra of the filters, two in each: one real, one imaginary.
    pairs: Vec<Vec<Complex<f64>>>,
    count: usize,
}

impl Bank {
    /// The bank of these filters, each with `width` × `height` samples, row by row.
    fn new(kernels: &[Vec<f64>], width: usize, height: usize) -> Self {
        // Room for the image and for half a filter on either side of it.
        let plane = Plane::new(next_fast_length(2 * width - 1), next_fast_length(2 * height - 1));
        let pairs = kernels
            .chunks(2)
            .map(|pair| {
                let none = Vec::new();
                let second = pair.get(1).unwrap_or(&none);
                plane.spectrum(height, |row, line| {
                    for (column, value) in line.iter_mut().enumerate().take(width) {
                        let at = row * width + column;
                        *value = Complex::new(pair[0][at], second.get(at).copied().unwrap_or(0.0));
                    }
                })
            })
            .collect();
        Self { width, height, plane, pairs, count: kernels.len() }
    }

    /// Number of pixels of an image.
    fn len(&self) -> usize {
        self.width * self.height
    }

    /// The response of every filter to the image. Beyond its border, the light is `outside`; if that is `None`, the
    /// border pixels are repeated. Filters must have no response to uniform light.
    fn filtered(&self, light: &[f32], outside: Option<f64>) -> Vec<Vec<f64>> {
        let (left, top) = (before(self.width), before(self.height));
        // Subtracting the mean or the surround reduces rounding errors and does not change the response.
        let level = outside.unwrap_or_else(|| mean(light));
        let spectrum = self.plane.spectrum(2 * self.height - 1, |row, line| {
            for (column, value) in line.iter_mut().enumerate().take(2 * self.width - 1) {
                let inside = (top..top + self.height).contains(&row) && (left..left + self.width).contains(&column);
                if inside || outside.is_none() {
                    let y = row.saturating_sub(top).min(self.height - 1);
                    let x = column.saturating_sub(left).min(self.width - 1);
                    *value = Complex::from(f64::from(light[y * self.width + x]) - level);
                }
            }
        });
        let through = |pair: &Vec<Complex<f64>>| {
            let product = pair.par_iter().zip(&spectrum).map(|(a, b)| a * b).collect();
            let values = self.plane.inverse(product, self.height - 1, self.height, self.width - 1, self.width);
            [values.iter().map(|v| v.re).collect(), values.iter().map(|v| v.im).collect()]
        };
        // Pairs are processed one after the other: each uses all threads, and the memory for one pair is enough.
        self.pairs.iter().flat_map(through).take(self.count).collect()
    }
}

impl fmt::Debug for Bank {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bank").field("width", &self.width).field("height", &self.height).finish_non_exhaustive()
    }
}

/// Samples of surround before a side of `side` pixels: half a filter, minus one if its center is between two pixels.
fn before(side: usize) -> usize {
    side - 1 - side / 2
}

fn mean(light: &[f32]) -> f64 {
    light.iter().map(|value| f64::from(*value)).sum::<f64>() / light.len().max(1) as f64
}

/// The transforms of a plane of samples. A spectrum is stored column by column.
struct Plane {
    width: usize,
    height: usize,
    rows: [Arc<dyn Fft<f64>>; 2],
    columns: [Arc<dyn Fft<f64>>; 2],
}

impl Plane {
    fn new(width: usize, height: usize) -> Self {
        let both = |size| [fft::forward(size), fft::inverse(size)];
        let (rows, columns) = (both(width), both(height));
        Self { width, height, rows, columns }
    }

    /// The spectrum of a plane. `fill` writes the first `used` rows; all other values are zero.
    fn spectrum(&self, used: usize, fill: impl Fn(usize, &mut [Complex<f64>]) + Sync) -> Vec<Complex<f64>> {
        let mut lines = vec![Complex::default(); self.width * used];
        lines.par_chunks_mut(self.width).enumerate().for_each_init(
            || scratch(&self.rows[0]),
            |scratch, (row, line)| {
                fill(row, line);
                self.rows[0].process_with_scratch(line, scratch);
            },
        );
        let mut columns = transposed(&lines, self.width, 0..self.width, self.height);
        transform(&self.columns[0], &mut columns, self.height);
        columns
    }

    /// The samples of the plane with this spectrum, in `height` rows from `top` and `width` columns from `left`.
    fn inverse(
        &self,
        mut spectrum: Vec<Complex<f64>>,
        top: usize,
        height: usize,
        left: usize,
        width: usize,
    ) -> Vec<Complex<f64>> {
        transform(&self.columns[1], &mut spectrum, self.height);
        let mut lines = transposed(&spectrum, self.height, top..top + height, self.width);
        transform(&self.rows[1], &mut lines, self.width);
        let scale = 1.0 / (self.width * self.height) as f64;
        lines.chunks(self.width).flat_map(|line| line[left..left + width].iter().map(|value| value * scale)).collect()
    }
}

/// Transforms every run of `len` values.
fn transform(fft: &Arc<dyn Fft<f64>>, values: &mut [Complex<f64>], len: usize) {
    values.par_chunks_mut(len).for_each_init(|| scratch(fft), |scratch, line| fft.process_with_scratch(line, scratch));
}

fn scratch(fft: &Arc<dyn Fft<f64>>) -> Vec<Complex<f64>> {
    vec![Complex::default(); fft.get_inplace_scratch_len()]
}

/// Transposes the columns `wanted` of `lines` (of `width` values each) into lines of `len` values. Missing values are
/// 0.
fn transposed(lines: &[Complex<f64>], width: usize, wanted: std::ops::Range<usize>, len: usize) -> Vec<Complex<f64>> {
    /// Columns processed at once, so that a cache line is used while it is still in the cache.
    const BLOCK: usize = 8;
    let mut out = vec![Complex::default(); wanted.len() * len];
    out.par_chunks_mut(BLOCK * len).enumerate().for_each(|(block, out)| {
        let first = wanted.start + block * BLOCK;
        for (row, line) in lines.chunks(width).enumerate() {
            for (i, target) in out.chunks_mut(len).enumerate() {
                target[row] = line[first + i];
            }
        }
    });
    out
}
