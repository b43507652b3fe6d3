//! One trial: what was shown, what was answered, and how likely that answer is.

use std::fmt;
use std::str::FromStr;

use statrs::function::erf::erfc;

use super::Channel;
use crate::light::Transfer;

/// Share of answers that have nothing to do with the picture, allowed for in every likelihood: one slip must not outvote
/// the rest.
const LAPSE: f64 = 0.02;
/// Standard deviation of a slip with the slider, in natural logarithms of light.
const SLIP: f64 = 0.5;
/// Light below which a code counts as dark, relative to full light; keeps the logarithm finite.
const DARK: f64 = 1e-5;

/// A halftone of rows: `lit` of every `period` rows have the code `hi`, the others `lo`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RowField {
    /// Rows of a period that have the high code.
    pub lit: u32,
    /// Rows of a period.
    pub period: u32,
    /// Pixels a row is thick.
    pub row_px: u32,
    /// Code of the other rows.
    pub lo: u8,
    /// Code of the lit rows.
    pub hi: u8,
}

impl RowField {
    /// The mean of what `of` makes of the codes: the mean light, where `of` is light.
    pub fn mean(&self, of: impl Fn(u8) -> f64) -> f64 {
        let share = f64::from(self.lit) / f64::from(self.period);
        share * of(self.hi) + (1.0 - share) * of(self.lo)
    }

    /// The code of pixel row `y`, from 0 at the top.
    #[must_use]
    pub fn code(&self, y: u32) -> u8 {
        if y / self.row_px % self.period < self.lit { self.hi } else { self.lo }
    }

    /// A period in pixels.
    #[must_use]
    pub fn period_px(&self) -> u32 {
        self.period * self.row_px
    }
}

/// What stands on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NullingStimulus {
    /// What carries the light.
    pub channel: Channel,
    /// The rows.
    pub rows: RowField,
    /// Code of the uniform patch.
    pub patch: u8,
}

/// What the observer says of the patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Judgement {
    /// Brighter than the field.
    Brighter,
    /// Darker than the field.
    Darker,
    /// The border has vanished. Counts as half an answer of each kind.
    Same,
    /// Adjusted until the border vanished.
    Matched,
}

impl fmt::Display for Judgement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Judgement::Brighter => "brighter",
            Judgement::Darker => "darker",
            Judgement::Same => "same",
            Judgement::Matched => "matched",
        })
    }
}

impl FromStr for Judgement {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all = [Judgement::Brighter, Judgement::Darker, Judgement::Same, Judgement::Matched];
        let named = all.into_iter().find(|judgement| judgement.to_string() == text);
        named.ok_or_else(|| "expected brighter, darker, same or matched".to_owned())
    }
}

/// One answered trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Observation {
    /// From 1, in the order of the trials.
    pub trial: u32,
    /// Index into [`Plan::levels`](super::Plan::levels).
    pub level: usize,
    /// Whether the patch was meant to be plainly different.
    pub catch: bool,
    /// What was shown; with the slider, as it was accepted.
    pub stimulus: NullingStimulus,
    /// What was answered.
    pub judgement: Judgement,
}

impl Observation {
    /// ln(light of the patch / mean light of the field) on a display where code c makes the light `light(c)`, 0…1.
    pub fn log_ratio(&self, light: impl Fn(u8) -> f64) -> f64 {
        let field = self.stimulus.rows.mean(&light).max(DARK);
        (light(self.stimulus.patch).max(DARK) / field).ln()
    }

    /// Logarithm of the probability of the answer where the patch has e^`log_ratio` times the field's light and the
    /// observer's comparison has the standard deviation `sigma`, in natural logarithms of light.
    ///
    /// P(brighter) = λ/2 + (1 − λ)·Φ(`log_ratio`/`sigma`). A match by slider is normal about equality; a slip is wider.
    #[must_use]
    pub fn log_likelihood(&self, log_ratio: f64, sigma: f64) -> f64 {
        let z = log_ratio / sigma;
        let lapsed = |p: f64| (LAPSE / 2.0 + (1.0 - LAPSE) * p).ln();
        match self.judgement {
            Judgement::Brighter => lapsed(normal_cdf(z)),
            Judgement::Darker => lapsed(normal_cdf(-z)),
            Judgement::Same => 0.5 * (lapsed(normal_cdf(z)) + lapsed(normal_cdf(-z))),
            Judgement::Matched => {
                let density = |sd: f64| (-0.5 * (log_ratio / sd).powi(2)).exp() / sd;
                ((1.0 - LAPSE) * density(sigma) + LAPSE * density(SLIP)).ln()
            }
        }
    }

    /// Whether the answer to a plain difference was wrong, on a display with this transfer function; `None` for other
    /// trials.
    #[must_use]
    pub fn missed(&self, transfer: &Transfer) -> Option<bool> {
        let brighter = self.log_ratio(|code| transfer.linear_from_encoded(f64::from(code) / 255.0)) > 0.0;
        let right = if brighter { Judgement::Brighter } else { Judgement::Darker };
        self.catch.then_some(self.judgement != right)
    }
}

/// The standard normal distribution function.
fn normal_cdf(z: f64) -> f64 {
    0.5 * erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}
