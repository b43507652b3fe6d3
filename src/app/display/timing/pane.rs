//! How evenly this screen shows frames: a patch that flips with each of them, a table and a plot.

use std::path::PathBuf;

use eframe::egui::{self, Color32, Key, ViewportCommand};
use egui_plot::{HLine, Plot, Points};

use super::super::{ToolGo, tool};
use crate::{
    app::{
        Monitor, theme,
        timing::{Patch, Place, Plan, Run, SceneKind, TimingReport, WARNING, table},
    },
    report::figures,
    store,
};

/// Numbers of frames to choose from.
const FRAMES: [u32; 4] = [300, 600, 1800, 3600];
/// Sides of the patch to choose from, physical pixels.
const SIZES: [u32; 4] = [48, 96, 192, 384];

/// The tool.
pub struct TimingPane {
    plan: Plan,
    run: Option<Run>,
    report: Option<TimingReport>,
    out: String,
    said: Option<Result<String, String>>,
}

impl Default for TimingPane {
    fn default() -> Self {
        let plan = Plan { scene: SceneKind::Trial, frames: 600, patch: Patch::default() };
        Self { plan, run: None, report: None, out: "timing.csv".to_owned(), said: None }
    }
}

impl TimingPane {
    /// Draws the measurement, or what is set and was found.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor) -> ToolGo {
        let escaped = ui.input(|input| input.key_pressed(Key::Escape));
        if let Some(run) = &mut self.run {
            let report = run.show(ui, monitor, None);
            if report.is_some() || escaped {
                self.report = report.or(self.report.take());
                self.run = None;
                ui.ctx().send_viewport_cmd(ViewportCommand::Fullscreen(false));
            }
            return ToolGo::Stay;
        }
        let mut back = escaped;
        tool(ui, "Timing", &mut back, |ui| {
            ui.label("Frames should follow the screen's refresh one by one. This measures whether they do.");
            ui.add_space(8.0);
            self.settings(ui);
            if theme::primary(ui, "Measure", true, "Full screen. Esc stops.") {
                self.said = None;
                self.run = Some(Run::new(self.plan));
                ui.ctx().send_viewport_cmd(ViewportCommand::Fullscreen(true));
                ui.ctx().request_repaint();
            }
            ui.add_space(12.0);
            self.found(ui);
        });
        if back { ToolGo::Back } else { ToolGo::Stay }
    }

    /// What stands behind everything while frames are measured.
    pub fn ground(&self) -> Option<Color32> {
        self.run.as_ref().map(Run::ground)
    }

    fn settings(&mut self, ui: &mut egui::Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.label("Shown");
            ui.radio_value(&mut self.plan.scene, SceneKind::Trial, "The screen of a trial");
            ui.radio_value(&mut self.plan.scene, SceneKind::Patch, "A patch that flips");
        });
        choice(ui, "Frames", &mut self.plan.frames, FRAMES, |frames| frames.to_string());
        if self.plan.scene == SceneKind::Patch {
            choice(ui, "Side of the patch, pixels", &mut self.plan.patch.size_px, SIZES, |size| size.to_string());
            let places = [Place::Corner, Place::Center];
            choice(ui, "Place", &mut self.plan.patch.place, places, |place| {
                let text = if place == Place::Corner { "upper left corner" } else { "centre" };
                text.to_owned()
            });
            ui.add(egui::Label::new(egui::RichText::new(WARNING).color(theme::NOTE)).wrap());
        }
        ui.add_space(4.0);
    }

    fn found(&mut self, ui: &mut egui::Ui) {
        let Some(report) = &self.report else { return };
        verdict(ui, report);
        ui.add_space(4.0);
        table(ui, report);
        ui.add_space(8.0);
        plot(ui, report);
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Export to");
            ui.add(egui::TextEdit::singleline(&mut self.out).desired_width(260.0)).labelled_by(label.id);
            if ui.button("Export").clicked() {
                self.said = Some(export(report, &PathBuf::from(self.out.trim())));
            }
        });
        match &self.said {
            Some(Ok(said)) => _ = ui.add(egui::Label::new(theme::quiet(said)).wrap()),
            Some(Err(fault)) => theme::fault(ui, fault),
            None => {}
        }
    }
}

/// Whether the frames do what the page asks.
fn verdict(ui: &mut egui::Ui, report: &TimingReport) {
    let color = if report.is_one_by_one() == Some(true) { theme::GOOD } else { theme::NOTE };
    ui.add(egui::Label::new(egui::RichText::new(report.verdict()).strong().color(color)).wrap());
}

/// The intervals, and beside them their plot.
fn export(report: &TimingReport, path: &std::path::Path) -> Result<String, String> {
    let plot = path.with_extension("svg");
    let svg = figures::intervals(report.intervals_us(), report.refresh);
    store::write_file(path, report.csv().as_bytes()).map_err(|error| error.to_string())?;
    store::write_file(&plot, svg.as_bytes()).map_err(|error| error.to_string())?;
    Ok(format!("Written: {} and {}", path.display(), plot.display()))
}

fn choice<T: Copy + PartialEq, const N: usize>(
    ui: &mut egui::Ui,
    name: &str,
    chosen: &mut T,
    values: [T; N],
    text: impl Fn(T) -> String,
) {
    ui.horizontal(|ui| {
        let label = ui.label(name);
        egui::ComboBox::from_id_salt(name)
            .selected_text(text(*chosen))
            .show_ui(ui, |ui| {
                for value in values {
                    ui.selectable_value(chosen, value, text(value));
                }
            })
            .response
            .labelled_by(label.id);
    });
}

fn plot(ui: &mut egui::Ui, report: &TimingReport) {
    let points: Vec<[f64; 2]> =
        (1..).zip(report.intervals_us()).map(|(frame, us)| [f64::from(frame), f64::from(*us) * 1e-3]).collect();
    Plot::new("intervals")
        .height(220.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .include_y(0.0)
        .x_axis_label("frame")
        .y_axis_label("interval, ms")
        .show(ui, |plot| {
            if let Some(refresh) = report.refresh {
                plot.hline(HLine::new("refresh", refresh.seconds() * 1e3).color(theme::QUIET));
            }
            plot.points(Points::new("interval", points).radius(1.5).color(Color32::from_rgb(0x56, 0xb4, 0xe9)));
        });
}
