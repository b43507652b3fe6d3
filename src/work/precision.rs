//! Precision and power of studies of any task but a rating on categories: sessions are simulated trial by trial, with the
//! definition's own task and method, and each study is analyzed as recorded answers are.
//!
//! Every participant has a value of their own in each condition: a threshold, d′, a proportion of correct answers, a scale
//! value in JND, or a setting. It is that of the population, plus a normal deviation of the person, the [`Shift`]s of the
//! levels of the condition, and for each [`Slope`] a normal deviation at each level of its factor. Levels and settings count
//! as in the definition: in base-10 logarithms if it is logarithmic.

use std::fmt;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use rayon::prelude::*;

use crate::{
    analysis::{
        comparisons::Scaling,
        power::{PlanError, Sampling, Shift, Slope},
        tasks::population::{Difference, Mean},
    },
    experiment::{
        Course, Identity, Phase, Protocol,
        task::{Answer, Curve, Presentation, Psychometric, significant},
    },
    report::tasks::{Asked, Estimand, Levels, Measure, TaskResults, TaskStudy},
    statistics::{Interval, median},
    system::checkpoint,
};

/// Number of studies from which intervals of a scale come.
const DRAWS: usize = 200;

/// How participants answer: parameters with their values and ranges.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskObserver(Vec<(&'static str, f64, [f64; 2])>);

impl fmt::Display for TaskObserver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self.0.iter().map(|(name, value, _)| format!("{name}={value}"));
        f.write_str(&all.collect::<Vec<_>>().join(" "))
    }
}

impl TaskObserver {
    /// Returns an observer whose value lies in the middle of the scale. Where it has ends, people differ by a twentieth of
    /// the range; a psychometric function rises within a third of it, and settings vary by a tenth of it.
    fn of(asked: &Asked) -> Self {
        const SPREAD: [f64; 2] = [0.0, 1e6];
        let rounded = |value: f64| format!("{value:.1e}").parse().unwrap_or(value);
        let (lapse, false_alarms) = (("lapse", 0.02, [0.0, 0.5]), ("false_alarms", 0.1, [1e-3, 0.9]));
        let mut own = match &asked.measure {
            Measure::Thresholds(Levels { common, range, .. }) => {
                let [low, high] = range.map(|level| common.scaled(level));
                vec![
                    ("threshold", common.level(f64::midpoint(low, high)), *range),
                    ("subject_sd", rounded((high - low) / 20.0), SPREAD),
                    ("slope", rounded(6.0 / (high - low)), [1e-6, 1e6]),
                    lapse,
                ]
            }
            Measure::Proportions => {
                let guess = asked.protocol.as_ref().and_then(|protocol| protocol.task.guess()).unwrap_or_default();
                vec![("proportion", f64::midpoint(guess, 1.0), [guess, 1.0]), ("subject_sd", 0.05, SPREAD)]
            }
            Measure::Sensitivity => vec![("d_prime", 1.5, [0.0, 10.0]), ("subject_sd", 0.5, SPREAD)],
            Measure::Settings(dial) => {
                let Estimand { name, ends, .. } = asked.estimand();
                let [low, high] = ends.unwrap_or_default();
                let [subject_sd, sd] = [20.0, 10.0].map(|parts| rounded((high - low) / parts));
                vec![(name, dial.at(0.5), dial.range), ("subject_sd", subject_sd, SPREAD), ("sd", sd, SPREAD)]
            }
            Measure::Scale => vec![("subject_sd", 0.5, SPREAD), lapse],
        };
        own.extend(asked.has_catches().then_some(false_alarms));
        Self(own)
    }

    /// Returns each parameter with its name and its range.
    pub fn parameters(&mut self) -> Vec<(&'static str, &mut f64, [f64; 2])> {
        self.0.iter_mut().map(|(name, value, range)| (*name, value, *range)).collect()
    }

    fn get(&self, name: &str) -> f64 {
        self.0.iter().find(|(known, ..)| *known == name).map_or(0.0, |(_, value, _)| *value)
    }
}

/// A quantity that a study estimates.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// The value of one participant in one condition.
    Person,
    /// The mean over people in one condition.
    Mean,
    /// The value of a condition minus that of the first one.
    Difference {
        /// Position of the condition.
        condition: usize,
        /// The true difference.
        truth: f64,
    },
}

/// What studies of one size find.
#[derive(Clone, Debug, PartialEq)]
pub struct Precision {
    /// Number of participants.
    pub participants: u32,
    /// Number of trials of each condition or pair.
    pub trials: u32,
    /// What is estimated.
    pub quantity: Quantity,
    /// Number of studies.
    pub studies: usize,
    /// Number of studies in which the analysis says that the conditions differ.
    pub found: usize,
    /// Number of estimates that are not possible or have no interval.
    pub missing: usize,
    /// The median of half the width of the 95 % interval.
    pub half_width: Option<f64>,
    /// The root mean square of estimate minus truth.
    pub error: Option<f64>,
}

impl Precision {
    /// Returns the true difference between conditions, if that is the quantity and there are intervals, which could exclude
    /// 0; one participant has none.
    pub fn tested(&self) -> Option<f64> {
        let Quantity::Difference { truth, .. } = self.quantity else { return None };
        self.half_width.map(|_| truth)
    }

    /// Returns the share of studies that find a difference, with its 95 % interval (Clopper and Pearson).
    pub fn share(&self) -> (f64, Interval) {
        (self.found as f64 / self.studies as f64, Interval::of_proportion(self.found, self.studies))
    }
}

/// Studies of a task.
#[derive(Clone, Debug)]
pub struct TaskPlan {
    /// The definition.
    pub protocol: Protocol,
    /// A study without answers.
    pub study: TaskStudy,
    /// How participants answer.
    pub observer: TaskObserver,
    /// By how much each condition differs from the mean.
    shifts: Vec<f64>,
    /// The factor and the standard deviation of each slope.
    slopes: Vec<(usize, f64)>,
}

/// An estimate of one study.
struct Estimate {
    quantity: Quantity,
    /// `None` if the study does not allow it.
    mean: Option<Mean>,
    truth: f64,
    /// Whether it is a difference that the analysis finds.
    is_found: bool,
}

impl TaskPlan {
    /// Plans studies of a definition; `set` changes parameters of the observer.
    ///
    /// # Errors
    /// A shift or a slope names a factor or a level that is not in the definition, or `set` fails.
    pub fn new<E: From<PlanError>>(
        protocol: &Protocol,
        shifts: &[Shift],
        slopes: &[Slope],
        set: impl FnOnce(&mut TaskObserver) -> Result<(), E>,
    ) -> Result<Self, E> {
        let asked = Asked::from(protocol);
        let mut observer = TaskObserver::of(&asked);
        set(&mut observer)?;
        let shift = Shift::sum(shifts, &asked.factors)?;
        let shifts = asked.conditions.iter().map(|levels| shift(levels)).collect();
        let slope = |slope: &Slope| Ok((slope.resolve(&asked.factors)?, slope.sd));
        let slopes = slopes.iter().map(slope).collect::<Result<_, PlanError>>()?;
        let study = TaskStudy { asked, ..TaskStudy::default() };
        Ok(Self { protocol: protocol.clone(), study, observer, shifts, slopes })
    }

    /// Returns the mean value of the population, without shifts; 0 for a scale.
    fn center(&self) -> f64 {
        let value = self.observer.0[0].1;
        match &self.study.asked.measure {
            Measure::Thresholds(Levels { common, .. }) => common.scaled(value),
            Measure::Settings(dial) if dial.log => value.log10(),
            Measure::Scale => 0.0,
            _ => value,
        }
    }

    /// Simulates studies of a number of participants. `progress` learns of participants whose sessions are done.
    ///
    /// # Errors
    /// A participant has no such order of the trials.
    pub fn run(
        &self,
        people: u32,
        sampling: &Sampling,
        progress: &(dyn Fn(u64) + Sync),
    ) -> anyhow::Result<Vec<Precision>> {
        let study = |study: u32| {
            let found = self.estimates(people, study, sampling.seed)?;
            progress(people.into());
            Ok(found)
        };
        let studies = (0..sampling.studies).into_par_iter().map(study);
        let studies = studies.collect::<anyhow::Result<Vec<Vec<Estimate>>>>()?;
        let quantities = (1..self.shifts.len()).map(|condition| self.difference(condition));
        let precision = |quantity: Quantity| {
            let all = || studies.iter().flatten().filter(|one| one.quantity == quantity);
            let known = || all().filter_map(|one| Some((one.mean?, one.truth)));
            let intervals = || known().filter_map(|(mean, _)| mean.interval);
            // The value of one person has none.
            let expected = if quantity == Quantity::Person { known().count() } else { intervals().count() };
            let squares: Vec<f64> = known().map(|(mean, truth)| (mean.mean - truth).powi(2)).collect();
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            Precision {
                participants: people,
                trials: self.protocol.repetitions(),
                studies: all().count(),
                found: all().filter(|one| one.is_found).count(),
                missing: all().count() - expected,
                half_width: median(intervals().map(|one| (one.high - one.low) / 2.0).collect()),
                error: (!squares.is_empty()).then_some(mean.sqrt()),
                quantity,
            }
        };
        Ok([Quantity::Person, Quantity::Mean].into_iter().chain(quantities).map(precision).collect())
    }

    fn difference(&self, condition: usize) -> Quantity {
        Quantity::Difference { condition, truth: self.shifts[condition] - self.shifts[0] }
    }

    /// Simulates a study; returns its estimates.
    fn estimates(&self, people: u32, study: u32, seed: u64) -> anyhow::Result<Vec<Estimate>> {
        let names = (0..people).map(|person| format!("S{person:05}")).collect();
        let mut answered = TaskStudy { people: names, ..self.study.clone() };
        let sessions = (0..people as usize).map(|person| self.session(&mut answered, person, study, seed));
        let values = sessions.collect::<anyhow::Result<Vec<Vec<f64>>>>()?;
        let results = TaskResults::estimated(&answered, DRAWS, seed ^ u64::from(study));
        // Only differences on a scale mean something.
        let is_scale = results.comparisons.is_some();
        let middle = |values: &[f64]| if is_scale { values.iter().sum::<f64>() / values.len() as f64 } else { 0.0 };
        let mut all = Vec::new();
        let mut add = |quantity, mean, truth, is_found| all.push(Estimate { quantity, mean, truth, is_found });
        for condition in 0..self.shifts.len() {
            for (person, own) in values.iter().enumerate() {
                let found = results.own.iter().find(|own| (own.person, own.condition) == (person, condition));
                let value = found.map(|own| Mean { mean: own.found, interval: None, people: 1 });
                add(Quantity::Person, value, own[condition] - middle(own), false);
            }
            let mean = results.means.iter().find(|(of, _)| *of == condition).map(|(_, mean)| *mean);
            add(Quantity::Mean, mean, self.center() + self.shifts[condition] - middle(&self.shifts), false);
            let found = results.differences.iter().find(|found| found.conditions == [0, condition]);
            let turned = |Difference { mean, .. }: &Difference| Mean {
                mean: -mean.mean,
                interval: mean.interval.map(|interval| interval.map(|end| -end)),
                ..*mean
            };
            let truth = self.shifts[condition] - self.shifts[0];
            add(self.difference(condition), found.map(turned), truth, found.is_some_and(Difference::is_clear));
        }
        Ok(all)
    }

    /// Simulates the session of one participant, and returns the true values.
    fn session(&self, study: &mut TaskStudy, person: usize, number: u32, seed: u64) -> anyhow::Result<Vec<f64>> {
        checkpoint();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(u64::from(number) << 32 | person as u64);
        let values = self.values(&mut rng);
        // Names of people and seeds only order the trials.
        let seed = seed.wrapping_add(u64::from(number).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let identity = Identity::new(&study.people[person], "1").map_err(anyhow::Error::msg)?;
        let mut course = Course::new(&self.protocol, &identity, seed)?;
        for trial in 0..course.schedule().trials.len() {
            let (planned, phase) = (course.schedule().trials[trial].condition, course.schedule().trials[trial].phase);
            if phase != Phase::Main || course.is_over(trial) {
                continue;
            }
            let shown = course.presentation(trial);
            let Some(places) = study.asked.places(planned, &shown) else { continue };
            let own: Vec<f64> = places.into_iter().map(|place| values[place]).collect();
            let answer = self.answer(&shown, &own, &mut rng);
            course.answer(trial, &shown, &answer);
            study.take(person, planned, &shown, &answer);
        }
        Ok(values)
    }

    /// Draws the values of a participant in each condition.
    fn values(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let asked = &self.study.asked;
        let by_level = |&(factor, sd): &(usize, f64)| -> (usize, Vec<f64>) {
            (factor, asked.factors[factor].levels.iter().map(|_| sd * normal()).collect())
        };
        let deviations: Vec<(usize, Vec<f64>)> = self.slopes.iter().map(by_level).collect();
        let sd = self.observer.get("subject_sd");
        let common = sd * normal();
        // What people have in common in all conditions, a scale does not show.
        let is_scale = matches!(asked.measure, Measure::Scale);
        let value = |(levels, shift): (&Vec<usize>, &f64)| {
            let own = if is_scale { sd * normal() } else { common };
            let more: f64 = deviations.iter().map(|(factor, by_level)| by_level[levels[*factor]]).sum();
            self.center() + own + shift + more
        };
        asked.conditions.iter().zip(&self.shifts).map(value).collect()
    }

    /// Answers a trial about conditions with these values.
    fn answer(&self, shown: &Presentation, values: &[f64], rng: &mut ChaCha8Rng) -> Answer {
        let (asked, task) = (&self.study.asked, &self.protocol.task);
        let [lapse, false_alarms] = ["lapse", "false_alarms"].map(|name| self.observer.get(name));
        let chance = match &asked.measure {
            Measure::Settings(dial) => {
                let noise: f64 = StandardNormal.sample(rng);
                let set = values[0] + self.observer.get("sd") * noise;
                let set = if dial.log { f64::powf(10.0, set) } else { set };
                return Answer::Value(significant(set.clamp(dial.range[0], dial.range[1])));
            }
            _ if shown.target == Some(0) => false_alarms,
            Measure::Thresholds(Levels { common, model, .. }) => {
                let level = shown.level.unwrap_or_default();
                let (slope, guess) = (common.sign() * self.observer.get("slope"), task.guess().unwrap_or(false_alarms));
                // The curve's own threshold need not be where F is ½.
                let threshold = values[0] - model.curve.inverse(0.5) / slope;
                model.curve.probability(common.scaled(level), &Psychometric { threshold, slope, guess, lapse })
            }
            Measure::Sensitivity => Curve::Normal.sigmoid(values[0] + Curve::Normal.inverse(false_alarms)),
            Measure::Scale => {
                let first = Curve::Normal.sigmoid(Scaling::Thurstone.jnd() * (values[0] - values[1]));
                lapse / 2.0 + (1.0 - lapse) * first
            }
            Measure::Proportions => values[0],
        };
        let seen = rng.random::<f64>() < chance.max(task.guess().unwrap_or_default());
        let keys = self.protocol.response.categories.len().max(2) as u8;
        let means = |answer: &Answer| task.outcome(shown, answer) == seen;
        (0..keys).map(Answer::Key).find(means).unwrap_or(Answer::Key(0))
    }
}
