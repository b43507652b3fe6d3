//! Forced choice: one of two or four stimuli is the target, and participants say which.

use serde::{Deserialize, Serialize};

use super::{
    kind::{Answer, Given, Kind, Layout, Measures, Presentation, Senses, Settings, Turn, strongest},
    options::{OptionValue, TaskOption},
};
use crate::{
    experiment::{faults::DefinitionErrors, scale::ResponseScale},
    text::names::named,
};

named! {
    /// How the alternatives are shown.
    Shown, ShownError {
        /// One after the other, at the same place.
        Intervals = "intervals",
        /// At the same time, side by side.
        Places = "places",
    }
}

/// Forced choice between a target, which is the stimulus of the condition, and copies of a reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Choice {
    /// Number of stimuli, 2 or 4.
    pub alternatives: u32,
    /// How they are shown.
    pub shown: Shown,
    /// How long each interval lasts, seconds, 0.001…60.
    pub duration_s: f64,
    /// The uniform field between two intervals, seconds, 0.001…60.
    pub gap_s: f64,
    /// The parameters in which the reference differs from the target.
    pub reference: Settings,
    /// Whether participants are told if they were right.
    pub feedback: bool,
}

impl Default for Choice {
    fn default() -> Self {
        Self {
            alternatives: 2,
            shown: Shown::Intervals,
            duration_s: 0.5,
            gap_s: 0.4,
            reference: Settings::default(),
            feedback: false,
        }
    }
}

impl Choice {
    /// The options, as a form lists them.
    pub const OPTIONS: &[TaskOption] = &[
        TaskOption::new("alternatives", "Alternatives", OptionValue::OneOf(&["2", "4"]), "Number of stimuli."),
        TaskOption::new(
            "shown",
            "Shown as",
            OptionValue::OneOf(Shown::NAMES),
            "Intervals: one after the other, at the same place. Places: at the same time, side by side.",
        ),
        TaskOption::new("duration_s", "Each interval, s", OptionValue::Number, "How long each interval lasts."),
        TaskOption::new("gap_s", "Gap, s", OptionValue::Number, "The uniform field between two intervals."),
        TaskOption::new(
            "reference",
            "Reference",
            OptionValue::Settings,
            "The parameters in which the other stimuli differ from the target.",
        ),
        TaskOption::new(
            "feedback",
            "Feedback",
            OptionValue::Flag,
            "A mark after each answer says whether it was right.",
        ),
    ];
}

impl Kind for Choice {
    fn scale(&self) -> ResponseScale {
        let (question, labels): (_, &[&str]) = match (self.shown, self.alternatives) {
            (Shown::Intervals, 4) => ("Which image had the brighter band?", &["First", "Second", "Third", "Fourth"]),
            (Shown::Intervals, _) => ("Which image had the brighter band?", &["First", "Second"]),
            (Shown::Places, 4) => {
                ("Which image has the brighter band?", &["Top left", "Top right", "Bottom left", "Bottom right"])
            }
            (Shown::Places, _) => ("Which image has the brighter band?", &["Left", "Right"]),
        };
        ResponseScale::numbered(question, labels)
    }

    fn instructions(&self) -> String {
        let count = if self.alternatives == 4 { "four" } else { "two" };
        let shown = match self.shown {
            Shown::Intervals => format!("You will see {count} images, one after the other."),
            Shown::Places => format!("You will see {count} images at the same time."),
        };
        format!(
            "{shown} Each has a dark and a bright area with a transition between them. In one of them, a line or band that is brighter still may stand out where the transition meets the bright area.\n\nAfter the images, say which one it was. If you are not sure, guess.\n\nBetween trials, the screen shows one even color while your eyes recover."
        )
    }

    fn check(&self, given: &Given<'_>, errors: &mut DefinitionErrors) {
        if ![2, 4].contains(&self.alternatives) {
            errors.add("task.alternatives", format!("alternatives is {}; expected 2 or 4", self.alternatives));
        }
        errors.check_range("task.duration_s", self.duration_s, 0.001, 60.0, "seconds");
        errors.check_range("task.gap_s", self.gap_s, 0.001, 60.0, "seconds");
        given.check_reference(&self.reference, errors);
    }

    fn layout(&self) -> Layout {
        let count = self.alternatives as usize;
        match self.shown {
            Shown::Intervals => Layout::Intervals { count, duration_s: self.duration_s, gap_s: self.gap_s },
            Shown::Places => Layout::Places(count),
        }
    }

    fn places(&self) -> Vec<u32> {
        (0..self.alternatives).collect()
    }

    fn present(&self, turn: &Turn<'_>) -> Presentation {
        let target = turn.target();
        let reference = self.reference.apply(&target).unwrap_or_else(|_| target.clone());
        let mut stimuli = vec![reference; self.alternatives as usize];
        stimuli[turn.place as usize] = target;
        let level = turn.level.map(|(_, level)| level);
        Presentation { stimuli, target: Some(turn.place + 1), level, start: None }
    }

    fn judge(&self, shown: &Presentation, answer: &Answer) -> Option<bool> {
        let Answer::Key(key) = answer else { return None };
        Some(shown.target == Some(u32::from(*key) + 1))
    }

    fn guess(&self) -> Option<f64> {
        Some(1.0 / f64::from(self.alternatives))
    }

    fn feedback(&self) -> bool {
        self.feedback
    }

    fn answer(&self, shown: &Presentation, senses: Senses<'_>) -> Answer {
        strongest(shown, senses)
    }

    fn measures(&self) -> Measures {
        Measures::Proportions
    }
}
