//! Sections about thresholds, detection, comparisons and settings.

use super::{
    results::{Comparisons, PersonFunction, TaskResults, proportion},
    study::{Levels, Measure, OfPerson, TaskStudy, scaled},
};
use crate::{
    analysis::{comparisons::Scale, tasks::psychometric::Fit},
    experiment::task::{Common, Dial},
    report::{
        document::{Section, TableOf, fixed, probability, range, unit, whole},
        figures::Figure,
    },
};

/// What groups of conditions mean that were never compared.
pub(super) const APART: &str = "No comparison leads from one group of conditions to another, so each has a scale of its own, and their values cannot be compared.";

/// Says which conditions are highest and lowest on the scale, and how far they are apart.
pub(super) fn order(study: &TaskStudy, found: &Comparisons) -> Vec<String> {
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
        let may = match group.iter().all(|item| found.interval(*item).is_some_and(|interval| interval.contains(0.0))) {
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

/// Returns the sections about what was measured.
pub(super) fn of_results(study: &TaskStudy, results: &TaskResults, figures: &[Figure]) -> Vec<Section> {
    let measured = match &study.asked.measure {
        Measure::Thresholds(Levels { common, .. }) => Some(thresholds(study, results, figures, common)),
        Measure::Proportions => Some(shares(study)),
        Measure::Sensitivity => None,
        Measure::Settings(dial) => Some(settings(study, dial)),
        Measure::Scale => results.comparisons.as_ref().map(|found| comparisons(study, found, figures)),
    };
    measured.into_iter().chain(study.asked.has_catches().then(|| detection(study))).collect()
}

fn thresholds(study: &TaskStudy, results: &TaskResults, figures: &[Figure], common: &Common) -> Section {
    let mut section = Section::new("thresholds", "Thresholds");
    section.figures(figures, &["psychometric", "thresholds"]);
    let level = |own: &PersonFunction| scaled(common.log, own.described().map(|fit| fit.threshold));
    let slopes = |own: &PersonFunction| own.described().and_then(Fit::determined_slopes);
    let slope = |own: &PersonFunction| scaled(false, slopes(own));
    TableOf::new("The psychometric function of each participant", &results.functions)
        .text("Participant", |own| &study.people[own.person])
        .text("Condition", |own| study.name(own.condition))
        .number("Trials", |own| whole(own.trials()))
        .number("Threshold", |own| own.threshold().map_or_else(|| fixed(None, 0), level(own)))
        .number("95\u{a0}% interval", |own| range(own.described().map(|fit| fit.threshold), level(own)))
        .number("Slope", |own| {
            own.described().and_then(Fit::determined_slope).map_or_else(|| fixed(None, 0), slope(own))
        })
        .number("95\u{a0}% interval of the slope", |own| range(slopes(own), slope(own)))
        .number("Guess rate", |own| unit(own.described().map(|fit| fit.estimate.guess)))
        .number("Lapse rate", |own| unit(own.described().map(|fit| fit.estimate.lapse)))
        .number("p of the fit", |own| probability(own.goodness.map(|goodness| goodness.p)))
        .add_to(&mut section);
    for (condition, _) in results.populations.iter().filter(|(_, population)| population.interval.is_none()) {
        section.warning(format!(
            "The mean threshold{} has no interval: the functions of all participants rise between the same two levels, or their thresholds \
             are the same. It is not compared with others.",
            study.at(*condition)
        ));
    }
    section.note(
        "A threshold or slope is left out if its most probable value lies outside its interval, or a threshold beyond the levels: the answers \
         do not determine it. So is a slope if the function rises within twice the distance of two levels. Where an interval reaches beyond the levels, only the prior limits it. If p of the fit is small, answers vary \
         more than a psychometric function allows.",
    );
    let failed = |own: &PersonFunction| Some(format!("{}: {}", of(study, own), own.estimate.as_ref().err()?));
    section.list(results.functions.iter().filter_map(failed).collect());
    section
}

/// Names a participant, and the condition if there are several.
pub(super) fn of(study: &TaskStudy, function: &PersonFunction) -> String {
    format!("{}{}", study.people[function.person], study.at(function.condition))
}

/// Begins a table of the participants and the conditions.
fn begun<'a, T>(study: &TaskStudy, caption: impl Into<String>, rows: &'a [OfPerson<T>]) -> TableOf<'a, OfPerson<T>> {
    TableOf::new(caption, rows)
        .text("Participant", |own| &study.people[own.person])
        .text("Condition", |own| study.name(own.condition))
}

fn shares(study: &TaskStudy) -> Section {
    let mut section = Section::new("shares", "Correct answers");
    begun(study, "Correct answers of each participant", &study.shares())
        .number("Trials", |own| whole(own.found[1].into()))
        .number("Correct", |own| whole(own.found[0].into()))
        .number("Proportion", |own| unit(proportion(&own.found)))
        .add_to(&mut section);
    section
}

fn detection(study: &TaskStudy) -> Section {
    let mut section = Section::new("detection", "Detection");
    section.text(if study.asked.levels().is_some() {
        "The levels of the targets differ, so there is no d’ and no criterion over all of them: they would describe how the levels were \
         chosen, not any stimulus. The false alarms are those of catch trials."
    } else {
        "d’ is the distance between targets and catch trials in standard deviations of the noise; c is the criterion, above 0 if yes is said \
         less readily than by an unbiased observer. Half an answer is added to each count (Hautus 1995), so that proportions of 0 and 1 stay \
         finite; with few trials, this pulls d’ toward 0."
    });
    begun(study, "Detection by each participant", &study.detection())
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
    TableOf::new("Scale values in JND, highest first", &found.order().concat())
        .text("Condition", |item| study.name(*item))
        .number("Comparisons", |item| whole((won(*item) + lost(*item)) as u64))
        .number("Chosen", |item| whole(won(*item) as u64))
        .number("Thurstone", |item| fixed(thurstone.values[*item], 2))
        .number("95 % interval", |item| range(found.interval(*item), |end| fixed(end, 2)))
        .number("Bradley–Terry", |item| fixed(bradley_terry.values[*item], 2))
        .add_to(&mut section);
    section.text(if found.drawn.is_some() {
        "Intervals are those of the mean of a population like this sample: their standard error comes from 1,000 studies whose people are \
         drawn with replacement, and their width from the t distribution. They are at least as wide as if one participant had made all \
         comparisons."
    } else {
        "There are no intervals: they need at least two participants, and with fewer than five, each participant’s own comparisons must \
         determine a scale."
    });
    let span = |own: &Option<[Scale; 2]>| {
        let own = own.as_ref().map(|[own, _]| own).filter(|own| !own.is_limited)?;
        own.groups.iter().map(|group| own.span(group)).reduce(f64::max)
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
         undecided. A span that only a weak prior limits is left out.",
    );
    section
}

fn settings(study: &TaskStudy, dial: &Dial) -> Section {
    let all = study.settings();
    let is_slider = dial.parameter.is_none();
    let (heading, of_each) = if is_slider { ("Ratings", "ratings") } else { ("Settings", "settings") };
    let mut section = Section::new("settings", heading);
    let has_start = all.iter().any(|own| own.found.direction.is_some());
    let plain = |value: Option<f64>| value.map_or_else(|| fixed(None, 0), scaled(false, None));
    let mut table = begun(study, format!("The {of_each} of each participant"), &all)
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
