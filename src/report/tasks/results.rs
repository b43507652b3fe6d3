//! What follows from the answers to a task.

use std::collections::BTreeMap;

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};
use rayon::prelude::*;

use super::study::{Levels, TaskAnswered, TaskStudy};
use crate::{
    analysis::{
        comparisons::{Scale, Scaling, Triads, Wins},
        detection::{Answers, Detection},
        settings::Settings,
        tasks::{
            population::{self, Mean, Population},
            psychometric::{self, Fit, GoodnessOfFit, Guess, Model, Point},
        },
    },
    experiment::task::{Common, Measures},
    statistics::Interval,
};

/// The results of a task.
#[derive(Clone, Debug, Default)]
pub struct TaskResults {
    /// The psychometric functions of each person and condition.
    pub functions: Vec<PersonFunction>,
    /// The thresholds of people, by condition.
    pub populations: Vec<(usize, Population)>,
    /// The conditions whose thresholds lie beyond the levels that could be shown, where only the prior places them, and on
    /// which side: at least half of the people's, or their mean.
    pub beyond: Vec<(usize, Beyond)>,
    /// Differences between the thresholds of two conditions, of the people who have both.
    pub differences: Vec<([usize; 2], Mean)>,
    /// The number of correct answers of each person and condition, and of all, if no levels were varied.
    pub shares: Vec<OfPerson<[u32; 2]>>,
    /// Hits and false alarms of each person and condition, with sensitivity and criterion.
    pub detection: Vec<OfPerson<Detected>>,
    /// The scale of comparisons.
    pub comparisons: Option<Comparisons>,
    /// The settings of each person and condition, on the scale of the dial.
    pub settings: Vec<OfPerson<Settings>>,
}

/// What follows from the answers of a person in a condition.
#[derive(Clone, Debug)]
pub struct OfPerson<T> {
    /// Index into [`TaskStudy::people`].
    pub person: usize,
    /// Index into the conditions.
    pub condition: usize,
    /// What follows.
    pub found: T,
}

/// The answers of a person in a condition, and sensitivity and criterion: `None` without targets or catch trials, and over
/// different levels, where both would describe how the levels were chosen, not any stimulus.
pub type Detected = (Answers, Option<Detection>);

/// The scale of comparisons.
#[derive(Clone, Debug)]
pub struct Comparisons {
    /// How often each condition was chosen over each other, by each person.
    pub people: Vec<Wins>,
    /// The scale of all people by Thurstone's Case V, and by the model of Bradley and Terry.
    pub scales: [Scale; 2],
    /// The 95 % intervals of Thurstone's scale.
    pub intervals: Option<Vec<Interval>>,
    /// Each person's own scale.
    pub own: Vec<Option<Scale>>,
    /// Each person's contradictions.
    pub triads: Vec<Triads>,
}

impl Comparisons {
    /// Returns the groups of conditions that were compared, each from the highest to the lowest on the scale.
    pub fn order(&self) -> Vec<Vec<usize>> {
        let Scale { values, mut groups, .. } = self.scales[0].clone();
        groups.iter_mut().for_each(|group| group.sort_by(|a, b| values[*b].total_cmp(&values[*a])));
        groups
    }
}

impl PersonFunction {
    /// Returns the answers to targets.
    pub fn targets(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(|point| point.is_target())
    }

    /// Returns the fitted function, if it means something.
    pub fn described(&self) -> Option<&Fit> {
        self.fit.as_ref().ok().filter(|_| !self.is_reversed)
    }

    /// Returns the most probable threshold, if the answers determine one within the levels.
    pub fn threshold(&self) -> Option<f64> {
        self.described()?.determined_threshold().filter(|_| self.beyond.is_none())
    }

    /// Returns the number of trials with a target.
    pub fn trials(&self) -> u64 {
        self.targets().map(|point| u64::from(point.total)).sum()
    }
}

/// Where beyond the levels a threshold lies, with the last level on that side, on the scale on which the method counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beyond {
    /// Below the lowest level.
    Below(f64),
    /// Above the highest level.
    Above(f64),
}

impl Beyond {
    /// Returns on which side of a range a value lies; `None` within it. A value at an end is beyond: the search ends there
    /// if the answers say only that the threshold is not in the range.
    pub fn of([low, high]: [f64; 2], value: f64) -> Option<Self> {
        let near = 1e-6 * (high - low);
        let above = (value >= high - near).then_some(Self::Above(high));
        if value <= low + near { Some(Self::Below(low)) } else { above }
    }
}

/// The psychometric function of a person in a condition.
#[derive(Clone, Debug)]
pub struct PersonFunction {
    /// Index into [`TaskStudy::people`].
    pub person: usize,
    /// Index into the conditions.
    pub condition: usize,
    /// The answers at each level and, where they tell the guess rate, in catch trials.
    pub points: Vec<Point>,
    /// The fitted function.
    pub fit: Result<Fit, &'static str>,
    /// How well it fits.
    pub goodness: Option<GoodnessOfFit>,
    /// Where the most probable threshold lies, if beyond the levels.
    pub beyond: Option<Beyond>,
    /// Whether more answers count at the end of the levels that is said to be harder, so that the function means nothing.
    pub is_reversed: bool,
}

/// Number of simulated studies for the goodness of fit.
const SIMULATIONS: usize = 1000;

impl TaskResults {
    /// Analyzes a study. `seed` is that of simulated studies.
    pub fn of(study: &TaskStudy, seed: u64) -> Self {
        let mut results = Self {
            shares: shares(study),
            detection: detection(study),
            comparisons: comparisons(study, seed),
            settings: settings(study),
            ..Self::default()
        };
        if let Some(Levels { common, model, .. }) = &study.asked.levels {
            results.functions = functions(points(study, &results.detection, common, model), model, seed);
            for (condition, population) in populations(study, &results.functions, model) {
                let place = majority(&results.functions, condition);
                match place.or(Beyond::of(population.range, population.function.threshold)) {
                    Some(place) => results.beyond.push((condition, place)),
                    None => results.populations.push((condition, population)),
                }
            }
            results.differences = differences(&contributions(&results.populations, &results.functions));
        }
        results
    }
}

/// Gathers the answers of each person in each condition, in this order of both, for which `one` returns something.
fn by_person<T: Default, A>(
    study: &TaskStudy,
    one: impl Fn(&TaskAnswered) -> Option<A>,
    add: impl Fn(&mut T, A),
) -> Vec<OfPerson<T>> {
    let mut all: BTreeMap<(usize, usize), T> = BTreeMap::new();
    for trial in &study.trials {
        if let Some(answer) = one(&trial.answer) {
            add(all.entry((trial.condition, trial.person)).or_default(), answer);
        }
    }
    all.into_iter().map(|((condition, person), found)| OfPerson { person, condition, found }).collect()
}

/// Returns whether trials had a target, in how many it was seen or chosen, and their number.
fn seen(answer: &TaskAnswered) -> Option<(bool, u32, u32)> {
    match *answer {
        TaskAnswered::Seen { is_target, seen, total, .. } => Some((is_target, seen, total)),
        _ => None,
    }
}

fn shares(study: &TaskStudy) -> Vec<OfPerson<[u32; 2]>> {
    if study.asked.measures != Some(Measures::Proportions) || study.asked.levels.is_some() {
        return Vec::new();
    }
    by_person(study, seen, |[right, all]: &mut [u32; 2], (_, seen, total)| {
        (*right, *all) = (*right + seen, *all + total);
    })
}

fn detection(study: &TaskStudy) -> Vec<OfPerson<Detected>> {
    if study.asked.measures != Some(Measures::Detection) {
        return Vec::new();
    }
    let all = by_person(study, seen, |answers: &mut Answers, (is_target, seen, total)| {
        let (yes, no) = match is_target {
            true => (&mut answers.hits, &mut answers.misses),
            false => (&mut answers.false_alarms, &mut answers.correct_rejections),
        };
        (*yes, *no) = (*yes + seen, *no + total - seen);
    });
    let with = |OfPerson { person, condition, found }: OfPerson<Answers>| {
        let sensitivity = found.detection().filter(|_| study.asked.levels.is_none());
        OfPerson { person, condition, found: (found, sensitivity) }
    };
    all.into_iter().map(with).collect()
}

fn comparisons(study: &TaskStudy, seed: u64) -> Option<Comparisons> {
    let items = study.asked.conditions.len();
    let mut people = vec![Wins::zeros(items, items); study.people.len()];
    for trial in &study.trials {
        let TaskAnswered::Compared { other, first_won } = trial.answer else { continue };
        let place = if first_won { (trial.condition, other) } else { (other, trial.condition) };
        people[trial.person][place] += 1.0;
    }
    let all: Wins = people.iter().sum();
    let scales = [Scaling::Thurstone.fit(&all)?, Scaling::BradleyTerry.fit(&all)?];
    let intervals = Scaling::Thurstone.intervals(&people, SIMULATIONS, &mut ChaCha8Rng::seed_from_u64(seed));
    let own = people.iter().map(|wins| Scaling::Thurstone.fit(wins)).collect();
    let triads = people.iter().map(Triads::of).collect();
    Some(Comparisons { people, scales, intervals, own, triads })
}

fn settings(study: &TaskStudy) -> Vec<OfPerson<Settings>> {
    let log = study.asked.dial.as_ref().is_some_and(|dial| dial.log);
    let set = |answer: &TaskAnswered| match *answer {
        TaskAnswered::Set { value, from_above } => Some((if log { value.log10() } else { value }, from_above)),
        _ => None,
    };
    let all = by_person(study, set, |values: &mut Vec<(f64, Option<bool>)>, value| values.push(value));
    let one = |OfPerson { person, condition, found }: OfPerson<Vec<_>>| {
        Some(OfPerson { person, condition, found: Settings::of(&found)? })
    };
    all.into_iter().filter_map(one).collect()
}

/// Returns the answers at each level of each person and condition. If the guess rate is estimated, catch trials come with
/// them: those of the condition, whatever the level of the second parameter.
fn points(
    study: &TaskStudy,
    detection: &[OfPerson<Detected>],
    common: &Common,
    model: &Model,
) -> Vec<OfPerson<Vec<Point>>> {
    let counted = |answer: &TaskAnswered| match *answer {
        TaskAnswered::Seen { level, is_target: true, seen, total } if total > 0 => Some((level?, seen, total)),
        _ => None,
    };
    let mut all = by_person(study, counted, |points, (level, seen, total)| {
        Point::add(points, common.scaled(level), seen, total);
    });
    let second = study.asked.protocol.as_ref().and_then(|protocol| protocol.adaptive.as_ref()?.second());
    let levels = second.map_or(1, |second| second.levels.len());
    let of = |condition: usize| condition / levels;
    for OfPerson { person, condition, found } in &mut all {
        let is_own = |own: &&OfPerson<Detected>| own.person == *person && of(own.condition) == of(*condition);
        for own in detection.iter().filter(|own| is_own(own) && model.guess == Guess::Free) {
            let Answers { false_alarms, correct_rejections, .. } = own.found.0;
            Point::add(found, model.unseen(), false_alarms, false_alarms + correct_rejections);
        }
        found.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    all
}

fn functions(points: Vec<OfPerson<Vec<Point>>>, model: &Model, seed: u64) -> Vec<PersonFunction> {
    let function = |(index, OfPerson { person, condition, found: points }): (usize, OfPerson<Vec<Point>>)| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index as u64);
        let fit = psychometric::fit(&points, model);
        let goodness = psychometric::goodness_of_fit(&points, model, SIMULATIONS, &mut rng).ok();
        let beyond = fit.as_ref().ok().and_then(|fit| Beyond::of(fit.range, fit.estimate.threshold));
        let is_reversed = is_reversed(&points, model);
        PersonFunction { person, condition, points, fit, goodness, beyond, is_reversed }
    };
    points.into_par_iter().enumerate().map(function).collect()
}

/// Returns the functions in a condition that mean something.
fn sound(functions: &[PersonFunction], condition: usize) -> impl Iterator<Item = &PersonFunction> {
    functions.iter().filter(move |function| function.condition == condition && !function.is_reversed)
}

/// Fits the people of each condition in which several have a function that means something. Why others have none, their
/// functions say.
fn populations(study: &TaskStudy, functions: &[PersonFunction], model: &Model) -> Vec<(usize, Population)> {
    let conditions = 0..study.asked.conditions.len();
    let fit = |condition: usize| {
        let people: Vec<Vec<Point>> = sound(functions, condition).map(|function| function.points.clone()).collect();
        Some((condition, population::fit(&people, model).ok()?))
    };
    conditions.into_par_iter().filter_map(fit).collect()
}

/// Standard errors beyond which answers are not due to chance.
const CLEAR: f64 = 3.0;

/// Returns whether the share of the answers falls where it should rise (the test of Armitage 1955, Biometrics 11, 375).
fn is_reversed(points: &[Point], model: &Model) -> bool {
    let sum = |of: &dyn Fn(&Point) -> f64| points.iter().filter(|point| point.is_target()).map(of).sum::<f64>();
    let n = sum(&|point| point.total.into());
    let [share, middle] =
        [sum(&|point| point.correct.into()), sum(&|point| f64::from(point.total) * point.x)].map(|sum| sum / n);
    let trend = sum(&|point| f64::from(point.correct) * (point.x - middle));
    let spread = sum(&|point| f64::from(point.total) * (point.x - middle).powi(2));
    let z = trend / (share * (1.0 - share) * spread).sqrt();
    // If all answers are the same, there is no trend, and rounding must not make one.
    share > 0.0 && share < 1.0 && (if model.falls { -z } else { z }) < -CLEAR
}

/// Returns the side of the levels on which the thresholds of at least half of the people lie, if they do, with the last
/// level of the first of them.
fn majority(functions: &[PersonFunction], condition: usize) -> Option<Beyond> {
    let own = || sound(functions, condition);
    let below = |place: &Beyond| matches!(place, Beyond::Below(_));
    let on = |side: bool| own().filter_map(|function| function.beyond).filter(move |place| below(place) == side);
    [true, false].into_iter().find_map(|side| on(side).next().filter(|_| 2 * on(side).count() >= own().count()))
}

/// The contributions of people to the mean threshold of a condition.
type Contributions = BTreeMap<usize, f64>;

/// Returns the contributions in each condition that has an interval; without one, they say nothing about how people differ.
fn contributions(populations: &[(usize, Population)], functions: &[PersonFunction]) -> Vec<(usize, Contributions)> {
    let own = |(condition, population): &(usize, Population)| {
        let people = sound(functions, *condition).zip(&population.contributions);
        (*condition, people.map(|(function, own)| (function.person, *own)).collect())
    };
    populations.iter().filter(|(_, population)| population.interval.is_some()).map(own).collect()
}

/// Compares two conditions by the people who have both, if there are several.
fn differences(all: &[(usize, Contributions)]) -> Vec<([usize; 2], Mean)> {
    let pairs = all.iter().enumerate().flat_map(|(i, one)| all[i + 1..].iter().map(move |two| (one, two)));
    let compared = pairs.map(|((one, first), (two, second))| {
        let both = first.iter().filter_map(|(person, value)| Some((*value, *second.get(person)?)));
        ([*one, *two], Mean::of_differences(&both.collect::<Vec<_>>()))
    });
    compared.filter(|(_, difference)| difference.people > 1).collect()
}
