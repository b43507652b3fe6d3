//! Tests whether the ordinal models recover known effects in simulated studies with the design of `bangay2003`: bias,
//! standard errors, and the coverage of 95 % intervals. Also counts how often the likelihood-ratio test finds an effect
//! that does not exist.

use std::error::Error;

use machband::analysis::{
    Link, ModelReport, ModelSpec, Random,
    counts::{Counts, MeasuredBuilder},
    fit_with_tests,
    terms::Terms,
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use rayon::prelude::*;

type Fault = Box<dyn Error + Send + Sync>;

/// The true effects of the levels, in logits. The last factor has no effect.
const WIDTHS: [(&str, f64); 6] =
    [("0.02", 0.0), ("0.05", 0.3), ("0.1", 0.7), ("0.2", 0.9), ("0.4", 0.4), ("0.8", -0.5)];
const DEPTHS: [(&str, f64); 5] = [("1", 0.0), ("2", -1.0), ("3", -1.6), ("4", -2.0), ("inf", -2.6)];
const ORIENTATIONS: [&str; 4] = ["0", "45", "90", "135"];
const FACTORS: [&str; 3] = ["width", "depth", "orientation_deg"];
const THRESHOLDS: [f64; 3] = [-2.2, -0.7, 0.8];
/// The true standard deviation of the random intercept in studies that have one.
const SUBJECT_SD: f64 = 0.6;
const PARTICIPANTS: usize = 8;
const REPETITIONS: usize = 2;

/// One parameter, with its estimate and standard error in each study.
pub struct Parameter {
    pub name: String,
    pub truth: f64,
    pub estimates: Vec<(f64, f64)>,
}

/// The results of one model over all studies.
pub struct Recovery {
    pub coefficients: Vec<Parameter>,
    /// The standard deviation of the random intercept, if the model has one.
    pub sd: Option<Parameter>,
    /// The number of studies in which the factor without an effect is significant at 0.05.
    pub false_alarms: usize,
}

impl Parameter {
    /// The mean over all studies of a function of the estimate and its standard error.
    pub fn mean(&self, value: impl Fn(f64, f64) -> f64) -> f64 {
        self.estimates.iter().map(|(estimate, se)| value(*estimate, *se)).sum::<f64>() / self.estimates.len() as f64
    }

    /// The number of studies whose 95 % interval contains the true value.
    pub fn covered(&self) -> usize {
        let half = Link::Probit.quantile(0.975);
        self.estimates.iter().filter(|(estimate, se)| (estimate - self.truth).abs() <= half * se).count()
    }
}

/// The share of the coefficients' intervals that contain the true value, over all studies.
pub fn coverage(coefficients: &[Parameter]) -> f64 {
    coefficients.iter().map(|parameter| parameter.covered() as f64 / parameter.estimates.len() as f64).sum::<f64>()
        / coefficients.len() as f64
}

/// Simulates the studies and fits each one. Without a random intercept, the simulated participants do not differ.
pub fn recover(random: Random, studies: u32, seed: u64) -> Result<Recovery, Fault> {
    let spec = ModelSpec { random, ..ModelSpec::new(Terms::factors(&FACTORS)) };
    let subject_sd = if random == Random::Subject { SUBJECT_SD } else { 0.0 };
    let reports = (0..studies).into_par_iter().map(|study| {
        let report = fit_with_tests(&simulate(subject_sd, seed, study)?, &spec, None)?;
        if report.model.converged() { Ok(report) } else { Err(format!("study {study}: no convergence").into()) }
    });
    let reports = reports.collect::<Result<Vec<ModelReport>, Fault>>()?;
    let models = || reports.iter().map(|report| &report.model);
    let names = models().next().into_iter().flat_map(|model| &model.coefficients).map(|c| c.name.clone());
    let coefficient = |(index, name): (usize, String)| {
        let estimates = models().map(|model| &model.coefficients[index]);
        let estimates = estimates.map(|c| (c.estimate, c.se.unwrap_or(f64::NAN))).collect();
        Parameter { truth: truth(&name), name, estimates }
    };
    // An sd of 0 has no standard error: its interval covers nothing.
    let sds: Vec<_> = models().filter_map(|m| m.random.as_ref()).map(|r| (r.sd, r.se.unwrap_or_default())).collect();
    let sd = Parameter { name: "sd of the random intercept".to_owned(), truth: SUBJECT_SD, estimates: sds };
    let significant = |report: &&ModelReport| {
        report.terms.iter().any(|test| test.term.name() == FACTORS[2] && test.p.is_some_and(|p| p < 0.05))
    };
    Ok(Recovery {
        coefficients: names.enumerate().map(coefficient).collect(),
        sd: (random == Random::Subject).then_some(sd),
        false_alarms: reports.iter().filter(significant).count(),
    })
}

/// The true effect of a coefficient, by the model's name for it.
fn truth(name: &str) -> f64 {
    let is = |factor: &str, level: &str| name.strip_prefix(factor) == Some(level);
    let width = WIDTHS.iter().find(|(level, _)| is(FACTORS[0], level));
    let depth = DEPTHS.iter().find(|(level, _)| is(FACTORS[1], level));
    width.or(depth).map_or(0.0, |(_, effect)| *effect)
}

/// One study: every participant rates every condition twice.
fn simulate(subject_sd: f64, seed: u64, study: u32) -> Result<Counts, Fault> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(study.into());
    let mut deviate = |link: Link| link.quantile((f64::from(rng.next_u32()) + 0.5) / 2f64.powi(32));
    let mut builder = MeasuredBuilder::new(&FACTORS).with_categories(&["0", "1", "2", "3"]);
    for participant in 1..=PARTICIPANTS {
        let intercept = subject_sd * deviate(Link::Probit);
        for ((width, by_width), (depth, by_depth)) in WIDTHS.iter().flat_map(|w| DEPTHS.iter().map(move |d| (w, d))) {
            for orientation in ORIENTATIONS.iter().flat_map(|level| [level; REPETITIONS]) {
                let latent = intercept + by_width + by_depth + deviate(Link::Logit);
                let rating = THRESHOLDS.iter().filter(|threshold| latent > **threshold).count();
                builder.add_counts(&participant.to_string(), &[width, depth, orientation], &rating.to_string(), 1)?;
            }
        }
    }
    Ok(builder.finish().counts)
}
