//! What the vision model predicts for stimuli in the gallery: immediately if the stimulus varies in one direction, and
//! otherwise on a separate thread. The bands of a ramp are marked along its profile; all else is numbers.

use eframe::egui;

use crate::{
    app::ui::{self, work::Latest},
    display::{DisplayProfile, LuminanceRange, Screen, Viewing},
    stimulus::{Stimulus, ViewingConditions, Visible},
    vision::RampBands,
};

/// The viewing distance and luminance of the stimulus.
#[derive(Clone, Copy)]
pub struct ViewingPlace {
    viewing: Option<Viewing>,
    /// With a window of the usual width.
    usual: ViewingConditions,
}

impl ViewingPlace {
    /// Creates the place for a screen described by `display`, viewed from `distance_cm` centimeters.
    pub fn new(display: &DisplayProfile, distance_cm: Option<f64>) -> Self {
        let viewing = || {
            let ([columns, rows], width) = (display.native_px?, display.screen_width_cm?);
            Viewing::new(Screen::new(columns, rows, width).ok()?, distance_cm?).ok()
        };
        let mut usual = ViewingConditions::new(ViewingConditions::WINDOW_DEG);
        if let Some(LuminanceRange { black_cd_m2, white_cd_m2 }) = display.luminance {
            (usual.white_cd_m2, usual.black_cd_m2) = (white_cd_m2 - black_cd_m2, black_cd_m2);
        }
        Self { viewing: viewing(), usual }
    }

    /// Returns the size in degrees of a window of `size` pixels.
    fn window_deg(&self, size: u32) -> f64 {
        self.viewing.map_or(self.usual.window_deg, |viewing| f64::from(size) / viewing.px_per_degree())
    }

    fn sentence(&self, size: u32) -> String {
        let window = self.window_deg(size);
        match self.viewing {
            Some(viewing) => format!("At {} cm, the window is {window:.1}° wide.", viewing.distance_cm),
            None => format!("The window is assumed to be {window}° wide."),
        }
    }

    fn predict(&self, (stimulus, size): &Key) -> Result<Predicted, String> {
        let window_deg = self.window_deg(*size);
        let conditions = ViewingConditions { window_deg, ..self.usual };
        let predict = || {
            let visible = conditions.visible(&[stimulus], Some(*size))?.remove(0);
            Ok((visible, conditions.detection(stimulus)?))
        };
        let (visible, detection) = predict().map_err(|error: crate::vision::VisionError| error.to_string())?;
        let marks = if let Visible::Ramp(bands) = &visible { marks(bands, window_deg) } else { Vec::new() };
        Ok(Predicted { visible, detection, marks })
    }
}

/// A stimulus and its side in pixels.
type Key = (Stimulus, u32);

/// The prediction for a stimulus.
struct Predicted {
    visible: Visible,
    detection: f64,
    /// The bands of a ramp that people can see.
    marks: Vec<Mark>,
}

/// The prediction for the displayed stimulus.
pub struct Prediction {
    place: ViewingPlace,
    predicted: Latest<Key, Predicted>,
}

impl Prediction {
    pub fn new(place: ViewingPlace) -> Self {
        Self { place, predicted: Latest::default() }
    }

    /// Requests the prediction for the displayed stimulus.
    pub fn refresh(&mut self, ctx: &egui::Context, stimulus: &Stimulus, size: u32) {
        let (place, key) = (self.place, (stimulus.clone(), size));
        if !stimulus.is_line() {
            self.predicted.want(ctx, key.clone(), || move || place.predict(&key));
        } else if self.predicted.get(&key).is_none() {
            let predicted = place.predict(&key);
            self.predicted.put(key, predicted);
        }
    }

    /// Returns the bands along the line.
    pub fn marks(&self, stimulus: &Stimulus, size: u32) -> &[Mark] {
        match self.predicted.get(&(stimulus.clone(), size)) {
            Some(Ok(predicted)) => &predicted.marks,
            _ => &[],
        }
    }

    /// Draws the numbers.
    pub fn show(&mut self, ui: &mut egui::Ui, stimulus: &Stimulus, size: u32) {
        match self.predicted.get(&(stimulus.clone(), size)) {
            Some(Ok(Predicted { visible, detection, .. })) => {
                ui::paragraph(ui, sentence(visible));
                ui::paragraph(
                    ui,
                    format!("The contrast of the whole picture is predicted to be {detection:.1} times the threshold."),
                );
                ui::hint(ui, format!("At 1, people just see the difference. {}", self.place.sentence(size)));
            }
            Some(Err(error)) => ui::show_error(ui, format!("No prediction: {error}.")),
            None => _ = ui.label("Predicting…"),
        }
    }
}

/// Says how visible the bands are.
fn sentence(visible: &Visible) -> String {
    match visible {
        Visible::Ramp(RampBands { bright, dark, .. }) => format!(
            "The bright band, which the question asks about, is predicted {}: {bright:.1} times the threshold. The dark \
             band is at {dark:.1}.",
            seen(*bright)
        ),
        Visible::Surface(difference) => {
            format!("It is predicted to differ from the smooth surface by {difference:.1} times the threshold.")
        }
        Visible::Unknown => {
            "The model does not say how visible the bands of this stimulus are: it has no smooth reference.".to_owned()
        }
    }
}

/// Says in words how visible something is that is this many times threshold.
fn seen(times: f64) -> &'static str {
    match times {
        ..0.8 => "not to be visible",
        0.8..1.25 => "to be just visible",
        1.25..3.0 => "to be visible",
        _ => "to be easily visible",
    }
}

/// Describes the positions of the bands for screen readers.
pub fn description(marks: &[Mark]) -> String {
    if marks.is_empty() {
        return "no predicted band".to_owned();
    }
    let one = |mark: &Mark| format!("{} at {:+.2}", if mark.is_bright { "bright" } else { "dark" }, mark.place);
    format!("predicted bands: {}", marks.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// Strength of a band that is just visible; weaker bands are not shown.
const JUST_VISIBLE: f64 = 1.0;

/// A visible band along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Signed distance from the center, in window sides.
    pub place: f64,
    pub is_bright: bool,
}

/// Returns the visible bands of a ramp.
fn marks(RampBands { bright, dark, at_deg, .. }: &RampBands, window_deg: f64) -> Vec<Mark> {
    let both = [(*bright, at_deg[0], true), (*dark, at_deg[1], false)];
    let visible = both.into_iter().filter(|(strength, ..)| *strength >= JUST_VISIBLE);
    visible.map(|(_, at_deg, is_bright)| Mark { place: at_deg / window_deg, is_bright }).collect()
}
