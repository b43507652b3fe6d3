//! A chart with its title and caption, as an SVG drawing and as pixels of the same drawing.

use std::sync::{Arc, OnceLock};

use anyhow::Context as _;
use png::{ColorType, Compression, Encoder, Filter};
use resvg::{
    tiny_skia::{Pixmap, Transform},
    usvg::{
        Options, Tree,
        fontdb::{Database, Source},
    },
};

use super::svg::{Plotted, Svg};

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
    pub(super) fn draw(
        name: &'static str,
        title: String,
        caption: String,
        height: f64,
        paint: impl FnOnce(&mut Svg),
    ) -> Self {
        let (svg, values) = Svg::draw(height, &title, &caption, paint);
        Self { name, title, caption, height, svg, values }
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
