//! What takes time and has a result of its own: a check of the recorded files, a simulated pilot, an export.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use anyhow::{anyhow, ensure};
use eframe::egui::{Context, Ui};

use crate::{
    app::ui::{
        self,
        theme::{Icon, MESSAGE, ink},
        work::{BackgroundTask, Lost, Steps},
    },
    experiment::Protocol,
    report::document::numbers::count,
    work::{
        Export, Found, Watcher,
        plan::{self, Plan, Precision},
        simulate::{Simulate, simulate},
        verify::Verify,
    },
};

/// The labels of what is given for a plan.
pub const EFFECTS: &str = "Effects";
pub const DEVIATIONS: &str = "People differ by";

/// The error of a job that was stopped.
const STOPPED: &str = "stopped";

/// What a job made.
pub enum Made {
    /// What a check found in a folder.
    Checked(PathBuf, Found),
    /// The folder of a simulated study.
    Pilot(PathBuf),
    /// A message: what was exported, or that the user stopped it.
    Told(String),
    /// What a plan found, in sentences.
    Planned(Vec<String>),
}

/// Returns what a plan found, in sentences.
fn planned(found: &plan::Found) -> Vec<String> {
    let planned = match found {
        plan::Found::Ratings(planned) => {
            let fields = [EFFECTS, DEVIATIONS].map(|label| format!("“{label}”"));
            return planned.sentences(fields.each_ref().map(String::as_str));
        }
        plan::Found::Task(planned) => planned,
    };
    let line = |one: &Precision| {
        let people = count(one.participants.into(), "participant");
        // One participant has no interval, and thus no test.
        let precision = match (one.half_width, one.error) {
            (Some(half), _) => format!(" ± {half:.3}"),
            (None, Some(error)) => format!(", error {error:.3}"),
            (None, None) => String::new(),
        };
        let is_tested = one.tested().is_some_and(|truth| truth != 0.0);
        let power = if is_tested { format!(", power {:.0}\u{a0}%", 100.0 * one.share().0) } else { String::new() };
        format!("{people}, {} trials: {}{precision}{power}", one.trials, planned.told(&one.quantity))
    };
    let unit = format!(
        "Half the width of the 95 % interval follows ±; an error is the root mean square of estimate minus truth; both in {}.",
        planned.unit()
    );
    planned.found.iter().map(line).chain([unit]).collect()
}

/// How far a job is, and whether it should end.
#[derive(Default)]
struct State {
    steps: Steps,
    stopped: AtomicBool,
    /// What the user should know about a result.
    warnings: Mutex<Vec<String>>,
}

impl Watcher for State {
    fn progress(&self, done: u64, total: u64) {
        self.steps.set(done, total);
    }

    fn warn(&self, warning: &str) {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(warning.to_owned());
    }

    fn found(&self, _: &Path, _: &str) -> anyhow::Result<()> {
        self.check(Path::new(""))
    }

    fn check(&self, _: &Path) -> anyhow::Result<()> {
        ensure!(!self.stopped.load(Ordering::Relaxed), STOPPED);
        Ok(())
    }
}

/// A job that runs on a separate thread.
pub struct Job {
    /// What it does, as the beginning of a sentence.
    pub what: &'static str,
    state: Arc<State>,
    work: BackgroundTask<anyhow::Result<Made>>,
    /// Whether it writes files, so that it must come to its end.
    writes: bool,
    /// The folder in which it leaves what it has made if it is stopped.
    folder: Option<PathBuf>,
}

impl Job {
    fn start(
        ctx: &Context,
        what: &'static str,
        writes: bool,
        run: impl FnOnce(&dyn Watcher) -> anyhow::Result<Made> + Send + 'static,
    ) -> Self {
        let state = Arc::<State>::default();
        let watcher = state.clone();
        let compute = move || run(&*watcher);
        let work = if writes { BackgroundTask::start(ctx, compute) } else { BackgroundTask::stoppable(ctx, compute) };
        Self { what, state, work, writes, folder: None }
    }

    /// Checks the files of a study.
    pub fn check(ctx: &Context, folder: PathBuf) -> Self {
        Self::start(ctx, "Checking", true, move |watcher| {
            let found = Verify { folder: folder.clone() }.verify(watcher)?;
            Ok(Made::Checked(folder, found))
        })
    }

    /// Finds how many participants a study needs.
    pub fn plan(ctx: &Context, request: Plan) -> Self {
        Self::start(ctx, "Planning", false, move |watcher| Ok(Made::Planned(planned(&request.plan(watcher)?))))
    }

    /// Simulates a study in a folder of its own.
    pub fn pilot(ctx: &Context, request: Simulate, protocol: Protocol) -> Self {
        let folder = Some(request.results.clone());
        let simulate = move |watcher: &dyn Watcher| {
            simulate(&request, &protocol, watcher)?;
            Ok(Made::Pilot(request.results.join(&protocol.name)))
        };
        Self { folder, ..Self::start(ctx, "Simulating", true, simulate) }
    }

    /// Exports a study.
    pub fn export(ctx: &Context, request: Export) -> Self {
        Self::start(ctx, "Exporting", true, move |watcher| {
            request.export(watcher)?;
            Ok(Made::Told(format!("Exported to {}", ui::full(&request.out).display())))
        })
    }

    /// Returns what the job made, once it is done.
    pub fn poll(&self) -> Option<anyhow::Result<Made>> {
        let is_left = !self.writes && self.state.stopped.load(Ordering::Relaxed);
        let made = if is_left { Ok(Err(anyhow!(STOPPED))) } else { self.work.poll()? };
        let made = made.unwrap_or_else(|Lost| Err(anyhow!("It ended without a result.")));
        let kept = self.folder.as_ref().map(|folder| format!(" What was made is in {}.", folder.display()));
        Some(match made {
            Err(error) if error.to_string() == STOPPED => {
                Ok(Made::Told(format!("{} was stopped.{}", self.what, kept.unwrap_or_default())))
            }
            made => made,
        })
    }

    /// Returns what the user should know about the result.
    pub fn warnings(&self) -> Vec<String> {
        self.state.warnings.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Draws how far the job is, and the button that stops it.
    pub fn show(&self, ui: &mut Ui) {
        // The button is as high as the line.
        ui.spacing_mut().interact_size.y = MESSAGE;
        ui.spacing_mut().button_padding.y = 2.0;
        ui.horizontal(|ui| {
            Icon::Part.show(ui, ink(ui).text);
            self.state.steps.show(ui, self.what, "");
            if ui.button("Stop").clicked() {
                self.state.stopped.store(true, Ordering::Relaxed);
            }
        });
    }
}
