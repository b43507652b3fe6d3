//! The gallery: every stimulus of the catalog with its parameters, its luminance profile, and ways to export it.

use std::path::Path;

use eframe::egui::{self, CentralPanel, Color32, Frame, Panel, ScrollArea, TextureHandle, Ui};
use egui_plot::{Corner, Legend, Line, MarkerShape, PlotUi, Points};

use crate::{
    app::{
        explore::prediction::{self, Mark, Prediction, ViewingPlace},
        ui::{self, Field, Saving, Step, pixels, theme},
    },
    display::DisplayProfile,
    light::{Bits, Dither, Quantizer},
    stimulus::{Parameter, ParameterValue, Stimulus, catalog, place, recipe::Recipe},
    store,
    vision::Polarity,
};

/// Number of samples of the plotted profile.
const SAMPLES: u32 = 1024;
/// The choices for the side of the image, physical pixels.
const SIZES: [u32; 4] = [256, 384, 512, 768];
/// The choices for the dither.
const DITHERS: [&str; 4] = ["none", "ordered", "blue-noise", "random"];
/// In a window narrower than this, in points, the image is below its controls.
const NARROW: f32 = 760.0;
/// Width of the column of labels, points.
const LABELS: f32 = 108.0;
/// The strength that gets the longest mark; a just-visible band gets the shortest. Lengths are shares of the plotted
/// range of light.
const STRONGEST: f64 = 100.0;
const MARKS: [f64; 2] = [0.06, 0.22];

pub struct Gallery {
    entry: usize,
    /// Each parameter and the text in its control.
    values: Vec<(&'static Parameter, String)>,
    size: u32,
    dither: Dither,
    derivatives: bool,
    shown: Option<Shown>,
    out: String,
    saving: Saving,
    display: DisplayProfile,
    distance_cm: Option<f64>,
    prediction: Prediction,
}

/// Errors. Each belongs to the named parameter, or to the combination of parameters if it has no name.
type Faults = Vec<(Option<&'static str>, String)>;

/// The displayed image and curves, and the recipe that they were made from.
struct Shown {
    recipe: Recipe,
    texture: TextureHandle,
    curves: Curves,
}

/// Luminance of the strongest channel along a line through the center, in the direction of the orientation.
struct Curves {
    requested: Vec<[f64; 2]>,
    emitted: Vec<[f64; 2]>,
}

impl Gallery {
    /// Creates the gallery for a screen described by `display`, viewed from `distance_cm` centimeters if that is known.
    pub fn new(display: DisplayProfile, distance_cm: Option<f64>) -> Self {
        let mut gallery = Self {
            prediction: Prediction::new(ViewingPlace::new(&display, distance_cm)),
            entry: 0,
            values: Vec::new(),
            size: 512,
            dither: Dither::None,
            derivatives: false,
            shown: None,
            out: "stimulus.png".to_owned(),
            saving: Saving::default(),
            display,
            distance_cm,
        };
        gallery.choose(0);
        gallery
    }

    /// Uses another screen, or the same screen from another distance.
    pub fn set_screen(&mut self, display: &DisplayProfile, distance_cm: Option<f64>) {
        if self.display != *display || self.distance_cm != distance_cm {
            self.display = display.clone();
            self.distance_cm = distance_cm;
            self.prediction = Prediction::new(ViewingPlace::new(display, distance_cm));
        }
    }

    fn choose(&mut self, entry: usize) {
        self.entry = entry;
        self.saving = Saving::default();
        let stimulus = catalog::all()[entry].default_stimulus();
        let value = |name: &str| stimulus.get(name).map_or_else(String::new, |value| value.to_string());
        self.values = stimulus.parameters().iter().map(|parameter| (parameter, value(parameter.name))).collect();
    }

    /// Returns the stimulus that the controls describe, or the errors in them.
    fn stimulus(&self) -> Result<Stimulus, Faults> {
        let mut stimulus = catalog::all()[self.entry].default_stimulus();
        let mut errors = Vec::new();
        for (parameter, text) in &self.values {
            let value: ParameterValue = text.parse().unwrap_or_else(|never| match never {});
            if let Err(error) = stimulus.set(parameter.name, &value) {
                errors.push((Some(parameter.name), error.to_string()));
            }
        }
        if errors.is_empty()
            && let Err(found) = stimulus.validate()
        {
            errors.extend(found.iter().map(|error| (None, error.to_string())));
        }
        if errors.is_empty() { Ok(stimulus) } else { Err(errors) }
    }

    pub fn show(&mut self, ui: &mut Ui) -> Step {
        let escaped = ui::escaped(ui);
        let stimulus = self.stimulus();
        if let Ok(stimulus) = &stimulus {
            self.refresh(ui.ctx(), stimulus);
        }
        let errors = stimulus.err().unwrap_or_default();
        let frame = Frame::NONE.inner_margin(16.0);
        let scrolling = || ScrollArea::vertical().auto_shrink(false);
        let mut back = false;
        if ui.available_width() < NARROW {
            CentralPanel::default().frame(frame).show(ui, |ui| {
                scrolling().show(ui, |ui| {
                    // Leaves room for the scroll bar.
                    ui.set_max_width(ui.available_width() - 6.0);
                    back = self.controls(ui, &errors);
                    ui.separator();
                    self.picture(ui);
                });
            });
        } else {
            Panel::left("gallery").resizable(false).exact_size(370.0).frame(frame).show(ui, |ui| {
                scrolling().show(ui, |ui| back = self.controls(ui, &errors));
            });
            CentralPanel::default().frame(frame).show(ui, |ui| scrolling().show(ui, |ui| self.picture(ui)));
        }
        Step::back_if(back || escaped)
    }

    /// Renders the stimulus again if something has changed.
    fn refresh(&mut self, ctx: &egui::Context, stimulus: &Stimulus) {
        let recipe = Recipe {
            stimulus: stimulus.clone(),
            size: self.size,
            transfers: self.display.transfers.clone(),
            bits: Bits::Eight,
            dither: self.dither,
            seed: 1,
            display_sha256: self.display.measured.is_some().then(|| store::profile::hash(&self.display)),
        };
        self.prediction.refresh(ctx, stimulus, self.size);
        if self.shown.as_ref().is_some_and(|shown| shown.recipe == recipe) {
            return;
        }
        let quantizer = recipe.quantizer();
        let texture = pixels::texture_of(ctx, "gallery", &recipe.codes(&quantizer));
        let curves = Curves::new(&recipe, &quantizer);
        self.saving = Saving::default();
        self.shown = Some(Shown { recipe, texture, curves });
    }

    /// Draws all settings and exports; returns whether to go back.
    fn controls(&mut self, ui: &mut Ui, errors: &Faults) -> bool {
        let back = ui::heading(ui, "Gallery");
        let mut chosen = self.entry;
        let entries: Vec<usize> = (0..catalog::all().len()).collect();
        Field::new("Stimulus").width(250.0).choice(ui, &mut chosen, &entries, |i| catalog::all()[*i].title.to_owned());
        if chosen != self.entry {
            self.choose(chosen);
        }
        ui::hint(ui, catalog::all()[self.entry].about);
        ui.add_space(8.0);
        let show = |ui: &mut Ui, name: Option<&str>| {
            errors.iter().filter(|(of, _)| *of == name).for_each(|(_, error)| ui::show_error(ui, error));
        };
        for (parameter, text) in &mut self.values {
            ui::parameter(ui, LABELS, parameter, text);
            show(ui, Some(parameter.name));
        }
        show(ui, None);
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            Field::new("Size, px").width(80.0).choice(ui, &mut self.size, &SIZES, u32::to_string);
            let dithers: Vec<Dither> = DITHERS.iter().filter_map(|name| name.parse().ok()).collect();
            Field::new("Dither").width(110.0).choice(ui, &mut self.dither, &dithers, Dither::to_string);
        });
        ui.checkbox(&mut self.derivatives, "First and second derivative");
        self.export(ui);
        back
    }

    fn export(&mut self, ui: &mut Ui) {
        ui.add_space(8.0);
        ui.separator();
        let Some(shown) = &self.shown else { return };
        ui::hint(ui, format!("Display: {}.", self.display.sentence()));
        Field::new("Export to").width(250.0).text(ui, &mut self.out);
        ui.horizontal_wrapped(|ui| {
            let path = Path::new(self.out.trim());
            if let Some(writer) = self.saving.button(ui, "Export PNG", true, path, &[]) {
                let written = store::image::write_recipe(&writer, path, &shown.recipe, &shown.recipe.quantizer());
                self.saving.finish(path, written.map(|()| format!("Saved to {}", path.display())));
            }
            if ui.button("Copy as command").clicked() {
                ui.ctx().copy_text(shown.recipe.command());
                self.saving.finish(path, Ok(format!("Copied: {}", shown.recipe.command())));
            }
        });
        self.saving.show(ui);
    }

    fn picture(&mut self, ui: &mut Ui) {
        let Some(shown) = &self.shown else { return };
        let Recipe { stimulus, size, .. } = &shown.recipe;
        let room = ui.available_width();
        let map = self.prediction.texture(ui.ctx(), stimulus, *size);
        ScrollArea::horizontal().id_salt("stimulus").show(ui, |ui| {
            pixels::picture(ui, map.as_ref().unwrap_or(&shown.texture), catalog::all()[self.entry].title);
        });
        self.prediction.show(ui, stimulus, *size);
        ui.add_space(8.0);
        let width = (*size as f32 / ui.ctx().pixels_per_point()).max(420.0).min(room.max(300.0));
        let curves = &shown.curves;
        let marks = self.prediction.marks(stimulus, *size);
        let band = theme::ink(ui).band;
        let lines: [(&str, &Vec<[f64; 2]>); 2] =
            [("after quantization", &curves.emitted), ("requested", &curves.requested)];
        let response = plot(ui, "profile", "light", width, &lines, |plot| {
            marks.iter().for_each(|mark| draw_mark(plot, mark, &curves.requested, band));
        });
        if stimulus.is_line() {
            ui::describe(&response, &format!("Plot: light, {}", prediction::description(marks)));
        }
        if self.derivatives {
            let slope = slopes(&curves.requested);
            plot(ui, "slope", "first derivative", width, &[("slope, light per window", &slope)], |_| {});
            let curvature = [("curvature, light per window²", &slopes(&slope))];
            plot(ui, "curvature", "second derivative", width, &curvature, |_| {});
        }
    }
}

/// Draws an arrow from the curve at a predicted band, up for a bright band and down for a dark one. Stronger bands have
/// longer arrows.
fn draw_mark(plot: &mut PlotUi<'_>, mark: &Mark, curve: &[[f64; 2]], color: Color32) {
    let light = || curve.iter().map(|point| point[1]);
    let (least, most) = (light().fold(f64::INFINITY, f64::min), light().fold(f64::NEG_INFINITY, f64::max));
    let share = (mark.strength.ln() / STRONGEST.ln()).clamp(0.0, 1.0);
    let length = (most - least).max(0.02) * (MARKS[0] + (MARKS[1] - MARKS[0]) * share);
    let nearest = curve.partition_point(|point| point[0] < mark.place).min(curve.len().saturating_sub(1));
    let Some([_, light]) = curve.get(nearest) else { return };
    let (tip, shape) = match mark.polarity {
        Polarity::Bright => (light + length, MarkerShape::Up),
        Polarity::Dark => (light - length, MarkerShape::Down),
    };
    let name = "predicted band";
    plot.line(Line::new(name, vec![[mark.place, *light], [mark.place, tip]]).color(color).width(2.0));
    plot.points(Points::new(name, vec![[mark.place, tip]]).color(color).shape(shape).radius(5.0).filled(true));
}

fn plot(
    ui: &mut Ui,
    id: &str,
    axis: &str,
    width: f32,
    lines: &[(&str, &Vec<[f64; 2]>)],
    over: impl FnOnce(&mut PlotUi<'_>),
) -> egui::Response {
    let sides = theme::ink(ui).sides;
    let lowest = lines.iter().flat_map(|(_, points)| points.iter()).map(|point| point[1]).fold(f64::INFINITY, f64::min);
    ui::still_plot(id)
        .width(width)
        .height(200.0)
        // Nearly uniform light is shown as uniform, so that rounding is not magnified.
        .include_y(lowest - 0.02)
        .include_y(lowest + 0.02)
        .x_axis_label("position, in window sides")
        .y_axis_label(axis)
        .legend(Legend::default().position(Corner::LeftTop).text_style(egui::TextStyle::Small).background_alpha(0.5))
        .show(ui, |plot| {
            for ((name, points), color) in lines.iter().zip(sides) {
                plot.line(Line::new(*name, (*points).clone()).color(color).width(1.5));
            }
            over(plot);
        })
        .response
}

impl Curves {
    fn new(recipe: &Recipe, quantizer: &Quantizer) -> Self {
        let strongest = recipe.stimulus.strongest_channel();
        let light = recipe.stimulus.profile(SAMPLES);
        let at = |i: u32| [place(i, SAMPLES), f64::from(light[i as usize][strongest])];
        let requested: Vec<[f64; 2]> = (0..SAMPLES).map(at).collect();
        let emitted =
            store::curve::samples(recipe, quantizer).iter().map(|sample| [sample.x, sample.emitted]).collect();
        Self { requested, emitted }
    }
}

/// Returns the slope between each pair of neighboring points, placed at their midpoint.
pub fn slopes(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let slope = |pair: &[[f64; 2]]| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
    points.windows(2).map(|pair| [(pair[0][0] + pair[1][0]) / 2.0, slope(pair)]).collect()
}
