//! Applies the vision model to stimuli and images in a window on a screen.

use super::catalog::Stimulus;
use crate::{
    light::LinearImage,
    shading::{Frame, coverage},
    vision::{
        self, Border, Eye, Line, LinePrediction, LuminanceImage, PicturePrediction, Visibility, VisionError, luminance,
        luminances,
    },
};

/// Minimum adapting luminance, cd/m²: some light reaches the eye even from a black window.
const MIN_CD_M2: f64 = 0.01;

/// Pixels per degree of the pictures whose detection is predicted: as fine as an average person sees with ease.
const DETECTION_PX_PER_DEG: f64 = 25.0;

/// The prediction for a stimulus.
#[derive(Clone, Debug)]
pub enum StimulusPrediction {
    /// For a stimulus that varies in one direction only.
    Line(LinePrediction),
    /// For any other stimulus.
    Picture(Box<PicturePrediction>),
}

impl StimulusPrediction {
    /// Returns the visibility of the stimulus's bands.
    #[must_use]
    pub fn visibility(&self) -> Visibility {
        match self {
            Self::Line(view) => view.visibility,
            Self::Picture(view) => view.visibility,
        }
    }
}

/// A window on a screen, viewed by an eye adapted to the window's mean light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewingConditions {
    /// The window's width in degrees of visual angle; above 0.
    pub window_deg: f64,
    /// Luminance of white, cd/m²; above 0.
    pub white_cd_m2: f64,
}

impl ViewingConditions {
    /// Luminance of white on a typical screen, cd/m².
    pub const WHITE_CD_M2: f64 = 100.0;
    /// A sufficient width for a stimulus that varies in one direction, pixels.
    pub const LINE_PX: u32 = 1024;
    /// A sufficient side for any other stimulus, pixels. It is smaller because the time grows with the area.
    pub const PICTURE_PX: u32 = 512;

    /// Maximum side of a picture in pixels: the model keeps dozens of numbers for each pixel. A line has no such limit.
    pub const MAX_PICTURE_PX: u32 = 4096;

    /// Creates a window of this many degrees on a typical screen.
    #[must_use]
    pub fn new(window_deg: f64) -> Self {
        Self { window_deg, white_cd_m2: Self::WHITE_CD_M2 }
    }

    /// Returns a sufficient size for `stimulus`, pixels.
    #[must_use]
    pub fn px(stimulus: &Stimulus) -> u32 {
        if stimulus.is_line() { Self::LINE_PX } else { Self::PICTURE_PX }
    }

    /// Predicts the bands in a stimulus that fills the window with `size` pixels per side. A stimulus that varies in
    /// one direction keeps its end values beyond the window. For a mesh, only the surface counts; see
    /// [`ViewingConditions::predict_surface`].
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the window is too small or all black.
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

    /// Predicts the bands in an image that fills the window's width.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the image is too small or all black.
    pub fn predict_image(&self, image: &LinearImage) -> Result<PicturePrediction, VisionError> {
        self.predict_within(image, None)
    }

    /// Predicts the bands in the picture of a surface. It excludes the outlines, where the light inevitably jumps.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the picture does not have the size of the frame, is too small or is all black.
    pub fn predict_surface(&self, frame: &Frame, image: &LinearImage) -> Result<PicturePrediction, VisionError> {
        self.predict_within(image, Some(&coverage::interior_mask(frame)))
    }

    fn predict_within(&self, image: &LinearImage, mask: Option<&[bool]>) -> Result<PicturePrediction, VisionError> {
        let light = luminances(image);
        LuminanceImage { mask, ..self.luminance_image(image, &light) }.predict(&self.eye(&light))
    }

    /// Returns how many times the contrast of a stimulus that fills the window stands above the threshold of an average
    /// person, who looks at its middle; see [`vision::detection`].
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the window is all black.
    pub fn detection(&self, stimulus: &Stimulus) -> Result<f64, VisionError> {
        let size = (DETECTION_PX_PER_DEG * self.window_deg).clamp(256.0, 1024.0) as u32;
        self.detection_of_image(&stimulus.linear(size))
    }

    /// Returns the same for an image that fills the window's width.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the image is all black.
    pub fn detection_of_image(&self, image: &LinearImage) -> Result<f64, VisionError> {
        let light = luminances(image);
        vision::detection(&self.luminance_image(image, &light), &self.eye(&light))
    }

    fn luminance_image<'a>(&self, image: &LinearImage, light: &'a [f64]) -> LuminanceImage<'a> {
        let (width, height) = (image.width as usize, image.height as usize);
        LuminanceImage { light, width, height, px_per_deg: self.px_per_deg(image.width), mask: None }
    }

    fn eye(&self, light: &[f64]) -> Eye {
        let mean = light.iter().sum::<f64>() / light.len().max(1) as f64;
        Eye::adapted_to((self.white_cd_m2 * mean).max(MIN_CD_M2))
    }

    fn px_per_deg(&self, px: u32) -> f64 {
        f64::from(px) / self.window_deg
    }
}
