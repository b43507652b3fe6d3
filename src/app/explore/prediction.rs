//! Predictions of the vision model for stimuli in the gallery: immediately if the stimulus varies in one direction, and
//! otherwise on a separate thread. Predictions are shown as marks along a line, as band maps, and as numbers.

use eframe::egui::{self, TextureHandle};

use crate::{
    app::ui::{self, pixels, work::Latest},
    display::{DisplayProfile, Screen, Viewing},
    light::{CodeImage, Samples, Transfer},
    stimulus::{Stimulus, StimulusPrediction, ViewingConditions},
    vision::{BandMap, Criterion, LinePrediction, Polarity, Visibility, luminances},
};

/// The viewing distance and luminance of the stimulus.
#[derive(Clone, Copy)]
pub struct ViewingPlace {
    viewing: Option<Viewing>,
    white_cd_m2: f64,
}

impl ViewingPlace {
    /// Creates the place for a screen described by `display`, viewed from `distance_cm` centimeters.
    pub fn new(display: &DisplayProfile, distance_cm: Option<f64>) -> Self {
        let viewing = || {
            let ([columns, rows], width) = (display.native_px?, display.screen_width_cm?);
            Viewing::new(Screen::new(columns, rows, width).ok()?, distance_cm?).ok()
        };
        let white_cd_m2 = display.luminance.map_or(ViewingConditions::WHITE_CD_M2, |range| range.white_cd_m2);
        Self { viewing: viewing(), white_cd_m2 }
    }

    /// Returns the size in degrees of a window of `size` pixels.
    fn window_deg(&self, size: u32) -> f64 {
        self.viewing.map_or(ViewingConditions::WINDOW_DEG, |viewing| f64::from(size) / viewing.px_per_degree())
    }

    fn sentence(&self, size: u32) -> String {
        let window = self.window_deg(size);
        match self.viewing {
            Some(viewing) => format!("At {} cm, the window is {window:.1}° wide.", viewing.distance_cm()),
            None => format!("The window is assumed to be {window}° wide."),
        }
    }

    fn predict(&self, (stimulus, size): &Key) -> Result<Predicted, String> {
        let window_deg = self.window_deg(*size);
        let conditions = ViewingConditions { window_deg, white_cd_m2: self.white_cd_m2 };
        Ok(match conditions.predict(stimulus, *size).map_err(|error| error.to_string())? {
            StimulusPrediction::Line(line) => {
                Predicted { visibility: line.visibility, marks: marks(&line, window_deg), map: None }
            }
            StimulusPrediction::Picture(picture) => {
                let light = luminances(&stimulus.linear(*size));
                let (map, full_scale) = (&picture.map, strongest(&picture.map));
                let drawing = BandMapImage { map, light: &light, size: [*size as usize; 2], full_scale };
                let map = drawing.codes(*size, *size);
                Predicted { visibility: picture.visibility, marks: Vec::new(), map: Some(map) }
            }
        })
    }
}

/// A stimulus and its side in pixels.
type Key = (Stimulus, u32);

/// The prediction for a stimulus.
struct Predicted {
    visibility: Visibility,
    /// The bands of a stimulus that varies in one direction; empty for other stimuli.
    marks: Vec<Mark>,
    /// The bands of a stimulus that varies in two directions, drawn over its image.
    map: Option<CodeImage>,
}

/// The prediction for the displayed stimulus.
pub struct Prediction {
    place: ViewingPlace,
    line: Option<(Key, Result<Predicted, String>)>,
    picture: Latest<Key, Predicted>,
    texture: Option<(Key, TextureHandle)>,
    /// Whether the band map is shown instead of the image.
    shows_map: bool,
}

impl Prediction {
    pub fn new(place: ViewingPlace) -> Self {
        Self { place, line: None, picture: Latest::default(), texture: None, shows_map: false }
    }

    /// Requests the prediction for the displayed stimulus.
    pub fn refresh(&mut self, ctx: &egui::Context, stimulus: &Stimulus, size: u32) {
        let (place, key) = (self.place, (stimulus.clone(), size));
        if !stimulus.is_line() {
            self.picture.want(ctx, key.clone(), || move || place.predict(&key));
        } else if self.line.as_ref().is_none_or(|(of, _)| *of != key) {
            let predicted = place.predict(&key);
            self.line = Some((key, predicted));
        }
    }

    fn get(&self, key: &Key) -> Option<&Result<Predicted, String>> {
        let line = self.line.as_ref().filter(|(of, _)| of == key).map(|(_, predicted)| predicted);
        line.or_else(|| self.picture.get(key))
    }

    /// Returns the band map, if it is selected and available.
    pub fn texture(&mut self, ctx: &egui::Context, stimulus: &Stimulus, size: u32) -> Option<TextureHandle> {
        let key = (stimulus.clone(), size);
        let map = self.get(&key)?.as_ref().ok()?.map.as_ref().filter(|_| self.shows_map)?;
        if self.texture.as_ref().is_none_or(|(of, _)| *of != key) {
            let texture = pixels::texture_of(ctx, "predicted bands", map);
            self.texture = Some((key, texture));
        }
        self.texture.as_ref().map(|(_, texture)| texture.clone())
    }

    /// Returns the bands along the line.
    pub fn marks(&self, stimulus: &Stimulus, size: u32) -> &[Mark] {
        match self.get(&(stimulus.clone(), size)) {
            Some(Ok(predicted)) => &predicted.marks,
            _ => &[],
        }
    }

    /// Draws the numbers, and the switch between the image and its map.
    pub fn show(&mut self, ui: &mut egui::Ui, stimulus: &Stimulus, size: u32) {
        match self.get(&(stimulus.clone(), size)) {
            Some(Ok(predicted)) => {
                let Visibility { bright, dark } = predicted.visibility;
                let visibility = predicted.visibility.max();
                let rating = Criterion::default().mean(visibility);
                ui::paragraph(
                    ui,
                    format!(
                        "Predicted visibility {visibility:.1} (bright {bright:.1}, dark {dark:.1}), rating {rating:.1}"
                    ),
                );
                ui::hint(ui, format!("A visibility of 1 is just visible. {}", self.place.sentence(size)));
            }
            Some(Err(error)) => ui::show_error(ui, format!("No prediction: {error}.")),
            None => _ = ui.label("Predicting…"),
        }
        if !stimulus.is_line() {
            ui.checkbox(&mut self.shows_map, "Predicted bands");
        }
    }
}

/// Describes the positions of the bands for screen readers.
pub fn description(marks: &[Mark]) -> String {
    if marks.is_empty() {
        return "no predicted band".to_owned();
    }
    let one = |mark: &Mark| {
        let word = if mark.polarity == Polarity::Bright { "bright" } else { "dark" };
        format!("{word} at {:+.2}", mark.place)
    };
    format!("predicted bands: {}", marks.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// Strength of a band that is just visible; weaker bands are not shown.
const JUST_VISIBLE: f64 = 1.0;

/// A visible band along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Signed distance from the center, in window sides.
    pub place: f64,
    pub polarity: Polarity,
    /// Visibility; 1 is just visible.
    pub strength: f64,
}

/// Returns the visible bands of a line.
fn marks(view: &LinePrediction, window_deg: f64) -> Vec<Mark> {
    let visible = view.bands.iter().filter(|band| band.strength >= JUST_VISIBLE);
    visible
        .map(|band| Mark { place: band.at_deg / window_deg, polarity: band.polarity, strength: band.strength })
        .collect()
}

/// Returns the largest strength in a map.
pub fn strongest(map: &BandMap) -> f64 {
    map.bright.iter().chain(&map.dark).copied().fold(0.0, f64::max)
}

/// Codes of black and of white in the dimmed picture under the bands, chosen so that the bands are its brightest
/// and darkest parts.
const GROUND: [f64; 2] = [88.0, 148.0];

/// The weakest band that a map draws white or black. Maps also show bands that are too weak to be seen: the page says how
/// visible the strongest is.
const FAINT: f64 = 0.1;

/// A band map over the dimmed picture. Bands of the strength `full_scale` are white or black.
pub struct BandMapImage<'a> {
    pub map: &'a BandMap,
    /// The picture's luminance, 1 for white; it has as many values as the map.
    pub light: &'a [f64],
    /// Columns and rows of the map and the luminance.
    pub size: [usize; 2],
    /// The strength that is drawn white or black.
    pub full_scale: f64,
}

impl BandMapImage<'_> {
    /// Returns the drawing as a picture of `width` × `height` pixels.
    pub fn codes(&self, width: u32, height: u32) -> CodeImage {
        let from = |place: u32, side: u32, values: usize| {
            ((f64::from(place) + 0.5) * values as f64 / f64::from(side.max(1))) as usize
        };
        let index = |x: u32, y: u32| from(y, height, self.size[1]) * self.size[0] + from(x, width, self.size[0]);
        let codes =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| [self.code(index(x, y)); 3]);
        CodeImage { width, height, samples: Samples::Eight(codes.collect()) }
    }

    /// Returns the code of a band over a middle gray. The share of the full strength is −1 for the strongest dark band
    /// and 1 for the strongest bright band.
    pub fn scale(share: f64) -> u8 {
        Self::over((GROUND[0] + GROUND[1]) / 2.0, share)
    }

    fn over(ground: f64, share: f64) -> u8 {
        let end = if share > 0.0 { 255.0 } else { 0.0 };
        (ground + (end - ground) * share.abs()).round() as u8
    }

    /// Returns the code at the place `i` of the map.
    fn code(&self, i: usize) -> u8 {
        let strength = self.map.bright[i] - self.map.dark[i];
        let share = (strength / self.full_scale.max(FAINT)).clamp(-1.0, 1.0);
        let ground =
            GROUND[0] + (GROUND[1] - GROUND[0]) * Transfer::Srgb.encoded_from_linear(self.light[i].clamp(0.0, 1.0));
        Self::over(ground, share)
    }
}
