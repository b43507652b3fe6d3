//! What a definition says about an adaptive method.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::{
    common::Common,
    kind::Kind,
    kinds::kinds,
    options::{OptionValue, TaskOption},
    quest::QuestPlus,
    staircase::Staircase,
};
use crate::{
    experiment::{condition::Factor, faults::DefinitionErrors},
    stimulus::Stimulus,
};

/// The method of constant stimuli: every level occurs equally often, in random order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Constant {
    /// The levels.
    pub levels: Vec<f64>,
}

impl Constant {
    /// The options, as a form lists them.
    pub const OPTIONS: &[TaskOption] =
        &[TaskOption::new("levels", "Levels", OptionValue::Numbers(""), "The levels; each occurs equally often.")];
}

kinds! {
    /// How levels are chosen.
    Method, "method" {
        /// Up after wrong answers, down after right ones.
        Staircase(Staircase) = "staircase",
        /// The level whose answer is expected to tell most.
        QuestPlus(QuestPlus) = "quest-plus",
        /// Every level equally often.
        Constant(Constant) = "constant",
    }
}

impl Default for Method {
    fn default() -> Self {
        Self::Constant(Constant::default())
    }
}

/// A method that chooses the levels of a parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Adaptive {
    /// What every method says.
    #[serde(flatten)]
    pub common: Common,
    /// The method with its own options.
    #[serde(flatten)]
    pub method: Method,
}

impl Adaptive {
    /// Returns the lowest and the highest level.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let of = |levels: &[f64]| [f64::min, f64::max].map(|end| levels.iter().copied().fold(f64::NAN, end));
        match &self.method {
            Method::Staircase(stairs) => [stairs.low, stairs.high],
            Method::QuestPlus(quest) => of(&quest.levels),
            Method::Constant(constant) => of(&constant.levels),
        }
    }

    /// Returns the parameters that the method varies.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        let second = if let Method::QuestPlus(quest) = &self.method { quest.second.as_ref() } else { None };
        [self.common.parameter.as_str()].into_iter().chain(second.map(|second| second.parameter.as_str()))
    }

    /// Adds every error.
    pub fn check(&self, stimulus: &Stimulus, factors: &[Factor], task: &dyn Kind, errors: &mut DefinitionErrors) {
        for name in self.parameters() {
            let path = if name == self.common.parameter { "adaptive.parameter" } else { "adaptive.second.parameter" };
            if name.is_empty() || stimulus.get(name).is_none() {
                let names: Vec<&str> = stimulus.parameters().iter().map(|parameter| parameter.name).collect();
                errors.add(path, format!("parameter {name:?} is not known; expected one of {}", names.join(", ")));
            } else if factors.iter().any(|factor| factor.name == name) {
                errors.add(path, format!("{name} is a factor; expected a parameter that no factor varies"));
            }
        }
        errors.check_range("adaptive.trials", self.common.trials.into(), 1.0, 10_000.0, "the trials of a condition");
        match &self.method {
            Method::Staircase(stairs) => stairs.check(&self.common, errors),
            Method::QuestPlus(quest) => quest.check(&self.common, task.guess(), errors),
            Method::Constant(constant) => self.check_constant(&constant.levels, errors),
        }
        self.check_levels(stimulus, errors);
    }

    fn check_constant(&self, levels: &[f64], errors: &mut DefinitionErrors) {
        let (trials, count) = (self.common.trials, levels.len() as u32);
        if count < 2 {
            errors.add("adaptive.levels", format!("the number of levels is {count}; expected at least 2"));
        } else if !trials.is_multiple_of(count) {
            let message =
                format!("trials {trials} is no multiple of the {count} levels; expected each level equally often");
            errors.add("adaptive.trials", message);
        }
    }

    /// Adds an error if a level is not positive on a logarithmic scale, or the stimulus cannot have it.
    fn check_levels(&self, stimulus: &Stimulus, errors: &mut DefinitionErrors) {
        let name = &self.common.parameter;
        if stimulus.get(name).is_none() {
            return;
        }
        let keys = if let Method::Staircase(_) = self.method { ["low", "high"] } else { ["levels"; 2] };
        let mut told = BTreeSet::new();
        for (key, level) in keys.into_iter().zip(self.range()) {
            let path = format!("adaptive.{key}");
            let message = match stimulus.clone().set(name, &level.into()) {
                _ if level.is_nan() => continue,
                Err(error) => error.to_string(),
                Ok(()) if self.common.log && level <= 0.0 => {
                    format!("level {level} is not above 0; expected positive levels, or log = false")
                }
                Ok(()) => continue,
            };
            if told.insert(message.clone()) {
                errors.add(path, message);
            }
        }
    }
}
