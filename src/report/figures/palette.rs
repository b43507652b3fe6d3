//! The colors of all charts, on paper and in the window, and the markers and dashes that distinguish series without
//! color.

use std::fmt;

/// A color, encoded in sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgb(pub u8, pub u8, pub u8);

impl fmt::Display for Rgb {
    /// Writes the color in SVG notation: `#0072b2`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}

pub const BLACK: Rgb = Rgb(0, 0, 0);
pub const WHITE: Rgb = Rgb(255, 255, 255);
pub const GRAY: Rgb = Rgb(120, 120, 120);
// The palette of Okabe & Ito (2008, jfly.uni-koeln.de/color), which color-blind readers can distinguish.
pub const ORANGE: Rgb = Rgb(230, 159, 0);
pub const SKY: Rgb = Rgb(86, 180, 233);
pub const GREEN: Rgb = Rgb(0, 158, 115);
pub const YELLOW: Rgb = Rgb(240, 228, 66);
pub const BLUE: Rgb = Rgb(0, 114, 178);
pub const VERMILION: Rgb = Rgb(213, 94, 0);
pub const PURPLE: Rgb = Rgb(204, 121, 167);

/// Colors of series on white, darkest first. Yellow is omitted because it is barely visible on white.
pub const ON_WHITE: [Rgb; 7] = [BLACK, BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY];
/// Colors of series on a dark background.
pub const ON_DARK: [Rgb; 7] = [ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILION, PURPLE];

/// Returns a drawing on white as a drawing on a light card.
pub fn on_light(svg: &str) -> String {
    svg.replace(&WHITE.to_string(), &Rgb(0xfa, 0xfa, 0xfa).to_string())
}

/// Returns a drawing on white as a drawing on a dark background. Series get the colors that are as easily told apart
/// there; the lightness of every other color is reversed, so that a scale still goes from what is close to the background
/// to what is far from it.
pub fn on_dark(svg: &str) -> String {
    const CARD: Rgb = Rgb(0x2a, 0x2a, 0x2a);
    const TEXT: Rgb = Rgb(0xe6, 0xe6, 0xe6);
    const SERIES: [(Rgb, Rgb); 8] = [
        (WHITE, CARD),
        (BLACK, TEXT),
        (BLUE, SKY),
        (VERMILION, ORANGE),
        (GREEN, Rgb(0x35, 0xb5, 0x8a)),
        (PURPLE, Rgb(0xd5, 0x9b, 0xc0)),
        (ORANGE, YELLOW),
        (SKY, Rgb(0xb8, 0xb8, 0xb8)),
    ];
    let mut parts = svg.split('#');
    let mut drawn = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let digits = part.get(..6).filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
        let Some(code) = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()) else {
            drawn.extend(["#", part]);
            continue;
        };
        let [_, r, g, b] = code.to_be_bytes();
        let color = Rgb(r, g, b);
        let known = SERIES.iter().find(|(on_white, _)| *on_white == color).map(|(_, dark)| *dark);
        drawn.extend([&*known.unwrap_or_else(|| color.reversed(CARD)).to_string(), &part[6..]]);
    }
    drawn
}

impl Rgb {
    /// Returns the color of the same hue whose lightness is as far from that of `ground` as it was from white.
    fn reversed(self, Rgb(ground, ..): Rgb) -> Self {
        let Self(r, g, b) = self;
        let (least, most) = (r.min(g).min(b), r.max(g).max(b));
        // Reversing the lightness exchanges the largest and the smallest channel.
        let turned = |channel: u8| f64::from(255 - (u16::from(least) + u16::from(most) - u16::from(channel)) as u8);
        let onto = |channel: f64| (f64::from(ground) + channel * (255.0 - f64::from(ground)) / 255.0).round() as u8;
        Self(onto(turned(r)), onto(turned(g)), onto(turned(b)))
    }
}

/// Maximum number of series that can be distinguished in one chart.
pub const MAX_SERIES: usize = 12;

/// Shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
}

const MARKERS: [Marker; 4] = [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond];

/// Lengths of a dash and of the gap after it; `None` for a solid line.
pub type Dash = Option<(f64, f64)>;

const DASHES: [Dash; 3] = [None, Some((18.0, 8.0)), Some((8.0, 6.0))];

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    pub color: Rgb,
    pub width: f64,
    pub opacity: f64,
    pub dash: Dash,
}

impl Stroke {
    pub const fn new(color: Rgb, width: f64) -> Self {
        Self { color, width, opacity: 1.0, dash: None }
    }
}

/// Axes.
pub const AXIS: Stroke = Stroke::new(Rgb(60, 60, 60), 2.0);
/// Grid lines.
pub const GRID: Stroke = Stroke::new(Rgb(222, 222, 222), 1.4);

/// The color, marker and dashes that distinguish a series from the others.
#[derive(Clone, Copy, Debug)]
pub struct Series {
    pub color: Rgb,
    pub marker: Marker,
    pub dash: Dash,
}

impl Series {
    /// Returns the style of the series with this index. No two of the first [`MAX_SERIES`] look the same, even in gray.
    pub fn of(index: usize) -> Self {
        Self {
            color: ON_WHITE[index % ON_WHITE.len()],
            marker: MARKERS[index % MARKERS.len()],
            dash: DASHES[index % DASHES.len()],
        }
    }

    /// Returns the style of a chart's only series.
    pub fn only() -> Self {
        Self { color: BLUE, ..Self::of(0) }
    }

    pub fn line(self) -> Stroke {
        Stroke { dash: self.dash, ..Stroke::new(self.color, 3.2) }
    }

    /// Returns the stroke of the series' intervals.
    pub fn bar(self) -> Stroke {
        Stroke::new(self.color, 2.2)
    }
}

/// Returns the color of an ordered category, from light to dark.
pub fn category(index: usize, of: usize) -> Rgb {
    // A single hue: light means low, in color and in gray.
    const ENDS: [[f64; 3]; 2] = [[208.0, 224.0, 240.0], [8.0, 34.0, 82.0]];
    let share = if of < 2 { 1.0 } else { index as f64 / (of - 1) as f64 };
    let mix = |channel: usize| (ENDS[0][channel] + share * (ENDS[1][channel] - ENDS[0][channel])).round() as u8;
    Rgb(mix(0), mix(1), mix(2))
}
