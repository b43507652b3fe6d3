//! `machband simulate`

use std::{
    path::{Path, PathBuf},
    sync::OnceLock,
    thread,
    time::{Duration, Instant},
};

use indicatif::ProgressBar;
use rayon::prelude::*;

use super::{UsageError, progress_style};
use crate::{
    experiment::{
        Condition, FrameCount, Identity, Observer, Protocol, RowContext, Schedule, Session, SessionOptions,
        TrialRecord, UniformObserver, VisionObserver, simulate,
    },
    report::document::numbers::count,
    store::{
        StoreError, definition, observer,
        session::{Changes, Interrupted, SessionStore},
        sitting::{Pictures, SimulatedObserver, Sitting},
    },
    system::{after, before, check_clock, now, signals, threads},
};

/// Number of sessions that run at the same time. A session spends most of its time waiting for the disk (every row is
/// synced), and a disk serves several waiting sessions at once, so this exceeds the number of cores.
const AT_A_TIME: usize = 32;

/// Run sessions with a simulated observer. The sessions and files are the same as those from the window, but no window
/// opens.
#[derive(clap::Args)]
#[command(after_help = "Example: machband simulate bangay2003 --participants 8 --seed 1 --results results")]
pub struct Arguments {
    /// Built-in definition or path to a .toml file.
    experiment: PathBuf,
    /// Number of participants; their IDs start at S001.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    participants: u32,
    /// Seed of the trial order and of the observers.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Simulated observer.
    #[arg(long, value_enum, default_value_t = ObserverKind::Paper)]
    observer: ObserverKind,
    /// Parameters of the paper or vision observer; experiments/observers has the documented defaults.
    #[arg(long, value_name = "FILE.toml")]
    observer_file: Option<PathBuf>,
    /// Resume an interrupted run; complete sessions are not changed.
    #[arg(long)]
    resume: bool,
    /// Resume sessions whose files were changed after they were sealed; their sidecars record the changes.
    #[arg(long, requires = "resume")]
    accept_changes: bool,
}

/// How a simulated observer rates.
#[derive(Clone, Copy, clap::ValueEnum)]
enum ObserverKind {
    /// Follows the paper's findings
    Paper,
    /// Presses keys at random
    Random,
    /// Rates the visibility that the vision model predicts
    Vision,
}

/// Data shared by all sessions of a run.
struct Simulation<'a> {
    arguments: &'a Arguments,
    protocol: &'a Protocol,
    observer: Box<dyn Observer>,
    /// How the sidecars describe the observer.
    description: SimulatedObserver,
    pictures: Pictures,
    /// Hashes of the pictures, which are rendered when the first session ends, so that no row waits for them.
    hashes: OnceLock<Vec<String>>,
    watcher: &'a dyn Watcher,
}

/// Whoever waits for a simulation.
pub trait Watcher: Sync {
    /// Learns that `trials` more trials are done.
    fn advance(&self, trials: u64);
    /// Receives a warning.
    fn warn(&self, warning: &str);
    /// Says whether to go on; `place` is where the answers are.
    ///
    /// # Errors
    /// The sessions should end.
    fn check(&self, place: &Path) -> anyhow::Result<()>;
}

impl Watcher for ProgressBar {
    fn advance(&self, trials: u64) {
        self.inc(trials);
    }

    fn warn(&self, warning: &str) {
        self.suspend(|| super::message("warning", warning));
    }

    fn check(&self, place: &Path) -> anyhow::Result<()> {
        Ok(signals::check(place)?)
    }
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let protocol = definition::open(&arguments.experiment)?;
    let started = Instant::now();
    let trials = arguments.trials(&protocol);
    let bar = ProgressBar::new(trials).with_style(progress_style("trials"));
    signals::watch();
    let done = sessions(arguments, &protocol, &bar);
    bar.finish_and_clear();
    done?;
    super::print_line(&format!(
        "{} of {} in {}, {}, {:.1} s",
        count(arguments.participants.into(), "session"),
        protocol.name,
        arguments.results.join(&protocol.name).display(),
        count(trials, "row"),
        started.elapsed().as_secs_f64()
    ))
}

impl Arguments {
    /// Returns the number of trials in all sessions of a definition.
    #[must_use]
    pub fn trials(&self, protocol: &Protocol) -> u64 {
        u64::from(self.participants) * (protocol.main_trials() as u64 + u64::from(protocol.design.practice))
    }
}

/// Runs the sessions of a definition, which need not be the one that `arguments` name.
///
/// # Errors
/// The observer is invalid, a session cannot be stored, or `watcher` ended it.
pub fn sessions(arguments: &Arguments, protocol: &Protocol, watcher: &dyn Watcher) -> anyhow::Result<()> {
    let (observer, description) = observer(arguments, protocol)?;
    let pictures = Pictures::without_screen(protocol);
    let simulation =
        Simulation { arguments, pictures, protocol, observer, description, hashes: OnceLock::new(), watcher };
    check_clock()?;
    let total = arguments.participants as usize;
    let (threads, begin) = threads(AT_A_TIME.min(total))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).spawn_handler(begin).build()?;
    pool.install(|| (1..=total).into_par_iter().try_for_each(|number| simulation.session(number)))
}

/// Returns the observer, and how the sidecars describe it.
fn observer(arguments: &Arguments, protocol: &Protocol) -> anyhow::Result<(Box<dyn Observer>, SimulatedObserver)> {
    let file = arguments.observer_file.as_deref();
    Ok(match arguments.observer {
        ObserverKind::Random if file.is_some() => {
            let message = "--observer-file does not apply to --observer random; expected --observer paper or vision";
            return Err(UsageError(message.to_owned()).into());
        }
        ObserverKind::Random => (Box::new(UniformObserver), SimulatedObserver::Random),
        ObserverKind::Vision => {
            let parameters = file.map(observer::open_vision).transpose()?.unwrap_or_default();
            let description = SimulatedObserver::Vision { vision: parameters.clone() };
            let observer = VisionObserver::new(parameters, protocol)
                .map_err(|error| anyhow::anyhow!("{}: {error}", arguments.experiment.display()))?;
            (Box::new(observer), description)
        }
        ObserverKind::Paper => {
            let parameters = match file {
                Some(path) => observer::open(path)?,
                None => observer::parse("paper.toml", observer::PAPER)?,
            };
            let description = SimulatedObserver::Paper { ordered_logit: parameters.clone() };
            (Box::new(parameters), description)
        }
    })
}

impl Simulation<'_> {
    fn session(&self, number: usize) -> anyhow::Result<()> {
        let Self { arguments, protocol, watcher, .. } = *self;
        watcher.check(&arguments.results)?;
        let identity = Identity::new(&format!("S{number:03}"), "1")?;
        let sitting = Sitting {
            started_at: now().to_string(),
            observer: Some(self.description.clone()),
            pictures: Some(self.pictures.clone()),
            ..Sitting::default()
        };
        let seed = arguments.seed;
        let changes = if arguments.accept_changes { Changes::Accept } else { Changes::Refuse };
        let resume =
            || SessionStore::resume(&arguments.results, protocol, &identity, Some(seed), sitting.clone(), changes);
        let (mut store, left) = match arguments.resume.then(resume) {
            None | Some(Err(StoreError::NothingToResume(_))) => {
                let schedule = Schedule::new(protocol, &identity, seed)?;
                let store = SessionStore::create(&arguments.results, protocol, &identity, seed, sitting)?;
                (store, Interrupted::before_the_first_trial(schedule))
            }
            Some(resumed) => resumed?,
        };
        let Interrupted { schedule, resumed, elapsed_s, sitting, partial_line, .. } = left;
        if partial_line.is_some() {
            let file = store.csv().display();
            let text = format!("{file}: an incomplete last row was removed; its trial will be shown again");
            watcher.warn(&text);
        }
        watcher.advance(resumed.done.len() as u64);
        if store.is_complete() {
            return Ok(());
        }
        let elapsed = Duration::try_from_secs_f64(elapsed_s).unwrap_or_default();
        // Simulated time continues from the recorded time. `origin` is the wall-clock time at which the session would
        // have started.
        let origin = before(now(), elapsed);
        let options = SessionOptions { pages: 0, frames: FrameCount::Off };
        let mut session = Session::new(protocol.clone(), schedule.clone(), &resumed, options);
        let context = RowContext { protocol, schedule: &schedule, identity: &identity, sitting };
        let rated = simulate(&mut session, self.observer.as_ref(), &identity, elapsed, |response| {
            watcher.advance(1);
            store.append(&TrialRecord::new(&context, response, after(origin, response.onset)))?;
            watcher.check(store.csv())
        });
        if rated.as_ref().is_err_and(|error| error.is::<StoreError>()) {
            return rated;
        }
        // A signal may arrive during the last trial.
        let complete = session.current().is_none();
        if complete {
            let hashes = self.hashes.get_or_init(|| self.hash(&schedule.conditions));
            hashes.iter().enumerate().for_each(|(condition, hash)| store.note_picture(condition, hash.clone()));
        }
        store.finish(complete, now().to_string(), None)?;
        rated
    }

    /// Renders the pictures on a separate thread, outside the pool. A pool thread could pick up another session while
    /// it renders, and that session would wait for the same hashes: a deadlock.
    fn hash(&self, conditions: &[Condition]) -> Vec<String> {
        // Its own threads, because those that all computations share do not exist in a process that was forked.
        let hash = || {
            let threads = rayon::ThreadPoolBuilder::new().build();
            threads.map(|threads| threads.install(|| self.pictures.hashes(conditions))).unwrap_or_default()
        };
        // Without a thread, or after a panic, there are no hashes; `verify` then counts the pictures as unverified.
        thread::scope(|scope| {
            let hashed = thread::Builder::new().spawn_scoped(scope, hash).ok();
            hashed.and_then(|hashed| hashed.join().ok()).unwrap_or_default()
        })
    }
}
