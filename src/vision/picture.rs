//! From an image to its bands: every channel's ridges, less what finer channels mask.

use rayon::prelude::*;

use super::{
    band::{Band, Polarity, Visibility, pooled, powered, unmasked, unpowered},
    error::{VisionError, check},
    eye::{Border, Channel, Eye},
    image::{Clear, Field, Grid, Picture},
    ridge::{Ridge, Search},
    spectrum::{Responses, Scratch, Spectrum},
};

/// The prediction for an image.
#[derive(Clone, Debug, Default)]
pub struct PicturePrediction {
    /// Of every channel, at every place of its lines, the strongest first.
    pub bands: Vec<Band>,
    /// Of the strongest place, over all channels.
    pub visibility: Visibility,
    /// How much band there is: strength times length over the area judged, for every channel, added up over channels
    /// as visibility is; per degree.
    pub density: f64,
    /// Strength of bright and of dark bands at every pixel, over all channels.
    pub map: BandMap,
}

/// Lines of bands, drawn one pixel wide.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandMap {
    /// Bright bands.
    pub bright: Vec<f64>,
    /// Dark bands.
    pub dark: Vec<f64>,
}

/// Places in a degree at which channels mask each other.
const MASK_PER_DEG: f64 = 16.0;
/// Least pixels on a side.
const LEAST: usize = 16;

impl Picture<'_> {
    /// The prediction for `eye`.
    ///
    /// # Errors
    /// [`VisionError`] for an image smaller than 16 × 16 pixels or than three periods of the finest channel, for light
    /// that is negative or no number, and for all black.
    pub fn predict(&self, eye: &Eye) -> Result<PicturePrediction, VisionError> {
        self.check()?;
        let (spectrum, clear) = rayon::join(|| Spectrum::new(self, eye), || Clear::new(self));
        let side = self.width.min(self.height) as f64 / self.px_per_deg;
        // A channel without room between its margins finds nothing.
        let channels: Vec<Channel> = Channel::all()
            .filter(|channel| 2.0 * Border::Cut.margin_deg(channel.frequency) < side)
            .filter(|channel| is_sampled(*channel, self.px_per_deg))
            .collect();
        if channels.is_empty() {
            let least = least_side(self.px_per_deg);
            return Err(VisionError::TooSmall { width: self.width, height: self.height, least });
        }
        let mean = spectrum.mean();
        let seen: Vec<(Vec<Ridge>, Field)> = channels
            .par_iter()
            // The finest first: they take longest.
            .rev()
            .map_init(Scratch::default, |scratch, channel| {
                self.ridges(*channel, &spectrum.respond(*channel, scratch), &mean, &clear)
            })
            .collect();
        Ok(self.view(&unmask(seen), &clear))
    }

    fn check(&self) -> Result<(), VisionError> {
        if !(self.px_per_deg.is_finite() && self.px_per_deg > 0.0) {
            return Err(VisionError::Sampling(self.px_per_deg));
        }
        if self.width.min(self.height) < LEAST {
            return Err(VisionError::TooSmall { width: self.width, height: self.height, least: LEAST });
        }
        let found = self.mask.map_or(self.light.len(), |mask| mask.len().min(self.light.len()));
        check(self.light.iter().copied(), self.width, self.height, found)
    }

    /// A channel's ridges, and its energy for those that it masks.
    fn ridges(&self, channel: Channel, responses: &Responses, mean: &Field, clear: &Clear) -> (Vec<Ridge>, Field) {
        let px = |deg: f64| deg * self.px_per_deg;
        let search = Search {
            responses,
            channel,
            px_per_deg: self.px_per_deg,
            mean,
            clear,
            margin: px(Border::Cut.margin_deg(channel.frequency)),
            beside: px(Border::Cut.beside_deg(channel.frequency)),
        };
        (search.ridges(), self.energy(responses))
    }

    fn view(&self, seen: &[Vec<Ridge>], clear: &Clear) -> PicturePrediction {
        let strongest = |ridges: &Vec<Ridge>| {
            let of = |polarity| self.strongest(ridges, polarity);
            Visibility { bright: of(Polarity::Bright), dark: of(Polarity::Dark) }
        };
        let channels: Vec<Visibility> = seen.par_iter().map(strongest).collect();
        let (map, bands) = rayon::join(|| self.map(seen), || self.bands(seen));
        let area = clear.area() / (self.px_per_deg * self.px_per_deg);
        let amount = |ridges: &Vec<Ridge>| {
            let amounts = ridges.iter().map(|ridge| ridge.strength * ridge.length_px / self.px_per_deg);
            amounts.sum::<f64>() / area
        };
        PicturePrediction {
            bands,
            visibility: Visibility::over(&channels),
            density: pooled(seen.iter().map(amount)),
            map,
        }
    }

    fn bands(&self, seen: &[Vec<Ridge>]) -> Vec<Band> {
        let mut bands: Vec<Band> = seen.iter().flatten().map(|ridge| self.band(ridge)).collect();
        bands.sort_by(|a, b| b.strength.total_cmp(&a.strength));
        bands
    }

    fn map(&self, seen: &[Vec<Ridge>]) -> BandMap {
        let of = |polarity| {
            let mut map = vec![0.0; self.light.len()];
            for ridge in seen.iter().flatten().filter(|ridge| ridge.polarity == polarity) {
                self.draw(ridge, &mut map);
            }
            map.iter_mut().for_each(|value| *value = unpowered(*value));
            map
        };
        let (bright, dark) = rayon::join(|| of(Polarity::Bright), || of(Polarity::Dark));
        BandMap { bright, dark }
    }

    /// What a period's length of a channel's bands exceeds: a single place, where lines cross or end, is none.
    fn strongest(&self, ridges: &[Ridge], polarity: Polarity) -> f64 {
        let mut places: Vec<(f64, f64)> = ridges
            .iter()
            .filter(|ridge| ridge.polarity == polarity)
            .map(|ridge| (ridge.strength, ridge.length_px / self.px_per_deg * ridge.frequency))
            .collect();
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut periods = 0.0;
        let long_enough = places.iter().find(|(_, length)| {
            periods += length;
            periods >= 1.0
        });
        long_enough.map_or(0.0, |(strength, _)| *strength)
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

    /// A stroke as long as the ridge's step, so that lines of coarse channels have no holes.
    fn draw(&self, ridge: &Ridge, map: &mut [f64]) {
        let amount = powered(ridge.strength);
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
}

impl Picture<'_> {
    /// Energy at the few places at which channels mask each other.
    fn energy(&self, responses: &Responses) -> Field {
        let step = (self.px_per_deg / MASK_PER_DEG).max(1.0);
        let count = |side: usize| (side as f64 / step).ceil() as usize + 1;
        let (columns, rows) = (count(self.width), count(self.height));
        // About the middle, so that an image that is turned is masked as before.
        let first = |n: usize, side: usize| side as f64 / 2.0 - (n - 1) as f64 / 2.0 * step;
        let first = [first(columns, self.width), first(rows, self.height)];
        let grid = Grid { columns, rows, first, step: [step; 2] };
        let mut values = responses.grid.resampled(&responses.energy, &grid);
        values.iter_mut().for_each(|energy| *energy = energy.sqrt());
        Field { grid, values }
    }
}

/// Takes from every ridge what finer channels mask; the finest come first.
fn unmask(seen: Vec<(Vec<Ridge>, Field)>) -> Vec<Vec<Ridge>> {
    let mut finer: Option<Field> = None;
    let mut left = Vec::with_capacity(seen.len());
    for (mut ridges, coarse) in seen {
        if let Some(finer) = &finer {
            for ridge in &mut ridges {
                ridge.strength *= unmasked(ridge.energy, finer.at(ridge.at));
            }
            ridges.retain(|ridge| ridge.strength > 0.0);
        }
        left.push(ridges);
        finer = Some(match finer {
            Some(mut finer) => {
                finer.values.iter_mut().zip(&coarse.values).for_each(|(most, value)| *most = most.max(*value));
                finer
            }
            None => coarse,
        });
    }
    left
}

/// Whether an image of this sampling has the channel's frequency.
fn is_sampled(channel: Channel, px_per_deg: f64) -> bool {
    channel.frequency < px_per_deg / 2.0
}

/// Pixels that a side needs for the finest channel to have room between its margins.
fn least_side(px_per_deg: f64) -> usize {
    let finest = Channel::all().filter(|channel| is_sampled(*channel, px_per_deg)).last();
    let margins = finest.map_or(0.0, |channel| 2.0 * Border::Cut.margin_deg(channel.frequency) * px_per_deg);
    (margins.floor() as usize + 1).max(LEAST)
}
