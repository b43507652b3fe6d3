//! The experiments to choose from: a card for each, with a picture of its stimulus.

use std::path::Path;

use eframe::egui::{
    self, Align2, Color32, Rect, ScrollArea, Sense, Stroke, TextStyle, TextureHandle, Ui, Vec2, text::LayoutJob,
};

use crate::{
    app::ui::{
        pixels,
        theme::{GAP, ink},
        work::Latest,
    },
    experiment::Protocol,
    light::{Bits, CodeImage, Quantizer, Transfer},
    store::definition::{self, BUILT_IN},
};

/// Minimum width and the height of a card, points; the height in a small window.
const SIZE: Vec2 = Vec2::new(220.0, 82.0);
const SMALL_HEIGHT: f32 = 44.0;
/// Distance from the edge of a card to its content, points.
const PADDING: f32 = 8.0;

/// The cards, in the order in which they are shown.
#[derive(Default)]
pub struct Cards {
    /// The files that have a card, before the built-in definitions.
    files: Vec<String>,
    cards: Vec<Card>,
}

struct Card {
    /// Name of a built-in definition, or path of a file.
    experiment: String,
    /// The definition, or the first error in it.
    protocol: Result<Protocol, String>,
    picture: Latest<u32, CodeImage>,
    texture: Option<(u32, TextureHandle)>,
}

impl Cards {
    /// Reads the definitions if these are not the files that have a card.
    pub fn update(&mut self, files: &[String]) {
        if self.files != files || self.cards.is_empty() {
            self.read(files);
        }
    }

    /// Reads the built-in definitions and these files again, because they may have changed. Pictures of definitions
    /// that have not changed stay.
    pub fn read(&mut self, files: &[String]) {
        let mut before = std::mem::take(&mut self.cards);
        self.files = files.to_vec();
        let names = files.iter().map(String::as_str).chain(BUILT_IN.iter().map(|built_in| built_in.name));
        for experiment in names {
            let protocol = definition::open(experiment).map_err(|errors| errors.to_string());
            let known = before.iter().position(|card| card.experiment == experiment && card.protocol == protocol);
            self.cards.push(match known {
                Some(index) => before.swap_remove(index),
                None => Card { experiment: experiment.to_owned(), protocol, picture: Latest::default(), texture: None },
            });
        }
    }

    /// Draws the cards in as many columns as fit; returns the experiment that was clicked.
    pub fn show(&mut self, ui: &mut Ui, chosen: &str, small: bool) -> Option<String> {
        let mut clicked = None;
        ScrollArea::vertical().id_salt("cards").auto_shrink([false, true]).show(ui, |ui| {
            ui.spacing_mut().item_spacing = Vec2::splat(GAP);
            let columns = ((ui.available_width() + GAP) / (SIZE.x + GAP)).floor().max(1.0);
            let width = ((ui.available_width() + GAP) / columns - GAP).floor();
            let size = Vec2::new(width, if small { SMALL_HEIGHT } else { SIZE.y });
            for row in self.cards.chunks_mut(columns as usize) {
                ui.horizontal(|ui| {
                    for card in row {
                        if card.show(ui, size, card.experiment == chosen, small) {
                            clicked = Some(card.experiment.clone());
                        }
                    }
                });
            }
        });
        clicked
    }
}

impl Card {
    /// Returns the title and one line about the experiment.
    fn texts(&self) -> (String, String) {
        let built_in = BUILT_IN.iter().any(|built_in| built_in.name == self.experiment);
        let name = Path::new(&self.experiment).file_name().unwrap_or_default().to_string_lossy().into_owned();
        match &self.protocol {
            Ok(protocol) => {
                let trials = protocol.main_trials() + protocol.design.practice as usize;
                let origin = if built_in { String::new() } else { format!(" · {name}") };
                (protocol.title.clone(), format!("{trials} trials, {} min{origin}", protocol.minutes()))
            }
            Err(error) => (name, error.lines().next().unwrap_or_default().to_owned()),
        }
    }

    fn show(&mut self, ui: &mut Ui, size: Vec2, chosen: bool, small: bool) -> bool {
        let (title, line) = self.texts();
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let label = format!("{title}: {line}");
        response.widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, chosen, &label));
        if ui.is_rect_visible(rect) {
            let ink = ink(ui);
            let focus = response.has_focus();
            let stroke = match (focus, chosen, response.hovered()) {
                (true, ..) => ui.visuals().widgets.active.bg_stroke,
                (_, true, _) => ui.visuals().selection.stroke,
                (_, _, true) => ui.visuals().widgets.hovered.bg_stroke,
                _ => Stroke::new(1.0, ink.outline),
            };
            let fill = if chosen { ui.visuals().selection.bg_fill.gamma_multiply(0.6) } else { ink.card };
            ui.painter().rect(rect, 8.0, fill, stroke, egui::StrokeKind::Inside);
            let side = size.y - 2.0 * PADDING;
            let picture = Rect::from_min_size(rect.min + Vec2::splat(PADDING), Vec2::splat(side));
            self.draw_picture(ui, picture);
            let left = picture.right() + PADDING;
            let room = Rect::from_min_max(egui::pos2(left, rect.top() + PADDING), rect.max - Vec2::splat(PADDING));
            let color = if self.protocol.is_err() { ink.error } else { ink.secondary };
            let rows = if small { 1 } else { 2 };
            text(ui, room, &title, (TextStyle::Button, ink.text), rows, Align2::LEFT_TOP);
            text(ui, room, &line, (TextStyle::Small, color), 1, Align2::LEFT_BOTTOM);
        }
        response.on_hover_text(format!("{title}\n{}\n{line}", self.experiment)).clicked()
    }

    fn draw_picture(&mut self, ui: &Ui, rect: Rect) {
        let Ok(protocol) = &self.protocol else { return };
        let px = (rect.width() * ui.ctx().pixels_per_point()).floor().max(1.0) as u32;
        self.picture.want(ui.ctx(), px, || {
            let protocol = protocol.clone();
            move || {
                let conditions = protocol.conditions();
                let middle = conditions.get(conditions.len() / 2).map_or(&protocol.stimulus, |middle| &middle.stimulus);
                Ok(middle.codes(px, &Quantizer::new(&Transfer::Srgb, Bits::Eight)))
            }
        });
        if let Some(Ok(image)) = self.picture.get(&px)
            && self.texture.as_ref().is_none_or(|(made, _)| *made != px)
        {
            self.texture = Some((px, pixels::texture_of(ui.ctx(), "card", image)));
        }
        if let Some((_, texture)) = &self.texture {
            pixels::draw_centered(ui, texture, rect);
        }
    }
}

/// Draws text in a corner of a rectangle, cut off with dots after `rows` rows.
fn text(ui: &Ui, rect: Rect, text: &str, style: (TextStyle, Color32), rows: usize, align: Align2) {
    let (font, color) = (style.0.resolve(ui.style()), style.1);
    let mut job = LayoutJob::simple(text.to_owned(), font, color, rect.width());
    job.wrap.max_rows = rows;
    let galley = ui.painter().layout_job(job);
    let at = align.align_size_within_rect(galley.size(), rect).min;
    ui.painter().galley(at, galley, color);
}
