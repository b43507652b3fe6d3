//! The document's skin in the window.

use eframe::egui::{self, Label, RichText, ScrollArea};

use super::{figure::FigureView, table::TableView};
use crate::{
    app::ui::{hint, paragraph, section, theme, tick},
    report::document::{Block, Document, Section},
};

/// A document and what its tables and figures remember.
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
    /// A document that is yet to be drawn. The pictures of an earlier one stay until the new ones are there.
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

    /// Address and heading of every section.
    pub fn headings(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        self.sections.iter().map(|section| (section.id, section.heading))
    }

    /// Draws the section at an address; whether there is one.
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
                    paragraph(ui, RichText::new(text).color(theme::NOTE));
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
