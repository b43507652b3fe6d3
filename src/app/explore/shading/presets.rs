//! The paper's figures, and where the demo begins.

use super::comparison::{Comparison, MeshChoice, Side};
use crate::{
    light::Depth,
    shading::{Correction, Shade, Shader, shapes::Shape},
};

/// A comparison by name.
pub struct Preset {
    /// What it is called.
    pub name: &'static str,
    /// The mesh and the right shader; `None` for what the demo begins with.
    figure: Option<(MeshChoice, Shade)>,
}

impl Preset {
    /// Sets it. The figures' own views and lights are not known; those here stay. Gives where the divider goes:
    /// a figure is shown whole, Gouraud uncovered by dragging the divider.
    pub fn apply(&self, compared: &mut Comparison) -> f64 {
        match &self.figure {
            None => {
                *compared = Comparison::default();
                0.5
            }
            Some((mesh, shade)) => {
                compared.mesh = mesh.clone();
                compared.sides = [Side::new(Shade::new(Shader::Gouraud)), Side::new(*shade)];
                0.0
            }
        }
    }
}

/// All of them.
pub fn all() -> Vec<Preset> {
    let cube = |name, shade| Preset { name, figure: Some((MeshChoice::Named(Shape::Cube, 8), shade)) };
    let plain = |shader, n, boundary| Shade { depth: Depth::Finite(n), boundary, ..Shade::new(shader) };
    let fixed = |n, b| plain(Shader::Fixed, n, b);
    let vertex = |n, b| Shade { vertex: Correction::Printed, ..fixed(n, b) };
    let reweighted = |n, b| Shade { reweight: Correction::Printed, ..fixed(n, b) };
    let mut presets = vec![
        Preset { name: "Gouraud beside Patch", figure: None },
        cube("Figure 8 (a): flat", Shade::new(Shader::Flat)),
        cube("Figure 8 (b): Gouraud", Shade::new(Shader::Gouraud)),
        cube("Figure 8 (c): Phong", Shade::new(Shader::Phong)),
        cube("Figure 8 (d): fixed (3, 0.05)", fixed(3, 0.05)),
        cube("Figure 8 (e): fixed (3, 0.2)", fixed(3, 0.2)),
        cube("Figure 8 (f): fixed (3, 0.33)", fixed(3, 0.33)),
        cube("Figure 8 (g): fixed (5, 0.05)", fixed(5, 0.05)),
        cube("Figure 8 (h): fixed (5, 0.2)", fixed(5, 0.2)),
        cube("Figure 8 (i): fixed (5, 0.33)", fixed(5, 0.33)),
        cube("Figure 9 (a): vertex (3, 0.05)", vertex(3, 0.05)),
        cube("Figure 9 (b): vertex (3, 0.2)", vertex(3, 0.2)),
        cube("Figure 9 (c): vertex (3, 0.33)", vertex(3, 0.33)),
        cube("Figure 10 (a): reweighted (3, 0.05)", reweighted(3, 0.05)),
        cube("Figure 10 (b): reweighted (3, 0.2)", reweighted(3, 0.2)),
        cube("Figure 10 (c): reweighted (3, 0.33)", reweighted(3, 0.33)),
    ];
    let blobs: [(usize, [&'static str; 4]); 2] = [
        (
            313,
            [
                "Figure 11 (a): 622, fixed (1, 0.05)",
                "Figure 11 (b): 622, fixed (3, 0.2)",
                "Figure 11 (c): 622, vertex (3, 0.2)",
                "Figure 11 (d): 622, reweighted (3, 0.33)",
            ],
        ),
        (
            771,
            [
                "Figure 12 (a): 1538, fixed (1, 0.05)",
                "Figure 12 (b): 1538, fixed (3, 0.2)",
                "Figure 12 (c): 1538, vertex (3, 0.2)",
                "Figure 12 (d): 1538, reweighted (3, 0.33)",
            ],
        ),
    ];
    for (vertices, names) in blobs {
        let shades = [fixed(1, 0.05), fixed(3, 0.2), vertex(3, 0.2), reweighted(3, 0.33)];
        for (name, shade) in names.into_iter().zip(shades) {
            presets.push(Preset { name, figure: Some((MeshChoice::Named(Shape::Blob, vertices), shade)) });
        }
    }
    presets
}
