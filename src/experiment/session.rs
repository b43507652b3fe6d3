//! The session as a pure state machine: it takes events and times, and returns effects. It uses no clock, no files and
//! no window, so a person at the screen and a simulated observer can drive the same machine.

use std::{
    collections::{BTreeMap, BTreeSet},
    time::Duration,
};

use super::{
    course::Course,
    frame_log::{FrameLog, FrameRun, Shown},
    protocol::Protocol,
    schedule::{Phase, Schedule},
    task::{Answer, Dial, Layout, Presentation},
};
use crate::display::frames::{FrameTimes, Refresh};

/// An event in a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A frame begins that will show the current [`State`]. Without a screen: time has passed.
    Frame,
    /// Continue from a page or a break.
    Continue,
    /// Go back to the previous page of the instructions.
    Back,
    /// The trial is answered now, with this answer, from 0. If a value is set, 0 accepts it.
    Rate(u8),
    /// The trial was answered before this frame began.
    RateAt {
        /// The answer, from 0.
        rating: u8,
        /// When the program received the answer. A time before the onset or after the start of this frame is clamped to
        /// that limit.
        at: Duration,
        /// Longest time that the rating may have waited before the program received it, if known.
        uncertainty: Option<Duration>,
    },
    /// The value that participants set is now this.
    Adjust(f64),
    /// Undo the last answer.
    Undo,
    /// Stop at once.
    Pause,
    /// Continue after a pause.
    Resume,
    /// End the session here; existing ratings are kept.
    Leave,
    /// The last [`Effect::Record`] is on disk.
    Stored,
}

/// What the driver must do.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Only show the current state.
    None,
    /// Store this on disk and reply with [`Event::Stored`]. Until then, no further stimulus is shown.
    Record(Box<TrialResponse>),
}

/// What the screen shows. Times are measured from the session's start.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// A page of the instructions, counted from 0.
    Instructions(usize),
    /// A page that announces the practice or the main trials.
    PhaseStart(Phase),
    /// The uniform field before a stimulus.
    Recovery {
        /// When the field first appeared on the screen.
        since: Duration,
    },
    /// The stimulus.
    Stimulus {
        /// Start of the frame that presented it. If several intervals show a stimulus, that of the last one so far.
        onset: Duration,
        /// The interval, from 0.
        interval: usize,
    },
    /// The uniform field between two intervals.
    Gap {
        /// When the field appeared on the screen.
        since: Duration,
        /// The next interval.
        next: usize,
    },
    /// The uniform field after a stimulus of fixed duration, until it is rated.
    Response {
        /// Start of the frame that presented the stimulus.
        onset: Duration,
        /// Actual duration of the stimulus, or of the last interval.
        stimulus: Duration,
    },
    /// A rest, until the participant continues.
    Break,
    /// The uniform field after the last trial, whose rating can still be undone.
    Closing {
        /// When the field first appeared on the screen.
        since: Duration,
    },
    /// Paused in the given state. A trial in progress will start over.
    Paused(Box<State>),
    /// All trials are rated and stored.
    Done,
    /// Ended early.
    Left,
}

/// One answered trial.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialResponse {
    /// Index into [`Schedule::trials`].
    pub trial: usize,
    /// 1, plus 1 each time the rating was undone, and each time the practice was repeated.
    pub attempt: u32,
    /// What it showed.
    pub shown: Presentation,
    /// The answer.
    pub answer: Answer,
    /// Every change of a value that was set, with the time since the onset; `None` if no value is set.
    pub steps: Option<Vec<(Duration, f64)>>,
    /// Time from the onset, or from that of the last interval, to the answer.
    pub response_time: Duration,
    /// Onset of the stimulus, measured from the session's start.
    pub onset: Duration,
    /// Actual duration of the uniform field before the stimulus.
    pub recovery: Duration,
    /// Time from the onset to the frame that replaced the stimulus, if there is a screen.
    pub stimulus: Option<Duration>,
    /// Longest time that the rating may have waited before the program received it, if known.
    pub uncertainty: Option<Duration>,
    /// Whether the onset was more than half a refresh later than planned, if the refresh interval is known.
    pub late_onset: Option<bool>,
    /// Number of frames that presented the stimulus, if there is a screen.
    pub frames: Option<u32>,
    /// Number of frame intervals longer than 1.5 times the screen's during recovery and stimulus, if that interval is
    /// known.
    pub dropped_frames: Option<u32>,
}

impl TrialResponse {
    /// Returns the changes of a value as a row writes them.
    pub fn path(&self) -> Option<String> {
        let steps = self.steps.as_ref().filter(|steps| !steps.is_empty())?;
        let step = |(at, value): &(Duration, f64)| format!("{:.3}:{value}", at.as_secs_f64());
        Some(steps.iter().map(step).collect::<Vec<_>>().join(" "))
    }
}

/// Whether frames are counted, and the interval against which they are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameCount {
    /// No screen.
    Off,
    /// A screen whose refresh interval is unknown.
    Frames,
    /// A screen with this refresh interval, in seconds.
    Against(f64),
}

/// How a session starts.
#[derive(Clone, Copy, Debug)]
pub struct SessionOptions {
    /// Number of pages of instructions before the first trial.
    pub pages: usize,
    /// How frames are counted.
    pub frames: FrameCount,
}

/// What an interrupted session had already recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resumed {
    /// Indices into [`Schedule::trials`] of the trials that have a rating.
    pub done: BTreeSet<usize>,
    /// The last attempt of trials that are shown again although they have a rating.
    pub again: BTreeMap<usize, u32>,
}

impl Resumed {
    /// Shows every practice trial again. `attempts` are the last attempts of the trials that have a rating.
    pub fn repeat_practice(&mut self, practice: usize, attempts: impl IntoIterator<Item = (usize, u32)>) {
        self.again = attempts.into_iter().filter(|(trial, _)| *trial < practice).collect();
        self.done.retain(|trial| *trial >= practice);
    }
}

/// Progress of a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Number of trials rated, including those of earlier sittings.
    pub done: usize,
    /// Number of trials planned.
    pub total: usize,
    /// Time remaining, estimated from the pace so far or, before the first rating, from the definition.
    pub remaining: Duration,
}

/// A running session.
#[derive(Clone, Debug)]
pub struct Session {
    course: Course,
    /// The trials that were still missing when the session started, in order.
    missing: Vec<usize>,
    /// Index in `missing` of the first trial that is not answered.
    position: usize,
    /// What the current or next trial shows.
    shown: Option<Presentation>,
    /// What is known about the trial at hand so far.
    trial: Measured,
    /// See [`Resumed::again`].
    again: BTreeMap<usize, u32>,
    /// The trial being repeated after its rating was undone, and its attempt.
    redo: Option<(usize, u32)>,
    /// True if the page or break before the next trial was already over when a rating was undone, so that it is not
    /// shown again.
    page_left: bool,
    /// The trial rated last and its attempt. Its rating can still be undone.
    last: Option<(usize, u32)>,
    /// A record is being written to disk.
    pending: bool,
    state: State,
    options: SessionOptions,
    log: FrameLog,
    /// Total time spent in trials and their number, to estimate the remaining time.
    pace: (Duration, u32),
}

/// What is measured in a trial, until it is answered.
#[derive(Clone, Debug, Default)]
struct Measured {
    /// When the uniform field before the stimulus appeared.
    start: Duration,
    /// The actual duration of that field.
    recovery: Duration,
    /// Start of the frame that presented the stimulus, or its first interval.
    onset: Duration,
    /// The value that is set, and its changes so far.
    value: Option<f64>,
    steps: Vec<(Duration, f64)>,
    frames: u32,
    dropped: u32,
    /// True if a frame could not be judged because no refresh interval was known.
    unjudged: bool,
    late: Option<bool>,
}

impl Session {
    /// Creates a session at its first page. All trials that are not yet done lie ahead.
    pub fn new(course: Course, resumed: &Resumed, options: SessionOptions) -> Self {
        let missing = (0..course.schedule().trials.len()).filter(|trial| !resumed.done.contains(trial)).collect();
        let mut session = Self {
            course,
            missing,
            again: resumed.again.clone(),
            position: 0,
            shown: None,
            trial: Measured::default(),
            redo: None,
            page_left: false,
            last: None,
            pending: false,
            state: State::Instructions(0),
            options,
            log: FrameLog::default(),
            pace: (Duration::ZERO, 0),
        };
        session.plan();
        if session.current().is_none() {
            session.state = State::Done;
        } else if options.pages == 0 {
            session.state = State::PhaseStart(session.phase());
        }
        session
    }

    /// Returns what the screen shows.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the definition.
    pub fn protocol(&self) -> &Protocol {
        self.course.protocol()
    }

    /// Returns the planned order of the trials.
    pub fn schedule(&self) -> &Schedule {
        self.course.schedule()
    }

    /// Returns the index into [`Schedule::trials`] of the current or next trial, or `None` if no trial is left.
    pub fn current(&self) -> Option<usize> {
        let next = || self.missing[self.position..].iter().find(|trial| !self.course.is_over(**trial)).copied();
        self.redo.map(|(trial, _)| trial).or_else(next)
    }

    /// Returns what the current or next trial shows, or `None` if no trial is left.
    pub fn shown(&self) -> Option<&Presentation> {
        self.shown.as_ref()
    }

    /// Returns the value that is set now, if the task asks for one and it was touched or began somewhere.
    pub fn value(&self) -> Option<f64> {
        self.trial.value
    }

    /// Chooses what the current or next trial shows.
    fn plan(&mut self) {
        self.shown = self.current().map(|trial| self.course.presentation(trial));
    }

    /// Returns whether a rating is waiting to be stored.
    pub fn is_storing(&self) -> bool {
        self.pending
    }

    /// Returns whether the trial can be answered now: the last of its stimuli is or was shown.
    pub fn can_answer(&self) -> bool {
        match self.state {
            State::Stimulus { interval, .. } => interval + 1 == self.protocol().task.layout().intervals(),
            State::Response { .. } => true,
            _ => false,
        }
    }

    /// Returns whether [`Event::Undo`] would have an effect now.
    pub fn can_undo(&self) -> bool {
        let between =
            matches!(self.state, State::Recovery { .. } | State::Closing { .. } | State::Break | State::PhaseStart(_));
        between && self.last.is_some() && self.redo.is_none() && !self.pending
    }

    /// Returns the intervals of all frames of the trials so far, excluding pages.
    pub fn frame_times(&self) -> &FrameTimes {
        &self.log.times
    }

    /// Returns what the frames since the last call showed and how long each was shown.
    pub fn take_frame_runs(&mut self) -> Vec<FrameRun> {
        std::mem::take(&mut self.log.runs)
    }

    /// Judges frames against `frames`, beginning with the next one. Call this when the screen has changed or when its
    /// refresh interval is known more accurately.
    pub fn set_frame_count(&mut self, frames: FrameCount) {
        self.options.frames = frames;
    }

    /// Notes that something else was on the screen, so that the next frame does not follow the last one.
    pub fn interrupt_frames(&mut self) {
        self.log.interrupt();
    }

    /// Returns the progress of the session.
    pub fn progress(&self) -> Progress {
        let total = self.schedule().trials.len();
        let left = self.missing[self.position..].iter().filter(|trial| !self.course.is_over(**trial)).count();
        let (time, rated) = self.pace;
        let planned = || Duration::try_from_secs_f64(self.protocol().trial_s() * left as f64).unwrap_or_default();
        let remaining = if rated > 0 { time / rated * left as u32 } else { planned() };
        Progress { done: total - left, total, remaining }
    }

    /// Returns whether [`Event::Back`] would have an effect now. A page after a rating leads only forward; there, the
    /// rating can be undone.
    pub fn can_go_back(&self) -> bool {
        match self.state {
            State::Instructions(page) => page > 0,
            State::PhaseStart(_) => self.options.pages > 0 && self.pace.1 == 0,
            _ => false,
        }
    }

    /// Processes one event at `now`, the time since the session's start, which must never decrease. An event that does
    /// not apply to the current state is ignored.
    pub fn step(&mut self, event: Event, now: Duration) -> Effect {
        match (event, &self.state) {
            (Event::Stored, _) => self.pending = false,
            (Event::Frame, _) => self.frame(now),
            (Event::Continue, State::Instructions(page)) => {
                let next = page + 1;
                self.state =
                    if next < self.options.pages { State::Instructions(next) } else { State::PhaseStart(self.phase()) };
            }
            (Event::Back, _) if self.can_go_back() => {
                let page = if let State::Instructions(page) = self.state { page } else { self.options.pages };
                self.state = State::Instructions(page - 1);
            }
            (Event::Continue, State::PhaseStart(_) | State::Break) => self.recover(now),
            (Event::Rate(rating), _) => return self.rate(rating, now, None, now),
            (Event::RateAt { rating, at, uncertainty }, _) => return self.rate(rating, at, uncertainty, now),
            (Event::Adjust(value), State::Stimulus { onset, .. } | State::Response { onset, .. }) => {
                if let Some(Dial { range: [low, high], .. }) = self.protocol().task.dial()
                    && value.is_finite()
                {
                    let value = value.clamp(low, high);
                    if self.trial.value.replace(value) != Some(value) {
                        self.trial.steps.push((now.saturating_sub(*onset), value));
                    }
                }
            }
            (Event::Undo, _) if self.can_undo() => {
                self.redo = self.last.take().map(|(trial, attempt)| (trial, attempt + 1));
                self.redo.into_iter().for_each(|(trial, _)| self.course.take_back(trial));
                self.plan();
                self.page_left = matches!(self.state, State::Recovery { .. });
                self.recover(now);
            }
            (Event::Pause, state) if !matches!(state, State::Paused(_) | State::Done | State::Left) => {
                let held = std::mem::replace(&mut self.state, State::Done);
                self.state = State::Paused(Box::new(held));
            }
            (Event::Resume, State::Paused(held)) => match held.as_ref() {
                State::Recovery { .. } | State::Stimulus { .. } | State::Gap { .. } | State::Response { .. } => {
                    self.recover(now);
                }
                State::Closing { .. } => self.state = State::Closing { since: now },
                other => self.state = other.clone(),
            },
            (Event::Leave, State::Paused(_)) => self.state = State::Left,
            _ => {}
        }
        Effect::None
    }

    fn phase(&self) -> Phase {
        self.current().map_or(Phase::Main, |trial| self.schedule().trials[trial].phase)
    }

    fn recover(&mut self, now: Duration) {
        // What has been on the screen until now belongs to the previous state.
        self.end_frame(now);
        self.trial = Measured { start: now, ..Measured::default() };
        self.state = State::Recovery { since: now };
    }

    fn frame(&mut self, now: Duration) {
        self.end_frame(now);
        match self.state {
            State::Recovery { since } if self.is_recovered(since, now) => self.present(since, now),
            State::Stimulus { onset, interval } => match self.protocol().presentation_duration() {
                Some(planned) if self.is_over(now.saturating_sub(onset), planned) => {
                    let next = interval + 1;
                    self.state = match self.protocol().task.layout() {
                        Layout::Intervals { count, .. } if next < count => State::Gap { since: now, next },
                        _ => State::Response { onset, stimulus: now.saturating_sub(onset) },
                    };
                }
                _ => self.trial.frames += 1,
            },
            State::Gap { since, next } if self.is_over(now.saturating_sub(since), self.protocol().gap_duration()) => {
                self.trial.frames += 1;
                self.state = State::Stimulus { onset: now, interval: next };
            }
            State::Closing { since } if self.is_recovered(since, now) => self.state = State::Done,
            _ => {}
        }
        self.begin_frame(now);
    }

    fn present(&mut self, since: Duration, now: Duration) {
        let recovery = now.saturating_sub(since);
        let late = self.refresh().map(|refresh| refresh.is_late(recovery, self.protocol().recovery_duration()));
        if late == Some(true) {
            self.log.times.late_onset();
        }
        let value = self.shown.as_ref().and_then(|shown| shown.start);
        let before = std::mem::take(&mut self.trial);
        self.trial = Measured { recovery, onset: now, value, frames: 1, late, ..before };
        self.state = State::Stimulus { onset: now, interval: 0 };
    }

    fn is_recovered(&self, since: Duration, now: Duration) -> bool {
        self.is_over(now.saturating_sub(since), self.protocol().recovery_duration()) && !self.pending
    }

    /// Returns whether a duration is over. If the refresh interval is known, durations last a whole number of
    /// refreshes.
    fn is_over(&self, elapsed: Duration, duration: Duration) -> bool {
        match self.refresh() {
            Some(refresh) => refresh.is_due(elapsed, duration),
            None => elapsed >= duration,
        }
    }

    fn refresh(&self) -> Option<Refresh> {
        match self.options.frames {
            FrameCount::Against(seconds) => Refresh::new(seconds),
            FrameCount::Off | FrameCount::Frames => None,
        }
    }

    fn begin_frame(&mut self, now: Duration) {
        let at_hand = self.current().map(|trial| (trial, self.attempt(trial)));
        let of = |shown| at_hand.map(|(trial, attempt)| (shown, trial, attempt));
        let shown = match self.state {
            _ if self.options.frames == FrameCount::Off => None,
            State::Recovery { .. } => of(Shown::Recovery),
            State::Stimulus { .. } => of(Shown::Stimulus),
            State::Gap { .. } => of(Shown::Gap),
            State::Response { .. } => of(Shown::Response),
            State::Closing { .. } => self.last.map(|(trial, attempt)| (Shown::Closing, trial, attempt)),
            _ => None,
        };
        self.log.begin(now, self.refresh(), shown);
    }

    fn end_frame(&mut self, now: Duration) {
        if let Some((Shown::Recovery | Shown::Stimulus | Shown::Gap, interval)) = self.log.end(now) {
            self.trial.dropped += u32::from(interval.dropped);
            self.trial.unjudged |= interval.refresh.is_none();
        }
    }

    /// Returns the attempt of the trial at hand.
    fn attempt(&self, trial: usize) -> u32 {
        self.redo.map_or_else(|| self.again.get(&trial).map_or(1, |last| last + 1), |(_, attempt)| attempt)
    }

    /// Returns the answer of a key; `None` if there is no such answer, or not yet.
    fn answer(&self, key: u8) -> Option<Answer> {
        if self.protocol().task.dial().is_some() {
            return self.trial.value.filter(|_| key == 0).map(Answer::Value);
        }
        (usize::from(key) < self.protocol().response.categories.len()).then_some(Answer::Key(key))
    }

    fn rate(&mut self, key: u8, at: Duration, uncertainty: Option<Duration>, now: Duration) -> Effect {
        let (onset, stimulus) = match self.state {
            State::Stimulus { onset, .. } if self.can_answer() => (onset, now.saturating_sub(onset)),
            State::Response { onset, stimulus } => (onset, stimulus),
            _ => return Effect::None,
        };
        let (Some(trial), Some(answer)) = (self.current(), self.answer(key)) else { return Effect::None };
        let Some(shown) = self.shown.take() else { return Effect::None };
        // The last frame that shows the stimulus counts as well.
        self.end_frame(now);
        let attempt = self.attempt(trial);
        self.course.answer(trial, &shown, &answer);
        if self.redo.take().is_none() {
            self.done(trial);
        }
        self.plan();
        self.last = Some((trial, attempt));
        self.pending = true;
        let measured = std::mem::take(&mut self.trial);
        self.pace.0 += now.saturating_sub(measured.start);
        self.pace.1 += 1;
        let screen = self.options.frames != FrameCount::Off;
        let judged = self.refresh().is_some() && !measured.unjudged;
        let sets_value = matches!(answer, Answer::Value(_));
        let response = TrialResponse {
            trial,
            attempt,
            shown,
            answer,
            steps: sets_value.then_some(measured.steps),
            response_time: at.min(now).saturating_sub(onset),
            onset: measured.onset,
            recovery: measured.recovery,
            stimulus: screen.then_some(stimulus),
            uncertainty,
            late_onset: measured.late,
            frames: screen.then_some(measured.frames),
            dropped_frames: judged.then_some(measured.dropped),
        };
        self.after(trial, now);
        Effect::Record(Box::new(response))
    }

    /// Notes that a trial is answered. Trials before it that were left out stay in `missing`, because an answer that is
    /// undone may bring them back.
    fn done(&mut self, trial: usize) {
        let ahead = &mut self.missing[self.position..];
        if let Some(place) = ahead.iter().position(|other| *other == trial) {
            ahead[..=place].rotate_right(1);
            self.position += 1;
        }
    }

    /// Moves to what follows a rated trial.
    fn after(&mut self, rated: usize, now: Duration) {
        let rated = self.schedule().trials[rated].clone();
        let every = self.protocol().design.break_every;
        let Some(next) = self.current() else {
            self.state = State::Closing { since: now };
            return;
        };
        if std::mem::take(&mut self.page_left) {
            self.recover(now);
        } else if self.schedule().trials[next].phase != rated.phase {
            self.state = State::PhaseStart(self.phase());
        } else if rated.phase == Phase::Main && every > 0 && rated.number.is_multiple_of(every) {
            self.state = State::Break;
        } else {
            self.recover(now);
        }
    }
}
