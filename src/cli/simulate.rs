//! `machband simulate`

use std::{
    path::PathBuf,
    sync::OnceLock,
    time::{Duration, Instant},
};

use indicatif::ProgressBar;
use jiff::Timestamp;
use serde_json::json;

use super::{UsageError, parallel, progress_style};
use crate::{
    experiment::{
        FrameCount, Identity, Observer, Protocol, Resumed, RowContext, Schedule, Session, SessionOptions, TrialRecord,
        UniformObserver, VisionObserver, simulate,
    },
    store::{
        StoreError, definition, observer,
        pictures::Pictures,
        session::{Interrupted, SessionStore},
        sidecar::Sitting,
    },
};

/// Sessions that run at a time. A session waits for the disk most of its time (every row is synced), and disks serve
/// several waiting sessions together, so this is more than there are cores.
const AT_A_TIME: usize = 32;

/// Run sessions with a simulated observer: the same session and the same files, without a window.
#[derive(clap::Args)]
#[command(after_help = "Example: machband simulate bangay2003 --participants 8 --seed 1 --results results")]
pub(super) struct Arguments {
    /// Built-in definition or path of a .toml file.
    experiment: String,
    /// Number of participants, S001 onwards.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    participants: u32,
    /// Seed of the orders and of the observers.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value_os_t = super::default_results())]
    results: PathBuf,
    /// Who rates: `paper` follows the paper's findings, `vision` rates what the model of vision sees, `random` presses
    /// any key.
    #[arg(long, default_value = "paper", value_parser = ["paper", "random", "vision"])]
    observer: String,
    /// Parameters of the `paper` or the `vision` observer; the documented defaults are in experiments/observers.
    #[arg(long, value_name = "FILE.toml")]
    observer_file: Option<PathBuf>,
    /// Go on with what an interrupted run left; sessions that are complete stay as they are.
    #[arg(long)]
    resume: bool,
}

struct Rater {
    observer: Box<dyn Observer>,
    description: serde_json::Value,
}

/// What the sessions show. It is rendered when the first of them ends: rows do not wait for it.
struct Shown {
    pictures: Pictures,
    hashes: OnceLock<Vec<String>>,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let protocol = definition::open(&arguments.experiment)?;
    let rater = rater(arguments, &protocol)?;
    let shown = Shown { pictures: Pictures::without_screen(&protocol), hashes: OnceLock::new() };
    let started = Instant::now();
    let trials = protocol.main_trials() + protocol.design.practice as usize;
    let total = arguments.participants as usize;
    let bar = ProgressBar::new((total * trials) as u64).with_style(progress_style("trials"));
    let done = parallel::each(total, AT_A_TIME, |i| one(arguments, &protocol, &rater, &shown, i + 1, &bar));
    bar.finish_and_clear();
    done?;
    super::say(&format!(
        "{} sessions of {} in {}, {} rows, {:.1} s",
        total,
        protocol.name,
        arguments.results.join(&protocol.name).display(),
        total * trials,
        started.elapsed().as_secs_f64()
    ))
}

fn rater(arguments: &Arguments, protocol: &Protocol) -> anyhow::Result<Rater> {
    match (arguments.observer.as_str(), &arguments.observer_file) {
        ("random", None) => {
            Ok(Rater { observer: Box::new(UniformObserver), description: json!({ "observer": "random" }) })
        }
        ("random", Some(_)) => {
            Err(UsageError("--observer-file belongs to --observer paper or vision; expected one of them".to_owned())
                .into())
        }
        ("vision", file) => {
            let parameters = file.as_deref().map(observer::open_vision).transpose()?.unwrap_or_default();
            let description = json!({ "observer": "vision", "vision": parameters });
            let observer = VisionObserver::new(parameters, protocol)
                .map_err(|error| anyhow::anyhow!("{}: {error}", arguments.experiment))?;
            Ok(Rater { observer: Box::new(observer), description })
        }
        (_, file) => {
            let parameters = match file {
                Some(path) => observer::open(path)?,
                None => observer::parse("paper.toml", observer::PAPER)?,
            };
            Ok(Rater {
                description: json!({ "observer": "paper", "ordered_logit": parameters }),
                observer: Box::new(parameters),
            })
        }
    }
}

fn one(
    arguments: &Arguments,
    protocol: &Protocol,
    rater: &Rater,
    shown: &Shown,
    number: usize,
    bar: &ProgressBar,
) -> anyhow::Result<()> {
    let identity = Identity::new(&format!("S{number:03}"), "1")?;
    let sitting = Sitting {
        started_at: Timestamp::now().to_string(),
        observer: Some(rater.description.clone()),
        pictures: Some(shown.pictures.clone()),
        ..Sitting::default()
    };
    let fresh = |sitting| -> anyhow::Result<_> {
        let schedule = Schedule::new(protocol, &identity, arguments.seed)?;
        let store = SessionStore::create(&arguments.results, protocol, &identity, arguments.seed, sitting)?;
        Ok((store, schedule, Resumed::default(), 0.0, 1))
    };
    let (mut store, schedule, resumed, elapsed_s, sitting) = if arguments.resume {
        match SessionStore::resume(&arguments.results, protocol, &identity, Some(arguments.seed), sitting.clone()) {
            Ok((store, Interrupted { schedule, resumed, elapsed_s, sitting, torn, .. })) => {
                if torn.is_some() {
                    bar.suspend(|| {
                        eprintln!(
                            "{}: a half-written last row was cut off and its trial asked again",
                            store.csv().display()
                        )
                    });
                }
                (store, schedule, resumed, elapsed_s, sitting)
            }
            Err(StoreError::NothingToResume(_)) => fresh(sitting)?,
            Err(error) => return Err(error.into()),
        }
    } else {
        fresh(sitting)?
    };
    bar.inc(resumed.done.len() as u64);
    if store.is_complete() {
        return Ok(());
    }
    let elapsed = Duration::from_secs_f64(elapsed_s);
    // Simulated time runs on from what is recorded; the wall clock is where it would have begun.
    let origin = Timestamp::now() - elapsed;
    let options = SessionOptions { pages: 0, frames: FrameCount::Off };
    let mut session = Session::new(protocol.clone(), schedule.clone(), &resumed, options);
    let context = RowContext { protocol, schedule: &schedule, identity: &identity, sitting };
    simulate(&mut session, rater.observer.as_ref(), &identity, elapsed, |response| {
        bar.inc(1);
        store.append(&TrialRecord::new(&context, response, origin + response.onset))
    })?;
    let hashes = shown.hashes.get_or_init(|| shown.pictures.hashes(&schedule.conditions));
    hashes.iter().enumerate().for_each(|(condition, hash)| store.note_picture(condition, hash.clone()));
    store.finish(true, Timestamp::now().to_string(), None)?;
    Ok(())
}
