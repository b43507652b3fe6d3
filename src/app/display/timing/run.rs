//! A running measurement, what is drawn during it, and the window of `machband timing`, which measures and closes.

use std::{sync::mpsc::Sender, time::Duration};

use eframe::egui::{
    CentralPanel, Color32, CursorIcon, Frame, Key, Rect, TextureHandle, Ui, Vec2, emath::GuiRounding as _,
};

use super::report::TimingReport;
use crate::{
    app::ui::{Monitor, page, paragraph, pixels, theme::DARK_PAGE},
    display::frames::FrameTimes,
    light::{Bits, Quantizer, Transfer},
    stimulus::{MachBand, Stimulus},
};

/// Frames that are skipped before the measurement while caches fill and the window settles.
const SETTLING: u32 = 30;
/// How long the warning is shown before something flickers, seconds.
const WARNING_S: f64 = 3.0;
/// The safety warning that precedes a flickering patch.
pub const FLICKER_WARNING: &str = "A patch will flicker between black and white with every frame. Flicker can cause seizures in people with photosensitive epilepsy: do not look at it, and keep anyone at risk from looking at it.";
/// Side of the trial's stimulus, physical pixels.
const STIMULUS_PX: u32 = 512;
/// Number of frames that show the field and then the stimulus in a trial.
const FIELD_FRAMES: u32 = 30;
const STIMULUS_FRAMES: u32 = 60;
/// Distance from the patch to the edge of the window, physical pixels.
const MARGIN_PX: f32 = 16.0;

/// What is drawn during a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Scene {
    /// A patch that alternates between black and white: a target for a photodiode.
    Patch,
    /// The screen of a trial as in a session: the uniform field, and a different stimulus in each trial.
    Trial,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Place {
    /// In the upper left corner, where a photodiode can be held.
    Corner,
    /// In the middle of the window.
    Center,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Side of the patch, physical pixels.
    pub size_px: u32,
    pub place: Place,
}

impl Default for Patch {
    /// Returns a small patch, so that it stimulates as little of the retina as possible.
    fn default() -> Self {
        Self { size_px: 96, place: Place::Corner }
    }
}

/// The settings of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimingPlan {
    /// What is drawn during the measurement.
    pub scene: Scene,
    /// Frames to measure, at least 2.
    pub frames: u32,
    /// The flickering patch of [`Scene::Patch`].
    pub patch: Patch,
}

/// A measurement in progress.
pub struct TimingRun {
    plan: TimingPlan,
    /// The window's time at which the warning began, seconds. Content that does not flicker needs no warning.
    warned: Option<f64>,
    frame: u32,
    times: FrameTimes,
    quantizer: Quantizer,
    /// Number of the current trial, from 0, and its image.
    picture: Option<(u32, TextureHandle)>,
}

impl TimingRun {
    /// Creates a measurement that is ready to begin. Flicker begins only after a warning.
    pub fn new(plan: TimingPlan) -> Self {
        let quantizer = Quantizer::new(Transfer::Srgb, Bits::Eight);
        Self { plan, warned: None, frame: 0, times: FrameTimes::default(), quantizer, picture: None }
    }

    /// Draws a frame and requests the next one; returns the report once all frames are measured.
    pub fn show(&mut self, ui: &mut Ui, monitor: &Monitor) -> Option<TimingReport> {
        let now = ui.input(|input| input.time);
        ui.ctx().request_repaint();
        match self.plan.scene {
            Scene::Patch => {
                let remaining_s = WARNING_S - (now - *self.warned.get_or_insert(now));
                if remaining_s > 0.0 {
                    warn(ui, remaining_s);
                    return None;
                }
                draw_patch(ui, self.plan.patch, self.frame);
            }
            Scene::Trial => self.draw_trial(ui),
        }
        self.frame += 1;
        if self.frame > SETTLING {
            self.times.frame(Duration::try_from_secs_f64(now).unwrap_or_default(), None);
        }
        let measured = self.times.intervals_us();
        (measured.len() >= self.plan.frames as usize).then(|| TimingReport::new(measured, monitor))
    }

    /// Returns the background color of the page.
    pub fn ground(&self) -> Color32 {
        match self.plan.scene {
            // Black, so that nothing of the warning page remains behind the patch.
            Scene::Patch if self.frame > 0 => Color32::BLACK,
            Scene::Patch => DARK_PAGE,
            Scene::Trial => pixels::field(&self.quantizer, stimulus(0).field_light(0.5)),
        }
    }

    /// Draws the screen of a trial.
    fn draw_trial(&mut self, ui: &mut Ui) {
        let trial = self.frame / (FIELD_FRAMES + STIMULUS_FRAMES);
        if self.picture.as_ref().is_none_or(|(made, _)| *made != trial) {
            // As in a session, the texture is created while the field is shown.
            let texture = pixels::texture(ui.ctx(), "timing", &stimulus(trial).codes(STIMULUS_PX, &self.quantizer));
            self.picture = Some((trial, texture));
        }
        let shown = self.frame % (FIELD_FRAMES + STIMULUS_FRAMES) >= FIELD_FRAMES;
        CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            if let Some((_, texture)) = self.picture.as_ref().filter(|_| shown) {
                pixels::draw_centered(ui, texture, ui.ctx().content_rect());
            }
        });
    }
}

/// Returns a different stimulus for each trial.
fn stimulus(trial: u32) -> Stimulus {
    let mut stimulus = Stimulus::MachBand(MachBand::default());
    // Cannot fail: the orientation is valid for every Mach band.
    let _ = stimulus.set("orientation_deg", &f64::from(45 * (trial % 8)).into());
    stimulus
}

fn draw_patch(ui: &mut Ui, patch: Patch, frame: u32) {
    CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
        let scale = ui.ctx().pixels_per_point();
        let side = Vec2::splat(patch.size_px as f32 / scale);
        let area = ui.ctx().content_rect();
        let corner = match patch.place {
            Place::Corner => area.min + Vec2::splat(MARGIN_PX / scale),
            Place::Center => area.center() - side / 2.0,
        };
        let rect = Rect::from_min_size(corner.round_to_pixels(scale), side);
        let color = if frame.is_multiple_of(2) { Color32::WHITE } else { Color32::BLACK };
        ui.painter().rect_filled(rect, 0.0, color);
    });
}

fn warn(ui: &mut Ui, remaining_s: f64) {
    page(ui, |ui| {
        ui.heading("Flicker");
        paragraph(ui, FLICKER_WARNING);
        ui.label(format!("It begins in {:.0} s. Press Esc to stop.", remaining_s.ceil()));
    });
}

/// A measurement that `machband timing` requests.
pub struct TimingRequest {
    pub plan: TimingPlan,
    /// Whether the window is full screen.
    pub fullscreen: bool,
    /// Receives the report; nothing is sent if the window is closed early.
    pub report: Sender<TimingReport>,
}

/// The page of the window of `machband timing`.
pub struct TimingPage {
    run: TimingRun,
    report: Sender<TimingReport>,
    /// Whether the window is about to close.
    done: bool,
}

impl TimingPage {
    pub fn new(request: TimingRequest) -> Self {
        Self { run: TimingRun::new(request.plan), report: request.report, done: false }
    }

    /// Draws a frame; returns whether the measurement is done.
    pub fn show(&mut self, ui: &mut Ui, monitor: &Monitor) -> bool {
        ui.ctx().set_cursor_icon(CursorIcon::None);
        if self.done {
            return false;
        }
        let report = self.run.show(ui, monitor);
        self.done = report.is_some() || ui.input(|input| input.key_pressed(Key::Escape));
        if let Some(report) = report {
            // If the receiver is gone, nobody needs the report.
            let _ = self.report.send(report);
        }
        self.done
    }

    /// Returns the background color of the page.
    pub fn ground(&self) -> Color32 {
        self.run.ground()
    }
}
