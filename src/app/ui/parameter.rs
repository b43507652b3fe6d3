//! The control of a stimulus parameter.

use eframe::egui::{self, ComboBox, Slider, TextEdit, Ui};

use super::fields::Field;
use crate::stimulus::{Parameter, ParameterValue, StimulusColor};

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

/// Returns the label of a parameter: `orientation, °` for `orientation_deg`.
pub fn label(parameter: &str) -> String {
    parameter.replace('_', " ").replace(" deg", ", °")
}

/// Draws the control of a parameter: a slider if it has a range, and otherwise a text field with a list of common
/// values. A value outside the range can be typed; the page then shows the error.
///
/// The labels are in a column of this width, points.
pub fn parameter(ui: &mut Ui, column: f32, parameter: &'static Parameter, text: &mut String) {
    Field::new(&label(parameter.name)).column(column).show(ui, |ui, label| {
        match (slider_range(parameter.name), text.parse::<f64>()) {
            (Some((least, most, step)), Ok(mut value)) => {
                ui.spacing_mut().slider_width = 130.0;
                let slider = Slider::new(&mut value, least..=most)
                    .clamping(egui::SliderClamping::Never)
                    .step_by(step)
                    .max_decimals(if step >= 1.0 { 0 } else { 4 });
                if ui.add(slider).labelled_by(label).on_hover_text(parameter.description).changed() {
                    *text = ParameterValue::Number(value).to_string();
                }
            }
            _ => {
                ui.horizontal(|ui| {
                    let field = ui.add(TextEdit::singleline(text).desired_width(90.0));
                    field
                        .labelled_by(label)
                        .on_hover_text(format!("{}: {}", parameter.description, parameter.expected));
                    ComboBox::from_id_salt(parameter.name).selected_text("…").width(40.0).show_ui(ui, |ui| {
                        let of_model = color_in_models(parameter, text);
                        for level in parameter.levels_hint.iter().map(|level| (*level).to_owned()).chain(of_model) {
                            ui.selectable_value(text, level.clone(), level);
                        }
                    });
                });
            }
        }
    });
}

/// Returns the color in `text`, written in every color model; empty if the parameter is not a color.
fn color_in_models(parameter: &Parameter, text: &str) -> Vec<String> {
    let is_color = parameter.name.starts_with("color");
    text.parse::<StimulusColor>().ok().filter(|_| is_color).map_or_else(Vec::new, StimulusColor::in_models)
}
