//! Floor 3: what an experiment is and how one of its sessions runs. It uses no clock, no files and no window.
//!
//! A [`Protocol`] (a definition, validated once) and a seed determine a [`Schedule`]. A [`Session`] steps through it,
//! driven by events, and returns effects. A [`TrialRecord`] is one row of the data. [`Observer`]s simulate
//! participants.

mod condition;
mod faults;
mod frame_log;
mod identity;
mod observer;
mod participant;
mod protocol;
mod record;
mod schedule;
mod scripts;
mod session;
mod texts;

pub use condition::{Condition, Factor};
pub use faults::{DefinitionError, DefinitionErrors};
pub use frame_log::{FrameRun, Shown};
pub use identity::{Identity, IdentityError};
pub use observer::{Observer, OrderedLogit, UniformObserver, VisionObserver, VisionRater, simulate, visibilities};
pub use participant::{AnswerError, Answers, FieldKind, FieldSpec, MAX_ANSWER, ParticipantField, ParticipantFields};
pub use protocol::{
    Category, Design, MAX_RATING, Order, Presentation, Protocol, Recovery, ResponseScale, ViewingPlan, name_error,
};
pub use record::{
    Column, LATER_COLUMN_COUNT, Rating, RatingRow, RowContext, Seconds, TrialRecord, columns, columns_by_header,
};
pub use schedule::{GENERATOR, Phase, Schedule, ScheduleError, Trial, session_seed};
pub use session::{Effect, Event, FrameCount, Progress, Resumed, Session, SessionOptions, State, TrialResponse};
pub use texts::Texts;
