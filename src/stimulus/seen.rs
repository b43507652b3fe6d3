//! What the model of vision makes of a stimulus.

use super::Stimulus;
use crate::{
    light::LinearImage,
    shading::{Frame, Reference, coverage},
    vision::{Border, Eye, Line, LineView, Picture, PictureView, Visibility, VisionError, luminance, luminances},
};

/// An eye is set for no less, cd/m²: a black window is no world.
const LEAST_CD_M2: f64 = 0.01;

/// What is seen of a stimulus.
#[derive(Clone, Debug)]
pub enum View {
    /// Of one that varies in one direction only.
    Line(LineView),
    /// Of any other.
    Picture(Box<PictureView>),
}

impl View {
    /// How strong its bands are.
    #[must_use]
    pub fn visibility(&self) -> Visibility {
        match self {
            Self::Line(view) => view.visibility,
            Self::Picture(view) => view.visibility,
        }
    }
}

impl Stimulus {
    /// Whether it varies along its orientation alone.
    #[must_use]
    pub fn is_line(&self) -> bool {
        matches!(self, Self::MachBand(_) | Self::Chevreul(_) | Self::Cornsweet(_) | Self::Cylinder(_))
    }

    /// An eye that is set for its mean light, in a window of `size` pixels that takes `window_deg` degrees, where white
    /// has `white_cd_m2`.
    #[must_use]
    pub fn eye(&self, size: u32, window_deg: f64, white_cd_m2: f64) -> Eye {
        let profile = self.profile(size);
        let mean = profile.iter().map(|light| luminance(*light)).sum::<f64>() / profile.len().max(1) as f64;
        Eye { luminance: (white_cd_m2 * mean).max(LEAST_CD_M2), field_deg: window_deg }
    }

    /// What `eye` sees of it in a window of `size` pixels, `px_per_deg` to a degree. What varies in one direction is
    /// taken to go on beyond the window as it ends there; of a mesh the outlines are left out, see [`surface_seen`].
    ///
    /// # Errors
    /// [`VisionError`] for a window that is too small, and for one that is all black.
    pub fn seen(&self, size: u32, px_per_deg: f64, eye: &Eye) -> Result<View, VisionError> {
        if self.is_line() {
            let light: Vec<f64> = self.profile(size).into_iter().map(luminance).collect();
            return Ok(View::Line(Line::new(light.len(), px_per_deg, eye)?.see(&light, Border::Continues)?));
        }
        if let Self::ShadedMesh(shaded) = self
            && let Some(frame) = shaded.frame(size)
        {
            let image = Reference::new(&frame, &shaded.shade()).image();
            return Ok(View::Picture(Box::new(surface_seen(&frame, &image, px_per_deg, eye)?)));
        }
        let light = luminances(&self.linear(size));
        let side = size as usize;
        let picture = Picture { light: &light, width: side, height: side, px_per_deg, mask: None };
        Ok(View::Picture(Box::new(picture.see(eye)?)))
    }
}

/// What `eye` sees of `image`, the picture of a surface, on the surface alone: its outlines are left out, where the
/// light has every reason to jump.
///
/// # Errors
/// [`VisionError`] for a picture of another size than the frame's, one that is too small, and one that is all black.
pub fn surface_seen(
    frame: &Frame,
    image: &LinearImage,
    px_per_deg: f64,
    eye: &Eye,
) -> Result<PictureView, VisionError> {
    let mask = coverage::inside_outlines(frame);
    let light = luminances(image);
    let (width, height) = (frame.width as usize, frame.height as usize);
    Picture { light: &light, width, height, px_per_deg, mask: Some(&mask) }.see(eye)
}
