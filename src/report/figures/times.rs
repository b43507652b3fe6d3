//! Response times: median and quartiles by rating, and by participant.

use super::{
    axes::{EDGE, Levels, MARKER, PANEL, Panel, Values, below},
    figure::Figure,
    palette::{Series, Stroke},
    svg::{Svg, WIDTH},
};
use crate::{
    analysis::{Results, times::Quartiles},
    report::document::numbers::count,
};

/// `times`, where response times are known.
pub(super) fn figure(results: &Results) -> Option<Figure> {
    let n: u64 = results.times.iter().flatten().map(|quartiles| quartiles.n).sum();
    if n == 0 {
        return None;
    }
    let counts = &results.measured.counts;
    let several = results.is_inferential();
    let by = if several { "by rating and by participant" } else { "by rating" };
    let caption = format!(
        "Time from the onset of the stimulus to the rating: median, and the middle half of the times as bars, {by}; {}, {}.",
        count(results.people() as u64, "participant"),
        count(n, "response time"),
    );
    let mut parts = vec![("Rating", &counts.categories, results.times.clone(), 0.42)];
    if several {
        parts.push(("Participant", &counts.subjects, results.subjects.iter().map(|s| s.times).collect(), 0.58));
    }
    let longest = parts.iter().flat_map(|(_, _, times, _)| times).flatten().map(|times| times.upper);
    let values = Values::from_zero(longest.fold(0.0, f64::max));
    let (gap, left) = (if several { 36.0 } else { 0.0 }, values.margin());
    let full = WIDTH - EDGE - left - gap;
    let all: f64 = parts.iter().map(|(.., share)| share).sum();
    let mut from = left;
    let panels: Vec<_> = (parts.iter())
        .map(|(_, names, _, share)| {
            let panel = values.panel(from, from + share / all * full, EDGE, PANEL);
            from = panel.right + gap;
            let levels = Levels::evenly(names, crate::analysis::numbers_of(names).is_some());
            let below_axis = levels.labels(panel.width());
            (panel, levels, below_axis)
        })
        .collect();
    let height = panels.iter().map(|(.., below_axis)| below_axis.height).fold(0.0, f64::max);
    let title = format!("Response times {by}");
    Some(Figure::draw("times", title, caption, EDGE + PANEL + below(height), |svg| {
        for (index, ((panel, levels, below_axis), (title, _, times, _))) in panels.iter().zip(&parts).enumerate() {
            values.draw(svg, panel, (index == 0).then_some("Response time (s)"));
            levels.draw(svg, panel, below_axis, title);
            quartiles(svg, panel, levels, times);
        }
    }))
}

/// The middle half of the times as a bar, with the median.
fn quartiles(svg: &mut Svg, panel: &Panel, levels: &Levels, times: &[Option<Quartiles>]) {
    let series = Series::only();
    let room = levels.gap() * panel.width();
    let (bar, radius) = ((0.3 * room).clamp(1.0, 12.0), (0.4 * room).clamp(1.5, MARKER));
    for (&at, times) in levels.at.iter().zip(times) {
        let Some(times) = times else { continue };
        let x = panel.x(at);
        let ends = [(x, panel.y(times.lower)), (x, panel.y(times.upper))];
        svg.line(&ends, Stroke { opacity: 0.45, ..Stroke::new(series.color, bar) });
        svg.marker((x, panel.y(times.median)), radius, series);
    }
}
