//! Adaptive methods: what a definition says about one, and its state in one condition, or that of the comparisons of a
//! session.

use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::{
    curve::Common,
    kind::{Given, Kind, Pick},
    options::{OptionValue, TaskOption, kinds, options},
    quest::{Quest, QuestPlus, Second, picks},
    scaling::Ranking,
    staircase::{Staircase, Stairs},
};
use crate::{experiment::faults::DefinitionErrors, statistics::shuffle, stimulus::Stimulus};

options! {
    /// The method of constant stimuli: every level occurs equally often, in random order.
    Constant {
        levels: Vec<f64> = Vec::new(), "Levels", OptionValue::Numbers(""), "The levels; each occurs equally often.";
    }
}

kinds! {
    /// How levels are chosen.
    Method, "method" {
        /// Up after wrong answers, down after right ones.
        Staircase(Staircase) = "staircase",
        /// The level whose answer is expected to tell most.
        QuestPlus(QuestPlus) = "quest-plus",
        /// Every level equally often.
        Constant(Constant) = "constant",
    }
}

impl Default for Method {
    fn default() -> Self {
        Self::Constant(Constant::default())
    }
}

/// A method that chooses the levels of a parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Adaptive {
    /// What every method says.
    #[serde(flatten)]
    pub common: Common,
    /// The method with its own options.
    #[serde(flatten)]
    pub method: Method,
}

impl Adaptive {
    /// Returns the options of a method, with those of every method first.
    pub fn options(method: &str) -> Vec<TaskOption> {
        [Common::OPTIONS, Method::options(method)].concat()
    }

    /// Returns the lowest and the highest level.
    pub fn range(&self) -> [f64; 2] {
        match &self.method {
            Method::Staircase(stairs) => [stairs.low, stairs.high],
            _ => [f64::min, f64::max].map(|end| self.levels().iter().copied().fold(f64::NAN, end)),
        }
    }

    /// Returns whether the method can choose a level.
    pub fn can_show(&self, level: f64) -> bool {
        let [low, high] = self.range();
        let levels = self.levels();
        if levels.is_empty() { (low..=high).contains(&level) } else { levels.contains(&level) }
    }

    /// Returns the parameters that the method varies.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        [self.common.parameter.as_str()].into_iter().chain(self.second().map(|second| second.parameter.as_str()))
    }

    /// Returns what a trial can show at these levels.
    pub(in crate::experiment) fn picks(&self, levels: &[f64]) -> Vec<Pick> {
        picks(levels, self.second())
    }

    /// Returns the parameters with the levels that were chosen.
    pub(in crate::experiment) fn named(&self, pick: Pick) -> Vec<(&str, f64)> {
        let Pick::Level(level, second) = pick else { return Vec::new() };
        self.parameters().zip([level].into_iter().chain(second)).collect()
    }

    /// Returns the second parameter that the method varies.
    pub fn second(&self) -> Option<&Second> {
        if let Method::QuestPlus(quest) = &self.method { quest.second.as_ref() } else { None }
    }

    /// Returns the levels from which the method chooses; none if it finds its own.
    pub(in crate::experiment) fn levels(&self) -> &[f64] {
        match &self.method {
            Method::Staircase(_) => &[],
            Method::QuestPlus(quest) => &quest.levels,
            Method::Constant(constant) => &constant.levels,
        }
    }

    /// Adds every error.
    pub fn check(&self, given: &Given<'_>, task: &dyn Kind, errors: &mut DefinitionErrors) {
        given.check_parameter("adaptive.parameter", &self.common.parameter, errors);
        match self.second() {
            Some(Second { parameter, .. }) if *parameter == self.common.parameter => {
                let message = format!("{parameter} is varied already; expected another parameter");
                errors.add("adaptive.second.parameter", message);
            }
            Some(second) => _ = given.check_parameter("adaptive.second.parameter", &second.parameter, errors),
            None => {}
        }
        errors.check_range("adaptive.trials", self.common.trials.into(), 1.0, 10_000.0, "the trials of a condition");
        match &self.method {
            Method::Staircase(stairs) => stairs.check(&self.common, given, errors),
            Method::QuestPlus(quest) => quest.check(&self.common, task.guess(), errors),
            Method::Constant(constant) => self.check_constant(&constant.levels, errors),
        }
        self.check_levels("adaptive.levels", &self.common.parameter, self.levels(), given.stimulus, errors);
        if let Some(Second { parameter, levels, .. }) = self.second() {
            self.check_levels("adaptive.second.levels", parameter, levels, given.stimulus, errors);
        }
    }

    fn check_constant(&self, levels: &[f64], errors: &mut DefinitionErrors) {
        let (trials, count) = (self.common.trials, levels.len() as u32);
        if count < 2 {
            errors.add("adaptive.levels", format!("the number of levels is {count}; expected at least 2"));
        } else if !trials.is_multiple_of(count) {
            let message =
                format!("trials {trials} is not a multiple of the {count} levels; expected each level equally often");
            errors.add("adaptive.trials", message);
        }
    }

    /// Adds an error for each level that appears twice, that is not positive on a logarithmic scale, or that the stimulus
    /// cannot have.
    fn check_levels(&self, path: &str, name: &str, levels: &[f64], stimulus: &Stimulus, errors: &mut DefinitionErrors) {
        let is_known = stimulus.get(name).is_some();
        for (i, level) in levels.iter().enumerate().filter(|(_, level)| is_known && !level.is_nan()) {
            let message = match stimulus.clone().set(name, &(*level).into()) {
                Err(error) => error.to_string(),
                Ok(()) if self.common.log && *level <= 0.0 => {
                    format!("level {level} is not above 0; expected positive levels, or log = false")
                }
                Ok(()) if levels[..i].contains(level) => {
                    format!("level {level} appears twice; expected each level once")
                }
                Ok(()) => continue,
            };
            errors.add(format!("{path}.{i}"), message);
        }
    }
}

/// A method at some trial.
#[derive(Clone, Debug)]
pub enum Track {
    /// A staircase.
    Stairs(Stairs),
    /// QUEST+, with what the definition says about it.
    Quest(QuestPlus, Quest),
    /// The levels of constant stimuli in their order, and the number of those that are done.
    Levels(Vec<f64>, usize),
    /// Comparisons.
    Ranking(Ranking),
}

impl Track {
    /// Begins the method of each of `count` conditions, of which each has a generator of its own.
    pub fn begin(
        Adaptive { common, method }: &Adaptive,
        guess: Option<f64>,
        count: usize,
        generator: impl Fn(usize) -> ChaCha8Rng,
    ) -> Vec<Self> {
        match method {
            Method::Staircase(staircase) => vec![Self::Stairs(Stairs::new(staircase, common)); count],
            // All conditions share what was prepared.
            Method::QuestPlus(quest) => vec![Self::Quest(quest.clone(), quest.prepare(common, guess)); count],
            Method::Constant(constant) => {
                let rounds = common.trials as usize / constant.levels.len().max(1);
                // Shuffled round by round, so that catch trials, which take no level, leave every level about equally
                // often.
                let round = |rng: &mut ChaCha8Rng| {
                    let mut round = constant.levels.clone();
                    shuffle(&mut round, rng);
                    round
                };
                let levels = |mut rng| (0..rounds).flat_map(|_| round(&mut rng)).collect();
                (0..count).map(|condition| Self::Levels(levels(generator(condition)), 0)).collect()
            }
        }
    }

    /// Returns whether the method has learned enough.
    pub fn is_over(&self) -> bool {
        match self {
            Self::Stairs(stairs) => stairs.is_over(),
            Self::Quest(options, quest) => options.stop_width.is_some_and(|width| quest.width <= width),
            Self::Levels(levels, done) => *done >= levels.len(),
            Self::Ranking(_) => false,
        }
    }

    /// Returns what the next trial shows. `draw` is uniform in 0…1.
    pub fn pick(&self, draw: f64) -> Pick {
        match self {
            Self::Stairs(stairs) => Pick::Level(stairs.level, None),
            Self::Quest(options, quest) => picks(&options.levels, options.second.as_ref())[quest.choose()],
            Self::Levels(levels, done) => levels.get(*done).map_or(Pick::Planned, |level| Pick::Level(*level, None)),
            Self::Ranking(ranking) => Pick::Pair(ranking.choose(draw)),
        }
    }

    /// Learns the outcome of a trial. `is_catch` if it showed no target.
    pub fn learn(&mut self, pick: Pick, outcome: bool, is_catch: bool) {
        match (self, pick) {
            (Self::Quest(_, quest), _) if is_catch => quest.learn(None, outcome),
            (Self::Stairs(stairs), _) if !is_catch => stairs.answer(outcome),
            (Self::Quest(options, quest), _) => {
                let all = picks(&options.levels, options.second.as_ref());
                let place = all.iter().position(|other| *other == pick);
                place.into_iter().for_each(|place| quest.learn(Some(place), outcome));
            }
            (Self::Levels(_, done), _) if !is_catch => *done += 1,
            (Self::Ranking(ranking), Pick::Pair([left, right])) => {
                let [winner, loser] = if outcome { [left, right] } else { [right, left] };
                ranking.learn(winner, loser);
            }
            _ => {}
        }
    }
}
