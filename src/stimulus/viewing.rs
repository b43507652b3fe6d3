//! What the model of vision makes of stimuli and pictures in a window on a screen.

use super::catalog::Stimulus;
use crate::{
    light::LinearImage,
    shading::{Frame, coverage},
    vision::{
        Border, Eye, Line, LinePrediction, Picture, PicturePrediction, Visibility, VisionError, luminance, luminances,
    },
};

/// An eye is set for no less, cd/m²: a black window is no world.
const LEAST_CD_M2: f64 = 0.01;

/// What is seen of a stimulus.
#[derive(Clone, Debug)]
pub enum StimulusPrediction {
    /// Of one that varies in one direction only.
    Line(LinePrediction),
    /// Of any other.
    Picture(Box<PicturePrediction>),
}

impl StimulusPrediction {
    /// How strong its bands are.
    #[must_use]
    pub fn visibility(&self) -> Visibility {
        match self {
            Self::Line(view) => view.visibility,
            Self::Picture(view) => view.visibility,
        }
    }
}

/// A window on a screen, as an eye sees it that is set for the window's mean light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewingConditions {
    /// The window's width in the eye's field, degrees; above 0.
    pub window_deg: f64,
    /// Luminance of white, cd/m²; above 0.
    pub white_cd_m2: f64,
}

impl ViewingConditions {
    /// Luminance of a common screen's white, cd/m².
    pub const WHITE_CD_M2: f64 = 100.0;
    /// Pixels across that tell enough of a stimulus that varies in one direction.
    pub const LINE_PX: u32 = 1024;
    /// Pixels on a side that tell enough of any other: a picture takes time with its area.
    pub const PICTURE_PX: u32 = 512;

    /// A window of so many degrees on a common screen.
    #[must_use]
    pub fn new(window_deg: f64) -> Self {
        Self { window_deg, white_cd_m2: Self::WHITE_CD_M2 }
    }

    /// [`ViewingConditions::LINE_PX`] or [`ViewingConditions::PICTURE_PX`].
    #[must_use]
    pub fn px(stimulus: &Stimulus) -> u32 {
        if stimulus.is_line() { Self::LINE_PX } else { Self::PICTURE_PX }
    }

    /// What is seen of a stimulus that fills the window with `size` pixels on a side. What varies in one direction is
    /// taken to go on beyond the window as it ends there; of a mesh the outlines are left out, see
    /// [`ViewingConditions::see_surface`].
    ///
    /// # Errors
    /// [`VisionError`] for a window that is too small, and for one that is all black.
    pub fn predict(&self, stimulus: &Stimulus, size: u32) -> Result<StimulusPrediction, VisionError> {
        if stimulus.is_line() {
            let light: Vec<f64> = stimulus.profile(size).into_iter().map(luminance).collect();
            let line = Line { light: &light, px_per_deg: self.px_per_deg(size), border: Border::Continues };
            return Ok(StimulusPrediction::Line(line.predict(&self.eye(&light))?));
        }
        let surface = match stimulus {
            Stimulus::ShadedMesh(shaded) => shaded.frame(size).map(|frame| (frame, shaded)),
            _ => None,
        };
        let view = match surface {
            Some((frame, shaded)) => self.predict_surface(&frame, &shaded.shot(&frame).emitted())?,
            None => self.predict_image(&stimulus.linear(size))?,
        };
        Ok(StimulusPrediction::Picture(Box::new(view)))
    }

    /// What is seen of an image that fills the window's width.
    ///
    /// # Errors
    /// [`VisionError`] for an image that is too small, and for one that is all black.
    pub fn predict_image(&self, image: &LinearImage) -> Result<PicturePrediction, VisionError> {
        self.see_part(image, None)
    }

    /// What is seen of the picture of a surface, on the surface alone: its outlines are left out, where the light has
    /// every reason to jump.
    ///
    /// # Errors
    /// [`VisionError`] for a picture of another size than the frame's, one that is too small, and one that is all black.
    pub fn predict_surface(&self, frame: &Frame, image: &LinearImage) -> Result<PicturePrediction, VisionError> {
        self.see_part(image, Some(&coverage::inside_outlines(frame)))
    }

    fn see_part(&self, image: &LinearImage, mask: Option<&[bool]>) -> Result<PicturePrediction, VisionError> {
        let light = luminances(image);
        let (width, height) = (image.width as usize, image.height as usize);
        Picture { light: &light, width, height, px_per_deg: self.px_per_deg(image.width), mask }
            .predict(&self.eye(&light))
    }

    fn eye(&self, light: &[f64]) -> Eye {
        let mean = light.iter().sum::<f64>() / light.len().max(1) as f64;
        Eye { luminance: (self.white_cd_m2 * mean).max(LEAST_CD_M2), field_deg: self.window_deg }
    }

    fn px_per_deg(&self, px: u32) -> f64 {
        f64::from(px) / self.window_deg
    }
}
