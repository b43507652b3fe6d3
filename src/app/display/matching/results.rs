//! What comes of a run: γ with its spread, what speaks against it, and the way to a profile.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Key};
use egui_plot::{Legend, Line, Plot, PlotPoints, Points};

use super::{
    super::{Saved, signed},
    Trials, tool,
};
use crate::{
    app::{display::check::capital, theme, today},
    display::{
        DisplayProfile, Measurement,
        matching::{Channel, ChannelEstimate, Estimates, estimate},
    },
};

/// The page.
pub struct Results {
    estimates: Estimates,
    /// With the new transfer functions; `None` where there are none.
    profile: Option<DisplayProfile>,
    name: String,
    by: String,
    path: String,
    answers: PathBuf,
    said: Option<String>,
    /// Asked to leave without a profile saved.
    leaving: bool,
}

/// Where the page leads.
pub enum Go {
    Stay,
    Again,
    Check(Box<DisplayProfile>),
    Saved(Saved),
}

impl Results {
    /// Of a run that is done; what it did not measure comes from the profile in use.
    pub fn new(in_use: &DisplayProfile, trials: &Trials, path: &Path) -> Self {
        let estimates = estimate(trials.plan(), trials.observations());
        let measured = Measurement { on: Some(today()), by: None, with: Some(estimates.with()) };
        let profile = estimates.transfers().map(|transfers| DisplayProfile {
            transfers,
            measured: Some(measured),
            ..in_use.clone()
        });
        Self {
            estimates,
            profile,
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            by: String::new(),
            path: path.display().to_string(),
            answers: trials.file().to_owned(),
            said: None,
            leaving: false,
        }
    }

    /// Draws the page.
    pub fn show(&mut self, ui: &mut egui::Ui) -> Go {
        let (mut back, mut again, mut go) = (false, false, Go::Stay);
        tool(ui, "Gamma by eye: the result", &mut back, |ui| {
            for channel in &self.estimates.channels {
                ui.label(sentence(channel));
            }
            ui.add_space(4.0);
            for doubt in self.estimates.doubts() {
                ui.horizontal(|ui| {
                    theme::mark(ui, false);
                    ui.add(egui::Label::new(doubt.to_string()).wrap());
                });
            }
            ui.add_space(8.0);
            if self.profile.is_some() {
                self.save(ui, &mut go);
            }
            if self.leaving {
                theme::fault(ui, "The profile is not saved. Once more leaves it; the answers stay in their file.");
            }
            again = ui.button("Match again…").clicked();
            ui.add(egui::Label::new(theme::quiet(format!("All answers: {}", self.answers.display()))).wrap());
            ui.add_space(8.0);
            plot(ui, &self.estimates);
            levels(ui, &self.estimates);
        });
        if !back && !again && !ui.input(|input| input.key_pressed(Key::Escape)) {
            return go;
        }
        // Minutes of work go with one key.
        let sure = self.leaving || self.profile.is_none();
        self.leaving = true;
        if sure { Go::Again } else { Go::Stay }
    }

    fn save(&mut self, ui: &mut egui::Ui, go: &mut Go) {
        for (label, text) in
            [("Name of the profile", &mut self.name), ("Measured by", &mut self.by), ("Save as", &mut self.path)]
        {
            ui.horizontal_wrapped(|ui| {
                let label = ui.label(label);
                ui.add(egui::TextEdit::singleline(text).desired_width(340.0)).labelled_by(label.id);
            });
        }
        let path = PathBuf::from(self.path.trim());
        if path.exists() {
            ui.add(egui::Label::new(theme::quiet("This file exists, and will be replaced.")).wrap());
        }
        if let Some(said) = &self.said {
            theme::fault(ui, said);
        }
        ui.horizontal_wrapped(|ui| {
            if ui.button("Check on the screen…").clicked()
                && let Some(profile) = self.named()
            {
                *go = Go::Check(Box::new(profile));
            }
            if theme::primary(ui, "Save and use", !self.name.trim().is_empty(), "")
                && let Some(named) = self.named()
            {
                match Saved::write(path, &named) {
                    Ok(saved) => *go = Go::Saved(saved),
                    Err(error) => self.said = Some(error.to_string()),
                }
            }
        });
    }

    fn named(&self) -> Option<DisplayProfile> {
        let mut profile = self.profile.clone()?;
        self.name.trim().clone_into(&mut profile.name);
        if let Some(measured) = &mut profile.measured {
            measured.by = Some(self.by.trim().to_owned()).filter(|by| !by.is_empty());
        }
        Some(profile)
    }
}

fn sentence(channel: &ChannelEstimate) -> String {
    let name = capital(channel.channel);
    match &channel.fit {
        Ok(fit) => format!(
            "{name}: gamma {:.2}, 95 % within {:.2} to {:.2}, from {} answers; differences of {:.1} % were told.",
            fit.gamma,
            fit.interval[0],
            fit.interval[1],
            fit.answers,
            fit.threshold() * 100.0
        ),
        Err(error) => format!("{name}: no gamma, since {error}."),
    }
}

fn plot(ui: &mut egui::Ui, estimates: &Estimates) {
    let response = Plot::new("nulling")
        .height(260.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .x_axis_label("code")
        .y_axis_label("light, of full light")
        .legend(Legend::default().position(egui_plot::Corner::LeftTop))
        .show(ui, |plot| {
            for channel in &estimates.channels {
                let Ok(fit) = &channel.fit else { continue };
                let (name, color) = (channel.channel.to_string(), color(channel.channel));
                let curve: PlotPoints<'_> =
                    (0..=255).map(|code| [f64::from(code), (f64::from(code) / 255.0).powf(fit.gamma)]).collect();
                plot.line(Line::new(name.clone(), curve).color(color).width(1.5));
                let points: Vec<[f64; 2]> = channel.levels.iter().map(|level| [level.code, level.share]).collect();
                plot.points(Points::new(name.clone(), points).radius(4.5).color(color));
                for level in &channel.levels {
                    let ends = [-1.0, 1.0].map(|side| [level.code + side * 1.96 * level.code_error, level.share]);
                    plot.line(Line::new(name.clone(), ends.to_vec()).color(color).width(3.0));
                }
            }
        })
        .response;
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Plot of the matches and of gamma"));
}

fn color(channel: Channel) -> egui::Color32 {
    match channel {
        Channel::Red => egui::Color32::from_rgb(0xe0, 0x60, 0x50),
        Channel::Green => egui::Color32::from_rgb(0x60, 0xc0, 0x70),
        Channel::Blue => egui::Color32::from_rgb(0x70, 0xa0, 0xf0),
        Channel::Gray => egui::Color32::from_gray(0xd0),
    }
}

/// What each level says by itself.
fn levels(ui: &mut egui::Ui, estimates: &Estimates) {
    egui::ScrollArea::horizontal().id_salt("levels").show(ui, |ui| {
        egui::Grid::new("levels").striped(true).num_columns(5).spacing([18.0, 2.0]).show(ui, |ui| {
            for name in ["channel", "light of the field", "matched code", "answers", "gamma gives"] {
                ui.label(theme::quiet(name));
            }
            ui.end_row();
            for channel in &estimates.channels {
                for level in &channel.levels {
                    ui.label(channel.channel.to_string());
                    ui.label(format!("{:.3}", level.share));
                    let sd = level.code_sd.map_or_else(String::new, |sd| format!(" (SD {sd:.1})"));
                    ui.label(format!("{:.1} ± {:.1}{sd}", level.code, level.code_error));
                    ui.label(level.answers.to_string());
                    ui.label(format!("{} % light", signed(&format!("{:+.1}", level.excess * 100.0))));
                    ui.end_row();
                }
            }
        });
    });
}
