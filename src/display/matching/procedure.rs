//! The trials, one after the other.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng as _},
};

use super::{
    Channel,
    belief::Belief,
    observation::{Judgement, NullingStimulus, Observation, RowField},
    plan::{Method, Plan, PlanError},
};
use crate::light::shuffle::{below, shuffle};

/// How far a patch is placed from the believed match, in spreads of the observer's comparison: near, since there an
/// answer tells most of the match; not at it, since two codes tell of the spread too.
const OFFSET: f64 = 0.35;
/// A plain difference: light times or divided by e to this.
const PLAIN: f64 = 0.35;
/// Farthest start of the slider from the believed match, natural logarithm of light.
const START: f64 = 0.7;

/// One planned trial, with the chance that it needs drawn beforehand: so the picture follows from the answers alone, and
/// an answer that is taken back brings back the same picture.
#[derive(Clone, Copy, Debug)]
struct Trial {
    channel: Channel,
    level: usize,
    catch: bool,
    /// −1…1.
    draw: f64,
}

/// A run of the procedure: gives pictures, takes answers.
#[derive(Clone, Debug)]
pub struct Nulling {
    plan: Plan,
    trials: Vec<Trial>,
    observations: Vec<Observation>,
    /// For each channel of the plan.
    beliefs: Vec<Belief>,
    /// What stands on the screen; `None` when all is done.
    shown: Option<NullingStimulus>,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Trials answered.
    pub done: usize,
    /// Trials in all.
    pub total: usize,
    /// Expected time of the rest, seconds.
    pub left_s: f64,
}

impl Nulling {
    /// Plans the trials: channels in random order, one after the other so that the eye adapts to each once, and within a
    /// channel all its trials in random order. The same plan and seed give the same order on every machine.
    ///
    /// # Errors
    /// When the plan cannot be run.
    pub fn new(plan: Plan, seed: u64) -> Result<Self, PlanError> {
        plan.validate()?;
        let trials = schedule(&plan, &mut ChaCha8Rng::seed_from_u64(seed));
        let beliefs = vec![Belief::new(&plan); plan.channels.len()];
        let mut nulling = Self { plan, trials, observations: Vec::new(), beliefs, shown: None };
        nulling.shown = nulling.next_stimulus();
        Ok(nulling)
    }

    /// What is matched.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What stands on the screen; `None` when all trials are answered.
    #[must_use]
    pub fn stimulus(&self) -> Option<NullingStimulus> {
        self.shown
    }

    /// Takes the observer's answer to the picture; gives it as it is to be kept. `None` where there is no picture, or
    /// where a match by slider is expected instead (and the other way round).
    pub fn answer(&mut self, judgement: Judgement) -> Option<Observation> {
        let by_slider = judgement == Judgement::Matched;
        if by_slider != (self.plan.method == Method::Adjustment) {
            return None;
        }
        let trial = self.trials.get(self.observations.len())?;
        let observation = Observation {
            trial: self.observations.len() as u32 + 1,
            level: trial.level,
            catch: trial.catch,
            stimulus: self.shown?,
            judgement,
        };
        self.take_in(observation);
        Some(observation)
    }

    /// Gives the patch another code; with the slider only.
    pub fn adjust(&mut self, code: u8) {
        if self.plan.method == Method::Adjustment
            && let Some(shown) = &mut self.shown
        {
            shown.patch = code;
        }
    }

    /// Accepts the patch as it stands: [`Nulling::answer`] with [`Judgement::Matched`].
    pub fn accept(&mut self) -> Option<Observation> {
        self.answer(Judgement::Matched)
    }

    /// Takes the last answer back and brings its picture again, with the slider where it was accepted. Gives the answer
    /// that no longer counts.
    pub fn undo(&mut self) -> Option<Observation> {
        let last = self.observations.pop()?;
        let answered = std::mem::take(&mut self.observations);
        self.beliefs = vec![Belief::new(&self.plan); self.plan.channels.len()];
        answered.into_iter().for_each(|observation| self.take_in(observation));
        self.shown = Some(last.stimulus);
        Some(last)
    }

    /// How far the run is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let (done, total) = (self.observations.len(), self.trials.len());
        Progress { done, total, left_s: (total - done) as f64 * self.plan.method.trial_s() }
    }

    /// Every answer that counts, in order.
    #[must_use]
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    fn take_in(&mut self, observation: Observation) {
        if let Some(at) = self.channel_index(observation.stimulus.channel) {
            self.beliefs[at].update(&observation);
        }
        self.observations.push(observation);
        self.shown = self.next_stimulus();
    }

    fn channel_index(&self, channel: Channel) -> Option<usize> {
        self.plan.channels.iter().position(|planned| *planned == channel)
    }

    fn next_stimulus(&self) -> Option<NullingStimulus> {
        let trial = self.trials.get(self.observations.len())?;
        let belief = self.beliefs.get(self.channel_index(trial.channel)?)?;
        let level = self.plan.levels.get(trial.level)?;
        let rows = RowField {
            lit: level.lit,
            period: level.period,
            row_px: self.plan.row_px,
            lo: belief.code(level.lo),
            hi: belief.code(level.hi),
        };
        let log_ratio = match self.plan.method {
            _ if trial.catch => PLAIN * trial.draw.signum(),
            Method::Staircase => OFFSET * belief.sigma() * trial.draw.signum(),
            Method::Adjustment => START * trial.draw,
        };
        Some(NullingStimulus { channel: trial.channel, rows, patch: belief.patch(trial.level, &rows, log_ratio) })
    }
}

fn schedule(plan: &Plan, rng: &mut ChaCha8Rng) -> Vec<Trial> {
    let mut channels = plan.channels.clone();
    shuffle(&mut channels, rng);
    let mut trials = Vec::with_capacity(plan.trials() as usize);
    for channel in channels {
        let mut levels: Vec<usize> =
            plan.levels.iter().enumerate().flat_map(|(i, level)| vec![i; level.trials as usize]).collect();
        shuffle(&mut levels, rng);
        let start = trials.len();
        trials.extend(levels.iter().map(|&level| Trial { channel, level, catch: false, draw: draw(rng) }));
        if plan.method == Method::Staircase {
            for _ in 0..plan.catches {
                // Plain only once the channel is known a little: in its second half.
                let half = (trials.len() - start) / 2;
                let at = start + half + below(rng, (trials.len() - start - half) as u64 + 1) as usize;
                let level = levels[below(rng, levels.len() as u64) as usize];
                trials.insert(at, Trial { channel, level, catch: true, draw: draw(rng) });
            }
        }
    }
    trials
}

/// Uniform in −1…1.
fn draw(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
