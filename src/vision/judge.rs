//! How visible the difference between two pictures is, in units of people's threshold; and the bright and the dark band of
//! a ramp: how visible it is that the ramp is not a smooth edge.

use rayon::prelude::*;
use statrs::function::erf::erf;

use super::{
    error::{VisionError, check, check_extent},
    eye::{Eye, Sensitivity},
    grid::{ENOUGH_PX_PER_DEG, Grid, Lookup, averaged, coarser, within},
    transforms::{Cosines, next_fast_length},
};
use crate::{
    light::image::{resampled, shares},
    system::checkpoint,
};

/// Responses with at least twice this number of places per degree are averaged before they are pooled, since the weight falls to half only within a third of a degree.
const ENOUGH_TO_POOL: f64 = 30.0;
/// How far a line extends to each side along its bars, degrees.
const HALF_LINE_DEG: f64 = 4.0;

/// Frequency of the lowest band, cycles per degree. Bands are an octave apart.
const LOWEST: f64 = 0.125;
/// Number of bands.
const BANDS: i32 = 9;
/// A band is sampled finely enough for frequencies up to this multiple of its own.
const SAMPLED: f64 = 10.0;

/// An eye, and all it needs to judge pictures of one size.
pub struct Judge {
    eye: Eye,
    /// Size of the pictures `[across, down]`, pixels.
    given: [usize; 2],
    /// The judge's own pixels, which may be coarser.
    pub(super) grid: Grid,
    /// For lines, the unit vector across their bars.
    across: Option<[f64; 2]>,
    /// Functions of a frequency in cycles per degree: what is left of it in the light to which the eye adapts, the
    /// eye's gain, the share of it that is lost for oblique structure, and the part of each band.
    adaptation: Lookup,
    gain: Lookup,
    obliqueness: Lookup,
    shares: Vec<Lookup>,
    /// The weight of a response at a distance in degrees from the gaze, to the power of the pooling.
    weight: Lookup,
    /// Number of places at which responses are pooled, and what that leaves of each cosine over `padded` places.
    places: [usize; 2],
    padded: [usize; 2],
    pooled: Cosines,
}

impl Judge {
    /// Prepares to judge pictures of `size` pixels `[across, down]`.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if there are no pixels, or if the number of pixels per degree is not above 0 or makes
    /// the picture wider than the whole field around the eye.
    pub fn of_pictures(size: [usize; 2], px_per_deg: f64, eye: Eye) -> Result<Judge, VisionError> {
        Judge::new(size, px_per_deg, eye, None)
    }

    /// Prepares to judge lines of `length` pixels: pictures that vary in one direction, of which the judge sees 8°
    /// along the bars. `orientation_deg` is the direction in which they vary, from the horizontal.
    ///
    /// # Errors
    /// As for [`Judge::of_pictures`].
    pub fn of_lines(length: usize, px_per_deg: f64, orientation_deg: f64, eye: Eye) -> Result<Judge, VisionError> {
        let (sine, cosine) = orientation_deg.to_radians().sin_cos();
        Judge::new([length, 1], px_per_deg, eye, Some([cosine, sine]))
    }

    fn new(given: [usize; 2], px_per_deg: f64, eye: Eye, across: Option<[f64; 2]>) -> Result<Judge, VisionError> {
        check_extent(given[0], given[1], px_per_deg)?;
        let Eye { sensitivity, masking, .. } = eye;
        let extent = given.map(|side| side as f64 / px_per_deg);
        let grid = Grid { size: coarser(given, px_per_deg / ENOUGH_PX_PER_DEG), extent };
        let places = coarser(grid.size, 1.0 / grid.step()[0] / ENOUGH_TO_POOL);
        // A line has no other rows.
        let padded =
            [0, 1].map(|axis| if axis == 1 && across.is_some() { 1 } else { next_fast_length(2 * places[axis]) });
        let step = Grid { size: places, extent }.step();
        let farthest = extent[0].hypot(extent[1]);
        let power = |away: f64| sensitivity.eccentric(away).powf(sensitivity.pooling);
        // Along a line, the weight is the integral over its bars, with places that lie densest near the gaze (Simpson).
        let most = (HALF_LINE_DEG / sensitivity.fovea_deg).asinh() / 32.0;
        let places_along = (0..=32).map(|i| {
            let (sinh, cosh) = ((f64::from(i) * most).sinh(), (f64::from(i) * most).cosh());
            let part = if i % 32 == 0 { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
            (sensitivity.fovea_deg * sinh, 2.0 * sensitivity.fovea_deg * cosh * part * most / 3.0)
        });
        let along: Vec<(f64, f64)> = places_along.collect();
        let summed = |x: f64| along.iter().map(|(y, length)| power(x.hypot(*y)) * length).sum::<f64>();
        let weight = match across {
            Some(_) => Lookup::new(farthest, summed),
            None => Lookup::new(farthest, power),
        };
        // What pooling makes of a response at the first place, which lies beside its own mirror images. They are as far from
        // a picture in the middle as its sides are long, where the weights end.
        let images = padded.map(|side| side.min(2));
        let spread = |i: usize| -> f64 {
            if i.is_multiple_of(padded[0]) {
                checkpoint();
            }
            let image = |k: usize| {
                let (right, down) = (i % padded[0] + k % images[0], i / padded[0] + k / images[0]);
                let is_near = right < places[0] && down < places[1];
                if is_near { weight.at((right as f64 * step[0]).hypot(down as f64 * step[1])) } else { 0.0 }
            };
            (0..images[0] * images[1]).map(image).sum()
        };
        let mut pooled = Cosines::of((0..padded[0] * padded[1]).into_par_iter().map(spread).collect(), padded);
        // Relative to the cosines of that response. A sum becomes an integral.
        let area = if across.is_some() { step[0] } else { step[0] * step[1] };
        let alone = |k: usize, n: f64| 2.0 / n * (std::f64::consts::FRAC_PI_2 * k as f64 / n).cos();
        pooled.filter(|x, y| area / (alone(x, padded[0] as f64) * alone(y, padded[1] as f64)));
        let of = |value: &dyn Fn(f64) -> f64| Lookup::new(grid.finest(), value);
        Ok(Judge {
            eye,
            given,
            grid,
            across,
            adaptation: of(&|f| (-2.0 * (std::f64::consts::PI * masking.adaptation_deg * f).powi(2)).exp()),
            gain: of(&|f| if f > 0.0 { sensitivity.at(f, eye.luminance) } else { 0.0 }),
            obliqueness: of(&Sensitivity::obliqueness),
            shares: (0..BANDS).map(|band| of(&|f| share(band, f, masking.ratio))).collect(),
            weight,
            places,
            padded,
            pooled,
        })
    }

    /// Judges the difference of the picture `shown` from `reference`, both in cd/m², row by row. `share`, 0…1, is how
    /// far a difference counts at each pixel; without it, it counts everywhere.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if their light is not a positive number.
    ///
    /// # Panics
    /// Panics if the pictures or the share do not have the judge's size.
    pub fn difference(
        &self,
        shown: &[f64],
        reference: &[f64],
        share: Option<&[f64]>,
    ) -> Result<Difference<'_>, VisionError> {
        let (contrast, reference) = self.contrasts(shown, reference, share)?;
        Ok(self.judged(contrast, reference))
    }

    /// Judges the same difference as if the reference masked nothing.
    ///
    /// # Errors
    /// As for [`Judge::difference`].
    pub fn unmasked(&self, shown: &[f64], reference: &[f64]) -> Result<Difference<'_>, VisionError> {
        let (contrast, _) = self.contrasts(shown, reference, None)?;
        Ok(Difference { judge: self, response: contrast.at(self.grid.size, None, |_, _| 1.0) })
    }

    /// Returns the difference and the reference in units of the light to which the eye adapts, through the eye's filter.
    fn contrasts(
        &self,
        shown: &[f64],
        reference: &[f64],
        share: Option<&[f64]>,
    ) -> Result<(Cosines, Cosines), VisionError> {
        let [width, height] = self.given;
        for light in [shown, reference] {
            if let Some(i) = light.iter().position(|value| *value == 0.0) {
                return Err(VisionError::Black { x: i % width, y: i / width });
            }
            check(light, width, height, width as f64 / self.grid.extent[0])?;
        }
        let (mut shown, mut reference) = (self.averaged(shown), self.averaged(reference));
        let both = shown.par_iter().zip(&reference).map(|(a, b)| 0.5 * (a + b)).collect();
        let adapted = Cosines::of(both, self.grid.size)
            .at(self.grid.size, None, |x, y| self.adaptation.at(self.grid.frequency(x, y)));
        let share = share.map(|share| self.averaged(share));
        let each = shown.par_iter_mut().zip(&mut reference).zip(&adapted).enumerate();
        each.for_each(|(i, ((a, b), light))| {
            *a = (*a - *b) / light * share.as_ref().map_or(1.0, |share| share[i]);
            *b /= light;
        });
        drop((adapted, share));
        let filtered = |picture| {
            let mut cosines = Cosines::of(picture, self.grid.size);
            cosines.filter(|x, y| {
                let f = self.grid.frequency(x, y);
                let across = self.across.unwrap_or_else(|| {
                    let [right, down] = self.grid.frequencies(x, y);
                    [right / f.max(f64::MIN_POSITIVE), down / f.max(f64::MIN_POSITIVE)]
                });
                self.gain.at(f) * (1.0 - self.obliqueness.at(f) * (2.0 * across[0] * across[1]).powi(2))
            });
            cosines
        };
        Ok((filtered(shown), filtered(reference)))
    }

    fn averaged(&self, picture: &[f64]) -> Vec<f64> {
        averaged(picture.to_vec(), self.given, self.grid.size)
    }

    /// Masks the difference by the reference, band by band.
    fn judged(&self, contrast: Cosines, reference: Cosines) -> Difference<'_> {
        let mut masked = Cosines::none(self.grid.size);
        let mut finest = vec![0.0; self.grid.size[0] * self.grid.size[1]];
        for (band, share) in self.shares.iter().enumerate() {
            let share = |x: usize, y: usize| share.at(self.grid.frequency(x, y));
            let per_deg = 2.0 * SAMPLED * LOWEST * f64::from(1 << band);
            let enough = |axis: usize| next_fast_length(((self.grid.extent[axis] * per_deg).ceil() as usize).max(8));
            let places = [0, 1].map(|axis| enough(axis).min(self.grid.size[axis]));
            let mut mask = reference.at(places, None, share);
            mask.par_iter_mut().for_each(|value| *value *= *value);
            for axis in (0..2).filter(|axis| places[*axis] > 1) {
                // The Riesz transform: odd responses in all orientations alike.
                let odd = reference.at(places, Some(axis), |x, y| {
                    let (part, f) = (self.grid.frequencies(x, y)[axis], self.grid.frequency(x, y));
                    share(x, y) * part / f.max(f64::MIN_POSITIVE)
                });
                mask.par_iter_mut().zip(odd).for_each(|(sum, odd)| *sum += odd * odd);
            }
            let mut own = contrast.at(places, None, share);
            let scale = 1.0 / (self.eye.masking.half * self.eye.masking.half);
            own.par_iter_mut().zip(mask).for_each(|(own, mask)| *own /= (1.0 + mask * scale).sqrt());
            if places == self.grid.size {
                finest.par_iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            } else {
                masked.add(&Cosines::of(own, places));
            }
        }
        drop((contrast, reference));
        let coarse = masked.at(self.grid.size, None, |_, _| 1.0);
        finest.par_iter_mut().zip(coarse).for_each(|(sum, coarse)| *sum += coarse);
        Difference { judge: self, response: finest }
    }
}

/// Returns the part of a response at `frequency` that belongs to a band whose Gaussian has this `ratio`. The parts of all
/// bands add up to 1.
fn share(band: i32, frequency: f64, ratio: f64) -> f64 {
    let octaves = (frequency.max(f64::MIN_POSITIVE) / LOWEST).log2();
    let of = |band: i32| {
        let away = octaves - f64::from(band);
        let is_beyond = (band == 0 && away < 0.0) || (band == BANDS - 1 && away > 0.0);
        if is_beyond { 1.0 } else { (-0.5 * (away / ratio.log2()).powi(2)).exp() }
    };
    of(band) / (0..BANDS).map(of).sum::<f64>()
}

/// The visible difference between two pictures.
pub struct Difference<'a> {
    judge: &'a Judge,
    /// The response of the eye to the difference at each of the judge's pixels, after masking.
    response: Vec<f64>,
}

/// How visible a difference is for a gaze at each place, in times threshold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DifferenceMap {
    /// Times threshold, row by row.
    pub times: Vec<f64>,
    /// Number of places `[across, down]`.
    pub places: [usize; 2],
    /// Size of the picture `[across, down]`, pixels.
    pub size: [usize; 2],
}

/// One of the places at which a difference is most visible.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Place {
    /// Column and row of the pixel, from 0.
    pub x: usize,
    pub y: usize,
    /// Times threshold for a gaze there.
    pub times_threshold: f64,
}

impl Difference<'_> {
    /// Returns the map of the difference.
    pub fn map(&self) -> DifferenceMap {
        self.map_of(|_, response| response.abs())
    }

    /// Returns the map of a part of the response: `part` gets the place across the picture, 0…1, and the
    /// response there; it returns a number that is not negative.
    pub fn map_of(&self, part: impl Fn(f64, f64) -> f64 + Sync) -> DifferenceMap {
        let Judge { eye, given, grid: Grid { size, .. }, places, padded, pooled, .. } = self.judge;
        let power = eye.sensitivity.pooling;
        let across = |i: usize| ((i % size[0]) as f64 + 0.5) / size[0] as f64;
        let powers: Vec<f64> =
            self.response.par_iter().enumerate().map(|(i, value)| part(across(i), *value).powf(power)).collect();
        let powers = averaged(powers, *size, *places);
        let (values, first) = within(&powers, *places, *padded);
        let values = Cosines::of(values, *padded).at(*padded, None, |x, y| pooled.amplitudes[x * padded[1] + y]);
        let rows = values.chunks_exact(padded[0]).skip(first[1]).take(places[1]).inspect(|_| checkpoint());
        let times = rows.flat_map(|row| &row[first[0]..][..places[0]]).map(|value| value.max(0.0).powf(1.0 / power));
        let times = times.collect();
        DifferenceMap { times, places: *places, size: *given }
    }

    /// Returns how visible the difference is for a gaze at the middle of the picture, in times threshold.
    pub fn center(&self) -> f64 {
        let Judge { eye, grid, weight, across, .. } = self.judge;
        grid.pooled(&self.response, [[0; 2], grid.size], eye.sensitivity.pooling, weight, across.is_some())
    }
}

impl DifferenceMap {
    /// Returns the largest value.
    pub fn largest(&self) -> f64 {
        self.times.iter().copied().fold(0.0, f64::max)
    }

    /// Returns up to `number` peaks, the highest first, that are at least `apart` pixels from each other.
    pub fn peaks(&self, number: usize, apart: f64) -> Vec<Place> {
        let [columns, rows] = self.places;
        let is_peak = |i: usize| {
            let (x, y, own) = (i % columns, i / columns, self.times[i]);
            let near = |at: usize, n: usize| at.saturating_sub(1)..(at + 2).min(n);
            own > 0.0 && near(y, rows).all(|y| near(x, columns).all(|x| self.times[y * columns + x] <= own))
        };
        let mut all: Vec<usize> = (0..self.times.len()).filter(|i| is_peak(*i)).collect();
        all.sort_by(|a, b| self.times[*b].total_cmp(&self.times[*a]));
        let mut found: Vec<Place> = Vec::new();
        for i in all {
            // The pixel at the middle of the place.
            let middle = |axis: usize, place: usize| (2 * place + 1) * self.size[axis] / (2 * self.places[axis]);
            let (x, y) = (middle(0, i % columns), middle(1, i / columns));
            let is_far = |other: &Place| (x as f64 - other.x as f64).hypot(y as f64 - other.y as f64) >= apart;
            if found.iter().all(is_far) {
                found.push(Place { x, y, times_threshold: self.times[i] });
            }
            if found.len() == number {
                break;
            }
        }
        found
    }

    /// Returns the map with one value for each pixel of the picture, row by row.
    pub fn enlarged(&self) -> Vec<f64> {
        let at = |x: usize, y: usize| [self.times[y * self.places[0] + x]];
        resampled(self.places, self.size, shares, at).into_flattened()
    }
}

/// The nearest smooth edge is sought among those with up to this multiple of the blur that suits the places at which the
/// ramp rises, and down to the same part of it ...
const REACH: f64 = 1.25;
/// ... in this number of equal ratios to either side.
const STEPS: i32 = 4;
/// Edges count with this power of the inverse of their difference, so that the result moves from one to the next without
/// a jump.
const NEARNESS: i32 = 12;
/// Below this difference, in times threshold, they count alike: nobody can tell them from the ramp.
const ALIKE: f64 = 0.3;
/// They are compared at this contrast: what is nearest depends on the shape of the ramp alone.
const CONTRAST: f64 = 0.5;
/// The mean logarithm of the distance from the middle of a Gaussian with σ = 1.
const LOG_DISTANCE: f64 = -0.635_181_422_730_739;
/// The smallest blur, pixels: the edge is as good as a step.
const SHARP_PX: f64 = 1e-3;

/// How visible the bands of a ramp are: the difference from the nearest smooth edge, in times threshold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RampBands {
    /// On the light side, where the ramp looks brighter than the edge.
    pub bright: f64,
    /// On the dark side, where it looks darker.
    pub dark: f64,
    /// σ of the nearest smooth edge, degrees: the Gaussian blur of a step.
    pub blur_deg: f64,
    /// The places of the bright and of the dark band, degrees from the middle of the line.
    pub at_deg: [f64; 2],
}

impl RampBands {
    /// Judges the bands of a line that rises from one plateau to another, or falls, in cd/m². The reference is the
    /// step between the plateaus with the Gaussian blur at which the unmasked difference is smallest, as people's
    /// judgments of blur suggest (Georgeson, May, Freeman & Hesse 2007, J. Vision 7(13):7). A line without a rise has no
    /// bands.
    ///
    /// # Errors
    /// As for [`Judge::difference`].
    ///
    /// # Panics
    /// Panics if the line does not have the judge's size.
    pub fn of(judge: &Judge, light: &[f64]) -> Result<RampBands, VisionError> {
        let (first, last) = (light[0], light[light.len() - 1]);
        // Less is a rounding error.
        if (last - first).abs() <= 1e-7 * first {
            return Ok(RampBands::default());
        }
        let size = light.len() as f64;
        let px = judge.grid.extent[0] / size;
        let rise = (last - first).signum();
        let shares: Vec<f64> = light.iter().map(|value| (value - first) / (last - first)).collect();
        // The edge has as much light as the ramp.
        let center = shares.iter().map(|share| 1.0 - share).sum::<f64>().clamp(0.0, size);
        let edge = |blur: f64| -> Vec<f64> {
            let risen = |at: usize| integral_of_edge(at as f64 - center, blur);
            (0..light.len()).map(|i| risen(i + 1) - risen(i)).collect()
        };
        let middle = 0.5 * (first + last);
        let weak = |shares: &[f64]| -> Vec<f64> {
            let of = |share: &f64| middle * (1.0 + CONTRAST * rise * (2.0 * share - 1.0)).max(1.0 - CONTRAST);
            shares.iter().map(of).collect()
        };
        let (about, ramp) = (suitable_blur(&shares, center).min(size), weak(&shares));
        let try_one = |step: i32| {
            let blur = about * REACH.powf(f64::from(step) / f64::from(STEPS));
            let far = judge.unmasked(&ramp, &weak(&edge(blur)))?.map().largest();
            Ok((blur.ln(), far.hypot(ALIKE).powi(-NEARNESS)))
        };
        let tried = (-STEPS..=STEPS).map(try_one).collect::<Result<Vec<(f64, f64)>, VisionError>>()?;
        let (sum, weights) =
            tried.iter().fold((0.0, 0.0), |(sum, all), (log, weight)| (sum + log * weight, all + weight));
        let blur = (sum / weights).exp();
        let reference: Vec<f64> = edge(blur).into_iter().map(|share| first + (last - first) * share).collect();
        let difference = judge.difference(light, &reference, None)?;
        let is_light = |x: f64| (x * size - center) * rise > 0.0;
        let bright = difference.map_of(|x, response| if is_light(x) { response.max(0.0) } else { 0.0 });
        let dark = difference.map_of(|x, response| if is_light(x) { 0.0 } else { (-response).max(0.0) });
        let at_deg = [&bright, &dark].map(|map| {
            let peak = map.peaks(1, 1.0);
            peak.first().map_or(0.0, |peak| (peak.x as f64 + 0.5 - 0.5 * size) * px)
        });
        Ok(RampBands { bright: bright.largest(), dark: dark.largest(), blur_deg: blur * px, at_deg })
    }
}

/// Returns the integral, from far on its dark side to `x`, of an edge that rises from 0 to 1 around 0 with this `blur`.
fn integral_of_edge(x: f64, blur: f64) -> f64 {
    let z = x / blur;
    let density = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    0.5 * x * (1.0 + erf(z * std::f64::consts::FRAC_1_SQRT_2)) + blur * density
}

/// Returns the blur of the edge that rises at the same mean logarithmic distance from `center` as the line that has these
/// shares of its light, in pixels.
fn suitable_blur(shares: &[f64], center: f64) -> f64 {
    // Light rises evenly between the middles of two pixels.
    let integral = |x: f64| if x == 0.0 { 0.0 } else { x * x.abs().ln() - x };
    let square = |share: &dyn Fn(usize) -> f64| {
        let rise = |i: usize| {
            let at = i as f64 - center;
            (share(i) - share(i - 1)) * (integral(at + 0.5) - integral(at - 0.5))
        };
        (2.0 * ((1..shares.len()).map(rise).sum::<f64>() - LOG_DISTANCE)).exp()
    };
    // Less what a step would have in these pixels.
    let step = |i: usize| (i as f64 + 1.0 - center).clamp(0.0, 1.0);
    (square(&|i| shares[i]) - square(&step)).max(SHARP_PX * SHARP_PX).sqrt()
}
