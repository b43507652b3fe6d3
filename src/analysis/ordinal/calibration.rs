//! A model with tests and intervals that hold for few participants: the parametric bootstrap where the χ² distribution is
//! not accurate, and profile intervals.

use rayon::prelude::*;
use serde::Serialize;

use super::{
    checks::{self, Checks},
    design::{coefficients, is_level},
    estimates::{self, Prediction, predictions},
    fitting::{Fitted, fit_counts},
    interactions::{Interaction, interactions},
    likelihood_ratios::{LEAST_PER_PARAMETER, MAX_NOMINAL, TermTest, Withheld, nominal_tests, quantile, without_terms},
    margins::{self, Comparison, Margin},
    model::{Contrast, Model, ModelError, ModelSpec, Random, RandomEffect},
    order::{Order, order},
    profile::{self, Quantity, chi_squared_limit},
    resampling::{Resampling, simulate},
    terms::{Term, Variable},
};
use crate::{
    analysis::{
        counts::{Counts, Trial},
        frame::{Frame, find_factor},
        levels::number_of,
    },
    statistics::{Interval, holm},
};

/// With fewer participants than this, likelihood ratios are calibrated by simulation.
pub const FEW_FOR_LIKELIHOOD_RATIOS: usize = 41;
/// A term that varies only between participants is calibrated by simulation up to this number of participants.
const FEW_BETWEEN: usize = 100;
/// Maximum number of coefficients with profile intervals; the others have Wald intervals.
const MAX_PROFILES: usize = 60;
/// Number of ratings for each parameter of the wider model from which the ratio of a test without random effects has a χ²
/// distribution.
const MANY_PER_PARAMETER: u64 = 50;
/// Number of simulated studies after which most tests are decided.
const USUAL_DRAWS: u32 = 199;
/// Maximum time of the simulated studies, minutes of one processor, unless the user allows more. Five factors with ten
/// levels each, 8 participants and 600 ratings of each take 4.
pub const MAX_MINUTES: u64 = 5;

/// A model with its tests.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelReport {
    pub model: Model,
    /// Tests of each term against the model without it.
    pub terms: Vec<TermTest>,
    /// Tests of proportional odds.
    pub proportional_odds: Vec<TermTest>,
    /// Tests of the two-way interactions that the model leaves out.
    pub interactions: Vec<Interaction>,
    /// The model's expected ratings in each condition on which it was fitted.
    pub predictions: Vec<Prediction>,
    /// The model's expected ratings at each level of each factor.
    pub margins: Vec<Margin>,
    /// Differences between levels.
    pub comparisons: Vec<Comparison>,
    /// How ratings depend on the order of the trials, if it is known.
    pub order: Option<Order>,
    /// How well the model describes the data; only for the main analysis.
    pub checks: Option<Checks>,
}

/// Fits a model and computes its tests, with probabilities from the χ² distribution, and its predictions.
///
/// # Errors
/// Returns the same errors as [`fit`](super::fit).
pub fn fit_with_tests(counts: &Counts, spec: &ModelSpec) -> Result<ModelReport, ModelError> {
    let full = fit_counts(counts, spec, true)?;
    let mut report = report_with_tests(&full)?;
    report.comparisons = margins::comparisons(&full, &report.model, &usual_limits(&full), &report.terms);
    Ok(report)
}

fn report_with_tests(full: &Fitted) -> Result<ModelReport, ModelError> {
    let model = estimates::report(full);
    let (terms, proportional_odds) = rayon::join(|| without_terms(full), || nominal_tests(full));
    Ok(ModelReport {
        terms: terms?,
        proportional_odds: proportional_odds?,
        interactions: Vec::new(),
        predictions: predictions(full, &model),
        margins: margins::margins(full, &model),
        comparisons: Vec::new(),
        order: None,
        checks: None,
        model,
    })
}

/// For each term, the limit of its likelihood ratio for one degree of freedom, which may be simulated, or the reason why
/// its test is withheld: there are then no intervals or comparisons either.
pub(super) type Limits = Vec<Result<f64, Withheld>>;

fn usual_limits(full: &Fitted) -> Limits {
    vec![Ok(chi_squared_limit(1)); full.spec.terms.iter().count()]
}

/// The name of a factor, and the indices of two of its levels.
pub type Pair = (String, [u32; 2]);

/// How to calibrate tests and intervals.
#[derive(Clone, Copy)]
pub struct Calibration<'a> {
    pub resampling: Resampling,
    /// Maximum time of the simulated studies, minutes of one processor.
    pub max_minutes: u64,
    /// The trials that are known one by one.
    pub trials: &'a [Trial],
    /// Whether to compute [`ModelReport::checks`].
    pub checks: bool,
    /// Returns the pairs of levels whose contrast is of interest, given the marginal means.
    pub contrasts: &'a (dyn Fn(&[Margin]) -> Vec<Pair> + Sync),
    /// Called after each simulated study, with the number of those done and of all.
    pub progress: &'a (dyn Fn(usize, usize) + Sync),
}

/// Fits a model and computes its tests, intervals and predictions.
///
/// # Errors
/// Returns the same errors as [`fit`](super::fit); [`ModelError::TooMuchWork`].
pub fn fit_calibrated(
    counts: &Counts,
    spec: &ModelSpec,
    calibration: &Calibration<'_>,
) -> Result<ModelReport, ModelError> {
    let (frame, _) = Frame::new(counts, spec)?;
    let (minutes, most) = (minutes(&frame, spec, calibration.resampling.draws), calibration.max_minutes);
    if minutes > most {
        return Err(ModelError::TooMuchWork { minutes, most });
    }
    let full = fit_counts(counts, spec, true)?;
    let mut report = report_with_tests(&full)?;
    let mut limits = usual_limits(&full);
    withhold(&full, &mut report);
    calibrate_tests(&full, &mut report, &mut limits, calibration);
    let terms: Vec<&Term> = full.spec.terms.iter().collect();
    for place in (0..terms.len()).rev() {
        let own = report.terms.iter().find(|test| test.term == terms[place].to_string());
        limits[place] = match own.and_then(|test| test.withheld) {
            // Its coefficients are effects in the larger term.
            Some(Withheld::Contained | Withheld::EmptyCells) => {
                let larger = (place + 1..terms.len()).find(|&other| terms[other].contains(terms[place]));
                larger.map_or(limits[place], |larger| limits[larger])
            }
            reason => reason.map_or(limits[place], Err),
        };
    }
    correct(&mut report.proportional_odds);
    report.interactions = interactions(&full, calibration.resampling);
    report.order = order(&full, calibration.trials, calibration.resampling.seed);
    if full.mixed.is_some() && full.frame.subjects.len() < FEW_FOR_LIKELIHOOD_RATIOS {
        // Wald's test rejects too often.
        report.model.coefficients.iter_mut().for_each(|coefficient| coefficient.p = None);
    }
    report.comparisons = margins::comparisons(&full, &report.model, &limits, &report.terms);
    for own in report.comparisons.iter_mut().filter(|own| own.at.is_none() && own.p.is_some()) {
        // The only difference of a term has the term's probability.
        let is_own = |test: &&TermTest| test.df == 1 && test.term == Term::factor(&own.factor).to_string();
        if let Some(p) = report.terms.iter().find(is_own).and_then(|test| test.p) {
            (own.p, own.p_holm) = (Some(p), Some(p));
        }
    }
    profile_coefficients(&full, &mut report, &limits);
    if let Some(random) = &mut report.model.random {
        profile_deviations(&full, random);
    }
    report.model.contrasts = contrasts(&full, &report, &limits, &(calibration.contrasts)(&report.margins));
    share_intervals(&mut report);
    report.checks = (calibration.checks).then(|| checks::checks(&full, calibration.resampling.seed));
    Ok(report)
}

/// Withholds tests whose distribution is not accurate even if it is simulated.
fn withhold(full: &Fitted, report: &mut ModelReport) {
    let parameters = full.frame.categories.len() - 1 + full.rank();
    for test in &mut report.proportional_odds {
        if full.frame.subjects.len() > 1 && test.lr.is_some() {
            (test.p, test.withheld) = (None, Some(Withheld::OwnThresholds));
        }
        if full.frame.total() < LEAST_PER_PARAMETER * (parameters + test.df) as u64 && test.lr.is_some() {
            (test.p, test.withheld) = (None, Some(Withheld::FewRatings));
        }
    }
    for test in &mut report.terms {
        let term = full.spec.terms.iter().find(|term| term.to_string() == test.term);
        if let Some(reason) = term.and_then(|term| full.withheld(term)) {
            (test.p, test.withheld) = (None, Some(reason));
        }
    }
}

/// Replaces the probabilities of the tests by simulated ones, and the limits of the profiles, by term, where they are
/// simulated.
fn calibrate_tests(full: &Fitted, report: &mut ModelReport, limits: &mut Limits, calibration: &Calibration<'_>) {
    let terms: Vec<&Term> = full.spec.terms.iter().collect();
    let is_uncertain = |test: &TermTest| {
        let parameters = full.frame.categories.len() - 1 + full.rank() + test.df;
        full.mixed.is_some() || full.frame.total() < MANY_PER_PARAMETER * parameters as u64
    };
    // The places of the tests to simulate, and of their terms.
    let simulated = |tests: &[TermTest]| -> Vec<(usize, usize)> {
        let is_tested = |test: &TermTest| test.lr.is_some() && test.withheld.is_none() && is_uncertain(test);
        let place = |test: &TermTest| terms.iter().position(|term| is_tested(test) && term.to_string() == test.term);
        tests.iter().enumerate().filter_map(|(index, test)| Some((index, place(test)?))).collect()
    };
    let [mut of_terms, odds] = [&report.terms, &report.proportional_odds].map(|tests| simulated(tests));
    of_terms.retain(|(_, term)| needs_simulation(&full.frame, terms[*term]));
    if of_terms.is_empty() && odds.is_empty() {
        return;
    }
    let settings = calibration.resampling;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let progress = || {
        let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        (calibration.progress)(done, settings.draws as usize);
    };
    let observed = |places: &[(usize, usize)], tests: &[TermTest]| {
        places.iter().map(|&(test, term)| (terms[term], tests[test].lr.unwrap_or(f64::NAN))).collect()
    };
    let tested = [observed(&of_terms, &report.terms), observed(&odds, &report.proportional_odds)];
    let [term_ratios, odds_ratios] = simulate(full, &tested, settings, &progress);
    // If the ratings are separated, those of the simulated studies are too, and their ratios are too small.
    let is_separated = full.infinite().next().is_some();
    for (tests, places, ratios) in
        [(&mut report.terms, &of_terms, &term_ratios), (&mut report.proportional_odds, &odds, &odds_ratios)]
    {
        for (&(test, _), ratios) in places.iter().zip(ratios) {
            let test = &mut tests[test];
            let usual = test.p;
            test.calibrate(ratios);
            if is_separated && test.p < usual && test.p.is_some() {
                (test.p, test.draws, test.p_error) = (usual, None, None);
            }
        }
    }
    for (&(test, term), ratios) in of_terms.iter().zip(&term_ratios) {
        // The distribution of a ratio with several degrees of freedom differs from χ² by about the same factor.
        if let Some(simulated) = quantile(ratios, profile::LEVEL) {
            let factor = simulated / chi_squared_limit(report.terms[test].df);
            limits[term] = limits[term].map(|limit| limit * if is_separated { factor.max(1.0) } else { factor });
        }
    }
}

/// Returns about how many minutes of one processor the simulated studies take.
fn minutes(frame: &Frame, spec: &ModelSpec, draws: u32) -> u64 {
    /// Time for one mixed model, for each of its parameters and each count of ratings, seconds. Like the next one, it
    /// is for 20 to 100 parameters, and right to a factor of about 2.
    const MIXED_S: f64 = 0.7e-6;
    /// Time for one test of proportional odds, for each condition and the square of the parameters, seconds.
    const ODDS_S: f64 = 2e-9;
    let (people, rows) = (frame.subjects.len(), frame.rows.len());
    let thresholds = (frame.categories.len() - 1) as f64;
    let of_terms: Vec<f64> = coefficients(frame, &spec.terms).into_iter().map(|own| own as f64).collect();
    let parameters = thresholds + of_terms.iter().sum::<f64>();
    let simulated = |term: &&Term| !spec.terms.is_marginal(term) && needs_simulation(frame, term);
    let mixed = if people < 2 || spec.random == Random::None { 0 } else { spec.terms.iter().filter(simulated).count() };
    let models = if mixed == 0 { 0 } else { 1 + mixed };
    let mixed_s = MIXED_S * parameters * (models * rows) as f64;
    let of_odds =
        of_terms.iter().map(|own| parameters + (thresholds - 1.0) * own).filter(|all| *all <= MAX_NOMINAL as f64);
    let of_one_s = ODDS_S * of_odds.map(|all| all * all).sum::<f64>() * frame.conditions().len() as f64;
    let odds_s = if people > 1 { 0.0 } else { of_one_s };
    (f64::from(draws.min(USUAL_DRAWS)) * (mixed_s + odds_s) / 60.0) as u64
}

/// Returns whether the ratio of a term does not have a χ² distribution with this number of participants. A few who rated
/// several levels of a factor do not make it one that varies within participants.
fn needs_simulation(frame: &Frame, term: &Term) -> bool {
    let mut factors = term.variables.iter().filter_map(|variable| find_factor(frame.counts, variable).ok());
    let people = frame.subjects.len();
    people < FEW_FOR_LIKELIHOOD_RATIOS
        || (people < FEW_BETWEEN && factors.any(|(factor, _)| !frame.counts.is_within(factor)))
}

/// Corrects the probabilities of several tests of the same kind by Holm's method.
fn correct(tests: &mut [TermTest]) {
    let corrected = holm(&tests.iter().map(|test| test.p).collect::<Vec<_>>());
    tests.iter_mut().zip(corrected).for_each(|(test, p)| test.p_holm = p);
}

fn profile_coefficients(full: &Fitted, report: &mut ModelReport, limits: &Limits) {
    let columns = &full.x.columns;
    let profiled = columns.len() <= MAX_PROFILES;
    let coefficients = &mut report.model.coefficients;
    coefficients.par_iter_mut().enumerate().for_each(|(column, coefficient)| {
        let Ok(limit) = limits[columns[column].term] else {
            coefficient.interval = None;
            return;
        };
        let quantity = Quantity::Coefficient(column);
        coefficient.interval = (coefficient.se.filter(|_| profiled && coefficient.estimate.is_finite()))
            .and_then(|se| profile::interval(full, quantity, coefficient.estimate, se, [limit; 2]))
            .or_else(|| Interval::around(coefficient.estimate, coefficient.se, limit.sqrt()));
    });
}

fn profile_deviations(full: &Fitted, random: &mut RandomEffect) {
    if full.random.correlated {
        return;
    }
    let interval = |component: usize, sd: f64, se: Option<f64>| {
        let (all, df) = full.degrees(component);
        let se = se.unwrap_or(0.3 / full.random.components[component].unit);
        profile::interval(full, Quantity::Deviation(component), sd, se, profile::deviation_limits(all, df))
    };
    random.interval = interval(0, random.sd, random.se);
    random.slopes.par_iter_mut().enumerate().for_each(|(slope, one)| {
        one.interval = interval(1 + slope, one.sd, one.se);
    });
    if let Some(items) = &mut random.items {
        items.interval = interval(full.random.components.len() - 1, items.sd, items.se);
    }
}

/// Gives the comparisons the profile intervals that are known, and the coefficients in an interaction those of the simple
/// effects that they are, so that a difference has one interval.
fn share_intervals(report: &mut ModelReport) {
    for simple in report.comparisons.iter().filter(|own| own.at.is_some()) {
        let values = [&simple.level, &simple.other].map(|level| number_of(level));
        let range = if let [Some(high), Some(low)] = values { high - low } else { f64::NAN };
        for coefficient in &mut report.model.coefficients {
            let is_number =
                matches!(&coefficient.parts[..], [part] if part.variable == Variable::Number(simple.factor.clone()));
            let by = match simple {
                _ if is_number => range,
                _ if is_level(&coefficient.parts, &simple.factor, &simple.level) => 1.0,
                _ if is_level(&coefficient.parts, &simple.factor, &simple.other) => -1.0,
                _ => continue,
            };
            // Only the simple effect at the baseline of the other factor is the coefficient.
            if (by * coefficient.estimate - simple.estimate).abs() < 1e-9 * simple.estimate.abs().max(1.0) {
                coefficient.interval = simple.interval.map(|interval| interval.scaled(by.recip()));
            }
        }
    }
    let Model { coefficients, contrasts, .. } = &report.model;
    for own in report.comparisons.iter_mut().filter(|own| own.at.is_none() && own.interval.is_some()) {
        let is_same = |c: &&Contrast| (&c.factor, &c.level, &c.other) == (&own.factor, &own.level, &own.other);
        let is_own = |estimate: f64| (estimate - own.estimate).abs() < 1e-9;
        let of_level = |level: &str| coefficients.iter().find(|c| is_level(&c.parts, &own.factor, level));
        let known = match (contrasts.iter().find(is_same), of_level(&own.level), of_level(&own.other)) {
            (Some(contrast), ..) => contrast.interval,
            (None, Some(level), None) if is_own(level.estimate) => level.interval,
            (None, None, Some(other)) if is_own(-other.estimate) => {
                other.interval.map(|interval| interval.scaled(-1.0))
            }
            _ => None,
        };
        own.interval = known.or(own.interval);
    }
}

/// Returns the differences between two levels with their profile intervals.
fn contrasts(full: &Fitted, report: &ModelReport, limits: &Limits, wanted: &[Pair]) -> Vec<Contrast> {
    let of_pair = |(factor, levels): &Pair| {
        let own = Term::factor(factor);
        // An effect that depends on another factor has no single size.
        let is_own = |term: &Term| *term == own && !full.spec.terms.is_marginal(term);
        let term = full.spec.terms.iter().position(is_own)?;
        let (index, description) = full.frame.counts.factor(factor)?;
        let names = levels.map(|level| description.levels[level as usize].clone());
        let own = full.x.columns.iter().filter(|column| column.term == term).count();
        // If a column was dropped, a level without a coefficient is not necessarily the baseline.
        if own + 1 != full.frame.levels(index).len() {
            return None;
        }
        let find = |level: &String| full.x.columns.iter().position(|column| column.is_level(factor, level));
        let places = [find(&names[0]), find(&names[1])];
        let (estimate, se) = estimates::difference(&report.model, places);
        let interval = match places {
            // The difference from the baseline is the coefficient, or its negative.
            [Some(column), None] => report.model.coefficients[column].interval,
            [None, Some(column)] => report.model.coefficients[column].interval.map(|interval| interval.scaled(-1.0)),
            [Some(a), Some(b)] => (se.filter(|_| estimate.is_finite()).zip(limits[term].ok()))
                .and_then(|(se, limit)| profile::interval(full, Quantity::Difference(a, b), estimate, se, [limit; 2])),
            [None, None] => None,
        };
        let [level, other] = names;
        (!estimate.is_nan()).then_some(Contrast { factor: factor.clone(), level, other, estimate, interval })
    };
    wanted.par_iter().filter_map(of_pair).collect()
}
