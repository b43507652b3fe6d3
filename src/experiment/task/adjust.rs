//! Adjustment: participants change one parameter until a criterion holds.

use super::{
    kind::{Answer, Dial, Given, Kind, Presentation, Senses, Turn, at_level},
    options::{OptionValue, options},
};
use crate::{
    experiment::{faults::DefinitionErrors, scale::ResponseScale},
    stimulus::is_direction,
};

/// The share of the range, at either end, in which an adjustment begins.
const START: f64 = 0.3;
/// Directions that span this or more, degrees, have no mean.
const HALF_TURN: f64 = 180.0;
/// Number of steps between the values that a simulated observer tries.
const TRIED: u32 = 40;

options! {
    /// Adjustment of a parameter, beginning equally often at low and at high values.
    Adjust {
        parameter: String = String::new(), "Parameter", OptionValue::Parameter(false), "The parameter that participants change.";
        low: f64 = 0.0, "Lowest value", OptionValue::Number, "The lowest value that can be set.";
        high: f64 = 1.0, "Highest value", OptionValue::Number, "The highest value that can be set.";
        step: f64 = 0.02, "Step", OptionValue::Number, "How far one key press goes: added or, on a logarithmic scale, multiplied by 10 to this power. Shift makes it ten times finer.";
        log: bool = false, "Steps are ratios", OptionValue::Flag, "Steps are equal ratios instead of equal differences.";
    }
}

impl Adjust {
    fn own_dial(&self) -> Dial {
        let Self { ref parameter, low, high, step, log } = *self;
        Dial { parameter: Some(parameter.clone()), range: [low, high], step, log }
    }
}

impl Kind for Adjust {
    fn scale(&self) -> ResponseScale {
        ResponseScale::new("Change the image until the brighter band is just visible.", &[], [])
    }

    fn check(&self, given: &Given<'_>, errors: &mut DefinitionErrors) {
        let Self { parameter, low, high, step, log } = self;
        if !given.check_parameter("task.parameter", parameter, errors) {
            return;
        }
        given.check_span("task", (parameter, *log), [*low, *high], [("task.step".to_owned(), *step)], errors);
        if high - low >= HALF_TURN && is_direction(parameter) {
            let message = format!(
                "{parameter} from {low} to {high} goes around half a turn or more, where settings have no mean; expected less than {HALF_TURN}°"
            );
            errors.add("task.high", message);
        }
    }

    fn dial(&self) -> Option<Dial> {
        Some(self.own_dial())
    }

    fn places(&self) -> u32 {
        2
    }

    fn present(&self, turn: &Turn<'_>) -> Presentation {
        let share = if turn.place == 0 { START * turn.draw } else { 1.0 - START * turn.draw };
        let start = self.own_dial().at(share);
        Presentation { start: Some(start), ..Presentation::of(at_level(turn.target(), &self.parameter, start)) }
    }

    /// The observer sets the value nearest to the start at which what they see crosses the criterion; if it never does, they
    /// set where it comes closest.
    fn answer(&self, shown: &Presentation, senses: Senses<'_>) -> Answer {
        let (dial, start) = (self.own_dial(), shown.start.unwrap_or_default());
        let Senses { noisy, mean, criterion } = senses;
        // The noise of one look moves the criterion of this trial; less than nothing cannot be seen.
        let criterion = (criterion + noisy(&shown.stimuli[0]) - mean(&shown.stimuli[0])).max(0.0);
        // The same values in every trial, so that an observer may remember what it saw.
        let tried: Vec<(f64, f64)> = (0..=TRIED)
            .map(|i| f64::from(i) / f64::from(TRIED))
            .map(|share| {
                (share, mean(&at_level(shown.stimuli[0].clone(), &self.parameter, dial.at(share))) - criterion)
            })
            .collect();
        let crossings = tried.windows(2).filter(|pair| (pair[0].1 > 0.0) != (pair[1].1 > 0.0)).map(|pair| {
            let [(from, over), (to, under)] = [pair[0], pair[1]];
            from + (to - from) * over / (over - under)
        });
        let distance = |share: &f64| (share - dial.share(start)).abs();
        let found = crossings.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let closest = || tried.iter().min_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map(|(share, _)| *share);
        Answer::Value(dial.at(found.or_else(closest).unwrap_or_default()))
    }
}
