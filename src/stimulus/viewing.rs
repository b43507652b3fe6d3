//! A window on a screen, and the eye that sees it; and the smooth surface behind a mesh: what a shader's picture should look
//! like, and how visibly it differs from that.

use rayon::prelude::*;
use serde::Serialize;

use super::catalog::Stimulus;
use crate::{
    display::LuminanceRange,
    light::LinearImage,
    shading::{Frame, Truth, coverage},
    vision::{ContrastSpectrum, DifferenceMap, Eye, SRGB_WEIGHTS, VisionError, luminances},
};

/// A window on a screen, viewed by an eye adapted to the window's mean light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
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

    /// Creates a window of this many degrees on a screen with these luminances, if they are known.
    pub fn on(screen: Option<LuminanceRange>, window_deg: f64) -> Self {
        let range = |LuminanceRange { black_cd_m2, white_cd_m2 }| Self {
            white_cd_m2: white_cd_m2 - black_cd_m2,
            black_cd_m2,
            window_deg,
        };
        screen.map_or_else(|| Self::new(window_deg), range)
    }

    /// Returns a sufficient size for `stimulus`, pixels.
    pub fn px(stimulus: &Stimulus) -> u32 {
        if stimulus.is_line() { Self::LINE_PX } else { Self::PICTURE_PX }
    }

    /// Returns the luminance of light, 1 for white, in cd/m².
    pub fn cd_m2(&self, light: f64) -> f64 {
        self.white_cd_m2 * light + self.black_cd_m2
    }

    /// Returns the luminance of each pixel in cd/m²; `weights` are those of full red, green and blue relative to white.
    pub fn luminances(&self, image: &LinearImage, weights: [f64; 3]) -> Vec<f64> {
        luminances(image, weights).into_iter().map(|light| self.cd_m2(light)).collect()
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

/// Where a shader's pictures of a frame are judged, and the smooth surface if it is known.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The pixels that show the mesh, row by row.
    pub shown: Vec<bool>,
    truth: Option<Smooth>,
}

/// The picture of the smooth surface.
#[derive(Clone, Debug)]
struct Smooth {
    picture: LinearImage,
    /// Where light is compared; see [`Truth::mask`].
    mask: Vec<bool>,
    /// Where a difference is visible as one; see [`Truth::mask`].
    common: Vec<bool>,
    /// See [`Truth::apart`].
    apart: f64,
}

/// Differences count in full from this distance from the pixels where pictures are not compared, degrees, and less
/// nearer by: an abrupt end would be an edge of its own.
const TAPER_DEG: f64 = 0.2;

impl Judged {
    /// Prepares to judge pictures of `frame`, whose mesh approximates `truth`. Outlines and edges that are meant to be
    /// creases do not count; in the residual, terminators and what turns away by more than 72.5° do not, either.
    pub fn new(frame: &Frame, truth: Option<&Truth>) -> Judged {
        let shown = coverage::visible(frame).into_iter().map(|triangle| triangle != coverage::NONE).collect();
        let smooth = |truth: &Truth| Smooth {
            picture: truth.picture(frame),
            mask: truth.mask(frame, true),
            common: truth.mask(frame, false),
            apart: truth.apart(frame),
        };
        Judged { shown, truth: truth.map(smooth) }
    }

    /// Prepares to judge pictures of `frame` against the surface that its mesh is known to approximate, if any.
    pub fn known(frame: &Frame) -> Judged {
        Judged::new(frame, Truth::traced(frame).as_ref())
    }

    /// Returns the share of the mesh's pixels where pictures are not compared with the smooth surface, 0…1; `None` if
    /// the surface is not known.
    pub fn not_compared(&self) -> Option<f64> {
        let Smooth { common, .. } = self.truth.as_ref()?;
        let shown = self.shown.iter().filter(|shown| **shown).count();
        let compared = self.shown.iter().zip(common).filter(|(shown, counts)| **shown && **counts).count();
        Some(1.0 - compared as f64 / shown.max(1) as f64)
    }

    /// Returns the number of pixels that show either the mesh or the smooth surface, as a share of those that show the
    /// mesh; `None` if the surface is not known.
    pub fn apart(&self) -> Option<f64> {
        self.truth.as_ref().map(|truth| truth.apart)
    }

    /// Returns how visible the difference between `picture` and the smooth surface is; `None` if the surface is not
    /// known, or no pixel can be compared.
    ///
    /// # Errors
    /// Returns a [`VisionError`] if the picture is too small, or has no light at a place.
    ///
    /// # Panics
    /// Panics if the picture does not have the size of the frame.
    pub fn difference(
        &self,
        viewing: &ViewingConditions,
        picture: &LinearImage,
    ) -> Result<Option<SurfaceDifference>, VisionError> {
        let Some(Smooth { picture: truth, common: mask, .. }) = &self.truth else { return Ok(None) };
        if !mask.contains(&true) {
            return Ok(None);
        }
        let (width, height) = (truth.width as usize, truth.height as usize);
        let smooth = viewing.luminances(truth, SRGB_WEIGHTS);
        let judge = viewing.judge([width, height], &smooth)?;
        let px = TAPER_DEG * viewing.px_per_deg(truth.width);
        let share: Vec<f64> = distances(mask, width, height, px).iter().map(|away| (away / px).min(1.0)).collect();
        let difference = judge.difference(&viewing.luminances(picture, SRGB_WEIGHTS), &smooth, Some(&share))?;
        let map = difference.map();
        let mut inside: Vec<f64> =
            map.enlarged().into_iter().zip(mask).filter(|(_, counts)| **counts).map(|(times, _)| times).collect();
        inside.sort_by(f64::total_cmp);
        let most = inside.len() - 1;
        Ok(Some(SurfaceDifference { largest: inside[most], p95: inside[most * 95 / 100], map }))
    }

    /// Returns how far `picture` is from the smooth surface; `None` if the surface is not known, or no pixel can be
    /// compared.
    ///
    /// # Panics
    /// Panics if the picture does not have the size of the frame.
    pub fn residual(&self, viewing: &ViewingConditions, picture: &LinearImage) -> Option<Residual> {
        let Smooth { picture: truth, mask, .. } = self.truth.as_ref().filter(|truth| truth.mask.contains(&true))?;
        let light = luminances(truth, SRGB_WEIGHTS);
        let own = luminances(picture, SRGB_WEIGHTS);
        assert_eq!(own.len(), light.len(), "pictures of one frame have one size");
        let difference =
            own.iter().zip(&light).zip(mask).map(|((own, light), counts)| if *counts { own - light } else { 0.0 });
        let eye = viewing.eye(&viewing.luminances(truth, SRGB_WEIGHTS));
        let size = [truth.width, truth.height].map(|side| side as usize);
        let spectrum = ContrastSpectrum::of(&difference.collect::<Vec<_>>(), size, viewing.px_per_deg(truth.width));
        let peak = eye.sensitivity.peak(eye.luminance);
        let filtered = spectrum.filtered(|frequency| eye.sensitivity.at(frequency, eye.luminance) / peak);
        let counted = filtered.iter().zip(mask).filter(|(_, counts)| **counts);
        let mut sizes: Vec<f64> = counted.map(|(value, _)| value.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let rms = (sizes.iter().map(|size| size * size).sum::<f64>() / sizes.len() as f64).sqrt();
        Some(Residual { rms, p999: sizes[(sizes.len() - 1) * 999 / 1000] })
    }
}

/// The difference between a picture and the smooth surface, filtered by the contrast sensitivity of the model of vision.
/// The filter is scaled so that it passes its best frequency unchanged, and the difference is in linear light, 1 for
/// white. Only pixels that can be compared count; elsewhere the difference is taken as 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Residual {
    /// Root mean square.
    pub rms: f64,
    /// The size that one pixel in a thousand exceeds.
    pub p999: f64,
}

/// How visible a picture's difference from the smooth surface is, in times threshold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceDifference {
    /// The largest value on the surface.
    pub largest: f64,
    /// The value that one place in twenty exceeds.
    pub p95: f64,
    #[serde(skip)]
    pub map: DifferenceMap,
}

/// Returns the distance of each pixel from the nearest pixel that does not count, in pixels, but at least `reach` if it is
/// farther away. It is computed first along the columns, and then along the rows.
fn distances(mask: &[bool], width: usize, height: usize, reach: f64) -> Vec<f64> {
    let far = (width + height) as f64;
    let mut squares = vec![0.0; mask.len()];
    for x in 0..width {
        let mut distance = far;
        for y in 0..height {
            distance = if mask[y * width + x] { distance + 1.0 } else { 0.0 };
            squares[y * width + x] = distance;
        }
        distance = far;
        for y in (0..height).rev() {
            distance = if mask[y * width + x] { distance + 1.0 } else { 0.0 };
            let both: f64 = distance.min(squares[y * width + x]);
            squares[y * width + x] = both * both;
        }
    }
    let beside = reach.ceil() as usize;
    let along_row = |row: &[f64]| -> Vec<f64> {
        let nearest = |x: usize| {
            let near = x.saturating_sub(beside)..(x + beside + 1).min(width);
            near.map(|other| (x.abs_diff(other) as f64).powi(2) + row[other]).fold(f64::INFINITY, f64::min).sqrt()
        };
        (0..width).map(nearest).collect()
    };
    squares.par_chunks_exact(width).flat_map_iter(along_row).collect()
}
