//! What is known about the screen, and the list of tools.

use eframe::egui::{self, Color32, RichText};

use super::{
    by_eye::ByEye,
    calibrate::{Calibrate, LABELS, Tool},
    photometer::Photometer,
    screen::{CheckedScreen, ScreenForm},
    sizes::SizeTest,
    timing::TimingTool,
};
use crate::app::ui::{Monitor, ScreenFields, Step, full, hint, say, tool_page};

pub struct Display {
    /// All tools, in the order in which a new screen needs them. They outlive their pages, so that a paused run can be
    /// resumed.
    tools: [Entry; 4],
    /// The place of the tool that is open.
    open: Option<usize>,
    screen: ScreenForm,
}

/// A tool's name, a description of it, and the tool.
type Entry = (&'static str, &'static str, Box<dyn Tool>);

impl Default for Display {
    fn default() -> Self {
        let tools: [Entry; 4] = [
            (
                "Photometer",
                "Measure the luminance of every level: point a photometer at patches, or load readings from a file.",
                Box::new(Calibrate::new(Photometer::default(), [true, true])),
            ),
            (
                "Patch size",
                "Find out with a photometer whether the screen dims large bright areas, as OLED screens do.",
                Box::new(Calibrate::new(SizeTest { settle_s: 2.0 }, [false, true])),
            ),
            (
                "Gamma by eye",
                "No photometer needed: match a square to a field of rows in each channel. This takes about five minutes.",
                Box::new(Calibrate::new(ByEye::default(), [true, false])),
            ),
            (
                "Timing",
                "Find out whether every refresh shows a new frame: intervals and dropped frames.",
                Box::new(TimingTool::default()),
            ),
        ];
        Self { tools, open: None, screen: ScreenForm::default() }
    }
}

impl Display {
    fn tool(&mut self) -> Option<&mut dyn Tool> {
        Some(&mut *self.tools[self.open?].2)
    }

    /// Returns the background color while the screen is measured, which then shows nothing else; `None` for a page.
    pub fn ground(&self) -> Option<Color32> {
        self.tools[self.open?].2.ground()
    }

    /// Pauses the measurement; that of frames ends.
    pub fn pause(&mut self, ctx: &egui::Context) {
        if let Some(tool) = self.tool() {
            tool.pause(ctx);
        }
    }

    /// Draws the open tool, or the list of tools; returns whether the user left the list, and `Next` once a tool has written
    /// the profile that the fields name. `fields` are those for the screen, and `checked` is what they say.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        monitor: &Monitor,
        fields: &mut ScreenFields,
        checked: &CheckedScreen,
    ) -> Step<()> {
        let Some(tool) = self.tool() else { return Step::back_if(self.list(ui, monitor, fields, checked)) };
        let step = tool.show(ui, monitor, checked.viewing.as_ref());
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
        monitor: &Monitor,
        fields: &mut ScreenFields,
        checked: &CheckedScreen,
    ) -> bool {
        let mut chosen = None;
        let back = tool_page(ui, "Display", |ui| {
            ui.label(
                "The eye sees light, not codes. A display profile describes how much light this screen produces for \
                    each code.",
            );
            ui.add_space(8.0);
            self.screen.show(ui, LABELS, fields, monitor, checked);
            ui.add_space(8.0);
            for (place, (name, what, _)) in self.tools.iter().enumerate() {
                ui.add_space(4.0);
                let button = egui::Button::new(RichText::new(*name).strong()).min_size([260.0, 34.0].into());
                if ui.add(button).clicked() {
                    chosen = Some(place);
                }
                hint(ui, *what);
            }
        });
        self.screen.measure(ui.ctx(), fields, monitor);
        if let Some(place) = chosen {
            self.tools[place].2.open(checked.profile.clone().unwrap_or_default());
            self.open = Some(place);
            ui.ctx().request_repaint();
        }
        back
    }
}
