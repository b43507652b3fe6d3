//! Rows and a patch as a picture.

use super::{
    Channel,
    observation::{NullingStimulus, RowField},
};
use crate::light::{CodeImage, Samples};

/// The rows of `stimulus` over `width` × `height` pixels, with the uniform patch, a square of about `patch_px`, in the
/// middle; 8 bits, to be shown pixel by pixel.
///
/// The patch is made smaller until it spans whole periods, and begins with one: above and below it lie the same rows.
#[must_use]
pub fn picture(stimulus: &NullingStimulus, width: u32, height: u32, patch_px: u32) -> CodeImage {
    let patch = stimulus.channel.rgb(stimulus.patch);
    rows_with_patch(stimulus.channel, &stimulus.rows, patch, [width, height], patch_px)
}

pub(super) fn rows_with_patch(
    channel: Channel,
    rows: &RowField,
    patch: [u8; 3],
    [width, height]: [u32; 2],
    patch_px: u32,
) -> CodeImage {
    let period = rows.period_px().max(1);
    let side = patch_px.min(width).min(height) / period * period;
    let left = (width - side) / 2;
    let top = (height - side) / 2 / period * period;
    let mut codes = Vec::with_capacity(width as usize * height as usize * 3);
    for y in 0..height {
        let row = channel.rgb(rows.code(y));
        let across = (top..top + side).contains(&y);
        codes.extend((0..width).flat_map(|x| if across && (left..left + side).contains(&x) { patch } else { row }));
    }
    CodeImage { width, height, samples: Samples::Eight(codes) }
}
