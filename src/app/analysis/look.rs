//! Small things that the parts of the pane have in common.

use eframe::egui::{self, ComboBox, Label, Response, RichText};

use crate::app::theme;

/// Much on a page, and bars that show where there is more of it.
pub fn dense(ui: &mut egui::Ui) {
    theme::compact(ui);
    ui.spacing_mut().scroll = egui::style::ScrollStyle::thin();
}

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

/// A choice of one among names: all of them beside each other, or a list where there is little room.
pub fn choice(ui: &mut egui::Ui, name: &str, chosen: &mut usize, names: &[&str], narrow: bool) {
    *chosen = (*chosen).min(names.len().saturating_sub(1));
    if narrow {
        let text = names.get(*chosen).copied().unwrap_or_default();
        let list = ComboBox::from_id_salt(name).selected_text(text).width(150.0).truncate().show_ui(ui, |ui| {
            theme::compact(ui);
            for (index, name) in names.iter().enumerate() {
                ui.selectable_value(chosen, index, *name);
            }
        });
        named(ui, &list.response, name);
        return;
    }
    ui.horizontal_wrapped(|ui| {
        for (index, name) in names.iter().enumerate() {
            ui.selectable_value(chosen, index, *name);
        }
    });
}
