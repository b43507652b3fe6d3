//! Pages, which are columns of text and controls with a heading, a main button and keys, and navigation between them.

use eframe::egui::{
    self, CentralPanel, Color32, Context, Event, Frame, Id, InputState, Key, Modal, Panel, Popup, RichText, ScrollArea,
    Ui, UiBuilder, Vec2,
    accesskit::{Action, ActionRequest, TreeId},
    style::StyleModifier,
};

use super::{
    text::secondary,
    theme::{BIG_CONTROL, COLUMN, CONTROL, GAP, Icon, LARGE_GAP, MARGIN, compact, focus_ring, ink, ink_of},
};

/// Where a page leads after a frame. A page that can only lead back says instead whether the user left it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step<T> {
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

/// Draws a page with a centered column, a little below the top. It scrolls if the window is too small.
pub fn page<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    page_from(ui, 0.18, add)
}

/// Draws the lower edge of a page, which stays in view when the page scrolls: its main button. Call this before the page
/// is drawn.
pub fn footer<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    let frame = Frame::NONE.inner_margin(egui::vec2(MARGIN, GAP));
    let panel = Panel::bottom("footer").resizable(false).show_separator_line(false).frame(frame);
    panel.show(ui, |ui| centered(ui, ui.available_width(), add)).inner
}

/// Draws a column in the middle of the `whole` width, of which a scroll bar may have a part.
fn centered<R>(ui: &mut Ui, whole: f32, add: impl FnOnce(&mut Ui) -> R) -> R {
    let width = ui.available_width().min(COLUMN);
    let margin = (whole - width) / 2.0;
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
    scrolled(ui, "", |ui, whole| {
        // A small window has no room for the space at the top.
        let spare = ui.available_height() - 560.0;
        ui.add_space((ui.available_height() * top).min(spare.max(0.0)));
        centered(ui, whole, add)
    })
}

/// Draws the page of a place with this name, whose column is beside the side bar.
pub fn place_page<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui) -> R) -> R {
    scrolled(ui, name, |ui, _| {
        ui.set_width(ui.available_width().min(COLUMN));
        add(ui)
    })
}

fn scrolled<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui, f32) -> R) -> R {
    let scrolling = |ui: &mut Ui| {
        let (width, area) = (ui.available_width(), ScrollArea::vertical().id_salt(name).auto_shrink(false));
        area.show(ui, |ui| paged(ui, |ui| add(ui, width))).inner
    };
    CentralPanel::default().frame(Frame::NONE.inner_margin(MARGIN)).show(ui, scrolling).inner
}

/// Draws what scrolls: Page Up and Page Down move it, because not everything in it can have the focus.
pub fn paged<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    let added = add(ui);
    let is_free = ui.memory(|memory| memory.allows_interaction(ui.layer_id())) && !ui.ctx().text_edit_focused();
    let presses = |key| ui.input(|input| input.num_presses(key)) as f32;
    let pages = presses(Key::PageUp) - presses(Key::PageDown);
    if is_free && pages != 0.0 {
        ui.scroll_with_delta(Vec2::new(0.0, 0.9 * pages * ui.clip_rect().height()));
    }
    added
}

/// Draws a page for one tool, with its name, a back button and its content. Returns whether the user left it, with the
/// button or with Escape.
pub fn tool_page(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) -> bool {
    let escaped = escaped(ui);
    place_page(ui, name, |ui| {
        let back = heading(ui, name);
        ui.add_space(8.0);
        add(ui);
        back || escaped
    })
}

/// Height of the bar above a window, points.
const TITLE_BAR: f32 = 40.0;
/// In a page narrower than this, in points, the view is above the controls, in one column.
const ONE_COLUMN: f32 = 760.0;

/// The parts of a page with controls on the left, an export below them that stays in view, and a view on the right.
pub struct Bench<T> {
    pub name: &'static str,
    /// Width of the controls, points.
    pub width: f32,
    pub controls: fn(&mut T, &mut Ui),
    pub export: fn(&mut T, &mut Ui),
    /// Draws the view; the last argument is true in one column.
    pub view: fn(&mut T, &mut Ui, bool),
}

impl<T> Bench<T> {
    /// Draws the page; returns whether its back button was clicked.
    pub fn show(self, ui: &mut Ui, page: &mut T) -> bool {
        let Self { name, width, controls, export, view } = self;
        let is_narrow = ui.available_width() < ONE_COLUMN;
        let frame = Frame::NONE.inner_margin(LARGE_GAP);
        let mut back = false;
        let mut column = |ui: &mut Ui, page: &mut T| {
            ScrollArea::vertical().id_salt(name).auto_shrink(false).show(ui, |ui| {
                // Leaves room for the scroll bar.
                ui.set_max_width(ui.available_width() - 6.0);
                back = heading(ui, name);
                if is_narrow {
                    view(page, ui, true);
                    ui.separator();
                }
                controls(page, ui);
                if is_narrow {
                    export(page, ui);
                }
            });
        };
        compact(ui);
        if is_narrow {
            CentralPanel::default().frame(frame).show(ui, |ui| column(ui, page));
            return back;
        }
        Panel::left(name).resizable(false).exact_size(width).frame(frame).show(ui, |ui| {
            pinned(ui, page, column, |ui, page| export(page, ui));
        });
        CentralPanel::default().frame(frame).show(ui, |ui| view(page, ui, false));
        back
    }
}

/// Draws the lower edge of a column, which stays in view, and what is above it, which Tab reaches first.
pub fn pinned<T, A, B>(
    ui: &mut Ui,
    page: &mut T,
    above: impl FnOnce(&mut Ui, &mut T) -> A,
    below: impl FnOnce(&mut Ui, &mut T) -> B,
) -> (A, B) {
    let (id, column) = (ui.scope_id().with("lower edge"), ui.max_rect());
    let height: f32 = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let (upper, lower) = column.split_top_bottom_at_y(column.bottom() - height);
    let shown = ui.scope_builder(UiBuilder::new().max_rect(upper), |ui| above(ui, page)).inner;
    let edge = ui.scope_builder(UiBuilder::new().max_rect(lower), |ui| {
        ui.separator();
        below(ui, page)
    });
    let needed = edge.response.rect.height();
    if needed != height {
        ui.data_mut(|data| data.insert_temp(id, needed));
        ui.ctx().request_discard("the lower edge has another height");
        ui.ctx().request_repaint();
    }
    (shown, edge.inner)
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
    let ink = ink(ui);
    filled(ui, text, [ink.accent, ink.on_accent], enabled, hint)
}

/// Draws the main button of a page that shows a stimulus, where nothing may be colored; otherwise like [`primary`].
pub fn neutral_primary(ui: &mut Ui, text: &str, enabled: bool, hint: &str) -> bool {
    let ink = ink(ui);
    filled(ui, text, [ink.neutral, ink.on_neutral], enabled, hint)
}

fn filled(ui: &mut Ui, text: &str, [fill, on_fill]: [Color32; 2], enabled: bool, hint: &str) -> bool {
    // One that is disabled never stands out.
    let button = egui::Button::new(if enabled { RichText::new(text).color(on_fill) } else { text.into() });
    let button = if enabled { button.fill(fill) } else { button };
    let button = button.min_size(Vec2::new(3.0 * BIG_CONTROL, BIG_CONTROL));
    ui.horizontal(|ui| {
        let response = ui.add_enabled(enabled, button);
        focus_ring(ui, &response);
        if !hint.is_empty() {
            super::text::hint(ui, hint);
        }
        response.clicked()
    })
    .inner
}

/// Draws a button with an icon.
pub fn action(ui: &mut Ui, icon: Icon, text: &str) -> egui::Response {
    labeled(ui, icon, text, None)
}

/// Draws the main button of a page with an icon.
pub fn main_action(ui: &mut Ui, icon: Icon, text: &str) -> egui::Response {
    let ink = ink(ui);
    let response = labeled(ui, icon, text, Some([ink.accent, ink.on_accent]));
    focus_ring(ui, &response);
    response
}

/// Draws a menu below its button. A choice closes it, also with the keyboard, and the focus is seen in it.
pub fn menu<R>(button: &egui::Response, add: impl FnOnce(&mut Ui) -> R) -> Option<R> {
    let popup = Popup::menu(button).style(StyleModifier::default());
    let shown = popup.show(|ui| {
        let added = add(ui);
        let chooses = |input: &InputState| input.key_pressed(Key::Enter) || input.key_pressed(Key::Space);
        if ui.input(chooses) && !button.has_focus() {
            ui.close();
        }
        added
    });
    shown.map(|shown| shown.inner)
}

/// Draws a button without a background, for what is rarely needed; without a text, only its icon, whose name is `name`.
pub fn quiet(ui: &mut Ui, icon: Icon, text: &str, name: &str) -> egui::Response {
    let response = labeled(ui, icon, text, Some([Color32::TRANSPARENT, ink(ui).text]));
    super::text::name(ui, &response, name);
    if text.is_empty() { response.on_hover_text(name) } else { response }
}

fn labeled(ui: &mut Ui, icon: Icon, text: &str, colors: Option<[Color32; 2]>) -> egui::Response {
    let [fill, color] = colors.unwrap_or([ink(ui).raised, ink(ui).text]);
    let mut atoms = egui::Atoms::new(icon.atom(color));
    if !text.is_empty() {
        atoms.push_right(RichText::new(text).color(color));
    }
    let button = egui::Button::new(atoms);
    ui.add(if colors.is_some() { filled_with(button, fill) } else { button })
}

/// Sets the background of a button; if it is transparent, it appears only under the pointer.
pub fn filled_with(button: egui::Button<'_>, fill: Color32) -> egui::Button<'_> {
    if fill == Color32::TRANSPARENT { button.frame_when_inactive(false) } else { button.fill(fill) }
}

/// Draws what can be folded away, below its header, which shows the keyboard focus.
pub fn folded<R>(
    ui: &mut Ui,
    header: egui::CollapsingHeader,
    add: impl FnOnce(&mut Ui) -> R,
) -> egui::CollapsingResponse<R> {
    let shown = header.show(ui, add);
    focus_ring(ui, &shown.header_response);
    shown
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
/// result, and whether the user closed the dialog with Escape. A click beside it loses nothing.
pub fn modal<R>(ctx: &Context, id: &str, width: f32, add: impl FnOnce(&mut Ui, f32) -> R) -> (R, bool) {
    let room = ctx.content_rect().size() - Vec2::splat(2.0 * (MARGIN + GAP));
    let veil = ink_of(&ctx.global_style().visuals).veil;
    let frame = Frame::popup(&ctx.global_style()).inner_margin(MARGIN);
    let shown = Modal::new(Id::unique(("dialog", id))).backdrop_color(veil).frame(frame).show(ctx, |ui| {
        ui.set_width(width.min(room.x));
        ui.set_max_height(room.y);
        add(ui, room.y)
    });
    let closed = shown.should_close() && !shown.backdrop_response.clicked();
    (shown.inner, closed)
}

/// Draws a dialog with a Close button, above which its content scrolls; returns whether it stays open.
pub fn notice(ctx: &Context, id: &str, width: f32, add: impl FnOnce(&mut Ui)) -> bool {
    let (clicked, closed) = modal(ctx, id, width, |ui, height| {
        ScrollArea::vertical().max_height(height - CONTROL - 2.0 * GAP).show(ui, |ui| paged(ui, add));
        ui.add_space(GAP);
        ui.button("Close").clicked()
    });
    !(clicked || closed)
}

/// Asks before something is lost. `keep` and `leave` are the answers; returns whether to leave, once answered.
pub fn ask(ctx: &Context, question: &str, text: &str, [keep, leave]: [&str; 2]) -> Option<bool> {
    let ((kept, left), closed) = modal(ctx, question, 480.0, |ui, _| {
        ui.heading(question);
        ui.label(text);
        ui.add_space(GAP);
        (neutral_primary(ui, keep, true, "Esc"), ui.button(leave).clicked())
    });
    if kept || closed { Some(false) } else { left.then_some(true) }
}

/// Returns whether a key was pressed that is meant for the page. A control with keyboard focus handles keys itself.
pub fn shortcut(ui: &Ui, key: Key) -> bool {
    let is_free = ui.memory(|memory| memory.focused().is_none() && memory.allows_interaction(ui.layer_id()));
    is_free && ui.input(|input| input.key_pressed(key))
}

/// Returns whether Enter confirms the page or dialog: also in a text field, but not on a control that handles it itself.
/// Call this before the fields are drawn.
pub fn entered(ctx: &Context) -> bool {
    let free = ctx.memory(|memory| memory.focused().is_none()) || ctx.text_edit_focused();
    free && !Popup::is_any_open(ctx) && ctx.input(|input| input.key_pressed(Key::Enter))
}

/// Returns whether Escape leaves the page. Escape first closes the innermost thing: an open list or dialog, then the
/// field in which the user is typing. Call this before lists and dialogs are drawn.
pub fn escaped(ui: &Ui) -> bool {
    let open = Popup::is_any_open(ui.ctx()) || !ui.memory(|memory| memory.allows_interaction(ui.layer_id()));
    // egui has already taken the keyboard focus from the field in which the user was typing.
    let typing = LastFrame::of(ui.ctx(), |last| last.typing);
    !open && !typing && ui.input(|input| input.key_pressed(Key::Escape))
}

/// What the pages remember from the last frame.
#[derive(Clone, Default)]
struct LastFrame {
    /// Whether the user is typing in a field.
    typing: bool,
    focused: Option<Id>,
}

impl LastFrame {
    fn of<R>(ctx: &Context, change: impl FnOnce(&mut Self) -> R) -> R {
        ctx.data_mut(|data| change(data.get_temp_mut_or_default(Id::unique("last frame"))))
    }
}

/// Scrolls to the control that the keyboard focus moved to. Call this at the beginning of each frame.
pub fn begin_frame(ctx: &Context) {
    let focused = ctx.memory(|memory| memory.focused());
    let before = LastFrame::of(ctx, |last| std::mem::replace(&mut last.focused, focused));
    // A control that was clicked is under the pointer, and stays there.
    let is_cut = |response: &egui::Response| {
        !response.interact_rect.contains_rect(response.rect) && !response.contains_pointer()
    };
    let moved = focused.filter(|_| before != focused);
    if let Some(id) = moved.filter(|id| ctx.read_response(*id).is_some_and(|response| is_cut(&response))) {
        let (action, target_node) = (Action::ScrollIntoView, id.accesskit_id());
        let request = ActionRequest { action, target_tree: TreeId::ROOT, target_node, data: None };
        ctx.input_mut(|input| input.events.push(Event::AccessKitActionRequest(request)));
        ctx.request_repaint();
    }
}

/// Remembers the frame for the next one. Call this at the end of each frame.
pub fn end_frame(ctx: &Context) {
    let typing = ctx.text_edit_focused();
    // Forms check what was typed before they draw their fields, so that the next frame shows the result.
    if typing && ctx.input(|input| input.events.iter().any(|event| matches!(event, Event::Text(_) | Event::Key { .. })))
    {
        ctx.request_repaint();
    }
    LastFrame::of(ctx, |last| last.typing = typing);
}

/// Maximizes a window that is too large for its screen.
pub fn fit_window(ctx: &Context) {
    let sizes = ctx.input(|input| input.viewport().monitor_size.zip(input.viewport().inner_rect));
    if sizes.is_some_and(|(screen, window)| window.width() > screen.x || window.height() + TITLE_BAR > screen.y) {
        ctx.send_viewport_cmd(egui::ViewportCommand::Maximized(true));
    }
}

/// Takes the keyboard focus from the control that has it, because another page appears: Space is then a key of that page.
pub fn release_focus(ctx: &egui::Context) {
    ctx.request_repaint();
    if let Some(focused) = ctx.memory(|memory| memory.focused()) {
        ctx.memory_mut(|memory| memory.surrender_focus(focused));
    }
}
