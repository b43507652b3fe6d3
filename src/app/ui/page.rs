//! Pages, which are columns of text and controls with a heading, a main button and keys, and navigation between them.

use std::convert::Infallible;

use eframe::egui::{
    self, CentralPanel, Color32, Context, Frame, Id, Key, Modal, Panel, Popup, RichText, ScrollArea, Ui, Vec2,
};

use super::{
    text::secondary,
    theme::{COLUMN, GAP, MARGIN, ink},
};

/// Where a page leads after a frame. The step of a page that can only lead back is a plain `Step`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step<T = Infallible> {
    /// Stay on this page.
    Stay,
    /// Go back to the previous page.
    Back,
    /// Go on to the next page, with the value that it needs.
    Next(T),
}

impl<T> Step<T> {
    pub fn back_if(back: bool) -> Self {
        if back { Self::Back } else { Self::Stay }
    }

    /// Converts the value for the next page.
    pub fn map<U>(self, next: impl FnOnce(T) -> U) -> Step<U> {
        match self {
            Self::Stay => Step::Stay,
            Self::Back => Step::Back,
            Self::Next(value) => Step::Next(next(value)),
        }
    }
}

impl Step {
    /// Converts this to the step of a page that can also go on to a next page.
    pub fn widen<U>(self) -> Step<U> {
        self.map(|never| match never {})
    }
}

/// Draws a page with a centered column, a little below the top. It scrolls if the window is too small.
pub fn page<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    page_from(ui, 0.18, add)
}

/// Draws the lower edge of a page, which stays in view when the page scrolls: its main button. Call this before the page
/// is drawn.
pub fn footer<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    let frame = Frame::NONE.inner_margin(egui::vec2(MARGIN, GAP));
    let panel = Panel::bottom("footer").resizable(false).show_separator_line(false).frame(frame);
    panel.show(ui, |ui| centered(ui, add)).inner
}

/// Draws a column in the middle of the available width.
fn centered<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    let width = ui.available_width().min(COLUMN);
    let margin = (ui.available_width() - width) / 2.0;
    let content = |ui: &mut Ui| {
        ui.set_width(width);
        add(ui)
    };
    ui.horizontal(|ui| {
        ui.add_space(margin);
        ui.vertical(content).inner
    })
    .inner
}

/// Draws a page that begins at this share of the window's height.
pub fn page_from<R>(ui: &mut Ui, top: f32, add: impl FnOnce(&mut Ui) -> R) -> R {
    let column = |ui: &mut Ui| {
        // A small window has no room for the space at the top.
        let spare = ui.available_height() - 560.0;
        ui.add_space((ui.available_height() * top).min(spare.max(0.0)));
        centered(ui, add)
    };
    let scrolling = |ui: &mut Ui| ScrollArea::vertical().auto_shrink(false).show(ui, column).inner;
    CentralPanel::default().frame(Frame::NONE.inner_margin(MARGIN)).show(ui, scrolling).inner
}

/// Draws a page for one tool, with its name, a back button and its content. Returns whether the user left it, with the
/// button or with Escape, and the result of `add`.
pub fn tool_page<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> R) -> (bool, R) {
    let escaped = escaped(ui);
    page_from(ui, 0.02, |ui| {
        let back = heading(ui, name);
        ui.add_space(8.0);
        let content = add(ui);
        (back || escaped, content)
    })
}

/// Draws the name of a page and its back button; returns whether the button was clicked.
pub fn heading(ui: &mut Ui, name: &str) -> bool {
    ui.horizontal_wrapped(|ui| {
        ui.heading(name);
        let back = ui.button("Back").clicked();
        ui.label(secondary("Esc"));
        back
    })
    .inner
}

/// Draws the main button of a page, followed by a hint, such as its key; returns whether the button was clicked.
pub fn primary(ui: &mut Ui, text: &str, enabled: bool, hint: &str) -> bool {
    let button = egui::Button::new(RichText::new(text).size(19.0).strong().color(Color32::BLACK))
        .fill(ink(ui).primary)
        // As high as the style's other buttons and half as much again.
        .min_size(1.4 * Vec2::new(4.0 * ui.spacing().interact_size.y, ui.spacing().interact_size.y));
    ui.horizontal(|ui| {
        let clicked = ui.add_enabled(enabled, button).clicked();
        if !hint.is_empty() {
            super::text::hint(ui, hint);
        }
        clicked
    })
    .inner
}

/// Draws a button with its key next to it; returns whether it was clicked.
pub fn keyed(ui: &mut Ui, text: &str, key: &str) -> bool {
    ui.horizontal(|ui| {
        let clicked = ui.button(text).clicked();
        ui.label(secondary(key));
        clicked
    })
    .inner
}

/// Draws a dialog of at most this width, points, above the page. `add` gets the height that it may fill. Returns its
/// result, and whether the user closed the dialog with Escape or by a click beside it.
pub fn modal<R>(ctx: &Context, id: &str, width: f32, add: impl FnOnce(&mut Ui, f32) -> R) -> (R, bool) {
    let room = ctx.content_rect().size() - Vec2::splat(2.0 * (MARGIN + GAP));
    let frame = Frame::popup(&ctx.global_style()).inner_margin(MARGIN);
    let shown = Modal::new(Id::unique(("dialog", id))).frame(frame).show(ctx, |ui| {
        ui.set_width(width.min(room.x));
        add(ui, room.y)
    });
    let closed = shown.should_close();
    (shown.inner, closed)
}

/// Asks before something is lost. `keep` and `leave` are the answers; returns whether to leave, once answered.
pub fn ask(ctx: &Context, question: &str, text: &str, [keep, leave]: [&str; 2]) -> Option<bool> {
    let ((kept, left), closed) = modal(ctx, question, 480.0, |ui, _| {
        ui.heading(question);
        ui.label(text);
        ui.add_space(GAP);
        (primary(ui, keep, true, "Esc"), ui.button(leave).clicked())
    });
    if kept || closed { Some(false) } else { left.then_some(true) }
}

/// Returns whether a key was pressed that is meant for the page. A control with keyboard focus handles keys itself.
pub fn shortcut(ui: &Ui, key: Key) -> bool {
    let focused = ui.memory(|memory| memory.focused().is_some());
    !focused && ui.input(|input| input.key_pressed(key))
}

/// Returns whether Escape leaves the page. Escape first closes the innermost thing: an open list or dialog, then the
/// field in which the user is typing. Call this before lists and dialogs are drawn.
pub fn escaped(ui: &Ui) -> bool {
    let open = Popup::is_any_open(ui.ctx()) || !ui.memory(|memory| memory.allows_interaction(ui.layer_id()));
    // egui has already taken the keyboard focus from the field in which the user was typing.
    let typing = ui.data(|data| data.get_temp(typing_id())).unwrap_or(false);
    !open && !typing && ui.input(|input| input.key_pressed(Key::Escape))
}

/// Remembers whether the user is typing in a field, so that [`escaped`] knows it in the next frame. Call this at the end
/// of each frame.
pub fn end_frame(ctx: &egui::Context) {
    let typing = ctx.text_edit_focused();
    ctx.data_mut(|data| data.insert_temp(typing_id(), typing));
}

/// Takes the keyboard focus from the control that has it, when another page appears: Space is then a key of that page.
pub fn release_focus(ctx: &egui::Context) {
    if let Some(focused) = ctx.memory(|memory| memory.focused()) {
        ctx.memory_mut(|memory| memory.surrender_focus(focused));
    }
}

fn typing_id() -> Id {
    Id::unique("typing")
}
