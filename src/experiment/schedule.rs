//! The order of the trials. The definition, the seed and the identity determine it, and it is the same on every
//! machine.

use std::{collections::HashMap, sync::Arc};

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng as _},
};

use super::{
    condition::{Condition, Factor},
    definition::Order,
    participant::{Identity, fnv1a},
    protocol::Protocol,
    task::Task,
};
use crate::statistics::shuffle;
use crate::text::names::named;

/// Describes, for the sidecar, how an order is generated from a seed. Any change to this procedure would change the
/// meaning of recorded data.
pub const GENERATOR: &str = "ChaCha8, seed_from_u64(seed), stream FNV-1a-64(subject_id NUL session_id), Fisher-Yates from the end, rejection sampling";

/// Maximum number of shuffles tried to satisfy `max_run`.
const RUN_ATTEMPTS: usize = 200;
/// Maximum number of exchanges tried to satisfy `max_run`. This limits the search to about a second if a large design
/// has no possible order.
const RUN_EXCHANGES: usize = 20_000_000;

named! {
    /// The phase of a trial. Practice trials are recorded but not analyzed.
    #[derive(Default)]
    Phase, PhaseError {
        /// Practice trials, which come before the main trials.
        Practice = "practice",
        /// Main trials, which are analyzed; also the placeholder for a row that is not yet filled in.
        #[default]
        Main = "main",
    }
}

/// One planned trial.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trial {
    /// Practice or main.
    pub phase: Phase,
    /// Number of the block within the phase, from 1. In a blocked order, a block is one level of the factor; otherwise,
    /// it is the trials between two breaks.
    pub block: u32,
    /// Number of the trial within the phase, from 1.
    pub number: u32,
    /// How many times this condition has occurred in this phase, including this trial; from 1.
    pub repetition: u32,
    /// Index into [`Schedule::conditions`] or, in a task that compares conditions, into
    /// [`Protocol::pairs`](super::Protocol::pairs).
    pub condition: usize,
    /// Drawn in advance and balanced over the trials of a condition: where the target is, for example. Its meaning
    /// depends on the task.
    pub place: u32,
    /// Drawn in advance, uniform over all values.
    pub draw: u32,
}

impl Trial {
    /// Returns the conditions that the trial compares, left and right, if the schedule of this protocol plans them.
    pub fn planned_pair(&self, protocol: &Protocol) -> Option<[usize; 2]> {
        let pairs = protocol.pairs().filter(|_| protocol.task.ranking().is_none())?;
        Some(self.placed(pairs[self.condition]))
    }

    /// Returns a pair of conditions as the trial shows them, left and right.
    pub(super) fn placed(&self, [one, other]: [usize; 2]) -> [usize; 2] {
        if self.place == 1 { [other, one] } else { [one, other] }
    }
}

/// All trials of a session, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// The cells of the design.
    pub conditions: Arc<[Condition]>,
    /// Practice trials, followed by main trials.
    pub trials: Vec<Trial>,
    /// The seed from which the order was generated.
    pub seed: u64,
    /// The number of the participant's and session's own random stream.
    pub stream: u64,
}

/// No order with the definition's `max_run` was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found no order with max_run = {max_run}; expected a larger max_run or more levels")]
pub struct ScheduleError {
    /// The requested limit.
    pub max_run: u32,
}

/// Returns a session's own random number generator. For a given seed, each participant and session has a separate
/// stream.
pub(super) fn generator(seed: u64, identity: &Identity) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream(identity));
    rng
}

fn stream(identity: &Identity) -> u64 {
    fnv1a(format!("{}\0{}", identity.subject(), identity.session()).as_bytes())
}

/// Derives the seed of a new session from anything that differs between sessions. It is below 2³², so that every JSON
/// reader preserves it.
pub fn session_seed(entropy: u64) -> u64 {
    ChaCha8Rng::seed_from_u64(entropy).next_u64() >> 32
}

impl Schedule {
    /// Creates the order for this definition, participant, session and seed.
    ///
    /// # Errors
    /// Returns a [`ScheduleError`] if `max_run` cannot be satisfied.
    pub fn new(protocol: &Protocol, identity: &Identity, seed: u64) -> Result<Self, ScheduleError> {
        let conditions = Arc::clone(protocol.conditions());
        let mut rng = generator(seed, identity);
        let mut trials = practice(protocol, &mut rng);
        trials.extend(main(protocol, &conditions, identity, &mut rng)?);
        draw_places(&mut trials, &protocol.task, &mut rng);
        Ok(Self { conditions, trials, seed, stream: stream(identity) })
    }

    /// Returns the planned trials of one phase.
    pub fn phase(&self, phase: Phase) -> impl Iterator<Item = &Trial> {
        self.trials.iter().filter(move |trial| trial.phase == phase)
    }
}

/// Draws the place and the number of each trial. Within a condition, and within the practice, every round of places is
/// complete before the next begins. A task with a single place draws nothing.
fn draw_places(trials: &mut [Trial], task: &Task, rng: &mut ChaCha8Rng) {
    if task.places() < 2 {
        return;
    }
    let owner = |trial: &Trial| (trial.phase == Phase::Main).then_some(trial.condition);
    // The number of trials, the number of those that have a place, and the places that are left of a round.
    let mut rounds: HashMap<Option<usize>, (usize, usize, Vec<u32>)> = HashMap::new();
    trials.iter().for_each(|trial| rounds.entry(owner(trial)).or_default().0 += 1);
    for trial in trials {
        let (all, done, left) = rounds.entry(owner(trial)).or_default();
        if left.is_empty() {
            *left = task.round(*done, *all);
            *done += left.len();
            shuffle(left, rng);
        }
        (trial.place, trial.draw) = (left.pop().unwrap_or_default(), (rng.next_u64() >> 32) as u32);
    }
}

/// Picks the practice trials. Each condition occurs at most one time more than any other.
fn practice(protocol: &Protocol, rng: &mut ChaCha8Rng) -> Vec<Trial> {
    let (wanted, conditions) = (protocol.design.practice as usize, protocol.slots());
    let mut picked = Vec::with_capacity(wanted);
    while picked.len() < wanted {
        let mut round: Vec<usize> = (0..conditions).collect();
        shuffle(&mut round, rng);
        round.truncate(wanted - picked.len());
        picked.extend(round);
    }
    number(Phase::Practice, conditions, picked.into_iter().map(|condition| (1, condition)))
}

fn main(
    protocol: &Protocol,
    conditions: &[Condition],
    identity: &Identity,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Trial>, ScheduleError> {
    let design = &protocol.design;
    let blocking = design.order.factor().and_then(|name| protocol.factors.iter().position(|f| f.name == name));
    let all = 0..protocol.slots();
    let (blocks, block_trials): (Vec<Vec<usize>>, _) = match blocking {
        None if design.break_every == 0 => (vec![all.collect()], protocol.main_trials()),
        None => (vec![all.collect()], design.break_every as usize),
        Some(factor) => {
            let levels = protocol.factors[factor].levels.len();
            let mut of_level = vec![Vec::new(); levels];
            all.for_each(|c| of_level[conditions[c].levels[factor]].push(c));
            let mut order: Vec<usize> = (0..levels).collect();
            match design.order {
                Order::Latin(_) => order = williams_row(levels, identity.counterbalance_row()),
                _ => shuffle(&mut order, rng),
            }
            let blocks = order.into_iter().map(|level| std::mem::take(&mut of_level[level]));
            (blocks.collect(), protocol.main_trials() / levels)
        }
    };
    let mut cells = Vec::with_capacity(protocol.main_trials());
    for block in blocks {
        let settled = cells.len();
        cells.extend(block.repeat(protocol.repetitions() as usize));
        shuffle(&mut cells[settled..], rng);
        if let Some(max_run) = design.max_run {
            limit_runs(&mut cells, settled, conditions, &protocol.factors, blocking, max_run, rng)?;
        }
    }
    let numbered = cells.into_iter().enumerate().map(|(i, cell)| ((i / block_trials.max(1)) as u32 + 1, cell));
    Ok(number(Phase::Main, protocol.slots(), numbered))
}

/// Returns one row of a Williams square. Over all rows, each level takes each position equally often and follows every
/// other level equally often. An odd number of levels needs twice as many rows; the second half is mirrored. Williams
/// 1949, Aust. J. Sci. Res. A 2:149.
fn williams_row(levels: usize, row: u64) -> Vec<usize> {
    let rows = if levels.is_multiple_of(2) { levels } else { 2 * levels };
    let row = (row % rows as u64) as usize;
    let mut sequence: Vec<usize> = (0..levels)
        .map(|i| if i % 2 == 1 { i.div_ceil(2) } else { (levels - i / 2) % levels })
        .map(|base| (base + row) % levels)
        .collect();
    if row >= levels {
        sequence.reverse();
    }
    sequence
}

fn number(phase: Phase, conditions: usize, cells: impl Iterator<Item = (u32, usize)>) -> Vec<Trial> {
    let mut seen = vec![0; conditions];
    cells
        .zip(1..)
        .map(|((block, condition), number)| {
            seen[condition] += 1;
            Trial { phase, block, number, repetition: seen[condition], condition, place: 0, draw: 0 }
        })
        .collect()
}

/// Rearranges the shuffled `cells` from index `settled` on, until no factor keeps a level for more than `max_run`
/// consecutive trials, counting the trials of earlier blocks. The factor that defines the blocks is exempt, because its
/// level is constant within a block by design. A factor with a single level is exempt as well.
fn limit_runs(
    cells: &mut [usize],
    settled: usize,
    conditions: &[Condition],
    factors: &[Factor],
    blocking: Option<usize>,
    max_run: u32,
    rng: &mut ChaCha8Rng,
) -> Result<(), ScheduleError> {
    let held: Vec<usize> =
        (0..factors.len()).filter(|f| Some(*f) != blocking && factors[*f].levels.len() > 1).collect();
    let max = max_run as usize;
    // Checks the runs through `at`, considering only the settled cells (`..end`).
    let fits = |cells: &[usize], at: usize, end: usize| {
        held.iter().all(|&f| {
            let same = |i: &usize| conditions[cells[*i]].levels[f] == conditions[cells[at]].levels[f];
            let before = (0..at).rev().take(max).take_while(same).count();
            let after = (at + 1..end).take(max).take_while(same).count();
            before + after < max
        })
    };
    let end = cells.len();
    let mut exchanges = 0;
    'attempt: for _ in 0..RUN_ATTEMPTS {
        for i in settled..end {
            if exchanges > RUN_EXCHANGES {
                break 'attempt;
            }
            let mut exchange = |j: usize, good: &dyn Fn(&[usize]) -> bool| {
                exchanges += 1;
                cells.swap(i, j);
                let good = good(cells);
                if !good {
                    cells.swap(i, j);
                }
                good
            };
            let found = (i..end).any(|j| exchange(j, &|cells| fits(cells, i, i + 1)))
                // If no cell ahead fits, exchange with a settled cell such that both then fit.
                || (settled..i).any(|j| exchange(j, &|cells| fits(cells, j, i + 1) && fits(cells, i, i + 1)));
            if !found {
                shuffle(&mut cells[settled..], rng);
                continue 'attempt;
            }
        }
        return Ok(());
    }
    Err(ScheduleError { max_run })
}
