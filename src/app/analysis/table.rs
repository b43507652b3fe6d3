//! A table of the document. It scrolls horizontally, draws only its visible rows, and can be sorted by clicking a
//! column name. The names stay in view while any of its rows is.

use eframe::egui::{
    self, Align, Button, Label, Layout, Rect, RichText, Role, ScrollArea, Sense, TextStyle, UiBuilder, Vec2,
    WidgetInfo, scroll_area::ScrollBarVisibility,
};

use crate::{
    app::ui::{paragraph, text::name, theme},
    report::document::TextTable,
};

/// Padding of a column, points.
const PADDING: f32 = 16.0;

/// A table and the order of its rows.
pub struct TableView {
    table: TextTable,
    /// Width of each column, points; measured when the table is first drawn.
    widths: Vec<f32>,
    /// The column by which the table is sorted, and whether the order is descending.
    sorted: Option<(usize, bool)>,
}

impl TableView {
    pub fn new(table: TextTable) -> Self {
        Self { table, widths: Vec::new(), sorted: None }
    }

    /// Sorts the rows as those of an earlier table, if that is the same of other data.
    pub fn sort_like(&mut self, earlier: &Self) {
        let is_same = earlier.table.caption == self.table.caption && earlier.table.header == self.table.header;
        if let Some((column, down)) = earlier.sorted.filter(|_| is_same) {
            self.sort(column);
            if down {
                self.sort(column);
            }
        }
    }

    /// Draws the table at its full height.
    pub fn show(&mut self, ui: &mut egui::Ui, id: usize) {
        ui.add_space(6.0);
        paragraph(ui, RichText::new(&self.table.caption).strong());
        if self.widths.is_empty() {
            self.widths = self.measure(ui);
        }
        let height = ui.text_style_height(&TextStyle::Body) + 8.0;
        let size = Vec2::new(self.widths.iter().sum(), height * (self.table.rows.len() + 1) as f32);
        // The bar of a table below the view would be at the edge of the view.
        let is_below = ui.cursor().top() > ui.clip_rect().bottom();
        let bar = if is_below { ScrollBarVisibility::AlwaysHidden } else { ScrollBarVisibility::VisibleWhenNeeded };
        let area = ScrollArea::horizontal().scroll_bar_visibility(bar).id_salt(id).auto_shrink([false, true]);
        let clicked = area.show(ui, |ui| {
            let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
            response.widget_info(|| WidgetInfo::labeled(Role::Table, true, &self.table.caption));
            let line = rect.top() + height;
            let visible = ui.clip_rect();
            let first = ((visible.top() - line) / height).floor().max(0.0) as usize;
            let last = ((visible.bottom() - line) / height).ceil().max(0.0) as usize;
            for (index, row) in self.table.rows.iter().enumerate().take(last).skip(first) {
                if index % 2 == 1 {
                    let stripe = Rect::from_min_size(rect.min, Vec2::new(rect.width(), height));
                    let stripe = stripe.translate(Vec2::new(0.0, height * (index + 1) as f32));
                    ui.painter().rect_filled(stripe, 0.0, theme::ink(ui).stripe);
                }
                for (column, text) in row.iter().enumerate() {
                    self.cell(ui, rect, height, (index + 1, column), |ui| ui.add(Label::new(&**text).extend()));
                }
            }
            let top = visible.top().min(rect.bottom() - 2.0 * height).max(rect.top());
            let head = Rect::from_min_size(egui::pos2(rect.left(), top), Vec2::new(rect.width(), height));
            let ink = theme::ink(ui);
            if top > rect.top() {
                // The names also cover the rows of a table that is dimmed.
                let mut painter = ui.painter().clone();
                painter.set_opacity(1.0);
                painter.rect_filled(head, 0.0, ink.page);
            }
            ui.painter().hline(head.x_range(), head.bottom(), egui::Stroke::new(1.0, ink.dim));
            self.header(ui, head, height)
        });
        if let Some(column) = clicked.inner {
            self.sort(column);
        }
    }

    /// Draws the column names; returns the one that was clicked.
    fn header(&self, ui: &mut egui::Ui, rect: Rect, height: f32) -> Option<usize> {
        let mut clicked = None;
        for (column, text) in self.table.header.iter().enumerate() {
            let button = Button::new(RichText::new(text).color(theme::ink(ui).dim)).frame_when_inactive(false);
            let response = self.cell(ui, rect, height, (0, column), |ui| ui.add(button));
            name(ui, &response, &format!("Sort by {text}"));
            if let Some((_, down)) = self.sorted.filter(|(sorted, _)| *sorted == column) {
                let order = if down { "descending" } else { "ascending" };
                ui.ctx().accesskit_node_builder(response.id, |node| node.set_description(format!("sorted, {order}")));
                // The arrow is on the side that has room. It is painted, because the font has no arrows.
                let is_text = column < self.table.texts;
                let x = if is_text { response.rect.right() + 6.0 } else { response.rect.left() - 6.0 };
                let (y, tip) = (response.rect.center().y, if down { 3.0 } else { -3.0 });
                let corners = [(x - 4.0, y - tip), (x + 4.0, y - tip), (x, y + tip)].map(egui::Pos2::from);
                ui.painter().add(egui::Shape::convex_polygon(corners.to_vec(), theme::ink(ui).dim, egui::Stroke::NONE));
            }
            clicked = if response.clicked() { Some(column) } else { clicked };
        }
        clicked
    }

    fn cell(
        &self,
        ui: &mut egui::Ui,
        rect: Rect,
        height: f32,
        (row, column): (usize, usize),
        add: impl FnOnce(&mut egui::Ui) -> egui::Response,
    ) -> egui::Response {
        let left = rect.left() + self.widths[..column].iter().sum::<f32>();
        let corner = egui::pos2(left, rect.top() + height * row as f32);
        let cell = Rect::from_min_size(corner, Vec2::new(self.widths[column], height));
        let layout = if column < self.table.texts {
            Layout::left_to_right(Align::Center)
        } else {
            Layout::right_to_left(Align::Center)
        };
        let inside = cell.shrink2(Vec2::new(PADDING / 2.0, 0.0));
        ui.scope_builder(UiBuilder::new().max_rect(inside).layout(layout), add).inner
    }

    fn measure(&self, ui: &egui::Ui) -> Vec<f32> {
        let font = TextStyle::Body.resolve(ui.style());
        let width =
            |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), theme::ink(ui).dim).size().x;
        (self.table.header.iter().enumerate())
            .map(|(column, name)| {
                let texts = self.table.rows.iter().map(|row| &*row[column]);
                let widest = texts.map(width).fold(0.0, f32::max);
                // Leaves room for the sort arrow.
                widest.max(width(name) + PADDING) + PADDING
            })
            .collect()
    }

    /// Sorts by a column: ascending first, descending when clicked again.
    fn sort(&mut self, column: usize) {
        let down = self.sorted == Some((column, false));
        self.sorted = Some((column, down));
        self.table.rows.sort_by(|a, b| {
            let order = a[column].value().compare(b[column].value());
            if down { order.reverse() } else { order }
        });
    }
}
