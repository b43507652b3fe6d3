//! The definition of an experiment, validated once.

use std::{collections::HashSet, time::Duration};

use serde::{Deserialize, Serialize, Serializer, ser::SerializeMap as _};

use super::{
    condition::{Condition, Factor, cross, serialize_factors},
    faults::{DefinitionError, DefinitionErrors},
    participant::ParticipantFields,
    texts::Texts,
};
use crate::{
    light::names::serde_as_text,
    stimulus::{ParameterError, ParameterValue, Stimulus},
};

/// Highest rating on the paper's scale; ratings are 0…3 (Bangay §3.1).
pub const MAX_RATING: u8 = 3;
/// Maximum number of trials per session.
const MAX_TRIALS: usize = 100_000;
/// Typical time to look at a stimulus and rate it, seconds.
const RATING_S: f64 = 3.5;

/// An experiment: what is varied, in what order it is shown, and how it is shown and rated. It is serialized in the
/// form of a definition, so that the copy in a sidecar can be read back.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Protocol {
    /// Version of the definition's format; 1.
    pub schema: u32,
    /// Name, `[a-z0-9-]+`. The results folder has the same name.
    pub name: String,
    /// Title for people, one line.
    pub title: String,
    /// The stimulus with the parameters that do not vary.
    pub stimulus: Stimulus,
    /// The factors to cross, in the order of the definition.
    #[serde(serialize_with = "serialize_factors")]
    pub factors: Vec<Factor>,
    /// Number and order of the trials.
    pub design: Design,
    /// What is shown between stimuli.
    pub recovery: Recovery,
    /// How long the stimulus is shown. If `None`, it stays until it is rated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub presentation: Option<Presentation>,
    /// The rating scale.
    pub response: ResponseScale,
    /// The planned viewing geometry.
    pub viewing: ViewingPlan,
    /// What is asked about the participant before the first page.
    #[serde(skip_serializing_if = "ParticipantFields::is_empty")]
    pub participant: ParticipantFields,
    /// The participant's texts.
    pub instructions: Texts,
}

/// Number and order of the trials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Design {
    /// Number of main trials for each condition, at least 1.
    pub repetitions: u32,
    /// Number of practice trials, which are drawn from the same conditions.
    pub practice: u32,
    /// Number of main trials between two breaks; 0 for no breaks.
    pub break_every: u32,
    /// Order of the main trials.
    pub order: Order,
    /// Maximum number of consecutive trials with the same level of a factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_run: Option<u32>,
}

/// Order of the main trials.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// All trials are shuffled together.
    Random,
    /// One block for each level of a factor. The blocks are in random order, and the trials are shuffled within each
    /// block.
    Blocked(String),
    /// One block for each level of a factor. A Williams square counterbalances the order of the blocks across
    /// participants, and the trials are shuffled within each block.
    Latin(String),
}

impl Order {
    /// Returns the factor that defines the blocks, if there are any.
    pub fn factor(&self) -> Option<&str> {
        match self {
            Self::Random => None,
            Self::Blocked(factor) | Self::Latin(factor) => Some(factor),
        }
    }
}

impl std::fmt::Display for Order {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Random => write!(f, "random"),
            Self::Blocked(factor) => write!(f, "blocked:{factor}"),
            Self::Latin(factor) => write!(f, "latin:{factor}"),
        }
    }
}

impl std::str::FromStr for Order {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "random" => Ok(Self::Random),
            Some(("blocked", factor)) => Ok(Self::Blocked(factor.to_owned())),
            Some(("latin", factor)) => Ok(Self::Latin(factor.to_owned())),
            _ => Err(format!("order {text:?} is unknown; expected random, blocked:FACTOR or latin:FACTOR")),
        }
    }
}

serde_as_text!(Order);

/// The uniform field between stimuli (Bangay §3.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Recovery {
    /// Seconds, 0…600.
    pub duration_s: f64,
    /// Relative luminance in linear light, 0…1, in the color of the stimulus.
    pub level: f64,
}

impl Recovery {
    /// Returns the duration to the nanosecond, as the session measures it.
    pub fn duration(&self) -> Duration {
        Duration::try_from_secs_f64(self.duration_s).unwrap_or_default()
    }
}

/// A stimulus of fixed duration. The uniform field follows until the stimulus is rated; an earlier rating ends the
/// stimulus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Presentation {
    /// Seconds, 0.001…600.
    pub duration_s: f64,
}

impl Presentation {
    /// Returns the duration to the nanosecond, as the session measures it.
    pub fn duration(&self) -> Duration {
        Duration::try_from_secs_f64(self.duration_s).unwrap_or_default()
    }
}

/// The rating scale: one category for each of the ratings 0…3.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseScale {
    /// Shown next to the scale.
    pub question: String,
    /// Categories in the order of their ratings.
    pub categories: Vec<Category>,
}

/// Serializes the scale as it appears in a definition: question, labels and keys.
impl Serialize for ResponseScale {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("question", &self.question)?;
        map.serialize_entry("labels", &self.categories.iter().map(|c| &c.label).collect::<Vec<_>>())?;
        map.serialize_entry("keys", &self.categories.iter().map(|c| c.key).collect::<Vec<_>>())?;
        map.end()
    }
}

/// One possible answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Category {
    /// What the answer means.
    pub label: String,
    /// The key for this answer: one digit or letter.
    pub key: char,
}

/// The planned viewing geometry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ViewingPlan {
    /// Distance from the eye to the screen, cm.
    pub distance_cm: f64,
    /// Side of the square stimulus, degrees of visual angle.
    pub window_deg: f64,
}

impl Default for Design {
    fn default() -> Self {
        Self { repetitions: 1, practice: 0, break_every: 0, order: Order::Random, max_run: None }
    }
}

impl Default for Recovery {
    fn default() -> Self {
        Self { duration_s: 2.0, level: 0.5 }
    }
}

impl Default for ViewingPlan {
    /// About 10° at 50 cm (Bangay §3.1).
    fn default() -> Self {
        Self { distance_cm: 50.0, window_deg: 10.0 }
    }
}

impl Default for ResponseScale {
    /// The paper's four categories (Bangay §3.1).
    fn default() -> Self {
        let labels = ["No band", "Broad band", "Narrow band, indistinct boundaries", "Narrow band, clearly defined"];
        Self {
            question: "How visible is the brighter band?".to_owned(),
            categories: labels
                .iter()
                .zip('0'..)
                .map(|(label, key)| Category { label: (*label).to_owned(), key })
                .collect(),
        }
    }
}

/// Keys that the session itself uses, so they cannot be answers.
const RESERVED_KEYS: [char; 1] = ['s'];

impl Protocol {
    /// Returns all cells of the design. The last factor varies fastest.
    ///
    /// This never fails for a validated protocol. The error is also one of [`Protocol::errors`].
    pub fn conditions(&self) -> Result<Vec<Condition>, ParameterError> {
        cross(&self.stimulus, &self.factors)
    }

    /// Returns the number of main trials.
    pub fn main_trials(&self) -> usize {
        self.cells().saturating_mul(self.design.repetitions as usize)
    }

    /// Returns the estimated duration of a session in whole minutes, including one minute for the instructions.
    pub fn minutes(&self) -> u64 {
        let trials = self.main_trials() as f64 + f64::from(self.design.practice);
        let minutes = trials * self.trial_s() / 60.0;
        // The cast saturates, so the duration of an invalid definition does no harm.
        (minutes.ceil() as u64).saturating_add(1)
    }

    /// Returns the estimated duration of a trial, seconds.
    pub(super) fn trial_s(&self) -> f64 {
        self.recovery.duration_s + RATING_S
    }

    fn cells(&self) -> usize {
        self.factors.iter().fold(1, |n: usize, factor| n.saturating_mul(factor.levels.len()))
    }

    /// Returns the name without hyphens, for file names: a Psych-DS keyword value must be alphanumeric.
    pub fn task(&self) -> String {
        self.name.replace('-', "")
    }

    /// Returns the experiment in gray, for observers who see colors differently from most people. A yellow with equal
    /// amounts of red and green light has a different luminance for each kind of color deficiency, but a gray has the
    /// same luminance for everyone.
    ///
    /// It is a separate experiment: its name ends in `-gray`, so its data go into a separate folder and are not mixed
    /// with the data of the original. Returns `None` if the experiment is already gray or if color is a factor.
    #[must_use]
    pub fn in_gray(&self) -> Option<Self> {
        let [gray, same] = ["gray", "same"].map(ParameterValue::from);
        let (color, color_high) = (self.stimulus.get("color")?, self.stimulus.get("color_high"));
        let is_gray = color == gray && color_high.iter().all(|high| *high == same || *high == gray);
        let varies = self.factors.iter().any(|factor| factor.name.starts_with("color"));
        if is_gray || varies {
            return None;
        }
        let mut copy = self.clone();
        copy.stimulus.set("color", &gray).ok()?;
        if color_high.is_some() {
            copy.stimulus.set("color_high", &same).ok()?;
        }
        copy.name += "-gray";
        copy.title += " (gray)";
        Some(copy)
    }

    /// Returns all errors; a valid protocol has none.
    pub fn errors(&self) -> Vec<DefinitionError> {
        let mut errors = DefinitionErrors::default();
        if let Some(message) = name_error(&self.name) {
            errors.add("name", message);
        }
        self.factor_errors(&mut errors);
        self.design_errors(&mut errors);
        errors.check_range("recovery.duration_s", self.recovery.duration_s, 0.0, 600.0, "seconds");
        errors.check_range("recovery.level", self.recovery.level, 0.0, 1.0, "the relative luminance of the field");
        if let Some(presentation) = &self.presentation {
            let meaning = "seconds; without [presentation] the stimulus stays until it is rated";
            errors.check_range("presentation.duration_s", presentation.duration_s, 0.001, 600.0, meaning);
        }
        errors.check_range("viewing.distance_cm", self.viewing.distance_cm, 1.0, 10_000.0, "cm from eye to screen");
        errors.check_range("viewing.window_deg", self.viewing.window_deg, 0.01, 170.0, "degrees of visual angle");
        self.response_errors(&mut errors);
        self.participant.check(&mut errors);
        errors.0
    }

    fn factor_errors(&self, errors: &mut DefinitionErrors) {
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
            return;
        }
        // With repetitions = 0, which is reported as its own error, there are no trials, but there are still cells.
        let repetitions = self.design.repetitions.max(1) as usize;
        let main = self.cells().saturating_mul(repetitions);
        let trials = main.saturating_add(self.design.practice as usize);
        if trials > MAX_TRIALS {
            errors.add("factors", format!("the design has {trials} trials; expected at most {MAX_TRIALS}"));
            return;
        }
        // Each level is valid by itself. Now check the cells, where a level of one factor may contradict a level of
        // another.
        let Ok(cells) = self.conditions() else { return };
        if let Some(error) = cells.iter().find_map(|cell| cell.stimulus.validate().err()?.into_iter().next()) {
            let place =
                if self.factors.iter().any(|f| f.name == "low" || f.name == "high") { "factors" } else { "stimulus" };
            errors.add(place, error.to_string());
        }
    }

    fn design_errors(&self, errors: &mut DefinitionErrors) {
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

    fn response_errors(&self, errors: &mut DefinitionErrors) {
        let categories = &self.response.categories;
        let expected = usize::from(MAX_RATING) + 1;
        if categories.len() != expected {
            errors.add(
                "response.labels",
                format!(
                    "the number of categories is {}; expected {expected}, one for each rating 0…{MAX_RATING}",
                    categories.len()
                ),
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
