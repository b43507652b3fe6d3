//! Shows the document in the window. Each figure of the report is drawn at the size in pixels that it occupies.

use std::{path::PathBuf, sync::Arc};

use eframe::egui::{
    self, Align, Color32, ColorImage, Label, Layout, Popup, PopupCloseBehavior, Pos2, Rect, RichText, ScrollArea,
    Sense, TextureHandle, Vec2,
};

use super::table::TableView;
use crate::{
    app::ui::{
        Field, Saving, describe, hint, paragraph,
        pixels::{Canvas, draw_centered},
        section, show_error,
        text::name,
        theme, tick,
        work::Latest,
    },
    report::{
        document::{Block, Document, Section},
        figures::{Figure, Plotted, palette},
        png,
    },
};

/// Address of the section that says what was found.
const SUMMARY: &str = "summary";
/// In a view wider than this, points, figures are in two columns.
const TWO_COLUMNS: f32 = 880.0;
/// Width of the controls that save a figure, points.
const SAVING: f32 = 440.0;
/// How far from its marker a value is told, in units of a figure, which is 800 wide.
const NEAR: f32 = 8.0;
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
    /// Creates a view of a document that has not been drawn yet. The images of `earlier` ones, of which the last is the
    /// newest, stay until the new ones are ready.
    pub fn new(document: Document, earlier: impl IntoIterator<Item = Self>) -> Self {
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
        if id == SUMMARY {
            return self.summary(ui, false);
        }
        let Some(section) = self.sections.iter_mut().find(|section| section.id == id) else { return false };
        scrolled(ui, id, |ui| show_blocks(ui, &mut section.blocks));
        true
    }

    /// Draws the summary; returns whether there is one. It begins with the figures that show the result. `is_draft`: no
    /// model is fitted yet, so that there are only these figures.
    pub fn summary(&mut self, ui: &mut egui::Ui, is_draft: bool) -> bool {
        let place = |id: &str| self.sections.iter().position(|section| section.id == id);
        let is_figure = |block: &BlockView| matches!(block, BlockView::Figure(_));
        let first = || self.sections.iter().position(|section| section.blocks.iter().any(is_figure));
        let (Some(summary), description) = (place(SUMMARY), place("description").or_else(first)) else { return false };
        scrolled(ui, SUMMARY, |ui| {
            self.show_warnings(ui);
            let figures = description.map(|index| &mut self.sections[index].blocks);
            let key = figures.into_iter().flatten().filter(|block| is_figure(block));
            let many = if ui.available_width() >= TWO_COLUMNS { 2 } else { 1 };
            show_blocks(ui, key.take(many));
            if is_draft {
                return hint(ui, "The tests are being computed. What needs no model, such as Description, is final.");
            }
            let is_rest = |block: &&mut BlockView| !matches!(block, BlockView::Text(Block::Warning(_)));
            show_blocks(ui, self.sections[summary].blocks.iter_mut().filter(is_rest));
        });
        true
    }

    /// Draws the warnings of the summary, which hold for all sections.
    fn show_warnings(&self, ui: &mut egui::Ui) {
        let blocks = self.sections.iter().filter(|section| section.id == SUMMARY).flat_map(|section| &section.blocks);
        for block in blocks {
            if let BlockView::Text(warning @ Block::Warning(_)) = block {
                show_text(ui, warning);
            }
        }
    }
}

/// Draws what can be scrolled. It has the same width whether or not it is long enough for a scroll bar.
fn scrolled(ui: &mut egui::Ui, id: &str, add: impl FnOnce(&mut egui::Ui)) {
    let width = ui.available_width() - ui.spacing().scroll.allocated_width();
    ScrollArea::vertical().id_salt(id).auto_shrink(false).show(ui, |ui| {
        ui.set_max_width(width);
        add(ui);
    });
}

/// Draws blocks. Two ordinary figures that follow each other are side by side if there is room.
fn show_blocks<'a>(ui: &mut egui::Ui, blocks: impl IntoIterator<Item = &'a mut BlockView>) {
    let two = ui.available_width() >= TWO_COLUMNS;
    let mut blocks = blocks.into_iter().enumerate().peekable();
    while let Some((index, block)) = blocks.next() {
        let left = match block {
            BlockView::Text(block) => {
                show_text(ui, block);
                continue;
            }
            BlockView::Table(table) => {
                table.show(ui, index);
                continue;
            }
            BlockView::Figure(left) => left,
        };
        let fits = |next: &(usize, &mut BlockView)| matches!(&next.1, BlockView::Figure(right) if !right.figure.wide);
        let beside = two && !left.figure.wide;
        match blocks.next_if(|next| beside && fits(next)) {
            Some((_, BlockView::Figure(right))) => ui.columns(2, |columns| {
                for (column, figure) in columns.iter_mut().zip([left, right]) {
                    // Columns would stretch the spaces of captions.
                    column.with_layout(Layout::top_down(Align::Min), |ui| figure.show(ui));
                }
            }),
            _ => left.show(ui),
        }
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
    /// By the width in pixels, and whether the theme is dark.
    drawn: Latest<(u32, bool), Arc<ColorImage>>,
    canvas: Canvas,
    /// The last image and its requested width in pixels; the image of the previous analysis until the new one is drawn.
    shown: Option<(Option<(u32, bool)>, TextureHandle)>,
    /// The path to save it to, and the outcome.
    saving: (String, Saving),
}

impl FigureView {
    /// Creates a figure that has not been drawn yet.
    fn new(figure: Figure) -> Self {
        let saving = (format!("{}.svg", figure.name), Saving::default());
        Self { figure, drawn: Latest::default(), canvas: Canvas::default(), shown: None, saving }
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
        if let Some(text) = response.hover_pos().and_then(|at| self.value_at((at - rect.min) * 800.0 / width)) {
            response.on_hover_text_at_pointer(text);
        }
        ui.horizontal_wrapped(|ui| {
            ui.add(Label::new(RichText::new(&self.figure.title).strong()).wrap());
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
        let (typed, saving) = &mut self.saving;
        ui.horizontal_wrapped(|ui| {
            let field = Field::new("Save the figure as").width(240.0).text(ui, typed);
            if field.on_hover_text("End the name in .svg or .png, which chooses the format.").changed() {
                *saving = Saving::default();
            }
            let path = PathBuf::from(typed.trim());
            saving.export(ui, "Save", &path, &["svg", "png"], |writer, ending| match ending {
                "svg" => writer.write(&path, self.figure.svg.as_bytes()),
                _ => writer.write(&path, &png(&self.figure, &path)?),
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
                if dark {
                    figure.svg = palette::on_dark(&figure.svg);
                }
                let pixels = figure.pixels(px).map_err(|error| error.to_string())?;
                let size = [pixels.width as usize, pixels.height as usize];
                Ok(Arc::new(ColorImage::from_rgb(size, &pixels.rgb)))
            }
        });
        match self.drawn.get(&key) {
            Some(Ok(image)) if self.shown.as_ref().is_none_or(|(made, _)| *made != Some(key)) => {
                let texture = self.canvas.put(ui.ctx(), self.figure.name, image.clone());
                self.shown = Some((Some(key), texture));
            }
            Some(Err(error)) => show_error(ui, error),
            _ => {}
        }
        match &self.shown {
            Some((Some(shown), texture)) if *shown == key => draw_centered(ui, texture, rect),
            Some((_, texture)) => {
                let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
                ui.painter().image(texture.id(), rect, whole, Color32::WHITE);
            }
            None => _ = ui.painter().rect_filled(rect, 0.0, theme::ink(ui).card),
        }
    }
}
