//! Agreement: of participants with each other, and of each with themselves.

use super::{limits::LOW_KAPPA, names};
use crate::{
    analysis::{Results, bootstrap::Interval},
    report::document::{
        Section,
        numbers::{count, maybe_unit, percent, range, unit, whole},
    },
};

/// The section.
pub(super) fn section(results: &Results) -> Section {
    let mut section = Section::new("agreement", "Agreement");
    let interval = |interval: Option<Interval>| match interval {
        Some(_) => {
            format!(" ({} bootstrap interval {})", percent(results.options.bootstrap.level), range(interval, unit))
        }
        None => String::new(),
    };
    section.heading("Between participants");
    match results.alpha {
        Some(alpha) => {
            section.text(format!(
                "Krippendorff’s ordinal α is {}{}, from {} of {} that two or more participants rated. 1 is perfect \
                 agreement; 0 is what chance gives.",
                unit(alpha.alpha),
                interval(alpha.interval),
                count(alpha.ratings, "rating"),
                count(alpha.units as u64, "condition"),
            ));
            section.note(
                "Krippendorff’s limits of .800 and .667 are meant for coders who apply a rule. Participants may differ \
                 because they see differently; then a low α is a finding and not a fault.",
            );
        }
        None if results.is_inferential() => section.text(
            "No condition was rated by two participants, or all ratings are the same: agreement cannot be computed.",
        ),
        None => section.text("One participant cannot agree or disagree with another."),
    }
    section.heading("Within participants");
    let Some((kappa, ends)) = results.kappa else {
        section
            .text("As far as the files show, no participant rated a condition twice, so repetition cannot be judged.");
        return section;
    };
    section.text(format!(
        "Cohen’s κ with quadratic weights compares a participant’s first and second rating of a condition. {} {}{}. 1 is \
         perfect repetition, 0 is what chance gives, and Landis and Koch call agreement up to {} slight.",
        if results.is_inferential() { "Its mean over participants is" } else { "It is" },
        unit(kappa),
        interval(ends),
        unit(LOW_KAPPA),
    ));
    let rows = (results.subjects.iter())
        .map(|subject| vec![names::participant(subject).to_owned(), whole(subject.retests), maybe_unit(subject.kappa)])
        .collect();
    let numbers = ["Conditions rated twice", "Weighted κ"];
    section.table("First and second ratings of each participant", &["Participant"], &numbers, rows);
    section
}
