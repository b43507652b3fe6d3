//! Sessions with a simulated observer.

use std::{
    collections::{BTreeMap, HashMap},
    path::PathBuf,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    thread,
    time::Duration,
};

use rayon::prelude::*;
use serde::Serialize;

use super::{RequestError, Watcher};
use crate::{
    experiment::{
        self, FrameCount, Identity, Observer, OrderedLogit, Protocol, RowContext, Session, SessionOptions, TrialRecord,
        UniformObserver, VisionObserver, VisionRater,
    },
    stimulus::Stimulus,
    store::{
        StoreError, observer,
        session::{Changes, Interrupted, SessionStore},
        sidecar::{Pictures, SimulatedObserver, Sitting},
    },
    system::{after, before, check_clock, now, threads},
    text::number::whole,
};

/// Number of sessions that run at the same time. A session spends most of its time waiting for the disk (every row is
/// synced), and a disk serves several waiting sessions at once, so this exceeds the number of cores.
const AT_A_TIME: usize = 32;

/// How a session begins that nobody sees.
const NO_SCREEN: SessionOptions = SessionOptions { pages: 0, frames: FrameCount::Off };

/// Run sessions with a simulated observer. The sessions and files are the same as those from the window, but no window
/// opens.
#[derive(Clone, Debug, clap::Args, Serialize)]
#[command(after_help = "Example: machband simulate bangay2003 --participants 8 --seed 1 --results results")]
pub struct Simulate {
    /// Built-in definition or path to a .toml file.
    pub experiment: PathBuf,
    /// Number of participants; their IDs start at S001.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1..=1_000_000))]
    pub participants: u32,
    /// Seed of the trial order and of the observers.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    pub results: PathBuf,
    /// Simulated observer [default: paper for ratings, vision for other tasks].
    #[arg(long, value_enum)]
    pub observer: Option<ObserverKind>,
    /// Parameters of the paper or vision observer; experiments/observers has the documented defaults.
    #[arg(long, value_name = "FILE.toml")]
    pub observer_file: Option<PathBuf>,
    /// Resume an interrupted run; complete sessions are not changed.
    #[arg(long)]
    pub resume: bool,
    /// Resume sessions whose files were changed after they were sealed; their sidecars record the changes.
    #[arg(long, requires = "resume")]
    pub accept_changes: bool,
}

/// How a simulated observer rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObserverKind {
    /// Follows the paper's findings
    Paper,
    /// Presses keys at random
    Random,
    /// Invented: rates what the vision model predicts, in times threshold
    Vision,
}

impl ObserverKind {
    /// The observer that answers if none is asked for: the paper's findings are about ratings, and its observer does not
    /// see what most other tasks vary.
    pub fn usual(protocol: &Protocol) -> Self {
        if protocol.task.is_default() { Self::Paper } else { Self::Vision }
    }
}

/// Data shared by all sessions of a run.
struct Simulation<'a> {
    request: &'a Simulate,
    protocol: &'a Protocol,
    observer: Box<dyn Observer>,
    /// How the sidecars describe the observer.
    description: SimulatedObserver,
    pictures: Pictures,
    /// Hashes of the pictures by the keys of their stimuli. They are rendered when a session ends, so that no row waits for
    /// them.
    hashes: Mutex<HashMap<String, String>>,
    /// The most trials that all sessions can have, and the rows of those that are done.
    trials: u64,
    done: AtomicU64,
    watcher: &'a dyn Watcher,
}

/// Runs the sessions of `protocol`, which need not be the definition that the request names. The watcher learns the
/// number of trials. Returns the number of rows.
///
/// # Errors
/// The observer is invalid, a session cannot be stored, or the watcher ended it.
pub fn simulate(request: &Simulate, protocol: &Protocol, watcher: &dyn Watcher) -> anyhow::Result<u64> {
    let (observer, description) = observer(request, protocol)?;
    let simulation = Simulation {
        request,
        protocol,
        observer,
        description,
        pictures: Pictures::without_screen(protocol),
        hashes: Mutex::default(),
        trials: u64::from(request.participants) * (protocol.main_trials() as u64 + u64::from(protocol.design.practice)),
        done: AtomicU64::new(0),
        watcher,
    };
    check_clock()?;
    let total = request.participants as usize;
    let (threads, begin) = threads(AT_A_TIME.min(total))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).spawn_handler(begin).build()?;
    pool.install(|| (1..=total).into_par_iter().try_for_each(|number| simulation.session(number)))?;
    Ok(simulation.done.into_inner())
}

/// Returns the observer, and how the sidecars describe it.
fn observer(request: &Simulate, protocol: &Protocol) -> anyhow::Result<(Box<dyn Observer>, SimulatedObserver)> {
    let file = request.observer_file.as_deref();
    Ok(match request.observer.unwrap_or_else(|| ObserverKind::usual(protocol)) {
        ObserverKind::Random if file.is_some() => {
            let message = "does not apply to the observer random; expected the observer paper or vision";
            return Err(RequestError::new("observer_file", message).into());
        }
        ObserverKind::Random => (Box::new(UniformObserver), SimulatedObserver::Random),
        ObserverKind::Vision => {
            let parameters: VisionRater = file.map(observer::open).transpose()?.unwrap_or_default();
            let description = SimulatedObserver::Vision { vision: parameters.clone() };
            let observer = VisionObserver::new(parameters, protocol).map_err(|error| {
                anyhow::anyhow!("{}: {error}, or the observer random or paper", request.experiment.display())
            })?;
            (Box::new(observer), description)
        }
        ObserverKind::Paper => {
            let parameters: OrderedLogit = file.map(observer::open).transpose()?.unwrap_or_default();
            let description = SimulatedObserver::Paper { ordered_logit: parameters.clone() };
            (Box::new(parameters), description)
        }
    })
}

impl Simulation<'_> {
    fn advance(&self, trials: u64) {
        let done = self.done.fetch_add(trials, Ordering::Relaxed) + trials;
        self.watcher.progress(done, self.trials);
    }

    fn session(&self, number: usize) -> anyhow::Result<()> {
        let Self { request, protocol, watcher, .. } = *self;
        watcher.check(&request.results)?;
        let identity = Identity::new(&format!("S{number:03}"), "1").map_err(anyhow::Error::msg)?;
        let sitting = Sitting {
            started_at: now().to_string(),
            observer: Some(self.description.clone()),
            pictures: Some(self.pictures.clone()),
            ..Sitting::default()
        };
        let seed = request.seed;
        let changes = if request.accept_changes { Changes::Accept } else { Changes::Refuse };
        let resume =
            || SessionStore::resume(&request.results, protocol, &identity, Some(seed), sitting.clone(), changes);
        let (mut store, left) = match request.resume.then(resume) {
            None | Some(Err(StoreError::NothingToResume(_))) => {
                SessionStore::create(&request.results, protocol, &identity, seed, sitting)?
            }
            Some(resumed) => resumed?,
        };
        let Interrupted { course, resumed, elapsed_s, sitting, partial_line, .. } = left;
        let schedule = course.schedule().clone();
        if partial_line.is_some() {
            let file = store.csv().display();
            let text = format!("{file}: an incomplete last row was removed; its trial will be shown again");
            watcher.warn(&text);
        }
        self.advance(resumed.done.len() as u64);
        if store.is_complete() {
            return Ok(());
        }
        let elapsed = Duration::try_from_secs_f64(elapsed_s).unwrap_or_default();
        // Simulated time continues from the recorded time. `origin` is the wall-clock time at which the session would
        // have started.
        let origin = before(now(), elapsed);
        let mut session = Session::new(course, &resumed, NO_SCREEN);
        let context = RowContext { protocol, schedule: &schedule, identity: &identity, sitting };
        let mut shown = BTreeMap::new();
        let rated = experiment::simulate(&mut session, self.observer.as_ref(), &identity, elapsed, |response| {
            self.advance(1);
            shown.extend(response.shown.stimuli.iter().map(|stimulus| (stimulus.key(), stimulus.clone())));
            store.append(&TrialRecord::new(&context, response, after(origin, response.onset)))?;
            watcher.check(store.csv())
        });
        if rated.as_ref().is_err_and(|error| error.is::<StoreError>()) {
            return rated;
        }
        // A signal may arrive during the last trial.
        let complete = session.current().is_none();
        if complete && protocol.task.is_default() {
            // Also those of sittings that ended without their pictures.
            let all = schedule.conditions.iter().map(|condition| condition.stimulus.clone());
            shown.extend(all.map(|stimulus| (stimulus.key(), stimulus)));
        }
        let hashed = self.hashed(shown);
        store.note_pictures(hashed.iter().map(|(stimulus, hash)| (stimulus, hash.clone())));
        store.finish(complete, now().to_string(), None)?;
        rated
    }

    /// Returns these stimuli, by their keys, with the hashes of their pictures, and renders those that no session has shown
    /// before. It renders them on a separate thread, outside the pool: a pool thread could pick up another session
    /// meanwhile, and that session would wait for the same hashes, a deadlock.
    fn hashed(&self, shown: BTreeMap<String, Stimulus>) -> Vec<(Stimulus, String)> {
        let mut known = self.hashes.lock().unwrap_or_else(PoisonError::into_inner);
        let new: Vec<(&String, &Stimulus)> = shown.iter().filter(|(key, _)| !known.contains_key(*key)).collect();
        let stimuli: Vec<&Stimulus> = new.iter().map(|(_, stimulus)| *stimulus).collect();
        // Its own threads, because those that all computations share do not exist in a process that was forked.
        let hash = || {
            let threads = rayon::ThreadPoolBuilder::new().build();
            threads.map(|threads| threads.install(|| self.pictures.hashes(&stimuli))).unwrap_or_default()
        };
        // Without a thread, or after a panic, there are no hashes; `verify` then counts the pictures as unverified.
        let found = thread::scope(|scope| {
            let hashed = thread::Builder::new().spawn_scoped(scope, hash).ok();
            hashed.and_then(|hashed| hashed.join().ok()).unwrap_or_default()
        });
        known.extend(new.into_iter().map(|(key, _)| key.clone()).zip(found));
        let all = shown.into_iter().filter_map(|(key, stimulus)| Some((stimulus, known.get(&key)?.clone())));
        all.collect()
    }
}
