//! The sections about the ratings as they are, and agreement.

use super::names::{self, participant};
use crate::{
    analysis::{Results, summary::Group},
    report::{
        document::{Section, Shown, TableOf, count, fixed, mean, range, unit, whole, with_interval},
        figures::Figure,
    },
};

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
    section.figures(figures, &["stimulus", "figure4a", "figure4b", "proportions", "subjects", "orientation"]);
    for factor in &results.factors {
        let name = names::factor(results, &factor.name);
        let levels = factor.levels.iter().zip(factor.times.iter().copied());
        let rows = levels.map(|(level, time)| (vec![names::level_of(results, factor, level)], level, time));
        ratings(&mut section, results, &format!("Ratings by {name}"), std::slice::from_ref(&name), rows.collect());
    }
    let factors = &results.measured.counts.factors;
    if factors.len() > 1 {
        let heads: Vec<String> = factors.iter().map(|factor| names::factor(results, &factor.name)).collect();
        let levels = |cell: &Group| {
            factors.iter().zip(&cell.names).map(|(f, level)| names::level(results, &f.name, level)).collect()
        };
        let rows = results.cells.iter().map(|cell| (levels(cell), cell, None));
        ratings(&mut section, results, "Ratings of every condition", &heads, rows.collect());
    }
    let rows = (results.subjects.iter()).map(|own| (vec![participant(own).into()], &own.group, own.time));
    ratings(&mut section, results, "Ratings of every participant", &["Participant".to_owned()], rows.collect());
    section
}

/// A row of a table: the names of a group, its ratings, and their median time.
type Rated<'a> = (Vec<Shown>, &'a Group, Option<f64>);

/// Adds a table of groups of ratings; `heads` are the headings of the columns with their names.
fn ratings(section: &mut Section, results: &Results, caption: &str, heads: &[String], rows: Vec<Rated<'_>>) {
    let mut table = TableOf::new(caption, &rows);
    for (place, head) in heads.iter().enumerate() {
        table = table.text(head, |(names, ..)| names[place].clone());
    }
    table = table
        .number("Ratings", |(_, group, _)| whole(group.summary.n))
        .number("Mean", |(_, group, _)| mean(group.summary.mean))
        .number("Median", |(_, group, _)| fixed(group.summary.median, 1));
    if rows.iter().any(|(_, group, _)| group.summary.interval.is_some()) {
        table = table.number("Interval of the mean", |(_, group, _)| range(group.summary.interval, mean));
    }
    for (place, category) in results.measured.counts.categories.iter().enumerate() {
        table = table.number(format!("Rated {category}"), |(_, group, _)| unit(group.summary.proportions[place]));
    }
    if rows.iter().any(|(.., time)| time.is_some()) {
        table = table.number("Median time (s)", |(.., time)| fixed(*time, 2));
    }
    table.add_to(section);
}

/// Describes agreement between and within participants.
pub(super) fn agreement(results: &Results) -> Section {
    let mut section = Section::new("agreement", "Agreement");
    section.heading("Between participants");
    match results.alpha {
        Some(alpha) => {
            section.text(format!(
                "Krippendorff’s ordinal α is {}{}, from {} of {} that two or more participants rated. 1 is perfect \
                 agreement; 0 is agreement by chance, also if the conditions hardly differ.",
                unit(alpha.alpha),
                with_interval(alpha.interval, unit),
                count(alpha.ratings, "rating"),
                match results.spec.items {
                    None => count(alpha.units as u64, "condition"),
                    Some(_) => format!("{} (each an item in a condition)", count(alpha.units as u64, "unit")),
                },
            ));
        }
        None => section.text(
            "Agreement between participants needs two conditions that two participants rated, and ratings that differ.",
        ),
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
         perfect agreement, and 0 is agreement by chance. That of each participant is in subjects.csv.",
        if results.is_inferential() { "Its mean over participants is" } else { "It is" },
        unit(kappa),
        with_interval(interval, unit),
    ));
    section
}
