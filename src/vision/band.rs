//! Bands and their visibility.

/// The sign of a band or line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Polarity {
    /// A line brighter than both sides.
    Bright,
    /// A line darker than both sides.
    Dark,
}

/// A band along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Position relative to the center, degrees to the right.
    pub at_deg: f64,
    pub polarity: Polarity,
    /// Visibility; 1 is just visible.
    pub strength: f64,
}

/// Visibility of the bands, pooled over all channels. 0 means no band; 1 means the response of a thin line at its
/// detection threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Visibility {
    /// The strongest bright band.
    pub bright: f64,
    /// The strongest dark band.
    pub dark: f64,
}

impl Visibility {
    /// Returns the visibility of the stronger band, or 0 if there is no band.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.bright.max(self.dark)
    }

    /// Returns the strongest places of a map of `columns` per row.
    pub(super) fn strongest(map: &BandMap, columns: usize) -> Visibility {
        Visibility { bright: highest(&map.bright, columns), dark: highest(&map.dark, columns) }
    }
}

/// The visibility of bands at each place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandMap {
    /// Visibility of bright bands.
    pub bright: Vec<f64>,
    /// Visibility of dark bands.
    pub dark: Vec<f64>,
}

/// Returns the position of the maximum of the parabola through (−1, `a`), (0, `b`) and (1, `c`), limited to −½…½.
/// Returns 0 if the parabola has no maximum.
#[must_use]
pub fn vertex(a: f64, b: f64, c: f64) -> f64 {
    let bend = 2.0 * b - a - c;
    if bend > 0.0 { (0.5 * (c - a) / bend).clamp(-0.5, 0.5) } else { 0.0 }
}

/// Returns the height of that maximum above `b`.
pub(super) fn crest(a: f64, b: f64, c: f64) -> f64 {
    0.25 * (c - a) * vertex(a, b, c)
}

/// Returns the maximum of a map of `columns` per row, interpolated between neighbors.
fn highest(map: &[f64], columns: usize) -> f64 {
    let Some(at) = (0..map.len()).max_by(|a, b| map[*a].total_cmp(&map[*b])) else { return 0.0 };
    let neighbor = |there: Option<usize>| there.and_then(|there| map.get(there)).copied().unwrap_or(map[at]);
    let (left, right) = (at.checked_sub(1).filter(|_| at % columns > 0), Some(at + 1).filter(|at| at % columns > 0));
    let across = crest(neighbor(left), map[at], neighbor(right));
    let down = crest(neighbor(at.checked_sub(columns)), map[at], neighbor(Some(at + columns)));
    map[at] + across + down
}

/// Thresholds between ratings. A rating is above k if ln visibility plus logistic noise exceeds the logarithm of
/// threshold k.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Criterion {
    /// Visibilities at which half of the ratings are above 0, 1 and 2. They are positive and increasing.
    pub thresholds: [f64; 3],
    /// Scale of the logistic noise, in units of ln visibility; above 0.
    pub spread: f64,
}

impl Default for Criterion {
    /// The result of `machband predict bangay2003 --fit` for 40 simulated sessions of the `paper` observer with seed 1.
    /// That observer reproduces Bangay's Figure 4; the criterion was not fitted to people.
    fn default() -> Self {
        Self { thresholds: [0.116, 0.342, 1.488], spread: 0.802 }
    }
}

impl Criterion {
    /// Returns the probabilities of the ratings 0…3 for a band of this visibility. A visibility of 0 means no band.
    #[must_use]
    pub fn probabilities(&self, visibility: f64) -> [f64; 4] {
        let above = self.thresholds.map(|threshold| self.above(visibility, threshold));
        [1.0 - above[0], above[0] - above[1], above[1] - above[2], above[2]]
    }

    /// Returns the mean rating, 0…3, of a band of this visibility.
    #[must_use]
    pub fn mean(&self, visibility: f64) -> f64 {
        self.thresholds.iter().map(|threshold| self.above(visibility, *threshold)).sum()
    }

    fn above(&self, visibility: f64, threshold: f64) -> f64 {
        // (v/t)^(1/s) / (1 + (v/t)^(1/s)) is the logistic function of (ln v − ln t)/s, and it is 0 if there is no band.
        let odds = (visibility.max(0.0) / threshold).powf(1.0 / self.spread);
        if odds.is_finite() { odds / (1.0 + odds) } else { 1.0 }
    }

    /// Returns the rating for this visibility and this value of standard logistic `noise`.
    #[must_use]
    pub fn rate(&self, visibility: f64, noise: f64) -> u8 {
        let latent = visibility.max(0.0).ln() + self.spread * noise;
        self.thresholds.iter().filter(|threshold| latent > threshold.ln()).count() as u8
    }
}
