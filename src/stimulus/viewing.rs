//! A window on a screen, and the eye that sees it.

use super::catalog::Stimulus;
use crate::{
    light::LinearImage,
    vision::{Eye, luminance},
};

/// A window on a screen, viewed by an eye adapted to the window's mean light.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ViewingConditions {
    /// The window's width in degrees of visual angle; above 0.
    pub window_deg: f64,
    /// Luminance of white without that of black, cd/m²; above 0.
    pub white_cd_m2: f64,
    /// Luminance of black with what the screen reflects, cd/m².
    pub black_cd_m2: f64,
}

impl ViewingConditions {
    /// Luminance of white on a typical screen, cd/m².
    pub const WHITE_CD_M2: f64 = 100.0;
    /// Luminance of black on a typical screen in a dim room, cd/m².
    pub const BLACK_CD_M2: f64 = 0.2;
    /// Width of a window of unknown size, degrees.
    pub const WINDOW_DEG: f64 = 10.0;
    /// A sufficient width for a stimulus that varies in one direction, pixels.
    pub const LINE_PX: u32 = 1024;
    /// A sufficient side for any other stimulus, pixels. It is smaller because the time grows with the area.
    pub const PICTURE_PX: u32 = 512;

    /// Maximum side of a picture in pixels: the model keeps dozens of numbers for each pixel. A line has no such limit.
    pub const MAX_PICTURE_PX: u32 = 4096;

    /// Creates a window of this many degrees on a typical screen.
    pub fn new(window_deg: f64) -> Self {
        Self { window_deg, white_cd_m2: Self::WHITE_CD_M2, black_cd_m2: Self::BLACK_CD_M2 }
    }

    /// Returns a sufficient size for `stimulus`, pixels.
    pub fn px(stimulus: &Stimulus) -> u32 {
        if stimulus.is_line() { Self::LINE_PX } else { Self::PICTURE_PX }
    }

    /// Returns the luminance of light, 1 for white, in cd/m².
    pub fn cd_m2(&self, light: f64) -> f64 {
        self.white_cd_m2 * light + self.black_cd_m2
    }

    /// Returns the luminance of each pixel in cd/m².
    pub fn luminances(&self, image: &LinearImage) -> Vec<f64> {
        image.data.chunks_exact(3).map(|pixel| self.cd_m2(luminance([pixel[0], pixel[1], pixel[2]]))).collect()
    }

    /// Returns an eye that is adapted to the mean of `light` in cd/m².
    pub(super) fn eye(&self, light: &[f64]) -> Eye {
        Eye::adapted_to(light.iter().sum::<f64>() / light.len().max(1) as f64)
    }

    /// Returns the pixels per degree of a picture that fills the window with this width.
    pub fn px_per_deg(&self, px: u32) -> f64 {
        f64::from(px) / self.window_deg
    }
}
