//! Halftone: many levels of light from a device that has few codes. Shoaff §2.1.2.
//!
//! A device of m bits makes 2^m levels on its own and n²·(2^m − 1) + 1 with cells of n × n dots. Level
//! j = c·n² + r is a cell whose r first dots, in the order of a [`DitherMatrix`], have the code c + 1 and
//! whose others have c. From level to level one dot gains one code and none loses any: the levels are a
//! growth sequence.
//!
//! Shoaff counts levels as if the codes were evenly spaced in light. Here a device has a [`Transfer`],
//! and a value's level is the one whose cell's mean light is nearest, as in [`dither`](super::dither).

use std::fmt;
use std::str::FromStr;

use super::dither::{Levels, from_rank};
use super::gamma::Transfer;
use super::image::{CodeImage, LinearImage, Samples};
use super::matrix::DitherMatrix;

/// Most bits of a device that needs a halftone.
const MAX_BITS: u32 = 8;

/// Why there is no halftone.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HalftoneError {
    /// Bits that no such device has.
    #[error("a halftone of {0} bits cannot be made; expected 1 to 8")]
    Bits(u32),
    /// Too many dots.
    #[error(
        "{width} × {height} pixels of {size} × {size} dots are too many; expected at most {max} dots a side", max = u32::MAX
    )]
    TooLarge {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Dots a side of a pixel's cell.
        size: u32,
    },
}

/// A device with few codes and the cells drawn on it. Written `clustered3:1`: the matrix and the bits a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Screen {
    /// Order of the dots in a cell.
    pub matrix: DitherMatrix,
    /// Bits m of a code, 1…8.
    pub bits: u32,
}

/// A text that is no [`Screen`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is no halftone; expected bayer2, bayer4, bayer8, bayer16, clustered2 or clustered3, a colon and 1…8 bits, such as clustered3:1"
)]
pub struct ScreenError(String);

impl fmt::Display for Screen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.matrix, self.bits)
    }
}

impl FromStr for Screen {
    type Err = ScreenError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = text.split_once(':').and_then(|(matrix, bits)| {
            let bits = bits.parse().ok().filter(|bits| (1..=MAX_BITS).contains(bits))?;
            Some(Self { matrix: matrix.parse().ok()?, bits })
        });
        parsed.ok_or_else(|| ScreenError(text.to_owned()))
    }
}

/// A way from light to the codes of a device that has few.
#[derive(Clone, Debug)]
pub struct Halftone {
    matrix: DitherMatrix,
    ranks: Vec<u16>,
    /// The threshold of every rank, rising.
    thresholds: Vec<f64>,
    bits: u32,
    levels: Levels,
}

/// Codes of a device with few, a picture of dots.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HalftoneImage {
    /// Dots a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bits m of a code, 1…8.
    pub bits: u32,
    /// The codes, 0…2^m − 1: red green blue interleaved, row by row from the top left.
    pub codes: Vec<u8>,
}

impl Halftone {
    /// Halftone by `matrix` for a device of `bits` bits a channel, 1…8, whose code c is encoded as
    /// c/(2^m − 1) and turned into light by `transfer`.
    ///
    /// # Errors
    /// When `bits` is not within 1…8.
    pub fn new(matrix: DitherMatrix, bits: u32, transfer: &Transfer) -> Result<Self, HalftoneError> {
        if !(1..=MAX_BITS).contains(&bits) {
            return Err(HalftoneError::Bits(bits));
        }
        let max = max_code(bits);
        let light = |code| transfer.linear_from_encoded(f64::from(code) / f64::from(max));
        let ranks = matrix.ranks();
        let thresholds = (0..).take(ranks.len()).map(|rank| from_rank(rank, matrix.size())).collect();
        Ok(Self { matrix, ranks, thresholds, bits, levels: Levels::new((0..=max).map(light)) })
    }

    /// Dots n a side of a cell.
    #[must_use]
    pub fn size(&self) -> u32 {
        self.matrix.size()
    }

    /// The levels that a cell can show, n²·(2^m − 1) + 1. Three channels together show its cube.
    #[must_use]
    pub fn level_count(&self) -> u32 {
        self.dots() * u32::from(max_code(self.bits)) + 1
    }

    /// The level, 0…[`level_count`](Halftone::level_count) − 1, whose mean light is nearest to the relative
    /// luminance `linear`; the lower of two as near. NaN is level 0.
    #[must_use]
    pub fn level(&self, linear: f32) -> u32 {
        let code = self.levels.at_most(linear);
        let lit = self.thresholds.partition_point(|&threshold| self.levels.decide(linear, threshold, code) > code);
        // At most n² ≤ 2⁸.
        u32::from(code) * self.dots() + lit as u32
    }

    /// The codes of the cell of `level`, row by row. Levels above the last are the last.
    #[must_use]
    pub fn cell(&self, level: u32) -> Vec<u8> {
        let level = level.min(self.level_count() - 1);
        let (code, lit) = (level / self.dots(), level % self.dots());
        // The last level has code 2^m − 1 ≤ 255, and lights no dot above it.
        self.ranks.iter().map(|&rank| (code + u32::from(u32::from(rank) < lit)) as u8).collect()
    }

    /// The mean relative luminance of the cell of `level`.
    #[must_use]
    pub fn luminance(&self, level: u32) -> f64 {
        let cell = self.cell(level);
        let sum: f64 = cell.iter().map(|&code| self.levels.level(u16::from(code))).sum();
        sum / cell.len() as f64
    }

    /// `image` with a cell in the place of every pixel: n times as wide and as high.
    ///
    /// # Errors
    /// When a side would have more than `u32::MAX` dots.
    pub fn enlarged(&self, image: &LinearImage) -> Result<HalftoneImage, HalftoneError> {
        let n = self.size();
        let (Some(width), Some(height)) = (image.width.checked_mul(n), image.height.checked_mul(n)) else {
            return Err(HalftoneError::TooLarge { width: image.width, height: image.height, size: n });
        };
        let cells: Vec<Vec<u8>> = (0..self.level_count()).map(|level| self.cell(level)).collect();
        let mut codes = vec![0; 3 * width as usize * height as usize];
        let (n, row_len) = (n as usize, 3 * width as usize);
        let pixel_rows = image.data.chunks_exact(3 * image.width.max(1) as usize);
        for (band, pixels) in codes.chunks_exact_mut((row_len * n).max(1)).zip(pixel_rows) {
            for (sample, &linear) in pixels.iter().enumerate() {
                let cell = &cells[self.level(linear) as usize];
                let (x, channel) = (sample / 3, sample % 3);
                for (i, &code) in cell.iter().enumerate() {
                    band[i / n * row_len + (x * n + i % n) * 3 + channel] = code;
                }
            }
        }
        Ok(HalftoneImage { width, height, bits: self.bits, codes })
    }

    /// `image` dot for pixel: the dot at (x, y) has the upper of the two codes that enclose its value iff
    /// S(x, y) > D\[x mod n\]\[y mod n\], S being the lit dots, 0…n², that a cell of this value would
    /// have above the lower code. Meant for matrices that scatter their dots.
    #[must_use]
    pub fn same_size(&self, image: &LinearImage) -> HalftoneImage {
        let width = image.width.max(1) as usize;
        let codes = image.data.iter().enumerate().map(|(i, &linear)| {
            // An image's sides are u32.
            let (x, y) = ((i / 3 % width) as u32, (i / 3 / width) as u32);
            let threshold = from_rank(self.matrix.rank(x, y), self.size());
            // At most 255.
            self.levels.decide(linear, threshold, self.levels.at_most(linear)) as u8
        });
        HalftoneImage { width: image.width, height: image.height, bits: self.bits, codes: codes.collect() }
    }

    /// Dots n² of a cell.
    fn dots(&self) -> u32 {
        self.size() * self.size()
    }
}

impl HalftoneImage {
    /// Red, green and blue codes in column `x` and row `y`, both from 0 at the top left.
    ///
    /// # Panics
    /// When the dot is outside the image.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        assert!(
            x < self.width && y < self.height,
            "dot ({x}, {y}) is outside the {} × {} image",
            self.width,
            self.height
        );
        let i = (y as usize * self.width as usize + x as usize) * 3;
        [self.codes[i], self.codes[i + 1], self.codes[i + 2]]
    }

    /// The same encoded values in 8 bits, for a file or a screen: code c becomes c·255/(2^m − 1),
    /// rounded, exact for 1, 2, 4 and 8 bits.
    #[must_use]
    pub fn to_8_bits(&self) -> CodeImage {
        let max = max_code(self.bits);
        // At most 255, as c ≤ max.
        let scaled = |code: u8| ((u16::from(code) * 255 + max / 2) / max) as u8;
        let samples = Samples::Eight(self.codes.iter().map(|&code| scaled(code)).collect());
        CodeImage { width: self.width, height: self.height, samples }
    }
}

/// The code of full light, 2^m − 1.
fn max_code(bits: u32) -> u16 {
    (1 << bits) - 1
}
