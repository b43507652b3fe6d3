//! The fields for the screen, which stand on the page *Display* and in the dialog of a session: the viewing distance, the
//! width, which a bank card can measure, and the display profile.

use std::path::Path;

use eframe::egui::{self, ScrollArea, Sense, Stroke, TextEdit, Vec2};

use super::calibrate::LABELS;
use crate::{
    app::{
        session::{room, stimulus_side_px},
        ui::{
            Field, FileKind, Monitor, ScreenFields, Step, modal, neutral_primary, number,
            platform::Platform,
            secondary, show_error,
            theme::{COLUMN, ink},
            today,
            work::Kept,
        },
    },
    display::{
        DisplayProfile, Screen, Viewing,
        geometry::{CARD_WIDTH_CM, width_cm_from_card},
    },
    experiment::Protocol,
    report::names::capitalized,
    store::profile,
};

/// What the fields for the screen say about it.
#[derive(Debug)]
pub struct CheckedScreen {
    /// The display profile, or what is wrong with it; sRGB if no profile is given.
    pub profile: Result<DisplayProfile, String>,
    /// The geometry, if the distance and the width are possible.
    pub viewing: Option<Viewing>,
    /// Side of the stimulus on this screen, physical pixels.
    pub stimulus_px: Option<u32>,
    /// How large a degree and the stimulus are, and whether the stimulus is too coarse.
    size: (String, bool),
    /// What is wrong with the distance and with the width; empty if nothing is.
    errors: [String; 2],
}

impl CheckedScreen {
    /// Checks the fields for a monitor, on which the stimulus of the definition must have room.
    pub fn new(fields: &ScreenFields, monitor: &Monitor, protocol: Option<&Protocol>) -> Self {
        let profile = match fields.profile.trim() {
            "" => Ok(DisplayProfile::default()),
            path => profile::open(Path::new(path)).map_err(|error| error.to_string()),
        };
        let centimeters = |typed: &str, example: &str| {
            number(typed).ok_or_else(|| format!("Enter a number of centimeters, e.g. {example}."))
        };
        let distance = centimeters(&fields.distance_cm, "57");
        let width = match fields.width_is_assumed() {
            true => Ok(monitor.assumed_width_cm()),
            false => centimeters(&fields.screen_width_cm, "53.1"),
        };
        let viewing = match width.and_then(|cm| Screen::new(monitor.width_px, monitor.height_px, cm)) {
            Ok(screen) => distance.and_then(|cm| Viewing::new(screen, cm)).map_err(|error| [error, String::new()]),
            Err(error) => Err([distance.err().unwrap_or_default(), error]),
        };
        let viewing = match viewing {
            Ok(viewing) => viewing,
            Err(errors) => {
                let errors = errors.map(|error| capitalized(&error));
                return Self { profile, viewing: None, stimulus_px: None, size: Default::default(), errors };
            }
        };
        let per_degree = viewing.px_per_degree();
        let cm = per_degree / viewing.screen().px_per_cm();
        let mut size = (format!("One degree is {cm:.2} cm, {per_degree:.1} pixels."), false);
        let (mut errors, mut stimulus_px) = (<[String; 2]>::default(), None);
        if let Some(protocol) = protocol {
            let side = stimulus_side_px(&viewing, protocol);
            let screen = [monitor.width_px, monitor.height_px];
            if let Err(error) = room(protocol, side, monitor.scale, "screen", screen) {
                errors[0] = error + " Enter a shorter distance, or use a larger screen.";
            }
            size.0 += &format!(" The study's stimulus is {side} pixels wide.");
            size = viewing.coarseness(protocol.viewing.window_deg).map_or(size, |coarse| (coarse, true));
            stimulus_px = Some(side);
        }
        Self { profile, viewing: Some(viewing), stimulus_px, size, errors }
    }

    /// Returns whether nothing is wrong.
    pub fn is_right(&self) -> bool {
        self.profile.is_ok() && self.errors.iter().all(String::is_empty)
    }
}

/// The fields for the screen, and the dialog that measures its width.
#[derive(Default)]
pub struct ScreenForm {
    card: Option<Card>,
    /// The width in cm that the screen with this title reports, if any.
    reported_cm: Kept<String, Option<f64>>,
}

impl ScreenForm {
    /// Draws the fields, with their labels in a column of this width, points.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        labels: f32,
        fields: &mut ScreenFields,
        monitor: &Monitor,
        checked: &CheckedScreen,
    ) {
        let ([of_distance, of_width], (size, is_coarse)) = (&checked.errors, &checked.size);
        let field = |label| Field::new(label).column(labels).slot();
        let distance = field("Viewing distance, cm").error(of_distance).note(size, *is_coarse);
        distance.hint("from eye to screen").text(ui, &mut fields.distance_cm);
        let assumption = if fields.width_is_assumed() { monitor.assumption() + "." } else { String::new() };
        let width = field("Screen width, cm").error(of_width).note(&assumption, true);
        width.show(ui, |ui, label| ui.horizontal_wrapped(|ui| self.width(ui, label, fields, monitor)));
        let (told, warns) = match &checked.profile {
            Ok(profile) => match profile.warning(today()) {
                Some(warning) => (format!("{}. {warning}", profile.sentence()), true),
                None => (format!("{}.", profile.sentence()), false),
            },
            Err(_) => Default::default(),
        };
        let wrong = checked.profile.as_ref().err().map_or("", String::as_str);
        let profile = field("Display profile").error(wrong).note(&told, warns).hint("sRGB, assumed");
        profile.path(ui, &mut fields.profile, (FileKind::Toml, "Choose a display profile…"));
    }

    /// Draws the field for the width, and the buttons that measure it.
    fn width(&mut self, ui: &mut egui::Ui, label: egui::Id, fields: &mut ScreenFields, monitor: &Monitor) {
        let assumed = monitor.assumed_width_cm();
        let edit = TextEdit::singleline(&mut fields.screen_width_cm).desired_width(90.0);
        ui.add(edit.hint_text(format!("{assumed:.1}"))).labelled_by(label);
        if ui.button("Measure with a card…").clicked() {
            self.card = Some(Card::new(number(&fields.screen_width_cm).unwrap_or(assumed), monitor.width_px));
        }
        let reported_cm = *self.reported_cm.get(monitor.title(), || Platform::of(monitor).width_cm);
        let Some(reported) = reported_cm.map(|cm| format!("{cm:.1}")) else { return };
        let button = ui.button(format!("The screen reports {reported}"));
        if button.on_hover_text("Some screens report an incorrect width; check it with a card.").clicked() {
            fields.screen_width_cm = reported;
        }
    }

    /// Returns whether the dialog that measures the width is open.
    pub fn measures(&self) -> bool {
        self.card.is_some()
    }

    /// Draws the dialog that measures the width, if it is open; a width that the user accepts is that of the screen.
    pub fn measure(&mut self, ctx: &egui::Context, fields: &mut ScreenFields, monitor: &Monitor) {
        let Some(step) = self.card.as_mut().map(|card| card.show(ctx, monitor.width_px)) else { return };
        if let Step::Next(width) = step {
            fields.screen_width_cm = width.to_string();
        }
        if step != Step::Stay {
            self.card = None;
        }
    }
}

/// Height divided by width of an ISO/IEC 7810 ID-1 card, 53.98 mm by 85.60 mm.
const CARD_ASPECT: f32 = 53.98 / 85.60;

/// Width of the slider with its number, points.
const SLIDER: f32 = 420.0;
/// Minimum width of the outline, physical pixels.
const MIN_PX: f32 = 100.0;

/// A dialog with an outline that the user adjusts to the size of a card.
struct Card {
    card_px: f32,
    /// Whether the slider has been drawn, and had the keyboard focus.
    is_shown: bool,
}

impl Card {
    /// Starts with the outline that matches the current width.
    fn new(screen_width_cm: f64, screen_width_px: u32) -> Self {
        let px_per_cm = f64::from(screen_width_px) / screen_width_cm.clamp(1.0, 1000.0);
        Self { card_px: (px_per_cm * CARD_WIDTH_CM) as f32, is_shown: false }
    }

    fn show(&mut self, ctx: &egui::Context, screen_width_px: u32) -> Step<f64> {
        let outline = Vec2::new(self.card_px, self.card_px * CARD_ASPECT) / ctx.pixels_per_point();
        let (step, closed) = modal(ctx, "card", COLUMN.max(outline.x), |ui, height| {
            let scrolling = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
            scrolling.show(ui, |ui| self.content(ui, screen_width_px, outline)).inner
        });
        if closed && step == Step::Stay { Step::Back } else { step }
    }

    fn content(&mut self, ui: &mut egui::Ui, screen_width_px: u32, outline: Vec2) -> Step<f64> {
        ui.heading("Measure the screen with a card");
        ui.label(
            "Hold a bank card (8.56 cm wide) against the screen and adjust the outline to the same width with the \
            left and right arrow keys.",
        );
        // A small window does not limit the outline.
        let range = MIN_PX..=(screen_width_px as f32).max(2.0 * MIN_PX);
        let field = Field::new("Width of the outline, pixels").column(LABELS).width(SLIDER);
        let slider = field.slider(ui, &mut self.card_px, range, 1.0);
        if !std::mem::replace(&mut self.is_shown, true) {
            slider.request_focus();
        }
        if outline.x > ui.available_width() {
            ui.label(secondary("The outline is wider than this window. Make the window larger to see all of it."));
        }
        ScrollArea::horizontal().id_salt("outline").show(ui, |ui| {
            let (rect, _) = ui.allocate_exact_size(outline, Sense::hover());
            let stroke = Stroke::new(1.0, ink(ui).text);
            ui.painter().rect(rect, 10.0, ink(ui).line, stroke, egui::StrokeKind::Inside);
        });
        let found = width_cm_from_card(f64::from(self.card_px), screen_width_px);
        match &found {
            Ok(width) => _ = ui.label(format!("The screen is {width:.1} cm wide.")),
            Err(error) => show_error(ui, error),
        }
        ui.horizontal_wrapped(|ui| {
            let used = neutral_primary(ui, "Use this width", found.is_ok(), "");
            if ui.button("Cancel").clicked() {
                return Step::Back;
            }
            let width = found.ok().filter(|_| used);
            width.map_or(Step::Stay, |width| Step::Next((width * 10.0).round() / 10.0))
        })
        .inner
    }
}
