//! Settings of a value in the method of adjustment, in one condition.

use serde::Serialize;

use super::means::Mean;
use crate::statistics::mean_and_sd;

/// On which side of the expected setting an adjustment began.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Start {
    /// Above it.
    Above,
    /// Below it.
    Below,
}

/// A setting.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// The value that was set, in its own unit.
    pub value: f64,
    /// Where it began, if that was controlled. It must not be determined from the setting itself.
    pub start: Option<Start>,
}

/// Why settings cannot be analyzed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AdjustmentError {
    /// A value is infinite, not a number, or has no logarithm.
    #[error("a setting is not a finite number, or is not above 0 on a logarithmic scale")]
    Value,
    /// A person has no settings.
    #[error("expected at least one setting of every person")]
    Empty,
}

/// The settings of one person, in the unit of the values or in decades.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Person {
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation, with n − 1; `None` for a single setting.
    pub sd: Option<f64>,
    /// Their number.
    pub settings: usize,
    /// The mean of those that began above minus that of those that began below; `None` if there are not both.
    pub start_effect: Option<f64>,
}

/// The settings of people in one condition, in the unit of the values or in decades.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Adjustment {
    /// The people, in the order of their settings.
    pub people: Vec<Person>,
    /// The mean of their means. The geometric mean of the values is 10 to this power on a logarithmic scale.
    pub mean: Mean,
    /// The mean effect of where a setting began, over the people with both kinds.
    pub start_effect: Mean,
}

/// Analyzes the settings of each person; if `logarithmic`, their decadic logarithms.
///
/// # Errors
///
/// A value is not finite or has no logarithm, or a person has no settings.
pub fn analyze(people: &[Vec<Setting>], logarithmic: bool) -> Result<Adjustment, AdjustmentError> {
    let people = people.iter().map(|settings| person(settings, logarithmic)).collect::<Result<Vec<_>, _>>()?;
    let mean = Mean::new(&people.iter().map(|person| person.mean).collect::<Vec<_>>());
    let effects: Vec<f64> = people.iter().filter_map(|person| person.start_effect).collect();
    Ok(Adjustment { people, mean, start_effect: Mean::new(&effects) })
}

fn person(settings: &[Setting], logarithmic: bool) -> Result<Person, AdjustmentError> {
    let scaled = |value: f64| if logarithmic { value.log10() } else { value };
    let values: Vec<f64> = settings.iter().map(|setting| scaled(setting.value)).collect();
    if values.is_empty() {
        return Err(AdjustmentError::Empty);
    }
    if values.iter().any(|value| !value.is_finite()) {
        return Err(AdjustmentError::Value);
    }
    let mean_from = |start: Start| {
        let own: Vec<f64> =
            settings.iter().zip(&values).filter(|(setting, _)| setting.start == Some(start)).map(|(_, v)| *v).collect();
        Some(mean_and_sd(&own).0).filter(|mean| !mean.is_nan())
    };
    let (mean, sd) = mean_and_sd(&values);
    let start_effect = mean_from(Start::Above).zip(mean_from(Start::Below)).map(|(above, below)| above - below);
    Ok(Person { mean, sd: Some(sd).filter(|sd| sd.is_finite()), settings: values.len(), start_effect })
}
