//! The tables that the files have, to be looked at.

use eframe::egui::{self, ScrollArea};

use super::{grid::Grid, look};
use crate::{
    analysis::Results,
    report::tables::{self, Table},
};

/// All tables, rounded for reading, and which one is looked at.
pub struct Tables {
    tables: Vec<Entry>,
}

struct Entry {
    name: String,
    title: String,
    /// As it goes to the clipboard.
    table: Table,
    grid: Grid,
}

impl Tables {
    /// The tables of an analysis.
    pub fn new(results: &Results) -> Self {
        let factors = results.measured.counts.factors.len();
        let mut all = Self { tables: Vec::new() };
        all.add("Cells", "Every cell of the design", tables::cells(results), factors);
        for factor in &results.factors {
            let title = format!("By {}, over everything else", factor.name);
            all.add(&factor.name, &title, tables::by_factor(results, factor), 1);
        }
        all.add("Participants", "By participant", tables::subjects(results), 1);
        if let Some(table) = tables::predictions(results) {
            all.add("Predictions", "What the model expects of a participant in the middle", table, factors);
        }
        all
    }

    fn add(&mut self, name: &str, title: &str, table: Table, names: usize) {
        let grid = Grid::rounded(&table, names);
        self.tables.push(Entry { name: name.to_owned(), title: title.to_owned(), table, grid });
    }

    /// Draws the choice and the chosen table.
    pub fn show(&mut self, ui: &mut egui::Ui, chosen: &mut usize, narrow: bool) {
        let names: Vec<&str> = self.tables.iter().map(|entry| entry.name.as_str()).collect();
        look::choice(ui, "Table", chosen, &names, narrow);
        let Some(entry) = self.tables.get_mut(*chosen) else { return };
        ui.horizontal_wrapped(|ui| {
            look::heading(ui, &entry.title);
            let copy = ui.button("Copy");
            look::named(ui, &copy, "Copy the table as CSV");
            if copy.on_hover_text("The whole table as CSV, with all digits.").clicked() {
                ui.ctx().copy_text(String::from_utf8_lossy(&entry.table.csv()).into_owned());
            }
        });
        ScrollArea::vertical().id_salt("tables").auto_shrink(false).show(ui, |ui| entry.grid.show(ui, &entry.name));
    }
}
