//! Sections about detection, comparisons and settings.

use super::{
    results::{Comparisons, PersonAnswers, PersonSettings, PersonShare, TaskResults},
    study::TaskStudy,
};
use crate::{
    analysis::tasks::means::Mean,
    experiment::task::Dial,
    report::{
        document::{
            Section, Shown,
            numbers::{count, fixed, list, range, unit, whole},
        },
        figures::Figure,
    },
    statistics::Interval,
};

/// Returns the sentences of the summary.
pub(super) fn summary(study: &TaskStudy, results: &TaskResults) -> Vec<String> {
    let conditions = || 0..study.asked.conditions.len();
    let mut all: Vec<String> = conditions().filter_map(|condition| right(study, results, condition)).collect();
    all.extend(conditions().filter_map(|condition| sensitivity(study, results, condition)));
    all.extend(results.comparisons.iter().flat_map(|found| order(study, found)));
    if let Some(dial) = study.asked.dial.as_ref() {
        all.extend(conditions().filter_map(|condition| setting(study, results, dial, condition)));
        all.extend(direction(results, dial));
    }
    all
}

/// Averages one value of each person; `None` if there are none. No value can be outside `ends`, if there are any.
pub(super) fn over_people(values: &[f64], ends: Option<[f64; 2]>) -> Option<Mean> {
    (!values.is_empty()).then(|| ends.map_or_else(|| Mean::new(values), |ends| Mean::bounded(values, ends)))
}

/// Returns the ends of a dial, on the scale on which it counts.
pub(super) fn scaled_ends(dial: &Dial) -> [f64; 2] {
    dial.range.map(|end| if dial.log { end.log10() } else { end })
}

fn with_interval(value: &Shown, interval: Option<Interval>, format: impl Fn(f64) -> Shown) -> String {
    let interval = interval.map(|i| format!(" (95\u{a0}% interval {} to {})", format(i.low), format(i.high)));
    format!("{value}{}", interval.unwrap_or_default())
}

fn right(study: &TaskStudy, results: &TaskResults, condition: usize) -> Option<String> {
    let own = results.shares.iter().filter(|own| own.condition == condition);
    let found = over_people(&own.map(PersonShare::share).collect::<Vec<_>>(), Some([0.0, 1.0]))?;
    let value = with_interval(&unit(found.mean), found.interval, unit);
    let guess = unit(study.asked.guess);
    Some(format!(
        "The share of right answers{} is {value} on average over people; guessing gives {guess}.",
        study.at(condition)
    ))
}

fn sensitivity(study: &TaskStudy, results: &TaskResults, condition: usize) -> Option<String> {
    let own = results.detection.iter().filter(|own| own.condition == condition);
    let found = over_people(&own.filter_map(|own| Some(own.detection()?.d_prime)).collect::<Vec<_>>(), None)?;
    let two = |value: f64| fixed(value, 2);
    let value = with_interval(&two(found.mean), found.interval, two);
    Some(format!("The sensitivity d′{} is {value} on average over people.", study.at(condition)))
}

/// Says which conditions are highest and lowest on the scale, and whether neighbors differ by a JND.
fn order(study: &TaskStudy, found: &Comparisons) -> Vec<String> {
    let values = &found.scales[0].values;
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let names: Vec<String> = order.iter().map(|item| study.item(*item)).collect();
    let span = values[order[0]] - values[order[order.len() - 1]];
    let mut all = vec![format!(
        "From the highest to the lowest on the scale: {}. The ends are {} JND apart; conditions one JND apart are told apart in 75\u{a0}% of \
         comparisons.",
        list(&names),
        fixed(span, 1)
    )];
    if found.scales[0].is_limited {
        all.push(
            "Some conditions were always or never chosen over all others, so how far they lie from them is not known: a weak prior limits \
             the scale."
                .to_owned(),
        );
    }
    all
}

/// Formats a setting, which is a logarithm if the dial counts in ratios.
fn shown(dial: &Dial, value: f64) -> Shown {
    let value = if dial.log { f64::powf(10.0, value) } else { value };
    let decimals = (2.0 - value.abs().max(1e-12).log10().floor()).clamp(0.0, 8.0) as usize;
    fixed(value, decimals)
}

fn setting(study: &TaskStudy, results: &TaskResults, dial: &Dial, condition: usize) -> Option<String> {
    let own = results.settings.iter().filter(|own| own.condition == condition);
    let found = over_people(&own.map(|own| own.settings.mean).collect::<Vec<_>>(), Some(scaled_ends(dial)))?;
    let value = with_interval(&shown(dial, found.mean), found.interval, |end| shown(dial, end));
    let what = dial.parameter.as_deref().unwrap_or("the rating");
    let mean = if dial.log { "geometric mean" } else { "mean" };
    Some(format!("The {mean} of {what}{} is {value} over people.", study.at(condition)))
}

/// Says whether settings depend on where they began: one value of each person.
fn direction(results: &TaskResults, dial: &Dial) -> Option<String> {
    let people = results.settings.iter().map(|own| own.person).max()? + 1;
    let of_person = |person: usize| {
        let own = results.settings.iter().filter(|own| own.person == person);
        over_people(&own.filter_map(|own| own.settings.direction).collect::<Vec<_>>(), None).map(|own| own.mean)
    };
    let found = over_people(&(0..people).filter_map(of_person).collect::<Vec<_>>(), None)?;
    let interval = found.interval?;
    let format = |value: f64| if dial.log { fixed(f64::powf(10.0, value), 2) } else { fixed(value, 3) };
    let value = with_interval(&format(found.mean), Some(interval), format);
    let kind = if dial.log { "are a factor of" } else { "differ by" };
    let clear = interval.low > 0.0 || interval.high < 0.0;
    let verdict = if clear { "so the start matters" } else { "so it is not clear that the start matters" };
    let what = if dial.log { "those that began below" } else { "from those that began below" };
    Some(match dial.log {
        true => format!("Settings that began above {kind} {value} of {what}, {verdict}."),
        false => format!("Settings that began above {kind} {value} {what}, {verdict}."),
    })
}

/// Returns the sections for which there are data.
pub(super) fn sections(study: &TaskStudy, results: &TaskResults, figures: &[Figure]) -> Vec<Section> {
    let answered = (!results.shares.is_empty()).then(|| shares(study, results, figures));
    let detected = (!results.detection.is_empty()).then(|| detection(study, results, figures));
    let compared = results.comparisons.as_ref().map(|found| comparisons(study, found, figures));
    let set = study.asked.dial.as_ref().filter(|_| !results.settings.is_empty());
    let set = set.map(|dial| settings(study, results, dial, figures));
    answered.into_iter().chain(detected).chain(compared).chain(set).collect()
}

fn shares(study: &TaskStudy, results: &TaskResults, figures: &[Figure]) -> Section {
    let mut section = Section::new("shares", "Right answers");
    section.figures(figures, &["shares"]);
    let row = |own: &PersonShare| {
        let [right, all] = own.right.map(|count| whole(count.into()));
        vec![study.people[own.person].as_str().into(), study.name(own.condition).into(), all, right, unit(own.share())]
    };
    let rows = results.shares.iter().map(row).collect();
    section.table("Right answers of each person", &["Participant", "Condition"], &["Trials", "Right", "Share"], rows);
    section
}

fn detection(study: &TaskStudy, results: &TaskResults, figures: &[Figure]) -> Section {
    let mut section = Section::new("detection", "Detection");
    section.text(if results.detection.iter().any(|own| own.varied) {
        "The levels of the targets differ, so there is no d′ and no criterion over all of them: they would describe how the levels were \
         chosen, and no stimulus. The false alarms are those of catch trials."
    } else {
        "d′ is the distance between targets and catch trials in standard deviations of the noise, c the criterion: above 0 if yes is said \
         less readily than by an unbiased observer. Half an answer is added to each count (Hautus 1995), so that shares of 0 and 1 stay finite; \
         with few trials, this pulls d′ toward 0."
    });
    section.figures(figures, &["detection"]);
    let row = |own: &PersonAnswers| {
        let found = own.detection();
        let counts = [own.answers.hits, own.answers.misses, own.answers.false_alarms, own.answers.correct_rejections];
        let mut row = vec![study.people[own.person].as_str().into(), study.name(own.condition).into()];
        row.extend(counts.map(|count| whole(count.into())));
        row.extend(
            [found.map(|found| found.d_prime), found.map(|found| found.d_prime_se)].map(|value| fixed(value, 2)),
        );
        row.extend(
            [found.map(|found| found.criterion), found.map(|found| found.criterion_se)].map(|value| fixed(value, 2)),
        );
        row
    };
    let numbers = ["Hits", "Misses", "False alarms", "Correct rejections", "d′", "SE", "c", "SE"];
    let rows = results.detection.iter().map(row).collect();
    section.table("Detection by each person", &["Participant", "Condition"], &numbers, rows);
    section
}

fn comparisons(study: &TaskStudy, found: &Comparisons, figures: &[Figure]) -> Section {
    let mut section = Section::new("comparisons", "Comparisons");
    section.figures(figures, &["scale"]);
    let [thurstone, bradley_terry] = &found.scales;
    let mut order: Vec<usize> = (0..thurstone.values.len()).collect();
    order.sort_by(|a, b| thurstone.values[*b].total_cmp(&thurstone.values[*a]));
    let row = |item: &usize| {
        let won: f64 = found.people.iter().map(|wins| wins.row(*item).sum()).sum();
        let all: f64 = won + found.people.iter().map(|wins| wins.column(*item).sum()).sum::<f64>();
        vec![
            study.item(*item).as_str().into(),
            whole(all as u64),
            whole(won as u64),
            fixed(thurstone.values[*item], 2),
            range(found.intervals.as_ref().map(|intervals| intervals[*item]), |end| fixed(end, 2)),
            fixed(bradley_terry.values[*item], 2),
        ]
    };
    let numbers = ["Comparisons", "Chosen", "Thurstone", "95 % interval", "Bradley–Terry"];
    section.table("Scale values in JND, highest first", &["Condition"], &numbers, order.iter().map(row).collect());
    section.text(format!(
        "The log-likelihood is {} for Thurstone’s Case V and {} for the model of Bradley and Terry. Intervals are those of the mean of people \
         like these: the standard error of 1,000 studies whose people are drawn with replacement, and the t distribution.",
        fixed(thurstone.log_likelihood, 1),
        fixed(bradley_terry.log_likelihood, 1)
    ));
    let row = |((triads, own), person): ((&_, &Option<_>), &String)| {
        let triads: &crate::analysis::comparisons::Triads = triads;
        let own: Option<&crate::analysis::comparisons::Scale> = own.as_ref();
        let span = own.map(|own| {
            let ends = own.values.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
            ends.1 - ends.0
        });
        vec![person.as_str().into(), whole(triads.circular.into()), whole(triads.all.into()), fixed(span, 2)]
    };
    let rows = found.triads.iter().zip(&found.own).zip(&study.people).map(row).collect();
    let numbers = ["Circular triads", "Decided triads", "Span of the own scale (JND)"];
    section.table("Contradictions of each person", &["Participant"], &numbers, rows);
    section.note(
        "A triad is circular if a is chosen over b, b over c, and c over a. One in four is by chance; adaptive pairs leave many triads \
         undecided.",
    );
    section
}

fn settings(study: &TaskStudy, results: &TaskResults, dial: &Dial, figures: &[Figure]) -> Section {
    let mut section = Section::new("settings", "Settings");
    section.figures(figures, &["settings"]);
    let spread = |value: f64| fixed(value, 3);
    let row = |own: &PersonSettings| {
        vec![
            study.people[own.person].as_str().into(),
            study.name(own.condition).into(),
            whole(own.settings.n as u64),
            shown(dial, own.settings.mean),
            spread(own.settings.sd),
            own.settings.direction.map_or_else(|| fixed(None, 0), spread),
        ]
    };
    let numbers = ["Settings", "Mean", "SD", "Above − below"];
    let rows = results.settings.iter().map(row).collect();
    section.table("The settings of each person", &["Participant", "Condition"], &numbers, rows);
    if dial.log {
        section
            .note("Means are geometric; the standard deviation and the effect of the start are in decadic logarithms.");
    }
    let all = count(study.trials.len() as u64, "setting");
    section.note(format!("{all}. Each person counts once in the means over people."));
    section
}
