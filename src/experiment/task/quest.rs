//! QUEST+ (Watson 2017, J. Vis. 17(3):10): every trial has the level whose answer is expected to leave the least
//! uncertainty about the parameters of the psychometric function.

use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, de::Error as _};

use super::{
    curve::{Common, Curve, Psychometric, entropy},
    kind::Pick,
    options::{OptionValue, options},
};
use crate::experiment::faults::DefinitionErrors;

/// Maximum number of pairs of levels and parameters.
const MAX_CELLS: usize = 10_000_000;
/// The share of the posterior between the ends of the interval whose width ends a run.
const SHARE: f64 = 0.95;
/// Levels whose expected entropies, in nats, differ by less are equal, and the first is taken. Rounding differs between
/// machines, and must not decide.
const EQUAL: f64 = 1e-12;

options! {
    /// QUEST+ as a definition says it. Parameters are on the scale of the levels; for a logarithmic one, a threshold is the
    /// base-10 logarithm of a level.
    QuestPlus {
        levels: Vec<f64> = Vec::new(), "Levels", OptionValue::Numbers(""), "The levels to choose from.";
        function: Curve = Curve::Weibull, "Function", OptionValue::OneOf(Curve::NAMES), "The shape of the psychometric function.";
        #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "filled")]
        threshold: Vec<f64> = Vec::new(), "Thresholds", OptionValue::Numbers("the levels"), "Possible thresholds, as levels; by default the levels.";
        #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "filled")]
        slope: Vec<f64> = Vec::new(), "Slopes", OptionValue::Numbers("seven, from shallow to steep"), "Possible slopes; by default seven from shallow to steep.";
        #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "filled")]
        guess: Vec<f64> = Vec::new(), "Guess rates", OptionValue::Numbers("that of the task"), "Possible guess rates; by default that of the task.";
        #[serde(deserialize_with = "filled")]
        lapse: Vec<f64> = vec![0.0, 0.02, 0.04, 0.06], "Lapse rates", OptionValue::Numbers(""), "Possible lapse rates.";
        #[serde(skip_serializing_if = "Option::is_none")]
        stop_width: Option<f64> = None, "Stops at a width of", OptionValue::Optional("never"), "It stops when the 95 % interval of the threshold is this narrow, on the scale of the levels.";
    }
    /// A second parameter, on which the threshold depends.
    second: Option<Second> = None, [
        "second.parameter", "Second parameter", OptionValue::Parameter(true), "A second parameter, on which the threshold depends.";
        "second.levels", "Its levels", OptionValue::Numbers(""), "The levels of the second parameter.";
        "second.gradient", "Its gradients", OptionValue::Numbers(""), "Possible changes of the threshold for each unit of the second parameter, both in base-10 logarithms if steps are ratios.";
    ]
}

/// A second parameter of the stimulus. The threshold is t + g·(y − y₀), where y is its level, y₀ the middle of its levels
/// (both in logarithms if the first parameter is) and g the gradient.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Second {
    /// The parameter of the stimulus.
    pub parameter: String,
    /// Its levels.
    pub levels: Vec<f64>,
    /// Possible gradients.
    pub gradient: Vec<f64>,
}

/// Reads a list that has a default if it is missing; an empty one says nothing.
fn filled<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    let list = Vec::deserialize(deserializer)?;
    if list.is_empty() { Err(D::Error::custom("the list is empty; expected at least one value")) } else { Ok(list) }
}

/// The default slopes of the Weibull function, per base-10 logarithm.
const SLOPES: [f64; 7] = [1.0, 1.5, 2.2, 3.2, 4.6, 6.8, 10.0];
/// The default guess rates of a task in which they depend on the participant.
const GUESSES: [f64; 5] = [0.01, 0.05, 0.1, 0.2, 0.3];

impl QuestPlus {
    /// Adds every error.
    pub(super) fn check(&self, common: &Common, guess: Option<f64>, errors: &mut DefinitionErrors) {
        if self.levels.len() < 2 {
            errors
                .add("adaptive.levels", format!("the number of levels is {}; expected at least 2", self.levels.len()));
        }
        if self.function == Curve::Weibull && !common.log {
            let message = "a Weibull function uses logarithms of the level; expected log = true, logistic or normal";
            errors.add("adaptive.function", message);
        }
        let gradients = self.second.as_ref().map_or(&[][..], |second| &second.gradient);
        for (key, values, least, most) in [
            ("guess", &self.guess[..], 0.0, 0.99),
            ("lapse", &self.lapse, 0.0, 0.5),
            ("slope", &self.slope, 1e-6, 1e6),
            ("threshold", &self.threshold, if common.log { 1e-12 } else { -1e12 }, 1e12),
            ("second.gradient", gradients, -1e6, 1e6),
        ] {
            for (i, value) in values.iter().enumerate() {
                let path = format!("adaptive.{key}.{i}");
                errors.check_range(&path, *value, least, most, "a number in this range");
                if values[..i].contains(value) {
                    errors.add(path, format!("{value} appears twice; expected each value once"));
                }
            }
        }
        if let (Some(of_task), false) = (guess, self.guess.is_empty()) {
            let message = format!("a guess is right with probability {of_task} in this task; expected no guess rates");
            errors.add("adaptive.guess", message);
        }
        let most = |rates: &[f64]| rates.iter().copied().fold(0.0, f64::max);
        let (guesses, lapses) = (guess.unwrap_or_else(|| most(&self.guess)), most(&self.lapse));
        if guesses + lapses >= 1.0 {
            let is = format!("a guess rate of {guesses} and a lapse rate of {lapses} leave nothing to see");
            errors.add("adaptive.lapse", is + "; expected a sum below 1");
        }
        let [low, high] = [f64::min, f64::max].map(|end| self.levels.iter().copied().fold(f64::NAN, end));
        if !self.threshold.is_empty() && !self.threshold.iter().any(|one| (low..=high).contains(one)) {
            let message = format!("no threshold lies within the levels; expected values from {low} to {high}");
            errors.add("adaptive.threshold", message);
        }
        if let Some(width) = self.stop_width {
            errors.check_range("adaptive.stop_width", width, 1e-6, 1e6, "the width of an interval");
            let thresholds = self.grid(common, guess).thresholds;
            let before = central(thresholds.iter().map(|threshold| (*threshold, 1.0 / thresholds.len() as f64)));
            if width >= before {
                let unit = if common.log { " (base-10 logarithms)" } else { "" };
                let message = format!(
                    "stop_width {width} is reached before the first trial; expected less than {before:.3}{unit}, the width of the \
                     interval of the possible thresholds"
                );
                errors.add("adaptive.stop_width", message);
            }
        }
        if let Some(second) = &self.second
            && (second.levels.len() < 2 || second.gradient.is_empty())
        {
            errors.add("adaptive.second", "second has too few values; expected at least two levels and one gradient");
        }
        let second = self.second.as_ref().map_or(1, |second| second.levels.len());
        let cells = self.grid(common, guess).len().saturating_mul(self.levels.len()).saturating_mul(second);
        if cells > MAX_CELLS {
            let message = format!("the levels and parameters make {cells} cells; expected at most {MAX_CELLS}");
            errors.add("adaptive.levels", message);
        }
    }

    /// Returns the levels on the scale of the method, with the distances of those of the second parameter from their middle.
    fn stimuli(&self, common: &Common) -> Vec<(f64, f64)> {
        let seconds = self.second.iter().flat_map(|second| &second.levels).map(|y| common.scaled(*y));
        let [low, high] = [f64::min, f64::max].map(|end| seconds.clone().fold(f64::NAN, end));
        let stimulus = |pick| match pick {
            Pick::Level(x, y) => (common.scaled(x), y.map_or(0.0, |y| common.scaled(y) - (low + high) / 2.0)),
            _ => (f64::NAN, 0.0),
        };
        picks(&self.levels, self.second.as_ref()).into_iter().map(stimulus).collect()
    }

    fn grid(&self, common: &Common, guess: Option<f64>) -> Grid {
        let or = |given: &[f64], default: &[f64]| if given.is_empty() { default } else { given }.to_vec();
        let thresholds = or(&self.threshold, &self.levels).into_iter().map(|level| common.scaled(level)).collect();
        let span = common.scaled(self.levels.iter().copied().fold(f64::NAN, f64::max))
            - common.scaled(self.levels.iter().copied().fold(f64::NAN, f64::min));
        // The same steepness at the threshold; on a linear scale, over the levels instead of over two decades.
        let unit = match self.function {
            Curve::Weibull => 1.0,
            Curve::Logistic => 3.39,
            Curve::Normal => 2.12,
        } * if common.log { 1.0 } else { 2.0 / span };
        Grid {
            thresholds,
            slopes: or(&self.slope, &SLOPES.map(|slope| slope * unit)),
            guesses: or(&self.guess, guess.as_ref().map_or(&GUESSES, std::slice::from_ref)),
            lapses: self.lapse.clone(),
            gradients: self.second.as_ref().map_or_else(|| vec![0.0], |second| second.gradient.clone()),
        }
    }

    /// Prepares a run.
    pub fn prepare(&self, common: &Common, guess: Option<f64>) -> Quest {
        let grid = self.grid(common, guess);
        Quest::new(self.function, common.sign(), &self.stimuli(common), grid)
    }
}

/// Returns what a trial can show at these levels: each with each of a second parameter.
pub(super) fn picks(levels: &[f64], second: Option<&Second>) -> Vec<Pick> {
    let of_second = |second: &Second| second.levels.iter().copied().map(Some).collect();
    let seconds: Vec<Option<f64>> = second.map_or_else(|| vec![None], of_second);
    levels.iter().flat_map(|x| seconds.iter().map(|y| Pick::Level(*x, *y))).collect()
}

/// The possible values of each parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Thresholds t.
    pub thresholds: Vec<f64>,
    /// Slopes β.
    pub slopes: Vec<f64>,
    /// Guess rates γ.
    pub guesses: Vec<f64>,
    /// Lapse rates λ.
    pub lapses: Vec<f64>,
    /// Gradients of the threshold over the second parameter; a single 0 if there is none.
    pub gradients: Vec<f64>,
}

impl Grid {
    fn len(&self) -> usize {
        self.axes().iter().fold(1, |product: usize, values| product.saturating_mul(values.len()))
    }

    /// Returns the values of each parameter, beginning with the one that varies fastest.
    fn axes(&self) -> [&[f64]; 5] {
        [&self.lapses, &self.guesses, &self.slopes, &self.thresholds, &self.gradients]
    }

    /// Returns every combination, with its gradient.
    fn cells(&self) -> impl Iterator<Item = (Psychometric, f64)> {
        (0..self.len()).map(|mut rest| {
            let [lapse, guess, slope, threshold, gradient] = self.axes().map(|values| {
                let place = rest % values.len();
                rest /= values.len();
                values[place]
            });
            (Psychometric { threshold, slope, guess, lapse }, gradient)
        })
    }
}

/// What does not change during a run.
#[derive(Debug, PartialEq)]
struct Tables {
    cells: Vec<(Psychometric, f64)>,
    /// For each stimulus and cell, the probability of the outcome.
    likelihood: Vec<Vec<f64>>,
    /// For each stimulus and cell, the entropy of the outcome, nats.
    entropy: Vec<Vec<f64>>,
}

/// A run of QUEST+ at some trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Quest {
    tables: Arc<Tables>,
    posterior: Vec<f64>,
    /// The width of the 95 % interval of the threshold, as far apart as the grid tells.
    pub width: f64,
}

impl Quest {
    /// Begins with equal probabilities. `sign` is −1 if higher levels are harder. A stimulus is its level and how far the
    /// second parameter is from its middle.
    pub fn new(curve: Curve, sign: f64, stimuli: &[(f64, f64)], grid: Grid) -> Self {
        let cells: Vec<_> = grid.cells().collect();
        let likelihood_at = |&(x, y): &(f64, f64)| {
            let seen = |(one, gradient): &(Psychometric, f64)| {
                let threshold = one.threshold + gradient * y;
                curve.probability(x, &Psychometric { threshold, slope: one.slope * sign, ..*one })
            };
            cells.iter().map(seen).collect()
        };
        let likelihood: Vec<Vec<f64>> = stimuli.iter().map(likelihood_at).collect();
        let entropy_of = |row: &Vec<f64>| row.iter().map(|p| entropy(*p)).collect();
        let entropy = likelihood.iter().map(entropy_of).collect();
        let posterior = vec![1.0 / cells.len() as f64; cells.len()];
        let mut quest = Self { tables: Arc::new(Tables { cells, likelihood, entropy }), posterior, width: 0.0 };
        quest.width = quest.interval();
        quest
    }

    /// Returns the number of the stimulus whose outcome is expected to leave the least entropy. It is that of the
    /// posterior, plus the expected entropy of the outcome given the parameters, minus the entropy of the outcome.
    pub fn choose(&self) -> usize {
        let expected = |(likelihood, entropies): (&Vec<f64>, &Vec<f64>)| {
            let (mut seen, mut inner) = (0.0, 0.0);
            for ((p, l), h) in self.posterior.iter().zip(likelihood).zip(entropies) {
                seen += p * l;
                inner += p * h;
            }
            inner - entropy(seen)
        };
        let all: Vec<f64> = self.tables.likelihood.iter().zip(&self.tables.entropy).map(expected).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        all.iter().position(|entropy| *entropy <= least + EQUAL).unwrap_or(0)
    }

    /// Learns from the outcome at a stimulus or, without one, of a catch trial, whose probability is the guess rate.
    pub fn learn(&mut self, stimulus: Option<usize>, seen: bool) {
        let tables = Arc::clone(&self.tables);
        match stimulus {
            Some(stimulus) => self.update(seen, tables.likelihood[stimulus].iter().copied()),
            None => self.update(seen, tables.cells.iter().map(|(one, _)| one.guess)),
        }
    }

    fn update(&mut self, seen: bool, likelihood: impl Iterator<Item = f64>) {
        let updated = self.posterior.iter().zip(likelihood).map(|(p, l)| p * if seen { l } else { 1.0 - l });
        let updated: Vec<f64> = updated.collect();
        let sum: f64 = updated.iter().sum();
        // An outcome that no parameters allow teaches nothing.
        if sum > 0.0 {
            self.posterior = updated.into_iter().map(|p| p / sum).collect();
            self.width = self.interval();
        }
    }

    /// Returns the mean of a function of the parameters.
    pub fn mean(&self, of: impl Fn(&Psychometric) -> f64) -> f64 {
        self.posterior.iter().zip(&self.tables.cells).map(|(p, (one, _))| p * of(one)).sum()
    }

    fn interval(&self) -> f64 {
        central(self.tables.cells.iter().zip(&self.posterior).map(|((one, _), p)| (one.threshold, *p)))
    }
}

/// Returns the width of the central interval of thresholds with these probabilities.
fn central(thresholds: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut marginal: Vec<(f64, f64)> = thresholds.collect();
    marginal.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = |share: f64| {
        let mut sum = 0.0;
        marginal.iter().find(|(_, p)| {
            sum += p;
            sum >= share
        })
    };
    let ends = [at((1.0 - SHARE) / 2.0), at((1.0 + SHARE) / 2.0)];
    if let [Some(low), Some(high)] = ends { high.0 - low.0 } else { f64::INFINITY }
}
