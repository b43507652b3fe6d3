//! The timing tool: measures how regular frame intervals are, and shows them in a table and a plot.

use std::{path::PathBuf, time::Duration};

use eframe::{
    egui::{self, CentralPanel, Color32, Frame, Key, Rect, RichText, Ui, Vec2},
    emath::GuiRounding as _,
};

use super::calibrate::{Tool, full_screen};
use crate::{
    app::ui::{
        Field, Monitor, Step, figure::FigureView, neutral_primary, page, paragraph, secondary, theme::ink, tool_page,
    },
    display::{
        Viewing,
        frames::{FrameTimes, Refresh},
    },
    report::figures,
};

/// Frames to measure.
const FRAMES: usize = 600;
/// Frames that are skipped before the measurement while caches fill and the window settles.
const SETTLING: u32 = 30;
/// How long the warning is shown before something flickers, seconds.
const WARNING_S: f64 = 3.0;
/// The safety warning that precedes a flickering patch.
const FLICKER_WARNING: &str = "A patch will flicker between black and white with every frame. Flicker can cause seizures in people with photosensitive epilepsy: do not look at it, and keep anyone at risk from looking at it.";
/// Side of the patch, which is small so that it stimulates as little of the retina as possible, and its distance from the
/// upper left corner of the screen, where a photodiode can be held, physical pixels.
const PATCH_PX: f32 = 96.0;
const MARGIN_PX: f32 = 16.0;

/// Frame intervals and the refresh against which they are judged.
#[derive(Clone, Debug, PartialEq)]
pub struct TimingReport {
    /// The intervals, judged against the refresh if it is known.
    times: FrameTimes,
    /// The refresh of the screen, if known.
    pub refresh: Option<Refresh>,
    /// The source of the refresh: `reported`, `measured` or `unknown`.
    pub source: &'static str,
}

impl TimingReport {
    /// Judges intervals in microseconds. The refresh is the one that the monitor reports, or otherwise the one that the
    /// frames follow. If the intervals scatter, the refresh is unknown, and no frame is judged.
    pub fn new(intervals_us: &[u32], monitor: &Monitor) -> Self {
        let (refresh, source) = Refresh::known(monitor.refresh_hz, intervals_us);
        let mut times = FrameTimes::default();
        let mut now = Duration::ZERO;
        times.frame(now, refresh);
        for interval in intervals_us {
            now += Duration::from_micros(u64::from(*interval));
            times.frame(now, refresh);
        }
        Self { times, refresh, source }
    }

    /// Returns how long each frame was shown, in microseconds.
    pub fn intervals_us(&self) -> &[u32] {
        self.times.intervals_us()
    }

    /// Returns the findings as rows of a name and a value.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let ms = |p: f64| self.times.quantile(p).map_or_else(String::new, |s| format!("{:.3} ms", s * 1e3));
        let count = |number: Option<u64>| number.map_or_else(|| "unknown".to_owned(), |number| number.to_string());
        vec![
            ("intervals", self.intervals_us().len().to_string()),
            (
                "refresh",
                self.refresh.map_or_else(
                    || "unknown".to_owned(),
                    |refresh| format!("{:.3} Hz, {:.3} ms, {}", refresh.hz(), refresh.seconds() * 1e3, self.source),
                ),
            ),
            ("shortest", ms(0.0)),
            ("1 %", ms(0.01)),
            ("median", ms(0.5)),
            ("99 %", ms(0.99)),
            ("longest", ms(1.0)),
            ("dropped frames", count(self.times.dropped())),
            ("missed refreshes", count(self.times.missed_refreshes())),
        ]
    }

    /// Returns whether there is one frame per refresh, and says so in one or two sentences.
    pub fn verdict(&self) -> (bool, String) {
        let (count, ms) = (self.intervals_us().len(), |p: f64| self.times.quantile(p).unwrap_or_default() * 1e3);
        let Some(refresh) = self.refresh.filter(|refresh| refresh.is_followed_by(self.intervals_us())) else {
            let judged = match self.refresh {
                Some(refresh) => format!("not even the {:.2} Hz that the system reports", refresh.hz()),
                None => "so no frame can be judged as dropped".to_owned(),
            };
            let told = format!(
                "The frames do not follow a steady refresh, {judged}: 98 % of their intervals are between {:.1} and {:.1} \
                    ms. Close other programs and measure in full screen.",
                ms(0.01),
                ms(0.99)
            );
            return (false, told);
        };
        let (hz, dropped) = (refresh.hz(), self.times.dropped().unwrap_or_default());
        let percent = 100.0 * dropped as f64 / count as f64;
        let told = match dropped {
            0 => format!("Every refresh at {hz:.2} Hz showed a new frame: none of {count} was dropped."),
            _ => format!(
                "The frames follow the refresh rate of {hz:.2} Hz; dropped frames: {dropped} of {count} ({percent:.1} %). Close other programs."
            ),
        };
        (dropped == 0, told)
    }
}

/// A measurement in progress.
#[derive(Default)]
struct TimingRun {
    /// Whether a patch alternates between black and white: a target for a photodiode.
    flickers: bool,
    /// The window's time at which the warning began, seconds. Content that does not flicker needs no warning.
    warned: Option<f64>,
    frame: u32,
    times: FrameTimes,
}

impl TimingRun {
    /// Draws a frame and requests the next one; returns the report once all frames are measured.
    fn show(&mut self, ui: &mut Ui, monitor: &Monitor) -> Option<TimingReport> {
        let now = ui.input(|input| input.time);
        ui.ctx().request_repaint();
        if self.flickers {
            let remaining_s = WARNING_S - (now - *self.warned.get_or_insert(now));
            if remaining_s > 0.0 {
                warn(ui, remaining_s);
                return None;
            }
            draw_patch(ui, self.frame);
        }
        self.frame += 1;
        if self.frame > SETTLING {
            self.times.frame(Duration::try_from_secs_f64(now).unwrap_or_default(), None);
        }
        let measured = self.times.intervals_us();
        (measured.len() >= FRAMES).then(|| TimingReport::new(measured, monitor))
    }
}

fn draw_patch(ui: &mut Ui, frame: u32) {
    CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
        let scale = ui.ctx().pixels_per_point();
        let corner = (ui.ctx().content_rect().min + Vec2::splat(MARGIN_PX / scale)).round_to_pixels(scale);
        let color = if frame.is_multiple_of(2) { Color32::WHITE } else { Color32::BLACK };
        ui.painter().rect_filled(Rect::from_min_size(corner, Vec2::splat(PATCH_PX / scale)), 0.0, color);
    });
}

fn warn(ui: &mut Ui, remaining_s: f64) {
    page(ui, |ui| {
        ui.heading("Flicker");
        paragraph(ui, FLICKER_WARNING);
        ui.label(format!("It begins in {:.0} s. Press Esc to stop.", remaining_s.ceil()));
    });
}

#[derive(Default)]
pub struct TimingTool {
    flickers: bool,
    run: Option<TimingRun>,
    found: Option<(TimingReport, FigureView)>,
}

impl TimingTool {
    fn settings(&mut self, ui: &mut egui::Ui) {
        Field::new("Show").show(ui, |ui, _| ui.checkbox(&mut self.flickers, "A flickering patch"));
        if self.flickers {
            paragraph(ui, RichText::new(FLICKER_WARNING).color(ink(ui).warn));
        }
        ui.add_space(4.0);
    }

    fn show_found(&mut self, ui: &mut egui::Ui) {
        let Some((report, figure)) = &mut self.found else { return };
        let (is_one_by_one, told) = report.verdict();
        let color = if is_one_by_one { ink(ui).good } else { ink(ui).warn };
        paragraph(ui, RichText::new(told).strong().color(color));
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
    }
}

impl Tool for TimingTool {
    fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor, _: Option<&Viewing>) -> Step<PathBuf> {
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
                self.run = Some(TimingRun { flickers: self.flickers, ..TimingRun::default() });
                full_screen(ui.ctx(), true);
            }
            ui.add_space(12.0);
            self.show_found(ui);
        }))
    }

    fn pause(&mut self, ctx: &egui::Context) {
        self.run = None;
        full_screen(ctx, false);
    }

    fn ground(&self) -> Option<Color32> {
        self.run.is_some().then_some(Color32::BLACK)
    }
}
