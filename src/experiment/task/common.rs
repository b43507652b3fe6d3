//! What every adaptive method says.

use super::{
    kind::significant,
    options::{OptionValue, options},
};
use crate::text::names::named;

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
