//! Halftone: many levels of light from a device with few codes. Shoaff §2.1.2.
//!
//! A device with m bits shows 2^m levels on its own and n²·(2^m − 1) + 1 levels with cells of n × n dots. Level j =
//! c·n² + r is a cell whose first r dots, in the order of a [`DitherMatrix`], have the code c + 1, and whose other dots
//! have the code c. From each level to the next, the code of one dot rises by one and no other dot changes: the levels
//! are a growth sequence.
//!
//! Shoaff counts levels as if the codes were evenly spaced in light. Here, a device has a [`Transfer`](super::Transfer), and a value
//! gets the level whose cell has the nearest mean light, as in [`dither`](super::dither).

use std::fmt;
use std::str::FromStr;

use super::dither::{DitherMatrix, Levels, from_rank};
use super::image::{CodeImage, LinearImage, Samples};
use super::transfer::Transfers;
use crate::{system::checkpoint, text::names::with_number};

/// The maximum number of bits in a code.
const MAX_BITS: u32 = 8;

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

/// Returns `image` with a cell in place of every pixel, n times as wide and n times as high, for a device that `transfers`
/// describes and whose code c has the encoded value c/(2^m − 1). In a tie, a value gets the lower level; NaN gets level 0.
///
/// The result has 8 bits: code c becomes c·255/(2^m − 1), rounded; this is exact for 1, 2, 4 and 8 bits. Bits outside 1…8,
/// which no valid text contains, are clamped to that range. Check the size before drawing, because a cell can have 16 × 16
/// dots.
pub fn enlarged(image: &LinearImage, screen: Screen, transfers: &Transfers) -> CodeImage {
    let (size, max) = (screen.matrix.size(), (1 << screen.bits.clamp(1, MAX_BITS)) - 1);
    let levels = transfers.channels().each_ref().map(|transfer| Levels::new(transfer, max));
    let ranks = screen.matrix.ranks();
    let thresholds: Vec<f64> = (0..).take(ranks.len()).map(|rank| from_rank(rank, size)).collect();
    // The result is at most 255 because a code is at most `max`.
    let scaled: Vec<u8> = (0..=max).map(|code| ((code * 255 + max / 2) / max) as u8).collect();
    let (width, height) = (image.width * size, image.height * size);
    let mut codes = vec![0; 3 * width as usize * height as usize];
    let (n, row_len) = (size as usize, 3 * width as usize);
    let pixel_rows = image.data.chunks_exact(3 * image.width.max(1) as usize);
    for (band, pixels) in codes.chunks_exact_mut((row_len * n).max(1)).zip(pixel_rows) {
        checkpoint();
        for (sample, &linear) in pixels.iter().enumerate() {
            let (x, channel) = (sample / 3, sample % 3);
            let code = levels[channel].at_most(linear);
            let is_lit = |threshold: &f64| levels[channel].decide(linear, *threshold, code) > code;
            // The last code has no dot above it.
            let lit = thresholds.partition_point(is_lit);
            for (i, rank) in ranks.iter().enumerate() {
                let dot = usize::from(code) + usize::from(usize::from(*rank) < lit);
                band[i / n * row_len + (x * n + i % n) * 3 + channel] = scaled[dot];
            }
        }
    }
    CodeImage { width, height, samples: Samples::Eight(codes) }
}
