//! Visual nulling on the screen: what to match, how, the pictures one by one, and what comes of them.

mod results;
mod setup;
mod trial;

use eframe::egui::{self, Key, ViewportCommand};

use self::{results::Results, setup::Setup, trial::Trials};
use super::{ToolGo, check::CheckScreen, tool};
use crate::{
    app::{Monitor, theme},
    display::{DisplayProfile, Viewing, matching::Method},
};

/// The pane.
pub struct NullingPane {
    /// The profile in use: what nulling does not measure is taken from it.
    profile: DisplayProfile,
    viewing: Option<Viewing>,
    setup: Setup,
    stage: Stage,
}

/// Where a run stands.
enum Stage {
    Setup,
    Instructions(Box<Trials>),
    Trials(Box<Trials>),
    Paused(Box<Trials>),
    Results(Box<Results>),
    Check(Box<Results>, Box<CheckScreen>),
}

impl NullingPane {
    /// For the screen in use; `viewing` tells from where the rows blend.
    pub fn new(profile: DisplayProfile, viewing: Option<Viewing>) -> Self {
        Self { profile, viewing, setup: Setup::default(), stage: Stage::Setup }
    }

    /// Draws the stage.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor) -> ToolGo {
        let mut go = ToolGo::Stay;
        let ctx = ui.ctx().clone();
        let stage = std::mem::replace(&mut self.stage, Stage::Setup);
        self.stage = match stage {
            Stage::Setup => match self.setup.show(ui, self.viewing.as_ref()) {
                setup::Go::Stay => Stage::Setup,
                setup::Go::Back => {
                    go = ToolGo::Back;
                    Stage::Setup
                }
                setup::Go::Begin(trials) => Stage::Instructions(trials),
            },
            Stage::Instructions(trials) => self.instructions(ui, trials),
            Stage::Trials(mut trials) => match trials.show(ui) {
                trial::Go::Stay => Stage::Trials(trials),
                trial::Go::Pause => {
                    full_screen(&ctx, false);
                    Stage::Paused(trials)
                }
                trial::Go::Done => {
                    full_screen(&ctx, false);
                    Stage::Results(Box::new(Results::new(&self.profile, &trials, &self.setup.path())))
                }
            },
            Stage::Paused(trials) => paused(ui, trials),
            Stage::Results(mut results) => match results.show(ui) {
                results::Go::Stay => Stage::Results(results),
                results::Go::Again => Stage::Setup,
                results::Go::Saved(saved) => {
                    go = ToolGo::Saved(saved);
                    Stage::Results(results)
                }
                results::Go::Check(profile) => Stage::Check(results, Box::new(CheckScreen::new(*profile))),
            },
            Stage::Check(results, mut check) => match check.show(ui, monitor) {
                ToolGo::Stay => Stage::Check(results, check),
                _ => Stage::Results(results),
            },
        };
        go
    }

    fn instructions(&self, ui: &mut egui::Ui, mut trials: Box<Trials>) -> Stage {
        let (mut back, mut begin) = (false, false);
        tool(ui, "How to match", &mut back, |ui| {
            for sentence in sentences(trials.method()) {
                ui.label(sentence);
            }
            ui.add_space(6.0);
            ui.label(setup::distance_sentence(self.viewing.as_ref(), trials.period_px()));
            ui.label("Dim the room, and let no lamp shine on the screen. Fields can be colored, full of fine rows, and may seem to shimmer: who is sensitive to patterns should not do this.");
            ui.label(theme::quiet(format!("Every answer is kept in {}", trials.file().display())));
            ui.add_space(12.0);
            begin = theme::primary(ui, "Begin", true, "Space");
        });
        begin |= proceeds(ui);
        match () {
            () if back || ui.input(|input| input.key_pressed(Key::Escape)) => Stage::Setup,
            () if begin => {
                full_screen(ui.ctx(), true);
                trials.begin(ui.input(|input| input.time));
                ui.ctx().request_repaint();
                Stage::Trials(trials)
            }
            () => Stage::Instructions(trials),
        }
    }
}

fn sentences(method: Method) -> [&'static str; 4] {
    match method {
        Method::Staircase => [
            "A square stands in a field of fine rows. Say whether the square is brighter or darker than the field.",
            "Brighter: arrow up, or B. Darker: arrow down, or D. The border has vanished altogether: S.",
            "It soon becomes hard, as it must: guess then. Do not look for long; the first impression is the best.",
            "Backspace takes the last answer back. Esc pauses.",
        ],
        Method::Adjustment => [
            "A square stands in a field of fine rows. Make it as bright as the field, until its border vanishes.",
            "Arrows right and left change it, page up and page down in large steps. Enter accepts.",
            "Go past the match on both sides, and come back to the middle.",
            "Backspace brings the match before back. Esc pauses.",
        ],
    }
}

fn paused(ui: &mut egui::Ui, mut trials: Box<Trials>) -> Stage {
    let (mut leave, mut resume) = (false, false);
    theme::page(ui, |ui| {
        ui.heading("Paused");
        ui.label(trials.progress_sentence());
        ui.add_space(12.0);
        resume = theme::primary(ui, "Go on", true, "Space");
        leave = ui.button("Leave; the answers so far stay in their file").clicked();
        ui.add(egui::Label::new(theme::quiet("What is left cannot be gone on with later: it begins anew.")).wrap());
    });
    resume |= proceeds(ui);
    match () {
        () if leave => Stage::Setup,
        () if resume => {
            full_screen(ui.ctx(), true);
            trials.begin(ui.input(|input| input.time));
            ui.ctx().request_repaint();
            Stage::Trials(trials)
        }
        () => Stage::Paused(trials),
    }
}

/// Space, where no control has the keyboard. Not Enter: that ends the typing in a field, and is for the field alone.
fn proceeds(ui: &egui::Ui) -> bool {
    let focused = ui.ctx().memory(|memory| memory.focused().is_some());
    !focused && ui.input(|input| input.key_pressed(Key::Space))
}

fn full_screen(ctx: &egui::Context, full: bool) {
    ctx.send_viewport_cmd(ViewportCommand::Fullscreen(full));
}
