//! What no system reports, asked of the person at the screen. Nothing here holds a session up: what nobody confirms is
//! recorded so.

use eframe::egui;

use crate::{app::ui::platform::Platform, display::DisplayProfile, store::sidecar::PreflightNote};

/// A statement to confirm by a glance at the screen or into its menu.
struct Question {
    check: &'static str,
    statement: &'static str,
    confirmed: bool,
}

/// The questions of one session.
pub struct Questions(Vec<Question>);

impl Questions {
    /// What is left to ask when the system has reported what it knows.
    pub fn new(platform: &Platform, display: &DisplayProfile) -> Self {
        let questions = [
            (
                display.measured.is_some(),
                "right_monitor_asked",
                "This is the screen that the profile was measured on, with the same brightness, contrast and color settings.",
            ),
            (
                true,
                "monitor_settings_asked",
                "The screen's own enhancements are off: dynamic contrast, local dimming, automatic brightness, eye comfort.",
            ),
            (
                platform.ramps_straight.is_none(),
                "night_light_asked",
                "The system's night light, blue-light filter and color corrections are off.",
            ),
            (platform.hdr != Some(false), "hdr_asked", "High dynamic range (HDR) is off."),
            (
                platform.variable_refresh != Some(false),
                "variable_refresh_asked",
                "Variable refresh (FreeSync, G-Sync, Adaptive-Sync) is off.",
            ),
            (
                true,
                "other_programs_asked",
                "No other program draws on the screen: no video, no notifications, no screen sharing.",
            ),
        ];
        let wanted = questions.into_iter().filter(|(wanted, ..)| *wanted);
        Self(wanted.map(|(_, check, statement)| Question { check, statement, confirmed: false }).collect())
    }

    /// Draws the statements, each with a box to tick.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        for question in &mut self.0 {
            ui.checkbox(&mut question.confirmed, question.statement);
        }
    }

    /// The answers, for the sidecar.
    pub fn notes(&self) -> impl Iterator<Item = PreflightNote> {
        self.0.iter().map(|question| PreflightNote {
            check: question.check.to_owned(),
            ok: question.confirmed,
            sentence: match question.confirmed {
                true => format!("Confirmed at the screen: {}", question.statement),
                false => format!("Not confirmed: {}", question.statement),
            },
        })
    }
}
