//! Ordinal regression: cumulative-link models for counts of ratings, with or without random effects.
//!
//! | file | contents |
//! |---|---|
//! | [`terms`], `design` | the terms of a model, and the matrix columns made from them |
//! | `link`, `clm` | the likelihood without random effects, and its maximum |
//! | `random`, `clmm`, `search` | the random effects, the likelihood with them, and its maximum |
//! | `fitting` | fits the models to counts |
//! | `estimates`, `likelihood_ratios` | estimates, tests and predictions, on the scale of the data |
//! | `resampling`, `profile` | studies simulated from a fit, and profile-likelihood intervals |
//! | `interactions` | tests of the interactions that a model leaves out |
//! | `margins`, `checks` | marginal means and comparisons, and how well the model describes the data and their order |
//! | `calibration` | the whole report on a model, with tests and intervals that hold for few participants |
//! | `model` | fitted models, their notes, and the errors if there is no model |

mod arrow;
mod calibration;
mod checks;
mod clm;
mod clmm;
mod design;
mod estimates;
mod fitting;
mod interactions;
mod likelihood_ratios;
mod link;
mod margins;
mod model;
mod profile;
mod random;
mod resampling;
mod search;
pub mod terms;

pub use calibration::{Calibration, FEW_FOR_LIKELIHOOD_RATIOS, ModelReport, fit_with_tests};
pub use checks::{Checks, Order, Proportion};
pub use estimates::{Prediction, fit};
pub use interactions::{Interaction, LEAST_FOR_SIGNS};
pub use likelihood_ratios::{TermTest, Withheld};
pub use link::Link;
pub use margins::{Comparison, Margin};
pub use model::{
    Coefficient, MAX_COEFFICIENTS, Model, ModelError, ModelSpec, Note, Random, RandomEffect, RandomSlope, Slopes,
    Threshold,
};

pub use resampling::Resampling;

pub(super) use design::{Design, Span, check_size};
pub(super) use fitting::{Fitted, fit_counts};
pub(super) use likelihood_ratios::without_term;
