//! The results of a task as tables.

use super::{
    results::{Comparisons, PersonFunction, TaskResults},
    study::{Levels, Measure, OfPerson, TaskStudy},
};
use crate::{
    analysis::{
        comparisons::Wins,
        tasks::{population::Population, psychometric::Point},
    },
    experiment::task::{Common, Dial},
    report::tables::Rows,
    text::Table,
};

/// Returns the tables by the names of their files.
pub fn tables(study: &TaskStudy, results: &TaskResults) -> Vec<(&'static str, Table)> {
    let mut all = match &study.asked.measure {
        Measure::Thresholds(Levels { common, .. }) => vec![
            ("answers", answers(study, results, common)),
            ("thresholds", thresholds(study, results, common)),
            ("population", population(study, results, common)),
        ],
        Measure::Proportions => vec![("shares", shares(study))],
        Measure::Sensitivity => Vec::new(),
        Measure::Settings(dial) => vec![("settings", settings(study, dial))],
        Measure::Scale => {
            let tables = |found| [("comparisons", comparisons(study, found)), ("scale", scale(study, found))];
            results.comparisons.iter().flat_map(tables).collect()
        }
    };
    if study.asked.has_catches() {
        all.push(("detection", detection(study)));
    }
    if !results.differences.is_empty() {
        all.push(("differences", differences(study, results)));
    }
    all
}

/// Begins a table with the levels of the factors in the condition of each row.
fn with_levels<'a, R>(study: &TaskStudy, rows: Rows<'a, R>, condition: impl Fn(&'a R) -> usize) -> Rows<'a, R> {
    let names = study.asked.factors.iter().map(|factor| &factor.name);
    rows.levels(names, |row, factor| study.cell(condition(row), factor))
}

/// Begins a table with the participant of each row, given by index.
fn with_people<'a, R>(study: &TaskStudy, rows: &'a [R], person: impl Fn(&'a R) -> usize) -> Rows<'a, R> {
    Rows::new(rows).column("subject_id", "Participant.", |row| study.people[person(row)].as_str())
}

/// Begins a table of what follows from the answers of each person in each condition.
fn of_people<'a, T>(study: &TaskStudy, rows: &'a [OfPerson<T>]) -> Rows<'a, OfPerson<T>> {
    with_levels(study, with_people(study, rows, |own| own.person), |own| own.condition)
}

fn answers(study: &TaskStudy, results: &TaskResults, common: &Common) -> Table {
    let all = results.functions.iter();
    let rows: Vec<(&PersonFunction, &Point)> =
        all.flat_map(|function| function.targets().map(move |point| (function, point))).collect();
    with_levels(study, with_people(study, &rows, |(own, _)| own.person), |(own, _)| own.condition)
        .column("level", "Level of the adapted parameter.", |(_, point)| common.level(point.x))
        .column("correct", "Number of correct answers, or of yes answers.", |(_, point)| point.correct)
        .column("total", "Number of trials with a target.", |(_, point)| point.total)
        .table()
}

fn thresholds(study: &TaskStudy, results: &TaskResults, common: &Common) -> Table {
    const THRESHOLD: &str = "Level with F = 1/2; empty if the most probable one lies outside the interval and, with the \
                             values up to `lapse`, if no function describes the answers.";
    const SLOPE: &str = "Slope of the psychometric function at the threshold; empty if the most probable one lies outside the interval and, \
                         with its interval, if the function rises within twice the distance of two levels.";
    const OVERDISPERSION: &str = "By how much blocks of trials vary more than binomially, 0 to 1; 0 for single trials.";
    const BEYOND: &str = "1 if the most probable threshold lies beyond the levels, where only the prior places it.";
    with_levels(study, with_people(study, &results.functions, |own| own.person), |own| own.condition)
        .column("trials", "Number of trials with a target.", |own| own.trials())
        .column("threshold", THRESHOLD, |own| Some(common.level(own.described()?.determined_threshold()?)))
        .interval("threshold", "its 95 % interval", |own| Some(own.described()?.threshold.map(|end| common.level(end))))
        .column("slope", SLOPE, |own| own.described()?.determined_slope())
        .in_unit("per unit of the scale of the levels", 1)
        .interval("slope", "its 95 % interval", |own| own.described()?.determined_slopes())
        .column("guess", "Guess rate.", |own| Some(own.described()?.estimate.guess))
        .column("lapse", "Lapse rate.", |own| Some(own.described()?.estimate.lapse))
        .column("overdispersion", OVERDISPERSION, |own| Some(own.described()?.estimate.overdispersion))
        .column("is_beyond", BEYOND, |own| u64::from(own.is_beyond()))
        .column("deviance", "Deviance of the best function.", |own| Some(own.goodness?.deviance))
        .column("p", "Proportion of simulated studies with at least this deviance.", |own| Some(own.goodness?.p))
        .table()
}

fn population(study: &TaskStudy, results: &TaskResults, common: &Common) -> Table {
    let scaled = |(_, own): &(usize, Population)| Some(own.interval?.map(|end| common.level(end)));
    let mean = "Mean threshold of people, on the scale of the levels.";
    with_levels(study, Rows::new(&results.populations), |(condition, _)| *condition)
        .column("people", "Number of participants.", |(_, own)| own.contributions.len())
        .column("threshold", mean, |(_, own)| common.level(own.function.threshold))
        .interval("threshold", "its 95 % interval", scaled)
        .column("sd", "Standard deviation of people's thresholds.", |(_, own)| own.sd)
        .column("function_width", "Distance of the levels with F = .05 and F = .95.", |(_, own)| own.function.width)
        .in_unit("scale of the levels", 2)
        .column("guess", "Common guess rate.", |(_, own)| own.function.guess)
        .column("lapse", "Common lapse rate.", |(_, own)| own.function.lapse)
        .table()
}

fn shares(study: &TaskStudy) -> Table {
    of_people(study, &study.shares())
        .column("correct", "Number of correct answers.", |own| own.found[0])
        .column("total", "Number of trials.", |own| own.found[1])
        .table()
}

fn detection(study: &TaskStudy) -> Table {
    of_people(study, &study.detection())
        .column("hits", "Targets answered yes.", |own| own.found.0.hits)
        .column("misses", "Targets answered no.", |own| own.found.0.misses)
        .column("false_alarms", "Catch trials answered yes.", |own| own.found.0.false_alarms)
        .column("correct_rejections", "Catch trials answered no.", |own| own.found.0.correct_rejections)
        .column("d_prime", "Sensitivity, with the log-linear correction.", |own| Some(own.found.1?.d_prime))
        .column("criterion", "Criterion c.", |own| Some(own.found.1?.criterion))
        .table()
}

/// Describes a column with the levels of a condition, and returns them.
const LEVELS: &str = "Levels of the condition.";

fn levels(study: &TaskStudy, condition: usize) -> String {
    let levels = (0..study.asked.factors.len()).map(|factor| study.cell(condition, factor).to_string());
    levels.collect::<Vec<_>>().join(", ")
}

fn differences(study: &TaskStudy, results: &TaskResults) -> Table {
    let estimand = study.asked.estimand();
    let scaled = |value: f64| if estimand.log { f64::powf(10.0, value) } else { value };
    let what = if estimand.log { "Ratio of the first to the second." } else { "The first minus the second." };
    Rows::new(&results.differences)
        .column("first", LEVELS, |found| levels(study, found.conditions[0]))
        .column("second", LEVELS, |found| levels(study, found.conditions[1]))
        .column("people", "Number of participants who have both.", |found| found.mean.people)
        .column(if estimand.log { "ratio" } else { "difference" }, what, |found| scaled(found.mean.mean))
        .interval("ci", "its 95 % interval", |found| Some(found.mean.interval?.map(scaled)))
        .column("p", "p of the t test, with Holm’s correction for all pairs.", |found| found.p)
        .table()
}

/// Returns how often each person chose each condition over each other.
fn comparisons(study: &TaskStudy, found: &Comparisons) -> Table {
    let of_person = |(person, wins): (usize, &Wins)| {
        let pairs = (0..wins.nrows()).flat_map(|winner| (0..wins.ncols()).map(move |loser| (winner, loser)));
        pairs.map(|pair| (person, pair, wins[pair] as u64)).filter(|(.., count)| *count > 0).collect::<Vec<_>>()
    };
    let rows: Vec<(usize, (usize, usize), u64)> = found.people.iter().enumerate().flat_map(of_person).collect();
    with_people(study, &rows, |(person, ..)| *person)
        .column("winner", LEVELS, |(_, (winner, _), _)| levels(study, *winner))
        .column("loser", LEVELS, |(_, (_, loser), _)| levels(study, *loser))
        .column("count", "How often it was chosen over the other.", |(.., count)| *count)
        .table()
}

/// A row of a scale: a person, if it is not that of all people, the condition, its value by either model, and its group.
type OfScale = (Option<usize>, usize, [f64; 2], Option<usize>);

/// Returns the scale of all people and, if there are several, each person's own.
fn scale(study: &TaskStudy, found: &Comparisons) -> Table {
    const THURSTONE: &str =
        "Scale value of Thurstone's Case V. A weak prior limits that of conditions that were always or never chosen.";
    let own = found.own.iter().enumerate().filter(|_| found.own.len() > 1);
    let own = own.filter_map(|(person, scales)| Some((Some(person), scales.as_ref()?)));
    let mut rows: Vec<OfScale> = Vec::new();
    for (person, [thurstone, bradley_terry]) in std::iter::once((None, &found.scales)).chain(own) {
        for item in 0..study.asked.conditions.len() {
            let group = thurstone.groups.iter().position(|group| group.contains(&item)).map(|group| group + 1);
            let values = [thurstone, bradley_terry].map(|scale| scale.values[item]);
            rows.extend((person.is_none() || group.is_some()).then_some((person, item, values, group)));
        }
    }
    let interval = |(person, item, ..): &OfScale| found.interval(*item).filter(|_| person.is_none());
    with_levels(study, Rows::new(&rows), |(_, item, ..)| *item)
        .column("thurstone", THURSTONE, |(_, _, [value, _], _)| *value)
        .column("low", "Lower end of its 95 % interval over people.", |row| Some(interval(row)?.low))
        .column("high", "Upper end of its 95 % interval over people.", |row| Some(interval(row)?.high))
        .column("bradley_terry", "Scale value of the model of Bradley and Terry.", |(_, _, [_, value], _)| *value)
        .in_unit("JND", 4)
        .column("group", "Only values of the same group can be compared.", |(.., group)| *group)
        .column("subject_id", "Participant; empty for the scale of all.", |(person, ..)| {
            person.map(|person| study.people[person].as_str())
        })
        .table()
}

fn settings(study: &TaskStudy, dial: &Dial) -> Table {
    let direction =
        "Mean of settings that began in the upper half of the range minus that of those that began in the lower half.";
    of_people(study, &study.settings())
        .column("n", "Number of settings.", |own| own.found.n)
        .column("mean", "Mean of the settings.", |own| own.found.mean)
        .column("sd", "Standard deviation of the settings.", |own| own.found.sd)
        .column("direction", direction, |own| own.found.direction)
        .in_unit(if dial.log { "log10 of the value" } else { "" }, 3)
        .table()
}
