//! Analysis: from counts of ratings to descriptive statistics, ordinal models, tests and agreement.
//!
//! Everything works on [`counts::Counts`], the sufficient statistic subject × condition × rating, so that its cost does
//! not grow with the number of rows. The conventions are those of R's `ordinal` where it has them:
//!
//! - P(Y ≤ j) = F(θ_j − xβ − σu): a positive coefficient, and a positive intercept of a subject, mean higher ratings.
//!   `statsmodels` has the same signs; its thresholds are the first one and the logarithms of the differences.
//! - Levels and categories come in natural order, numbers ascending with `inf` last, texts by their bytes. The first
//!   level is the baseline of treatment contrasts; coefficients are named as in R (`width0.05`, `width0.05:depth2`).
//! - Standard errors come from the observed information of the likelihood that was maximized: for a mixed model its
//!   Laplace or Gauss–Hermite approximation. The log-likelihood has no constant for the order of the ratings.
//! - A [`Note`] of a model says what the data cannot answer; a [`ModelError`] says why there is no model.
//!
//! Sources: McCullagh (1980), J. R. Stat. Soc. B 42, 109; Pratt (1981), J. Am. Stat. Assoc. 76, 103; Christensen (2022),
//! `ordinal`, R package 2022.11-16; Liu & Pierce (1994), Biometrika 81, 624; Albert & Anderson (1984), Biometrika 71, 1.

pub mod agreement;
pub mod bootstrap;
pub mod counts;
mod frame;
mod levels;
mod ordinal;
pub mod power;
pub mod rank_tests;
pub mod results;
pub mod summary;

pub use levels::{number_of, numbers_of};
pub use ordinal::{
    Coefficient, Link, MOST_NODES, Model, ModelError, ModelReport, ModelSpec, Note, Part, Prediction, Random,
    RandomEffect, SubjectMode, TermTest, Threshold, fit, fit_with_tests, scale_tests, terms,
};
pub use results::{Options, Results, analyze};
