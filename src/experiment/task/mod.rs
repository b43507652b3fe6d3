//! What participants do in a trial, and what an adaptive method shows next.
//!
//! A [`Task`] is one of the kinds, each of which states in its own file how its trials look, how they are judged and how
//! an observer answers. An [`Adaptive`] method chooses levels. Both are functions of the definition, the seed and the
//! answers so far, which a [`Course`](super::Course) replays.

mod adaptive;
mod adjust;
mod choice;
pub mod curve;
mod kind;
mod options;
mod pair;
mod quest;
mod rating;
mod scaling;
mod staircase;
mod yes_no;

pub use adaptive::{Adaptive, Constant, Method, Track};
pub use adjust::Adjust;
pub use choice::{Choice, Shown as ChoiceShown};
pub use curve::{Common, Curve, Easier, Psychometric};
pub(super) use kind::at_level;
pub use kind::{Answer, Dial, Given, Kind, Layout, Pick, Presentation, Senses, Settings, Turn, significant};
pub use options::{Defaults, OptionReader, OptionValue, TaskOption, typed};
pub use pair::{Pair, Pairs};
pub use quest::{Grid, Quest, QuestPlus, Second};
pub use rating::{Rating as RatingTask, Scale as RatingScale};
pub use scaling::{Mode, Ranking, Scaling, Wins};
pub use staircase::{Staircase, Stairs};
pub use yes_no::YesNo;

use options::kinds;
pub(super) use options::options;

use super::{scale::ResponseScale, texts::Texts};

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

/// What is to be seen, unless the pictures are a study's own.
const BAND: &str = " Each has a dark and a bright area with a transition between them. Where the transition meets the bright area, a line or band that is brighter still may stand out.\n\n";
/// How a dial is turned.
const DIAL: &str = "Change the value with the arrow keys or the mouse wheel; with Shift, the steps are finer. Press Enter to answer. While the screen shows one even color, Backspace undoes the last answer. Esc pauses.";
/// How answers with keys of their own are given.
const KEYS: &str = "Answer with the keys {keys}. While the screen shows one even color, Backspace undoes the last answer. S shows or hides the answers. Esc pauses.";

impl Task {
    /// Replaces the default texts, which are those of a rating of bands with digits, by texts that suit this task, its answers
    /// and, if `is_picture`, pictures of a study's own: what they show, only the question says.
    pub fn instruct(&self, texts: &mut Texts, scale: &ResponseScale, is_picture: bool) {
        let (default, has_dial) = (Texts::default(), self.dial().is_some());
        let replace = |text: &mut String, default: String, own: &str| {
            if *text == default {
                own.clone_into(text);
            }
        };
        if is_picture || !self.is_default() {
            replace(&mut texts.task, default.task, &self.first_page(&scale.question, is_picture));
        }
        if self.is_default() && scale.categories.iter().all(|category| category.key.is_ascii_digit()) {
            return;
        }
        replace(&mut texts.keys, default.keys, if has_dial { DIAL } else { KEYS });
        // A dial has no scale that can be hidden.
        if has_dial {
            replace(&mut texts.practice_scale, default.practice_scale, "");
            replace(&mut texts.main_scale, default.main_scale, "");
        }
    }

    /// Returns what the first page says about the task, unless the definition has its own text.
    fn first_page(&self, question: &str, is_picture: bool) -> String {
        let (seen, guess) = match self.layout() {
            Layout::Single => ("one image at a time", ""),
            Layout::Places(_) => ("several images at the same time", " If you are not sure, guess."),
            Layout::Intervals { .. } => ("several images, one after the other", " If you are not sure, guess."),
        };
        let asked = match self.dial() {
            Some(Dial { parameter: Some(_), .. }) => "Each time, do this:",
            _ => "Each time, answer this question:",
        };
        let none = if self.catches().is_some() { " In some images, there is none." } else { "" };
        let band = if is_picture { " " } else { BAND };
        format!(
            "You will see {seen}.{band}{asked} {question}{none}{guess}\n\nIn between, the screen shows one even color while your eyes recover."
        )
    }

    /// Returns whether this is the rating that a definition without a task asks for.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
