//! The crease metric, and how much of Gouraud's creases the shaders leave.

use crate::{frame, grid, random, shades, slopes::at_vertices};
use glam::{DVec2, DVec3};
use machband::shading::{
    Correction, Creases, Frame, Scene, Shade, Shader, Shading, Surface,
    shapes::{self, Shape},
};

/// B and C, and the apexes A and D of the two triangles at the edge between B and C, in pixels; [`LIGHTS`] are their
/// lights.
const PLACES: [DVec2; 4] =
    [DVec2::new(20.0, 60.0), DVec2::new(100.0, 75.0), DVec2::new(50.0, 10.0), DVec2::new(85.0, 110.0)];
const LIGHTS: [f64; 4] = [0.3, 0.55, 0.9, 0.2];

fn pair(places: [DVec2; 4], lights: [f64; 4]) -> Frame {
    let mut frame = frame(&places, &[[2, 0, 1], [3, 0, 1]], |_| DVec3::ZERO);
    for (vertex, light) in frame.vertices.iter_mut().zip(lights) {
        // The channels have different contrasts.
        vertex.light = DVec3::new(light, 0.5 * light, 0.0);
    }
    frame
}

/// Returns the jump across the edge of a gray pair: for each apex, the difference between its light and the edge's
/// light at its foot, divided by its height.
fn analytic_jump(places: [DVec2; 4], lights: [f64; 4]) -> f64 {
    let [b, c, a, d] = places;
    let slope_to = |apex: DVec2, light: f64| {
        let foot = (apex - b).dot(c - b) / (c - b).length_squared();
        let height = apex.distance(b + foot * (c - b));
        (light - (lights[0] + foot * (lights[1] - lights[0]))) / height
    };
    slope_to(a, lights[2]) + slope_to(d, lights[3])
}

fn scenes() -> Vec<(String, Frame)> {
    let mut frames = Vec::new();
    for (shape, vertices) in [(Shape::Sphere, 642), (Shape::Torus, 768), (Shape::Blob, 313), (Shape::Blob, 771)] {
        let surface = Surface::new(shapes::mesh(shape, vertices).expect("a mesh"));
        let turned = Scene { rotate_deg: [70.0, 10.0, 40.0], distance: 3.0, ..Scene::default() };
        for scene in [Scene::default(), turned] {
            let name = format!("{shape} of {} triangles", surface.mesh.triangles.len());
            frames.push((name, scene.frame(&surface, 512, 512)));
        }
    }
    frames
}

const GOURAUD: Shade = Shade::new(Shader::Gouraud);

fn over_gouraud(frame: &Frame, shade: &Shade) -> f64 {
    Creases::of(frame, shade).rms / Creases::of(frame, &GOURAUD).rms
}

#[test]
fn gouraud_jump_matches_the_analytic_value() {
    let creases = Creases::of(&pair(PLACES, LIGHTS), &GOURAUD);
    let expected = analytic_jump(PLACES, LIGHTS).abs() * (1.25_f64 / 3.0).sqrt();
    assert_eq!(creases.edges.len(), 1);
    for value in [creases.edges[0].jump, creases.rms, creases.median, creases.p95, creases.max] {
        assert!((value - expected).abs() < 1e-9, "{value}, expected {expected}");
    }
    assert!(creases.step_rms < 1e-15);
    assert!((creases.edges[0].length - PLACES[0].distance(PLACES[1])).abs() < 1e-12);
}

#[test]
fn a_smooth_field_has_no_crease() {
    let (places, triangles) = grid(6, 100.0, 0.24, 4);
    let frame = frame(&places, &triangles, |p| DVec3::splat(random((p.x * 1e4) as u64)));
    let creases = Creases::of_field(&frame, 1e-5, |t, w| {
        let [a, b, c] = frame.corners(t).map(|v| v.screen);
        let p = w[0] * a + w[1] * b + w[2] * c;
        DVec3::splat((0.2 * p.x).sin() * (0.3 * p.y).cos())
    });
    assert!(creases.max < 1e-7, "{}", creases.max);
    assert_eq!(Creases::of_field(&frame, 1e-5, |_, _| DVec3::ONE).max, 0.0);
}

/// Each shared edge of a frame is measured once, and silhouettes are not measured.
#[test]
fn every_shared_edge_is_measured_once() {
    for (name, frame) in scenes() {
        let sides = frame.triangles.iter().flat_map(|t| t.across);
        let shared = sides.flatten().count();
        let edges = Creases::of(&frame, &GOURAUD).edges;
        assert_eq!(2 * edges.len(), shared, "{name}");
        assert!(edges.len() > 300 && edges.iter().all(|e| e.jump.is_finite() && e.length > 0.0), "{name}");
    }
}

/// As printed, the regions of vertex shading overlap for widths above ¼, and the light jumps.
#[test]
fn both_sides_of_an_edge_have_the_same_light() {
    use Correction::{Off, Printed, Repaired};
    for (name, frame) in &scenes()[4..6] {
        for shade in shades(&[(1, 0.1), (3, 0.25), (0, 0.2)]).into_iter().filter(|shade| shade.shader != Shader::Flat) {
            for (vertex, reweight) in [(Off, Off), (Off, Printed), (Printed, Repaired), (Repaired, Off)] {
                let creases = Creases::of(frame, &Shade { vertex, reweight, ..shade });
                assert!(creases.step_rms < 1e-10, "{name}, {shade:?}, {vertex}, {reweight}: {}", creases.step_rms);
            }
        }
    }
}

#[test]
fn patch_leaves_at_most_a_thousandth_and_one_slope_per_vertex() {
    let rms = |frame: &Frame, shade: &Shade| {
        let shading = Shading::new(frame, shade);
        let spreads = at_vertices(frame, |t, w| shading.light(t, w));
        assert!(spreads.len() > 100);
        (spreads.iter().map(|spread| spread * spread).sum::<f64>() / spreads.len() as f64).sqrt()
    };
    for (name, frame) in scenes() {
        let shade = Shade::new(Shader::Patch);
        // Repaired vertex shading keeps the slopes continuous.
        for vertex in [Correction::Off, Correction::Repaired] {
            let ratio = over_gouraud(&frame, &Shade { vertex, ..shade });
            assert!(ratio <= 1e-3, "{name}, {vertex}: {ratio}");
        }
        let spread = rms(&frame, &shade) / rms(&frame, &Shade::new(Shader::Gouraud));
        assert!(spread <= 1e-3, "{name}: spread {spread} at the vertices");
    }
}
