//! The smooth surface behind a mesh: what a shader's picture should look like, and how far it is from that as far as
//! people can see.

use super::viewing::ViewingConditions;
use crate::{
    light::LinearImage,
    shading::{Frame, Truth, coverage},
    vision::{ContrastSpectrum, LuminanceImage, VisionError, luminances},
};

/// Where a shader's pictures of a frame are judged, and the smooth surface if it is known.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The pixels that show the mesh.
    shown: Vec<bool>,
    /// The picture of the smooth surface, and the pixels where it can be compared; see [`Truth::mask`].
    truth: Option<(LinearImage, Vec<bool>)>,
    /// The pixels where bands count.
    bands: Vec<bool>,
}

/// The visibility from which a band or line of the smooth surface itself counts as seen.
const SEEN: f64 = 0.05;

/// The distance from such a band within which a shader's bands do not count, degrees.
const BESIDE_DEG: f64 = 0.1;

impl Judged {
    /// Prepares to judge pictures of `frame`, whose mesh approximates `truth`.
    ///
    /// Bands do not count at outlines and at edges that are meant to be creases. If the smooth surface is known, they
    /// also do not count at its terminators, where it turns away by more than 72.5°, and beside bands that it has
    /// itself, such as the bends around a highlight.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the frame is too small.
    pub fn new(viewing: &ViewingConditions, frame: &Frame, truth: Option<&Truth>) -> Result<Judged, VisionError> {
        let shown = coverage::visible(frame).into_iter().map(|triangle| triangle != coverage::NONE).collect();
        let Some(truth) = truth else {
            return Ok(Judged { shown, truth: None, bands: coverage::interior_mask(frame) });
        };
        let (picture, mask) = (truth.picture(frame), truth.mask(frame));
        let light = luminances(&picture);
        let mut bands = mask.clone();
        let image = LuminanceImage { mask: Some(&mask), ..viewing.luminance_image(&picture, &light) };
        match image.predict(&viewing.eye(&light)) {
            Ok(own) => {
                let seen = own.map.bright.iter().zip(&own.map.dark).map(|(bright, dark)| bright.max(*dark) >= SEEN);
                let reach = (BESIDE_DEG * viewing.px_per_deg(frame.width)).ceil() as usize;
                for (band, own) in bands.iter_mut().zip(dilated(seen.collect(), frame.width as usize, reach)) {
                    *band &= !own;
                }
            }
            Err(VisionError::AllBlack) => {}
            Err(error) => return Err(error),
        }
        Ok(Judged { shown, truth: Some((picture, mask)), bands })
    }

    /// Prepares to judge pictures of `frame` against the surface that its mesh is known to approximate, if any.
    ///
    /// # Errors
    /// As for [`Judged::new`].
    pub fn known(viewing: &ViewingConditions, frame: &Frame) -> Result<Judged, VisionError> {
        Judged::new(viewing, frame, Truth::traced(frame).as_ref())
    }

    /// The pixels where bands count.
    pub(super) fn bands(&self) -> &[bool] {
        &self.bands
    }

    /// Returns the share of the mesh's pixels where bands do not count, 0…1.
    #[must_use]
    pub fn masked(&self) -> f64 {
        self.share(&self.bands)
    }

    /// Returns the share of the mesh's pixels where pictures are not compared with the smooth surface, 0…1; `None` if
    /// the surface is not known.
    #[must_use]
    pub fn not_compared(&self) -> Option<f64> {
        self.truth.as_ref().map(|(_, mask)| self.share(mask))
    }

    fn share(&self, mask: &[bool]) -> f64 {
        let count = |mask: &mut dyn Iterator<Item = bool>| mask.filter(|is| *is).count() as f64;
        let shown = count(&mut self.shown.iter().copied());
        1.0 - count(&mut self.shown.iter().zip(mask).map(|(shown, counts)| *shown && *counts)) / shown.max(1.0)
    }

    /// Returns how far `picture` is from the smooth surface; `None` if the surface is not known. 0 if no pixel can be
    /// compared.
    ///
    /// # Panics
    /// Panics if the picture does not have the size of the frame.
    #[must_use]
    pub fn residual(&self, viewing: &ViewingConditions, picture: &LinearImage) -> Option<Residual> {
        let (truth, mask) = self.truth.as_ref()?;
        let light = luminances(truth);
        let own = luminances(picture);
        assert_eq!(own.len(), light.len(), "pictures of one frame have one size");
        let difference =
            own.iter().zip(&light).zip(mask).map(|((own, light), counts)| if *counts { own - light } else { 0.0 });
        let eye = viewing.eye(&light);
        let size = [truth.width, truth.height].map(|side| side as usize);
        let spectrum = ContrastSpectrum::of(&difference.collect::<Vec<_>>(), size, viewing.px_per_deg(truth.width));
        let peak = eye.sensitivity.peak(eye.luminance);
        let filtered = spectrum.filtered(|frequency| eye.sensitivity.at(frequency, eye.luminance) / peak);
        let counted = filtered.iter().zip(mask).filter(|(_, counts)| **counts);
        let mut sizes: Vec<f64> = counted.map(|(value, _)| value.abs()).collect();
        if sizes.is_empty() {
            return Some(Residual::default());
        }
        sizes.sort_by(f64::total_cmp);
        let rms = (sizes.iter().map(|size| size * size).sum::<f64>() / sizes.len() as f64).sqrt();
        Some(Residual { rms, p999: sizes[(sizes.len() - 1) * 999 / 1000] })
    }
}

/// The difference between a picture and the smooth surface, filtered by the contrast sensitivity of the model of vision.
/// The filter is scaled so that it passes its best frequency unchanged, and the difference is in linear light, 1 for
/// white. Only pixels that can be compared count; elsewhere the difference is taken as 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Root mean square.
    pub rms: f64,
    /// The size that one pixel in a thousand exceeds.
    pub p999: f64,
}

/// Adds all pixels within `reach` rows and columns of a pixel that is set.
fn dilated(set: Vec<bool>, width: usize, reach: usize) -> Vec<bool> {
    let along = |set: &[bool], stride: usize, line: &dyn Fn(usize) -> usize| -> Vec<bool> {
        let near = |i: usize| {
            (1..=reach).any(|step| {
                let [before, after] = [i.checked_sub(step * stride), Some(i + step * stride)];
                [before, after].into_iter().flatten().any(|j| j < set.len() && line(j) == line(i) && set[j])
            })
        };
        (0..set.len()).map(|i| set[i] || near(i)).collect()
    };
    let rows = along(&set, 1, &|i| i / width);
    along(&rows, width, &|i| i % width)
}
