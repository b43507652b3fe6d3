//! Every subject's mean rating by the first factor, and the mean of all.

use plotters::style::{RGBColor, text_anchor::HPos};

use super::{
    Figure,
    axes::{EDGE, Levels, PANEL, Panel, Values, below},
    labels as text,
    palette::{Look, MARKER, TEXT},
    regroup::{by_interest, project},
    svg::{Canvas, Drawn, Setting, Stroke, WIDTH, drawing},
};
use crate::analysis::{Results, summary::category_values};

/// Of one subject.
const GREY: RGBColor = RGBColor(120, 120, 120);

/// `subjects`.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    by_interest(&results.measured.counts).first().and_then(|&factor| figure(results, factor)).into_iter().collect()
}

fn figure(results: &Results, factor: usize) -> Option<Figure> {
    let counts = &results.measured.counts;
    let by = text::word(&counts.factors[factor].name);
    let title = format!("{} of every subject by {by}", text::rating(results));
    let caption = if results.is_inferential() {
        format!(
            "{} by {by}: a grey line is one subject, the thick line the mean of all ratings; {}.",
            text::rating(results),
            text::sample(results)
        )
    } else {
        format!("{} of the only subject by {by}; {}.", text::rating(results), text::sample(results))
    };
    let svg = svg(results, factor, &title, &caption)?;
    Some(Figure { name: "subjects", title, caption, wide: false, svg })
}

fn svg(results: &Results, factor: usize, title: &str, caption: &str) -> Option<String> {
    let counts = &results.measured.counts;
    let by = &counts.factors[factor];
    let values = Values::ratings(counts);
    let levels = Levels::of(by);
    let several = results.is_inferential();
    let top = if several { EDGE + 1.5 * TEXT } else { EDGE };
    let (left, right) = (values.margin(), WIDTH - EDGE);
    let labels = levels.labels(right - left);
    let panel = Panel { left, right, top, bottom: top + PANEL, low: values.low, high: values.high };
    let people = counts.subjects.len();
    let thin = Stroke {
        alpha: (12.0 / people as f64).clamp(0.25, 0.75),
        ..Stroke::new(GREY, if people > 40 { 1.4 } else { 2.0 })
    };
    drawing(panel.bottom + below(labels.height), title, caption, |canvas| {
        values.draw(canvas, &panel, Some(text::rating(results)))?;
        levels.draw(canvas, &panel, &labels, &text::axis(&by.name))?;
        if several {
            for means in subject_means(results, factor) {
                path(canvas, &panel, &levels, &means, thin)?;
            }
            legend(canvas, &panel, thin)?;
        }
        let group = |level: &String| {
            let group = results.factors[factor].levels.iter().find(|group| group.names.first() == Some(level));
            group.map(|group| group.summary.mean)
        };
        let means: Vec<Option<f64>> = by.levels.iter().map(group).collect();
        path(canvas, &panel, &levels, &means, Stroke { width: 5.0, ..Look::only().stroke() })?;
        for (&at, mean) in levels.at.iter().zip(means) {
            if let Some(mean) = mean {
                canvas.marker((panel.x(at), panel.y(mean)), MARKER + 1.0, Look::only())?;
            }
        }
        Ok(())
    })
}

/// Mean rating of each subject at each level.
fn subject_means(results: &Results, factor: usize) -> Vec<Vec<Option<f64>>> {
    let counts = project(&results.measured.counts, &[factor]);
    let values = category_values(&counts);
    let mut sums = vec![vec![(0.0, 0.0); counts.factors[0].levels.len()]; counts.subjects.len()];
    for row in &counts.rows {
        let Some(level) = counts.conditions[row.condition as usize][0] else { continue };
        let (n, sum) = &mut sums[row.subject as usize][level as usize];
        *n += row.count as f64;
        *sum += row.count as f64 * values[usize::from(row.rating)];
    }
    let mean = |(n, sum): (f64, f64)| (n > 0.0).then(|| sum / n);
    sums.into_iter().map(|levels| levels.into_iter().map(mean).collect()).collect()
}

/// A line through the means, with gaps where there are none.
fn path(canvas: &Canvas<'_>, panel: &Panel, levels: &Levels, means: &[Option<f64>], stroke: Stroke) -> Drawn {
    let points: Vec<Option<(f64, f64)>> =
        (levels.at.iter().zip(means)).map(|(&at, mean)| mean.map(|mean| (panel.x(at), panel.y(mean)))).collect();
    for run in points.split(Option::is_none) {
        match *run {
            // Too short for a line: a dash.
            [Some((x, y))] => canvas.line(&[(x - 5.0, y), (x + 5.0, y)], stroke)?,
            _ => canvas.line(&run.iter().flatten().copied().collect::<Vec<_>>(), stroke)?,
        }
    }
    Ok(())
}

/// Above the panel, where there are no ratings.
fn legend(canvas: &Canvas<'_>, panel: &Panel, thin: Stroke) -> Drawn {
    let (x, y) = (panel.left, EDGE + 0.5 * TEXT);
    canvas.line(&[(x, y), (x + 46.0, y)], Stroke { alpha: 0.8, width: 2.0, ..thin })?;
    canvas.text("one subject", (x + 56.0, y), Setting::new(TEXT, HPos::Left))?;
    let x = x + 56.0 + text::width("one subject", TEXT) + 30.0;
    canvas.line(&[(x, y), (x + 46.0, y)], Stroke { width: 5.0, ..Look::only().stroke() })?;
    canvas.legend_entry((x, y), Look::only(), false, "all ratings", TEXT)
}
