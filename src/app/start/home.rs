//! The Home page, on which the user chooses the experiment, the participant and the screen.

use std::{path::PathBuf, rc::Rc};

use eframe::egui::{self, Button, ComboBox, Key, RichText, TextEdit, TextureHandle, ViewportCommand};

use super::form::{Checked, Form, LABELS, Part};
use crate::{
    app::{
        display::CardHelper,
        session::Request,
        ui::{self, Dialog, Field, FileKind, Monitor, Step, number, pixels, today},
    },
    display::DisplayProfile,
    light::{Bits, Quantizer, Transfer},
    stimulus::{MachBand, Stimulus},
    store::definition::BUILT_IN,
};

/// Side of the example image below the form, physical pixels.
const PICTURE_PX: u32 = 180;

/// The pages to which Home leads.
pub enum Destination {
    Session(Box<Request>),
    Display {
        /// Side of the planned stimulus in degrees.
        window_deg: f64,
    },
    /// The gallery, with the display profile and, if known, the viewing distance in cm.
    Gallery(Box<DisplayProfile>, Option<f64>),
    Shading,
    /// The analysis of the experiments in this results folder.
    Analysis(PathBuf),
}

#[derive(Default)]
pub struct Home {
    form: Form,
    /// The form and the monitor that were checked last, and the result. Updated if either has changed.
    checked: Option<(Form, Monitor, Rc<Checked>)>,
    /// The screen width that the program filled in, and its source.
    width_origin: Option<(String, &'static str)>,
    card: Option<CardHelper>,
    experiment: Dialog,
    profile: Dialog,
    results: Dialog,
    picture: Option<TextureHandle>,
    monitor_choice: Option<usize>,
    full_screen: bool,
    started: bool,
}

impl Home {
    /// Creates Home with the previous values of its fields.
    pub fn again(form: Form) -> Self {
        Self { form, ..Self::default() }
    }

    pub fn form(&self) -> &Form {
        &self.form
    }

    pub fn show(&mut self, ui: &mut egui::Ui, here: &Monitor, monitors: &[Monitor]) -> Step<Destination> {
        // The form is for the monitor that the session will use, which may not be the monitor that shows this window.
        let chosen = self.monitor_choice.filter(|_| self.full_screen).and_then(|index| monitors.get(index));
        let monitor = chosen.unwrap_or(here);
        if !self.started {
            self.started = true;
            self.full_screen = true;
            self.form.suggest(monitor);
        }
        let dropped = ui.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.choose_experiment(path.display().to_string());
        }
        let checked = self.check(monitor);
        let next = ui::page_from(ui, 0.02, |ui| {
            ui.heading("machband");
            ui.label("How visible are Mach bands? Rate them; every answer is saved.");
            ui.add_space(6.0);
            let measure = self.fields(ui, &checked, monitor, here, monitors);
            ui.add_space(8.0);
            let start = self.start(ui, &checked);
            let aside = self.other_pages(ui, &checked);
            ui.add_space(8.0);
            self.example(ui);
            start.or(aside).or(measure)
        });
        self.measure_with_card(ui.ctx(), here);
        next.map_or(Step::Stay, Step::Next)
    }

    fn choose_experiment(&mut self, name_or_path: String) {
        self.form.experiment = name_or_path;
        // The planned distance and the choice of gray belong to the definition.
        self.form.gray = false;
        self.form.screen.distance_cm.clear();
    }

    /// Checks the form if something in it has changed.
    fn check(&mut self, monitor: &Monitor) -> Rc<Checked> {
        if let Some((form, seen, checked)) = &self.checked
            && *form == self.form
            && seen == monitor
        {
            return checked.clone();
        }
        if self.form.screen.distance_cm.is_empty() {
            self.form.suggest(monitor);
        }
        let mut checked = self.form.check(monitor);
        let known = checked.display.as_ref().and_then(|display| display.screen_width_cm);
        if let Some(width) = known
            && self.form.screen.width_is_assumed(monitor)
        {
            // A profile that knows the screen's width is better than an assumption.
            self.set_width(width, "From the display profile");
            checked = self.form.check(monitor);
        }
        let checked = Rc::new(checked);
        self.checked = Some((self.form.clone(), monitor.clone(), checked.clone()));
        checked
    }

    fn set_width(&mut self, width_cm: f64, origin: &'static str) {
        self.form.screen.screen_width_cm = width_cm.to_string();
        self.width_origin = Some((width_cm.to_string(), origin));
    }

    fn fields(
        &mut self,
        ui: &mut egui::Ui,
        checked: &Checked,
        monitor: &Monitor,
        here: &Monitor,
        monitors: &[Monitor],
    ) -> Option<Destination> {
        self.experiment_field(ui, checked);
        let Form { participant, session, screen, .. } = &mut self.form;
        checked.field(Part::Participant).hint("letters and digits").text(ui, participant);
        checked.field(Part::Session).hint("1, 2, … for the same participant").text(ui, session);
        checked.field(Part::Distance).hint("from eye to screen").text(ui, &mut screen.distance_cm);
        self.width_field(ui, checked, monitor, here);
        let measure = self.profile_field(ui, checked);
        checked.field(Part::Results).show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| {
                ui.add(TextEdit::singleline(&mut self.form.results)).labelled_by(label);
                self.results.browse(ui, FileKind::Folder, "Choose the results folder…", &mut self.form.results);
            });
        });
        self.monitor_field(ui, checked, monitor, monitors);
        measure.then(|| {
            let window_deg = checked.protocol.as_ref().map_or(10.0, |protocol| protocol.viewing.window_deg);
            Destination::Display { window_deg }
        })
    }

    fn experiment_field(&mut self, ui: &mut egui::Ui, checked: &Checked) {
        let mut name = self.form.experiment.clone();
        checked.field(Part::Experiment).show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| {
                let field = TextEdit::singleline(&mut name).desired_width(200.0);
                ui.add(field.hint_text("name, or path to a .toml file")).labelled_by(label);
                let list = ComboBox::from_id_salt("experiment").selected_text("Built in").width(96.0);
                let list = list.show_ui(ui, |ui| {
                    for built_in in BUILT_IN {
                        ui.selectable_value(&mut name, built_in.name.to_owned(), built_in.name);
                    }
                });
                list.response.labelled_by(label);
                self.experiment.browse(ui, FileKind::Toml, "Choose a definition…", &mut name);
            });
            if let Some(protocol) = &checked.protocol {
                let practice = match protocol.design.practice {
                    0 => String::new(),
                    n => format!("{n} practice and "),
                };
                let text = format!(
                    "{}. {practice}{} trials, about {} min. You can also drop a .toml file on this window.",
                    protocol.title,
                    protocol.main_trials(),
                    protocol.minutes()
                );
                ui::hint(ui, text);
            }
        });
        if name != self.form.experiment {
            self.choose_experiment(name);
        }
    }

    fn width_field(&mut self, ui: &mut egui::Ui, checked: &Checked, monitor: &Monitor, here: &Monitor) {
        checked.field(Part::ScreenWidth).show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| {
                let width = &mut self.form.screen.screen_width_cm;
                ui.add(TextEdit::singleline(width).desired_width(120.0)).labelled_by(label);
                let measure = ui.add_enabled(monitor == here, Button::new("Measure with a card…"));
                if measure.on_disabled_hover_text("First move this window to that screen.").clicked() {
                    let width = number(width).unwrap_or_else(|| monitor.assumed_width_cm());
                    self.card = Some(CardHelper::new(width, monitor.width_px));
                }
            });
            let Some((side, per_degree)) = checked.stimulus_px.filter(|_| !checked.is_wrong(Part::ScreenWidth)) else {
                return;
            };
            let screen = &self.form.screen;
            let origin = match &self.width_origin {
                Some((width, origin)) if *width == screen.screen_width_cm => origin,
                _ if screen.width_is_assumed(monitor) => {
                    "Assumed (96 pixels per inch); measure it before an actual \
                    study"
                }
                _ => "As typed",
            };
            let text = format!("{origin}. {per_degree:.1} pixels per degree; the stimulus is {side} pixels wide.");
            ui::hint(ui, text);
        });
    }

    /// Draws the field for the profile; returns whether the user wants to measure the screen.
    fn profile_field(&mut self, ui: &mut egui::Ui, checked: &Checked) -> bool {
        checked.field(Part::Profile).show(ui, |ui, label| {
            let path = &mut self.form.screen.profile;
            let line = |ui: &mut egui::Ui| {
                ui.add(TextEdit::singleline(path).desired_width(210.0).hint_text("sRGB")).labelled_by(label);
                self.profile.browse(ui, FileKind::Toml, "Choose a display profile…", path);
                ui.button("Measure…").on_hover_text("Luminance, size, and timing of the screen.").clicked()
            };
            let measure = ui.horizontal_wrapped(line).inner;
            if let Some(display) = &checked.display {
                ui::hint(ui, display.sentence());
                // If the profile is assumed, its description already says so.
                if let Some(warning) = display.warning(today()).filter(|_| display.measured.is_some()) {
                    ui::note(ui, warning);
                }
            }
            measure
        })
    }

    fn monitor_field(&mut self, ui: &mut egui::Ui, checked: &Checked, monitor: &Monitor, monitors: &[Monitor]) {
        let has_color = checked.protocol.as_ref().is_some_and(|protocol| protocol.in_gray().is_some());
        let mut line = |ui: &mut egui::Ui, label| {
            if monitors.len() > 1 {
                let list = ComboBox::from_id_salt("monitor").selected_text(monitor.title()).width(300.0);
                let list = list.show_ui(ui, |ui| {
                    for (i, monitor) in monitors.iter().enumerate() {
                        ui.selectable_value(&mut self.monitor_choice, Some(i), monitor.title());
                    }
                });
                list.response.labelled_by(label);
            } else {
                ui.label(monitor.title());
            }
            ui.checkbox(&mut self.full_screen, "Full screen");
            if self.form.gray || has_color {
                let gray = ui.checkbox(&mut self.form.gray, "In gray");
                gray.on_hover_text(
                    "For participants with a color vision deficiency. The experiment's name then ends in -gray.",
                );
            }
        };
        let field = Field::new("Screen").column(LABELS);
        field.show(ui, |ui, label| ui.horizontal_wrapped(|ui| line(ui, label)));
    }

    fn start(&mut self, ui: &mut egui::Ui, checked: &Checked) -> Option<Destination> {
        let text = if checked.resume { "Resume" } else { "Start" };
        let hint = match (&checked.request, checked.resume) {
            (None, _) => "Something above needs attention.",
            (Some(_), true) => "This session was interrupted. It resumes with the remaining trials.",
            (Some(_), false) => "Or press Enter. Esc pauses at any time; every answer is saved immediately.",
        };
        let clicked = Field::new("").column(LABELS).show(ui, |ui, _| {
            for dialog in [&self.experiment, &self.profile, &self.results] {
                dialog.missing_error(ui);
            }
            ui::primary(ui, text, checked.request.is_some(), hint)
        });
        let entered = self.card.is_none() && ui::shortcut(ui, Key::Enter);
        let mut request = checked.request.clone().filter(|_| clicked || entered)?;
        request.windowed = !self.full_screen;
        if self.full_screen {
            // Choosing a monitor makes the window full screen there.
            ui.ctx().send_viewport_cmd(match self.monitor_choice {
                Some(index) => ViewportCommand::SetMonitor(index),
                None => ViewportCommand::Fullscreen(true),
            });
        }
        Some(Destination::Session(Box::new(request)))
    }

    fn other_pages(&mut self, ui: &mut egui::Ui, checked: &Checked) -> Option<Destination> {
        let buttons = |ui: &mut egui::Ui| {
            // Less padding puts all three on one line, so that the example below is visible without scrolling.
            ui.spacing_mut().button_padding.x = 8.0;
            let [gallery, shading, analysis] =
                ["Gallery of stimuli…", "Shading demo…", "Analyze results…"].map(|text| ui.button(text).clicked());
            if gallery {
                let display = checked.display.clone().unwrap_or_default();
                return Some(Destination::Gallery(Box::new(display), number(&self.form.screen.distance_cm)));
            }
            if shading {
                return Some(Destination::Shading);
            }
            analysis.then(|| Destination::Analysis(self.form.results.trim().into()))
        };
        Field::new("").column(LABELS).show(ui, |ui, _| ui.horizontal_wrapped(buttons).inner)
    }

    /// Draws a Mach band as an example.
    fn example(&mut self, ui: &mut egui::Ui) {
        let texture = self.picture.get_or_insert_with(|| {
            let stimulus = Stimulus::MachBand(MachBand::default());
            pixels::texture(ui.ctx(), "example", &stimulus, PICTURE_PX, &Quantizer::new(&Transfer::Srgb, Bits::Eight))
        });
        ui.separator();
        ui.horizontal_top(|ui| {
            pixels::picture(ui, texture, "A dark area and a bright area with a linear ramp between them");
            ui.vertical(|ui| {
                ui.label(RichText::new("Do you see a bright line?").strong());
                ui.label(
                    "It appears at the right end of the ramp, where the bright area begins, but it is not in the \
                        image.",
                );
                ui.label(
                    "It is a Mach band. In a session, participants rate how visible it is in images like this \
                    one.",
                );
            });
        });
    }

    fn measure_with_card(&mut self, ctx: &egui::Context, monitor: &Monitor) {
        let Some(card) = &mut self.card else { return };
        match card.show(ctx, monitor.width_px) {
            Step::Stay => return,
            Step::Back => {}
            Step::Next(width) => self.set_width(width, "Measured with a card"),
        }
        self.card = None;
    }
}
