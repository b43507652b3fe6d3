//! The current profile and the list of tools.

use eframe::egui::{self, Color32, RichText};

use super::{
    by_eye::ByEye, calibrate::Calibrate, check::CheckPage, geometry::GeometryPage, photometer::Photometer,
    sizes::SizeTest, steps::StepsPage, timing::TimingTool, tool::Tool,
};
use crate::{
    app::ui::{Dialog, Field, FileKind, Monitor, ScreenFields, Step, full, hint, note, say, text, today, tool_page},
    display::DisplayProfile,
};

#[derive(Default)]
pub struct Display {
    /// The tools that were opened, in the order of [`TOOLS`]. They outlive their pages, so that a paused run can be
    /// resumed.
    tools: [Option<Box<dyn Tool>>; TOOLS.len()],
    /// The place of the tool that is open.
    open: Option<usize>,
    dialog: Dialog,
}

impl Display {
    /// Returns the background color while the screen is measured, which then shows nothing else; `None` for a page.
    pub fn ground(&self) -> Option<Color32> {
        self.tools[self.open?].as_ref()?.ground()
    }

    /// Pauses the measurement; that of frames ends.
    pub fn pause(&mut self, ctx: &egui::Context) {
        if let Some(tool) = self.open.and_then(|open| self.tools[open].as_mut()) {
            tool.pause(ctx);
        }
    }

    /// Draws the open tool, or the list of tools; returns whether the user left the list, and `Next` once a tool has written
    /// the profile that the fields name. `fields` are the start page's fields for the profile's path, the screen's width and
    /// the distance, which can also be set here; `found` is the profile, or what is wrong with it; `window_deg` is the side
    /// of the planned stimulus.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        monitor: &Monitor,
        fields: &mut ScreenFields,
        found: Result<&DisplayProfile, &str>,
        window_deg: f64,
    ) -> Step<()> {
        let Some(tool) = self.open.and_then(|open| self.tools[open].as_mut()) else {
            return Step::back_if(self.list(ui, fields, found, window_deg));
        };
        let step = tool.show(ui, monitor, fields);
        if step == Step::Stay {
            return Step::Stay;
        }
        self.open = None;
        ui.ctx().request_repaint();
        let Step::Next(saved) = step else { return Step::Stay };
        fields.profile = full(&saved).display().to_string();
        say(ui.ctx(), format!("Saved as {}; now in use.", fields.profile));
        Step::Next(())
    }

    fn list(
        &mut self,
        ui: &mut egui::Ui,
        fields: &mut ScreenFields,
        found: Result<&DisplayProfile, &str>,
        window_deg: f64,
    ) -> bool {
        let mut chosen = None;
        let back = tool_page(ui, "Display", |ui| {
            ui.label(
                "The eye sees light, not codes. A display profile describes how much light this screen produces for \
                    each code.",
            );
            ui.add_space(8.0);
            self.profile_field(ui, fields, found);
            ui.add_space(8.0);
            for (place, (name, what, _)) in TOOLS.iter().enumerate() {
                ui.add_space(4.0);
                let button = egui::Button::new(RichText::new(*name).strong()).min_size([260.0, 34.0].into());
                if ui.add(button).clicked() {
                    chosen = Some(place);
                }
                hint(ui, *what);
            }
        });
        if let Some(place) = chosen {
            let (profile, (.., make)) = (found.cloned().unwrap_or_default(), TOOLS[place]);
            if !self.tools[place].as_mut().is_some_and(|tool| tool.reopen(&profile)) {
                self.tools[place] = Some(make(profile, window_deg));
            }
            self.open = Some(place);
            ui.ctx().request_repaint();
        }
        back
    }

    fn profile_field(&mut self, ui: &mut egui::Ui, fields: &mut ScreenFields, found: Result<&DisplayProfile, &str>) {
        let browse = (FileKind::Toml, "Choose a profile…");
        let field = Field::new("Profile in use").hint("sRGB, assumed").width(300.0);
        field.path(ui, &mut fields.profile, &mut self.dialog, browse);
        match found {
            Ok(profile) => {
                hint(ui, format!("{}.", profile.sentence()));
                profile.warning(today()).iter().for_each(|warning| note(ui, warning));
            }
            Err(errors) => text::errors(ui, errors),
        }
    }
}

/// A tool's name, a description of it, and a function that opens it for a screen with this profile and a stimulus with
/// this side in degrees.
type Entry = (&'static str, &'static str, fn(DisplayProfile, f64) -> Box<dyn Tool>);

/// All tools, in the order in which a new screen needs them.
const TOOLS: &[Entry] = &[
    (
        "Size and distance",
        "Enter the screen's width or measure it with a bank card; see the size of one degree and whether the stimulus \
            fits.",
        |_, window_deg| Box::new(GeometryPage::new(window_deg)),
    ),
    (
        "Photometer",
        "Measure the luminance of every level: point a photometer at patches, or load readings from a file.",
        |profile, _| Box::new(Calibrate::new(Photometer::default(), profile, [true, true])),
    ),
    (
        "Patch size",
        "Find out with a photometer whether the screen dims large bright areas, as OLED screens do.",
        |profile, _| Box::new(Calibrate::new(SizeTest { settle_s: 2.0 }, profile, [false, true])),
    ),
    (
        "Gamma by eye",
        "No photometer needed: match a square to a field of rows in each channel. This takes about five minutes.",
        |profile, _| Box::new(Calibrate::new(ByEye::default(), profile, [true, false])),
    ),
    (
        "Check the gamma",
        "View squares in fields of rows. If the profile is correct, the squares vanish; a visible border means that it \
            is wrong.",
        |profile, _| Box::new(CheckPage::new(profile)),
    ),
    (
        "Steps of equal brightness",
        "Levels that look evenly spaced, from the screen's black to its white, as a table and a wedge.",
        |profile, _| Box::new(StepsPage::new(profile)),
    ),
    (
        "Timing",
        "Find out whether every refresh shows a new frame: intervals, dropped frames, and a patch for a photodiode.",
        |_, _| Box::new(TimingTool::default()),
    ),
];
