//! Calibration with a photometer: patches in a good order, readings typed or from a file, the fit, the profile.

mod measure;
mod outcome;
mod setup;

use std::path::Path;

use eframe::egui::{self, ViewportCommand};

use self::{
    measure::{MeasureGo, Measuring},
    outcome::{Outcome, OutcomeGo},
    setup::{Setup, SetupGo},
};
use super::ToolGo;
use crate::{
    display::{DisplayProfile, photometer::Readings},
    store::readings,
};

/// The tool.
pub struct PhotometerPane {
    /// What is known of the screen besides its light.
    profile: DisplayProfile,
    setup: Setup,
    stage: Stage,
}

enum Stage {
    Setup,
    Measuring(Box<Measuring>),
    /// What the readings gave; the patches to go back to, where they were shown here.
    Outcome(Box<Outcome>, Option<Box<Measuring>>),
}

impl PhotometerPane {
    /// For the screen that `profile` describes so far.
    pub fn new(profile: DisplayProfile) -> Self {
        Self { setup: Setup::new(&profile), profile, stage: Stage::Setup }
    }

    /// The same, for what is known of the screen by now.
    pub fn for_profile(self, profile: DisplayProfile) -> Self {
        Self { profile, ..self }
    }

    /// Whether patches were left before all were read.
    pub fn is_paused(&self) -> bool {
        self.setup.is_paused()
    }

    /// Draws the stage that is on.
    pub fn show(&mut self, ui: &mut egui::Ui) -> ToolGo {
        let (next, go) = match std::mem::replace(&mut self.stage, Stage::Setup) {
            Stage::Setup => self.set_up(ui),
            Stage::Measuring(measuring) => self.measure(ui, measuring),
            Stage::Outcome(outcome, measuring) => self.conclude(ui, outcome, measuring),
        };
        self.stage = next;
        go
    }

    fn set_up(&mut self, ui: &mut egui::Ui) -> (Stage, ToolGo) {
        let next = match self.setup.show(ui) {
            SetupGo::Stay => Stage::Setup,
            SetupGo::Back => return (Stage::Setup, ToolGo::Back),
            SetupGo::Measure(measuring) => {
                full_screen(ui, true);
                Stage::Measuring(measuring)
            }
            SetupGo::Fit(path) => Stage::Outcome(self.outcome(&path), None),
        };
        ui.ctx().request_repaint();
        (next, ToolGo::Stay)
    }

    fn measure(&mut self, ui: &mut egui::Ui, mut measuring: Box<Measuring>) -> (Stage, ToolGo) {
        let next = match measuring.show(ui) {
            MeasureGo::Stay => return (Stage::Measuring(measuring), ToolGo::Stay),
            MeasureGo::Pause => {
                self.setup.left(Some(&measuring));
                Stage::Setup
            }
            MeasureGo::Done => {
                self.setup.left(None);
                let outcome = self.outcome(measuring.path());
                Stage::Outcome(outcome, Some(measuring))
            }
        };
        full_screen(ui, false);
        ui.ctx().request_repaint();
        (next, ToolGo::Stay)
    }

    fn conclude(
        &mut self,
        ui: &mut egui::Ui,
        mut outcome: Box<Outcome>,
        measuring: Option<Box<Measuring>>,
    ) -> (Stage, ToolGo) {
        match (outcome.show(ui, measuring.is_some()), measuring) {
            (OutcomeGo::Back, _) => (Stage::Setup, ToolGo::Stay),
            (OutcomeGo::Again(patches), Some(mut measuring)) => {
                measuring.again(&patches);
                full_screen(ui, true);
                ui.ctx().request_repaint();
                (Stage::Measuring(measuring), ToolGo::Stay)
            }
            (OutcomeGo::Saved(saved), _) => (Stage::Setup, ToolGo::Saved(saved)),
            (_, measuring) => (Stage::Outcome(outcome, measuring), ToolGo::Stay),
        }
    }

    fn outcome(&self, path: &Path) -> Box<Outcome> {
        let read: Result<Readings, String> = readings::open(path).map_err(|faults| faults.to_string());
        Box::new(Outcome::new(read, path, &self.profile, self.setup.name()))
    }
}

fn full_screen(ui: &egui::Ui, on: bool) {
    ui.ctx().send_viewport_cmd(ViewportCommand::Fullscreen(on));
}
