//! Parameters by name: files, commands and the gallery use them to read and change a stimulus. `kind!` declares a kind
//! of stimulus with its parameters.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::color::{ColorError, StimulusColor};
use crate::{
    light::{Depth, DepthError},
    text::{Cell, names::expected_one_of},
};

/// One parameter of a stimulus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// The name used in files.
    pub name: &'static str,
    /// Unit: `1` for a plain number, and empty if the parameter is not a number.
    pub unit: &'static str,
    /// What it means, in one sentence without a period.
    pub description: &'static str,
    /// The values it can have, as worded in error messages.
    pub expected: &'static str,
    /// All values, if the parameter is one of a few names.
    pub choices: &'static [&'static str],
    /// True for a direction, whose levels are circular, so that they cannot increase or decrease.
    pub is_direction: bool,
    /// Values worth comparing in an experiment, each in the form that [`ParameterValue`] reads.
    pub levels_hint: &'static [&'static str],
}

/// The value of a parameter: a finite number or a string such as `inf` or `yellow`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "the value is neither a number nor text; expected one of them")]
pub enum ParameterValue {
    Number(f64),
    /// Anything else.
    Text(String),
}

impl ParameterValue {
    /// Returns a text in quotes, and a number as it is.
    pub(super) fn quoted(&self) -> String {
        if let Self::Text(text) = self { format!("{text:?}") } else { self.to_string() }
    }
}

impl fmt::Display for ParameterValue {
    /// Writes a number in the shortest form that reads back as the same number: `0.4`, `45`, `1`.
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

    /// Reads a finite number as a number, and anything else as a string. `inf` is a string: it names a depth.
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

impl From<ParameterValue> for Cell {
    fn from(value: ParameterValue) -> Self {
        match value {
            ParameterValue::Number(number) => number.into(),
            ParameterValue::Text(text) => text.into(),
        }
    }
}

impl From<&str> for ParameterValue {
    fn from(text: &str) -> Self {
        ParameterValue::Text(text.to_owned())
    }
}

/// The error for a value that a parameter cannot have. Its message is one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{parameter} {value} {problem}; expected {expected}")]
pub struct ParameterError {
    /// Name of the parameter, as given.
    pub parameter: String,
    /// The value that was given.
    pub value: String,
    /// The problem, as a phrase that begins with a verb.
    pub problem: String,
    /// What it should have been.
    pub expected: String,
}

impl ParameterError {
    pub(super) fn new(parameter: &str, value: impl fmt::Display, problem: impl Into<String>, expected: &str) -> Self {
        let expected = expected.trim_start_matches("expected ").to_owned();
        Self { parameter: parameter.to_owned(), value: value.to_string(), problem: problem.into(), expected }
    }

    /// Returns the error for setting `name` to `value` when the kind `kind` has no such parameter, only those in
    /// `known`.
    pub(super) fn unknown(name: &str, value: &ParameterValue, kind: &str, known: &[Parameter]) -> Self {
        let names: Vec<&str> = known.iter().map(|parameter| parameter.name).collect();
        let problem = format!("sets a parameter that {kind} does not have");
        Self::new(name, format_args!("= {value}"), problem, &expected_one_of(name, &names))
    }
}

impl Parameter {
    /// Returns the command-line option that sets this parameter, without the leading dashes. It omits the unit, which
    /// the help text states.
    pub fn option(&self) -> String {
        self.name.trim_end_matches("_deg").replace('_', "-")
    }

    /// Returns the name in words, without its unit: `color high` for `color_high`.
    pub fn words(&self) -> String {
        self.option().replace('-', " ")
    }

    /// Returns the label of its control, with its unit: `Orientation, °` for `orientation_deg`.
    pub fn label(&self) -> String {
        let mut label = self.words();
        label[..1].make_ascii_uppercase();
        if matches!(self.unit, "" | "1") { label } else { format!("{label}, {}", self.unit) }
    }

    /// Returns the error for setting this parameter to `value`.
    pub(super) fn error(&self, value: impl fmt::Display, problem: impl Into<String>) -> ParameterError {
        ParameterError::new(self.name, value, problem, self.expected)
    }
}

/// The values that a parameter can have.
#[derive(Clone, Copy, Debug)]
pub(super) enum Range {
    /// Finite numbers from the first to the second.
    Within(f64, f64),
    /// A direction in degrees: any finite number. Directions are circular: 350° is near 10°.
    Direction,
    /// Any value of the type.
    Any,
}

/// A type of field that can be read from a parameter's value and written as one.
pub(super) trait ParameterType: Sized {
    /// All values, if they are a few names.
    const CHOICES: &'static [&'static str] = &[];
    fn read(parameter: &Parameter, range: Range, value: &ParameterValue) -> Result<Self, ParameterError>;
    fn write(&self) -> ParameterValue;
}

fn number(parameter: &Parameter, range: Range, value: &ParameterValue) -> Result<f64, ParameterError> {
    let ParameterValue::Number(number) = value else {
        return Err(parameter.error(value.quoted(), "is not a number"));
    };
    match range {
        _ if !number.is_finite() => Err(parameter.error(number, "is not a finite number")),
        Range::Within(least, most) if !(least..=most).contains(number) => {
            Err(parameter.error(number, format!("is outside {least}…{most}")))
        }
        _ => Ok(*number),
    }
}

impl ParameterType for f64 {
    fn read(parameter: &Parameter, range: Range, value: &ParameterValue) -> Result<Self, ParameterError> {
        number(parameter, range, value)
    }
    fn write(&self) -> ParameterValue {
        (*self).into()
    }
}

impl ParameterType for u32 {
    fn read(parameter: &Parameter, range: Range, value: &ParameterValue) -> Result<Self, ParameterError> {
        let number = number(parameter, range, value)?;
        if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) {
            Ok(number as u32)
        } else {
            Err(parameter.error(number, "is not a whole number"))
        }
    }
    fn write(&self) -> ParameterValue {
        f64::from(*self).into()
    }
}

/// Implements [`ParameterType`] for types that are written as text; each with all its values, if they are a few names, and with
/// what is wrong with another text.
macro_rules! text_field {
    ($($kind:ty: $choices:expr, $problem:expr;)*) => {$(
        impl $crate::stimulus::parameter::ParameterType for $kind {
            const CHOICES: &'static [&'static str] = $choices;
            fn read(
                parameter: &$crate::stimulus::parameter::Parameter,
                _: $crate::stimulus::parameter::Range,
                value: &$crate::stimulus::parameter::ParameterValue,
            ) -> Result<Self, $crate::stimulus::parameter::ParameterError> {
                value.to_string().parse().map_err(|error| parameter.error(value.quoted(), $problem(error)))
            }
            fn write(&self) -> $crate::stimulus::parameter::ParameterValue {
                let Ok(value) = self.to_string().parse();
                value
            }
        }
    )*};
}
pub(super) use text_field;
text_field! {
    Depth: &[], |error: DepthError| error.problem;
    StimulusColor: &[], |error: ColorError| error.problem;
}

/// What is wrong with a text that is none of a few names.
pub(super) fn unknown<E>(_: E) -> &'static str {
    "is not known"
}

/// The text that stands for the color of the other plateau.
const SAME: &str = "same";

impl ParameterType for Option<StimulusColor> {
    fn read(parameter: &Parameter, range: Range, value: &ParameterValue) -> Result<Self, ParameterError> {
        if value.to_string().trim() == SAME { Ok(None) } else { ParameterType::read(parameter, range, value).map(Some) }
    }
    fn write(&self) -> ParameterValue {
        self.as_ref().map_or(SAME.into(), ParameterType::write)
    }
}

/// Declares a kind of stimulus: a struct whose fields are its parameters, with their defaults, ranges, units, meanings
/// and levels worth comparing. `set`, `get` and `validate` are generated from the declaration. `validate` requires that
/// `low` is not above `high`; the method named after `where` returns an error if a parameter contradicts the others.
macro_rules! kind {
    (
        $(#[$meta:meta])*
        $name:ident = $kind:literal $(where $rule:ident)? {
            $($(#[$field_meta:meta])* $field:ident: $type:ty = $default:expr, $range:expr, $unit:literal, $meaning:expr, $expected:expr, [$($level:literal),*];)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            $(#[doc = concat!("The parameter `", stringify!($field), "`; see [`Self::PARAMETERS`].")] $(#[$field_meta])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $name {
            /// This kind's name in files and commands.
            pub const KIND: &'static str = $kind;

            /// All parameters, in the order of the fields.
            pub const PARAMETERS: &'static [$crate::stimulus::parameter::Parameter] = &[$($crate::stimulus::parameter::Parameter {
                name: stringify!($field),
                unit: $unit,
                description: $meaning,
                expected: $expected,
                choices: <$type as $crate::stimulus::parameter::ParameterType>::CHOICES,
                is_direction: matches!($range, $crate::stimulus::parameter::Range::Direction),
                levels_hint: &[$($level),*],
            },)*];

            /// Sets the parameter `name`. This checks only the range of the parameter itself.
            ///
            /// # Errors
            /// Returns an error if there is no such parameter or it cannot have this value.
            pub fn set(
                &mut self,
                name: &str,
                value: &$crate::stimulus::parameter::ParameterValue,
            ) -> Result<(), $crate::stimulus::parameter::ParameterError> {
                let Some(parameter) = Self::PARAMETERS.iter().find(|parameter| parameter.name == name) else {
                    return Err($crate::stimulus::parameter::ParameterError::unknown(name, value, Self::KIND, Self::PARAMETERS));
                };
                $(if name == stringify!($field) {
                    self.$field = $crate::stimulus::parameter::ParameterType::read(parameter, $range, value)?;
                })*
                Ok(())
            }

            /// Returns the value of the parameter `name`, or `None` if there is no such parameter.
            pub fn get(&self, name: &str) -> Option<$crate::stimulus::parameter::ParameterValue> {
                $(if name == stringify!($field) {
                    return Some($crate::stimulus::parameter::ParameterType::write(&self.$field));
                })*
                None
            }

            /// Checks that every parameter is within its range and that the parameters do not contradict each other.
            ///
            /// # Errors
            /// Returns every error found, in the order of the fields.
            pub fn validate(&self) -> Result<(), Vec<$crate::stimulus::parameter::ParameterError>> {
                let mut probe = self.clone();
                let mut errors: Vec<_> = Self::PARAMETERS
                    .iter()
                    .filter_map(|parameter| probe.set(parameter.name, &self.get(parameter.name)?).err())
                    .collect();
                errors.extend($crate::stimulus::parameter::low_above_high(Self::PARAMETERS, self.low, self.high));
                $(errors.extend(self.$rule());)?
                if errors.is_empty() { Ok(()) } else { Err(errors) }
            }
        }
    };
}
pub(super) use kind;

/// Returns an error if `low` is above `high`. They may be equal, which makes a uniform field.
pub(super) fn low_above_high(parameters: &[Parameter], low: f64, high: f64) -> Option<ParameterError> {
    (low > high).then(|| parameter_error(parameters, "high", high, format!("is below low, which is {low}")))?
}

/// Returns the error for setting the parameter `name` to `value`, or `None` if it is not one of `parameters`.
pub(super) fn parameter_error(
    parameters: &[Parameter],
    name: &str,
    value: impl fmt::Display,
    problem: impl Into<String>,
) -> Option<ParameterError> {
    let parameter = parameters.iter().find(|parameter| parameter.name == name)?;
    Some(parameter.error(value, problem))
}
