//! How much of Gouraud's creases each shader leaves: the table of `docs/shading.md`.

use std::error::Error;

use machband::{
    light::Depth,
    shading::{Creases, Frame, Mesh, Scene, Shade, Shader, Shading, Surface, shapes},
};

use crate::slopes::at_vertices;

/// Pixels per side of the images.
const CREASES_PX: u32 = 1024;

/// Shader, n and b.
fn head(shade: &Shade, boundary: String) -> [String; 3] {
    let name = shade.shader.to_string();
    if shade.has_strip() { [name, shade.depth.to_string(), boundary] } else { [name, String::new(), String::new()] }
}

fn crossed(shader: Shader, depths: &[u8], widths: &[f64]) -> Vec<Shade> {
    let shade = |depth, boundary| Shade { depth: Depth::Finite(depth), boundary, ..Shade::new(shader) };
    depths.iter().flat_map(|&depth| widths.iter().map(move |&width| shade(depth, width))).collect()
}

/// How much of Gouraud's creases each shader leaves.
///
/// A crease is the jump, on the screen, of the slope normal to an edge that two front-facing triangles share. It is
/// measured by one-sided differences of the luminance. Each cell shows the median over the length of the edges and the
/// 95th percentile, both relative to Gouraud's. A slope jump is not yet a perceived band.
pub fn creases() -> Result<(), Box<dyn Error>> {
    let scene = Scene::default();
    let meshes: [(&str, Mesh); 4] = [
        ("sphere", shapes::mesh(shapes::Shape::Sphere, 642)?),
        ("torus", shapes::mesh(shapes::Shape::Torus, 768)?),
        ("blob-622", shapes::mesh(shapes::Shape::Blob, 313)?),
        ("blob-1538", shapes::mesh(shapes::Shape::Blob, 771)?),
    ];
    let frames: Vec<(&str, Frame)> = meshes
        .into_iter()
        .map(|(name, mesh)| (name, scene.frame(&Surface::new(mesh), CREASES_PX, CREASES_PX)))
        .collect();
    let gouraud: Vec<Creases> =
        frames.iter().map(|(_, frame)| Creases::of(frame, &Shade::new(Shader::Gouraud))).collect();

    println!("| shader | n | b | {} | vertices |", frames.iter().map(|f| f.0).collect::<Vec<_>>().join(" | "));
    println!("|---|---|---|{}", "---|".repeat(frames.len() + 1));
    for shades in families() {
        let rows: Vec<Row> = shades.iter().map(|shade| Row::of(shade, &frames, &gouraud)).collect();
        // One row for all shaders with identical results.
        let mut groups: Vec<Vec<&Row>> = Vec::new();
        for row in &rows {
            match groups.iter_mut().find(|group| group[0].cells == row.cells) {
                Some(group) => group.push(row),
                None => groups.push(vec![row]),
            }
        }
        for group in groups {
            let heads = [0, 1, 2].map(|column| listed(group.iter().map(|row| row.head[column].as_str())));
            println!("| {} | {} |", heads.join(" | "), group[0].cells.join(" | "));
        }
    }
    println!("\nGouraud's own at {CREASES_PX} × {CREASES_PX}, in linear light per pixel:");
    for ((name, _), c) in frames.iter().zip(&gouraud) {
        let edges = c.edges.len();
        println!("{name}: rms {:.1e}, median {:.1e}, 95 % {:.1e}, {edges} edges", c.rms, c.median, c.p95);
    }
    Ok(())
}

/// Each shader with the depths and widths at which its creases are compared.
fn families() -> Vec<Vec<Shade>> {
    let family = |&shader: &Shader| match shader {
        _ if Shade::new(shader).has_strip() => crossed(shader, &[2, 3, 5], &[0.05, 0.2, 0.33]),
        _ => vec![Shade::new(shader)],
    };
    Shader::ALL.iter().map(family).collect()
}

struct Row {
    /// Shader, n and b.
    head: [String; 3],
    cells: Vec<String>,
}

/// The distinct names in order of first appearance, separated by commas.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut once: Vec<&str> = Vec::new();
    for name in names {
        if !once.contains(&name) {
            once.push(name);
        }
    }
    once.join(", ")
}

impl Row {
    fn of(shade: &Shade, frames: &[(&str, Frame)], gouraud: &[Creases]) -> Row {
        let mut cells: Vec<String> =
            frames.iter().zip(gouraud).map(|((_, frame), gouraud)| cell(&Creases::of(frame, shade), gouraud)).collect();
        let spreads =
            frames.iter().map(|(_, frame)| spread(frame, shade) / spread(frame, &Shade::new(Shader::Gouraud)));
        let worst = spreads.fold(0.0, f64::max);
        cells.push(if worst < 1e-6 { ratio(worst) } else { format!("{worst:.1}") });
        Row { head: head(shade, shade.boundary.to_string()), cells }
    }
}

/// Creases relative to Gouraud's, and the jump of the luminance itself if there is one.
fn cell(own: &Creases, gouraud: &Creases) -> String {
    let ratios = format!("{}, {}", ratio(own.median / gouraud.median), ratio(own.p95 / gouraud.p95));
    if own.step_rms > 1e-9 { format!("{ratios}; steps of {:.3}", own.step_rms) } else { ratios }
}

fn ratio(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        _ if value < 1e-6 => "< 1e-6".to_owned(),
        _ => format!("{value:.2}"),
    }
}

/// How far the luminance is from having a single slope at each vertex: root mean square over the vertices.
fn spread(frame: &Frame, shade: &Shade) -> f64 {
    let shading = Shading::new(frame, shade);
    let vertices = at_vertices(frame, |triangle, weights| shading.light(triangle, weights));
    (vertices.iter().map(|spread| spread * spread).sum::<f64>() / vertices.len() as f64).sqrt()
}
