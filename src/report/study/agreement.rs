//! The section about agreement between and within participants.

use super::names;
use crate::{
    analysis::Results,
    report::document::{Section, TableOf, count, unit, whole, with_interval},
};

/// Counts what agreement is about: conditions, items, or items in conditions.
fn units(results: &Results, number: u64) -> String {
    match &results.spec.items {
        None => count(number, "condition"),
        Some(_) if names::varied(results).next().is_none() => count(number, "item"),
        Some(items) => format!("{} of {} and condition", count(number, "combination"), names::factor(results, items)),
    }
}

pub(super) fn section(results: &Results) -> Section {
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
