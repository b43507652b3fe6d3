//! From the visibility of a band to its rating.

/// Thresholds between ratings: the rating is above k if ln visibility plus logistic noise is above the logarithm of
/// threshold k.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Criterion {
    /// Visibility at which half of the ratings are above 0, 1, 2; above 0 and rising.
    pub thresholds: [f64; 3],
    /// Scale of the logistic noise, on ln visibility; above 0.
    pub spread: f64,
}

impl Default for Criterion {
    /// What `machband predict bangay2003 --fit` finds in 40 simulated sessions of the `paper` observer, seed 1: it reproduces
    /// Bangay's Figure 4, and was not fitted to people.
    fn default() -> Self {
        Self { thresholds: [1.01, 4.83, 32.0], spread: 1.29 }
    }
}

impl Criterion {
    /// Probability of each rating 0…3 of a band of this visibility, 0 for none.
    #[must_use]
    pub fn probabilities(&self, visibility: f64) -> [f64; 4] {
        let above = self.thresholds.map(|threshold| self.above(visibility, threshold));
        [1.0 - above[0], above[0] - above[1], above[1] - above[2], above[2]]
    }

    /// Mean rating of a band of this visibility, 0…3.
    #[must_use]
    pub fn mean(&self, visibility: f64) -> f64 {
        self.thresholds.iter().map(|threshold| self.above(visibility, *threshold)).sum()
    }

    fn above(&self, visibility: f64, threshold: f64) -> f64 {
        // (v/t)^(1/s) / (1 + (v/t)^(1/s)): the logistic function of (ln v − ln t)/s, and 0 for no band.
        let odds = (visibility.max(0.0) / threshold).powf(1.0 / self.spread);
        if odds.is_finite() { odds / (1.0 + odds) } else { 1.0 }
    }

    /// The rating with standard logistic `noise`.
    #[must_use]
    pub fn rate(&self, visibility: f64, noise: f64) -> u8 {
        let latent = visibility.max(0.0).ln() + self.spread * noise;
        self.thresholds.iter().filter(|threshold| latent > threshold.ln()).count() as u8
    }
}
