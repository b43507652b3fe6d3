//! Dither: a value between two codes gets one or the other, depending on the pixel's position, so that the mean light
//! of many pixels is the requested light.
//!
//! All kinds of dither compare in linear light. If the relative luminances L(c) and L(c + 1) of the codes c and c + 1
//! enclose v, then p = (v − L(c)) / (L(c + 1) − L(c)) is the fraction of pixels that should have the upper code, and
//! the pixel at (x, y) gets it iff p > t(x, y). The thresholds t are spread evenly over the open interval (0, 1); the
//! kinds of dither differ only in t.
//!
//! - A value that equals a code's own luminance, to within one unit in the last place of an f32, gets that code
//!   everywhere, without noise.
//! - The red, green and blue of a pixel share its threshold. Equal values therefore give equal codes: yellow stays
//!   yellow, and gray stays gray.
//! - Thresholds depend only on the pixel's position and the seed, and are the same on every machine.
//!
//! Halftone (Shoaff §2.1.2) makes many levels of light from a device with few codes. A device with m bits shows 2^m levels
//! on its own and n²·(2^m − 1) + 1 levels with cells of n × n dots. Level j = c·n² + r is a cell whose first r dots, in the
//! order of a [`DitherMatrix`], have the code c + 1, and whose other dots have the code c. From each level to the next, the
//! code of one dot rises by one and no other dot changes: the levels are a growth sequence. Shoaff counts levels as if the
//! codes were evenly spaced in light. Here, a device has a [`Transfer`], and a value gets the level whose cell has the
//! nearest mean light.

use std::fmt;
use std::str::FromStr;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::image::{CodeImage, LinearImage, Samples};
use super::transfer::{Transfer, Transfers};
use crate::{
    system::checkpoint,
    text::names::{named, serde_as_text, with_number},
};

/// How to choose between two codes. Written `none`, `ordered`, `ordered:MATRIX` with the name of a [`DitherMatrix`],
/// `blue-noise` or `random`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Dither {
    /// The nearest code, in encoded space: no dither.
    #[default]
    None,
    /// A small matrix, repeated. If the text names no matrix, it is [`DitherMatrix::Bayer8`].
    Ordered(DitherMatrix),
    /// The 64 × 64 mask of [`mask`], repeated.
    BlueNoise,
    /// Stratified random thresholds. Every tile of 4 × 4 pixels has one threshold in each sixteenth of (0, 1), and each
    /// 2 × 2 quarter of a tile has one in each quarter of (0, 1). Which pixel gets which stratum, and where the
    /// threshold lies within it, is random. The mean of 16 × 16 pixels is off by up to 0.14 code with plain white
    /// noise, but by less than 0.1 code here.
    Random,
}

impl fmt::Display for Dither {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Dither::None => f.write_str("none"),
            Dither::Ordered(matrix) if *matrix == DitherMatrix::default() => f.write_str("ordered"),
            Dither::Ordered(matrix) => write!(f, "ordered:{matrix}"),
            Dither::BlueNoise => f.write_str("blue-noise"),
            Dither::Random => f.write_str("random"),
        }
    }
}

impl FromStr for Dither {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        match (text, text.strip_prefix("ordered:")) {
            ("none", _) => Ok(Dither::None),
            ("ordered", _) => Ok(Dither::Ordered(DitherMatrix::default())),
            ("blue-noise", _) => Ok(Dither::BlueNoise),
            ("random", _) => Ok(Dither::Random),
            (_, Some(matrix)) => {
                matrix.parse().map(Dither::Ordered).map_err(|error: DitherMatrixError| error.to_string())
            }
            _ => Err(format!(
                "dither {text:?} is not known; expected none, ordered, ordered:MATRIX, blue-noise or random"
            )),
        }
    }
}

serde_as_text!(Dither);

/// Shoaff §2.1.2, D⁽²⁾.
const SHOAFF_2: [[u16; 2]; 2] = [[0, 2], [3, 1]];
/// Shoaff §2.1.2, D⁽³⁾: the dot grows outward from its center.
const SHOAFF_3: [[u16; 3]; 3] = [[6, 8, 4], [1, 0, 3], [5, 2, 7]];

named! {
    /// An n × n tile that contains every rank 0…n²−1 once: the dot of rank k is the (k + 1)-th to be lit.
    ///
    /// Bayer's matrices (*An optimum method for two-level rendition of continuous-tone pictures*, ICC 1973) scatter the
    /// dots as far apart as possible, for screens. Shoaff's matrices, named `clustered`, grow a single dot, for print.
    /// D⁽²⁾ is too small to cluster; it is Bayer's 2 × 2 matrix transposed.
    #[derive(Default)]
    DitherMatrix, DitherMatrixError {
        /// Bayer 2 × 2: 5 levels between two codes.
        Bayer2 = "bayer2",
        /// Bayer 4 × 4: 17 levels.
        Bayer4 = "bayer4",
        /// Bayer 8 × 8: 65 levels.
        #[default]
        Bayer8 = "bayer8",
        /// Bayer 16 × 16: 257 levels.
        Bayer16 = "bayer16",
        /// Shoaff's D⁽²⁾: 5 levels.
        Clustered2 = "clustered2",
        /// Shoaff's D⁽³⁾: 10 levels.
        Clustered3 = "clustered3",
    }
}

impl DitherMatrix {
    /// Dots per side, n.
    pub const fn size(self) -> u32 {
        match self {
            Self::Bayer2 | Self::Clustered2 => 2,
            Self::Clustered3 => 3,
            Self::Bayer4 => 4,
            Self::Bayer8 => 8,
            Self::Bayer16 => 16,
        }
    }

    /// Returns the rank, 0…n²−1, of the dot in column `x` and row `y`; the tile repeats indefinitely.
    ///
    /// Shoaff indexes D\[i\]\[j\] with i = x mod n and j = y mod n, so the rows as printed are columns here.
    pub fn rank(self, x: u32, y: u32) -> u16 {
        let (x, y) = (x % self.size(), y % self.size());
        match self {
            Self::Clustered2 => SHOAFF_2[x as usize][y as usize],
            Self::Clustered3 => SHOAFF_3[x as usize][y as usize],
            _ => bayer_rank(self.size(), x, y),
        }
    }

    /// Returns every rank, row by row from the top left.
    pub fn ranks(self) -> Vec<u16> {
        let n = self.size();
        (0..n * n).map(|i| self.rank(i % n, i / n)).collect()
    }
}

/// Bayer's recursion, M₂ₙ = \[4Mₙ, 4Mₙ + 2; 4Mₙ + 3, 4Mₙ + 1\] from M₁ = \[0\], bit by bit: the lowest bits of the
/// position determine the highest bits of the rank. `size` is a power of 2.
fn bayer_rank(size: u32, x: u32, y: u32) -> u16 {
    let bits = size.trailing_zeros();
    (0..bits).fold(0, |rank, bit| {
        let (x, y) = (x >> bit & 1, y >> bit & 1);
        // \[0, 2; 3, 1\] by row y and column x; both are single bits.
        rank << 2 | ((x ^ y) << 1 | y) as u16
    })
}

/// Pixels per side of the blue-noise mask.
pub const MASK_SIZE: u32 = 64;

/// The mask's ranks, 16 bits each, lower byte first.
const MASK_BYTES: &[u8; 2 * MASK_SIZE as usize * MASK_SIZE as usize] = include_bytes!("blue_noise_64.bin");

/// Returns the ranks of the blue-noise mask, row by row from the top left. Each of 0…[`MASK_SIZE`]²−1 occurs once. Blue
/// noise has no visible pattern and no low-frequency variation. R. Ulichney, *The void-and-cluster method for dither
/// array generation*, Proc. SPIE 1913 (1993).
///
/// `cargo run -p tools -- blue-noise` regenerates the file; a test in `tools` compares the two byte for byte.
pub fn mask() -> Vec<u16> {
    MASK_BYTES.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

/// Returns the threshold of `rank` among `size`² ranks: the middle of its share of (0, 1).
pub(super) fn from_rank(rank: u16, size: u32) -> f64 {
    (f64::from(rank) + 0.5) / f64::from(size * size)
}

/// Pixels per side of a tile of [`Dither::Random`].
const TILE: u32 = 4;
/// Pixels in a tile, which is also the number of strata in (0, 1).
const STRATA: usize = (TILE * TILE) as usize;
/// The index of the first pixel of each quarter of a tile; [`PLACES`] are the offsets of a quarter's pixels from there.
const QUARTERS: [usize; 4] = [0, 2, 8, 10];
const PLACES: [usize; 4] = [0, 1, 4, 5];
/// Random words per tile: 16 for jitter, 12 to assign strata to quarters, 12 to assign places within quarters, 8
/// unused.
const WORDS: u32 = 48;
/// The first stream of the generator; each row of tiles has its own stream. No other code that uses the same seed may
/// use these streams.
const FIRST_STREAM: u64 = u64::from_be_bytes(*b"dith\0\0\0\0");

/// The tiles of [`Dither::Random`]: ChaCha8 with the given seed. A tile uses the stream [`FIRST_STREAM`] + row of
/// tiles, starting at word [`WORDS`] · column of tiles.
struct Tiles(ChaCha8Rng);

impl Tiles {
    /// Returns the thresholds of the current tile, row by row, and moves to the next tile on the right.
    fn next(&mut self) -> [f64; STRATA] {
        // quarters[i][k]: the threshold in the k-th quarter of (0, 1) that the i-th quarter of the tile gets.
        let mut quarters = [[0.0; 4]; 4];
        for k in 0..4 {
            let strata = [0, 1, 2, 3].map(|s| (f64::from(4 * k + s) + self.unit()) / STRATA as f64);
            for (quarter, stratum) in quarters.iter_mut().zip(self.shuffled(strata)) {
                quarter[k as usize] = stratum;
            }
        }
        let mut tile = [0.0; STRATA];
        for (first, quarter) in QUARTERS.into_iter().zip(quarters) {
            for (place, threshold) in PLACES.into_iter().zip(self.shuffled(quarter)) {
                tile[first + place] = threshold;
            }
        }
        for _ in 40..WORDS {
            self.0.next_u32();
        }
        tile
    }

    /// Returns a number strictly between 0 and 1, made from one word.
    fn unit(&mut self) -> f64 {
        (f64::from(self.0.next_u32()) + 0.5) / 2f64.powi(32)
    }

    /// The Fisher–Yates shuffle, using three words. With 32 bits for at most 4 places, the bias is too small to need
    /// rejection.
    fn shuffled(&mut self, mut four: [f64; 4]) -> [f64; 4] {
        for last in (1..4).rev() {
            let pick = (u64::from(self.0.next_u32()) * (last as u64 + 1)) >> 32;
            four.swap(last, pick as usize);
        }
        four
    }
}

/// The thresholds of an image, one row at a time. A threshold is the fraction of the step to the next code that a value
/// must exceed to get that code.
pub struct Thresholds {
    source: Source,
    row: Vec<f64>,
}

enum Source {
    /// A square of `size` pixels per side, repeated.
    Periodic { size: usize, thresholds: Vec<f64> },
    /// Tiles, the row of tiles computed last, and its thresholds.
    Tiled { tiles: Box<Tiles>, at: Option<u32>, band: Vec<[f64; STRATA]> },
}

impl Thresholds {
    /// Makes the thresholds for an image of `width` pixels per row; `seed` is that of random ones. Returns `None` if there is
    /// no dither.
    pub fn new(dither: Dither, seed: u64, width: u32) -> Option<Self> {
        let width = width as usize;
        let periodic = |size: u32, ranks: Vec<u16>| Source::Periodic {
            size: size as usize,
            thresholds: ranks.into_iter().map(|rank| from_rank(rank, size)).collect(),
        };
        let source = match dither {
            Dither::None => return None,
            Dither::Ordered(matrix) => periodic(matrix.size(), matrix.ranks()),
            Dither::BlueNoise => periodic(MASK_SIZE, mask()),
            Dither::Random => Source::Tiled {
                tiles: Box::new(Tiles(ChaCha8Rng::seed_from_u64(seed))),
                at: None,
                band: vec![[0.0; STRATA]; width.div_ceil(TILE as usize)],
            },
        };
        Some(Self { source, row: vec![0.0; width] })
    }

    /// Returns the thresholds of row `y`, counted from 0 at the top; each is strictly between 0 and 1.
    pub fn row(&mut self, y: u32) -> &[f64] {
        match &mut self.source {
            Source::Periodic { size, thresholds } => {
                let period = &thresholds[y as usize % *size * *size..][..*size];
                for piece in self.row.chunks_mut(*size) {
                    piece.copy_from_slice(&period[..piece.len()]);
                }
            }
            Source::Tiled { tiles, at, band } => {
                if at.replace(y / TILE) != Some(y / TILE) {
                    tiles.0.set_stream(FIRST_STREAM + u64::from(y / TILE));
                    tiles.0.set_word_pos(0);
                    band.iter_mut().for_each(|tile| *tile = tiles.next());
                }
                let first = (y % TILE * TILE) as usize;
                for (piece, tile) in self.row.chunks_mut(TILE as usize).zip(band) {
                    piece.copy_from_slice(&tile[first..][..piece.len()]);
                }
            }
        }
        &self.row
    }
}

/// The relative luminance of every code of a device, prepared for choosing between two of them.
#[derive(Clone, Debug)]
pub(super) struct Levels(Vec<f32>);

impl Levels {
    /// Describes a device whose largest code is `max`. The levels are rounded to f32, as images are, so that the last bits
    /// of a machine's `powf` do not matter.
    pub(super) fn new(transfer: &Transfer, max: u16) -> Self {
        let level = |code| transfer.linear_from_encoded(f64::from(code) / f64::from(max)) as f32;
        Self((0..=max).map(level).collect())
    }

    /// Returns the largest code that produces no more light than `linear`; 0 for light below 0 and for NaN.
    pub(super) fn at_most(&self, linear: f32) -> u16 {
        // There are at most 2¹⁶ codes, and the first of them is dark.
        self.0.partition_point(|&level| level <= linear).saturating_sub(1) as u16
    }

    /// Returns the code of `linear` at the threshold `threshold`: one of the two codes that enclose it. `near` must be
    /// one of these two. Light outside 0…1 gets the nearest code, and NaN gets code 0.
    #[inline]
    pub(super) fn decide(&self, linear: f32, threshold: f64, near: u16) -> u16 {
        let near = usize::from(near);
        let lower = if linear < self.0[near] { near.saturating_sub(1) } else { near };
        let (low, Some(&high)) = (self.0[lower], self.0.get(lower + 1)) else { return lower as u16 };
        // Light within one rounding error of a code's light gets that code. Every comparison with NaN is false.
        let above = linear > low.next_up() && {
            let (linear, low, high) = (f64::from(linear), f64::from(low), f64::from(high));
            linear - low > threshold * (high - low)
        };
        // `lower` is at most `near`.
        (if above || linear >= high.next_down() && linear > low { lower + 1 } else { lower }) as u16
    }
}

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
        with_number(text, DitherMatrix::NAMES, 1..=MAX_BITS, "bits").map(|(matrix, bits)| Self { matrix, bits })
    }
}

serde_as_text!(Screen);

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
