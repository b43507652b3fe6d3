//! Tables of numbers.

use eframe::egui::{Grid, ScrollArea, Ui};

use super::text::quiet;

/// A striped table that scrolls sideways where it is too wide.
pub fn table<const N: usize>(ui: &mut Ui, id: &str, heads: [&str; N], rows: impl IntoIterator<Item = [String; N]>) {
    ScrollArea::horizontal().id_salt(id).show(ui, |ui| {
        Grid::new(id).striped(true).num_columns(N).spacing([18.0, 2.0]).show(ui, |ui| {
            for head in heads {
                ui.label(quiet(head));
            }
            ui.end_row();
            for row in rows {
                for cell in row {
                    ui.monospace(cell);
                }
                ui.end_row();
            }
        });
    });
}
