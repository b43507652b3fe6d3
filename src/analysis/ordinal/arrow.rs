//! The factor of the curvature of random effects: that of one participant or, if participants share effects, that of all
//! participants, whose effects are related only through the shared ones.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A factor of a positive definite matrix.
pub(super) enum Factor {
    Dense(Cholesky<f64, Dyn>),
    Arrow(Arrow),
}

/// The factor of a matrix [D C; Cᵀ E] with a block diagonal D.
pub(super) struct Arrow {
    /// The factors of the blocks of D.
    blocks: Vec<Cholesky<f64, Dyn>>,
    /// D⁻¹C.
    solved: DMatrix<f64>,
    /// The factor of the Schur complement E − CᵀD⁻¹C.
    corner: Cholesky<f64, Dyn>,
}

impl Factor {
    /// Factors a matrix that has `people` blocks of size `own` on its diagonal, with zeros between them, before the last
    /// `shared` rows and columns. `None` if it is not positive definite.
    pub fn new(matrix: DMatrix<f64>, (people, own, shared): (usize, usize, usize)) -> Option<Self> {
        if people == 1 {
            return matrix.cholesky().map(Self::Dense);
        }
        let split = people * own;
        let block = |person: usize| matrix.view((person * own, person * own), (own, own)).into_owned().cholesky();
        let blocks = (0..people).map(block).collect::<Option<Vec<_>>>()?;
        let cross = matrix.view((0, split), (split, shared));
        let mut solved = cross.into_owned();
        for (person, block) in blocks.iter().enumerate() {
            block.solve_mut(&mut solved.rows_mut(person * own, own));
        }
        let corner = matrix.view((split, split), (shared, shared)) - cross.tr_mul(&solved);
        Some(Self::Arrow(Arrow { blocks, solved, corner: corner.cholesky()? }))
    }

    /// Returns the solution of a system of equations.
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        match self {
            Self::Dense(factor) => factor.solve(right),
            Self::Arrow(Arrow { blocks, solved, corner }) => {
                let (split, shared) = solved.shape();
                let mut all = right.clone();
                let below = right.rows(split, shared) - solved.tr_mul(&right.rows(0, split));
                all.rows_mut(split, shared).copy_from(&corner.solve(&below));
                let own = split / blocks.len();
                for (person, block) in blocks.iter().enumerate() {
                    block.solve_mut(&mut all.rows_mut(person * own, own));
                }
                let correction = solved * all.rows(split, shared);
                let mut above = all.rows_mut(0, split);
                above -= correction;
                all
            }
        }
    }

    /// Returns the logarithm of the determinant.
    pub fn log_determinant(&self) -> f64 {
        let of =
            |factor: &Cholesky<f64, Dyn>| 2.0 * factor.l_dirty().diagonal().iter().map(|pivot| pivot.ln()).sum::<f64>();
        match self {
            Self::Dense(factor) => of(factor),
            Self::Arrow(Arrow { blocks, corner, .. }) => of(corner) + blocks.iter().map(of).sum::<f64>(),
        }
    }

    /// Returns the inverse.
    pub fn inverse(&self) -> DMatrix<f64> {
        match self {
            Self::Dense(factor) => factor.inverse(),
            Self::Arrow(Arrow { blocks, solved, corner }) => {
                let (split, shared) = solved.shape();
                let corner = corner.inverse();
                let cross = solved * &corner;
                let mut all = DMatrix::zeros(split + shared, split + shared);
                all.view_mut((0, 0), (split, split)).gemm(1.0, &cross, &solved.transpose(), 0.0);
                let own = split / blocks.len();
                for (person, block) in blocks.iter().enumerate() {
                    let mut view = all.view_mut((person * own, person * own), (own, own));
                    view += block.inverse();
                }
                all.view_mut((0, split), (split, shared)).copy_from(&-&cross);
                all.view_mut((split, 0), (shared, split)).tr_copy_from(&-cross);
                all.view_mut((split, split), (shared, shared)).copy_from(&corner);
                all
            }
        }
    }
}
