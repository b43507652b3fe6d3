//! The panel of controls.

use std::ops::RangeInclusive;

use eframe::egui::{self, RichText};
use glam::DVec3;

use super::comparison::{Comparison, MeshChoice, depth_title, shader_title};
use crate::{
    app::ui::{Field, secondary, theme::ink},
    light::Depth,
    shading::{Correction, Highlight, Scene, Shade, Shader, shapes::Shape},
};

/// Width of the labels, points.
const LABEL: f32 = 84.0;
/// Maximum of the slider for vertices; a file can have more.
const MAX_VERTICES: usize = 20_000;
/// Distance of the eye in a perspective view, radii.
const PERSPECTIVE: f64 = 3.0;
/// The colors of the surface.
const COLORS: [(DVec3, &str); 2] = [(DVec3::ONE, "white"), (DVec3::new(1.0, 1.0, 0.0), "yellow")];
/// The range of a control for a share of the light.
const SHARE: RangeInclusive<f64> = 0.0..=1.0;

fn field<'a>(label: &'a str, name: &'a str) -> Field<'a> {
    Field::new(label).column(LABEL).named(name)
}

/// Draws the controls of one side's renderer.
pub fn side(ui: &mut egui::Ui, which: usize, shade: &mut Shade) {
    let place = ["Left", "Right"][which];
    ui.label(RichText::new(place).strong().color(ink(ui).sides()[which]));
    let name = |control: &str| format!("{place} {control}");
    field("Shader", &name("shader")).choice(ui, &mut shade.shader, Shader::ALL, |shader| shader_title(*shader));
    if shade.has_strip() {
        let depths: Vec<Depth> = (1..=Depth::MAX_FINITE).map(Depth::Finite).chain([Depth::Infinite]).collect();
        field("Depth n", &name("depth n"))
            .choice(ui, &mut shade.depth, &depths, |depth| depth_title(*depth))
            .on_hover_text("The continuity depth: n − 1 derivatives vanish at the ends of the strip.");
        field("Strip b", &name("strip b"))
            .slider(ui, &mut shade.boundary, 0.0..=1.0 / 3.0, 0.01)
            .on_hover_text("The width of the strip along each edge, as a barycentric weight.");
    }
    if shade.shader.interpolates_light() {
        let title = |correction: &Correction| correction.name().to_owned();
        field("Vertex", &name("vertex"))
            .choice(ui, &mut shade.vertex, Correction::ALL, title)
            .on_hover_text("The paper's correction at the vertices, as printed or repaired.");
        field("Reweight", &name("reweight"))
            .choice(ui, &mut shade.reweight, Correction::ALL, title)
            .on_hover_text("The paper's correction by the length of the normal, as printed or repaired.");
    } else {
        // A correction that was chosen for another shader must not stay on unseen.
        (shade.vertex, shade.reweight) = (Correction::Off, Correction::Off);
    }
}

/// Draws the controls of the mesh and its rotation.
pub fn mesh(ui: &mut egui::Ui, compared: &mut Comparison) {
    let MeshChoice { name, vertices } = compared.mesh.clone();
    let shapes = Shape::ALL.iter().map(|shape| shape.name().into());
    let file = compared.mesh.shape().is_none().then_some(name);
    let meshes: Vec<_> = shapes.chain(file).map(|name| MeshChoice { name, vertices }).collect();
    field("Mesh", "Shape of the mesh").choice(ui, &mut compared.mesh, &meshes, MeshChoice::title);
    let row = field("Vertices", "Number of vertices").log();
    match compared.mesh.shape().filter(|shape| shape.has_vertices()) {
        Some(shape) => {
            // Another shape may need more vertices.
            let (vertices, least) = (&mut compared.mesh.vertices, shape.min_vertices());
            *vertices = (*vertices).max(least);
            row.slider(ui, vertices, least..=MAX_VERTICES, 1.0);
        }
        // The row stays, so that what follows does not move.
        None => _ = row.show(ui, |ui, _| ui.horizontal(|ui| ui.label(secondary("as in the mesh")))),
    }
    let names = [("Rotate x", "Rotate about x"), ("Rotate y", "Rotate about y"), ("Rotate z", "Rotate about z")];
    for ((label, name), degrees) in names.into_iter().zip(&mut compared.scene.rotate_deg) {
        field(label, name).suffix("°").slider(ui, degrees, -180.0..=180.0, 1.0);
    }
}

/// Draws the controls of the light's direction.
pub fn light(ui: &mut egui::Ui, compared: &mut Comparison) {
    let before = compared.light_deg();
    let [mut right, mut up] = before;
    field("Light, right", "Light, degrees to the right").suffix("°").slider(ui, &mut right, -180.0..=180.0, 1.0);
    field("Light, up", "Light, degrees upward").suffix("°").slider(ui, &mut up, -90.0..=90.0, 1.0);
    if [right, up] != before {
        compared.set_light_deg([right, up]);
    }
}

/// Draws the controls of how the surface reflects light.
pub fn material(ui: &mut egui::Ui, scene: &mut Scene) {
    let color = |color: &DVec3| COLORS.iter().find(|(one, _)| one == color).map_or("", |(_, name)| name).to_owned();
    field("Color", "Color of the surface").choice(ui, &mut scene.color, &COLORS.map(|(color, _)| color), color);
    field("Ambient", "Ambient light").slider(ui, &mut scene.ambient, SHARE, 0.01);
    field("Diffuse", "Diffuse light").slider(ui, &mut scene.diffuse, SHARE, 0.01);
    field("Specular", "Specular light").slider(ui, &mut scene.specular, SHARE, 0.01);
    if scene.specular > 0.0 {
        let title = |shape: &Highlight| shape.name().replace('-', "–");
        field("Highlight", "Highlight model").choice(ui, &mut scene.highlight, Highlight::ALL, title);
        field("Exponent", "Highlight exponent").slider(ui, &mut scene.shininess, 1.0..=200.0, 1.0);
    }
    field("Background", "Light of the background").slider(ui, &mut scene.background, SHARE, 0.01);
    let mut perspective = scene.distance.is_finite();
    if ui.checkbox(&mut perspective, "Perspective").changed() {
        scene.distance = if perspective { PERSPECTIVE } else { f64::INFINITY };
    }
}
