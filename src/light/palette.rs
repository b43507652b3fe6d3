//! Palettes: an image of 8-bit codes in fewer colors, and the error of its light. Shoaff §2.2.10.
//!
//! Colors are counted and split into boxes by their codes, and averaged and compared in linear light: the color of a box
//! is that of its mean light, and a pixel gets the nearest color of the palette. The reported error is therefore the
//! least that the palette allows.
//!
//! Palette and indices are the same on every machine: no threads, no random numbers, ties decided by the codes, sums in
//! one order, and light rounded to f32 first, so that the last bits of a machine's `powf` do not decide.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use quantette::deps::palette::LinSrgb;
use quantette::wu::{BinnerF32x3, WuF32x3};
use quantette::{PaletteCounts, PaletteSize};

use super::image::{CodeImage, Samples};
use super::names::{named, with_number};
use super::quantize::{Bits, Quantizer};
use super::transfer::Transfers;

/// Most colors that an 8-bit index can tell apart.
const MOST_COLORS: u32 = 256;

named! {
    /// How the colors of a palette are chosen.
    Reducer, ReducerError {
        /// The most frequent colors, as they are. Shoaff §2.2.10, solution 2; Heckbert 1982, without his reduction to 5
        /// bits beforehand.
        Popularity = "popularity",
        /// The box around all colors is split at the median of its longest side, and again the fullest box that can be,
        /// until there are enough; each box gives its mean. Shoaff §2.2.10, solution 3; Heckbert 1982, *Color image
        /// quantization for frame buffer display*, Computer Graphics 16(3):297, doi:10.1145/965145.801294.
        MedianCut = "median-cut",
        /// K-means in linear light (Celebi 2011, doi:10.1016/j.imavis.2010.10.002), begun from boxes of least variance (Wu
        /// 1992, doi:10.1145/146443.146475, by the crate quantette), from median cut and from the most frequent colors; the
        /// best of the three. Its rms error is never above that of the others.
        KMeans = "k-means",
    }
}

/// An image of more bits than a palette has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the image has 16-bit codes; expected 8 bits, which is what palettes hold")]
pub struct SixteenBits;

/// The difference in light between a reduced image and the original, over all pixels and the three channels, in relative
/// luminance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightError {
    /// Root of the mean of the squares.
    pub rms: f64,
    /// The largest.
    pub max: f64,
}

/// An image as a palette and an index for every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct IndexedImage {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue codes; at most as many as requested, in rising order, none twice.
    pub palette: Vec<[u8; 3]>,
    /// Index into the palette of every pixel, row by row from the top left.
    pub indices: Vec<u8>,
    /// The error of the reduction.
    pub error: LightError,
}

impl IndexedImage {
    /// The image with a pixel's codes in place of its index.
    #[must_use]
    pub fn codes(&self) -> CodeImage {
        let codes = self.indices.iter().flat_map(|&index| self.palette[usize::from(index)]).collect();
        CodeImage { width: self.width, height: self.height, samples: Samples::Eight(codes) }
    }
}

/// A color of the image.
#[derive(Clone, Copy, Debug)]
struct Tally {
    codes: [u8; 3],
    /// Its relative luminances, rounded to f32.
    light: [f64; 3],
    /// Pixels that have it.
    count: u32,
}

/// A way to reduce colors, and to how many. Written `median-cut:16`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reduction {
    /// How the palette is chosen.
    pub reducer: Reducer,
    /// Most colors, 1…256.
    pub colors: u32,
}

/// A text that is not a [`Reduction`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is not a palette; expected popularity, median-cut or k-means, a colon and 1…256 colors, such as median-cut:16"
)]
pub struct ReductionError(String);

impl fmt::Display for Reduction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.reducer, self.colors)
    }
}

impl FromStr for Reduction {
    type Err = ReductionError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = with_number(text, 1..=MOST_COLORS).map(|(reducer, colors)| Self { reducer, colors });
        parsed.ok_or_else(|| ReductionError(text.to_owned()))
    }
}

/// The image `image`, of a display that `transfers` describes, in at most as many colors as `reduction` says; numbers
/// outside 1…256, which no text names, act as the nearest inside.
///
/// An image of no more colors than that keeps them all.
///
/// # Errors
/// When the image has 16 bits.
pub fn reduce(
    image: &CodeImage,
    transfers: impl Into<Transfers>,
    reduction: Reduction,
) -> Result<IndexedImage, SixteenBits> {
    let colors = reduction.colors.clamp(1, MOST_COLORS) as usize;
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

/// Every color, in rising order of its codes.
fn count(pixels: &[[u8; 3]], quantizer: &Quantizer) -> Vec<Tally> {
    let mut counts: BTreeMap<[u8; 3], u32> = BTreeMap::new();
    pixels.iter().for_each(|&codes| *counts.entry(codes).or_default() += 1);
    counts.into_iter().map(|(codes, count)| Tally { codes, light: light_of(codes, quantizer), count }).collect()
}

fn most_frequent(tallies: &[Tally], colors: usize) -> Vec<[u8; 3]> {
    let mut tallies = tallies.to_vec();
    // Stable: of equally frequent colors the one of lower codes comes first.
    tallies.sort_by_key(|tally| std::cmp::Reverse(tally.count));
    tallies[..colors].iter().map(|tally| tally.codes).collect()
}

/// The codes of the mean light of `tallies`, which are not none.
fn mean_codes(tallies: &[Tally], quantizer: &Quantizer) -> [u8; 3] {
    let mut sum = Sum::default();
    tallies.iter().for_each(|tally| sum.add(tally));
    codes_of(sum.mean(), quantizer)
}

/// The light of `codes`, rounded to f32.
fn light_of(codes: [u8; 3], quantizer: &Quantizer) -> [f64; 3] {
    quantizer.linear(codes.map(u16::from)).map(|light| f64::from(light as f32))
}

/// Codes of the light `light`.
fn codes_of(light: [f64; 3], quantizer: &Quantizer) -> [u8; 3] {
    // An 8-bit code fits.
    quantizer.codes(light.map(|value| value as f32)).map(|code| code as u8)
}

/// Light added up.
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

/// The channel in which the box of codes around `tallies` is longest; the first of equals.
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
        // The first of equally full boxes.
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

/// How many of the sorted `tallies`, at least 2, hold half of the pixels, or as near to it as can be; neither none nor all.
fn median(tallies: &[Tally]) -> usize {
    let total: u64 = tallies.iter().map(|tally| u64::from(tally.count)).sum();
    let mut below = 0;
    for (at, tally) in tallies.iter().enumerate() {
        let with = below + u64::from(tally.count);
        if 2 * with >= total {
            // The cut before this color or after it, whichever is nearer to the middle.
            let at = if total - 2 * below < 2 * with - total { at } else { at + 1 };
            return at.clamp(1, tallies.len() - 1);
        }
        below = with;
    }
    tallies.len() - 1
}

/// Bins per side of Wu's histogram, spread over the range of light that the image has.
const BINS: usize = 64;
/// Most rounds of k-means. Every round improves the palette; most images need fewer.
const MOST_ROUNDS: usize = 64;

fn k_means(tallies: &[Tally], colors: usize, quantizer: &Quantizer) -> Vec<[u8; 3]> {
    let light = |palette: &[[u8; 3]]| palette.iter().map(|&codes| light_of(codes, quantizer)).collect::<Vec<_>>();
    let coded = |centers: &[[f64; 3]]| centers.iter().map(|&center| codes_of(center, quantizer)).collect::<Vec<_>>();
    let starts = [
        filled_up(least_variance(tallies, colors), tallies, colors),
        light(&median_cut(tallies, colors, quantizer)),
        light(&most_frequent(tallies, colors)),
    ];
    // Rounding to codes may undo what the last rounds gained.
    let palettes = starts.into_iter().flat_map(|start| [coded(&start), coded(&settled(start, tallies))]);
    let squares = |palette: &[[u8; 3]]| {
        let centers = light(palette);
        tallies.iter().map(|tally| f64::from(tally.count) * nearest(&centers, tally.light).1).sum::<f64>()
    };
    // The first of equals.
    palettes
        .map(|palette| (squares(&palette), palette))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(vec![], |best| best.1)
}

/// The `centers` and, up to `colors`, the colors with the largest error.
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

/// The `centers` after k-means: every one the mean of the colors nearest to it.
fn settled(mut centers: Vec<[f64; 3]>, tallies: &[Tally]) -> Vec<[f64; 3]> {
    let mut chosen: Vec<usize> = vec![usize::MAX; tallies.len()];
    for _ in 0..MOST_ROUNDS {
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

/// Centers of at most `colors` boxes of little variance in linear light.
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

/// The nearest of `centers` to `light`, the first of equals, and the square of its distance; ∞ if there are none.
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

/// Gives every pixel its nearest color in `palette`.
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
        // At most 256 colors.
        chosen.push(at as u8);
    }
    // Every color of the image has its tally.
    let tally = |codes: &[u8; 3]| tallies.binary_search_by_key(codes, |tally| tally.codes).unwrap_or(0);
    let indices = pixels.iter().map(|codes| chosen[tally(codes)]).collect();
    let rms = if pixels.is_empty() { 0.0 } else { (squares / (3 * pixels.len()) as f64).sqrt() };
    IndexedImage { width: image.width, height: image.height, palette, indices, error: LightError { rms, max } }
}
