//! A sheet to draw on: plotters' elements and SVG back end, in units of a tenth of its own whole numbers.

use std::io;

use plotters::{
    coord::Shift,
    drawing::DrawingAreaErrorKind,
    element::DashedPathElement,
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use super::{
    labels as text,
    palette::{Look, Marker},
};

/// Back-end units, which are whole numbers, in one of ours.
const FINE: f64 = 10.0;
/// The back end divides sizes of fonts by this.
const FONT_FACTOR: f64 = 1.24;
/// Noto Sans is what the PNG is set in; without it, what every machine has.
const FAMILY: &str = "Noto Sans, Open Sans, Helvetica, Arial, sans-serif";
/// Width of every chart.
pub(super) const WIDTH: f64 = 800.0;

/// Whether something could be drawn.
pub(super) type Drawn = Result<(), DrawingAreaErrorKind<io::Error>>;

/// The sheet. Lengths are in units of the view box, y downwards.
pub(super) struct Canvas<'a>(DrawingArea<SVGBackend<'a>, Shift>);

/// How a line is drawn.
#[derive(Clone, Copy)]
pub(super) struct Stroke {
    pub colour: RGBColor,
    pub width: f64,
    /// 1 is opaque.
    pub alpha: f64,
    /// Length of a dash, and of the gap after it.
    pub dash: Option<(f64, f64)>,
}

impl Stroke {
    pub const fn new(colour: RGBColor, width: f64) -> Self {
        Self { colour, width, alpha: 1.0, dash: None }
    }
}

/// How a text is set.
#[derive(Clone, Copy)]
pub(super) struct Setting {
    pub size: f64,
    pub bold: bool,
    /// Read from below.
    pub upright: bool,
    /// The side of the text that is at its place, along the line.
    pub side: HPos,
    /// The same, across the line.
    pub height: VPos,
}

impl Setting {
    pub const fn new(size: f64, side: HPos) -> Self {
        Self { size, bold: false, upright: false, side, height: VPos::Center }
    }

    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    pub const fn upright(self) -> Self {
        Self { upright: true, ..self }
    }
}

/// A chart as SVG, with its title and description for those who cannot see it. None where drawing fails.
pub(super) fn drawing(
    height: f64,
    title: &str,
    description: &str,
    paint: impl FnOnce(&Canvas<'_>) -> Drawn,
) -> Option<String> {
    // Whole pixels, so that the last row is as white as the others.
    let height = height.ceil();
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (fine(WIDTH) as u32, fine(height) as u32)).into_drawing_area();
        let canvas = Canvas(area);
        canvas.rectangle((0.0, 0.0), (WIDTH, height), WHITE).ok()?;
        paint(&canvas).ok()?;
        canvas.0.present().ok()?;
    }
    let (_, body) = svg.split_once(">\n")?;
    // Only lines are translucent: as a property of the line it needs no layer of its own, of which hundreds are slow.
    let body = body.replace(" opacity=\"1\"", "").replace(" opacity=\"", " stroke-opacity=\"");
    Some(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {} {}\" \
         role=\"img\">\n<title>{}</title>\n<desc>{}</desc>\n{body}",
        fine(WIDTH),
        fine(height),
        escaped(title),
        escaped(description),
    ))
}

fn fine(length: f64) -> i32 {
    (length * FINE).round() as i32
}

fn place((x, y): (f64, f64)) -> (i32, i32) {
    (fine(x), fine(y))
}

fn escaped(text: &str) -> String {
    text::clean(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

impl Canvas<'_> {
    /// A line through points.
    pub fn line(&self, points: &[(f64, f64)], stroke: Stroke) -> Drawn {
        let points: Vec<(i32, i32)> = points.iter().copied().map(place).collect();
        let style = ShapeStyle {
            color: stroke.colour.mix(stroke.alpha),
            filled: false,
            stroke_width: fine(stroke.width) as u32,
        };
        match stroke.dash {
            Some((dash, gap)) => self.0.draw(&DashedPathElement::new(points, fine(dash), fine(gap), style)),
            None => self.0.draw(&PathElement::new(points, style)),
        }
    }

    /// A filled rectangle between two corners.
    pub fn rectangle(&self, from: (f64, f64), to: (f64, f64), colour: RGBColor) -> Drawn {
        self.0.draw(&Rectangle::new([place(from), place(to)], colour.filled()))
    }

    /// A filled polygon.
    pub fn polygon(&self, corners: &[(f64, f64)], colour: RGBColor) -> Drawn {
        self.0.draw(&Polygon::new(corners.iter().copied().map(place).collect::<Vec<_>>(), colour.filled()))
    }

    /// A line of text at a place.
    pub fn text(&self, content: &str, at: (f64, f64), setting: Setting) -> Drawn {
        let weight = if setting.bold { FontStyle::Bold } else { FontStyle::Normal };
        let turn = if setting.upright { FontTransform::Rotate270 } else { FontTransform::None };
        let style = TextStyle::from((FAMILY, setting.size * FINE * FONT_FACTOR, weight).into_font())
            .color(&BLACK)
            .transform(turn)
            .pos(Pos::new(setting.side, setting.height));
        self.0.draw(&Text::new(text::clean(content), place(at), style))
    }

    /// An upright interval with caps.
    pub fn interval(&self, x: f64, from: f64, to: f64, cap: f64, stroke: Stroke) -> Drawn {
        self.line(&[(x, from), (x, to)], stroke)?;
        for y in [from, to] {
            self.line(&[(x - cap, y), (x + cap, y)], stroke)?;
        }
        Ok(())
    }

    /// The marker of a series.
    pub fn marker(&self, (x, y): (f64, f64), radius: f64, look: Look) -> Drawn {
        let line = Stroke::new(look.colour, 2.6);
        let r = radius;
        let corners: Vec<(f64, f64)> = match look.marker {
            Marker::Circle => {
                let fill = if look.open { WHITE } else { look.colour };
                self.0.draw(&Circle::new(place((x, y)), fine(r), fill.filled()))?;
                if !look.open {
                    return Ok(());
                }
                let outline = ShapeStyle { color: look.colour.mix(1.0), filled: false, stroke_width: fine(2.6) as u32 };
                return self.0.draw(&Circle::new(place((x, y)), fine(r - 1.0), outline));
            }
            Marker::Square => {
                let s = 0.88 * r;
                vec![(-s, -s), (s, -s), (s, s), (-s, s)]
            }
            Marker::Triangle => vec![(0.0, -1.2 * r), (1.1 * r, 0.75 * r), (-1.1 * r, 0.75 * r)],
            Marker::Inverted => vec![(0.0, 1.2 * r), (1.1 * r, -0.75 * r), (-1.1 * r, -0.75 * r)],
            Marker::Diamond => vec![(0.0, -1.3 * r), (1.05 * r, 0.0), (0.0, 1.3 * r), (-1.05 * r, 0.0)],
            Marker::Cross => {
                let s = 0.85 * r;
                let bold = Stroke { width: if look.open { 2.6 } else { 4.5 }, ..line };
                self.line(&[(x - s, y - s), (x + s, y + s)], bold)?;
                return self.line(&[(x - s, y + s), (x + s, y - s)], bold);
            }
        };
        let mut corners: Vec<(f64, f64)> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
        self.polygon(&corners, if look.open { WHITE } else { look.colour })?;
        if look.open {
            // Once more around the first corner, so that it is mitred like the others.
            corners.extend_from_within(..2);
            self.line(&corners, line)?;
        }
        Ok(())
    }

    /// A sample of a series at the left end of `at`, 46 wide, with its name.
    pub fn legend_entry(&self, (x, y): (f64, f64), look: Look, lined: bool, name: &str, size: f64) -> Drawn {
        if lined {
            self.line(&[(x, y), (x + 46.0, y)], look.stroke())?;
        }
        self.marker((x + 23.0, y), 0.28 * size, look)?;
        self.text(name, (x + 56.0, y), Setting::new(size, HPos::Left))
    }
}
