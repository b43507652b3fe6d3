//! What is drawn while frames are measured.

use eframe::egui::{self, Color32, Pos2, Rect, TextureHandle, Vec2};

use crate::{
    app::ui::{pixels, theme::PAGE},
    light::{Bits, Quantizer, Transfer},
    stimulus::{MachBand, Stimulus},
};

/// Side of the trial's stimulus, physical pixels.
const STIMULUS_PX: u32 = 512;
/// Frames of field, and then of stimulus, of a trial.
const FIELD_FRAMES: u32 = 30;
const STIMULUS_FRAMES: u32 = 60;
/// From the patch to the edge of the window, physical pixels.
const MARGIN_PX: f32 = 16.0;

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Scene {
    /// A patch that alternates between black and white: a target for a photodiode.
    Patch,
    /// The screen of a trial as in a session: the uniform field, and a different stimulus in each trial.
    Trial,
}

/// Where the patch is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Place {
    /// In the upper left corner, where a photodiode can be held.
    Corner,
    /// In the center.
    Center,
}

/// The patch that flickers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Its side, physical pixels.
    pub size_px: u32,
    /// Where it is.
    pub place: Place,
}

impl Default for Patch {
    /// Small, so that as little of the eye as possible sees it.
    fn default() -> Self {
        Self { size_px: 96, place: Place::Corner }
    }
}

/// A scene, and what it needs to be drawn.
pub enum Drawing {
    Patch(Patch),
    Trial(Box<Trial>),
}

impl Drawing {
    pub fn new(scene: Scene, patch: Patch) -> Self {
        match scene {
            Scene::Patch => Self::Patch(patch),
            Scene::Trial => Self::Trial(Box::default()),
        }
    }

    /// Draws the frame `frame`, from 0.
    pub fn show(&mut self, ui: &mut egui::Ui, frame: u32) {
        match self {
            Self::Patch(patch) => patch.show(ui, frame),
            Self::Trial(trial) => trial.show(ui, frame),
        }
    }

    /// The color behind everything.
    pub fn ground(&self, frame: u32) -> Color32 {
        match self {
            // Nothing of the warning's page remains behind the patch.
            Self::Patch(_) if frame > 0 => Color32::BLACK,
            Self::Patch(_) => PAGE,
            Self::Trial(trial) => trial.field,
        }
    }
}

impl Patch {
    fn show(self, ui: &mut egui::Ui, frame: u32) {
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| {
            let scale = ui.ctx().pixels_per_point();
            let side = Vec2::splat(self.size_px as f32 / scale);
            let area = ui.ctx().content_rect();
            let whole = |points: f32| (points * scale).round() / scale;
            let corner = match self.place {
                Place::Corner => area.min + Vec2::splat(MARGIN_PX / scale),
                Place::Center => area.center() - side / 2.0,
            };
            let rect = Rect::from_min_size(Pos2::new(whole(corner.x), whole(corner.y)), side);
            let color = if frame.is_multiple_of(2) { Color32::WHITE } else { Color32::BLACK };
            ui.painter().rect_filled(rect, 0.0, color);
        });
    }
}

/// The screen of a trial.
pub struct Trial {
    quantizer: Quantizer,
    field: Color32,
    /// The trial, from 0, and its picture.
    picture: Option<(u32, TextureHandle)>,
}

impl Default for Trial {
    fn default() -> Self {
        let quantizer = Quantizer::new(Transfer::Srgb, Bits::Eight);
        let field = pixels::field(&quantizer, Self::stimulus(0).field_light(0.5));
        Self { quantizer, field, picture: None }
    }
}

impl Trial {
    fn show(&mut self, ui: &mut egui::Ui, frame: u32) {
        let trial = frame / (FIELD_FRAMES + STIMULUS_FRAMES);
        if self.picture.as_ref().is_none_or(|(made, _)| *made != trial) {
            // As in a session: made while the field is shown.
            let stimulus = Self::stimulus(trial);
            let texture = pixels::texture(ui.ctx(), "timing", &stimulus, STIMULUS_PX, &self.quantizer);
            self.picture = Some((trial, texture));
        }
        let shown = frame % (FIELD_FRAMES + STIMULUS_FRAMES) >= FIELD_FRAMES;
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| {
            if let Some((_, texture)) = self.picture.as_ref().filter(|_| shown) {
                pixels::draw_centered(ui, texture, ui.ctx().content_rect());
            }
        });
    }

    /// Another one with each trial.
    fn stimulus(trial: u32) -> Stimulus {
        let mut stimulus = Stimulus::MachBand(MachBand::default());
        let degrees = f64::from(45 * (trial % 8)).into();
        // A direction that every Mach band has.
        let _ = stimulus.set("orientation_deg", &degrees);
        stimulus
    }
}
