//! Forced choice: one of two or four stimuli is the target, and participants say which.

use super::{
    kind::{Given, Kind, Layout, Presentation, Settings, Turn},
    options::{OptionValue, options},
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

options! {
    /// Forced choice between a target, which is the stimulus of the condition, and copies of a reference.
    Choice {
        alternatives: u32 = 2, "Alternatives", OptionValue::OneOf(&["2", "4"]), "Number of stimuli.";
        shown: Shown = Shown::Intervals, "Shown as", OptionValue::OneOf(Shown::NAMES), "Intervals: one after the other, at the same place. Places: at the same time, side by side.";
        duration_s: f64 = 0.5, "Each interval, s", OptionValue::Number, "How long each interval lasts.";
        gap_s: f64 = 0.4, "Gap, s", OptionValue::Number, "The uniform field between two intervals.";
        reference: Settings = Settings::default(), "Reference", OptionValue::Settings, "The parameters in which the other stimuli differ from the target.";
        feedback: bool = false, "Feedback", OptionValue::Flag, "A mark after each answer says whether it was right.";
    }
}

impl Kind for Choice {
    fn scale(&self) -> ResponseScale {
        let (question, labels) = match (self.shown, self.alternatives) {
            (Shown::Intervals, _) => ("Which image had the brighter band?", ["First", "Second", "Third", "Fourth"]),
            (Shown::Places, 4) => {
                ("Which image has the brighter band?", ["Top left", "Top right", "Bottom left", "Bottom right"])
            }
            (Shown::Places, _) => ("Which image has the brighter band?", ["Left", "Right", "", ""]),
        };
        let count = if self.alternatives == 4 { 4 } else { 2 };
        ResponseScale::new(question, &labels[..count], '1'..)
    }

    fn check(&self, given: &Given<'_>, errors: &mut DefinitionErrors) {
        if ![2, 4].contains(&self.alternatives) {
            errors.add("task.alternatives", format!("alternatives is {}; expected 2 or 4", self.alternatives));
        }
        errors.check_range("task.duration_s", self.duration_s, 0.001, 60.0, "seconds");
        errors.check_range("task.gap_s", self.gap_s, 0.001, 60.0, "seconds");
        let times = [("duration_s", self.duration_s, 0.5), ("gap_s", self.gap_s, 0.4)];
        for (key, ..) in times.iter().filter(|(_, own, default)| self.shown == Shown::Places && own != default) {
            let message = format!("{key} applies to intervals only; expected [presentation], or shown = \"intervals\"");
            errors.add(format!("task.{key}"), message);
        }
        given.check_reference(&self.reference, errors);
    }

    fn layout(&self) -> Layout {
        let count = self.alternatives as usize;
        match self.shown {
            Shown::Intervals => Layout::Intervals { count, duration_s: self.duration_s, gap_s: self.gap_s },
            Shown::Places => Layout::Places(count),
        }
    }

    fn reference(&self) -> Option<&Settings> {
        Some(&self.reference)
    }

    fn places(&self) -> u32 {
        self.alternatives
    }

    fn present(&self, turn: &Turn<'_>) -> Presentation {
        let [target, reference] = turn.compared(&self.reference);
        let mut stimuli = vec![reference; self.alternatives as usize];
        stimuli[turn.place as usize] = target;
        turn.shows(stimuli, turn.place + 1)
    }

    fn guess(&self) -> Option<f64> {
        Some(1.0 / f64::from(self.alternatives))
    }

    fn feedback(&self) -> bool {
        self.feedback
    }
}
