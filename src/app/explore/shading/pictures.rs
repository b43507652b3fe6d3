//! Draws the two images of a comparison. Redraws them only if something has changed.

use std::sync::Arc;

use eframe::egui::{self, ColorImage, TextureHandle, TextureId};

use super::{canvas::FACTOR, comparison::Comparison};
use crate::{
    app::ui::pixels,
    light::{Bits, CodeImage, Quantizer, Samples, Transfers},
    shading::{Frame, Shade, Surface, image},
};

/// The picture of one side.
pub struct Picture {
    /// Its codes.
    pub codes: CodeImage,
    texture: TextureHandle,
}

impl Picture {
    fn draw(ctx: &egui::Context, frame: &Frame, shade: &Shade, quantizer: &Quantizer) -> Picture {
        let codes = quantizer.quantize(&image(frame, shade));
        let size = [codes.width, codes.height].map(|side| side as usize);
        let pixels = ColorImage::from_rgb(size, codes.bytes().unwrap_or_default());
        let texture = pixels::load(ctx, "shading", Arc::new(pixels));
        Picture { codes, texture }
    }

    /// Returns the picture's texture in egui.
    pub fn id(&self) -> TextureId {
        self.texture.id()
    }
}

/// Both pictures of a comparison at a size.
pub struct Pictures {
    /// The comparison that they show, and the transfer functions of the display for which they were drawn.
    pub compared: Comparison,
    pub transfers: Transfers,
    /// The surface that they show.
    pub surface: Arc<Surface>,
    /// A number that increases whenever either image changes.
    pub edition: u64,
    /// The surface on the screen, in linear light.
    pub frame: Frame,
    /// The left and the right picture.
    pub sides: [Picture; 2],
}

impl Pictures {
    /// Returns the pictures of `compared`, or `before` if it is up to date.
    pub fn updated(
        ctx: &egui::Context,
        before: Option<Pictures>,
        surface: &Arc<Surface>,
        (compared, transfers): (&Comparison, &Transfers),
        size: [u32; 2],
    ) -> Pictures {
        let edition = before.as_ref().map_or(0, |before| before.edition + 1);
        let is_right = |p: &Pictures| {
            let same = p.compared == *compared && p.transfers == *transfers;
            same && [p.frame.width, p.frame.height] == size && Arc::ptr_eq(&p.surface, surface)
        };
        if let Some(before) = before.filter(is_right) {
            return before;
        }
        let frame = compared.scene.frame(surface, size[0], size[1]);
        let quantizer = Quantizer::new(transfers.clone(), Bits::Eight);
        let draw = |which: usize| Picture::draw(ctx, &frame, &compared.sides[which], &quantizer);
        let sides = [0, 1].map(draw);
        let (compared, transfers) = (compared.clone(), transfers.clone());
        Pictures { compared, transfers, surface: surface.clone(), edition, frame, sides }
    }
}

/// The difference between two images, and the version of the images that it was computed from.
pub struct Difference {
    edition: u64,
    pub codes: CodeImage,
    /// The difference as a texture.
    pub texture: TextureHandle,
}

impl Difference {
    /// Returns the amplified difference of `pictures`, or `before` if it is up to date.
    pub fn updated(ctx: &egui::Context, before: Option<Self>, pictures: &Pictures) -> Difference {
        if let Some(before) = before.filter(|before| before.edition == pictures.edition) {
            return before;
        }
        let [left, right] = &pictures.sides;
        let codes = combined(&left.codes, &right.codes, |_, left, right| left.abs_diff(right).saturating_mul(FACTOR));
        let texture = pixels::texture(ctx, "difference", &codes);
        Difference { edition: pictures.edition, codes, texture }
    }
}

/// Returns the left image up to a column and the right image from that column on, as at the divider.
pub fn divided([left, right]: [&CodeImage; 2], column: u32) -> CodeImage {
    combined(left, right, |x, left, right| if x < column { left } else { right })
}

fn combined(left: &CodeImage, right: &CodeImage, code: impl Fn(u32, u8, u8) -> u8) -> CodeImage {
    let (a, b) = (left.bytes().unwrap_or_default(), right.bytes().unwrap_or_default());
    let row = left.width.max(1) as usize * 3;
    let codes = a.iter().zip(b).enumerate().map(|(i, (a, b))| code((i % row / 3) as u32, *a, *b)).collect();
    CodeImage { width: left.width, height: left.height, samples: Samples::Eight(codes) }
}
