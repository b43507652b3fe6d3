//! Runs one session from the preflight to the last page.

use std::path::PathBuf;

use eframe::egui::{Color32, Ui};

use super::{finish::Finish, preflight::Preflight, request::Request, trials::Trials};
use crate::app::{
    ui::{Monitor, Step, theme},
    window::Input,
};

enum Stage {
    Preflight(Box<Preflight>),
    Trials(Box<Trials>),
    Finish(Box<Finish>),
}

/// A session in the window, in its current stage.
pub struct Runner(Stage);

impl Runner {
    /// Begins with the preflight, while the window becomes full screen.
    pub fn new(request: Request) -> Self {
        Self(Stage::Preflight(Box::new(Preflight::new(request))))
    }

    /// Draws a frame. `Next` leads to the analysis of a data set. `direct`: leaving the session closes the window.
    pub fn show(&mut self, ui: &mut Ui, monitor: &Monitor, input: &mut Input, direct: bool) -> Step<PathBuf> {
        let next = match &mut self.0 {
            Stage::Preflight(preflight) => preflight.show(ui, monitor).map(Stage::Trials),
            Stage::Trials(trials) => trials.show(ui, monitor, input).map(Stage::Finish),
            Stage::Finish(finish) => return finish.show(ui, direct),
        };
        match next {
            Step::Stay => Step::Stay,
            Step::Back => Step::Back,
            Step::Next(stage) => {
                self.0 = stage;
                ui.ctx().request_repaint();
                Step::Stay
            }
        }
    }

    pub fn ground(&self) -> Color32 {
        if let Stage::Trials(trials) = &self.0 { trials.ground() } else { theme::DARK_PAGE }
    }

    /// Returns the last page while it is shown.
    pub fn finish(&self) -> Option<&Finish> {
        if let Stage::Finish(finish) = &self.0 { Some(finish) } else { None }
    }

    /// Returns the trials while some remain to be rated, so that leaving now interrupts the session.
    pub fn trials(&mut self) -> Option<&mut Trials> {
        if let Stage::Trials(trials) = &mut self.0 { Some(trials) } else { None }
    }
}
