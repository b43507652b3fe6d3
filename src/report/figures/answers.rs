//! A chart of the answers: how often each category was used, with one bar for each level of a factor.

use super::{
    axes::{EDGE, Levels, PANEL, Values, beside, legend},
    figure::Figure,
    labels::{self, chosen, evenly},
    palette::{Marker, Series, category},
    svg::WIDTH,
};
use crate::{
    analysis::{Results, summary::by_levels},
    report::names,
};

/// Maximum number of categories in the legend; readers can interpolate the colors in between.
const MAX_NAMED: usize = 10;

/// Draws `proportions`.
pub(super) fn proportions(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let chosen: Vec<usize> = chosen(counts).into_iter().take(1).collect();
    let groups = by_levels(counts, &chosen);
    if groups.is_empty() {
        return None;
    }
    let factor = chosen.first().map(|&factor| &counts.factors[factor]);
    let (bars, is_ordered) =
        factor.map_or((vec![String::new()], true), |own| (own.levels.clone(), own.numbers.is_some()));
    let levels = Levels::evenly(&bars, is_ordered);
    let (by, across) = factor.map_or_else(Default::default, |factor| {
        let name = &factor.name;
        (format!(" by {}", labels::in_sentence(results, name)), names::axis(results, name))
    });
    let title = format!("How often each rating was given{by}");
    let caption = format!("Proportions of the ratings; {}.", labels::sample(results));
    let color = |index: usize| category(index, counts.categories.len());
    // The highest category is on top.
    let named = evenly(counts.categories.len(), MAX_NAMED).into_iter().rev();
    let series = named.map(|index| {
        (Series { color: color(index), marker: Marker::Square, dash: None }, counts.categories[index].as_str())
    });
    let series: Vec<(Series, &str)> = series.collect();
    let values = Values::between(0.0, 100.0);
    let panel = values.panel(values.margin(), WIDTH - EDGE - beside("Rating", &series), EDGE, PANEL);
    Some(Figure::draw("proportions", title, caption, panel.bottom + levels.below(panel.width()), |svg| {
        values.draw(svg, &panel, Some("Ratings (%)"));
        levels.draw(svg, &panel, &across);
        let half = 0.4 * levels.gap() * panel.width();
        for (at, level) in levels.at.iter().zip(&bars) {
            let own = groups.iter().find(|group| group.names.first().is_none_or(|name| name == level));
            let Some(summary) = own.map(|group| &group.summary) else { continue };
            let (x, mut from) = (panel.x(*at), 0.0);
            for (index, share) in summary.proportions.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                let (name, to) = (labels::level(&counts.categories[index]), from + 100.0 * share);
                let text = format!("{name}: {:.0} % of {} ratings", 100.0 * share, summary.n);
                svg.bar((x - half, panel.y(to)), (x + half, panel.y(from)), color(index), text);
                from = to;
            }
        }
        legend(svg, &panel, "Rating", &series, false);
    }))
}
