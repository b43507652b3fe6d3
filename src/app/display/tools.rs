//! What is known about the screen, and the list of tools.

use eframe::egui::{self, Color32, RichText};

use super::{
    by_eye::ByEye,
    calibrate::{Calibrate, LABELS, Tool},
    card::CardHelper,
    photometer::Photometer,
    sizes::SizeTest,
    timing::TimingTool,
};
use crate::{
    app::ui::{
        Field, FileKind, Monitor, ScreenFields, Step, full, hint, note, platform::Platform, say, text, theme::ink,
        today, tool_page,
    },
    display::{DisplayProfile, Viewing, geometry::distance_cm},
    report::names::capitalized,
};

pub struct Display {
    /// All tools, in the order in which a new screen needs them. They outlive their pages, so that a paused run can be
    /// resumed.
    tools: [Entry; 4],
    /// The place of the tool that is open.
    open: Option<usize>,
    /// The width in cm that the screen reports, if any; `None` until it is queried.
    reported_cm: Option<Option<f64>>,
    card: Option<CardHelper>,
}

/// A tool's name, a description of it, and the tool.
type Entry = (&'static str, &'static str, Box<dyn Tool>);

impl Default for Display {
    fn default() -> Self {
        let tools: [Entry; 4] = [
            (
                "Photometer",
                "Measure the luminance of every level: point a photometer at patches, or load readings from a file.",
                Box::new(Calibrate::new(Photometer::default(), [true, true])),
            ),
            (
                "Patch size",
                "Find out with a photometer whether the screen dims large bright areas, as OLED screens do.",
                Box::new(Calibrate::new(SizeTest { settle_s: 2.0 }, [false, true])),
            ),
            (
                "Gamma by eye",
                "No photometer needed: match a square to a field of rows in each channel. This takes about five minutes.",
                Box::new(Calibrate::new(ByEye::default(), [true, false])),
            ),
            (
                "Timing",
                "Find out whether every refresh shows a new frame: intervals and dropped frames.",
                Box::new(TimingTool::default()),
            ),
        ];
        Self { tools, open: None, reported_cm: None, card: None }
    }
}

impl Display {
    fn tool(&mut self) -> Option<&mut dyn Tool> {
        Some(&mut *self.tools[self.open?].2)
    }

    /// Returns the background color while the screen is measured, which then shows nothing else; `None` for a page.
    pub fn ground(&self) -> Option<Color32> {
        self.tools[self.open?].2.ground()
    }

    /// Pauses the measurement; that of frames ends.
    pub fn pause(&mut self, ctx: &egui::Context) {
        if let Some(tool) = self.tool() {
            tool.pause(ctx);
        }
    }

    /// Draws the open tool, or the list of tools; returns whether the user left the list, and `Next` once a tool has written
    /// the profile that the fields name. `fields` are the start page's fields for the profile's path, the screen's width and
    /// the distance, which can also be set here; `found` is the profile, or what is wrong with it; `window_deg` is the side
    /// of the planned stimulus.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        monitor: &Monitor,
        fields: &mut ScreenFields,
        found: Result<&DisplayProfile, &str>,
        window_deg: f64,
    ) -> Step<()> {
        let Some(tool) = self.tool() else {
            return Step::back_if(self.list(ui, monitor, fields, found, window_deg));
        };
        let step = tool.show(ui, monitor, fields.viewing(monitor).ok().as_ref());
        if step == Step::Stay {
            return Step::Stay;
        }
        self.open = None;
        ui.ctx().request_repaint();
        let Step::Next(saved) = step else { return Step::Stay };
        fields.profile = full(&saved).display().to_string();
        say(ui.ctx(), format!("Saved as {}; now in use.", fields.profile));
        Step::Next(())
    }

    fn list(
        &mut self,
        ui: &mut egui::Ui,
        monitor: &Monitor,
        fields: &mut ScreenFields,
        found: Result<&DisplayProfile, &str>,
        window_deg: f64,
    ) -> bool {
        let mut chosen = None;
        let back = tool_page(ui, "Display", |ui| {
            ui.label(
                "The eye sees light, not codes. A display profile describes how much light this screen produces for \
                    each code.",
            );
            ui.add_space(8.0);
            Self::profile_field(ui, fields, found);
            self.size_fields(ui, monitor, fields, window_deg);
            ui.add_space(8.0);
            for (place, (name, what, _)) in self.tools.iter().enumerate() {
                ui.add_space(4.0);
                let button = egui::Button::new(RichText::new(*name).strong()).min_size([260.0, 34.0].into());
                if ui.add(button).clicked() {
                    chosen = Some(place);
                }
                hint(ui, *what);
            }
        });
        CardHelper::measure(&mut self.card, ui.ctx(), fields, monitor);
        if let Some(place) = chosen {
            self.tools[place].2.open(found.cloned().unwrap_or_default());
            self.open = Some(place);
            ui.ctx().request_repaint();
        }
        back
    }

    fn profile_field(ui: &mut egui::Ui, fields: &mut ScreenFields, found: Result<&DisplayProfile, &str>) {
        let browse = (FileKind::Toml, "Choose a profile…");
        let field = Field::new("Profile in use").column(LABELS).hint("sRGB, assumed").width(300.0);
        field.path(ui, &mut fields.profile, browse);
        match found {
            Ok(profile) => {
                hint(ui, format!("{}.", profile.sentence()));
                profile.warning(today()).iter().for_each(|warning| note(ui, warning));
            }
            Err(errors) => text::errors(ui, errors),
        }
    }

    /// Draws the width of the screen and the distance from which it is seen, and says how large that makes a degree.
    fn size_fields(&mut self, ui: &mut egui::Ui, monitor: &Monitor, fields: &mut ScreenFields, window_deg: f64) {
        let reported_cm = *self.reported_cm.get_or_insert_with(|| Platform::of(monitor).width_cm);
        let of_width = fields.screen(monitor).err().unwrap_or_default();
        let found = fields.viewing(monitor);
        let of_distance = found.as_ref().err().filter(|_| of_width.is_empty()).map_or("", String::as_str);
        let [of_width, of_distance] = [&*of_width, of_distance].map(capitalized);
        Field::new("Screen width, cm").column(LABELS).slot().error(&of_width).show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| {
                CardHelper::field(&mut self.card, ui, label, fields, monitor);
                let Some(reported) = reported_cm.map(|cm| format!("{cm:.1}")) else { return };
                let button = ui.button(format!("The screen reports {reported}"));
                let button = button.on_hover_text("Some screens report an incorrect width; check it with a card.");
                if button.clicked() {
                    fields.screen_width_cm = reported;
                }
            });
        });
        let field = Field::new("Viewing distance, cm").column(LABELS).width(90.0);
        field.slot().error(&of_distance).text(ui, &mut fields.distance_cm);
        // What the fields say has the same room, whatever it is.
        let ink = ink(ui);
        let (told, color) = match found {
            Ok(viewing) if fields.width_is_assumed() => {
                (format!("{}. {}", monitor.assumption(), size_sentence(&viewing, window_deg)), ink.warn)
            }
            Ok(viewing) => (size_sentence(&viewing, window_deg), ink.dim),
            Err(_) => (String::new(), ink.dim),
        };
        text::two_lines(ui, &told, color, 3);
    }
}

/// Says how large a degree is, and whether the planned stimulus, whose side has `window_deg` degrees, fits the screen.
fn size_sentence(viewing: &Viewing, window_deg: f64) -> String {
    let (screen, per_degree) = (viewing.screen(), viewing.px_per_degree());
    let wanted = viewing.px_from_deg(window_deg);
    let degree = format!("One degree is {per_degree:.1} pixels, or {:.2} cm.", per_degree / screen.px_per_cm());
    let fits = if wanted <= f64::from(screen.width_px.min(screen.height_px)) {
        "fits".to_owned()
    } else {
        let most = distance_cm(window_deg, screen.width_cm.min(screen.height_cm())).floor();
        format!("fits only at a viewing distance of {most} cm or less")
    };
    format!("{degree} The {window_deg}° stimulus of the chosen study has {wanted:.0} × {wanted:.0} pixels and {fits}.")
}
