//! A table on the page: numbers to the right, only the rows that are seen.

use eframe::egui::{self, Align, Layout, Rect, RichText, ScrollArea, Sense, TextStyle, UiBuilder, Vec2};

use super::words;
use crate::{app::theme, report::tables::Table};

/// Room within a column, points.
const PADDING: f32 = 16.0;
/// Rows that are measured for the columns' widths; of more, only the longest texts.
const MEASURED: usize = 2000;

/// A table to be looked at.
pub struct Grid {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    numeric: Vec<bool>,
    /// Measured when it is first drawn.
    widths: Vec<f32>,
}

impl Grid {
    /// A table whose cells are as they are to be read.
    pub fn new(header: &[&str], rows: Vec<Vec<String>>) -> Self {
        Self::of(header.iter().map(|name| (*name).to_owned()).collect(), rows)
    }

    /// A table of the files, its numbers rounded to three decimals but for the first columns, which are names.
    pub fn rounded(table: &Table, names: usize) -> Self {
        let columns = 0..table.header.len();
        let decimals: Vec<Option<usize>> = columns.map(|c| decimals(&table.rows, c).filter(|_| c >= names)).collect();
        let cell = |(text, decimals): (&String, &Option<usize>)| match (text.parse::<f64>(), decimals) {
            (Ok(number), Some(decimals)) => words::fixed(number, *decimals),
            _ => text.clone(),
        };
        let rows = table.rows.iter().map(|row| row.iter().zip(&decimals).map(cell).collect()).collect();
        Self::of(table.header.clone(), rows)
    }

    fn of(header: Vec<String>, rows: Vec<Vec<String>>) -> Self {
        let is_number = |text: &str| {
            let first = text.trim_start_matches(['<', ' ', '−', '-']);
            text.is_empty()
                || first.starts_with(|c: char| c.is_ascii_digit())
                || matches!(first, "inf" | "infinite" | "–")
        };
        let numeric = (0..header.len()).map(|column| rows.iter().all(|row| is_number(&row[column]))).collect();
        Self { header, rows, numeric, widths: Vec::new() }
    }

    /// Draws it as high as it is. A wide one scrolls sideways by itself.
    pub fn show(&mut self, ui: &mut egui::Ui, id: &str) {
        if self.widths.is_empty() {
            self.widths = self.measure(ui);
        }
        let height = ui.text_style_height(&TextStyle::Body) + 8.0;
        let size = Vec2::new(self.widths.iter().sum(), height * (self.rows.len() + 1) as f32);
        ScrollArea::horizontal().id_salt(id).auto_shrink([false, true]).show(ui, |ui| {
            let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
            self.row(ui, rect, 0, height, &self.header, true);
            let line = rect.top() + height;
            ui.painter().hline(rect.x_range(), line, egui::Stroke::new(1.0, theme::QUIET));
            let seen = ui.clip_rect();
            let first = ((seen.top() - line) / height).floor().max(0.0) as usize;
            let last = ((seen.bottom() - line) / height).ceil().max(0.0) as usize;
            for (index, row) in self.rows.iter().enumerate().take(last).skip(first) {
                self.row(ui, rect, index + 1, height, row, false);
            }
        });
    }

    fn row(&self, ui: &mut egui::Ui, rect: Rect, index: usize, height: f32, cells: &[String], head: bool) {
        let top = rect.top() + height * index as f32;
        let mut left = rect.left();
        for ((text, &width), &numeric) in cells.iter().zip(&self.widths).zip(&self.numeric) {
            let cell = Rect::from_min_size(egui::pos2(left, top), Vec2::new(width, height))
                .shrink2(Vec2::new(PADDING / 2.0, 0.0));
            let layout =
                if numeric { Layout::right_to_left(Align::Center) } else { Layout::left_to_right(Align::Center) };
            if !text.is_empty() {
                let text = RichText::new(text);
                let text = if head { text.color(theme::QUIET) } else { text };
                ui.scope_builder(UiBuilder::new().max_rect(cell).layout(layout), |ui| {
                    ui.add(egui::Label::new(text).extend());
                });
            }
            left += width;
        }
    }

    fn measure(&self, ui: &egui::Ui) -> Vec<f32> {
        let font = TextStyle::Body.resolve(ui.style());
        let width = |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), theme::QUIET).size().x;
        (self.header.iter().enumerate())
            .map(|(column, name)| {
                let texts = self.rows.iter().map(|row| row[column].as_str());
                let widest = if self.rows.len() > MEASURED {
                    texts.max_by_key(|text| text.chars().count()).map(width).unwrap_or_default() + PADDING
                } else {
                    texts.map(width).fold(0.0, f32::max)
                };
                widest.max(width(name)) + PADDING
            })
            .collect()
    }
}

/// How many decimals, up to three, the numbers of a column have; none where none has any.
fn decimals(rows: &[Vec<String>], column: usize) -> Option<usize> {
    let of = |text: &String| match text.split_once('.') {
        _ if text.contains('e') => 3,
        Some((_, decimals)) => decimals.len(),
        None => 0,
    };
    rows.iter().map(|row| of(&row[column]).min(3)).max().filter(|decimals| *decimals > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_computed_is_rounded_and_what_is_named_is_not() {
        let text = |cells: [&str; 5]| cells.map(str::to_owned).to_vec();
        let table = Table {
            header: text(["width", "who", "n", "mean", "median"]),
            rows: vec![text(["0.0251", "S1", "96", "1.23456", "2"]), text(["inf", "S2", "1", "", "0.5"])],
        };
        let grid = Grid::rounded(&table, 2);
        assert_eq!(grid.rows, [["0.0251", "S1", "96", "1.235", "2.0"], ["inf", "S2", "1", "", "0.5"]]);
        assert_eq!(grid.numeric, [true, false, true, true, true]);
    }
}
