//! Charts with values on the vertical axis, either numbers or the levels of a factor on the horizontal axis, and a legend
//! beside them. Ticks are at round numbers.

use super::{
    labels::{self, TEXT},
    palette::{AXIS, GRID, Series},
    svg::{Anchor, Figure, Font, Svg, WIDTH},
};
use crate::{
    analysis::{
        counts::{Counts, Factor},
        summary::category_values,
    },
    statistics::Interval,
};

/// Radius of a marker.
pub(super) const MARKER: f64 = 8.0;
/// Height of a panel in a chart of column width.
const PANEL: f64 = 380.0;
/// Free space at the edges of a chart: half a line of text, for a tick at the end of an axis.
pub(super) const EDGE: f64 = 22.0;
/// The top of a panel is at the edge.
const BOTTOM: f64 = EDGE + PANEL;
/// Length of a tick.
const TICK: f64 = 8.0;
/// Maximum width of a category's name at a tick.
const MAX_NAME: f64 = 200.0;
/// Maximum length of a level's name that is rotated below a tick.
const MAX_UPRIGHT: f64 = 250.0;
/// Maximum width of a name beside a panel.
const MAX_BESIDE: f64 = 180.0;
/// Distance of a legend from its panel.
const BESIDE: f64 = 24.0;
/// Width of a sample in a legend, with the space after it.
const SAMPLE: f64 = 56.0;
/// Text below a tick or a panel.
const BELOW: Font = Font { below: true, ..Font::new(Anchor::Middle) };
/// Maximum number of ticks without a name.
const MAX_TICKS: usize = 40;
/// Maximum number of round numbers on a horizontal axis.
const MAX_NUMBERS: usize = 8;

/// Draws a chart: its axes with their titles, its marks and its legend. The legend has a heading, which may be empty, the series
/// and their names, and lines if the last value is true.
pub(super) fn chart(
    name: &'static str,
    texts: [String; 2],
    (values, of_values): (Values, &str),
    (levels, of_levels): (&Levels, &str),
    (heading, series, lined): (&str, &[(Series, &str)], bool),
    marks: impl FnOnce(&mut Svg, &Panel),
) -> Figure {
    // A number at the end of an axis is wider than a tick.
    let overhang = if levels.has_grid { EDGE + TEXT } else { EDGE };
    let panel = Panel {
        left: EDGE + 1.3 * TEXT + values.widest() + TICK + 8.0,
        right: WIDTH - overhang - beside(heading, series),
        low: values.low,
        high: values.high,
    };
    let height = BOTTOM + levels.below(panel.width());
    Figure::draw(name, texts, height, |svg| {
        values.draw(svg, &panel, of_values);
        levels.draw(svg, &panel, of_levels);
        marks(svg, &panel);
        legend(svg, &panel, heading, series, lined);
    })
}

/// A rectangle in which values are drawn.
#[derive(Clone, Copy)]
pub(super) struct Panel {
    pub left: f64,
    pub right: f64,
    /// The value at the bottom.
    pub low: f64,
    /// The value at the top.
    pub high: f64,
}

impl Panel {
    /// Returns the x coordinate at a proportion of the width, 0…1 from the left.
    pub fn x(&self, share: f64) -> f64 {
        self.left + share * self.width()
    }

    /// Returns the y coordinate of a value.
    pub fn y(&self, value: f64) -> f64 {
        BOTTOM - (value - self.low) / (self.high - self.low) * PANEL
    }

    pub fn width(&self) -> f64 {
        self.right - self.left
    }
}

/// The vertical axis.
pub(super) struct Values {
    low: f64,
    high: f64,
    ticks: Vec<(f64, String)>,
}

impl Values {
    /// Creates an axis for the whole rating scale, even if not all of it was used.
    pub fn ratings(counts: &Counts) -> Self {
        let values = category_values(counts);
        let (low, high) = ends(values.iter().copied()).unwrap_or((0.0, 1.0));
        let pad = if high > low { 0.05 * (high - low) } else { 0.5 };
        let named = |value: f64| values.iter().position(|v| *v == value).map(|i| labels::level(&counts.categories[i]));
        let shown = if values.len() <= 8 { values.clone() } else { ticks(low, high, 7) };
        let ticks = shown.into_iter().map(|value| (value, named(value).unwrap_or_else(|| plain(value)))).collect();
        Self { low: low - pad, high: high + pad, ticks }
    }

    /// Creates an axis from 0 to slightly above the largest value.
    pub fn from_zero(largest: f64) -> Self {
        Self::between(0.0, if largest > 0.0 { 1.06 * largest } else { 1.0 })
    }

    pub fn between(low: f64, high: f64) -> Self {
        Self { low, high, ticks: ticks(low, high, 6).into_iter().map(|value| (value, plain(value))).collect() }
    }

    fn widest(&self) -> f64 {
        let widths = self.ticks.iter().map(|(_, name)| labels::width(name).min(MAX_NAME));
        widths.fold(0.0, f64::max)
    }

    /// Draws grid lines, ticks and a title.
    fn draw(&self, svg: &mut Svg, panel: &Panel, title: &str) {
        for (value, name) in &self.ticks {
            let y = panel.y(*value);
            svg.line(&[(panel.left, y), (panel.right, y)], GRID);
            svg.line(&[(panel.left - TICK, y), (panel.left, y)], AXIS);
            svg.text(&labels::fit(name, MAX_NAME), (panel.left - TICK - 8.0, y), Font::new(Anchor::End));
        }
        svg.line(&[(panel.left, EDGE), (panel.left, BOTTOM)], AXIS);
        let title = labels::fit(title, PANEL + 80.0);
        let middle = (EDGE + 0.5 * TEXT, EDGE + PANEL / 2.0);
        svg.text(&title, middle, Font { upright: true, ..Font::new(Anchor::Middle) });
    }
}

/// The horizontal axis: the levels of a factor, or round numbers.
pub(super) struct Levels {
    /// The position of each level, as a proportion of the panel's width.
    pub at: Vec<f64>,
    /// True if a line from one level to the next is meaningful.
    pub ordered: bool,
    pub names: Vec<String>,
    /// Whether there are vertical grid lines.
    has_grid: bool,
}

impl Levels {
    /// Places numbers at their values, on a logarithmic axis if they span more than a factor of ten; directions are
    /// always on a linear axis. All other levels are evenly spaced, in order.
    pub fn of(factor: &Factor) -> Self {
        let numbers = factor.numbers.as_ref();
        let places = numbers.filter(|numbers| numbers.len() > 1);
        let places = places.and_then(|numbers| spread(numbers, factor.is_direction));
        let even = Self::evenly(&factor.levels, numbers.is_some());
        Self { at: places.unwrap_or(even.at), ..even }
    }

    /// Spaces names evenly, in order.
    pub fn evenly(names: &[String], ordered: bool) -> Self {
        let at = (0..names.len()).map(|index| (index as f64 + 0.5) / names.len() as f64).collect();
        Self { at, ordered, names: names.iter().map(|name| labels::level(name)).collect(), has_grid: false }
    }

    /// Places round numbers on an axis between two ends.
    pub fn numbers(low: f64, high: f64) -> Self {
        let numbers = ticks(low, high, MAX_NUMBERS);
        let at = numbers.iter().map(|value| (value - low) / (high - low)).collect();
        Self { at, ordered: true, names: numbers.into_iter().map(plain).collect(), has_grid: true }
    }

    /// Returns the smallest distance between two levels, as a proportion of the panel's width.
    pub fn gap(&self) -> f64 {
        self.at.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min)
    }

    /// Returns the space that the names and a title need below a panel of this width.
    fn below(&self, width: f64) -> f64 {
        TICK + 6.0 + self.labels(width).2 + 10.0 + TEXT + EDGE
    }

    /// Returns whether the names below a panel of this width are rotated, the names that fit, and their height. If not
    /// all names fit, unordered names are rotated; if there is still not enough room, only every nth name is kept.
    fn labels(&self, width: f64) -> (bool, Vec<Option<String>>, f64) {
        let widths: Vec<f64> = self.names.iter().map(|name| labels::width(name)).collect();
        let fits = |each: usize, widths: &[f64]| {
            let shown: Vec<usize> = (0..widths.len()).step_by(each).collect();
            shown.windows(2).all(|pair| {
                let room = (self.at[pair[1]] - self.at[pair[0]]) * width;
                (widths[pair[0]] + widths[pair[1]]) / 2.0 + 0.4 * TEXT <= room
            })
        };
        let upright = !self.ordered && !fits(1, &widths);
        let widths = if upright { vec![0.75 * TEXT; widths.len()] } else { widths };
        let each = (1..=widths.len()).find(|each| fits(*each, &widths)).unwrap_or(1);
        let room = if upright { MAX_UPRIGHT } else { width };
        let texts: Vec<Option<String>> = (self.names.iter().enumerate())
            .map(|(index, name)| (index % each == 0).then(|| labels::fit(name, room)))
            .collect();
        let longest = texts.iter().flatten().map(|name| labels::width(name)).fold(TEXT, f64::max);
        (upright, texts, if upright { longest } else { TEXT })
    }

    /// Draws the axis, ticks, names and title below a panel.
    fn draw(&self, svg: &mut Svg, panel: &Panel, title: &str) {
        let (upright, names, height) = self.labels(panel.width());
        let font = if upright { Font { upright: true, ..Font::new(Anchor::End) } } else { BELOW };
        for (at, name) in self.at.iter().zip(names) {
            let x = panel.x(*at);
            if self.has_grid {
                svg.line(&[(x, EDGE), (x, BOTTOM)], GRID);
            }
            if name.is_some() || self.at.len() <= MAX_TICKS {
                svg.line(&[(x, BOTTOM), (x, BOTTOM + TICK)], AXIS);
            }
            name.iter().for_each(|name| svg.text(name, (x, BOTTOM + TICK + 6.0), font));
        }
        svg.line(&[(panel.left, BOTTOM), (panel.right, BOTTOM)], AXIS);
        let center = panel.x(0.5);
        let title = labels::fit(title, 2.0 * (center.min(WIDTH - center) - EDGE));
        svg.text(&title, (center, BOTTOM + TICK + 16.0 + height), BELOW);
    }
}

/// Returns the space that a legend needs beside a panel; none if there is only one series.
fn beside(heading: &str, series: &[(Series, &str)]) -> f64 {
    if series.len() < 2 {
        return 0.0;
    }
    let heading = labels::fit(heading, SAMPLE + MAX_BESIDE);
    let names = series.iter().map(|(_, name)| SAMPLE + labels::width(name).min(MAX_BESIDE));
    BESIDE + names.fold(1.2 * labels::width(&heading), f64::max)
}

/// Names series beside a panel, unless there is only one; `lined` if they have lines. The heading may be empty.
fn legend(svg: &mut Svg, panel: &Panel, heading: &str, series: &[(Series, &str)], lined: bool) {
    if series.len() < 2 {
        return;
    }
    let first = usize::from(!heading.is_empty());
    let pitch = (PANEL / (first + series.len()) as f64).min(1.35 * TEXT);
    let at = |line: usize| (panel.right + BESIDE, EDGE + 0.5 * TEXT + line as f64 * pitch);
    if first > 0 {
        let heading = labels::fit(heading, SAMPLE + MAX_BESIDE);
        svg.text(&heading, at(0), Font { bold: true, ..Font::new(Anchor::Start) });
    }
    for (line, (series, name)) in (first..).zip(series) {
        svg.legend_entry(at(line), *series, lined, &labels::fit(name, MAX_BESIDE));
    }
}

/// Returns the positions of numbers, as proportions of the width; `None` if any of them would be too close together.
fn spread(numbers: &[f64], always_linear: bool) -> Option<Vec<f64>> {
    const MARGIN: f64 = 0.07;
    let (low, high) = ends(numbers.iter().copied()).filter(|(low, high)| low.is_finite() && high.is_finite())?;
    let logarithmic = !always_linear && low > 0.0 && high > 10.0 * low;
    let of =
        |number: f64| if logarithmic { (number / low).ln() / (high / low).ln() } else { (number - low) / (high - low) };
    let at: Vec<f64> = numbers.iter().map(|&number| MARGIN + (1.0 - 2.0 * MARGIN) * of(number)).collect();
    let least = 0.3 / numbers.len() as f64;
    at.windows(2).all(|pair| pair[1] - pair[0] >= least).then_some(at)
}

/// Returns the smallest and the largest value, if there are any values.
pub(super) fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.map(|value| (value, value)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Returns at most `most` round numbers in a range, in steps of 1, 2 or 5 times a power of ten.
fn ticks(low: f64, high: f64, most: usize) -> Vec<f64> {
    let span = high - low;
    if !(span.is_finite() && span > 0.0) {
        return vec![low];
    }
    let power = 10_f64.powf((span / most as f64).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0, 20.0].map(|factor| factor * power);
    let step = step.into_iter().find(|step| span / step < most as f64).unwrap_or(span);
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    (0..=(last - first).max(0.0) as usize).map(|index| (first + index as f64) * step).collect()
}

/// Formats a number without binary rounding noise.
fn plain(value: f64) -> String {
    labels::level(&((value * 1e6).round() / 1e6 + 0.0).to_string())
}

/// Says how much a value is, with its interval.
pub(super) fn told(value: f64, interval: Option<Interval>) -> String {
    let digits = |number: f64| plain((number * 1e3).round() / 1e3);
    let interval = interval.map(|Interval { low, high }| format!(", from {} to {}", digits(low), digits(high)));
    digits(value) + &interval.unwrap_or_default()
}
