//! A chart of how well the model describes the ratings: observed proportions, and those in studies simulated from the
//! model.

use super::{
    axes::{EDGE, MARKER, PANEL, TEXT, Values, below, beside, legend, number_axis, told},
    choice::evenly,
    figure::Figure,
    labels,
    palette::{AXIS, Series, Stroke},
    svg::WIDTH,
};
use crate::analysis::{Results, numbers_of};

/// Maximum number of proportions in the chart.
const MAX_POINTS: usize = 150;

/// Draws `predictive`, if the model was checked.
pub(super) fn figure(results: &Results) -> Option<Figure> {
    let report = results.model.as_ref().ok()?;
    let all = &report.checks.as_ref()?.proportions;
    if all.is_empty() {
        return None;
    }
    let shown = evenly(all.len(), MAX_POINTS);
    let categories = &report.model.categories;
    let named = numbers_of(categories).is_none();
    let caption = format!(
        "Observed proportion of each rating at each level of each factor, against the proportion that the model expects; \
         bars show the middle 95\u{a0}% of studies simulated from the model{}{}; {}.",
        if named { "" } else { ". Colors and markers stand for the rating" },
        labels::some_of(shown.len(), all.len()),
        labels::fitted(&report.model)
    );
    let largest = all.iter().flat_map(|p| [p.observed, p.expected, p.range.high]).fold(0.0, f64::max);
    let values = Values::from_zero(largest);
    let named = categories.iter().enumerate().take(8);
    let series: Vec<_> = named.map(|(index, name)| (Series::of(index), name.as_str())).collect();
    let panel = values.panel(values.margin(), WIDTH - EDGE - beside("", &series), EDGE, PANEL);
    let title = "Observed and expected proportions".to_owned();
    Some(Figure::draw("predictive", title, caption, panel.bottom + below(TEXT), |svg| {
        values.draw(svg, &panel, Some("Observed proportion"));
        number_axis(svg, &panel, (panel.low, panel.high), "Proportion expected by the model");
        let share = |value: f64| (value - panel.low) / (panel.high - panel.low);
        let ends = [panel.low, panel.high].map(|value| (panel.x(share(value)), panel.y(value)));
        svg.line(&ends, Stroke { dash: Some((9.0, 6.0)), ..AXIS });
        for proportion in shown.iter().map(|&index| &all[index]) {
            let category = categories.iter().position(|name| *name == proportion.category).unwrap_or(0);
            let (series, x) = (Series::of(category), panel.x(share(proportion.expected)));
            let bar = Stroke { opacity: 0.35, ..Stroke::new(series.color, 5.0) };
            svg.line(&[(x, panel.y(proportion.range.low)), (x, panel.y(proportion.range.high))], bar);
            let [observed, expected] = [proportion.observed, proportion.expected].map(|share| told(share, None));
            let factor = labels::in_sentence(results, &proportion.factor);
            let (level, rating) = (&proportion.level, &proportion.category);
            let text = format!("{factor} {level}, rating {rating}: {observed}, expected {expected}");
            svg.point((x, panel.y(proportion.observed)), 0.8 * MARKER, series, text);
        }
        legend(svg, &panel, "", &series, false);
    }))
}
