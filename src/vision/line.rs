//! Prediction along a line, for stimuli that vary in one direction only.

use std::{cell::RefCell, f64::consts::PI, sync::Arc};

use rustfft::{Fft, num_complex::Complex64};

use super::{
    band::{Band, FALL_PERIODS, Polarity, Visibility, peak, strength, unmasked},
    error::{VisionError, check},
    eye::{ADAPTATION_DEG, Border, Channel, Eye, REACH},
    fft::{self, smooth},
};

/// Beyond the ends of a profile, degrees: as long as the coarsest channel's period, so that the profile does not meet
/// itself.
const BEYOND_DEG: f64 = 16.0;
/// Samples of a channel's response in a period of it.
const SAMPLES_PER_PERIOD: f64 = 16.0;
/// Samples per degree of the mean light, and of the energy that masks.
const MEAN_PER_DEG: f64 = 16.0;

/// A model for profiles of one length and one sampling, whose filters are made once.
pub struct Line {
    samples: usize,
    px_per_deg: f64,
    /// Samples until the profile repeats.
    period: usize,
    forward: Arc<dyn Fft<f64>>,
    /// For each place of the spectrum: from a jump of the light to the eye's response.
    weights: Vec<f64>,
    channels: Arc<[Filter]>,
}

/// One channel of profiles of one length, whatever the eye.
struct Filter {
    channel: Channel,
    /// The first frequency that it passes, in cycles a repeat.
    first: usize,
    /// Share that it passes of this and of those that follow.
    passes: Vec<f64>,
    inverse: Arc<dyn Fft<f64>>,
}

thread_local! {
    /// The filters made last, and their length: successive conditions have the same length, but each an eye of its own.
    static LAST: RefCell<Option<(f64, Arc<[Filter]>)>> = const { RefCell::new(None) };
}

/// All channels for profiles that repeat after `length` degrees.
fn filters(length: f64) -> Arc<[Filter]> {
    LAST.with_borrow_mut(|last| match last {
        Some((known, filters)) if *known == length => filters.clone(),
        _ => {
            let logs: Vec<f64> = (0..=last_place(finest(), length)).map(|j| (j as f64 / length).ln()).collect();
            let filters: Arc<[Filter]> = Channel::all().map(|channel| Filter::new(channel, length, &logs)).collect();
            *last = Some((length, filters.clone()));
            filters
        }
    })
}

fn finest() -> f64 {
    Channel::all().map(|channel| channel.frequency).fold(0.0, f64::max)
}

/// The last place of the spectrum that a channel passes.
fn last_place(frequency: f64, length: f64) -> usize {
    ((frequency * REACH * length).floor() as usize).max(1)
}

/// The prediction for a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinePrediction {
    /// Of every channel, the strongest first.
    pub bands: Vec<Band>,
    /// Over all channels.
    pub visibility: Visibility,
}

impl Line {
    /// For profiles of `samples` pixels of 1/`px_per_deg` degree.
    ///
    /// # Errors
    /// [`VisionError`] for a profile of less than two samples, and a sampling that is not above 0.
    pub fn new(samples: usize, px_per_deg: f64, eye: &Eye) -> Result<Line, VisionError> {
        if samples < 2 {
            return Err(VisionError::TooSmall { width: samples, height: 1, least: 2 });
        }
        if !(px_per_deg.is_finite() && px_per_deg > 0.0) {
            return Err(VisionError::Sampling(px_per_deg));
        }
        let period = smooth(samples + (BEYOND_DEG * px_per_deg).ceil() as usize);
        let length = period as f64 / px_per_deg;
        let weight = |j: usize| {
            let f = j as f64 / length;
            // From jumps to light: divided by 2πif. Twice, since only frequencies above 0 are kept.
            if j > 0 { eye.sensitivity(f) / (PI * f * length) } else { 0.0 }
        };
        let weights = (0..=last_place(finest(), length)).map(weight).collect();
        let (forward, channels) = (fft::forward(period), filters(length));
        Ok(Line { samples, px_per_deg, period, forward, weights, channels })
    }

    /// The prediction for `light`, linear, 1 for white. It continues beyond its ends as it ends.
    ///
    /// # Errors
    /// [`VisionError`] for another number of samples, light that is negative or no number, and all black.
    pub fn predict(&self, light: &[f64], border: Border) -> Result<LinePrediction, VisionError> {
        check(light.iter().copied(), self.samples, 1, light.len())?;
        let spectrum = self.spectrum(light, border);
        let mean = Mean::new(light, self.px_per_deg);
        let length = self.period as f64 / self.px_per_deg;
        let mut view = LinePrediction::default();
        let mut channels = Vec::with_capacity(self.channels.len());
        let mut response = Vec::new();
        let seen = self.samples as f64 / self.px_per_deg;
        let mut finer = Finer::new(seen);
        // The finest first: they mask the others.
        for filter in self.channels.iter().rev() {
            filter.respond(&spectrum, &mut response);
            let mut strongest = Visibility::default();
            for (mut band, energy) in filter.bands(&response, length, seen, border, &mean) {
                band.strength *= unmasked(energy, finer.at(band.at_deg[0] + seen / 2.0));
                strongest.take(band.polarity, band.strength);
                if band.strength > 0.0 {
                    view.bands.push(band);
                }
            }
            channels.push(strongest);
            finer.add(&response, length);
        }
        view.bands.sort_by(|a, b| b.strength.total_cmp(&a.strength));
        view.visibility = Visibility::over(&channels);
        Ok(view)
    }

    /// As the eye is sensitive to it, of the light's jumps from pixel to pixel: pixels are squares, and their light is a
    /// staircase.
    /// Beyond an edge that cuts, jumps come back as they went and fade: light and slope go on.
    fn spectrum(&self, light: &[f64], border: Border) -> Vec<Complex64> {
        let mut jumps = vec![Complex64::default(); self.period];
        for (i, pair) in light.windows(2).enumerate() {
            jumps[i + 1].re = pair[1] - pair[0];
        }
        if border == Border::Cut {
            let n = self.samples;
            let beyond = ((self.period - n) / 2).min(n - 1);
            for k in 0..beyond {
                let fade = 0.5 + 0.5 * (PI * (k + 1) as f64 / (beyond + 1) as f64).cos();
                jumps[n + k].re = fade * jumps[n - 1 - k].re;
                jumps[(self.period - k) % self.period].re = fade * jumps[1 + k].re;
            }
        }
        self.forward.process(&mut jumps);
        let seen = |(j, weight): (usize, &f64)| jumps[j % jumps.len()] * Complex64::new(0.0, -weight);
        self.weights.iter().enumerate().map(seen).collect()
    }
}

impl Filter {
    /// `logs` has the logarithm of every place's frequency.
    fn new(channel: Channel, length: f64, logs: &[f64]) -> Filter {
        let first = ((channel.frequency / REACH * length).ceil() as usize).max(1);
        let last = last_place(channel.frequency, length);
        let own = channel.frequency.ln();
        let samples = smooth((SAMPLES_PER_PERIOD * channel.frequency * length).ceil() as usize);
        Filter {
            channel,
            first,
            passes: logs[first..=last].iter().map(|log| channel.passes_log(log - own)).collect(),
            inverse: fft::inverse(samples.max(last + 1)),
        }
    }

    /// Even + i·odd along the whole repeat.
    fn respond(&self, spectrum: &[Complex64], response: &mut Vec<Complex64>) {
        response.clear();
        response.resize(self.inverse.len(), Complex64::default());
        for (j, passes) in (self.first..).zip(&self.passes) {
            response[j] = spectrum[j] * passes;
        }
        self.inverse.process(response);
    }

    /// Peaks within the first `seen` of `length` degrees, each with its energy.
    fn bands(&self, response: &[Complex64], length: f64, seen: f64, border: Border, mean: &Mean) -> Vec<(Band, f64)> {
        let n = response.len();
        let step = length / n as f64;
        let frequency = self.channel.frequency;
        let margin = border.margin_deg(frequency);
        let fall = ((FALL_PERIODS / frequency / step) as usize).min(n / 2);
        // How far it may be seen to fall: not where an edge already bends it.
        let beside = border.beside_deg(frequency);
        let clear = |deg: f64| match border {
            Border::Continues => fall,
            Border::Cut => (((deg - beside) / step).max(0.0) as usize).min(fall),
        };
        let energy: Vec<f64> = response.iter().map(|value| value.norm_sqr()).collect();
        let first = (margin / step).ceil() as usize;
        let end = (((seen - margin) / step).floor().max(0.0) as usize + 1).min(n);
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
            let before = least(clear(place), &|k| at(n - k));
            let lowest = before.max(least(clear(seen - place), &|k| at(k))).sqrt();
            let strength = strength(value, lowest, mean.at(place));
            let polarity = if value.re > 0.0 { Polarity::Bright } else { Polarity::Dark };
            let at_deg = [place - seen / 2.0, 0.0];
            let band = Band { at_deg, orientation_deg: 0.0, polarity, strength, frequency };
            (strength > 0.0).then_some((band, value.norm()))
        };
        (first..end).filter_map(band).collect()
    }
}

/// The largest energy of the channels so far.
struct Finer {
    values: Vec<f64>,
}

impl Finer {
    fn new(seen: f64) -> Finer {
        Finer { values: vec![0.0; (seen * MEAN_PER_DEG).ceil() as usize + 1] }
    }

    fn add(&mut self, response: &[Complex64], length: f64) {
        let step = response.len() as f64 / length / MEAN_PER_DEG;
        for (i, value) in self.values.iter_mut().enumerate() {
            *value = value.max(response[(i as f64 * step).round() as usize % response.len()].norm());
        }
    }

    /// At `x` degrees from the profile's beginning.
    fn at(&self, x: f64) -> f64 {
        self.values[((x * MEAN_PER_DEG).round().max(0.0) as usize).min(self.values.len() - 1)]
    }
}

/// Mean light, for which the eye is set.
struct Mean {
    values: Vec<f64>,
}

impl Mean {
    fn new(light: &[f64], px_per_deg: f64) -> Mean {
        let length = light.len() as f64 / px_per_deg;
        let cells = (length * MEAN_PER_DEG).ceil() as usize + 1;
        // The pixels in each cell, one at least: of what is finer than a cell one pixel would tell a tale.
        let pixels = |i: usize| {
            let place = |half: f64| ((i as f64 + half) / MEAN_PER_DEG * px_per_deg).max(0.0) as usize;
            let first = place(-0.5).min(light.len() - 1);
            &light[first..place(0.5).clamp(first + 1, light.len())]
        };
        let mean = |pixels: &[f64]| pixels.iter().sum::<f64>() / pixels.len() as f64;
        let coarse: Vec<f64> = (0..cells).map(|i| mean(pixels(i))).collect();
        let reach = (3.0 * ADAPTATION_DEG * MEAN_PER_DEG) as isize;
        let weight = |k: isize| (-0.5 * (k as f64 / (ADAPTATION_DEG * MEAN_PER_DEG)).powi(2)).exp();
        let weights: Vec<f64> = (-reach..=reach).map(weight).collect();
        let total: f64 = weights.iter().sum();
        let values = (0..cells as isize)
            .map(|i| {
                let near = (-reach..=reach).map(|k| coarse[(i + k).clamp(0, cells as isize - 1) as usize]);
                near.zip(&weights).map(|(light, weight)| light * weight).sum::<f64>() / total
            })
            .collect();
        Mean { values }
    }

    /// At `x` degrees from the profile's beginning.
    fn at(&self, x: f64) -> f64 {
        let x = (x * MEAN_PER_DEG).clamp(0.0, (self.values.len() - 1) as f64);
        let i = (x as usize).min(self.values.len().saturating_sub(2));
        let part = x - i as f64;
        self.values[i] * (1.0 - part) + self.values.get(i + 1).unwrap_or(&self.values[i]) * part
    }
}
