//! Prediction along a line, for stimuli that vary in one direction only.

use std::f64::consts::PI;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::{
    band::{Band, Polarity, Visibility, crest, vertex},
    channel::{Answer, Fields, FrequencyChannel, SAMPLES_PER_PERIOD, SLOPE_PERIODS, pooled},
    error::{VisionError, check},
    eye::{ADAPTATION_DEG, Border, Eye},
    fft::{self, next_fast_length},
    image::Grid,
    spectrum::periodic_length,
};

/// Padding between the ends of a profile that continues, degrees: one period of the coarsest channel, so that the two
/// ends of the periodic profile do not affect each other.
const BEYOND_DEG: f64 = 16.0;
/// A channel's response is computed this far beyond the ends of the profile, in periods of the channel.
const BEYOND_PERIODS: f64 = 2.5;
/// Number of cells per degree for the mean light.
const CELLS_PER_DEG: f64 = 16.0;
/// Number of places per degree at which bands are sought.
const PLACES_PER_DEG: f64 = 32.0;

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

/// One frequency of a line's spectrum.
struct Frequency {
    /// Natural logarithm of the frequency in cycles per degree.
    log: f64,
    /// The slope's amplitude and phase.
    slope: Complex64,
}

/// The prediction for a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinePrediction {
    /// The bands, sorted by descending strength.
    pub bands: Vec<Band>,
    /// Visibility of the strongest bands.
    pub visibility: Visibility,
    /// Visibility of the strongest lines that are in the light itself.
    pub lines: Visibility,
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
        let (spectrum, mean, half) = (self.spectrum(), self.mean(), 0.5 * self.length());
        let answer = |channel: FrequencyChannel| {
            let mean = |[x, _]: [f64; 2]| between(&mean, (x + half) * CELLS_PER_DEG);
            let weight = |[x, _]: [f64; 2]| self.border.weight((half - x.abs()) * channel.frequency);
            self.respond(channel, &spectrum).answer(channel, 1.0, eye, mean, weight)
        };
        let channels: Vec<FrequencyChannel> = FrequencyChannel::all().collect();
        let answers: Vec<Answer> = channels.into_par_iter().rev().map(answer).collect();
        let columns = (self.length() * PLACES_PER_DEG).ceil() as usize + 1;
        let step = self.length() / (columns - 1) as f64;
        let places = Grid { columns, rows: 1, first: [-half, 0.0], step: [step; 2] };
        let [map, lines] = pooled(&answers, &places);
        let mut bands: Vec<Band> = [(Polarity::Bright, &map.bright), (Polarity::Dark, &map.dark)]
            .into_iter()
            .flat_map(|(polarity, map)| {
                peaks(map).map(move |(at, strength)| Band { at_deg: at * step - half, polarity, strength })
            })
            .collect();
        bands.sort_by(|a, b| b.strength.total_cmp(&a.strength));
        let [visibility, lines] = [&map, &lines].map(|map| Visibility::strongest(map, columns));
        Ok(LinePrediction { bands, visibility, lines })
    }

    /// Returns the length of the profile, degrees.
    fn length(&self) -> f64 {
        self.light.len() as f64 / self.px_per_deg
    }

    /// Returns the number of samples after which the padded profile repeats.
    fn period(&self) -> usize {
        match self.border {
            Border::Continues => next_fast_length(self.light.len() + (BEYOND_DEG * self.px_per_deg).ceil() as usize),
            Border::Cut => periodic_length(self.light.len(), self.light.len()),
        }
    }

    /// Returns the length after which the padded profile repeats, degrees.
    fn repeat(&self) -> f64 {
        self.period() as f64 / self.px_per_deg
    }

    /// Returns the number of cells for the mean light.
    fn cells(&self) -> usize {
        (self.length() * CELLS_PER_DEG).ceil() as usize + 1
    }

    /// Returns the spectrum of the light's slope up to the highest frequency that any channel needs. The slope consists
    /// of jumps from pixel to pixel: pixels are squares, so their light is a staircase.
    fn spectrum(&self) -> Vec<Frequency> {
        let (n, period) = (self.light.len(), self.period());
        let mut jumps = vec![Complex64::default(); period];
        for (jump, pair) in jumps[1..].iter_mut().zip(self.light.windows(2)) {
            jump.re = pair[1] - pair[0];
        }
        if self.border == Border::Cut {
            // Point reflection up to halfway to the next repetition; without the constant part of the slope, the light
            // is periodic.
            for k in 0..((period - n) / 2).min(n - 1) {
                jumps[n + k] = jumps[n - 1 - k];
                jumps[(period - k) % period] = jumps[1 + k];
            }
        }
        fft::forward(period).process(&mut jumps);
        let repeat = self.repeat();
        // The first place is half a period before the middle of the profile.
        let first = 0.5 * (self.length() - repeat);
        let last = FrequencyChannel::all().map(|channel| self.samples(channel) / 2).max().unwrap_or(0);
        let frequency = |j: usize| {
            let f = j as f64 / repeat;
            Frequency { log: f.ln(), slope: jumps[j % period] * Complex64::cis(2.0 * PI * f * first) / repeat }
        };
        (0..last).map(frequency).collect()
    }

    /// Returns the number of samples of a channel's responses over one period of the padded profile, which is even.
    fn samples(&self, channel: FrequencyChannel) -> usize {
        2 * next_fast_length((0.5 * SAMPLES_PER_PERIOD * channel.frequency * self.repeat()).ceil() as usize)
    }

    /// Returns a channel's responses on a grid in degrees from the middle of the profile.
    fn respond(&self, channel: FrequencyChannel, spectrum: &[Frequency]) -> Fields {
        let (frequency, repeat, samples) = (channel.frequency, self.repeat(), self.samples(channel));
        let (step, middle) = (repeat / samples as f64, samples / 2);
        let (own, coarse) = (frequency.ln(), channel.octave_below().frequency.ln());
        let [mut pair, mut others] = [0; 2].map(|_| vec![Complex64::default(); samples]);
        // The mean slope. Without it, plateaus would fall where the light as a whole rises.
        others[0] = spectrum[0].slope * Complex64::i();
        for (j, Frequency { log, slope }) in spectrum.iter().enumerate().take(middle).skip(1) {
            let f = j as f64 / repeat;
            // Dividing by 2πif turns slope into light.
            let light = slope * Complex64::new(0.0, -0.5 / (PI * f));
            let even = light * channel.passes_log(log - own);
            let coarse = light * channel.octave_below().passes_log(log - coarse);
            let slope = slope * (-0.5 * (2.0 * PI * SLOPE_PERIODS * f / frequency).powi(2)).exp();
            // Without the negative frequencies, the transform is even + i·odd. The factor of 2 makes up for them.
            pair[j] = even * 2.0;
            // A real field in the real part plus i times another.
            others[j] = coarse + slope * Complex64::i();
            others[samples - j] = coarse.conj() + slope.conj() * Complex64::i();
        }
        let inverse = fft::inverse(samples);
        inverse.process(&mut pair);
        inverse.process(&mut others);
        let beyond = 0.5 * self.length() + BEYOND_PERIODS / frequency;
        let reach = ((beyond / step).ceil() as usize).min(middle - 1);
        let part = middle - reach..=middle + reach;
        let (pair, others) = (&pair[part.clone()], &others[part]);
        let grid = Grid { columns: pair.len(), rows: 1, first: [-(reach as f64) * step, 0.0], step: [step; 2] };
        let each =
            |of: fn(&Complex64, &Complex64) -> Complex64| pair.iter().zip(others).map(|(a, b)| of(a, b)).collect();
        Fields {
            grid,
            even: each(|pair, others| Complex64::new(pair.re, others.re)),
            odd: each(|pair, _| pair.im.into()),
            straight: each(|pair, _| pair.re.into()),
            slope: each(|_, others| others.im.into()),
        }
    }

    /// Returns the mean light to which the eye adapts, one value per cell.
    fn mean(&self) -> Vec<f64> {
        // Each cell has at least one pixel.
        let pixels = |i: usize| {
            let place = |half: f64| ((i as f64 + half) / CELLS_PER_DEG * self.px_per_deg).max(0.0) as usize;
            let first = place(-0.5).min(self.light.len() - 1);
            &self.light[first..place(0.5).clamp(first + 1, self.light.len())]
        };
        let mean = |pixels: &[f64]| pixels.iter().sum::<f64>() / pixels.len() as f64;
        let coarse: Vec<f64> = (0..self.cells()).map(|i| mean(pixels(i))).collect();
        let sigma = ADAPTATION_DEG * CELLS_PER_DEG;
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

/// Returns the position and the height of each peak of a map.
fn peaks(map: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    map.windows(3).enumerate().filter_map(|(i, neighbors)| {
        let [a, b, c] = *neighbors else { return None };
        (b > a && b >= c).then(|| ((i + 1) as f64 + vertex(a, b, c), b + crest(a, b, c)))
    })
}
