//! Decides which energy peaks are bands, and how strong they are.

use rustfft::num_complex::Complex64;

use super::eye::PER_OCTAVE;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Polarity {
    /// A line brighter than both sides.
    Bright,
    /// A line darker than both sides.
    Dark,
}

/// A predicted band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Position relative to the center, in degrees: `[right, up]`.
    pub at_deg: [f64; 2],
    /// Direction across the band, in degrees counterclockwise from the right, 0…180. A stimulus's `orientation_deg`
    /// means the same direction.
    pub orientation_deg: f64,
    pub polarity: Polarity,
    /// Contrast times sensitivity, in multiples of the strength that is just visible.
    pub strength: f64,
    /// Preferred frequency of the channel that responds to the band, cycles per degree. The reciprocal is the band's
    /// scale.
    pub frequency: f64,
}

/// Visibility of the bands, pooled over all channels.
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
}

/// The share of the odd response that the even response must exceed. At 1, a band's phase is within 45° of a line's; at
/// ½, it is within 63°. Morrone & Burr 1988 (Proc. R. Soc. B 235:221): the phase of a feature determines whether it
/// looks like a line or an edge.
pub(super) const ODD_SHARE: f64 = 0.5;
/// A peak starts to count when the energy falls by the first share on both sides, and it counts in full from the second
/// share on. This keeps the crests of a grating from counting as bands.
const PROMINENCE: [f64; 2] = [0.3, 0.5];
/// The share of a peak's energy to which the energy must fall for the peak to count at all.
pub(super) const COUNTS_BELOW: f64 = 1.0 - PROMINENCE[0];
/// The share of a peak's energy to which the energy must fall for the peak to count in full.
pub(super) const COUNTS_FULLY_BELOW: f64 = 1.0 - PROMINENCE[1];
/// The energy must fall within this many of the channel's periods.
pub(super) const FALL_PERIODS: f64 = 2.0;
/// Exponent for pooling over channels. Quick 1974 (Kybernetik 16:65) gives 3 to 4 for pooling over frequencies.
const POOLING: i32 = 3;
/// Strong fine detail masks coarser channels. A channel with less than the first share of a finer channel's energy at
/// the same place is masked completely; a channel with more than the second share is not masked at all.
const MASKED: [f64; 2] = [0.3, 0.35];
/// Stray light relative to white: light reflected by the screen or scattered in the eye. Without it, bands on black
/// would be infinitely strong.
pub(super) const VEIL: f64 = 0.01;

/// Returns the strength of an energy peak, or 0 if the peak does not count. `response` is even + i·odd in units of
/// light × sensitivity, `lowest` is the minimum of the energy on the side where it falls less, and `light` is the mean
/// light at the peak.
pub(super) fn strength(response: Complex64, lowest: f64, light: f64) -> f64 {
    let energy = response.norm();
    let even = response.re.abs() - ODD_SHARE * response.im.abs();
    if even <= 0.0 || energy <= 0.0 {
        return 0.0;
    }
    let fall = ((1.0 - lowest / energy) - PROMINENCE[0]) / (PROMINENCE[1] - PROMINENCE[0]);
    even * fall.clamp(0.0, 1.0) / (light.max(0.0) + VEIL)
}

/// Returns the share of a band's strength that remains unmasked. `energy` is the energy of the band's own channel, and
/// `finer` is the energy of a finer channel at the same place.
pub(super) fn unmasked(energy: f64, finer: f64) -> f64 {
    if finer <= 0.0 {
        return 1.0;
    }
    ((energy / finer - MASKED[0]) / (MASKED[1] - MASKED[0])).clamp(0.0, 1.0)
}

/// Returns the energy peak among three neighboring responses: its position, −½…½ steps from the middle one, and the
/// interpolated response there.
pub(super) fn peak([before, here, after]: [Complex64; 3]) -> (f64, Complex64) {
    let [a, b, c] = [before, here, after].map(|response| response.norm());
    let at = vertex(a, b, c);
    (at, here + (after - before) * (at / 2.0) + (after - here * 2.0 + before) * (at * at / 2.0))
}

/// Returns the position of the maximum of the parabola through (−1, `a`), (0, `b`) and (1, `c`), limited to −½…½.
/// Returns 0 if the parabola has no maximum.
#[must_use]
pub fn vertex(a: f64, b: f64, c: f64) -> f64 {
    let bend = 2.0 * b - a - c;
    if bend > 0.0 { (0.5 * (c - a) / bend).clamp(-0.5, 0.5) } else { 0.0 }
}

/// Returns what a channel contributes to the sum over channels.
pub(super) fn to_pooled(strength: f64) -> f64 {
    strength.powi(POOLING)
}

/// Converts a sum of these contributions back to a strength.
pub(super) fn from_pooled(sum: f64) -> f64 {
    sum.powf(1.0 / f64::from(POOLING))
}

/// Pools the strengths of the individual channels into one strength.
#[must_use]
pub fn pooled(channels: impl Iterator<Item = f64>) -> f64 {
    from_pooled(channels.map(to_pooled).sum::<f64>() / f64::from(PER_OCTAVE))
}

impl Visibility {
    /// Pools the visibilities of the individual channels.
    pub(super) fn over(channels: &[Visibility]) -> Visibility {
        let over = |of: fn(&Visibility) -> f64| pooled(channels.iter().map(of));
        Visibility { bright: over(|channel| channel.bright), dark: over(|channel| channel.dark) }
    }

    /// Raises the visibility for `polarity` to `strength` if it was lower.
    pub(super) fn raise_to(&mut self, polarity: Polarity, strength: f64) {
        let strongest = match polarity {
            Polarity::Bright => &mut self.bright,
            Polarity::Dark => &mut self.dark,
        };
        *strongest = strongest.max(strength);
    }
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
        Self { thresholds: [1.01, 4.83, 32.0], spread: 1.29 }
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
