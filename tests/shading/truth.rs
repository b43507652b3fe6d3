//! Smooth surfaces: the normals and lines of sight of the known ones, and how far each shader's picture is from them. The
//! crease metric, and how much of Gouraud's creases the shaders leave.

use glam::{DVec2, DVec3};
use machband::{
    light::LinearImage,
    shading::{
        Correction, Creases, Frame, Mesh, Normals, Scene, Shade, Shader, Surface, Truth,
        shapes::{self, Shape},
    },
    stimulus::{Judged, ViewingConditions, emitted},
};

use crate::{frame, grid, random, shades};

const SIDE: u32 = 256;

/// The shapes whose surface is known, with the number of vertices and the rotation with which they are shown.
const SHAPES: [(Shape, usize, [f64; 3]); 8] = [
    (Shape::Terrain, 289, [-35.0, 10.0, 20.0]),
    (Shape::Blob, 320, [25.0, -35.0, 0.0]),
    (Shape::Torus, 768, [25.0, -35.0, 0.0]),
    (Shape::JitteredTorus, 400, [25.0, -35.0, 0.0]),
    (Shape::UvSphere, 674, [25.0, -35.0, 0.0]),
    (Shape::Sphere, 642, [25.0, -35.0, 0.0]),
    (Shape::FilletedCylinder, 194, [60.0, -35.0, 0.0]),
    (Shape::Cylinder, 48, [60.0, -35.0, 0.0]),
];

/// A highlight, with the lamp aside; the default; matt, with the lamp at the eye.
fn scenes(rotate_deg: [f64; 3]) -> [Scene; 3] {
    let scene = Scene { rotate_deg, ..Scene::default() };
    [
        Scene { specular: 0.3, light: DVec3::new(0.5, 0.5, 0.7), ..scene },
        scene,
        Scene { specular: 0.0, light: DVec3::Z, ..scene },
    ]
}

fn drawn(frame: &Frame, shader: Shader) -> LinearImage {
    emitted(frame, &Shade::new(shader))
}

/// The residuals of the shaders over Gouraud's.
fn residuals<const N: usize>(frame: &Frame, shaders: [Shader; N]) -> [f64; N] {
    let viewing = ViewingConditions::new(10.0);
    let judged = Judged::known(frame);
    assert!(judged.not_compared().unwrap() < 0.25, "{:?}", judged.not_compared());
    let rms = |shader| judged.residual(&viewing, &drawn(frame, shader)).unwrap().rms;
    let gouraud = rms(Shader::Gouraud);
    shaders.map(|shader| rms(shader) / gouraud)
}

#[test]
fn c1_phong_is_closest_to_the_smooth_surface() {
    for (shape, vertices, rotate_deg) in SHAPES {
        let surface = Surface::new(shapes::mesh(shape, vertices).unwrap());
        for (which, scene) in scenes(rotate_deg).into_iter().enumerate() {
            let frame = scene.frame(&surface, SIDE, SIDE);
            let [phong, c1] = residuals(&frame, [Shader::Phong, Shader::C1Phong]);
            assert!(c1 <= 0.6 * phong, "{shape}, scene {which}: {c1} and {phong}");
            let most = if shape == Shape::UvSphere { 0.1 } else { 0.3 };
            assert!(which > 0 || c1 <= most, "{shape}: {c1}");
        }
    }
}

/// People see flat shading's difference from the surface more than Gouraud's, Gouraud's more than that of Phong or
/// `patch`, and that of `c1-phong` least.
#[test]
fn the_visible_difference_orders_the_shaders() {
    let viewing = ViewingConditions::new(10.0);
    // On the cylinder, whose light bends only along its axis, `patch` and Gouraud are about alike.
    for (shape, vertices, _) in SHAPES.into_iter().filter(|(shape, ..)| *shape != Shape::Cylinder) {
        let surface = Surface::new(shapes::mesh(shape, vertices).unwrap());
        let frame = Scene::default().frame(&surface, SIDE, SIDE);
        let judged = Judged::known(&frame);
        let shaders = [Shader::Flat, Shader::Gouraud, Shader::Phong, Shader::Patch, Shader::C1Phong];
        let seen = shaders.map(|shader| judged.difference(&viewing, &drawn(&frame, shader)).unwrap().unwrap().largest);
        let [flat, gouraud, phong, patch, c1] = seen;
        assert!(flat > gouraud && gouraud > phong && gouraud > patch && phong > c1 && patch > c1, "{shape}: {seen:?}");
    }
}

#[test]
fn slopes_continue_across_every_edge_under_c1_phong() {
    for (shape, vertices, rotate_deg) in SHAPES {
        let surface = Surface::new(shapes::mesh(shape, vertices).unwrap());
        for scene in scenes(rotate_deg) {
            for distance in [f64::INFINITY, 3.0] {
                let frame = Scene { distance, ..scene }.frame(&surface, SIDE, SIDE);
                let own = Creases::of(&frame, &Shade::new(Shader::C1Phong));
                let over = own.rms / Creases::of(&frame, &Shade::new(Shader::Gouraud)).rms;
                // Where a plane runs into a rounding, the slope of the surface's own light jumps, and the shader's too.
                let most = if shape == Shape::FilletedCylinder { 0.3 } else { 1e-6 };
                assert!(own.median < 1e-6 && over < most && own.step_rms < 1e-12, "{shape}: {over}, {}", own.median);
            }
        }
    }
}

/// Returns a mesh whose vertices lie on the surface, and far more of them than the shader needs.
fn fine(shape: Shape) -> Mesh {
    shapes::mesh(shape, 20_000).unwrap()
}

#[test]
fn traced_surface_looks_like_a_fine_mesh() {
    for (shape, vertices, rotate_deg) in SHAPES {
        for distance in [f64::INFINITY, 3.0] {
            let scene = Scene { distance, ..scenes(rotate_deg)[0] };
            let frame = scene.frame(&Surface::new(shapes::mesh(shape, vertices).unwrap()), SIDE, SIDE);
            let traced = Truth::traced(&frame).unwrap();
            let meshed = Truth::of_mesh(&frame, &Surface::new(fine(shape)));
            let (a, b, mask) = (traced.picture(&frame), meshed.picture(&frame), traced.mask(&frame, true));
            let worst = mask.iter().enumerate().filter(|(_, counts)| **counts);
            let worst = worst.map(|(i, _)| (a.data[3 * i] - b.data[3 * i]).abs()).fold(0.0, f32::max);
            assert!(worst < 0.03, "{shape} from {distance}: {worst}");
        }
    }
}

/// The truth is not known for the cube, and a mesh that is its own truth has only Phong's residual of rounding.
#[test]
fn unknown_surfaces_have_no_residual() {
    let viewing = ViewingConditions::new(10.0);
    let frame = Scene::default().frame(&Surface::new(shapes::cube()), SIDE, SIDE);
    assert!(Judged::known(&frame).residual(&viewing, &drawn(&frame, Shader::Phong)).is_none());
    let surface = Surface::new(shapes::blob(2000));
    let frame = Scene::default().frame(&surface, SIDE, SIDE);
    let judged = Judged::new(&frame, Some(&Truth::of_mesh(&frame, &surface)));
    let rms = |shader| judged.residual(&viewing, &drawn(&frame, shader)).unwrap().rms;
    assert!(rms(Shader::Phong) < 1e-6 && rms(Shader::Gouraud) > 1e-4, "{}", rms(Shader::Phong));
}

/// The root mean square of the angle between the estimated normals and the surface's, degrees, over the vertices that
/// are not at the border of the terrain.
fn error_deg(mesh: &Mesh, normals: Normals) -> f64 {
    let estimated = mesh.clone().estimated(normals);
    let inside =
        |p: DVec3| mesh.smooth != Some(machband::shading::Smooth::Terrain) || p.truncate().abs().max_element() < 0.99;
    let pairs = mesh.vertices.iter().zip(&estimated.vertices).filter(|(v, _)| inside(v.position));
    let squares: Vec<f64> = pairs.map(|(v, e)| v.normal.angle_between(e.normal).to_degrees().powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn estimated_normals_approach_the_surfaces() {
    // On a sphere, hardly anything is missed; elsewhere, `best` is closer than Shoaff's means.
    for mesh in [shapes::sphere(8), shapes::mesh(Shape::UvSphere, 674).unwrap()] {
        assert!(error_deg(&mesh, Normals::Best) < 0.3, "{}", error_deg(&mesh, Normals::Best));
        assert_eq!(error_deg(&mesh, Normals::Given), 0.0);
    }
    for (shape, vertices) in [(Shape::Blob, 771), (Shape::JitteredTorus, 400), (Shape::FilletedCylinder, 600)] {
        let mesh = shapes::mesh(shape, vertices).unwrap();
        let [averaged, best] = [Normals::Averaged, Normals::Best].map(|normals| error_deg(&mesh, normals));
        assert!(best < 0.8 * averaged, "{shape}: {best} {averaged}");
    }
}

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

fn creased() -> Vec<(String, Frame)> {
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

fn over_gouraud(frame: &Frame, shade: &Shade) -> f64 {
    Creases::of(frame, shade).rms / Creases::of(frame, &Shade::new(Shader::Gouraud)).rms
}

#[test]
fn gouraud_jump_matches_the_analytic_value() {
    let creases = Creases::of(&pair(PLACES, LIGHTS), &Shade::new(Shader::Gouraud));
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

/// As printed, the regions of vertex shading overlap for widths above ¼, and the light jumps.
#[test]
fn both_sides_of_an_edge_have_the_same_light() {
    use Correction::{Off, Printed, Repaired};
    for (name, frame) in &creased()[4..6] {
        for shade in shades(&[(1, 0.1), (3, 0.25), (0, 0.2)]).into_iter().filter(|shade| shade.shader != Shader::Flat) {
            for (vertex, reweight) in [(Off, Off), (Off, Printed), (Printed, Repaired), (Repaired, Off)] {
                let creases = Creases::of(frame, &Shade { vertex, reweight, ..shade });
                assert!(creases.step_rms < 1e-10, "{name}, {shade:?}, {vertex}, {reweight}: {}", creases.step_rms);
            }
        }
    }
}

#[test]
fn patch_leaves_at_most_a_thousandth() {
    for (name, frame) in creased() {
        // Repaired vertex shading keeps the slopes continuous.
        for vertex in [Correction::Off, Correction::Repaired] {
            let ratio = over_gouraud(&frame, &Shade { vertex, ..Shade::new(Shader::Patch) });
            assert!(ratio <= 1e-3, "{name}, {vertex}: {ratio}");
        }
    }
}
