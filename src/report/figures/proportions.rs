//! How often each category was used: a bar a level of the first factor, a panel a level of the second.

use plotters::style::{
    WHITE,
    text_anchor::{HPos, VPos},
};

use super::{
    Figure,
    axes::{EDGE, middle},
    labels as text,
    means::evenly,
    palette::{AXIS, SMALL, TEXT, category},
    regroup::{by_interest, project},
    svg::{Canvas, Drawn, Setting, Stroke, WIDTH, drawing},
};
use crate::analysis::{
    Results,
    counts::{Counts, Factor},
};

/// Most panels of a chart.
const MOST_PANELS: usize = 10;
/// Most panels side by side.
const ABREAST: usize = 5;
/// Most categories in the legend: of more, the colours between are clear.
const MOST_NAMED: usize = 10;
/// Most bars of a panel.
const MOST_BARS: usize = 40;

/// `proportions`.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    figure(results).into_iter().collect()
}

/// What is drawn, and how large.
struct Chart<'a> {
    counts: &'a Counts,
    bars: Vec<Bar>,
    panels: Vec<Part>,
    /// Names of the factors of bars and panels.
    names: (String, String),
    /// Size of text.
    size: f64,
    label: f64,
    abreast: usize,
}

/// A level of the first factor.
struct Bar {
    level: Option<usize>,
    name: String,
}

/// A level of the second factor.
struct Part {
    name: String,
    /// Proportions of each bar; none without ratings.
    shares: Vec<Option<Vec<f64>>>,
}

fn figure(results: &Results) -> Option<Figure> {
    let chosen: Vec<usize> = by_interest(&results.measured.counts).into_iter().take(2).collect();
    let counts = project(&results.measured.counts, &chosen);
    if counts.total() == 0 {
        return None;
    }
    let chart = Chart::new(&counts);
    let by = |names: &[&Factor]| names.iter().map(|f| text::word(&f.name)).collect::<Vec<_>>().join(" and ");
    let factors: Vec<&Factor> = counts.factors.iter().collect();
    let title = match factors[..] {
        [] => "How often each rating was given".to_owned(),
        _ => format!("How often each rating was given, by {}", by(&factors)),
    };
    let caption = format!("Proportions of the ratings{}; {}.", chart.caption(), text::sample(results));
    let svg = chart.svg(&title, &caption)?;
    Some(Figure { name: "proportions", title, caption, wide: chart.panels.len() > 1, svg })
}

impl<'a> Chart<'a> {
    fn new(counts: &'a Counts) -> Self {
        let tallies = tallies(counts);
        let (bars, panels) = (shown(counts.factors.first(), MOST_BARS), shown(counts.factors.get(1), MOST_PANELS));
        let share = |bar: Option<usize>, panel: Option<usize>| {
            let tally = tallies.get(panel.unwrap_or(0))?.get(bar.unwrap_or(0))?;
            let n: u64 = tally.iter().sum();
            (n > 0).then(|| tally.iter().map(|&count| count as f64 / n as f64).collect::<Vec<f64>>())
        };
        let panels: Vec<Part> = panels
            .into_iter()
            .map(|panel| Part {
                shares: bars.iter().map(|bar| share(bar.level, panel.level)).collect(),
                name: panel.name,
            })
            .collect();
        let size = if panels.len() > 1 { SMALL } else { TEXT };
        let widest = bars.iter().map(|bar| text::width(&bar.name, size)).fold(0.0, f64::max);
        let abreast = if panels.len() <= ABREAST { panels.len() } else { panels.len().div_ceil(2).min(ABREAST) };
        let name = |index: usize| counts.factors.get(index).map(|factor| factor.name.clone()).unwrap_or_default();
        Self { counts, bars, panels, names: (name(0), name(1)), size, label: widest.min(12.0 * size), abreast }
    }

    fn caption(&self) -> String {
        let mut parts = Vec::new();
        for (index, shown, thing) in [(0, self.bars.len(), "bar"), (1, self.panels.len(), "panel")] {
            if let Some(factor) = self.counts.factors.get(index) {
                let all = factor.levels.len();
                let some = if shown < all { format!(" ({shown} of {all} are drawn)") } else { String::new() };
                parts.push(format!("one {thing} a level of {}{some}", text::word(&factor.name)));
            }
        }
        if parts.is_empty() { String::new() } else { format!(", {}", parts.join(", ")) }
    }

    /// Distance of two bars.
    fn pitch(&self) -> f64 {
        1.5 * self.size
    }

    fn svg(&self, title: &str, caption: &str) -> Option<String> {
        let size = self.size;
        let left = EDGE + if self.names.0.is_empty() { 0.0 } else { 1.5 * size + self.label + 10.0 };
        let gap = 1.2 * size;
        let width = (WIDTH - 1.5 * size - left + gap) / self.abreast as f64 - gap;
        let legend = self.legend_rows();
        let heading = if self.names.1.is_empty() { 0.3 * size } else { 1.7 * size };
        let bars = self.pitch() * self.bars.len() as f64;
        let rows = self.panels.len().div_ceil(self.abreast);
        let top = EDGE + 1.5 * size * legend.len() as f64 + 0.3 * size;
        let block = heading + bars + 2.3 * size;
        drawing(top + block * rows as f64 + 1.6 * size + EDGE, title, caption, |canvas| {
            self.legend(canvas, &legend)?;
            for (index, panel) in self.panels.iter().enumerate() {
                let (row, column) = (index / self.abreast, index % self.abreast);
                let x = left + column as f64 * (width + gap);
                let y = top + row as f64 * block + heading;
                self.panel(canvas, panel, (x, y), width)?;
                if column == 0 {
                    self.names(canvas, (x, y))?;
                }
            }
            let at = (middle(left, WIDTH - 1.5 * size), top + block * rows as f64 - 0.3 * size);
            let below = Setting { height: VPos::Top, ..Setting::new(size, HPos::Center) };
            canvas.text("Ratings (%)", at, below)
        })
    }

    /// A panel's bars, with the axis below.
    fn panel(&self, canvas: &Canvas<'_>, panel: &Part, (left, top): (f64, f64), width: f64) -> Drawn {
        let (size, pitch) = (self.size, self.pitch());
        if !self.names.1.is_empty() {
            let numbers = self.counts.factors.get(1).is_some_and(|factor| factor.numbers.is_some());
            // A name says what it is; a number does not.
            let heading = match self.names.1.as_str() {
                "depth" => format!("n = {}", panel.name),
                "orientation_deg" => format!("{}°", panel.name),
                name if numbers => format!("{name} = {}", panel.name),
                _ => panel.name.clone(),
            };
            let at = (left + width / 2.0, top - 0.75 * size);
            canvas.text(&text::fit(&heading, width, size), at, Setting::new(size, HPos::Center).bold())?;
        }
        let bottom = top + pitch * self.bars.len() as f64;
        for (index, shares) in panel.shares.iter().enumerate() {
            let y = top + pitch * index as f64;
            let Some(shares) = shares else {
                let at = (left + 0.4 * size, y + pitch / 2.0);
                canvas.text("no ratings", at, Setting::new(0.85 * size, HPos::Left))?;
                continue;
            };
            let mut from = 0.0;
            for (category_index, share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                let ends = [from, from + share].map(|share: f64| left + share.min(1.0) * width);
                let colour = category(category_index, shares.len());
                canvas.rectangle((ends[0], y + 0.12 * pitch), (ends[1], y + 0.88 * pitch), colour)?;
                if from > 0.0 && share * width > 5.0 {
                    let edge = [(ends[0], y + 0.12 * pitch), (ends[0], y + 0.88 * pitch)];
                    canvas.line(&edge, Stroke::new(WHITE, 1.6))?;
                }
                from += share;
            }
        }
        canvas.line(&[(left, bottom), (left + width, bottom)], AXIS)?;
        // The outer ones inwards, away from the next panel's.
        let ticks = [(0.0, HPos::Left, true), (50.0, HPos::Center, width > 7.0 * size), (100.0, HPos::Right, true)];
        for (percent, side, named) in ticks {
            let x = left + percent / 100.0 * width;
            canvas.line(&[(x, bottom), (x, bottom + 6.0)], AXIS)?;
            let below = Setting { height: VPos::Top, ..Setting::new(size, side) };
            if named {
                canvas.text(&percent.to_string(), (x, bottom + 9.0), below)?;
            }
        }
        Ok(())
    }

    /// Names of the bars, and of their factor.
    fn names(&self, canvas: &Canvas<'_>, (left, top): (f64, f64)) -> Drawn {
        if self.names.0.is_empty() {
            return Ok(());
        }
        let (size, pitch) = (self.size, self.pitch());
        for (index, bar) in self.bars.iter().enumerate() {
            let at = (left - 10.0, top + pitch * (index as f64 + 0.5));
            canvas.text(&text::fit(&bar.name, self.label, size), at, Setting::new(size, HPos::Right))?;
        }
        let length = pitch * self.bars.len() as f64;
        let title = text::fit(&text::heading(&self.names.0), length.max(4.0 * size), size);
        let at = (EDGE + 0.5 * size, top + length / 2.0);
        canvas.text(&title, at, Setting::new(size, HPos::Center).upright())
    }

    /// Entries of the legend by row: category and left end.
    fn legend_rows(&self) -> Vec<Vec<(usize, f64)>> {
        let size = self.size;
        let mut rows = vec![Vec::new()];
        let mut x = EDGE + text::width("Rating", 1.2 * size) + size;
        let first = x;
        for index in evenly(self.counts.categories.len(), MOST_NAMED) {
            let name = text::fit(&self.counts.categories[index], 16.0 * size, size);
            let width = 2.6 * size + text::width(&name, size);
            if x + width > WIDTH - EDGE && x > first {
                rows.push(Vec::new());
                x = first;
            }
            if let Some(row) = rows.last_mut() {
                row.push((index, x));
            }
            x += width;
        }
        rows
    }

    fn legend(&self, canvas: &Canvas<'_>, rows: &[Vec<(usize, f64)>]) -> Drawn {
        let size = self.size;
        canvas.text("Rating", (EDGE, EDGE + 0.5 * size), Setting::new(size, HPos::Left).bold())?;
        for (row, entries) in rows.iter().enumerate() {
            let y = EDGE + (0.5 + 1.5 * row as f64) * size;
            for &(index, x) in entries {
                let box_ = [(x, y - 0.45 * size), (x + 1.2 * size, y + 0.45 * size)];
                canvas.rectangle(box_[0], box_[1], category(index, self.counts.categories.len()))?;
                let name = text::fit(&text::level(&self.counts.categories[index]), 16.0 * size, size);
                canvas.text(&name, (x + 1.5 * size, y), Setting::new(size, HPos::Left))?;
            }
        }
        Ok(())
    }
}

/// Ratings in each category, by level of the second factor, then of the first.
fn tallies(counts: &Counts) -> Vec<Vec<Vec<u64>>> {
    let levels = |index: usize| counts.factors.get(index).map_or(1, |factor| factor.levels.len());
    let mut tallies = vec![vec![vec![0; counts.categories.len()]; levels(0)]; levels(1)];
    for row in &counts.rows {
        let level = |index: usize| {
            let level = counts.conditions[row.condition as usize].get(index).copied().flatten();
            level.map_or(0, |level| level as usize)
        };
        tallies[level(1)][level(0)][usize::from(row.rating)] += row.count;
    }
    tallies
}

/// The levels that are drawn, or a single one without a name.
fn shown(factor: Option<&Factor>, most: usize) -> Vec<Bar> {
    let Some(factor) = factor else { return vec![Bar { level: None, name: String::new() }] };
    let bar = |level: usize| Bar { level: Some(level), name: text::level(&factor.levels[level]) };
    evenly(factor.levels.len(), most).into_iter().map(bar).collect()
}
