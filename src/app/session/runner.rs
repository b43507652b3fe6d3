//! Runs one session from the preflight to the last page.

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

    /// Draws a frame; returns whether the session is left. `direct`: leaving the session closes the window.
    pub fn show(&mut self, ui: &mut Ui, monitor: &Monitor, input: &mut Input, direct: bool) -> bool {
        let next = match self {
            Self::Preflight(preflight) => preflight.show(ui, monitor).map(Self::Trials),
            Self::Trials(trials) => trials.show(ui, monitor, input).map(Self::Finish),
            Self::Finish(finish) => return finish.show(ui, direct),
        };
        let is_left = matches!(next, Step::Back);
        if let Step::Next(stage) = next {
            *self = stage;
            ui.ctx().request_repaint();
        }
        is_left
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
