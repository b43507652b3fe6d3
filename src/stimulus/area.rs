//! Windows that vary in both directions.

use crate::light::LinearImage;

/// A stimulus that is drawn pixel by pixel.
pub(super) trait Area {
    /// The light of a window of `size` × `size` pixels.
    fn linear(&self, size: u32) -> LinearImage;

    /// The light at the pixel centers of a row of `size` through the middle, along the orientation.
    fn profile(&self, size: u32) -> Vec<[f32; 3]>;
}
