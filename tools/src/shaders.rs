//! How much of Gouraud's bands and creases each shader leaves: the tables of `docs/shaders.md` and `docs/shading.md`.

use std::error::Error;

use glam::DVec3;
use machband::{
    light::{Depth, LinearImage},
    shading::{Creases, Frame, Gradients, Mesh, Reference, Scene, Shade, Shader, Surface, crease, shapes},
    stimulus::ViewingConditions,
    vision::PicturePrediction,
};

/// Pixels per side of the images for bands, and of the images for creases.
const BANDS_PX: u32 = 512;
const CREASES_PX: u32 = 1024;
/// Width of the images, degrees of visual angle.
const WINDOW_DEG: f64 = 10.0;
/// Vertices of the meshes that approximate the smooth surfaces.
const FINE: usize = 60_000;

/// The visibility of the bands that each shader leaves, as the vision model predicts it: the table of
/// `docs/shaders.md`.
///
/// The images have 512 pixels per side and are 10° wide; outlines are excluded, and white is 100 cd/m². Each cell shows
/// the visibility of the strongest band and the amount of banding (the root mean square of the visibility over the surface), both
/// relative to Gouraud's. The lamp is at the viewer's eye and the surface is matte, so that the smooth surface has no
/// lines of its own. `--default-scene` uses the scene of the shading page, whose terminators and highlights are lines
/// of their own.
pub fn bands(is_default: bool) -> Result<(), Box<dyn Error>> {
    let lamp = |scene: Scene| if is_default { scene } else { Scene { light: DVec3::Z, specular: 0.0, ..scene } };
    let turned = |rotate_deg| lamp(Scene { rotate_deg, ..Scene::default() });
    let (usual, blob, sheet) =
        (turned(Scene::default().rotate_deg), turned([0.0, -30.0, 0.0]), turned([-20.0, 15.0, 0.0]));
    let shape = |shape, vertices| shapes::mesh(shape, vertices);
    let fine_blob = shape(shapes::Shape::Blob, FINE)?;
    let subjects = [
        ("sphere", usual, shape(shapes::Shape::Sphere, 642)?, shape(shapes::Shape::Sphere, FINE)?),
        ("torus", usual, shape(shapes::Shape::Torus, 768)?, shape(shapes::Shape::Torus, FINE)?),
        ("blob-622", blob, shape(shapes::Shape::Blob, 313)?, fine_blob.clone()),
        ("blob-1538", blob, shape(shapes::Shape::Blob, 771)?, fine_blob),
        ("sheet-512", sheet, waves(16, 0.24)?, waves(250, 0.0)?),
    ];
    let subjects: Vec<Subject> = subjects
        .into_iter()
        .map(|(name, scene, mesh, fine)| Subject::new(name, &scene, mesh, fine))
        .collect::<Result<_, _>>()?;
    println!("| shader | n | b | {} |", subjects.iter().map(|s| s.name).collect::<Vec<_>>().join(" | "));
    println!("|---|---|---|{}", "---|".repeat(subjects.len()));
    let smooth: Vec<String> = subjects.iter().map(|s| s.cell(&s.smooth)).collect();
    println!("| the smooth function | | | {} |", smooth.join(" | "));
    for shade in shades() {
        let cells =
            subjects.iter().map(|s| Ok(s.cell(&s.seen(&shade)?))).collect::<Result<Vec<_>, Box<dyn Error>>>()?;
        println!("| {} | {} |", head(&shade, format!("{:.2}", shade.boundary)).join(" | "), cells.join(" | "));
    }
    println!("\nGouraud's own: visibility, and amount:");
    for subject in &subjects {
        println!("{}: {:.1}, {:.2}", subject.name, subject.gouraud.visibility.max(), subject.gouraud.density);
    }
    Ok(())
}

/// A wavy sheet with triangles of many shapes and the normals of the waves.
fn waves(cells: usize, jitter: f64) -> Result<Mesh, Box<dyn Error>> {
    let along = |step: usize, at: u64| {
        let moved = if step == 0 || step == cells { 0.0 } else { jitter * noise(at) };
        (step as f64 + moved) / cells as f64 * 2.0 - 1.0
    };
    let place = |i: usize| {
        let (x, y) = (along(i % (cells + 1), 2 * i as u64), along(i / (cells + 1), 2 * i as u64 + 1));
        DVec3::new(x, y, 0.25 * (2.2 * x + 0.5).sin() * (1.9 * y - 0.4).cos())
    };
    let places: Vec<DVec3> = (0..(cells + 1).pow(2)).map(place).collect();
    let above = cells as u32 + 1;
    let corners = (0..cells as u32).flat_map(|row| (0..cells as u32).map(move |column| row * above + column));
    let triangles: Vec<[u32; 3]> =
        corners.flat_map(|a| [[a, a + 1, a + above + 1], [a, a + above + 1, a + above]]).collect();
    Ok(Mesh::new(&places, &triangles, 180.0)?.with_normals(|p| {
        let ((up, along), (down, across)) = ((2.2 * p.x + 0.5).sin_cos(), (1.9 * p.y - 0.4).sin_cos());
        DVec3::new(-0.25 * 2.2 * along * across, 0.25 * 1.9 * up * down, 1.0)
    }))
}

/// A pseudo-random number from −1 to 1 that depends only on `at` (SplitMix64).
fn noise(at: u64) -> f64 {
    let mut z = at.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}

struct Subject {
    name: &'static str,
    frame: Frame,
    gouraud: PicturePrediction,
    smooth: PicturePrediction,
}

impl Subject {
    fn new(name: &'static str, scene: &Scene, mesh: Mesh, fine: Mesh) -> Result<Subject, Box<dyn Error>> {
        let frame = scene.frame(&Surface::new(mesh), BANDS_PX, BANDS_PX);
        let gouraud = seen(&frame, &Reference::new(&frame, &Shade::new(Shader::Gouraud)).image())?;
        // Lighting is computed at every pixel from normals that hardly change within a triangle.
        let fine = scene.frame(&Surface::new(fine), BANDS_PX, BANDS_PX);
        let smooth = seen(&frame, &Reference::new(&fine, &Shade::new(Shader::Phong)).image())?;
        Ok(Subject { name, frame, gouraud, smooth })
    }

    fn seen(&self, shade: &Shade) -> Result<PicturePrediction, Box<dyn Error>> {
        seen(&self.frame, &Reference::new(&self.frame, shade).image())
    }

    fn cell(&self, view: &PicturePrediction) -> String {
        let strongest = view.visibility.max() / self.gouraud.visibility.max();
        format!("{strongest:.2}, {:.2}", view.density / self.gouraud.density)
    }
}

fn seen(frame: &Frame, image: &LinearImage) -> Result<PicturePrediction, Box<dyn Error>> {
    Ok(ViewingConditions::new(WINDOW_DEG).predict_surface(frame, image)?)
}

/// Each shader, with the depths and strip widths at which it is compared.
fn shades() -> Vec<Shade> {
    let family = |&shader: &Shader| match shader {
        Shader::Patch => Gradients::ALL.iter().map(|&gradients| Shade { gradients, ..Shade::new(shader) }).collect(),
        Shader::Cut => crossed(shader, &[1, 2], &[0.1, 1.0 / 3.0, 1.0]),
        Shader::GradientRepaired => crossed(shader, &[3], &[0.2]),
        _ if has_strip(shader) => crossed(shader, &[2, 3], &[0.05, 0.2, 1.0 / 3.0]),
        _ => vec![Shade::new(shader)],
    };
    Shader::ALL.iter().flat_map(family).collect()
}

/// Shader, n and b.
fn head(shade: &Shade, boundary: String) -> [String; 3] {
    let name = match shade.shader {
        Shader::Patch => format!("patch ({})", shade.gradients),
        shader => shader.to_string(),
    };
    if has_strip(shade.shader) {
        [name, shade.depth.to_string(), boundary]
    } else {
        [name, String::new(), String::new()]
    }
}

fn has_strip(shader: Shader) -> bool {
    use Shader::{Cut, Exact, Fixed, Gradient, GradientRepaired};
    matches!(shader, Fixed | Gradient | GradientRepaired | Exact | Cut)
}

fn crossed(shader: Shader, depths: &[u8], widths: &[f64]) -> Vec<Shade> {
    let shade = |depth, boundary| Shade { depth: Depth::Finite(depth), boundary, ..Shade::new(shader) };
    depths.iter().flat_map(|&depth| widths.iter().map(move |&width| shade(depth, width))).collect()
}

/// How much of Gouraud's creases each shader leaves.
///
/// A crease is the jump, on the screen, of the slope normal to an edge that two front-facing triangles share. It is
/// measured by one-sided differences of the luminance. Each cell shows the root mean square over the length of the
/// edges and the median, both relative to Gouraud's. A slope jump is not yet a perceived band.
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
    let gouraud: Vec<Creases> = frames.iter().map(|(_, frame)| Creases::of_gouraud(frame)).collect();

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
        Shader::Patch => Gradients::ALL.iter().map(|&gradients| Shade { gradients, ..Shade::new(shader) }).collect(),
        Shader::Cut => crossed(shader, &[1, 2, 3], &[0.1, 0.33, 1.0]),
        _ if has_strip(shader) => crossed(shader, &[2, 3, 5], &[0.05, 0.2, 0.33]),
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
    let ratios = format!("{}, {}", ratio(own.rms / gouraud.rms), ratio(own.median / gouraud.median));
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
    let reference = Reference::new(frame, shade);
    let vertices = crease::at_vertices(frame, |triangle, weights| reference.light(triangle, weights));
    (vertices.iter().map(|spread| spread * spread).sum::<f64>() / vertices.len() as f64).sqrt()
}
