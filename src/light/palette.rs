//! Palettes: reduces an image of 8-bit codes to fewer colors and reports the error in light. Shoaff §2.2.10.
//!
//! Colors are counted and split into boxes by their codes, but averaged and compared in linear light: the color of a
//! box is its mean light, and each pixel gets the nearest color in the palette. The reported error is therefore the
//! smallest that the palette allows.
//!
//! The palette and the indices are the same on every machine: the code uses no threads and no random numbers, breaks
//! ties by the codes, adds in a fixed order, and first rounds light to f32, so the last bits of a machine's `powf` make
//! no difference.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use quantette::deps::palette::LinSrgb;
use quantette::wu::{BinnerF32x3, WuF32x3};
use quantette::{PaletteCounts, PaletteSize};

use super::image::{CodeImage, Samples};
use super::quantize::{Bits, Quantizer};
use super::transfer::Transfers;
use crate::text::names::{named, with_number};

/// The most colors that an 8-bit index can address.
const MAX_COLORS: u32 = 256;

named! {
    /// How the colors of a palette are chosen.
    Reducer, ReducerError {
        /// The most frequent colors, unchanged. Shoaff §2.2.10, solution 2; Heckbert 1982, without his initial
        /// reduction to 5 bits.
        Popularity = "popularity",
        /// Splits the box around all colors at the median of its longest side, then repeatedly splits the box with the
        /// most pixels among those that can be split, until there are enough boxes. Each box contributes its mean
        /// color. Shoaff §2.2.10, solution 3; Heckbert 1982, *Color image quantization for frame buffer display*,
        /// Computer Graphics 16(3):297, doi:10.1145/965145.801294.
        MedianCut = "median-cut",
        /// K-means in linear light (Celebi 2011, doi:10.1016/j.imavis.2010.10.002), starting from boxes of least
        /// variance (Wu 1992, doi:10.1145/146443.146475, computed by the crate quantette), from median cut and from the
        /// most frequent colors; the best of the three results wins. Its rms error is never larger than the error of
        /// the other two methods.
        KMeans = "k-means",
    }
}

/// The image has more bits per code than a palette can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the image has 16-bit codes; expected 8-bit codes, the only ones that a palette can hold")]
pub struct SixteenBits;

/// The difference between a reduced image and the original, over all pixels and all three channels, in relative
/// luminance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightError {
    /// The root mean square of the differences.
    pub rms: f64,
    /// The largest difference.
    pub max: f64,
}

/// An image that consists of a palette and a palette index for every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct IndexedImage {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// The red, green and blue codes of each color: at most as many colors as requested, in ascending order, without
    /// duplicates.
    pub palette: Vec<[u8; 3]>,
    /// The palette index of every pixel, row by row from the top left.
    pub indices: Vec<u8>,
    /// The error that the reduction causes.
    pub error: LightError,
}

impl IndexedImage {
    /// Returns the image with each index replaced by its color's codes.
    pub fn codes(&self) -> CodeImage {
        let codes = self.indices.iter().flat_map(|&index| self.palette[usize::from(index)]).collect();
        CodeImage { width: self.width, height: self.height, samples: Samples::Eight(codes) }
    }
}

/// A color of the image and how often it occurs.
#[derive(Clone, Copy, Debug)]
struct Tally {
    codes: [u8; 3],
    /// The relative luminance of each channel, rounded to f32.
    light: [f64; 3],
    /// The number of pixels of this color.
    count: u32,
}

/// A method of color reduction and the number of colors, written as in `median-cut:16`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reduction {
    /// How the palette is chosen.
    pub reducer: Reducer,
    /// The maximum number of colors, 1…256.
    pub colors: u32,
}

impl fmt::Display for Reduction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.reducer, self.colors)
    }
}

impl FromStr for Reduction {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = with_number(text, 1..=MAX_COLORS).map(|(reducer, colors)| Self { reducer, colors });
        parsed.ok_or_else(|| {
            format!(
                "{text:?} is not a palette; expected popularity, median-cut or k-means, a colon and 1…256 colors, such as median-cut:16"
            )
        })
    }
}

/// Reduces `image`, meant for a display that `transfers` describes, to at most the number of colors that `reduction`
/// specifies. Numbers outside 1…256, which no valid text contains, are clamped to that range.
///
/// An image that already has no more colors than that keeps all of them.
///
/// # Errors
/// Returns an error if the image has 16 bits.
pub fn reduce(
    image: &CodeImage,
    transfers: impl Into<Transfers>,
    reduction: Reduction,
) -> Result<IndexedImage, SixteenBits> {
    let colors = reduction.colors.clamp(1, MAX_COLORS) as usize;
    let pixels = image.bytes().ok_or(SixteenBits)?.as_chunks::<3>().0;
    let quantizer = Quantizer::new(transfers, Bits::Eight);
    let tallies = count(pixels, &quantizer);
    let mut palette = if tallies.len() <= colors {
        tallies.iter().map(|tally| tally.codes).collect()
    } else {
        match reduction.reducer {
            Reducer::Popularity => most_frequent(&tallies, colors),
            Reducer::MedianCut => median_cut(&tallies, colors, &quantizer),
            Reducer::KMeans => k_means(&tallies, colors, &quantizer),
        }
    };
    palette.sort_unstable();
    palette.dedup();
    Ok(index(image, pixels, palette, &tallies, &quantizer))
}

/// Counts the pixels of every color; the colors come in ascending order of their codes.
fn count(pixels: &[[u8; 3]], quantizer: &Quantizer) -> Vec<Tally> {
    let mut counts: BTreeMap<[u8; 3], u32> = BTreeMap::new();
    pixels.iter().for_each(|&codes| *counts.entry(codes).or_default() += 1);
    counts.into_iter().map(|(codes, count)| Tally { codes, light: light_of(codes, quantizer), count }).collect()
}

fn most_frequent(tallies: &[Tally], colors: usize) -> Vec<[u8; 3]> {
    let mut tallies = tallies.to_vec();
    // The sort is stable: among equally frequent colors, the one with lower codes comes first.
    tallies.sort_by_key(|tally| std::cmp::Reverse(tally.count));
    tallies[..colors].iter().map(|tally| tally.codes).collect()
}

/// Returns the codes of the mean light of `tallies`, which must not be empty.
fn mean_codes(tallies: &[Tally], quantizer: &Quantizer) -> [u8; 3] {
    let mut sum = Sum::default();
    tallies.iter().for_each(|tally| sum.add(tally));
    codes_of(sum.mean(), quantizer)
}

/// Returns the relative luminances of `codes`, rounded to f32.
fn light_of(codes: [u8; 3], quantizer: &Quantizer) -> [f64; 3] {
    quantizer.linear(codes.map(u16::from)).map(|light| f64::from(light as f32))
}

fn codes_of(light: [f64; 3], quantizer: &Quantizer) -> [u8; 3] {
    // An 8-bit code fits into u8.
    quantizer.codes(light.map(|value| value as f32)).map(|code| code as u8)
}

/// A sum of light over pixels, from which the mean is taken.
#[derive(Clone, Copy, Default)]
struct Sum {
    light: [f64; 3],
    count: f64,
}

impl Sum {
    fn add(&mut self, tally: &Tally) {
        let count = f64::from(tally.count);
        for (sum, value) in self.light.iter_mut().zip(tally.light) {
            *sum += count * value;
        }
        self.count += count;
    }

    fn mean(&self) -> [f64; 3] {
        self.light.map(|sum| sum / self.count)
    }
}

/// Returns the channel in which the box of codes around `tallies` is longest; in a tie, the first channel.
fn longest_side(tallies: &[Tally]) -> usize {
    let side = |channel: usize| {
        let codes = || tallies.iter().map(|tally| tally.codes[channel]);
        codes().max().unwrap_or(0) - codes().min().unwrap_or(0)
    };
    (1..3).fold(0, |longest, channel| if side(channel) > side(longest) { channel } else { longest })
}

fn median_cut(tallies: &[Tally], colors: usize, quantizer: &Quantizer) -> Vec<[u8; 3]> {
    let mut boxes = vec![tallies.to_vec()];
    while boxes.len() < colors {
        let pixels = |tallies: &[Tally]| tallies.iter().map(|tally| u64::from(tally.count)).sum::<u64>();
        let splittable = boxes.iter().enumerate().filter(|(_, tallies)| tallies.len() > 1);
        // In a tie, the first box.
        let Some((fullest, _)) = splittable.max_by_key(|(at, tallies)| (pixels(tallies), std::cmp::Reverse(*at)))
        else {
            break;
        };
        let mut lower = std::mem::take(&mut boxes[fullest]);
        let channel = longest_side(&lower);
        lower.sort_by_key(|tally| tally.codes[channel]);
        let upper = lower.split_off(median(&lower));
        boxes[fullest] = lower;
        boxes.push(upper);
    }
    boxes.iter().map(|tallies| mean_codes(tallies, quantizer)).collect()
}

/// Returns how many of the sorted `tallies` (at least 2), counted from the first, together hold closest to half of the
/// pixels: at least one and never all.
fn median(tallies: &[Tally]) -> usize {
    let total: u64 = tallies.iter().map(|tally| u64::from(tally.count)).sum();
    let mut below = 0;
    for (at, tally) in tallies.iter().enumerate() {
        let with = below + u64::from(tally.count);
        if 2 * with >= total {
            // Cut before or after this color, whichever is nearer to the middle.
            let at = if total - 2 * below < 2 * with - total { at } else { at + 1 };
            return at.clamp(1, tallies.len() - 1);
        }
        below = with;
    }
    tallies.len() - 1
}

/// Bins per side of Wu's histogram, spread over the image's range of light.
const BINS: usize = 64;
/// The maximum number of k-means rounds. Every round improves the palette; most images need fewer.
const MAX_ROUNDS: usize = 64;

fn k_means(tallies: &[Tally], colors: usize, quantizer: &Quantizer) -> Vec<[u8; 3]> {
    let light = |palette: &[[u8; 3]]| palette.iter().map(|&codes| light_of(codes, quantizer)).collect::<Vec<_>>();
    let coded = |centers: &[[f64; 3]]| centers.iter().map(|&center| codes_of(center, quantizer)).collect::<Vec<_>>();
    let starts = [
        filled_up(least_variance(tallies, colors), tallies, colors),
        light(&median_cut(tallies, colors, quantizer)),
        light(&most_frequent(tallies, colors)),
    ];
    // Rounding to codes may undo what the last rounds gained, so the starting palettes also compete.
    let palettes = starts.into_iter().flat_map(|start| [coded(&start), coded(&settled(start, tallies))]);
    let squares = |palette: &[[u8; 3]]| {
        let centers = light(palette);
        tallies.iter().map(|tally| f64::from(tally.count) * nearest(&centers, tally.light).1).sum::<f64>()
    };
    // `min_by` returns the first of equally good palettes.
    palettes
        .map(|palette| (squares(&palette), palette))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(vec![], |best| best.1)
}

/// Fills `centers` up to `colors` entries by repeatedly adding the color with the largest total error.
fn filled_up(mut centers: Vec<[f64; 3]>, tallies: &[Tally], colors: usize) -> Vec<[f64; 3]> {
    let mut distances: Vec<f64> = tallies.iter().map(|tally| nearest(&centers, tally.light).1).collect();
    while centers.len() < colors {
        let cost = |at: usize| distances[at] * f64::from(tallies[at].count);
        let worst = (0..tallies.len()).fold(0, |worst, at| if cost(at) > cost(worst) { at } else { worst });
        if distances[worst] <= 0.0 {
            break;
        }
        let center = tallies[worst].light;
        for (distance, tally) in distances.iter_mut().zip(tallies) {
            *distance = distance.min(squared_distance(center, tally.light));
        }
        centers.push(center);
    }
    centers
}

/// Returns the `centers` after k-means: each is the mean of the colors nearest to it.
fn settled(mut centers: Vec<[f64; 3]>, tallies: &[Tally]) -> Vec<[f64; 3]> {
    let mut chosen: Vec<usize> = vec![usize::MAX; tallies.len()];
    for _ in 0..MAX_ROUNDS {
        let mut sums = vec![Sum::default(); centers.len()];
        let mut changed = false;
        for (tally, chosen) in tallies.iter().zip(&mut chosen) {
            let (at, _) = nearest(&centers, tally.light);
            changed |= std::mem::replace(chosen, at) != at;
            sums[at].add(tally);
        }
        if !changed {
            break;
        }
        for (center, sum) in centers.iter_mut().zip(&sums) {
            if sum.count > 0.0 {
                *center = sum.mean();
            }
        }
    }
    centers
}

/// Returns the centers of at most `colors` boxes of low variance in linear light.
fn least_variance(tallies: &[Tally], colors: usize) -> Vec<[f64; 3]> {
    let ranges = [0, 1, 2].map(|channel| {
        let light = || tallies.iter().map(|tally| tally.light[channel] as f32);
        let (least, most) = (light().fold(f32::INFINITY, f32::min), light().fold(f32::NEG_INFINITY, f32::max));
        (least, if most > least { most } else { least + 1.0 })
    });
    let light = tallies.iter().map(|tally| LinSrgb::from(tally.light.map(|value| value as f32))).collect();
    let counts = tallies.iter().map(|tally| tally.count).collect();
    let size = PaletteSize::try_from(colors).unwrap_or(PaletteSize::MAX);
    let binner = BinnerF32x3::<BINS, BINS, BINS>::new(ranges);
    let boxes = PaletteCounts::new(light, counts).ok().and_then(|counts| WuF32x3::run_palette_counts(&counts, binner));
    let centers = boxes.map(|boxes| boxes.palette(size));
    centers.map_or_else(Vec::new, |centers| {
        centers.iter().map(|center| [center.red, center.green, center.blue].map(f64::from)).collect()
    })
}

#[inline]
fn squared_distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

/// Returns the index of the center nearest to `light` (the first of equally near centers) and its squared distance,
/// which is ∞ if `centers` is empty.
fn nearest(centers: &[[f64; 3]], light: [f64; 3]) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for (at, &center) in centers.iter().enumerate() {
        let distance = squared_distance(center, light);
        if distance < best.1 {
            best = (at, distance);
        }
    }
    best
}

/// Gives every pixel the nearest color in `palette` and measures the error.
fn index(
    image: &CodeImage,
    pixels: &[[u8; 3]],
    palette: Vec<[u8; 3]>,
    tallies: &[Tally],
    quantizer: &Quantizer,
) -> IndexedImage {
    let light = |codes: [u8; 3]| quantizer.linear(codes.map(u16::from));
    let centers: Vec<[f64; 3]> = palette.iter().map(|&codes| light_of(codes, quantizer)).collect();
    let (mut squares, mut max) = (0.0, 0.0f64);
    let mut chosen = Vec::with_capacity(tallies.len());
    for tally in tallies {
        let (at, _) = nearest(&centers, tally.light);
        for (before, after) in light(tally.codes).into_iter().zip(light(palette[at])) {
            let error = (before - after).abs();
            squares += f64::from(tally.count) * error * error;
            max = max.max(error);
        }
        // There are at most 256 colors.
        chosen.push(at as u8);
    }
    // Every color of the image has a tally, so the search always succeeds.
    let tally = |codes: &[u8; 3]| tallies.binary_search_by_key(codes, |tally| tally.codes).unwrap_or(0);
    let indices = pixels.iter().map(|codes| chosen[tally(codes)]).collect();
    let rms = if pixels.is_empty() { 0.0 } else { (squares / (3 * pixels.len()) as f64).sqrt() };
    IndexedImage { width: image.width, height: image.height, palette, indices, error: LightError { rms, max } }
}
