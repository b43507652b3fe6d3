//! Rows and a patch as a picture.

use crate::{
    display::channel::Channel,
    light::{CodeImage, Samples},
};

/// A field of rows: `lit` of every `period` rows have the largest code, the others are dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rows {
    /// Lit rows of a period.
    pub lit: u32,
    /// Rows of a period.
    pub period: u32,
    /// Thickness of a row, pixels.
    pub row_px: u32,
}

impl Rows {
    /// The mean light of the field, 0…1.
    #[must_use]
    pub fn share(&self) -> f64 {
        f64::from(self.lit) / f64::from(self.period)
    }

    /// A period in pixels.
    #[must_use]
    pub fn period_px(&self) -> u32 {
        self.period * self.row_px
    }

    /// The rows over `width` × `height` pixels, with a uniform patch in the middle, a square of about `patch_px`; 8 bits,
    /// to be shown pixel by pixel.
    ///
    /// The patch is made smaller until it spans whole periods, and begins with one: above and below it are the same rows.
    #[must_use]
    pub fn picture(&self, channel: Channel, patch: [u8; 3], [width, height]: [u32; 2], patch_px: u32) -> CodeImage {
        let period = self.period_px().max(1);
        let side = patch_px.min(width).min(height) / period * period;
        let left = (width - side) / 2;
        let top = (height - side) / 2 / period * period;
        let mut codes = Vec::with_capacity(width as usize * height as usize * 3);
        for y in 0..height {
            let is_lit = y / self.row_px % self.period < self.lit;
            let row = channel.rgb(if is_lit { 255 } else { 0 });
            let across = (top..top + side).contains(&y);
            codes.extend((0..width).flat_map(|x| if across && (left..left + side).contains(&x) { patch } else { row }));
        }
        CodeImage { width, height, samples: Samples::Eight(codes) }
    }
}
