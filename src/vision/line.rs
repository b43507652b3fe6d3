//! Prediction along a line, for stimuli that vary in one direction only.

use std::f64::consts::PI;

use rustfft::num_complex::Complex64;

use super::{
    band::{Band, FALL_PERIODS, Polarity, Visibility, peak, strength, unmasked},
    error::{VisionError, check},
    eye::{ADAPTATION_DEG, Border, Channel, Eye, REACH},
    fft::{self, next_fast_length},
};

/// Padding beyond the end of a profile, degrees: one period of the coarsest channel, so that the two ends of the
/// periodic profile do not affect each other.
const BEYOND_DEG: f64 = 16.0;
/// Number of samples of a channel's response per period of the channel.
const SAMPLES_PER_PERIOD: f64 = 16.0;
/// Number of cells per degree for the mean light and the masking energy.
const COARSE_PER_DEG: f64 = 16.0;

/// A profile in linear light.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    /// Luminance, 1 for white, from left to right.
    pub light: &'a [f64],
    /// Pixels per degree.
    pub px_per_deg: f64,
    /// What lies beyond the ends of the profile.
    pub border: Border,
}

/// The prediction for a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinePrediction {
    /// The bands of all channels, sorted by descending strength.
    pub bands: Vec<Band>,
    /// Visibility pooled over all channels.
    pub visibility: Visibility,
}

impl Line<'_> {
    /// Predicts the bands that `eye` sees.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if there are fewer than two samples, if the number of pixels per degree is not above
    /// 0, if a light value is negative or not finite, or if the profile is all black.
    pub fn predict(&self, eye: &Eye) -> Result<LinePrediction, VisionError> {
        check(self.light, self.light.len(), 1, self.px_per_deg)?;
        if self.light.len() < 2 {
            return Err(VisionError::TooSmall { width: self.light.len(), height: 1, least: 2 });
        }
        let spectrum = self.spectrum(eye);
        let mean = self.mean();
        let mut finer = vec![0.0; self.cells()];
        let mut prediction = LinePrediction::default();
        let mut channels = Vec::new();
        // The finest channels come first because they mask the others.
        for channel in Channel::all().rev() {
            let response = self.response(channel, &spectrum);
            let mut strongest = Visibility::default();
            for (mut band, energy) in self.bands(channel, &response, &mean) {
                let cell = ((band.at_deg[0] + self.length() / 2.0) * COARSE_PER_DEG).round().max(0.0) as usize;
                band.strength *= unmasked(energy, finer[cell.min(finer.len() - 1)]);
                strongest.raise_to(band.polarity, band.strength);
                if band.strength > 0.0 {
                    prediction.bands.push(band);
                }
            }
            channels.push(strongest);
            let step = response.len() as f64 / self.repeat() / COARSE_PER_DEG;
            for (i, energy) in finer.iter_mut().enumerate() {
                *energy = f64::max(*energy, response[(i as f64 * step).round() as usize % response.len()].norm());
            }
        }
        prediction.bands.sort_by(|a, b| b.strength.total_cmp(&a.strength));
        prediction.visibility = Visibility::over(&channels);
        Ok(prediction)
    }

    /// Returns the length of the profile, degrees.
    fn length(&self) -> f64 {
        self.light.len() as f64 / self.px_per_deg
    }

    /// Returns the number of samples after which the padded profile repeats.
    fn period(&self) -> usize {
        next_fast_length(self.light.len() + (BEYOND_DEG * self.px_per_deg).ceil() as usize)
    }

    /// Returns the length after which the padded profile repeats, degrees.
    fn repeat(&self) -> f64 {
        self.period() as f64 / self.px_per_deg
    }

    /// Returns the number of cells for the mean light and the masking energy.
    fn cells(&self) -> usize {
        (self.length() * COARSE_PER_DEG).ceil() as usize + 1
    }

    /// Returns the index of the highest frequency of the spectrum that a channel passes.
    fn last_place(&self, channel: Channel) -> usize {
        ((channel.frequency * REACH * self.repeat()).floor() as usize).max(1)
    }

    /// Returns the spectrum of the eye's response to the jumps in light from pixel to pixel: pixels are squares, so
    /// their light is a staircase. Beyond a [`Border::Cut`], the jumps are mirrored and fade out, so that light and
    /// slope continue.
    fn spectrum(&self, eye: &Eye) -> Vec<Complex64> {
        let (n, period, repeat) = (self.light.len(), self.period(), self.repeat());
        let mut jumps = vec![Complex64::default(); period];
        for (i, pair) in self.light.windows(2).enumerate() {
            jumps[i + 1].re = pair[1] - pair[0];
        }
        if self.border == Border::Cut {
            let beyond = ((period - n) / 2).min(n - 1);
            for k in 0..beyond {
                let fade = 0.5 + 0.5 * (PI * (k + 1) as f64 / (beyond + 1) as f64).cos();
                jumps[n + k].re = fade * jumps[n - 1 - k].re;
                jumps[(period - k) % period].re = fade * jumps[1 + k].re;
            }
        }
        fft::forward(period).process(&mut jumps);
        let response = |j: usize| {
            let f = j as f64 / repeat;
            // Dividing by 2πif turns jumps into light. The factor of 2 makes up for the negative frequencies, which are
            // dropped.
            let weight = if j > 0 { eye.sensitivity(f) / (PI * f * repeat) } else { 0.0 };
            jumps[j % period] * Complex64::new(0.0, -weight)
        };
        let last = Channel::all().map(|channel| self.last_place(channel)).max().unwrap_or(0);
        (0..=last).map(response).collect()
    }

    /// Returns a channel's response, even + i·odd, over one period of the padded profile.
    fn response(&self, channel: Channel, spectrum: &[Complex64]) -> Vec<Complex64> {
        let (frequency, repeat, last) = (channel.frequency, self.repeat(), self.last_place(channel));
        let first = ((frequency / REACH * repeat).ceil() as usize).max(1);
        let samples = next_fast_length((SAMPLES_PER_PERIOD * frequency * repeat).ceil() as usize).max(last + 1);
        let mut response = vec![Complex64::default(); samples];
        for j in first..=last {
            response[j] = spectrum[j] * channel.passes_log((j as f64 / repeat).ln() - frequency.ln());
        }
        fft::inverse(samples).process(&mut response);
        response
    }

    /// Returns the bands at the peaks of a channel's energy within the profile, each with the height of its peak.
    fn bands(&self, channel: Channel, response: &[Complex64], mean: &[f64]) -> Vec<(Band, f64)> {
        let (n, length, frequency) = (response.len(), self.length(), channel.frequency);
        let step = self.repeat() / n as f64;
        let margin = self.border.margin_deg(frequency);
        let fall = ((FALL_PERIODS / frequency / step) as usize).min(n / 2);
        // The search for the fall stops where a border already distorts the response.
        let unusable = self.border.unusable_deg(frequency);
        let free = |deg: f64| match self.border {
            Border::Continues => fall,
            Border::Cut => (((deg - unusable) / step).max(0.0) as usize).min(fall),
        };
        let energy: Vec<f64> = response.iter().map(|value| value.norm_sqr()).collect();
        let first = (margin / step).ceil() as usize;
        let end = (((length - margin) / step).floor().max(0.0) as usize + 1).min(n);
        let band = |i: usize| {
            let at = |offset: usize| (i + n + offset) % n;
            let (before, after) = (at(n - 1), at(1));
            if energy[i] <= energy[before] || energy[i] < energy[after] {
                return None;
            }
            let (shift, value) = peak([response[before], response[i], response[after]]);
            let place = (i as f64 + shift) * step;
            let least = |far: usize, toward: &dyn Fn(usize) -> usize| {
                (1..=far).map(|k| energy[toward(k)]).fold(f64::MAX, f64::min)
            };
            let before = least(free(place), &|k| at(n - k));
            let lowest = before.max(least(free(length - place), &|k| at(k))).sqrt();
            let strength = strength(value, lowest, between(mean, place * COARSE_PER_DEG));
            let polarity = if value.re > 0.0 { Polarity::Bright } else { Polarity::Dark };
            let at_deg = [place - length / 2.0, 0.0];
            let band = Band { at_deg, orientation_deg: 0.0, polarity, strength, frequency };
            (strength > 0.0).then_some((band, value.norm()))
        };
        (first..end).filter_map(band).collect()
    }

    /// Returns the mean light to which the eye adapts, one value per cell.
    fn mean(&self) -> Vec<f64> {
        // Each cell has at least one pixel.
        let pixels = |i: usize| {
            let place = |half: f64| ((i as f64 + half) / COARSE_PER_DEG * self.px_per_deg).max(0.0) as usize;
            let first = place(-0.5).min(self.light.len() - 1);
            &self.light[first..place(0.5).clamp(first + 1, self.light.len())]
        };
        let mean = |pixels: &[f64]| pixels.iter().sum::<f64>() / pixels.len() as f64;
        let coarse: Vec<f64> = (0..self.cells()).map(|i| mean(pixels(i))).collect();
        let sigma = ADAPTATION_DEG * COARSE_PER_DEG;
        let reach = (3.0 * sigma) as isize;
        let weights: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
        let total: f64 = weights.iter().sum();
        let last = coarse.len() as isize - 1;
        let smoothed = |i: isize| {
            let near = (-reach..=reach).map(|k| coarse[(i + k).clamp(0, last) as usize]);
            near.zip(&weights).map(|(light, weight)| light * weight).sum::<f64>() / total
        };
        (0..=last).map(smoothed).collect()
    }
}

/// Interpolates linearly between the two values around the position `at`.
fn between(values: &[f64], at: f64) -> f64 {
    let at = at.clamp(0.0, (values.len() - 1) as f64);
    let i = (at as usize).min(values.len().saturating_sub(2));
    let part = at - i as f64;
    values[i] * (1.0 - part) + values.get(i + 1).unwrap_or(&values[i]) * part
}
