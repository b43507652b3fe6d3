//! A rating of one stimulus: the categories of the definition, or a continuous scale.

use super::{
    kind::{Answer, Dial, Given, Kind, Presentation, Senses, Turn},
    options::{OptionValue, options},
};
use crate::{
    experiment::{faults::DefinitionErrors, scale::ResponseScale},
    text::names::named,
};

named! {
    /// What a rating is chosen from.
    Scale, ScaleError {
        /// The categories of the definition.
        Categories = "categories",
        /// A slider from 0 to 100, whose ends have the definition's labels: the visual analog scale.
        Slider = "slider",
    }
}

options! {
    /// A rating of one stimulus.
    Rating {
        scale: Scale = Scale::Categories, "Scale", OptionValue::OneOf(Scale::NAMES), "Categories, or a slider from 0 to 100 whose ends have labels.";
    }
}

/// Lowest and highest value of the slider.
const RANGE: [f64; 2] = [0.0, 100.0];

impl Kind for Rating {
    fn scale(&self) -> ResponseScale {
        match self.scale {
            Scale::Categories => ResponseScale::default(),
            Scale::Slider => {
                let ends = ["Not visible", "Very clearly visible"];
                ResponseScale::new("How visible is the brighter band?", &ends, '1'..)
            }
        }
    }

    fn check(&self, _: &Given<'_>, _: &mut DefinitionErrors) {}

    fn dial(&self) -> Option<Dial> {
        let dial = Dial { parameter: None, range: RANGE, step: 1.0, log: false };
        (self.scale == Scale::Slider).then_some(dial)
    }

    fn answers(&self) -> Option<usize> {
        (self.scale == Scale::Slider).then_some(2)
    }

    fn present(&self, turn: &Turn<'_>) -> Presentation {
        Presentation::of(turn.target())
    }

    fn response(&self, answer: &Answer) -> String {
        match answer {
            Answer::Key(rating) => rating.to_string(),
            Answer::Value(value) => value.to_string(),
        }
    }

    /// The observer's criterion is in the middle of the slider.
    fn answer(&self, shown: &Presentation, senses: Senses<'_>) -> Answer {
        let Senses { noisy, criterion, .. } = senses;
        let seen = noisy(&shown.stimuli[0]) - criterion;
        Answer::Value((RANGE[1] / (1.0 + (-seen).exp())).round())
    }
}
