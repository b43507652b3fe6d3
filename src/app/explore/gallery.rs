//! The gallery: every stimulus of the catalog with its parameters, its luminance profile, what the vision model predicts
//! for it, and ways to export it. The bands of a ramp are marked along its profile; all else is numbers.

use eframe::egui::{self, Color32, ScrollArea, TextureHandle, Ui};
use egui_plot::{GridMark, Line, MarkerShape, PlotUi, Points};

use crate::{
    app::ui::{
        self, Bench, Field, History, Saving,
        pixels::{self, Drawn},
        theme,
        work::Latest,
    },
    display::{DisplayProfile, Viewing},
    light::{Bits, Dither, DitherMatrix, Quantizer},
    stimulus::{Parameter, ParameterError, Stimulus, ViewingConditions, Visible, catalog, recipe::Recipe},
    store,
    text::Cell,
    vision::RampBands,
    work,
};

/// The choices for the side of the image, physical pixels.
const SIZES: [u32; 5] = [256, 384, 512, 768, 1024];
/// The choices for the dither.
const DITHERS: [Dither; 4] = [Dither::None, Dither::Ordered(DitherMatrix::Bayer8), Dither::BlueNoise, Dither::Random];
/// Width of the column of controls and, in it, of the labels, points.
const CONTROLS: f32 = 360.0;
const LABELS: f32 = 100.0;
/// Room on the left of the image for the vertical axes of the plots, points. The plots are as wide as the image, so that
/// each place in a plot is below the same place in the image.
const AXIS: f32 = 76.0;
/// Height of a plot, and of all texts and gaps above and below the image that should be visible with it, points.
const PLOT: f32 = 180.0;
const TEXTS: f32 = 66.0;
/// If there is this much room on the right of the image, in points, the prediction is there.
const BESIDE: f32 = 200.0;
/// Side of a kind's picture in the overview, points; in a page narrower than `WIDE`, it is smaller.
const TILE: f32 = 72.0;
const SMALL_TILE: f32 = 44.0;
const WIDE: f32 = 640.0;
/// Length of the mark of a predicted band, as a share of the plotted range of light.
const MARK: f64 = 0.12;

/// The page with the stimuli of the catalog.
#[derive(Default)]
pub struct Gallery {
    settings: Choices,
    /// What is wrong with the settings.
    faults: Vec<ParameterError>,
    history: History<Choices>,
    shown: Option<Shown>,
    saving: Saving,
    display: DisplayProfile,
    /// The geometry of the screen, if it is known.
    viewing: Option<Viewing>,
    /// How visible the bands of a stimulus are, and the contrast of its picture, times threshold.
    predicted: Latest<Key, (Visible, f64)>,
    /// The pictures of all kinds, by their side in pixels.
    tiles: Drawn<u32>,
}

/// Everything that determines the image.
#[derive(Clone, Debug, PartialEq)]
struct Choices {
    /// The place of the kind in the catalog.
    entry: usize,
    /// The text in the control of each parameter, for every kind. Each kind keeps its own values.
    values: Vec<Vec<String>>,
    size: u32,
    dither: Dither,
}

/// The displayed image and curves, and the recipe that they were made from.
struct Shown {
    recipe: Recipe,
    texture: TextureHandle,
    /// Luminance of the strongest channel along a line through the center, in the direction of the orientation: as
    /// requested, and as emitted.
    curves: [Trace; 2],
}

/// Points of a plotted curve.
type Trace = Vec<[f64; 2]>;

/// A visible band along a line: its signed distance from the center, in window sides, and whether it is bright.
type Mark = (f64, bool);

/// Returns the default values of a kind's parameters, as text.
fn default_values(entry: &catalog::Entry) -> Vec<String> {
    let stimulus = entry.default_stimulus();
    let value =
        |parameter: &Parameter| stimulus.get(parameter.name).map_or_else(String::new, |value| value.to_string());
    stimulus.parameters().iter().map(value).collect()
}

impl Default for Choices {
    fn default() -> Self {
        let values = catalog::all().iter().map(default_values).collect();
        Self { entry: 0, values, size: SIZES[0], dither: Dither::None }
    }
}

impl Choices {
    /// Returns these settings with the defaults of the chosen kind.
    fn reset(&self) -> Self {
        let mut values = self.values.clone();
        values[self.entry] = default_values(self.kind());
        Self { values, dither: Dither::None, ..self.clone() }
    }

    fn kind(&self) -> &'static catalog::Entry {
        &catalog::all()[self.entry]
    }

    /// Returns the parameters of the chosen kind.
    fn parameters(&self) -> &'static [Parameter] {
        self.kind().default_stimulus().parameters()
    }

    /// Returns the stimulus that the controls describe, or the errors in them.
    fn stimulus(&self) -> Result<Stimulus, Vec<ParameterError>> {
        let given = self.parameters().iter().zip(&self.values[self.entry]);
        Stimulus::with_parameters(self.kind().kind, given.map(|(parameter, text)| (parameter.name, text.as_str())))
    }
}

impl Gallery {
    /// Chooses the largest size with which the image and its plot fit the window, once.
    fn fit(&mut self, ui: &Ui) {
        if self.shown.is_some() {
            return;
        }
        let room = (ui.available_height() - 2.0 * theme::LARGE_GAP - TEXTS - PLOT - TILE) * ui.ctx().pixels_per_point();
        let size = SIZES.iter().rev().find(|size| **size as f32 <= room).unwrap_or(&SIZES[0]);
        self.settings.size = *size;
        self.history = History::new(self.settings.clone());
        self.saving = Saving::to("stimulus.png");
    }

    /// Draws the page for a screen with this profile and this geometry, if that is known; returns whether the user left
    /// it.
    pub fn show(&mut self, ui: &mut Ui, display: &DisplayProfile, viewing: Option<Viewing>) -> bool {
        self.display.clone_from(display);
        self.viewing = viewing;
        let escaped = ui::escaped(ui);
        self.fit(ui);
        let stimulus = self.settings.stimulus();
        if let Ok(stimulus) = &stimulus {
            self.refresh(ui.ctx(), stimulus);
        }
        self.faults = stimulus.err().unwrap_or_default();
        let (controls, export, view) = (Self::controls, Self::export, Self::view);
        let bench = Bench { name: "Stimuli", width: CONTROLS, controls, export, view };
        let back = bench.show(ui, self);
        self.history.record(ui, &self.settings);
        back || escaped
    }

    /// Draws the kinds to choose from, and the stimulus.
    fn view(&mut self, ui: &mut Ui, is_narrow: bool) {
        self.overview(ui);
        let area = if is_narrow { ScrollArea::horizontal() } else { ScrollArea::both().auto_shrink(false) };
        area.id_salt("picture").show(ui, |ui| self.picture(ui));
    }

    /// Renders the stimulus again if something has changed.
    fn refresh(&mut self, ctx: &egui::Context, stimulus: &Stimulus) {
        let recipe = Recipe {
            stimulus: stimulus.clone(),
            size: self.settings.size,
            transfers: self.display.transfers.clone(),
            bits: Bits::Eight,
            dither: self.settings.dither,
            seed: 1,
            display_sha256: self.display.measured.is_some().then(|| store::profile::hash(&self.display)),
            finish: None,
        };
        if self.settings.kind().has_bands {
            let key = (stimulus.clone(), recipe.size, self.conditions(recipe.size));
            if !stimulus.is_line() {
                self.predicted.want(ctx, key.clone(), || move || predicted(&key));
            } else if self.predicted.get(&key).is_none() {
                let predicted = predicted(&key);
                self.predicted.put(key, predicted);
            }
        }
        if self.shown.as_ref().is_some_and(|shown| shown.recipe == recipe) {
            return;
        }
        let quantizer = recipe.quantizer();
        let texture = pixels::texture(ctx, "gallery", &recipe.codes(&quantizer));
        let curves = curves(&recipe, &quantizer);
        self.saving.forget();
        self.shown = Some(Shown { recipe, texture, curves });
    }

    /// Returns how an image with this side is seen.
    fn conditions(&self, size: u32) -> ViewingConditions {
        let degrees = |viewing: Viewing| f64::from(size) / viewing.px_per_degree();
        ViewingConditions::on(self.display.luminance, self.viewing.map_or(ViewingConditions::WINDOW_DEG, degrees))
    }

    /// Draws all settings.
    fn controls(&mut self, ui: &mut Ui) {
        ui::section(ui, self.settings.kind().title);
        let initial = self.settings.reset();
        self.history.show(ui, &mut self.settings, initial);
        ui::hint(ui, self.settings.kind().about);
        ui.add_space(theme::SMALL_GAP);
        let parameters = self.settings.parameters();
        let Choices { entry, values, size, dither } = &mut self.settings;
        for (parameter, text) in parameters.iter().zip(&mut values[*entry]) {
            let is_wrong = self.faults.iter().any(|error| error.parameter == parameter.name);
            ui.scope(|ui| {
                if is_wrong {
                    theme::outline_wrong(ui);
                }
                ui::parameter(ui, LABELS, parameter, text, None);
            });
        }
        ui.add_space(theme::SMALL_GAP);
        Field::new("Size, px")
            .column(LABELS)
            .choice(ui, size, &SIZES, u32::to_string)
            .on_hover_text("The side of the image, in pixels of the screen.");
        Field::new("Dither")
            .column(LABELS)
            .choice(ui, dither, &DITHERS, Dither::to_string)
            .on_hover_text("How a value between two codes is rounded to one of them.");
    }

    fn export(&mut self, ui: &mut Ui) {
        let Some(shown) = &self.shown else { return };
        // Below a control, an error would shift the others.
        for ParameterError { parameter, value, problem, expected } in &self.faults {
            let label = ui::parameter::label(self.settings.parameters(), parameter);
            ui::show_error(ui, format!("{label}: {value} {problem}. Enter {expected}."));
        }
        let field = Field::new("Export to").column(LABELS).width(ui.available_width() - LABELS - theme::GAP);
        self.saving.field(ui, field).on_hover_text(
            "The ending chooses the format: .png for the image, .csv for the light along its orientation.",
        );
        // What is shown is the stimulus before the errors.
        let is_shown = self.faults.is_empty();
        ui.horizontal_wrapped(|ui| {
            if !is_shown {
                ui.disable();
            }
            self.saving.export(ui, "Export", &["png", "csv"], |writer, path, ending| {
                let (recipe, quantizer) = (&shown.recipe, shown.recipe.quantizer());
                match ending {
                    "csv" => writer.write(path, &recipe.profile(&quantizer).csv()),
                    _ => store::image::write_recipe(writer, path, recipe, &quantizer),
                }
            });
            let copy = ui.button("Copy as command");
            if copy.on_hover_text("Copies the command that writes this image.").clicked() {
                let command = work::stimulus::command(&shown.recipe);
                ui.ctx().copy_text(command.clone());
                ui::say(ui.ctx(), format!("Copied: {command}"));
            }
        });
        self.saving.show(ui);
    }

    /// Draws every kind of stimulus as a picture to choose.
    fn overview(&mut self, ui: &mut Ui) {
        let side = if ui.available_width() > WIDE { TILE } else { SMALL_TILE };
        let px = (side * ui.ctx().pixels_per_point()).round() as u32;
        let all = || catalog::all().iter().map(catalog::Entry::default_stimulus).collect();
        let mut tiles = self.tiles.get(ui.ctx(), px, px, all).into_iter().flat_map(|(_, tiles)| tiles);
        let mut named = " ";
        ui.horizontal_wrapped(|ui| {
            for (index, entry) in catalog::all().iter().enumerate() {
                let size = egui::vec2(side + 2.0 * theme::SMALL_GAP, side + 2.0 * theme::SMALL_GAP);
                let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click());
                let is_chosen = self.settings.entry == index;
                let name = format!("Show {}", entry.title);
                response.widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, is_chosen, &name));
                tiles.next().into_iter().for_each(|tile| pixels::draw_centered(ui, tile, rect));
                if is_chosen || response.has_focus() || response.hovered() {
                    let ink = theme::ink(ui);
                    let color = if response.hovered() && !is_chosen { ink.edge } else { ink.ink };
                    let ring = egui::Stroke::new(2.0, color);
                    ui.painter().rect_stroke(rect, 0.0, ring, egui::StrokeKind::Inside);
                }
                if response.hovered() || response.has_focus() {
                    named = entry.title;
                }
                if response.clicked() {
                    self.settings.entry = index;
                }
            }
        });
        // A tooltip would cover the stimulus. The line is there before and after.
        ui::hint(ui, named);
        ui.add_space(theme::SMALL_GAP);
    }

    /// Draws the image, what is predicted for it, and its plots.
    fn picture(&mut self, ui: &mut Ui) {
        let Some(shown) = &self.shown else { return };
        let Recipe { stimulus, size, .. } = &shown.recipe;
        let kind = self.settings.kind();
        let conditions = self.conditions(*size);
        let predicted = self.predicted.get(&(stimulus.clone(), *size, conditions)).filter(|_| kind.has_bands);
        let room = ui.clip_rect().width();
        let side = *size as f32 / ui.ctx().pixels_per_point();
        let beside = room - AXIS - side - 2.0 * ui.spacing().item_spacing.x;
        let numbers = |ui: &mut Ui, width: f32| {
            ui.vertical(|ui| {
                ui.set_width(width.min(theme::COLUMN));
                match predicted {
                    Some(Ok((visible, detection))) => {
                        ui::paragraph(ui, sentence(visible));
                        ui::paragraph(
                            ui,
                            format!("The contrast of the whole picture is predicted to be {detection:.1} times the threshold."),
                        );
                        ui::hint(ui, format!("At 1, people just see the difference. {}", self.place(conditions.window_deg)));
                    }
                    Some(Err(error)) => ui::show_error(ui, format!("No prediction: {error}.")),
                    None if kind.has_bands => _ = ui.label("Predicting…"),
                    None => ui::paragraph(ui, "Nothing is predicted: this is not about Mach bands."),
                }
            });
        };
        ui.horizontal_top(|ui| {
            let gap = std::mem::take(&mut ui.spacing_mut().item_spacing.x);
            ui.add_space(AXIS);
            pixels::picture(ui, &shown.texture, kind.title);
            ui.spacing_mut().item_spacing.x = gap;
            if beside >= BESIDE {
                ui.add_space(gap);
                numbers(ui, beside);
            }
        });
        if beside < BESIDE {
            numbers(ui, room);
        }
        let [asked, emitted] = &shown.curves;
        let bands = predicted.and_then(|found| found.as_ref().ok()?.0.bands());
        let marks = bands.map_or_else(Vec::new, |bands| marks(bands, conditions.window_deg));
        let ink = theme::ink(ui);
        let [after, requested] = ink.sides();
        ui.horizontal(|ui| {
            ui.add_space(AXIS);
            ui::legend(ui, [(requested, "requested"), (after, "after quantization")]);
            if !marks.is_empty() {
                ui::hint(ui, "arrows: predicted bands");
            }
        });
        // The requested light is drawn last: where the curves agree, it covers the other.
        let lines = [(after, emitted), (requested, asked)];
        let response = plot(ui, AXIS + side, lines, |plot| {
            marks.iter().for_each(|mark| draw_mark(plot, *mark, asked, ink.ink));
        });
        if stimulus.is_line() {
            let bands = if kind.has_bands { description(&marks) } else { "no Mach bands".to_owned() };
            ui::describe(&response, &format!("Plot: light, {bands}"));
        }
    }

    /// Says how wide the window is.
    fn place(&self, window: f64) -> String {
        match self.viewing {
            Some(viewing) => format!("At {} cm, the window is {window:.1}° wide.", viewing.distance_cm),
            None => format!("The window is assumed to be {window}° wide."),
        }
    }
}

/// Draws an arrow from the curve at a predicted band, up for a bright band and down for a dark one.
fn draw_mark(plot: &mut PlotUi<'_>, (place, is_bright): Mark, curve: &[[f64; 2]], color: Color32) {
    let light = || curve.iter().map(|point| point[1]);
    let (least, most) = (light().fold(f64::INFINITY, f64::min), light().fold(f64::NEG_INFINITY, f64::max));
    let length = (most - least).max(0.02) * MARK;
    let nearest = curve.partition_point(|point| point[0] < place).min(curve.len().saturating_sub(1));
    let Some([_, light]) = curve.get(nearest) else { return };
    let (tip, shape) = if is_bright { (light + length, MarkerShape::Up) } else { (light - length, MarkerShape::Down) };
    let name = "predicted band";
    plot.line(Line::new(name, vec![[place, *light], [place, tip]]).color(color).width(2.0));
    plot.points(Points::new(name, vec![[place, tip]]).color(color).shape(shape).radius(5.0).filled(true));
}

/// Draws a plot whose data area, right of its axis, is below the image.
fn plot(ui: &mut Ui, width: f32, lines: [(Color32, &Trace); 2], over: impl FnOnce(&mut PlotUi<'_>)) -> egui::Response {
    let lowest = lines.iter().flat_map(|(_, points)| points.iter()).map(|point| point[1]).fold(f64::INFINITY, f64::min);
    // The title of the vertical axis begins left of its place.
    let margin = egui::Margin { left: theme::SMALL_GAP as i8, ..Default::default() };
    let plot = |ui: &mut Ui| {
        ui::still_plot(ui, "light", ["position, in sides of the image", "light, 1 = white"])
            .width(width - theme::SMALL_GAP)
            .height(PLOT)
            .y_axis_min_width(AXIS - theme::SMALL_GAP)
            .set_margin_fraction(egui::vec2(0.0, 0.05))
            .include_x(-0.5)
            .include_x(0.5)
            // Nearly uniform light is shown as uniform, so that rounding is not magnified.
            .include_y(lowest - 0.02)
            .include_y(lowest + 0.02)
            .x_grid_spacer(|_| (-2..=2).map(|i| GridMark { value: f64::from(i) / 4.0, step_size: 0.25 }).collect())
            // At the corner, it would meet the label of the other axis.
            .y_axis_formatter(|mark, range| match mark.value - range.start() {
                from if from < 0.06 * (range.end() - range.start()) => String::new(),
                _ => ui::signed(&format!("{:.*}", (-mark.step_size.log10()).ceil().max(0.0) as usize, mark.value)),
            })
            .x_axis_formatter(|mark, _| ui::signed(&mark.value.to_string()))
            .show(ui, |plot| {
                for (color, points) in lines {
                    plot.line(Line::new("", points.clone()).color(color).width(2.0));
                }
                over(plot);
            })
            .response
    };
    egui::Frame::NONE.inner_margin(margin).show(ui, plot).inner
}

/// Returns the requested and the emitted light.
fn curves(recipe: &Recipe, quantizer: &Quantizer) -> [Trace; 2] {
    let table = recipe.profile(quantizer);
    let numbers = |name| table.column(name).into_iter().flat_map(|of| of.cells.iter().filter_map(Cell::as_number));
    ["linear", "emitted"].map(|light| numbers("x").zip(numbers(light)).map(<[f64; 2]>::from).collect())
}

/// A stimulus, its side in pixels, and how it is seen.
type Key = (Stimulus, u32, ViewingConditions);

/// Predicts how visible the bands of a stimulus are, and the contrast of its picture.
fn predicted((stimulus, size, conditions): &Key) -> Result<(Visible, f64), String> {
    let visible = conditions.visible(&[stimulus], Some(*size)).map(|mut found| found.remove(0));
    visible.and_then(|visible| Ok((visible, conditions.detection(stimulus)?))).map_err(|error| error.to_string())
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
fn description(marks: &[Mark]) -> String {
    if marks.is_empty() {
        return "no predicted band".to_owned();
    }
    let one = |(place, is_bright): &Mark| format!("{} at {place:+.2}", if *is_bright { "bright" } else { "dark" });
    format!("predicted bands: {}", marks.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// Strength of a band that is just visible; weaker bands are not shown.
const JUST_VISIBLE: f64 = 1.0;

/// Returns the visible bands of a ramp.
fn marks(RampBands { bright, dark, at_deg, .. }: &RampBands, window_deg: f64) -> Vec<Mark> {
    let both = [(*bright, at_deg[0], true), (*dark, at_deg[1], false)];
    let visible = both.into_iter().filter(|(strength, ..)| *strength >= JUST_VISIBLE);
    visible.map(|(_, at_deg, is_bright)| (at_deg / window_deg, is_bright)).collect()
}
