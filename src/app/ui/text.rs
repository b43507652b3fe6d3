//! Text: paragraphs, hints, notes, and errors.

use eframe::egui::{
    self, Align, Color32, FontId, Label, Layout, Response, RichText, Role, TextStyle, Ui, Vec2, WidgetInfo, WidgetText,
    text::LayoutJob,
};

use super::theme::{Icon, NOTE, SECTION, ink};
use crate::experiment::Protocol;

pub fn secondary(text: impl Into<String>) -> RichText {
    RichText::new(text).small().weak()
}

/// Draws text that wraps.
pub fn paragraph(ui: &mut Ui, text: impl Into<WidgetText>) {
    ui.add(Label::new(text).wrap());
}

/// Draws secondary text that wraps.
pub fn hint(ui: &mut Ui, text: impl Into<String>) {
    paragraph(ui, secondary(text));
}

/// Draws a note that deserves attention.
pub fn note(ui: &mut Ui, text: impl Into<String>) {
    small(ui, text, ink(ui).warn);
}

/// Draws an error, next to the field or button that it concerns.
pub fn show_error(ui: &mut Ui, text: impl Into<String>) {
    small(ui, text, ink(ui).bad);
}

fn small(ui: &mut Ui, text: impl Into<String>, color: Color32) {
    paragraph(ui, RichText::new(text).small().color(color));
}

/// Draws a note in the room of two lines, which it takes even if it is empty, so that it shifts nothing. A longer one
/// takes up to `most` lines, and the pointer on it shows the rest.
pub fn two_lines(ui: &mut Ui, text: &str, color: Color32, most: usize) {
    let size = Vec2::new(ui.available_width(), (2.0 * ui.text_style_height(&TextStyle::Small)).ceil());
    let mut job = LayoutJob::simple(text.to_owned(), FontId::proportional(NOTE), color, size.x);
    job.wrap.max_rows = most;
    ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), |ui| {
        ui.set_min_size(size);
        ui.add(Label::new(job).wrap());
    });
}

/// Draws errors, one a line.
pub fn errors(ui: &mut Ui, errors: &str) {
    errors.lines().for_each(|error| show_error(ui, error));
}

/// Draws a heading within a page.
pub fn section(ui: &mut Ui, text: impl Into<String>) {
    ui.add_space(6.0);
    paragraph(ui, RichText::new(text).strong().size(SECTION));
}

/// Paints a check mark or an exclamation mark, because not every font has them.
pub fn tick(ui: &mut Ui, passed: bool) {
    let (icon, color) = if passed { (Icon::Check, ink(ui).good) } else { (Icon::Warn, ink(ui).warn) };
    icon.show(ui, color);
}

/// Replaces the hyphen of a number with a typographic minus sign.
pub fn signed(number: &str) -> String {
    number.replace('-', "−")
}

/// Describes a picture or a plot for screen readers.
pub fn describe(response: &Response, text: &str) {
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, text));
}

/// Names a control for screen readers.
pub fn name(ui: &Ui, response: &Response, name: &str) {
    let ctx: &egui::Context = ui.ctx();
    ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
}

/// Returns the number of trials and the estimated duration of a session.
pub fn extent(protocol: &Protocol) -> String {
    let (practice, main) = (protocol.design.practice as usize, protocol.main_trials());
    let of_them = if practice == 0 { String::new() } else { format!(", {practice} of them practice") };
    format!("{} trials{of_them}, about {} min", practice + main, protocol.minutes())
}
