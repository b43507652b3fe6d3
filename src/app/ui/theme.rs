//! Colors, sizes and icons of all pages, in a dark and a light theme; they stand only here. All grays are neutral. A session is always dark, so that
//! pages between trials do not change the eye's adaptation.

use eframe::egui::{
    self, Button, Color32, ComboBox, CornerRadius, FontFamily, FontId, Rect, Sense, Shadow, Shape, Stroke, StrokeKind,
    Style, TextStyle, Theme, Ui, Vec2, Visuals,
    class::HasClasses as _,
    style::{HandleShape, ScrollAnimation},
    theme::{DefaultStyle, StyleProvider},
    widget_style::{ButtonStyle, StyleArgs, WidgetState},
};
use egui_plot::MarkerShape;

use crate::report::figures::palette::{ON_DARK, ON_WHITE, Rgb};

/// The spacing scale, points: between the parts of a line, between controls, between groups, and around a page.
pub const SMALL_GAP: f32 = 4.0;
pub const GAP: f32 = 8.0;
pub const LARGE_GAP: f32 = 16.0;
pub const MARGIN: f32 = 24.0;
/// The type scale, points: the one key number of a card, the title of a page, the heading of a section, body text and
/// controls, and notes and labels. There is one weight; emphasis is size and brightness.
pub const KEY: f32 = 34.0;
pub const TITLE: f32 = 26.0;
pub const SECTION: f32 = 18.0;
pub const BODY: f32 = 15.0;
pub const NOTE: f32 = 13.0;
/// Opacity of what a newer result is about to replace.
pub const STALE: f32 = 0.6;
/// Height of a control, of the main button of a session's page, of a row in a table, and of the line that keeps room for
/// a message, points.
pub const CONTROL: f32 = 32.0;
pub const BIG_CONTROL: f32 = 40.0;
pub const ROW: f32 = 28.0;
pub const MESSAGE: f32 = 24.0;
/// Side of an icon, points.
pub const ICON: f32 = 16.0;
/// Maximum width of a line of running text, points.
pub const COLUMN: f32 = 680.0;
/// Maximum width of a page of cards and forms, points.
pub const CONTENT: f32 = 1560.0;
/// In a window narrower than this, in points, the side bar shows only icons, and columns are narrower.
pub const WIDE: f32 = 1440.0;
/// In a window narrower than this, in points, a page has one column.
pub const NARROW: f32 = 900.0;
/// The background of a session's pages and of the screens that measure the display, in both themes.
pub const DARK_PAGE: Color32 = DARK.page;

/// Marks on a picture, in both themes: light and dark strokes, the fill of a knob, and a shade under text.
pub const MARK: Color32 = gray(0xe0);
pub const MARK_LINE: Color32 = gray(0x80);
pub const MARK_DARK: Color32 = gray(0x20);
pub const KNOB: [Color32; 2] = [gray(0x30), gray(0xc0)];
pub const SHADE: Color32 = Color32::from_black_alpha(150);

/// Grid lines of a plot: a translucent gray, fainter than any curve in both themes.
pub const GRID: Color32 = Color32::from_rgba_premultiplied(0x1c, 0x1c, 0x1c, 0x38);

macro_rules! inks {
    ($($(#[$doc:meta])* $role:ident $dark:expr, $light:expr;)*) => {
        /// The colors of a theme.
        #[derive(Debug)]
        pub struct Ink {
            $($(#[$doc])* pub $role: Color32,)*
        }

        const DARK: Ink = Ink { $($role: $dark,)* };
        const LIGHT: Ink = Ink { $($role: $light,)* };
    };
}

// The role of each color, in the dark and in the light theme.
inks! {
    /// Background of the side bar and the status line.
    rail gray(0x1a), gray(0xe4);
    /// Background of a page.
    page gray(0x22), gray(0xee);
    /// Background of a card, a dialog and a filled cell.
    card gray(0x2a), gray(0xfa);
    /// Buttons and selected rows; the same under the pointer; pressed buttons and chosen segments.
    raised gray(0x38), gray(0xd8);
    hover gray(0x44), gray(0xcc);
    active gray(0x50), gray(0xc0);
    /// Inside of a text field, and the track of a slider or a bar.
    field gray(0x16), gray(0xff);
    /// Outline of a card, and dividers.
    line gray(0x3c), gray(0xd0);
    /// Outline of a field or check box; its contrast with page and card is at least 3:1.
    edge gray(0x7c), gray(0x7a);
    /// Titles, key words, and the focus ring.
    ink gray(0xff), gray(0x00);
    /// Body text.
    text gray(0xe6), gray(0x1c);
    /// Labels, notes and axes; the contrast with page and card is at least 7:1.
    dim gray(0xb8), gray(0x4a);
    /// Disabled controls and what is only planned.
    off gray(0x92), gray(0x68);
    /// The main button of a page, and the mark of the current place; the text on it.
    accent Color32::from_rgb(0xe8, 0xd0, 0x70), Color32::from_rgb(0xf0, 0xc8, 0x48);
    on_accent gray(0x14), gray(0x14);
    /// The main button beside a stimulus, where nothing may be colored, and in sessions; the text on it.
    neutral gray(0xd8), gray(0x33);
    on_neutral gray(0x14), gray(0xff);
    /// Unfinished things and notes that deserve attention.
    warn Color32::from_rgb(0xe8, 0xc8, 0x60), Color32::from_rgb(0x6c, 0x48, 0x00);
    /// Errors and failed checks.
    bad Color32::from_rgb(0xff, 0x9c, 0x80), Color32::from_rgb(0x9c, 0x22, 0x0c);
    /// Passed checks.
    good Color32::from_rgb(0x90, 0xd0, 0xa0), Color32::from_rgb(0x12, 0x56, 0x2c);
    /// What lies behind a dialog is covered with this color.
    veil Color32::from_black_alpha(160), Color32::from_black_alpha(96);
    /// Every second row of a table.
    stripe Color32::from_rgba_premultiplied(18, 18, 18, 18), Color32::from_black_alpha(14);
}

impl Ink {
    /// Returns the colors of the left and the right image, or of a solid and a dashed line, beside a stimulus.
    pub fn sides(&self) -> [Color32; 2] {
        [self.ink, self.dim]
    }
}

const fn gray(code: u8) -> Color32 {
    Color32::from_gray(code)
}

/// Returns the color and marker of a series in a plot: the colors of the figures. Once all have been used, they repeat
/// with other markers.
pub fn series(dark: bool, index: usize) -> (Color32, MarkerShape) {
    let colors = if dark { ON_DARK } else { ON_WHITE };
    let markers: Vec<_> = MarkerShape::all().collect();
    (color(colors[index % colors.len()]), markers[(index + index / colors.len()) % markers.len()])
}

/// Returns a color of the figures.
pub const fn color(Rgb(r, g, b): Rgb) -> Color32 {
    Color32::from_rgb(r, g, b)
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
    ctx.add_widget_theme::<ButtonStyle>(Buttons);
    // A new panel takes one pass to be measured, and its lower edge another.
    ctx.options_mut(|options| options.max_passes = 3.try_into().unwrap_or(options.max_passes));
}

/// Buttons have no outline; lists to choose from look like the fields that they are.
struct Buttons;

impl StyleProvider<ButtonStyle> for Buttons {
    fn style(&mut self, args: &StyleArgs<'_>) -> ButtonStyle {
        let mut button = StyleProvider::<ButtonStyle>::style(&mut DefaultStyle, args);
        let ink = ink_of(&args.style.visuals);
        let frame = &mut button.atom_layout.frame;
        if args.classes.has_class(&ComboBox::CLASS) {
            frame.fill = ink.field;
        } else if args.state != WidgetState::Active && (frame.stroke.color == ink.edge || frame.stroke.color == ink.bad)
        {
            frame.stroke.color = Color32::TRANSPARENT;
        }
        if args.classes.has_class(&Button::CLASS_SELECTED) {
            frame.fill = ink.active;
        }
        button
    }
}

fn sizes(style: &mut Style) {
    style.text_styles = [
        (TextStyle::Heading, TITLE),
        (TextStyle::Body, BODY),
        (TextStyle::Button, BODY),
        (TextStyle::Small, NOTE),
        (TextStyle::Monospace, NOTE),
    ]
    .map(|(name, size)| {
        let family = if name == TextStyle::Monospace { FontFamily::Monospace } else { FontFamily::Proportional };
        (name, FontId::new(size, family))
    })
    .into();
    style.spacing.item_spacing = Vec2::new(GAP, SMALL_GAP);
    // With the height of body text, this is the height of a control.
    style.spacing.button_padding = Vec2::new(12.0, 7.0);
    style.spacing.interact_size.y = CONTROL;
    style.spacing.indent = LARGE_GAP;
    style.spacing.icon_width = ICON;
    style.spacing.icon_width_inner = 10.0;
    style.spacing.text_edit_width = 280.0;
    style.spacing.slider_rail_height = SMALL_GAP;
    style.animation_time = 0.0;
    style.scroll_animation = ScrollAnimation::none();
    // A scroll bar that can be seen says that there is more.
    style.spacing.scroll.dormant_handle_opacity = 0.6;
    // It lies beside what it scrolls, not on it.
    style.spacing.scroll.floating_allocated_width = GAP;
}

fn visuals(visuals: &mut Visuals) {
    let ink = ink_of(visuals);
    // The window is cleared to the color of the page, so no page draws its background again.
    visuals.panel_fill = Color32::TRANSPARENT;
    visuals.window_fill = ink.card;
    visuals.window_stroke = Stroke::new(1.0, ink.edge);
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.menu_corner_radius = CornerRadius::same(6);
    visuals.window_shadow = Shadow::NONE;
    visuals.popup_shadow = Shadow::NONE;
    visuals.extreme_bg_color = ink.field;
    visuals.faint_bg_color = ink.stripe;
    visuals.override_text_color = Some(ink.text);
    visuals.weak_text_color = Some(ink.dim);
    visuals.error_fg_color = ink.bad;
    visuals.warn_fg_color = ink.warn;
    visuals.handle_shape = HandleShape::Circle;
    // What is disabled can still be read.
    visuals.disabled_alpha = 0.65;
    // In the light theme, an empty track is hardly visible.
    visuals.slider_trailing_fill = true;
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, ink.line);
    for (widget, fill, stroke) in [
        (&mut widgets.inactive, ink.raised, Stroke::new(1.0, ink.edge)),
        (&mut widgets.hovered, ink.hover, Stroke::new(1.0, ink.edge)),
        // The control with keyboard focus stands out more than the control under the mouse.
        (&mut widgets.active, ink.active, Stroke::new(2.0, ink.ink)),
        (&mut widgets.open, ink.active, Stroke::new(1.0, ink.edge)),
    ] {
        widget.weak_bg_fill = fill;
        widget.bg_stroke = stroke;
        // Check marks and radio buttons are drawn in this color.
        widget.fg_stroke = Stroke::new(1.5, ink.ink);
        widget.expansion = 0.0;
        widget.corner_radius = CornerRadius::same(4);
        // The track of a slider, and the inside of a check box.
        widget.bg_fill = ink.field;
    }
    widgets.inactive.fg_stroke.color = ink.text;
    visuals.selection.bg_fill = ink.active;
    visuals.selection.stroke = Stroke::new(2.0, ink.ink);
    widgets.noninteractive.corner_radius = CornerRadius::same(4);
}

/// Uses smaller controls, for pages with many of them and for small windows.
pub fn compact(ui: &mut Ui) {
    let style = ui.style_mut();
    style.spacing.button_padding = Vec2::new(8.0, 3.0);
    style.spacing.interact_size.y = 26.0;
}

/// Outlines the fields that follow: what is in them is wrong.
pub fn outline_wrong(ui: &mut Ui) {
    let bad = ink(ui).bad;
    let visuals = ui.visuals_mut();
    let widgets = &mut visuals.widgets;
    for widget in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active, &mut widgets.open] {
        widget.bg_stroke.color = bad;
    }
    visuals.selection.stroke.color = bad;
}

/// Draws the ring around a control that has the keyboard focus, for one that does not draw its own.
pub fn focus_ring(ui: &Ui, response: &egui::Response) {
    if response.has_focus() && !ui.ctx().text_edit_focused() {
        // The response of a slider also has the place of its number.
        let rect = ui.ctx().read_response(response.id).map_or(response.rect, |own| own.rect);
        let ring = Stroke::new(2.0, ink(ui).ink);
        ui.painter().rect_stroke(rect.expand(1.0), 5.0, ring, StrokeKind::Outside);
    }
}

/// Returns the frame of a card: a group of things that belong together.
pub fn card(ui: &Ui) -> egui::Frame {
    let ink = ink(ui);
    egui::Frame::NONE.fill(ink.card).stroke(Stroke::new(1.0, ink.line)).corner_radius(6.0).inner_margin(12.0)
}

macro_rules! icons {
    ($($name:ident $path:literal)*) => {
        /// A picture of an action, a place or a state: polylines and circles on a square of [`ICON`] points.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Icon {
            $($name,)*
        }

        impl Icon {
            /// Returns the lines and circles of the icon: `X Y` for each point of a line, followed by `Z` if it is closed,
            /// and `X Y RADIUS` for a circle; parts are separated by `|`.
            const fn path(self) -> &'static str {
                match self {
                    $(Self::$name => $path,)*
                }
            }
        }
    };
}

icons! {
    Studies "2 2 7 2 7 7 2 7Z|9 2 14 2 14 7 9 7Z|2 9 7 9 7 14 2 14Z|9 9 14 9 14 14 9 14Z"
    Stimuli "2 2 14 2 14 14 2 14Z|2 11 6 11 10 5 14 5"
    Shading "8 8 6|9.2 2.2 11.2 4.8 11.9 8 11.2 11.2 9.2 13.8"
    Display "1.5 3 14.5 3 14.5 11.5 1.5 11.5Z|8 11.5 8 14|5 14 11 14"
    Analyze "2 2 2 14 14 14|5 10 8 6.5 10.5 8.5 14 4"
    Settings "2 4 14 4|2 12 14 12|6 4 2|10 12 2"
    Help "8 8 6.25|6 6.5 6.5 5.4 8 5 9.5 5.4 10 6.5 9.4 7.6 8 8.6 8 9.4|8 11.4 8 11.5"
    Play "5 3 12.5 8 5 13Z"
    Resume "3.5 3 3.5 13|7 3 13.5 8 7 13Z"
    Pilot "1.5 8 4 8 6 3 9.5 13 11.5 8 14.5 8"
    Check "3 8.5 6.5 12 13 4.5"
    Out "8 10 8 2|5 5 8 2 11 5|3 9 3 14 13 14 13 9"
    Folder "1.5 4 6 4 7.5 5.5 14.5 5.5 14.5 13 1.5 13Z"
    Edit "3 13 3.6 10 11 2.6 13.4 5 6 12.4Z"
    More "3.5 8 .8|8 8 .8|12.5 8 .8"
    Plus "8 3 8 13|3 8 13 8"
    Down "4.5 6.5 8 10 11.5 6.5"
    Warn "8 2 14.5 13.5 1.5 13.5Z|8 6.5 8 9.5|8 11.4 8 11.5"
    Close "4 4 12 12|12 4 4 12"
    Done "8 8 6|5 8.3 7.2 10.5 11 6"
    None "8 8 6"
    Part "8 8 6|8 2 8 8 12 12.2"
    People "8 5 3|2.5 14 4.5 10.5 11.5 10.5 13.5 14"
    Rating "5 1 11 1 11 7 5 7Z|1 11 4 11 4 14 1 14Z|6.5 11 9.5 11 9.5 14 6.5 14Z|12 11 15 11 15 14 12 14Z"
    Choice "1 4.5 6 4.5 6 9.5 1 9.5Z|10 4.5 15 4.5 15 9.5 10 9.5Z|7 7 9 7"
    YesNo "5 1 11 1 11 7 5 7Z|2 11 7 11 7 14 2 14Z|9 11 14 11 14 14 9 14Z"
    Pair "1 2 7 2 7 8 1 8Z|9 2 15 2 15 8 9 8Z|3 12 5 12|11 12 13 12"
    Adjust "5 1 11 1 11 7 5 7Z|1 12.5 7.5 12.5|10.5 12.5 15 12.5|9 12.5 1.5"
}

impl Icon {
    /// Draws the icon in a square.
    pub fn paint(self, painter: &egui::Painter, rect: Rect, color: Color32) {
        let scale = rect.width() / ICON;
        let stroke = Stroke::new(1.5 * scale, color);
        let at = |x: f32, y: f32| rect.min + scale * Vec2::new(x, y);
        for part in self.path().split('|') {
            let numbers: Vec<f32> = part.split([' ', 'Z']).filter_map(|number| number.parse().ok()).collect();
            match numbers[..] {
                [x, y, radius] => _ = painter.circle_stroke(at(x, y), scale * radius, stroke),
                _ => {
                    let points = numbers.as_chunks().0.iter().map(|[x, y]| at(*x, *y)).collect();
                    let is_closed = part.ends_with('Z');
                    painter.add(if is_closed {
                        Shape::closed_line(points, stroke)
                    } else {
                        Shape::line(points, stroke)
                    });
                }
            }
        }
    }

    /// Returns the icon as a part of a button.
    pub fn atom<'a>(self, color: Color32) -> egui::Atom<'a> {
        egui::Atom::paint(Vec2::splat(ICON), move |ui, args| self.paint(ui.painter(), args.rect, color))
    }

    /// Draws the icon in line with text.
    pub fn show(self, ui: &mut Ui, color: Color32) {
        let (rect, _) = ui.allocate_exact_size(Vec2::splat(ICON), Sense::hover());
        self.paint(ui.painter(), rect, color);
    }
}
