//! The current profile and the list of tools.

use eframe::egui::{self, Color32, RichText};

use super::{
    by_eye::ByEye,
    calibrate::{Calibrate, SavedProfile},
    check::CheckPage,
    geometry::GeometryPage,
    photometer::Photometer,
    sizes::SizeTest,
    steps::StepsPage,
    timing::TimingTool,
};
use crate::{
    app::ui::{
        Dialog, Field, FileKind, Monitor, ScreenFields, Step, hint, note, show_error, success, theme::DARK_PAGE, today,
        tool_page,
    },
    display::DisplayProfile,
};

/// The tool that is open.
enum Tool {
    Geometry(Box<GeometryPage>),
    Photometer,
    ByEye,
    Sizes,
    Check(Box<CheckPage>),
    Steps(Box<StepsPage>),
    Timing(Box<TimingTool>),
}

pub struct Display {
    /// Side of the planned stimulus, degrees.
    window_deg: f64,
    /// The path of the last profile that was read, and the profile or its errors.
    read: Option<(String, Result<DisplayProfile, String>)>,
    tool: Option<Tool>,
    dialog: Dialog,
    /// The profile that a tool wrote; a message names it while it is in use.
    saved: Option<SavedProfile>,
    /// This, `by_eye` and `sizes` outlive their pages, so that a paused run can be resumed.
    photometer: Calibrate<Photometer>,
    by_eye: Calibrate<ByEye>,
    sizes: Calibrate<SizeTest>,
}

impl Display {
    /// Creates the page for a screen that these fields describe.
    pub fn new(fields: &ScreenFields) -> Self {
        let known = fields.profile().unwrap_or_default();
        let photometer = Calibrate::new(Photometer::default(), known.clone(), [true, true]);
        let by_eye = Calibrate::new(ByEye::default(), known.clone(), [true, false]);
        let sizes = Calibrate::new(SizeTest::default(), known, [false, true]);
        let (read, tool, dialog, saved) = Default::default();
        Self { window_deg: 10.0, read, tool, dialog, saved, photometer, by_eye, sizes }
    }

    /// Returns the background color while the screen is measured, which then shows nothing else; `None` for a page.
    pub fn ground(&self) -> Option<Color32> {
        match &self.tool {
            Some(Tool::Timing(tool)) => tool.ground(),
            Some(Tool::Photometer) => self.photometer.is_running().then_some(Color32::BLACK),
            Some(Tool::ByEye) => self.by_eye.is_running().then_some(DARK_PAGE),
            Some(Tool::Sizes) => self.sizes.is_running().then_some(Color32::BLACK),
            _ => None,
        }
    }

    /// Pauses the measurement; that of frames ends.
    pub fn pause(&mut self, ctx: &egui::Context) {
        match &mut self.tool {
            Some(Tool::Timing(tool)) => tool.stop(ctx),
            Some(Tool::Photometer) => self.photometer.pause(ctx),
            Some(Tool::ByEye) => self.by_eye.pause(ctx),
            Some(Tool::Sizes) => self.sizes.pause(ctx),
            _ => {}
        }
    }

    /// Draws the open tool, or the list of tools. `fields` are the start page's fields for the profile's path, the
    /// screen's width and the distance, which can also be set here; `window_deg` is the side of the planned stimulus.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor, fields: &mut ScreenFields, window_deg: f64) -> Step {
        self.window_deg = window_deg;
        let viewing = fields.viewing(monitor).ok();
        let step = match &mut self.tool {
            None => return self.list(ui, fields),
            Some(Tool::Geometry(page)) => page.show(ui, monitor, fields).widen(),
            Some(Tool::Photometer) => self.photometer.show(ui, viewing.as_ref()),
            Some(Tool::ByEye) => self.by_eye.show(ui, viewing.as_ref()),
            Some(Tool::Sizes) => self.sizes.show(ui, viewing.as_ref()),
            Some(Tool::Check(page)) => page.show(ui).widen(),
            Some(Tool::Steps(page)) => page.show(ui).widen(),
            Some(Tool::Timing(page)) => page.show(ui, monitor).widen(),
        };
        match step {
            Step::Stay => return Step::Stay,
            Step::Back => {}
            Step::Next(saved) => {
                fields.profile = saved.path.display().to_string();
                // The file has changed, so it must be read again.
                self.read = None;
                self.saved = Some(saved);
            }
        }
        self.tool = None;
        ui.ctx().request_repaint();
        Step::Stay
    }

    /// Returns the profile that the fields name, read once per path.
    fn profile(&mut self, fields: &ScreenFields) -> Result<DisplayProfile, String> {
        let path = fields.profile.trim().to_owned();
        if self.read.as_ref().is_none_or(|(read, _)| *read != path) {
            self.read = Some((path, fields.profile()));
        }
        self.read.as_ref().map_or_else(|| Ok(DisplayProfile::default()), |(_, found)| found.clone())
    }

    fn list(&mut self, ui: &mut egui::Ui, fields: &mut ScreenFields) -> Step {
        let found = self.profile(fields);
        let (back, chosen) = tool_page(ui, "Display", |ui| {
            ui.label(
                "The eye sees light, not codes. A display profile describes how much light this screen produces for \
                    each code.",
            );
            ui.add_space(8.0);
            self.profile_field(ui, fields, &found);
            ui.add_space(8.0);
            let mut chosen = None;
            for (name, what, make) in TOOLS {
                ui.add_space(4.0);
                let button = egui::Button::new(RichText::new(*name).strong()).min_size([260.0, 34.0].into());
                if ui.add(button).clicked() {
                    chosen = Some(make);
                }
                hint(ui, *what);
            }
            chosen
        });
        if let Some(make) = chosen {
            self.saved = None;
            self.tool = Some(make(self, found.unwrap_or_default()));
            ui.ctx().request_repaint();
        }
        Step::back_if(back)
    }

    fn profile_field(&mut self, ui: &mut egui::Ui, fields: &mut ScreenFields, found: &Result<DisplayProfile, String>) {
        Field::new("Profile in use").show(ui, |ui, label| {
            let field = egui::TextEdit::singleline(&mut fields.profile).desired_width(300.0);
            ui.add(field.hint_text("sRGB, assumed")).labelled_by(label);
            self.dialog.browse(ui, FileKind::Toml, "Choose a profile…", &mut fields.profile);
        });
        match found {
            Ok(profile) => {
                hint(ui, format!("{}.", profile.sentence()));
                // If the profile is assumed, the sentence above already says so.
                let warning = profile.measured.as_ref().and_then(|_| profile.warning(today()));
                warning.iter().for_each(|warning| note(ui, warning));
            }
            Err(errors) => errors.lines().for_each(|line| show_error(ui, line)),
        }
        self.saved = self.saved.take().filter(|saved| fields.profile.trim() == saved.path.display().to_string());
        if let Some(SavedProfile { path, replaced }) = &self.saved {
            let done = if *replaced { "Replaced" } else { "Saved as" };
            success(ui, format!("{done} {}; now in use.", path.display()));
        }
    }
}

/// A tool's name, a description of it, and a function that opens it.
type Entry = (&'static str, &'static str, fn(&mut Display, DisplayProfile) -> Tool);

/// All tools, in the order in which a new screen needs them.
const TOOLS: &[Entry] = &[
    (
        "Size and distance",
        "Enter the screen's width or measure it with a bank card; see the size of one degree and whether the stimulus \
            fits.",
        |display, _| Tool::Geometry(Box::new(GeometryPage::new(display.window_deg))),
    ),
    (
        "Photometer",
        "Measure the luminance of every level: point a photometer at patches, or load readings from a file.",
        |display, profile| {
            display.photometer.update(profile);
            Tool::Photometer
        },
    ),
    (
        "Patch size",
        "Find out with a photometer whether the screen dims large bright areas, as OLED screens do.",
        |_, _| Tool::Sizes,
    ),
    (
        "Gamma by eye",
        "No photometer needed: match a square to a field of rows in each channel. This takes about five minutes.",
        |display, profile| {
            display.by_eye.update(profile);
            Tool::ByEye
        },
    ),
    (
        "Check the gamma",
        "View squares in fields of rows. If the profile is correct, the squares vanish; a visible border means that it \
            is wrong.",
        |_, profile| Tool::Check(Box::new(CheckPage::new(profile))),
    ),
    (
        "Steps of equal brightness",
        "Levels that look evenly spaced, from the screen's black to its white, as a table and a wedge.",
        |_, profile| Tool::Steps(Box::new(StepsPage::new(profile))),
    ),
    (
        "Timing",
        "Find out whether every refresh shows a new frame: intervals, dropped frames, and a patch for a photodiode.",
        |_, _| Tool::Timing(Box::default()),
    ),
];
