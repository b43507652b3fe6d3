//! What tells series and categories apart, in colour, without red and green, and in grey.

use plotters::style::RGBColor;

use super::svg::Stroke;

/// Size of text in a chart for a column.
pub(super) const TEXT: f64 = 29.0;
/// Size of text in a chart for the width of a page.
pub(super) const SMALL: f64 = 20.0;
/// Radius of a marker.
pub(super) const MARKER: f64 = 8.0;
/// Most series that one chart can tell apart.
pub(super) const MOST_SERIES: usize = 12;

/// Axes.
pub(super) const AXIS: Stroke = Stroke::new(RGBColor(60, 60, 60), 2.0);
/// Lines across a panel at its ticks.
pub(super) const GRID: Stroke = Stroke::new(RGBColor(222, 222, 222), 1.4);
/// The stand-alone colour, darkest but black: what a chart with a single series is drawn in.
pub(super) const INK: RGBColor = RGBColor(0, 114, 178);

/// Okabe & Ito's colours without yellow, which is hardly seen on white, the darkest first.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 0, 0),
    INK,
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

const MARKERS: [Marker; 6] =
    [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Inverted, Marker::Cross];

const DASHES: [Option<(f64, f64)>; 4] = [None, Some((18.0, 8.0)), Some((8.0, 6.0)), Some((30.0, 7.0))];

/// Shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
    Inverted,
    Cross,
}

/// What a series looks like.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub colour: RGBColor,
    pub marker: Marker,
    /// An outline instead of a filled shape.
    pub open: bool,
    pub dash: Option<(f64, f64)>,
}

impl Look {
    /// The look of a series; no two of [`MOST_SERIES`] are alike, even in grey.
    pub fn of(series: usize) -> Self {
        Self {
            colour: COLOURS[series % COLOURS.len()],
            marker: MARKERS[series % MARKERS.len()],
            open: (series / MARKERS.len()) % 2 == 1,
            dash: DASHES[series % DASHES.len()],
        }
    }

    /// The look of the only series.
    pub fn only() -> Self {
        Self { colour: INK, ..Self::of(0) }
    }

    /// Its line.
    pub fn stroke(self) -> Stroke {
        Stroke { dash: self.dash, ..Stroke::new(self.colour, 3.2) }
    }

    /// Its intervals.
    pub fn bar(self) -> Stroke {
        Stroke::new(self.colour, 2.2)
    }
}

/// The colour of an ordered category, from light to dark in even steps of lightness.
pub(super) fn category(index: usize, of: usize) -> RGBColor {
    // A single hue: light in both its forms, colour and grey, means low.
    const STOPS: [(f64, f64, f64); 4] =
        [(208.0, 224.0, 240.0), (133.0, 178.0, 213.0), (42.0, 112.0, 176.0), (8.0, 34.0, 82.0)];
    let share = if of < 2 { 1.0 } else { index as f64 / (of - 1) as f64 };
    let place = share * (STOPS.len() - 1) as f64;
    let below = (place.floor() as usize).min(STOPS.len() - 2);
    let (from, to, t) = (STOPS[below], STOPS[below + 1], place - below as f64);
    let mix = |a: f64, b: f64| (a + t * (b - a)).round() as u8;
    RGBColor(mix(from.0, to.0), mix(from.1, to.1), mix(from.2, to.2))
}
