//! A measurement that runs.

use std::time::Duration;

use eframe::egui::{self, Color32};

use super::{
    report::TimingReport,
    scene::{Drawing, Patch, Scene},
};
use crate::{
    app::ui::{Monitor, page, paragraph},
    display::frames::FrameTimes,
};

/// Frames before the measurement: caches fill, and a window comes to rest.
const SETTLING: u32 = 30;
/// How long the warning is shown before something flickers, seconds.
const WARNING_S: f64 = 3.0;
/// What everyone must know before something flickers.
pub const FLICKER_WARNING: &str = "A patch will flicker between black and white with every frame. Flicker can cause seizures in people with photosensitive epilepsy: do not look at it, and keep anyone at risk from looking at it.";

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimingPlan {
    /// What is drawn meanwhile.
    pub scene: Scene,
    /// Frames to measure, at least 2.
    pub frames: u32,
    /// The patch that flickers, in [`Scene::Patch`].
    pub patch: Patch,
}

/// A measurement.
pub struct TimingRun {
    plan: TimingPlan,
    drawing: Drawing,
    /// When the warning began; what does not flicker needs none.
    warned: Option<f64>,
    frame: u32,
    times: FrameTimes,
}

impl TimingRun {
    /// Ready to begin; a flicker begins after a warning.
    pub fn new(plan: TimingPlan) -> Self {
        let drawing = Drawing::new(plan.scene, plan.patch);
        Self { plan, drawing, warned: None, frame: 0, times: FrameTimes::default() }
    }

    /// Draws a frame and asks for the next; the report when all are measured.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor) -> Option<TimingReport> {
        let now = ui.input(|input| input.time);
        ui.ctx().request_repaint();
        if self.plan.scene == Scene::Patch {
            let left_s = WARNING_S - (now - *self.warned.get_or_insert(now));
            if left_s > 0.0 {
                warn(ui, left_s);
                return None;
            }
        }
        self.drawing.show(ui, self.frame);
        self.frame += 1;
        if self.frame > SETTLING {
            self.times.frame(Duration::try_from_secs_f64(now).unwrap_or_default(), None);
        }
        let measured = self.times.intervals_us();
        (measured.len() >= self.plan.frames as usize).then(|| TimingReport::new(measured, monitor))
    }

    /// The color behind everything.
    pub fn ground(&self) -> Color32 {
        self.drawing.ground(self.frame)
    }
}

fn warn(ui: &mut egui::Ui, left_s: f64) {
    page(ui, |ui| {
        ui.heading("Flicker");
        paragraph(ui, FLICKER_WARNING);
        ui.label(format!("It begins in {:.0} s. Esc stops.", left_s.ceil()));
    });
}
