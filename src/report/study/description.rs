//! Description: every factor, every condition, every participant.

use super::names;
use crate::{
    analysis::{
        Results,
        summary::{Group, Summary},
    },
    report::{
        document::{
            Section,
            numbers::{fixed, mean, percent, range, unit, whole},
        },
        figures::Figure,
    },
};

/// The section.
pub(super) fn section<'a>(results: &Results, figures: impl Iterator<Item = &'a Figure>) -> Section {
    let mut section = Section::new("description", "Description");
    let intervals = if results.is_inferential() {
        format!(
            "The {} intervals say how far a mean might be off with other participants: they resample participants, {} times.",
            percent(results.options.bootstrap.level),
            whole(results.options.bootstrap.replicates as u64)
        )
    } else {
        "With one participant there are no intervals for other people.".to_owned()
    };
    section.text(format!(
        "A mean of ratings treats the categories as equal steps, which nobody has shown. It describes; the model \
         does without it. {intervals}"
    ));
    section.figures(figures);
    for factor in &results.factors {
        let name = names::factor(&factor.name);
        let level = |group: &Group| vec![names::level_of(factor, group)];
        groups(&mut section, results, &format!("Ratings by {name}"), &[name], &factor.levels, level);
    }
    let factors = &results.measured.counts.factors;
    if factors.len() > 1 {
        let heads: Vec<&str> = factors.iter().map(|factor| names::factor(&factor.name)).collect();
        let levels =
            |group: &Group| factors.iter().zip(&group.names).map(|(f, level)| names::level(&f.name, level)).collect();
        groups(&mut section, results, "Ratings of every condition", &heads, &results.cells, levels);
    }
    let subjects: Vec<Group> = results.subjects.iter().map(|subject| subject.group.clone()).collect();
    groups(&mut section, results, "Ratings of every participant", &["Participant"], &subjects, |group| {
        group.names.clone()
    });
    section
}

fn groups(
    section: &mut Section,
    results: &Results,
    caption: &str,
    heads: &[&str],
    groups: &[Group],
    names: impl Fn(&Group) -> Vec<String>,
) {
    let categories: Vec<String> = results.measured.counts.categories.iter().map(|c| format!("Rated {c}")).collect();
    let intervals = groups.iter().any(|group| group.summary.interval.is_some());
    let mut numbers = vec!["Ratings", "Mean", "Median"];
    numbers.extend(intervals.then_some("Interval of the mean"));
    numbers.extend(categories.iter().map(String::as_str));
    let row = |group: &Group| {
        let Summary { n, mean: average, median, ref proportions, interval, .. } = group.summary;
        let mut row = names(group);
        row.extend([whole(n), mean(average), fixed(median, 1)]);
        row.extend(intervals.then(|| range(interval, mean)));
        row.extend(proportions.iter().map(|p| unit(*p)));
        row
    };
    section.table(caption, heads, &numbers, groups.iter().map(row).collect());
}
