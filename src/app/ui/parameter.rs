//! The control of a stimulus parameter.

use eframe::egui::{self, ComboBox, TextEdit, Ui};

use super::{
    fields::{Field, entry},
    text,
    theme::ink,
};
use crate::stimulus::{Parameter, ParameterValue, StimulusColor};

/// Maximum width of a control, points.
const CONTROL: f32 = 240.0;
/// Widths of the button of a list, and of the button of a color picker, points.
const LIST: f32 = 38.0;
const PICKER: f32 = 32.0;
/// Opacity of the swatch of what is not a color, such as `same`.
const FAINT: f32 = 0.2;

/// Returns the lower end, upper end and step of a parameter's slider; `None` for a parameter whose values are not only
/// numbers.
fn slider_range(parameter: &str) -> Option<(f64, f64, f64)> {
    Some(match parameter {
        "width" | "low" | "high" | "side" => (0.0, 1.0, 0.005),
        "radius" => (0.01, 0.5, 0.005),
        "orientation_deg" => (0.0, 360.0, 1.0),
        "tanh_k" => (1.0, 20.0, 0.5),
        "exponent" => (0.5, 6.0, 0.05),
        "steps" | "squares" => (2.0, 32.0, 1.0),
        "facets" => (1.0, 32.0, 1.0),
        _ => return None,
    })
}

/// Returns the label of a factor: that of the parameter or, if it is not one of these, its name.
pub fn label(parameters: &[Parameter], factor: &str) -> String {
    parameters.iter().find(|parameter| parameter.name == factor).map_or_else(|| factor.to_owned(), Parameter::label)
}

/// Returns the name of a method as it is read: `QUEST+` for `quest-plus`.
pub fn method(name: &str) -> String {
    name.replace("quest-plus", "QUEST+")
}

/// Draws the control of a parameter: a slider if it has a range, and otherwise a text field with a list of common
/// values, and a color picker if it is a color.
///
/// The labels are in a column of this width, points.
pub fn parameter(ui: &mut Ui, column: f32, parameter: &'static Parameter, text: &mut String) {
    let name = parameter.label();
    let field = Field::new(&name).column(column);
    if let (Some((least, most, step)), Ok(mut value)) = (slider_range(parameter.name), text.parse::<f64>()) {
        let slider = field.width(CONTROL).slider(ui, &mut value, least..=most, step);
        if slider.on_hover_text(parameter.description).changed() {
            *text = ParameterValue::Number(value).to_string();
        }
        return;
    }
    let mut line = |ui: &mut Ui, label| {
        ui.spacing_mut().interact_size.x = PICKER;
        let gap = ui.spacing().item_spacing.x;
        let picker = if is_color(parameter) { PICKER + gap } else { 0.0 };
        let room = ui.available_width().min(CONTROL) - LIST - gap - picker;
        let edit = TextEdit::singleline(text).id_salt(("field", parameter.name)).desired_width(room);
        let about = format!("{}: {}", parameter.description, parameter.expected);
        ui.add(edit).labelled_by(label).on_hover_text(about);
        let list = ComboBox::from_id_salt(parameter.name).selected_text("").width(PICKER);
        let list = list.show_ui(ui, |ui| {
            for level in parameter.levels_hint {
                if entry(ui, text == level, *level).clicked() {
                    (*level).clone_into(text);
                }
            }
        });
        text::name(ui, &list.response, &format!("Values of {}", parameter.words()));
        list.response.on_hover_text("Lists values to choose from.");
        if is_color(parameter) {
            pick_color(ui, &parameter.words(), text);
        }
    };
    field.show(ui, |ui, label| ui.horizontal(|ui| line(ui, label)));
}

fn is_color(parameter: &Parameter) -> bool {
    parameter.name.starts_with("color")
}

/// Draws a button in the color of `text` that opens a color picker. A text that is not a color is shown faintly. Like
/// the weights of a stimulus, the picker's numbers are in linear light.
fn pick_color(ui: &mut Ui, name: &str, text: &mut String) {
    let color = text.parse::<StimulusColor>().ok();
    let mut rgb = color.as_ref().map_or([1.0; 3], |color| color.rgb().map(|weight| weight as f32));
    let button = ui.scope(|ui| {
        if color.is_none() {
            ui.multiply_opacity(FAINT);
        }
        ui.color_edit_button_rgb(&mut rgb)
    });
    let button = button.inner;
    swatch_edge(ui, &button);
    text::name(ui, &button, &format!("Pick the {name}"));
    if button.changed() {
        let [r, g, b] = rgb.map(|weight| (f64::from(weight.clamp(0.0, 1.0)) * 1e3).round() / 1e3);
        // A stimulus without light has no color, so the picker stops just above black.
        let [r, g, b] = if [r, g, b] == [0.0; 3] { [0.001; 3] } else { [r, g, b] };
        let weights = format!("{r},{g},{b}");
        *text = weights.parse().map_or(weights, |color: StimulusColor| color.to_string());
    }
    button.on_hover_text("Opens a color picker.");
}

/// Draws the edge of a swatch, so that a white one can be seen on a white page too.
pub fn swatch_edge(ui: &Ui, swatch: &egui::Response) {
    let edge = egui::Stroke::new(1.0, ink(ui).edge);
    ui.painter().rect_stroke(swatch.rect, 4.0, edge, egui::StrokeKind::Inside);
}
