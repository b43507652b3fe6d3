//! Shows the document in the window.

use eframe::egui::{self, Align, Layout, RichText, ScrollArea};

use super::{opened::SUMMARY, table::TableView};
use crate::{
    app::ui::{figure::FigureView, hint, paged, paragraph, section, theme, tick},
    report::document::{Block, Document, Section},
};

/// In a view wider than this, points, figures are in two columns.
const TWO_COLUMNS: f32 = 780.0;

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
    /// Creates a view of a document that has not been drawn yet.
    pub fn new(document: Document) -> Self {
        let block = |block| match block {
            Block::Table(table) => BlockView::Table(TableView::new(table)),
            Block::Figure(figure) => BlockView::Figure(Box::new(FigureView::new(figure))),
            text => BlockView::Text(text),
        };
        let section = |Section { id, heading, blocks }: Section| SectionView {
            id,
            heading,
            blocks: blocks.into_iter().map(block).collect(),
        };
        Self { sections: document.sections.into_iter().map(section).collect() }
    }

    /// Sorts the tables as those of an earlier view, and shows its images until the new ones are ready.
    pub fn after(mut self, earlier: &Self) -> Self {
        for block in self.sections.iter_mut().flat_map(|section| &mut section.blocks) {
            for earlier in earlier.sections.iter().flat_map(|section| &section.blocks) {
                match (&mut *block, earlier) {
                    (BlockView::Table(table), BlockView::Table(earlier)) => table.sort_like(earlier),
                    (BlockView::Figure(figure), BlockView::Figure(earlier)) => figure.follow(earlier),
                    _ => {}
                }
            }
        }
        self
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
        let is_figure = |block: &BlockView| matches!(block, BlockView::Figure(_));
        let drawn = self.sections.iter().position(|section| section.blocks.iter().any(is_figure));
        let Some(summary) = self.sections.iter().position(|section| section.id == SUMMARY) else { return false };
        scrolled(ui, SUMMARY, |ui| {
            // The warnings hold for all sections.
            let is_warning = |block: &BlockView| matches!(block, BlockView::Text(Block::Warning(_)));
            show_blocks(ui, self.sections[summary].blocks.iter_mut().filter(|block| is_warning(block)));
            let figures = drawn.map(|index| &mut self.sections[index].blocks);
            let key = figures.into_iter().flatten().filter(|block| is_figure(block));
            let many = if ui.available_width() >= TWO_COLUMNS { 2 } else { 1 };
            show_blocks(ui, key.take(many));
            if is_draft {
                return hint(
                    ui,
                    "There are no tests of these data yet. What needs no model, such as Description, is final.",
                );
            }
            show_blocks(ui, self.sections[summary].blocks.iter_mut().filter(|block| !is_warning(block)));
        });
        true
    }
}

/// Draws what can be scrolled. It has the same width whether or not it is long enough for a scroll bar.
fn scrolled(ui: &mut egui::Ui, id: &str, add: impl FnOnce(&mut egui::Ui)) {
    let width = ui.available_width() - ui.spacing().scroll.allocated_width();
    ScrollArea::vertical().id_salt(id).auto_shrink(false).show(ui, |ui| {
        ui.set_max_width(width);
        paged(ui, add);
    });
}

/// Draws blocks. Two figures that follow each other are side by side if there is room.
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
        match blocks.next_if(|next| two && matches!(&next.1, BlockView::Figure(_))) {
            Some((_, BlockView::Figure(right))) => ui.columns(2, |columns| {
                for (column, figure) in columns.iter_mut().zip([left, right]) {
                    // Columns would stretch the spaces of captions.
                    column.with_layout(Layout::top_down(Align::Min), |ui| figure.show(ui));
                }
            }),
            // It is as wide as one of two.
            _ => {
                ui.scope(|ui| {
                    let one = (ui.available_width() - ui.spacing().item_spacing.x) / 2.0;
                    ui.set_max_width(if two { one } else { ui.available_width() });
                    left.show(ui);
                });
            }
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
            Block::Code(text) => paragraph(ui, RichText::new(text).monospace()),
            Block::Table(_) | Block::Figure(_) => {}
        }
    });
}
