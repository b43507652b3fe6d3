//! Home: what is to be run, for whom, on which screen.

use std::path::PathBuf;

use eframe::egui::{self, Key, RichText, TextureHandle, ViewportCommand};

use super::form::{Checked, Form};
use crate::{
    app::{
        display::card::{CardHelper, CardOutcome},
        session::Request,
        ui::{self, Ask, Dialog, Monitor, Step, number, pixels, theme, today},
    },
    display::DisplayProfile,
    light::{Bits, Quantizer, Transfer},
    stimulus::{MachBand, Stimulus},
    store::definition::BUILT_IN,
};

/// Side of the picture beside the form, physical pixels.
const PICTURE_PX: u32 = 180;

/// Where Home leads.
pub enum Destination {
    /// A session.
    Session(Box<Request>),
    /// The display lab.
    Display {
        /// Side of the planned stimulus, degrees.
        window_deg: f64,
    },
    /// The gallery, for a display at a distance in cm, where that is known.
    Gallery(DisplayProfile, Option<f64>),
    /// The shading demo.
    Shading,
    /// The analysis, with the experiments of a results folder.
    Analysis(PathBuf),
}

/// The page.
#[derive(Default)]
pub struct Home {
    form: Form,
    checked: Option<(Form, Monitor, Checked)>,
    /// What the card helper found: shows that the width is not an assumption.
    measured_cm: Option<f64>,
    /// What the display profile says.
    profile_cm: Option<f64>,
    card: Option<CardHelper>,
    /// Which field an open dialog is for.
    dialog: Dialog,
    asking: Option<Field>,
    picture: Option<TextureHandle>,
    monitor_choice: Option<usize>,
    full_screen: bool,
    started: bool,
}

#[derive(Clone, Copy)]
enum Field {
    Experiment,
    Profile,
    Results,
}

impl Home {
    /// Home as it was left.
    pub fn again(form: Form) -> Self {
        Self { form, ..Self::default() }
    }

    /// The fields.
    pub fn form(&self) -> &Form {
        &self.form
    }

    /// Draws the page.
    pub fn show(&mut self, ui: &mut egui::Ui, here: &Monitor, monitors: &[Monitor]) -> Step<Destination> {
        // The form is about the monitor that the session will use, wherever this window is.
        let chosen = self.monitor_choice.filter(|_| self.full_screen).and_then(|index| monitors.get(index));
        let monitor = chosen.unwrap_or(here);
        if !self.started {
            self.started = true;
            self.full_screen = true;
            self.form.suggest(monitor);
        }
        self.take_files(ui.ctx());
        self.recheck(monitor);
        let mut step = Step::Stay;
        ui::page_from(ui, 0.02, |ui| {
            ui.heading("machband");
            ui.label("How visible are Mach bands? Rate them, and keep every answer.");
            ui.add_space(12.0);
            let measure = self.fields(ui, monitor, here, monitors);
            ui.add_space(8.0);
            step = self.start(ui);
            if measure {
                step = Step::Next(Destination::Display { window_deg: self.window_deg() });
            }
            row(ui, "", |ui, _| {
                ui.horizontal_wrapped(|ui| {
                    // Three beside each other, so that the example below needs no scrolling.
                    ui.spacing_mut().button_padding.x = 8.0;
                    if ui.button("Gallery of stimuli…").clicked() {
                        let profile = checked_display(&self.checked);
                        step = Step::Next(Destination::Gallery(profile, number(&self.form.screen.distance_cm)));
                    }
                    if ui.button("Shading demo…").clicked() {
                        step = Step::Next(Destination::Shading);
                    }
                    if ui.button("Analyse results…").clicked() {
                        step = Step::Next(Destination::Analysis(self.form.results.trim().into()));
                    }
                });
            });
            ui.add_space(16.0);
            self.example(ui);
        });
        self.card(ui.ctx(), here);
        step
    }

    /// A file dropped on the window or chosen in a dialog.
    fn take_files(&mut self, ctx: &egui::Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.choose_experiment(path.display().to_string());
        }
        if let Some(path) = self.dialog.take() {
            let path = path.display().to_string();
            match self.asking {
                Some(Field::Experiment) => self.choose_experiment(path),
                Some(Field::Profile) => self.form.screen.profile = path,
                Some(Field::Results) => self.form.results = path,
                None => {}
            }
        }
    }

    fn choose_experiment(&mut self, name_or_path: String) {
        self.form.experiment = name_or_path;
        // The planned distance belongs to the definition, and so does its colour.
        self.form.gray = false;
        self.form.screen.distance_cm.clear();
    }

    /// Looks the form through when something in it has changed.
    fn recheck(&mut self, monitor: &Monitor) {
        let current = |(form, seen, _): &(Form, Monitor, Checked)| *form == self.form && seen == monitor;
        if !self.checked.as_ref().is_some_and(current) {
            if self.form.screen.distance_cm.is_empty() {
                self.form.suggest(monitor);
            }
            let mut checked = self.form.check(monitor);
            let measured = checked.display.as_ref().and_then(|display| display.screen_width_cm);
            if let Some(width) = measured
                && self.form.screen.width_is_assumed(monitor)
            {
                // A profile that knows the screen's width is better than an assumption.
                self.form.screen.screen_width_cm = width.to_string();
                self.profile_cm = Some(width);
                checked = self.form.check(monitor);
            }
            self.checked = Some((self.form.clone(), monitor.clone(), checked));
        }
    }

    /// The form; gives whether the screen is to be measured.
    fn fields(&mut self, ui: &mut egui::Ui, monitor: &Monitor, here: &Monitor, monitors: &[Monitor]) -> bool {
        let mut measure = false;
        // Taken out while the fields change the form; what was checked stays known by the form it was checked for.
        let Some((form, seen, checked)) = self.checked.take() else { return false };
        let faults = &checked.faults;
        self.experiment_field(ui, &checked);
        let typed = &mut self.form;
        text_field(ui, "Participant", &mut typed.participant, faults.participant.as_deref(), "letters and digits");
        text_field(ui, "Session", &mut typed.session, faults.session.as_deref(), "1, 2, … for the same participant");
        text_field(
            ui,
            "Viewing distance, cm",
            &mut typed.screen.distance_cm,
            faults.distance.as_deref(),
            "from eye to screen",
        );
        row(ui, "Screen width, cm", |ui, label| {
            ui.horizontal_wrapped(|ui| {
                ui.add(egui::TextEdit::singleline(&mut self.form.screen.screen_width_cm).desired_width(120.0))
                    .labelled_by(label);
                let measure = ui.add_enabled(monitor == here, egui::Button::new("Measure with a card…"));
                if measure.on_disabled_hover_text("Move this window to that screen first.").clicked() {
                    let width = self.form.screen.screen_width_cm.parse().unwrap_or_else(|_| monitor.assumed_width_cm());
                    self.card = Some(CardHelper::new(width, monitor.width_px));
                }
            });
            match (&faults.screen_width, checked.stimulus_px) {
                (Some(text), _) => ui::fault(ui, text),
                (None, Some((side, per_degree))) => {
                    let origin =
                        if self.measured_cm.is_some_and(|cm| self.form.screen.screen_width_cm == cm.to_string()) {
                            "Measured with a card"
                        } else if self.profile_cm.is_some_and(|cm| self.form.screen.screen_width_cm == cm.to_string()) {
                            "From the display profile"
                        } else if self.form.screen.width_is_assumed(monitor) {
                            "Assumed from 96 pixels an inch; measure it for a real study"
                        } else {
                            "As typed"
                        };
                    ui.label(ui::quiet(format!(
                        "{origin}. {per_degree:.1} pixels a degree; the stimulus is {side} pixels wide."
                    )));
                }
                (None, None) => {}
            }
        });
        row(ui, "Display profile", |ui, label| {
            ui.horizontal_wrapped(|ui| {
                ui.add(
                    egui::TextEdit::singleline(&mut self.form.screen.profile).desired_width(210.0).hint_text("sRGB"),
                )
                .labelled_by(label);
                self.browse(ui, Field::Profile, "Choose a display profile…");
                measure = ui.button("Measure…").on_hover_text("The screen's light, size and timing.").clicked();
            });
            match (&faults.profile, &checked.display) {
                (Some(text), _) => ui::fault(ui, text),
                (None, Some(display)) => {
                    ui.add(egui::Label::new(ui::quiet(display.sentence())).wrap());
                    if display.measured.is_some()
                        && let Some(doubt) = display.doubt(today())
                    {
                        ui.label(RichText::new(doubt).small().color(theme::NOTE));
                    }
                }
                (None, None) => {}
            }
        });
        row(ui, "Results folder", |ui, label| {
            ui.horizontal_wrapped(|ui| {
                ui.add(egui::TextEdit::singleline(&mut self.form.results).desired_width(300.0)).labelled_by(label);
                self.browse(ui, Field::Results, "Choose the results folder…");
            });
            if let Some(text) = &faults.results {
                ui::fault(ui, text);
            }
        });
        self.monitor_field(ui, &checked, monitor, monitors);
        self.checked.get_or_insert((form, seen, checked));
        measure
    }

    fn experiment_field(&mut self, ui: &mut egui::Ui, checked: &Checked) {
        let mut chosen = None;
        row(ui, "Experiment", |ui, label| {
            ui.horizontal_wrapped(|ui| {
                let mut typed = self.form.experiment.clone();
                ui.add(
                    egui::TextEdit::singleline(&mut typed).desired_width(200.0).hint_text("name, or path of a .toml"),
                )
                .labelled_by(label);
                if typed != self.form.experiment {
                    chosen = Some(typed);
                }
                egui::ComboBox::from_id_salt("experiment")
                    .selected_text("Built in")
                    .width(96.0)
                    .show_ui(ui, |ui| {
                        for built_in in BUILT_IN {
                            if ui.selectable_label(self.form.experiment == built_in.name, built_in.name).clicked() {
                                chosen = Some(built_in.name.to_owned());
                            }
                        }
                    })
                    .response
                    .labelled_by(label);
                self.browse(ui, Field::Experiment, "Choose a definition…");
            });
            match (&checked.faults.experiment, &checked.protocol) {
                (Some(text), _) => text.lines().for_each(|line| ui::fault(ui, line)),
                (None, Some(protocol)) => {
                    let practice = match protocol.design.practice {
                        0 => String::new(),
                        n => format!("{n} practice and "),
                    };
                    let minutes = (protocol.main_trials() + protocol.design.practice as usize) as f64
                        * (protocol.recovery.duration_s + 3.5)
                        / 60.0;
                    ui.label(ui::quiet(format!(
                        "{}. {practice}{} trials, about {:.0} min. A .toml file can also be dropped on this window.",
                        protocol.title,
                        protocol.main_trials(),
                        minutes.ceil() + 1.0
                    )));
                }
                (None, None) => {}
            }
        });
        if let Some(name) = chosen {
            self.choose_experiment(name);
        }
    }

    fn browse(&mut self, ui: &mut egui::Ui, field: Field, label: &str) {
        let button = ui.button("Browse…");
        button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, label));
        if button.clicked() {
            self.asking = Some(field);
            self.dialog.open(ui.ctx(), if let Field::Results = field { Ask::Folder } else { Ask::Toml });
        }
    }

    fn monitor_field(&mut self, ui: &mut egui::Ui, checked: &Checked, monitor: &Monitor, monitors: &[Monitor]) {
        let can_be_gray =
            self.form.gray || checked.protocol.as_ref().is_some_and(|protocol| protocol.in_gray().is_some());
        row(ui, "Screen", |ui, label| {
            ui.horizontal_wrapped(|ui| {
                if monitors.len() > 1 {
                    let shown = monitor.title();
                    egui::ComboBox::from_id_salt("monitor")
                        .selected_text(shown)
                        .width(300.0)
                        .show_ui(ui, |ui| {
                            for (i, monitor) in monitors.iter().enumerate() {
                                ui.selectable_value(&mut self.monitor_choice, Some(i), monitor.title());
                            }
                        })
                        .response
                        .labelled_by(label);
                } else {
                    ui.label(monitor.title());
                }
                ui.checkbox(&mut self.full_screen, "Full screen");
                if can_be_gray {
                    let gray = ui.checkbox(&mut self.form.gray, "In gray");
                    gray.on_hover_text(
                        "For someone with a color deficiency. The experiment's name then ends in -gray.",
                    );
                }
            });
        });
    }

    fn start(&mut self, ui: &mut egui::Ui) -> Step<Destination> {
        let Some((_, _, checked)) = &self.checked else { return Step::Stay };
        let text = if checked.resume { "Resume" } else { "Start" };
        let ready = checked.request().is_some();
        let mut clicked = false;
        row(ui, "", |ui, _| {
            if self.dialog.is_missing() {
                ui::fault(
                    ui,
                    "No file dialog opened on this system: type the path, or drop a definition on this window.",
                );
            }
            let hint = match (ready, checked.resume) {
                (false, _) => "Something above needs attention.",
                (true, true) => "This session was interrupted; it goes on with the trials that are missing.",
                (true, false) => "Enter starts too. Esc pauses at any time; every answer is saved at once.",
            };
            clicked = ui::primary(ui, text, ready, hint);
        });
        let typing = ui.ctx().memory(|memory| memory.focused().is_some());
        let entered = !typing && self.card.is_none() && ui.input(|input| input.key_pressed(Key::Enter));
        match checked.request() {
            Some(request) if clicked || entered => {
                let mut request = request.clone();
                request.windowed = !self.full_screen;
                if self.full_screen {
                    // Choosing a monitor makes the window full screen there.
                    ui.ctx().send_viewport_cmd(match self.monitor_choice {
                        Some(index) => ViewportCommand::SetMonitor(index),
                        None => ViewportCommand::Fullscreen(true),
                    });
                }
                Step::Next(Destination::Session(Box::new(request)))
            }
            _ => Step::Stay,
        }
    }

    /// Side of the stimulus that the definition plans, degrees.
    fn window_deg(&self) -> f64 {
        let protocol = self.checked.as_ref().and_then(|(_, _, checked)| checked.protocol.as_ref());
        protocol.map_or(10.0, |protocol| protocol.viewing.window_deg)
    }

    /// A Mach band to look at while deciding.
    fn example(&mut self, ui: &mut egui::Ui) {
        let texture = self.picture.get_or_insert_with(|| {
            let stimulus = Stimulus::MachBand(MachBand::default());
            pixels::texture(ui.ctx(), "example", &stimulus, PICTURE_PX, &Quantizer::new(&Transfer::Srgb, Bits::Eight))
        });
        ui.separator();
        ui.horizontal_top(|ui| {
            pixels::picture(ui, texture, "A dark and a bright area with a linear ramp between them");
            ui.vertical(|ui| {
                ui.label(RichText::new("Do you see a bright line?").strong());
                ui.label("On the right of the ramp, where it meets the bright area: that line is not in the picture.");
                ui.label("It is a Mach band. The session asks how visible it is in pictures like this one.");
            });
        });
    }

    fn card(&mut self, ctx: &egui::Context, monitor: &Monitor) {
        let Some(card) = &mut self.card else { return };
        match card.show(ctx, monitor.width_px) {
            CardOutcome::Open => return,
            CardOutcome::Closed => {}
            CardOutcome::Measured(width) => {
                self.form.screen.screen_width_cm = width.to_string();
                self.measured_cm = Some(width);
            }
        }
        self.card = None;
    }
}

/// The display profile that the form names; sRGB where it names none that can be read.
fn checked_display(checked: &Option<(Form, Monitor, Checked)>) -> DisplayProfile {
    checked.as_ref().and_then(|(_, _, checked)| checked.display.clone()).unwrap_or_default()
}

/// A label, and a field beside it or, where the window is narrow, below.
fn row(ui: &mut egui::Ui, label: &str, field: impl FnOnce(&mut egui::Ui, egui::Id)) {
    const LABEL: f32 = 190.0;
    let narrow = ui.available_width() < 520.0;
    let draw_label = |ui: &mut egui::Ui| ui.label(label).id;
    if narrow {
        let id = draw_label(ui);
        ui.vertical(|ui| field(ui, id));
    } else {
        ui.horizontal_top(|ui| {
            let id = ui
                .allocate_ui_with_layout(
                    egui::vec2(LABEL, 32.0),
                    egui::Layout::left_to_right(egui::Align::Center),
                    |ui| {
                        ui.set_min_width(LABEL);
                        draw_label(ui)
                    },
                )
                .inner;
            ui.vertical(|ui| field(ui, id));
        });
    }
}

fn text_field(ui: &mut egui::Ui, label: &str, text: &mut String, fault: Option<&str>, hint: &str) {
    row(ui, label, |ui, id| {
        ui.add(egui::TextEdit::singleline(text).desired_width(300.0).hint_text(hint)).labelled_by(id);
        if let Some(fault) = fault {
            ui::fault(ui, fault);
        }
    });
}
