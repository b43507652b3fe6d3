//! The eye's contrast sensitivity, its frequency channels, and how they treat the borders of an image.

use std::f64::consts::LN_2;

use crate::light::LinearImage;

/// The eye of a standard observer, adapted to a screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Mean luminance of the field, cd/m².
    pub luminance: f64,
    /// Side of the field, degrees.
    pub field_deg: f64,
}

impl Default for Eye {
    /// 50 cd/m² is half the white of a typical screen; 10° is the field of Bangay §3.1.
    fn default() -> Self {
        Self { luminance: 50.0, field_deg: 10.0 }
    }
}

impl Eye {
    /// Returns the contrast sensitivity for a grating of `frequency` cycles per degree, which must be above 0. The
    /// sensitivity is the reciprocal of the contrast that is just visible. The formula of Barten 2003, *Formula for the
    /// contrast sensitivity of the human eye* (Proc. SPIE 5294), covers the optics, photon and neural noise, and the
    /// lateral inhibition that attenuates coarse gratings.
    #[must_use]
    pub fn sensitivity(&self, frequency: f64) -> f64 {
        let u2 = frequency * frequency;
        // In dimmer light, the pupil is larger, and so is the blur.
        let optics = (-0.0016 * frequency * frequency * (1.0 + 100.0 / self.luminance).powf(0.08)).exp();
        let field = 1.0 + 144.0 / (self.field_deg * self.field_deg) + 0.64 * u2;
        let photons = 63.0 / self.luminance.powf(0.83);
        let inhibition = -(-0.02 * u2).exp_m1();
        5200.0 * optics / (field * (photons + 1.0 / inhibition)).sqrt()
    }
}

/// A channel: a filter whose gain is a Gaussian of the logarithm of frequency (log-Gabor; Field 1987, J. Opt. Soc. Am.
/// A 4:2379).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Channel {
    /// Preferred frequency, cycles per degree.
    pub(super) frequency: f64,
}

/// σ of a channel's Gaussian, given as a ratio of frequencies. 0.65 is a bandwidth of 1.5 octaves at half height, close
/// to the median of cells in V1 (1.4 in De Valois, Albrecht & Thorell 1982, Vis. Res. 22:545).
const RATIO: f64 = 0.65;
/// σ of the Gaussian window in which the eye averages light, degrees: the eye adapts locally, not to the whole field.
pub(super) const ADAPTATION_DEG: f64 = 0.5;
/// Frequency of the lowest channel, cycles per degree: half its period is the 8° window.
const MIN_FREQUENCY: f64 = 0.0625;
/// Channels per octave. With fewer, the response to a smooth edge would depend on where the channels happen to lie.
pub(super) const PER_OCTAVE: u32 = 4;
/// Number of channels. They span 7.5 octaves; the highest is 11.3 cycles per degree, above which the eye is barely
/// sensitive.
const CHANNELS: u32 = 31;
/// Beyond this ratio of frequencies, a channel passes less than a hundred-thousandth of the amplitude.
pub(super) const REACH: f64 = 8.0;

impl Channel {
    /// Returns all channels, starting with the coarsest.
    pub(super) fn all() -> impl DoubleEndedIterator<Item = Channel> {
        (0..CHANNELS)
            .map(|k| Channel { frequency: MIN_FREQUENCY * (LN_2 * f64::from(k) / f64::from(PER_OCTAVE)).exp() })
    }

    /// Returns the share of a grating's amplitude that the channel passes, 0…1. `ratio` is the logarithm of the
    /// grating's frequency divided by the channel's frequency.
    #[must_use]
    pub(super) fn passes_log(&self, ratio: f64) -> f64 {
        (-0.5 * (ratio / RATIO.ln()).powi(2)).exp()
    }
}

/// Returns the luminance of a linear sRGB color, 1 for white (IEC 61966-2-1).
#[must_use]
pub fn luminance([red, green, blue]: [f32; 3]) -> f64 {
    0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
}

/// Returns the luminance of each pixel of an image.
#[must_use]
pub fn luminances(image: &LinearImage) -> Vec<f64> {
    image.data.chunks_exact(3).map(|pixel| luminance([pixel[0], pixel[1], pixel[2]])).collect()
}

/// What lies beyond the ends of a profile or the edges of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// The end values continue, as for a ramp between endless plateaus.
    Continues,
    /// The image is cut off: a channel ignores anything within 1.5 periods of the border.
    Cut,
}

/// A channel ignores bands within this many of its periods of the border.
const MARGIN_PERIODS: f64 = 1.5;
/// Closer than this, the channel responds to the border itself, and the response is not used at all.
const UNUSABLE_PERIODS: f64 = 0.75;

impl Border {
    /// Returns the width of the margin in which bands are ignored, degrees.
    pub(super) fn margin_deg(self, frequency: f64) -> f64 {
        match self {
            Border::Continues => 0.0,
            Border::Cut => MARGIN_PERIODS / frequency,
        }
    }

    /// Returns the width of the margin in which the response is not used at all, degrees.
    pub(super) fn unusable_deg(self, frequency: f64) -> f64 {
        match self {
            Border::Continues => 0.0,
            Border::Cut => UNUSABLE_PERIODS / frequency,
        }
    }
}
