//! What one trial shows, and the stimuli of all conditions.

use eframe::egui::{Align2, FontId, Rect, Sense, TextureHandle, Ui, Vec2, vec2};

use crate::{
    app::ui::{
        self,
        pixels::{self, Drawn},
        theme::{self, GAP},
        work::Kept,
    },
    experiment::{
        Category, Condition, Course, Factor, Identity, Phase, Protocol,
        task::{Layout, Presentation},
    },
    light::{Bits, Quantizer, Transfer},
    report::{document::numbers::count, names},
    stimulus::Stimulus,
};

/// Largest size of the picture of a trial, and of a stimulus in it, points.
const ROOM: Vec2 = vec2(420.0, 200.0);
const SIDE: f32 = 140.0;
/// Room for the captions below the stimuli, points.
const CAPTION: f32 = 22.0;

/// Maximum number of thumbnails.
const MAX_THUMBNAILS: usize = 200;
/// Side of a thumbnail, and of one in a line, points.
const THUMBNAIL: f32 = 96.0;
const STRIP: f32 = 48.0;

#[derive(Default)]
pub struct Preview {
    /// The trial, by the revision of the form.
    trial: Kept<u64, Option<Presentation>>,
    drawn: Drawn<(Vec<Stimulus>, u32)>,
}

impl Preview {
    /// Draws the first trial of the main part. A rating is shown by its conditions alone. `when` follows the heading.
    pub fn show(&mut self, ui: &mut Ui, protocol: &Protocol, revision: u64, when: &str) {
        if protocol.task.is_default() {
            return;
        }
        let layout = protocol.task.layout();
        let [columns, rows] = if layout.intervals() > 1 { [layout.intervals(), 1] } else { layout.grid() };
        let room = vec2(ROOM.x.min(ui.available_width()), ROOM.y);
        let side = ((room.x - GAP) / columns as f32).min((room.y - CAPTION) / rows as f32) - GAP;
        let side = side.clamp(16.0, SIDE);
        let Some(trial) = self.trial.get(revision, || first_trial(protocol)) else { return };
        let px = (side * ui.ctx().pixels_per_point()).round() as u32;
        let drawn = self.drawn.get(ui.ctx(), (trial.stimuli.clone(), px), px, || trial.stimuli.clone());
        ui::section(ui, format!("One trial{when}"));
        let light = protocol.stimulus.field_light(protocol.recovery.level);
        let field = pixels::field(&Quantizer::new(&Transfer::Srgb.into(), Bits::Eight), light);
        let height = rows as f32 * (side + GAP) + GAP + CAPTION;
        let (rect, response) = ui.allocate_exact_size(vec2(room.x, height), Sense::hover());
        ui::describe(&response, "One trial");
        ui.painter().rect_filled(rect, 4.0, field);
        let textures = drawn.into_iter().flat_map(|(_, textures)| textures);
        let left = (rect.width() - columns as f32 * (side + GAP) + GAP) / 2.0;
        for (i, texture) in textures.enumerate().take(columns * rows) {
            let (column, row) = (i % columns, i / columns);
            let at = rect.min + vec2(left + column as f32 * (side + GAP), GAP + row as f32 * (side + GAP));
            pixels::draw_centered(ui, texture, Rect::from_min_size(at, Vec2::splat(side)));
            let caption = match layout {
                Layout::Intervals { duration_s, .. } => format!("{} · {} ms", i + 1, (1e3 * duration_s).round()),
                _ => continue,
            };
            // Black or white, whichever is easier to read on the field.
            let ink = if protocol.recovery.level > 0.2 { theme::MARK_DARK } else { theme::MARK };
            let at = at + vec2(side / 2.0, side + 3.0);
            ui.painter().text(at, Align2::CENTER_TOP, caption, FontId::proportional(theme::NOTE), ink);
        }
        let answers = if protocol.task.dial().is_some() {
            "Participants set a value and press Enter.".to_owned()
        } else {
            let answer = |answer: &Category| format!("{}: {}", answer.key_name(), answer.label);
            protocol.response.categories.iter().map(answer).collect::<Vec<_>>().join(" · ")
        };
        ui::hint(ui, format!("{} {answers}", protocol.response.question));
    }
}

/// Returns the first trial of the main part.
fn first_trial(protocol: &Protocol) -> Option<Presentation> {
    let course = Course::new(protocol, &Identity::new("P001", "1").ok()?, 1).ok()?;
    let trial = course.schedule().trials.iter().position(|trial| trial.phase == Phase::Main)?;
    Some(course.presentation(trial))
}

/// A stimulus and its factors, and how many conditions are shown at most.
type Design = (Stimulus, Vec<Factor>, usize);

#[derive(Default)]
pub struct Thumbnails {
    /// The number of conditions, and those that are shown.
    listed: Kept<Design, (usize, Vec<Thumbnail>)>,
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
    pub fn show(&mut self, ui: &mut Ui, protocol: &Protocol, when: &str) {
        let (n, all) = self.update(ui, protocol, THUMBNAIL, MAX_THUMBNAILS);
        ui::section(ui, count(*n as u64, "condition") + when);
        if *n > all.len() {
            ui::hint(ui, format!("{} of them are shown, from all parts of the design.", all.len()));
        }
        let gap = ui.spacing().item_spacing.x;
        let per_row = ((ui.available_width() + gap) / (THUMBNAIL + gap)).max(1.0) as usize;
        for row in all.chunks(per_row) {
            ui.horizontal_top(|ui| row.iter().for_each(|thumbnail| thumbnail.show(ui)));
        }
    }

    /// Draws one line of stimuli, from all parts of the design.
    pub fn strip(&mut self, ui: &mut Ui, protocol: &Protocol) {
        let shown = ((ui.available_width() + GAP) / (STRIP + GAP)).max(1.0) as usize;
        let (_, all) = self.update(ui, protocol, STRIP, shown);
        ui.horizontal(|ui| all.iter().for_each(|thumbnail| thumbnail.picture(ui, STRIP)));
    }

    /// Lists up to `most` conditions, from all parts of the design, and draws their pictures with this side, points. Until
    /// they are ready, those of the same stimuli stay.
    fn update(&mut self, ui: &Ui, protocol: &Protocol, side: f32, most: usize) -> &(usize, Vec<Thumbnail>) {
        let key = (protocol.stimulus.clone(), protocol.factors.clone(), most);
        let listed = self.listed.get(key, || thumbnails(protocol, most));
        let px = (side * ui.ctx().pixels_per_point()).round() as u32;
        let stimuli: Vec<Stimulus> = listed.1.iter().map(|thumbnail| thumbnail.stimulus.clone()).collect();
        let drawn = self.drawn.get(ui.ctx(), (stimuli.clone(), px), px, || stimuli);
        let drawn = drawn.into_iter().flat_map(|((stimuli, _), textures)| stimuli.iter().zip(textures));
        listed.1.iter_mut().for_each(|thumbnail| thumbnail.texture = None);
        for (thumbnail, (stimulus, texture)) in listed.1.iter_mut().zip(drawn) {
            thumbnail.texture = Some(texture.clone()).filter(|_| thumbnail.stimulus == *stimulus);
        }
        listed
    }
}

/// Returns the number of conditions, and up to `most` of them.
fn thumbnails(protocol: &Protocol, most: usize) -> (usize, Vec<Thumbnail>) {
    let conditions = protocol.conditions();
    let known = Some(protocol.stimulus.parameters());
    let names: Vec<String> = protocol.factors.iter().map(|factor| names::factor(known, &factor.name)).collect();
    let thumbnail = |condition: &Condition| {
        let level = |(factor, index): (&Factor, &usize)| {
            names::level(known, &factor.name, &factor.levels[*index].to_string()).to_string()
        };
        let levels: Vec<String> = protocol.factors.iter().zip(&condition.levels).map(level).collect();
        let described: Vec<String> = names.iter().zip(&levels).map(|(name, level)| format!("{name} {level}")).collect();
        Thumbnail { texture: None, description: described.join("; "), levels, stimulus: condition.stimulus.clone() }
    };
    let step = conditions.len().div_ceil(most).max(1);
    (conditions.len(), conditions.iter().step_by(step).map(thumbnail).collect())
}

impl Thumbnail {
    fn show(&self, ui: &mut Ui) {
        ui.vertical(|ui| {
            ui.set_width(THUMBNAIL);
            ui.spacing_mut().item_spacing.y = 2.0;
            self.picture(ui, THUMBNAIL);
            ui::hint(ui, self.levels.join("; "));
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
