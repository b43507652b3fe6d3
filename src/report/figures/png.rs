//! The drawing as pixels.

use std::sync::{Arc, OnceLock};

use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use resvg::{
    tiny_skia::{Pixmap, Transform},
    usvg::{Options, Tree, fontdb::Database},
};
use thiserror::Error;

/// Pixels to a unit of the view box.
const SCALE: f32 = 2.0;

/// Why a chart cannot be drawn as pixels.
#[derive(Debug, Error)]
pub enum FigureError {
    /// The SVG is not one.
    #[error("the chart cannot be read: {0}; expected SVG")]
    Svg(#[from] resvg::usvg::Error),
    /// Too large, or of no size.
    #[error("the chart is {0} × {1}; expected a size that fits the memory")]
    Size(f32, f32),
    /// The encoder failed.
    #[error("the chart cannot be written as PNG: {0}")]
    Png(#[from] png::EncodingError),
}

/// The fonts that are part of the program, and no others.
fn fonts() -> Arc<Database> {
    static FONTS: OnceLock<Arc<Database>> = OnceLock::new();
    let load = || {
        let mut fonts = Database::new();
        for face in [notosans::REGULAR_TTF, notosans::BOLD_TTF] {
            fonts.load_font_source(resvg::usvg::fontdb::Source::Binary(Arc::new(face)));
        }
        fonts.set_sans_serif_family("Noto Sans");
        Arc::new(fonts)
    };
    FONTS.get_or_init(load).clone()
}

/// The SVG as PNG, without transparency.
pub(super) fn png(svg: &str) -> Result<Vec<u8>, FigureError> {
    let options = Options { fontdb: fonts(), font_family: "Noto Sans".to_owned(), ..Options::default() };
    let tree = Tree::from_str(svg, &options)?;
    let size = tree.size();
    let (width, height) = ((size.width() * SCALE).ceil() as u32, (size.height() * SCALE).ceil() as u32);
    let mut pixels = Pixmap::new(width, height).ok_or(FigureError::Size(size.width(), size.height()))?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    encoded(&pixels)
}

fn encoded(pixels: &Pixmap) -> Result<Vec<u8>, FigureError> {
    // The sheet is white and opaque everywhere, so there is no alpha to undo.
    let mut rgb = vec![0; pixels.data().len() / 4 * 3];
    for (to, from) in rgb.chunks_exact_mut(3).zip(pixels.data().chunks_exact(4)) {
        to.copy_from_slice(&from[..3]);
    }
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Paeth);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
}
