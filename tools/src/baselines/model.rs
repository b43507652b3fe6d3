//! The interface of every one-dimensional model.

/// A band that a one-dimensional model predicts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Position in degrees of visual angle from the middle of the profile, positive toward its end.
    pub at_deg: f64,
    /// Whether it looks brighter than its surround; otherwise, it looks darker.
    pub bright: bool,
    /// Strength in the model's own unit, above 0.
    pub strength: f64,
}

/// A model that predicts bands.
pub trait Baseline {
    /// The model's name, for tables and figures.
    fn name(&self) -> &'static str;

    /// The bands of a profile of linear light, in the order of their position.
    ///
    /// `light` contains samples at pixel centers, `px_per_deg` of them per degree. Beyond its ends, the profile is
    /// constant. There are no bands if the profile has fewer than three samples or a value that is not finite, or if
    /// `px_per_deg` is not above 0 and at most 100 000.
    fn marks(&self, light: &[f64], px_per_deg: f64) -> Vec<Mark>;
}

/// Maximum samples per degree: far beyond the resolution of any eye, but a continued profile still fits into memory.
const MOST_PX_PER_DEG: f64 = 1e5;

/// Whether a model can process this profile at all.
pub fn is_profile(light: &[f64], px_per_deg: f64) -> bool {
    light.len() >= 3 && px_per_deg > 0.0 && px_per_deg <= MOST_PX_PER_DEG && light.iter().all(|value| value.is_finite())
}
