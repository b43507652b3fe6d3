//! The drawing as pixels.

use std::sync::{Arc, OnceLock};

use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use resvg::{
    tiny_skia::{Pixmap, Transform},
    usvg::{
        Options, Tree,
        fontdb::{Database, Source},
    },
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
            fonts.load_font_source(Source::Binary(Arc::new(face)));
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
    encoded(&pixels, &colours(svg))
}

/// Colours that the drawing names, each once, in the order of their first use.
fn colours(svg: &str) -> Vec<[u8; 3]> {
    let hex =
        |text: &str| u32::from_str_radix(text.get(..6)?, 16).ok().map(|c| [(c >> 16) as u8, (c >> 8) as u8, c as u8]);
    let mut colours: Vec<[u8; 3]> = Vec::new();
    for colour in svg.split("=\"#").skip(1).filter_map(hex) {
        if !colours.contains(&colour) {
            colours.push(colour);
        }
    }
    colours
}

/// PNG with a palette: a third of the bytes to move. The sheet is opaque everywhere, so there is no alpha to undo.
fn encoded(pixels: &Pixmap, named: &[[u8; 3]]) -> Result<Vec<u8>, FigureError> {
    let (palette, indices) = indexed(pixels.data(), named);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(ColorType::Indexed);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_palette(palette.concat());
    encoder.set_compression(Compression::Fast);
    // Indices above each other are mostly the same, and zeros are what the fast compression is good at.
    encoder.set_filter(Filter::Up);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&indices)?;
    writer.finish()?;
    Ok(bytes)
}

/// A palette that begins with the named colours; the others are mixtures along their edges. Of these, those that are
/// almost alike are one, and when there are too many, the nearest has to do.
fn indexed(rgba: &[u8], named: &[[u8; 3]]) -> (Vec<[u8; 3]>, Vec<u8>) {
    const NONE: u16 = u16::MAX;
    let bin = |[r, g, b]: [u8; 3]| (usize::from(r >> 3) << 11) | (usize::from(g >> 2) << 5) | usize::from(b >> 3);
    let mut index_of = vec![NONE; 1 << 16];
    let mut palette: Vec<[u8; 3]> = Vec::with_capacity(256);
    let mut index = |colour: [u8; 3]| {
        let known = &mut index_of[bin(colour)];
        if *known == NONE {
            *known = if palette.len() < 256 {
                palette.push(colour);
                palette.len() as u16 - 1
            } else {
                nearest(&palette, colour)
            };
        }
        *known as u8
    };
    for &colour in named {
        index(colour);
    }
    let mut last = ([0; 4], 0);
    let indices = (rgba.as_chunks::<4>().0.iter())
        .map(|&pixel| {
            if pixel != last.0 {
                last = (pixel, index([pixel[0], pixel[1], pixel[2]]));
            }
            last.1
        })
        .collect();
    (palette, indices)
}

fn nearest(palette: &[[u8; 3]], colour: [u8; 3]) -> u16 {
    let distance =
        |other: &[u8; 3]| -> u32 { other.iter().zip(colour).map(|(&a, b)| u32::from(a.abs_diff(b)).pow(2)).sum() };
    (0..).zip(palette).min_by_key(|(_, other)| distance(other)).map_or(0, |(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Named colours are exact, and nothing is far from what it was.
    #[test]
    fn a_palette_is_near_any_picture() {
        let named = [[255, 255, 255], [0, 114, 178], [213, 94, 0]];
        let mut rgba = Vec::new();
        for step in 0..=255_u32 {
            for pair in [(0, 1), (0, 2), (1, 2)] {
                let mix = |c: usize| {
                    ((u32::from(named[pair.0][c]) * step + u32::from(named[pair.1][c]) * (255 - step)) / 255) as u8
                };
                rgba.extend([mix(0), mix(1), mix(2), 255]);
            }
        }
        let (palette, indices) = indexed(&rgba, &named);
        assert!(palette.len() <= 256 && palette[..3] == named && indices.len() == rgba.len() / 4);
        for (pixel, index) in rgba.as_chunks::<4>().0.iter().zip(indices) {
            let drawn = palette[usize::from(index)];
            let exact = named.iter().any(|colour| *colour == pixel[..3]);
            let most = if exact { 0 } else { 12 };
            assert!(drawn.iter().zip(pixel).all(|(a, b)| a.abs_diff(*b) <= most), "{pixel:?} is {drawn:?}");
        }
    }

    #[test]
    fn colours_are_those_of_the_drawing() {
        assert_eq!(
            colours("<a fill=\"#FF0001\"/><b stroke=\"#00000a\" fill=\"#FF0001\">=\"#x</b>"),
            [[255, 0, 1], [0, 0, 10]]
        );
    }
}
