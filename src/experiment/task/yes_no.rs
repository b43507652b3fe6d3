//! Yes or no: participants say whether they see the target; catch trials show the reference.

use super::{
    kind::{Answer, Given, Kind, Presentation, Senses, Settings, Turn},
    options::{OptionValue, options},
};
use crate::experiment::{faults::DefinitionErrors, scale::ResponseScale};

/// Number of trials of a condition over which catch trials are balanced, so that an adaptive method that stops early has had
/// about their share.
const CYCLE: usize = 10;

options! {
    /// Yes or no.
    YesNo {
        reference: Settings = Settings::default(), "Reference", OptionValue::Settings, "The parameters in which the stimulus of a catch trial differs from the target.";
        catch: f64 = 0.25, "Catch trials, proportion", OptionValue::Number, "The proportion of trials that show the reference: 0.05 to 0.95.";
        feedback: bool = false, "Feedback", OptionValue::Flag, "A mark after each answer says whether it was right.";
    }
}

impl Kind for YesNo {
    fn scale(&self) -> ResponseScale {
        ResponseScale::new("Do you see a brighter band?", &["No", "Yes"], ['n', 'y'])
    }

    fn check(&self, given: &Given<'_>, errors: &mut DefinitionErrors) {
        errors.check_range("task.catch", self.catch, 0.05, 0.95, "the proportion of trials that show the reference");
        given.check_reference(&self.reference, errors);
    }

    fn reference(&self) -> Option<&Settings> {
        Some(&self.reference)
    }

    fn places(&self) -> u32 {
        2
    }

    fn round(&self, done: usize, all: usize) -> Vec<u32> {
        // If possible, there is at least one catch trial and one target.
        let least = usize::from(all > 1);
        let catches = ((self.catch * all as f64).round() as usize).clamp(least, all - least);
        let catches_in = |trials: usize| (2 * catches * trials + all) / (2 * all);
        let end = all.min(done + CYCLE);
        let catch = catches_in(end) - catches_in(done);
        (done..end).map(|trial| u32::from(trial - done >= catch)).collect()
    }

    fn present(&self, turn: &Turn<'_>) -> Presentation {
        let [target, reference] = turn.compared(&self.reference);
        turn.shows(vec![if turn.place == 0 { reference } else { target }], turn.place)
    }

    fn outcome(&self, _: &Presentation, answer: &Answer) -> bool {
        *answer == Answer::Key(1)
    }

    fn catches(&self) -> Option<f64> {
        Some(self.catch)
    }

    fn feedback(&self) -> bool {
        self.feedback
    }

    fn response(&self, answer: &Answer) -> String {
        if *answer == Answer::Key(1) { "yes" } else { "no" }.to_owned()
    }

    fn answer(&self, shown: &Presentation, senses: Senses<'_>) -> Answer {
        let Senses { noisy, criterion, .. } = senses;
        Answer::Key(u8::from(noisy(&shown.stimuli[0]) > criterion))
    }
}
