//! What is known about the screen, and the list of tools.

use eframe::egui::{self, RichText};

use super::{
    by_eye::ByEye,
    calibrate::{LABELS, Tool},
    photometer::Photometer,
    screen::{CheckedScreen, ScreenForm},
    sizes::SizeTest,
    timing::Timing,
};
use crate::app::ui::{Monitor, ScreenFields, Step, full, hint, say, tool_page};

pub struct Display {
    /// All tools, in the order in which a new screen needs them. They outlive their pages, so that a paused run can be
    /// resumed.
    tools: [Tool; 4],
    /// The place of the tool that is open.
    open: Option<usize>,
    screen: ScreenForm,
}

impl Default for Display {
    fn default() -> Self {
        let tools = [
            Tool::new(Photometer::default(), Some([true, true])),
            Tool::new(SizeTest { settle_s: 2.0 }, None),
            Tool::new(ByEye::default(), Some([true, false])),
            Tool::new(Timing::default(), None),
        ];
        Self { tools, open: None, screen: ScreenForm::default() }
    }
}

impl Display {
    /// Returns whether the screen is measured, which then shows nothing else.
    pub fn measures(&self) -> bool {
        self.open.is_some_and(|open| self.tools[open].measures())
    }

    /// Pauses the measurement; that of frames ends.
    pub fn pause(&mut self, ctx: &egui::Context) {
        if let Some(open) = self.open {
            self.tools[open].pause(ctx);
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
        let Some(open) = self.open else { return Step::back_if(self.list(ui, monitor, fields, checked)) };
        let step = self.tools[open].show(ui, monitor, checked.viewing.as_ref());
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
            for (place, Tool { about, .. }) in self.tools.iter().enumerate() {
                ui.add_space(4.0);
                let button = egui::Button::new(RichText::new(about.title).strong()).min_size([260.0, 34.0].into());
                if ui.add(button).clicked() {
                    chosen = Some(place);
                }
                hint(ui, about.purpose);
            }
        });
        self.screen.measure(ui.ctx(), fields, monitor);
        if let Some(place) = chosen {
            self.tools[place].known = checked.profile.clone().unwrap_or_default();
            self.open = Some(place);
            ui.ctx().request_repaint();
        }
        back
    }
}
