//! Images of rows with a patch, and the patch that shows whether a profile is correct.

use crate::{
    display::channel::Channel,
    light::{CodeImage, Samples, Transfers},
};

/// Lit rows and rows per period in the fields of a check: a quarter, a half and three quarters of full light.
pub const CHECKED: [(u32, u32); 3] = [(1, 4), (1, 2), (3, 4)];

/// A field of rows: `lit` of every `period` rows have the largest code, and the others are dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rows {
    /// Lit rows per period.
    pub lit: u32,
    /// Rows per period.
    pub period: u32,
    /// Thickness of a row in pixels.
    pub row_px: u32,
}

impl Rows {
    /// The field's share of full light, 0…1.
    #[must_use]
    pub fn share(&self) -> f64 {
        f64::from(self.lit) / f64::from(self.period)
    }

    /// The period in pixels.
    #[must_use]
    pub fn period_px(&self) -> u32 {
        self.period * self.row_px
    }

    /// Draws the rows over `width` × `height` pixels, with a uniform square patch of about `patch_px` pixels in the
    /// middle. The image has 8 bits and must be shown pixel by pixel.
    ///
    /// The patch is shrunk until it spans whole periods, and it starts where a period starts, so whole periods border
    /// it above and below.
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

    /// Returns the 8-bit codes of a patch that vanishes in these rows on a display with `transfers` whose γ is off by
    /// `error`: 0 for the profile itself, ± 0.2 for an example of a wrong profile.
    #[must_use]
    pub fn check_patch(&self, transfers: &Transfers, channel: Channel, error: f64) -> [u8; 3] {
        let share = self.share();
        let codes = transfers.encoded_from_linear([share; 3]).map(|encoded| {
            // For any transfer function, the exponent that maps this encoded value to this light.
            let gamma = (share.ln() / encoded.ln() + error).max(0.1);
            let encoded = if error == 0.0 { encoded } else { share.powf(gamma.recip()) };
            (encoded * 255.0).round() as u8
        });
        std::array::from_fn(|i| if channel.index().is_none_or(|index| index == i) { codes[i] } else { 0 })
    }
}
