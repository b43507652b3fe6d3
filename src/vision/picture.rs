//! Finds bands in an image at any position and orientation.

use rayon::prelude::*;

use super::{
    band::{BandMap, Visibility},
    channel::{Answer, FrequencyChannel, pooled},
    error::{VisionError, check},
    eye::{Border, Eye},
    image::{Distances, Grid, LuminanceImage},
    spectrum::Spectrum,
};

/// Minimum number of pixels per side.
const MIN_SIDE_PX: usize = 16;
/// The border margins of a channel on both sides, in its periods: an image must be larger than those of the finest.
const MIN_PERIODS: f64 = 1.4;

/// The prediction for an image.
#[derive(Clone, Debug, Default)]
pub struct PicturePrediction {
    /// Visibility of the strongest bands: lines that are not in the light, which only rises or only falls there.
    pub visibility: Visibility,
    /// Visibility of the strongest lines that are in the light: highlights, outlines, texture.
    pub lines: Visibility,
    /// The amount of banding: the root mean square of the visibility over the area judged.
    pub density: f64,
    /// Visibility of the bands at each pixel.
    pub map: BandMap,
}

impl LuminanceImage<'_> {
    /// Predicts the bands that `eye` sees.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the image is smaller than 16 × 16 pixels or 1.4 periods of the finest channel, if
    /// the number of pixels per degree is not above 0, if the light or the mask has the wrong length, if a light value
    /// is negative or not finite, or if the image is all black.
    pub fn predict(&self, eye: &Eye) -> Result<PicturePrediction, VisionError> {
        check(self.light, self.width, self.height, self.px_per_deg)?;
        if let Some(mask) = self.mask.filter(|mask| mask.len() != self.light.len()) {
            return Err(VisionError::Count { found: mask.len(), expected: self.light.len() });
        }
        let side = self.width.min(self.height);
        let sampled = || FrequencyChannel::all().filter(|channel| 2.0 * channel.frequency < self.px_per_deg);
        let margins = |channel: &FrequencyChannel| MIN_PERIODS / channel.frequency;
        let channels: Vec<FrequencyChannel> =
            sampled().filter(|channel| margins(channel) < side as f64 / self.px_per_deg).collect();
        if side < MIN_SIDE_PX || channels.is_empty() {
            let finest = sampled().next_back().map_or(0.0, |channel| margins(&channel) * self.px_per_deg);
            let least = (finest.floor() as usize + 1).max(MIN_SIDE_PX);
            return Err(VisionError::TooSmall { width: self.width, height: self.height, least });
        }
        let (spectrum, distances) = rayon::join(|| Spectrum::new(self), || Distances::new(self));
        let mean = spectrum.mean();
        let answer = |channel: &FrequencyChannel| {
            let periods = channel.frequency / self.px_per_deg;
            let weight = |place: [f64; 2]| Border::Cut.weight(distances.distance_at(place) * periods);
            spectrum.respond(*channel).answer(*channel, self.px_per_deg, eye, |place| mean.at(place), weight)
        };
        // The finest channels take longest, so they start first.
        let answers: Vec<Answer> = channels.par_iter().rev().map(answer).collect();
        drop(spectrum);
        let own = Grid { columns: self.width, rows: self.height, first: [0.5; 2], step: [1.0; 2] };
        let [map, lines] = pooled(&answers, &own);
        let judged = distances.area();
        // In order: a parallel sum would be rounded differently in every run.
        let total: f64 = map.bright.iter().chain(&map.dark).map(|value| value * value).sum();
        Ok(PicturePrediction {
            visibility: Visibility::strongest(&map, self.width),
            lines: Visibility::strongest(&lines, self.width),
            density: (total / judged).sqrt(),
            map,
        })
    }
}
