//! The identifiers of a participant and a session, and what a session asks about the participant before its first page.

use serde::{Deserialize, Serialize, Serializer};

use super::{faults::DefinitionErrors, texts::Texts};
use crate::text::names::expected_one_of;

/// A field of a definition's `[participant]` table, in the form of the file: a number, a text, a choice, or a text to agree
/// to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ParticipantField {
    /// Its key, which is its column in `participants.tsv`.
    #[serde(skip)]
    pub name: String,
    /// Whether the session begins only with an answer.
    #[serde(skip_serializing_if = "Clone::clone")]
    pub required: bool,
    /// What the participant reads next to the field.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// A text to agree to. The answer is the day on which the participant agreed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// The possible answers, as they are recorded; if empty, those that its name has.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<String>,
    /// The possible answers as the participant reads them; empty if they read the recorded ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub choice_labels: Vec<String>,
    /// Whether the answer is a number.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub number: bool,
}

impl Default for ParticipantField {
    fn default() -> Self {
        let (name, label, text, choices, choice_labels) = Default::default();
        Self { name, required: true, label, text, choices, choice_labels, number: false }
    }
}

/// How a field is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// A number.
    Number,
    /// Any text of one line.
    Text,
    /// One of several answers.
    Choice,
    /// Agreement to a text, which is recorded as a day.
    Agreement,
}

/// The answers of one participant, by the names of the fields. A question without an answer is not among them.
pub type Answers = serde_json::Map<String, serde_json::Value>;

/// A field that people know by its name, with the answers that BIDS allows.
struct Known {
    name: &'static str,
    label: &'static str,
    description: &'static str,
    choices: &'static [&'static str],
    /// Whether the definition may have other answers.
    open: bool,
}

const fn known([name, label, description]: [&'static str; 3], choices: &'static [&'static str], open: bool) -> Known {
    Known { name, label, description, choices, open }
}

/// The names with a meaning of their own.
const KNOWN: [Known; 5] = [
    known(["age", "Age in years", "Age of the participant."], &[], true),
    known(["sex", "Sex", "Sex, as reported by the participant."], &["female", "male", "other"], false),
    known(
        ["handedness", "Handedness", "Handedness, as reported by the participant."],
        &["right", "left", "ambidextrous"],
        false,
    ),
    known(
        ["vision", "How do you see the screen?", "Vision during the session, as reported by the participant."],
        &["without glasses", "with glasses", "with contact lenses"],
        true,
    ),
    known(["consent", "Consent", "Day on which the participant agreed to the text of the definition."], &[], true),
];

/// The columns that have another meaning in BIDS.
const TAKEN: [&str; 3] = ["participant_id", "session_id", "species"];
/// The largest age that a person can have, years.
const MAX_AGE: f64 = 130.0;
/// Longest answer, characters.
pub const MAX_ANSWER: usize = 200;

impl ParticipantField {
    /// Returns the names with a meaning of their own.
    pub fn known_names() -> impl Iterator<Item = &'static str> {
        KNOWN.iter().map(|known| known.name)
    }

    fn known(&self) -> Option<&'static Known> {
        KNOWN.iter().find(|known| known.name == self.name)
    }

    /// Returns how the field is answered.
    pub fn kind(&self) -> FieldKind {
        if self.text.is_some() {
            FieldKind::Agreement
        } else if self.number || self.name == "age" {
            FieldKind::Number
        } else if self.choices().is_empty() {
            FieldKind::Text
        } else {
            FieldKind::Choice
        }
    }

    /// Returns what the participant reads next to the field.
    pub fn label(&self) -> String {
        let known = || self.known().map(|known| known.label.to_owned());
        let from_name = || {
            let mut letters = self.name.replace('_', " ").chars().collect::<Vec<_>>();
            letters[..1].iter_mut().for_each(|first| first.make_ascii_uppercase());
            letters.into_iter().collect()
        };
        self.label.clone().or_else(known).unwrap_or_else(from_name)
    }

    /// Returns the possible answers, as they are recorded.
    pub fn choices(&self) -> Vec<&str> {
        match self.known() {
            Some(known) if self.choices.is_empty() => known.choices.to_vec(),
            _ => self.choices.iter().map(String::as_str).collect(),
        }
    }

    /// Returns each possible answer with what the participant reads.
    pub fn options(&self) -> Vec<(&str, &str)> {
        let choices = self.choices();
        let labels = self.choice_labels.iter().map(String::as_str);
        let labels: Vec<_> = if self.choice_labels.is_empty() { choices.clone() } else { labels.collect() };
        choices.into_iter().zip(labels).collect()
    }

    /// Returns the meaning of the column and its unit, for people who read the data.
    pub fn description(&self) -> (String, Option<&'static str>) {
        let known = self.known().map(|known| known.description.to_owned());
        (known.unwrap_or_else(|| self.label()), (self.name == "age").then_some("years"))
    }

    /// Returns what is recorded for an answer as it was typed or chosen; `None` if it is empty. For an agreement, the
    /// answer is the day, or empty.
    ///
    /// # Errors
    /// The one of `texts` that says why the answer is not accepted: it is missing, not a number, no person's age, or a
    /// spreadsheet would take it for a formula.
    pub fn answer<'t>(&self, typed: &str, texts: &'t Texts) -> Result<Option<serde_json::Value>, &'t str> {
        let text = typed.split_whitespace().collect::<Vec<_>>().join(" ");
        if text.is_empty() {
            let is_agreement = self.kind() == FieldKind::Agreement;
            let missing = if is_agreement { &texts.agreement_missing } else { &texts.answer_missing };
            return if self.required { Err(missing) } else { Ok(None) };
        }
        if self.kind() != FieldKind::Number {
            let is_formula = text.starts_with(['=', '+', '-', '@']);
            return if is_formula { Err(&texts.letter_expected) } else { Ok(Some(text.into())) };
        }
        // Many countries use a decimal comma.
        let number: Option<f64> = text.replace(',', ".").parse().ok().filter(|number: &f64| number.is_finite());
        let number = number.ok_or(texts.number_expected.as_str())?;
        if self.name == "age" && !(0.0..=MAX_AGE).contains(&number) {
            return Err(&texts.age_expected);
        }
        let is_whole = number.fract() == 0.0 && number.abs() < 1e15;
        Ok(Some(if is_whole { (number as i64).into() } else { number.into() }))
    }

    /// Adds the errors of the field.
    pub(super) fn check(&self, errors: &mut DefinitionErrors) {
        let Self { name, text, choices, number, .. } = self;
        let path = format!("participant.{name}");
        let first = |c: char| c.is_ascii_lowercase();
        let rest = |c: char| first(c) || c.is_ascii_digit() || c == '_';
        if !(name.len() <= 64 && name.starts_with(first) && name.chars().all(rest)) {
            let expected = "expected at most 64 lowercase letters, digits and underscores, with a letter first";
            return errors.add(path, format!("the name {name:?} is not allowed; {expected}"));
        }
        if TAKEN.contains(&name.as_str()) {
            return errors.add(path, format!("{name} already has another meaning; expected another name"));
        }
        if name == "consent" && text.is_none() {
            errors.add(&path, "consent has no text; expected text = …, the text to agree to");
        }
        if name == "age" && text.is_none() && !choices.is_empty() {
            errors.add(format!("{path}.choices"), "age has choices; expected none, because age is a number");
        }
        let kinds = [text.is_some(), !choices.is_empty(), *number];
        if kinds.into_iter().filter(|is| *is).count() > 1 {
            errors.add(&path, format!("{name} has more than one of text, choices and number; expected one of them"));
        }
        self.check_choices(&path, errors);
    }

    fn check_choices(&self, path: &str, errors: &mut DefinitionErrors) {
        let Self { name, choices, .. } = self;
        for (i, choice) in choices.iter().enumerate() {
            let path = format!("{path}.choices.{i}");
            let closed = self.known().filter(|known| !known.open);
            if choice.trim() != choice || choice.is_empty() || choice.contains(['\t', '\n', '\r']) || choice == "n/a" {
                errors.add(path, format!("choice {choice:?} cannot be recorded; expected text on one line"));
            } else if choice.starts_with(['=', '+', '-', '@']) {
                let expected = "expected text that begins with another character";
                errors.add(path, format!("spreadsheets would treat choice {choice:?} as a formula; {expected}"));
            } else if choices[..i].contains(choice) {
                errors.add(path, format!("choice {choice:?} appears twice; expected each choice once"));
            } else if let Some(known) = closed.filter(|known| !known.choices.contains(&choice.as_str())) {
                let expected = expected_one_of(choice, known.choices);
                let hint = "choice_labels can have any words";
                errors.add(path, format!("choice {choice:?} is not a value of {name} in BIDS; {expected}; {hint}"));
            }
        }
        let (labels, choices) = (self.choice_labels.len(), self.choices().len());
        if labels != 0 && labels != choices {
            let expected = format!("expected {choices}, one for each choice");
            errors.add(format!("{path}.choice_labels"), format!("choice_labels has length {labels}; {expected}"));
        }
    }
}

/// Serializes fields as they appear in a definition, by their names.
pub(super) fn serialize_fields<S: Serializer>(fields: &[ParticipantField], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(fields.iter().map(|field| (&field.name, field)))
}

/// Maximum length of an identifier: a file name with two of them must fit every file system.
const MAX_LENGTH: usize = 40;

/// The participant and the session of a data file. Both identifiers match `[A-Za-z0-9]+` and have at most 40
/// characters, so they can be part of a file name on any system and of a Psych-DS or BIDS keyword.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Identity {
    subject: String,
    session: String,
}

impl Identity {
    /// Checks both identifiers. The error names the first one that is not valid.
    pub fn new(subject: &str, session: &str) -> Result<Self, String> {
        Ok(Self { subject: Self::check_subject(subject)?, session: Self::check_session(session)? })
    }

    /// Checks a participant identifier alone.
    pub fn check_subject(id: &str) -> Result<String, String> {
        check_id("participant", id, "S001")
    }

    /// Checks a session identifier alone.
    pub fn check_session(id: &str) -> Result<String, String> {
        check_id("session", id, "1")
    }

    /// Returns the participant's identifier.
    pub fn subject(&self) -> &str {
        &self.subject
    }

    /// Returns the session's identifier.
    pub fn session(&self) -> &str {
        &self.session
    }

    /// Returns the participant's row in a counterbalancing square: the number at the end of the identifier, counted
    /// from 0 (`S001` → 0, `P12` → 11). If there is no such number, it is a hash that is the same on every machine.
    pub fn counterbalance_row(&self) -> u64 {
        let digits = self.subject.len() - self.subject.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        match self.subject[self.subject.len() - digits..].parse::<u64>() {
            Ok(number) => number.saturating_sub(1),
            Err(_) => fnv1a(self.subject.as_bytes()),
        }
    }
}

/// Returns the 64-bit FNV-1a hash. It is public and fixed, whereas the standard library's hash may change between
/// versions.
pub(super) fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

fn check_id(what: &str, id: &str, example: &str) -> Result<String, String> {
    if (1..=MAX_LENGTH).contains(&id.len()) && id.chars().all(|c| c.is_ascii_alphanumeric()) {
        return Ok(id.to_owned());
    }
    let shown: String = id.chars().take(MAX_LENGTH + 8).collect();
    Err(format!(
        "{what} {shown:?} is not allowed; expected letters A–Z, a–z and digits only, at most 40, such as {example}"
    ))
}
