//! What follows from the answers to a task.

use std::collections::BTreeMap;

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};
use rayon::prelude::*;

use super::study::{Given, Levels, Measure, OfPerson, TaskStudy};
use crate::{
    analysis::{
        comparisons::{Drawn, Scale, Scaling, Triads, Wins},
        tasks::{
            person::Settings,
            population::{self, Difference, Mean, Population},
            psychometric::{self, Estimate, Fit, GoodnessOfFit, Model, Point},
        },
    },
    statistics::Interval,
};

/// The results of a task.
#[derive(Clone, Debug, Default)]
pub struct TaskResults {
    /// What is estimated for each person in each condition; [`Asked::estimand`](super::Asked::estimand) says what that is.
    pub own: Vec<OfPerson<f64>>,
    /// Its mean over people in each condition.
    pub means: Vec<(usize, Mean)>,
    /// Differences between two conditions; none between more conditions than anyone would compare in pairs.
    pub differences: Vec<Difference>,
    /// The psychometric functions of each person and condition.
    pub functions: Vec<PersonFunction>,
    /// The thresholds of people, by condition.
    pub populations: Vec<(usize, Population)>,
    /// The conditions whose thresholds lie beyond the levels that could be shown, where only the prior places them: at least
    /// half of the people's, or their mean.
    pub beyond: Vec<usize>,
    /// The scale of comparisons.
    pub comparisons: Option<Comparisons>,
}

/// The scale of comparisons.
#[derive(Clone, Debug)]
pub struct Comparisons {
    /// How often each condition was chosen over each other, by each person.
    pub people: Vec<Wins>,
    /// The scale of all people by Thurstone's Case V, and by the model of Bradley and Terry.
    pub scales: [Scale; 2],
    /// What other samples of people would give on Thurstone's scale, if these people say that.
    pub drawn: Option<Drawn>,
    /// Each person's own scale by both models.
    pub own: Vec<Option<[Scale; 2]>>,
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

    /// Returns the 95 % interval of a value of Thurstone's scale.
    pub fn interval(&self, item: usize) -> Option<Interval> {
        self.drawn.as_ref()?.mean(item, None).interval
    }
}

impl PersonFunction {
    /// Returns the answers to targets.
    pub fn targets(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(|point| point.is_target())
    }

    /// Returns the most probable function, if it means something.
    fn estimated(&self) -> Option<&Estimate> {
        self.estimate.as_ref().ok().filter(|_| !self.is_reversed)
    }

    /// Returns the function with its intervals, if it means something.
    pub fn described(&self) -> Option<&Fit> {
        self.fit.as_ref().filter(|_| !self.is_reversed)
    }

    /// Returns the most probable threshold, if the answers determine one within the levels.
    pub fn threshold(&self) -> Option<f64> {
        self.described()?.determined_threshold().filter(|_| !self.is_beyond())
    }

    /// Returns whether the most probable threshold lies beyond the levels.
    pub fn is_beyond(&self) -> bool {
        self.estimated().is_some_and(|estimate| is_beyond(self.range, estimate.threshold))
    }

    /// Returns the number of trials with a target.
    pub fn trials(&self) -> u64 {
        self.targets().map(|point| u64::from(point.total)).sum()
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
    /// The lowest and the highest level that could be shown or, in a table, that was.
    pub range: [f64; 2],
    /// The most probable function.
    pub estimate: Result<Estimate, &'static str>,
    /// That function with its intervals.
    pub fit: Option<Fit>,
    /// How well it fits.
    pub goodness: Option<GoodnessOfFit>,
    /// Whether more answers count at the end of the levels that is said to be harder, so that the function means nothing.
    pub is_reversed: bool,
}

/// Number of simulated studies for the goodness of fit and for intervals of a scale.
const SIMULATIONS: usize = 1000;
/// The most conditions of which every two are compared.
const MAX_COMPARED: usize = 20;

impl TaskResults {
    /// Analyzes a study. `seed` is that of simulated studies.
    pub fn of(study: &TaskStudy, seed: u64) -> Self {
        let mut results = Self::estimated(study, SIMULATIONS, seed);
        if let Some(Levels { model, .. }) = study.asked.levels() {
            results.functions.par_iter_mut().enumerate().for_each(|(index, own)| {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(index as u64);
                own.fit = psychometric::fit(&own.points, model).ok();
                own.goodness = psychometric::goodness_of_fit(&own.points, model, SIMULATIONS, &mut rng).ok();
            });
        }
        results
    }

    /// Analyzes a study, except for the intervals and the fit of one person's function, which take the most time. `draws` is
    /// the number of studies from which intervals of a scale come.
    pub fn estimated(study: &TaskStudy, draws: usize, seed: u64) -> Self {
        let mut results = Self { comparisons: comparisons(study, draws, seed), ..Self::default() };
        if let Some(Levels { model, .. }) = study.asked.levels() {
            results.functions = functions(study, model);
            results.measure(study.asked.conditions.len(), model);
        }
        results.own = results.of_each(study);
        let ends = study.asked.estimand().ends;
        let conditions = study.asked.conditions.len();
        results.means =
            (0..conditions).filter_map(|condition| Some((condition, results.mean(condition, ends)?))).collect();
        if conditions <= MAX_COMPARED {
            results.differences = results.compared();
        }
        results
    }

    /// Fits the people of each condition in which several have a function that means something, and keeps the populations whose
    /// thresholds were measured. Why others have none, their functions say.
    fn measure(&mut self, conditions: usize, model: &Model) {
        let fit = |condition: usize| {
            let people = sound(&self.functions, condition).map(|function| function.points.clone());
            Some((condition, population::fit(&people.collect::<Vec<_>>(), model).ok()?))
        };
        let found: Vec<_> = (0..conditions).into_par_iter().filter_map(fit).collect();
        for (condition, population) in found {
            let own = || sound(&self.functions, condition);
            let are_beyond = 2 * own().filter(|function| function.is_beyond()).count() >= own().count();
            if are_beyond || is_beyond(population.range, population.function.threshold) {
                self.beyond.push(condition);
            } else {
                self.populations.push((condition, population));
            }
        }
    }

    /// Returns what is estimated for each person.
    fn of_each(&self, study: &TaskStudy) -> Vec<OfPerson<f64>> {
        let with = |person, condition, found| OfPerson { person, condition, found };
        let threshold = |own: &PersonFunction| Some(with(own.person, own.condition, own.estimated()?.threshold));
        let mut all: Vec<OfPerson<f64>> = match study.asked.measure {
            Measure::Thresholds(_) => self.functions.iter().filter_map(threshold).collect(),
            Measure::Proportions => study.each(|given| Some(proportion(&given.seen(true)))),
            Measure::Sensitivity => {
                let own = study.detection().into_iter();
                own.filter_map(|own| Some(with(own.person, own.condition, own.found.1?.d_prime))).collect()
            }
            Measure::Settings(_) => study.each(|given| Some(Settings::of(&given.values)?.mean)),
            Measure::Scale => {
                let people = self.comparisons.iter().flat_map(|found| found.own.iter().enumerate());
                let scales = people.filter_map(|(person, scales)| Some((person, &scales.as_ref()?[0].values)));
                let of_person = |(person, values): (usize, &Vec<f64>)| {
                    values.iter().enumerate().map(|(item, value)| with(person, item, *value)).collect::<Vec<_>>()
                };
                scales.flat_map(of_person).collect()
            }
        };
        all.retain(|own| !own.found.is_nan());
        all
    }

    /// Returns the mean of a condition, which cannot lie outside `ends`.
    fn mean(&self, condition: usize, ends: Option<[f64; 2]>) -> Option<Mean> {
        if !self.functions.is_empty() {
            let (_, population) = self.populations.iter().find(|(of, _)| *of == condition)?;
            let Population { function, interval, contributions, .. } = population;
            return Some(Mean { mean: function.threshold, interval: *interval, people: contributions.len() });
        }
        if let Some(Comparisons { scales: [scale, _], drawn, people, .. }) = &self.comparisons {
            let alone = Mean { mean: scale.values[condition], interval: None, people: people.len() };
            return Some(drawn.as_ref().map_or(alone, |drawn| drawn.mean(condition, None)));
        }
        let own: Vec<f64> = self.own.iter().filter(|own| own.condition == condition).map(|own| own.found).collect();
        (!own.is_empty()).then(|| ends.map_or_else(|| Mean::new(&own), |ends| Mean::bounded(&own, ends)))
    }

    /// Compares every two conditions.
    fn compared(&self) -> Vec<Difference> {
        if let Some(Comparisons { scales, drawn, .. }) = &self.comparisons {
            let pairs = scales[0].groups.iter().flat_map(|group| {
                group.iter().enumerate().flat_map(|(place, i)| group[place + 1..].iter().map(|j| [*i, *j]))
            });
            return drawn
                .as_ref()
                .map_or_else(Vec::new, |drawn| Difference::of(pairs.map(|[i, j]| ([i, j], drawn.mean(i, Some(j))))));
        }
        if !self.functions.is_empty() {
            // Without an interval, contributions say nothing about how people differ.
            let known = self.populations.iter().filter(|(_, population)| population.interval.is_some());
            let own = |(condition, population): &(usize, Population)| {
                let people = sound(&self.functions, *condition).zip(&population.contributions);
                (*condition, people.map(|(function, own)| (function.person, *own)).collect())
            };
            return Difference::between(&known.map(own).collect::<Vec<_>>());
        }
        let mut values: BTreeMap<usize, BTreeMap<usize, f64>> = BTreeMap::new();
        for own in &self.own {
            values.entry(own.condition).or_default().insert(own.person, own.found);
        }
        Difference::between(&values.into_iter().collect::<Vec<_>>())
    }
}

/// Returns the proportion of correct answers.
pub(super) fn proportion([right, all]: &[u32; 2]) -> f64 {
    f64::from(*right) / f64::from(*all)
}

fn comparisons(study: &TaskStudy, draws: usize, seed: u64) -> Option<Comparisons> {
    let items = study.asked.conditions.len();
    let mut people = vec![Wins::zeros(items, items); study.people.len()];
    for (person, [winner, loser]) in &study.compared {
        people[*person][(*winner, *loser)] += 1.0;
    }
    let all: Wins = people.iter().sum();
    let fit = |wins: &Wins| Some([Scaling::Thurstone.fit(wins)?, Scaling::BradleyTerry.fit(wins)?]);
    let scales = fit(&all)?;
    let drawn = Scaling::Thurstone.drawn(&people, draws, &mut ChaCha8Rng::seed_from_u64(seed));
    let own = people.iter().map(fit).collect();
    let triads = people.iter().map(Triads::of).collect();
    Some(Comparisons { people, scales, drawn, own, triads })
}

/// Estimates the function of each person and condition. Catch trials come with the answers at each level: those of the
/// condition, whatever the level of the second parameter.
fn functions(study: &TaskStudy, model: &Model) -> Vec<PersonFunction> {
    let targets = |given: &Given| given.points.iter().copied().filter(Point::is_target).collect::<Vec<Point>>();
    let all = study.each(|given| Some(targets(given)).filter(|points| !points.is_empty()));
    let second = study.asked.protocol.as_ref().and_then(|protocol| protocol.adaptive.as_ref()?.second());
    let levels = second.map_or(1, |second| second.levels.len());
    let of = |condition: usize| condition / levels;
    let function = |OfPerson { person, condition, found: mut points }: OfPerson<Vec<Point>>| {
        let own = study.given.iter().filter(|(own, _)| own.1 == person && of(own.0) == of(condition));
        for catch in own.flat_map(|(_, given)| &given.points).filter(|point| !point.is_target()) {
            Point::add(&mut points, model.unseen(), catch.correct, catch.total);
        }
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let levels = || points.iter().filter(|point| point.is_target()).map(|point| point.x);
        let ends = || [f64::min, f64::max].map(|end| levels().fold(f64::NAN, end));
        let range = model.range.unwrap_or_else(ends);
        let (estimate, is_reversed) = (psychometric::estimate(&points, model), is_reversed(&points, model));
        PersonFunction { person, condition, range, estimate, fit: None, goodness: None, is_reversed, points }
    };
    all.into_par_iter().map(function).collect()
}

/// Returns the functions in a condition that mean something.
fn sound(functions: &[PersonFunction], condition: usize) -> impl Iterator<Item = &PersonFunction> {
    functions.iter().filter(move |function| function.condition == condition && !function.is_reversed)
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

/// Returns whether a value lies beyond a range. One at an end does: the search ends there if the answers say only that the
/// threshold is not in the range.
fn is_beyond([low, high]: [f64; 2], value: f64) -> bool {
    let near = 1e-6 * (high - low);
    value <= low + near || value >= high - near
}
