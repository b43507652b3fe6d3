//! Lateral inhibition: one difference of Gaussians, the text-book account of Mach bands since Mach 1865 and
//! Ratliff 1965.

use rustfft::num_complex::Complex;

use super::bands::overshoots;
use super::model::{Baseline, Mark, is_profile};
use super::spectrum::{Spectrum, gaussian};

/// A balanced center and surround of one size, both Gaussians of area 1.
///
/// Predicted brightness is the response, center less surround: 0 on any plateau and on any straight ramp. A band's
/// strength is the response's overshoot over the plateau beside it, divided by the light under the surround, as
/// contrast is: 0.1 is a band of a tenth of the local light.
///
/// For a profile that goes on unchanged across its own direction the round receptive field of two dimensions is
/// exactly this filter of one: a Gaussian's integral across is a Gaussian of the same width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralInhibition {
    /// Standard deviation of the center, degrees of visual angle, above 0.
    pub center_deg: f64,
    /// The surround's standard deviation over the center's, above 1.
    pub surround: f64,
}

impl LateralInhibition {
    /// Width of the excitatory part, minutes of arc: mechanism S of Wilson and Bergen (Vision Research 19:19, 1979)
    /// at the fovea, the more sensitive of the two sustained ones, as Marr and Hildreth give it (Proc. R. Soc. Lond.
    /// B 207:187, 1980): N 3.1′, S 6.2′, T 11.7′, U 21′.
    pub const WIDTH_ARCMIN: f64 = 6.2;
    /// Surround over center of the sustained mechanisms (same sources; 3 for the transient ones).
    pub const SURROUND: f64 = 1.75;

    /// The model whose excitatory part is `width_deg` degrees wide, and whose surround is `surround` (> 1) times as
    /// wide as its center. Marr and Hildreth make the mechanism balanced; so is this one.
    #[must_use]
    pub fn with_width(width_deg: f64, surround: f64) -> Self {
        // Centre and surround of area 1 are equal where x² = 2σ²·ln r·r²/(r² − 1).
        let square = surround * surround;
        let half = (2.0 * surround.ln() * square / (square - 1.0)).sqrt();
        Self { center_deg: 0.5 * width_deg / half, surround }
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
        let [response, mean] = spectrum.filtered(|f| {
            let surround = gaussian(surround_deg, f);
            [Complex::from(gaussian(self.center_deg, f) - surround), Complex::from(surround)]
        });
        overshoots(light, &response, px_per_deg, self.center_deg * px_per_deg, |at, over| over / mean[at])
    }
}
