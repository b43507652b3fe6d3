//! Description: every factor, every cell, every participant.

use maud::{Markup, html};

use super::names;
use crate::analysis::{
    Results,
    summary::{Group, Summary},
};
use crate::report::document::numbers::{fixed, mean, percent, range, short_list, unit, whole};
use crate::report::skins::html::table::{Column, Kind, table};

/// The section.
pub(crate) fn section(results: &Results, figures: Markup) -> Markup {
    let level = percent(results.options.bootstrap.level);
    html! {
        p {
            "A mean of ratings treats the categories as equal steps, which nobody has shown; it describes, and the model below does without it. "
            @if results.is_inferential() {
                "Intervals (" (level) ") say how far a mean might be off with other participants: they resample participants, "
                (whole(results.options.bootstrap.replicates as u64)) " times."
            } @else {
                "With one participant there are no intervals for other people."
            }
        }
        (figures)
        @for factor in &results.factors {
            (groups(
                results,
                &format!("Ratings by {}", names::factor(&factor.name)),
                &[names::factor(&factor.name)],
                &factor.levels,
                |group| vec![names::level(&factor.name, group.names.first().map_or("", String::as_str))],
            ))
        }
        (cells(results))
        (participants(results))
    }
}

fn cells(results: &Results) -> Markup {
    let factors = &results.measured.counts.factors;
    if factors.len() < 2 {
        return html! {};
    }
    let heads: Vec<&str> = factors.iter().map(|factor| names::factor(&factor.name)).collect();
    let values =
        |group: &Group| factors.iter().zip(&group.names).map(|(f, level)| names::level(&f.name, level)).collect();
    groups(results, "Ratings of every condition", &heads, &results.cells, values)
}

fn participants(results: &Results) -> Markup {
    let groups_of: Vec<Group> = results.subjects.iter().map(|subject| subject.group.clone()).collect();
    groups(results, "Ratings of every participant", &["Participant"], &groups_of, |group| group.names.clone())
}

fn groups(
    results: &Results,
    caption: &str,
    heads: &[&str],
    groups: &[Group],
    values: impl Fn(&Group) -> Vec<String>,
) -> Markup {
    let categories: Vec<String> = results.measured.counts.categories.iter().map(|c| format!("Rated {c}")).collect();
    let intervals = groups.iter().any(|group| group.summary.interval.is_some());
    let mut columns: Vec<Column<'_>> = heads.iter().map(|head| (*head, Kind::Text)).collect();
    columns.extend([("Ratings", Kind::Number), ("Mean", Kind::Number)]);
    if intervals {
        columns.push(("Interval", Kind::Number));
    }
    columns.push(("Median", Kind::Number));
    columns.extend(categories.iter().map(|name| (name.as_str(), Kind::Number)));
    let row = |group: &Group| {
        let Summary { n, mean: average, median, ref proportions, interval, .. } = group.summary;
        let mut row = values(group);
        row.extend([whole(n), mean(average)]);
        if intervals {
            row.push(range(interval, mean));
        }
        row.push(fixed(median, 1));
        row.extend(proportions.iter().map(|p| unit(*p)));
        row
    };
    table(caption, &columns, groups.iter().map(row).collect::<Vec<_>>())
}

/// Subjects whose number of ratings differs from most others', in words; none where all are alike.
pub(crate) fn uneven(results: &Results) -> Option<String> {
    let ns: Vec<u64> = results.subjects.iter().map(|subject| subject.group.summary.n).collect();
    let (least, most) = (*ns.iter().min()?, *ns.iter().max()?);
    if least == most {
        return None;
    }
    let few: Vec<&str> = (results.subjects.iter())
        .filter(|subject| subject.group.summary.n < most)
        .filter_map(|subject| subject.group.names.first().map(String::as_str))
        .collect();
    Some(format!(
        "Not all participants gave equally many ratings: {} to {}; fewer than the most came from {}.",
        whole(least),
        whole(most),
        short_list(&few, 12)
    ))
}
