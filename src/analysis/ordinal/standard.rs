//! Columns centered and scaled for the search, and the way back: numbers far from 0, such as years, would make the
//! information matrix too ill-conditioned for exact derivatives.

use nalgebra::{DMatrix, DVector};

/// What was subtracted from each column and what it was divided by; contrasts stay as they are.
#[derive(Clone, Debug)]
pub(super) struct Standard {
    centers: DVector<f64>,
    scales: DVector<f64>,
}

impl Standard {
    /// Centers and scales the columns of a matrix.
    pub fn of(x: DMatrix<f64>) -> (DMatrix<f64>, Self) {
        Self::with(x, true)
    }

    /// Only scales them: the center of a column of a scale would divide the thresholds too.
    pub fn scaled(x: DMatrix<f64>) -> (DMatrix<f64>, Self) {
        Self::with(x, false)
    }

    fn with(mut x: DMatrix<f64>, centered: bool) -> (DMatrix<f64>, Self) {
        let columns = x.ncols();
        let mut standard = Self { centers: DVector::zeros(columns), scales: DVector::from_element(columns, 1.0) };
        for (index, mut column) in x.column_iter_mut().enumerate() {
            if column.iter().all(|value| *value == 0.0 || *value == 1.0) {
                continue;
            }
            let center = if centered { column.mean() } else { 0.0 };
            column.add_scalar_mut(-center);
            let scale = column.amax();
            if scale > 0.0 {
                column /= scale;
                (standard.centers[index], standard.scales[index]) = (center, scale);
            }
        }
        (x, standard)
    }
}

/// The matrix that takes θ, β, ζ (and what follows) of standardized columns to those of the data.
pub(super) fn back(location: &Standard, scale: &Standard, thresholds: usize, size: usize) -> DMatrix<f64> {
    let mut back = DMatrix::identity(size, size);
    for column in 0..location.scales.len() {
        let index = thresholds + column;
        back[(index, index)] = 1.0 / location.scales[column];
        for threshold in 0..thresholds {
            back[(threshold, index)] = location.centers[column] / location.scales[column];
        }
    }
    let first = thresholds + location.scales.len();
    for column in 0..scale.scales.len() {
        back[(first + column, first + column)] = 1.0 / scale.scales[column];
    }
    back
}
