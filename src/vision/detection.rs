//! Whether an average observer detects a picture at all: its contrast relative to the threshold.

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::{
    error::{VisionError, check},
    eye::Eye,
    fft::{next_fast_length, transform},
    sensitivity::Sensitivity,
};
use crate::system::checkpoint;

/// The picture stands on an endless field of its mean light. This is how much of that field is computed, degrees.
const FIELD_DEG: f64 = 2.0;
/// Pictures with at least twice this number of pixels per degree are averaged down to it, or a little more: the eye
/// sees nothing finer.
const ENOUGH_PX_PER_DEG: f64 = 120.0;

/// An image in linear light.
#[derive(Clone, Copy, Debug)]
pub struct LuminanceImage<'a> {
    /// Luminance, row by row, starting at the upper left corner; its unit does not matter.
    pub light: &'a [f64],
    pub width: usize,
    pub height: usize,
    /// Pixels per degree.
    pub px_per_deg: f64,
}

/// Returns the contrast of `picture`, in multiples of the threshold at which `eye` tells it from a uniform field of its
/// mean light: 1 is just visible (84 % correct in a choice between two), 0 is a uniform field. The eye
/// looks at the middle of the picture.
///
/// # Errors
/// Returns a [`VisionError`] if the light has the wrong length, if the number of pixels per degree is not above 0, if a
/// light value is negative or not finite, or if the picture is all black.
pub fn detection(picture: &LuminanceImage, eye: &Eye) -> Result<f64, VisionError> {
    Ok(ContrastSpectrum::new(picture)?.detection(eye))
}

/// The spectrum of a picture's contrast: light divided by mean light, minus 1.
pub struct ContrastSpectrum {
    values: Vec<Complex64>,
    columns: usize,
    rows: usize,
    px_per_deg: f64,
    /// The size of the picture and its first place in the field, `[across, down]`, and the pixels per value.
    size: [usize; 2],
    first: [usize; 2],
    block: usize,
}

impl ContrastSpectrum {
    /// Computes the spectrum of a picture's contrast with its mean light.
    ///
    /// # Errors
    /// As for [`detection`].
    pub fn new(picture: &LuminanceImage) -> Result<ContrastSpectrum, VisionError> {
        check(picture.light, picture.width, picture.height, picture.px_per_deg)?;
        let mean = picture.light.iter().sum::<f64>() / picture.light.len() as f64;
        let contrast: Vec<f64> = picture.light.iter().map(|light| light / mean - 1.0).collect();
        Ok(Self::of(&contrast, [picture.width, picture.height], picture.px_per_deg))
    }

    /// Computes the spectrum of the contrast with a field, row by row, for `size` pixels `[across, down]`.
    #[must_use]
    pub fn of(contrast: &[f64], size: [usize; 2], px_per_deg: f64) -> ContrastSpectrum {
        let block = ((px_per_deg / ENOUGH_PX_PER_DEG) as usize).max(1);
        let px_per_deg = px_per_deg / block as f64;
        let [width, height] = size.map(|side| side.div_ceil(block));
        let field = (FIELD_DEG * px_per_deg).ceil() as usize;
        let [columns, rows] = [width, height].map(|side| next_fast_length(side + field));
        let [left, top] = [(columns - width) / 2, (rows - height) / 2];
        let mut values = vec![Complex64::default(); columns * rows];
        let share = 1.0 / (block * block) as f64;
        for (y, row) in contrast.chunks_exact(size[0]).enumerate() {
            for (x, contrast) in row.iter().enumerate() {
                values[(top + y / block) * columns + left + x / block].re += contrast * share;
            }
        }
        transform(&mut values, columns, rows);
        ContrastSpectrum { values, columns, rows, px_per_deg, size, first: [left, top], block }
    }

    /// Returns the contrast in multiples of the threshold of `eye`, which looks at the middle of the picture.
    #[must_use]
    pub fn detection(&self, eye: &Eye) -> f64 {
        self.pooled(&eye.sensitivity, |frequency| eye.sensitivity.at(frequency, eye.luminance))
    }

    /// Returns the response of the filter `gain`, with the oblique effect, all over the field.
    fn response(&self, gain: impl Fn(f64) -> f64) -> Vec<Complex64> {
        let (columns, rows) = (self.columns, self.rows);
        let signed = |k: usize, n: usize| {
            let k = if 2 * k > n { k as f64 - n as f64 } else { k as f64 };
            k * self.px_per_deg / n as f64
        };
        let scale = 1.0 / self.values.len() as f64;
        let gain = Lookup::new(self.px_per_deg, |frequency| gain(frequency) * scale);
        let mut response = vec![Complex64::default(); self.values.len()];
        let filtered = response.par_chunks_mut(columns).zip(self.values.par_chunks(columns)).enumerate();
        filtered.for_each(|(row, (response, values))| {
            checkpoint();
            let down = signed(row, rows);
            for (column, (response, value)) in response.iter_mut().zip(values).enumerate() {
                let right = signed(column, columns);
                let frequency = (right * right + down * down).sqrt();
                if frequency > 0.0 {
                    let oblique = Sensitivity::oblique(frequency, [right / frequency, down / frequency]);
                    // The conjugate makes the forward transform an inverse one.
                    *response = (value * (gain.at(frequency) * oblique)).conj();
                }
            }
        });
        transform(&mut response, columns, rows);
        response
    }

    /// Returns the picture as the filter `gain`, a function of the frequency in cycles per degree, leaves it: each pixel's
    /// value, row by row.
    #[must_use]
    pub fn filtered(&self, gain: impl Fn(f64) -> f64) -> Vec<f64> {
        let (response, [width, height]) = (self.response(gain), self.size);
        let place =
            |x: usize, y: usize| (self.first[1] + y / self.block) * self.columns + self.first[0] + x / self.block;
        (0..width * height).map(|i| response[place(i % width, i / width)].re).collect()
    }

    /// Returns the response of the filter `gain`, pooled over space and with the fall-off with eccentricity of
    /// `sensitivity`.
    pub fn pooled(&self, sensitivity: &Sensitivity, gain: impl Fn(f64) -> f64) -> f64 {
        let (columns, rows, response) = (self.columns, self.rows, self.response(gain));
        let area = 1.0 / (self.px_per_deg * self.px_per_deg);
        let middle = [columns, rows].map(|n| 0.5 * n as f64 - 0.5);
        let farthest = middle[0].hypot(middle[1]) / self.px_per_deg;
        let weight = Lookup::new(farthest, |away| sensitivity.eccentric(away).powf(sensitivity.pooling));
        let total: f64 = response
            .par_chunks(columns)
            .enumerate()
            .map(|(row, values)| {
                let down = row as f64 - middle[1];
                let each = values.iter().enumerate().map(|(column, value)| {
                    let right = column as f64 - middle[0];
                    let away = (right * right + down * down).sqrt() / self.px_per_deg;
                    value.re.abs().powf(sensitivity.pooling) * weight.at(away)
                });
                each.sum::<f64>()
            })
            .collect::<Vec<f64>>()
            .iter()
            .sum();
        (total * area).powf(1.0 / sensitivity.pooling)
    }
}

/// A function of a number that is not negative, interpolated between values that lie densest near 0.
pub(super) struct Lookup {
    values: Vec<f64>,
    per_root: f64,
}

/// Number of values in a table; the error is below a millionth.
const TABLE: usize = 8192;

impl Lookup {
    pub(super) fn new(most: f64, value: impl Fn(f64) -> f64) -> Lookup {
        let per_root = (TABLE - 2) as f64 / most.sqrt();
        Lookup { values: (0..TABLE).map(|i| value((i as f64 / per_root).powi(2))).collect(), per_root }
    }

    pub(super) fn at(&self, of: f64) -> f64 {
        let at = of.sqrt() * self.per_root;
        let i = (at as usize).min(TABLE - 2);
        self.values[i] + (self.values[i + 1] - self.values[i]) * (at - i as f64)
    }
}
