//! The places of the program, and the bar at the left edge that leads to them.

use eframe::egui::{self, Align, Button, Frame, Key, KeyboardShortcut, Layout, Modifiers, Panel, RichText, Ui};

use super::{
    logo::logo,
    text::name,
    theme::{self, GAP, LARGE_GAP, SMALL_GAP, ink},
};

/// Width of the bar, points, and its width in a window that is narrower than [`NARROW`].
const WIDTHS: [f32; 2] = [140.0, 96.0];
const NARROW: f32 = 900.0;

/// A place of the program. Each keeps its state when the user goes to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// Experiments, sessions, and the form that starts one.
    #[default]
    Run,
    Stimuli,
    Shading,
    Display,
    Analyze,
}

/// What the user chose in the bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SideChoice {
    Go(Place),
    Help,
    Settings,
}

impl Place {
    const ALL: [(Self, &str, &str, Key); 5] = [
        (Self::Run, "Run", "Choose an experiment, start or resume a session.", Key::Num1),
        (Self::Stimuli, "Stimuli", "See, predict and export every stimulus.", Key::Num2),
        (Self::Shading, "Shading", "Compare shaders on a mesh, with and without bands.", Key::Num3),
        (Self::Display, "Display", "Measure the size, the luminance and the timing of this screen.", Key::Num4),
        (Self::Analyze, "Analyze", "Open ratings and see the results.", Key::Num5),
    ];
}

/// Draws the bar; returns what was chosen with a click or with its keys.
pub fn side_bar(ui: &mut Ui, here: Place) -> Option<SideChoice> {
    let narrow = ui.available_width() < NARROW;
    let frame = Frame::NONE.fill(ink(ui).card).inner_margin(GAP);
    let bar = Panel::left("places").resizable(false).exact_size(WIDTHS[usize::from(narrow)]).frame(frame);
    bar.show(ui, |ui| {
        if narrow {
            theme::compact(ui);
        }
        ui.spacing_mut().item_spacing.y = SMALL_GAP;
        ui.horizontal(|ui| {
            logo(ui, 28.0);
            if !narrow {
                ui.label(RichText::new("machband").strong().size(18.0));
            }
        });
        ui.add_space(if narrow { SMALL_GAP } else { LARGE_GAP });
        let mut choice = None;
        for (place, title, about, key) in Place::ALL {
            let shortcut = KeyboardShortcut::new(Modifiers::COMMAND, key);
            let hover = format!("{about} ({})", ui.ctx().format_shortcut(&shortcut));
            let clicked = item(ui, title, place == here).on_hover_text(hover).clicked();
            if clicked || ui.input_mut(|input| input.consume_shortcut(&shortcut)) {
                choice = Some(SideChoice::Go(place));
            }
        }
        ui.with_layout(Layout::bottom_up(Align::Min), |ui| {
            let help = item(ui, "Help", false).on_hover_text("Keys of this page, and about machband (F1).");
            if help.clicked() || ui.input(|input| input.key_pressed(Key::F1)) {
                choice = Some(SideChoice::Help);
            }
            if item(ui, "Settings", false).on_hover_text("Theme and size of the window.").clicked() {
                choice = Some(SideChoice::Settings);
            }
        });
        choice
    })
    .inner
}

fn item(ui: &mut Ui, title: &str, selected: bool) -> egui::Response {
    let text = if selected { RichText::new(title).strong() } else { RichText::new(title) };
    let height = ui.spacing().interact_size.y + 4.0;
    let button = Button::selectable(selected, text).min_size(egui::vec2(ui.available_width(), height)).truncate();
    let response = ui.add(button);
    name(ui, &response, title);
    response
}
