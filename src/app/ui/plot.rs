//! Plots.

use eframe::egui::AsIdSalt;
use egui_plot::Plot;

/// A plot that stays as it is: dragging and scrolling move the page, not the plot.
pub fn still_plot<'a>(id: impl AsIdSalt) -> Plot<'a> {
    Plot::new(id)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
}
