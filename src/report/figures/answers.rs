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
    report::{document::whole_percent, names},
};

/// Maximum number of categories in the legend; readers can interpolate the colors in between.
const MAX_NAMED: usize = 10;

/// Draws `proportions`.
pub(super) fn proportions(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let index = *chosen(counts).first()?;
    let (groups, factor) = (by_levels(counts, &[index]), &counts.factors[index]);
    let levels = Levels::evenly(&factor.levels, factor.numbers.is_some());
    let title = format!("How often each rating was given by {}", labels::in_sentence(results, &factor.name));
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
        levels.draw(svg, &panel, &names::axis(results, &factor.name));
        let half = 0.4 * levels.gap() * panel.width();
        for (at, level) in levels.at.iter().zip(&factor.levels) {
            let own = groups.iter().find(|group| group.names[0] == *level);
            let Some(summary) = own.map(|group| &group.summary) else { continue };
            let (x, mut from) = (panel.x(*at), 0.0);
            for (index, share) in summary.proportions.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                let (name, to) = (labels::level(&counts.categories[index]), from + 100.0 * share);
                let text = format!("{name}: {} of {} ratings", whole_percent(*share), summary.n);
                svg.bar((x - half, panel.y(to)), (x + half, panel.y(from)), color(index), text);
                from = to;
            }
        }
        legend(svg, &panel, "Rating", &series, false);
    }))
}
