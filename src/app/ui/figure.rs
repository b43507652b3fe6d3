//! Shows a figure of the report, drawn at the size in pixels that it occupies.

use std::sync::Arc;

use eframe::egui::{self, ColorImage, Popup, PopupCloseBehavior, Rect, RichText, Sense, TextureHandle, Vec2};

use super::{
    fields::Field,
    pixels::{draw_centered, load, paint},
    saving::Saving,
    text::{describe, hint, name, paragraph, show_error},
    theme,
    work::Latest,
};
use crate::report::{
    figures::{Figure, Plotted, palette},
    png,
};

/// Width of the controls that save a figure, points.
const SAVING: f32 = 440.0;
/// How far from its marker a value is told, in units of a figure, which is 800 wide.
const NEAR: f32 = 8.0;
/// Maximum width in points.
const MAX_WIDTH: f32 = 720.0;

/// A figure and its pixels.
pub struct FigureView {
    figure: Figure,
    /// By the width in pixels, and whether the theme is dark.
    drawn: Latest<(u32, bool), Arc<ColorImage>>,
    /// The last image and its requested width in pixels; the image of the previous analysis until the new one is drawn.
    shown: Option<(Option<(u32, bool)>, TextureHandle)>,
    saving: Saving,
}

impl FigureView {
    /// Creates a figure that has not been drawn yet.
    pub fn new(figure: Figure) -> Self {
        let saving = Saving::to(format!("{}.svg", figure.name));
        Self { figure, drawn: Latest::default(), shown: None, saving }
    }

    /// Shows the image of an earlier figure until this one is drawn, if that is the same of other data.
    pub fn follow(&mut self, earlier: &Self) {
        if self.figure.name == earlier.figure.name {
            self.saving = earlier.saving.clone();
            self.shown = earlier.shown.clone().map(|(_, texture)| (None, texture)).or(self.shown.take());
        }
    }

    /// Draws the figure with its title and caption.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        ui.add_space(6.0);
        let width = ui.available_width().min(MAX_WIDTH);
        let size = Vec2::new(width, (width * self.figure.height as f32 / 800.0).ceil());
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        describe(&response, &format!("{}. {}", self.figure.title, self.figure.caption));
        if ui.is_rect_visible(rect) {
            self.draw(ui, rect);
        }
        if let Some(text) = response.hover_pos().and_then(|at| self.value_at((at - rect.min) * 800.0 / width)) {
            response.on_hover_text_at_pointer(text);
        }
        ui.horizontal_wrapped(|ui| {
            paragraph(ui, RichText::new(&self.figure.title).strong());
            let save = ui.small_button("Save…");
            name(ui, &save, &format!("Save the figure: {}", self.figure.title));
            let save = save.on_hover_text("Saves this figure alone, as SVG or PNG.");
            let popup = Popup::from_toggle_button_response(&save).width(SAVING);
            popup.close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| self.save(ui));
        });
        hint(ui, &self.figure.caption);
    }

    /// Returns the value nearest to a place in the figure, if one is there.
    fn value_at(&self, at: Vec2) -> Option<&str> {
        let distances = self.figure.values.iter().filter_map(|Plotted { center, half, text }| {
            let away = (at - Vec2::new(center.0 as f32, center.1 as f32)).abs();
            let near = Vec2::new(half.0 as f32, half.1 as f32) + Vec2::splat(NEAR);
            (away.x <= near.x && away.y <= near.y).then(|| (away.length(), text.as_str()))
        });
        distances.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, text)| text)
    }

    /// Draws the controls that save the figure. Its ending chooses the format.
    fn save(&mut self, ui: &mut egui::Ui) {
        let Self { saving, figure, .. } = self;
        ui.horizontal_wrapped(|ui| {
            let field = saving.field(ui, Field::new("Save the figure as").width(240.0));
            field.on_hover_text("End the name in .svg or .png, which chooses the format.");
            saving.export(ui, "Save", &["svg", "png"], |writer, path, ending| match ending {
                "svg" => writer.write(path, figure.svg.as_bytes()),
                _ => writer.write(path, &png(figure, path)?),
            });
        });
        saving.show(ui);
    }

    fn draw(&mut self, ui: &mut egui::Ui, rect: Rect) {
        let px = (rect.width() * ui.ctx().pixels_per_point()).floor().max(1.0) as u32;
        let dark = ui.visuals().dark_mode;
        let (figure, key) = (&self.figure, (px, dark));
        self.drawn.want(ui.ctx(), key, || {
            let mut figure = figure.clone();
            move || {
                let drawn = if dark { palette::on_dark } else { palette::on_light };
                figure.svg = drawn(&figure.svg);
                let pixels = figure.pixels(px).map_err(|error| error.to_string())?;
                let size = [pixels.width as usize, pixels.height as usize];
                Ok(Arc::new(ColorImage::from_rgb(size, &pixels.rgb)))
            }
        });
        match self.drawn.get(&key) {
            Some(Ok(image)) if self.shown.as_ref().is_none_or(|(made, _)| *made != Some(key)) => {
                let texture = load(ui.ctx(), self.figure.name, image.clone());
                self.shown = Some((Some(key), texture));
            }
            Some(Err(error)) => show_error(ui, error),
            _ => {}
        }
        match &self.shown {
            Some((Some(shown), texture)) if *shown == key => draw_centered(ui, texture, rect),
            Some((_, texture)) => paint(ui.painter(), texture.id(), rect),
            None => _ = ui.painter().rect_filled(rect, 0.0, theme::ink(ui).card),
        }
    }
}
