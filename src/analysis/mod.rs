//! Analysis: descriptive statistics, ordinal models, tests and agreement, all computed from counts of ratings; the models
//! of other tasks are in [`tasks`].
//!
//! Ratings are kept as [`counts::Counts`], the sufficient statistic participant × condition × rating, so the cost does
//! not grow with the number of rows. Where R's `ordinal` has a convention, this module follows it:
//!
//! - P(Y ≤ j) = F(θ_j − xβ − σu): a positive coefficient or a positive participant intercept means higher ratings.
//!   `statsmodels` uses the same signs; its threshold parameters are the first threshold and the logarithms of the
//!   differences.
//! - Levels and categories are in natural order: numbers in ascending order with `inf` last, other strings such that S2
//!   is before S10. The first level is the baseline of treatment contrasts. Coefficients are named as in R
//!   (`width0.05`, `width0.05:depth2`).
//! - Standard errors come from the observed information of the likelihood that was maximized; for a mixed model, this
//!   is its Laplace approximation. The log-likelihood omits the constant for the order of the ratings.
//! - A model's [`Note`]s say what the data cannot answer. A [`ModelError`] says why there is no model.
//!
//! Sources: McCullagh (1980), J. R. Stat. Soc. B 42, 109; Pratt (1981), J. Am. Stat. Assoc. 76, 103; Christensen
//! (2022), `ordinal`, R package 2022.11-16; Albert & Anderson (1984), Biometrika 71, 1.

pub mod agreement;

pub mod comparisons;
pub mod counts;
mod frame;
mod levels;
mod ordinal;
pub mod power;
pub mod rank_tests;
pub mod results;
pub mod summary;
pub mod tasks;

pub(crate) use frame::find_factor;
pub use levels::{number_of, numbers_of};
pub use ordinal::{
    Calibration, Checks, Coefficient, Comparison, FEW_FOR_LIKELIHOOD_RATIOS, Interaction, LEAST_FOR_SIGNS, Link,
    MAX_COEFFICIENTS, Margin, Model, ModelError, ModelReport, ModelSpec, Note, Order, Prediction, Proportion, Random,
    RandomEffect, RandomSlope, Resampling, Slopes, TermTest, Threshold, Withheld, fit, fit_with_tests, terms,
};
pub use results::{Options, Results, analyze, analyze_with};
