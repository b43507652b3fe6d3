//! Colors and sizes of all pages, in a dark and a light theme. All grays are neutral. A session is always dark, so that
//! pages between trials do not change the eye's adaptation.

use eframe::egui::{
    self, Color32, CornerRadius, FontFamily, FontId, Stroke, Style, TextStyle, Theme, Ui, Vec2, Visuals,
    style::HandleShape,
};
use egui_plot::MarkerShape;

use crate::report::figures::palette::{ON_DARK, ON_WHITE, Rgb};

/// The spacing scale, points: between the parts of a line, between lines, between groups, and around a page of text.
pub const SMALL_GAP: f32 = 4.0;
pub const GAP: f32 = 8.0;
pub const LARGE_GAP: f32 = 16.0;
pub const MARGIN: f32 = 24.0;
/// Maximum width of a line of running text, points.
pub const COLUMN: f32 = 680.0;
/// The background of a session's pages and of the screens that measure the display, in both themes.
pub const DARK_PAGE: Color32 = DARK.page;

/// The colors of a theme that egui's own style does not have.
#[derive(Debug)]
pub struct Ink {
    /// Background of a page.
    pub page: Color32,
    /// Background of a card, a side bar and a dialog.
    pub card: Color32,
    /// Outline of a card.
    pub outline: Color32,
    /// Body text.
    pub text: Color32,
    /// Secondary text; its contrast with the page is at least 7:1.
    pub secondary: Color32,
    /// Errors.
    pub error: Color32,
    /// Notes that deserve attention.
    pub note: Color32,
    /// Success messages, and checks that passed.
    pub success: Color32,
    /// The main button of a page, which has black text.
    pub primary: Color32,
    /// Predicted bands.
    pub band: Color32,
    /// Colors of the series in a plot: the colors of the figures.
    pub series: [Color32; 7],
    /// Colors of the left and right images in a comparison.
    pub sides: [Color32; 2],
}

impl Ink {
    /// Returns the color and marker of a series. Once all colors have been used, they repeat with other markers.
    pub fn series(&self, index: usize) -> (Color32, MarkerShape) {
        let colors = self.series.len();
        (self.series[index % colors], MARKERS[(index + index / colors) % MARKERS.len()])
    }
}

const DARK: Ink = Ink {
    page: Color32::from_gray(0x22),
    card: Color32::from_gray(0x2c),
    outline: Color32::from_gray(0x40),
    text: Color32::from_gray(0xec),
    secondary: Color32::from_gray(0xb4),
    error: Color32::from_rgb(0xff, 0xa0, 0x80),
    note: Color32::from_rgb(0xe8, 0xc8, 0x60),
    success: Color32::from_rgb(0x90, 0xd0, 0xa0),
    primary: Color32::from_rgb(0xe8, 0xd0, 0x70),
    band: Color32::from_rgb(0xe0, 0x90, 0xc0),
    series: colors(ON_DARK),
    sides: [colors(ON_DARK)[1], Color32::from_rgb(0xe8, 0xc8, 0x60)],
};

const LIGHT: Ink = Ink {
    page: Color32::from_gray(0xee),
    card: Color32::from_gray(0xfa),
    outline: Color32::from_gray(0xc8),
    text: Color32::from_gray(0x18),
    secondary: Color32::from_gray(0x46),
    error: Color32::from_rgb(0x9c, 0x22, 0x0c),
    note: Color32::from_rgb(0x6c, 0x48, 0x00),
    success: Color32::from_rgb(0x12, 0x56, 0x2c),
    primary: Color32::from_rgb(0xf0, 0xc8, 0x48),
    band: Color32::from_rgb(0xa0, 0x30, 0x78),
    series: colors(ON_WHITE),
    sides: [colors(ON_WHITE)[1], colors(ON_WHITE)[2]],
};

/// Markers of the series of a plot. Each is different, so that readers need not distinguish colors.
const MARKERS: [MarkerShape; 7] = [
    MarkerShape::Circle,
    MarkerShape::Square,
    MarkerShape::Diamond,
    MarkerShape::Up,
    MarkerShape::Down,
    MarkerShape::Cross,
    MarkerShape::Plus,
];

const fn colors(palette: [Rgb; 7]) -> [Color32; 7] {
    let mut colors = [Color32::BLACK; 7];
    let mut index = 0;
    while index < colors.len() {
        let Rgb(r, g, b) = palette[index];
        colors[index] = Color32::from_rgb(r, g, b);
        index += 1;
    }
    colors
}

/// Returns the colors of a theme.
pub fn ink_of(visuals: &Visuals) -> &'static Ink {
    if visuals.dark_mode { &DARK } else { &LIGHT }
}

/// Returns the colors of the theme in use.
pub fn ink(ui: &Ui) -> &'static Ink {
    ink_of(ui.visuals())
}

/// Sets the style of all pages; called once.
pub fn apply(ctx: &egui::Context) {
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| {
            sizes(style);
            visuals(&mut style.visuals);
        });
    }
}

fn sizes(style: &mut Style) {
    style.text_styles = [
        (TextStyle::Heading, 26.0),
        (TextStyle::Body, 16.0),
        (TextStyle::Button, 16.0),
        (TextStyle::Small, 14.0),
        (TextStyle::Monospace, 15.0),
    ]
    .map(|(name, size)| {
        let family = if name == TextStyle::Monospace { FontFamily::Monospace } else { FontFamily::Proportional };
        (name, FontId::new(size, family))
    })
    .into();
    style.spacing.item_spacing = Vec2::new(10.0, GAP);
    style.spacing.button_padding = Vec2::new(12.0, 6.0);
    style.spacing.interact_size.y = 32.0;
    style.spacing.icon_width = 18.0;
    style.spacing.icon_width_inner = 11.0;
    style.spacing.text_edit_width = 300.0;
    // A scroll bar that can be seen says that there is more.
    style.spacing.scroll.dormant_handle_opacity = 0.6;
}

fn visuals(visuals: &mut Visuals) {
    let ink = ink_of(visuals);
    let [field, raised, line, hovered, strong] = if visuals.dark_mode {
        [0x14, 0x40, 0x68, 0xa0, 0xff].map(Color32::from_gray)
    } else {
        [0xff, 0xe0, 0x8c, 0x58, 0x00].map(Color32::from_gray)
    };
    // The window is cleared to the color of the page, so no page draws its background again.
    visuals.panel_fill = Color32::TRANSPARENT;
    visuals.window_fill = ink.card;
    visuals.window_stroke = Stroke::new(1.0, ink.outline);
    visuals.extreme_bg_color = field;
    visuals.faint_bg_color = ink.card;
    visuals.override_text_color = Some(ink.text);
    visuals.weak_text_color = Some(ink.secondary);
    visuals.error_fg_color = ink.error;
    visuals.warn_fg_color = ink.note;
    visuals.handle_shape = HandleShape::Circle;
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, ink.outline);
    widgets.inactive.bg_fill = raised;
    widgets.inactive.weak_bg_fill = raised;
    widgets.inactive.bg_stroke = Stroke::new(1.0, line);
    // Check marks and radio buttons are drawn in this color.
    widgets.inactive.fg_stroke = Stroke::new(2.0, ink.text);
    widgets.hovered.bg_stroke = Stroke::new(1.0, hovered);
    widgets.hovered.fg_stroke = Stroke::new(2.0, strong);
    // The control with keyboard focus stands out more than the control under the mouse.
    widgets.active.bg_stroke = Stroke::new(2.5, strong);
    widgets.active.fg_stroke = Stroke::new(2.0, strong);
    (visuals.selection.bg_fill, visuals.selection.stroke) = if visuals.dark_mode {
        (Color32::from_rgb(0x4a, 0x5a, 0x80), Stroke::new(2.0, Color32::from_rgb(0xc8, 0xd8, 0xff)))
    } else {
        (Color32::from_rgb(0xb8, 0xcc, 0xf0), Stroke::new(2.0, Color32::from_rgb(0x10, 0x38, 0x80)))
    };
    let corners = CornerRadius::same(4);
    for widget in [&mut widgets.noninteractive, &mut widgets.inactive, &mut widgets.hovered, &mut widgets.active] {
        widget.corner_radius = corners;
    }
}

/// Uses smaller text and spacing, for pages with many controls and for small windows.
pub fn compact(ui: &mut Ui) {
    let style = ui.style_mut();
    for (name, size) in [(TextStyle::Body, 15.0), (TextStyle::Button, 15.0), (TextStyle::Small, 13.0)] {
        if let Some(font) = style.text_styles.get_mut(&name) {
            font.size = size;
        }
    }
    style.spacing.item_spacing = Vec2::new(8.0, 5.0);
    style.spacing.button_padding = Vec2::new(8.0, 3.0);
    style.spacing.interact_size.y = 26.0;
}

/// Returns the frame of a card: a group of things that belong together.
pub fn card(ui: &Ui) -> egui::Frame {
    let ink = ink(ui);
    egui::Frame::NONE.fill(ink.card).stroke(Stroke::new(1.0, ink.outline)).corner_radius(8.0).inner_margin(12.0)
}
