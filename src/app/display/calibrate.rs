//! What the tools share: settings, a full-screen run that can be paused and resumed, findings, and the profile to save.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Context, RichText, Ui, ViewportCommand};

use crate::{
    app::{
        analysis::TableView,
        ui::{
            Field, FileKind, Monitor, Saving, Step, figure::FigureView, hint, neutral_primary, paragraph, secondary,
            section, show_error, theme::ink, today, tool_page,
        },
    },
    display::{Channel, DisplayProfile, Measurement, Viewing},
    store::profile,
    system::found,
};

/// Width of the labels, and of a slider with its number, points.
pub const LABELS: f32 = 210.0;
pub const SLIDER: f32 = 240.0;

/// What a tool is about.
pub struct About {
    pub title: &'static str,
    /// What it finds out, for the list of tools.
    pub purpose: &'static str,
    /// How it measures, in a few sentences.
    pub introduction: &'static str,
    /// What is measured, in the plural.
    pub items: &'static str,
    /// The format of a file of measurements; `None` if they are not kept.
    pub format: Option<&'static str>,
}

/// A way to measure the screen.
pub trait Method {
    fn about(&self) -> About;

    /// Draws the settings of this method. `viewing` is the geometry of the screen, if it is known.
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
    fn read(&self, _file: &Path, _known: &DisplayProfile) -> Result<Findings, String> {
        Ok(Findings::default())
    }
}

/// A run that takes measurements, while the screen shows nothing else. Each one is saved to the file, if there is one,
/// before the next is requested.
pub trait Run {
    /// Draws a frame. Returns `Back` to pause, and `Next` when everything is measured: with the findings, or without them
    /// if they are in the file.
    fn show(&mut self, ui: &mut Ui, monitor: &Monitor) -> Step<Option<Findings>>;
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

/// The page of a tool: settings, then a run, then the findings.
pub struct Tool {
    method: Box<dyn Method>,
    pub about: About,
    /// What is known about the screen apart from these measurements.
    pub known: DisplayProfile,
    /// Path of the measurements.
    path: String,
    /// Why they cannot be read, or no run can begin; empty otherwise.
    error: String,
    /// Whether to measure red, green and blue, and whether to measure gray; `None` if nobody can choose.
    channels: Option<[bool; 2]>,
    /// The current run.
    run: Option<Box<dyn Run>>,
    /// The findings, once there are measurements, and the form of their profile.
    found: Option<(Findings, ProfileForm)>,
}

impl Tool {
    /// Creates the settings page. `channels` are the chosen ones, red, green and blue, and gray, if they can be chosen.
    pub fn new(method: impl Method + 'static, channels: Option<[bool; 2]>) -> Self {
        let (about, known, error) = (method.about(), DisplayProfile::default(), String::new());
        let path = format!("calibration/{}.csv", about.items);
        Self { method: Box::new(method), about, known, path, error, channels, run: None, found: None }
    }

    /// Draws the page. `viewing` is `None` if the viewing distance or the screen's width is unknown. `Next` leaves the page
    /// with the path of a profile that was written.
    pub fn show(&mut self, ui: &mut Ui, monitor: &Monitor, viewing: Option<&Viewing>) -> Step<PathBuf> {
        let Some(run) = &mut self.run else {
            return if self.found.is_some() { self.show_findings(ui) } else { self.set_up(ui, viewing) };
        };
        match run.show(ui, monitor) {
            Step::Stay => {}
            Step::Back => self.pause(ui.ctx()),
            Step::Next(found) => {
                // Pausing a finished run closes its file before the file is read.
                self.pause(ui.ctx());
                let read = || self.method.read(&self.source(), &self.known);
                let advice = "\nTo measure a patch again, delete its line in the file and resume.";
                self.finish(found.map_or_else(read, Ok).map_err(|errors| errors + advice));
            }
        }
        Step::Stay
    }

    /// Returns whether the screen is measured, which then shows nothing else.
    pub fn measures(&self) -> bool {
        self.run.is_some()
    }

    /// Pauses the measurement. Everything so far is in the file, if there is one.
    pub fn pause(&mut self, ctx: &Context) {
        if self.run.take().is_some() {
            full_screen(ctx, false);
        }
    }

    fn source(&self) -> PathBuf {
        PathBuf::from(self.path.trim())
    }

    fn finish(&mut self, found: Result<Findings, String>) {
        self.error.clear();
        match found {
            Ok(found) => {
                let form = ProfileForm::new(&self.known, &found.instrument);
                self.found = Some((found, form));
            }
            Err(errors) => self.error = errors,
        }
    }

    /// Draws the settings.
    fn set_up(&mut self, ui: &mut Ui, viewing: Option<&Viewing>) -> Step<PathBuf> {
        let (mut begin, mut use_file) = (false, false);
        let About { title, introduction, items, format, .. } = self.about;
        let back = tool_page(ui, title, |ui| {
            paragraph(ui, introduction);
            ui.add_space(8.0);
            let is_there =
                format.is_some() && found(&self.source()).is_ok_and(|at| at.is_some_and(|file| file.is_file()));
            if format.is_some() {
                self.file_field(ui, is_there);
            }
            if let Some([colors, gray]) = &mut self.channels {
                Field::new("Channels").column(LABELS).show(ui, |ui, _| {
                    ui.horizontal(|ui| {
                        ui.checkbox(colors, "red, green, blue");
                        ui.checkbox(gray, "gray");
                    });
                });
            }
            self.method.fields(ui, viewing);
            let estimate = match self.path.trim() {
                "" => Err(format!("No file is given for the {items}; expected a path.")),
                _ => self.method.estimate(&self.channels()),
            };
            match &estimate {
                Ok((count, seconds)) if *seconds < 60.0 => hint(ui, format!("{count} {items}, about {seconds:.0} s.")),
                Ok((count, seconds)) => hint(ui, format!("{count} {items}, about {:.0} min.", (seconds / 60.0).ceil())),
                Err(message) => show_error(ui, message),
            }
            let text = if is_there { "Resume" } else { "Begin" };
            let ends = if format.is_some() { "pause" } else { "stop" };
            begin = neutral_primary(ui, text, estimate.is_ok(), &format!("Full screen. Press Esc to {ends}."));
            if let Some(format) = format {
                use_file = ui.add_enabled(is_there, egui::Button::new("Use this file")).clicked();
                hint(ui, format);
            }
        });
        if use_file {
            self.finish(self.method.read(&self.source(), &self.known));
        }
        if begin {
            match self.method.begin(&self.channels(), &self.source()) {
                Ok(run) => {
                    self.run = Some(run);
                    self.error.clear();
                    full_screen(ui.ctx(), true);
                }
                Err(error) => self.error = error,
            }
        }
        if use_file || begin {
            ui.ctx().request_repaint();
        }
        Step::back_if(back)
    }

    fn file_field(&mut self, ui: &mut Ui, is_there: bool) {
        let note = "This file exists already. To resume, keep the settings. To start over, enter another file.";
        let note = if is_there { note } else { "" };
        let field = Field::new("File of measurements").column(LABELS).slot().error(&self.error).note(note, false);
        let (field, chosen) = field.path(ui, &mut self.path, (FileKind::Data, "Choose a file…"));
        if chosen || field.changed() {
            self.error.clear();
        }
    }

    fn channels(&self) -> Vec<Channel> {
        let [colors, gray] = self.channels.unwrap_or_default();
        let wanted = |channel: &Channel| if *channel == Channel::Gray { gray } else { colors };
        Channel::ALL.iter().copied().filter(wanted).collect()
    }

    fn show_findings(&mut self, ui: &mut Ui) -> Step<PathBuf> {
        let Some((found, form)) = &mut self.found else { return Step::Stay };
        let mut saved = None;
        let back = tool_page(ui, "Result", |ui| {
            if self.about.format.is_some() {
                paragraph(ui, secondary(self.path.trim()));
            }
            for (text, warns) in &found.told {
                let color = if *warns { ink(ui).warn } else { ink(ui).text };
                paragraph(ui, RichText::new(text).color(color));
            }
            saved = found.profile.as_ref().and_then(|profile| form.show(ui, profile));
            ui.add_space(8.0);
            found.figure.iter_mut().for_each(|figure| figure.show(ui));
            found.tables.iter_mut().enumerate().for_each(|(id, table)| table.show(ui, id));
        });
        if back || saved.is_some() {
            self.found = None;
            ui.ctx().request_repaint();
        }
        saved.map_or(Step::Stay, Step::Next)
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
    fn new(known: &DisplayProfile, with: &str) -> Self {
        let name = if known.measured.is_some() { known.name.clone() } else { UNNAMED.to_owned() };
        let by = known.measured.clone().and_then(|measured| measured.by).unwrap_or_default();
        Self { name, by, with: with.to_owned(), saving: Saving::to("calibration/screen.toml") }
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
fn full_screen(ctx: &Context, on: bool) {
    ctx.send_viewport_cmd(ViewportCommand::Fullscreen(on));
    ctx.request_repaint();
}
