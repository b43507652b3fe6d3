//! A chart of response times: the median and quartiles by rating and by participant.

use super::{
    axes::{EDGE, Levels, MARKER, PANEL, Values, told},
    figure::Figure,
    palette::{Series, Stroke},
    svg::WIDTH,
};
use crate::{
    analysis::{Results, counts::Quartiles, numbers_of},
    report::document::count,
    statistics::Interval,
};

/// Space between two panels.
const GAP: f64 = 36.0;

/// Draws `times`, if response times are known.
pub(super) fn figure(results: &Results) -> Option<Figure> {
    let n: u64 = results.times.iter().flatten().map(|quartiles| quartiles.n).sum();
    if n == 0 {
        return None;
    }
    let counts = &results.measured.counts;
    let several = results.is_inferential();
    let by = if several { "by rating and by participant" } else { "by rating" };
    let caption = format!(
        "Markers are medians, with bars from the lower to the upper quartile; {}, {}.",
        count(results.people() as u64, "participant"),
        count(n, "response time"),
    );
    let of_people: Vec<Option<Quartiles>> = results.subjects.iter().map(|subject| subject.times).collect();
    let longest = results.times.iter().chain(&of_people).flatten().map(|times| times.upper);
    let values = Values::from_zero(longest.fold(0.0, f64::max));
    let (left, right) = (values.margin(), WIDTH - EDGE);
    let middle = if several { left + 0.42 * (right - left - GAP) } else { right };
    let panel = |from, to| values.panel(from, to, EDGE, PANEL);
    let levels = |names: &[String]| Levels::evenly(names, numbers_of(names).is_some());
    let mut parts = vec![("Rating", levels(&counts.categories), &results.times, panel(left, middle))];
    if several {
        parts.push(("Participant", levels(&counts.subjects), &of_people, panel(middle + GAP, right)));
    }
    let below = parts.iter().map(|(_, levels, _, panel)| levels.below(panel.width())).fold(0.0, f64::max);
    Some(Figure::draw("times", format!("Response times {by}"), caption, EDGE + PANEL + below, |svg| {
        for (title, levels, times, panel) in &parts {
            values.draw(svg, panel, (panel.left == left).then_some("Response time (s)"));
            levels.draw(svg, panel, title);
            // A bar between the quartiles, and a marker at the median.
            let (series, room) = (Series::only(), levels.gap() * panel.width());
            let (bar, radius) = ((0.3 * room).clamp(1.0, 12.0), (0.4 * room).clamp(1.5, MARKER));
            for ((at, name), times) in levels.at.iter().zip(&levels.names).zip(*times) {
                let Some(times) = times else { continue };
                let x = panel.x(*at);
                let ends = [(x, panel.y(times.lower)), (x, panel.y(times.upper))];
                svg.line(&ends, Stroke { opacity: 0.45, ..Stroke::new(series.color, bar) });
                let quartiles = Interval { low: times.lower, high: times.upper };
                let text = format!("{title} {name}: {} s", told(times.median, Some(quartiles)));
                svg.point((x, panel.y(times.median)), radius, series, text);
            }
        }
    }))
}
