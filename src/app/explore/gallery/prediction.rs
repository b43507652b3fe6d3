//! What the vision model predicts for the stimulus: at once where it varies along a line, else on a thread of its own.

use eframe::egui::{self, TextureHandle};

use crate::{
    app::{
        explore::predicted::{self, Drawing, Mark, number},
        ui::{self, pixels, work::Latest},
    },
    display::{DisplayProfile, Screen, Viewing},
    light::CodeImage,
    stimulus::{Sight, Stimulus, View},
    vision::{Criterion, Polarity, Visibility, VisionError, luminances},
};

/// Degrees that the window takes where nothing is known of the screen's size: as `machband predict` has it.
const WINDOW_DEG: f64 = 10.0;

/// How far away and how bright the stimulus is.
#[derive(Clone, Copy)]
pub struct Place {
    viewing: Option<Viewing>,
    white_cd_m2: f64,
}

impl Place {
    /// On a screen that `display` describes, `distance_cm` centimeters away.
    pub fn new(display: &DisplayProfile, distance_cm: Option<f64>) -> Self {
        let viewing = || {
            let ([columns, rows], width) = (display.native_px?, display.screen_width_cm?);
            Viewing::new(Screen::new(columns, rows, width).ok()?, distance_cm?).ok()
        };
        let white_cd_m2 = display.luminance.map_or(Sight::WHITE_CD_M2, |range| range.white_cd_m2);
        Self { viewing: viewing(), white_cd_m2 }
    }

    /// Degrees that a window of `size` pixels takes.
    fn window_deg(&self, size: u32) -> f64 {
        self.viewing.map_or(WINDOW_DEG, |viewing| f64::from(size) / viewing.px_per_degree())
    }

    fn sentence(&self, size: u32) -> String {
        let window = self.window_deg(size);
        match self.viewing {
            Some(viewing) => format!("At {} cm the window is {window:.1}° wide.", viewing.distance_cm()),
            None => format!("The window is assumed to be {window}° wide."),
        }
    }

    fn see(&self, stimulus: &Stimulus, size: u32) -> Result<View, VisionError> {
        Sight { window_deg: self.window_deg(size), white_cd_m2: self.white_cd_m2 }.see(stimulus, size)
    }
}

/// A stimulus, and its side in pixels.
type Key = (Stimulus, u32);

/// What is predicted of a stimulus along a line.
struct AlongLine {
    key: Key,
    seen: Result<(Visibility, Vec<Mark>), String>,
}

/// What is predicted of an image.
struct OfPicture {
    visibility: Visibility,
    codes: CodeImage,
}

/// The prediction of the stimulus that is shown.
pub struct Prediction {
    place: Place,
    line: Option<AlongLine>,
    picture: Latest<Key, OfPicture>,
    texture: Option<(Key, TextureHandle)>,
    /// Whether the map of an image's bands takes its place.
    map: bool,
}

impl Prediction {
    /// As seen from `place`.
    pub fn new(place: Place) -> Self {
        Self { place, line: None, picture: Latest::default(), texture: None, map: false }
    }

    /// Follows the stimulus that is shown.
    pub fn refresh(&mut self, ctx: &egui::Context, stimulus: &Stimulus, size: u32) {
        let key = (stimulus.clone(), size);
        if stimulus.is_line() {
            if self.line.as_ref().is_none_or(|line| line.key != key) {
                let seen = self.place.see(stimulus, size).map(|view| match view {
                    View::Line(view) => (view.visibility, predicted::marks(&view)),
                    View::Picture(view) => (view.visibility, Vec::new()),
                });
                self.line = Some(AlongLine { key, seen: seen.map_err(|error| error.to_string()) });
            }
            return;
        }
        let place = self.place;
        self.picture.want(ctx, key.clone(), || move || of_picture(&place, &key.0, key.1));
        self.map_texture(ctx, stimulus, size);
    }

    fn map_texture(&mut self, ctx: &egui::Context, stimulus: &Stimulus, size: u32) {
        let key = (stimulus.clone(), size);
        let is_there = self.texture.as_ref().is_some_and(|(of, _)| *of == key);
        if self.map
            && !is_there
            && let Some(Ok(seen)) = self.picture.get(&key)
        {
            self.texture = Some((key, pixels::texture_of(ctx, "predicted bands", &seen.codes)));
        }
    }

    /// The map of the bands, where it is wanted and there.
    pub fn texture(&self, stimulus: &Stimulus, size: u32) -> Option<&TextureHandle> {
        let wanted = self.map && !stimulus.is_line();
        self.texture.as_ref().filter(|((of, side), _)| wanted && of == stimulus && *side == size).map(|(_, map)| map)
    }

    /// The bands along the line.
    pub fn marks(&self, stimulus: &Stimulus, size: u32) -> &[Mark] {
        match &self.line {
            Some(AlongLine { key: (of, side), seen: Ok((_, marks)) }) if of == stimulus && *side == size => marks,
            _ => &[],
        }
    }

    /// A place of a mark as a share of the window's side, from its middle.
    pub fn place(&self, mark: &Mark, size: u32) -> f64 {
        mark.at_deg / self.place.window_deg(size)
    }

    /// The numbers, and the switch between an image and its map.
    pub fn show(&mut self, ui: &mut egui::Ui, stimulus: &Stimulus, size: u32) {
        let key = (stimulus.clone(), size);
        let seen = if stimulus.is_line() {
            self.line.as_ref().filter(|line| line.key == key).map(|line| line.seen.as_ref().map(|(seen, _)| *seen))
        } else {
            self.picture.get(&key).map(|seen| seen.as_ref().map(|seen| seen.visibility))
        };
        match seen {
            Some(Ok(visibility)) => {
                ui::paragraph(ui, sentence(&visibility));
                ui::hint(ui, format!("A visibility of 1 is just visible. {}", self.place.sentence(size)));
            }
            Some(Err(fault)) => ui::fault(ui, format!("No prediction: {fault}.")),
            None => _ = ui.label("Predicting…"),
        }
        if !stimulus.is_line() {
            ui.checkbox(&mut self.map, "Predicted bands");
        }
    }
}

fn of_picture(place: &Place, stimulus: &Stimulus, size: u32) -> Result<OfPicture, String> {
    let View::Picture(view) = place.see(stimulus, size).map_err(|error| error.to_string())? else {
        return Err("it varies in one direction only".to_owned());
    };
    let light = luminances(&stimulus.linear(size));
    let most = predicted::strongest(&view.map);
    let drawing = Drawing { map: &view.map, light: &light, size: [size as usize; 2], most };
    Ok(OfPicture { visibility: view.visibility, codes: drawing.codes(size, size) })
}

fn sentence(visibility: &Visibility) -> String {
    let Visibility { bright, dark } = *visibility;
    format!(
        "Predicted visibility {} (bright {}, dark {}), rating {:.1}",
        number(visibility.max()),
        number(bright),
        number(dark),
        Criterion::default().mean(visibility.max())
    )
}

/// Where the bands are, in words.
pub fn in_words(places: &[(f64, Polarity)]) -> String {
    if places.is_empty() {
        return "no predicted band".to_owned();
    }
    let one = |(place, polarity): &(f64, Polarity)| {
        let word = if *polarity == Polarity::Bright { "bright" } else { "dark" };
        format!("{word} at {place:+.2}")
    };
    format!("predicted bands: {}", places.iter().map(one).collect::<Vec<_>>().join(", "))
}
