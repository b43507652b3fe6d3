//! The factor of the curvature of random effects. It is zero between some of them: the deviations of a participant at
//! different levels of a factor, or the effects of different participants, which are related only through those of items.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Up to this size, it is faster to leave D empty.
const SMALL: usize = 16;

/// The size of the parts of a matrix [D C; Cᵀ E], in which D consists of blocks on its diagonal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blocks {
    /// Number of blocks.
    pub number: usize,
    /// Number of rows of each.
    pub size: usize,
    /// Number of rows of E.
    pub rest: usize,
}

/// The factor of a positive definite matrix [D C; Cᵀ E].
pub(super) struct Factor {
    of_blocks: OfBlocks,
    /// D⁻¹C.
    solved: DMatrix<f64>,
    /// The factor of the Schur complement E − CᵀD⁻¹C.
    corner: Cholesky<f64, Dyn>,
}

/// The factors of the blocks of D.
enum OfBlocks {
    /// The inverse of a diagonal D.
    Diagonal(Vec<f64>),
    Square(Vec<Cholesky<f64, Dyn>>),
}

impl OfBlocks {
    fn new(matrix: &DMatrix<f64>, Blocks { number, size, .. }: Blocks) -> Option<Self> {
        if size == 1 {
            let inverse = |i: usize| Some(matrix[(i, i)].recip()).filter(|inverse| *inverse > 0.0);
            return (0..number).map(inverse).collect::<Option<_>>().map(Self::Diagonal);
        }
        let block = |i: usize| matrix.view((i * size, i * size), (size, size)).into_owned().cholesky();
        (0..number).map(block).collect::<Option<_>>().map(Self::Square)
    }

    /// Multiplies the first rows of a matrix by D⁻¹.
    fn solve(&self, matrix: &mut DMatrix<f64>) {
        match self {
            Self::Diagonal(inverse) => {
                for mut column in matrix.column_iter_mut() {
                    column.iter_mut().zip(inverse).for_each(|(value, inverse)| *value *= inverse);
                }
            }
            Self::Square(factors) => {
                for (i, factor) in factors.iter().enumerate() {
                    let size = factor.l_dirty().nrows();
                    factor.solve_mut(&mut matrix.rows_mut(i * size, size));
                }
            }
        }
    }
}

impl Factor {
    /// Factors a matrix. `None` if it is not positive definite.
    pub fn new(matrix: DMatrix<f64>, blocks: Blocks) -> Option<Self> {
        let all = matrix.nrows();
        let is_whole = blocks.number <= 1 || all < SMALL;
        let blocks = if is_whole { Blocks { number: 0, size: 1, rest: all } } else { blocks };
        let (split, rest) = (blocks.number * blocks.size, blocks.rest);
        let of_blocks = OfBlocks::new(&matrix, blocks)?;
        let cross = matrix.view((0, split), (split, rest));
        let mut solved = cross.into_owned();
        of_blocks.solve(&mut solved);
        let corner = matrix.view((split, split), (rest, rest)) - cross.tr_mul(&solved);
        Some(Self { of_blocks, solved, corner: corner.cholesky()? })
    }

    /// Returns the solution of a system of equations.
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let Self { of_blocks, solved, corner } = self;
        let (split, rest) = solved.shape();
        let below = corner.solve(&(right.rows(split, rest) - solved.tr_mul(&right.rows(0, split))));
        let mut above = DMatrix::from_column_slice(split, 1, &right.as_slice()[..split]);
        of_blocks.solve(&mut above);
        above -= solved * &below;
        DVector::from_iterator(split + rest, above.iter().chain(below.iter()).copied())
    }

    /// Returns the logarithm of the determinant.
    pub fn log_determinant(&self) -> f64 {
        let of =
            |factor: &Cholesky<f64, Dyn>| 2.0 * factor.l_dirty().diagonal().iter().map(|pivot| pivot.ln()).sum::<f64>();
        of(&self.corner)
            + match &self.of_blocks {
                OfBlocks::Diagonal(inverse) => -inverse.iter().map(|inverse| inverse.ln()).sum::<f64>(),
                OfBlocks::Square(factors) => factors.iter().map(of).sum::<f64>(),
            }
    }

    /// Returns the inverse.
    pub fn inverse(&self) -> DMatrix<f64> {
        let Self { of_blocks, solved, corner } = self;
        let (split, rest) = solved.shape();
        let corner = corner.inverse();
        let cross = solved * &corner;
        let mut all = DMatrix::zeros(split + rest, split + rest);
        all.view_mut((0, 0), (split, split)).gemm(1.0, &cross, &solved.transpose(), 0.0);
        match of_blocks {
            OfBlocks::Diagonal(inverse) => (0..split).for_each(|i| all[(i, i)] += inverse[i]),
            OfBlocks::Square(factors) => {
                for (i, factor) in factors.iter().enumerate() {
                    let size = split / factors.len();
                    let mut view = all.view_mut((i * size, i * size), (size, size));
                    view += factor.inverse();
                }
            }
        }
        all.view_mut((split, 0), (rest, split)).tr_copy_from(&-&cross);
        all.view_mut((0, split), (split, rest)).copy_from(&-cross);
        all.view_mut((split, split), (rest, rest)).copy_from(&corner);
        all
    }
}
