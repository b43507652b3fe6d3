//! Preflight: what the screen really is, in plain sentences, before anything is measured on it.

mod asked;
mod screen;

use eframe::egui::{self, Key, ViewportCommand};

use self::asked::Asked;
use super::{
    frames::FrameStatistics,
    request::{Request, stimulus_side_px},
    trials::{Prepared, Trials},
};
use crate::{
    app::ui::{self, Monitor, Step, platform::Platform, theme, today, window_px},
    display::{Screen, Viewing, frames::Refresh},
    experiment::FrameCount,
    store::{
        dataset::SessionPaths,
        profile,
        sidecar::{PreflightNote, Sidecar},
    },
};

/// How long frames are measured, seconds, after the window has come to rest.
const MEASURE_S: f64 = 1.0;
/// And how many at least.
const MEASURE_FRAMES: u64 = 30;
/// Longest wait for the window to become full screen, seconds.
const SETTLE_S: f64 = 0.7;

/// The page.
pub struct Preflight {
    request: Request,
    /// What the sitting that was interrupted had.
    before: Option<Before>,
    since: Option<f64>,
    frames: FrameStatistics,
    /// What the system tells of the screen, looked up when the window has come to rest.
    platform: Option<Platform>,
    asked: Option<Asked>,
    /// How far light steps between field and picture.
    light_steps: PreflightNote,
    /// Why the session could not begin.
    refused: Option<String>,
}

/// The screen of an earlier sitting.
struct Before {
    /// In words.
    profile: String,
    /// Whether its profile is the one that is in use now.
    same_profile: bool,
    size_px: u64,
}

fn sitting_before(request: &Request) -> Option<Before> {
    let paths = SessionPaths::new(&request.results, &request.protocol, &request.identity);
    let sidecar = Sidecar::read(&paths.sidecar).ok()??;
    let sitting = sidecar.sittings.last()?;
    let display = sitting.display.as_ref()?;
    let transfer = display["transfer"].as_str()?;
    Some(Before {
        profile: format!("{} ({transfer})", display["name"].as_str().unwrap_or("a profile")),
        same_profile: match display["sha256"].as_str() {
            Some(hash) => hash == profile::hash(&request.display),
            None => transfer == request.display.transfers.to_string(),
        },
        size_px: sitting.viewing.as_ref()?["stimulus_px"].as_u64()?,
    })
}

/// What was found.
struct Findings {
    notes: Vec<PreflightNote>,
    prepared: Option<Prepared>,
}

impl Preflight {
    /// For a session; the window is on its way to full screen.
    pub fn new(request: Request) -> Self {
        let before = if request.resume { sitting_before(&request) } else { None };
        // A definition that was loaded has its conditions.
        let conditions = request.protocol.conditions().unwrap_or_default();
        let light_steps = screen::note(screen::light_steps(&request.protocol, &conditions));
        Self {
            request,
            before,
            since: None,
            frames: FrameStatistics::default(),
            platform: None,
            asked: None,
            light_steps,
            refused: None,
        }
    }

    /// Draws the page.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor) -> Step<Box<Trials>> {
        let now = ui.input(|input| input.time);
        let since = *self.since.get_or_insert(now);
        if self.measuring(now - since) {
            if now - since > SETTLE_S {
                self.frames.frame(now);
            }
            ui.ctx().request_repaint();
            ui::page(ui, |ui| {
                ui.heading("Before the session");
                ui.label("Measuring the screen…");
                ui.spinner();
            });
            return if ui.input(|input| input.key_pressed(Key::Escape)) { self.back(ui.ctx()) } else { Step::Stay };
        }
        let platform = self.platform.take().unwrap_or_else(|| Platform::look(monitor));
        let mut findings = self.findings(ui.ctx(), monitor, &platform);
        self.asked.get_or_insert_with(|| Asked::new(&platform, &self.request.display));
        self.platform = Some(platform);
        let (begin, back) = self.draw(ui, &findings);
        findings.notes.extend(self.asked.iter().flat_map(Asked::notes));
        if back {
            return self.back(ui.ctx());
        }
        match findings.prepared {
            Some(prepared) if begin => {
                match Trials::begin(ui.ctx(), &self.request, prepared, findings.notes, monitor) {
                    Ok(page) => Step::Next(Box::new(page)),
                    Err(error) => {
                        self.refused = Some(error.to_string());
                        Step::Stay
                    }
                }
            }
            _ => Step::Stay,
        }
    }

    fn measuring(&self, elapsed: f64) -> bool {
        elapsed < SETTLE_S + MEASURE_S || (self.frames.count() < MEASURE_FRAMES && elapsed < SETTLE_S + 5.0 * MEASURE_S)
    }

    fn back(&self, ctx: &egui::Context) -> Step<Box<Trials>> {
        if !self.request.windowed {
            ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
        }
        Step::Back
    }

    fn draw(&mut self, ui: &mut egui::Ui, findings: &Findings) -> (bool, bool) {
        let mut begin = false;
        let mut back = false;
        ui::page_from(ui, 0.02, |ui| {
            ui.heading("Before the session");
            ui.label(ui::quiet(format!(
                "{} · participant {} · session {} · Space continues, Esc goes back",
                self.request.protocol.title,
                self.request.identity.subject(),
                self.request.identity.session()
            )));
            ui.add_space(8.0);
            theme::compact(ui);
            for note in &findings.notes {
                ui.horizontal(|ui| {
                    ui::tick(ui, note.ok);
                    ui.add(egui::Label::new(&note.sentence).wrap());
                });
            }
            ui.add_space(8.0);
            if let Some(asked) = &mut self.asked {
                ui.label(egui::RichText::new("Please look yourself").strong());
                ui.label(ui::quiet("No program can tell these. What is not ticked is recorded as not confirmed."));
                asked.show(ui);
            }
            ui.add_space(16.0);
            if let Some(refused) = &self.refused {
                ui::fault(ui, refused);
            }
            begin = ui::primary(
                ui,
                "Continue",
                findings.prepared.is_some(),
                "Space. These findings are kept with the data.",
            );
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                back = ui.button("Back").clicked();
                ui.label(ui::quiet("Esc"));
            });
        });
        let focused = ui.ctx().memory(|memory| memory.focused().is_some());
        let key = |key| !focused && ui.input(|input| input.key_pressed(key));
        (begin || key(Key::Space) || key(Key::Enter), back || ui.input(|input| input.key_pressed(Key::Escape)))
    }

    fn findings(&self, ctx: &egui::Context, monitor: &Monitor, platform: &Platform) -> Findings {
        let mut notes = Vec::new();
        let mut note = |check: &str, ok: bool, sentence: String| {
            notes.push(PreflightNote { check: check.to_owned(), ok, sentence });
        };
        let name = monitor.name.as_ref().map_or_else(|| "without a name".to_owned(), |name| format!("{name:?}"));
        note("monitor", true, format!("Monitor {name}, {} × {} pixels.", monitor.width_px, monitor.height_px));

        let window = window_px(ctx);
        let whole = window == (monitor.width_px, monitor.height_px);
        note(
            "full_screen",
            whole || self.request.windowed,
            match (self.request.windowed, whole) {
                (true, _) => format!(
                    "The session runs in a window of {} × {} pixels, as asked; other things on the screen may distract.",
                    window.0, window.1
                ),
                (false, true) => "The window has the whole screen.".to_owned(),
                (false, false) => format!(
                    "The window has {} × {} pixels and not the whole screen; the window system did not give it.",
                    window.0, window.1
                ),
            },
        );
        let points = f64::from(ctx.pixels_per_point());
        note(
            "scale",
            true,
            format!("The system's scale is {points}; stimuli are drawn in physical pixels whatever it is."),
        );

        // The mode's own timing is exact; what the window is told is rounded.
        let refresh_hz = platform.refresh_hz.or(monitor.refresh_hz);
        let median = self.frames.quantile(0.5);
        let steady = match (median, self.frames.quantile(0.99)) {
            (Some(median), Some(slow)) => slow <= 1.5 * median,
            _ => false,
        };
        note(
            "refresh",
            refresh_hz.is_some(),
            match refresh_hz {
                Some(hz) => format!("The system reports {hz:.3} Hz."),
                None => "The system does not report a refresh rate; the measured frame interval stands in for it."
                    .to_owned(),
            },
        );
        note(
            "frame_interval",
            steady,
            match (median, self.frames.quantile(0.99)) {
                (Some(median), Some(slow)) => format!(
                    "Frames came every {:.1} ms ({:.1} Hz); 99 % of them within {:.1} ms{}",
                    median * 1e3,
                    1.0 / median,
                    slow * 1e3,
                    if steady { "." } else { ": not steady, so close other programs." }
                ),
                _ => "No frames could be measured.".to_owned(),
            },
        );
        let display = &self.request.display;
        let of_the_screen = screen::path_to_the_screen(platform).into_iter();
        for (check, ok, sentence) in of_the_screen.chain(screen::profile(display, monitor, platform, today())) {
            note(check, ok, sentence);
        }

        let measured = self.frames.refresh().filter(|_| steady);
        let interval = refresh_hz.map(|hz| 1.0 / hz).or(measured.map(Refresh::seconds));
        let prepared = self.geometry(monitor, window, &mut note).map(|(viewing, size_px)| Prepared {
            viewing,
            size_px,
            frames: interval.map_or(FrameCount::Frames, FrameCount::Against),
            refresh_source: match (refresh_hz, measured) {
                (Some(_), _) => "reported",
                (None, Some(_)) => "measured",
                (None, None) => "unknown",
            },
            window,
        });
        if let (Some(Before { profile, same_profile, size_px }), Some(now)) = (&self.before, &prepared) {
            let same = *same_profile && *size_px == u64::from(now.size_px);
            note(
                "same_as_before",
                same,
                if same {
                    "Display profile and stimulus size are those of the sitting before.".to_owned()
                } else {
                    format!(
                        "The sitting before had the display profile {profile} and a stimulus of {size_px} pixels: go back and restore that, unless you mean to change it."
                    )
                },
            );
        }
        notes.push(self.light_steps.clone());
        Findings { notes, prepared }
    }

    fn geometry(
        &self,
        monitor: &Monitor,
        window: (u32, u32),
        note: &mut impl FnMut(&str, bool, String),
    ) -> Option<(Viewing, u32)> {
        let width_cm = self.request.screen_width_cm.or(self.request.display.screen_width_cm);
        let assumed = width_cm.unwrap_or_else(|| monitor.assumed_width_cm());
        let viewing = Screen::new(monitor.width_px, monitor.height_px, assumed)
            .and_then(|screen| Viewing::new(screen, self.request.distance_cm));
        let viewing = match viewing {
            Ok(viewing) => viewing,
            Err(error) => {
                note("geometry", false, format!("{error}."));
                return None;
            }
        };
        note(
            "physical_size",
            width_cm.is_some(),
            match width_cm {
                Some(cm) => format!(
                    "The screen is {cm:.1} cm wide; at {} cm a degree is {:.1} pixels.",
                    self.request.distance_cm,
                    viewing.px_per_degree()
                ),
                None => format!(
                    "The screen's width is not known; {assumed:.1} cm is assumed from 96 pixels an inch. At {} cm a degree is {:.1} pixels.",
                    self.request.distance_cm,
                    viewing.px_per_degree()
                ),
            },
        );
        let deg = self.request.protocol.viewing.window_deg;
        let size_px = stimulus_side_px(&viewing, deg);
        let least = window.0.min(window.1);
        let fits = size_px <= least;
        note(
            "stimulus_fits",
            fits,
            if fits {
                format!("The stimulus of {deg}° is {size_px} × {size_px} pixels and fits.")
            } else {
                format!(
                    "The stimulus of {deg}° would be {size_px} × {size_px} pixels, and the window has {} × {}: sit closer, or use a larger screen.",
                    window.0, window.1
                )
            },
        );
        fits.then_some((viewing, size_px))
    }
}
