//! The state of an adaptive method in one condition, or of the comparisons of a session.

use rand_chacha::ChaCha8Rng;

use super::{
    adaptive::{Adaptive, Method},
    quest::Quest,
    ranking::Ranking,
    staircase::{Staircase, Stairs},
};
use crate::statistics::shuffle;

/// What a method chose for a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pick {
    /// What the schedule plans.
    Planned,
    /// A level of the adapted parameter, and one of the second.
    Level(f64, Option<f64>),
    /// A pair of conditions.
    Pair([usize; 2]),
}

/// A method at some trial.
#[derive(Clone, Debug)]
pub enum Track {
    /// The schedule plans everything.
    Planned,
    /// A staircase.
    Stairs(Staircase, Stairs),
    /// QUEST+, and whether it learned enough.
    Quest {
        /// The run.
        quest: Quest,
        /// The width of the threshold's interval that ends it.
        stop_width: Option<f64>,
    },
    /// The levels of constant stimuli in their order, and the number of those that are done.
    Levels(Vec<f64>, usize),
    /// Comparisons.
    Ranking(Ranking),
}

impl Track {
    /// Begins a method. `quest` is its prepared run, which all conditions share.
    #[must_use]
    pub fn new(adaptive: &Adaptive, quest: Option<&Quest>, rng: &mut ChaCha8Rng) -> Self {
        match (&adaptive.method, quest) {
            (Method::Staircase(staircase), _) => Self::Stairs(staircase.clone(), Stairs::new(staircase)),
            (Method::QuestPlus(options), Some(quest)) => {
                Self::Quest { quest: quest.clone(), stop_width: options.stop_width }
            }
            (Method::Constant(constant), _) => {
                let rounds = adaptive.common.trials as usize / constant.levels.len().max(1);
                // Shuffled round by round, so that catch trials, which take no level, leave every level about equally
                // often.
                let round = |_| {
                    let mut round = constant.levels.clone();
                    shuffle(&mut round, rng);
                    round
                };
                Self::Levels((0..rounds).flat_map(round).collect(), 0)
            }
            (Method::QuestPlus(_), None) => Self::Planned,
        }
    }

    /// Returns whether the method has learned enough.
    #[must_use]
    pub fn is_over(&self) -> bool {
        match self {
            Self::Stairs(staircase, stairs) => stairs.is_over(staircase),
            Self::Quest { quest, stop_width } => stop_width.is_some_and(|width| quest.width() <= width),
            Self::Levels(levels, done) => *done >= levels.len(),
            Self::Planned | Self::Ranking(_) => false,
        }
    }

    /// Returns what the next trial shows. `draw` is uniform in 0…1.
    #[must_use]
    pub fn pick(&self, adaptive: Option<&Adaptive>, draw: f64) -> Pick {
        match self {
            Self::Planned => Pick::Planned,
            Self::Stairs(_, stairs) => Pick::Level(stairs.level, None),
            Self::Quest { quest, .. } => adaptive.map_or(Pick::Planned, |adaptive| level(adaptive, quest.choose())),
            Self::Levels(levels, done) => levels.get(*done).map_or(Pick::Planned, |level| Pick::Level(*level, None)),
            Self::Ranking(ranking) => Pick::Pair(ranking.choose(draw)),
        }
    }

    /// Learns the outcome of a trial. `is_catch` if it showed no target.
    pub fn learn(&mut self, adaptive: Option<&Adaptive>, pick: Pick, outcome: bool, is_catch: bool) {
        match (self, pick) {
            (Self::Stairs(staircase, stairs), _) if !is_catch => {
                adaptive.into_iter().for_each(|adaptive| stairs.answer(outcome, staircase, &adaptive.common));
            }
            (Self::Quest { quest, .. }, _) if is_catch => quest.learn_catch(outcome),
            (Self::Quest { quest, .. }, pick) => {
                if let Some(index) = adaptive.and_then(|adaptive| index(adaptive, pick)) {
                    quest.learn(index, outcome);
                }
            }
            (Self::Levels(_, done), _) if !is_catch => *done += 1,
            (Self::Ranking(ranking), Pick::Pair([left, right])) => {
                if outcome {
                    ranking.learn(left, right)
                } else {
                    ranking.learn(right, left)
                }
            }
            _ => {}
        }
    }
}

/// Returns the level with a number in QUEST+.
fn level(adaptive: &Adaptive, index: usize) -> Pick {
    let Method::QuestPlus(quest) = &adaptive.method else { return Pick::Planned };
    match &quest.second {
        None => Pick::Level(quest.levels[index], None),
        Some(second) => {
            let count = second.levels.len();
            Pick::Level(quest.levels[index / count], Some(second.levels[index % count]))
        }
    }
}

/// Returns the number of a level in QUEST+.
fn index(adaptive: &Adaptive, pick: Pick) -> Option<usize> {
    let (Method::QuestPlus(quest), Pick::Level(x, y)) = (&adaptive.method, pick) else { return None };
    let first = quest.levels.iter().position(|level| *level == x)?;
    match (&quest.second, y) {
        (Some(second), Some(y)) => {
            Some(first * second.levels.len() + second.levels.iter().position(|level| *level == y)?)
        }
        _ => Some(first),
    }
}
