//! What no system tells, asked of the person at the screen. Nothing here holds a session up: what is not confirmed is
//! recorded so.

use eframe::egui;

use crate::{app::ui::platform::Platform, display::DisplayProfile, store::sidecar::PreflightNote};

/// A statement to be confirmed by a look at the screen or into its menu.
struct Question {
    check: &'static str,
    statement: &'static str,
    confirmed: bool,
}

/// The questions of one session.
pub struct Asked {
    questions: Vec<Question>,
}

impl Asked {
    /// What is left to ask once the system has told what it knows.
    pub fn new(platform: &Platform, display: &DisplayProfile) -> Self {
        let ask = |wanted: bool, check, statement| wanted.then_some(Question { check, statement, confirmed: false });
        let questions = [
            ask(
                display.measured.is_some(),
                "right_monitor_asked",
                "This is the screen that the profile was measured on, with the same brightness, contrast and color settings.",
            ),
            ask(
                true,
                "monitor_settings_asked",
                "The screen's own helpers are off: dynamic contrast, local dimming, automatic brightness, eye comfort.",
            ),
            ask(
                platform.ramps_straight.is_none(),
                "night_light_asked",
                "Night light, blue-light filters and color corrections of the system are off.",
            ),
            ask(platform.hdr != Some(false), "hdr_asked", "High dynamic range (HDR) is off."),
            ask(
                platform.variable_refresh != Some(false),
                "variable_refresh_asked",
                "Variable refresh (FreeSync, G-Sync, Adaptive-Sync) is off.",
            ),
            ask(
                true,
                "other_programs_asked",
                "No other program draws on the screen: no video, no notifications, no screen sharing.",
            ),
        ];
        Self { questions: questions.into_iter().flatten().collect() }
    }

    /// Draws the statements, each with a box to tick.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        for question in &mut self.questions {
            ui.checkbox(&mut question.confirmed, question.statement);
        }
    }

    /// The answers, for the sidecar.
    pub fn notes(&self) -> Vec<PreflightNote> {
        let note = |question: &Question| PreflightNote {
            check: question.check.to_owned(),
            ok: question.confirmed,
            sentence: match question.confirmed {
                true => format!("Confirmed at the screen: {}", question.statement),
                false => format!("Not confirmed: {}", question.statement),
            },
        };
        self.questions.iter().map(note).collect()
    }
}
