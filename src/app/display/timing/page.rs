//! The window of `machband timing`: measures, and closes.

use std::sync::mpsc::Sender;

use eframe::egui::{self, Color32, CursorIcon, Key};

use super::{
    report::TimingReport,
    run::{TimingPlan, TimingRun},
};
use crate::app::ui::Monitor;

/// What `machband timing` asks of the window.
pub struct TimingRequest {
    /// What is measured.
    pub plan: TimingPlan,
    /// On the whole screen.
    pub fullscreen: bool,
    /// Where the report goes; nothing is sent where the window is closed before its end.
    pub report: Sender<TimingReport>,
}

/// The page.
pub struct TimingPage {
    run: TimingRun,
    report: Sender<TimingReport>,
    /// The window is about to close.
    done: bool,
}

impl TimingPage {
    /// For a request.
    pub fn new(request: TimingRequest) -> Self {
        Self { run: TimingRun::new(request.plan), report: request.report, done: false }
    }

    /// Draws a frame; `true` when the page is done.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor) -> bool {
        ui.ctx().set_cursor_icon(CursorIcon::None);
        if self.done {
            return false;
        }
        let report = self.run.show(ui, monitor);
        self.done = report.is_some() || ui.input(|input| input.key_pressed(Key::Escape));
        if let Some(report) = report {
            // Nobody may be waiting for it any more.
            let _ = self.report.send(report);
        }
        self.done
    }

    /// The color behind everything.
    pub fn ground(&self) -> Color32 {
        self.run.ground()
    }
}
