//! Agreement: of participants with each other, and of each with themselves.

use maud::{Markup, html};

use super::{
    oddities::LOW_KAPPA,
    summary::{RELIABLE, TENTATIVE},
};
use crate::analysis::{Results, results::SubjectResults};
use crate::report::document::numbers::{count, percent, range, unit, whole};
use crate::report::skins::html::table::{Kind, table};

/// The section.
pub(crate) fn section(results: &Results) -> Markup {
    html! { (between(results)) (within(results)) }
}

fn between(results: &Results) -> Markup {
    let level = percent(results.options.bootstrap.level);
    html! {
        h3 { "With each other" }
        @match results.alpha {
            Some(alpha) => {
                p {
                    "Krippendorff’s ordinal α is " (unit(alpha.alpha))
                    @if let Some(interval) = alpha.interval { " (" (level) " bootstrap interval " (range(Some(interval), unit)) ")" }
                    ", from " (count(alpha.ratings, "rating")) " of " (count(alpha.units as u64, "condition")) " that two or more participants rated: "
                    "1 is perfect agreement, 0 what chance gives. "
                    (verdict(alpha.alpha))
                }
                p.note {
                    "The marks .800 (reliable) and .667 (tentative conclusions only) are Krippendorff’s, for coders who apply a rule. "
                    "Participants may differ because they see differently, and then a low α is a finding and no fault."
                }
            }
            None if results.is_inferential() => {
                p { "No condition was rated by two participants, or all ratings are the same: agreement cannot be computed." }
            }
            None => { p { "One participant cannot agree or disagree with another." } }
        }
    }
}

fn verdict(alpha: f64) -> &'static str {
    match alpha {
        a if a >= RELIABLE => "By Krippendorff’s marks these ratings are reliable.",
        a if a >= TENTATIVE => "By Krippendorff’s marks these ratings allow tentative conclusions only.",
        _ => "By Krippendorff’s marks these ratings are not reliable as a common judgement.",
    }
}

fn within(results: &Results) -> Markup {
    let level = percent(results.options.bootstrap.level);
    let columns = [("Participant", Kind::Text), ("Conditions rated twice", Kind::Number), ("Weighted κ", Kind::Number)];
    let row = |subject: &SubjectResults| {
        let name = subject.group.names.first().cloned().unwrap_or_default();
        vec![name, whole(subject.retests), subject.kappa.map_or_else(|| "–".to_owned(), unit)]
    };
    let rows: Vec<Vec<String>> = results.subjects.iter().map(row).collect();
    html! {
        h3 { "With themselves" }
        @match results.kappa {
            Some((kappa, interval)) => {
                p {
                    "Cohen’s κ with quadratic weights compares a participant’s first and second rating of a condition. "
                    @if results.is_inferential() { "Its mean over participants is " } @else { "It is " }
                    (unit(kappa))
                    @if interval.is_some() { " (" (level) " bootstrap interval " (range(interval, unit)) ")" }
                    "; 1 is perfect repetition, 0 what chance gives, and up to " (unit(LOW_KAPPA)) " Landis and Koch call agreement slight."
                }
                (table("First and second ratings of each participant", &columns, rows))
            }
            None => { p { "No condition was rated twice by the same participant, as far as the files tell: nothing can be said about repetition." } }
        }
    }
}
