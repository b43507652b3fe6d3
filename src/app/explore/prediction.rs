//! Predictions of the vision model for stimuli in the gallery: immediately if the stimulus varies in one direction, and
//! otherwise on a separate thread. Predictions are shown as marks along a line, as band maps, and as numbers.

use eframe::egui::{self, TextureHandle};

use crate::{
    app::ui::{self, pixels, work::Latest},
    display::{DisplayProfile, Screen, Viewing},
    light::{CodeImage, Samples, Transfer},
    stimulus::{Stimulus, StimulusPrediction, ViewingConditions},
    vision::{Band, BandMap, Criterion, LinePrediction, Polarity, Visibility, luminances, pooled},
};

/// Assumed size of the window in degrees if the size of the screen is unknown; the same as in `machband predict`.
const WINDOW_DEG: f64 = 10.0;

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
        self.viewing.map_or(WINDOW_DEG, |viewing| f64::from(size) / viewing.px_per_degree())
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

/// Peaks of two channels are one band if they are no farther apart than this many periods of the coarser channel.
const ONE_BAND_PERIODS: f64 = 0.5;
/// Strength of a band that is just visible; weaker bands are not shown.
const JUST_VISIBLE: f64 = 1.0;

/// Peaks weaker than this are noise, not bands that a peak of a coarser channel could join.
const MIN_STRENGTH: f64 = 0.25;
/// A band is located by the finest channel whose peak reaches this share of the strongest peak.
const DISTINCT: f64 = 0.5;

/// One band along a line, over all channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Signed distance from the center, in window sides.
    pub place: f64,
    pub polarity: Polarity,
    /// Strength pooled over channels, in multiples of the strength that is just visible.
    pub strength: f64,
}

/// Returns the visible bands of a line, each listed once. Fine channels locate a band precisely and coarse channels
/// less so; each peak therefore joins the nearest band that finer channels have found.
fn marks(view: &LinePrediction, window_deg: f64) -> Vec<Mark> {
    let mut finest_first: Vec<&Band> = view.bands.iter().filter(|band| band.strength >= MIN_STRENGTH).collect();
    finest_first.sort_by(|a, b| b.frequency.total_cmp(&a.frequency));
    let mut clusters: Vec<Vec<&Band>> = Vec::new();
    for band in finest_first {
        let apart = |cluster: &Vec<&Band>| {
            cluster.iter().map(|other| (other.at_deg[0] - band.at_deg[0]).abs()).fold(f64::INFINITY, f64::min)
        };
        let is_one = |cluster: &&mut Vec<&Band>| {
            cluster[0].polarity == band.polarity && apart(cluster) <= ONE_BAND_PERIODS / band.frequency
        };
        match clusters.iter_mut().filter(is_one).min_by(|a, b| apart(a).total_cmp(&apart(b))) {
            Some(cluster) => cluster.push(band),
            None => clusters.push(vec![band]),
        }
    }
    clusters
        .iter_mut()
        .filter_map(|cluster| mark(cluster, window_deg))
        .filter(|mark| mark.strength >= JUST_VISIBLE)
        .collect()
}

/// Returns the mark for a group of peaks that form one band; `None` if there are no peaks.
fn mark(bands: &mut [&Band], window_deg: f64) -> Option<Mark> {
    bands.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    let most = bands.first()?.strength;
    let distinct = bands.iter().filter(|band| band.strength >= DISTINCT * most);
    let finest = distinct.max_by(|a, b| a.frequency.total_cmp(&b.frequency))?;
    Some(Mark { place: finest.at_deg[0] / window_deg, polarity: finest.polarity, strength: over_channels(bands) })
}

/// Returns the strength pooled over channels; each channel contributes its strongest peak. `bands` must be sorted by
/// strength, strongest first.
fn over_channels(bands: &[&Band]) -> f64 {
    let first = |i: &usize| !bands[..*i].iter().any(|earlier| earlier.frequency == bands[*i].frequency);
    pooled((0..bands.len()).filter(first).map(|i| bands[i].strength))
}

/// Returns the largest strength in a map.
pub fn strongest(map: &BandMap) -> f64 {
    map.bright.iter().chain(&map.dark).copied().fold(0.0, f64::max)
}

/// Codes of black and of white in the dimmed picture under the bands, chosen so that the bands are its brightest
/// and darkest parts.
const GROUND: [f64; 2] = [88.0, 148.0];

/// A band map over the dimmed picture. Bands of the strength `most` are white or black.
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
    /// Returns the drawing as a picture of `width` × `height` pixels. The map's lines are one pixel wide and become two
    /// pixels wide.
    pub fn codes(&self, width: u32, height: u32) -> CodeImage {
        let scale = [self.size[0] as f64 / f64::from(width.max(1)), self.size[1] as f64 / f64::from(height.max(1))];
        let at = |x: u32, y: u32| [(f64::from(x) + 0.5) * scale[0] - 0.5, (f64::from(y) + 0.5) * scale[1] - 0.5];
        let codes =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| [self.code(at(x, y)); 3]);
        CodeImage { width, height, samples: Samples::Eight(codes.collect()) }
    }

    /// Returns the code at `at`, a position in map pixels from the center of the first pixel.
    fn code(&self, at: [f64; 2]) -> u8 {
        let [column, row] = at.map(|place| place.round() as isize);
        let mut strength = 0.0_f64;
        for (x, y) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (column + dx, row + dy))) {
            let Some(i) = self.index(x, y) else { continue };
            let far = (at[0] - x as f64).abs().max((at[1] - y as f64).abs());
            let here = (self.map.bright[i] - self.map.dark[i]) * (1.5 - far).clamp(0.0, 1.0);
            strength = if here.abs() > strength.abs() { here } else { strength };
        }
        let share = if strength.abs() < JUST_VISIBLE {
            0.0
        } else {
            (strength / self.full_scale.max(JUST_VISIBLE)).clamp(-1.0, 1.0)
        };
        let clamped = |place: isize, side: usize| place.clamp(0, side.saturating_sub(1) as isize);
        let light =
            self.index(clamped(column, self.size[0]), clamped(row, self.size[1])).map_or(0.0, |i| self.light[i]);
        let ground = GROUND[0] + (GROUND[1] - GROUND[0]) * Transfer::Srgb.encoded_from_linear(light.clamp(0.0, 1.0));
        let end = if share > 0.0 { 255.0 } else { 0.0 };
        (ground + (end - ground) * share.abs()).round() as u8
    }

    fn index(&self, x: isize, y: isize) -> Option<usize> {
        let [width, height] = self.size.map(|side| side as isize);
        ((0..width).contains(&x) && (0..height).contains(&y)).then(|| (y * width + x) as usize)
    }
}
