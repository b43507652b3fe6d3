//! Finds bands in an image at any position and orientation: the energy ridges of each channel that are not masked by
//! finer channels.

use rayon::prelude::*;

use super::{
    band::{Band, Polarity, Visibility, from_pooled, pooled, to_pooled, unmasked},
    error::{VisionError, check},
    eye::{Border, Channel, Eye},
    image::{Distances, Field, Grid, LuminanceImage},
    ridge::{Ridge, Search},
    spectrum::{Responses, Spectrum},
};

/// Number of places per degree at which the energy for masking is sampled.
const MASK_PER_DEG: f64 = 16.0;
/// Minimum number of pixels per side.
const MIN_SIDE_PX: usize = 16;

/// The prediction for an image.
#[derive(Clone, Debug, Default)]
pub struct PicturePrediction {
    /// The bands of all channels, one for each place along a line, sorted by descending strength.
    pub bands: Vec<Band>,
    /// Visibility of the strongest bands, pooled over all channels.
    pub visibility: Visibility,
    /// The amount of banding, per degree: in each channel, the sum of strength times length, divided by the area
    /// judged. Channels are pooled as for visibility.
    pub density: f64,
    /// Strength of the bright and the dark bands at each pixel, pooled over all channels.
    pub map: BandMap,
}

/// The strength of bands at each pixel, as lines one pixel wide.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandMap {
    pub bright: Vec<f64>,
    pub dark: Vec<f64>,
}

impl LuminanceImage<'_> {
    /// Predicts the bands that `eye` sees.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the image is smaller than 16 × 16 pixels or three periods of the finest channel, if
    /// the number of pixels per degree is not above 0, if the light or the mask has the wrong length, if a light value
    /// is negative or not finite, or if the image is all black.
    pub fn predict(&self, eye: &Eye) -> Result<PicturePrediction, VisionError> {
        check(self.light, self.width, self.height, self.px_per_deg)?;
        if let Some(mask) = self.mask.filter(|mask| mask.len() != self.light.len()) {
            return Err(VisionError::Count { found: mask.len(), expected: self.light.len() });
        }
        let side = self.width.min(self.height);
        let sampled = || Channel::all().filter(|channel| channel.frequency < self.px_per_deg / 2.0);
        // A channel with no room between its margins detects nothing.
        let margins = |channel: &Channel| 2.0 * Border::Cut.margin_deg(channel.frequency);
        let channels: Vec<Channel> =
            sampled().filter(|channel| margins(channel) < side as f64 / self.px_per_deg).collect();
        if side < MIN_SIDE_PX || channels.is_empty() {
            let finest = sampled().next_back().map_or(0.0, |channel| margins(&channel) * self.px_per_deg);
            let least = (finest.floor() as usize + 1).max(MIN_SIDE_PX);
            return Err(VisionError::TooSmall { width: self.width, height: self.height, least });
        }
        let (spectrum, distances) = rayon::join(|| Spectrum::new(self, eye), || Distances::new(self));
        let mean = spectrum.mean();
        // The finest channels come first because they take longest and mask the others.
        let found = channels.par_iter().rev().map(|channel| {
            let responses = spectrum.respond(*channel);
            let (channel, px_per_deg) = (*channel, self.px_per_deg);
            let search = Search { responses: &responses, channel, px_per_deg, mean: &mean, distances: &distances };
            (search.ridges(), self.energy(&responses))
        });
        let channels = unmask(found.collect());
        let strongest = |ridges: &Vec<Ridge>| {
            let of = |polarity| self.strongest(ridges, polarity);
            Visibility { bright: of(Polarity::Bright), dark: of(Polarity::Dark) }
        };
        let area = distances.area() / (self.px_per_deg * self.px_per_deg);
        let amount = |ridges: &Vec<Ridge>| {
            ridges.iter().map(|ridge| ridge.strength * ridge.length_px / self.px_per_deg).sum::<f64>() / area
        };
        let mut bands: Vec<Band> = channels.iter().flatten().map(|ridge| self.band(ridge)).collect();
        bands.sort_by(|a, b| b.strength.total_cmp(&a.strength));
        let map = |polarity| self.map(&channels, polarity);
        let (bright, dark) = rayon::join(|| map(Polarity::Bright), || map(Polarity::Dark));
        Ok(PicturePrediction {
            bands,
            visibility: Visibility::over(&channels.iter().map(strongest).collect::<Vec<_>>()),
            density: pooled(channels.iter().map(amount)),
            map: BandMap { bright, dark },
        })
    }

    /// Returns the strength that bands reach over a total length of one period. A single place, such as a crossing or
    /// the end of a line, does not count.
    fn strongest(&self, ridges: &[Ridge], polarity: Polarity) -> f64 {
        let mut places: Vec<&Ridge> = ridges.iter().filter(|ridge| ridge.polarity == polarity).collect();
        places.sort_by(|a, b| b.strength.total_cmp(&a.strength));
        let mut periods = 0.0;
        let long_enough = places.iter().find(|ridge| {
            periods += ridge.length_px / self.px_per_deg * ridge.frequency;
            periods >= 1.0
        });
        long_enough.map_or(0.0, |ridge| ridge.strength)
    }

    fn band(&self, ridge: &Ridge) -> Band {
        let at_deg = [
            (ridge.at[0] - self.width as f64 / 2.0) / self.px_per_deg,
            (self.height as f64 / 2.0 - ridge.at[1]) / self.px_per_deg,
        ];
        let [x, y] = ridge.across;
        let orientation_deg = (-y).atan2(x).to_degrees().rem_euclid(180.0);
        let Ridge { polarity, strength, frequency, .. } = *ridge;
        Band { at_deg, orientation_deg, polarity, strength, frequency }
    }

    fn map(&self, channels: &[Vec<Ridge>], polarity: Polarity) -> Vec<f64> {
        let mut map = vec![0.0; self.light.len()];
        for ridge in channels.iter().flatten().filter(|ridge| ridge.polarity == polarity) {
            self.draw(ridge, &mut map);
        }
        map.into_iter().map(from_pooled).collect()
    }

    /// Draws a stroke as long as the part of the band that the ridge represents, so that the lines of coarse channels
    /// have no gaps.
    fn draw(&self, ridge: &Ridge, map: &mut [f64]) {
        let amount = to_pooled(ridge.strength);
        let steps = ridge.length_px.ceil().max(1.0) as usize;
        let mut last = usize::MAX;
        for step in 0..steps {
            let along = ((step as f64 + 0.5) / steps as f64 - 0.5) * ridge.length_px;
            let x = (ridge.at[0] - along * ridge.across[1]).floor();
            let y = (ridge.at[1] + along * ridge.across[0]).floor();
            if x < 0.0 || y < 0.0 || x >= self.width as f64 || y >= self.height as f64 {
                continue;
            }
            let pixel = y as usize * self.width + x as usize;
            if pixel != last {
                map[pixel] += amount;
                last = pixel;
            }
        }
    }

    /// Samples the energy at the coarse grid of places used for masking.
    fn energy(&self, responses: &Responses) -> Field {
        let step = (self.px_per_deg / MASK_PER_DEG).max(1.0);
        let count = |side: usize| (side as f64 / step).ceil() as usize + 1;
        let (columns, rows) = (count(self.width), count(self.height));
        // The grid is centered, so that rotating an image does not change its masking.
        let first = |n: usize, side: usize| side as f64 / 2.0 - (n - 1) as f64 / 2.0 * step;
        let first = [first(columns, self.width), first(rows, self.height)];
        let grid = Grid { columns, rows, first, step: [step; 2] };
        let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        let energy = |(column, row)| responses.grid.at(&responses.energy, grid.place(column, row)).sqrt();
        let values = places.map(energy).collect();
        Field { grid, values }
    }
}

/// Reduces each ridge by the part that finer channels mask. The finest channel must come first.
fn unmask(found: Vec<(Vec<Ridge>, Field)>) -> Vec<Vec<Ridge>> {
    let mut finer: Option<Field> = None;
    let mut left = Vec::with_capacity(found.len());
    for (mut ridges, coarse) in found {
        if let Some(finer) = &mut finer {
            for ridge in &mut ridges {
                ridge.strength *= unmasked(ridge.energy, finer.at(ridge.at));
            }
            ridges.retain(|ridge| ridge.strength > 0.0);
            finer.values.iter_mut().zip(&coarse.values).for_each(|(most, value)| *most = most.max(*value));
        } else {
            finer = Some(coarse);
        }
        left.push(ridges);
    }
    left
}
