//! Shows the document in the window. Each figure of the report is drawn at the size in pixels that it occupies.

use std::{path::PathBuf, sync::Arc};

use eframe::egui::{self, Color32, ColorImage, Label, Pos2, Rect, RichText, ScrollArea, Sense, TextureHandle, Vec2};

use super::table::TableView;
use crate::{
    app::ui::{
        Field, Saving, describe, ending, hint, paragraph,
        pixels::{Canvas, draw_centered},
        saved, section, show_error,
        text::name,
        theme, tick,
        work::Latest,
    },
    report::{
        document::{Block, Document, Section},
        figures::Figure,
        png,
    },
};

/// Maximum width in points of an ordinary figure, and of a figure made for the full width of a page.
const MAX_WIDTHS: [f32; 2] = [720.0, 1080.0];

/// A document and the state of its tables and figures.
pub struct DocumentView {
    sections: Vec<SectionView>,
}

struct SectionView {
    id: &'static str,
    heading: &'static str,
    blocks: Vec<BlockView>,
}

enum BlockView {
    Text(Block),
    Table(TableView),
    Figure(Box<FigureView>),
}

impl DocumentView {
    /// Creates a view of a document that has not been drawn yet. The images of `earlier` stay until the new ones are
    /// ready.
    pub fn new(document: Document, earlier: Option<Self>) -> Self {
        let mut pictures: Vec<FigureView> = (earlier.into_iter())
            .flat_map(|view| view.sections)
            .flat_map(|section| section.blocks)
            .filter_map(|block| if let BlockView::Figure(figure) = block { Some(*figure) } else { None })
            .collect();
        let mut block = |block| match block {
            Block::Table(table) => BlockView::Table(TableView::new(table)),
            Block::Figure(figure) => {
                let mut view = FigureView::new(figure);
                pictures = pictures.drain(..).filter_map(|earlier| view.replace(earlier)).collect();
                BlockView::Figure(Box::new(view))
            }
            text => BlockView::Text(text),
        };
        let section = |Section { id, heading, blocks }: Section| SectionView {
            id,
            heading,
            blocks: blocks.into_iter().map(&mut block).collect(),
        };
        Self { sections: document.sections.into_iter().map(section).collect() }
    }

    /// Returns the address (`id`) and the heading of every section.
    pub fn headings(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        self.sections.iter().map(|section| (section.id, section.heading))
    }

    /// Draws the section at an address; returns whether it exists.
    pub fn show(&mut self, ui: &mut egui::Ui, id: &str) -> bool {
        let Some(section) = self.sections.iter_mut().find(|section| section.id == id) else { return false };
        ScrollArea::vertical().id_salt(id).auto_shrink(false).show(ui, |ui| {
            for (index, block) in section.blocks.iter_mut().enumerate() {
                match block {
                    BlockView::Text(block) => show_text(ui, block),
                    BlockView::Table(table) => table.show(ui, index),
                    BlockView::Figure(figure) => figure.show(ui),
                }
            }
        });
        true
    }
}

fn show_text(ui: &mut egui::Ui, block: &Block) {
    // Long lines are hard to read.
    ui.scope(|ui| {
        ui.set_max_width(ui.available_width().min(theme::COLUMN));
        match block {
            Block::Heading(text) => section(ui, text),
            Block::Text(text) => paragraph(ui, text),
            Block::Note(text) => hint(ui, text),
            Block::Warning(text) => {
                ui.horizontal_top(|ui| {
                    tick(ui, false);
                    paragraph(ui, RichText::new(text).color(theme::ink(ui).warn));
                });
            }
            Block::List(items) => {
                for item in items {
                    ui.horizontal_top(|ui| {
                        ui.label("•");
                        paragraph(ui, item);
                    });
                }
            }
            Block::Code(text) => {
                ui.add(Label::new(RichText::new(text).monospace()).wrap());
            }
            Block::Table(_) | Block::Figure(_) => {}
        }
    });
}

/// A figure and its pixels.
struct FigureView {
    figure: Figure,
    drawn: Latest<u32, Arc<ColorImage>>,
    canvas: Canvas,
    /// The last image and its requested width in pixels; the image of the previous analysis until the new one is drawn.
    shown: Option<(Option<u32>, TextureHandle)>,
    /// The path to save it to, while the user enters one, and the outcome.
    saving: Option<(String, Saving)>,
}

impl FigureView {
    /// Creates a figure that has not been drawn yet.
    fn new(figure: Figure) -> Self {
        Self { figure, drawn: Latest::default(), canvas: Canvas::default(), shown: None, saving: None }
    }

    /// Shows the image of the previous figure until this one is drawn.
    fn replace(&mut self, earlier: Self) -> Option<Self> {
        if earlier.figure.name != self.figure.name {
            return Some(earlier);
        }
        self.canvas = earlier.canvas;
        self.saving = earlier.saving;
        self.shown = earlier.shown.map(|(_, texture)| (None, texture));
        None
    }

    /// Draws the figure with its title and caption.
    fn show(&mut self, ui: &mut egui::Ui) {
        ui.add_space(6.0);
        let width = ui.available_width().min(MAX_WIDTHS[usize::from(self.figure.wide)]);
        let size = Vec2::new(width, (width * self.figure.height as f32 / 800.0).ceil());
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        describe(&response, &format!("{}. {}", self.figure.title, self.figure.caption));
        if ui.is_rect_visible(rect) {
            self.draw(ui, rect);
        }
        ui.horizontal_wrapped(|ui| {
            ui.add(Label::new(RichText::new(&self.figure.title).strong()).wrap());
            let save = ui.small_button("Save…");
            name(ui, &save, &format!("Save the figure: {}", self.figure.title));
            if save.on_hover_text("Saves this figure alone, as SVG or PNG.").clicked() {
                let path = format!("{}.svg", self.figure.name);
                self.saving = if self.saving.is_some() { None } else { Some((path, Saving::default())) };
            }
        });
        self.save(ui);
        hint(ui, &self.figure.caption);
    }

    /// Draws the controls that save the figure. Its ending chooses the format.
    fn save(&mut self, ui: &mut egui::Ui) {
        let Some((typed, saving)) = &mut self.saving else { return };
        ui.horizontal_wrapped(|ui| {
            let field = Field::new("Save the figure as").width(240.0).text(ui, typed);
            if field.on_hover_text("End the name in .svg or .png, which chooses the format.").changed() {
                *saving = Saving::default();
            }
            let path = PathBuf::from(typed.trim());
            if let Some(writer) = saving.button(ui, "Save", true, &path, &[]) {
                let written = ending(&path, &["svg", "png"]).and_then(|ending| match ending {
                    "svg" => writer.write(&path, self.figure.svg.as_bytes()),
                    _ => writer.write(&path, &png(&self.figure, &path)?),
                });
                saving.finish(&path, written.map(|()| saved(&path)));
            }
        });
        saving.show(ui);
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
            Some(Err(error)) => show_error(ui, error),
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
