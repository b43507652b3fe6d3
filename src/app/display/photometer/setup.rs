//! What is to be measured, or which file of readings is to be fitted.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Key, Slider};

use super::{
    super::{room_for, tool},
    measure::{Measuring, Viewing},
};
use crate::{
    app::{
        dialog::{Ask, Dialog},
        form::parse,
        theme,
    },
    display::{
        DisplayProfile,
        photometer::{Channel, Plan, PlanSettings},
    },
};

/// Seconds that reading and typing take, for the estimate.
const READING_S: f64 = 5.0;
/// Room for a slider and its number, points.
const SLIDER_ROOM: f32 = 190.0;

/// The page.
pub struct Setup {
    name: String,
    /// Where the typed readings go; follows the name until it is typed.
    path: String,
    colors: bool,
    gray: bool,
    levels: usize,
    repeats: usize,
    settle_s: String,
    percent: u32,
    gray_around: bool,
    /// A file of readings to fit.
    file: String,
    fault: Option<String>,
    /// The file of patches that were left, how many of them were read, and how many there are.
    paused: Option<(PathBuf, usize, usize)>,
    dialog: Dialog,
}

/// Where the page leads.
pub enum SetupGo {
    /// Nowhere yet.
    Stay,
    /// Back to the tools.
    Back,
    /// To the patches.
    Measure(Box<Measuring>),
    /// To the fit of a file.
    Fit(PathBuf),
}

impl Setup {
    /// For the screen that a profile describes.
    pub fn new(profile: &DisplayProfile) -> Self {
        let name = if profile.measured.is_some() { profile.name.clone() } else { "My screen".to_owned() };
        let path = suggested(&name);
        Self {
            name,
            path,
            colors: true,
            gray: true,
            levels: 17,
            repeats: 1,
            settle_s: "1".to_owned(),
            percent: 40,
            gray_around: false,
            file: String::new(),
            fault: None,
            paused: None,
            dialog: Dialog::default(),
        }
    }

    /// The screen's name.
    pub fn name(&self) -> &str {
        self.name.trim()
    }

    /// Patches were left before all were read; `None` where all are.
    pub fn left(&mut self, measuring: Option<&Measuring>) {
        self.paused = measuring.map(|measuring| {
            let (done, all) = measuring.progress();
            (measuring.path().to_owned(), done, all)
        });
    }

    /// Whether patches were left before all were read.
    pub fn is_paused(&self) -> bool {
        self.paused.is_some()
    }

    /// Draws the page.
    pub fn show(&mut self, ui: &mut egui::Ui) -> SetupGo {
        if let Some(path) = self.dialog.take() {
            self.file = path.display().to_string();
        }
        let mut back = false;
        let mut begin = false;
        let mut fit = false;
        tool(ui, "Photometer", &mut back, |ui| {
            ui.label("Patches are shown one by one; type what the photometer reads of each. Let the screen warm up for half an hour, and darken the room.");
            ui.add_space(8.0);
            self.fields(ui);
            let plan = self.plan();
            match &plan {
                Ok((plan, settle_s)) => {
                    let minutes = (plan.duration_s(*settle_s, READING_S) / 60.0).ceil();
                    ui.label(theme::quiet(format!("{} patches, about {minutes} minutes.", plan.patches.len())));
                }
                Err(fault) => theme::fault(ui, fault),
            }
            let begun = self.begun();
            if let Some(sentence) = &begun {
                ui.label(theme::quiet(sentence));
            }
            let text = if begun.is_some() { "Go on" } else { "Show patches" };
            begin = theme::primary(ui, text, plan.is_ok(), "fills the screen; Esc pauses");
            if let Some(fault) = &self.fault {
                theme::fault(ui, fault);
            }
            ui.add_space(12.0);
            fit = self.file_field(ui);
        });
        if back || ui.input(|input| input.key_pressed(Key::Escape)) {
            return SetupGo::Back;
        }
        if fit {
            return SetupGo::Fit(PathBuf::from(self.file.trim()));
        }
        if begin { self.begin() } else { SetupGo::Stay }
    }

    /// That the file has readings already, from this time or an earlier one; `None` where it is a new one.
    fn begun(&self) -> Option<String> {
        let path = Path::new(self.path.trim());
        match &self.paused {
            Some((left, done, all)) if left == path => {
                Some(format!("Paused after {done} of {all} readings. They are saved; the same settings go on."))
            }
            _ => path.is_file().then(|| {
                "This file has readings of an earlier time. The same settings go on with them; for new ones, name another file.".to_owned()
            }),
        }
    }

    fn begin(&mut self) -> SetupGo {
        let viewing = |settle_s| Viewing { settle_s, percent: self.percent, gray_around: self.gray_around };
        let made = self.plan().and_then(|(plan, settle_s)| {
            Measuring::begin(plan, Path::new(self.path.trim()), viewing(settle_s)).map_err(|error| error.to_string())
        });
        match made {
            Ok(measuring) => {
                self.fault = None;
                SetupGo::Measure(Box::new(measuring))
            }
            Err(fault) => {
                self.fault = Some(fault);
                SetupGo::Stay
            }
        }
    }

    /// The patches and the time to settle.
    fn plan(&self) -> Result<(Plan, f64), String> {
        let mut channels = Vec::new();
        if self.colors {
            channels.extend([Channel::Red, Channel::Green, Channel::Blue]);
        }
        if self.gray {
            channels.push(Channel::Gray);
        }
        let settings = PlanSettings { channels, levels: self.levels, repeats: self.repeats, ..PlanSettings::default() };
        let settle_s = parse(&self.settle_s).filter(|s| (0.0..=60.0).contains(s));
        let settle_s =
            settle_s.ok_or_else(|| format!("{:?} is no time to settle; expected seconds, 0 to 60", self.settle_s))?;
        if self.path.trim().is_empty() {
            return Err("The readings have no file; expected a path.".to_owned());
        }
        Ok((Plan::new(&settings).map_err(|error| error.to_string())?, settle_s))
    }

    fn fields(&mut self, ui: &mut egui::Ui) {
        text(ui, "Name of the screen", 260.0, &mut self.name, |name, _| {
            // The file follows until someone types another.
            name.changed()
        })
        .then(|| self.path = suggested(&self.name));
        text(ui, "Readings are kept in", 400.0, &mut self.path, |_, _| false);
        ui.horizontal_wrapped(|ui| {
            ui.label("Channels");
            ui.checkbox(&mut self.colors, "red, green, blue");
            ui.checkbox(&mut self.gray, "gray");
        });
        slider(ui, "Levels of each channel", &mut self.levels, 5..=33);
        slider(ui, "Readings of each patch", &mut self.repeats, 1..=5);
        text(ui, "Seconds to settle", 70.0, &mut self.settle_s, |_, _| false);
        slider(ui, "Height of the patch, % of the screen", &mut self.percent, 10..=80);
        ui.checkbox(&mut self.gray_around, "Gray around the patch instead of black");
    }

    fn file_field(&mut self, ui: &mut egui::Ui) -> bool {
        let mut fit = false;
        ui.label(egui::RichText::new("Or readings that are in a file already").strong());
        ui.label(theme::quiet("CSV with the columns channel,level,luminance_cd_m2: channel r, g, b or gray; level the code divided by the largest, 0 to 1."));
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("File of readings");
            ui.add(egui::TextEdit::singleline(&mut self.file).desired_width(300.0)).labelled_by(label.id);
            if ui.button("Browse…").clicked() {
                self.dialog.open(ui.ctx(), Ask::Data);
            }
            fit = ui.add_enabled(!self.file.trim().is_empty(), egui::Button::new("Fit this file")).clicked();
        });
        fit
    }
}

/// Where readings of a screen go unless told otherwise.
fn suggested(name: &str) -> String {
    format!("calibration/{}_readings.csv", file_name(name))
}

/// A name as part of a file's name.
pub fn file_name(name: &str) -> String {
    let letter = |c: char| if c.is_alphanumeric() || c == '-' { c } else { '_' };
    let name: String = name.trim().chars().map(letter).collect();
    if name.is_empty() { "screen".to_owned() } else { name }
}

fn text(
    ui: &mut egui::Ui,
    name: &str,
    width: f32,
    value: &mut String,
    done: impl FnOnce(&egui::Response, &str) -> bool,
) -> bool {
    ui.horizontal_wrapped(|ui| {
        let label = ui.label(name);
        let field = ui.add(egui::TextEdit::singleline(value).desired_width(width)).labelled_by(label.id);
        done(&field, value)
    })
    .inner
}

fn slider<N: egui::emath::Numeric>(ui: &mut egui::Ui, name: &str, value: &mut N, range: std::ops::RangeInclusive<N>) {
    ui.horizontal_wrapped(|ui| {
        let label = ui.label(name);
        room_for(ui, SLIDER_ROOM);
        ui.add(Slider::new(value, range)).labelled_by(label.id);
    });
}
