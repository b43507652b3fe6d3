//! What every adaptive method says.

use serde::{Deserialize, Serialize};

use super::{
    kind::significant,
    options::{OptionValue, TaskOption},
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

/// What every method says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Common {
    /// The parameter of the stimulus whose levels the method chooses.
    pub parameter: String,
    /// Whether the method counts in decadic logarithms of the level, so that steps are equal ratios.
    pub log: bool,
    /// The end of the levels at which the target is easier to see.
    pub easier: Easier,
    /// The number of trials of each condition, or the most if the method can stop earlier; 1…10,000.
    pub trials: u32,
}

impl Default for Common {
    fn default() -> Self {
        Self { parameter: String::new(), log: true, easier: Easier::High, trials: 40 }
    }
}

impl Common {
    /// The keys of a definition that every method has.
    pub const KEYS: [&str; 4] = ["parameter", "log", "easier", "trials"];

    /// The options, as a form lists them.
    pub const OPTIONS: &[TaskOption] = &[
        TaskOption::new("parameter", "Varies", OptionValue::Parameter(false), "The parameter whose levels are chosen."),
        TaskOption::new(
            "log",
            "Steps are ratios",
            OptionValue::Flag,
            "The method counts in decadic logarithms of the level.",
        ),
        TaskOption::new(
            "easier",
            "Easier to see",
            OptionValue::OneOf(Easier::NAMES),
            "The end of the levels at which the target is easier to see.",
        ),
        TaskOption::new(
            "trials",
            "Trials",
            OptionValue::Number,
            "The number of trials of each condition, or the most if the method can stop earlier.",
        ),
    ];

    /// Returns a level on the scale on which the method counts.
    #[must_use]
    pub fn scaled(&self, level: f64) -> f64 {
        if self.log { level.log10() } else { level }
    }

    /// Returns the level at a place of that scale.
    #[must_use]
    pub fn level(&self, scaled: f64) -> f64 {
        significant(if self.log { f64::powf(10.0, scaled) } else { scaled })
    }

    /// Returns 1 if a higher level is easier, and −1 otherwise.
    #[must_use]
    pub fn sign(&self) -> f64 {
        if self.easier == Easier::High { 1.0 } else { -1.0 }
    }
}
