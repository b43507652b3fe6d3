//! Models of ordered ratings: what to fit, and what a fit says.

use nalgebra::DMatrix;
use serde::{Serialize, Serializer};

use super::{link::Link, notes::Note, terms::Terms};

/// Whether subjects differ by a random intercept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Random {
    /// All ratings are independent: a cumulative-link model.
    #[default]
    None,
    /// One normal intercept a subject: a cumulative-link mixed model.
    Subject,
}

/// What to fit.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelSpec {
    /// Location: what shifts the ratings.
    pub terms: Terms,
    /// What spreads the ratings; without a random intercept only.
    pub scale: Terms,
    /// The link.
    pub link: Link,
    /// The random part.
    pub random: Random,
    /// Quadrature nodes; 1 is Laplace's approximation.
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
    /// The subject.
    pub subject: String,
    /// The most probable intercept: positive gives higher ratings.
    pub mode: f64,
    /// Its conditional standard deviation.
    pub sd: f64,
}

/// A fitted model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Model {
    /// The link.
    pub link: Link,
    /// `clm`, or `clmm` with its approximation: `clmm-laplace`, `clmm-aghq-10`.
    pub method: String,
    /// Ratings.
    pub nobs: u64,
    /// Subjects.
    pub subjects: usize,
    /// Log-likelihood, or its approximation; without constants of the counts, as in R.
    pub loglik: f64,
    /// Largest absolute element of the gradient at the estimates.
    pub gradient: f64,
    /// Iterations.
    pub iterations: usize,
    /// Parameters that were estimated, the standard deviation of a mixed model among them.
    pub parameters: usize,
    /// Thresholds.
    pub thresholds: Vec<Threshold>,
    /// Coefficients of the location.
    pub coefficients: Vec<Coefficient>,
    /// Coefficients of the log scale.
    pub scale: Vec<Coefficient>,
    /// The random intercept of a mixed model.
    pub random: Option<RandomEffect>,
    /// Names of the ordered categories that have ratings.
    pub categories: Vec<String>,
    /// What was recognized in the data.
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
