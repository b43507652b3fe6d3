//! Fields that show whether a profile is right: rows beside the uniform code that it says has their light.

use super::{Channel, observation::RowField, picture::rows_with_patch};
use crate::light::{CodeImage, Transfers};

/// Rows of a period that are lit, of how many, in the fields of a check: a quarter, a half and three quarters of full
/// light.
pub const CHECKED: [(u32, u32); 3] = [(1, 4), (1, 2), (3, 4)];

/// Full and dark rows, and a patch that vanishes in them where the profile is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CheckField {
    /// What carries the light.
    pub channel: Channel,
    /// The rows.
    pub rows: RowField,
    /// The patch's codes.
    pub patch: [u8; 3],
}

impl CheckField {
    /// `lit` of `period` rows at code 255, against the 8-bit codes that make their mean light on a display of
    /// `transfers` whose γ was wrong by `error`: 0 for the profile as it is, ± 0.2 to see what wrong looks like.
    #[must_use]
    pub fn new(transfers: &Transfers, channel: Channel, [lit, period]: [u32; 2], row_px: u32, error: f64) -> Self {
        let share = f64::from(lit) / f64::from(period);
        let codes = transfers.encoded_from_linear([share; 3]).map(|encoded| {
            // The exponent that makes this light of this encoded value, whatever the function is.
            let gamma = (share.ln() / encoded.ln() + error).max(0.1);
            let encoded = if error == 0.0 { encoded } else { share.powf(gamma.recip()) };
            (encoded * 255.0).round() as u8
        });
        let patch = std::array::from_fn(|i| if channel.index().is_none_or(|index| index == i) { codes[i] } else { 0 });
        Self { channel, rows: RowField { lit, period, row_px, lo: 0, hi: 255 }, patch }
    }

    /// The mean light of the rows, 0…1.
    #[must_use]
    pub fn share(&self) -> f64 {
        f64::from(self.rows.lit) / f64::from(self.rows.period)
    }

    /// The field, `width` × `height` pixels of 8 bits, with a square patch of about `patch_px`, as
    /// [`picture`](super::picture()) draws it.
    #[must_use]
    pub fn picture(&self, width: u32, height: u32, patch_px: u32) -> CodeImage {
        rows_with_patch(self.channel, &self.rows, self.patch, [width, height], patch_px)
    }
}
