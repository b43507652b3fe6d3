//! Staircases: the level becomes harder after right answers and easier after wrong ones.

use super::{
    curve::Common,
    kind::Given,
    options::{OptionValue, options},
};
use crate::experiment::faults::DefinitionErrors;

options! {
    /// A transformed and weighted up-down method (Levitt 1971; Kaernbach 1991). By default, it converges to 70.7 % right
    /// answers.
    Staircase {
        start: f64 = f64::NAN, "First level", OptionValue::Number, "The level of the first trial.";
        low: f64 = f64::NAN, "Lowest level", OptionValue::Number, "The lowest level.";
        high: f64 = f64::NAN, "Highest level", OptionValue::Number, "The highest level.";
        down: u32 = 2, "Right in a row", OptionValue::Number, "How many right answers in a row make the level harder.";
        up: u32 = 1, "Wrong in a row", OptionValue::Number, "How many wrong answers in a row make it easier.";
        steps: Vec<f64> = vec![0.2, 0.2, 0.1, 0.1, 0.05], "Steps", OptionValue::Numbers(""), "The size of a step toward harder levels, on the scale of the levels. Each reversal moves on to the next size, and the last one stays.";
        weight: f64 = 1.0, "Step up, in steps down", OptionValue::Number, "The size of a step toward easier levels in steps toward harder ones.";
        #[serde(skip_serializing_if = "Option::is_none")]
        reversals: Option<u32> = None, "Stops after reversals", OptionValue::Optional("never"), "The number of reversals after which it stops.";
    }
}

impl Staircase {
    /// Adds every error.
    pub(super) fn check(&self, common: &Common, given: &Given<'_>, errors: &mut DefinitionErrors) {
        let Self { start, low, high, .. } = *self;
        for (key, _) in [("start", start), ("low", low), ("high", high)].iter().filter(|(_, value)| value.is_nan()) {
            errors.add(format!("adaptive.{key}"), format!("adaptive.{key} is missing; expected {key} = …"));
        }
        if low < high && (start < low || start > high) {
            let message = format!("start {start} is outside {low}…{high}; expected a level in this range");
            errors.add("adaptive.start", message);
        }
        for (key, count) in [("down", self.down), ("up", self.up), ("reversals", self.reversals.unwrap_or(1))] {
            errors.check_range(&format!("adaptive.{key}"), count.into(), 1.0, 1000.0, "a count");
        }
        errors.check_range("adaptive.weight", self.weight, 0.01, 100.0, "the ratio of the two step sizes");
        if self.steps.is_empty() {
            errors.add("adaptive.steps", "steps is empty; expected at least one size");
        }
        let steps = self.steps.iter().enumerate().map(|(i, step)| (format!("adaptive.steps.{i}"), *step));
        if given.stimulus.get(&common.parameter).is_some() {
            given.check_span("adaptive", (&common.parameter, common.log), [low, high], steps, errors);
        }
    }
}

/// A staircase at some trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Stairs {
    /// What the definition says.
    options: (Staircase, Common),
    /// The level of the next trial.
    pub level: f64,
    /// How often the direction of the steps has changed.
    pub reversals: u32,
    /// Right and wrong answers in a row since the last step.
    right: u32,
    wrong: u32,
    /// Whether the last step was toward harder levels.
    harder: Option<bool>,
}

impl Stairs {
    /// Begins at the first level.
    pub fn new(staircase: &Staircase, common: &Common) -> Self {
        let options = (staircase.clone(), common.clone());
        Self { options, level: staircase.start, reversals: 0, right: 0, wrong: 0, harder: None }
    }

    /// Takes an answer. At a reversal, the new step size applies at once.
    pub fn answer(&mut self, right: bool) {
        let (staircase, common) = &self.options;
        (self.right, self.wrong) = if right { (self.right + 1, 0) } else { (0, self.wrong + 1) };
        let harder = self.right >= staircase.down;
        if !harder && self.wrong < staircase.up {
            return;
        }
        (self.right, self.wrong) = (0, 0);
        if self.harder.replace(harder).is_some_and(|before| before != harder) {
            self.reversals += 1;
        }
        let last = staircase.steps.len().saturating_sub(1);
        let step = staircase.steps.get(last.min(self.reversals as usize)).copied().unwrap_or_default();
        let step = if harder { -step } else { step * staircase.weight };
        let level = common.level(common.scaled(self.level) + step * common.sign());
        self.level = level.clamp(staircase.low, staircase.high);
    }

    /// Returns whether it is over.
    pub fn is_over(&self) -> bool {
        self.options.0.reversals.is_some_and(|most| self.reversals >= most)
    }
}
