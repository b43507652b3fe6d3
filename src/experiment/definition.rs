//! What the definition of an experiment says, and the scripts in which the window can show its texts.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use unicode_script::{Script, UnicodeScript as _};

use super::{
    condition::{Factor, serialize_factors},
    faults::DefinitionError,
    participant::{ParticipantField, serialize_fields},
    scale::ResponseScale,
    task::{Adaptive, OptionValue, Task, options},
    texts::Texts,
};
use crate::{stimulus::Stimulus, text::names::serde_as_text};

/// The definition of an experiment: what is varied, in what order it is shown, and how it is shown and rated. A
/// [`Protocol`](super::Protocol) is a definition without errors. It is serialized in the form of its file, so that the
/// copy in a sidecar can be read back; texts that equal their defaults are left out. Its reader fills in the tables whose
/// content depends on a kind, or on each other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Definition {
    /// Version of the definition's format; 1.
    #[serde(skip_deserializing)]
    pub schema: u32,
    /// Name, `[a-z0-9-]+`. The results folder has the same name.
    pub name: String,
    /// Title for people, one line.
    pub title: String,
    /// The stimulus with the parameters that do not vary.
    #[serde(skip_deserializing)]
    pub stimulus: Stimulus,
    /// The factors to cross, in the order of the definition.
    #[serde(skip_deserializing, serialize_with = "serialize_factors")]
    pub factors: Vec<Factor>,
    /// Number and order of the trials.
    pub design: Design,
    /// What is shown between stimuli.
    pub recovery: Recovery,
    /// How long the stimulus is shown. If `None`, it stays until it is rated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub presentation: Option<Presentation>,
    /// What participants do in a trial.
    #[serde(skip_deserializing, skip_serializing_if = "Task::is_default")]
    pub task: Task,
    /// The method that chooses levels from the answers so far.
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<Adaptive>,
    /// The question and its possible answers.
    #[serde(skip_deserializing)]
    pub response: ResponseScale,
    /// The planned viewing geometry.
    pub viewing: ViewingPlan,
    /// What is asked about the participant before the first page.
    #[serde(skip_deserializing, serialize_with = "serialize_fields", skip_serializing_if = "Vec::is_empty")]
    pub participant: Vec<ParticipantField>,
    /// The participant's texts.
    pub instructions: Texts,
    /// What happens around a session's trials.
    #[serde(skip_serializing_if = "SessionRules::is_default")]
    pub session: SessionRules,
    /// How many people are planned. No session depends on it, so it may change at any time, and no copy is kept.
    #[serde(skip_serializing)]
    pub plan: Plan,
}

options! {
    /// Number and order of the trials.
    Design {
        repetitions: u32 = 1, "Repetitions", OptionValue::Number, "Main trials for each condition.";
        practice: u32 = 0, "Practice", OptionValue::Number, "Practice trials before the main part, from the same conditions; they are recorded, but not analyzed.";
        break_every: u32 = 0, "Break every", OptionValue::Number, "Main trials between two breaks; 0 for no breaks.";
        order: Order = Order::Random, "Order", OptionValue::Order, "Random: all trials shuffled together. Blocks: one for each level of a factor, in random order or, as in a Latin square, counterbalanced across participants.";
        #[serde(skip_serializing_if = "Option::is_none")]
        max_run: Option<u32> = None, "Longest run", OptionValue::Optional("any length"), "At most this many consecutive trials with the same level of a factor.";
    }
}

options! {
    /// What happens around a session's trials.
    SessionRules {
        own_means: bool = false, "Own means at the end", OptionValue::Flag, "The last page shows participants their own mean ratings. Someone who has seen them may rate differently in the next session.";
        #[serde(skip_serializing_if = "Option::is_none")]
        refresh_after_h: Option<f64> = None, "Practice again after, h", OptionValue::Optional("never"), "An interrupted session that is resumed later shows the instructions and the practice again.";
    }
}

impl SessionRules {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

options! {
    /// How many people are planned, and how often each of them comes.
    #[derive(Copy, Eq)]
    Plan {
        participants: Option<u32> = None, "Participants", OptionValue::Optional("not planned"), "How many people are to take part, 1…9999. The plan may change while a study runs.";
        sessions: u32 = 1, "Sessions each", OptionValue::Number, "How many sessions each participant attends, 1…99.";
    }
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

options! {
    /// The uniform field between stimuli (Bangay §3.1).
    Recovery {
        duration_s: f64 = 2.0, "Recovery, s", OptionValue::Number, "Duration of the uniform field between two stimuli.";
        level: f64 = 0.5, "Recovery level", OptionValue::Number, "Relative luminance of the uniform field, from 0 to 1, in linear light.";
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

options! {
    /// The planned viewing geometry; by default, about 10° at 50 cm (Bangay §3.1).
    ViewingPlan {
        distance_cm: f64 = 50.0, "Distance, cm", OptionValue::Number, "Planned distance from the eye to the screen.";
        window_deg: f64 = 10.0, "Stimulus size, °", OptionValue::Number, "Side of the square stimulus, in degrees of visual angle.";
    }
}

impl Definition {
    /// Creates a definition with a name and a stimulus. Everything else has its default: one trial without factors.
    pub fn new(name: String, stimulus: Stimulus) -> Self {
        Self { schema: 1, title: name.clone(), name, stimulus, ..Self::default() }
    }

    /// Returns the name without hyphens, for file names: a Psych-DS keyword value must be alphanumeric.
    pub fn file_task(&self) -> String {
        self.name.replace('-', "")
    }

    /// Returns every text that participants read, with its place in the definition, or that of its question.
    pub fn participant_texts(&self) -> impl Iterator<Item = (String, &str)> {
        let texts = self.instructions.entries().map(|(key, text)| (format!("instructions.{key}"), text));
        let question = ("response.question".to_owned(), self.response.question.as_str());
        let labels = self.response.categories.iter().enumerate();
        let labels = labels.map(|(i, category)| (format!("response.labels.{i}"), category.label.as_str()));
        let fields = self.participant.iter().flat_map(|field| {
            let texts = [&field.label, &field.text].into_iter().filter_map(|text| text.as_deref());
            let texts = texts.chain(field.options().into_iter().map(|(_, shown)| shown));
            texts.map(|text| (format!("participant.{}", field.name), text))
        });
        texts.chain([question]).chain(labels).chain(fields)
    }

    /// Returns the letters in the participants' texts for which the window's own font is not made: those of scripts
    /// other than Latin, Greek and Cyrillic.
    pub fn foreign_letters(&self) -> BTreeSet<char> {
        let own = [Script::Latin, Script::Greek, Script::Cyrillic, Script::Common, Script::Inherited];
        let letters = self.participant_texts().flat_map(|(_, text)| text.chars());
        letters.filter(|c| !own.contains(&c.script())).collect()
    }

    /// Returns an error for the title and for each of the participants' texts that the window cannot show.
    pub(super) fn script_errors(&self) -> Vec<DefinitionError> {
        let error = |(path, text): (String, &str)| {
            let (letter, why) = text.chars().find_map(|c| Some((c, refusal(c.script())?)))?;
            let name = letter.script().full_name().replace('_', " ");
            let message = format!(
                "the text contains {letter:?} of the script {name}, which {why}; expected a script that is written from left to right"
            );
            Some(DefinitionError { path, message })
        };
        let title = ("title".to_owned(), self.title.as_str());
        std::iter::once(title).chain(self.participant_texts()).filter_map(error).collect()
    }
}

/// Returns why the window cannot show a script, if it cannot. Its layout shapes letters, so that the scripts of India and
/// of Southeast Asia are shown correctly, but it writes only from left to right.
fn refusal(script: Script) -> Option<&'static str> {
    match script {
        Script::Adlam
        | Script::Arabic
        | Script::Hanifi_Rohingya
        | Script::Hebrew
        | Script::Mandaic
        | Script::Mende_Kikakui
        | Script::Nko
        | Script::Samaritan
        | Script::Syriac
        | Script::Thaana => Some("is written from right to left"),
        Script::Mongolian => Some("is written from top to bottom"),
        _ => None,
    }
}
