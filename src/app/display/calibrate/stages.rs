//! The stages of a calibration: settings, the run on the full screen, what was found, and a check of it.

use std::path::{Path, PathBuf};

use eframe::egui::{self, ViewportCommand};

use super::profile_form::{ProfileForm, SavedProfile, file_name};
use crate::{
    app::{
        display::check::CheckPage,
        ui::{Ask, Dialog, Field, Step, fault, hint, paragraph, primary, quiet, section, tool_page},
    },
    display::{Channel, DisplayProfile, Viewing},
};

/// A way to measure the light of a screen.
pub trait Method {
    /// Takes the measurements.
    type Run: Run;
    /// What they say.
    type Findings: Findings;

    /// Name of the page.
    const TITLE: &'static str;
    /// What is done, in a sentence or two.
    const INTRODUCTION: &'static str;
    /// What is measured, in the plural: readings, matches.
    const ITEMS: &'static str;
    /// What a file of them looks like.
    const FORMAT: &'static str;
    /// The button that begins.
    const BEGIN: &'static str;

    /// The settings of this method.
    fn fields(&mut self, ui: &mut egui::Ui, viewing: Option<&Viewing>);

    /// Number of items and seconds that they take.
    ///
    /// # Errors
    /// Settings that cannot be run.
    fn extent(&self, channels: &[Channel]) -> Result<(usize, f64), String>;

    /// Begins a run, or resumes the one that is in the file.
    ///
    /// # Errors
    /// Settings that cannot be run; a file of other settings, or one that cannot be written.
    fn begin(&self, channels: &[Channel], file: &Path) -> Result<Self::Run, String>;
}

/// Measurements that are being taken. Each is in the file before the next is asked for.
pub trait Run {
    /// Draws a frame: back to pause, next when all is measured.
    fn show(&mut self, ui: &mut egui::Ui) -> Step<()>;

    /// Items measured, and all.
    fn progress(&self) -> (usize, usize);

    /// Items that are to be measured again before a profile can be made of them.
    fn questionable(&self) -> Vec<usize> {
        Vec::new()
    }

    /// Measures some items again.
    fn repeat(&mut self, _: &[usize]) {}
}

/// What measurements say.
pub trait Findings: Sized {
    /// Reads a file of measurements.
    ///
    /// # Errors
    /// Why no profile can be made of it, a line a fault.
    fn read(path: &Path) -> Result<Self, String>;

    /// In a few lines, with any choice that is left.
    fn summary(&mut self, ui: &mut egui::Ui);

    /// Plots and tables.
    fn details(&self, ui: &mut egui::Ui);

    /// What is known of the screen, with what was found; `None` where that is too little.
    fn profile(&self, known: &DisplayProfile) -> Option<DisplayProfile>;

    /// What the screen was measured with.
    fn instrument(&self) -> String;
}

/// The page of a method.
pub struct Calibrate<M: Method> {
    /// What is known of the screen besides what this measures.
    known: DisplayProfile,
    method: M,
    /// Of the screen.
    name: String,
    /// Where the measurements go; follows the name until another is typed.
    path: String,
    /// Red, green and blue; gray.
    channels: [bool; 2],
    /// A file of measurements to use.
    file: String,
    dialog: Dialog,
    fault: Option<String>,
    /// The file of a run that was left, how many items were measured, and how many there are.
    paused: Option<(PathBuf, usize, usize)>,
    stage: Stage<M>,
}

enum Stage<M: Method> {
    SetUp,
    Running(Box<M::Run>),
    /// What was found, and the run to go back to where it was taken here.
    Found(Box<Outcome<M::Findings>>, Option<Box<M::Run>>),
    Check(Box<Outcome<M::Findings>>, Option<Box<M::Run>>, Box<CheckPage>),
}

struct Outcome<F> {
    source: PathBuf,
    found: Result<(F, ProfileForm), String>,
}

/// Where the settings lead.
enum Begin<R> {
    Run(Box<R>),
    File(PathBuf),
}

/// Where the findings lead.
enum Onward {
    Saved(SavedProfile),
    Check(Box<DisplayProfile>),
    Repeat(Vec<usize>),
}

impl<M: Method> Calibrate<M> {
    /// For the screen that `known` describes so far.
    pub fn new(method: M, known: DisplayProfile, channels: [bool; 2]) -> Self {
        let name = if known.measured.is_some() { known.name.clone() } else { "My screen".to_owned() };
        let path = suggested(&name, M::ITEMS);
        let (file, dialog) = Default::default();
        let (fault, paused, stage) = (None, None, Stage::SetUp);
        Self { known, method, name, path, channels, file, dialog, fault, paused, stage }
    }

    /// Takes what is known of the screen by now.
    pub fn update(&mut self, known: DisplayProfile) {
        self.known = known;
    }

    /// Draws the stage. `viewing` says from where the screen is seen.
    pub fn show(&mut self, ui: &mut egui::Ui, viewing: Option<&Viewing>) -> Step<SavedProfile> {
        match std::mem::replace(&mut self.stage, Stage::SetUp) {
            Stage::SetUp => match self.set_up(ui, viewing) {
                Step::Stay => return Step::Stay,
                Step::Back => return Step::Back,
                Step::Next(Begin::Run(run)) => self.run(ui, run),
                Step::Next(Begin::File(path)) => self.stage = Stage::Found(self.outcome(path), None),
            },
            Stage::Running(mut run) => match run.show(ui) {
                Step::Stay => {
                    self.stage = Stage::Running(run);
                    return Step::Stay;
                }
                Step::Back => {
                    let (done, all) = run.progress();
                    self.paused = Some((PathBuf::from(self.path.trim()), done, all));
                    full_screen(ui, false);
                }
                Step::Next(()) => {
                    self.paused = None;
                    full_screen(ui, false);
                    // A run that is over lets go of its file before that is read.
                    let questionable = (!run.questionable().is_empty()).then_some(run);
                    self.stage = Stage::Found(self.outcome(PathBuf::from(self.path.trim())), questionable);
                }
            },
            Stage::Found(mut outcome, run) => match outcome.show(ui, run.as_deref(), &self.known) {
                Step::Stay => {
                    self.stage = Stage::Found(outcome, run);
                    return Step::Stay;
                }
                Step::Back => {}
                Step::Next(Onward::Saved(saved)) => return Step::Next(saved),
                Step::Next(Onward::Check(profile)) => {
                    self.stage = Stage::Check(outcome, run, Box::new(CheckPage::new(*profile)));
                }
                Step::Next(Onward::Repeat(items)) => {
                    if let Some(mut run) = run {
                        run.repeat(&items);
                        self.run(ui, run);
                    }
                }
            },
            Stage::Check(outcome, run, mut check) => match check.show(ui) {
                Step::Back => self.stage = Stage::Found(outcome, run),
                _ => {
                    self.stage = Stage::Check(outcome, run, check);
                    return Step::Stay;
                }
            },
        }
        ui.ctx().request_repaint();
        Step::Stay
    }

    fn run(&mut self, ui: &egui::Ui, run: Box<M::Run>) {
        full_screen(ui, true);
        self.stage = Stage::Running(run);
    }

    fn outcome(&self, source: PathBuf) -> Box<Outcome<M::Findings>> {
        let found = M::Findings::read(&source).map(|found: M::Findings| {
            let form = ProfileForm::new(self.name.trim(), &self.known, found.instrument());
            (found, form)
        });
        Box::new(Outcome { source, found })
    }

    fn channels(&self) -> Vec<Channel> {
        let [colors, gray] = self.channels;
        let wanted = |channel: &Channel| if *channel == Channel::Gray { gray } else { colors };
        Channel::ALL.into_iter().filter(wanted).collect()
    }

    fn set_up(&mut self, ui: &mut egui::Ui, viewing: Option<&Viewing>) -> Step<Begin<M::Run>> {
        let (mut begin, mut use_file) = (false, false);
        let (back, ()) = tool_page(ui, M::TITLE, |ui| {
            paragraph(ui, M::INTRODUCTION);
            ui.add_space(8.0);
            if Field::new("Name of the screen").width(260.0).text(ui, &mut self.name).changed() {
                self.path = suggested(&self.name, M::ITEMS);
            }
            Field::new("Keep the measurements in").width(380.0).text(ui, &mut self.path);
            Field::new("Channels").show(ui, |ui, _| {
                ui.checkbox(&mut self.channels[0], "red, green, blue");
                ui.checkbox(&mut self.channels[1], "gray");
            });
            self.method.fields(ui, viewing);
            let extent = self.extent();
            match &extent {
                Ok((items, seconds)) => {
                    let minutes = (seconds / 60.0).ceil();
                    hint(ui, format!("{items} {}, about {minutes} min.", M::ITEMS));
                }
                Err(message) => fault(ui, message),
            }
            let begun = self.begun();
            let text = if begun.is_some() { "Resume" } else { M::BEGIN };
            begun.iter().for_each(|sentence| hint(ui, sentence));
            begin = primary(ui, text, extent.is_ok(), "fills the screen; Esc pauses");
            self.fault.iter().for_each(|message| fault(ui, message));
            use_file = self.file_field(ui);
        });
        if back {
            return Step::Back;
        }
        if use_file {
            return Step::Next(Begin::File(PathBuf::from(self.file.trim())));
        }
        if !begin {
            return Step::Stay;
        }
        match self.method.begin(&self.channels(), Path::new(self.path.trim())) {
            Ok(run) => {
                self.fault = None;
                Step::Next(Begin::Run(Box::new(run)))
            }
            Err(message) => {
                self.fault = Some(message);
                Step::Stay
            }
        }
    }

    fn extent(&self) -> Result<(usize, f64), String> {
        if self.path.trim().is_empty() {
            return Err(format!("The {} have no file; expected a path.", M::ITEMS));
        }
        self.method.extent(&self.channels())
    }

    /// That the file has measurements already; `None` where it is a new one.
    fn begun(&self) -> Option<String> {
        let path = Path::new(self.path.trim());
        match &self.paused {
            Some((left, done, all)) if left == path => {
                Some(format!("Paused after {done} of {all}. They are saved; keep the settings to resume."))
            }
            _ => path.is_file().then(|| {
                format!(
                    "This file already has {}. Keep the settings to resume, or name another file to start over.",
                    M::ITEMS
                )
            }),
        }
    }

    fn file_field(&mut self, ui: &mut egui::Ui) -> bool {
        section(ui, format!("Or use {} from a file", M::ITEMS));
        hint(ui, M::FORMAT);
        let label = format!("File of {}", M::ITEMS);
        Field::new(&label).show(ui, |ui, label| {
            ui.add(egui::TextEdit::singleline(&mut self.file).desired_width(300.0)).labelled_by(label);
            self.dialog.browse(ui, Ask::Data, "Choose a file…", &mut self.file);
            ui.add_enabled(!self.file.trim().is_empty(), egui::Button::new("Use this file")).clicked()
        })
    }
}

impl<F: Findings> Outcome<F> {
    fn show<R: Run>(&mut self, ui: &mut egui::Ui, run: Option<&R>, known: &DisplayProfile) -> Step<Onward> {
        let source = self.source.display().to_string();
        let (back, onward) = tool_page(ui, "Result", |ui| {
            paragraph(ui, quiet(source));
            match &mut self.found {
                Ok((found, form)) => show_found(ui, found, form, known),
                Err(faults) => {
                    ui.label("These measurements do not make a profile:");
                    faults.lines().for_each(|line| fault(ui, line));
                    let items = run.map(Run::questionable).unwrap_or_default();
                    let again = !items.is_empty() && ui.button(format!("Measure {} again", items.len())).clicked();
                    again.then_some(Onward::Repeat(items))
                }
            }
        });
        match onward {
            _ if back => Step::Back,
            Some(onward) => Step::Next(onward),
            None => Step::Stay,
        }
    }
}

fn show_found<F: Findings>(
    ui: &mut egui::Ui,
    found: &mut F,
    form: &mut ProfileForm,
    known: &DisplayProfile,
) -> Option<Onward> {
    found.summary(ui);
    let mut onward = None;
    if let Some(profile) = found.profile(known) {
        onward = form.show(ui, &profile).map(Onward::Saved);
        if ui.button("Check on the screen…").clicked() {
            onward = Some(Onward::Check(Box::new(form.filled(&profile))));
        }
    }
    ui.add_space(8.0);
    found.details(ui);
    onward
}

/// Where measurements of a screen go unless told otherwise.
fn suggested(name: &str, items: &str) -> String {
    format!("calibration/{}_{items}.csv", file_name(name))
}

fn full_screen(ui: &egui::Ui, on: bool) {
    ui.ctx().send_viewport_cmd(ViewportCommand::Fullscreen(on));
}
