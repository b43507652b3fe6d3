//! The charts of a task.

use super::{
    results::{TaskResults, model},
    study::TaskStudy,
};
use crate::{
    analysis::tasks::psychometric::Estimate,
    report::{
        document::numbers::count,
        figures::{
            Figure,
            tasks::{Curve, estimates, psychometric},
        },
    },
    statistics::Interval,
};

/// Number of levels at which a function is drawn.
const DRAWN: usize = 81;

/// Draws every chart for which there are data.
#[must_use]
pub fn figures(study: &TaskStudy, results: &TaskResults) -> Vec<Figure> {
    [functions(study, results), thresholds(study, results)].into_iter().flatten().collect()
}

fn functions(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let (adaptive, model) = (study.protocol.adaptive.as_ref()?, model(study)?);
    let range = adaptive.range().map(|level| adaptive.common.scaled(level));
    let conditions: Vec<usize> = (0..study.protocol.conditions().len())
        .filter(|condition| results.functions.iter().any(|function| function.condition == *condition))
        .collect();
    let curve = |&condition: &usize| {
        let own = results.functions.iter().filter(|function| function.condition == condition);
        let mut tallies: Vec<(f64, u32, u32)> = Vec::new();
        for point in own.clone().flat_map(|function| &function.points) {
            match tallies.iter_mut().find(|tally| tally.0 == point.x) {
                Some(tally) => (tally.1, tally.2) = (tally.1 + point.correct, tally.2 + point.total),
                None => tallies.push((point.x, point.correct, point.total)),
            }
        }
        let of_people = results.populations.iter().find(|(of, _)| *of == condition).map(|(_, population)| Estimate {
            threshold: population.mean,
            width: population.width,
            lapse: population.lapse,
            guess: population.guess,
            overdispersion: 0.0,
        });
        let of_one = own.clone().find_map(|function| function.fit.as_ref().ok()).map(|fit| fit.estimate);
        let parameters = of_people.or(of_one).map(|estimate| model.parameters(&estimate));
        let at = |index: usize| range[0] + (range[1] - range[0]) * index as f64 / (DRAWN - 1) as f64;
        let line =
            parameters.map(|parameters| (0..DRAWN).map(|i| model.curve.probability(at(i), &parameters)).collect());
        Curve {
            name: study.name(condition),
            points: tallies.into_iter().map(|(x, seen, n)| (x, f64::from(seen) / f64::from(n), n)).collect(),
            line: line.unwrap_or_default(),
        }
    };
    let curves: Vec<Curve> = conditions.iter().map(curve).collect();
    let name = &adaptive.common.parameter;
    let axis = if adaptive.common.log { format!("log₁₀ {name}") } else { name.clone() };
    let caption = format!(
        "Share of right answers, or of answers yes, by level; the area of a marker stands for the number of trials. \
         Lines are the functions {}; {}, {}.",
        if results.populations.is_empty() { "of the participant" } else { "at the mean threshold of people" },
        count(study.people.len() as u64, "participant"),
        count(study.trials.len() as u64, "answer")
    );
    psychometric(&curves, range, &axis, caption)
}

fn thresholds(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let common = &study.protocol.adaptive.as_ref()?.common;
    let conditions: Vec<usize> = (0..study.protocol.conditions().len())
        .filter(|condition| results.functions.iter().any(|function| function.condition == *condition))
        .collect();
    let series = |&condition: &usize| {
        let own = |person: usize| {
            let mut all = results.functions.iter();
            let function = all.find(|function| function.condition == condition && function.person == person)?;
            let fit = function.fit.as_ref().ok()?;
            Some((fit.estimate.threshold, Some(fit.threshold)))
        };
        let mut all: Vec<Option<(f64, Option<Interval>)>> = (0..study.people.len()).map(own).collect();
        let of_people = results.populations.iter().find(|(of, _)| *of == condition);
        all.push(of_people.map(|(_, population)| (population.mean, population.interval)));
        (study.name(condition), all)
    };
    let places: Vec<String> = study.people.iter().cloned().chain(["mean".to_owned()]).collect();
    let axis = if common.log { format!("log₁₀ {}", common.parameter) } else { common.parameter.clone() };
    let caption = format!(
        "The threshold of each participant, and the mean of people, with 95\u{a0}% intervals; {}.",
        count(study.trials.len() as u64, "answer")
    );
    let series: Vec<_> = conditions.iter().map(series).collect();
    estimates("thresholds", &places, &series, ("Thresholds", &axis, caption))
}
