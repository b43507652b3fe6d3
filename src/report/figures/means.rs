//! Figure 4 of Bangay's paper: the mean rating by one factor, one line a level of the other, and the reverse; measured,
//! and as the model of vision predicts it.

use std::collections::HashMap;

use plotters::style::text_anchor::HPos;

use super::{
    Figure,
    axes::{EDGE, Levels, PANEL, Panel, Values, below},
    labels as text,
    palette::{Look, MARKER, MOST_SERIES, TEXT},
    regroup::{by_interest, project},
    svg::{Canvas, Drawn, Setting, WIDTH, drawing},
};
use crate::analysis::{
    Results,
    bootstrap::Interval,
    counts::{Counts, Factor},
    summary::{Group, by_cell},
};

/// Longest name in the legend.
const LONGEST_NAME: f64 = 180.0;

/// `figure4a` and, of two factors, `figure4b`: width and depth where there are both.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let counts = &results.measured.counts;
    match by_interest(counts)[..] {
        [] => Vec::new(),
        [only] => {
            let groups = &results.factors[only].levels;
            let mean =
                |level: &str| mean_of(groups.iter().find(|group| group.names.first().is_some_and(|n| n == level))?);
            Chart::of_one(results, &counts.factors[only], mean).figure("figure4a").into_iter().collect()
        }
        [first, second, ..] => {
            let pair = project(counts, &[first, second]);
            let groups = if counts.factors.len() == 2 && (first, second) == (0, 1) {
                results.cells.clone()
            } else {
                by_cell(&pair, &results.options.bootstrap)
            };
            let mean = |levels: [&str; 2]| mean_of(groups.iter().find(|group| group.names == levels)?);
            of_pair(results, &pair, mean, Source::Ratings, ["figure4a", "figure4b"])
        }
    }
}

/// `figure4a_predicted` and, of two factors, `figure4b_predicted`: what is expected in each of the counts' conditions,
/// averaged as the ratings are.
pub(super) fn predicted(results: &Results, expected: &[Option<f64>]) -> Vec<Figure> {
    let counts = &results.measured.counts;
    match by_interest(counts)[..] {
        [] => Vec::new(),
        [only] => {
            let means = expected_means(counts, &[only], expected);
            let mean = |level: &str| means.get([level].as_slice()).copied().map(Mean::bare);
            let chart = Chart { source: Source::Model, ..Chart::of_one(results, &counts.factors[only], mean) };
            chart.figure("figure4a_predicted").into_iter().collect()
        }
        [first, second, ..] => {
            let pair = project(counts, &[first, second]);
            let means = expected_means(counts, &[first, second], expected);
            let mean = |levels: [&str; 2]| means.get(levels.as_slice()).copied().map(Mean::bare);
            of_pair(results, &pair, mean, Source::Model, ["figure4a_predicted", "figure4b_predicted"])
        }
    }
}

/// The chart by each of two factors, one line a level of the other; `mean` is that of a level of each.
fn of_pair(
    results: &Results,
    pair: &Counts,
    mean: impl Fn([&str; 2]) -> Option<Mean>,
    source: Source,
    names: [&'static str; 2],
) -> Vec<Figure> {
    let [first, second] = [0, 1].map(|index| &pair.factors[index]);
    let by_first = Chart::of_two(results, first, second, |x, line| mean([x, line]));
    let by_second = Chart::of_two(results, second, first, |x, line| mean([line, x]));
    let charts = [by_first, by_second].into_iter().zip(names);
    charts.filter_map(|(chart, name)| Chart { source, ..chart }.figure(name)).collect()
}

/// Means of what is expected by the levels of some factors, each condition with the weight of its ratings.
fn expected_means<'a>(counts: &'a Counts, factors: &[usize], expected: &[Option<f64>]) -> HashMap<Vec<&'a str>, f64> {
    let mut sums: HashMap<Vec<&str>, (f64, f64)> = HashMap::new();
    for row in &counts.rows {
        let Some(rating) = expected.get(row.condition as usize).copied().flatten() else { continue };
        let levels = counts.level_names(row.condition);
        let (sum, n) = sums.entry(factors.iter().map(|factor| levels[*factor]).collect()).or_default();
        *sum += rating * row.count as f64;
        *n += row.count as f64;
    }
    sums.into_iter().map(|(levels, (sum, n))| (levels, sum / n)).collect()
}

/// A mean and how sure it is.
#[derive(Clone, Copy)]
struct Mean {
    mean: f64,
    interval: Option<Interval>,
}

impl Mean {
    /// Without an interval.
    fn bare(mean: f64) -> Self {
        Self { mean, interval: None }
    }
}

fn mean_of(group: &Group) -> Option<Mean> {
    Some(Mean { mean: group.summary.mean, interval: group.summary.interval })
}

/// Where means come from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Source {
    Ratings,
    Model,
}

/// A chart of means.
struct Chart<'a> {
    results: &'a Results,
    x: &'a Factor,
    lines: Vec<Line>,
    /// What the lines are, and how many of its levels there are; none of a single line.
    by: Option<&'a Factor>,
    source: Source,
}

/// The means along a line, by level of the factor across.
struct Line {
    name: String,
    look: Look,
    means: Vec<Option<Mean>>,
}

impl<'a> Chart<'a> {
    fn of_one(results: &'a Results, x: &'a Factor, mean: impl Fn(&str) -> Option<Mean>) -> Self {
        let means = x.levels.iter().map(|level| mean(level)).collect();
        let line = Line { name: String::new(), look: Look::only(), means };
        Self { results, x, lines: vec![line], by: None, source: Source::Ratings }
    }

    /// `mean` is that of a level across and one of the lines.
    fn of_two(results: &'a Results, x: &'a Factor, by: &'a Factor, mean: impl Fn(&str, &str) -> Option<Mean>) -> Self {
        let shown = evenly(by.levels.len(), MOST_SERIES);
        let line = |(series, &level): (usize, &usize)| {
            let name = &by.levels[level];
            let look = if shown.len() == 1 { Look::only() } else { Look::of(series) };
            let means = x.levels.iter().map(|level| mean(level, name)).collect();
            Line { name: text::level(name), look, means }
        };
        let lines = shown.iter().enumerate().map(line).collect();
        Self { results, x, lines, by: Some(by), source: Source::Ratings }
    }

    /// What is drawn upwards.
    fn what(&self) -> &'static str {
        match self.source {
            Source::Ratings => text::rating(self.results),
            Source::Model => "Predicted mean rating",
        }
    }

    fn figure(&self, name: &'static str) -> Option<Figure> {
        let (what, by) = (self.what(), text::word(&self.x.name));
        let thing = if Levels::of(self.x).ordered { "line" } else { "marker" };
        let lines = self.by.map_or_else(String::new, |by| {
            let (shown, all) = (self.lines.len(), by.levels.len());
            let some = if shown < all { format!(" ({shown} of {all} are drawn)") } else { String::new() };
            format!(", one {thing} a level of {}{some}", text::word(&by.name))
        });
        let title = match self.by {
            Some(second) => format!("{what} by {by} and {}", text::word(&second.name)),
            None => format!("{what} by {by}"),
        };
        let from = match self.source {
            Source::Ratings => text::bars(self.results),
            Source::Model => "by the model of vision, its criterion fitted to the ratings".to_owned(),
        };
        let caption = format!("{what} by {by}{lines}; {from}.");
        let svg = self.svg(&title, &caption)?;
        Some(Figure { name, title, caption, wide: false, svg })
    }

    fn svg(&self, title: &str, caption: &str) -> Option<String> {
        let values = Values::ratings(&self.results.measured.counts);
        let levels = Levels::of(self.x);
        let left = values.margin();
        let right = WIDTH - EDGE - self.legend_width();
        let labels = levels.labels(right - left);
        let bottom = EDGE + PANEL;
        let panel = Panel { left, right, top: EDGE, bottom, low: values.low, high: values.high };
        drawing(bottom + below(labels.height), title, caption, |canvas| {
            values.draw(canvas, &panel, Some(self.what()))?;
            levels.draw(canvas, &panel, &labels, &text::axis(&self.x.name))?;
            self.series(canvas, &panel, &levels)?;
            self.legend(canvas, &panel)
        })
    }

    fn series(&self, canvas: &Canvas<'_>, panel: &Panel, levels: &Levels) -> Drawn {
        let count = self.lines.len() as f64;
        // Beside each other, so that no interval hides another; lines allow less of it than points alone.
        let most = if levels.ordered { 10.0 } else { 26.0 };
        let step = (0.75 * levels.gap() * panel.width() / count).min(most);
        for (index, line) in self.lines.iter().enumerate() {
            let shift = (index as f64 - (count - 1.0) / 2.0) * step;
            let points: Vec<Option<(f64, f64)>> = (levels.at.iter().zip(&line.means))
                .map(|(&at, mean)| mean.map(|mean| (panel.x(at) + shift, panel.y(mean.mean))))
                .collect();
            if levels.ordered {
                for run in points.split(Option::is_none).filter(|run| run.len() > 1) {
                    canvas.line(&run.iter().flatten().copied().collect::<Vec<_>>(), line.look.stroke())?;
                }
            }
            for (point, mean) in points.iter().zip(&line.means) {
                let (Some((x, _)), Some(interval)) = (point, mean.and_then(|mean| mean.interval)) else { continue };
                canvas.interval(*x, panel.y(interval.low), panel.y(interval.high), 5.0, line.look.bar())?;
            }
            for point in points.into_iter().flatten() {
                canvas.marker(point, MARKER, line.look)?;
            }
        }
        Ok(())
    }

    fn legend_width(&self) -> f64 {
        let Some(by) = self.by.filter(|_| self.lines.len() > 1) else { return 0.0 };
        let widest = self.lines.iter().map(|line| text::width(&line.name, TEXT).min(LONGEST_NAME)).fold(0.0, f64::max);
        let heading = text::width(&text::heading(&by.name), 1.2 * TEXT).min(56.0 + LONGEST_NAME);
        24.0 + f64::max(56.0 + widest, heading)
    }

    fn legend(&self, canvas: &Canvas<'_>, panel: &Panel) -> Drawn {
        let Some(by) = self.by.filter(|_| self.lines.len() > 1) else { return Ok(()) };
        let x = panel.right + 24.0;
        let pitch = (PANEL / (self.lines.len() as f64 + 1.0)).min(1.35 * TEXT);
        let heading = text::fit(&text::heading(&by.name), 56.0 + LONGEST_NAME, TEXT);
        canvas.text(&heading, (x, panel.top + 0.5 * TEXT), Setting::new(TEXT, HPos::Left).bold())?;
        for (index, line) in self.lines.iter().enumerate() {
            let y = panel.top + 0.5 * TEXT + (index as f64 + 1.0) * pitch;
            let name = text::fit(&line.name, LONGEST_NAME, TEXT);
            canvas.legend_entry((x, y), line.look, Levels::of(self.x).ordered, &name, TEXT)?;
        }
        Ok(())
    }
}

/// At most so many of the first numbers, evenly, the first and the last among them.
pub(super) fn evenly(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|index| (index * (count - 1) + (most - 1) / 2) / (most - 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::evenly;

    #[test]
    fn few_of_many_are_spread_to_both_ends() {
        assert_eq!(evenly(3, 12), [0, 1, 2]);
        let some = evenly(30, 12);
        assert_eq!((some.len(), some[0], some[11]), (12, 0, 29));
        assert!(some.windows(2).all(|pair| (2..=3).contains(&(pair[1] - pair[0]))), "{some:?}");
    }
}
