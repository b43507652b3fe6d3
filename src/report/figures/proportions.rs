//! A chart of how often each category was used, with one bar for each level of the first factor and one panel for each
//! level of the second.

use super::{
    axes::{EDGE, TEXT},
    choice::{chosen, evenly},
    figure::Figure,
    labels,
    palette::{AXIS, Rgb, Stroke, WHITE, category},
    svg::{Anchor, Font, Point, Svg, WIDTH},
};
use crate::analysis::{
    Results,
    counts::{Counts, Factor},
};

/// Text size in a chart that is as wide as the page.
const SMALL: f64 = 20.0;
/// Maximum number of panels in a chart.
const MAX_PANELS: usize = 10;
/// Maximum number of panels in a row.
const PER_ROW: usize = 5;
/// Maximum number of categories in the legend; readers can interpolate the colors in between.
const MAX_NAMED: usize = 10;
/// Maximum number of bars in a panel.
const MAX_BARS: usize = 40;

/// The layout of the chart.
struct Chart<'a> {
    results: &'a Results,
    /// The factors of bars and panels.
    factors: Vec<&'a Factor>,
    /// The number of ratings in each category, by panel and bar.
    tallies: Vec<Vec<Vec<u64>>>,
    /// Level and name of each bar.
    bars: Vec<(usize, String)>,
    /// Level and name of each panel.
    panels: Vec<(usize, String)>,
    size: f64,
    /// Distance between bars.
    pitch: f64,
    /// Width of the names of the bars.
    label: f64,
}

/// Draws `proportions`.
pub(super) fn figure(results: &Results) -> Option<Figure> {
    let counts = &results.measured.counts;
    let chosen = chosen(counts);
    let tallies = tallies(counts, &chosen);
    if tallies.iter().flatten().flatten().all(|count| *count == 0) {
        return None;
    }
    let factors: Vec<&Factor> = chosen.iter().map(|&factor| &counts.factors[factor]).collect();
    let bars = shown(factors.first(), MAX_BARS);
    let panels = shown(factors.get(1), MAX_PANELS);
    let mut title = "How often each rating was given".to_owned();
    let mut caption = "Proportions of the ratings".to_owned();
    let drawn = [("bar", ", by ", bars.len()), ("panel", " and ", panels.len())];
    for (factor, (thing, by, drawn)) in factors.iter().zip(drawn) {
        let (name, some) = (labels::in_sentence(results, &factor.name), labels::some_of(drawn, factor.levels.len()));
        title += &format!("{by}{name}");
        caption += &format!(", one {thing} for each level of {name}{some}");
    }
    caption += &format!("; {}.", labels::sample(results));
    let size = if panels.len() > 1 { SMALL } else { TEXT };
    let widest = bars.iter().map(|(_, name)| labels::width(name, size)).fold(0.0, f64::max);
    let wide = panels.len() > 1;
    let chart =
        Chart { results, factors, tallies, bars, panels, size, pitch: 1.5 * size, label: widest.min(12.0 * size) };
    Some(Figure { wide, ..chart.figure(title, caption) })
}

/// Returns the levels to show, or a single level without a name if there is no factor.
fn shown(factor: Option<&&Factor>, most: usize) -> Vec<(usize, String)> {
    let Some(factor) = factor else { return vec![(0, String::new())] };
    evenly(factor.levels.len(), most).into_iter().map(|level| (level, labels::level(&factor.levels[level]))).collect()
}

/// Counts the ratings in each category, by level of the second factor and then of the first. Ratings that lack one of these
/// levels are left out.
fn tallies(counts: &Counts, factors: &[usize]) -> Vec<Vec<Vec<u64>>> {
    let levels = |index: usize| factors.get(index).map_or(1, |factor| counts.factors[*factor].levels.len());
    let mut tallies = vec![vec![vec![0; counts.categories.len()]; levels(0)]; levels(1)];
    for row in &counts.rows {
        let condition = &counts.conditions[row.condition as usize];
        let level = |index: usize| factors.get(index).map_or(Some(0), |factor| condition[*factor]);
        if let (Some(bar), Some(panel)) = (level(0), level(1)) {
            tallies[panel as usize][bar as usize][usize::from(row.rating)] += row.count;
        }
    }
    tallies
}

impl Chart<'_> {
    fn figure(&self, title: String, caption: String) -> Figure {
        let size = self.size;
        let abreast =
            if self.panels.len() <= PER_ROW { self.panels.len() } else { self.panels.len().div_ceil(2).min(PER_ROW) };
        let left = EDGE + if !self.factors.is_empty() { 1.5 * size + self.label + 10.0 } else { 0.0 };
        let (right, gap) = (WIDTH - 1.5 * size, 1.2 * size);
        let width = (right - left + gap) / abreast as f64 - gap;
        let legend = self.legend();
        let lines = legend.last().map_or(1.0, |(.., line)| line + 1.0);
        let heading = if self.factors.len() > 1 { 1.7 * size } else { 0.3 * size };
        let top = EDGE + (1.5 * lines + 0.3) * size;
        let block = heading + self.pitch * self.bars.len() as f64 + 2.3 * size;
        let bottom = top + block * self.panels.len().div_ceil(abreast) as f64;
        Figure::draw("proportions", title, caption, bottom + 1.6 * size + EDGE, |svg| {
            svg.text("Rating", (EDGE, EDGE + 0.5 * size), Font::new(size, Anchor::Start).bold());
            for (color, name, x, line) in legend {
                let y = EDGE + (0.5 + 1.5 * line) * size;
                svg.rectangle((x, y - 0.45 * size), (x + 1.2 * size, y + 0.45 * size), color);
                svg.text(&name, (x + 1.5 * size, y), Font::new(size, Anchor::Start));
            }
            for (index, (level, name)) in self.panels.iter().enumerate() {
                let (row, column) = (index / abreast, index % abreast);
                let at = (left + column as f64 * (width + gap), top + row as f64 * block + heading);
                self.panel(svg, name, &self.tallies[*level], at, width);
                if column == 0 {
                    self.names(svg, at);
                }
            }
            let below = Font::new(size, Anchor::Middle).below();
            svg.text("Ratings (%)", ((left + right) / 2.0, bottom - 0.3 * size), below);
        })
    }

    /// Draws a panel's heading and bars, with the axis below.
    fn panel(&self, svg: &mut Svg, name: &str, tallies: &[Vec<u64>], (left, top): Point, width: f64) {
        let (size, pitch) = (self.size, self.pitch);
        if let Some(factor) = self.factors.get(1) {
            // A text is self-explanatory, but a number needs the factor's name.
            let heading = match &factor.numbers {
                Some(_) => format!("{} {name}", labels::in_sentence(self.results, &factor.name)),
                None => name.to_owned(),
            };
            let at = (left + width / 2.0, top - 0.75 * size);
            svg.text(&labels::fit(&heading, width, size), at, Font::new(size, Anchor::Middle).bold());
        }
        for (index, (level, _)) in self.bars.iter().enumerate() {
            self.bar(svg, &tallies[*level], (left, top + pitch * index as f64), width);
        }
        let bottom = top + pitch * self.bars.len() as f64;
        svg.line(&[(left, bottom), (left + width, bottom)], AXIS);
        // The outer labels are shifted inward, away from the labels of the next panel.
        for (percent, anchor) in [(0, Anchor::Start), (50, Anchor::Middle), (100, Anchor::End)] {
            let x = left + f64::from(percent) / 100.0 * width;
            svg.line(&[(x, bottom), (x, bottom + 6.0)], AXIS);
            if percent != 50 || width > 7.0 * size {
                svg.text(&percent.to_string(), (x, bottom + 9.0), Font::new(size, anchor).below());
            }
        }
    }

    fn bar(&self, svg: &mut Svg, tally: &[u64], (left, top): Point, width: f64) {
        let (size, pitch) = (self.size, self.pitch);
        let n: u64 = tally.iter().sum();
        if n == 0 {
            let at = (left + 0.4 * size, top + pitch / 2.0);
            return svg.text("no ratings", at, Font::new(0.85 * size, Anchor::Start));
        }
        let (high, low) = (top + 0.12 * pitch, top + 0.88 * pitch);
        let mut from = left;
        for (index, &count) in tally.iter().enumerate().filter(|(_, count)| **count > 0) {
            let to = from + count as f64 / n as f64 * width;
            let percent = 100.0 * count as f64 / n as f64;
            let text = format!(
                "{}: {count} of {n}, {percent:.0} %",
                labels::level(&self.results.measured.counts.categories[index])
            );
            svg.bar((from, high), (to, low), category(index, tally.len()), text);
            if from > left && to - from > 5.0 {
                svg.line(&[(from, high), (from, low)], Stroke::new(WHITE, 1.6));
            }
            from = to;
        }
    }

    /// Draws the names of the bars and of their factor.
    fn names(&self, svg: &mut Svg, (left, top): Point) {
        let Some(factor) = self.factors.first() else { return };
        let (size, pitch) = (self.size, self.pitch);
        for (index, (_, name)) in self.bars.iter().enumerate() {
            let at = (left - 10.0, top + pitch * (index as f64 + 0.5));
            svg.text(&labels::fit(name, self.label, size), at, Font::new(size, Anchor::End));
        }
        let length = pitch * self.bars.len() as f64;
        let title = labels::fit(&labels::heading(self.results, &factor.name), length.max(4.0 * size), size);
        let at = (EDGE + 0.5 * size, top + length / 2.0);
        svg.text(&title, at, Font::new(size, Anchor::Middle).upright());
    }

    /// Returns the entries of the legend: color, name, left end, and line of the legend from 0.
    fn legend(&self) -> Vec<(Rgb, String, f64, f64)> {
        let (size, categories) = (self.size, &self.results.measured.counts.categories);
        let first = EDGE + labels::width("Rating", 1.2 * size) + size;
        let (mut x, mut line) = (first, 0.0);
        let entry = |index: usize| {
            let name = labels::fit(&labels::level(&categories[index]), 16.0 * size, size);
            let width = 2.6 * size + labels::width(&name, size);
            if x + width > WIDTH - EDGE && x > first {
                (x, line) = (first, line + 1.0);
            }
            x += width;
            (category(index, categories.len()), name, x - width, line)
        };
        evenly(categories.len(), MAX_NAMED).into_iter().map(entry).collect()
    }
}
