//! Models of ordered ratings: specifications, fitted models, notes and errors.

use nalgebra::DMatrix;
use serde::Serialize;
use thiserror::Error;

use super::{
    link::Link,
    terms::{Term, TermPart, Terms},
};
use crate::{
    statistics::Interval,
    text::names::{expected_one_of, named},
};

named! {
    /// Whether participants have random intercepts.
    #[derive(Default)]
    Random, RandomError {
        /// All ratings are independent: a cumulative-link model.
        #[default]
        None = "none",
        /// One normal intercept per participant: a cumulative-link mixed model.
        Subject = "subject",
    }
}

named! {
    /// Whether participants also differ in the effects.
    #[derive(Default)]
    Slopes, SlopesError {
        /// Participants differ only in their intercepts.
        None = "none",
        /// Each term that varies within participants has its own standard deviation, where the design supports it:
        /// R's `(1 | subject:factor)` or `(0 + x | subject)`.
        #[default]
        Independent = "independent",
        /// The intercept and the contrasts of the main effects have a common covariance matrix: R's
        /// `(1 + factor | subject)`.
        Correlated = "correlated",
    }
}

/// The specification of a model to fit.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelSpec {
    /// The terms that shift the ratings.
    pub terms: Terms,
    pub link: Link,
    /// The random part.
    pub random: Random,
    /// Random slopes; they need a random intercept.
    pub slopes: Slopes,
    /// The factor whose levels are items, such as pictures: a sample, like the participants. Each item has a random intercept,
    /// which all participants share: R's `(1 | item)`.
    pub items: Option<String>,
    /// The factors that are covariates: numbers without levels of their own in the results.
    pub covariates: Vec<String>,
    /// Maximum number of coefficients; a specification with more is refused.
    pub max_coefficients: usize,
}

/// Maximum number of coefficients of a model, unless the user allows more. The time for a fit grows with the square or
/// the cube of their number. A full crossing of 6, 5 and 4 levels has 119.
pub const MAX_COEFFICIENTS: usize = 120;

impl ModelSpec {
    /// Specifies these terms with the logit link, without random effects.
    pub fn new(terms: Terms) -> Self {
        Self {
            terms,
            link: Link::Logit,
            random: Random::None,
            slopes: Slopes::None,
            items: None,
            covariates: Vec::new(),
            max_coefficients: MAX_COEFFICIENTS,
        }
    }
}

/// A threshold between two categories.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Threshold {
    /// The two categories that it separates, such as `0|1`.
    pub name: String,
    /// Estimate on the scale of the link; infinite if there is no finite estimate.
    #[serde(serialize_with = "crate::text::as_cell")]
    pub estimate: f64,
    /// Standard error from the observed information.
    pub se: Option<f64>,
}

/// A regression coefficient: how far one unit, or a level instead of the baseline, shifts the latent rating upward.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coefficient {
    /// The name, as in R: the factor followed by the level, or the name of the number.
    pub name: String,
    /// The term it belongs to.
    pub term: Term,
    /// What it stands for: each variable of the term, with its level.
    pub parts: Vec<TermPart>,
    /// Estimate on the scale of the link; infinite if there is no finite estimate.
    #[serde(serialize_with = "crate::text::as_cell")]
    pub estimate: f64,
    /// Standard error from the observed information.
    pub se: Option<f64>,
    /// The estimate divided by its standard error.
    pub z: Option<f64>,
    /// Two-sided probability of z from the normal distribution; too small with few participants.
    pub p: Option<f64>,
    /// The 95 % profile-likelihood interval; an end is infinite if the data exclude no value there. It is Wald's if there
    /// is no profile, and always with more than 60 coefficients. That of a factor in an interaction is the interval of the
    /// simple effect at the baseline of the other factor.
    pub interval: Option<Interval>,
}

/// The random intercept, and the random slopes if there are any.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RandomEffect {
    /// Standard deviation between participants, on the scale of the link.
    pub sd: f64,
    /// Standard error of `sd`; `None` if `sd` is 0.
    pub se: Option<f64>,
    /// The random slopes, in the order of the terms.
    pub slopes: Vec<RandomSlope>,
    /// The random intercept of the items, if there are any.
    pub items: Option<RandomSlope>,
    /// Correlations of the intercept and the slopes, in this order; `None` if they are independent.
    pub correlations: Option<Vec<Vec<f64>>>,
}

/// How much participants differ in an effect, or items in their ratings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RandomSlope {
    /// The term, or the name of the contrast if the effects are correlated.
    pub name: String,
    /// The term whose effect differs between participants, or the factor whose levels are items.
    #[serde(skip)]
    pub term: Term,
    /// Standard deviation on the scale of the link: of the deviation at each level, or per unit of a number.
    pub sd: f64,
    /// Standard error of `sd`; `None` if `sd` is 0.
    pub se: Option<f64>,
}

/// A fitted model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Model {
    pub link: Link,
    /// `clm`, or `clmm-laplace` with random effects.
    pub method: &'static str,
    /// Number of ratings.
    pub nobs: u64,
    pub subjects: usize,
    /// The log-likelihood, or its approximation, without constants that depend only on the counts, as in R.
    pub loglik: f64,
    /// Largest absolute element of the gradient at the estimates.
    pub gradient: f64,
    /// Number of estimated parameters, including the standard deviation of a mixed model.
    pub parameters: usize,
    pub thresholds: Vec<Threshold>,
    pub coefficients: Vec<Coefficient>,
    /// The random intercept of a mixed model.
    pub random: Option<RandomEffect>,
    /// Names of the ordered categories that have ratings.
    pub categories: Vec<String>,
    /// Notes on the data.
    pub notes: Vec<Note>,
    /// Covariance of thresholds, coefficients and sd, in this order. It is NaN for parameters without a finite
    /// estimate, and 0 for an sd of 0.
    #[serde(skip)]
    pub covariance: DMatrix<f64>,
}

impl Model {
    /// Returns whether the maximum was found.
    pub fn converged(&self) -> bool {
        !self.notes.iter().any(|note| matches!(note, Note::NotConverged { .. }))
    }

    /// Returns the Bayesian information criterion with the number of ratings, as in R.
    pub fn bic(&self) -> f64 {
        (self.nobs as f64).ln() * self.parameters as f64 - 2.0 * self.loglik
    }

    /// Returns Akaike's information criterion.
    pub fn aic(&self) -> f64 {
        2.0 * self.parameters as f64 - 2.0 * self.loglik
    }
}

/// Something about the data that a reader of the model must know.
#[derive(Clone, Debug, Error, PartialEq, Serialize)]
#[serde(tag = "note", rename_all = "snake_case")]
pub enum Note {
    /// Some ratings have no value for a factor that the model needs.
    #[error(
        "{ratings} {} without a value of {factor} {} excluded",
        if *.ratings == 1 { "rating" } else { "ratings" },
        if *.ratings == 1 { "is" } else { "are" }
    )]
    MissingValues {
        factor: String,
        /// Number of excluded ratings; those without a value of another factor that is named before are not counted again.
        ratings: u64,
    },
    /// Nobody used this category, or any of these, so its probability cannot be estimated and it is excluded.
    #[error("no rating is {category}, so the model has no such category")]
    EmptyCategory { category: String },
    /// A column is a combination of other columns, so it is dropped, as in R.
    #[error("the coefficient {column} is determined by the preceding terms and is dropped")]
    Aliased {
        /// Name of the coefficient.
        column: String,
    },
    /// A term has no remaining columns.
    #[error("the term {term} has one level, or adds nothing to the preceding terms, and is dropped")]
    AliasedTerm {
        term: String,
        #[serde(skip)]
        of: Term,
    },
    /// A factor is not a term, because it determines another one.
    #[error(
        "the factor {factor} is not in the model, because each of its levels occurs with one level of {other}{}",
        if *.varies { "; with --items, it is a sample of stimuli" } else { "" }
    )]
    Nested {
        factor: String,
        other: String,
        /// Whether it varies within participants, so that its levels may be stimuli.
        varies: bool,
    },
    /// A term predicts some ratings perfectly, so its coefficient has no finite estimate.
    #[error("the coefficient {coefficient} has no finite estimate: {term} separates the ratings, so the estimate tends to {}infinity",
            if *.positive { "" } else { "minus " })]
    Separation {
        /// Name of the coefficient.
        coefficient: String,
        /// The term it belongs to.
        term: String,
        /// Whether the estimate is +∞.
        positive: bool,
    },
    /// A threshold diverges together with some coefficients.
    #[error("the threshold {threshold} has no finite estimate because the ratings are separated")]
    SeparatedThreshold {
        /// The threshold's name, such as `0|1`.
        threshold: String,
    },
    /// The first level of a factor has no finite effect, so another level became the baseline.
    #[error(
        "the baseline of {factor} is {baseline}, because all ratings at {separated} are {category}: a comparison with {separated} would have no finite estimate"
    )]
    Rebased {
        factor: String,
        /// The level with which all others are now compared.
        baseline: String,
        /// The level whose ratings are all the same.
        separated: String,
        category: String,
    },
    /// There is only one participant, so nothing can be said about other people.
    #[error("only one participant: no random intercept, and no inference about other people")]
    OneSubject,
    /// Every participant gave one rating.
    #[error("each participant gave one rating, so there is no random intercept: all ratings are independent")]
    OneRatingEach,
    /// There are too few ratings per participant and level for a random slope.
    #[error(
        "the design does not support differences between participants in the effect of {term}: there are fewer than two ratings per random effect"
    )]
    NoSlope {
        term: String,
        #[serde(skip)]
        of: Term,
    },
    /// The correlated random effects have a variance of 0 in some direction.
    #[error("the covariance matrix of the random effects is singular, so their correlations are not reliable")]
    SingularCovariance,
    /// The variance between participants, or an effect within participants, has no finite estimate, or the ratings are separated
    /// in such a way that no mixed model can be fitted.
    #[error(
        "no mixed model could be fitted, as where hardly any participant uses more than one category under the same conditions: the estimates ignore that ratings by the same participant are related, so the model has no standard errors, intervals or tests"
    )]
    NoMixedModel,
    /// The iteration ended before the gradient became small.
    #[error("the fit did not converge: the largest gradient is {gradient:.1e}")]
    NotConverged {
        /// Largest absolute element of the gradient.
        gradient: f64,
    },
    /// The information matrix cannot be inverted, so there are no standard errors.
    #[error("no standard errors: the likelihood is flat in some direction")]
    Flat,
}

/// The reason why there is no model.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ModelError {
    /// The table is empty, or no row has all the values that the terms need.
    #[error("no ratings; expected at least two different ones")]
    NoRatings,
    /// Every rating is the same.
    #[error("every rating is {category}; expected at least two different ones")]
    NoVariation { category: String },
    /// A term names a factor that is not in the table.
    #[error("{name}: no such factor; {}", expected_one_of(.name, .known))]
    UnknownFactor {
        name: String,
        /// Names of all factors.
        known: Vec<String>,
    },
    /// A factor used as a number has a level that is not a number.
    #[error("num:{factor}: the level {level} is not a finite number; expected numbers, or the factor {factor}")]
    NotANumber { factor: String, level: String },
    /// The depth is used as a number but has the level `inf`.
    #[error(
        "num:{name}: the depth inf is not a finite number; expected num:inv_n (1/depth, 0 for inf), or the factor {name}"
    )]
    InfiniteDepth {
        /// Name of the factor.
        name: String,
    },
    /// The items, or the random effects beside theirs, allow no crossed random effects.
    #[error("{items}: expected {expected}")]
    Items { items: String, expected: &'static str },
    /// The terms need too many coefficients.
    #[error(
        "the model has {coefficients} coefficients; expected at most {most}: use num:FACTOR for a factor with many levels"
    )]
    TooManyCoefficients {
        coefficients: usize,
        /// Maximum number of coefficients.
        most: usize,
    },
    /// The correlated random effects have too many covariances.
    #[error(
        "correlated: each participant has {effects} random effects; expected at most {most}: use num:FACTOR, fewer terms, or independent slopes"
    )]
    TooManySlopes {
        effects: usize,
        /// Maximum number of effects.
        most: usize,
    },
}
