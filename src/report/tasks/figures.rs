//! The charts of a task.

use super::{
    results::{PersonFunction, TaskResults},
    sections::APART,
    study::{Levels, TaskStudy},
};
use crate::{
    analysis::tasks::psychometric::Point,
    report::{
        document::{count, list},
        figures::{
            Figure,
            tasks::{Curve, Estimates, estimates, psychometric},
        },
    },
};

/// Number of levels at which a function is drawn.
const DRAWN: usize = 81;

/// Draws every chart for which there are data.
pub fn figures(study: &TaskStudy, results: &TaskResults) -> Vec<Figure> {
    let kinds = [functions, thresholds, scale];
    kinds.into_iter().filter_map(|kind| kind(study, results)).collect()
}

/// Returns the conditions in which there are functions.
fn measured(study: &TaskStudy, results: &TaskResults) -> impl Iterator<Item = usize> {
    let is_measured =
        move |condition: &usize| results.functions.iter().any(|function| function.condition == *condition);
    (0..study.asked.conditions.len()).filter(is_measured)
}

fn functions(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let Levels { common, range, model, .. } = study.asked.levels()?;
    let range = range.map(|level| common.scaled(level));
    let curve = |condition: usize| {
        let own = results.functions.iter().filter(|function| function.condition == condition);
        let mut all: Vec<Point> = Vec::new();
        for point in own.clone().flat_map(PersonFunction::targets) {
            Point::add(&mut all, point.x, point.correct, point.total);
        }
        let of_people = results.populations.iter().find(|(of, _)| *of == condition);
        let of_people = of_people.map(|(_, population)| population.function);
        // A line of one person would not be that of the others' answers.
        let of_one = own.clone().next().filter(|_| own.clone().count() == 1);
        let of_one = of_one.and_then(PersonFunction::described).map(|fit| fit.estimate);
        let parameters = of_people.or(of_one).map(|estimate| model.parameters(&estimate));
        let at = |index: usize| range[0] + (range[1] - range[0]) * index as f64 / (DRAWN - 1) as f64;
        let line =
            parameters.map(|parameters| (0..DRAWN).map(|i| model.curve.probability(at(i), &parameters)).collect());
        Curve {
            name: study.levels(condition).join(", "),
            points: all.iter().map(|at| (at.x, f64::from(at.correct) / f64::from(at.total), at.total)).collect(),
            line: line.unwrap_or_default(),
        }
    };
    let curves: Vec<Curve> = measured(study, results).map(curve).collect();
    let axis = study.asked.axis(&common.parameter, common.log);
    let caption = format!(
        "Proportion of correct answers, or of yes answers, by level; the area of a marker stands for the number of trials. \
         Lines are the functions {}; {}, {}.{}",
        if study.people.len() == 1 {
            "of the participant"
        } else {
            "at the mean threshold of the participants, where it was measured"
        },
        count(study.people.len() as u64, "participant"),
        count(study.answers(), "answer"),
        symbols(study)
    );
    psychometric(&curves, range, &axis, caption)
}

fn thresholds(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let common = &study.asked.levels()?.common;
    let series = |condition: usize| {
        let own = |person: usize| {
            let mut all = results.functions.iter();
            let function = all.find(|function| function.condition == condition && function.person == person)?;
            Some((function.threshold()?, Some(function.described()?.threshold)))
        };
        let mut all: Vec<_> = (0..study.people.len()).map(own).collect();
        let of_people = results.populations.iter().find(|(of, _)| *of == condition);
        all.push(of_people.map(|(_, population)| (population.function.threshold, population.interval)));
        (study.levels(condition).join(", "), all)
    };
    let axis = study.asked.axis(&common.parameter, common.log);
    let caption = format!(
        "The threshold of each participant, and the mean if there are several, with 95\u{a0}% intervals; {}.{}",
        count(study.answers(), "answer"),
        symbols(study)
    );
    let series: Vec<_> = measured(study, results).map(series).collect();
    let places = [&study.people[..], &["mean".to_owned()]].concat();
    estimates("thresholds", &places, &series, ("Thresholds", &axis, caption))
}

/// Says what the symbols of a figure stand for, if there are several.
fn symbols(study: &TaskStudy) -> String {
    let names: Vec<String> = study.asked.factors.iter().map(|factor| study.asked.factor(&factor.name)).collect();
    match study.asked.conditions.len() {
        0 | 1 => String::new(),
        _ => format!(" The symbols are the levels of {}.", list(&names)),
    }
}

fn scale(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let comparisons = results.comparisons.as_ref()?;
    let groups = comparisons.order();
    let order: Vec<usize> = groups.concat().into_iter().rev().collect();
    let value = |item: usize| (comparisons.scales[0].values[item], comparisons.interval(item));
    let series = |(number, group): (usize, &Vec<usize>)| {
        let values = order.iter().map(|item| group.contains(item).then(|| value(*item))).collect();
        (if groups.len() > 1 { format!("group {}", number + 1) } else { String::new() }, values)
    };
    let series: Vec<Estimates> = groups.iter().enumerate().map(series).collect();
    let places: Vec<String> = order.iter().map(|item| study.levels(*item).join(", ")).collect();
    let bars = match comparisons.drawn {
        Some(_) => "Bars are 95\u{a0}% intervals over participants",
        None => "There are no intervals, because too few participants determine a scale",
    };
    let caption = format!(
        "Scale values of Thurstone\u{2019}s Case V, lowest first; two conditions one JND apart are told apart in 75\u{a0}% of comparisons. {bars}; {}, {}.{}",
        count(study.people.len() as u64, "participant"),
        count(study.compared.len() as u64, "comparison"),
        if groups.len() > 1 { format!(" {APART}") } else { String::new() }
    );
    estimates("scale", &places, &series, ("Scale of the comparisons", "Scale value (JND)", caption))
}
