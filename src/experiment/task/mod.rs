//! What participants do in a trial, and what an adaptive method shows next.
//!
//! A [`Task`] is one of the kinds, each of which states in its own file how its trials look, how they are judged and how
//! an observer answers. An [`Adaptive`] method chooses levels. Both are functions of the definition, the seed and the
//! answers so far, which a [`Course`](super::Course) replays.

mod adaptive;
mod adjust;
mod choice;
mod common;
mod curve;
mod kind;
mod kinds;
mod pair;
mod quest;
mod ranking;
mod rating;
mod staircase;
mod track;
mod yes_no;

pub use adaptive::{Adaptive, Constant, Method};
pub use adjust::Adjust;
pub use choice::{Choice, Shown as ChoiceShown};
pub use common::{Common, Easier};
pub use curve::{Curve, Psychometric};
pub use kind::{Answer, Dial, Given, Kind, Layout, Measures, Presentation, Senses, Settings, Turn, significant};
pub use kinds::OptionReader;
pub use pair::{Pair, Pairs};
pub use quest::{Grid, Quest, QuestPlus, Second};
pub use ranking::Ranking;
pub use rating::{Rating as RatingTask, Scale as RatingScale};
pub use staircase::{Staircase, Stairs};
pub use track::{Pick, Track};
pub use yes_no::YesNo;

use kinds::kinds;

kinds! {
    /// What participants do in a trial.
    Task, "kind" {
        /// Rate one stimulus.
        Rating(RatingTask) = "rating",
        /// Say which of several stimuli is the target.
        Choice(Choice) = "choice",
        /// Say whether the target is there.
        YesNo(YesNo) = "yes-no",
        /// Compare two stimuli.
        Pair(Pair) = "pair",
        /// Change a parameter until a criterion holds.
        Adjust(Adjust) = "adjust",
    }
}

impl std::ops::Deref for Task {
    type Target = dyn Kind;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Rating(task) => task,
            Self::Choice(task) => task,
            Self::YesNo(task) => task,
            Self::Pair(task) => task,
            Self::Adjust(task) => task,
        }
    }
}

impl Default for Task {
    fn default() -> Self {
        Self::Rating(RatingTask::default())
    }
}

impl Task {
    /// Returns whether this is the rating that a definition without a task asks for.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
