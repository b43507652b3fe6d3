//! The image on the page, with dragging, overlays and the keys to its colors.

use eframe::egui::{
    self, Color32, CursorIcon, EventFilter, Id, Key, Label, Popup, Pos2, Rect, Response, Sense, Shape, Stroke,
    TextureId, Vec2,
};

use super::comparison::Comparison;
use crate::app::ui::{describe, pixels, secondary, theme};

/// Degrees of rotation per press of an arrow key, without and with Shift.
const STEPS_DEG: [f64; 2] = [5.0, 1.0];

/// The enlargements of the picture; at 1, each of its pixels is one of the screen.
const ZOOMS: [f32; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];

/// Radius of the knob that moves the divider, points.
const KNOB: f32 = 9.0;

/// How the images are shown. None of these settings changes an image.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewSettings {
    /// Whether maps show how visible the difference of each image from the smooth surface is, in its place.
    pub maps: bool,
    /// Position of the divider, as a share of the image's width.
    pub divider: f64,
    /// Whether the scan line and its plots are shown; a drag then draws the line, and otherwise rotates the mesh.
    pub scan: bool,
    /// The ends of the scan line, as shares of the image's width and height.
    pub line: [Pos2; 2],
    /// One of `ZOOMS`.
    pub zoom: f32,
    /// The place in the middle of the enlarged picture, as shares of its width and height.
    pub middle: Pos2,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            maps: false,
            divider: 0.5,
            scan: false,
            line: [Pos2::new(0.2, 0.45), Pos2::new(0.8, 0.45)],
            zoom: ZOOMS[0],
            middle: Pos2::new(0.5, 0.5),
        }
    }
}

impl ViewSettings {
    /// Returns the first column of the right picture.
    pub fn column(&self, width: u32) -> u32 {
        (self.divider.clamp(0.0, 1.0) * f64::from(width)).round() as u32
    }

    /// Returns the next larger or smaller enlargement, if there is one.
    pub fn next_zoom(&self, larger: bool) -> Option<f32> {
        let at = ZOOMS.iter().position(|zoom| *zoom >= self.zoom)?;
        ZOOMS.get(if larger { at + 1 } else { at.checked_sub(1)? }).copied()
    }

    /// Returns where the whole picture is, of which `rect` shows a part when it is enlarged.
    pub fn whole(&self, rect: Rect) -> Rect {
        let size = rect.size() * self.zoom;
        let min = rect.center() - self.middle.to_vec2() * size;
        // No edge of the picture is inside the view.
        let min = min.min(rect.min).max(rect.max - size);
        Rect::from_min_size(min, size)
    }
}

/// Returns the largest rectangle of whole physical pixels in `area`, and its size in pixels.
pub fn whole_pixels(ctx: &egui::Context, area: Rect) -> (Rect, [u32; 2]) {
    let scale = ctx.pixels_per_point();
    let low = (area.min.to_vec2() * scale).ceil();
    let size = ((area.max.to_vec2() * scale).floor() - low).max(Vec2::splat(1.0));
    let rect = Rect::from_min_size((low / scale).to_pos2(), size / scale);
    (rect, [size.x as u32, size.y as u32])
}

const ARROWS: [Key; 4] = [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown];

/// Lets the pointer and the keys move the mesh, the light or the scan line; returns whether a drag is in progress.
pub fn interact(
    ui: &egui::Ui,
    rect: Rect,
    compared: &mut Comparison,
    settings: &mut ViewSettings,
    label: &str,
) -> bool {
    let response = ui.interact(rect, Id::unique("shading picture"), Sense::click_and_drag());
    describe(&response, label);
    // While nothing has the focus, the arrow keys are for the picture.
    let is_free = ui.memory(|memory| memory.focused().is_none() && memory.allows_interaction(ui.layer_id()));
    let turns =
        is_free && !Popup::is_any_open(ui.ctx()) && ARROWS.iter().any(|key| ui.input(|input| input.key_pressed(*key)));
    if response.drag_started() || response.clicked() || turns {
        response.request_focus();
    }
    if response.dragged_by(egui::PointerButton::Middle) {
        settings.middle -= response.drag_delta() / (rect.size() * settings.zoom);
    } else if response.dragged() {
        drag(&response, rect, compared, settings);
    }
    zoom(ui, &response, rect, settings);
    if response.has_focus() || turns {
        keys(ui, &response, compared, settings);
        ui.painter().rect_stroke(rect, 0.0, Stroke::new(2.0, theme::ink(ui).text), egui::StrokeKind::Outside);
    }
    let icon = match () {
        () if settings.scan => CursorIcon::Crosshair,
        () if response.dragged() => CursorIcon::Grabbing,
        () => CursorIcon::Grab,
    };
    let divided = divider(ui, rect, settings);
    response.on_hover_cursor(icon).dragged() || divided
}

/// Lets the wheel enlarge the picture about the pointer.
fn zoom(ui: &egui::Ui, response: &Response, rect: Rect, settings: &mut ViewSettings) {
    let notches = ui.input(|input| {
        let wheel = |event: &egui::Event| match event {
            egui::Event::MouseWheel { delta, .. } => delta.y,
            _ => 0.0,
        };
        input.events.iter().map(wheel).sum::<f32>()
    });
    let Some(at) = response.hover_pos().filter(|_| notches != 0.0) else { return };
    let place = share(settings.whole(rect), at);
    settings.zoom = settings.next_zoom(notches > 0.0).unwrap_or(settings.zoom);
    settings.middle = place + (rect.center() - at) / (rect.size() * settings.zoom);
    settings.middle = settings.middle.clamp(Pos2::ZERO, Pos2::new(1.0, 1.0));
}

fn drag(response: &Response, rect: Rect, compared: &mut Comparison, settings: &mut ViewSettings) {
    // A drag as long as the surface's radius rotates it by one radian.
    let radius = 0.45 * rect.width().min(rect.height());
    let turned = (response.drag_delta() / radius).to_pos2();
    let [right, down] = [turned.x, turned.y].map(|radians| f64::from(radians).to_degrees());
    let is_light = response.dragged_by(egui::PointerButton::Secondary);
    match response.interact_pointer_pos() {
        Some(at) if settings.scan && !is_light => {
            let place = share(settings.whole(rect), at);
            if response.drag_started() {
                settings.line[0] = place;
            }
            settings.line[1] = place;
        }
        _ if response.drag_delta() == Vec2::ZERO => {}
        _ if is_light => {
            let [from_right, from_up] = compared.light_deg();
            compared.set_light_deg([from_right + right, from_up - down]);
        }
        _ => compared.turn(right, down),
    }
}

fn keys(ui: &egui::Ui, response: &Response, compared: &mut Comparison, settings: &mut ViewSettings) {
    let [right, down] = arrows(ui, response);
    let step = STEPS_DEG[usize::from(ui.input(|input| input.modifiers.shift))];
    if settings.scan {
        let by = Vec2::new(right as f32, down as f32) * step as f32 / 250.0;
        settings.line = settings.line.map(|end| (end + by).clamp(Pos2::ZERO, Pos2::new(1.0, 1.0)));
    } else if right != 0.0 || down != 0.0 {
        compared.turn(right * step, down * step);
    }
}

/// Returns the number of presses of the right and down arrow keys (left and up are negative) for the control with
/// keyboard focus.
fn arrows(ui: &egui::Ui, response: &Response) -> [f64; 2] {
    let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..Default::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
    let [left, right, up, down] = ARROWS.map(|key| ui.input(|input| input.num_presses(key) as f64));
    [right - left, down - up]
}

/// Handles dragging and keys on the divider; returns whether it is being dragged.
fn divider(ui: &egui::Ui, rect: Rect, settings: &mut ViewSettings) -> bool {
    let x = rect.left() + rect.width() * settings.divider as f32;
    // Only the knob takes the drag, so that the picture can be dragged beside the line.
    let handle = Rect::from_center_size(knob(rect, x), Vec2::splat(2.0 * KNOB + 8.0));
    let response = ui.interact(handle, Id::unique("shading divider"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::slider(true, settings.divider, "Divider"));
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_value(format!("{:.3}", settings.divider)));
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        settings.divider = f64::from(share(rect, at).x);
    }
    if response.has_focus() {
        let [right, _] = arrows(ui, &response);
        settings.divider = (settings.divider + right * 0.02).clamp(0.0, 1.0);
    }
    let dragged = response.dragged();
    response.on_hover_cursor(CursorIcon::ResizeHorizontal);
    dragged
}

/// Draws the image: the columns left of the divider from one texture, the rest from the other.
pub fn draw(ui: &egui::Ui, rect: Rect, textures: [TextureId; 2], size: [u32; 2], settings: &ViewSettings) {
    let x = rect.left() + rect.width() * settings.column(size[0]) as f32 / size[0] as f32;
    let halves = [rect.left()..=x, x..=rect.right()];
    for (texture, half) in textures.into_iter().zip(halves) {
        let clip = Rect::from_x_y_ranges(half, rect.y_range()).intersect(ui.clip_rect());
        pixels::paint(&ui.painter().with_clip_rect(clip), texture, settings.whole(rect));
    }
}

/// Draws the divider and the scan line.
pub fn draw_marks(ui: &egui::Ui, rect: Rect, settings: &ViewSettings) {
    let painter = ui.painter().with_clip_rect(rect.expand(KNOB));
    let x = rect.left() + rect.width() * settings.divider as f32;
    if ui.memory(|memory| memory.has_focus(Id::unique("shading divider"))) {
        painter.vline(x, rect.y_range(), Stroke::new(4.0, ui.visuals().selection.stroke.color));
    }
    painter.vline(x, rect.y_range(), Stroke::new(1.0, theme::MARK_LINE));
    grip(&painter, knob(rect, x));
    if settings.scan {
        let whole = settings.whole(rect);
        let [from, to] = settings.line.map(|end| whole.lerp_inside(end.to_vec2()));
        // A dark line next to a light one, so that the scan line is visible on any image.
        painter.line_segment([from, to], Stroke::new(3.0, theme::SHADE));
        painter.line_segment([from, to], Stroke::new(1.0, theme::MARK));
        painter.circle(from, 4.0, theme::MARK_DARK, Stroke::new(1.5, theme::MARK));
        painter.circle_filled(to, 3.0, theme::MARK);
    }
}

/// Returns the center of the divider's knob; `x` is where the divider is.
fn knob(rect: Rect, x: f32) -> Pos2 {
    Pos2::new(x.clamp(rect.left() + KNOB, rect.right() - KNOB), rect.bottom() - 26.0)
}

/// Draws the handle of the divider: two arrowheads on a disc.
fn grip(painter: &egui::Painter, at: Pos2) {
    let [fill, outline] = theme::KNOB;
    painter.circle(at, KNOB, fill, Stroke::new(1.0, outline));
    for side in [-1.0, 1.0] {
        let corner = |x: f32, y: f32| at + Vec2::new(x * side, y);
        let tip = vec![corner(6.5, 0.0), corner(2.0, -3.5), corner(2.0, 3.5)];
        painter.add(Shape::convex_polygon(tip, theme::MARK, Stroke::NONE));
    }
}

/// Converts a position to shares of a rectangle's width and height.
fn share(rect: Rect, at: Pos2) -> Pos2 {
    let from = (at - rect.min) / rect.size();
    from.to_pos2().clamp(Pos2::ZERO, Pos2::new(1.0, 1.0))
}

/// Size of a scale of colors, points.
const SCALE: Vec2 = Vec2::new(120.0, 12.0);
const STEPS: usize = 40;

/// Draws a scale of encoded colors between the names of its ends.
pub fn key(ui: &mut egui::Ui, least: &str, color: impl Fn(f64) -> [f64; 3], most: &str) {
    ui.label(secondary(least));
    let (rect, response) = ui.allocate_exact_size(SCALE, Sense::hover());
    describe(&response, &format!("Key: from {least} to {most}"));
    let step = rect.width() / STEPS as f32;
    for i in 0..STEPS {
        let left = rect.left() + step * i as f32;
        let part = Rect::from_x_y_ranges(left..=left + step, rect.y_range());
        let [r, g, b] = color(i as f64 / (STEPS - 1) as f64).map(|encoded| (encoded * 255.0).round() as u8);
        ui.painter().rect_filled(part, 0.0, Color32::from_rgb(r, g, b));
    }
    // A wider page would change the size of the picture, and thus what is measured.
    ui.add(Label::new(secondary(most)).truncate());
}
