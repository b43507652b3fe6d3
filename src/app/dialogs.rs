//! Dialogs above the pages: help, settings, and the question before the window is closed during a session.

use eframe::egui::{Context, RichText, Ui, ViewportCommand};

use super::{
    session::Trials,
    ui::{Field, Place, ask, hint, notice, paragraph, pixels::logo, secondary, section, theme::SECTION},
};
use crate::store::settings::{Settings, ThemeChoice};

/// Width of a dialog's content, points.
const WIDTH: f32 = 560.0;
/// Width of the column of keys, points.
const KEYS: f32 = 190.0;
/// The choices for the zoom; the keys allow others.
const ZOOMS: [f32; 6] = [0.75, 1.0, 1.25, 1.5, 1.75, 2.0];
/// Keys that work everywhere outside trials.
const EVERYWHERE: &[(&str, &str)] = &[
    ("Ctrl+1 … Ctrl+5", "Go to Studies, Analyze, Stimuli, Shading, Display"),
    ("Tab, Shift+Tab", "Go to the next or previous control"),
    ("Page Up, Page Down", "Scroll"),
    ("Esc", "Close a list or dialog; leave a field; then go back"),
    ("Ctrl + and Ctrl −", "Enlarge or reduce text and controls; Ctrl+0 restores their size"),
    ("Ctrl+Q", "Quit; asks first during a session, or if a copy is not saved"),
    ("F1", "This help"),
];

/// Returns the keys of a place.
fn keys_of(place: Place) -> &'static [(&'static str, &'static str)] {
    match place {
        Place::Studies => &[
            ("Arrow keys", "Choose a session"),
            ("Enter", "Begin or resume the chosen session, or open its file"),
            ("Delete", "Remove the chosen session if nothing was rated; asks first"),
            ("Ctrl+S", "While a study is edited: save it"),
            ("Ctrl+Z, Ctrl+Shift+Z", "While a study is edited: undo, redo"),
            ("In a session: 0 1 2 3", "Rate the image (a definition can choose other keys)"),
            ("In a session: Backspace", "Withdraw the last answer, before the next image"),
            ("In a session: S", "Show or hide the scale"),
            ("In a session: Esc", "Pause"),
        ],
        Place::Stimuli => &[("Ctrl+Z, Ctrl+Shift+Z", "Undo, redo"), ("Arrow keys", "Move the slider with the focus")],
        Place::Shading => &[
            ("Arrow keys", "Rotate the mesh, or move the scan line; Shift for small steps"),
            ("Drag", "The same with the mouse; with the right button, move the light"),
            ("Ctrl+Z, Ctrl+Shift+Z", "Undo, redo"),
        ],
        Place::Display => &[("Enter", "Accept a reading or a match"), ("Backspace", "Go back to the previous one")],
        Place::Analyze => &[("Space on a column name", "Sort the table by that column")],
    }
}

/// Draws the help; returns whether it stays open.
pub fn help(ctx: &Context, place: Place) -> bool {
    notice(ctx, "help", WIDTH, |ui| {
        let commit = env!("MACHBAND_COMMIT");
        let commit = commit.get(..12).unwrap_or(commit);
        ui.horizontal(|ui| {
            logo(ui, 40.0, false);
            ui.vertical(|ui| {
                ui.label(RichText::new("machband").strong().size(SECTION));
                ui.label(secondary(format!("version {}, commit {commit}", env!("CARGO_PKG_VERSION"))));
            });
        });
        paragraph(ui, "Measure, analyze, generate and predict the visibility of Mach bands.");
        section(ui, "Keys of this page");
        keys(ui, keys_of(place));
        section(ui, "Keys everywhere");
        keys(ui, EVERYWHERE);
        section(ui, "About");
        paragraph(ui, "License: MIT or Apache-2.0, as you choose.");
        paragraph(
            ui,
            "To cite machband, use CITATION.cff in its source. The guide is in the folder docs: run.md for sessions, definitions.md for experiments, analyze.md for results. `machband --help` lists the commands.",
        );
    })
}

/// Draws the settings; returns whether they stay open.
pub fn settings(ctx: &Context, settings: &mut Settings, problem: Option<&str>) -> bool {
    notice(ctx, "settings", WIDTH, |ui| {
        ui.heading("Settings");
        let themes =
            [(ThemeChoice::System, "Follow the system"), (ThemeChoice::Light, "Light"), (ThemeChoice::Dark, "Dark")];
        Field::new("Theme").column(120.0).radio(ui, &mut settings.theme, &themes);
        hint(ui, "Sessions are always dark, so that pages between trials do not change the eye's adaptation.");
        let title = |zoom: &f32| format!("{:.0} %", zoom * 100.0);
        Field::new("Size").column(120.0).width(110.0).choice(ui, &mut settings.zoom, &ZOOMS, title);
        hint(ui, "Also with Ctrl + and Ctrl −. Stimuli keep their size.");
        ui.checkbox(&mut settings.full_screen, "Run sessions full screen");
        match problem {
            Some(problem) => problem.lines().for_each(|line| super::ui::note(ui, line)),
            None => hint(
                ui,
                "These settings are remembered, together with the screen, the results folder and recent files. Data about participants are not.",
            ),
        }
    })
}

fn keys(ui: &mut Ui, keys: &[(&str, &str)]) {
    for (key, what) in keys {
        ui.horizontal_top(|ui| {
            ui.scope(|ui| {
                ui.set_width(KEYS);
                ui.label(RichText::new(*key).strong());
            });
            paragraph(ui, *what);
        });
    }
}

/// The question before the window is closed during a session or a measurement.
#[derive(Default)]
pub struct Quit {
    /// The open question, its text, and the answer that keeps the window open.
    question: Option<(&'static str, String, &'static str)>,
    agreed: bool,
}

impl Quit {
    /// Keeps the window open, and asks whether to quit during the measurement that was just paused.
    pub fn ask(&mut self, ctx: &Context) {
        ctx.send_viewport_cmd(ViewportCommand::CancelClose);
        let text = "Readings and matches are saved; the intervals of a stopped timing are not.".to_owned();
        self.question = Some(("Quit during the measurement?", text, "Stay"));
    }

    /// Handles a request to close the window, and draws the question if there is one. Closing the window a second time
    /// answers it. While an answer is only in memory, the window cannot be closed, because it would be lost.
    pub fn show(&mut self, ctx: &Context, trials: Option<&mut Trials>) {
        let requested = ctx.input(|input| input.viewport().close_requested());
        if let Some(trials) = trials.filter(|_| requested)
            && (trials.is_unsaved() || !(self.question.is_some() || self.agreed))
        {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            trials.pause(ctx);
            let question = || ("Quit during the session?", trials.how_to_resume(), "Continue the session");
            self.question = (!trials.is_unsaved()).then(question);
        }
        let Some((question, text, keep)) = &self.question else { return };
        if let Some(quits) = ask(ctx, question, text, [*keep, "Quit"]) {
            (self.question, self.agreed) = (None, quits);
            if quits {
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
        }
    }
}
