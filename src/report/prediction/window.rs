//! What the model of vision makes of stimuli in a window on a screen.

use rayon::prelude::*;

use crate::{
    experiment::Condition,
    light::LinearImage,
    shading::Frame,
    stimulus::{Stimulus, surface_seen},
    vision::{Eye, Picture, PictureView, Visibility, VisionError, luminance, luminances},
};

/// Pixels across a stimulus that varies in one direction, unless others are asked for.
pub const LINE_PX: u32 = 1024;
/// Pixels on a side of any other, unless others are asked for: a picture takes time with its area.
pub const PICTURE_PX: u32 = 512;

/// Where stimuli are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Its width in the eye's field, degrees; above 0.
    pub deg: f64,
    /// Luminance of white, cd/m²; above 0.
    pub white_cd_m2: f64,
    /// Pixels across; [`LINE_PX`] or [`PICTURE_PX`] where none are given.
    pub px: Option<u32>,
}

impl Window {
    /// Luminance of a common screen's white, cd/m².
    pub const WHITE_CD_M2: f64 = 100.0;

    /// A window of so many degrees on a common screen.
    #[must_use]
    pub fn new(deg: f64) -> Self {
        Self { deg, white_cd_m2: Self::WHITE_CD_M2, px: None }
    }

    /// An eye that is set for the mean of this light, 1 for white.
    #[must_use]
    pub fn eye(&self, light: &[f64]) -> Eye {
        let mean = light.iter().sum::<f64>() / light.len().max(1) as f64;
        Eye { luminance: (self.white_cd_m2 * mean).max(0.01), field_deg: self.deg }
    }

    /// How visible the bands of a stimulus are.
    ///
    /// # Errors
    /// [`VisionError`] for a stimulus that is all black, and for too few pixels.
    pub fn see(&self, stimulus: &Stimulus) -> Result<Visibility, VisionError> {
        let size = self.px.unwrap_or(if stimulus.is_line() { LINE_PX } else { PICTURE_PX });
        let light = if stimulus.is_line() {
            stimulus.profile(size).into_iter().map(luminance).collect()
        } else {
            luminances(&stimulus.linear(size))
        };
        Ok(stimulus.seen(size, self.px_per_deg(size), &self.eye(&light))?.visibility())
    }

    /// What is seen of an image that fills the window's width.
    ///
    /// # Errors
    /// [`VisionError`] for an image that is all black or too small.
    pub fn see_image(&self, image: &LinearImage) -> Result<PictureView, VisionError> {
        let light = luminances(image);
        let (width, height) = (image.width as usize, image.height as usize);
        let px_per_deg = self.px_per_deg(image.width);
        Picture { light: &light, width, height, px_per_deg, mask: None }.see(&self.eye(&light))
    }

    /// What is seen of a surface within its outlines, see [`surface_seen`].
    ///
    /// # Errors
    /// [`VisionError`] for an image that is all black, too small, or not of the frame's size.
    pub fn see_surface(&self, frame: &Frame, image: &LinearImage) -> Result<PictureView, VisionError> {
        surface_seen(frame, image, self.px_per_deg(frame.width), &self.eye(&luminances(image)))
    }

    /// How visible the bands of every condition are.
    ///
    /// # Errors
    /// The error of one that cannot be seen.
    pub fn see_all(&self, conditions: &[Condition]) -> Result<Vec<Visibility>, VisionError> {
        // Pictures keep all threads busy one by one, and need memory.
        if conditions.iter().any(|condition| !condition.stimulus.is_line()) {
            return conditions.iter().map(|condition| self.see(&condition.stimulus)).collect();
        }
        conditions.par_iter().map(|condition| self.see(&condition.stimulus)).collect()
    }

    fn px_per_deg(&self, px: u32) -> f64 {
        f64::from(px) / self.deg
    }
}
