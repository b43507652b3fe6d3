//! Decides which energy peaks are bands, and how strong they are.

use rustfft::num_complex::Complex64;

use super::eye::PER_OCTAVE;

/// Bright or dark.
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
    /// Position in degrees from the middle: to the right, and up.
    pub at_deg: [f64; 2],
    /// Direction across the band, degrees counterclockwise from the right, 0…180: a stimulus's `orientation_deg`.
    pub orientation_deg: f64,
    /// Bright or dark.
    pub polarity: Polarity,
    /// In multiples of the strength that is just visible: contrast times sensitivity.
    pub strength: f64,
    /// The frequency of the channel that responds to it, cycles per degree; its scale is the reciprocal.
    pub frequency: f64,
}

/// Visibility of the bands, over all channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Visibility {
    /// The strongest bright band.
    pub bright: f64,
    /// The strongest dark band.
    pub dark: f64,
}

impl Visibility {
    /// Visibility of the stronger band; 0 without a band.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.bright.max(self.dark)
    }
}

/// Share of the odd response that the even one must exceed: at 1 a band's phase is within 45° of a line's, at ½ within
/// 63°. Morrone & Burr 1988 (Proc. R. Soc. B 235:221): a feature looks like a line or like an edge by its phase.
pub(super) const ODD: f64 = 0.5;
/// A peak counts if the energy falls by the first share on both sides, and in full from the second share on: the crests
/// of a grating are not bands.
const PROMINENCE: [f64; 2] = [0.3, 0.5];
/// Share of a peak's energy to which it must fall to count at all.
pub(super) const STANDS_OUT: f64 = 1.0 - PROMINENCE[0];
/// Share to which it must fall to count in full.
pub(super) const FALLEN: f64 = 1.0 - PROMINENCE[1];
/// Periods of the channel within which it must fall.
pub(super) const FALL_PERIODS: f64 = 2.0;
/// Exponent of the sum over channels; Quick 1974 (Kybernetik 16:65), 3 to 4 over frequencies.
const POOLING: i32 = 3;
/// Strong fine detail masks coarser channels: a channel with less than the first share of a finer channel's energy at the
/// same place is masked completely, one with more than the second not at all.
const MASKED: [f64; 2] = [0.3, 0.35];
/// Stray light relative to white, reflected by the screen and scattered in the eye. Without it, bands on black would be
/// infinitely strong.
pub(super) const VEIL: f64 = 0.01;

/// Strength of a peak of the energy, 0 for none: `response` is even + i·odd in light × sensitivity, `lowest` the energy's
/// least value on the side where it falls less, `light` the mean light there.
pub(super) fn strength(response: Complex64, lowest: f64, light: f64) -> f64 {
    let energy = response.norm();
    let even = response.re.abs() - ODD * response.im.abs();
    if even <= 0.0 || energy <= 0.0 {
        return 0.0;
    }
    let fall = ((1.0 - lowest / energy) - PROMINENCE[0]) / (PROMINENCE[1] - PROMINENCE[0]);
    even * fall.clamp(0.0, 1.0) / (light.max(0.0) + VEIL)
}

/// Share of a band's strength that is not masked by a finer channel of the energy `finer`, where its own is `energy`.
pub(super) fn unmasked(energy: f64, finer: f64) -> f64 {
    if finer <= 0.0 {
        return 1.0;
    }
    ((energy / finer - MASKED[0]) / (MASKED[1] - MASKED[0])).clamp(0.0, 1.0)
}

/// Value and place, −½…½ steps from the middle, of the peak of the energy of three neighbors; the response there.
pub(super) fn peak([before, here, after]: [Complex64; 3]) -> (f64, Complex64) {
    let [a, b, c] = [before, here, after].map(|response| response.norm());
    let at = vertex(a, b, c);
    (at, here + (after - before) * (at / 2.0) + (after - here * 2.0 + before) * (at * at / 2.0))
}

/// Where the parabola through (−1, `a`), (0, `b`) and (1, `c`) is highest, within −½…½; 0 where it is flat.
#[must_use]
pub fn vertex(a: f64, b: f64, c: f64) -> f64 {
    let bend = 2.0 * b - a - c;
    if bend > 0.0 { (0.5 * (c - a) / bend).clamp(-0.5, 0.5) } else { 0.0 }
}

/// The contribution of a channel to a sum over channels.
pub(super) fn powered(strength: f64) -> f64 {
    strength.powi(POOLING)
}

/// The strength for a sum of such contributions.
pub(super) fn unpowered(sum: f64) -> f64 {
    sum.powf(1.0 / f64::from(POOLING))
}

/// The strength over all channels of the strengths in each.
#[must_use]
pub fn pooled(channels: impl Iterator<Item = f64>) -> f64 {
    unpowered(channels.map(powered).sum::<f64>() / f64::from(PER_OCTAVE))
}

impl Visibility {
    /// Over all channels.
    pub(super) fn over(channels: &[Visibility]) -> Visibility {
        let over = |of: fn(&Visibility) -> f64| pooled(channels.iter().map(of));
        Visibility { bright: over(|channel| channel.bright), dark: over(|channel| channel.dark) }
    }

    /// Keeps the stronger of two.
    pub(super) fn take(&mut self, polarity: Polarity, strength: f64) {
        let strongest = match polarity {
            Polarity::Bright => &mut self.bright,
            Polarity::Dark => &mut self.dark,
        };
        *strongest = strongest.max(strength);
    }
}

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
    /// The result of `machband predict bangay2003 --fit` for 40 simulated sessions of the `paper` observer, seed 1: it reproduces
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
