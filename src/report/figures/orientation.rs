//! The mean rating by orientation, and by the angle to the nearest of the horizontal and the vertical.

use super::{
    axes::{EDGE, MARKER, PANEL, Panel, TEXT, Values, below, ends, multiples, number_axis, plain},
    figure::Figure,
    labels,
    palette::Series,
    regroup::regroup,
    svg::{Svg, WIDTH},
};
use crate::analysis::{
    Results,
    counts::Factor,
    summary::{Summary, by_cell},
};

/// Room beside the first and the last angle.
const MARGIN: f64 = 24.0;

/// A mean at an angle, degrees.
type Mean = (f64, Summary);

/// `orientation`, where `orientation_deg` is a factor with several levels.
pub(super) fn figure(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let (index, factor) = counts.factor("orientation_deg")?;
    let angles = factor.numbers.as_ref().filter(|angles| angles.len() > 1 && angles.iter().all(|a| a.is_finite()))?;
    let means = by_angle(results, index, angles);
    let folded: Vec<f64> = angles.iter().map(|&angle| distance_to_axis(angle)).collect();
    let distances = by_angle(results, index, &folded);
    // Few orientations have fewer distances.
    let beside = (2..means.len()).contains(&distances.len());
    let (what, bars) = (labels::rating(results), labels::bars(results));
    let more =
        if beside { ", at the right by the angle to the nearest of the horizontal and the vertical" } else { "" };
    let caption = format!("{what} by orientation{more}; {bars}.");
    let values = Values::ratings(counts);
    let left = values.margin();
    let full = WIDTH - EDGE - left;
    let right = if beside { left + 0.62 * full } else { left + full };
    let height = EDGE + PANEL + below(TEXT);
    Some(Figure::draw("orientation", format!("{what} by orientation"), caption, height, |svg| {
        let panel = values.panel(left, right, EDGE, PANEL);
        values.draw(svg, &panel, Some(what));
        draw(svg, &panel, &means, labels::axis("orientation_deg"));
        if beside {
            let panel = values.panel(right + 46.0, left + full, EDGE, PANEL);
            values.draw(svg, &panel, None);
            draw(svg, &panel, &distances, "Off axis (°)");
        }
    }))
}

/// Means by an angle for each level of the factor; levels may share one.
fn by_angle(results: &Results, index: usize, angle_of_level: &[f64]) -> Vec<Mean> {
    let mut angles = angle_of_level.to_vec();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    let names: Vec<String> = angles.iter().map(|&angle| plain(angle)).collect();
    let factor = Factor { name: String::new(), levels: names.clone(), numbers: Some(angles.clone()) };
    let place = |level: u32| angles.iter().position(|a| *a == angle_of_level[level as usize]).map(|p| p as u32);
    let counts =
        regroup(&results.measured.counts, vec![factor], |condition| Some(vec![condition[index].and_then(place)?]));
    (by_cell(&counts, &results.options.bootstrap).into_iter())
        .filter_map(|group| {
            let place = names.iter().position(|name| group.names.first() == Some(name))?;
            Some((angles[place], group.summary))
        })
        .collect()
}

/// Degrees to the nearest multiple of 90°, without the noise of binary fractions.
fn distance_to_axis(angle: f64) -> f64 {
    let rest = angle.rem_euclid(90.0);
    (rest.min(90.0 - rest) * 1e6).round() / 1e6
}

/// Means on a linear axis of degrees.
fn draw(svg: &mut Svg, panel: &Panel, means: &[Mean], title: &str) {
    let Some((low, high)) = ends(means.iter().map(|(angle, _)| *angle)) else { return };
    let margin = MARGIN / panel.width();
    let at = |angle: f64| margin + (1.0 - 2.0 * margin) * (angle - low) / (high - low).max(1e-9);
    let ticks: Vec<(f64, String)> = (angle_ticks(low, high, panel.width() - 2.0 * MARGIN).into_iter())
        .map(|angle| (at(angle), plain(angle)))
        .collect();
    number_axis(svg, panel, &ticks, title);
    let series = Series::only();
    let points: Vec<_> = means.iter().map(|(angle, mean)| (panel.x(at(*angle)), panel.y(mean.mean))).collect();
    svg.line(&points, series.line());
    for (&(x, y), (_, mean)) in points.iter().zip(means) {
        if let Some(interval) = mean.interval {
            svg.interval(x, panel.y(interval.low), panel.y(interval.high), 6.0, series.bar());
        }
        svg.marker((x, y), MARKER, series);
    }
}

/// Multiples of 45° (within 45°, of 22.5°), 90° or more, as there is room.
fn angle_ticks(low: f64, high: f64, width: f64) -> Vec<f64> {
    let span = (high - low).max(1e-9);
    let fits = |step: f64| {
        let widest = [low, high, step].map(|angle| labels::width(&plain(angle), TEXT)).into_iter().fold(0.0, f64::max);
        step / span * width >= widest + 0.3 * TEXT
    };
    let steps: &[f64] = if span > 45.0 { &[45.0, 90.0, 180.0] } else { &[22.5, 45.0] };
    multiples(low, high, steps.iter().copied().find(|&step| fits(step)).unwrap_or(span))
}

#[cfg(test)]
mod tests {
    use super::distance_to_axis;

    #[test]
    fn angles_are_folded_to_the_nearest_axis() {
        let angles = [0.0, 22.5, 45.0, 67.5, 90.0, 135.0, 337.5, -10.0, 370.0];
        assert_eq!(angles.map(distance_to_axis), [0.0, 22.5, 45.0, 22.5, 0.0, 45.0, 22.5, 10.0, 10.0]);
    }
}
