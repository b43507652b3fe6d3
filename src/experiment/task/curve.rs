//! The levels of every method, and psychometric functions: the probability of an answer as a function of a level.

use statrs::function::erf::erfc;

use super::{
    kind::significant,
    options::{OptionValue, options},
};
use crate::text::names::named;

named! {
    /// The shape of a psychometric function: a sigmoid F that rises from 0 to 1.
    Curve, CurveError {
        /// F(x) = 1 − exp(−10^(β(x−t))), with x the base-10 logarithm of the level; F(t) = 1 − 1/e (Watson 2017).
        Weibull = "weibull",
        /// F(x) = 1/(1 + e^(−β(x−t))); F(t) = ½.
        Logistic = "logistic",
        /// F(x) = Φ(β(x−t)), the cumulative normal distribution with standard deviation 1/β; F(t) = ½.
        Normal = "normal",
    }
}

/// The parameters of a psychometric function ψ(x) = γ + (1 − γ − λ)·F(x; t, β) (Wichmann & Hill 2001, eq. 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Psychometric {
    /// t, on the scale of x.
    pub threshold: f64,
    /// β, per unit of x; a negative slope makes F fall.
    pub slope: f64,
    /// γ, the probability of the answer at a level that cannot be seen, 0…1.
    pub guess: f64,
    /// λ, the probability of another answer at a level that cannot be missed, 0…1.
    pub lapse: f64,
}

impl Curve {
    /// Returns F for z = β(x − t).
    pub fn sigmoid(self, z: f64) -> f64 {
        match self {
            Self::Weibull => -f64::exp_m1(-f64::powf(10.0, z)),
            Self::Logistic => 1.0 / (1.0 + (-z).exp()),
            Self::Normal => 0.5 * erfc(-z / std::f64::consts::SQRT_2),
        }
    }

    /// Returns ψ(x).
    pub fn probability(self, x: f64, parameters: &Psychometric) -> f64 {
        let Psychometric { threshold, slope, guess, lapse } = *parameters;
        guess + (1.0 - guess - lapse) * self.sigmoid(slope * (x - threshold))
    }

    /// Returns z with F = `share`, 0 < share < 1.
    pub fn inverse(self, share: f64) -> f64 {
        match self {
            Self::Weibull => (-(-share).ln_1p()).log10(),
            Self::Logistic => (share / (1.0 - share)).ln(),
            Self::Normal => -std::f64::consts::SQRT_2 * statrs::function::erf::erfc_inv(2.0 * share),
        }
    }
}

/// Returns the entropy of an answer with this probability, nats.
pub(super) fn entropy(p: f64) -> f64 {
    [p, 1.0 - p].into_iter().filter(|p| *p > 0.0).map(|p| -p * p.ln()).sum()
}

named! {
    /// The end of the levels at which the target is easier to see.
    Easier, EasierError {
        /// Higher levels are easier.
        High = "high",
        /// Lower levels are easier.
        Low = "low",
    }
}

options! {
    /// What every method says.
    Common {
        parameter: String = String::new(), "Varies", OptionValue::Parameter(false), "The parameter whose levels are chosen.";
        log: bool = true, "Steps are ratios", OptionValue::Flag, "The method uses base-10 logarithms of the level.";
        easier: Easier = Easier::High, "Easier to see", OptionValue::OneOf(Easier::NAMES), "The end of the levels at which the target is easier to see.";
        trials: u32 = 40, "Trials", OptionValue::Number, "The number of trials of each condition, or the most if the method can stop earlier.";
    }
}

impl Common {
    /// Returns a level on the scale on which the method counts.
    pub fn scaled(&self, level: f64) -> f64 {
        if self.log { level.log10() } else { level }
    }

    /// Returns the level at a place of that scale.
    pub fn level(&self, scaled: f64) -> f64 {
        significant(if self.log { f64::powf(10.0, scaled) } else { scaled })
    }

    /// Returns 1 if a higher level is easier, and −1 otherwise.
    pub fn sign(&self) -> f64 {
        if self.easier == Easier::High { 1.0 } else { -1.0 }
    }
}
