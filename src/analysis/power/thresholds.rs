//! Precision and power of studies of thresholds: sessions are simulated trial by trial, with the definition's own task
//! and method, and each study is analyzed as recorded answers are.
//!
//! Every participant answers by a psychometric function of their own. Its threshold is that of the population, plus a
//! normal deviation of the person, the [`Shift`]s of the levels of the condition, and for each [`Slope`] a normal
//! deviation at each level of its factor, all on the scale on which the method counts.

use std::fmt;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use rayon::prelude::*;

use super::{
    Sampling, Shift, Slope,
    scenario::{PlanError, factor_of, resolve},
};
use crate::{
    analysis::tasks::{
        population::{self, Population},
        psychometric::{Guess, Model, Point, estimate},
    },
    experiment::{
        Condition, Course, Identity, Phase, Protocol,
        task::{Adaptive, Answer, Presentation, Psychometric},
    },
    statistics::{Interval, median},
    system::checkpoint,
};

/// How participants see.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdObserver {
    /// The mean threshold of the population, as a level: there, F = ½.
    pub threshold: f64,
    /// The standard deviation of thresholds between people, on the scale of the method: in base-10 logarithms if it is
    /// logarithmic.
    pub subject_sd: f64,
    /// The slope β of the function that the method assumes, on that scale.
    pub slope: f64,
    /// The share of answers that do not depend on the stimulus, 0…0.5.
    pub lapse: f64,
    /// The share of yes answers to a stimulus without a target, 0…0.9, in tasks in which it depends on the participant.
    pub false_alarms: f64,
}

impl fmt::Display for ThresholdObserver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { threshold, subject_sd, slope, lapse, false_alarms } = self;
        write!(
            f,
            "threshold={threshold} subject_sd={subject_sd} slope={slope} lapse={lapse} false_alarms={false_alarms}"
        )
    }
}

impl ThresholdObserver {
    /// Returns an observer whose threshold lies in the middle of the levels. People differ by a twentieth of the range,
    /// and the function rises within a third of it.
    pub fn of(adaptive: &Adaptive) -> Self {
        let [low, high] = adaptive.range().map(|level| adaptive.common.scaled(level));
        let threshold = adaptive.common.level((low + high) / 2.0);
        let rounded = |value: f64| format!("{value:.1e}").parse().unwrap_or(value);
        Self {
            threshold,
            subject_sd: rounded((high - low) / 20.0),
            slope: rounded(6.0 / (high - low)),
            lapse: 0.02,
            false_alarms: 0.1,
        }
    }

    /// Returns each parameter with its name and its range; `levels` is that of the levels.
    pub fn parameters(&mut self, levels: [f64; 2]) -> [(&'static str, &mut f64, [f64; 2]); 5] {
        [
            ("threshold", &mut self.threshold, levels),
            ("subject_sd", &mut self.subject_sd, [0.0, 1e6]),
            ("slope", &mut self.slope, [1e-6, 1e6]),
            ("lapse", &mut self.lapse, [0.0, 0.5]),
            ("false_alarms", &mut self.false_alarms, [0.0, 0.9]),
        ]
    }
}

/// A quantity that a study estimates.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// The threshold of one participant in one condition.
    Person,
    /// The mean threshold over people in one condition.
    Mean,
    /// The threshold of a condition minus that of the first one.
    Difference {
        /// Position of the condition.
        condition: usize,
        /// The true difference, on the scale of the method.
        truth: f64,
    },
}

impl Quantity {
    /// Returns the true value of a difference; `None` for the thresholds themselves.
    pub fn truth(&self) -> Option<f64> {
        if let Self::Difference { truth, .. } = self { Some(*truth) } else { None }
    }

    /// Returns whether there is a difference to find.
    pub fn differs(&self) -> bool {
        self.truth().is_some_and(|truth| truth != 0.0)
    }
}

/// What studies of one size find.
#[derive(Clone, Debug, PartialEq)]
pub struct Precision {
    /// Number of participants.
    pub participants: u32,
    /// Number of trials of each condition.
    pub trials: u32,
    /// What is estimated.
    pub quantity: Quantity,
    /// Number of studies.
    pub studies: usize,
    /// Number of studies in which the analysis says that the conditions differ.
    pub found: usize,
    /// Number of estimates that are not possible or have no interval.
    pub missing: usize,
    /// The median of half the width of the 95 % interval, on the scale of the method.
    pub half_width: Option<f64>,
    /// The root mean square of estimate minus truth.
    pub error: Option<f64>,
}

impl Precision {
    /// Returns the share of studies that find a difference, with its 95 % interval (Clopper and Pearson).
    pub fn share(&self) -> (f64, Interval) {
        (self.found as f64 / self.studies as f64, Interval::of_proportion(self.found, self.studies))
    }
}

/// A study of thresholds.
#[derive(Clone, Debug)]
pub struct ThresholdPlan {
    protocol: Protocol,
    adaptive: Adaptive,
    model: Model,
    observer: ThresholdObserver,
    /// The factor, the level and the size of each shift.
    shifts: Vec<(usize, usize, f64)>,
    /// The factor and the standard deviation of each slope.
    slopes: Vec<(usize, f64)>,
}

/// An estimate of one study.
struct Estimate {
    value: f64,
    interval: Option<Interval>,
    truth: f64,
    /// Whether it is a difference that the analysis finds.
    is_found: bool,
}

impl ThresholdPlan {
    /// Plans a study.
    ///
    /// # Errors
    /// A shift or a slope names a factor or a level that is not in the definition, or the task has no method that varies a
    /// level.
    pub fn new(
        protocol: &Protocol,
        observer: ThresholdObserver,
        shifts: &[Shift],
        slopes: &[Slope],
    ) -> Result<Self, PlanError> {
        let shifts = shifts.iter().map(|shift| resolve(protocol, shift)).collect::<Result<_, _>>()?;
        let slope = |slope: &Slope| Ok((factor_of(protocol, true, &slope.factor)?, slope.sd));
        let slopes = slopes.iter().map(slope).collect::<Result<_, PlanError>>()?;
        let known = protocol.adaptive.clone().zip(Model::of(protocol));
        let (adaptive, model) = known.ok_or(PlanError::NothingVaries)?;
        Ok(Self { protocol: protocol.clone(), adaptive, model, observer, shifts, slopes })
    }

    /// Returns the quantities that are estimated: a difference for each condition but the first.
    pub fn quantities(&self) -> Vec<Quantity> {
        let conditions = self.protocol.conditions();
        let difference = |condition: usize| {
            let truth = self.shift(&conditions[condition]) - self.shift(&conditions[0]);
            Quantity::Difference { condition, truth }
        };
        [Quantity::Person, Quantity::Mean].into_iter().chain((1..conditions.len()).map(difference)).collect()
    }

    /// Returns by how much the levels of a condition move the threshold.
    fn shift(&self, condition: &Condition) -> f64 {
        let own = self.shifts.iter().filter(|(factor, level, _)| condition.levels[*factor] == *level);
        own.map(|(_, _, size)| size).sum()
    }

    /// Returns the true mean threshold of a condition.
    fn truth(&self, condition: &Condition) -> f64 {
        self.adaptive.common.scaled(self.observer.threshold) + self.shift(condition)
    }

    /// Simulates studies of each number of participants. `progress` learns of participants whose sessions are done.
    pub fn run(&self, participants: &[u32], sampling: &Sampling, progress: &(dyn Fn(u64) + Sync)) -> Vec<Precision> {
        let quantities = self.quantities();
        let of_size = |people: u32| {
            let study = |study: u32| {
                let found = self.study(people, u64::from(study), sampling.seed, &quantities);
                progress(people.into());
                found
            };
            let studies: Vec<Vec<Vec<Option<Estimate>>>> = (0..sampling.studies).into_par_iter().map(study).collect();
            let precision = |(i, quantity): (usize, &Quantity)| {
                let all = || studies.iter().flat_map(|study| &study[i]);
                let known = || all().filter_map(|one| one.as_ref());
                let intervals = || known().filter_map(|one| one.interval);
                // The threshold of one person has none.
                let expected = if *quantity == Quantity::Person { known().count() } else { intervals().count() };
                let errors: Vec<f64> = known().map(|one| (one.value - one.truth).powi(2)).collect();
                let mean = errors.iter().sum::<f64>() / errors.len() as f64;
                Precision {
                    participants: people,
                    trials: self.adaptive.common.trials,
                    quantity: quantity.clone(),
                    studies: all().count(),
                    found: known().filter(|one| one.is_found).count(),
                    missing: all().count() - expected,
                    half_width: median(intervals().map(|one| (one.high - one.low) / 2.0).collect()),
                    error: (!errors.is_empty()).then_some(mean.sqrt()),
                }
            };
            quantities.iter().enumerate().map(precision).collect::<Vec<_>>()
        };
        participants.iter().flat_map(|people| of_size(*people)).collect()
    }

    /// Simulates a study; returns the estimates of each quantity.
    fn study(&self, people: u32, study: u64, seed: u64, quantities: &[Quantity]) -> Vec<Vec<Option<Estimate>>> {
        let sessions: Vec<Answered> = (0..people).map(|person| self.session(person, study, seed)).collect();
        let conditions = self.protocol.conditions();
        let populations: Vec<Option<Population>> = (0..conditions.len())
            .map(|condition| {
                let points: Vec<Vec<Point>> =
                    sessions.iter().map(|session| session.points[condition].clone()).collect();
                population::fit(&points, &self.model).ok()
            })
            .collect();
        // Without an interval, the contributions say nothing about how people differ.
        let compared = populations.iter().enumerate().filter_map(|(condition, population)| {
            let population = population.as_ref().filter(|population| population.interval.is_some())?;
            Some((condition, population.contributions.iter().copied().enumerate().collect()))
        });
        let differences = population::differences(&compared.collect::<Vec<_>>());
        let of = |quantity: &Quantity| -> Vec<Option<Estimate>> {
            match *quantity {
                Quantity::Person => {
                    let own = sessions.iter().flat_map(|session| session.points.iter().zip(&session.thresholds));
                    own.map(|(points, truth)| {
                        let value = estimate(points, &self.model).ok()?.threshold;
                        Some(Estimate { value, interval: None, truth: *truth, is_found: false })
                    })
                    .collect()
                }
                Quantity::Mean => {
                    let all = populations.iter().zip(conditions.iter());
                    all.map(|(found, of)| {
                        let Population { function, interval, .. } = found.as_ref()?;
                        let (value, truth) = (function.threshold, self.truth(of));
                        Some(Estimate { value, interval: *interval, truth, is_found: false })
                    })
                    .collect()
                }
                Quantity::Difference { condition, truth } => {
                    let found = differences.iter().find(|difference| difference.conditions == [0, condition]);
                    vec![found.map(|found| Estimate {
                        value: -found.mean.mean,
                        interval: found.mean.interval.map(|interval| interval.scaled(-1.0)),
                        truth,
                        is_found: found.is_clear(),
                    })]
                }
            }
        };
        quantities.iter().map(of).collect()
    }

    /// Simulates the session of one participant.
    fn session(&self, person: u32, study: u64, seed: u64) -> Answered {
        checkpoint();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(study << 32 | u64::from(person));
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let common = &self.adaptive.common;
        let deviations: Vec<(usize, Vec<f64>)> = (self.slopes.iter())
            .map(|&(factor, sd)| (factor, self.protocol.factors[factor].levels.iter().map(|_| sd * normal()).collect()))
            .collect();
        let conditions = self.protocol.conditions();
        let own = self.observer.subject_sd * normal();
        let threshold = |condition: &Condition| {
            let deviation = |(factor, by_level): &(usize, Vec<f64>)| by_level[condition.levels[*factor]];
            own + self.truth(condition) + deviations.iter().map(deviation).sum::<f64>()
        };
        let thresholds: Vec<f64> = conditions.iter().map(threshold).collect();
        let mut points: Vec<Vec<Point>> = vec![Vec::new(); conditions.len()];
        // Names of people and seeds only order the trials.
        let seed = seed.wrapping_add(study.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let identity = Identity::new(&format!("S{person:05}"), "1").ok();
        let course = identity.and_then(|identity| Course::new(&self.protocol, &identity, seed).ok());
        let Some(mut course) = course else { return Answered { points, thresholds } };
        for trial in 0..course.schedule().trials.len() {
            let planned = &course.schedule().trials[trial];
            let (condition, phase) = (planned.condition, planned.phase);
            if phase != Phase::Main || course.is_over(trial) {
                continue;
            }
            let shown = course.presentation(trial);
            let is_target = shown.target != Some(0);
            let Some(level) = shown.level else { continue };
            let x = common.scaled(level);
            let seen = rng.random::<f64>()
                < if is_target { self.chance(x, thresholds[condition]) } else { self.observer.false_alarms };
            course.answer(trial, &shown, &self.answer(&shown, seen));
            if is_target || self.model.guess == Guess::Free {
                let x = if is_target { x } else { self.model.unseen() };
                Point::add(&mut points[condition], x, seen.into(), 1);
            }
        }
        Answered { points, thresholds }
    }

    /// Returns the probability that a target is seen or chosen.
    fn chance(&self, x: f64, threshold: f64) -> f64 {
        let (curve, sign) = (self.model.curve, self.adaptive.common.sign());
        let slope = sign * self.observer.slope;
        let guess = self.protocol.task.guess().unwrap_or(self.observer.false_alarms);
        // The curve's own threshold need not be where F is ½.
        let threshold = threshold - curve.inverse(0.5) / slope;
        curve.probability(x, &Psychometric { threshold, slope, guess, lapse: self.observer.lapse })
    }

    /// Returns an answer that means that the target was seen or chosen, or not.
    fn answer(&self, shown: &Presentation, seen: bool) -> Answer {
        let keys = self.protocol.response.categories.len().max(2) as u8;
        let means = |answer: &Answer| self.protocol.task.outcome(shown, answer) == seen;
        (0..keys).map(Answer::Key).find(means).unwrap_or(Answer::Key(0))
    }
}

/// The answers of one participant, by condition, and the true thresholds.
struct Answered {
    points: Vec<Vec<Point>>,
    thresholds: Vec<f64>,
}
