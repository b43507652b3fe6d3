//! The control of a stimulus parameter.

use eframe::egui::{ComboBox, TextEdit, Ui};

use super::{
    fields::{Field, entry},
    text,
};
use crate::stimulus::{Parameter, ParameterValue};

/// Maximum width of a control, points.
const CONTROL: f32 = 240.0;
/// Widths of the button of a list with and without its edge, points.
const LIST: f32 = 38.0;
const ARROW: f32 = 32.0;

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
/// values.
///
/// The labels are in a column of this width, points. If an error, or its absence, is given, there is room for one below a
/// text field.
pub fn parameter(ui: &mut Ui, column: f32, parameter: &'static Parameter, text: &mut String, error: Option<&str>) {
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
        let room = ui.available_width().min(CONTROL) - LIST - ui.spacing().item_spacing.x;
        let edit = TextEdit::singleline(text).id_salt(("field", parameter.name)).desired_width(room);
        ui.add(edit).labelled_by(label).on_hover_text(format!("{}: {}", parameter.description, parameter.expected));
        let list = ComboBox::from_id_salt(parameter.name).selected_text("").width(ARROW);
        let list = list.show_ui(ui, |ui| {
            for level in parameter.levels_hint {
                if entry(ui, text == level, *level).clicked() {
                    (*level).clone_into(text);
                }
            }
        });
        text::name(ui, &list.response, &format!("Values of {}", parameter.words()));
        list.response.on_hover_text("Lists values to choose from.");
    };
    let field = error.map_or(field, |error| field.slot().error(error));
    field.show(ui, |ui, label| ui.horizontal(|ui| line(ui, label)));
}
