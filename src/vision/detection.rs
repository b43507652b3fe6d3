//! Whether an average observer detects a picture at all: its contrast relative to the threshold.

use super::{
    error::{VisionError, check},
    eye::{Eye, Sensitivity},
    grid::{ENOUGH_PX_PER_DEG, Grid, Lookup, averaged, coarser, within},
    transforms::{Cosines, next_fast_length},
};

/// The picture stands on an endless field of its mean light. This is how much of that field is computed, degrees.
const FIELD_DEG: f64 = 2.0;

/// The spectrum of a picture's contrast: light divided by mean light, minus 1.
pub struct ContrastSpectrum {
    cosines: Cosines,
    /// The field that is computed.
    field: Grid,
    /// The size of the picture, pixels; the number of its places in the field; and the first of them: `[across, down]`.
    given: [usize; 2],
    size: [usize; 2],
    first: [usize; 2],
}

impl ContrastSpectrum {
    /// Computes the spectrum of the contrast of a picture of `size` pixels `[across, down]` with its mean light. `light` is
    /// its luminance, row by row; the unit does not matter.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the number of pixels per degree is not above 0, if a light value is negative or not
    /// finite, or if the picture is all black.
    pub fn new(light: &[f64], size: [usize; 2], px_per_deg: f64) -> Result<ContrastSpectrum, VisionError> {
        check(light, size[0], size[1], px_per_deg)?;
        let mean = light.iter().sum::<f64>() / light.len() as f64;
        let contrast: Vec<f64> = light.iter().map(|light| light / mean - 1.0).collect();
        Ok(Self::of(&contrast, size, px_per_deg))
    }

    /// Computes the spectrum of the contrast with a field, row by row, for `size` pixels `[across, down]`.
    pub fn of(contrast: &[f64], given: [usize; 2], px_per_deg: f64) -> ContrastSpectrum {
        let size = coarser(given, px_per_deg / ENOUGH_PX_PER_DEG);
        let contrast = averaged(contrast.to_vec(), given, size);
        let per_deg = [0, 1].map(|axis| px_per_deg * size[axis] as f64 / given[axis] as f64);
        let whole = [0, 1].map(|axis| next_fast_length(size[axis] + (FIELD_DEG * per_deg[axis]).ceil() as usize));
        let (values, first) = within(&contrast, size, whole);
        let field = Grid { size: whole, extent: [0, 1].map(|axis| whole[axis] as f64 / per_deg[axis]) };
        ContrastSpectrum { cosines: Cosines::of(values, whole), field, given, size, first }
    }

    /// Returns the contrast in multiples of the threshold at which `eye` tells the picture from a uniform field of its mean
    /// light: 1 is just visible (84 % correct in a choice between two), 0 is a uniform field. The eye looks at the middle
    /// of the picture.
    pub fn detection(&self, eye: &Eye) -> f64 {
        self.pooled(&eye.sensitivity, |frequency| eye.sensitivity.at(frequency, eye.luminance))
    }

    /// Returns the response of the filter `gain`, with the oblique effect, all over the field.
    fn response(&self, gain: impl Fn(f64) -> f64) -> Vec<f64> {
        let gain = Lookup::new(self.field.finest(), gain);
        self.cosines.at(self.field.size, None, |x, y| {
            let ([right, down], frequency) = (self.field.frequencies(x, y), self.field.frequency(x, y));
            if frequency == 0.0 {
                return 0.0;
            }
            gain.at(frequency) * Sensitivity::oblique(frequency, [right / frequency, down / frequency])
        })
    }

    /// Returns the picture as the filter `gain`, a function of the frequency in cycles per degree, leaves it: each pixel's
    /// value, row by row.
    pub fn filtered(&self, gain: impl Fn(f64) -> f64) -> Vec<f64> {
        let (response, [width, height]) = (self.response(gain), self.given);
        let place = |axis: usize, pixel: usize| self.first[axis] + pixel * self.size[axis] / self.given[axis];
        let at = |i: usize| response[place(1, i / width) * self.field.size[0] + place(0, i % width)];
        (0..width * height).map(at).collect()
    }

    /// Returns the response of the filter `gain`, pooled over space and with the fall-off with eccentricity of
    /// `sensitivity`.
    pub fn pooled(&self, sensitivity: &Sensitivity, gain: impl Fn(f64) -> f64) -> f64 {
        let farthest = self.field.extent[0].hypot(self.field.extent[1]);
        let weight = Lookup::new(farthest, |away| sensitivity.eccentric(away).powf(sensitivity.pooling));
        let shown = [self.first, self.size];
        self.field.pooled(&self.response(gain), shown, sensitivity.pooling, &weight, false)
    }
}
