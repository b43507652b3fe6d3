//! Lateral inhibition: one difference of Gaussians, the textbook explanation of Mach bands since Mach 1865 and
//! Ratliff 1965.

use rustfft::num_complex::Complex;

use super::profile::{Baseline, Mark, Spectrum, gaussian, is_profile, overshoots};

/// A balanced center and surround, both Gaussians of area 1.
///
/// The predicted brightness is the response, center minus surround: 0 on any plateau and on any straight ramp. The
/// strength of a band is the overshoot of the response above the adjacent plateau, divided by the light under the
/// surround. It is therefore a contrast: 0.1 means a tenth of the local light.
///
/// For an image that varies only along one direction, the round two-dimensional receptive field is exactly this
/// one-dimensional filter, because the integral of a Gaussian across that direction is a Gaussian of the same width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralInhibition {
    /// Standard deviation of the center, degrees of visual angle, above 0.
    pub center_deg: f64,
    /// Standard deviation of the surround, divided by the standard deviation of the center; above 1.
    pub surround: f64,
}

impl LateralInhibition {
    /// Width of the excitatory part, minutes of arc: mechanism S of Wilson and Bergen (Vision Research 19:19, 1979) at
    /// the fovea, the more sensitive of the two sustained mechanisms, as given by Marr and Hildreth (Proc. R. Soc.
    /// Lond. B 207:187, 1980): N 3.1′, S 6.2′, T 11.7′, U 21′.
    pub const WIDTH_ARCMIN: f64 = 6.2;
    /// Ratio of surround to center of the sustained mechanisms (same sources; 3 for the transient ones).
    pub const SURROUND: f64 = 1.75;

    /// The model whose excitatory part is `width_deg` degrees wide and whose surround is `surround` (> 1) times as wide
    /// as its center. Like Marr and Hildreth's mechanism, it is balanced.
    #[must_use]
    pub fn with_width(width_deg: f64, surround: f64) -> Self {
        // Center and surround of area 1 are equal where x² = 2σ²·ln r·r²/(r² − 1).
        let square = surround * surround;
        let half = (2.0 * surround.ln() * square / (square - 1.0)).sqrt();
        Self { center_deg: 0.5 * width_deg / half, surround }
    }

    /// The gain for a grating of `frequency` cycles per degree.
    #[must_use]
    pub fn gain(&self, frequency: f64) -> f64 {
        gaussian(self.center_deg, frequency) - gaussian(self.surround * self.center_deg, frequency)
    }
}

impl Default for LateralInhibition {
    fn default() -> Self {
        Self::with_width(Self::WIDTH_ARCMIN / 60.0, Self::SURROUND)
    }
}

impl Baseline for LateralInhibition {
    fn name(&self) -> &'static str {
        "lateral inhibition"
    }

    fn marks(&self, light: &[f64], px_per_deg: f64) -> Vec<Mark> {
        if !is_profile(light, px_per_deg) {
            return Vec::new();
        }
        let surround_deg = self.surround * self.center_deg;
        let spectrum = Spectrum::new(light, px_per_deg, 8.0 * surround_deg);
        let [response, mean] =
            spectrum.filtered(|f| [Complex::from(self.gain(f)), Complex::from(gaussian(surround_deg, f))]);
        overshoots(light, &response, px_per_deg, self.center_deg * px_per_deg, |at, over| over / mean[at])
    }
}
