//! What the tools have in common, and the stages that the photometer and matching by eye share: settings, a full-screen
//! run that can be paused and resumed, findings, and the profile to save.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Color32, Context, Ui, ViewportCommand};

use crate::{
    app::{
        analysis::TableView,
        ui::{
            Field, FileKind, Monitor, Saving, Step, figure::FigureView, hint, neutral_primary, note, paragraph,
            secondary, section, show_error, text, today, tool_page,
        },
    },
    display::{Channel, DisplayProfile, Measurement, Viewing},
    store::profile,
    system::found,
};

/// Width of the labels, and of a slider with its number, points.
pub const LABELS: f32 = 210.0;
pub const SLIDER: f32 = 240.0;

/// A page that measures the screen.
pub trait Tool {
    /// Draws the page. `viewing` is the geometry of the screen, if it is known. `Next` leaves the page with the path of a
    /// profile that was written.
    fn show(&mut self, ui: &mut Ui, monitor: &Monitor, viewing: Option<&Viewing>) -> Step<PathBuf>;

    /// Returns the background color while the screen is measured, which then shows nothing else; `None` for a page.
    fn ground(&self) -> Option<Color32>;

    /// Pauses the measurement; that of frames ends.
    fn pause(&mut self, _: &Context);

    /// Begins with what is known about the screen.
    fn open(&mut self, _: DisplayProfile) {}
}

/// A way to measure the light of a screen.
pub trait Method {
    const TITLE: &'static str;
    /// A description of the method, in a few sentences.
    const INTRODUCTION: &'static str;
    /// The plural noun for what is measured: readings or matches.
    const ITEMS: &'static str;
    /// The format of a measurement file.
    const FORMAT: &'static str;
    /// Whether channels can be chosen.
    const HAS_CHANNELS: bool = true;

    /// Draws the settings of this method.
    fn fields(&mut self, ui: &mut Ui, viewing: Option<&Viewing>);

    /// Returns the number of items to measure, and how long that takes in seconds.
    ///
    /// # Errors
    /// If a run with these settings is not possible.
    fn estimate(&self, channels: &[Channel]) -> Result<(usize, f64), String>;

    /// Begins a run, or resumes the one in the file.
    ///
    /// # Errors
    /// If a run with these settings is not possible, or if the file has other settings or cannot be written.
    fn begin(&self, channels: &[Channel], file: &Path) -> Result<Box<dyn Run>, String>;

    /// Returns what a file of measurements says about a screen, of which the rest is known.
    ///
    /// # Errors
    /// The reasons why no profile can be made from the file, one per line.
    fn read(file: &Path, known: &DisplayProfile) -> Result<Findings, String>;
}

/// A run that takes measurements. Each one is saved to the file before the next is requested.
pub trait Run {
    /// Draws a frame. Returns `Back` to pause, and `Next` when everything is measured.
    fn show(&mut self, ui: &mut Ui) -> Step<()>;
}

/// What a method finds from its measurements.
#[derive(Default)]
pub struct Findings {
    /// What is said about them, and whether it deserves attention.
    pub told: Vec<(String, bool)>,
    pub figure: Option<FigureView>,
    pub tables: Vec<TableView>,
    /// The known profile with what was found; `None` if that is not enough, or not for a profile.
    pub profile: Option<DisplayProfile>,
    /// What measured, for the profile.
    pub instrument: String,
}

/// A file of measurements, and either the findings with the profile's form, or the errors.
type Found = (PathBuf, Result<(Findings, ProfileForm), String>);

/// The page of a method: settings, then a run, then the findings.
pub struct Calibrate<M: Method> {
    /// What is known about the screen apart from these measurements.
    known: DisplayProfile,
    method: M,
    /// Path of the measurements.
    path: String,
    /// Why they cannot be read, or no run can begin; empty otherwise.
    error: String,
    /// Whether to measure red, green and blue, and whether to measure gray.
    channels: [bool; 2],
    /// The current run.
    run: Option<Box<dyn Run>>,
    /// The findings, once there are measurements.
    found: Option<Found>,
}

impl<M: Method> Calibrate<M> {
    /// Creates the settings page, on which these channels are chosen: red, green and blue; gray.
    pub fn new(method: M, channels: [bool; 2]) -> Self {
        let (known, path) = (DisplayProfile::default(), format!("calibration/{}.csv", M::ITEMS));
        Self { known, method, path, error: String::new(), channels, run: None, found: None }
    }

    /// Draws the settings. `viewing` is `None` if the viewing distance or the screen's width is unknown.
    fn set_up(&mut self, ui: &mut Ui, viewing: Option<&Viewing>) -> bool {
        let (mut begin, mut use_file) = (false, false);
        let back = tool_page(ui, M::TITLE, |ui| {
            paragraph(ui, M::INTRODUCTION);
            ui.add_space(8.0);
            let file = found(Path::new(self.path.trim()));
            let is_there = file.is_ok_and(|file| file.is_some_and(|file| file.is_file()));
            let note = "This file exists already. To resume, keep the settings. To start over, enter another file.";
            let note = if is_there { note } else { "" };
            let field = Field::new("File of measurements").column(LABELS).slot().error(&self.error).note(note, false);
            let (field, chosen) = field.path(ui, &mut self.path, (FileKind::Data, "Choose a file…"));
            if chosen || field.changed() {
                self.error.clear();
            }
            if M::HAS_CHANNELS {
                Field::new("Channels").column(LABELS).show(ui, |ui, _| {
                    ui.horizontal(|ui| {
                        ui.checkbox(&mut self.channels[0], "red, green, blue");
                        ui.checkbox(&mut self.channels[1], "gray");
                    });
                });
            }
            self.method.fields(ui, viewing);
            let estimate = match self.path.trim() {
                "" => Err(format!("No file is given for the {}; expected a path.", M::ITEMS)),
                _ => self.method.estimate(&self.channels()),
            };
            match &estimate {
                Ok((items, seconds)) => {
                    hint(ui, format!("{items} {}, about {:.0} min.", M::ITEMS, (seconds / 60.0).ceil()));
                }
                Err(message) => show_error(ui, message),
            }
            let text = if is_there { "Resume" } else { "Begin" };
            begin = neutral_primary(ui, text, estimate.is_ok(), "Full screen. Press Esc to pause.");
            use_file = ui.add_enabled(is_there, egui::Button::new("Use this file")).clicked();
            hint(ui, M::FORMAT);
        });
        let source = PathBuf::from(self.path.trim());
        let done = if use_file {
            self.findings(&source).map(|found| self.found = Some((source, Ok(found))))
        } else if begin {
            self.method.begin(&self.channels(), &source).map(|run| {
                full_screen(ui.ctx(), true);
                self.run = Some(run);
            })
        } else {
            return back;
        };
        self.error = done.err().unwrap_or_default();
        ui.ctx().request_repaint();
        back
    }

    fn channels(&self) -> Vec<Channel> {
        let [colors, gray] = self.channels;
        let wanted = |channel: &Channel| if *channel == Channel::Gray { gray } else { colors };
        Channel::ALL.iter().copied().filter(wanted).collect()
    }

    fn show_run(&mut self, ui: &mut Ui) {
        match self.run.as_mut().map(|run| run.show(ui)) {
            None | Some(Step::Stay) => {}
            Some(Step::Back) => self.pause(ui.ctx()),
            Some(Step::Next(())) => {
                // Dropping a finished run closes its file before the file is read.
                self.run = None;
                let source = PathBuf::from(self.path.trim());
                self.found = Some((source.clone(), self.findings(&source)));
                full_screen(ui.ctx(), false);
            }
        }
    }

    fn findings(&self, source: &Path) -> Result<(Findings, ProfileForm), String> {
        let found = M::read(source, &self.known)?;
        let form = ProfileForm::new(&self.known, found.instrument.clone());
        Ok((found, form))
    }

    fn show_findings(&mut self, ui: &mut Ui) -> Step<PathBuf> {
        let Some((source, result)) = &mut self.found else { return Step::Stay };
        let mut saved = None;
        let back = tool_page(ui, "Result", |ui| {
            paragraph(ui, secondary(source.display().to_string()));
            match result {
                Ok((found, form)) => {
                    for (text, warns) in &found.told {
                        if *warns { note(ui, text) } else { paragraph(ui, text) }
                    }
                    saved = found.profile.as_ref().and_then(|profile| form.show(ui, profile));
                    ui.add_space(8.0);
                    found.figure.iter_mut().for_each(|figure| figure.show(ui));
                    found.tables.iter_mut().enumerate().for_each(|(id, table)| table.show(ui, id));
                }
                Err(errors) => {
                    ui.label("No profile can be made from these measurements:");
                    text::errors(ui, errors);
                    hint(ui, "To measure a patch again, delete its line in the file and resume.");
                }
            }
        });
        if back || saved.is_some() {
            self.found = None;
            ui.ctx().request_repaint();
        }
        saved.map_or(Step::Stay, Step::Next)
    }
}

impl<M: Method> Tool for Calibrate<M> {
    fn show(&mut self, ui: &mut Ui, _: &Monitor, viewing: Option<&Viewing>) -> Step<PathBuf> {
        if self.found.is_some() {
            self.show_findings(ui)
        } else if self.run.is_some() {
            self.show_run(ui);
            Step::Stay
        } else {
            Step::back_if(self.set_up(ui, viewing))
        }
    }

    fn ground(&self) -> Option<Color32> {
        self.run.is_some().then_some(Color32::BLACK)
    }

    fn pause(&mut self, ctx: &Context) {
        // Everything so far is in the file.
        if self.run.take().is_some() {
            full_screen(ctx, false);
        }
    }

    fn open(&mut self, known: DisplayProfile) {
        self.known = known;
    }
}

/// The name of a screen that has none yet.
const UNNAMED: &str = "My screen";

/// The form for the details of a profile to save: name, person, instrument and file.
struct ProfileForm {
    name: String,
    by: String,
    with: String,
    saving: Saving,
}

impl ProfileForm {
    fn new(known: &DisplayProfile, with: String) -> Self {
        let name = if known.measured.is_some() { known.name.clone() } else { UNNAMED.to_owned() };
        let by = known.measured.clone().and_then(|measured| measured.by).unwrap_or_default();
        Self { name, by, with, saving: Saving::to("calibration/screen.toml") }
    }

    /// Draws the fields and the button; returns the path of the profile once it is written.
    fn show(&mut self, ui: &mut Ui, found: &DisplayProfile) -> Option<PathBuf> {
        section(ui, "Profile");
        for (label, value) in [
            ("Name of the screen", &mut self.name),
            ("Measured by", &mut self.by),
            ("Measured with", &mut self.with),
            ("Save as", &mut self.saving.typed),
        ] {
            Field::new(label).column(LABELS).width(340.0).text(ui, value);
        }
        let mut saved = None;
        let filled = self.filled(found);
        self.saving.export(ui, "Save the profile", &["toml"], |writer, path, _| {
            if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
                writer.make_folder(folder)?;
            }
            profile::write(writer, path, &filled)?;
            saved = Some(path.to_owned());
            Ok(())
        });
        hint(ui, "The program then uses this profile.");
        if saved.is_none() {
            self.saving.show(ui);
        }
        saved
    }

    /// Returns the profile with the details that the user typed.
    fn filled(&self, found: &DisplayProfile) -> DisplayProfile {
        let some = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
        let measured = Measurement { on: Some(today()), by: some(&self.by), with: some(&self.with) };
        let name = some(&self.name).unwrap_or_else(|| UNNAMED.to_owned());
        DisplayProfile { name, measured: Some(measured), ..found.clone() }
    }
}

/// Makes the window fill the screen, or not.
pub fn full_screen(ctx: &Context, on: bool) {
    ctx.send_viewport_cmd(ViewportCommand::Fullscreen(on));
    ctx.request_repaint();
}
