//! Applies the vision model to stimuli and images in a window on a screen.

use std::{
    collections::{HashMap, hash_map::Entry},
    sync::{Arc, Mutex, PoisonError},
};

use rayon::prelude::*;

use super::{
    catalog::Stimulus,
    mach_band::MachBand,
    parameter::ParameterValue,
    shaded_mesh::emitted,
    viewing::{Judged, ViewingConditions},
};
use crate::{
    text::Cell,
    vision::{
        ContrastSpectrum, Eye, Judge, MAX_DEG, RampBands, SRGB_WEIGHTS, VisionError, check_extent, luminance,
        next_fast_length,
    },
};

/// Pixels per degree of the pictures whose detection is predicted: as fine as an average person sees with ease.
const DETECTION_PX_PER_DEG: f64 = 25.0;
/// A ramp's plateaus continue at least this far beyond each side of the window, degrees, as far as there is a field around
/// the eye; the model's picture ends there.
const PLATEAU_DEG: f64 = 2.0;
/// Places in each part of a pixel at which its light is averaged.
const IN_PART: u32 = 8;

/// How visible the Mach bands of a stimulus are.
#[derive(Clone, Debug, PartialEq)]
pub enum Visible {
    /// The bands of a ramp: the difference from the nearest smooth edge.
    Ramp(RampBands),
    /// The largest difference of a shaded mesh from the smooth surface behind it, in times threshold.
    Surface(f64),
    /// There is no smooth reference with which the stimulus could be compared.
    Unknown,
}

impl Visible {
    /// Returns the bands of a ramp.
    pub fn bands(&self) -> Option<&RampBands> {
        if let Self::Ramp(bands) = self { Some(bands) } else { None }
    }

    /// Returns what raters are asked about, in times threshold: the bright band of a ramp, or the bands on a surface.
    pub fn rated(&self) -> Option<f64> {
        match self {
            Self::Ramp(bands) => Some(bands.bright),
            Self::Surface(difference) => Some(*difference),
            Self::Unknown => None,
        }
    }
}

/// Returns how far the orientation of a stimulus is from the nearest of horizontal and vertical, 0…45°.
fn oblique_deg(stimulus: &Stimulus) -> f64 {
    let orientation = stimulus.get("orientation_deg").and_then(|value| Cell::from(value).as_number());
    let turned = orientation.unwrap_or(0.0).rem_euclid(90.0);
    turned.min(90.0 - turned)
}

/// Returns the luminance of each of `size` pixels across a ramp, relative to white: the mean over its parts inside and
/// outside the ramp, since the light may jump at its ends.
fn pixels(band: &MachBand, size: u32) -> Vec<f64> {
    let (profile, side) = (band.ramp(), f64::from(size));
    let ends = [-0.5, 0.5].map(|end| (end * band.width + 0.5) * side);
    let part = |from: f64, to: f64| {
        let at = |k: u32| (from + (to - from) * (f64::from(k) + 0.5) / f64::from(IN_PART)) / side - 0.5;
        let light = |k| luminance(profile.light_at(at(k)).map(|light| light as f32));
        if from < to { (to - from) * (0..IN_PART).map(light).sum::<f64>() / f64::from(IN_PART) } else { 0.0 }
    };
    let pixel = |i: u32| {
        let (left, right) = (f64::from(i), f64::from(i + 1));
        let [first, last] = ends.map(|end| end.clamp(left, right));
        part(left, first) + part(first, last) + part(last, right)
    };
    (0..size).map(pixel).collect()
}

/// Computes something for each stimulus, once for lines that are alike if one is turned by a right angle or mirrored.
fn each_once<T: Clone + Send>(
    stimuli: &[&Stimulus],
    of: impl Fn(&Stimulus) -> Result<T, VisionError> + Sync,
) -> Result<Vec<T>, VisionError> {
    let mut distinct: Vec<Stimulus> = Vec::new();
    let mut place = |stimulus: &&Stimulus| {
        let mut folded = (*stimulus).clone();
        if folded.is_line() {
            // A kind without an orientation stays as it is.
            let _ = folded.set("orientation_deg", &ParameterValue::Number(oblique_deg(stimulus)));
        }
        distinct.iter().position(|known| *known == folded).unwrap_or_else(|| {
            distinct.push(folded);
            distinct.len() - 1
        })
    };
    let places: Vec<usize> = stimuli.iter().map(&mut place).collect();
    let found: Vec<T> = if distinct.iter().all(Stimulus::is_line) {
        distinct.par_iter().map(&of).collect::<Result<_, _>>()?
    } else {
        // A single picture keeps all threads busy and needs much memory.
        distinct.iter().map(&of).collect::<Result<_, _>>()?
    };
    Ok(places.into_iter().map(|place| found[place].clone()).collect())
}

impl ViewingConditions {
    /// Judges stimuli that fill the window with `size` pixels per side, or otherwise with [`ViewingConditions::px`]. The
    /// plateaus of a ramp continue beyond the window.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if a window is too small or too large, or has no light somewhere.
    pub fn visible(&self, stimuli: &[&Stimulus], size: Option<u32>) -> Result<Vec<Visible>, VisionError> {
        // A judge takes longer than a ramp, and many ramps have the same.
        let judges = Mutex::new(HashMap::new());
        let judge = |length: usize, px: u32, oblique_deg: f64, eye: Eye| {
            let mut judges = judges.lock().unwrap_or_else(PoisonError::into_inner);
            Ok::<_, VisionError>(match judges.entry((length, oblique_deg.to_bits(), eye.luminance.to_bits())) {
                Entry::Occupied(place) => Arc::clone(place.get()),
                Entry::Vacant(place) => {
                    let judge = Judge::of_lines(length, self.px_per_deg(px), oblique_deg, eye)?;
                    Arc::clone(place.insert(Arc::new(judge)))
                }
            })
        };
        each_once(stimuli, |stimulus| {
            let px = size.unwrap_or_else(|| ViewingConditions::px(stimulus));
            check_extent(px as usize, px as usize, self.px_per_deg(px))?;
            if let Some((light, eye)) = self.ramp(stimulus, px) {
                let judge = judge(light.len(), px, oblique_deg(stimulus), eye)?;
                return Ok(Visible::Ramp(RampBands::of(&judge, &light)?));
            }
            let Stimulus::ShadedMesh(shaded) = stimulus else { return Ok(Visible::Unknown) };
            let Some(frame) = shaded.frame(px) else { return Ok(Visible::Unknown) };
            let difference = Judged::known(&frame).difference(self, &emitted(&frame, &shaded.shade()))?;
            Ok(difference.map_or(Visible::Unknown, |difference| Visible::Surface(difference.largest)))
        })
    }

    /// Returns the line of a ramp in cd/m², with its plateaus beyond the window, and the eye that sees it; `None` for other
    /// stimuli.
    fn ramp(&self, stimulus: &Stimulus, size: u32) -> Option<(Vec<f64>, Eye)> {
        let Stimulus::MachBand(band) = stimulus else { return None };
        let window: Vec<f64> = pixels(band, size).into_iter().map(|light| self.cd_m2(light)).collect();
        let (first, last) = (*window.first()?, *window.last()?);
        let least = (PLATEAU_DEG * self.px_per_deg(size)).ceil() as usize;
        let most = ((MAX_DEG * self.px_per_deg(size)) as usize).max(window.len());
        let length = next_fast_length(window.len() + 2 * least).min(most);
        let before = (length - window.len()) / 2;
        // Without the rounding error of the sum, so that ramps between the same plateaus share a judge.
        let mean = window.iter().sum::<f64>() / window.len() as f64;
        let eye = Eye::adapted_to((mean * 1e6).round() / 1e6);
        let mut light = vec![first; before];
        light.extend(window);
        light.resize(length, last);
        Some((light, eye))
    }

    /// Returns the [detection](Self::detection) of each of these stimuli.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if a window is all black.
    pub fn detections(&self, stimuli: &[&Stimulus]) -> Result<Vec<f64>, VisionError> {
        each_once(stimuli, |stimulus| self.detection(stimulus))
    }

    /// Returns the contrast of a stimulus that fills the window, in multiples of the threshold of an average person who
    /// looks at its middle; see [`ContrastSpectrum::detection`].
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the window is all black.
    pub fn detection(&self, stimulus: &Stimulus) -> Result<f64, VisionError> {
        let size = (DETECTION_PX_PER_DEG * self.window_deg).clamp(256.0, 1024.0) as u32;
        let light = self.luminances(&stimulus.linear(size), SRGB_WEIGHTS);
        let spectrum = ContrastSpectrum::new(&light, [size as usize; 2], self.px_per_deg(size))?;
        Ok(spectrum.detection(&self.eye(&light)))
    }

    /// Prepares to judge pictures of `size` pixels `[across, down]` that fill the window's width, by an eye that is adapted
    /// to the mean of `reference` in cd/m².
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the picture is too small or too wide.
    pub fn judge(&self, size: [usize; 2], reference: &[f64]) -> Result<Judge, VisionError> {
        Judge::of_pictures(size, size[0] as f64 / self.window_deg, self.eye(reference))
    }
}
