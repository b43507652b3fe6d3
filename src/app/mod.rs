//! Floors 6 to 11: the window and all its pages. No other floor uses it.
//!
//! | room | contents |
//! |---|---|
//! | `ui` | elements that all pages share |
//! | `window` | the event loop, timestamps of keys, and the loss of the window |
//! | `analysis` | reading files and showing the results |
//! | `explore` | the gallery of stimuli; shaders side by side |
//! | `session` | preflight, instructions, trials, the last page |
//! | `display` | tools that measure the screen |
//! | `start` | Home and its form |

mod analysis;
mod display;
pub mod explore;
mod session;
mod start;
mod ui;
mod window;

use std::{path::PathBuf, time::Instant};

use eframe::egui::{self, ViewportCommand};

use session::Runner;
use start::{Destination, Form, Home};
use ui::Step;
use window::Program;

pub use display::timing;
pub use session::Request;
pub use ui::{Monitor, platform::is_resampled};
pub use window::{Input, InputReport, Pressed, Stamps, WindowError};

/// How the window starts.
#[derive(Debug, Default)]
pub struct Launch {
    /// The session to start with; `None` to start on Home.
    pub request: Option<Request>,
}

/// Opens the window; returns when it is closed.
///
/// # Errors
/// [`WindowError`] if there is no display or no graphics, if one of them is lost, or if a signal ends the program.
pub fn open(launch: Launch) -> Result<(), WindowError> {
    let fullscreen = launch.request.as_ref().is_some_and(|request| !request.windowed);
    window::open(fullscreen, |cc, input| App { input, ..App::new(cc, launch) })
}

/// Opens a window that measures its frame times; returns when it is closed.
///
/// # Errors
/// [`WindowError`] if there is no display or no graphics, if one of them is lost, or if a signal ends the program.
pub fn time(request: timing::TimingRequest) -> Result<(), WindowError> {
    window::open(request.fullscreen, |cc, input| App { input, ..App::timing(cc, request) })
}

enum Page {
    Home(Box<Home>),
    Session(Box<Runner>),
    Gallery(Box<explore::gallery::Gallery>),
    Shading(Box<explore::shading::ShadingPage>),
    Display(Box<display::Display>),
    Analysis(Box<analysis::Analysis>),
    Timing(Box<timing::TimingPage>),
}

/// The program's window.
pub struct App {
    page: Page,
    /// The page to return to from the analysis, if it is not Home.
    behind: Option<Page>,
    /// Whether the window was started with a session, so that leaving the session closes the window.
    direct: bool,
    monitors: Vec<Monitor>,
    /// The current values of Home's fields.
    form: Form,
    /// Keys and clicks with their arrival times.
    input: Input,
}

impl App {
    /// Shows the first page of a launch.
    pub fn new(cc: &eframe::CreationContext<'_>, launch: Launch) -> Self {
        let direct = launch.request.is_some();
        let page = match launch.request {
            Some(request) => Page::Session(Box::new(Runner::new(request))),
            None => Page::Home(Box::default()),
        };
        Self::at(cc, page, direct)
    }

    /// Creates the window of `machband timing`, which only measures frames.
    pub fn timing(cc: &eframe::CreationContext<'_>, request: timing::TimingRequest) -> Self {
        Self::at(cc, Page::Timing(Box::new(timing::TimingPage::new(request))), true)
    }

    fn at(cc: &eframe::CreationContext<'_>, page: Page, direct: bool) -> Self {
        ui::theme::apply(&cc.egui_ctx);
        ui::blit::install(cc);
        let (form, input) = (Form::default(), Input::default());
        Self { page, behind: None, direct, monitors: Vec::new(), form, input }
    }

    /// Draws the page; returns whether to stay, go back, or show another page.
    fn draw(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) -> Step<Page> {
        let monitor = Monitor::current(ui.ctx(), frame);
        match &mut self.page {
            Page::Home(home) => {
                self.monitors = Monitor::all(frame);
                let step = home.show(ui, &monitor, &self.monitors);
                self.form = home.form().clone();
                step.map(|destination| self.page_of(destination))
            }
            Page::Session(session) => {
                let step = session.show(ui, &monitor, &mut self.input, self.direct);
                step.map(|data_set| Page::Analysis(Box::new(analysis::Analysis::of(ui.ctx(), data_set))))
            }
            Page::Gallery(gallery) => gallery.show(ui).widen(),
            Page::Shading(shading) => shading.show(ui, frame.wgpu_render_state()).widen(),
            Page::Display(display) => {
                let step = display.show(ui, &monitor);
                self.form.screen = display.fields().clone();
                step.widen()
            }
            Page::Analysis(analysis) => analysis.show(ui).widen(),
            Page::Timing(timing) => Step::back_if(timing.show(ui, &monitor)),
        }
    }

    fn page_of(&self, destination: Destination) -> Page {
        match destination {
            Destination::Session(request) => Page::Session(Box::new(Runner::new(*request))),
            Destination::Display { window_deg } => {
                Page::Display(Box::new(display::Display::new(self.form.screen.clone(), window_deg)))
            }
            Destination::Gallery(profile, distance_cm) => {
                Page::Gallery(Box::new(explore::gallery::Gallery::new(*profile, distance_cm)))
            }
            Destination::Shading => Page::Shading(Box::default()),
            Destination::Analysis(results) => Page::Analysis(Box::new(analysis::Analysis::new(&results))),
        }
    }

    /// Returns the page to go back to; `None` to close the window.
    fn page_behind(&mut self) -> Option<Page> {
        if let Some(page) = self.behind.take() {
            return Some(page);
        }
        if self.direct {
            return None;
        }
        let mut form = self.form.clone();
        if matches!(&self.page, Page::Session(session) if session.is_complete()) {
            // After a completed session, the next participant is entered. After an interrupted one, the fields stay, so
            // that it can be resumed.
            form.participant.clear();
        }
        Some(Page::Home(Box::new(Home::again(form))))
    }

    /// Prevents closing while an answer is only in memory, because it would be lost.
    fn keep_unsaved(&self, ctx: &egui::Context) {
        let unsaved = matches!(&self.page, Page::Session(session) if session.is_unsaved());
        if unsaved && ctx.input(|input| input.viewport().close_requested()) {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.input.frame(ui.input(|input| input.time), Instant::now());
        let next = match self.draw(ui, frame) {
            Step::Stay => None,
            Step::Next(page) => Some(page),
            Step::Back => match self.page_behind() {
                Some(page) => Some(page),
                None => {
                    ui.ctx().send_viewport_cmd(ViewportCommand::Close);
                    None
                }
            },
        };
        if let Some(page) = next {
            let left = std::mem::replace(&mut self.page, page);
            // An analysis opened at the end of a session leads back to that page.
            self.behind = Some(left).filter(|left| matches!((left, &self.page), (Page::Session(_), Page::Analysis(_))));
            ui.ctx().request_repaint();
        }
        self.keep_unsaved(ui.ctx());
    }

    fn on_exit(&mut self) {
        self.close();
    }

    /// Returns the background of the page, or the uniform field of a trial. Clearing to this color costs nothing;
    /// without a GPU, drawing a full-screen rectangle would take most of a frame's time.
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        let ground = match &self.page {
            Page::Session(session) => Some(session.ground()),
            Page::Timing(timing) => Some(timing.ground()),
            Page::Display(display) => display.ground(),
            _ => None,
        };
        ground.unwrap_or(ui::theme::ink_of(visuals).page).to_normalized_gamma_f32()
    }
}

impl Program for App {
    fn close(&mut self) -> Option<PathBuf> {
        let Page::Session(session) = &mut self.page else { return None };
        session.close().map(ToOwned::to_owned)
    }
}
