//! Runs one session from the preflight to the last page.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Color32, Ui};

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

    /// Returns whether every planned trial is rated.
    pub fn is_complete(&self) -> bool {
        matches!(&self.0, Stage::Finish(finish) if finish.is_complete())
    }

    /// Returns the path of the data file once the last page is shown.
    pub fn saved_in(&self) -> Option<&Path> {
        if let Stage::Finish(finish) = &self.0 { Some(finish.path()) } else { None }
    }

    /// Returns whether an answer is only in memory.
    pub fn is_unsaved(&self) -> bool {
        matches!(&self.0, Stage::Trials(trials) if trials.is_unsaved())
    }

    /// Returns whether trials remain to be rated, so that leaving now interrupts the session.
    pub fn is_running(&self) -> bool {
        matches!(self.0, Stage::Trials(_))
    }

    /// Pauses the trials if they are running.
    pub fn pause(&mut self, ctx: &egui::Context) {
        if let Stage::Trials(trials) = &mut self.0 {
            trials.pause(ctx);
        }
    }

    /// Says how to resume the session after the window is closed.
    pub fn how_to_resume(&self) -> String {
        let saved = "Every answer so far is saved.";
        let Stage::Trials(trials) = &self.0 else { return saved.to_owned() };
        let identity = &trials.recording.identity;
        let (subject, session) = (identity.subject(), identity.session());
        format!(
            "{saved} To resume, start machband again, choose {subject}, session {session}, on the page Studies, and \
                press Resume."
        )
    }

    /// Ends the trials if they are running; returns the path of the file with their rows.
    pub fn close(&mut self) -> Option<&Path> {
        let Stage::Trials(trials) = &mut self.0 else { return None };
        trials.close();
        Some(trials.recording.csv())
    }
}
