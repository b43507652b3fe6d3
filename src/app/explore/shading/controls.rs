//! The panel of controls.

use eframe::egui::{self, ComboBox, Response, RichText, Slider};
use glam::DVec3;

use super::{
    canvas::COLORS,
    comparison::{Comparison, MeshChoice, Side, depth_text, title},
    look::Look,
    painters::{DrawnBy, Painters},
    presets,
};
use crate::{
    app::theme::compact,
    light::{Depth, Transfer},
    shading::{Correction, Gradients, Highlight, Scene, Shader, shapes::Shape},
};

/// Width of the labels, points.
const LABEL: f32 = 84.0;

/// Most vertices on the slider; more can come from a file.
const MOST_VERTICES: f64 = 20_000.0;
/// Distance of the eye in a perspective view, radii.
const PERSPECTIVE: f64 = 3.0;

/// Scenes by name.
pub fn preset(ui: &mut egui::Ui, compared: &mut Comparison, look: &mut Look, chosen: &mut &'static str) {
    let label = ui.label("Preset");
    let presets = presets::all();
    let response = ComboBox::from_id_salt("preset")
        .selected_text(*chosen)
        .width(ui.available_width())
        .truncate()
        .height(420.0)
        .show_ui(ui, |ui| {
            compact(ui);
            for preset in &presets {
                if ui.selectable_label(*chosen == preset.name, preset.name).clicked() {
                    look.divider = preset.apply(compared);
                    *chosen = preset.name;
                }
            }
        })
        .response;
    response.labelled_by(label.id);
}

/// One side's shader.
pub fn side(ui: &mut egui::Ui, which: usize, side: &mut Side) {
    let place = ["Left", "Right"][which];
    ui.label(RichText::new(place).strong().color(COLORS[which]));
    let name = |control: &str| format!("{place} {control}");
    choice(ui, "shader", &name("shader"), &mut side.shade.shader, Shader::ALL, |shader| title(*shader).to_owned());
    let shade = &mut side.shade;
    if shade.shader == Shader::Patch {
        choice(ui, "slopes from", &name("slopes"), &mut shade.gradients, Gradients::ALL, |g| {
            match g {
                Gradients::Curvature => "the mesh's curvature",
                Gradients::Ring => "neighbours, a plane",
                Gradients::Quadric => "neighbours, a quadric",
            }
            .to_owned()
        });
    }
    if side.has_strip() {
        let depths: Vec<Depth> = (1..=Depth::MAX_FINITE).map(Depth::Finite).chain([Depth::Infinite]).collect();
        choice(ui, "depth n", &name("depth n"), &mut side.shade.depth, &depths, |depth| depth_text(*depth));
        let most = if side.shade.shader == Shader::Cut { 1.0 } else { 1.0 / 3.0 };
        side.shade.boundary = side.shade.boundary.min(most);
        slider(ui, "strip b", &name("strip b"), &mut side.shade.boundary, 0.0..=most, 0.01);
    }
    if side.has_corrections() {
        let words = |c: &Correction| c.name().to_owned();
        choice(ui, "vertex", &name("vertex"), &mut side.shade.vertex, Correction::ALL, words);
        choice(ui, "reweight", &name("reweight"), &mut side.shade.reweight, Correction::ALL, words);
    }
    if side.can_be_naive() {
        let response = ui.checkbox(&mut side.naive, "ignore gamma, blend codes");
        named(ui, &response, &name("ignores gamma"));
    }
}

/// Which mesh, and how it is turned.
pub fn mesh(ui: &mut egui::Ui, compared: &mut Comparison) {
    let vertices = if let MeshChoice::Named(_, vertices) = compared.mesh { vertices } else { 313 };
    let mut meshes: Vec<_> = Shape::ALL.iter().map(|shape| MeshChoice::Named(*shape, vertices)).collect();
    if let MeshChoice::File(_) = compared.mesh {
        meshes.push(compared.mesh.clone());
    }
    choice(ui, "mesh", "Mesh", &mut compared.mesh, &meshes, MeshChoice::title);
    if let MeshChoice::Named(shape, vertices) = &mut compared.mesh
        && shape.has_vertices()
    {
        let mut number = (*vertices).max(shape.least_vertices()) as f64;
        let range = shape.least_vertices() as f64..=MOST_VERTICES;
        row(ui, "vertices", |ui| {
            let slider = Slider::new(&mut number, range).logarithmic(true).step_by(1.0).max_decimals(0);
            let response = ui.add(slider);
            named(ui, &response, "Vertices");
            // A preset's number, or one below the least of another shape.
            if response.changed() || *vertices < shape.least_vertices() {
                *vertices = number as usize;
            }
        });
    }
    for (axis, degrees) in ["x", "y", "z"].into_iter().zip(&mut compared.scene.rotate_deg) {
        degree(ui, &format!("turn {axis}"), &format!("Turn about {axis}"), degrees, 180.0);
    }
}

/// Where the light is.
pub fn light(ui: &mut egui::Ui, compared: &mut Comparison) {
    let before = compared.light_deg();
    let mut light = before;
    degree(ui, "light, right", "Light, degrees to the right", &mut light[0], 180.0);
    degree(ui, "light, up", "Light, degrees upward", &mut light[1], 90.0);
    if light != before {
        compared.set_light_deg(light);
    }
}

/// What the surface does with light.
pub fn material(ui: &mut egui::Ui, scene: &mut Scene) {
    row(ui, "colour", |ui| {
        let mut color = scene.color.as_vec3().to_array();
        let response = ui.color_edit_button_rgb(&mut color);
        named(ui, &response, "Colour");
        if response.changed() {
            scene.color = DVec3::from_array(color.map(f64::from));
        }
        if ui.button("white").clicked() {
            scene.color = DVec3::ONE;
        }
        if ui.button("yellow").clicked() {
            scene.color = DVec3::new(1.0, 1.0, 0.0);
        }
    });
    slider(ui, "ambient", "Ambient", &mut scene.ambient, 0.0..=1.0, 0.01);
    slider(ui, "diffuse", "Diffuse", &mut scene.diffuse, 0.0..=1.0, 0.01);
    slider(ui, "specular", "Specular", &mut scene.specular, 0.0..=1.0, 0.01);
    if scene.specular > 0.0 {
        choice(ui, "highlight", "Shape of the highlight", &mut scene.highlight, Highlight::ALL, |shape| {
            shape.name().replace('-', "–")
        });
        slider(ui, "exponent", "Exponent of the highlight", &mut scene.shininess, 1.0..=200.0, 1.0);
    }
    slider(ui, "ground", "Light around the surface", &mut scene.background, 0.0..=1.0, 0.01);
    let mut perspective = scene.distance.is_finite();
    if ui.checkbox(&mut perspective, "perspective").changed() {
        scene.distance = if perspective { PERSPECTIVE } else { f64::INFINITY };
    }
}

/// What the display makes of codes.
pub fn transfer(ui: &mut egui::Ui, compared: &mut Comparison) {
    let transfers = [Transfer::Srgb, Transfer::Gamma(2.2), Transfer::Gamma(1.8), Transfer::Linear];
    choice(ui, "display", "Transfer function of the display", &mut compared.transfer, &transfers, |transfer| {
        match transfer {
            Transfer::Srgb => "sRGB".to_owned(),
            Transfer::Linear => "linear".to_owned(),
            other => other.to_string().replace("gamma:", "gamma "),
        }
    });
}

/// How often the difference is amplified.
pub fn factor(ui: &mut egui::Ui, factor: &mut u8, label: egui::Id) {
    ComboBox::from_id_salt("factor")
        .selected_text(factor.to_string())
        .width(52.0)
        .show_ui(ui, |ui| {
            compact(ui);
            for one in [1, 2, 4, 8, 16, 32, 64] {
                ui.selectable_value(factor, one, one.to_string());
            }
        })
        .response
        .labelled_by(label);
}

/// Who draws, where both can.
pub fn painter(ui: &mut egui::Ui, painters: &mut Painters) {
    if let Ok(card) = painters.card_name() {
        choice(ui, "drawn by", "Drawn by", &mut painters.wanted, &[DrawnBy::Cpu, DrawnBy::Card], |by| match by {
            DrawnBy::Cpu => "CPU".to_owned(),
            DrawnBy::Card => card.clone(),
        });
    }
}

/// A label, and a control beside it.
fn row<R>(ui: &mut egui::Ui, label: &str, add: impl FnOnce(&mut egui::Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let size = egui::vec2(LABEL, ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
            ui.set_min_width(LABEL);
            ui.label(label);
        });
        // What a slider's number takes.
        ui.spacing_mut().slider_width = (ui.available_width() - 62.0).max(60.0);
        add(ui)
    })
    .inner
}

/// Tells what a control is to someone who does not see it.
fn named(ui: &egui::Ui, response: &Response, name: &str) {
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
}

/// A number. Left as it is, to the last digit, until it is moved.
fn slider(
    ui: &mut egui::Ui,
    label: &str,
    name: &str,
    value: &mut f64,
    range: std::ops::RangeInclusive<f64>,
    step: f64,
) {
    row(ui, label, |ui| {
        let (decimals, hundreds) = if step < 1.0 { (2, 100.0) } else { (0, 1.0) };
        // A slider rounds what it is given, and would call that a change.
        let mut shown = (*value * hundreds).round() / hundreds;
        let response = ui.add(Slider::new(&mut shown, range).step_by(step).max_decimals(decimals));
        named(ui, &response, name);
        if response.changed() {
            *value = shown;
        }
    });
}

/// An angle from −`most` to `most` degrees. Left as it is, to the last digit, until it is moved.
fn degree(ui: &mut egui::Ui, label: &str, name: &str, value: &mut f64, most: f64) {
    row(ui, label, |ui| {
        let mut shown = value.round();
        let response = ui.add(Slider::new(&mut shown, -most..=most).max_decimals(0).suffix("°"));
        named(ui, &response, name);
        if response.changed() {
            *value = shown;
        }
    });
}

/// One of several.
fn choice<T: PartialEq + Clone>(
    ui: &mut egui::Ui,
    label: &str,
    name: &str,
    value: &mut T,
    all: &[T],
    words: impl Fn(&T) -> String,
) {
    row(ui, label, |ui| {
        let response = ComboBox::from_id_salt(name)
            .selected_text(words(value))
            .width(ui.available_width())
            .truncate()
            .height(320.0)
            .show_ui(ui, |ui| {
                compact(ui);
                for one in all {
                    ui.selectable_value(value, one.clone(), words(one));
                }
            })
            .response;
        named(ui, &response, name);
    });
}
