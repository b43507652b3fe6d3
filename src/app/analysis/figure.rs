//! A figure of the report in the window: its own drawing, at the pixels that it takes up.

use std::sync::Arc;

use eframe::egui::{self, Color32, ColorImage, Pos2, Rect, RichText, Sense, TextureHandle, Vec2};

use crate::{
    app::ui::{
        describe, fault, hint, paragraph,
        pixels::{Canvas, draw_centered},
        work::Latest,
    },
    report::figures::Figure,
};

/// Widest figure, points, and widest of those made for the width of a page.
const WIDEST: [f32; 2] = [720.0, 1080.0];

/// A figure and its pixels.
pub struct FigureView {
    figure: Figure,
    drawn: Latest<u32, Arc<ColorImage>>,
    canvas: Canvas,
    /// The last picture, and how many pixels it was to be wide; that of an earlier analysis until the new one is drawn.
    shown: Option<(Option<u32>, TextureHandle)>,
}

impl FigureView {
    /// A figure that is yet to be drawn.
    pub fn new(figure: Figure) -> Self {
        Self { figure, drawn: Latest::default(), canvas: Canvas::default(), shown: None }
    }

    /// Shows the picture of an earlier figure until this one is drawn.
    pub fn replace(&mut self, earlier: Self) -> Option<Self> {
        if earlier.figure.name != self.figure.name {
            return Some(earlier);
        }
        self.canvas = earlier.canvas;
        self.shown = earlier.shown.map(|(_, texture)| (None, texture));
        None
    }

    /// Draws it with its title and caption.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        ui.add_space(6.0);
        let width = ui.available_width().min(WIDEST[usize::from(self.figure.wide)]);
        let size = Vec2::new(width, (width * self.figure.height as f32 / 800.0).ceil());
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        describe(&response, &format!("{}. {}", self.figure.title, self.figure.caption));
        if ui.is_rect_visible(rect) {
            self.draw(ui, rect);
        }
        paragraph(ui, RichText::new(&self.figure.title).strong());
        hint(ui, &self.figure.caption);
    }

    fn draw(&mut self, ui: &mut egui::Ui, rect: Rect) {
        let px = (rect.width() * ui.ctx().pixels_per_point()).floor().max(1.0) as u32;
        let figure = &self.figure;
        self.drawn.want(ui.ctx(), px, || {
            let figure = figure.clone();
            move || {
                let pixels = figure.pixels(px).map_err(|error| error.to_string())?;
                let size = [pixels.width as usize, pixels.height as usize];
                Ok(Arc::new(ColorImage::from_rgb(size, &pixels.rgb)))
            }
        });
        match self.drawn.get(&px) {
            Some(Ok(image)) if self.shown.as_ref().is_none_or(|(width, _)| *width != Some(px)) => {
                let texture = self.canvas.put(ui.ctx(), self.figure.name, image.clone());
                self.shown = Some((Some(px), texture));
            }
            Some(Err(error)) => fault(ui, error),
            _ => {}
        }
        match &self.shown {
            Some((Some(shown), texture)) if *shown == px => draw_centered(ui, texture, rect),
            Some((_, texture)) => {
                let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
                ui.painter().image(texture.id(), rect, whole, Color32::WHITE);
            }
            None => _ = ui.painter().rect_filled(rect, 0.0, Color32::WHITE),
        }
    }
}
