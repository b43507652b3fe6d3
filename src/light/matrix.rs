//! Matrices of ordered dither and of halftone: small tiles that say in which order their dots are lit.

use super::names::named;

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
    /// Dots n a side.
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

    /// The rank, 0…n²−1, of the dot in column `x` and row `y`; the tile repeats for ever.
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
