//! What each trial of a session shows: a function of the definition, the seed and the answers so far. Nothing of it is
//! stored, so a session can be resumed, and anyone can recompute it from its rows.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

use super::{
    participant::{Identity, fnv1a},
    protocol::Protocol,
    schedule::{Phase, Schedule, ScheduleError},
    task::{Adaptive, Answer, Method, Pick, Presentation, Ranking, Track, Turn},
};

/// A session's trials, and the answers to them so far.
#[derive(Clone, Debug)]
pub struct Course {
    protocol: Protocol,
    schedule: Schedule,
    /// The methods: one for each condition, or one for all comparisons; none if the schedule plans everything.
    tracks: Vec<Track>,
    /// The trial answered last, and its method before that answer.
    last: Option<(usize, Option<(usize, Track)>)>,
}

impl Course {
    /// Begins a session.
    ///
    /// # Errors
    /// There is no such order of the trials.
    pub fn new(protocol: &Protocol, identity: &Identity, seed: u64) -> Result<Self, ScheduleError> {
        let (protocol, schedule) = (protocol.clone(), Schedule::new(protocol, identity, seed)?);
        Ok(Self { tracks: tracks(&protocol, &schedule), protocol, schedule, last: None })
    }

    /// Returns the definition.
    pub fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Returns the planned order of the trials.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// Returns the method that decides what a trial shows. Practice trials do not affect one.
    fn track(&self, trial: usize) -> Option<usize> {
        let planned = &self.schedule.trials[trial];
        (planned.phase == Phase::Main && !self.tracks.is_empty()).then_some(planned.condition)
    }

    /// Returns whether a trial is left out, because its method has learned enough.
    pub fn is_over(&self, trial: usize) -> bool {
        self.track(trial).is_some_and(|track| self.tracks[track].is_over())
    }

    /// Returns what a trial would show now.
    pub fn presentation(&self, trial: usize) -> Presentation {
        self.present(trial, self.pick(trial))
    }

    fn pick(&self, trial: usize) -> Pick {
        let draw = self.draw(trial);
        match self.track(trial) {
            Some(track) => self.tracks[track].pick(draw),
            None if self.protocol.task.ranking().is_some() => {
                let pairs = self.protocol.pairs().unwrap_or_default();
                pairs.get((draw * pairs.len() as f64) as usize).map_or(Pick::Planned, |pair| Pick::Pair(*pair))
            }
            None => self.protocol.adaptive.as_ref().map_or(Pick::Planned, |adaptive| practice(adaptive, draw)),
        }
    }

    /// Returns the number that was drawn for a trial, in 0…1.
    fn draw(&self, trial: usize) -> f64 {
        f64::from(self.schedule.trials[trial].draw) / (f64::from(u32::MAX) + 1.0)
    }

    /// Returns what a trial shows if the method chooses `pick`.
    fn present(&self, trial: usize, pick: Pick) -> Presentation {
        let (planned, conditions) = (&self.schedule.trials[trial], &self.schedule.conditions);
        let pair = match pick {
            Pick::Pair(pair) => Some(planned.placed(pair)),
            _ => planned.planned_pair(&self.protocol),
        };
        let [one, other] = pair.unwrap_or([planned.condition; 2]);
        let turn = Turn {
            condition: &conditions[one],
            other: pair.map(|_| &conditions[other]),
            place: planned.place,
            draw: self.draw(trial),
            levels: self.protocol.adaptive.as_ref().map_or_else(Vec::new, |adaptive| adaptive.named(pick)),
        };
        Presentation { pick, ..self.protocol.task.present(&turn) }
    }

    /// Takes the answer to a trial that showed `shown`, which need not follow from the answers before. If the trial was
    /// answered last, the new answer replaces the old one.
    pub fn answer(&mut self, trial: usize, shown: &Presentation, answer: &Answer) {
        self.take_back(trial);
        let Some(track) = self.track(trial) else {
            self.last = Some((trial, None));
            return;
        };
        let (task, before) = (&self.protocol.task, self.tracks[track].clone());
        // The first of a pair may be on the right.
        let is_turned = matches!(shown.pick, Pick::Pair(_)) && self.schedule.trials[trial].place == 1;
        let is_catch = task.catches().is_some() && shown.target == Some(0);
        self.tracks[track].learn(shown.pick, task.outcome(shown, answer) != is_turned, is_catch);
        self.last = Some((trial, Some((track, before))));
    }

    /// Forgets the answer to a trial if it is the last one.
    pub fn take_back(&mut self, trial: usize) {
        if let Some((_, before)) = self.last.take_if(|(last, _)| *last == trial)
            && let Some((track, state)) = before
        {
            self.tracks[track] = state;
        }
    }

    /// Returns what a trial could show, whatever the answers before, given the level that it has.
    pub fn possible(&self, trial: usize, level: Option<f64>) -> Vec<Presentation> {
        let adaptive = self.protocol.adaptive.as_ref();
        let level = adaptive.zip(level).filter(|(adaptive, level)| adaptive.can_show(*level));
        let picks: Vec<Pick> = match (level, self.protocol.pairs()) {
            (Some((adaptive, level)), _) => adaptive.picks(&[level]),
            (None, Some(pairs)) if !self.tracks.is_empty() => pairs.iter().map(|pair| Pick::Pair(*pair)).collect(),
            _ => vec![Pick::Planned],
        };
        picks.into_iter().map(|pick| self.present(trial, pick)).collect()
    }
}

/// Returns the methods of a session at its start.
fn tracks(protocol: &Protocol, schedule: &Schedule) -> Vec<Track> {
    if protocol.task.ranking().is_some() {
        return vec![Track::Ranking(Ranking::new(protocol.conditions().len()))];
    }
    let Some(adaptive) = &protocol.adaptive else { return Vec::new() };
    let generator = |condition: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(schedule.seed);
        rng.set_stream(fnv1a(format!("levels\0{}\0{condition}", schedule.stream).as_bytes()));
        rng
    };
    Track::begin(adaptive, protocol.task.guess(), protocol.slots(), generator)
}

/// Returns the level of a practice trial: any of the levels, or where a staircase begins.
fn practice(adaptive: &Adaptive, draw: f64) -> Pick {
    let levels = adaptive.levels();
    let any = levels.get((draw * levels.len() as f64) as usize).copied();
    let level = if let Method::Staircase(staircase) = &adaptive.method { Some(staircase.start) } else { any };
    let second = adaptive.second().and_then(|second| second.levels.first()).copied();
    level.map_or(Pick::Planned, |level| Pick::Level(level, second))
}
