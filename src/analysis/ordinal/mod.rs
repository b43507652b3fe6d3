//! Ordinal regression: cumulative-link models of counts of ratings, with or without a random intercept.
//!
//! | file | what |
//! |---|---|
//! | [`terms`], `design`, `span`, `standard` | from the terms of a model to the columns of its matrix |
//! | `link`, `clm` | the likelihood without a random intercept, and its maximum |
//! | `kernel`, [`quadrature`], `clmm`, `search` | the likelihood with one, and its maximum |
//! | `fitting` | from counts to the maxima |
//! | `estimates`, `predictions`, `likelihood_ratios` | what they mean, on the scale of the data |
//! | `model`, `notes` | what is said of them |

mod clm;
mod clmm;
mod design;
mod estimates;
mod fitting;
mod kernel;
mod likelihood_ratios;
mod link;
mod model;
mod notes;
mod predictions;
pub mod quadrature;
mod search;
mod span;
mod standard;
pub mod terms;

pub use estimates::fit;
pub use likelihood_ratios::{ModelReport, Part, TermTest, fit_with_tests, scale_tests};
pub use link::Link;
pub use model::{Coefficient, Model, ModelSpec, Random, RandomEffect, SubjectMode, Threshold};
pub use notes::{ModelError, Note};
pub use predictions::Prediction;

pub(super) use design::Design;
pub(super) use estimates::{finite_product, predictors, two_sided};
pub(super) use fitting::fit_counts;
pub(super) use likelihood_ratios::{chi_squared_tail, without_terms};
pub(super) use span::Span;
