//! What can be asked of a study and takes time: the dialog that asks for it, and the job in the background. The bounds,
//! defaults, choices and explanations of the fields of a dialog are those of the request, as on the command line.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use anyhow::{anyhow, ensure};
use clap::{Arg, ArgAction, Command};
use eframe::egui::{Context, Response, ScrollArea, Ui};
use serde_json::{Map, Value};

use crate::{
    app::ui::{
        self, Field, FileKind, Step, primary,
        theme::{GAP, Icon, MESSAGE, ink},
        work::{BackgroundTask, Lost, Steps},
    },
    experiment::Protocol,
    report::document::numbers::count,
    work::{
        Export, Found, Request, RequestError, Watcher, from_names,
        plan::{self, Plan, Precision},
        simulate::{Simulate, simulate},
        verify::Verify,
    },
};

/// Width of the dialog, its column of labels, and its fields, points.
const WIDTH: f32 = 600.0;
const LABELS: f32 = 176.0;
const FIELD: f32 = 280.0;

/// Height of the title and of the buttons, points.
const BUTTONS: f32 = 150.0;

/// A field that the dialog shows.
struct Shown {
    label: &'static str,
    argument: Arg,
    /// What was typed or chosen; `true` for a box that is checked.
    value: String,
    /// What is shown while nothing is typed.
    hint: &'static str,
}

/// Starts what is requested; the request is made from the values of its fields.
type Start = Box<dyn Fn(&Context, &Map<String, Value>) -> Result<Job, RequestError>>;

/// The dialog and what was entered.
pub struct RequestForm {
    title: &'static str,
    /// Label of the button.
    action: &'static str,
    about: String,
    fields: Vec<Shown>,
    /// The fields that are not shown.
    given: Map<String, Value>,
    error: Option<RequestError>,
    /// Whether no frame was drawn yet, so that the first text field gets the focus, or an error was found, so that the
    /// field with it does.
    is_new: bool,
    start: Start,
}

impl RequestForm {
    /// Creates a dialog. `shown` are the names, labels and values of the fields to show, and what is shown while nothing is
    /// typed; a field without a value has its default. `given` are the other fields. `start` starts what is requested.
    pub fn new<T: Request>(
        [title, action]: [&'static str; 2],
        about: String,
        shown: &[(&str, &'static str, String, &'static str)],
        given: &[(&str, String)],
        start: impl Fn(&Context, T) -> Job + 'static,
    ) -> Self {
        let command = T::augment_args(Command::new("machband"));
        let find = |name: &str| command.get_arguments().find(|argument| argument.get_id() == name).cloned();
        let field = |(name, label, value, hint): &(&str, &'static str, String, &'static str)| {
            let argument = find(name)?;
            let default = argument.get_default_values().first().map(|value| value.to_string_lossy().into_owned());
            let value = if value.is_empty() { default.unwrap_or_default() } else { value.clone() };
            Some(Shown { label, argument, value, hint })
        };
        let fields = shown.iter().filter_map(field).collect();
        let given = given.iter().map(|(name, value)| ((*name).to_owned(), value.as_str().into())).collect();
        let start = Box::new(move |ctx: &Context, fields: &Map<_, _>| Ok(start(ctx, from_names(fields)?)));
        Self { title, action, about, fields, given, error: None, is_new: true, start }
    }

    /// Draws the dialog; starts what is requested once it is confirmed and possible.
    pub fn show(&mut self, ctx: &Context) -> Step<Job> {
        let entered = ui::entered(ctx);
        let (step, closed) = ui::modal(ctx, self.title, WIDTH, |ui, height| {
            ui.heading(self.title);
            ui::hint(ui, &self.about);
            ui.add_space(GAP);
            // The buttons stay in view in a low window.
            ScrollArea::vertical().max_height(height - BUTTONS).show(ui, |ui| {
                let wrong = self.error.as_ref().and_then(|error| error.field.as_deref());
                for field in &mut self.fields {
                    let is_next = wrong.is_none_or(|wrong| wrong == field.argument.get_id().as_str());
                    let text = field.show(ui, self.error.as_ref());
                    if let Some(text) = text.filter(|_| is_next && std::mem::take(&mut self.is_new)) {
                        text.request_focus();
                    }
                }
            });
            let of_none = self.error.iter().filter(|error| error.field.is_none());
            of_none.for_each(|error| ui::show_error(ui, error.to_string()));
            ui.horizontal(|ui| {
                let confirmed = primary(ui, self.action, true, "") || entered;
                let cancelled = ui.button("Cancel").clicked();
                if confirmed {
                    match self.start(ctx) {
                        Ok(job) => return Step::Next(job),
                        Err(error) => (self.error, self.is_new) = (Some(error), true),
                    }
                }
                Step::back_if(cancelled)
            })
            .inner
        });
        if closed { Step::Back } else { step }
    }

    /// Shows an error that was found after the dialog had closed; returns true if it is that of a field.
    pub fn refuse(&mut self, error: RequestError) -> bool {
        let is_of = |field: &Shown| error.field.as_deref() == Some(field.argument.get_id().as_str());
        let is_shown = self.fields.iter().any(is_of);
        (self.error, self.is_new) = (Some(error), true);
        is_shown
    }

    fn start(&self, ctx: &Context) -> Result<Job, RequestError> {
        let mut given = self.given.clone();
        given.extend(self.fields.iter().map(|field| (field.argument.get_id().to_string(), field.json())));
        (self.start)(ctx, &given)
    }
}

impl Shown {
    /// Draws the field; returns its response if it is a line of text.
    fn show(&mut self, ui: &mut Ui, error: Option<&RequestError>) -> Option<Response> {
        let error = error.filter(|error| error.field.as_deref() == Some(self.argument.get_id().as_str()));
        let error = error.map(|error| error.told(|_| String::new())).unwrap_or_default();
        let error = error.trim_start_matches([' ', ':']);
        let about = self.argument.get_help().map(ToString::to_string).unwrap_or_default();
        let choices = self.argument.get_possible_values();
        let names = self.argument.get_value_names().unwrap_or_default();
        let is_folder = names.first().is_some_and(|name| name == "DIR");
        let field = Field::new(self.label).column(LABELS).hint(self.hint).slot().error(error);
        if matches!(self.argument.get_action(), ArgAction::SetTrue) {
            let mut checked = self.value == "true";
            Field::new("").column(LABELS).slot().show(ui, |ui, _| {
                ui.checkbox(&mut checked, self.label).on_hover_text(about);
            });
            self.value = if checked { "true".to_owned() } else { String::new() };
        } else if !choices.is_empty() {
            let names: Vec<String> = choices.iter().map(|choice| choice.get_name().to_owned()).collect();
            let title = |name: &String| {
                let choice = choices.iter().find(|choice| choice.get_name() == name);
                choice.and_then(|choice| choice.get_help()).map_or_else(|| name.clone(), ToString::to_string)
            };
            field.choice(ui, &mut self.value, &names, title).on_hover_text(about);
        } else if is_folder {
            let browse = (FileKind::Folder, "Choose the folder…");
            field.path(ui, &mut self.value, browse).0.on_hover_text(about);
        } else {
            return Some(field.width(FIELD).text(ui, &mut self.value).on_hover_text(about));
        }
        None
    }

    /// Returns the value as the request takes it: a list for what can be repeated.
    fn json(&self) -> Value {
        let value = self.value.trim();
        let parts = value.split(',').map(str::trim).filter(|part| !part.is_empty());
        match (self.argument.get_action(), self.argument.get_value_delimiter()) {
            (ArgAction::SetTrue, _) => (value == "true").into(),
            (ArgAction::Append, None) => parts.collect(),
            (_, Some(_)) => parts.collect::<Vec<_>>().join(",").into(),
            _ if value.is_empty() => Value::Null,
            _ => value.into(),
        }
    }
}

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
