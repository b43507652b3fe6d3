//! Parameters by name: how files, commands and the editor reach into a stimulus.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// What there is to know about one parameter of a stimulus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Name, as files write it.
    pub name: &'static str,
    /// Unit; `1` if it is a plain number, empty if it is not a number.
    pub unit: &'static str,
    /// What it means, in one sentence without a full stop.
    pub description: &'static str,
    /// The values it can have, as an error message says it.
    pub expected: &'static str,
    /// Values worth comparing in an experiment, each as [`ParameterValue`] reads it.
    pub levels_hint: &'static [&'static str],
}

/// The value of a parameter: a finite number, or a text such as `inf` or `yellow`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ParameterValue {
    /// A number.
    Number(f64),
    /// Anything else.
    Text(String),
}

impl fmt::Display for ParameterValue {
    /// Numbers in the shortest form that reads back as the same number: `0.4`, `45`, `1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // 0 and −0 are one value and must not become two levels.
            ParameterValue::Number(number) if *number == 0.0 => f.write_str("0"),
            ParameterValue::Number(number) => number.fmt(f),
            ParameterValue::Text(text) => text.fmt(f),
        }
    }
}

impl FromStr for ParameterValue {
    type Err = Infallible;

    /// A number if the text is a finite one, else the text. `inf` is a text: it names a depth.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        Ok(match text.parse::<f64>() {
            Ok(number) if number.is_finite() => ParameterValue::Number(number),
            _ => ParameterValue::Text(text.to_owned()),
        })
    }
}

impl From<f64> for ParameterValue {
    fn from(number: f64) -> Self {
        ParameterValue::Number(number)
    }
}

impl From<&str> for ParameterValue {
    fn from(text: &str) -> Self {
        ParameterValue::Text(text.to_owned())
    }
}

/// A parameter that cannot have the value it was given. Reads as one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{parameter} {value} {problem}; expected {expected}")]
pub struct ParameterError {
    /// Name of the parameter, as it was given.
    pub parameter: String,
    /// The value that was given.
    pub value: String,
    /// What is wrong with it: a verb and what follows.
    pub problem: String,
    /// What it should have been.
    pub expected: String,
}

impl ParameterError {
    /// The error for the parameter `name`, which does not exist, set to `value`, in a stimulus that
    /// has `known` ones.
    pub(super) fn unknown(name: &str, value: &ParameterValue, kind: &str, known: &[Parameter]) -> Self {
        let names: Vec<&str> = known.iter().map(|parameter| parameter.name).collect();
        Self {
            parameter: name.to_owned(),
            value: format!("= {value}"),
            problem: format!("sets a parameter that {kind} does not have"),
            expected: format!("one of {}", names.join(", ")),
        }
    }
}

impl Parameter {
    /// The command-line option that sets it, without the dashes: the unit is left to the help text.
    #[must_use]
    pub fn option(&self) -> String {
        self.name.trim_end_matches("_deg").replace('_', "-")
    }

    /// The error for this parameter set to `value`.
    pub(super) fn error(&self, value: impl fmt::Display, problem: impl Into<String>) -> ParameterError {
        ParameterError {
            parameter: self.name.to_owned(),
            value: value.to_string(),
            problem: problem.into(),
            expected: self.expected.to_owned(),
        }
    }
}
