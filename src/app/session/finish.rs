//! The last page: thanks the participant and plots their ratings. A closed section tells the experimenter where the data
//! are and how the frames were.

use std::{collections::BTreeMap, path::PathBuf};

use eframe::egui::{self, Key};
use egui_plot::{Corner, GridMark, Legend, Line, Points};

use crate::{
    app::ui::{self, Step, still_plot, theme},
    experiment::{Factor, Phase, Protocol, TrialRecord},
};

pub struct Finish {
    protocol: Protocol,
    path: PathBuf,
    /// Whether every planned trial is rated.
    complete: bool,
    /// The factor of the horizontal axis; `by` is the factor with one line per level.
    along: Option<Factor>,
    by: Option<Factor>,
    /// Name and points of each plotted line.
    lines: Vec<(String, Vec<[f64; 2]>)>,
    opened: Option<String>,
    /// One sentence about the frames of the sitting, if there were any.
    frames: Option<String>,
    /// The error if the end of the sitting could not be recorded.
    error: Option<String>,
}

impl Finish {
    /// Creates the last page of a completed or interrupted session.
    pub fn new(
        protocol: Protocol,
        rows: &[TrialRecord],
        path: PathBuf,
        complete: bool,
        frames: Option<String>,
        error: Option<String>,
    ) -> Self {
        let factors = &protocol.factors;
        let factor = |wanted: &str, other: usize| {
            factors.iter().find(|factor| factor.name == wanted).or_else(|| factors.get(other)).cloned()
        };
        let along = factor("width", 0);
        let by = factor("depth", 1).filter(|by| along.as_ref().is_none_or(|along| along.name != by.name));
        let lines = along.as_ref().map(|along| mean_lines(&protocol, rows, along, by.as_ref())).unwrap_or_default();
        Self { protocol, path, complete, along, by, lines, opened: None, frames, error }
    }

    /// Returns whether every planned trial is rated.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Draws the page. `direct`: leaving it closes the window.
    pub fn show(&mut self, ui: &mut egui::Ui, direct: bool) -> Step<PathBuf> {
        let texts = self.protocol.instructions.clone();
        let mut leave = false;
        let mut analyze = false;
        ui::page(ui, |ui| {
            if self.complete {
                ui.heading(&texts.thanks);
                ui.label(&texts.done);
            } else {
                ui.heading(&texts.left_heading);
                ui.label(&texts.left);
            }
            ui.add_space(8.0);
            if self.complete && self.protocol.session.own_means && !self.lines.is_empty() {
                self.plot(ui);
            }
            ui.add_space(8.0);
            if let Some(error) = &self.error {
                ui::show_error(
                    ui,
                    format!(
                        "The end of this sitting could not be recorded. Please call the experimenter. \
                    {error}"
                    ),
                );
            }
            leave = ui::neutral_primary(ui, if direct { &texts.close } else { &texts.back }, true, "Enter");
            ui.add_space(theme::LARGE_GAP);
            let section = egui::CollapsingHeader::new(ui::secondary(&texts.experimenter)).id_salt("experimenter");
            section.show(ui, |ui| analyze = self.details(ui));
        });
        let focused = ui.ctx().memory(|memory| memory.focused().is_some());
        let entered = !focused && ui.input(|input| input.key_pressed(Key::Enter));
        if let Some(data_set) = self.data_set().filter(|_| analyze) {
            return Step::Next(data_set);
        }
        Step::back_if(leave || entered)
    }

    /// Draws what only the experimenter needs; returns whether they want to analyze the results.
    fn details(&mut self, ui: &mut egui::Ui) -> bool {
        let texts = &self.protocol.instructions;
        ui.label(&texts.saved_in);
        ui.add(egui::Label::new(egui::RichText::new(self.path.display().to_string()).monospace()).wrap());
        let analyze = ui.horizontal_wrapped(|ui| {
            if ui.button(&texts.open_folder).clicked() {
                let folder = self.path.parent().unwrap_or(&self.path);
                self.opened = ui::open(folder);
            }
            // Participants who return must not see trends in their answers.
            self.complete && ui.button("Analyze these results…").clicked()
        });
        if let Some(frames) = &self.frames {
            ui::hint(ui, frames);
        }
        if let Some(error) = &self.opened {
            ui::show_error(ui, error);
        }
        analyze.inner
    }

    /// Returns the folder with all sessions of the experiment.
    fn data_set(&self) -> Option<PathBuf> {
        Some(self.path.parent()?.parent()?.to_owned())
    }

    fn plot(&self, ui: &mut egui::Ui) {
        let Some(along) = &self.along else { return };
        let lines = self.by.as_ref().map_or("experiment", |by| &by.name);
        ui.label(self.protocol.instructions.ratings.replace("{x}", &along.name).replace("{lines}", lines));
        let labels: Vec<String> = along.levels.iter().map(ToString::to_string).collect();
        let last = labels.len().saturating_sub(1) as f64;
        let (ink, highest) = (theme::ink(ui), self.protocol.response.highest());
        still_plot("ratings")
            .height(280.0)
            .include_x(-0.3)
            .include_x(last + 1.0)
            .include_y(-0.1)
            .include_y(f64::from(highest) + 0.1)
            .x_axis_label(along.name.clone())
            .y_axis_label(self.protocol.instructions.mean_rating.clone())
            .legend(Legend::default().position(Corner::RightTop))
            .x_grid_spacer(move |_| (0..=last as i64).map(|i| GridMark { value: i as f64, step_size: 1.0 }).collect())
            .y_grid_spacer(move |_| (0..=highest).map(|i| GridMark { value: f64::from(i), step_size: 1.0 }).collect())
            .x_axis_formatter(move |mark, _| {
                let index = mark.value.round();
                if index < 0.0 { String::new() } else { labels.get(index as usize).cloned().unwrap_or_default() }
            })
            .show(ui, |plot| {
                for (i, (name, points)) in self.lines.iter().enumerate() {
                    let (color, marker) = ink.series(i);
                    plot.line(Line::new(name, points.clone()).color(color).width(2.0));
                    plot.points(Points::new(name, points.clone()).shape(marker).radius(5.0).color(color));
                }
            });
    }
}

/// Returns the mean rating for each level, over the last attempts of the main trials. The horizontal position of a
/// level is its index.
fn mean_lines(
    protocol: &Protocol,
    rows: &[TrialRecord],
    along: &Factor,
    by: Option<&Factor>,
) -> Vec<(String, Vec<[f64; 2]>)> {
    // Later attempts overwrite earlier ones, because rows are in chronological order.
    let last: BTreeMap<u32, &TrialRecord> =
        rows.iter().filter(|row| row.phase == Phase::Main).map(|row| (row.trial, row)).collect();
    let index = |row: &TrialRecord, factor: &Factor| {
        let text = row.level(protocol, &factor.name)?;
        factor.levels.iter().position(|level| level.to_string() == text)
    };
    let mut ratings: BTreeMap<usize, BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
    for row in last.values() {
        let (Some(x), Some(rating)) = (index(row, along), row.rating) else { continue };
        let line = by.and_then(|by| index(row, by)).unwrap_or(0);
        ratings.entry(line).or_default().entry(x).or_default().push(rating.0.into());
    }
    let lines = ratings.into_iter().map(|(line, points)| {
        let name = by.map_or_else(|| "rating".to_owned(), |by| format!("{} {}", by.name, by.levels[line]));
        let mean = |(x, ratings): (usize, Vec<f64>)| [x as f64, ratings.iter().sum::<f64>() / ratings.len() as f64];
        (name, points.into_iter().map(mean).collect())
    });
    lines.collect()
}
