//! What the readings gave: models, errors, a plot; and the profile to save.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Color32, Key, RichText};
use egui_plot::{Corner, Legend, Line, MarkerShape, Plot, Points};

use super::{
    super::{Saved, signed, tool},
    setup::file_name,
};
use crate::{
    app::{theme, today},
    display::{
        DisplayProfile, Measurement,
        photometer::{Calibration, Channel, Family, FittedChannel, ReadingFault, Readings},
    },
};

/// Steps of a curve in the plot.
const STEPS: usize = 100;
/// Room for the numbers beside a plot, points: the same for all, so that their encoded values stand below each other.
const AXIS_ROOM: f32 = 80.0;

/// The page.
pub struct Outcome {
    found: Result<Box<Calibration>, String>,
    /// Patches that would be worth a second look.
    again: Vec<(Channel, f64)>,
    source: PathBuf,
    /// What is known of the screen besides its light.
    known: DisplayProfile,
    family: Option<Family>,
    name: String,
    by: String,
    with: String,
    path: String,
    fault: Option<String>,
}

/// Where the page leads.
pub enum OutcomeGo {
    /// Nowhere yet.
    Stay,
    /// Back to the settings.
    Back,
    /// To patches that are to be read again.
    Again(Vec<(Channel, f64)>),
    /// Out, with a profile.
    Saved(Saved),
}

impl Outcome {
    /// Fits what was read from `source`.
    pub fn new(read: Result<Readings, String>, source: &Path, known: &DisplayProfile, name: &str) -> Self {
        let found = read.and_then(|readings| match Calibration::new(&readings) {
            Ok(calibration) => Ok(Box::new(calibration)),
            Err(error) => Err(error.to_string()),
        });
        let again = if found.is_err() { doubtful(source) } else { Vec::new() };
        let measured = known.measured.clone().unwrap_or_default();
        Self {
            found,
            again,
            source: source.to_owned(),
            known: known.clone(),
            family: None,
            name: name.to_owned(),
            by: measured.by.unwrap_or_default(),
            with: String::new(),
            path: format!("calibration/{}.toml", file_name(name)),
            fault: None,
        }
    }

    /// Draws the page; `shown_here` where the patches can be gone back to.
    pub fn show(&mut self, ui: &mut egui::Ui, shown_here: bool) -> OutcomeGo {
        let mut back = false;
        let mut go = OutcomeGo::Stay;
        tool(ui, "What the readings say", &mut back, |ui| {
            ui.label(theme::quiet(self.source.display().to_string()));
            match &self.found {
                Err(faults) => {
                    ui.label("No profile can be made of these readings:");
                    faults.lines().for_each(|fault| theme::fault(ui, fault));
                    let usable = shown_here && !self.again.is_empty();
                    if usable && ui.button(format!("Read {} patches again", self.again.len())).clicked() {
                        go = OutcomeGo::Again(self.again.clone());
                    }
                }
                Ok(calibration) => {
                    summary(ui, calibration, self.family.unwrap_or(calibration.chosen));
                    choice(ui, calibration);
                    ui.add_space(8.0);
                }
            }
            if self.found.is_ok()
                && let Some(saved) = self.save_fields(ui)
            {
                go = OutcomeGo::Saved(saved);
            }
            if let Ok(calibration) = &self.found {
                ui.add_space(8.0);
                plots(ui, calibration, self.family.unwrap_or(calibration.chosen));
                ui.add_space(8.0);
                table(ui, calibration);
                ui.add_space(8.0);
                validation(ui, calibration);
            }
        });
        if back || ui.input(|input| input.key_pressed(Key::Escape)) { OutcomeGo::Back } else { go }
    }

    fn save_fields(&mut self, ui: &mut egui::Ui) -> Option<Saved> {
        ui.label(RichText::new("Profile").strong());
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Model");
            let chosen = self.found.as_ref().map_or(Family::Gamma, |calibration| calibration.chosen);
            let automatic = format!("automatic ({chosen})");
            let shown = self.family.map_or(automatic.clone(), |family| family.to_string());
            egui::ComboBox::from_id_salt("model")
                .selected_text(shown)
                .width(160.0)
                .show_ui(ui, |ui| {
                    ui.selectable_value(&mut self.family, None, automatic);
                    for family in Family::ALL {
                        ui.selectable_value(&mut self.family, Some(family), family.name());
                    }
                })
                .response
                .labelled_by(label.id);
        });
        for (name, value) in [
            ("Name of the display", &mut self.name),
            ("Measured by", &mut self.by),
            ("Photometer", &mut self.with),
            ("Save as", &mut self.path),
        ] {
            ui.horizontal_wrapped(|ui| {
                let label = ui.label(name);
                ui.add(egui::TextEdit::singleline(value).desired_width(360.0)).labelled_by(label.id);
            });
        }
        let exists = Path::new(self.path.trim()).exists();
        let usable = !self.path.trim().is_empty() && !self.name.trim().is_empty();
        let text = if exists { "Replace the profile" } else { "Save the profile" };
        let save = theme::primary(ui, text, usable, "and use it");
        if let Some(fault) = &self.fault {
            theme::fault(ui, fault);
        }
        if save { self.save() } else { None }
    }

    fn save(&mut self) -> Option<Saved> {
        match self.written() {
            Ok(saved) => Some(saved),
            Err(fault) => {
                self.fault = Some(fault);
                None
            }
        }
    }

    fn written(&self) -> Result<Saved, String> {
        let calibration = self.found.as_ref().map_err(Clone::clone)?;
        let some = |text: &str| (!text.trim().is_empty()).then(|| text.trim().to_owned());
        let with = some(&self.with).or_else(|| Some("photometer".to_owned()));
        let measured = Measurement { on: Some(today()), by: some(&self.by), with };
        let family = self.family.unwrap_or(calibration.chosen);
        let made = calibration.profile(family, self.name.trim(), measured).map_err(|error| error.to_string())?;
        let DisplayProfile { primaries, bits, screen_width_cm, native_px, .. } = self.known.clone();
        let made = DisplayProfile { primaries, bits, screen_width_cm, native_px, ..made };
        let path = PathBuf::from(self.path.trim());
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("toml")) {
            return Err(format!("{}: is no name of a profile; expected one that ends in .toml", path.display()));
        }
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).map_err(|error| {
                format!("{}: cannot be made: {error}; expected a place that can be written", folder.display())
            })?;
        }
        Saved::write(path, &made).map_err(|error| error.to_string())
    }
}

/// The levels that faults name.
fn doubtful(source: &Path) -> Vec<(Channel, f64)> {
    let Ok(all) = crate::store::readings::open_begun(source) else { return Vec::new() };
    let Err(faults) = Readings::new(all) else { return Vec::new() };
    let of = |fault: &ReadingFault| match *fault {
        ReadingFault::NotMonotone { channel, lower, upper, .. } => vec![(channel, lower), (channel, upper)],
        ReadingFault::Saturated { channel, level, .. } => vec![(channel, level), (channel, 1.0)],
        _ => Vec::new(),
    };
    faults.iter().flat_map(|found| of(&found.fault)).collect()
}

fn summary(ui: &mut egui::Ui, calibration: &Calibration, family: Family) {
    let light = calibration.luminance_of(family);
    ui.label(format!(
        "Black {:.3} cd/m², white {:.1} cd/m². Readings scatter by {:.2} %.",
        light.black_cd_m2,
        light.white_cd_m2,
        100.0 * calibration.noise.relative
    ));
    if let Some(additivity) = &calibration.additivity {
        let (percent, cd_m2) = (additivity.largest_percent(), additivity.largest_cd_m2());
        ui.label(format!(
            "Gray differs from the sum of its channels by at most {} % and {} cd/m².",
            signed(&format!("{:+.1}", percent.deviation_percent())),
            signed(&format!("{:+.2}", cd_m2.deviation_cd_m2()))
        ));
    }
    for note in &calibration.notes {
        ui.add(egui::Label::new(RichText::new(note.to_string()).small().color(theme::NOTE)).wrap());
    }
}

fn table(ui: &mut egui::Ui, calibration: &Calibration) {
    ui.label(theme::quiet("Largest error: of a reading from the model, in 8-bit codes and in cd/m²."));
    egui::ScrollArea::horizontal().id_salt("fits").show(ui, |ui| {
        egui::Grid::new("fits").striped(true).num_columns(7).spacing([18.0, 4.0]).show(ui, |ui| {
            for head in ["model", "channel", "γ", "offset", "R²", "codes", "cd/m²"] {
                ui.label(theme::quiet(head));
            }
            ui.end_row();
            for model in &calibration.models {
                for channel in &model.channels {
                    cells(model.family, channel).into_iter().for_each(|cell| _ = ui.label(cell));
                    ui.end_row();
                }
            }
        });
    });
}

fn cells(family: Family, channel: &FittedChannel) -> [String; 7] {
    let none = || "—".to_owned();
    let gamma = channel.shape.and_then(|shape| shape.gamma());
    let gamma = match (gamma, channel.gamma_se) {
        (Some(gamma), Some(se)) => format!("{gamma:.3} ± {se:.3}"),
        (Some(gamma), None) => format!("{gamma:.3}"),
        _ => none(),
    };
    let offset = channel.shape.and_then(|shape| shape.gain_and_offset());
    [
        family.to_string(),
        channel.channel.to_string(),
        gamma,
        offset.map_or_else(none, |(_, offset)| signed(&format!("{offset:+.4}"))),
        format!("{:.5}", channel.r_squared),
        format!("{:.2}", channel.largest_codes),
        format!("{:.3}", channel.largest_cd_m2),
    ]
}

fn validation(ui: &mut egui::Ui, calibration: &Calibration) {
    let errors: Vec<String> = (calibration.models.iter())
        .filter_map(|model| {
            let found = model.validation.as_ref()?;
            Some(format!("{} {:.2} codes, {:.3} cd/m²", model.family, found.rms_codes, found.rms_cd_m2))
        })
        .collect();
    ui.label(format!("Root mean square error of levels left out in turn: {}.", errors.join("; ")));
    ui.label(format!("Cross-validation prefers {}.", calibration.better));
}

fn choice(ui: &mut egui::Ui, calibration: &Calibration) {
    ui.strong(format!("Chosen: {}, the simplest that the readings do not speak against.", calibration.chosen));
}

fn look(channel: Channel) -> (Color32, MarkerShape) {
    match channel {
        Channel::Red => (Color32::from_rgb(0xd5, 0x5e, 0x00), MarkerShape::Square),
        Channel::Green => (Color32::from_rgb(0x00, 0x9e, 0x73), MarkerShape::Up),
        Channel::Blue => (Color32::from_rgb(0x56, 0xb4, 0xe9), MarkerShape::Diamond),
        Channel::Gray => (Color32::from_gray(0xd0), MarkerShape::Circle),
    }
}

/// A plot over all encoded values, as wide as the others beside its axis.
fn plot<'a>(id: &'static str, height: f32, values: &str) -> Plot<'a> {
    Plot::new(id)
        .include_x(0.0)
        .include_x(1.0)
        .y_axis_min_width(AXIS_ROOM)
        .height(height)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .x_axis_label("encoded value")
        .y_axis_label(values.to_owned())
}

fn plots(ui: &mut egui::Ui, calibration: &Calibration, family: Family) {
    let channels = &calibration.model(family).channels;
    let of = |channel: Channel| calibration.readings.all().iter().filter(move |one| one.channel == channel);
    ui.label(theme::quiet(format!("Luminance: readings, and {family} as lines.")));
    plot("light", 260.0, "cd/m²").legend(Legend::default().position(Corner::LeftTop)).show(ui, |plot| {
        for channel in channels {
            let (color, marker) = look(channel.channel);
            let name = channel.channel.name();
            let curve = (0..=STEPS).map(|step| step as f64 / STEPS as f64).map(|v| [v, channel.response.cd_m2(v)]);
            plot.line(Line::new(name, curve.collect::<Vec<_>>()).color(color).width(2.0));
            let read = of(channel.channel).map(|one| [one.level, one.luminance_cd_m2]);
            plot.points(Points::new(name, read.collect::<Vec<_>>()).shape(marker).radius(4.0).color(color));
        }
    });
    ui.label(theme::quiet("How far each reading is from its line, in 8-bit codes."));
    plot("off", 160.0, "codes").include_y(-1.0).include_y(1.0).show(ui, |plot| {
        for channel in channels {
            let (color, marker) = look(channel.channel);
            let off = of(channel.channel)
                .map(|one| [one.level, 255.0 * (channel.response.encoded(one.luminance_cd_m2) - one.level)]);
            let points = Points::new(channel.channel.name(), off.collect::<Vec<_>>());
            plot.points(points.shape(marker).radius(4.0).color(color));
        }
    });
}
