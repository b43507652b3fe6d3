//! Halftone: many levels of light from a device with few codes. Shoaff §2.1.2.
//!
//! A device with m bits shows 2^m levels on its own and n²·(2^m − 1) + 1 levels with cells of n × n dots. Level j =
//! c·n² + r is a cell whose first r dots, in the order of a [`DitherMatrix`], have the code c + 1, and whose other dots
//! have the code c. From each level to the next, the code of one dot rises by one and no other dot changes: the levels
//! are a growth sequence.
//!
//! Shoaff counts levels as if the codes were evenly spaced in light. Here, a device has a [`Transfer`], and a value
//! gets the level whose cell has the nearest mean light, as in [`dither`](super::dither).

use std::fmt;
use std::str::FromStr;

use super::dither::{DitherMatrix, Levels, from_rank};
use super::image::{CodeImage, LinearImage, Samples};
use super::transfer::{Transfer, Transfers};
use crate::text::names::with_number;

/// The maximum number of bits in a code.
const MAX_BITS: u32 = 8;

/// Maximum side in pixels of an image drawn in cells, the same as for any other image that the program writes.
pub const MAX_PX: u32 = 16_384;

/// A device with few codes and the cells drawn on it. Written as the matrix and the bits per channel: `clustered3:1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Screen {
    /// The order of the dots in a cell.
    pub matrix: DitherMatrix,
    /// Bits m of a code, 1…8.
    pub bits: u32,
}

impl fmt::Display for Screen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.matrix, self.bits)
    }
}

impl FromStr for Screen {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = with_number(text, 1..=MAX_BITS).map(|(matrix, bits)| Self { matrix, bits });
        parsed.ok_or_else(|| {
            format!(
                "{text:?} is not a halftone; expected bayer2, bayer4, bayer8, bayer16, clustered2 or clustered3, a colon and 1…8 bits, such as clustered3:1"
            )
        })
    }
}

/// Converts light to the cells of a device whose code c has the encoded value c/(2^m − 1).
#[derive(Clone, Debug)]
pub struct Halftone {
    screen: Screen,
    ranks: Vec<u16>,
    /// The threshold of every rank, in ascending order.
    thresholds: Vec<f64>,
    /// The levels of red, green and blue.
    levels: [Levels; 3],
}

impl Halftone {
    /// Makes a halftone with `screen` for a device that `transfers` describes. Bits outside 1…8, which no valid text
    /// contains, are clamped to that range.
    pub fn new(screen: Screen, transfers: &Transfers) -> Self {
        let screen = Screen { bits: screen.bits.clamp(1, MAX_BITS), ..screen };
        let max = max_code(screen.bits);
        let light = |transfer: &Transfer| {
            Levels::new((0..=max).map(|code| transfer.linear_from_encoded(f64::from(code) / f64::from(max))))
        };
        let ranks = screen.matrix.ranks();
        let thresholds = (0..).take(ranks.len()).map(|rank| from_rank(rank, screen.matrix.size())).collect();
        Self { screen, ranks, thresholds, levels: transfers.channels().each_ref().map(light) }
    }

    /// Returns the number of levels that a cell can show, n²·(2^m − 1) + 1. Three channels together show the cube of
    /// this number.
    pub fn level_count(&self) -> u32 {
        self.dots() * u32::from(max_code(self.screen.bits)) + 1
    }

    /// Returns the level, 0…[`level_count`](Halftone::level_count) − 1, whose mean light is nearest to the relative
    /// luminance `linear` of a channel; in a tie, the lower level. NaN gives level 0.
    pub fn level(&self, channel: usize, linear: f32) -> u32 {
        let levels = &self.levels[channel];
        let code = levels.at_most(linear);
        let lit = self.thresholds.partition_point(|&threshold| levels.decide(linear, threshold, code) > code);
        // `lit` is at most n² ≤ 2⁸.
        u32::from(code) * self.dots() + lit as u32
    }

    /// Returns the codes of the cell of `level`, row by row. Levels above the last are treated as the last.
    pub fn cell(&self, level: u32) -> Vec<u8> {
        let level = level.min(self.level_count() - 1);
        let (code, lit) = (level / self.dots(), level % self.dots());
        // The last level has the code 2^m − 1 ≤ 255 and no dot above it.
        self.ranks.iter().map(|&rank| (code + u32::from(u32::from(rank) < lit)) as u8).collect()
    }

    /// Returns `image` with a cell in place of every pixel, n times as wide and n times as high, in 8 bits: code c
    /// becomes c·255/(2^m − 1), rounded; this is exact for 1, 2, 4 and 8 bits. Check the size against [`MAX_PX`] before
    /// drawing, because a cell can have 16 × 16 dots.
    pub fn enlarged(&self, image: &LinearImage) -> CodeImage {
        let size = self.screen.matrix.size();
        let (width, height) = (image.width * size, image.height * size);
        let max = max_code(self.screen.bits);
        // The result is at most 255 because a code is at most `max`.
        let scaled = |code: u8| ((u16::from(code) * 255 + max / 2) / max) as u8;
        let cells: Vec<Vec<u8>> =
            (0..self.level_count()).map(|level| self.cell(level).into_iter().map(scaled).collect()).collect();
        let mut codes = vec![0; 3 * width as usize * height as usize];
        let (n, row_len) = (size as usize, 3 * width as usize);
        let pixel_rows = image.data.chunks_exact(3 * image.width.max(1) as usize);
        for (band, pixels) in codes.chunks_exact_mut((row_len * n).max(1)).zip(pixel_rows) {
            for (sample, &linear) in pixels.iter().enumerate() {
                let (x, channel) = (sample / 3, sample % 3);
                let cell = &cells[self.level(channel, linear) as usize];
                for (i, &code) in cell.iter().enumerate() {
                    band[i / n * row_len + (x * n + i % n) * 3 + channel] = code;
                }
            }
        }
        CodeImage { width, height, samples: Samples::Eight(codes) }
    }

    /// Dots per cell, n².
    fn dots(&self) -> u32 {
        self.screen.matrix.size().pow(2)
    }
}

/// The code of full light, 2^m − 1.
fn max_code(bits: u32) -> u16 {
    (1 << bits) - 1
}
