//! The timing tool: measures how regular frame intervals are.

use std::{path::Path, time::Duration};

use eframe::{
    egui::{CentralPanel, Color32, Frame, Key, Rect, RichText, Ui, Vec2},
    emath::GuiRounding as _,
};

use super::calibrate::{About, Findings, LABELS, Method, Run};
use crate::{
    app::ui::{Field, Monitor, Step, figure::FigureView, page, paragraph, theme::ink},
    display::{
        Channel, Viewing,
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

/// Says whether there is one frame per refresh, given how long each was shown, in microseconds; whether each thing that it
/// says deserves attention; and against which refresh it judged. That is the one that the monitor reports, or otherwise
/// the one that the frames follow. If the intervals scatter, the refresh is unknown, and no frame is judged.
pub fn judged_frames(intervals_us: &[u32], monitor: &Monitor) -> (Vec<(String, bool)>, Option<Refresh>) {
    let (refresh, source) = Refresh::known(monitor.refresh_hz, intervals_us);
    let (mut times, mut now) = (FrameTimes::default(), Duration::ZERO);
    times.begin(now, refresh);
    for interval in intervals_us {
        now += Duration::from_micros(u64::from(*interval));
        times.frame(now, refresh);
    }
    let ms = |p: f64| times.quantile(p).unwrap_or_default() * 1e3;
    let unknown = || "unknown".to_owned();
    let count = |number: Option<u64>| number.map_or_else(unknown, |number| number.to_string());
    let known = |refresh: Refresh| format!("{:.3} Hz, {:.3} ms, {source}", refresh.hz(), refresh.seconds() * 1e3);
    let (is_good, verdict) = verdict(&times, refresh);
    let rows = [
        ("Intervals", intervals_us.len().to_string()),
        ("Refresh", refresh.map_or_else(unknown, known)),
        ("Shortest", format!("{:.3} ms", ms(0.0))),
        ("1 %", format!("{:.3} ms", ms(0.01))),
        ("Median", format!("{:.3} ms", ms(0.5))),
        ("99 %", format!("{:.3} ms", ms(0.99))),
        ("Longest", format!("{:.3} ms", ms(1.0))),
        ("Dropped frames", count(times.dropped())),
        ("Missed refreshes", count(times.missed_refreshes())),
    ];
    let rows = rows.into_iter().map(|(name, value)| (format!("{name}: {value}"), false));
    ([(verdict, !is_good)].into_iter().chain(rows).collect(), refresh)
}

/// Returns whether there is one frame per refresh, and says so in one or two sentences.
fn verdict(times: &FrameTimes, refresh: Option<Refresh>) -> (bool, String) {
    let (count, ms) = (times.intervals_us().len(), |p: f64| times.quantile(p).unwrap_or_default() * 1e3);
    let Some(steady) = refresh.filter(|refresh| refresh.is_followed_by(times.intervals_us())) else {
        let judged = match refresh {
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
    let (hz, dropped) = (steady.hz(), times.dropped().unwrap_or_default());
    let percent = 100.0 * dropped as f64 / count as f64;
    let told = match dropped {
        0 => format!("Every refresh at {hz:.2} Hz showed a new frame: none of {count} was dropped."),
        _ => format!(
            "The frames follow the refresh rate of {hz:.2} Hz; dropped frames: {dropped} of {count} ({percent:.1} %). Close other programs."
        ),
    };
    (dropped == 0, told)
}

/// The settings.
#[derive(Default)]
pub struct Timing {
    /// Whether a patch alternates between black and white: a target for a photodiode.
    flickers: bool,
}

impl Method for Timing {
    fn about(&self) -> About {
        About {
            title: "Timing",
            purpose: "Find out whether every refresh shows a new frame: intervals and dropped frames.",
            introduction: "Every refresh of the screen should show a new frame. This tool measures whether it does.",
            items: "frames",
            format: None,
        }
    }

    fn fields(&mut self, ui: &mut Ui, _: Option<&Viewing>) {
        let show = Field::new("Show").column(LABELS);
        show.show(ui, |ui, _| ui.checkbox(&mut self.flickers, "A flickering patch"));
        if self.flickers {
            paragraph(ui, RichText::new(FLICKER_WARNING).color(ink(ui).warn));
        }
    }

    fn estimate(&self, _: &[Channel]) -> Result<(usize, f64), String> {
        Ok((FRAMES, FRAMES as f64 / 60.0))
    }

    fn begin(&self, _: &[Channel], _: &Path) -> Result<Box<dyn Run>, String> {
        let (warned, times) = (None, FrameTimes::default());
        Ok(Box::new(TimingRun { flickers: self.flickers, warned, frame: 0, times }))
    }
}

/// A measurement in progress.
struct TimingRun {
    flickers: bool,
    /// The window's time at which the warning began, seconds. Content that does not flicker needs no warning.
    warned: Option<f64>,
    frame: u32,
    times: FrameTimes,
}

impl Run for TimingRun {
    /// Draws a frame and requests the next one.
    fn show(&mut self, ui: &mut Ui, monitor: &Monitor) -> Step<Option<Findings>> {
        if ui.input(|input| input.key_pressed(Key::Escape)) {
            return Step::Back;
        }
        let now = ui.input(|input| input.time);
        ui.ctx().request_repaint();
        if self.flickers {
            let remaining_s = WARNING_S - (now - *self.warned.get_or_insert(now));
            if remaining_s > 0.0 {
                warn(ui, remaining_s);
                return Step::Stay;
            }
            draw_patch(ui, self.frame);
        }
        self.frame += 1;
        if self.frame > SETTLING {
            self.times.frame(Duration::try_from_secs_f64(now).unwrap_or_default(), None);
        }
        let measured = self.times.intervals_us();
        if measured.len() < FRAMES {
            return Step::Stay;
        }
        let (told, refresh) = judged_frames(measured, monitor);
        let figure = Some(FigureView::new(figures::intervals(measured, refresh)));
        Step::Next(Some(Findings { told, figure, ..Findings::default() }))
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
