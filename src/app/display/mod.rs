//! The display: what is known of the screen, and the tools that find it out. One tool a file or folder; each leads back
//! here.

pub mod card;
mod check;
mod geometry;
mod matching;
mod photometer;
mod picture;
mod steps;
pub mod timing;

use std::path::{Path, PathBuf};

use eframe::egui::{self, Key, RichText};

use self::{
    check::CheckScreen, geometry::GeometryPane, matching::NullingPane, photometer::PhotometerPane, steps::StepsPane,
    timing::pane::TimingPane,
};
use super::{
    Go, Monitor,
    dialog::{Ask, Dialog},
    theme,
    ui::{ScreenFields, number as parse, today},
};
use crate::{
    display::{DisplayProfile, Screen, Viewing},
    store::{StoreError, profile},
};

/// Where a tool leads.
pub enum ToolGo {
    /// Nowhere yet.
    Stay,
    /// Back to the list of tools.
    Back,
    /// Back, with a profile that was written.
    Saved(Saved),
}

/// A profile that was written.
pub struct Saved {
    path: PathBuf,
    /// In the place of another.
    replaced: bool,
}

impl Saved {
    /// Writes a profile and tells whether one was there before.
    ///
    /// # Errors
    /// The system's refusal.
    pub fn write(path: PathBuf, made: &DisplayProfile) -> Result<Self, StoreError> {
        let replaced = path.exists();
        profile::write(&path, made)?;
        Ok(Self { path, replaced })
    }
}

/// The tool that is open.
enum Tool {
    Geometry(Box<GeometryPane>),
    Photometer(Box<PhotometerPane>),
    Nulling(Box<NullingPane>),
    Check(Box<CheckScreen>),
    Steps(Box<StepsPane>),
    Timing(Box<TimingPane>),
}

/// The page.
pub struct Display {
    /// Home's fields: the profile's path, the screen's width and the distance are set here too.
    form: ScreenFields,
    /// Side of the planned stimulus, degrees.
    window_deg: f64,
    /// The path that `profile` was read from, and what was found there.
    read: Option<(String, Result<DisplayProfile, String>)>,
    tool: Option<Tool>,
    dialog: Dialog,
    /// What a tool wrote; told for as long as it is in use.
    saved: Option<Saved>,
    /// Patches that were left before all were read, to be gone on with.
    paused: Option<Box<PhotometerPane>>,
}

impl Display {
    /// The tools, with what Home's fields say.
    pub fn new(form: ScreenFields, window_deg: f64) -> Self {
        Self { form, window_deg, read: None, tool: None, dialog: Dialog::default(), saved: None, paused: None }
    }

    /// Home's fields, as they are now.
    pub fn form(&self) -> &ScreenFields {
        &self.form
    }

    /// What stands behind everything.
    pub fn ground(&self) -> egui::Color32 {
        match &self.tool {
            Some(Tool::Timing(pane)) => pane.ground().unwrap_or(theme::PAGE),
            _ => theme::PAGE,
        }
    }

    /// Draws the tool that is open, or the list of them.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor) -> Go {
        let go = match &mut self.tool {
            Some(Tool::Geometry(pane)) => {
                let go = pane.show(ui, monitor);
                let (width, distance) = pane.typed();
                width.clone_into(&mut self.form.screen_width_cm);
                distance.clone_into(&mut self.form.distance_cm);
                go
            }
            Some(Tool::Photometer(pane)) => pane.show(ui),
            Some(Tool::Nulling(pane)) => pane.show(ui, monitor),
            Some(Tool::Check(pane)) => pane.show(ui, monitor),
            Some(Tool::Steps(pane)) => pane.show(ui, monitor),
            Some(Tool::Timing(pane)) => pane.show(ui, monitor),
            None => return self.list(ui, monitor),
        };
        match go {
            ToolGo::Stay => return Go::Stay,
            ToolGo::Back => {}
            ToolGo::Saved(saved) => {
                self.form.profile = saved.path.display().to_string();
                // What was there before is no longer what is there.
                self.read = None;
                self.saved = Some(saved);
            }
        }
        self.paused = match self.tool.take() {
            Some(Tool::Photometer(pane)) => Some(pane).filter(|pane| pane.is_paused()),
            _ => self.paused.take(),
        };
        ui.ctx().request_repaint();
        Go::Stay
    }

    /// The profile that Home names, sRGB where it names none or one that cannot be read.
    fn profile(&mut self) -> Result<DisplayProfile, String> {
        let path = self.form.profile.trim().to_owned();
        match &self.read {
            Some((read, found)) if *read == path => found.clone(),
            _ => {
                let found = match path.as_str() {
                    "" => Ok(DisplayProfile::default()),
                    path => profile::open(Path::new(path)).map_err(|error| error.to_string()),
                };
                self.read = Some((path, found.clone()));
                found
            }
        }
    }

    /// Screen and distance, where both are known.
    fn viewing(&self, monitor: &Monitor) -> Option<Viewing> {
        let screen = Screen::new(monitor.width_px, monitor.height_px, parse(&self.form.screen_width_cm)?).ok()?;
        Viewing::new(screen, parse(&self.form.distance_cm)?).ok()
    }

    fn list(&mut self, ui: &mut egui::Ui, monitor: &Monitor) -> Go {
        if let Some(path) = self.dialog.take() {
            self.form.profile = path.display().to_string();
        }
        let found = self.profile();
        let mut back = false;
        let mut chosen = None;
        tool(ui, "Display", &mut back, |ui| {
            ui.label(
                "What reaches the eye is light, not codes. A profile says how much light this screen makes of each.",
            );
            ui.add_space(8.0);
            self.profile_field(ui, &found);
            ui.add_space(8.0);
            for (name, what, make) in TOOLS {
                ui.add_space(4.0);
                if ui.add(egui::Button::new(RichText::new(*name).strong()).min_size([260.0, 34.0].into())).clicked() {
                    chosen = Some(make);
                }
                ui.add(egui::Label::new(theme::quiet(*what)).wrap());
            }
        });
        if let Some(make) = chosen {
            let profile = found.unwrap_or_default();
            self.saved = None;
            self.tool = Some(make(self, profile, monitor));
            ui.ctx().request_repaint();
        }
        if back || ui.input(|input| input.key_pressed(Key::Escape)) { Go::Back } else { Go::Stay }
    }

    fn profile_field(&mut self, ui: &mut egui::Ui, found: &Result<DisplayProfile, String>) {
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Profile in use");
            let field =
                egui::TextEdit::singleline(&mut self.form.profile).desired_width(300.0).hint_text("sRGB, assumed");
            ui.add(field).labelled_by(label.id);
            if ui.button("Browse…").clicked() {
                self.dialog.open(ui.ctx(), Ask::Toml);
            }
        });
        match found {
            Ok(profile) => {
                ui.add(egui::Label::new(theme::quiet(format!("{}.", profile.sentence()))).wrap());
                // An assumption says so itself.
                if profile.measured.is_some()
                    && let Some(doubt) = profile.doubt(today())
                {
                    ui.add(egui::Label::new(RichText::new(doubt).small().color(theme::NOTE)).wrap());
                }
            }
            Err(faults) => faults.lines().for_each(|fault| theme::fault(ui, fault)),
        }
        self.saved = self.saved.take().filter(|saved| self.form.profile.trim() == saved.path.display().to_string());
        if let Some(Saved { path, replaced }) = &self.saved {
            let path = path.display();
            let said =
                if *replaced { format!("Replaced {path}; in use.") } else { format!("Saved as {path}, and in use.") };
            ui.add(egui::Label::new(RichText::new(said).small().color(theme::GOOD)).wrap());
        }
    }
}

/// A tool's name, what it is for, and how it begins.
type Entry = (&'static str, &'static str, fn(&mut Display, DisplayProfile, &Monitor) -> Tool);

/// All tools, in the order in which a new screen needs them.
const TOOLS: &[Entry] = &[
    (
        "Size and distance",
        "How wide the screen is, by a bank card or typed; what a degree is on it, and whether the stimulus fits.",
        |display, _, _| {
            let (width, distance) = (display.form.screen_width_cm.clone(), display.form.distance_cm.clone());
            Tool::Geometry(Box::new(GeometryPane::new(width, distance, display.window_deg)))
        },
    ),
    (
        "Photometer",
        "The light of every level, measured: patches to point it at, or readings from a file; the fit and the profile.",
        |display, profile, _| {
            Tool::Photometer(match display.paused.take() {
                Some(pane) => Box::new(pane.for_profile(profile)),
                None => Box::new(PhotometerPane::new(profile)),
            })
        },
    ),
    (
        "Gamma by eye",
        "Without a photometer: squares are matched to fields of rows, for each channel, in about five minutes.",
        |display, profile, monitor| Tool::Nulling(Box::new(NullingPane::new(profile, display.viewing(monitor)))),
    ),
    (
        "Check the gamma",
        "Rows beside the codes that the profile says have their light: a border shows where it is wrong.",
        |_, profile, _| Tool::Check(Box::new(CheckScreen::new(profile))),
    ),
    (
        "Steps of equal brightness",
        "Levels that look equally far apart, from the screen's black to its white: a table and a wedge.",
        |_, profile, _| Tool::Steps(Box::new(StepsPane::new(profile))),
    ),
    (
        "Timing",
        "Whether frames follow the screen's refresh one by one: intervals, dropped frames, a patch for a photodiode.",
        |_, _, _| Tool::Timing(Box::default()),
    ),
];

/// A tool's page: its name, the way back, and its content in a column that scrolls.
fn tool<R>(ui: &mut egui::Ui, name: &str, back: &mut bool, add: impl FnOnce(&mut egui::Ui) -> R) -> R {
    theme::page_from(ui, 0.02, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.heading(name);
            *back |= ui.button("Back").clicked();
            ui.label(theme::quiet("Esc"));
        });
        ui.add_space(8.0);
        add(ui)
    })
}

/// Begins a new row where what follows needs more than is left of this one, points.
fn room_for(ui: &mut egui::Ui, width: f32) {
    if ui.available_size_before_wrap().x < width {
        ui.end_row();
    }
}

/// A number in a text, with the minus sign of print.
fn signed(number: &str) -> String {
    number.replace('-', "−")
}
