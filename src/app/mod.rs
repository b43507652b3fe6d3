//! Floor 6: the window. One page a file; the only place that makes a texture.
//!
//! Home → preflight → session → finish. `machband run` begins at the preflight. Home → display, gallery, demo, analysis;
//! finish → analysis.

mod analysis;
mod blit;
pub mod demo;
mod dialog;
mod display;
mod event_loop;
mod explore;
mod finish;
mod form;
mod frames;
mod hasher;
mod home;
mod input;
mod loss;
mod monitor;
mod pages;
mod pixels;
mod platform;
mod preflight;
mod scale;
mod session;
mod theme;
mod trouble;
mod work;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use eframe::{
    egui::{self, ViewportBuilder, ViewportCommand},
    egui_wgpu::WgpuSetup,
    wgpu::DeviceDescriptor,
};

use crate::{
    display::DisplayProfile,
    experiment::{Identity, Protocol},
    shading::gpu,
};

pub use display::timing;
pub use monitor::Monitor;

/// How the window starts.
#[derive(Debug, Default)]
pub struct Launch {
    /// Straight into this session; `None` for Home.
    pub request: Option<Request>,
}

/// A session that is to be run, with everything checked that can be checked before the screen is known.
#[derive(Clone, Debug)]
pub struct Request {
    /// The definition.
    pub protocol: Protocol,
    /// Whose session.
    pub identity: Identity,
    /// Seed of the order; `None` for a fresh one, or on resume the one it had.
    pub seed: Option<u64>,
    /// Results folder.
    pub results: PathBuf,
    /// What is known of the screen.
    pub display: DisplayProfile,
    /// Eye to screen, cm.
    pub distance_cm: f64,
    /// Width of the screen in cm; `None` to assume 96 pixels an inch.
    pub screen_width_cm: Option<f64>,
    /// Go on with an interrupted session.
    pub resume: bool,
    /// In a window instead of the full screen.
    pub windowed: bool,
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// No display to open a window on.
    #[error(
        "display: no window can be opened, since neither DISPLAY nor WAYLAND_DISPLAY is set; expected a desktop session (without one, `machband simulate` runs sessions with a simulated observer)"
    )]
    NoDisplay,
    /// The window system or the graphics driver refused.
    #[error(
        "display: no window can be opened ({0}); expected a desktop session with Vulkan or OpenGL (without one, `machband simulate` runs sessions with a simulated observer)"
    )]
    Refused(String),
    /// The window system or the graphics driver went away while the window was open.
    #[error("{}", lost(reason, rows.as_deref()))]
    Lost {
        /// What they said.
        reason: String,
        /// Where the rows of the session are that ran.
        rows: Option<PathBuf>,
    },
}

fn lost(reason: &str, rows: Option<&Path>) -> String {
    let (place, kept) = match rows {
        Some(rows) => (
            rows.display().to_string(),
            "every answer that was saved is there; expected the same command with --resume, or Home with the same participant and session, to go on",
        ),
        None => ("display".to_owned(), "expected a window system and graphics that stay"),
    };
    format!("{place}: the window was lost ({reason}); {kept}")
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// [`WindowError`] where there is no display, or no graphics.
pub fn open(launch: Launch) -> Result<(), WindowError> {
    let fullscreen = launch.request.as_ref().is_some_and(|request| !request.windowed);
    window(fullscreen, |cc| App::new(cc, launch))
}

/// Opens a window that measures its frames, and returns when it is closed.
///
/// # Errors
/// [`WindowError`] where there is no display, or no graphics.
pub fn time(request: timing::TimingRequest) -> Result<(), WindowError> {
    window(request.fullscreen, |cc| App::timing(cc, request))
}

fn window(
    fullscreen: bool,
    app: impl FnOnce(&eframe::CreationContext<'_>) -> App + 'static,
) -> Result<(), WindowError> {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(target_os = "linux") && !set("DISPLAY") && !set("WAYLAND_DISPLAY") {
        return Err(WindowError::NoDisplay);
    }
    let stamps = input::Stamps::default();
    let input = input::Input::hearing(stamps.clone());
    event_loop::run(options(fullscreen), stamps, loss::Shared::new(|cc| App { input, ..app(cc) }))
}

/// Least size of the window, outside sessions, in points.
const LEAST_SIZE: egui::Vec2 = egui::vec2(420.0, 360.0);

fn options(fullscreen: bool) -> eframe::NativeOptions {
    let mut options = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("machband")
            .with_inner_size([1100.0, 860.0])
            .with_min_inner_size(LEAST_SIZE)
            .with_fullscreen(fullscreen),
        // egui's dither adds noise to every pixel, stimulus included.
        dithering: false,
        ..Default::default()
    };
    // All that the graphics card has: eframe's own choice leaves OpenGL without what the shaders read.
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_options.wgpu_setup {
        setup.device_descriptor = Arc::new(|adapter| DeviceDescriptor {
            label: Some("machband"),
            required_limits: gpu::limits(adapter),
            ..Default::default()
        });
    }
    // One frame in flight: an image reaches the screen as soon as the system allows.
    options.wgpu_options.surface.desired_maximum_frame_latency = Some(1);
    options
}

/// The day, by the system's clock.
fn today() -> jiff::civil::Date {
    jiff::tz::TimeZone::UTC.to_datetime(jiff::Timestamp::now()).date()
}

/// What the window shows.
enum Page {
    Home(Box<home::Home>),
    Preflight(Box<preflight::Preflight>),
    Session(Box<session::SessionPage>),
    Finish(Box<finish::Finish>),
    Gallery(Box<explore::gallery::Gallery>),
    Demo(Box<demo::Demo>),
    Display(Box<display::Display>),
    Analysis(Box<analysis::Analysis>),
    Timing(Box<timing::TimingPage>),
}

/// Where a page leads.
enum Go {
    /// Nowhere yet.
    Stay,
    /// Home, or out of the program where it began with a session.
    Back,
    /// On to a page.
    To(Page),
    /// To a page that leads back here.
    Aside(Page),
}

/// The program's window.
pub struct App {
    page: Page,
    /// Where the page leads back to, if not Home.
    behind: Option<Page>,
    /// Started with a session: leaving it closes the window.
    direct: bool,
    monitors: Vec<Monitor>,
    /// Home's fields as they were left, to come back to.
    form: form::Form,
    /// Keys and clicks with the time of their arrival.
    input: input::Input,
}

impl App {
    /// The first page of a launch.
    pub fn new(cc: &eframe::CreationContext<'_>, launch: Launch) -> Self {
        let direct = launch.request.is_some();
        let page = match launch.request {
            Some(request) => Page::Preflight(Box::new(preflight::Preflight::new(request))),
            None => Page::Home(Box::default()),
        };
        Self::at(cc, page, direct)
    }

    /// Measures frames, and nothing else.
    pub fn timing(cc: &eframe::CreationContext<'_>, request: timing::TimingRequest) -> Self {
        Self::at(cc, Page::Timing(Box::new(timing::TimingPage::new(request))), true)
    }

    fn at(cc: &eframe::CreationContext<'_>, page: Page, direct: bool) -> Self {
        theme::apply(&cc.egui_ctx);
        blit::install(cc);
        let (form, input) = (form::Form::default(), input::Input::default());
        Self { page, behind: None, direct, monitors: Vec::new(), form, input }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.input.frame(ui.input(|input| input.time), Instant::now());
        let monitor = Monitor::current(ui.ctx(), frame);
        if let Page::Home(_) = self.page {
            self.monitors = Monitor::all(frame);
        }
        let go = match &mut self.page {
            Page::Home(home) => home.show(ui, &monitor, &self.monitors),
            Page::Preflight(preflight) => preflight.show(ui, &monitor),
            Page::Session(session) => session.show(ui, &monitor, &mut self.input),
            Page::Finish(finish) => finish.show(ui, self.direct),
            Page::Gallery(gallery) => gallery.show(ui),
            Page::Demo(demo) => demo.show(ui, frame.wgpu_render_state()),
            Page::Display(display) => display.show(ui, &monitor),
            Page::Analysis(analysis) => analysis.show(ui),
            Page::Timing(timing) => {
                if timing.show(ui, &monitor, frame.wgpu_render_state()) {
                    timing::TimingPage::leave(ui.ctx());
                }
                Go::Stay
            }
        };
        match &self.page {
            Page::Home(home) => self.form = home.form().clone(),
            Page::Display(display) => self.form = display.form().clone(),
            _ => {}
        }
        match go {
            Go::Stay => {}
            Go::To(page) => self.turn_to(ui.ctx(), page),
            Go::Aside(page) => {
                self.behind = Some(std::mem::replace(&mut self.page, page));
                ui.ctx().request_repaint();
            }
            Go::Back if self.behind.is_some() => {
                if let Some(page) = self.behind.take() {
                    self.turn_to(ui.ctx(), page);
                }
            }
            Go::Back if self.direct => ui.ctx().send_viewport_cmd(ViewportCommand::Close),
            Go::Back => {
                let mut form = self.form.clone();
                if matches!(&self.page, Page::Finish(finish) if finish.complete) {
                    // The next participant; an interrupted one stays, to be resumed.
                    form.participant.clear();
                }
                self.turn_to(ui.ctx(), Page::Home(Box::new(home::Home::again(form))));
            }
        }
        self.keep_unsaved(ui.ctx());
    }

    fn on_exit(&mut self) {
        self.close();
    }

    /// The page's ground, and the uniform field of a trial: clearing to it costs nothing, while a rectangle over the
    /// whole screen would be most of a frame's work where there is no GPU.
    fn clear_color(&self, _: &egui::Visuals) -> [f32; 4] {
        let ground = match &self.page {
            Page::Session(session) => session.ground(),
            Page::Timing(timing) => timing.ground(),
            Page::Display(display) => display.ground(),
            _ => theme::PAGE,
        };
        ground.to_normalized_gamma_f32()
    }
}

impl App {
    /// Ends a session that runs; gives the file of its rows.
    fn close(&mut self) -> Option<PathBuf> {
        let Page::Session(session) = &mut self.page else { return None };
        session.close();
        Some(session.csv().to_owned())
    }

    fn turn_to(&mut self, ctx: &egui::Context, page: Page) {
        self.page = page;
        ctx.request_repaint();
    }

    /// A window that closes while an answer is only in memory would lose it.
    fn keep_unsaved(&self, ctx: &egui::Context) {
        let unsaved = matches!(&self.page, Page::Session(session) if session.is_unsaved());
        if unsaved && ctx.input(|input| input.viewport().close_requested()) {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
        }
    }
}
