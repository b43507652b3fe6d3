//! Static plots and their legends.

use eframe::{
    egui::{AsIdSalt, Color32, FontId, RichText, Sense, Stroke, Ui, Vec2},
    emath::Rangef,
};
use egui_plot::{AxisHints, Plot};

use super::{
    text::secondary,
    theme::{GRID, NOTE, ink},
};

/// Minimum distance between the labels of an axis, across and down, points.
const TICKS: [f32; 2] = [40.0, 18.0];

/// Creates a static plot with these titles of its axes. Dragging and scrolling move the page, not the plot.
pub fn still_plot<'a>(ui: &Ui, id: impl AsIdSalt, [across, up]: [&str; 2]) -> Plot<'a> {
    let dim = ink(ui).dim;
    let small = |axis: AxisHints<'a>, title: &str, spacing: f32| {
        let axis = axis.tick_label_font(FontId::proportional(NOTE)).tick_label_color(dim);
        // Labels are there or not; none is faint.
        vec![axis.label(RichText::new(title).small().color(dim)).label_spacing(Rangef::new(spacing, spacing))]
    };
    Plot::new(id)
        .custom_x_axes(small(AxisHints::new_x(), across, TICKS[0]))
        .custom_y_axes(small(AxisHints::new_y(), up, TICKS[1]))
        .grid_color(GRID)
        .sense(Sense::hover())
        .allow_zoom(false)
        .allow_scroll(false)
}

/// Draws a legend: the name of each line after a piece of it. Unlike the legend inside a plot, it covers nothing.
pub fn legend<'a>(ui: &mut Ui, lines: impl IntoIterator<Item = (Color32, &'a str)>) {
    ui.horizontal_wrapped(|ui| {
        for (color, name) in lines {
            // The piece and its name stay on one line.
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 5.0;
                let height = ui.text_style_height(&eframe::egui::TextStyle::Small);
                let (rect, _) = ui.allocate_exact_size(Vec2::new(18.0, height), Sense::hover());
                ui.painter().hline(rect.x_range(), rect.center().y, Stroke::new(3.0, color));
                ui.label(secondary(name));
            });
        }
    });
}
