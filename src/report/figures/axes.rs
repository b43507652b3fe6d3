//! Panels with a value upwards and the levels of a factor, or numbers, across.

use plotters::style::text_anchor::{HPos, VPos};

use super::{
    labels as text,
    palette::{AXIS, GRID, TEXT},
    svg::{Canvas, Drawn, Setting, WIDTH},
};
use crate::analysis::{
    counts::{Counts, Factor},
    summary::category_values,
};

/// Height of a panel in a chart for a column.
pub(super) const PANEL: f64 = 380.0;
/// Free space at the edges of a chart.
pub(super) const EDGE: f64 = 16.0;
/// Length of a tick.
const TICK: f64 = 8.0;
/// Longest name of a category beside its tick.
const LONGEST_VALUE: f64 = 170.0;
/// Longest name of a level that stands upright below its tick.
const LONGEST_UPRIGHT: f64 = 250.0;
/// Most ticks without a name.
const MOST_TICKS: usize = 40;

/// A rectangle in which values are drawn.
#[derive(Clone, Copy)]
pub(super) struct Panel {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    /// The value at the bottom.
    pub low: f64,
    /// The value at the top.
    pub high: f64,
}

impl Panel {
    /// Where a share of the width is, 0…1 from the left.
    pub fn x(&self, share: f64) -> f64 {
        self.left + share * (self.right - self.left)
    }

    /// Where a value is.
    pub fn y(&self, value: f64) -> f64 {
        self.bottom - (value - self.low) / (self.high - self.low) * (self.bottom - self.top)
    }

    /// Its width.
    pub fn width(&self) -> f64 {
        self.right - self.left
    }
}

/// The axis upwards.
pub(super) struct Values {
    pub low: f64,
    pub high: f64,
    ticks: Vec<(f64, String)>,
}

impl Values {
    /// The whole scale of the ratings, whatever was used of it.
    pub fn ratings(counts: &Counts) -> Self {
        let values = category_values(counts);
        let (low, high) = ends(values.iter().copied()).unwrap_or((0.0, 1.0));
        let pad = if high > low { 0.05 * (high - low) } else { 0.5 };
        let ticks = if values.len() <= 8 {
            values.iter().zip(&counts.categories).map(|(&value, name)| (value, text::level(name))).collect()
        } else {
            let name = |value: f64| match values.iter().position(|v| *v == value) {
                Some(index) => text::level(&counts.categories[index]),
                None => plain(value),
            };
            ticks(low, high, 7).into_iter().map(|value| (value, name(value))).collect()
        };
        Self { low: low - pad, high: high + pad, ticks }
    }

    /// From 0 to a little more than the largest value.
    pub fn from_zero(largest: f64) -> Self {
        let high = if largest > 0.0 { 1.06 * largest } else { 1.0 };
        Self { low: 0.0, high, ticks: ticks(0.0, high, 6).into_iter().map(|value| (value, plain(value))).collect() }
    }

    /// From a lowest value to a highest.
    pub fn between(low: f64, high: f64) -> Self {
        Self { low, high, ticks: ticks(low, high, 5).into_iter().map(|value| (value, plain(value))).collect() }
    }

    /// Room that the axis needs at the left of the panel, with its title.
    pub fn margin(&self) -> f64 {
        EDGE + 1.3 * TEXT + self.widest() + TICK + 8.0
    }

    fn widest(&self) -> f64 {
        let widths = self.ticks.iter().map(|(_, name)| text::width(name, TEXT).min(LONGEST_VALUE));
        widths.fold(0.0, f64::max)
    }

    /// Lines across the panel, ticks, and their values unless they stand beside another panel.
    pub fn draw(&self, canvas: &Canvas<'_>, panel: &Panel, title: Option<&str>) -> Drawn {
        for (value, name) in &self.ticks {
            let y = panel.y(*value);
            canvas.line(&[(panel.left, y), (panel.right, y)], GRID)?;
            canvas.line(&[(panel.left - TICK, y), (panel.left, y)], AXIS)?;
            if title.is_some() {
                let name = text::fit(name, LONGEST_VALUE, TEXT);
                canvas.text(&name, (panel.left - TICK - 8.0, y), Setting::new(TEXT, HPos::Right))?;
            }
        }
        canvas.line(&[(panel.left, panel.top), (panel.left, panel.bottom)], AXIS)?;
        let Some(title) = title else { return Ok(()) };
        let x = (panel.left - TICK - 8.0 - self.widest() - 0.75 * TEXT).max(EDGE + 0.5 * TEXT);
        let title = text::fit(title, panel.bottom - panel.top + 80.0, TEXT);
        canvas.text(&title, (x, middle(panel.top, panel.bottom)), Setting::new(TEXT, HPos::Center).upright())
    }
}

/// The levels of a factor across a panel.
pub(super) struct Levels {
    /// Where each level is, a share of the panel's width.
    pub at: Vec<f64>,
    /// Whether a line from one level to the next has a meaning.
    pub ordered: bool,
    names: Vec<String>,
}

impl Levels {
    /// Numbers at their places, on a logarithmic axis where they span more than ten times; everything else, the depth
    /// too, in order and evenly.
    pub fn of(factor: &Factor) -> Self {
        let names: Vec<String> = factor.levels.iter().map(|name| text::level(name)).collect();
        let count = names.len();
        let evenly = || (0..count).map(|index| (index as f64 + 0.5) / count as f64).collect::<Vec<_>>();
        let places = factor.numbers.as_ref().filter(|_| factor.name != "depth" && count > 1).and_then(|n| spread(n));
        Self { at: places.unwrap_or_else(evenly), ordered: factor.numbers.is_some(), names }
    }

    /// The smallest distance between two levels, a share of the panel's width.
    pub fn gap(&self) -> f64 {
        self.at.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min)
    }

    /// How the names are set below a panel of this width.
    pub fn labels(&self, width: f64) -> Labels {
        let room = self.gap() * width - 0.4 * TEXT;
        let widest = self.names.iter().map(|name| text::width(name, TEXT)).fold(0.0, f64::max);
        if widest <= room.max(0.0) || self.names.len() == 1 {
            let texts = self.names.iter().map(|name| Some(text::fit(name, width, TEXT))).collect();
            return Labels { upright: false, texts, height: TEXT };
        }
        if self.ordered {
            return Labels { upright: false, texts: self.thinned(width), height: TEXT };
        }
        let each = (1.15 * TEXT / (self.gap() * width)).ceil().max(1.0) as usize;
        let short = |name: &String| text::fit(name, LONGEST_UPRIGHT, TEXT);
        let texts: Vec<Option<String>> =
            self.names.iter().enumerate().map(|(index, name)| (index % each == 0).then(|| short(name))).collect();
        let height = texts.iter().flatten().map(|name| text::width(name, TEXT)).fold(TEXT, f64::max);
        Labels { upright: true, texts, height }
    }

    /// Every so many of the names for which there is room; of numbers at uneven places, those that fit after the one
    /// before.
    fn thinned(&self, width: f64) -> Vec<Option<String>> {
        let count = self.names.len();
        let fitting = |each: usize| {
            let mut free = f64::NEG_INFINITY;
            let mut shown = vec![None; count];
            for index in (0..count).step_by(each) {
                let (centre, half) = (self.at[index] * width, text::width(&self.names[index], TEXT) / 2.0);
                if centre - half >= free {
                    free = centre + half + 0.4 * TEXT;
                    shown[index] = Some(self.names[index].clone());
                }
            }
            shown
        };
        let number = |shown: &[Option<String>]| shown.iter().flatten().count();
        let greedy = fitting(1);
        let even =
            (1..=count).map(|each| (fitting(each), count.div_ceil(each))).find(|(shown, all)| number(shown) == *all);
        even.map(|(shown, _)| shown).filter(|shown| 5 * number(shown) >= 3 * number(&greedy)).unwrap_or(greedy)
    }

    /// Axis, ticks, names and title below a panel.
    pub fn draw(&self, canvas: &Canvas<'_>, panel: &Panel, labels: &Labels, title: &str) -> Drawn {
        for (at, name) in self.at.iter().zip(&labels.texts) {
            let x = panel.x(*at);
            if name.is_some() || self.at.len() <= MOST_TICKS {
                canvas.line(&[(x, panel.bottom), (x, panel.bottom + TICK)], AXIS)?;
            }
            if let Some(name) = name {
                labels.name(canvas, name, (x, panel.bottom + TICK + 6.0))?;
            }
        }
        base(canvas, panel, labels.height, title)
    }
}

/// Names of levels as there is room for them.
pub(super) struct Labels {
    upright: bool,
    texts: Vec<Option<String>>,
    /// How far down they go.
    pub height: f64,
}

impl Labels {
    fn name(&self, canvas: &Canvas<'_>, name: &str, at: (f64, f64)) -> Drawn {
        if self.upright {
            canvas.text(name, at, Setting::new(TEXT, HPos::Right).upright())
        } else {
            canvas.text(name, at, Setting { height: VPos::Top, ..Setting::new(TEXT, HPos::Center) })
        }
    }
}

/// Room below a panel for names of this height, and a title.
pub(super) fn below(height: f64) -> f64 {
    TICK + 6.0 + height + 10.0 + TEXT + EDGE
}

/// The line below a panel, and its title under names of some height.
pub(super) fn base(canvas: &Canvas<'_>, panel: &Panel, height: f64, title: &str) -> Drawn {
    canvas.line(&[(panel.left, panel.bottom), (panel.right, panel.bottom)], AXIS)?;
    let centre = middle(panel.left, panel.right);
    let room = 2.0 * (centre.min(WIDTH - centre) - EDGE);
    let at = (centre, panel.bottom + TICK + 6.0 + height + 10.0);
    canvas.text(&text::fit(title, room, TEXT), at, Setting { height: VPos::Top, ..Setting::new(TEXT, HPos::Center) })
}

/// Ticks of a number across, below a panel; `at` are shares of its width.
pub(super) fn number_ticks(canvas: &Canvas<'_>, panel: &Panel, at: &[(f64, String)], title: &str) -> Drawn {
    for (share, name) in at {
        let x = panel.x(*share);
        canvas.line(&[(x, panel.bottom), (x, panel.bottom + TICK)], AXIS)?;
        let setting = Setting { height: VPos::Top, ..Setting::new(TEXT, HPos::Center) };
        canvas.text(name, (x, panel.bottom + TICK + 6.0), setting)?;
    }
    base(canvas, panel, TEXT, title)
}

/// Places of numbers, a share of the width; none where some would fall on others.
fn spread(numbers: &[f64]) -> Option<Vec<f64>> {
    const MARGIN: f64 = 0.07;
    let (low, high) = ends(numbers.iter().copied()).filter(|(low, high)| low.is_finite() && high.is_finite())?;
    let logarithmic = low > 0.0 && high > 10.0 * low;
    let of =
        |number: f64| if logarithmic { (number / low).ln() / (high / low).ln() } else { (number - low) / (high - low) };
    let at: Vec<f64> = numbers.iter().map(|&number| MARGIN + (1.0 - 2.0 * MARGIN) * of(number)).collect();
    let least = 0.3 / numbers.len() as f64;
    (at.windows(2).all(|pair| pair[1] - pair[0] >= least)).then_some(at)
}

/// Least and greatest; none of none.
pub(super) fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |ends, value| match ends {
        None => Some((value, value)),
        Some((low, high)) => Some((f64::min(low, value), f64::max(high, value))),
    })
}

/// Round numbers between two others: steps of 1, 2 or 5 times a power of ten, at most so many.
pub(super) fn ticks(low: f64, high: f64, most: usize) -> Vec<f64> {
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

/// A number without the noise of binary fractions.
pub(super) fn plain(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    text::level(&if rounded == 0.0 { "0".to_owned() } else { rounded.to_string() })
}

/// The number between two others.
pub(super) fn middle(from: f64, to: f64) -> f64 {
    (from + to) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(name: &str, levels: &[&str]) -> Factor {
        let levels: Vec<String> = levels.iter().map(|&level| level.to_owned()).collect();
        Factor { name: name.to_owned(), numbers: crate::analysis::numbers_of(&levels), levels }
    }

    #[test]
    fn wide_ranges_are_logarithmic_and_what_has_no_place_is_even() {
        let width = Levels::of(&factor("width", &["0.02", "0.2", "2"]));
        assert!((width.at[1] - 0.5).abs() < 1e-12, "{:?}", width.at);
        let linear = Levels::of(&factor("angle", &["0", "90", "360"]));
        assert!(((linear.at[1] - linear.at[0]) * 4.0 - (linear.at[2] - linear.at[0])).abs() < 1e-12);
        for even in
            [factor("depth", &["1", "2", "inf"]), factor("n", &["1", "1.001", "9"]), factor("t", &["a", "b", "c"])]
        {
            let at = Levels::of(&even).at;
            assert!((at[1] - at[0] - (at[2] - at[1])).abs() < 1e-12 && at[0] > 0.0, "{at:?}");
        }
    }

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks(0.0, 3.1, 6), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(ticks(-2.0, 2.0, 5), [-2.0, -1.0, 0.0, 1.0, 2.0]);
        assert_eq!(ticks(1.0, 1.0, 5), [1.0]);
        for (low, high) in [(0.0, 1e-9), (-7e12, 3e11), (0.03, 0.031), (1.0, 99.0)] {
            let found = ticks(low, high, 6);
            assert!((2..=6).contains(&found.len()), "{low} {high}: {found:?}");
            assert!(found.iter().all(|tick| (low..=high * (1.0 + 1e-9)).contains(tick)), "{found:?}");
        }
        assert_eq!([plain(0.30000000000000004), plain(-0.0), plain(-1.5)], ["0.3", "0", "−1.5"]);
    }

    #[test]
    fn numbers_are_thinned_and_texts_turned() {
        let levels: Vec<String> = (0..30).map(|i| (i * 10).to_string()).collect();
        let names: Vec<&str> = levels.iter().map(String::as_str).collect();
        let labels = Levels::of(&factor("x", &names)).labels(500.0);
        let shown = labels.texts.iter().flatten().count();
        assert!(!labels.upright && (6..15).contains(&shown), "{shown}");
        let shaders =
            Levels::of(&factor("s", &["gradient-repaired", "gradient", "flat", "phong", "exact"])).labels(500.0);
        assert!(shaders.upright && shaders.texts.iter().all(Option::is_some));
        assert!(!Levels::of(&factor("s", &["flat", "phong"])).labels(500.0).upright);
    }
}
