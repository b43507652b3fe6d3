//! Signal detection with answers yes and no, in the equal-variance normal model (Green & Swets 1966). [`Mean::new`]
//! combines the values of several people.
//!
//! [`Mean::new`]: super::means::Mean::new

use std::f64::consts::PI;

use serde::Serialize;

use crate::experiment::task::curve::Curve;

/// Counts of answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Answers {
    /// Answers yes to a signal.
    pub hits: u32,
    /// Answers no to a signal.
    pub misses: u32,
    /// Answers yes without a signal.
    pub false_alarms: u32,
    /// Answers no without a signal.
    pub correct_rejections: u32,
}

/// How well a person tells signals from their absence, and how readily the person says yes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Detection {
    /// d' = z(H) − z(F), in standard deviations of the noise.
    pub d_prime: f64,
    /// Its standard error.
    pub d_prime_se: f64,
    /// c = −(z(H) + z(F))/2: negative if the person tends to say yes.
    pub criterion: f64,
    /// Its standard error.
    pub criterion_se: f64,
}

impl Detection {
    /// Computes d' and c. The rates have the log-linear correction of Hautus (1995), Behav. Res. Methods 27, 46, in all
    /// cases: H = (hits + ½)/(signals + 1), and F alike. The variances are those of Gourevitch & Galanter (1967),
    /// Psychometrika 32, 25, eq. 6, with these rates. `None` without trials with a signal, or without trials without one.
    #[must_use]
    pub fn new(answers: &Answers) -> Option<Self> {
        let (hit, hit_variance) = quantile(answers.hits, answers.misses)?;
        let (alarm, alarm_variance) = quantile(answers.false_alarms, answers.correct_rejections)?;
        let se = (hit_variance + alarm_variance).sqrt();
        // + 0 turns −0 into 0.
        let criterion = -(hit + alarm) / 2.0 + 0.0;
        Some(Self { d_prime: hit - alarm, d_prime_se: se, criterion, criterion_se: se / 2.0 })
    }
}

/// Returns the normal quantile of the corrected rate of yes, and its variance.
fn quantile(yes: u32, no: u32) -> Option<(f64, f64)> {
    let (yes, trials) = (f64::from(yes), f64::from(yes) + f64::from(no));
    let rate = (yes + 0.5) / (trials + 1.0);
    let z = Curve::Normal.inverse(rate);
    let density = (-z * z / 2.0).exp() / (2.0 * PI).sqrt();
    (trials > 0.0).then(|| (z, rate * (1.0 - rate) / (trials * density * density)))
}
