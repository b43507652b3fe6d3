//! Runs one session from the preflight to the last page.

use std::path::PathBuf;

use eframe::egui::{Color32, Ui};

use super::{finish::Finish, preflight::Preflight, request::Request, trials::Trials};
use crate::app::{
    ui::{Monitor, Step, theme},
    window::Input,
};

/// A session in the window, in its current stage.
pub enum Runner {
    Preflight(Box<Preflight>),
    Trials(Box<Trials>),
    Finish(Box<Finish>),
}

impl Runner {
    /// Begins with the preflight, while the window becomes full screen.
    pub fn new(request: Request) -> Self {
        Self::Preflight(Box::new(Preflight::new(request)))
    }

    /// Draws a frame. `Next` leads to the analysis of a data set. `direct`: leaving the session closes the window.
    pub fn show(&mut self, ui: &mut Ui, monitor: &Monitor, input: &mut Input, direct: bool) -> Step<PathBuf> {
        let next = match self {
            Self::Preflight(preflight) => preflight.show(ui, monitor).map(Self::Trials),
            Self::Trials(trials) => trials.show(ui, monitor, input).map(Self::Finish),
            Self::Finish(finish) => return finish.show(ui, direct),
        };
        match next {
            Step::Stay => Step::Stay,
            Step::Back => Step::Back,
            Step::Next(stage) => {
                *self = stage;
                ui.ctx().request_repaint();
                Step::Stay
            }
        }
    }

    pub fn ground(&self) -> Color32 {
        if let Self::Trials(trials) = self { trials.ground() } else { theme::DARK_PAGE }
    }

    /// Returns the last page while it is shown.
    pub fn finish(&self) -> Option<&Finish> {
        if let Self::Finish(finish) = self { Some(finish) } else { None }
    }

    /// Returns the trials while some remain to be rated, so that leaving now interrupts the session.
    pub fn trials(&mut self) -> Option<&mut Trials> {
        if let Self::Trials(trials) = self { Some(trials) } else { None }
    }
}
