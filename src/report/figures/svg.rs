//! Charts as SVG drawings: lines, shapes and text in units of the view box, with y pointing down; with title and caption,
//! and as pixels of the same drawing.

use std::{
    fmt::Write as _,
    sync::{Arc, OnceLock},
};

use anyhow::Context as _;
use png::{ColorType, Compression, Encoder, Filter};
use resvg::{
    tiny_skia::{Pixmap, Transform},
    usvg::{
        Options, Tree,
        fontdb::{Database, Source},
    },
};

use super::{
    labels::{self, TEXT},
    palette::{BLACK, Marker, Rgb, Series, Stroke, WHITE},
};

/// Width of every chart.
pub(super) const WIDTH: f64 = 800.0;
/// The PNG uses Noto Sans; the others are fallbacks for the SVG, at least one of which every machine has.
const FAMILY: &str = "Noto Sans, Open Sans, Helvetica, Arial, sans-serif";

pub(super) type Point = (f64, f64);

/// The part of a text that is at its position.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// The style of a text.
#[derive(Clone, Copy)]
pub(super) struct Font {
    pub anchor: Anchor,
    pub bold: bool,
    /// Whether the text runs from bottom to top.
    pub upright: bool,
    /// Whether the top of the text is at its position.
    pub below: bool,
}

impl Font {
    /// Returns plain text that is vertically centered at its position.
    pub const fn new(anchor: Anchor) -> Self {
        Self { anchor, bold: false, upright: false, below: false }
    }
}

/// A value of the data at its place in a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Plotted {
    /// The center of its marker or bar.
    pub center: (f64, f64),
    /// Half the width and half the height of the marker or bar.
    pub half: (f64, f64),
    /// What and how much it is.
    pub text: String,
}

/// A drawing in progress, and the values in it.
pub(super) struct Svg {
    text: String,
    values: Vec<Plotted>,
}

/// Rounds a length to a hundredth, so that its text is short.
fn n(length: f64) -> f64 {
    // Adding 0 turns −0 into 0.
    (length * 100.0).round() / 100.0 + 0.0
}

fn escaped(text: &str) -> String {
    labels::clean(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn listed(points: &[Point]) -> String {
    let pairs: Vec<String> = points.iter().map(|&(x, y)| format!("{},{}", n(x), n(y))).collect();
    pairs.join(" ")
}

fn attributes(stroke: Stroke) -> String {
    let mut text = format!("stroke=\"{}\" stroke-width=\"{}\"", stroke.color, n(stroke.width));
    if stroke.opacity < 1.0 {
        text += &format!(" stroke-opacity=\"{}\"", n(stroke.opacity));
    }
    if let Some((dash, gap)) = stroke.dash {
        text += &format!(" stroke-dasharray=\"{dash} {gap}\"");
    }
    text
}

impl Svg {
    fn element(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to memory does not fail.
        let _ = writeln!(self.text, "{element}");
    }

    /// Draws a line through points.
    pub fn line(&mut self, points: &[Point], stroke: Stroke) {
        self.element(format_args!("<polyline points=\"{}\" fill=\"none\" {}/>", listed(points), attributes(stroke)));
    }

    /// Draws a line through points, with gaps where points are missing. An isolated point becomes a short dash.
    pub fn path(&mut self, points: &[Option<Point>], stroke: Stroke) {
        for run in points.split(Option::is_none) {
            match *run {
                [Some((x, y))] => self.line(&[(x - 5.0, y), (x + 5.0, y)], stroke),
                _ if !run.is_empty() => self.line(&run.iter().flatten().copied().collect::<Vec<_>>(), stroke),
                _ => {}
            }
        }
    }

    /// Draws a filled rectangle between two corners.
    pub fn rectangle(&mut self, (left, top): Point, (right, bottom): Point, color: Rgb) {
        let (width, height) = (n(right - left), n(bottom - top));
        self.element(format_args!(
            "<rect x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\" fill=\"{color}\"/>",
            n(left),
            n(top)
        ));
    }

    /// Draws a filled polygon.
    pub fn polygon(&mut self, corners: &[Point], color: Rgb) {
        self.element(format_args!("<polygon points=\"{}\" fill=\"{color}\"/>", listed(corners)));
    }

    /// Draws a filled circle.
    pub fn circle(&mut self, (x, y): Point, radius: f64, color: Rgb) {
        self.element(format_args!("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{color}\"/>", n(x), n(y), n(radius)));
    }

    /// Draws a line of text.
    pub fn text(&mut self, content: &str, (x, y): Point, font: Font) {
        let Font { anchor, bold, upright, below } = font;
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let weight = if bold { " font-weight=\"bold\"" } else { "" };
        let (x, y) = (n(x), n(y));
        let turn = if upright { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        // The distance from the baseline to half the height of a capital letter, or to its top.
        let baseline = n(y + TEXT * if below { 0.76 } else { 0.35 });
        self.element(format_args!(
            "<text x=\"{x}\" y=\"{baseline}\" font-size=\"{TEXT}\" text-anchor=\"{anchor}\"{weight}{turn} \
             fill=\"{BLACK}\">{}</text>",
            escaped(content)
        ));
    }

    /// Draws a vertical interval with caps.
    pub fn interval(&mut self, x: f64, from: f64, to: f64, cap: f64, stroke: Stroke) {
        self.line(&[(x, from), (x, to)], stroke);
        for y in [from, to] {
            self.line(&[(x - cap, y), (x + cap, y)], stroke);
        }
    }

    /// Draws the marker of a series.
    pub fn marker(&mut self, (x, y): Point, radius: f64, Series { color, marker, .. }: Series) {
        let corners: &[Point] = match marker {
            Marker::Circle => return self.circle((x, y), radius, color),
            Marker::Square => &[(-0.88, -0.88), (0.88, -0.88), (0.88, 0.88), (-0.88, 0.88)],
            Marker::Triangle => &[(0.0, -1.2), (1.1, 0.75), (-1.1, 0.75)],
            Marker::Diamond => &[(0.0, -1.3), (1.05, 0.0), (0.0, 1.3), (-1.05, 0.0)],
        };
        let corners: Vec<Point> = corners.iter().map(|(dx, dy)| (x + radius * dx, y + radius * dy)).collect();
        self.polygon(&corners, color);
    }

    /// Draws the marker of a value; `text` says what and how much it is.
    pub fn point(&mut self, center: Point, radius: f64, series: Series, text: String) {
        self.marker(center, radius, series);
        self.values.push(Plotted { center, half: (radius, radius), text });
    }

    /// Draws the bar of a value between two corners; `text` says what and how much it is.
    pub fn bar(&mut self, (left, top): Point, (right, bottom): Point, color: Rgb, text: String) {
        self.rectangle((left, top), (right, bottom), color);
        let (center, half) =
            (((left + right) / 2.0, (top + bottom) / 2.0), ((right - left) / 2.0, (bottom - top) / 2.0));
        self.values.push(Plotted { center, half, text });
    }

    /// Draws a legend entry: a sample of the series, which is 46 units wide and begins at `(x, y)`, and the series'
    /// name.
    pub fn legend_entry(&mut self, (x, y): Point, series: Series, lined: bool, name: &str) {
        if lined {
            self.line(&[(x, y), (x + 46.0, y)], series.line());
        }
        self.marker((x + 23.0, y), 0.28 * TEXT, series);
        self.text(name, (x + 56.0, y), Font::new(Anchor::Start));
    }
}

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Stem of its file name, such as `figure4a`.
    pub name: &'static str,
    /// A heading that says what the chart shows.
    pub title: String,
    /// One or two sentences that explain how the data are drawn and state the number of ratings.
    pub caption: String,
    /// Height at a width of 800.
    pub height: f64,
    /// The drawing, 800 units wide. Its text is kept as text, and it does not depend on other files.
    pub svg: String,
    /// The values in it, at their places.
    pub values: Vec<Plotted>,
}

impl Figure {
    /// Creates a complete drawing, whose title and caption are also for readers who cannot see it.
    pub(super) fn draw(
        name: &'static str,
        [title, caption]: [String; 2],
        height: f64,
        paint: impl FnOnce(&mut Svg),
    ) -> Self {
        // Whole pixels, so that the last row is fully white.
        let whole = height.ceil();
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{whole}\" \
             viewBox=\"0 0 {WIDTH} {whole}\" role=\"img\" font-family=\"{FAMILY}\">\n\
             <title>{}</title>\n<desc>{}</desc>\n",
            escaped(&title),
            escaped(&caption)
        );
        let mut drawn = Svg { text, values: Vec::new() };
        drawn.rectangle((0.0, 0.0), (WIDTH, whole), WHITE);
        paint(&mut drawn);
        let Svg { text, values } = drawn;
        Self { name, title, caption, height, svg: text + "</svg>\n", values }
    }

    /// Returns the chart as a PNG image that is 1600 pixels wide. Its bytes are the same on every machine.
    ///
    /// # Errors
    /// The drawing cannot be rendered or encoded.
    pub fn png(&self) -> anyhow::Result<Vec<u8>> {
        let pixels = self.pixels(1600)?;
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, pixels.width, pixels.height);
        encoder.set_color(ColorType::Rgb);
        encoder.set_compression(Compression::Fast);
        // Vertically adjacent pixels are mostly equal, so their differences are mostly zero and fast compression is
        // enough.
        encoder.set_filter(Filter::Up);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&pixels.rgb)?;
        writer.finish()?;
        Ok(bytes)
    }

    /// Renders the chart as pixels, at the given width.
    ///
    /// # Errors
    /// The drawing cannot be rendered.
    pub fn pixels(&self, width: u32) -> anyhow::Result<Pixels> {
        let options = Options { fontdb: fonts(), font_family: "Noto Sans".to_owned(), ..Options::default() };
        let tree = Tree::from_str(&self.svg, &options)?;
        let scale = width as f32 / tree.size().width();
        let height = (tree.size().height() * scale).ceil() as u32;
        let mut pixmap = Pixmap::new(width, height)
            .with_context(|| format!("the chart is {width} × {height}; expected a size that fits in memory"))?;
        // The background covers the last row entirely.
        let down = height as f32 / tree.size().height();
        resvg::render(&tree, Transform::from_scale(scale, down), &mut pixmap.as_mut());
        // The background is opaque everywhere, so there is no alpha to remove.
        let rgb = pixmap.data().as_chunks::<4>().0.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
        Ok(Pixels { width, height, rgb })
    }
}

/// Opaque pixels, three bytes each, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Red, green and blue of every pixel.
    pub rgb: Vec<u8>,
}

/// Returns only the fonts that are built into the program.
fn fonts() -> Arc<Database> {
    static FONTS: OnceLock<Arc<Database>> = OnceLock::new();
    let load = || {
        let mut fonts = Database::new();
        for face in [notosans::REGULAR_TTF, notosans::BOLD_TTF] {
            fonts.load_font_source(Source::Binary(Arc::new(face)));
        }
        fonts.set_sans_serif_family("Noto Sans");
        Arc::new(fonts)
    };
    FONTS.get_or_init(load).clone()
}
