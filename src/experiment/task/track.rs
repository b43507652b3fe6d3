//! The state of an adaptive method in one condition, or of the comparisons of a session.

use rand_chacha::ChaCha8Rng;

use super::{
    adaptive::{Adaptive, Method},
    common::Common,
    kind::Pick,
    quest::{Quest, QuestPlus},
    scaling::Ranking,
    staircase::{Staircase, Stairs},
};
use crate::statistics::shuffle;

/// A method at some trial.
#[derive(Clone, Debug)]
pub enum Track {
    /// A staircase, with what the definition says about it.
    Stairs(Staircase, Common, Stairs),
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
            Method::Staircase(staircase) => {
                vec![Self::Stairs(staircase.clone(), common.clone(), Stairs::new(staircase)); count]
            }
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
            Self::Stairs(staircase, _, stairs) => stairs.is_over(staircase),
            Self::Quest(options, quest) => options.stop_width.is_some_and(|width| quest.width() <= width),
            Self::Levels(levels, done) => *done >= levels.len(),
            Self::Ranking(_) => false,
        }
    }

    /// Returns what the next trial shows. `draw` is uniform in 0…1.
    pub fn pick(&self, draw: f64) -> Pick {
        match self {
            Self::Stairs(.., stairs) => Pick::Level(stairs.level, None),
            Self::Quest(options, quest) => level(options, quest.choose()),
            Self::Levels(levels, done) => levels.get(*done).map_or(Pick::Planned, |level| Pick::Level(*level, None)),
            Self::Ranking(ranking) => Pick::Pair(ranking.choose(draw)),
        }
    }

    /// Learns the outcome of a trial. `is_catch` if it showed no target.
    pub fn learn(&mut self, pick: Pick, outcome: bool, is_catch: bool) {
        match (self, pick) {
            (Self::Quest(_, quest), _) if is_catch => quest.learn_catch(outcome),
            (Self::Stairs(staircase, common, stairs), _) if !is_catch => stairs.answer(outcome, staircase, common),
            (Self::Quest(options, quest), Pick::Level(x, y)) => {
                index(options, x, y).into_iter().for_each(|index| quest.learn(index, outcome));
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

/// Returns the level with a number in QUEST+.
fn level(quest: &QuestPlus, index: usize) -> Pick {
    match &quest.second {
        None => Pick::Level(quest.levels[index], None),
        Some(second) => {
            let count = second.levels.len();
            Pick::Level(quest.levels[index / count], Some(second.levels[index % count]))
        }
    }
}

/// Returns the number of a level in QUEST+.
fn index(quest: &QuestPlus, x: f64, y: Option<f64>) -> Option<usize> {
    let place = |levels: &[f64], of: f64| levels.iter().position(|level| *level == of);
    let first = place(&quest.levels, x)?;
    match (&quest.second, y) {
        (Some(second), Some(y)) => Some(first * second.levels.len() + place(&second.levels, y)?),
        _ => Some(first),
    }
}
