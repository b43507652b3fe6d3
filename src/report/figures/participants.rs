//! Every participant's mean rating by the first factor, and the mean of all.

use super::{
    axes::{EDGE, Levels, MARKER, PANEL, Panel, TEXT, Values, below},
    figure::Figure,
    labels,
    palette::{GRAY, Series, Stroke},
    regroup::{by_interest, project},
    svg::{Anchor, Font, Point, Svg, WIDTH},
};
use crate::analysis::{Results, summary::category_values};

/// `subjects`.
pub(super) fn figure(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let factor = *by_interest(counts).first()?;
    let by = &counts.factors[factor];
    let (what, name, sample) = (labels::rating(results), labels::in_sentence(&by.name), labels::sample(results));
    let several = results.is_inferential();
    let title = format!("{what} of every participant by {name}");
    let caption = if several {
        format!("{what} by {name}: a gray line is one participant, the thick line the mean of all ratings; {sample}.")
    } else {
        format!("{what} of the only participant by {name}; {sample}.")
    };
    let (values, levels) = (Values::ratings(counts), Levels::of(by));
    let top = if several { EDGE + 1.5 * TEXT } else { EDGE };
    let panel = values.panel(values.margin(), WIDTH - EDGE, top, PANEL);
    let below_axis = levels.labels(panel.width());
    let people = results.people() as f64;
    let thin = Stroke {
        opacity: (12.0 / people).clamp(0.25, 0.75),
        ..Stroke::new(GRAY, if people > 40.0 { 1.4 } else { 2.0 })
    };
    let thick = Stroke { width: 5.0, ..Series::only().line() };
    Some(Figure::draw("subjects", title, caption, panel.bottom + below(below_axis.height), |svg| {
        values.draw(svg, &panel, Some(what));
        levels.draw(svg, &panel, &below_axis, labels::axis(&by.name));
        if several {
            for means in participant_means(results, factor) {
                path(svg, &panel, &levels, &means, thin);
            }
            legend(svg, panel.left, thin, thick);
        }
        let mean = |level: &String| {
            let group = results.factors[factor].levels.iter().find(|group| group.names.first() == Some(level));
            group.map(|group| group.summary.mean)
        };
        let means: Vec<Option<f64>> = by.levels.iter().map(mean).collect();
        path(svg, &panel, &levels, &means, thick);
        for (&at, mean) in levels.at.iter().zip(means) {
            if let Some(mean) = mean {
                svg.marker((panel.x(at), panel.y(mean)), MARKER + 1.0, Series::only());
            }
        }
    }))
}

/// Mean rating of each participant at each level.
fn participant_means(results: &Results, factor: usize) -> Vec<Vec<Option<f64>>> {
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
fn path(svg: &mut Svg, panel: &Panel, levels: &Levels, means: &[Option<f64>], stroke: Stroke) {
    let points: Vec<Option<Point>> =
        (levels.at.iter().zip(means)).map(|(&at, mean)| mean.map(|mean| (panel.x(at), panel.y(mean)))).collect();
    for run in points.split(Option::is_none) {
        match *run {
            // Too short for a line: a dash.
            [Some((x, y))] => svg.line(&[(x - 5.0, y), (x + 5.0, y)], stroke),
            _ => svg.line(&run.iter().flatten().copied().collect::<Vec<_>>(), stroke),
        }
    }
}

/// Above the panel, where there are no ratings.
fn legend(svg: &mut Svg, left: f64, thin: Stroke, thick: Stroke) {
    const ONE: &str = "one participant";
    let y = EDGE + 0.5 * TEXT;
    svg.line(&[(left, y), (left + 46.0, y)], Stroke { opacity: 0.8, width: 2.0, ..thin });
    svg.text(ONE, (left + 56.0, y), Font::new(TEXT, Anchor::Start));
    let x = left + 56.0 + labels::width(ONE, TEXT) + 30.0;
    svg.line(&[(x, y), (x + 46.0, y)], thick);
    svg.legend_entry((x, y), Series::only(), false, "all ratings", TEXT);
}
