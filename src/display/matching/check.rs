//! Fields that show whether a profile is right: rows beside the uniform code that should have their light.

use super::rows::Rows;
use crate::{
    display::channel::Channel,
    light::{CodeImage, Transfers},
};

/// Lit rows, and rows of a period, in the fields of a check: a quarter, a half and three quarters of full light.
pub const CHECKED: [(u32, u32); 3] = [(1, 4), (1, 2), (3, 4)];

/// Rows, and a patch that vanishes in them where the profile is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CheckField {
    /// What carries the light.
    pub channel: Channel,
    /// The rows.
    pub rows: Rows,
    /// The patch's codes.
    pub patch: [u8; 3],
}

impl CheckField {
    /// Rows against the 8-bit codes that make their mean light on a display of `transfers` whose γ is off by `error`: 0
    /// for the profile as it is, ± 0.2 for an example of a wrong one.
    #[must_use]
    pub fn new(transfers: &Transfers, channel: Channel, rows: Rows, error: f64) -> Self {
        let share = rows.share();
        let codes = transfers.encoded_from_linear([share; 3]).map(|encoded| {
            // The exponent that makes this light of this encoded value, whatever the function is.
            let gamma = (share.ln() / encoded.ln() + error).max(0.1);
            let encoded = if error == 0.0 { encoded } else { share.powf(gamma.recip()) };
            (encoded * 255.0).round() as u8
        });
        let patch = std::array::from_fn(|i| if channel.index().is_none_or(|index| index == i) { codes[i] } else { 0 });
        Self { channel, rows, patch }
    }

    /// The field as a square of `side` pixels, with a square patch of about `patch_px`.
    #[must_use]
    pub fn picture(&self, side: u32, patch_px: u32) -> CodeImage {
        self.rows.picture(self.channel, self.patch, [side, side], patch_px)
    }
}
