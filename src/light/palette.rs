//! Palettes: reduces an image of 8-bit codes to fewer colors. Shoaff §2.2.10.
//!
//! Colors are counted and split into boxes by their codes, but averaged and compared in linear light: the color of a
//! box is its mean light, and each pixel gets the nearest color in the palette.
//!
//! The palette and the indices are the same on every machine: the code uses no threads and no random numbers, breaks
//! ties by the codes, adds in a fixed order, and first rounds light to f32, so the last bits of a machine's `powf` make
//! no difference.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use super::image::CodeImage;
use super::quantize::{Bits, Quantizer};
use super::transfer::Transfers;
use crate::text::names::{named, serde_as_text, with_number};

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
    }
}

/// An image that consists of a palette and a palette index for every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct IndexedImage {
    /// The red, green and blue codes of each color: at most as many colors as requested, in ascending order, without
    /// duplicates.
    pub palette: Vec<[u8; 3]>,
    /// The palette index of every pixel, row by row from the top left.
    pub indices: Vec<u8>,
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
        with_number(text, Reducer::NAMES, 1..=MAX_COLORS, "colors").map(|(reducer, colors)| Self { reducer, colors })
    }
}

serde_as_text!(Reduction);

/// Reduces `image`, meant for a display that `transfers` describes, to at most the number of colors that `reduction`
/// specifies. Numbers outside 1…256, which no valid text contains, are clamped to that range.
///
/// An image that already has no more colors than that keeps all of them.
///
/// # Errors
/// Returns an error if the image has 16 bits.
pub fn reduce(image: &CodeImage, transfers: &Transfers, reduction: Reduction) -> Result<IndexedImage, &'static str> {
    let colors = reduction.colors.clamp(1, MAX_COLORS) as usize;
    let pixels = image
        .bytes()
        .ok_or("the image has 16-bit codes; expected 8-bit codes, the only ones that a palette can hold")?
        .as_chunks::<3>()
        .0;
    let quantizer = Quantizer::new(transfers, Bits::Eight);
    let tallies = count(pixels, &quantizer);
    let mut palette = if tallies.len() <= colors {
        tallies.iter().map(|tally| tally.codes).collect()
    } else {
        match reduction.reducer {
            Reducer::Popularity => most_frequent(&tallies, colors),
            Reducer::MedianCut => median_cut(&tallies, colors, &quantizer),
        }
    };
    palette.sort_unstable();
    palette.dedup();
    let lights: Vec<[f64; 3]> = palette.iter().map(|&codes| light_of(codes, &quantizer)).collect();
    // There are at most 256 colors.
    let chosen: Vec<u8> = tallies.iter().map(|tally| nearest(&lights, tally.light) as u8).collect();
    // Every color of the image has a tally, so the search always succeeds.
    let tally = |codes: &[u8; 3]| tallies.binary_search_by_key(codes, |tally| tally.codes).unwrap_or(0);
    let indices = pixels.iter().map(|codes| chosen[tally(codes)]).collect();
    Ok(IndexedImage { palette, indices })
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
    let pixels: f64 = tallies.iter().map(|tally| f64::from(tally.count)).sum();
    let light = |channel: usize| tallies.iter().map(|tally| f64::from(tally.count) * tally.light[channel]).sum::<f64>();
    // An 8-bit code fits into u8.
    quantizer.codes([0, 1, 2].map(|channel| (light(channel) / pixels) as f32)).map(|code| code as u8)
}

/// Returns the relative luminances of `codes`, rounded to f32.
fn light_of(codes: [u8; 3], quantizer: &Quantizer) -> [f64; 3] {
    quantizer.linear(codes.map(u16::from)).map(|light| f64::from(light as f32))
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
    let below = tallies.iter().scan(0, |below, tally| {
        *below += 2 * u64::from(tally.count);
        Some(*below)
    });
    // In a tie, the later cut.
    let cuts = (1..tallies.len()).zip(below);
    cuts.min_by_key(|(at, below)| (below.abs_diff(total), std::cmp::Reverse(*at))).map_or(1, |(at, _)| at)
}

/// Returns the index of the color nearest to `light`; the first of equally near ones.
fn nearest(colors: &[[f64; 3]], light: [f64; 3]) -> usize {
    let distance = |color: &[f64; 3]| (0..3).map(|channel| (color[channel] - light[channel]).powi(2)).sum::<f64>();
    let distances = colors.iter().map(distance).enumerate();
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
}
