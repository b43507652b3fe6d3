//! The places of the program, and the bar at the left edge that leads to them.

use eframe::egui::{self, Color32, Frame, Key, KeyboardShortcut, Modifiers, Panel, Rect, RichText, Ui, Vec2};

use super::{
    page::filled_with,
    pixels::logo,
    theme::{CONTROL, GAP, Icon, SECTION, SMALL_GAP, WIDE, ink},
};

/// Width of the bar with words, and with only icons, points.
const WIDTHS: [f32; 2] = [176.0, 56.0];

/// A place of the program. Each keeps its state when the user goes to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// The studies, their sessions, and the form that starts one.
    #[default]
    Studies,
    Analyze,
    Stimuli,
    Shading,
    Display,
}

/// The dialog above the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SideDialog {
    Help,
    Settings,
}

impl Place {
    const ALL: [(Self, Icon, &str, &str, Key); 5] = [
        (Self::Studies, Icon::Studies, "Studies", "Choose a study, start or resume a session.", Key::Num1),
        (Self::Analyze, Icon::Analyze, "Analyze", "Open ratings and see the results.", Key::Num2),
        (Self::Stimuli, Icon::Stimuli, "Stimuli", "See, predict and export every stimulus.", Key::Num3),
        (Self::Shading, Icon::Shading, "Shading", "Compare shaders on a mesh, with and without bands.", Key::Num4),
        (Self::Display, Icon::Display, "Display", "Measure the size, light and timing of this screen.", Key::Num5),
    ];

    /// Returns whether the page shows stimuli, beside which nothing is colored.
    pub fn shows_stimuli(self) -> bool {
        matches!(self, Self::Stimuli | Self::Shading | Self::Display)
    }
}

/// Draws the bar; returns the place that was chosen with a click or with its keys. A dialog that was chosen opens.
pub fn side_bar(ui: &mut Ui, here: Place, dialog: &mut Option<SideDialog>) -> Option<Place> {
    let narrow = ui.available_width() < WIDE;
    let frame = Frame::NONE.fill(ink(ui).rail).inner_margin(GAP);
    let bar = Panel::left("places").resizable(false).show_separator_line(false);
    bar.exact_size(WIDTHS[usize::from(narrow)])
        .frame(frame)
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = SMALL_GAP;
            ui.add_space(SMALL_GAP);
            ui.horizontal(|ui| {
                ui.add_space(SMALL_GAP);
                logo(ui, 24.0, here.shows_stimuli());
                if !narrow {
                    ui.label(RichText::new("machband").strong().size(SECTION));
                }
            });
            ui.add_space(GAP);
            let mut choice = None;
            for (place, icon, title, about, key) in Place::ALL {
                let shortcut = KeyboardShortcut::new(Modifiers::COMMAND, key);
                let hover = format!("{title}. {about} ({})", ui.ctx().format_shortcut(&shortcut));
                let clicked =
                    item(ui, icon, title, narrow, (place == here).then_some(here)).on_hover_text(hover).clicked();
                if clicked || ui.input_mut(|input| input.consume_shortcut(&shortcut)) {
                    choice = Some(place);
                }
            }
            // The other two are at the lower edge.
            ui.add_space((ui.available_height() - 2.0 * (CONTROL + SMALL_GAP) - SMALL_GAP).max(0.0));
            let settings = item(ui, Icon::Settings, "Settings", narrow, None);
            if settings.on_hover_text("Settings: theme and size of the window.").clicked() {
                *dialog = Some(SideDialog::Settings);
            }
            let help = item(ui, Icon::Help, "Help", narrow, None);
            let help = help.on_hover_text("Help: the keys of this page, and about machband (F1).");
            if help.clicked() || ui.input(|input| input.key_pressed(Key::F1)) {
                *dialog = Some(SideDialog::Help);
            }
            choice
        })
        .inner
}

/// Draws a place. `here`: this is the current place.
fn item(ui: &mut Ui, icon: Icon, title: &str, narrow: bool, here: Option<Place>) -> egui::Response {
    let ink = ink(ui);
    let (fill, color) = if here.is_some() { (ink.raised, ink.ink) } else { (Color32::TRANSPARENT, ink.text) };
    let mut atoms = egui::Atoms::new(icon.atom(color));
    if !narrow {
        atoms.push_right(RichText::new(title).color(color));
        atoms.push_right(egui::Atom::grow());
    }
    let size = Vec2::new(ui.available_width(), CONTROL + SMALL_GAP);
    let response = ui.add(filled_with(egui::Button::new(atoms), fill).min_size(size));
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, here.is_some(), title));
    if let Some(here) = here {
        let size = Vec2::new(2.0, response.rect.height() - 2.0 * GAP);
        let mark = Rect::from_min_size(response.rect.left_top() + Vec2::new(0.0, GAP), size);
        ui.painter().rect_filled(mark, 1.0, if here.shows_stimuli() { ink.neutral } else { ink.accent });
    }
    response
}
