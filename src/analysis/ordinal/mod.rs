//! Ordinal regression: cumulative-link models of counts of ratings, with or without a random intercept.
//!
//! | file | what |
//! |---|---|
//! | [`terms`], `design` | from the terms of a model to the columns of its matrix |
//! | `link`, `clm` | the likelihood without a random intercept, and its maximum |
//! | `clmm`, `search` | the likelihood with one, and its maximum |
//! | `fitting` | from counts to the maxima |
//! | `estimates`, `likelihood_ratios` | estimates, tests and predictions, on the scale of the data |
//! | `model` | a fitted model, its notes, and why there may be none |

mod clm;
mod clmm;
mod design;
mod estimates;
mod fitting;
mod likelihood_ratios;
mod link;
mod model;
mod search;
pub mod terms;

pub use clmm::MOST_NODES;
pub use estimates::{Prediction, fit};
pub use likelihood_ratios::{ModelReport, Part, TermTest, fit_with_tests, scale_tests};
pub use link::Link;
pub use model::{Coefficient, Model, ModelError, ModelSpec, Note, Random, RandomEffect, SubjectMode, Threshold};

pub(super) use design::{Design, Span};
pub(super) use estimates::{finite_product, predictors, two_sided};
pub(super) use fitting::fit_counts;
pub(super) use likelihood_ratios::{chi_squared_tail, without_terms};
