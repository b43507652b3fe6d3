//! The complete analysis of a study: descriptive statistics, model, tests and agreement.

use std::sync::Arc;

use rayon::prelude::*;
use serde::Serialize;

use super::{
    Link, MAX_COEFFICIENTS, ModelError, ModelReport, ModelSpec, Note, Prediction, Random, TermTest,
    agreement::{Alpha, mean_over_subjects, ordinal_alpha, retests},
    bootstrap::{Bootstrap, Interval, Resamples},
    counts::{Measured, Quartiles, Times},
    fit_with_tests,
    rank_tests::{Friedman, Pairs, SubjectMeans, friedman, pairs},
    scale_tests,
    summary::{Group, by_cell, by_factor, by_subject},
    terms::Terms,
};

/// What to compute.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Terms of the model. `None` means the main effects of all factors with two or more levels.
    pub terms: Option<Terms>,
    pub link: Link,
    /// The random part. `None` means an intercept for each participant if there are two or more participants.
    pub random: Option<Random>,
    /// Number of quadrature nodes of a mixed model; 1 is the Laplace approximation.
    pub quadrature: usize,
    /// Whether to test terms for effects on the spread of the ratings as well.
    pub scale: bool,
    /// Maximum number of coefficients of the model.
    pub max_coefficients: usize,
    /// The bootstrap for all intervals that do not come from the model.
    pub bootstrap: Bootstrap,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            terms: None,
            link: Link::Logit,
            random: None,
            quadrature: 1,
            scale: false,
            max_coefficients: MAX_COEFFICIENTS,
            bootstrap: Bootstrap::default(),
        }
    }
}

#[derive(Clone, Debug)]
pub struct Results {
    /// The ratings.
    pub measured: Measured,
    pub options: Options,
    /// The samples of the participants, for the intervals of other statistics.
    pub resamples: Arc<Resamples>,
    /// The ratings in each cell of the design.
    pub cells: Vec<Group>,
    pub factors: Vec<FactorResults>,
    pub subjects: Vec<SubjectResults>,
    /// The specification of the model.
    pub spec: ModelSpec,
    /// The model with its tests, or the reason why there is none.
    pub model: Result<ModelReport, ModelError>,
    /// Tests of effects on the spread of the ratings; empty unless requested.
    pub scale: Vec<TermTest>,
    /// Agreement between participants; `None` if there is only one participant.
    pub alpha: Option<Alpha>,
    /// Agreement within participants: the mean of weighted κ over participants and its bootstrap interval.
    pub kappa: Option<(f64, Option<Interval>)>,
    /// Response times for each category.
    pub times: Vec<Option<Quartiles>>,
}

/// The results for one factor.
#[derive(Clone, Debug, Serialize)]
pub struct FactorResults {
    /// Name of the factor.
    pub name: String,
    /// The ratings at each level, pooled over all other factors.
    pub levels: Vec<Group>,
    /// Participants who did not rate every level and are therefore excluded from the tests.
    pub incomplete: Vec<String>,
    /// Test of whether any level differs; `None` if there is only one participant or level.
    pub friedman: Option<Friedman>,
    /// Tests of which levels differ; `None` if there is only one participant or level.
    pub pairs: Option<Pairs>,
    /// Response times for each level.
    pub times: Vec<Option<Quartiles>>,
}

#[derive(Clone, Debug, Serialize)]
pub struct SubjectResults {
    /// The participant's ratings.
    pub group: Group,
    /// Number of conditions that the participant rated at least twice.
    pub retests: u64,
    /// Quadratically weighted κ of first and second ratings; `None` if there are no repetitions or all ratings are the
    /// same.
    pub kappa: Option<f64>,
    /// The participant's response times.
    pub times: Option<Quartiles>,
}

impl Results {
    /// Returns the number of participants.
    pub fn people(&self) -> usize {
        self.measured.counts.subjects.len()
    }

    /// Returns whether the results allow inferences about other people.
    pub fn is_inferential(&self) -> bool {
        self.people() > 1
    }

    /// Returns the model's expected ratings in each condition; empty if there is no model.
    pub fn predictions(&self) -> &[Prediction] {
        self.model.as_ref().map_or(&[], |report| &report.predictions)
    }
}

/// Analyzes a study.
///
/// Descriptive statistics are always available. If there is no model, `model` gives the reason.
pub fn analyze(measured: Measured, options: &Options) -> Results {
    let counts = &measured.counts;
    let people = counts.subjects.len();
    let spec = model_spec(&measured, options);
    let resamples = Arc::new(options.bootstrap.draw(people));
    let ((mut model, scale), (cells, alpha, factors)) = rayon::join(
        || {
            let scale = if options.scale { scale_tests(counts, &spec).unwrap_or_default() } else { Vec::new() };
            (fit_with_tests(counts, &spec), scale)
        },
        || {
            let factors = (0..counts.factors.len()).into_par_iter().map(|f| factor(&measured, f, &resamples));
            (by_cell(counts, &resamples), ordinal_alpha(counts, &resamples), factors.collect())
        },
    );
    if let Ok(ModelReport { model, .. }) = &mut model
        && people == 1
        && !model.notes.contains(&Note::OneSubject)
    {
        model.notes.push(Note::OneSubject);
    }
    let subjects: Vec<SubjectResults> = (by_subject(counts).into_iter())
        .zip(retests(&measured))
        .zip(measured.times_by(people, |row| Some(row.subject as usize)))
        .map(|((group, retest), times)| SubjectResults {
            group,
            retests: retest.pairs(),
            kappa: retest.kappa(),
            times: times.quartiles(),
        })
        .collect();
    let kappas: Vec<f64> = subjects.iter().filter_map(|subject| subject.kappa).collect();
    let times = (measured.times_by(counts.categories.len(), |row| Some(row.rating.into())).iter())
        .map(Times::quartiles)
        .collect();
    Results {
        cells,
        factors,
        subjects,
        spec,
        model,
        scale,
        alpha: if people > 1 { alpha } else { None },
        kappa: mean_over_subjects(&kappas, options.bootstrap),
        times,
        options: options.clone(),
        resamples,
        measured,
    }
}

fn model_spec(measured: &Measured, options: &Options) -> ModelSpec {
    let counts = &measured.counts;
    let varied: Vec<&str> =
        counts.factors.iter().filter(|factor| factor.levels.len() > 1).map(|factor| factor.name.as_str()).collect();
    let random = if counts.subjects.len() > 1 { Random::Subject } else { Random::None };
    ModelSpec {
        link: options.link,
        random: options.random.unwrap_or(random),
        quadrature: options.quadrature,
        max_coefficients: options.max_coefficients,
        ..ModelSpec::new(options.terms.clone().unwrap_or_else(|| Terms::factors(&varied)))
    }
}

fn factor(measured: &Measured, factor: usize, resamples: &Resamples) -> FactorResults {
    let counts = &measured.counts;
    let means = SubjectMeans::new(counts, factor);
    let several = means.rows.len() > 1 && means.levels.len() > 1;
    let levels = by_factor(counts, factor, resamples);
    let level_of = |condition: u32| counts.conditions[condition as usize][factor].map(|level| level as usize);
    let times = measured.times_by(counts.factors[factor].levels.len(), |row| level_of(row.condition));
    FactorResults {
        name: counts.factors[factor].name.clone(),
        levels,
        friedman: friedman(&means),
        pairs: several.then(|| pairs(&means)),
        incomplete: means.incomplete,
        times: times.iter().map(Times::quartiles).collect(),
    }
}
