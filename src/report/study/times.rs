//! Response times.

use super::names;
use crate::{
    analysis::{Results, counts::Quartiles},
    report::{
        document::{
            Section,
            numbers::{maybe, whole},
        },
        figures::Figure,
    },
};

/// The section.
pub(super) fn section<'a>(results: &Results, figures: impl Iterator<Item = &'a Figure>) -> Section {
    let mut section = Section::new("times", "Response times");
    if results.times.iter().all(Option::is_none) {
        section.text("The files have no response times, or they were not read.");
        return section;
    }
    section.text(
        "Times run from the onset of the stimulus to the rating, in seconds. They are counted in steps of 5\u{a0}%, so a \
         quartile is right to 2.5\u{a0}%. They are described and not tested.",
    );
    section.figures(figures);
    let counts = &results.measured.counts;
    quartiles(&mut section, "Rating", "rating", counts.categories.iter().cloned().zip(results.times.iter().copied()));
    for factor in names::varied(results) {
        let levels = counts.factor(&factor.name).map_or(&[][..], |(_, factor)| &factor.levels);
        let levels = levels.iter().map(|level| names::level(&factor.name, level));
        let name = names::factor(&factor.name);
        quartiles(&mut section, name, name, levels.zip(factor.times.iter().copied()));
    }
    let subjects = results.subjects.iter().map(|subject| (names::participant(subject).to_owned(), subject.times));
    quartiles(&mut section, "Participant", "participant", subjects);
    section
}

fn quartiles(section: &mut Section, head: &str, by: &str, rows: impl Iterator<Item = (String, Option<Quartiles>)>) {
    let row = |(name, times): (String, Option<Quartiles>)| {
        let seconds = [times.map(|t| t.lower), times.map(|t| t.median), times.map(|t| t.upper)];
        let n = whole(times.map_or(0, |times| times.n));
        [name, n].into_iter().chain(seconds.map(|seconds| maybe(seconds, 2))).collect()
    };
    let numbers = ["Answers", "Lower quartile", "Median", "Upper quartile"];
    section.table(format!("Response times by {by}"), &[head], &numbers, rows.map(row).collect());
}
