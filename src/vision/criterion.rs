//! How a rater turns what the model computes into ratings.

/// Thresholds between the ratings 0 to 3. A rating is above k if ln of what is rated plus logistic noise exceeds the
/// logarithm of threshold k. What is rated, such as a band, is in times threshold.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Criterion {
    /// The values at which half of the ratings are above 0, 1 and 2. They are positive and increasing.
    pub thresholds: [f64; 3],
    /// Scale of the logistic noise, in units of the logarithm; above 0.
    pub spread: f64,
}

impl Criterion {
    /// Returns the probabilities of the ratings 0…3 for this value, which is at least 0. At 0 there is nothing to see.
    pub fn probabilities(&self, value: f64) -> [f64; 4] {
        let above = self.thresholds.map(|threshold| self.above(value, threshold));
        [1.0 - above[0], above[0] - above[1], above[1] - above[2], above[2]]
    }

    /// Returns the mean rating, 0…3, for this value.
    pub fn mean(&self, value: f64) -> f64 {
        self.thresholds.iter().map(|threshold| self.above(value, *threshold)).sum()
    }

    fn above(&self, value: f64, threshold: f64) -> f64 {
        // (v/t)^(1/s) / (1 + (v/t)^(1/s)) is the logistic function of (ln v − ln t)/s, and it is 0 if there is nothing.
        let odds = (value.max(0.0) / threshold).powf(1.0 / self.spread);
        if odds.is_finite() { odds / (1.0 + odds) } else { 1.0 }
    }
}
