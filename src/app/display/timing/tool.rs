//! The timing tool: settings, a table, and a plot of the frame intervals.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Color32, Key, RichText, ViewportCommand};

use super::{
    report::TimingReport,
    run::{FLICKER_WARNING, Patch, Place, Scene, TimingPlan, TimingRun},
};
use crate::{
    app::{
        display::tool::Tool,
        ui::{
            Field, Monitor, Saving, ScreenFields, Step, figure::FigureView, neutral_primary, paragraph, secondary,
            theme::ink, tool_page,
        },
    },
    report::figures,
    store::{StoreError, Writer},
};

/// The choices for the number of frames.
const FRAMES: [u32; 4] = [300, 600, 1800, 3600];
/// The choices for the side of the patch, physical pixels.
const SIZES: [u32; 4] = [48, 96, 192, 384];

pub struct TimingTool {
    plan: TimingPlan,
    run: Option<TimingRun>,
    found: Option<(TimingReport, FigureView)>,
    out: String,
    saving: Saving,
}

impl Default for TimingTool {
    fn default() -> Self {
        let plan = TimingPlan { scene: Scene::Trial, frames: 600, patch: Patch::default() };
        Self { plan, run: None, found: None, out: "timing.csv".to_owned(), saving: Saving::default() }
    }
}

impl TimingTool {
    fn settings(&mut self, ui: &mut egui::Ui) {
        let TimingPlan { scene, frames, patch } = &mut self.plan;
        Field::new("Show").radio(
            ui,
            scene,
            &[(Scene::Trial, "The screen of a trial"), (Scene::Patch, "A flickering patch")],
        );
        Field::new("Frames").choice(ui, frames, &FRAMES, u32::to_string);
        if *scene == Scene::Patch {
            Field::new("Patch size, pixels").choice(ui, &mut patch.size_px, &SIZES, u32::to_string);
            let places = [(Place::Corner, "Upper-left corner"), (Place::Center, "Center")];
            Field::new("Patch position").radio(ui, &mut patch.place, &places);
            paragraph(ui, RichText::new(FLICKER_WARNING).color(ink(ui).warn));
        }
        ui.add_space(4.0);
    }

    fn show_found(&mut self, ui: &mut egui::Ui) {
        let Some((report, figure)) = &mut self.found else { return };
        let color = if report.is_one_by_one() == Some(true) { ink(ui).good } else { ink(ui).warn };
        paragraph(ui, RichText::new(report.verdict()).strong().color(color));
        ui.add_space(4.0);
        egui::Grid::new("timing").num_columns(2).spacing([24.0, 4.0]).show(ui, |ui| {
            for (name, value) in report.rows() {
                ui.label(secondary(name));
                ui.label(value);
                ui.end_row();
            }
        });
        ui.add_space(8.0);
        figure.show(ui);
        Field::new("Export to").show(ui, |ui, label| {
            ui.add(egui::TextEdit::singleline(&mut self.out).desired_width(260.0)).labelled_by(label);
            let path = Path::new(self.out.trim());
            if let Some(writer) = self.saving.button(ui, "Export", true, path, &[]) {
                self.saving.finish(path, export(&writer, report, path));
            }
        });
        self.saving.show(ui);
    }
}

impl Tool for TimingTool {
    fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor, _: &mut ScreenFields) -> Step<PathBuf> {
        if let Some(run) = &mut self.run {
            let report = run.show(ui, monitor);
            if report.is_some() || ui.input(|input| input.key_pressed(Key::Escape)) {
                let drawn = |report: TimingReport| {
                    let figure = figures::intervals(report.intervals_us(), report.refresh);
                    (report, FigureView::new(figure))
                };
                self.found = report.map(drawn).or(self.found.take());
                self.pause(ui.ctx());
            }
            return Step::Stay;
        }
        Step::back_if(tool_page(ui, "Timing", |ui| {
            ui.label("Every refresh of the screen should show a new frame. This tool measures whether it does.");
            ui.add_space(8.0);
            self.settings(ui);
            if neutral_primary(ui, "Measure", true, "Full screen. Press Esc to stop.") {
                self.saving = Saving::default();
                self.run = Some(TimingRun::new(self.plan));
                ui.ctx().send_viewport_cmd(ViewportCommand::Fullscreen(true));
                ui.ctx().request_repaint();
            }
            ui.add_space(12.0);
            self.show_found(ui);
        }))
    }

    fn pause(&mut self, ctx: &egui::Context) {
        self.run = None;
        ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
    }

    fn ground(&self) -> Option<Color32> {
        self.run.as_ref().map(TimingRun::ground)
    }
}

/// Writes the intervals as CSV and their plot as SVG; returns a message for the user.
fn export(writer: &Writer, report: &TimingReport, path: &Path) -> Result<String, StoreError> {
    let plot = path.with_extension("svg");
    let svg = figures::intervals(report.intervals_us(), report.refresh).svg;
    writer.write_all(&[(path.to_owned(), report.csv().into_bytes()), (plot.clone(), svg.into_bytes())])?;
    Ok(format!("Wrote {} and {}.", path.display(), plot.display()))
}
