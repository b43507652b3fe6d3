//! Sections about detection, comparisons and settings.

use super::{
    results::{Comparisons, OfPerson, TaskResults},
    study::TaskStudy,
};
use crate::{
    analysis::{comparisons::Scale, tasks::population::Mean},
    experiment::task::{Dial, Measures},
    report::{
        document::{Section, Shown, TableOf, count, fixed, range, significant, unit, whole, with_interval},
        figures::Figure,
    },
    statistics::Interval,
};

/// Returns the sentences of the summary.
pub(super) fn summary(study: &TaskStudy, results: &TaskResults) -> Vec<String> {
    let (two, guess) =
        (|value: f64| fixed(value, 2), unit(study.asked.protocol.as_ref().and_then(|protocol| protocol.task.guess())));
    let shares = means(study, &results.shares, Some([0.0, 1.0]), |own| Some(proportion(own)), |_| unit);
    let of_share = |(at, mean)| format!("The proportion of correct answers{at} is {mean}; guessing gives {guess}.");
    let mut all: Vec<String> = shares.into_iter().map(of_share).collect();
    let sensitivity = means(study, &results.detection, None, |own| Some(own.1?.d_prime), |_| two).into_iter();
    all.extend(sensitivity.map(|(at, mean)| format!("The sensitivity d’{at} is {mean}.")));
    let has_none =
        |condition: &usize| !results.detection.iter().any(|own| own.condition == *condition && own.found.1.is_some());
    let is_wanted = study.asked.measures == Some(Measures::Detection) && study.asked.levels.is_none();
    let without = (0..study.asked.conditions.len()).filter(|condition| is_wanted && has_none(condition));
    all.extend(without.map(|condition| {
        format!("There is no d’{}, because no participant had both targets and catch trials.", study.at(condition))
    }));
    all.extend(results.comparisons.iter().flat_map(|found| order(study, found)));
    if let Some(dial) = study.asked.dial.as_ref() {
        let format = |interval| scaled(dial.log, interval);
        let (what, kind) = (set(study, dial), if dial.log { "geometric mean" } else { "mean" });
        let settings = means(study, &results.settings, Some(scaled_ends(dial)), |own| Some(own.mean), format);
        let of_setting = |(at, mean)| format!("The {kind} {what}{at} is {mean}.");
        all.extend(settings.into_iter().map(of_setting));
    }
    all
}

/// Returns how a level or a setting is written, which is a logarithm if the method or the dial counts in ratios: with three
/// significant digits, and more if its interval is narrow.
pub(super) fn scaled(log: bool, interval: Option<Interval>) -> impl Fn(f64) -> Shown {
    let of_scale = move |value: f64| if log { f64::powf(10.0, value) } else { value };
    let width = interval.map(|interval| of_scale(interval.high) - of_scale(interval.low));
    let width = width.filter(|width| *width > 0.0).unwrap_or(f64::INFINITY);
    move |value| {
        let value = of_scale(value);
        // On a linear scale, a value near 0 is as large as its error.
        let size = value.abs().max(if log || width.is_infinite() { 0.0 } else { width / 10.0 });
        significant(value, size, width.min(size))
    }
}

/// Averages one value of each person; `None` if there are none. No value can be outside `ends`, if there are any.
fn over_people(values: &[f64], ends: Option<[f64; 2]>) -> Option<Mean> {
    (!values.is_empty()).then(|| ends.map_or_else(|| Mean::new(values), |ends| Mean::bounded(values, ends)))
}

/// Returns ` at CONDITION`, and the mean over people of one value of each with its interval and their number.
fn means<T, F: Fn(f64) -> Shown>(
    study: &TaskStudy,
    all: &[OfPerson<T>],
    ends: Option<[f64; 2]>,
    value: impl Fn(&T) -> Option<f64>,
    format: impl Fn(Option<Interval>) -> F,
) -> Vec<(String, String)> {
    let of_condition = |condition: usize| {
        let own = all.iter().filter(|own| own.condition == condition);
        let found = over_people(&own.filter_map(|own| value(&own.found)).collect::<Vec<_>>(), ends)?;
        let format = format(found.interval);
        let over = match found.people {
            1 => " for 1 participant".to_owned(),
            people => format!(", averaged over {}", count(people as u64, "participant")),
        };
        let mean = format!("{}{}{over}", format(found.mean), with_interval(found.interval, &format));
        Some((study.at(condition), mean))
    };
    (0..study.asked.conditions.len()).filter_map(of_condition).collect()
}

/// Returns the proportion of correct answers.
fn proportion([right, all]: &[u32; 2]) -> f64 {
    f64::from(*right) / f64::from(*all)
}

/// Returns the ends of a dial, on the scale on which it counts.
fn scaled_ends(dial: &Dial) -> [f64; 2] {
    dial.range.map(|end| if dial.log { end.log10() } else { end })
}

/// Names what participants set: `setting of nulling`, or `rating`.
fn set(study: &TaskStudy, dial: &Dial) -> String {
    dial.parameter
        .as_ref()
        .map_or_else(|| "rating".to_owned(), |name| format!("setting of {}", study.asked.factor(name)))
}

/// What groups of conditions mean that were never compared.
pub(super) const APART: &str = "No comparison leads from one group of conditions to another, so each has a scale of its own, and their values cannot be compared.";

/// Says which conditions are highest and lowest on the scale, and how far they are apart.
fn order(study: &TaskStudy, found: &Comparisons) -> Vec<String> {
    let (scale, order) = (&found.scales[0], found.order());
    let names =
        |items: &mut dyn Iterator<Item = usize>| items.map(|item| study.name(item)).collect::<Vec<_>>().join("; ");
    let of_group = |group: &Vec<usize>| {
        // A weak prior decides how far those are away that were always or never chosen.
        let span = if scale.is_limited {
            String::new()
        } else {
            format!(" The ends are {} JND apart.", fixed(scale.span(group), 1))
        };
        // Then all conditions may be alike.
        let is_open = |intervals: &Vec<Interval>| group.iter().all(|item| intervals[*item].contains(0.0));
        let may = match found.intervals.as_ref().is_some_and(is_open) {
            true => " All intervals include 0, the mean of the scale, so this order may be chance.",
            false => "",
        };
        let items = names(&mut group.iter().copied());
        format!("From the highest to the lowest on the scale: {items}.{may}{span}")
    };
    let mut all: Vec<String> = order.iter().map(of_group).collect();
    all.push("Conditions one JND apart are told apart in 75\u{a0}% of comparisons.".to_owned());
    if order.len() > 1 {
        all.push(APART.to_owned());
    }
    let alone = names(&mut (0..scale.values.len()).filter(|item| scale.values[*item].is_nan()));
    if !alone.is_empty() {
        all.push(format!("Compared with no other condition, and so without a place on the scale: {alone}."));
    }
    if scale.is_limited {
        all.push(
            "Some conditions were always or never chosen over all others, so how far they lie from them is not known: a weak prior limits \
             the scale."
                .to_owned(),
        );
    }
    all
}

/// Returns the sections for which there are data.
pub(super) fn sections(study: &TaskStudy, results: &TaskResults, figures: &[Figure]) -> Vec<Section> {
    let dial = study.asked.dial.as_ref().filter(|_| !results.settings.is_empty());
    let all = [
        (!results.shares.is_empty()).then(|| shares(study, results)),
        (!results.detection.is_empty()).then(|| detection(study, results)),
        results.comparisons.as_ref().map(|found| comparisons(study, found, figures)),
        dial.map(|dial| settings(study, results, dial)),
    ];
    all.into_iter().flatten().collect()
}

/// Begins a table of the participants and the conditions.
fn begun<'a, T>(study: &TaskStudy, caption: impl Into<String>, rows: &'a [OfPerson<T>]) -> TableOf<'a, OfPerson<T>> {
    TableOf::new(caption, rows)
        .text("Participant", |own| &study.people[own.person])
        .text("Condition", |own| study.name(own.condition))
}

fn shares(study: &TaskStudy, results: &TaskResults) -> Section {
    let mut section = Section::new("shares", "Correct answers");
    begun(study, "Correct answers of each participant", &results.shares)
        .number("Trials", |own| whole(own.found[1].into()))
        .number("Correct", |own| whole(own.found[0].into()))
        .number("Proportion", |own| unit(proportion(&own.found)))
        .add_to(&mut section);
    section
}

fn detection(study: &TaskStudy, results: &TaskResults) -> Section {
    let mut section = Section::new("detection", "Detection");
    section.text(if study.asked.levels.is_some() {
        "The levels of the targets differ, so there is no d’ and no criterion over all of them: they would describe how the levels were \
         chosen, not any stimulus. The false alarms are those of catch trials."
    } else {
        "d’ is the distance between targets and catch trials in standard deviations of the noise; c is the criterion, above 0 if yes is said \
         less readily than by an unbiased observer. Half an answer is added to each count (Hautus 1995), so that proportions of 0 and 1 stay \
         finite; with few trials, this pulls d’ toward 0."
    });
    begun(study, "Detection by each participant", &results.detection)
        .number("Hits", |own| whole(own.found.0.hits.into()))
        .number("Misses", |own| whole(own.found.0.misses.into()))
        .number("False alarms", |own| whole(own.found.0.false_alarms.into()))
        .number("Correct rejections", |own| whole(own.found.0.correct_rejections.into()))
        .number("d’", |own| fixed(own.found.1.map(|found| found.d_prime), 2))
        .number("c", |own| fixed(own.found.1.map(|found| found.criterion), 2))
        .add_to(&mut section);
    section
}

fn comparisons(study: &TaskStudy, found: &Comparisons, figures: &[Figure]) -> Section {
    let mut section = Section::new("comparisons", "Comparisons");
    section.figures(figures, &["scale"]);
    let [thurstone, bradley_terry] = &found.scales;
    let won = |item: usize| found.people.iter().map(|wins| wins.row(item).sum()).sum::<f64>();
    let lost = |item: usize| found.people.iter().map(|wins| wins.column(item).sum()).sum::<f64>();
    let interval = |item: usize| found.intervals.as_ref().map(|intervals| intervals[item]);
    TableOf::new("Scale values in JND, highest first", &found.order().concat())
        .text("Condition", |item| study.name(*item))
        .number("Comparisons", |item| whole((won(*item) + lost(*item)) as u64))
        .number("Chosen", |item| whole(won(*item) as u64))
        .number("Thurstone", |item| fixed(thurstone.values[*item], 2))
        .number("95 % interval", |item| range(interval(*item), |end| fixed(end, 2)))
        .number("Bradley–Terry", |item| fixed(bradley_terry.values[*item], 2))
        .add_to(&mut section);
    section.text(if found.intervals.is_some() {
        "Intervals are those of the mean of a population like this sample: their standard error comes from 1,000 studies whose people are \
         drawn with replacement, and their width from the t distribution. They are at least as wide as if one participant had made all \
         comparisons."
    } else {
        "There are no intervals: they need at least two participants, and with fewer than five, each participant’s own comparisons must \
         determine a scale."
    });
    let span = |own: &Option<[Scale; 2]>| {
        own.as_ref().and_then(|[own, _]| own.groups.iter().map(|group| own.span(group)).reduce(f64::max))
    };
    let rows: Vec<_> = study.people.iter().zip(&found.triads).zip(&found.own).collect();
    TableOf::new("Contradictions of each participant", &rows)
        .text("Participant", |((person, _), _)| *person)
        .number("Circular triads", |((_, triads), _)| whole(triads.circular.into()))
        .number("Decided triads", |((_, triads), _)| whole(triads.all.into()))
        .number("Span of the participant’s own scale (JND)", |(_, own)| fixed(span(own), 2))
        .add_to(&mut section);
    section.note(
        "A triad is circular if a is chosen over b, b over c, and c over a. By chance, one in four would be; adaptive pairs leave many triads \
         undecided.",
    );
    section
}

fn settings(study: &TaskStudy, results: &TaskResults, dial: &Dial) -> Section {
    let is_rating = study.asked.is_slider();
    let (heading, of_each) = if is_rating { ("Ratings", "ratings") } else { ("Settings", "settings") };
    let mut section = Section::new("settings", heading);
    let has_start = results.settings.iter().any(|own| own.found.direction.is_some());
    let plain = |value: Option<f64>| value.map_or_else(|| fixed(None, 0), scaled(false, None));
    let mut table = begun(study, format!("The {of_each} of each participant"), &results.settings)
        .number(heading, |own| whole(own.found.n as u64))
        .number("Mean", |own| scaled(dial.log, None)(own.found.mean))
        .number("SD", |own| plain(own.found.sd));
    if has_start {
        table = table.number("Effect of the start", |own| plain(own.found.direction));
    }
    table.add_to(&mut section);
    if has_start {
        section.note("The effect of the start is the mean of settings that began in the upper half of the range minus that of the others.");
    }
    if dial.log {
        section
            .note("Means are geometric; the standard deviation and the effect of the start are in base-10 logarithms.");
    }
    section.note("Each participant counts once in the means over participants.");
    section
}
