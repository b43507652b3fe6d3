//! The mean rating by orientation, and by the angle to the nearest of the horizontal and the vertical.

use super::{
    Figure,
    axes::{EDGE, PANEL, Panel, Values, below, ends, number_ticks, plain},
    labels as text,
    palette::{Look, MARKER, TEXT},
    regroup::regroup,
    svg::{Canvas, Drawn, WIDTH, drawing},
};
use crate::analysis::{
    Results,
    counts::{Counts, Factor},
    summary::{Summary, by_cell},
};

/// Room beside the first and the last angle.
const MARGIN: f64 = 24.0;

/// A mean at an angle, degrees.
type Point = (f64, Summary);

/// `orientation`, where `orientation_deg` is a factor with several levels.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    figure(results).into_iter().collect()
}

fn figure(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let (index, factor) = counts.factor("orientation_deg")?;
    let angles = factor.numbers.as_ref().filter(|angles| angles.len() > 1 && angles.iter().all(|a| a.is_finite()))?;
    let all: Vec<Point> = (results.factors[index].levels.iter())
        .filter_map(|group| {
            let level = factor.levels.iter().position(|level| group.names.first() == Some(level))?;
            Some((angles[level], group.summary.clone()))
        })
        .collect();
    let folded = folded(results, index, angles);
    let title = format!("{} by orientation", text::rating(results));
    let beside = if folded.len() > 1 {
        ", at the right by the angle to the nearest of the horizontal and the vertical"
    } else {
        ""
    };
    let caption = format!("{} by orientation{beside}; {}.", text::rating(results), text::bars(results));
    let svg = svg(results, &all, &folded, &title, &caption)?;
    Some(Figure { name: "orientation", title, caption, wide: false, svg })
}

/// Means by the distance to the nearest multiple of 90°; few orientations have fewer distances.
fn folded(results: &Results, index: usize, angles: &[f64]) -> Vec<Point> {
    let counts = &results.measured.counts;
    let mut distances: Vec<f64> = angles.iter().map(|&angle| distance(angle)).collect();
    let of: Vec<f64> = distances.clone();
    distances.sort_by(f64::total_cmp);
    distances.dedup();
    if distances.len() < 2 || distances.len() == angles.len() {
        return Vec::new();
    }
    let names: Vec<String> = distances.iter().map(|&angle| plain(angle)).collect();
    let factor = Factor { name: String::new(), levels: names.clone(), numbers: Some(distances.clone()) };
    let new = |level: u32| distances.iter().position(|d| *d == of[level as usize]).map(|level| level as u32);
    let few: Counts = regroup(counts, vec![factor], |condition| Some(vec![condition[index].and_then(new)?]));
    (by_cell(&few, &results.options.bootstrap).into_iter())
        .filter_map(|group| {
            let level = names.iter().position(|name| group.names.first() == Some(name))?;
            Some((distances[level], group.summary))
        })
        .collect()
}

/// Degrees to the nearest multiple of 90°, without the noise of binary fractions.
fn distance(angle: f64) -> f64 {
    let rest = angle.rem_euclid(90.0);
    (rest.min(90.0 - rest) * 1e6).round() / 1e6
}

fn svg(results: &Results, all: &[Point], folded: &[Point], title: &str, caption: &str) -> Option<String> {
    let values = Values::ratings(&results.measured.counts);
    let left = values.margin();
    let full = WIDTH - EDGE - left;
    let right = if folded.len() > 1 { left + 0.62 * full } else { left + full };
    let panel = Panel { left, right, top: EDGE, bottom: EDGE + PANEL, low: values.low, high: values.high };
    drawing(panel.bottom + below(TEXT), title, caption, |canvas| {
        values.draw(canvas, &panel, Some(text::rating(results)))?;
        draw(canvas, &panel, all, "Orientation (degrees)")?;
        if folded.len() < 2 {
            return Ok(());
        }
        let beside = Panel { left: right + 46.0, right: left + full, ..panel };
        values.draw(canvas, &beside, None)?;
        draw(canvas, &beside, folded, "Off axis (°)")
    })
}

/// Means on a linear axis of degrees.
fn draw(canvas: &Canvas<'_>, panel: &Panel, points: &[Point], title: &str) -> Drawn {
    let Some((low, high)) = ends(points.iter().map(|(angle, _)| *angle)) else { return Ok(()) };
    let margin = MARGIN / panel.width();
    let at = |angle: f64| margin + (1.0 - 2.0 * margin) * (angle - low) / (high - low).max(1e-9);
    number_ticks(canvas, panel, &ticks(low, high, panel.width() - 2.0 * MARGIN, at), title)?;
    let look = Look::only();
    let places: Vec<(f64, f64)> =
        points.iter().map(|(angle, mean)| (panel.x(at(*angle)), panel.y(mean.mean))).collect();
    canvas.line(&places, look.stroke())?;
    for (&(x, y), (_, mean)) in places.iter().zip(points) {
        if let Some(interval) = mean.interval {
            canvas.interval(x, panel.y(interval.low), panel.y(interval.high), 6.0, look.bar())?;
        }
        canvas.marker((x, y), MARKER, look)?;
    }
    Ok(())
}

/// Multiples of 45° (within 45°, of 22.5°), 90° or more, as there is room.
fn ticks(low: f64, high: f64, width: f64, at: impl Fn(f64) -> f64) -> Vec<(f64, String)> {
    let span = (high - low).max(1e-9);
    let fits = |step: f64| {
        let widest = [low, high, step].map(|angle| text::width(&plain(angle), TEXT)).into_iter().fold(0.0, f64::max);
        step / span * width >= widest + 0.3 * TEXT
    };
    let steps: &[f64] = if span > 45.0 { &[45.0, 90.0, 180.0] } else { &[22.5, 45.0] };
    let step = steps.iter().copied().find(|&step| fits(step)).unwrap_or(span);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last.min(first + 40)).map(|index| index as f64 * step).map(|angle| (at(angle), plain(angle))).collect()
}

#[cfg(test)]
mod tests {
    use super::distance;

    #[test]
    fn angles_are_folded_to_the_nearest_axis() {
        let angles = [0.0, 22.5, 45.0, 67.5, 90.0, 135.0, 337.5, -10.0, 370.0];
        assert_eq!(angles.map(distance), [0.0, 22.5, 45.0, 22.5, 0.0, 45.0, 22.5, 10.0, 10.0]);
    }
}
