//! Paired comparison: which of two stimuli has more of what the question asks about?

use super::{
    kind::{Given, Kind, Layout, Presentation, Settings, Turn},
    options::{OptionValue, options},
};
use crate::{
    experiment::{
        condition::{Condition, Factor},
        faults::DefinitionErrors,
        scale::ResponseScale,
    },
    stimulus::{Stimulus, picture::Picture},
    text::names::{expected_one_of, named},
};

named! {
    /// Which pairs of conditions are compared.
    Pairs, PairsError {
        /// Every condition with every other.
        All = "all",
        /// Neighboring levels of a factor, all else equal.
        Chain = "chain",
        /// Those whose comparison is expected to tell most.
        Adaptive = "adaptive",
    }
}

options! {
    /// Comparison of conditions with each other, or of a condition with a reference.
    Pair {
        pairs: Pairs = Pairs::All, "Pairs", OptionValue::OneOf(Pairs::NAMES), "All: every condition with every other. Chain: neighboring levels of a factor. Adaptive: the pair whose comparison is expected to be most informative.";
        #[serde(skip_serializing_if = "Option::is_none")]
        along: Option<String> = None, "Chain along", OptionValue::Factor, "The factor whose neighboring levels a chain compares.";
        #[serde(skip_serializing_if = "Option::is_none")]
        trials: Option<u32> = None, "Adaptive trials", OptionValue::Optional("60"), "The number of comparisons of adaptive pairs.";
        #[serde(skip_serializing_if = "is_empty")]
        reference: Settings = Settings::default(), "Reference", OptionValue::Settings, "With a method that chooses levels: the parameters in which the reference differs from the target.";
    }
}

fn is_empty(settings: &Settings) -> bool {
    settings.0.is_empty()
}

/// The number of comparisons of `adaptive` unless the definition says otherwise.
const TRIALS: u32 = 60;
/// Maximum number of conditions to compare, and of those whose comparisons follow from the answers.
const MAX_COMPARED: usize = 1000;
const MAX_RANKED: usize = 100;

impl Pair {
    fn with_reference(&self) -> bool {
        !is_empty(&self.reference)
    }

    /// Returns the position of the factor of `chain`.
    fn chained(&self, factors: &[Factor]) -> Option<usize> {
        match &self.along {
            Some(name) => factors.iter().position(|factor| factor.name == *name),
            None => (factors.len() == 1).then_some(0),
        }
    }
}

impl Kind for Pair {
    fn scale(&self) -> ResponseScale {
        ResponseScale::new("Which image has the more visible band?", &["Left", "Right"], '1'..)
    }

    fn check(&self, given: &Given<'_>, errors: &mut DefinitionErrors) {
        let with_levels = !given.adapted.is_empty();
        if self.trials.is_some() && (with_levels || self.pairs != Pairs::Adaptive) {
            let message = "trials applies to adaptive pairs only; expected design.repetitions, which repeats every pair, or adaptive.trials";
            errors.add("task.trials", message);
        }
        let is_chain = self.pairs == Pairs::Chain;
        if with_levels && self.pairs != Pairs::All {
            let message = "pairs applies to pairs of conditions only; expected none, because [adaptive] compares the target with the reference";
            errors.add("task.pairs", message);
        } else if self.along.is_some() && !is_chain {
            errors.add("task.along", "along applies to chains only; expected pairs = \"chain\", or no along");
        }
        if with_levels {
            given.check_reference(&self.reference, errors);
            return;
        }
        if self.with_reference() {
            let message = "task.reference needs a method that varies the target; expected [adaptive], or no reference";
            errors.add("task.reference", message);
        }
        let conditions = given.conditions;
        let most = if self.pairs == Pairs::Adaptive { MAX_RANKED } else { MAX_COMPARED };
        if conditions < 2 {
            errors.add("factors", "there is nothing to compare; expected factors with at least two conditions");
        } else if conditions > most {
            errors.add(
                "factors",
                format!("the number of conditions to compare is {conditions}; expected at most {most}"),
            );
        }
        if is_chain && self.chained(given.factors).is_none() {
            let names: Vec<&str> = given.factors.iter().map(|factor| factor.name.as_str()).collect();
            let message = match &self.along {
                Some(along) => format!("along {along:?} is not a factor; {}", expected_one_of(along, &names)),
                None => format!("along is missing; expected one of {}", names.join(", ")),
            };
            errors.add("task.along", message);
        }
        errors.check_range("task.trials", self.trials.unwrap_or(1).into(), 1.0, 10_000.0, "the number of comparisons");
    }

    fn layout(&self) -> Layout {
        Layout::Places(2)
    }

    fn reference(&self) -> Option<&Settings> {
        self.with_reference().then_some(&self.reference)
    }

    fn places(&self) -> u32 {
        2
    }

    fn pairs(&self, conditions: &[Condition], factors: &[Factor]) -> Option<Vec<[usize; 2]>> {
        if self.with_reference() {
            return None;
        }
        let all = (0..conditions.len()).flat_map(|i| (i + 1..conditions.len()).map(move |j| [i, j]));
        let chained = self.chained(factors).filter(|_| self.pairs == Pairs::Chain);
        let neighbors = |[i, j]: &[usize; 2]| {
            let mut levels = conditions[*i].levels.iter().zip(&conditions[*j].levels).enumerate();
            chained.is_none_or(|along| {
                levels.all(|(factor, (one, other))| {
                    // Each picture is itself a level of the factor that names the pictures.
                    let is_picture = matches!(conditions[*i].stimulus, Stimulus::Image(_))
                        && factors[factor].name == Picture::PICTURE;
                    is_picture && factor != along || one.abs_diff(*other) == usize::from(factor == along)
                })
            })
        };
        Some(all.filter(neighbors).collect())
    }

    fn ranking(&self) -> Option<u32> {
        (self.pairs == Pairs::Adaptive && !self.with_reference()).then(|| self.trials.unwrap_or(TRIALS))
    }

    fn present(&self, turn: &Turn<'_>) -> Presentation {
        let Some(other) = turn.other else {
            let mut stimuli = turn.compared(&self.reference).to_vec();
            stimuli.rotate_right(turn.place as usize);
            return turn.shows(stimuli, turn.place + 1);
        };
        let stimuli = vec![turn.target(), other.stimulus.clone()];
        Presentation { stimuli, ..Presentation::default() }
    }

    fn guess(&self) -> Option<f64> {
        Some(0.0)
    }
}
