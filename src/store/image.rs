//! Images as PNG.

use std::{io::BufWriter, path::Path};

use super::{StoreError, fault::io};
use crate::light::{CodeImage, Samples, Transfer};

/// Writes an image; `transfer` is what its codes mean, and is written into the file where PNG has words for it.
///
/// # Errors
/// The system's refusal.
pub fn write_png(path: &Path, image: &CodeImage, transfer: &Transfer) -> Result<(), StoreError> {
    let file = std::fs::File::create(path).map_err(io(path, "create"))?;
    let mut encoder = png::Encoder::new(BufWriter::new(file), image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(match image.samples {
        Samples::Eight(_) => png::BitDepth::Eight,
        Samples::Sixteen(_) => png::BitDepth::Sixteen,
    });
    match transfer {
        Transfer::Srgb => encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric),
        Transfer::Linear => encoder.set_source_gamma(png::ScaledFloat::new(1.0)),
        Transfer::Gamma(gamma) => encoder.set_source_gamma(png::ScaledFloat::new((1.0 / gamma) as f32)),
        // A measured table has no gAMA; a viewer that assumes sRGB is then near enough to look at it.
        Transfer::Table(_) => {}
    }
    let failed = |error: png::EncodingError| io(path, "write")(std::io::Error::other(error));
    let mut writer = encoder.write_header().map_err(failed)?;
    match &image.samples {
        Samples::Eight(codes) => writer.write_image_data(codes).map_err(failed)?,
        Samples::Sixteen(codes) => {
            let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_be_bytes()).collect();
            writer.write_image_data(&bytes).map_err(failed)?;
        }
    }
    writer.finish().map_err(failed)
}
