//! A definition without errors.

use std::{collections::HashSet, ops::Deref, sync::Arc, time::Duration};

use serde::{Serialize, Serializer};

use super::{
    condition::{Condition, cross},
    definition::{CATEGORIES, Definition},
    faults::{DefinitionError, DefinitionErrors},
};
use crate::stimulus::ParameterValue;

/// Maximum number of trials per session.
const MAX_TRIALS: usize = 100_000;
/// Typical time to look at a stimulus and rate it, seconds.
const RATING_S: f64 = 3.5;
/// Keys that the session itself uses, so they cannot be answers.
const RESERVED_KEYS: [char; 1] = ['s'];

/// A [`Definition`] without errors, and its conditions: what a session runs. The definition can be read but not changed.
#[derive(Clone, Debug)]
pub struct Protocol {
    definition: Definition,
    conditions: Arc<[Condition]>,
}

impl Deref for Protocol {
    type Target = Definition;

    fn deref(&self) -> &Definition {
        &self.definition
    }
}

/// The definition determines the conditions.
impl PartialEq for Protocol {
    fn eq(&self, other: &Self) -> bool {
        self.definition == other.definition
    }
}

impl Serialize for Protocol {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.definition.serialize(serializer)
    }
}

impl Protocol {
    /// Checks a definition.
    ///
    /// # Errors
    /// Returns every error in the definition.
    pub fn new(definition: Definition) -> Result<Self, Vec<DefinitionError>> {
        let mut errors = DefinitionErrors::default();
        let conditions = definition.check(&mut errors).into();
        if errors.0.is_empty() { Ok(Self { definition, conditions }) } else { Err(errors.0) }
    }

    /// Returns a protocol whose definition differs in what `change` does to it.
    ///
    /// # Errors
    /// Returns every error in the changed definition.
    pub fn with(&self, change: impl FnOnce(&mut Definition)) -> Result<Self, Vec<DefinitionError>> {
        let mut definition = self.definition.clone();
        change(&mut definition);
        Self::new(definition)
    }

    /// Returns all cells of the design, at least one. The last factor varies fastest.
    pub fn conditions(&self) -> &Arc<[Condition]> {
        &self.conditions
    }

    /// Returns the number of main trials.
    pub fn main_trials(&self) -> usize {
        self.conditions.len() * self.design.repetitions as usize
    }

    /// Returns the estimated duration of a session in whole minutes, including one minute for the instructions.
    pub fn minutes(&self) -> u64 {
        let trials = self.main_trials() as f64 + f64::from(self.design.practice);
        (trials * self.trial_s() / 60.0).ceil() as u64 + 1
    }

    /// Returns the estimated duration of a trial, seconds.
    pub(super) fn trial_s(&self) -> f64 {
        self.recovery.duration_s + RATING_S
    }

    /// Returns the duration of the uniform field between stimuli to the nanosecond, as the session measures it.
    pub fn recovery_duration(&self) -> Duration {
        Duration::from_secs_f64(self.recovery.duration_s)
    }

    /// Returns the duration of the stimulus to the nanosecond; `None` if it stays until it is rated.
    pub fn presentation_duration(&self) -> Option<Duration> {
        self.presentation.map(|presentation| Duration::from_secs_f64(presentation.duration_s))
    }

    /// Returns the experiment in gray, for observers who see colors differently from most people. A yellow with equal
    /// amounts of red and green light has a different luminance for each kind of color deficiency, but a gray has the
    /// same luminance for everyone.
    ///
    /// It is a separate experiment: its name ends in `-gray`, so its data go into a separate folder and are not mixed
    /// with the data of the original. Returns `None` if the experiment is already gray, if color is a factor, or if its
    /// name is too long for the suffix.
    #[must_use]
    pub fn in_gray(&self) -> Option<Self> {
        let [gray, same] = ["gray", "same"].map(ParameterValue::from);
        let (color, color_high) = (self.stimulus.get("color")?, self.stimulus.get("color_high"));
        let is_gray = color == gray && color_high.iter().all(|high| *high == same || *high == gray);
        let varies = self.factors.iter().any(|factor| factor.name.starts_with("color"));
        if is_gray || varies {
            return None;
        }
        let in_gray = |copy: &mut Definition| {
            let mut set = |name: &str, value| copy.stimulus.get(name).map(|_| copy.stimulus.set(name, value));
            let _ = (set("color", &gray), set("color_high", &same));
            copy.name += "-gray";
            copy.title += " (gray)";
        };
        self.with(in_gray).ok()
    }
}

impl Definition {
    /// Adds all errors, and returns the conditions; if there are errors in the factors, it returns none.
    fn check(&self, errors: &mut DefinitionErrors) -> Vec<Condition> {
        if let Some(message) = name_error(&self.name) {
            errors.add("name", message);
        }
        let conditions = self.check_factors(errors);
        self.check_design(errors);
        errors.check_range("recovery.duration_s", self.recovery.duration_s, 0.0, 600.0, "seconds");
        errors.check_range("recovery.level", self.recovery.level, 0.0, 1.0, "the relative luminance of the field");
        if let Some(presentation) = &self.presentation {
            let meaning = "seconds; without [presentation] the stimulus stays until it is rated";
            errors.check_range("presentation.duration_s", presentation.duration_s, 0.001, 600.0, meaning);
        }
        errors.check_range("viewing.distance_cm", self.viewing.distance_cm, 1.0, 10_000.0, "cm from eye to screen");
        errors.check_range("viewing.window_deg", self.viewing.window_deg, 0.01, 170.0, "degrees of visual angle");
        if let Some(hours) = self.session.refresh_after_h {
            errors.check_range("session.refresh_after_h", hours, 0.0, 8760.0, "hours");
        }
        let participants = f64::from(self.plan.participants.unwrap_or(1));
        errors.check_range("plan.participants", participants, 1.0, 9999.0, "the number of participants");
        errors.check_range("plan.sessions", self.plan.sessions.into(), 1.0, 99.0, "the sessions of each participant");
        self.check_response(errors);
        self.participant.check(errors);
        errors.0.extend(self.script_errors());
        conditions
    }

    fn check_factors(&self, errors: &mut DefinitionErrors) -> Vec<Condition> {
        let before = errors.0.len();
        for (i, factor) in self.factors.iter().enumerate() {
            let path = format!("factors.{}", factor.name);
            if factor.levels.is_empty() {
                errors.add(&path, format!("factor {} is empty; expected at least one level", factor.name));
            }
            if self.factors[..i].iter().any(|other| other.name == factor.name) {
                errors.add(&path, format!("factor {} appears twice", factor.name));
            }
            // Levels are compared as text in a set, so that even a list of a hundred thousand levels is checked
            // quickly.
            let mut seen = HashSet::new();
            for (j, level) in factor.levels.iter().enumerate() {
                let path = format!("{path}.{j}");
                if let Err(error) = self.stimulus.clone().set(&factor.name, level) {
                    errors.add(path, error.to_string());
                } else if !seen.insert(level.to_string()) {
                    errors.add(
                        path,
                        format!(
                            "level {level} of {} appears twice; expected each level once (repetitions repeat it)",
                            factor.name
                        ),
                    );
                }
            }
        }
        if errors.0.len() > before {
            return Vec::new();
        }
        // With repetitions = 0, which is reported as its own error, there are no trials, but there are still cells.
        let repetitions = self.design.repetitions.max(1) as usize;
        let cells = self.factors.iter().fold(1, |n: usize, factor| n.saturating_mul(factor.levels.len()));
        let main = cells.saturating_mul(repetitions);
        let trials = main.saturating_add(self.design.practice as usize);
        if trials > MAX_TRIALS {
            errors.add("factors", format!("the design has {trials} trials; expected at most {MAX_TRIALS}"));
            return Vec::new();
        }
        // Each level is valid by itself. Now check the cells, where a level of one factor may contradict a level of
        // another.
        let checked = cross(&self.stimulus, &self.factors).and_then(|cells| {
            let error = cells.iter().find_map(|cell| cell.stimulus.validate().err()?.into_iter().next());
            error.map_or(Ok(cells), Err)
        });
        checked.unwrap_or_else(|error| {
            let is_varied = self.factors.iter().any(|factor| factor.name == "low" || factor.name == "high");
            errors.add(if is_varied { "factors" } else { "stimulus" }, error.to_string());
            Vec::new()
        })
    }

    fn check_design(&self, errors: &mut DefinitionErrors) {
        let design = &self.design;
        if design.repetitions == 0 {
            errors.add("design.repetitions", "repetitions is 0; expected at least 1");
        }
        if design.max_run == Some(0) {
            errors.add("design.max_run", "max_run is 0; expected at least 1");
        }
        if let Some(name) = design.order.factor()
            && !self.factors.iter().any(|factor| factor.name == name)
        {
            let known: Vec<_> = self.factors.iter().map(|f| f.name.as_str()).collect();
            errors.add(
                "design.order",
                format!("order {} does not name a factor; expected one of {}", design.order, known.join(", ")),
            );
        }
    }

    fn check_response(&self, errors: &mut DefinitionErrors) {
        let categories = &self.response.categories;
        if !CATEGORIES.contains(&categories.len()) {
            let (least, most) = CATEGORIES.into_inner();
            errors.add(
                "response.labels",
                format!("the number of categories is {}; expected {least} to {most}", categories.len()),
            );
        }
        for (i, category) in categories.iter().enumerate() {
            let path = format!("response.keys.{i}");
            let key = category.key;
            if !key.is_ascii_alphanumeric() || RESERVED_KEYS.contains(&key.to_ascii_lowercase()) {
                errors.add(
                    path,
                    format!("key {key:?} cannot be an answer; expected a digit or a letter A–Z other than S"),
                );
            } else if categories[..i].iter().any(|other| other.key.eq_ignore_ascii_case(&key)) {
                errors.add(path, format!("key {key:?} appears twice; expected a different key for each answer"));
            }
            if category.label.trim().is_empty() {
                errors.add(format!("response.labels.{i}"), "the label is empty; expected the meaning of the answer");
            }
        }
    }
}

/// Returns why `name` cannot be the name of an experiment, or `None` if it can.
pub fn name_error(name: &str) -> Option<String> {
    // Windows does not allow folders with these names, and results move between machines.
    let reserved = ["con", "prn", "aux", "nul"].contains(&name)
        || (name.len() == 4
            && (name.starts_with("com") || name.starts_with("lpt"))
            && name.as_bytes()[3].is_ascii_digit());
    let well_formed = !name.is_empty()
        && name.len() <= 64
        && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-')
        // A spreadsheet would read a cell that starts with a hyphen as a formula, and a command line would read it as
        // an option.
        && !name.starts_with('-')
        && name.bytes().any(|b| b != b'-');
    if !well_formed {
        Some(format!(
            "name {name:?} is not allowed; expected at most 64 lowercase letters, digits and hyphens, with no hyphen first, such as \"bangay2003\""
        ))
    } else if reserved {
        Some(format!("name {name:?} is reserved by Windows; expected another name"))
    } else {
        None
    }
}
