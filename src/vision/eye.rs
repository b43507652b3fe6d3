//! The contrast sensitivity of the eye for gratings, from coarse to fine.

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
    /// 50 cd/m², half the white of a typical screen; 10° as in Bangay §3.1.
    fn default() -> Self {
        Self { luminance: 50.0, field_deg: 10.0 }
    }
}

impl Eye {
    /// Contrast sensitivity for a grating of `frequency` cycles per degree, above 0: the reciprocal of the contrast
    /// that is just visible. Barten 2003, *Formula for the contrast sensitivity of the human eye* (Proc. SPIE 5294),
    /// which includes the optics, photon and neural noise, and lateral inhibition, which attenuates coarse gratings.
    #[must_use]
    pub fn sensitivity(&self, frequency: f64) -> f64 {
        let u2 = frequency * frequency;
        // The darker it is, the larger are the pupil and the blur.
        let optics = (-0.0016 * frequency * frequency * (1.0 + 100.0 / self.luminance).powf(0.08)).exp();
        let field = 1.0 + 144.0 / (self.field_deg * self.field_deg) + 0.64 * u2;
        let photons = 63.0 / self.luminance.powf(0.83);
        let inhibition = -(-0.02 * u2).exp_m1();
        5200.0 * optics / (field * (photons + 1.0 / inhibition)).sqrt()
    }
}

/// One channel, which passes a Gaussian of the logarithm of frequency (log-Gabor; Field 1987, J. Opt.
/// Soc. Am. A 4:2379).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Channel {
    /// Its preferred frequency, cycles per degree.
    pub(super) frequency: f64,
}

/// σ of a channel on the logarithm of frequency, as the ratio of frequencies: 0.65 is a bandwidth of 1.5 octaves at half
/// height, the median of cells in V1 (De Valois, Albrecht & Thorell 1982, Vis. Res. 22:545: 1.4).
const RATIO: f64 = 0.65;
/// σ of the Gaussian over which the eye averages light, degrees: the eye adapts locally, not over the whole field.
pub(super) const ADAPTATION_DEG: f64 = 0.5;
/// Lowest channel, cycles per degree: half a period is the window of 8°.
const LOWEST: f64 = 0.0625;
/// Channels per octave: with fewer, the response to a smooth edge depends on where the channels happen to lie.
pub(super) const PER_OCTAVE: u32 = 4;
/// The highest is 11.3 cycles per degree, above which the eye is hardly sensitive: 7.5 octaves.
const CHANNELS: u32 = 31;
/// Beyond this ratio of frequencies a channel passes less than a hundred-thousandth.
pub(super) const REACH: f64 = 8.0;

impl Channel {
    /// All channels, from the coarsest.
    pub(super) fn all() -> impl DoubleEndedIterator<Item = Channel> {
        (0..CHANNELS).map(|k| Channel { frequency: LOWEST * (LN_2 * f64::from(k) / f64::from(PER_OCTAVE)).exp() })
    }

    /// Share of a grating's amplitude that it passes, 0…1, by the logarithm of the ratio of the grating's frequency to its
    /// own.
    #[must_use]
    pub(super) fn passes_log(&self, ratio: f64) -> f64 {
        (-0.5 * (ratio / RATIO.ln()).powi(2)).exp()
    }
}

/// Luminance of linear light in the primaries of sRGB, 1 for white (IEC 61966-2-1).
#[must_use]
pub fn luminance([red, green, blue]: [f32; 3]) -> f64 {
    0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
}

/// Luminance of every pixel of an image.
#[must_use]
pub fn luminances(image: &LinearImage) -> Vec<f64> {
    image.data.chunks_exact(3).map(|pixel| luminance([pixel[0], pixel[1], pixel[2]])).collect()
}

/// What lies beyond the ends of a profile or the edges of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// It continues as it ends: a ramp between endless plateaus.
    Continues,
    /// Something else: a channel ignores anything within 1.5 periods of an edge.
    Cut,
}

/// A channel ignores bands within this many of its periods from an edge.
const MARGIN_PERIODS: f64 = 1.5;
/// Closer than this, the response is to the edge itself and is not used at all.
const BESIDE_PERIODS: f64 = 0.75;

impl Border {
    /// Width of the margin along the edges in which bands are ignored, degrees.
    pub(super) fn margin_deg(self, frequency: f64) -> f64 {
        match self {
            Border::Continues => 0.0,
            Border::Cut => MARGIN_PERIODS / frequency,
        }
    }

    /// Width of the margin along the edges in which the response is not used, degrees.
    pub(super) fn beside_deg(self, frequency: f64) -> f64 {
        match self {
            Border::Continues => 0.0,
            Border::Cut => BESIDE_PERIODS / frequency,
        }
    }
}
