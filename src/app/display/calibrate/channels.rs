//! How the channels are drawn in plots.

use eframe::egui::Color32;
use egui_plot::MarkerShape;

use crate::{app::ui::theme::SERIES, display::Channel};

/// Color and marker of a channel.
pub fn series(channel: Channel) -> (Color32, MarkerShape) {
    match channel {
        Channel::Red => (SERIES[5], MarkerShape::Square),
        Channel::Green => (SERIES[2], MarkerShape::Up),
        Channel::Blue => (SERIES[1], MarkerShape::Diamond),
        Channel::Gray => (Color32::from_gray(0xd0), MarkerShape::Circle),
    }
}
