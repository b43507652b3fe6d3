//! Models of ordered ratings: their specifications and their fits.

use nalgebra::DMatrix;
use serde::{Serialize, Serializer};
use thiserror::Error;

use super::{link::Link, terms::Terms};
use crate::light::names::{expected_one_of, named};

named! {
    /// Whether subjects differ by a random intercept.
    #[derive(Default)]
    Random, RandomError {
        /// All ratings are independent: a cumulative-link model.
        #[default]
        None = "none",
        /// One normal intercept per subject: a cumulative-link mixed model.
        Subject = "subject",
    }
}

/// A model to fit.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelSpec {
    /// Location: what shifts the ratings.
    pub terms: Terms,
    /// What spreads the ratings; without a random intercept only.
    pub scale: Terms,
    pub link: Link,
    /// The random part.
    pub random: Random,
    /// Number of quadrature nodes; 1 is the Laplace approximation.
    pub quadrature: usize,
}

impl ModelSpec {
    /// These terms with the logit link, without random or scale effects.
    pub fn new(terms: Terms) -> Self {
        Self { terms, scale: Terms::default(), link: Link::Logit, random: Random::None, quadrature: 1 }
    }
}

/// A threshold between two categories.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Threshold {
    /// The categories it lies between, `0|1`.
    pub name: String,
    /// On the scale of the link; infinite where it has no finite estimate.
    #[serde(serialize_with = "finite")]
    pub estimate: f64,
    /// Standard error, from the observed information.
    pub se: Option<f64>,
}

/// A regression coefficient: how far one unit, or a level in place of the baseline, shifts the latent rating upwards.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coefficient {
    /// R's name: the factor and the level, or the number's name.
    pub name: String,
    /// The term it belongs to.
    pub term: String,
    /// On the scale of the link; infinite where it has no finite estimate.
    #[serde(serialize_with = "finite")]
    pub estimate: f64,
    /// Standard error, from the observed information.
    pub se: Option<f64>,
    /// Estimate over standard error.
    pub z: Option<f64>,
    /// Two-sided probability of z.
    pub p: Option<f64>,
}

/// The random intercept.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RandomEffect {
    /// Standard deviation between subjects, on the scale of the link.
    pub sd: f64,
    /// Its standard error; none at 0.
    pub se: Option<f64>,
    /// Every subject's intercept.
    pub subjects: Vec<SubjectMode>,
}

/// A subject's intercept given their ratings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SubjectMode {
    pub subject: String,
    /// The most probable intercept: positive gives higher ratings.
    pub mode: f64,
    /// Its conditional standard deviation.
    pub sd: f64,
}

/// A fitted model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Model {
    pub link: Link,
    /// `clm`, or `clmm` with its approximation: `clmm-laplace`, `clmm-aghq-10`.
    pub method: String,
    /// Ratings.
    pub nobs: u64,
    pub subjects: usize,
    /// Log-likelihood, or its approximation; without constants of the counts, as in R.
    pub loglik: f64,
    /// Largest absolute element of the gradient at the estimates.
    pub gradient: f64,
    pub iterations: usize,
    /// Parameters that were estimated, the standard deviation of a mixed model among them.
    pub parameters: usize,
    pub thresholds: Vec<Threshold>,
    /// Coefficients of the location.
    pub coefficients: Vec<Coefficient>,
    /// Coefficients of the log scale.
    pub scale: Vec<Coefficient>,
    /// The random intercept of a mixed model.
    pub random: Option<RandomEffect>,
    /// Names of the ordered categories that have ratings.
    pub categories: Vec<String>,
    /// Notes on the data.
    pub notes: Vec<Note>,
    /// Covariance of thresholds, coefficients, scale and sd, in this order; NaN for parameters without a finite
    /// estimate, and no row for an sd of 0.
    #[serde(skip)]
    pub covariance: DMatrix<f64>,
}

impl Model {
    /// Whether the maximum was found.
    pub fn converged(&self) -> bool {
        !self.notes.iter().any(|note| matches!(note, Note::NotConverged { .. }))
    }

    /// Akaike's information criterion.
    pub fn aic(&self) -> f64 {
        2.0 * self.parameters as f64 - 2.0 * self.loglik
    }
}

/// Numbers that are not finite are null in JSON.
fn finite<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { serializer.serialize_f64(*value) } else { serializer.serialize_none() }
}

/// A property of the data that the reader of a model must know.
#[derive(Clone, Debug, Error, PartialEq, Serialize)]
#[serde(tag = "note", rename_all = "snake_case")]
pub enum Note {
    /// Ratings without a value of a factor that the model needs.
    #[error("{ratings} ratings without a {factor} are excluded")]
    MissingValues {
        factor: String,
        /// Excluded ratings.
        ratings: u64,
    },
    /// A category that nobody used: it has no probability to estimate and is excluded.
    #[error("no rating is {category}, so this category is excluded from the scale")]
    EmptyCategory { category: String },
    /// A column that is a combination of other columns: dropped, as in R.
    #[error("{column} is determined by the preceding terms and is dropped")]
    Aliased {
        /// The coefficient's name.
        column: String,
    },
    /// A term with no remaining column.
    #[error("the term {term} adds nothing to the preceding terms and is dropped")]
    AliasedTerm { term: String },
    /// Ratings that a term predicts perfectly: its coefficient has no finite estimate.
    #[error("{coefficient} has no finite estimate: {term} separates the ratings, so the estimate tends to {}infinity",
            if *.positive { "" } else { "minus " })]
    Separation {
        /// The coefficient's name.
        coefficient: String,
        /// The term it belongs to.
        term: String,
        /// Whether the estimate is +∞.
        positive: bool,
    },
    /// A threshold that runs away together with coefficients.
    #[error("the threshold {threshold} has no finite estimate because the ratings are separated")]
    SeparatedThreshold {
        /// The threshold's name, such as `0|1`.
        threshold: String,
    },
    /// The first level of a factor has no finite effect, so another level became the baseline.
    #[error(
        "{factor} is compared with {baseline}, because all ratings at {separated} are {category}: a comparison with it would have no finite estimate"
    )]
    Rebased {
        factor: String,
        /// The level that all others are compared with now.
        baseline: String,
        /// The level whose ratings are all the same.
        separated: String,
        category: String,
    },
    /// One subject: nothing can be said about other people.
    #[error("only one participant: no random intercept, and no inference about other people")]
    OneSubject,
    /// Ratings were not repeated within subjects, or subjects do not differ: the variance between subjects is 0.
    #[error("the estimated variance between participants is 0: the mixed model is the same as the model without it")]
    NoSubjectVariance,
    /// Every subject uses a single category: the variance between subjects, or an effect within them, has no finite
    /// estimate.
    #[error(
        "the mixed model has no finite estimates: hardly any participant uses more than one category under the same conditions; the results ignore that ratings of the same participant are related, and the standard errors are too small"
    )]
    RunawayVariance,
    /// The ratings are separated in a way that leaves no mixed model to fit.
    #[error(
        "no mixed model could be fitted: the results ignore that ratings of the same participant are related, and the standard errors are too small"
    )]
    NoMixedModel,
    /// The iteration ended before the gradient was small.
    #[error("the fit did not converge: the largest gradient is {gradient:.1e}")]
    NotConverged {
        /// Largest absolute gradient element.
        gradient: f64,
    },
    /// The information matrix cannot be inverted: standard errors are missing.
    #[error("no standard errors: the likelihood is flat in some direction")]
    Flat,
    /// A random intercept together with scale terms.
    #[error("scale terms are dropped: only a model without a random intercept can have them")]
    ScaleIgnored,
}

/// Why there is no model.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ModelError {
    /// The table is empty, or no row has all the values the terms need.
    #[error("no ratings; expected at least two different ones")]
    NoRatings,
    /// Every rating is the same.
    #[error("every rating is {category}; expected at least two different ones")]
    NoVariation { category: String },
    /// A term names no factor of the table.
    #[error("--terms {name}: no such factor; {}", expected_one_of(.name, .known))]
    UnknownFactor {
        name: String,
        /// All factors.
        known: Vec<String>,
    },
    /// A factor used as a number has a level that is not a number.
    #[error("--terms num:{factor}: the level {level} is not a finite number; expected numbers, or the factor {factor}")]
    NotANumber { factor: String, level: String },
    /// The depth as a number, with `inf` among its levels.
    #[error(
        "--terms num:{name}: the depth inf is not a finite number; expected num:inv_n (1/depth, 0 for inf), or the factor {name}"
    )]
    InfiniteDepth {
        /// The factor.
        name: String,
    },
    /// Too many or no quadrature nodes.
    #[error("--quadrature {nodes}; expected 1 (Laplace) to {most}")]
    Quadrature {
        /// Requested number of nodes.
        nodes: usize,
        /// Maximum number of nodes.
        most: usize,
    },
    /// The iteration found no likelihood at all.
    #[error("the likelihood cannot be computed at the starting values")]
    NoLikelihood,
}
