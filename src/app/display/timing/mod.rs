//! How evenly frames come, measured while something changes with each of them.

pub(super) mod pane;
mod report;
mod scene;

use std::{
    sync::{Arc, Mutex, OnceLock, PoisonError},
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};

use eframe::{
    egui::{self, Color32, CursorIcon, Key, ViewportCommand},
    egui_wgpu::RenderState,
};

use crate::{
    app::{Monitor, theme},
    display::frames::FrameTimes,
};

pub use report::{TimingReport, table};
use scene::Scene;
pub use scene::{Patch, Place, SceneKind};

/// Frames before the measurement: caches fill, and a window comes to rest.
const SETTLING: u32 = 30;
/// How long the warning stands before something flickers, seconds.
const WARNING_S: f64 = 3.0;
/// What somebody must know before something flickers.
pub const WARNING: &str = "A patch is going to flicker between black and white with every frame. Flicker can cause seizures in people with photosensitive epilepsy: do not look at it, and let nobody look who may be at risk.";

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// What is drawn meanwhile.
    pub scene: SceneKind,
    /// Frames to measure, at least 2.
    pub frames: u32,
    /// The patch that flickers, in [`SceneKind::Patch`].
    pub patch: Patch,
}

/// A measurement that runs.
pub struct Run {
    plan: Plan,
    scene: Scene,
    /// When the warning began; what does not flicker needs none.
    warned: Option<f64>,
    frame: u32,
    times: FrameTimes,
}

impl Run {
    /// Ready to begin; a flicker begins after a warning.
    pub fn new(plan: Plan) -> Self {
        Self { plan, scene: Scene::new(plan.scene, plan.patch), warned: None, frame: 0, times: FrameTimes::default() }
    }

    /// Draws a frame and asks for the next; the report when all are measured.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor, state: Option<&RenderState>) -> Option<TimingReport> {
        let now = ui.input(|input| input.time);
        ui.ctx().request_repaint();
        if self.plan.scene == SceneKind::Patch {
            let since = *self.warned.get_or_insert(now);
            if now - since < WARNING_S {
                warning(ui, WARNING_S - (now - since));
                return None;
            }
        }
        self.scene.show(ui, self.frame, state);
        self.frame += 1;
        if self.frame > SETTLING {
            self.times.frame(Duration::try_from_secs_f64(now).unwrap_or_default(), None);
        }
        let measured = self.times.intervals_us();
        (measured.len() >= self.plan.frames as usize).then(|| TimingReport::new(measured.to_vec(), monitor))
    }

    /// What stands behind everything.
    pub fn ground(&self) -> Color32 {
        self.scene.ground(self.frame)
    }
}

fn warning(ui: &mut egui::Ui, left_s: f64) {
    theme::page(ui, |ui| {
        ui.heading("Flicker");
        ui.add(egui::Label::new(WARNING).wrap());
        ui.label(format!("It begins in {:.0} s. Esc stops.", left_s.ceil()));
    });
}

/// What `machband timing` asks of the window.
#[derive(Clone, Debug)]
pub struct TimingRequest {
    /// What is measured.
    pub plan: Plan,
    /// On the whole screen.
    pub fullscreen: bool,
    /// Where the report goes.
    pub report: Slot,
}

/// Where the window leaves a report for who opened it.
#[derive(Clone, Debug, Default)]
pub struct Slot(Arc<Mutex<Option<TimingReport>>>);

impl Slot {
    fn put(&self, report: TimingReport) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(report);
    }

    /// The report; `None` where the window was closed before its end.
    pub fn take(&self) -> Option<TimingReport> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// The window of `machband timing`: measures, and closes.
pub struct TimingPage {
    run: Run,
    report: Slot,
    /// Passes so far, and when the first picture was on its way to the screen.
    passes: u32,
    first: Option<FirstFrame>,
    /// Measured: the window is about to close.
    done: bool,
}

/// When the first frame had been handed to the system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstFrame {
    /// Since the program began, seconds.
    pub since_start_s: f64,
    /// Seconds since 1970, UTC.
    pub unix_s: f64,
}

impl TimingPage {
    /// For a request.
    pub fn new(request: TimingRequest) -> Self {
        Self { run: Run::new(request.plan), report: request.report, passes: 0, first: None, done: false }
    }

    /// Draws a frame; `true` when the page is done.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor, state: Option<&RenderState>) -> bool {
        self.passes += 1;
        if self.passes == 2 {
            // The pass before has been drawn and handed over.
            self.first = Some(FirstFrame::now());
        }
        ui.ctx().set_cursor_icon(CursorIcon::None);
        if self.done {
            return false;
        }
        let report = self.run.show(ui, monitor, state);
        if let Some(mut report) = report {
            report.first = self.first;
            self.report.put(report);
            self.done = true;
        }
        self.done |= ui.input(|input| input.key_pressed(Key::Escape));
        self.done
    }

    /// What stands behind everything.
    pub fn ground(&self) -> Color32 {
        self.run.ground()
    }

    /// Leaves the window.
    pub fn leave(ctx: &egui::Context) {
        ctx.send_viewport_cmd(ViewportCommand::Close);
    }
}

static START: OnceLock<Instant> = OnceLock::new();

/// The program begins: to be called first of all.
pub fn mark_start() {
    START.get_or_init(Instant::now);
}

impl FirstFrame {
    fn now() -> Self {
        Self {
            since_start_s: START.get_or_init(Instant::now).elapsed().as_secs_f64(),
            unix_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64()),
        }
    }
}
