//! What every model of one dimension answers.

/// A band as a model of one dimension sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Where it stands: degrees of visual angle from the profile's middle, positive toward its end.
    pub at_deg: f64,
    /// Whether it looks brighter than its surround, else darker.
    pub bright: bool,
    /// How strong it is, in the model's own unit; above 0.
    pub strength: f64,
}

/// A model that predicts bands.
pub trait Baseline {
    /// The model's name, for tables and figures.
    fn name(&self) -> &'static str;

    /// The bands of a profile of linear light, in the order of their position.
    ///
    /// `light` holds samples at pixel centers, `px_per_deg` of them a degree; beyond its ends the profile
    /// goes on as it ends. A profile of fewer than three samples or with a value that is not finite has no
    /// bands, nor has any at a `px_per_deg` outside 0 (not included) to 100 000.
    fn marks(&self, light: &[f64], px_per_deg: f64) -> Vec<Mark>;
}

/// Most samples a degree: far beyond any eye, and a profile's continuation still fits into memory.
const MOST_PX_PER_DEG: f64 = 1e5;

/// Whether a model can look at this profile at all.
pub fn is_profile(light: &[f64], px_per_deg: f64) -> bool {
    light.len() >= 3 && px_per_deg > 0.0 && px_per_deg <= MOST_PX_PER_DEG && light.iter().all(|value| value.is_finite())
}
