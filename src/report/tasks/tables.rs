//! The results of a task as tables.

use super::{
    asked::Levels,
    results::{Comparisons, OfPerson, TaskResults},
    study::TaskStudy,
};
use crate::{
    analysis::{detection::Detection, settings::Settings, tasks::psychometric::Fit},
    experiment::task::Common,
    report::tables::with_factors,
    statistics::Interval,
    text::{Cell, Column, Table},
};

/// Returns the tables by the names of their files.
#[must_use]
pub fn tables(study: &TaskStudy, results: &TaskResults) -> Vec<(&'static str, Table)> {
    let mut all = Vec::new();
    if let Some(Levels { common, .. }) = &study.asked.levels
        && !results.functions.is_empty()
    {
        all.push(("answers", answers(study, results, common)));
        all.push(("thresholds", thresholds(study, results, common)));
        all.push(("population", population(study, results, common)));
    }
    if !results.shares.is_empty() {
        all.push(("shares", shares(study, results)));
    }
    if !results.detection.is_empty() {
        all.push(("detection", detection(study, results)));
    }
    if let Some(found) = &results.comparisons {
        all.extend([("comparisons", comparisons(study, found)), ("scale", scale(study, found))]);
    }
    if !results.settings.is_empty() {
        all.push(("settings", settings(study, results)));
    }
    all
}

fn columns(study: &TaskStudy, first: &[(&str, &str)], last: &[(&str, &str, &str)]) -> Vec<Column> {
    let first = first.iter().map(|(name, text)| Column::new(*name, "", *text)).collect();
    let factors = study.asked.factors.iter().map(|factor| factor.name.clone()).collect();
    with_factors(first, factors, last.iter().map(|(name, unit, text)| Column::new(*name, unit, *text)).collect())
}

const PERSON: (&str, &str) = ("subject_id", "Participant.");

fn answers(study: &TaskStudy, results: &TaskResults, common: &Common) -> Table {
    let last = [
        ("level", "", "Level of the adapted parameter."),
        ("correct", "", "Number of correct answers, or of yes answers."),
        ("total", "", "Number of trials with a target."),
    ];
    let rows = results.functions.iter().flat_map(|function| {
        function.targets().map(|point| {
            let person = std::iter::once(Cell::from(study.people[function.person].as_str()));
            let numbers =
                [Cell::from(common.level(point.x)), u64::from(point.correct).into(), u64::from(point.total).into()];
            person.chain(study.cells(function.condition)).chain(numbers).collect()
        })
    });
    Table::new(columns(study, &[PERSON], &last), rows)
}

/// Returns the ends of an interval on the scale of the levels.
fn ends(common: &Common, interval: Option<Interval>) -> [Cell; 2] {
    let of = |end: fn(Interval) -> f64| interval.map(|interval| common.level(end(interval))).into();
    [of(|interval| interval.low), of(|interval| interval.high)]
}

fn thresholds(study: &TaskStudy, results: &TaskResults, common: &Common) -> Table {
    let last = [
        ("trials", "", "Number of trials with a target."),
        (
            "threshold",
            "",
            "Level with F = 1/2; empty if the most probable one lies outside the interval and, with the values up to `lapse`, if no function describes the answers.",
        ),
        ("threshold_low", "", "Lower end of its 95 % interval."),
        ("threshold_high", "", "Upper end of its 95 % interval."),
        (
            "slope",
            "per unit of the scale of the levels",
            "Slope of the psychometric function at the threshold; empty if the most probable one lies outside the interval.",
        ),
        ("slope_low", "", "Lower end of its 95 % interval."),
        ("slope_high", "", "Upper end of its 95 % interval."),
        ("guess", "", "Guess rate."),
        ("lapse", "", "Lapse rate."),
        ("overdispersion", "", "By how much blocks of trials vary more than binomially, 0 to 1; 0 for single trials."),
        ("is_beyond", "", "1 if the most probable threshold lies beyond the levels, where only the prior places it."),
        ("deviance", "", "Deviance of the best function."),
        ("p", "", "Proportion of simulated studies with at least this deviance."),
    ];
    let rows = results.functions.iter().map(|function| {
        let fit = function.described();
        let mut row = vec![Cell::from(study.people[function.person].as_str())];
        row.extend(study.cells(function.condition));
        row.push(function.trials().into());
        row.push(fit.and_then(Fit::determined_threshold).map(|threshold| common.level(threshold)).into());
        row.extend(ends(common, fit.map(|fit| fit.threshold)));
        let slope = fit.map(|fit| fit.slope_interval);
        row.extend(
            [fit.and_then(Fit::determined_slope), slope.map(|slope| slope.low), slope.map(|slope| slope.high)]
                .map(Cell::from),
        );
        let shares = fit.map(|Fit { estimate, .. }| [estimate.guess, estimate.lapse, estimate.overdispersion]);
        row.extend([0, 1, 2].map(|place| Cell::from(shares.map(|shares| shares[place]))));
        row.push(u64::from(fit.is_some() && function.beyond.is_some()).into());
        let goodness = function.goodness;
        row.extend([goodness.map(|goodness| goodness.deviance), goodness.map(|goodness| goodness.p)].map(Cell::from));
        row
    });
    Table::new(columns(study, &[PERSON], &last), rows)
}

fn population(study: &TaskStudy, results: &TaskResults, common: &Common) -> Table {
    let last = [
        ("people", "", "Number of participants."),
        ("threshold", "", "Mean threshold of people, on the scale of the levels."),
        ("threshold_low", "", "Lower end of its 95 % interval."),
        ("threshold_high", "", "Upper end of its 95 % interval."),
        ("sd", "scale of the levels", "Standard deviation of people's thresholds."),
        ("function_width", "scale of the levels", "Distance of the levels with F = .05 and F = .95."),
        ("guess", "", "Common guess rate."),
        ("lapse", "", "Common lapse rate."),
    ];
    let rows = results.populations.iter().map(|(condition, population)| {
        let mut row: Vec<Cell> = study.cells(*condition).collect();
        row.extend([(population.people.len() as u64).into(), common.level(population.mean).into()]);
        row.extend(ends(common, population.interval));
        row.extend([population.sd, population.width, population.guess, population.lapse].map(Cell::from));
        row
    });
    Table::new(columns(study, &[], &last), rows)
}

/// Begins a row with the participant and the levels of the condition.
fn begun<T>(study: &TaskStudy, own: &OfPerson<T>) -> Vec<Cell> {
    let person = std::iter::once(Cell::from(study.people[own.person].as_str()));
    person.chain(study.cells(own.condition)).collect()
}

fn shares(study: &TaskStudy, results: &TaskResults) -> Table {
    let last = [("correct", "", "Number of correct answers."), ("total", "", "Number of trials.")];
    let rows = results
        .shares
        .iter()
        .map(|own| begun(study, own).into_iter().chain(own.found.map(|count| Cell::from(u64::from(count)))).collect());
    Table::new(columns(study, &[PERSON], &last), rows)
}

fn detection(study: &TaskStudy, results: &TaskResults) -> Table {
    let last = [
        ("hits", "", "Targets answered yes."),
        ("misses", "", "Targets answered no."),
        ("false_alarms", "", "Catch trials answered yes."),
        ("correct_rejections", "", "Catch trials answered no."),
        ("d_prime", "", "Sensitivity, with the log-linear correction."),
        ("d_prime_se", "", "Its standard error."),
        ("criterion", "", "Criterion c."),
        ("criterion_se", "", "Its standard error."),
    ];
    let rows = results.detection.iter().zip(&results.sensitivity).map(|(own, OfPerson { found, .. })| {
        let counts = own.found.counts().map(|count| Cell::from(u64::from(count)));
        begun(study, own).into_iter().chain(counts).chain(Detection::numbers(*found).map(Cell::from)).collect()
    });
    Table::new(columns(study, &[PERSON], &last), rows)
}

/// Returns how often each person chose each condition over each other.
fn comparisons(study: &TaskStudy, found: &Comparisons) -> Table {
    let names = ["winner", "loser"].map(|name| Column::new(name, "", "Levels of the condition."));
    let count = Column::new("count", "", "How often it was chosen over the other.");
    let columns = [vec![Column::new(PERSON.0, "", PERSON.1)], names.to_vec(), vec![count]].concat();
    let rows = found.people.iter().zip(&study.people).flat_map(|(wins, person)| {
        let pairs = (0..wins.nrows()).flat_map(|i| (0..wins.ncols()).map(move |j| (i, j)));
        let compared = pairs.filter(|place| wins[*place] > 0.0);
        compared.map(|(i, j)| {
            let [winner, loser] = [i, j].map(|item| {
                let levels = study.asked.factors.iter().zip(&study.asked.conditions[item]);
                let levels = levels.map(|(factor, level)| factor.levels[*level].to_string());
                Cell::from(levels.collect::<Vec<_>>().join(", "))
            });
            vec![Cell::from(person.as_str()), winner, loser, (wins[(i, j)] as u64).into()]
        })
    });
    Table::new(columns, rows)
}

fn scale(study: &TaskStudy, found: &Comparisons) -> Table {
    let last = [
        ("thurstone", "JND", "Scale value of Thurstone's Case V, all people."),
        ("low", "JND", "Lower end of its 95 % interval over people."),
        ("high", "JND", "Upper end of its 95 % interval over people."),
        ("bradley_terry", "JND", "Scale value of the model of Bradley and Terry."),
        ("group", "", "Only values of the same group can be compared."),
    ];
    let [thurstone, bradley_terry] = &found.scales;
    let rows = (0..thurstone.values.len()).map(|item| {
        let mut row: Vec<Cell> = study.cells(item).collect();
        let interval = found.intervals.as_ref().map(|intervals| intervals[item]);
        row.push(thurstone.values[item].into());
        row.extend([interval.map(|interval| interval.low), interval.map(|interval| interval.high)].map(Cell::from));
        let group = thurstone.groups.iter().position(|group| group.contains(&item));
        row.extend([bradley_terry.values[item].into(), group.map(|group| group as u64 + 1).into()]);
        row
    });
    Table::new(columns(study, &[], &last), rows)
}

fn settings(study: &TaskStudy, results: &TaskResults) -> Table {
    let log = study.asked.dial.as_ref().is_some_and(|dial| dial.log);
    let unit = if log { "log10 of the value" } else { "" };
    let last = [
        ("n", "", "Number of settings."),
        ("mean", unit, "Mean of the settings."),
        ("sd", unit, "Standard deviation of the settings."),
        ("direction", unit, "Mean of those that began above minus that of those that began below."),
    ];
    let rows = results.settings.iter().map(|own| {
        let Settings { n, mean, sd, direction, .. } = own.found;
        let numbers = [(n as u64).into(), Cell::from(mean), sd.into(), direction.into()];
        begun(study, own).into_iter().chain(numbers).collect()
    });
    Table::new(columns(study, &[PERSON], &last), rows)
}
