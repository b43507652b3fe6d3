//! A definition without errors.

use std::{collections::HashSet, ops::Deref, sync::Arc, time::Duration};

use serde::Serialize;

use super::{
    condition::{Condition, cross},
    definition::{Definition, Design, Order},
    faults::{DefinitionError, DefinitionErrors},
    scale::CATEGORIES,
    task::{Adaptive, Given, Layout, Turn, at_level},
};
use crate::{stimulus::Stimulus, text::names::expected_one_of};

/// Maximum number of trials per session.
const MAX_TRIALS: usize = 100_000;
/// Typical time to look at a stimulus and rate it, seconds.
const RATING_S: f64 = 3.5;
/// Typical time to set a value, seconds.
const SETTING_S: f64 = 12.0;
/// A [`Definition`] without errors, and its conditions: what a session runs. The definition can be read but not changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Protocol {
    definition: Definition,
    #[serde(skip)]
    conditions: Arc<[Condition]>,
    /// See [`Protocol::pairs`].
    #[serde(skip)]
    pairs: Option<Arc<[[usize; 2]]>>,
}

impl Deref for Protocol {
    type Target = Definition;

    fn deref(&self) -> &Definition {
        &self.definition
    }
}

impl Protocol {
    /// Checks a definition.
    ///
    /// # Errors
    /// Returns every error in the definition.
    pub fn new(definition: Definition) -> Result<Self, Vec<DefinitionError>> {
        let mut errors = DefinitionErrors::default();
        let conditions: Arc<[Condition]> = definition.check(&mut errors).into();
        // Pairs are many: they are listed only if the task allows this number of conditions.
        let pairs = if errors.0.is_empty() { definition.pairs(&conditions, &mut errors) } else { None };
        if errors.0.is_empty() {
            definition.check_shown(&conditions, &mut errors);
        }
        if errors.0.is_empty() { Ok(Self { definition, conditions, pairs }) } else { Err(errors.0) }
    }

    /// Checks that the parameters that the task adjusts or adapts, and those of a reference, change what it shows. This draws
    /// stimuli, so it is for definitions that are written; those of recorded sessions were checked.
    ///
    /// # Errors
    /// Returns an error for each parameter that changes nothing.
    pub fn with_effect(self) -> Result<Self, Vec<DefinitionError>> {
        // A direction can come back to where it began.
        let between = |[low, high]: [f64; 2]| vec![low, f64::midpoint(low, high), high];
        let adjusted = self.task.dial().and_then(|dial| Some(("task.parameter", dial.parameter?, between(dial.range))));
        let adapted = |it: &Adaptive| ("adaptive.parameter", it.common.parameter.clone(), between(it.range()));
        let second = self.adaptive.as_ref().and_then(Adaptive::second);
        let second = second.map(|it| ("adaptive.second.parameter", it.parameter.clone(), it.levels.clone()));
        let reference = self.task.reference().cloned().unwrap_or_default();
        let (picks, mut errors) = (self.picks(), DefinitionErrors::default());
        // Most differences are seen in few pixels; only more pixels tell that there is none.
        let differ =
            |one: &Stimulus, other: &Stimulus| [32, 512].into_iter().any(|px| one.linear(px) != other.linear(px));
        for (path, name, levels) in adjusted.into_iter().chain(self.adaptive.as_ref().map(adapted)).chain(second) {
            let at = |shown: &Stimulus, level: f64| {
                let mut changed = shown.clone();
                changed.set(&name, &level.into()).ok().map(|()| changed)
            };
            let is_changed = |shown: &Stimulus| {
                let mut shown = levels.iter().filter_map(|level| at(shown, *level));
                shown.next().is_some_and(|first| shown.any(|other| differ(&first, &other)))
            };
            let targets = self.conditions.iter().flat_map(|condition| targets(condition, &picks));
            let mut shown = targets.flat_map(|target| [reference.apply(&target).ok(), Some(target)]).flatten();
            if !shown.any(|shown| is_changed(&shown)) {
                let message = "changes nothing that is shown; expected a parameter that has an effect here";
                errors.add(path, format!("{name} {message}"));
            }
        }
        let is_seen = |target: Stimulus| reference.apply(&target).is_ok_and(|other| differ(&target, &other));
        let is_told = |condition: &Condition| targets(condition, &picks).any(is_seen);
        // Pictures of a study's own are other files.
        let is_drawn = self.task.reference().is_some() && !matches!(self.stimulus, Stimulus::Image(_));
        if is_drawn && errors.0.is_empty() && !self.conditions.iter().all(is_told) {
            let message = "the reference looks like the target; expected parameters that change what is shown";
            errors.add("task.reference", message);
        }
        if errors.0.is_empty() { Ok(self) } else { Err(errors.0) }
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

    /// Returns why the conditions are not what the trials show: an adaptive method chooses a parameter. `None` if they
    /// are.
    pub fn chosen_later(&self) -> Option<String> {
        let names: Vec<&str> = self.adaptive.as_ref()?.parameters().collect();
        let names = names.join(" and ");
        Some(format!("{}: the answers decide {names}; expected a definition without [adaptive]", self.name))
    }

    /// Returns the pairs of conditions that the schedule plans to compare, if the task compares conditions. The answers
    /// so far may decide which of them a trial shows.
    pub fn pairs(&self) -> Option<&[[usize; 2]]> {
        self.pairs.as_deref()
    }

    /// Returns the number of different things that the schedule repeats: conditions or pairs, or one if the answers
    /// decide.
    pub(super) fn slots(&self) -> usize {
        if self.task.ranking().is_some() { 1 } else { self.pairs().map_or(self.conditions.len(), <[_]>::len) }
    }

    /// Returns the number of main trials of each of them.
    pub fn repetitions(&self) -> u32 {
        let adaptive = self.adaptive.as_ref().map(|adaptive| adaptive.common.trials);
        self.task.ranking().or(adaptive).unwrap_or(self.design.repetitions)
    }

    /// Returns the number of main trials, or the most if an adaptive method can stop earlier.
    pub fn main_trials(&self) -> usize {
        self.slots() * self.repetitions() as usize
    }

    /// Returns the estimated duration of a session in whole minutes, including one minute for the instructions.
    pub fn minutes(&self) -> u64 {
        let trials = self.main_trials() as f64 + f64::from(self.design.practice);
        (trials * self.trial_s() / 60.0).ceil() as u64 + 1
    }

    /// Returns the estimated duration of a trial, seconds.
    pub(super) fn trial_s(&self) -> f64 {
        let answer = if self.task.dial().is_some() { SETTING_S } else { RATING_S };
        self.recovery.duration_s + self.task.layout().lead_s() + answer
    }

    /// Returns the duration of the uniform field between stimuli to the nanosecond, as the session measures it.
    pub fn recovery_duration(&self) -> Duration {
        Duration::from_secs_f64(self.recovery.duration_s)
    }

    /// Returns the duration of the stimulus, or of each interval, to the nanosecond; `None` if it stays until it is
    /// answered.
    pub fn presentation_duration(&self) -> Option<Duration> {
        if let Layout::Intervals { duration_s, .. } = self.task.layout() {
            return Some(Duration::from_secs_f64(duration_s));
        }
        self.presentation.map(|presentation| Duration::from_secs_f64(presentation.duration_s))
    }

    /// Returns the duration of the uniform field between two intervals.
    pub fn gap_duration(&self) -> Duration {
        let Layout::Intervals { gap_s, .. } = self.task.layout() else { return Duration::ZERO };
        Duration::from_secs_f64(gap_s)
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
        let presentation = self.presentation.map(|presentation| presentation.duration_s);
        let until_rated = "seconds; without [presentation] the stimulus stays until it is rated";
        for (path, value, [low, high], meaning) in [
            ("recovery.duration_s", Some(self.recovery.duration_s), [0.0, 600.0], "seconds"),
            ("recovery.level", Some(self.recovery.level), [0.0, 1.0], "the relative luminance of the field"),
            ("presentation.duration_s", presentation, [0.001, 600.0], until_rated),
            ("viewing.distance_cm", Some(self.viewing.distance_cm), [1.0, 10_000.0], "cm from eye to screen"),
            ("viewing.window_deg", Some(self.viewing.window_deg), [0.01, 170.0], "degrees of visual angle"),
            ("session.refresh_after_h", self.session.refresh_after_h, [0.0, 8760.0], "hours"),
            ("plan.participants", self.plan.participants.map(f64::from), [1.0, 9999.0], "the number of participants"),
            ("plan.sessions", Some(self.plan.sessions.into()), [1.0, 99.0], "the sessions of each participant"),
        ] {
            value.into_iter().for_each(|value| errors.check_range(path, value, low, high, meaning));
        }
        self.check_response(errors);
        self.check_task(errors);
        self.participant.iter().for_each(|field| field.check(errors));
        errors.0.extend(self.script_errors());
        conditions
    }

    /// Returns the number of conditions.
    fn cells(&self) -> usize {
        match &self.stimulus {
            Stimulus::Image(pictures) => pictures.each().count(),
            _ => self.factors.iter().fold(1, |cells: usize, factor| cells.saturating_mul(factor.levels.len())),
        }
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
                    let expected = "expected each level once (repetitions repeat it)";
                    errors.add(path, format!("level {level} of {} appears twice; {expected}", factor.name));
                }
            }
        }
        if errors.0.len() > before {
            return Vec::new();
        }
        // With repetitions = 0, which is reported as its own error, there are no trials, but there are still cells.
        let adaptive = self.adaptive.as_ref().map(|adaptive| adaptive.common.trials);
        let repetitions = adaptive.unwrap_or(self.design.repetitions).max(1) as usize;
        let main = self.cells().saturating_mul(repetitions);
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
        let adaptive = self.adaptive.as_ref().map(|adaptive| adaptive.common.trials);
        let Design { repetitions, .. } = design;
        if let Some(trials) = self.task.ranking().or(adaptive).filter(|_| *repetitions > 1) {
            let what = format!("repetitions is {repetitions}, but trials says that there are {trials}");
            errors.add("design.repetitions", format!("{what}; expected no repetitions"));
        }
        if design.max_run == Some(0) {
            errors.add("design.max_run", "max_run is 0; expected at least 1");
        }
        if let Some(name) = design.order.factor()
            && !self.factors.iter().any(|factor| factor.name == name)
        {
            let known: Vec<_> = self.factors.iter().map(|f| f.name.as_str()).collect();
            let expected = match known[..] {
                [] => "expected random, because there are none".to_owned(),
                _ => expected_one_of(name, &known),
            };
            errors.add("design.order", format!("order {} does not name a factor; {expected}", design.order));
        }
    }

    fn check_task(&self, errors: &mut DefinitionErrors) {
        let adapted = self.adaptive.iter().flat_map(|adaptive| adaptive.parameters()).collect();
        let given = Given { stimulus: &self.stimulus, factors: &self.factors, conditions: self.cells(), adapted };
        self.task.check(&given, errors);
        let is_changed = self.task.dial().is_some_and(|dial| dial.parameter.is_some());
        let has_own = is_changed || matches!(self.task.layout(), Layout::Intervals { .. });
        if self.presentation.is_some() && has_own {
            let message = "[presentation] does not apply to this task; expected none, or task.duration_s for intervals";
            errors.add("presentation", message);
        }
        let Some(adaptive) = &self.adaptive else { return };
        if !self.task.adapts() {
            let (kind, expected) = (self.task.name(), "expected choice, yes-no or pair");
            errors.add("adaptive", format!("a task of the kind {kind} has no levels to choose; {expected}"));
        }
        adaptive.check(&given, &*self.task, errors);
    }

    /// Adds an error if a parameter that the task or the adaptive method sets contradicts another one.
    fn check_shown(&self, conditions: &[Condition], errors: &mut DefinitionErrors) {
        if self.task.is_default() {
            return;
        }
        let picks = self.picks();
        let dial = self.task.dial().and_then(|dial| Some((dial.parameter?, dial.range)));
        let reference = self.task.reference().cloned().unwrap_or_default();
        for target in conditions.iter().flat_map(|condition| targets(condition, &picks)) {
            let other = reference.apply(&target).unwrap_or_else(|_| target.clone());
            let shown = match &dial {
                Some((name, [low, high])) => [("task.low", low), ("task.high", high)]
                    .map(|(key, end)| (key, at_level(target.clone(), name, *end))),
                None => [("adaptive.parameter", target), ("task.reference", other)],
            };
            let wrong = |(path, stimulus): (_, Stimulus)| Some((path, stimulus.validate().err()?.into_iter().next()?));
            if let Some((path, error)) = shown.into_iter().find_map(wrong) {
                return errors.add(path, error.to_string());
            }
        }
    }

    /// Returns the levels that an adaptive method may choose, at both ends of its range, with each level of a second parameter.
    fn picks(&self) -> Vec<Vec<(&str, f64)>> {
        let Some(adaptive) = &self.adaptive else { return vec![Vec::new()] };
        adaptive.picks(&adaptive.range()).into_iter().map(|pick| adaptive.named(pick)).collect()
    }

    /// Returns the pairs of conditions to compare, and adds an error if their trials cannot be ordered as asked.
    fn pairs(&self, conditions: &[Condition], errors: &mut DefinitionErrors) -> Option<Arc<[[usize; 2]]>> {
        let pairs = self.task.pairs(conditions, &self.factors)?;
        if self.design.order != Order::Random {
            errors.add("design.order", "pairs have no levels of their own; expected order = \"random\"");
        }
        if self.design.max_run.is_some() {
            errors.add("design.max_run", "pairs have no levels of their own; expected no max_run");
        }
        if pairs.is_empty() {
            let message =
                "there are no two conditions to compare; expected neighboring levels of a factor, all else equal";
            errors.add("task.along", message);
        }
        let trials = pairs.len().saturating_mul(self.design.repetitions as usize);
        if self.task.ranking().is_none() && trials > MAX_TRIALS {
            errors.add("factors", format!("the design has {trials} comparisons; expected at most {MAX_TRIALS}"));
        }
        Some(pairs.into())
    }

    fn check_response(&self, errors: &mut DefinitionErrors) {
        let categories = &self.response.categories;
        if self.response.question.trim().is_empty() {
            errors.add("response.question", "the question is empty; expected what participants answer");
        }
        if let Some(expected) = self.task.answers().filter(|expected| *expected != categories.len()) {
            let message = format!("the number of labels is {}; expected {expected}", categories.len());
            errors.add("response.labels", message);
        } else if self.task.answers().is_none() && !CATEGORIES.contains(&categories.len()) {
            let (count, (least, most)) = (categories.len(), CATEGORIES.into_inner());
            errors.add("response.labels", format!("the number of categories is {count}; expected {least} to {most}"));
        }
        for (i, category) in categories.iter().take(*CATEGORIES.end()).enumerate() {
            let path = format!("response.keys.{i}");
            let key = category.key;
            // In a session, S shows the scale.
            if !key.is_ascii_alphanumeric() || key.eq_ignore_ascii_case(&'s') {
                let expected = "expected a digit or a letter A–Z other than S";
                errors.add(path, format!("key {key:?} cannot be an answer; {expected}"));
            } else if categories[..i].iter().any(|other| other.key.eq_ignore_ascii_case(&key)) {
                errors.add(path, format!("key {key:?} appears twice; expected a different key for each answer"));
            }
            if category.label.trim().is_empty() {
                errors.add(format!("response.labels.{i}"), "the label is empty; expected the meaning of the answer");
            } else if categories[..i].iter().any(|other| other.label == category.label) {
                let message =
                    format!("label {:?} appears twice; expected a different one for each answer", category.label);
                errors.add(format!("response.labels.{i}"), message);
            }
        }
    }
}

/// Returns the target of a condition at each of these levels.
fn targets<'a>(condition: &'a Condition, picks: &'a [Vec<(&'a str, f64)>]) -> impl Iterator<Item = Stimulus> {
    picks.iter().map(|levels| Turn { condition, other: None, place: 0, draw: 1.0, levels: levels.clone() }.target())
}

/// Returns why `name` cannot be the name of an experiment, or `None` if it can.
pub fn name_error(name: &str) -> Option<String> {
    let well_formed = !name.is_empty()
        && name.len() <= 64
        && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-')
        // A spreadsheet would read a cell that starts with a hyphen as a formula, and a command line would read it as
        // an option.
        && !name.starts_with('-');
    (!well_formed).then(|| {
        format!(
            "name {name:?} is not allowed; expected at most 64 lowercase letters, digits and hyphens, with no hyphen first, such as \"bangay2003\""
        )
    })
}
