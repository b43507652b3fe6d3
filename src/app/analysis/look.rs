//! Small things that the parts of the pane have in common.

use eframe::egui::{self, Label, Response, RichText};

use crate::app::theme;

/// Tells what a control is to someone who does not see it.
pub fn named(ui: &egui::Ui, response: &Response, name: &str) {
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
}

/// A paragraph.
pub fn text(ui: &mut egui::Ui, text: impl Into<egui::WidgetText>) {
    ui.add(Label::new(text).wrap());
}

/// Secondary text in a paragraph.
pub fn quiet(ui: &mut egui::Ui, text: impl Into<String>) {
    ui.add(Label::new(theme::quiet(text)).wrap());
}

/// What is worth knowing, with its mark.
pub fn note(ui: &mut egui::Ui, text: impl Into<String>) {
    ui.horizontal_top(|ui| {
        theme::mark(ui, false);
        ui.add(Label::new(RichText::new(text).color(theme::NOTE)).wrap());
    });
}

/// A heading within a view.
pub fn heading(ui: &mut egui::Ui, text: impl Into<String>) {
    ui.add_space(6.0);
    ui.add(Label::new(RichText::new(text).strong().size(18.0)).wrap());
}

/// A choice of one among names, on as many lines as it needs; true where it changed.
pub fn chips(ui: &mut egui::Ui, chosen: &mut usize, names: impl IntoIterator<Item = impl Into<String>>) {
    ui.horizontal_wrapped(|ui| {
        for (index, name) in names.into_iter().enumerate() {
            if ui.selectable_label(*chosen == index, name.into()).clicked() {
                *chosen = index;
            }
        }
    });
}
