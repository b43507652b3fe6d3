//! Applies the vision model to stimuli and images in a window on a screen.

use super::{catalog::Stimulus, smooth::Judged, viewing::ViewingConditions};
use crate::{
    light::LinearImage,
    vision::{
        self, Border, Line, LinePrediction, LuminanceImage, PicturePrediction, Visibility, VisionError, luminance,
        luminances,
    },
};

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

    /// Returns the visibility of the lines that are in the light itself.
    #[must_use]
    pub fn lines(&self) -> Visibility {
        match self {
            Self::Line(view) => view.lines,
            Self::Picture(view) => view.lines,
        }
    }
}

impl ViewingConditions {
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
            Some((frame, shaded)) => {
                self.predict_surface(&Judged::known(self, &frame)?, &shaded.shot(&frame).emitted())?
            }
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

    /// Predicts the bands in the picture of a surface, only where they count; see [`Judged::new`].
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the picture does not have the size of the frame, is too small or is all black.
    pub fn predict_surface(&self, judged: &Judged, image: &LinearImage) -> Result<PicturePrediction, VisionError> {
        self.predict_within(image, Some(judged.bands()))
    }

    fn predict_within(&self, image: &LinearImage, mask: Option<&[bool]>) -> Result<PicturePrediction, VisionError> {
        let light = luminances(image);
        LuminanceImage { mask, ..self.luminance_image(image, &light) }.predict(&self.eye(&light))
    }

    /// Returns the contrast of a stimulus that fills the window, in multiples of the threshold of an average person who
    /// looks at its middle; see [`vision::detection`].
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
}
