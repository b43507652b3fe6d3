//! How far each shader's picture is from the smooth surface, the tables whose ranges `docs/shaders.md` gives; and how much
//! of Gouraud's creases each leaves, the table of `docs/shading.md`.

use std::error::Error;

use glam::{DMat2, DVec2, DVec3};
use machband::{
    light::{Depth, LinearImage},
    shading::{
        Creases, Frame, Mesh, Normals, Scene, Shade, Shader, Shading, Surface, Vertex,
        shapes::{self, Shape},
    },
    stimulus::{Judged, Residual, ViewingConditions, emitted},
};

/// Pixels per side of the images.
const SIDE: u32 = 512;
/// Width of the images, degrees of visual angle.
const WINDOW_DEG: f64 = 10.0;
/// The number of parts into which tessellation cuts each edge.
const PARTS: usize = 8;

/// The meshes: name, shape, number of vertices, and rotation in degrees.
const MESHES: [(&str, Shape, usize, [f64; 3]); 8] = [
    ("terrain, 512", Shape::Terrain, 289, [-35.0, 10.0, 20.0]),
    ("blob, 636", Shape::Blob, 320, ROTATED),
    ("torus, 1548", Shape::Torus, 768, ROTATED),
    ("jittered torus, 800", Shape::JitteredTorus, 400, ROTATED),
    ("UV sphere, 1344", Shape::UvSphere, 674, ROTATED),
    ("sphere, 1280", Shape::Sphere, 642, ROTATED),
    ("filleted cylinder, 384", Shape::FilletedCylinder, 194, [60.0, -35.0, 0.0]),
    ("cylinder, 92", Shape::Cylinder, 48, [60.0, -35.0, 0.0]),
];

const ROTATED: [f64; 3] = [25.0, -35.0, 0.0];

/// The scenes, with their titles.
fn scenes() -> [(&'static str, Scene); 3] {
    let scene = Scene::default();
    [
        ("Highlight, lamp aside", Scene { specular: 0.3, light: DVec3::new(0.5, 0.5, 0.7), ..scene }),
        ("The default scene of `machband shade`", scene),
        ("Matt, lamp at the eye", Scene { light: DVec3::Z, specular: 0.0, ..scene }),
    ]
}

/// Prints, for every scene, the residual of each shader relative to Gouraud's; then the residuals with estimated
/// normals.
pub fn residuals() -> Result<(), Box<dyn Error>> {
    for (title, scene) in scenes() {
        let mut subjects = Vec::new();
        for (name, shape, vertices, rotate_deg) in MESHES {
            subjects.push(Subject::new(name, &Scene { rotate_deg, ..scene }, shape, vertices)?);
        }
        println!("\n### {title}\n");
        heading("shader", &subjects);
        for (name, drawn) in rows() {
            let cells = subjects.iter().map(|subject| subject.cell(&drawn)).collect::<Result<Vec<_>, _>>()?;
            println!("| {name} | {} |", cells.join(" | "));
        }
        println!();
        let gouraud = |what: &str, of: &dyn Fn(&Subject) -> f64| {
            let values: Vec<String> = subjects.iter().map(|subject| format!("{:.4}", of(subject))).collect();
            println!("{what}: {}", values.join(", "));
        };
        gouraud("Gouraud's rms", &|subject| subject.gouraud.0.rms);
        gouraud("Gouraud's bands", &|subject| subject.gouraud.1);
        gouraud("share not compared", &|subject| subject.judged.not_compared().unwrap_or(1.0));
    }
    normals()
}

fn heading(first: &str, subjects: &[Subject]) {
    println!("| {first} | {} |", subjects.iter().map(|subject| subject.name).collect::<Vec<_>>().join(" | "));
    println!("|---|{}", "---|".repeat(subjects.len()));
}

/// Prints how much is lost with normals that are estimated from the triangles: residuals relative to those of Gouraud
/// with the true normals, in the first scene.
fn normals() -> Result<(), Box<dyn Error>> {
    let [(title, scene), ..] = scenes();
    println!("\n### {title}: estimated normals\n");
    let mut subjects = Vec::new();
    for (name, shape, vertices, rotate_deg) in MESHES {
        subjects.push(Subject::new(name, &Scene { rotate_deg, ..scene }, shape, vertices)?);
    }
    heading("normals", &subjects);
    for normals in Normals::ALL {
        for shader in [Shader::Gouraud, Shader::Phong, Shader::C1Phong] {
            let of = |subject: &Subject| {
                let mesh = subject.mesh.clone().estimated(*normals);
                let (residual, _) = subject.judge(&subject.framed(mesh), &Shade::new(shader))?;
                Ok(format!("{:.3}", residual.rms / subject.gouraud.0.rms))
            };
            let cells: Result<Vec<String>, Box<dyn Error>> = subjects.iter().map(of).collect();
            println!("| {normals}, `{shader}` | {} |", cells?.join(" | "));
        }
    }
    Ok(())
}

/// What is drawn in place of Gouraud's picture.
enum Drawn {
    Shade(Shade),
    /// More triangles of the same surface under Gouraud, by this factor.
    Finer(usize),
    /// With this factor for the middle ordinates of the normals.
    PnTriangles(f64),
    PhongTessellation,
}

fn rows() -> Vec<(String, Drawn)> {
    let strip = |shader, depth, boundary| Shade { depth: Depth::Finite(depth), boundary, ..Shade::new(shader) };
    let shades = [
        Shade::new(Shader::Flat),
        Shade::new(Shader::Phong),
        Shade::new(Shader::Quadratic),
        strip(Shader::Fixed, 3, 0.2),
        strip(Shader::Gradient, 3, 0.2),
        Shade::new(Shader::Patch),
        Shade::new(Shader::C1Phong),
    ];
    let named = |shade: Shade| {
        let plain = format!("`{}`", shade.shader);
        let strips = format!(" ({}, {:.2})", shade.depth, shade.boundary);
        let name = if shade.has_strip() { plain + &strips } else { plain };
        (name, Drawn::Shade(shade))
    };
    let mut rows: Vec<(String, Drawn)> = shades.into_iter().map(named).collect();
    rows.push(("PN triangles as printed, 64 for each, `phong`".to_owned(), Drawn::PnTriangles(1.0)));
    rows.push(("PN triangles with Bézier normals, 64 for each, `phong`".to_owned(), Drawn::PnTriangles(2.0)));
    rows.push(("Phong tessellation, 64 for each, `phong`".to_owned(), Drawn::PhongTessellation));
    rows.push(("`gouraud`, 4 × the triangles".to_owned(), Drawn::Finer(4)));
    rows.push(("`gouraud`, 16 × the triangles".to_owned(), Drawn::Finer(16)));
    rows
}

struct Subject {
    name: &'static str,
    shape: Shape,
    mesh: Mesh,
    frame: Frame,
    judged: Judged,
    gouraud: (Residual, f64),
}

impl Subject {
    fn new(name: &'static str, scene: &Scene, shape: Shape, vertices: usize) -> Result<Subject, Box<dyn Error>> {
        let mesh = shapes::mesh(shape, vertices)?;
        let frame = scene.frame(&Surface::new(mesh.clone()), SIDE, SIDE);
        let judged = Judged::known(&frame);
        let mut subject = Subject { name, shape, mesh, frame, judged, gouraud: Default::default() };
        subject.gouraud = subject.judge(&subject.frame, &Shade::new(Shader::Gouraud))?;
        Ok(subject)
    }

    /// Returns the frame of another mesh of the same surface, in the same place.
    fn framed(&self, mesh: Mesh) -> Frame {
        let Frame { sphere, view, lighting, background, .. } = &self.frame;
        Frame::within(*sphere, &Surface::new(mesh), view, lighting, *background)
    }

    /// Returns the residual, and the largest visible difference from the smooth surface.
    fn judge(&self, frame: &Frame, shade: &Shade) -> Result<(Residual, f64), Box<dyn Error>> {
        let image: LinearImage = emitted(frame, shade);
        let residual = self.judged.residual(&viewing(), &image).ok_or("the surface is not known")?;
        let difference = self.judged.difference(&viewing(), &image)?.ok_or("the surface is not known")?;
        Ok((residual, difference.largest))
    }

    fn cell(&self, drawn: &Drawn) -> Result<String, Box<dyn Error>> {
        let (residual, visible) = match drawn {
            Drawn::Shade(shade) => self.judge(&self.frame, shade)?,
            Drawn::Finer(factor) => {
                let finer = shapes::mesh(self.shape, self.mesh.vertices.len() * factor)?;
                self.judge(&self.framed(finer), &Shade::new(Shader::Gouraud))?
            }
            Drawn::PnTriangles(factor) => {
                let fine = tessellated(&self.mesh, |corners, w| pn(corners, w, *factor));
                self.judge(&self.framed(fine), &Shade::new(Shader::Phong))?
            }
            Drawn::PhongTessellation => {
                self.judge(&self.framed(tessellated(&self.mesh, phong)), &Shade::new(Shader::Phong))?
            }
        };
        let (gouraud, own) = self.gouraud;
        let visible = if own > 0.0 { format!("{:.2}", visible / own) } else { "–".to_owned() };
        Ok(format!("{:.3}, {:.3}, {visible}", residual.rms / gouraud.rms, residual.p999 / gouraud.p999))
    }
}

fn viewing() -> ViewingConditions {
    ViewingConditions::new(WINDOW_DEG)
}

/// Cuts every triangle into [`PARTS`]² triangles, whose vertices `of` computes from the corners and the weights.
fn tessellated(mesh: &Mesh, of: impl Fn([Vertex; 3], [f64; 3]) -> (DVec3, DVec3)) -> Mesh {
    let mut fine = Mesh { vertices: Vec::new(), triangles: Vec::new(), smooth: mesh.smooth, paint: None };
    for triangle in &mesh.triangles {
        let corners = triangle.map(|v| mesh.vertices[v as usize]);
        let mut vertex = |i: usize, j: usize| {
            let w = [PARTS - i - j, i, j].map(|part| part as f64 / PARTS as f64);
            let (position, normal) = of(corners, w);
            let site = fine.vertices.len() as u32;
            fine.vertices.push(Vertex { position, normal: normal.normalize(), site });
            site
        };
        for i in 0..PARTS {
            for j in 0..PARTS - i {
                fine.triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 2 <= PARTS {
                    fine.triangles.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
                }
            }
        }
    }
    fine
}

/// A. Vlachos et al. 2001: a cubic through the corners, tangent to their planes, and a quadratic of the normals. The
/// paper gives the normals in the middle of the edges the weights w_i·w_j, which moves the normals of a flat mesh toward
/// the corners' (`factor` 1); a Bézier quadratic has twice these weights.
fn pn(corners: [Vertex; 3], w: [f64; 3], factor: f64) -> (DVec3, DVec3) {
    let [p, n] = [corners.map(|c| c.position), corners.map(|c| c.normal)];
    let (mut position, mut normal, mut edges) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for i in 0..3 {
        position += p[i] * w[i].powi(3);
        normal += n[i] * w[i].powi(2);
        for j in [(i + 1) % 3, (i + 2) % 3] {
            let toward = (2.0 * p[i] + p[j] - n[i] * (p[j] - p[i]).dot(n[i])) / 3.0;
            position += toward * (3.0 * w[i] * w[i] * w[j]);
            edges += toward / 6.0;
        }
        let j = (i + 1) % 3;
        let edge = p[j] - p[i];
        let bend = 2.0 * edge.dot(n[i] + n[j]) / edge.length_squared();
        normal += (n[i] + n[j] - edge * bend).normalize() * (factor * w[i] * w[j]);
    }
    let middle = edges + (edges - (p[0] + p[1] + p[2]) / 3.0) / 2.0;
    (position + middle * (6.0 * w[0] * w[1] * w[2]), normal)
}

/// T. Boubekeur & M. Alexa 2008: three quarters of the way from the flat triangle to the mean of its projections onto
/// the corners' planes.
fn phong(corners: [Vertex; 3], w: [f64; 3]) -> (DVec3, DVec3) {
    let flat: DVec3 = (0..3).map(|i| corners[i].position * w[i]).sum();
    let onto = |c: Vertex| flat - c.normal * (flat - c.position).dot(c.normal);
    let projected: DVec3 = (0..3).map(|i| onto(corners[i]) * w[i]).sum();
    (flat.lerp(projected, 0.75), (0..3).map(|i| corners[i].normal * w[i]).sum())
}

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

/// For every vertex of a drawn triangle, returns how far the light around it is from having a single slope there: the
/// root mean square difference between the slopes along the edges and medians that begin at the vertex and the gradient
/// that fits them best, in linear light per pixel.
fn at_vertices(frame: &Frame, light: impl Fn(usize, [f64; 3]) -> DVec3) -> Vec<f64> {
    let mut slopes: Vec<Vec<(DVec2, DVec3)>> = vec![Vec::new(); frame.vertices.len()];
    for (t, triangle) in frame.triangles.iter().enumerate() {
        let [a, b, c] = frame.corners(t).map(|v| v.screen);
        for k in 0..3 {
            let [own, next, last] = [0, 1, 2].map(|i| DVec3::AXES[(k + i) % 3]);
            for target in [next, last, (next + last) / 2.0] {
                let step = 1e-5 * (target - own);
                // The offset on the screen, relative to the first corner, because the changes of the weights sum to 0.
                let offset = step.y * (b - a) + step.z * (c - a);
                let [at_0, at_1, at_2] = [0.0, 1.0, 2.0].map(|steps| light(t, (own + steps * step).to_array()));
                // The error is proportional to the square of the step.
                let slope = (4.0 * at_1 - at_2 - 3.0 * at_0) / (2.0 * offset.length());
                slopes[triangle.vertices[k] as usize].push((offset.normalize(), slope));
            }
        }
    }
    let spread = |slopes: &Vec<(DVec2, DVec3)>| {
        let normal: DMat2 = slopes.iter().map(|(d, _)| DMat2::from_cols(d.x * d, d.y * d)).sum();
        let of_channel = |channel: usize| {
            let gradient = normal.inverse() * slopes.iter().map(|(d, slope)| slope[channel] * d).sum::<DVec2>();
            slopes.iter().map(|(d, slope)| (slope[channel] - d.dot(gradient)).powi(2)).sum::<f64>()
        };
        ((0..3).map(of_channel).sum::<f64>() / (3 * slopes.len()) as f64).sqrt()
    };
    slopes.iter().filter(|slopes| !slopes.is_empty()).map(spread).collect()
}
