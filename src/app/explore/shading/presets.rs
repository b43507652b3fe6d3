//! Comparisons by name: the page's first, and the paper's figures.

use super::comparison::{Comparison, MeshChoice};
use crate::{
    light::Depth,
    shading::{Correction, Shade, Shader, shapes::Shape},
    stimulus::Renderer,
};

/// A figure of the paper: a mesh, and the shader that is compared with Gouraud's.
type Figure = (&'static str, MeshChoice, Shade);

/// What the page begins with.
const FIRST: &str = "Gouraud beside Patch";

/// All names.
pub fn names() -> Vec<&'static str> {
    std::iter::once(FIRST).chain(figures().into_iter().map(|(name, ..)| name)).collect()
}

/// The name of what is compared, if it has one.
pub fn name_of(compared: &Comparison) -> Option<&'static str> {
    let first = (*compared == Comparison::default()).then_some(FIRST);
    let shown = |(_, mesh, shade): &Figure| {
        compared.mesh == *mesh && compared.sides == [Renderer::gouraud(), Renderer::new(*shade)]
    };
    first.or_else(|| figures().into_iter().find(shown).map(|(name, ..)| name))
}

/// Sets the comparison of this name. The views and lights of the paper's figures are not known: those here stay. Gives
/// where the divider goes: a figure is shown whole, and Gouraud is uncovered by dragging the divider.
pub fn apply(name: &str, compared: &mut Comparison) -> f64 {
    match figures().into_iter().find(|(figure, ..)| *figure == name) {
        None => {
            *compared = Comparison::default();
            0.5
        }
        Some((_, mesh, shade)) => {
            compared.mesh = mesh;
            compared.sides = [Renderer::gouraud(), Renderer::new(shade)];
            0.0
        }
    }
}

fn figures() -> Vec<Figure> {
    let fixed = |n, boundary| Shade { depth: Depth::Finite(n), boundary, ..Shade::new(Shader::Fixed) };
    let vertex = |n, b| Shade { vertex: Correction::Printed, ..fixed(n, b) };
    let reweighted = |n, b| Shade { reweight: Correction::Printed, ..fixed(n, b) };
    let cube = MeshChoice::Named(Shape::Cube, 8);
    let [coarse, fine] = [313, 771].map(|vertices| MeshChoice::Named(Shape::Blob, vertices));
    vec![
        ("Figure 8 (a): flat", cube.clone(), Shade::new(Shader::Flat)),
        ("Figure 8 (b): Gouraud", cube.clone(), Shade::new(Shader::Gouraud)),
        ("Figure 8 (c): Phong", cube.clone(), Shade::new(Shader::Phong)),
        ("Figure 8 (d): fixed (3, 0.05)", cube.clone(), fixed(3, 0.05)),
        ("Figure 8 (e): fixed (3, 0.2)", cube.clone(), fixed(3, 0.2)),
        ("Figure 8 (f): fixed (3, 0.33)", cube.clone(), fixed(3, 0.33)),
        ("Figure 8 (g): fixed (5, 0.05)", cube.clone(), fixed(5, 0.05)),
        ("Figure 8 (h): fixed (5, 0.2)", cube.clone(), fixed(5, 0.2)),
        ("Figure 8 (i): fixed (5, 0.33)", cube.clone(), fixed(5, 0.33)),
        ("Figure 9 (a): vertex (3, 0.05)", cube.clone(), vertex(3, 0.05)),
        ("Figure 9 (b): vertex (3, 0.2)", cube.clone(), vertex(3, 0.2)),
        ("Figure 9 (c): vertex (3, 0.33)", cube.clone(), vertex(3, 0.33)),
        ("Figure 10 (a): reweighted (3, 0.05)", cube.clone(), reweighted(3, 0.05)),
        ("Figure 10 (b): reweighted (3, 0.2)", cube.clone(), reweighted(3, 0.2)),
        ("Figure 10 (c): reweighted (3, 0.33)", cube, reweighted(3, 0.33)),
        ("Figure 11 (a): 622, fixed (1, 0.05)", coarse.clone(), fixed(1, 0.05)),
        ("Figure 11 (b): 622, fixed (3, 0.2)", coarse.clone(), fixed(3, 0.2)),
        ("Figure 11 (c): 622, vertex (3, 0.2)", coarse.clone(), vertex(3, 0.2)),
        ("Figure 11 (d): 622, reweighted (3, 0.33)", coarse, reweighted(3, 0.33)),
        ("Figure 12 (a): 1538, fixed (1, 0.05)", fine.clone(), fixed(1, 0.05)),
        ("Figure 12 (b): 1538, fixed (3, 0.2)", fine.clone(), fixed(3, 0.2)),
        ("Figure 12 (c): 1538, vertex (3, 0.2)", fine.clone(), vertex(3, 0.2)),
        ("Figure 12 (d): 1538, reweighted (3, 0.33)", fine, reweighted(3, 0.33)),
    ]
}
