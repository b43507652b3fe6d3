//! What some columns can say: an orthonormal basis of them.

use nalgebra::{DVector, DVectorView};

/// A column of which less than this is left is a combination of those before it: R's tolerance.
const TOLERANCE: f64 = 1e-7;

/// An orthonormal basis.
pub(crate) struct Span {
    pub basis: Vec<DVector<f64>>,
}

impl Span {
    /// That of a constant.
    pub fn with_constant(rows: usize) -> Self {
        Self { basis: vec![DVector::from_element(rows, 1.0 / (rows as f64).sqrt())] }
    }

    /// Adds a column; false if it is a combination of those before it.
    pub fn add(&mut self, column: DVectorView<f64>) -> bool {
        let column = column.clone_owned();
        // Twice, because one pass of Gram and Schmidt loses orthogonality where columns are nearly dependent.
        let once = &column - self.project(&column);
        let rest = &once - self.project(&once);
        let is_new = column.norm() > 0.0 && rest.norm() >= TOLERANCE * column.norm();
        if is_new {
            self.basis.push(rest.normalize());
        }
        is_new
    }

    /// The part of a vector within the span.
    pub fn project(&self, vector: &DVector<f64>) -> DVector<f64> {
        let mut part = DVector::zeros(vector.len());
        for direction in &self.basis {
            part.axpy(direction.dot(vector), direction, 1.0);
        }
        part
    }
}
