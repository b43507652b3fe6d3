//! The line at the lower edge of the window: the latest message of the program, and what the page works on.

use eframe::egui::{self, Align, CentralPanel, Context, Frame, Id, Label, Layout, RichText, Sense, Ui};

use super::{
    page::menu,
    theme::{GAP, Icon, LARGE_GAP, ink},
};

/// Number of messages that a click on the line shows.
const KEPT: usize = 50;

/// A message of the program, and whether it is an error.
type Message = (String, bool);

/// Shows a message: that something was done.
pub fn say(ctx: &Context, text: impl Into<String>) {
    add(ctx, text.into(), false);
}

/// Shows an error that belongs to no field.
pub fn complain(ctx: &Context, text: impl Into<String>) {
    add(ctx, text.into(), true);
}

fn add(ctx: &Context, text: String, failed: bool) {
    ctx.data_mut(|data| {
        let messages: &mut Vec<Message> = data.get_temp_mut_or_default(id());
        messages.insert(0, (text, failed));
        messages.truncate(KEPT);
    });
    // The line may have been drawn already.
    ctx.request_repaint();
}

fn id() -> Id {
    Id::unique("status messages")
}

/// Draws the line. `about` is what the page works on: a folder or a display, with its icon.
pub fn status_line(ui: &mut Ui, about: Option<(Icon, &str)>) {
    let frame = Frame::NONE.fill(ink(ui).rail).inner_margin(egui::Margin::symmetric(LARGE_GAP as i8, 0));
    CentralPanel::default().frame(frame).show(ui, |ui| {
        let messages: Vec<Message> = ui.data(|data| data.get_temp(id())).unwrap_or_default();
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if let Some((icon, text)) = about {
                ui.scope(|ui| {
                    ui.set_max_width(0.6 * ui.available_width());
                    ui.add(Label::new(RichText::new(text).small().color(ink(ui).dim)).truncate());
                });
                icon.show(ui, ink(ui).dim);
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let Some((text, failed)) = messages.first() else { return };
                ui.spacing_mut().item_spacing.x = GAP;
                let (icon, color) = if *failed { (Icon::Warn, ink(ui).bad) } else { (Icon::Check, ink(ui).text) };
                icon.show(ui, color);
                let line = text.lines().next().unwrap_or_default();
                let label = Label::new(RichText::new(line).small().color(color)).truncate().sense(Sense::click());
                let shown = ui.add(label);
                menu(&shown, |ui| {
                    ui.set_width(480.0);
                    // A menu would stretch the spaces between the words.
                    ui.with_layout(Layout::top_down(Align::Min), |ui| {
                        for (text, failed) in &messages {
                            let color = if *failed { ink(ui).bad } else { ink(ui).text };
                            ui.add(Label::new(RichText::new(text).small().color(color)).wrap());
                        }
                    });
                });
            });
        });
    });
}
