//! Figure 4 of Bangay's paper: the mean rating by one factor, one line a level of the other, and the reverse; measured,
//! and as the model of vision predicts it.

use std::collections::HashMap;

use super::{
    axes::{EDGE, Levels, MARKER, PANEL, Panel, TEXT, Values, below},
    figure::Figure,
    labels,
    palette::{MOST_SERIES, Series},
    regroup::{by_interest, evenly, project},
    svg::{Anchor, Font, Point, Svg, WIDTH},
};
use crate::analysis::{
    Results,
    bootstrap::Interval,
    counts::{Counts, Factor},
    summary::by_cell,
};

/// Longest name in the legend.
const LONGEST_NAME: f64 = 180.0;

/// A mean and how sure it is.
type Mean = (f64, Option<Interval>);

/// Means by the levels of the factors shown.
type Means = HashMap<Vec<String>, Mean>;

/// `figure4a` and, of two factors, `figure4b`: width and depth where there are both.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let counts = project(&results.measured.counts, &chosen(results));
    let groups = by_cell(&counts, &results.options.bootstrap).into_iter();
    let means = groups.map(|group| (group.names, (group.summary.mean, group.summary.interval))).collect();
    let names = ["figure4a", "figure4b"];
    charts(&counts, &means, names, labels::rating(results), &labels::bars(results))
}

/// Figure 4 as the model of vision predicts it: `figure4a_predicted`, `figure4b_predicted`. `expected` is the rating in
/// each of the counts' conditions, in the numbers of the categories; `None` where nothing is predicted. Conditions are
/// averaged with the weight of their ratings.
pub fn predicted(results: &Results, expected: &[Option<f64>]) -> Vec<Figure> {
    let (counts, factors) = (&results.measured.counts, chosen(results));
    let mut sums: HashMap<Vec<String>, (f64, f64)> = HashMap::new();
    for row in &counts.rows {
        let Some(rating) = expected.get(row.condition as usize).copied().flatten() else { continue };
        let levels = counts.level_names(row.condition);
        let (sum, n) = sums.entry(factors.iter().map(|&factor| levels[factor].to_owned()).collect()).or_default();
        *sum += rating * row.count as f64;
        *n += row.count as f64;
    }
    let means = sums.into_iter().map(|(levels, (sum, n))| (levels, (sum / n, None))).collect();
    let names = ["figure4a_predicted", "figure4b_predicted"];
    let source = "by the model of vision, its criterion fitted to the ratings";
    charts(&project(counts, &factors), &means, names, "Predicted mean rating", source)
}

/// The two factors of most interest.
fn chosen(results: &Results) -> Vec<usize> {
    by_interest(&results.measured.counts).into_iter().take(2).collect()
}

/// The chart by each factor, one line a level of the other.
fn charts(counts: &Counts, means: &Means, names: [&'static str; 2], what: &str, source: &str) -> Vec<Figure> {
    let chart = |(x, name): (usize, &'static str)| {
        let by = (counts.factors.len() == 2).then_some(1 - x);
        chart(counts, means, x, by).figure(name, what, source)
    };
    (0..counts.factors.len()).zip(names).map(chart).collect()
}

/// A chart of means.
struct Chart<'a> {
    counts: &'a Counts,
    x: &'a Factor,
    levels: Levels,
    lines: Vec<Line>,
    /// What the lines are; none of a single line.
    by: Option<&'a Factor>,
}

/// The means along a line, by level of the factor across.
struct Line {
    name: String,
    series: Series,
    means: Vec<Option<Mean>>,
}

fn chart<'a>(counts: &'a Counts, means: &Means, x: usize, by: Option<usize>) -> Chart<'a> {
    let across = &counts.factors[x].levels;
    let mean = |level: &String, line: Option<&String>| {
        let mut key = vec![level.clone()];
        key.extend(line.cloned());
        if x == 1 {
            key.reverse();
        }
        means.get(&key).copied()
    };
    let lines = match by.map(|by| &counts.factors[by].levels) {
        None => {
            let means = across.iter().map(|level| mean(level, None)).collect();
            vec![Line { name: String::new(), series: Series::only(), means }]
        }
        Some(names) => {
            let shown = evenly(names.len(), MOST_SERIES);
            let line = |(index, &level): (usize, &usize)| Line {
                name: labels::level(&names[level]),
                series: if shown.len() == 1 { Series::only() } else { Series::of(index) },
                means: across.iter().map(|x| mean(x, Some(&names[level]))).collect(),
            };
            shown.iter().enumerate().map(line).collect()
        }
    };
    let (x, by) = (&counts.factors[x], by.map(|by| &counts.factors[by]));
    Chart { counts, x, levels: Levels::of(x), lines, by }
}

impl Chart<'_> {
    fn figure(&self, name: &'static str, what: &str, source: &str) -> Figure {
        let x = labels::in_sentence(&self.x.name);
        let (mut title, mut caption) = (format!("{what} by {x}"), format!("{what} by {x}"));
        if let Some(by) = self.by {
            let thing = if self.levels.ordered { "line" } else { "marker" };
            let some = labels::some_of(self.lines.len(), by.levels.len());
            title += &format!(" and {}", labels::in_sentence(&by.name));
            caption += &format!(", one {thing} a level of {}{some}", labels::in_sentence(&by.name));
        }
        caption += &format!("; {source}.");
        let values = Values::ratings(self.counts);
        let panel = values.panel(values.margin(), WIDTH - EDGE - self.legend_width(), EDGE, PANEL);
        let below_axis = self.levels.labels(panel.width());
        Figure::draw(name, title, caption, panel.bottom + below(below_axis.height), |svg| {
            values.draw(svg, &panel, Some(what));
            self.levels.draw(svg, &panel, &below_axis, labels::axis(&self.x.name));
            self.draw(svg, &panel);
            self.legend(svg, &panel);
        })
    }

    fn draw(&self, svg: &mut Svg, panel: &Panel) {
        let (levels, count) = (&self.levels, self.lines.len() as f64);
        // Beside each other, so that no interval hides another; lines allow less of it than points alone.
        let most = if levels.ordered { 10.0 } else { 26.0 };
        let step = (0.75 * levels.gap() * panel.width() / count).min(most);
        for (index, line) in self.lines.iter().enumerate() {
            let shift = (index as f64 - (count - 1.0) / 2.0) * step;
            let points: Vec<Option<Point>> = (levels.at.iter().zip(&line.means))
                .map(|(&at, mean)| mean.map(|(mean, _)| (panel.x(at) + shift, panel.y(mean))))
                .collect();
            if levels.ordered {
                for run in points.split(Option::is_none).filter(|run| run.len() > 1) {
                    svg.line(&run.iter().flatten().copied().collect::<Vec<_>>(), line.series.line());
                }
            }
            for (point, mean) in points.iter().zip(&line.means) {
                if let (Some((x, _)), Some((_, Some(interval)))) = (point, mean) {
                    svg.interval(*x, panel.y(interval.low), panel.y(interval.high), 5.0, line.series.bar());
                }
            }
            for point in points.into_iter().flatten() {
                svg.marker(point, MARKER, line.series);
            }
        }
    }

    /// The heading of the legend; none of a single line.
    fn heading(&self) -> Option<String> {
        let by = self.by.filter(|_| self.lines.len() > 1)?;
        Some(labels::fit(labels::heading(&by.name), 56.0 + LONGEST_NAME, TEXT))
    }

    fn legend_width(&self) -> f64 {
        let Some(heading) = self.heading() else { return 0.0 };
        let names = self.lines.iter().map(|line| labels::width(&line.name, TEXT).min(LONGEST_NAME));
        24.0 + names.fold(0.0, f64::max).max(1.2 * labels::width(&heading, TEXT) - 56.0) + 56.0
    }

    fn legend(&self, svg: &mut Svg, panel: &Panel) {
        let Some(heading) = self.heading() else { return };
        let (x, top) = (panel.right + 24.0, panel.top + 0.5 * TEXT);
        let pitch = (PANEL / (self.lines.len() as f64 + 1.0)).min(1.35 * TEXT);
        svg.text(&heading, (x, top), Font::new(TEXT, Anchor::Start).bold());
        for (index, line) in self.lines.iter().enumerate() {
            let name = labels::fit(&line.name, LONGEST_NAME, TEXT);
            let y = top + (index as f64 + 1.0) * pitch;
            svg.legend_entry((x, y), line.series, self.levels.ordered, &name, TEXT);
        }
    }
}
