//! Dither: a pixel's place decides which of the two codes that enclose a value it gets, so that the mean light of many
//! pixels is the requested light.
//!
//! Every kind compares in linear light: between the codes c and c + 1, whose relative luminances L(c)
//! and L(c + 1) enclose v, p = (v − L(c)) / (L(c + 1) − L(c)) is the share of pixels that should have
//! the upper code, and the pixel at (x, y) has it iff p > t(x, y). The thresholds t are spread evenly
//! over the open interval (0, 1); the kinds of dither differ in nothing else.
//!
//! - A value that is a code's own luminance, to within one unit of f32's last place, gets that code
//!   everywhere, without noise.
//! - Red, green and blue of a pixel share its threshold: equal values give equal codes, a yellow stays
//!   yellow and a gray gray.
//! - Thresholds depend on the pixel's place and the seed only, and are the same on every machine.

use std::fmt;
use std::str::FromStr;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::names::{named, serde_as_text};

/// The choice between two codes. Written `none`, `ordered`, `ordered:MATRIX` with the name
/// of a [`DitherMatrix`], `blue-noise` or `random`; the text does not hold the seed of the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Dither {
    /// The nearest code, in encoded space: no dither.
    #[default]
    None,
    /// A small matrix, repeated. Written without a matrix it is [`DitherMatrix::Bayer8`].
    Ordered(DitherMatrix),
    /// The 64 × 64 mask of [`mask`], repeated.
    BlueNoise,
    /// Random thresholds, stratified: every tile of 4 × 4 pixels has one threshold in each sixteenth of
    /// (0, 1), and each 2 × 2 quarter of it one in each quarter of (0, 1); which pixel has which, and
    /// where in its share a threshold lies, is random. Plain white noise misses the mean of 16 × 16
    /// pixels by up to 0.14 code; this, by less than 0.1.
    Random {
        /// Seed of the pattern.
        seed: u64,
    },
}

/// Why something is not a [`Dither`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DitherError {
    /// A text that names no dither.
    #[error("dither {0:?} is not known; expected none, ordered, ordered:MATRIX, blue-noise or random")]
    Unknown(String),
    /// An ordered dither by a matrix that does not exist.
    #[error(transparent)]
    Matrix(#[from] DitherMatrixError),
}

impl Dither {
    /// The seed of `random` where none is given.
    pub const DEFAULT_SEED: u64 = 1;

    /// This dither with the seed `seed`; the same, if it is not random.
    #[must_use]
    pub const fn with_seed(self, seed: u64) -> Self {
        match self {
            Dither::Random { .. } => Dither::Random { seed },
            other => other,
        }
    }
}

impl fmt::Display for Dither {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Dither::None => f.write_str("none"),
            Dither::Ordered(matrix) if *matrix == DitherMatrix::default() => f.write_str("ordered"),
            Dither::Ordered(matrix) => write!(f, "ordered:{matrix}"),
            Dither::BlueNoise => f.write_str("blue-noise"),
            Dither::Random { .. } => f.write_str("random"),
        }
    }
}

impl FromStr for Dither {
    type Err = DitherError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        match text {
            "none" => Ok(Dither::None),
            "ordered" => Ok(Dither::Ordered(DitherMatrix::default())),
            "blue-noise" => Ok(Dither::BlueNoise),
            "random" => Ok(Dither::Random { seed: Dither::DEFAULT_SEED }),
            _ => match text.strip_prefix("ordered:") {
                Some(matrix) => Ok(Dither::Ordered(matrix.parse()?)),
                None => Err(DitherError::Unknown(text.to_owned())),
            },
        }
    }
}

serde_as_text!(Dither);

/// Shoaff §2.1.2, D⁽²⁾.
const SHOAFF_2: [[u16; 2]; 2] = [[0, 2], [3, 1]];
/// Shoaff §2.1.2, D⁽³⁾: it grows outward from its center.
const SHOAFF_3: [[u16; 3]; 3] = [[6, 8, 4], [1, 0, 3], [5, 2, 7]];

named! {
    /// An n × n tile that holds every rank 0…n²−1 once: the dot of rank k is the (k + 1)-th to be lit.
    ///
    /// Bayer's (*An optimum method for two-level rendition of continuous-tone pictures*, ICC 1973) scatter
    /// the dots as far as they can, for screens. Shoaff's, written `clustered`, are those of a growing
    /// dot, for print; D⁽²⁾ is too small to cluster, and is Bayer's 2 × 2 turned over.
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
    #[must_use]
    pub const fn size(self) -> u32 {
        match self {
            Self::Bayer2 | Self::Clustered2 => 2,
            Self::Clustered3 => 3,
            Self::Bayer4 => 4,
            Self::Bayer8 => 8,
            Self::Bayer16 => 16,
        }
    }

    /// The rank, 0…n²−1, of the dot in column `x` and row `y`; the tile repeats forever.
    ///
    /// Shoaff indexes D\[i\]\[j\] with i = x mod n, j = y mod n, so his printed rows are columns here.
    #[must_use]
    pub fn rank(self, x: u32, y: u32) -> u16 {
        let (x, y) = (x % self.size(), y % self.size());
        match self {
            Self::Clustered2 => SHOAFF_2[x as usize][y as usize],
            Self::Clustered3 => SHOAFF_3[x as usize][y as usize],
            _ => bayer_rank(self.size(), x, y),
        }
    }

    /// Every rank, row by row from the top left.
    #[must_use]
    pub fn ranks(self) -> Vec<u16> {
        let n = self.size();
        (0..n * n).map(|i| self.rank(i % n, i / n)).collect()
    }
}

/// Bayer's recursion, M₂ₙ = \[4Mₙ, 4Mₙ + 2; 4Mₙ + 3, 4Mₙ + 1\] from M₁ = \[0\], bit by bit: the lowest
/// bits of the place decide the highest of the rank. `size` is a power of 2.
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

/// The ranks of the blue-noise mask, each of 0…[`MASK_SIZE`]²−1 once, row by row from the top left: noise without
/// pattern and without slow undulation. R. Ulichney, *The void-and-cluster method for dither array generation*, Proc.
/// SPIE 1913 (1993).
///
/// `cargo run -p tools -- blue-noise` generates the file again; a test there compares the two byte for byte.
#[must_use]
pub fn mask() -> Vec<u16> {
    MASK_BYTES.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

/// The threshold of `rank` among `size`²: the middle of its share of (0, 1).
pub(super) fn from_rank(rank: u16, size: u32) -> f64 {
    (f64::from(rank) + 0.5) / f64::from(size * size)
}

/// Pixels per side of a tile of [`Dither::Random`].
const TILE: u32 = 4;
/// Pixels of a tile, and strata of (0, 1).
const STRATA: usize = (TILE * TILE) as usize;
/// Where the quarters of a tile begin, and the places of a quarter from there.
const QUARTERS: [usize; 4] = [0, 2, 8, 10];
const PLACES: [usize; 4] = [0, 1, 4, 5];
/// Random words of a tile: 16 jitters, 12 for strata to quarters, 12 for places within quarters, 8
/// not used.
const WORDS: u32 = 48;
/// First stream of the generator; the streams are one for each row of tiles. No other
/// user of the same seed may use them.
const FIRST_STREAM: u64 = u64::from_be_bytes(*b"dith\0\0\0\0");

/// The tiles of [`Dither::Random`]: ChaCha8 with the seed, stream [`FIRST_STREAM`] + row of tiles, from
/// word [`WORDS`] · column of tiles.
struct Tiles(ChaCha8Rng);

impl Tiles {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Moves to the first tile of a row.
    fn seek(&mut self, row: u32) {
        self.0.set_stream(FIRST_STREAM + u64::from(row));
        self.0.set_word_pos(0);
    }

    /// The thresholds of the tile here, row by row; then on to the one at its right.
    fn next(&mut self) -> [f64; STRATA] {
        // quarters[i][k]: what the i-th quarter of the tile has in the k-th quarter of (0, 1).
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

    /// A number strictly between 0 and 1, of one word.
    fn unit(&mut self) -> f64 {
        (f64::from(self.0.next_u32()) + 0.5) / 2f64.powi(32)
    }

    /// Fisher and Yates, of three words. 32 bits are so many more than 4 places that no pick needs
    /// repeating.
    fn shuffled(&mut self, mut four: [f64; 4]) -> [f64; 4] {
        for last in (1..4).rev() {
            let pick = (u64::from(self.0.next_u32()) * (last as u64 + 1)) >> 32;
            four.swap(last, pick as usize);
        }
        four
    }
}

/// The thresholds of an image, a row at a time: the share of the step to the next code that a value must exceed to get
/// that code.
pub struct Thresholds {
    source: Source,
    row: Vec<f64>,
}

enum Source {
    /// A square of `size` pixels per side, repeated.
    Periodic { size: usize, thresholds: Vec<f64> },
    /// Tiles, and the thresholds of the last row of tiles.
    Tiled { tiles: Box<Tiles>, at: Option<u32>, band: Vec<[f64; STRATA]> },
}

impl Thresholds {
    /// For an image of `width` pixels per row. `None` without dither.
    #[must_use]
    pub fn new(dither: &Dither, width: u32) -> Option<Self> {
        let width = width as usize;
        let periodic = |size: u32, ranks: Vec<u16>| Source::Periodic {
            size: size as usize,
            thresholds: ranks.into_iter().map(|rank| from_rank(rank, size)).collect(),
        };
        let source = match *dither {
            Dither::None => return None,
            Dither::Ordered(matrix) => periodic(matrix.size(), matrix.ranks()),
            Dither::BlueNoise => periodic(MASK_SIZE, mask()),
            Dither::Random { seed } => Source::Tiled {
                tiles: Box::new(Tiles::new(seed)),
                at: None,
                band: vec![[0.0; STRATA]; width.div_ceil(TILE as usize)],
            },
        };
        Some(Self { source, row: vec![0.0; width] })
    }

    /// Those of row `y`, from 0 at the top; each strictly between 0 and 1.
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
                    tiles.seek(y / TILE);
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

/// The relative luminance of every code of a device, ready for decisions between two of them.
#[derive(Clone, Debug)]
pub(super) struct Levels(Vec<f32>);

impl Levels {
    /// The device whose code c makes `levels[c]`, from 0 to 1, rising. They are rounded to f32, as images
    /// are, so that the last bits of a machine's `powf` do not matter.
    pub(super) fn new(levels: impl Iterator<Item = f64>) -> Self {
        Self(levels.map(|level| level as f32).collect())
    }

    /// The largest code that makes no more light than `linear`; 0 for light below 0 and NaN.
    pub(super) fn at_most(&self, linear: f32) -> u16 {
        // At most 2¹⁶ codes, the first of them dark.
        self.0.partition_point(|&level| level <= linear).saturating_sub(1) as u16
    }

    /// The code of `linear` where the threshold is `threshold`, one of the two codes that enclose it.
    /// `near` is one of these too. Light outside 0…1 gets the nearest code, NaN code 0.
    #[inline]
    pub(super) fn decide(&self, linear: f32, threshold: f64, near: u16) -> u16 {
        let near = usize::from(near);
        let lower = if linear < self.0[near] { near.saturating_sub(1) } else { near };
        let (low, Some(&high)) = (self.0[lower], self.0.get(lower + 1)) else { return lower as u16 };
        // Light a rounding away from a code's is that code's. NaN is above nothing.
        let above = linear > low.next_up() && {
            let (linear, low, high) = (f64::from(linear), f64::from(low), f64::from(high));
            linear - low > threshold * (high - low)
        };
        // `lower` is at most `near`.
        (if above || linear >= high.next_down() && linear > low { lower + 1 } else { lower }) as u16
    }
}
