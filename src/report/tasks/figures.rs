//! The charts of a task.

use super::{
    asked::Levels,
    further::{over_people, scaled_ends},
    results::TaskResults,
    study::TaskStudy,
};
use crate::{
    analysis::tasks::psychometric::{Estimate, Point},
    report::{
        document::numbers::{count, list},
        figures::{
            Figure,
            tasks::{Curve, Estimates, estimates, psychometric},
        },
    },
};

/// Number of levels at which a function is drawn.
const DRAWN: usize = 81;

/// Draws every chart for which there are data.
#[must_use]
pub fn figures(study: &TaskStudy, results: &TaskResults) -> Vec<Figure> {
    let kinds = [functions, thresholds, shares, detection, scale, settings];
    kinds.into_iter().filter_map(|kind| kind(study, results)).collect()
}

fn functions(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let Levels { common, range, model, .. } = study.asked.levels.as_ref()?;
    let range = range.map(|level| common.scaled(level));
    let conditions: Vec<usize> = (0..study.asked.conditions.len())
        .filter(|condition| results.functions.iter().any(|function| function.condition == *condition))
        .collect();
    let curve = |&condition: &usize| {
        let own = results.functions.iter().filter(|function| function.condition == condition);
        let mut all: Vec<Point> = Vec::new();
        for point in own.clone().flat_map(|function| &function.points) {
            Point::add(&mut all, point.x, point.correct, point.total);
        }
        let of_people = results.populations.iter().find(|(of, _)| *of == condition).map(|(_, population)| Estimate {
            threshold: population.mean,
            width: population.width,
            lapse: population.lapse,
            guess: population.guess,
            overdispersion: 0.0,
        });
        // A line of one person would not be that of the others' answers.
        let of_one = own.clone().next().filter(|_| own.clone().count() == 1);
        let of_one = of_one.and_then(|function| function.fit.as_ref().ok()).map(|fit| fit.estimate);
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
    let curves: Vec<Curve> = conditions.iter().map(curve).collect();
    let name = &common.parameter;
    let axis = if common.log { format!("log10 {name}") } else { name.clone() };
    let caption = format!(
        "Share of right answers, or of answers yes, by level; the area of a marker stands for the number of trials. \
         Lines are the functions {}; {}, {}.{}",
        if study.people.len() == 1 {
            "of the participant"
        } else {
            "at the mean threshold of people, where it was measured"
        },
        count(study.people.len() as u64, "participant"),
        count(study.answers(), "answer"),
        symbols(study)
    );
    psychometric(&curves, range, &axis, caption)
}

fn thresholds(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let common = &study.asked.levels.as_ref()?.common;
    let conditions: Vec<usize> = (0..study.asked.conditions.len())
        .filter(|condition| results.functions.iter().any(|function| function.condition == *condition))
        .collect();
    let series = |&condition: &usize| {
        let own = |person: usize| {
            let mut all = results.functions.iter();
            let function = all.find(|function| function.condition == condition && function.person == person)?;
            let fit = function.fit.as_ref().ok().filter(|_| function.beyond.is_none())?;
            Some((fit.determined_threshold()?, Some(fit.threshold)))
        };
        let mut all: Vec<_> = (0..study.people.len()).map(own).collect();
        let of_people = results.populations.iter().find(|(of, _)| *of == condition);
        all.push(of_people.map(|(_, population)| (population.mean, population.interval)));
        (study.levels(condition).join(", "), all)
    };
    let places: Vec<String> = study.people.iter().cloned().chain(["mean".to_owned()]).collect();
    let axis = if common.log { format!("log10 {}", common.parameter) } else { common.parameter.clone() };
    let caption = format!(
        "The threshold of each participant, and the mean of people, with 95\u{a0}% intervals; {}.{}",
        count(study.answers(), "answer"),
        symbols(study)
    );
    let series: Vec<_> = conditions.iter().map(series).collect();
    estimates("thresholds", &places, &series, ("Thresholds", &axis, caption))
}

/// Says what the symbols of a figure stand for, if there are several.
fn symbols(study: &TaskStudy) -> String {
    let names: Vec<&str> = study.asked.factors.iter().map(|factor| factor.name.as_str()).collect();
    match study.asked.conditions.len() {
        0 | 1 => String::new(),
        _ => format!(" The symbols are the levels of {}.", list(&names)),
    }
}

/// Returns the estimates of each condition, one for each person and at last their mean.
fn by_person(study: &TaskStudy, ends: Option<[f64; 2]>, value: impl Fn(usize, usize) -> Option<f64>) -> Vec<Estimates> {
    let condition = |condition: usize| {
        let own: Vec<Option<f64>> = (0..study.people.len()).map(|person| value(condition, person)).collect();
        let known: Vec<f64> = own.iter().flatten().copied().collect();
        let mut all: Vec<_> = own.into_iter().map(|own| Some((own?, None))).collect();
        all.push(over_people(&known, ends).map(|mean| (mean.mean, mean.interval)));
        (study.levels(condition).join(", "), all)
    };
    (0..study.asked.conditions.len()).map(condition).collect()
}

fn people_and_mean(study: &TaskStudy) -> Vec<String> {
    study.people.iter().cloned().chain(["mean".to_owned()]).collect()
}

fn shares(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let value = |condition: usize, person: usize| {
        let mut all = results.shares.iter();
        all.find(|own| own.condition == condition && own.person == person).map(|own| own.share())
    };
    let caption = format!(
        "The share of right answers of each participant, and the mean of people with its 95\u{a0}% interval; {}.{}",
        count(study.answers(), "answer"),
        symbols(study)
    );
    estimates(
        "shares",
        &people_and_mean(study),
        &by_person(study, Some([0.0, 1.0]), value),
        ("Right answers", "Share of right answers", caption),
    )
}

fn detection(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let value = |condition: usize, person: usize| {
        let mut all = results.detection.iter();
        let own = all.find(|answers| answers.condition == condition && answers.person == person)?;
        Some(own.detection()?.d_prime)
    };
    let series: Vec<_> =
        by_person(study, None, value).into_iter().filter(|(_, all)| all.iter().any(Option::is_some)).collect();
    let caption = format!(
        "d′ of each participant, and the mean of people with its 95\u{a0}% interval; {}.{}",
        count(study.answers(), "answer"),
        symbols(study)
    );
    estimates("detection", &people_and_mean(study), &series, ("Sensitivity", "d′", caption))
}

fn scale(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let comparisons = results.comparisons.as_ref()?;
    let mut order: Vec<usize> = (0..comparisons.scales[0].values.len()).collect();
    order.sort_by(|a, b| comparisons.scales[0].values[*a].total_cmp(&comparisons.scales[0].values[*b]));
    let interval = |item: usize| comparisons.intervals.as_ref().map(|intervals| intervals[item]);
    let values = order.iter().map(|item| Some((comparisons.scales[0].values[*item], interval(*item)))).collect();
    let places: Vec<String> = order.iter().map(|item| study.item(*item)).collect();
    let caption = format!(
        "Scale values of Thurstone\u{2019}s Case V, lowest first; two conditions one JND apart are told apart in 75\u{a0}% of comparisons. Bars are 95\u{a0}% intervals over people; {}, {}.",
        count(study.people.len() as u64, "participant"),
        count(study.trials.len() as u64, "comparison")
    );
    estimates("scale", &places, &[(String::new(), values)], ("Scale of the comparisons", "Scale value (JND)", caption))
}

fn settings(study: &TaskStudy, results: &TaskResults) -> Option<Figure> {
    let dial = study.asked.dial.as_ref()?;
    let value = |condition: usize, person: usize| {
        let mut all = results.settings.iter();
        all.find(|own| own.condition == condition && own.person == person).map(|own| own.settings.mean)
    };
    let name = dial.parameter.clone().unwrap_or_else(|| "rating".to_owned());
    let axis = if dial.log { format!("log10 {name}") } else { name };
    let caption = format!(
        "The mean setting of each participant, and the mean of people with its 95\u{a0}% interval; {}.{}",
        count(study.trials.len() as u64, "setting"),
        symbols(study)
    );
    estimates(
        "settings",
        &people_and_mean(study),
        &by_person(study, Some(scaled_ends(dial)), value),
        ("Settings", &axis, caption),
    )
}
