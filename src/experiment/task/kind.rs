//! What every task states: its question, how a trial's stimuli are arranged, how an answer is judged, and how an
//! observer answers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    experiment::{
        condition::{Condition, Factor},
        faults::DefinitionErrors,
        scale::ResponseScale,
    },
    stimulus::{ParameterError, ParameterValue, Stimulus},
    text::names::expected_one_of,
};

/// Parameters of a stimulus and their values, as in `reference = { depth = "inf" }`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Settings(pub BTreeMap<String, ParameterValue>);

impl Settings {
    /// Returns a stimulus with these parameters.
    ///
    /// # Errors
    /// Returns an error for the first parameter that does not exist or cannot have its value.
    pub fn apply(&self, stimulus: &Stimulus) -> Result<Stimulus, ParameterError> {
        let mut stimulus = stimulus.clone();
        self.0.iter().try_for_each(|(name, value)| stimulus.set(name, value))?;
        Ok(stimulus)
    }
}

/// How the stimuli of a trial are arranged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layout {
    /// One stimulus at the center.
    Single,
    /// Several stimuli in a row, or four in a square.
    Places(usize),
    /// Several stimuli at the center, one after the other.
    Intervals {
        /// Their number.
        count: usize,
        /// How long each is shown, seconds.
        duration_s: f64,
        /// The uniform field between two of them, seconds.
        gap_s: f64,
    },
}

impl Layout {
    /// Returns the number of intervals.
    pub fn intervals(self) -> usize {
        if let Self::Intervals { count, .. } = self { count } else { 1 }
    }

    /// Returns the time from the onset of the first interval to that of the last, seconds.
    pub fn lead_s(self) -> f64 {
        let Self::Intervals { count, duration_s, gap_s } = self else { return 0.0 };
        (count as f64 - 1.0) * (duration_s + gap_s)
    }

    /// Returns the gap between two stimuli that are shown at the same time, in pixels: a tenth of their side.
    pub fn gap_px(side: u32) -> u32 {
        side.div_ceil(10)
    }

    /// Returns the width and the height of all stimuli that are shown at the same time, in pixels.
    pub fn size_px(self, side: u32) -> [u32; 2] {
        self.grid().map(|count| count as u32 * (side + Self::gap_px(side)) - Self::gap_px(side))
    }

    /// Returns the number of columns and rows in which stimuli are on the screen at the same time.
    pub fn grid(self) -> [usize; 2] {
        match self {
            Self::Places(4) => [2, 2],
            Self::Places(count) => [count, 1],
            Self::Single | Self::Intervals { .. } => [1, 1],
        }
    }
}

/// A value that participants set instead of pressing the key of an answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Dial {
    /// The parameter of the stimulus that it changes; `None` if the stimulus does not change.
    pub parameter: Option<String>,
    /// Lowest and highest value.
    pub range: [f64; 2],
    /// How far one key press goes: added, or on a logarithmic scale, multiplied by 10 to this power.
    pub step: f64,
    /// Whether steps are equal ratios.
    pub log: bool,
}

impl Dial {
    /// How many times finer a step with Shift is.
    pub const FINE: f64 = 10.0;

    /// Returns the value after `steps` steps.
    pub fn turned(&self, value: f64, steps: f64) -> f64 {
        let by = self.step * steps;
        let turned = if self.log { value * f64::powf(10.0, by) } else { value + by };
        significant(turned.clamp(self.range[0], self.range[1]))
    }

    /// Returns the share of the range, 0…1, at a value; the inverse of [`Dial::at`].
    pub fn share(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        if self.log { (value / low).ln() / (high / low).ln() } else { (value - low) / (high - low) }
    }

    /// Returns the value at a share of the range, 0…1.
    pub fn at(&self, share: f64) -> f64 {
        let [low, high] = self.range;
        significant(if self.log { low * (high / low).powf(share) } else { low + share * (high - low) })
    }
}

/// Rounds to six significant digits, so that a level is the same on every machine, whatever its logarithms.
pub fn significant(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// What the schedule or a method chose for a trial.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pick {
    /// What the schedule plans.
    #[default]
    Planned,
    /// A level of the adapted parameter, and one of the second.
    Level(f64, Option<f64>),
    /// A pair of conditions.
    Pair([usize; 2]),
}

/// What a trial shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Presentation {
    /// The stimuli in the order of their places or intervals.
    pub stimuli: Vec<Stimulus>,
    /// Place or interval of the target, from 1; 0 if the trial shows none, and `None` if the task has none.
    pub target: Option<u32>,
    /// The level that an adaptive method chose.
    pub level: Option<f64>,
    /// The value at which an adjustment begins.
    pub start: Option<f64>,
    /// The choice that led to this.
    pub pick: Pick,
}

impl Presentation {
    /// Shows one stimulus.
    pub fn of(stimulus: Stimulus) -> Self {
        Self { stimuli: vec![stimulus], ..Self::default() }
    }

    /// Returns the stimulus that a row describes: the target if it is shown, and otherwise the first.
    pub fn described(&self) -> &Stimulus {
        let place = self.target.map_or(0, |target| target.saturating_sub(1) as usize);
        &self.stimuli[place.min(self.stimuli.len() - 1)]
    }
}

/// What is known about a trial before it is shown.
#[derive(Clone, Debug)]
pub struct Turn<'a> {
    /// The condition of the trial; for a pair without a reference, the stimulus on the left.
    pub condition: &'a Condition,
    /// For a pair without a reference, the stimulus on the right.
    pub other: Option<&'a Condition>,
    /// Drawn in advance for each trial, and balanced over the trials of a condition: below [`Kind::places`].
    pub place: u32,
    /// Drawn in advance for each trial, uniform in 0…1.
    pub draw: f64,
    /// The parameter and the value that the adaptive method chose, and those of its second parameter.
    pub levels: Vec<(&'a str, f64)>,
}

impl Turn<'_> {
    /// Returns the stimulus of the condition at the chosen level.
    pub fn target(&self) -> Stimulus {
        let stimulus = self.condition.stimulus.clone();
        self.levels.iter().fold(stimulus, |stimulus, (name, level)| at_level(stimulus, name, *level))
    }

    /// Returns that stimulus, and the same one with the parameters of a reference.
    pub fn compared(&self, reference: &Settings) -> [Stimulus; 2] {
        let target = self.target();
        let reference = reference.apply(&target).unwrap_or_else(|_| target.clone());
        [target, reference]
    }

    /// Shows these stimuli, with the target at a place or interval counted from 1, or nowhere.
    pub fn shows(&self, stimuli: Vec<Stimulus>, target: u32) -> Presentation {
        let level = self.levels.first().map(|(_, level)| *level);
        Presentation { stimuli, target: Some(target), level, ..Presentation::default() }
    }
}

/// Returns a stimulus with a level that the check of the definition allowed.
pub(in crate::experiment) fn at_level(mut stimulus: Stimulus, name: &str, level: f64) -> Stimulus {
    let set = stimulus.set(name, &level.into());
    debug_assert!(set.is_ok(), "{set:?}");
    stimulus
}

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// The answer of a key, from 0.
    Key(u8),
    /// A value that was set.
    Value(f64),
}

/// The part of a definition that a task is checked against.
pub struct Given<'a> {
    /// The stimulus before any factor is set.
    pub stimulus: &'a Stimulus,
    /// The factors.
    pub factors: &'a [Factor],
    /// The number of conditions.
    pub conditions: usize,
    /// The parameters that an adaptive method varies.
    pub adapted: Vec<&'a str>,
}

impl Given<'_> {
    /// Adds an error for each parameter of a reference that the stimulus lacks or that cannot have its value. A factor
    /// can be one of them: then the reference has the same level of it in all conditions.
    pub fn check_reference(&self, reference: &Settings, errors: &mut DefinitionErrors) {
        if reference.0.is_empty() {
            errors.add(
                "task.reference",
                "task.reference is missing; expected parameters that differ from the target, such as { depth = \"inf\" }",
            );
        }
        for (name, value) in &reference.0 {
            if let Err(error) = self.stimulus.clone().set(name, value) {
                errors.add(format!("task.reference.{name}"), error.to_string());
            }
        }
    }

    /// Adds an error if a parameter is missing, not known, or varied by a factor, and returns whether it is none of these.
    pub fn check_parameter(&self, path: &str, name: &str, errors: &mut DefinitionErrors) -> bool {
        let message = if self.stimulus.get(name).is_none() {
            let names: Vec<&str> = self.stimulus.parameters().iter().map(|parameter| parameter.name).collect();
            let is = if name.is_empty() { "parameter is missing".to_owned() } else { format!("{name} is not known") };
            format!("{is}; {}", expected_one_of(name, &names))
        } else if self.factors.iter().any(|factor| factor.name == name) {
            format!("{name} is a factor; expected a parameter that no factor varies")
        } else {
            return true;
        };
        errors.add(path, message);
        false
    }

    /// Adds every error of the range of a parameter and of the steps through it, each with its path.
    pub fn check_span(
        &self,
        table: &str,
        (name, log): (&str, bool),
        [low, high]: [f64; 2],
        steps: impl IntoIterator<Item = (String, f64)>,
        errors: &mut DefinitionErrors,
    ) {
        let before = errors.0.len();
        for (key, end) in [("low", low), ("high", high)].into_iter().filter(|(_, end)| !end.is_nan()) {
            let message = match self.stimulus.clone().set(name, &end.into()) {
                Err(error) => error.to_string(),
                Ok(()) if log && end <= 0.0 => {
                    format!("{key} {end} is not above 0; expected a positive number, or log = false")
                }
                Ok(()) => continue,
            };
            errors.add(format!("{table}.{key}"), message);
        }
        if low >= high {
            errors
                .add(format!("{table}.high"), format!("high {high} is not above low {low}; expected a higher number"));
        }
        // No whole number lies at an irrational share of the way from one to another.
        let between = low + (high - low) / 7.0_f64.sqrt();
        if errors.0.len() == before && between.is_finite() && self.stimulus.clone().set(name, &between.into()).is_err()
        {
            let expected = format!("expected a parameter that can have every number from {low} to {high}");
            errors.add(format!("{table}.parameter"), format!("{name} has whole numbers only; {expected}"));
        }
        let (span, unit) =
            if log { ((high / low).log10(), "base-10 logarithms") } else { (high - low, "units of the parameter") };
        let most = if span > 0.0 { significant(span) } else { f64::INFINITY };
        for (path, step) in steps {
            let meaning = format!("a size in {unit}, at most the distance from low to high");
            errors.check_range(&path, step, 1e-6, most, &meaning);
        }
    }
}

/// A simulated observer's view of a trial.
pub struct Senses<'a> {
    /// Returns how strongly the observer sees a stimulus this time, with noise of standard deviation 1.
    pub noisy: &'a mut dyn FnMut(&Stimulus) -> f64,
    /// Returns how strongly the observer sees a stimulus on average.
    pub mean: &'a dyn Fn(&Stimulus) -> f64,
    /// How strongly a stimulus must be seen to count as seen.
    pub criterion: f64,
}

/// A task. Everything that is particular to it stands in its implementation.
pub trait Kind {
    /// Returns the question and the answers, unless the definition has its own.
    fn scale(&self) -> ResponseScale;
    /// Adds every error.
    fn check(&self, given: &Given<'_>, errors: &mut DefinitionErrors);
    /// Returns how the stimuli of a trial are arranged.
    fn layout(&self) -> Layout {
        Layout::Single
    }
    /// Returns the value that participants set; `None` if they press the key of an answer.
    fn dial(&self) -> Option<Dial> {
        None
    }
    /// Returns the number of places to draw from.
    fn places(&self) -> u32 {
        1
    }
    /// Returns the places of the next trials of a condition, which are shuffled, after `done` of `all` its trials: by
    /// default, each place once.
    fn round(&self, _done: usize, _all: usize) -> Vec<u32> {
        (0..self.places()).collect()
    }
    /// Returns the pairs of conditions to compare; `None` if the trials show one condition each.
    fn pairs(&self, _conditions: &[Condition], _factors: &[Factor]) -> Option<Vec<[usize; 2]>> {
        None
    }
    /// Returns the parameters in which other stimuli differ from the target; `None` if there are no others.
    fn reference(&self) -> Option<&Settings> {
        None
    }
    /// Returns the number of trials in which the answers so far decide which pair is compared.
    fn ranking(&self) -> Option<u32> {
        None
    }
    /// Returns what a trial shows.
    fn present(&self, turn: &Turn<'_>) -> Presentation;
    /// Returns whether an answer is right; `None` if there is no right or wrong, because nothing is to be guessed.
    fn judge(&self, shown: &Presentation, answer: &Answer) -> Option<bool> {
        let is_judged = self.catches().is_some() || self.guess().is_some_and(|guess| guess > 0.0);
        is_judged.then(|| self.outcome(shown, answer) == (shown.target != Some(0)))
    }
    /// Returns what an adaptive method learns from an answer: whether the target was seen or chosen, or the first stimulus if
    /// there is no target.
    fn outcome(&self, shown: &Presentation, answer: &Answer) -> bool {
        matches!(answer, Answer::Key(key) if u32::from(*key) + 1 == shown.target.unwrap_or(1))
    }
    /// Returns the probability of the outcome without seeing anything; `None` if it depends on the participant.
    fn guess(&self) -> Option<f64> {
        None
    }
    /// Returns whether an adaptive method can choose levels.
    fn adapts(&self) -> bool {
        self.guess().is_some() || self.catches().is_some()
    }
    /// Returns the number of labels of the answers; `None` if the definition decides.
    fn answers(&self) -> Option<usize> {
        Some(self.scale().categories.len())
    }
    /// Returns the share of trials without a target; `None` if all show one.
    fn catches(&self) -> Option<f64> {
        None
    }
    /// Returns whether participants are told if they were right.
    fn feedback(&self) -> bool {
        false
    }
    /// Returns an answer as it is written in a row.
    fn response(&self, answer: &Answer) -> String {
        match answer {
            Answer::Key(key) => (u32::from(*key) + 1).to_string(),
            Answer::Value(value) => value.to_string(),
        }
    }
    /// Returns the answer of a simulated observer: by default, the stimulus that it sees most strongly.
    fn answer(&self, shown: &Presentation, senses: Senses<'_>) -> Answer {
        let seen: Vec<f64> = shown.stimuli.iter().map(senses.noisy).collect();
        let best = (0..seen.len()).fold(0, |best, place| if seen[place] > seen[best] { place } else { best });
        Answer::Key(best as u8)
    }
}
