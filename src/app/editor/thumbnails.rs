//! The stimuli of all conditions, drawn in the background.

use eframe::egui::{self, Sense, TextureHandle, Ui, Vec2};

use crate::{
    app::ui::{
        self,
        pixels::{self, Drawn},
        theme::{self, GAP},
    },
    experiment::{Condition, Factor, Protocol},
    report::{document::numbers::count, names},
    stimulus::Stimulus,
};

/// Maximum number of thumbnails.
const MAX_THUMBNAILS: usize = 200;
/// Side of a thumbnail, and of one in a line, points.
const SIDE: f32 = 96.0;
const STRIP: f32 = 48.0;

#[derive(Default)]
pub struct Thumbnails {
    /// The revision of the form.
    of: Option<u64>,
    all: Vec<Thumbnail>,
    conditions: usize,
    /// The names of the factors, as captions list their levels.
    factors: String,
    drawn: Drawn<(Vec<Stimulus>, u32)>,
}

struct Thumbnail {
    stimulus: Stimulus,
    levels: Vec<String>,
    /// The levels with the names of their factors.
    description: String,
    texture: Option<TextureHandle>,
}

impl Thumbnails {
    /// Draws the number of conditions, followed by `when`, and their stimuli.
    pub fn show(&mut self, ui: &mut Ui, protocol: &Protocol, revision: u64, when: &str) {
        self.update(ui, protocol, revision, SIDE, MAX_THUMBNAILS);
        let n = self.conditions;
        ui::section(ui, count(n as u64, "condition") + when);
        let mut hint = Vec::new();
        if !self.factors.is_empty() {
            hint.push(format!("Captions: {}.", self.factors));
        }
        if n > self.all.len() {
            hint.push(format!("{} of them are shown, from all parts of the design.", self.all.len()));
        }
        ui::hint(ui, hint.join(" "));
        let gap = ui.spacing().item_spacing.x;
        let per_row = ((ui.available_width() + gap) / (SIDE + gap)).max(1.0) as usize;
        for row in self.all.chunks(per_row) {
            ui.horizontal_top(|ui| row.iter().for_each(|thumbnail| thumbnail.show(ui)));
        }
    }

    /// Draws one line of stimuli, from all parts of the design.
    pub fn strip(&mut self, ui: &mut Ui, protocol: &Protocol) {
        let key = (&protocol.name, &protocol.stimulus, &protocol.factors);
        let revision = egui::Id::unique(format!("{key:?}")).value();
        let shown = ((ui.available_width() + GAP) / (STRIP + GAP)).max(1.0) as usize;
        self.update(ui, protocol, revision, STRIP, shown);
        ui.horizontal(|ui| self.all.iter().for_each(|thumbnail| thumbnail.picture(ui, STRIP)));
    }

    /// Lists up to `most` conditions, from all parts of the design, if the revision is another one, and draws their
    /// pictures with this side, points. Until they are ready, those of the same stimuli stay.
    fn update(&mut self, ui: &Ui, protocol: &Protocol, revision: u64, side: f32, most: usize) {
        if self.of.replace(revision) != Some(revision) {
            self.list(protocol, most);
        }
        let px = (side * ui.ctx().pixels_per_point()).round() as u32;
        let stimuli: Vec<Stimulus> = self.all.iter().map(|thumbnail| thumbnail.stimulus.clone()).collect();
        let drawn = self.drawn.get(ui.ctx(), (stimuli.clone(), px), px, || stimuli);
        let drawn = drawn.into_iter().flat_map(|((stimuli, _), textures)| stimuli.iter().zip(textures));
        self.all.iter_mut().for_each(|thumbnail| thumbnail.texture = None);
        for (thumbnail, (stimulus, texture)) in self.all.iter_mut().zip(drawn) {
            thumbnail.texture = Some(texture.clone()).filter(|_| thumbnail.stimulus == *stimulus);
        }
    }

    fn list(&mut self, protocol: &Protocol, most: usize) {
        let conditions = protocol.conditions();
        self.conditions = conditions.len();
        let known = Some(protocol.stimulus.parameters());
        let names: Vec<String> = protocol.factors.iter().map(|factor| names::factor(known, &factor.name)).collect();
        self.factors = names.join("; ");
        let thumbnail = |condition: &Condition| {
            let level = |(factor, index): (&Factor, &usize)| {
                names::level(known, &factor.name, &factor.levels[*index].to_string()).to_string()
            };
            let levels: Vec<String> = protocol.factors.iter().zip(&condition.levels).map(level).collect();
            let described: Vec<String> =
                names.iter().zip(&levels).map(|(name, level)| format!("{name} {level}")).collect();
            Thumbnail { texture: None, description: described.join("; "), levels, stimulus: condition.stimulus.clone() }
        };
        let step = conditions.len().div_ceil(most).max(1);
        self.all = conditions.iter().step_by(step).map(thumbnail).collect();
    }
}

impl Thumbnail {
    fn show(&self, ui: &mut Ui) {
        ui.vertical(|ui| {
            ui.set_width(SIDE);
            ui.spacing_mut().item_spacing.y = 2.0;
            self.picture(ui, SIDE);
            // One after the other, so that no line begins with a space.
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing.x = theme::SMALL_GAP;
                for (index, level) in self.levels.iter().enumerate() {
                    let end = if index + 1 < self.levels.len() { ";" } else { "" };
                    ui.label(ui::secondary(format!("{level}{end}")));
                }
            });
        });
    }

    fn picture(&self, ui: &mut Ui, side: f32) {
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
        ui::describe(&response, &self.description);
        match &self.texture {
            Some(texture) if ui.is_rect_visible(rect) => pixels::draw_centered(ui, texture, rect),
            _ => {}
        }
        response.on_hover_text(&self.description);
    }
}
