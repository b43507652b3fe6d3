//! Predicted visibility compared with ratings: a criterion fitted to them, and how well the order agrees.

mod comparison;
mod study;

pub use comparison::{Comparison, LEAST, PredictionError, rank_correlation};
pub use study::{StudyPrediction, compare_conditions, window_deg};
