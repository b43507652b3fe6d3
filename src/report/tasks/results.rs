//! What follows from the answers to a task.

use std::collections::BTreeMap;

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};
use rayon::prelude::*;

use super::study::{TaskAnswered, TaskStudy};
use crate::{
    analysis::tasks::{
        population::{self, Difference, Population},
        psychometric::{self, Fit, FitError, GoodnessOfFit, Guess, Model, Point},
    },
    experiment::task::{Common, Curve, Easier, Measures, Method},
};

/// The results of a task.
#[derive(Clone, Debug, Default)]
pub struct TaskResults {
    /// The psychometric functions of each person and condition.
    pub functions: Vec<PersonFunction>,
    /// The thresholds of people, by condition.
    pub populations: Vec<(usize, Population)>,
    /// Differences between the thresholds of two conditions that the same people saw.
    pub differences: Vec<([usize; 2], Difference)>,
}

/// The psychometric function of a person in a condition.
#[derive(Clone, Debug)]
pub struct PersonFunction {
    /// Index into [`TaskStudy::people`].
    pub person: usize,
    /// Index into the protocol's conditions.
    pub condition: usize,
    /// The answers at each level.
    pub points: Vec<Point>,
    /// The fitted function.
    pub fit: Result<Fit, FitError>,
    /// How well it fits.
    pub goodness: Option<GoodnessOfFit>,
}

/// Number of simulated studies for the goodness of fit.
const SIMULATIONS: usize = 1000;

impl TaskResults {
    /// Analyzes a study. `seed` is that of simulated studies.
    #[must_use]
    pub fn of(study: &TaskStudy, seed: u64) -> Self {
        let mut results = Self::default();
        if let Some(model) = model(study) {
            results.functions = functions(study, &model, seed);
            results.populations = populations(study, &results.functions, &model);
            results.differences = differences(&results.populations, &results.functions);
        }
        results
    }
}

/// Returns what is known about the psychometric functions; `None` if no levels were varied.
pub(super) fn model(study: &TaskStudy) -> Option<Model> {
    let adaptive = study.protocol.adaptive.as_ref()?;
    if !matches!(study.protocol.task.measures(), Measures::Proportions | Measures::Detection) {
        return None;
    }
    let curve = if let Method::QuestPlus(quest) = &adaptive.method { quest.function } else { Curve::Normal };
    let guess = study.protocol.task.guess().map_or(Guess::Free, Guess::Fixed);
    let falls = adaptive.common.easier == Easier::Low;
    let range = Some(adaptive.range().map(|level| adaptive.common.scaled(level)));
    Some(Model { curve, guess, falls, overdispersed: false, range })
}

/// Returns the answers at each level of each person and condition.
fn points(study: &TaskStudy, common: &Common) -> BTreeMap<(usize, usize), Vec<Point>> {
    let mut all: BTreeMap<(usize, usize), Vec<Point>> = BTreeMap::new();
    for trial in &study.trials {
        let TaskAnswered::Seen { level: Some(level), is_target: true, seen } = trial.answer else { continue };
        let (points, x) = (all.entry((trial.condition, trial.person)).or_default(), common.scaled(level));
        let known = points.iter().position(|point| point.x == x).unwrap_or_else(|| {
            points.push(Point { x, correct: 0, total: 0 });
            points.len() - 1
        });
        points[known].total += 1;
        points[known].correct += u32::from(seen);
    }
    all.values_mut().for_each(|points| points.sort_by(|a, b| a.x.total_cmp(&b.x)));
    all
}

fn functions(study: &TaskStudy, model: &Model, seed: u64) -> Vec<PersonFunction> {
    let Some(adaptive) = &study.protocol.adaptive else { return Vec::new() };
    let all: Vec<_> = points(study, &adaptive.common).into_iter().collect();
    let function = |(index, ((condition, person), points)): (usize, ((usize, usize), Vec<Point>))| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index as u64);
        let fit = psychometric::fit(&points, model);
        let goodness = psychometric::goodness_of_fit(&points, model, SIMULATIONS, &mut rng).ok();
        PersonFunction { person, condition, points, fit, goodness }
    };
    all.into_par_iter().enumerate().map(function).collect()
}

fn populations(study: &TaskStudy, functions: &[PersonFunction], model: &Model) -> Vec<(usize, Population)> {
    let conditions = 0..study.protocol.conditions().len();
    let fit = |condition: usize| {
        let of_people = functions.iter().filter(|function| function.condition == condition);
        let people: Vec<Vec<Point>> = of_people.map(|function| function.points.clone()).collect();
        Some((condition, population::fit(&people, model).ok()?))
    };
    conditions.into_par_iter().filter_map(fit).collect()
}

/// Compares the conditions whose people are the same.
fn differences(populations: &[(usize, Population)], functions: &[PersonFunction]) -> Vec<([usize; 2], Difference)> {
    let of = |condition: usize| -> Vec<usize> {
        functions.iter().filter(|function| function.condition == condition).map(|function| function.person).collect()
    };
    let pairs =
        populations.iter().enumerate().flat_map(|(i, one)| populations[i + 1..].iter().map(move |two| (one, two)));
    let compared = pairs.filter(|(one, two)| of(one.0) == of(two.0)).map(|((one, first), (two, second))| {
        let values = first.people.iter().zip(&second.people).map(|(a, b)| (a.contribution, b.contribution));
        ([*one, *two], Difference::new(&values.collect::<Vec<_>>()))
    });
    compared.collect()
}
