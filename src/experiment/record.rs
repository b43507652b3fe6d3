//! One row of the data. The struct is the schema: its fields, in order, are the columns of a result file, and the
//! column dictionary and the sidecar are generated from their descriptions.

use std::time::Duration;

use jiff::Timestamp;
use serde::Serialize;

use super::{
    participant::Identity,
    protocol::Protocol,
    scale::CATEGORIES,
    schedule::{Phase, Schedule},
    session::TrialResponse,
    task::{Answer, Presentation},
};
use crate::{light::interpolation::Depth, stimulus::Stimulus, text::Cell as CellValue};

/// A value in one cell of a CSV file.
trait Cell: Sized {
    fn value(&self) -> CellValue;
    fn to_cell(&self) -> String {
        self.value().to_string()
    }
    fn from_cell(text: &str) -> Result<Self, String>;
}

macro_rules! plain_cell {
    ($($kind:ty => $expected:literal, $value:expr;)*) => {$(
        impl Cell for $kind {
            fn value(&self) -> CellValue {
                $value(self)
            }
            fn from_cell(text: &str) -> Result<Self, String> {
                text.parse().map_err(|_| format!("expected {}", $expected))
            }
        }
    )*};
}
plain_cell! {
    u32 => "a whole number", |whole: &u32| CellValue::Whole((*whole).into());
    u64 => "a whole number", |whole: &u64| CellValue::Whole((*whole).into());
    Depth => "a whole number from 1 to 32, or inf", |depth: &Depth| CellValue::Number(match depth {
        Depth::Finite(n) => (*n).into(),
        Depth::Infinite => f64::INFINITY,
    });
    Phase => "practice or main", |phase: &Phase| CellValue::Text(phase.to_string());
    Timestamp => "an RFC 3339 time such as 2026-01-31T09:30:00Z", |time: &Timestamp| CellValue::Time(*time);
}

impl Cell for bool {
    fn value(&self) -> CellValue {
        CellValue::Whole((*self).into())
    }
    fn from_cell(text: &str) -> Result<Self, String> {
        match text {
            "0" => Ok(false),
            "1" => Ok(true),
            _ => Err("expected 0 or 1".to_owned()),
        }
    }
}

impl Cell for String {
    fn value(&self) -> CellValue {
        CellValue::Text(self.clone())
    }
    fn from_cell(text: &str) -> Result<Self, String> {
        if text.is_empty() { Err("expected text".to_owned()) } else { Ok(text.to_owned()) }
    }
}

impl Cell for f64 {
    /// Writes the number without an exponent, as a definition does.
    fn to_cell(&self) -> String {
        self.to_string()
    }
    fn value(&self) -> CellValue {
        CellValue::Number(*self)
    }
    fn from_cell(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(value) if f64::is_finite(value) => Ok(value),
            _ => Err("expected a number".to_owned()),
        }
    }
}

/// A rating; the lowest category of a scale is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rating(pub u8);

impl Cell for Rating {
    fn value(&self) -> CellValue {
        CellValue::Whole(self.0.into())
    }
    fn from_cell(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(rating) if usize::from(rating) < *CATEGORIES.end() => Ok(Self(rating)),
            _ => Err("expected a rating, a whole number from 0".to_owned()),
        }
    }
}

/// Maximum time in a row, about thirty years. Anything longer is not a measurement and would overflow clocks.
const MAX_TIME_S: f64 = 1e9;

/// A time in seconds, written to a tenth of a millisecond.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Seconds(pub f64);

impl Cell for Seconds {
    fn to_cell(&self) -> String {
        format!("{:.4}", self.0)
    }
    fn value(&self) -> CellValue {
        CellValue::Number(self.0)
    }
    fn from_cell(text: &str) -> Result<Self, String> {
        match f64::from_cell(text) {
            Ok(seconds) if (0.0..=MAX_TIME_S).contains(&seconds) => Ok(Self(seconds)),
            _ => Err("expected seconds, 0 or more".to_owned()),
        }
    }
}

impl<T: Cell> Cell for Option<T> {
    fn to_cell(&self) -> String {
        self.as_ref().map_or_else(String::new, Cell::to_cell)
    }
    fn value(&self) -> CellValue {
        self.as_ref().map_or(CellValue::Missing, Cell::value)
    }
    fn from_cell(text: &str) -> Result<Self, String> {
        if text.is_empty() { Ok(None) } else { T::from_cell(text).map(Some) }
    }
}

/// The description of a column in a result file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Column {
    /// The name in the header.
    #[serde(skip)]
    pub name: String,
    /// What the column contains.
    pub description: String,
    /// Unit, if it has one.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// The possible values and their meanings, if there are only a few.
    #[serde(skip_serializing_if = "serde_json::Map::is_empty")]
    pub levels: serde_json::Map<String, serde_json::Value>,
}

/// Declares a part of a row: its fields, in order, are columns.
macro_rules! record {
    ($(#[$meta:meta])* $struct:ident, $columns:ident {
        $($name:ident: $kind:ty, $unit:literal, $description:literal;)*
    } $($(#[$more_meta:meta])* $more:ident: $more_kind:ty,)*) => {
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct $struct {
            $(#[doc = $description] pub $name: $kind,)*
            $($(#[$more_meta])* pub $more: $more_kind,)*
        }

        /// Name, unit and description of the columns.
        const $columns: &[(&str, &str, &str)] = &[$((stringify!($name), $unit, $description),)*];

        impl $struct {
            fn own_cells(&self) -> Vec<String> {
                vec![$(Cell::to_cell(&self.$name),)*]
            }

            fn own_values(&self) -> Vec<CellValue> {
                vec![$(Cell::value(&self.$name),)*]
            }

            fn read(cells: &[&str], next: &mut usize) -> Result<Self, (usize, String)> {
                $(let $name = cell(cells, next, stringify!($name))?;)*
                Ok(Self { $($name,)* $($more: Default::default(),)* })
            }
        }
    };
}

/// Reads the cell at `next` and advances to the following cell.
fn cell<T: Cell>(cells: &[&str], next: &mut usize, name: &str) -> Result<T, (usize, String)> {
    let at = *next;
    *next += 1;
    let cell = cells.get(at).ok_or((at, "the cell is missing".to_owned()))?;
    T::from_cell(cell).map_err(|expected| (at, format!("{name} is {cell:?}; {expected}")))
}

record! {
    /// One trial as it was shown and answered: one row of a result file.
    TrialRecord, FIXED {
        row_id: String, "", "Unique name of the row: participant, session, phase, trial and attempt.";
        experiment: String, "", "Name of the definition.";
        subject_id: String, "", "Participant.";
        session_id: String, "", "Session ID of the participant.";
        phase: Phase, "", "Practice trials are not analyzed.";
        block: u32, "", "Block within the phase, from 1: one level of the blocking factor, or the stretch between two breaks.";
        trial: u32, "", "Planned position within the phase, from 1.";
        attempt: u32, "", "1, plus 1 for each correction of the rating; the last attempt of a trial counts.";
        repetition: u32, "", "How many times the condition has been planned in this phase up to this trial, from 1.";
        stimulus: String, "", "Kind of stimulus.";
        width: Option<f64>, "proportion of the stimulus window", "Width of the luminance ramp; 0 is a step.";
        depth: Option<Depth>, "", "Continuity depth n of the ramp, 1…32 or inf: n-1 derivatives vanish at its ends.";
        orientation_deg: Option<f64>, "degree", "Direction in which the ramp brightens: 0 is to the right, and positive is counterclockwise.";
        low: Option<f64>, "relative luminance, linear light", "Luminance of the darker plateau, 0…1.";
        high: Option<f64>, "relative luminance, linear light", "Luminance of the brighter plateau, 0…1.";
        color: Option<String>, "", "Color: a name, or linear weights of red, green and blue.";
        rating: Option<Rating>, "", "Rated visibility of the brighter band.";
        response_time_s: Seconds, "s", "Time from the onset of the stimulus to the rating.";
        onset_s: Seconds, "s", "Onset of the stimulus since the session's start: the start of the frame that presents it.";
        recovery_s: Seconds, "s", "Actual duration of the uniform field before the stimulus.";
        frames: Option<u32>, "", "Number of frames that presented the stimulus; empty if no screen was used.";
        dropped_frames: Option<u32>, "", "Number of frame intervals longer than 1.5 times the screen's, during recovery and stimulus; empty if not measured.";
        started_at: Timestamp, "", "Wall-clock time of the onset, RFC 3339, UTC.";
        stimulus_s: Option<Seconds>, "s", "Actual duration of the stimulus, from its onset to the frame that replaced it; empty if no screen was used.";
        late_onset: Option<bool>, "", "Whether the onset came more than half a refresh later than planned; empty if the screen's refresh rate is not known.";
        response_uncertainty_s: Option<Seconds>, "s", "Longest time that the key press may have waited before the program received it; empty if not measured.";
        sitting: u32, "", "1, plus 1 each time an interrupted session was resumed.";
        seed: u64, "", "Seed of the trial order.";
    }
    /// What a task other than a rating records in addition.
    answer: Option<TaskAnswer>,
    /// Levels of the factors that have no column above, in the order of the definition. For a pair of stimuli, the
    /// columns of the second follow.
    further: Vec<String>,
}

record! {
    /// The answer to a trial of any task but a rating on a scale of categories.
    TaskAnswer, TASK {
        task: String, "", "Kind of task.";
        response: String, "", "The answer: the number of the place or interval, yes or no, or the value that was set.";
        correct: Option<bool>, "", "Whether the answer is right; empty if there is no right or wrong.";
        level: Option<f64>, "", "The level that the adaptive method chose; in a trial without a target, that of the target that it stands for.";
        target: Option<u32>, "", "Place or interval of the target, from 1; 0 if the trial shows none.";
        start: Option<f64>, "", "The value at which an adjustment began.";
        path: Option<String>, "", "Every change of the value: seconds since the onset, a colon and the new value.";
    }
}

/// The columns of a stimulus.
pub const STIMULUS: [&str; 7] = ["stimulus", "width", "depth", "orientation_deg", "low", "high", "color"];
/// What follows the names of the columns of the second stimulus of a pair.
pub const SECOND: &str = "_2";

impl TrialRecord {
    /// Returns the cells of the row in the order of [`columns`].
    pub fn cells(&self) -> Vec<String> {
        let answer = self.answer.as_ref().map(TaskAnswer::own_cells).unwrap_or_default();
        [self.own_cells(), answer, self.further.clone()].concat()
    }

    /// Returns the values of the cells, in the same order. A factor without a column of its own is a number if its level
    /// is one.
    pub fn values(&self) -> Vec<CellValue> {
        let answer = self.answer.as_ref().map(TaskAnswer::own_values).unwrap_or_default();
        let further = self.further.iter().map(|level| {
            let number = level.parse().ok().filter(|number: &f64| !number.is_nan());
            if level.is_empty() { CellValue::Missing } else { CellValue::Level(level.clone(), number) }
        });
        [self.own_values(), answer, further.collect()].concat()
    }

    /// Reads a row whose cells are in the order of [`columns`].
    ///
    /// # Errors
    /// Returns the index of the first wrong cell and a message with the content that was expected.
    pub fn from_cells(cells: &[&str], columns: &[Column]) -> Result<Self, (usize, String)> {
        let mut next = 0;
        let mut row = Self::read(cells, &mut next)?;
        if columns.get(FIXED.len()).is_some_and(|column| column.name == TASK[0].0) {
            row.answer = Some(TaskAnswer::read(cells, &mut next)?);
        } else if row.rating.is_none() {
            let at = FIXED.iter().position(|(name, ..)| *name == "rating").unwrap_or_default();
            return Err((at, "rating is \"\"; expected a rating, a whole number from 0".to_owned()));
        }
        row.further = cells[next..].iter().map(|cell| (*cell).to_owned()).collect();
        Ok(row)
    }
}

/// Returns every column of a protocol's result files, in order.
pub fn columns(protocol: &Protocol) -> Vec<Column> {
    let known = protocol.stimulus.parameters();
    let factor = |name| {
        let parameter = known.iter().find(|parameter| parameter.name == name);
        parameter.map_or((name, "", ""), |parameter| (name, parameter.unit, parameter.description))
    };
    let with_levels = |one: (&str, &str, &str)| Column { levels: levels(protocol, one.0), ..column(one) };
    let task = if protocol.task.is_default() { &[] } else { TASK };
    let all = FIXED.iter().chain(task).copied().chain(extra_factors(protocol).map(factor)).map(with_levels);
    let mut all: Vec<Column> = all.collect();
    let second = |name: &str| {
        let first = all.iter().find(|column| column.name == name).cloned().unwrap_or_default();
        let description = format!("Of the second stimulus, on the right: {}", first.description);
        Column { name: format!("{name}{SECOND}"), description, ..first }
    };
    let second: Vec<Column> = described_twice(protocol).map(second).collect();
    all.extend(second);
    all
}

/// Returns the columns that a row has for both stimuli of a pair; none if the task shows no pairs of conditions.
fn described_twice(protocol: &Protocol) -> impl Iterator<Item = &str> {
    let own = STIMULUS.into_iter().chain(extra_factors(protocol));
    own.filter(|_| protocol.pairs().is_some())
}

/// Returns the columns of a file whose definition is unknown: the columns that every file has, and any others in its
/// header.
pub fn columns_by_header<'a>(header: impl Iterator<Item = &'a str>) -> Vec<Column> {
    let mut extra = header.skip(FIXED.len()).map(|name| (name, "", "")).peekable();
    let task = if extra.peek().is_some_and(|(name, ..)| *name == TASK[0].0) { TASK } else { &[] };
    FIXED.iter().chain(task).copied().chain(extra.skip(task.len())).map(column).collect()
}

/// Describes a column by its name, unit and meaning.
fn column((name, unit, description): (&str, &str, &str)) -> Column {
    Column { name: name.to_owned(), description: description.to_owned(), unit: unit.to_owned(), ..Column::default() }
}

/// Returns the factors, and the second parameter of an adaptive method, for which other columns have no place.
fn extra_factors(protocol: &Protocol) -> impl Iterator<Item = &str> {
    let second = protocol.adaptive.as_ref().and_then(|adaptive| Some(adaptive.second()?.parameter.as_str()));
    let names = protocol.factors.iter().map(|factor| factor.name.as_str()).chain(second);
    names.filter(|name| FIXED.iter().chain(TASK).all(|(fixed, ..)| fixed != name))
}

/// The column of a table that says whether a program answered, as the sidecars of result files do.
pub const SIMULATED: &str = "simulated";

/// The columns of a result file that have another name in BIDS, each with that name.
pub const IN_BIDS: [(&str, &str); 3] =
    [("phase", "trial_type"), ("response_time_s", "response_time"), ("subject_id", "participant_id")];
/// The column of a BIDS table that names the picture.
pub const STIM_FILE: &str = "stim_file";

/// Returns whether a column of every file has this name and is not a parameter of the stimulus, or an analysis reads from it
/// whether a program answered, so that a factor cannot have it.
pub fn is_reserved(name: &str) -> bool {
    let is_parameter = name != STIMULUS[0] && STIMULUS.contains(&name);
    !is_parameter
        && (name == SIMULATED || name.ends_with(SECOND) || FIXED.iter().chain(TASK).any(|(fixed, ..)| *fixed == name))
}

fn levels(protocol: &Protocol, column: &str) -> serde_json::Map<String, serde_json::Value> {
    let pair = |(level, meaning): (&str, &str)| (level.to_owned(), meaning.into());
    match column {
        "phase" => {
            [("practice", "Before the measurement"), ("main", "The measurement")].map(pair).into_iter().collect()
        }
        "late_onset" => [("0", "As planned"), ("1", "Late")].map(pair).into_iter().collect(),
        "correct" => [("0", "Wrong"), ("1", "Right")].map(pair).into_iter().collect(),
        "rating" if protocol.task.is_default() => (0..)
            .zip(&protocol.response.categories)
            .map(|(i, category): (u32, _)| pair((&i.to_string(), &category.label)))
            .collect(),
        _ => serde_json::Map::new(),
    }
}

/// A rating, or several equal ratings, from any file: the part of a row that an analysis needs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RatingRow<'a> {
    /// The participant.
    pub subject: &'a str,
    /// The level of each factor, as written; empty if missing.
    pub values: &'a [&'a str],
    /// The rating, as written.
    pub rating: &'a str,
    /// The number of equal ratings.
    pub count: u64,
    /// The session; it counts if the repetition or the position in it is known.
    pub session: &'a str,
    /// The repetition. The natural order of sessions and repetitions distinguishes a condition's first rating from its second.
    /// A rating whose repetition is unknown is not paired.
    pub repetition: Option<u32>,
    /// The place of the trial in its session, if known.
    pub position: Option<f64>,
    /// Time from the onset to the rating in seconds, if known.
    pub response_time_s: Option<f64>,
}

/// What a row needs in addition to the response.
#[derive(Clone, Debug)]
pub struct RowContext<'a> {
    /// The definition.
    pub protocol: &'a Protocol,
    /// The order of the trials.
    pub schedule: &'a Schedule,
    /// Participant and session.
    pub identity: &'a Identity,
    /// Number of the sitting: 1 unless the session was resumed.
    pub sitting: u32,
}

impl TrialRecord {
    /// Creates the row for a response. `started_at` is the wall-clock time of the onset.
    pub fn new(context: &RowContext<'_>, response: &TrialResponse, started_at: Timestamp) -> Self {
        let seconds = |time: Duration| Seconds(time.as_secs_f64());
        let TrialResponse { trial, attempt, shown, answer, .. } = response;
        let measured = Self {
            response_time_s: seconds(response.response_time),
            onset_s: seconds(response.onset),
            recovery_s: seconds(response.recovery),
            frames: response.frames,
            dropped_frames: response.dropped_frames,
            started_at,
            sitting: context.sitting,
            stimulus_s: response.stimulus.map(seconds),
            late_onset: response.late_onset,
            response_uncertainty_s: response.uncertainty.map(seconds),
            answer: response.path().map(|path| TaskAnswer { path: Some(path), ..TaskAnswer::default() }),
            ..Self::default()
        };
        measured.of_trial(context, *trial, *attempt, (shown, answer))
    }

    /// Returns the measurements of this row together with the planned values of a trial, what it showed and its answer.
    pub(super) fn of_trial(
        self,
        context: &RowContext<'_>,
        trial: usize,
        attempt: u32,
        (shown, answer): (&Presentation, &Answer),
    ) -> Self {
        let RowContext { protocol, schedule, identity, .. } = context;
        let (trial, task) = (&schedule.trials[trial], &protocol.task);
        let stimulus = shown.described();
        let number = |name: &str| CellValue::from(stimulus.get(name)?).as_number();
        let text = |stimulus: &Stimulus, name: &str| match name {
            "stimulus" => stimulus.kind().to_owned(),
            _ => stimulus.get(name).map(|value| value.to_string()).unwrap_or_default(),
        };
        let further = extra_factors(protocol).map(|name| text(stimulus, name));
        let second = shown.stimuli.last().unwrap_or(stimulus);
        let twice = described_twice(protocol).map(|name| text(second, name));
        let (subject, session) = (identity.subject(), identity.session());
        let of_task = || TaskAnswer {
            task: task.name().to_owned(),
            response: task.response(answer),
            correct: task.judge(shown, answer),
            level: shown.level,
            target: shown.target,
            start: shown.start,
            path: self.answer.as_ref().and_then(|answer| answer.path.clone()),
        };
        Self {
            row_id: format!("{subject}_{session}_{}_{:04}_{attempt}", trial.phase, trial.number),
            experiment: protocol.name.clone(),
            subject_id: subject.to_owned(),
            session_id: session.to_owned(),
            phase: trial.phase,
            block: trial.block,
            trial: trial.number,
            attempt,
            repetition: trial.repetition,
            stimulus: stimulus.kind().to_owned(),
            width: number("width"),
            depth: text(stimulus, "depth").parse().ok(),
            orientation_deg: number("orientation_deg"),
            low: number("low"),
            high: number("high"),
            color: Some(text(stimulus, "color")).filter(|color| !color.is_empty()),
            rating: if let (true, Answer::Key(key)) = (task.is_default(), answer) { Some(Rating(*key)) } else { None },
            seed: schedule.seed,
            answer: (!task.is_default()).then(of_task),
            further: further.chain(twice).collect(),
            ..self
        }
    }

    /// Returns the level of a factor in this row, as written in its cell.
    pub fn level(&self, protocol: &Protocol, factor: &str) -> Option<String> {
        let index = columns(protocol).iter().position(|column| column.name == factor)?;
        self.cells().into_iter().nth(index)
    }

    /// Returns whether the changes of a value lead to this answer: in the order of time, from the start to the answer.
    /// Times of changes are written to the millisecond.
    pub(super) fn leads_to(&self, answer: &Answer, protocol: &Protocol) -> bool {
        let Some(TaskAnswer { start, path, .. }) = &self.answer else { return true };
        if protocol.task.dial().is_none() {
            return path.is_none();
        }
        let (mut last_s, mut value) = (0.0, *start);
        let mut is_next = |step: &str| {
            let number = |text: &str| text.parse::<f64>().ok();
            let step = step.split_once(':').and_then(|(at, to)| number(at).zip(number(to)));
            step.is_some_and(|(at_s, to)| {
                value = Some(to);
                std::mem::replace(&mut last_s, at_s) <= at_s
            })
        };
        let is_whole = path.iter().flat_map(|path| path.split(' ')).all(&mut is_next);
        is_whole && last_s <= self.response_time_s.0 + 0.001 && value.map(Answer::Value).as_ref() == Some(answer)
    }

    /// Returns the answer in this row; `None` if the task has no such answer.
    pub fn given(&self, protocol: &Protocol) -> Option<Answer> {
        let Some(TaskAnswer { response, .. }) = &self.answer else { return Some(Answer::Key(self.rating?.0)) };
        if let Some(dial) = protocol.task.dial() {
            let value = response.parse().ok().filter(|value| (dial.range[0]..=dial.range[1]).contains(value))?;
            return Some(Answer::Value(value));
        }
        let keys = (0..protocol.response.categories.len()).map(|key| Answer::Key(key as u8));
        keys.into_iter().find(|answer| protocol.task.response(answer) == *response)
    }
}
