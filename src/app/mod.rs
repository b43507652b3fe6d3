//! Floors 7 to 12: the window and all its pages. No other floor uses it.
//!
//! | room | contents |
//! |---|---|
//! | `ui` | elements that all pages share |
//! | `window` | the event loop, timestamps of keys, and the loss of the window |
//! | `analysis` | reading files and showing the results |
//! | `editor` | duplicating and editing a definition |
//! | `explore` | the gallery of stimuli; shaders side by side |
//! | `session` | preflight, instructions, trials, the last page |
//! | `display` | tools that measure the screen |
//! | `studies` | the studies, their sessions, and what can be done with them |

mod analysis;
mod dialogs;
mod display;
mod editor;
pub mod explore;
mod memory;
mod session;
mod studies;
mod ui;
mod window;

use std::{path::PathBuf, time::Instant};

use eframe::egui::{self, ViewportCommand};

use dialogs::Quit;
use memory::Memory;
use session::Runner;
use studies::{Destination, Studies};
use ui::{Place, SideDialog, Step, theme::Icon};
use window::Program;

use crate::{display::DisplayProfile, store::settings::remember};

pub use display::judged_frames;
pub use session::Request;
pub use ui::{Monitor, pixels::icon, platform::is_resampled};
pub use window::{Input, Pressed, Stamps, WindowError};

/// How the window starts.
#[derive(Debug, Default)]
pub struct Launch {
    /// The session to start with; `None` to start on the start page.
    pub request: Option<Request>,
    /// The file with the settings; `None` to start with the default settings and to remember nothing.
    pub settings: Option<PathBuf>,
}

/// Opens the window; returns when it is closed.
///
/// # Errors
/// [`WindowError`] if there is no display or no graphics, if one of them is lost, or if a signal ends the program.
pub fn open(launch: Launch) -> Result<(), WindowError> {
    let fullscreen = launch.request.as_ref().is_some_and(|request| !request.windowed);
    window::open(fullscreen, |cc, input| App { input, ..App::new(cc, launch) })
}

/// The program's window.
#[derive(Default)]
pub struct App {
    /// The session that is shown instead of a place.
    session: Option<Runner>,
    place: Place,
    studies: Studies,
    /// The definition that is edited at [`Place::Studies`].
    editor: Option<Box<editor::Editor>>,
    gallery: explore::gallery::Gallery,
    shading: explore::shading::ShadingPage,
    display: display::Display,
    analysis: analysis::Analysis,
    /// Whether the window was started with a session, so that leaving the session closes the window.
    direct: bool,
    dialog: Option<SideDialog>,
    quit: Quit,
    memory: Memory,
    /// Whether the window has been made to fit its screen.
    is_fitted: bool,
    /// Keys and clicks with their arrival times.
    input: Input,
}

impl App {
    /// Shows the first page of a launch.
    pub fn new(cc: &eframe::CreationContext<'_>, launch: Launch) -> Self {
        let direct = launch.request.is_some();
        let session = launch.request.map(Runner::new);
        ui::theme::apply(&cc.egui_ctx);
        Self { session, direct, memory: Memory::open(&cc.egui_ctx, launch.settings), ..Self::default() }
    }

    fn draw(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        let monitor = Monitor::current(ui.ctx(), frame);
        let Some(session) = &mut self.session else { return self.draw_places(ui, &monitor) };
        if !session.show(ui, &monitor, &mut self.input, self.direct) {
            return;
        }
        if self.direct {
            ui.ctx().send_viewport_cmd(ViewportCommand::Close);
        } else if let Some(session) = self.session.take() {
            let finish = session.finish();
            let completed = finish.is_some_and(|finish| finish.complete);
            if let Some(finish) = finish {
                let how = if completed { "finished" } else { "interrupted" };
                let path = finish.path.display();
                ui::say(ui.ctx(), format!("The session is {how}; every answer is saved in {path}."));
            }
            self.go(Place::Studies, completed);
        }
        ui.ctx().request_repaint();
    }

    /// Draws the current place and, below it, the status line, which Tab reaches last.
    fn draw_places(&mut self, ui: &mut egui::Ui, monitor: &Monitor) {
        if self.measured().is_some() {
            return self.draw_place(ui, monitor);
        }
        let (page, line) = ui.max_rect().split_top_bottom_at_y(ui.max_rect().bottom() - ui::theme::ROW);
        ui.scope_builder(egui::UiBuilder::new().max_rect(page), |ui| {
            if let Some(place) = ui::side_bar(ui, self.place, &mut self.dialog) {
                self.go(place, false);
                ui.ctx().request_discard("the side bar shows the place before");
            }
            self.draw_place(ui, monitor);
        });
        ui.scope_builder(egui::UiBuilder::new().max_rect(line), |ui| self.draw_status(ui));
    }

    fn draw_place(&mut self, ui: &mut egui::Ui, monitor: &Monitor) {
        let step = match self.place {
            Place::Studies if self.editor.is_some() => return self.draw_editor(ui),
            Place::Studies => self.studies.show(ui, monitor, &mut self.memory.settings),
            Place::Stimuli | Place::Shading => {
                let (checked, assumed) = (self.studies.check(monitor), DisplayProfile::default());
                let viewing = checked.screen.viewing.filter(|_| !self.studies.screen().width_is_assumed());
                let profile = checked.screen.profile.as_ref().unwrap_or(&assumed);
                Step::back_if(if self.place == Place::Shading {
                    self.shading.show(ui, profile)
                } else {
                    self.gallery.show(ui, profile, viewing)
                })
            }
            Place::Display => {
                let checked = self.studies.check(monitor);
                self.studies.remember(&mut self.memory.settings, monitor, &checked);
                let step = self.display.show(ui, monitor, self.studies.screen(), &checked.screen);
                if step == Step::Next(()) {
                    // The file may have the same name as before.
                    self.studies.refresh(false, &self.memory.settings);
                }
                Step::back_if(step == Step::Back)
            }
            Place::Analyze => {
                let left = self.analysis.show(ui, &self.memory.settings.recent.analyses);
                if let Some(path) = self.analysis.opened() {
                    remember(&mut self.memory.settings.recent.analyses, &path.display().to_string());
                }
                Step::back_if(left)
            }
        };
        match step {
            Step::Stay => return,
            Step::Next(Destination::Session(request)) => {
                self.analysis.pause();
                self.session = Some(Runner::new(*request));
            }
            Step::Next(Destination::Editor(definition, sessions)) => match editor::Editor::of(&definition, sessions) {
                Ok(editor) => self.editor = Some(Box::new(editor)),
                Err(error) => ui::complain(ui.ctx(), error.to_string()),
            },
            Step::Next(Destination::Analysis(data_set)) => {
                self.analysis = analysis::Analysis::of(ui.ctx(), data_set);
                self.place = Place::Analyze;
            }
            Step::Back => self.go(Place::Studies, false),
        }
        ui.ctx().request_repaint();
    }

    /// Draws the line at the lower edge: the latest message, and the folder or the display of the page.
    fn draw_status(&self, ui: &mut egui::Ui) {
        let shown = |path: PathBuf| path.display().to_string();
        let about = match self.place {
            Place::Studies => Some(shown(self.studies.folder())),
            Place::Analyze => self.analysis.opened().map(shown),
            // The pages themselves say which display they are about.
            Place::Display => None,
            Place::Stimuli | Place::Shading => {
                let display = self.studies.checked().and_then(|checked| checked.screen.profile.as_ref().ok());
                display.map(DisplayProfile::sentence)
            }
        };
        let icon = if self.place.shows_stimuli() { Icon::Display } else { Icon::Folder };
        ui::status_line(ui, about.as_deref().map(|about| (icon, about)));
    }

    fn draw_editor(&mut self, ui: &mut egui::Ui) {
        let step = self.editor.as_mut().map_or(Step::Back, |editor| editor.show(ui));
        match step {
            Step::Stay => return,
            Step::Back => self.go(Place::Studies, false),
            Step::Next(path) => {
                ui::say(ui.ctx(), ui::saved(&path));
                self.studies.choose_new(&path, &mut self.memory.settings);
            }
        }
        self.editor = None;
        ui.ctx().request_repaint();
    }

    /// Goes to a place. `completed`: the last session is complete, so that the next participant is entered.
    fn go(&mut self, place: Place, completed: bool) {
        self.place = place;
        match place {
            Place::Studies => self.studies.refresh(completed, &self.memory.settings),
            Place::Analyze => self.analysis.look_again(),
            _ => {}
        }
    }

    /// Returns the page that measures the screen, while it does so. As in a trial, the window shows nothing else.
    fn measured(&mut self) -> Option<&mut display::Display> {
        let shown = self.session.is_none() && self.place == Place::Display;
        Some(&mut self.display).filter(|display| shown && display.measures())
    }

    fn draw_dialogs(&mut self, ctx: &egui::Context) {
        let open = match self.dialog {
            Some(SideDialog::Help) => dialogs::help(ctx, self.place),
            Some(SideDialog::Settings) => {
                dialogs::settings(ctx, &mut self.memory.settings, self.memory.problem.as_deref())
            }
            None => return,
        };
        self.dialog = self.dialog.filter(|_| open);
    }

    /// Asks before the window is closed while something would be left unfinished.
    fn ask_before_closing(&mut self, ctx: &egui::Context) {
        let closes = ctx.input(|input| input.viewport().close_requested());
        if closes && let Some(display) = self.measured() {
            display.pause(ctx);
            self.quit.ask(ctx);
        }
        let trials = self.session.as_mut().and_then(|session| session.trials());
        self.quit.show(ctx, trials);
        if closes && self.editor.as_mut().is_some_and(|editor| editor.asks_before_closing()) {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.place = Place::Studies;
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.input.frame(ui.input(|input| input.time), Instant::now());
        let is_dark = self.session.is_some() || self.measured().is_some();
        self.memory.apply(ui.ctx(), is_dark);
        if !std::mem::replace(&mut self.is_fitted, true) && self.session.is_none() {
            ui::fit_window(ui.ctx());
        }
        ui::begin_frame(ui.ctx());
        self.draw(ui, frame);
        self.draw_dialogs(ui.ctx());
        self.ask_before_closing(ui.ctx());
        self.memory.save(ui.ctx());
        ui::end_frame(ui.ctx());
    }

    fn on_exit(&mut self) {
        self.close();
    }

    /// Returns the background of the page, or the uniform field of a trial. Clearing to this color costs nothing;
    /// without a GPU, drawing a full-screen rectangle would take most of a frame's time.
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        let ground = match &self.session {
            Some(session) => session.ground(),
            None if self.place == Place::Display && self.display.measures() => egui::Color32::BLACK,
            None => ui::theme::ink_of(visuals).page,
        };
        ground.to_normalized_gamma_f32()
    }
}

impl Program for App {
    fn close(&mut self) -> Option<PathBuf> {
        self.memory.save_now();
        let trials = self.session.as_mut()?.trials()?;
        trials.close();
        Some(trials.recording.store.csv().to_owned())
    }
}
