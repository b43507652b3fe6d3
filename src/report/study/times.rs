//! Response times.

use maud::{Markup, html};

use super::names;
use crate::analysis::{Results, times::Quartiles};
use crate::report::document::numbers::{fixed, whole};
use crate::report::skins::html::table::{Column, Kind, table};

/// The section.
pub(crate) fn section(results: &Results, figures: Markup) -> Markup {
    if results.times.iter().all(Option::is_none) {
        return html! { p { "The files have no response times, or they were not asked for." } };
    }
    let counts = &results.measured.counts;
    let subjects = (results.subjects.iter())
        .map(|subject| (subject.group.names.first().cloned().unwrap_or_default(), subject.times))
        .collect();
    html! {
        p {
            "From the onset of the stimulus to the rating, in seconds. Times are counted in steps of 5\u{a0}%, so a quartile is right to 2.5\u{a0}%. "
            "They are described and not tested."
        }
        (figures)
        (quartiles("Response times by rating", "Rating", counts.categories.iter().cloned().zip(results.times.iter().copied()).collect()))
        @for factor in names::varied(results) {
            (quartiles(
                &format!("Response times by {}", names::factor(&factor.name)),
                names::factor(&factor.name),
                level_times(results, &factor.name, &factor.times),
            ))
        }
        (quartiles("Response times by participant", "Participant", subjects))
    }
}

fn level_times(results: &Results, name: &str, times: &[Option<Quartiles>]) -> Vec<(String, Option<Quartiles>)> {
    let factor = results.measured.counts.factors.iter().find(|factor| factor.name == name);
    let levels = factor.map(|factor| factor.levels.as_slice()).unwrap_or_default();
    levels.iter().map(|level| names::level(name, level)).zip(times.iter().copied()).collect()
}

fn quartiles(caption: &str, first: &str, rows: Vec<(String, Option<Quartiles>)>) -> Markup {
    let columns: [Column<'_>; 5] = [
        (first, Kind::Text),
        ("Answers", Kind::Number),
        ("Lower quartile", Kind::Number),
        ("Median", Kind::Number),
        ("Upper quartile", Kind::Number),
    ];
    let row = |(name, times): (String, Option<Quartiles>)| match times {
        None => vec![name, "0".to_owned(), "–".to_owned(), "–".to_owned(), "–".to_owned()],
        Some(t) => vec![name, whole(t.n), fixed(t.lower, 2), fixed(t.median, 2), fixed(t.upper, 2)],
    };
    table(caption, &columns, rows.into_iter().map(row).collect::<Vec<_>>())
}
