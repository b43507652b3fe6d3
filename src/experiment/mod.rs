//! Floor 3: what an experiment is and how one of its sessions runs. It uses no clock, no files and no window.
//!
//! A [`Definition`] is what a file says. Without errors, it becomes a [`Protocol`], which together with a seed determines
//! a [`Schedule`]. A [`Session`] steps through it, driven by events, and returns effects. A [`TrialRecord`] is one row of
//! the data. [`Observer`]s simulate participants.

mod condition;
mod course;
mod definition;
mod faults;
mod frame_log;
mod observer;
mod participant;
mod protocol;
mod record;
mod replay;
mod scale;
mod schedule;
mod session;
pub mod task;
mod texts;

pub use condition::{Condition, Factor};
pub use course::Course;
pub use definition::{Definition, Design, Order, Plan, Presentation, Recovery, SessionRules, ViewingPlan};
pub use faults::{DefinitionError, DefinitionErrors};
pub use frame_log::{FrameRun, Shown};
pub use observer::{
    Observer, ObserverParameters, OrderedLogit, UniformObserver, VisionObserver, VisionRater, simulate,
};
pub use participant::{Answers, FieldKind, Identity, MAX_ANSWER, ParticipantField};
pub use protocol::{Protocol, name_error};
pub use record::{
    Column, IN_BIDS, Rating, RatingRow, RowContext, SECOND, SIMULATED, STIM_FILE, STIMULUS, Seconds, TaskAnswer,
    TrialRecord, columns, columns_by_header, is_reserved,
};
pub use replay::{Replay, Replayed};
pub use scale::{CATEGORIES, Category, ResponseScale};
pub use schedule::{GENERATOR, Phase, Schedule, ScheduleError, Trial, session_seed};
pub use session::{Effect, Event, FrameCount, Progress, Resumed, Session, SessionOptions, State, TrialResponse};
pub use texts::Texts;
