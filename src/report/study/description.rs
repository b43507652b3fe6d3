//! The sections about the design, the ratings as they are, agreement, and the response times.

use super::{
    health,
    names::{self, participant},
};
use crate::{
    analysis::{
        Results,
        counts::{Factor, Quartiles},
        summary::Group,
    },
    report::{
        document::{Section, Shown, TableOf, count, fixed, mean, range, unit, whole, with_interval},
        figures::Figure,
    },
    store::ratings::Source,
};

/// Describes the design: what was varied, and how much was completed.
pub(super) fn design(source: &Source, results: &Results) -> Section {
    let mut section = Section::new("design", "Design");
    if let Some((first, last)) = health::days(source, results) {
        section.text(if first == last {
            format!("Sessions took place on {first}.")
        } else {
            format!("Sessions took place from {first} to {last}.")
        });
    }
    factors(&mut section, source, results);
    done(&mut section, results);
    section
}

fn factors(section: &mut Section, source: &Source, results: &Results) {
    let planned = |name: &str| {
        let factor = source.protocol.as_ref()?.factors.iter().find(|factor| factor.name == name)?;
        Some(factor.levels.len() as f64)
    };
    let factors = &results.measured.counts.factors;
    if factors.is_empty() {
        section.text("No factor was varied, so all ratings belong to one condition.");
        return;
    }
    let levels = |factor: &Factor| {
        let levels = factor.levels.iter().map(|level| names::level(results, &factor.name, level).to_string());
        levels.collect::<Vec<_>>().join(", ")
    };
    TableOf::new("Factors and their levels", factors)
        .text("Factor", |factor| names::factor(results, &factor.name))
        .text("Levels rated", levels)
        .number("Number", |factor| whole(factor.levels.len() as u64))
        .number("Planned", |factor| fixed(planned(&factor.name), 0))
        .add_to(section);
}

/// Describes the conditions, and how many ratings there are.
fn done(section: &mut Section, results: &Results) {
    let counts = &results.measured.counts;
    let possible: usize = counts.factors.iter().map(|factor| factor.levels.len()).product();
    let found = counts.complete_conditions();
    // Ratings without a level of some factor belong to no condition.
    let conditions = results.cells.iter().filter(|cell| cell.names.iter().all(|level| !level.is_empty()));
    let outside = counts.total() - conditions.clone().map(|cell| cell.summary.n).sum::<u64>();
    if let Some((least, most)) = least_and_most(conditions) {
        let of = if found < possible as u64 {
            format!(" out of {} possible combinations of these levels", whole(possible as u64))
        } else {
            String::new()
        };
        let each = if least == most {
            format!("each has {}", count(least, "rating"))
        } else {
            format!("they have {} to {} ratings each", whole(least), whole(most))
        };
        section.text(format!("There are ratings for {}{of}; {each}.", count(found, "condition")));
    }
    if outside > 0 {
        let lack =
            if outside == 1 { "lacks a level of a factor and belongs" } else { "lack a level of a factor and belong" };
        section.text(format!("{} {lack} to no condition.", count(outside, "rating")));
    }
    if let Some((least, most)) = least_and_most(results.subjects.iter().map(|subject| &subject.group))
        && least < most
    {
        section.text(format!("Each participant has {} to {} ratings.", whole(least), whole(most)));
    }
}

/// Returns the smallest and the largest number of ratings.
fn least_and_most<'a>(groups: impl Iterator<Item = &'a Group> + Clone) -> Option<(u64, u64)> {
    let ns = groups.map(|group| group.summary.n);
    Some((ns.clone().min()?, ns.max()?))
}

/// Lists descriptive statistics by factor, condition and participant.
pub(super) fn section(results: &Results, figures: &[Figure]) -> Section {
    let mut section = Section::new("description", "Description");
    let intervals = if results.is_inferential() {
        "The 95\u{a0}% intervals show how much a mean might differ with other participants. They are score \
         intervals (Wilson) with t quantiles over the participants’ means, so they stay on the scale; there is none where all participants have the same mean."
    } else {
        "The 95\u{a0}% intervals show how much a mean might differ in other trials of this participant; they say nothing \
         about other people."
    };
    section.text(format!(
        "A mean rating treats the categories as equally spaced, which is an assumption. It is descriptive only; the model \
         does not use it. In every mean, each participant counts equally, and so does each condition. {intervals}"
    ));
    section.figures(figures, &["figure4a", "figure4b", "proportions", "subjects", "orientation"]);
    for factor in &results.factors {
        let name = names::factor(results, &factor.name);
        let rows = factor.levels.iter().map(|level| (vec![names::level_of(results, factor, level)], level));
        ratings(&mut section, results, &format!("Ratings by {name}"), std::slice::from_ref(&name), rows.collect());
    }
    let factors = &results.measured.counts.factors;
    if factors.len() > 1 {
        let heads: Vec<String> = factors.iter().map(|factor| names::factor(results, &factor.name)).collect();
        let levels = |cell: &Group| {
            factors.iter().zip(&cell.names).map(|(f, level)| names::level(results, &f.name, level)).collect()
        };
        let rows = results.cells.iter().map(|cell| (levels(cell), cell));
        ratings(&mut section, results, "Ratings of every condition", &heads, rows.collect());
    }
    let rows = (results.subjects.iter()).map(|subject| (vec![participant(subject).into()], &subject.group));
    ratings(&mut section, results, "Ratings of every participant", &["Participant".to_owned()], rows.collect());
    section
}

/// Adds a table of groups of ratings; `heads` are the headings of the columns with their names.
fn ratings(section: &mut Section, results: &Results, caption: &str, heads: &[String], rows: Vec<(Vec<Shown>, &Group)>) {
    let mut table = TableOf::new(caption, &rows);
    for (place, head) in heads.iter().enumerate() {
        table = table.text(head, |(names, _)| names[place].clone());
    }
    table = table
        .number("Ratings", |(_, group)| whole(group.summary.n))
        .number("Mean", |(_, group)| mean(group.summary.mean))
        .number("Median", |(_, group)| fixed(group.summary.median, 1));
    if rows.iter().any(|(_, group)| group.summary.interval.is_some()) {
        table = table.number("Interval of the mean", |(_, group)| range(group.summary.interval, mean));
    }
    for (place, category) in results.measured.counts.categories.iter().enumerate() {
        table = table.number(format!("Rated {category}"), |(_, group)| unit(group.summary.proportions[place]));
    }
    table.add_to(section);
}

/// Describes the response times.
pub(super) fn times(results: &Results, figures: &[Figure]) -> Section {
    let mut section = Section::new("times", "Response times");
    if results.times.iter().all(Option::is_none) {
        section.text("The files contain no response times, or they were not read.");
        return section;
    }
    section.text(if results.options.parameters.is_some() {
        "Times are from the onset of the stimulus to the rating, in seconds. They are described, but not tested."
    } else {
        "Times are those in the table, taken to be in seconds; the table does not say from which moment. They are described, but not tested."
    });
    section.figures(figures, &["times"]);
    let counts = &results.measured.counts;
    quartiles(
        &mut section,
        "Rating",
        "rating",
        counts.categories.iter().map(Shown::from).zip(results.times.iter().copied()),
    );
    for factor in names::varied(results) {
        let name = names::factor(results, &factor.name);
        let levels = factor.levels.iter().map(|level| names::level_of(results, factor, level));
        quartiles(&mut section, &name, &name, levels.zip(factor.times.iter().copied()));
    }
    let subjects = results.subjects.iter().map(|subject| (participant(subject).into(), subject.times));
    quartiles(&mut section, "Participant", "participant", subjects);
    section
}

fn quartiles(section: &mut Section, head: &str, by: &str, rows: impl Iterator<Item = (Shown, Option<Quartiles>)>) {
    let rows: Vec<(Shown, Option<Quartiles>)> = rows.collect();
    let seconds = |of: fn(Quartiles) -> f64| move |(_, times): &(Shown, Option<Quartiles>)| fixed(times.map(of), 2);
    TableOf::new(format!("Response times by {by}"), &rows)
        .text(head, |(name, _)| name.clone())
        .number("Answers", |(_, times)| whole(times.map_or(0, |times| times.n)))
        .number("Lower quartile", seconds(|times| times.lower))
        .number("Median", seconds(|times| times.median))
        .number("Upper quartile", seconds(|times| times.upper))
        .add_to(section);
}

/// Counts what agreement is about: conditions, items, or items in conditions.
fn units(results: &Results, number: u64) -> String {
    match &results.spec.items {
        None => count(number, "condition"),
        Some(_) if names::varied(results).next().is_none() => count(number, "item"),
        Some(items) => format!("{} of {} and condition", count(number, "combination"), names::factor(results, items)),
    }
}

/// Describes agreement between and within participants.
pub(super) fn agreement(results: &Results) -> Section {
    let mut section = Section::new("agreement", "Agreement");
    section.heading("Between participants");
    match results.alpha {
        Some(alpha) => {
            section.text(format!(
                "Krippendorff’s ordinal α is {}{}, from {} of {} that two or more participants rated. 1 is perfect \
                 agreement; 0 is agreement by chance.",
                unit(alpha.alpha),
                with_interval(alpha.interval, unit),
                count(alpha.ratings, "rating"),
                units(results, alpha.units as u64),
            ));
            section.note(
                "Krippendorff’s limits of .800 and .667 are meant for coders who apply a rule. Participants may differ \
                 because they see differently; in that case, a low α is a finding and not an error. α is also near 0 if the \
                 conditions hardly differ.",
            );
        }
        None if results.is_inferential() => section.text(
            "Fewer than two conditions were rated by two participants, or all ratings are the same: agreement cannot be computed.",
        ),
        None => section.text("Agreement between participants requires at least two participants."),
    }
    section.heading("Within participants");
    let Some((kappa, interval)) = results.kappa else {
        section.text(
            "Test–retest agreement could not be computed: κ needs a participant who rated at least five conditions twice, in a \
             known order, and used more than one category in them.",
        );
        return section;
    };
    section.text(format!(
        "Cohen’s κ with quadratic weights compares a participant’s first and second rating of a condition. {} {}{}. 1 is \
         perfect agreement, and 0 is agreement by chance.",
        if results.is_inferential() { "Its mean over participants is" } else { "It is" },
        unit(kappa),
        with_interval(interval, unit),
    ));
    TableOf::new("First and second ratings of each participant", &results.subjects)
        .text("Participant", names::participant)
        .number("Conditions rated twice", |subject| whole(subject.retests))
        .number("Weighted κ", |subject| unit(subject.kappa))
        .add_to(&mut section);
    section
}
