//! Which pixels show which triangle. Scenes of several meshes: which surface is in front, transparency, refraction, lamps,
//! and the files that describe them.

use std::fs;

use glam::{DMat3, DVec2, DVec3};
use machband::{
    light::{Depth, LinearImage},
    shading::{
        Body, Coat, Composition, Frame, Lighting, Material, Mesh, Paint, PaintedCorner, Shade, Shader, Surface,
        Transmits, Transparency, View, coverage, image, shapes,
    },
    store::{mesh, scene},
};

use super::{apart, covers, lit_from, random, standard};

const SIDE: u32 = 96;

fn body(mesh: Mesh, color: DVec3) -> Body {
    Body {
        surface: Surface::new(mesh),
        shade: Shade::new(Shader::C1Phong),
        material: Material { color, ..standard().material },
        transparency: transparency(Transmits::Opaque, 0.0, DVec3::ONE),
        index: None,
    }
}

fn transparency(kind: Transmits, k_t: f64, color: DVec3) -> Transparency {
    Transparency { kind, k_t, color }
}

fn scene(bodies: Vec<Body>) -> Composition {
    Composition {
        bodies,
        ambient: DVec3::ONE,
        lamps: lit_from(DVec3::new(0.3, 0.4, 0.9)).lamps,
        background: DVec3::new(0.1, 0.2, 0.3),
        view: View::square(1),
    }
}

fn moved(mesh: Mesh, position: DVec3) -> Mesh {
    mesh.placed(1.0, DMat3::IDENTITY, position)
}

/// A square of this half side, facing the eye at the height z.
fn sheet(half: f64, z: f64) -> Mesh {
    let positions = [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]].map(DVec3::from_array);
    Mesh::new(&positions, &[[0, 1, 2], [0, 2, 3]], 180.0).unwrap()
}

#[test]
fn a_scene_of_one_mesh_is_its_picture() {
    for distance in [f64::INFINITY, 2.5] {
        let torus = shapes::torus(24, 12, 0.0);
        let view = View { distance, ..View::square(SIDE) }.rotated([25.0, -35.0, 10.0]);
        let alone = Composition { view, ..scene(vec![body(torus.clone(), DVec3::ONE)]) };
        // The lamp is fixed to the scene and turns with it.
        let toward = view.rotation * DVec3::new(0.3, 0.4, 0.9);
        let lighting = lit_from(toward);
        let frame = Frame::new(&Surface::new(torus), &view, &lighting, alone.background);
        let worst = apart(&alone.image(SIDE, SIDE), &image(&frame, &Shade::new(Shader::C1Phong)));
        assert!(worst < 1e-6, "{distance}: {worst}");
    }
}

#[test]
fn transparent_surfaces_combine_as_the_formulas_say() {
    let (tint, ball) = (DVec3::new(0.9, 0.5, 0.2), moved(shapes::sphere(3), DVec3::new(0.3, 0.0, -1.5)));
    let behind = body(ball, DVec3::new(0.2, 0.9, 0.6));
    let mut pane = body(sheet(1.2, 0.5), DVec3::new(0.6, 0.6, 0.1));
    let draw = |bodies: Vec<Body>| scene(bodies).image(SIDE, SIDE);
    let front = draw(vec![pane.clone(), behind.clone()]);
    // The same places without the pane: an invisible one keeps the view.
    pane.transparency = transparency(Transmits::Interpolated, 1.0, tint);
    let bare = draw(vec![pane.clone(), behind.clone()]);
    for (kind, k_t) in [(Transmits::Interpolated, 0.3), (Transmits::Filtered, 0.7)] {
        pane.transparency = transparency(kind, k_t, tint);
        let seen = draw(vec![behind.clone(), pane.clone()]);
        for i in 0..(SIDE * SIDE) as usize {
            let of =
                |image: &LinearImage| DVec3::from_array(image.pixel(i as u32 % SIDE, i as u32 / SIDE).map(f64::from));
            let (own, beyond, both) = (of(&front), of(&bare), of(&seen));
            let is_pane = own.distance(beyond) > 1e-6;
            let expected = match kind {
                _ if !is_pane => beyond,
                Transmits::Interpolated => (1.0 - k_t) * own + k_t * beyond,
                _ => own + k_t * tint * beyond,
            };
            assert!(both.distance(expected) < 1e-5, "{kind}: {both}, not {expected}");
        }
    }
    assert_eq!(transparency(Transmits::Opaque, 0.5, tint).through(tint, DVec3::ONE), tint);
}

fn bare() -> Material {
    Material { ambient: 1.0, diffuse: 0.0, specular: 0.0, ..standard().material }
}

/// A sheet whose red grows from 0 to 1 to the right, over −1.5…1.5.
fn behind_glass() -> Body {
    let back = sheet(1.5, -1.0);
    let color = |v: &u32| {
        let red = (back.vertices[*v as usize].position.x + 1.5) / 3.0;
        PaintedCorner { color: DVec3::new(red, 0.0, 0.0), ..PaintedCorner::default() }
    };
    let corners = back.triangles.iter().map(|t| [0, 1, 2].map(|k| color(&t[k]))).collect();
    let paint = Paint { corners, of_triangles: vec![0; 2], coats: vec![Coat::default()] };
    Body { material: bare(), ..body(back.clone().painted(paint), DVec3::ONE) }
}

/// Clear glass, which has no light of its own.
fn glass(mesh: Mesh, index: f64) -> Body {
    Body {
        material: Material { ambient: 0.0, ..bare() },
        transparency: transparency(Transmits::Filtered, 1.0, DVec3::ONE),
        index: Some(index),
        ..body(mesh, DVec3::ONE)
    }
}

/// Through a tilted slab of glass, a plane behind it is seen displaced by d = t·sin θ·(1 − cos θ/√(n² − sin² θ)).
#[test]
fn a_slab_of_glass_displaces_what_is_behind_it() {
    let (thickness, index, theta) = (0.4_f64, 1.5_f64, 35.0_f64.to_radians());
    let (w, h) = (1.0, thickness / 2.0);
    let obj: String =
        [[-w, -w, -h], [w, -w, -h], [w, w, -h], [-w, w, -h], [-w, -w, h], [w, -w, h], [w, w, h], [-w, w, h]]
            .iter()
            .map(|[x, y, z]| format!("v {x} {y} {z}\n"))
            .chain(["f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n".to_owned()])
            .collect();
    let slab = mesh::parse("slab", obj.as_bytes(), 30.0).unwrap().mesh;
    let slab = slab.placed(1.0, DMat3::from_rotation_y(theta), DVec3::new(0.0, 0.0, 1.0));
    let (back, glass) = (behind_glass(), glass(slab, index));
    let displacement = thickness * theta.sin() * (1.0 - theta.cos() / (index * index - theta.sin().powi(2)).sqrt());
    let with = scene(vec![back.clone(), glass.clone()]).image(SIDE, SIDE);
    let without = scene(vec![back, Body { index: None, ..glass }]).image(SIDE, SIDE);
    let (y, mut seen) = (SIDE / 2, 0);
    // The middle of the slab: rays that enter and leave through its two large faces.
    for x in SIDE / 2 - 6..SIDE / 2 + 6 {
        let moved = 3.0 * f64::from(with.pixel(x, y)[0] - without.pixel(x, y)[0]);
        assert!((moved.abs() - displacement).abs() < 1e-4, "at {x}: {moved}, not {displacement}");
        seen += 1;
    }
    assert_eq!(seen, 12);
}

const SCENE: &str = r#"
schema = 1
background = [0.02, 0.02, 0.04]
ambient = [1.0, 1.0, 1.0]

[view]
rotate = [-20.0, 15.0, 0.0]
distance = 4.0

[[mesh]]
mesh = "torus"
vertices = 300
shader = "patch"
color = [0.9, 0.3, 0.2]

[[mesh]]
mesh = "box.obj"
crease = 30.0
shader = "fixed"
depth = 2
position = [1.5, 0.0, 0.0]
rotate = [0.0, 30.0, 0.0]
scale = 0.5
transparency = "interpolated"
transmission = 0.4

[[mesh]]
mesh = "sphere"
position = [-1.5, 0.0, 0.5]
transparency = "filtered"
filter = [0.8, 0.9, 1.0]
index = 1.5
diffuse = 0.1
ambient = 0.05
highlight = "blinn"

[[lamp]]
direction = [0.3, 0.5, 0.8]
intensity = [0.8, 0.8, 0.7]

[[lamp]]
position = [0.0, 2.0, 1.0]
attenuation = [1.0, 0.2, 0.1]
"#;

#[test]
fn scenes_are_read_and_their_errors_have_places() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\n\
                f 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    fs::write(folder.path().join("box.obj"), cube).unwrap();
    fs::write(&path, SCENE).unwrap();
    let read = scene::read(&path).unwrap();
    assert_eq!((read.composition.bodies.len(), read.composition.lamps.len(), read.text.as_str()), (3, 2, SCENE));
    let bodies = &read.composition.bodies;
    assert_eq!((bodies[2].index, bodies[0].shade.depth), (Some(1.5), Depth::Finite(1)));
    let image = read.composition.image(SIDE, SIDE);
    let lit = image.data.iter().filter(|light| **light > 0.1).count();
    assert!(image.data.iter().all(|light| light.is_finite()) && lit > 3000, "{lit}");

    for (from, to, line, words) in [
        (
            "transmission = 0.4",
            "transmission = 1.4",
            25,
            "transmission 1.4 is outside 0…1; expected a number in this range",
        ),
        ("direction = [0.3, 0.5, 0.8]", "direction = [0, 0, 0]", 38, "expected a vector toward the lamp"),
        ("position = [0.0, 2.0, 1.0]", "", 41, "expected either direction = [x, y, z] or position"),
        ("mesh = \"torus\"", "mesh = \"torous\"", 11, "torous"),
        ("position = [1.5, 0.0, 0.0]", "position = [1e300, 0, 0]", 21, "position 1e300 is outside -1000000…1000000"),
    ] {
        fs::write(&path, SCENE.replace(from, to)).unwrap();
        let errors = scene::read(&path).expect_err("a fault").to_string();
        let place = format!("scene.toml:{line}:");
        assert!(errors.contains(&place) && errors.contains(words) && errors.contains("expected"), "{to}: {errors}");
    }
    fs::write(&path, SCENE.replace("box.obj", "none.obj")).unwrap();
    assert!(scene::read(&path).expect_err("a fault").to_string().contains("none.obj: cannot be opened"));
    fs::write(&path, "schema = 1\n").unwrap();
    assert!(scene::read(&path).expect_err("a fault").to_string().contains("expected at least one table [[mesh]]"));
}

/// Where media touch, light passes as if there were no boundary: two halves are one block, and a medium inside one of the
/// inverse index is none, because an index is relative to what surrounds it.
#[test]
fn media_that_touch_have_no_gap_between_them() {
    let block = |left: f64, right: f64| {
        let corner = |i: usize| {
            let side = |axis: usize, low: f64, high: f64| if i >> axis & 1 == 0 { low } else { high };
            DVec3::new(side(0, left, right), side(1, -0.6, 0.6), side(2, 0.0, 0.8))
        };
        let faces: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect::<Vec<_>>();
        Mesh::new(&std::array::from_fn::<_, 8, _>(corner), &triangles, 30.0).unwrap()
    };
    let draw = |blocks: &[(f64, f64, f64)]| {
        let blocks = blocks.iter().map(|(left, right, index)| glass(block(*left, *right), *index));
        let bodies = [behind_glass()].into_iter().chain(blocks).collect();
        Composition { view: View::square(1).rotated([12.0, 38.0, 0.0]), ..scene(bodies) }.image(2 * SIDE, 2 * SIDE)
    };
    let differ =
        |a: &LinearImage, b: &LinearImage| a.data.iter().zip(&b.data).filter(|(a, b)| (**a - **b).abs() > 1e-3).count();
    let (one, none) = (draw(&[(-0.7, 0.7, 1.5)]), draw(&[(-0.7, 0.7, 1.0)]));
    assert!(differ(&one, &none) > 2000, "{}", differ(&one, &none));
    for (blocks, expected) in [
        ([(-0.7, 0.1, 1.5), (0.1, 0.7, 1.5)], &one),
        ([(-0.7, 0.7, 1.5), (-0.7, 0.7, 2.0 / 3.0)], &none),
        ([(-0.7, 0.7, 1.25), (-0.7, 0.7, 1.2)], &one),
    ] {
        // At an edge, a line of sight may meet one side or the other.
        let apart = differ(&draw(&blocks), expected);
        assert!(apart < 60, "{blocks:?}: {apart}");
    }
}

/// Makes triangles that pass through each other, some of them thin.
fn ugly(seed: u32) -> Mesh {
    let place = |i: u32| DVec3::from_array([0, 1, 2].map(|c| 2.0 * random(u64::from(seed * 1000 + 3 * i + c)) - 1.0));
    let mut places: Vec<DVec3> = (0..90).map(place).collect();
    // These points lie next to others and make slivers.
    places.extend((0..30).map(|i| place(i) + 0.01 * place(i + 200)));
    let mut triangles: Vec<[u32; 3]> = (0..30).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    triangles.extend((0..20).map(|t| [t, t + 1, t + 30]));
    triangles.extend((0..20).map(|t| [t, t + 90, t + 40]));
    Mesh::new(&places, &triangles, 180.0).unwrap()
}

const SKY: DVec3 = DVec3::new(0.1, 0.2, 0.4);

fn framed(mesh: Mesh, [width, height]: [u32; 2], fill: f64, lighting: &Lighting, background: DVec3) -> Frame {
    let view = View { width, height, fill, ..View::square(1).rotated([25.0, 35.0, 10.0]) };
    Frame::new(&Surface::new(mesh), &view, lighting, background)
}

fn colored(color: DVec3) -> Lighting {
    Lighting { material: Material { color, ..standard().material }, ..standard() }
}

fn brown() -> Lighting {
    colored(DVec3::new(0.9, 0.6, 0.3))
}

/// Meshes of every kind, fully, partly or barely within windows of awkward sizes, in gray, yellow and other colors.
fn single_meshes() -> Vec<(&'static str, Frame)> {
    let yellow = colored(DVec3::new(1.0, 1.0, 0.0));
    let mut yellow_dull = yellow.clone();
    yellow_dull.material.specular = 0.0;
    let mut frames = vec![
        ("cube", framed(shapes::cube(), [131, 97], 0.9, &brown(), DVec3::ZERO)),
        ("cube, gray", framed(shapes::cube(), [97, 131], 0.9, &standard(), DVec3::splat(0.5))),
        ("cube, huge", framed(shapes::cube(), [75, 130], 40.0, &brown(), SKY)),
        ("torus, yellow", framed(shapes::torus(20, 12, 0.0), [160, 160], 1.0, &yellow_dull, DVec3::ZERO)),
        ("sphere", framed(shapes::sphere(8), [64, 64], 1.3, &yellow, DVec3::ZERO)),
        ("blob", framed(shapes::blob(313), [200, 180], 0.9, &brown(), SKY)),
        ("blob, one pixel", framed(shapes::blob(20), [1, 1], 0.9, &brown(), SKY)),
        ("blob, tiny", framed(shapes::blob(771), [37, 3], 0.9, &brown(), SKY)),
    ];
    for seed in 0..4 {
        frames.push(("ugly", framed(ugly(seed), [150, 101], 1.1, &brown(), SKY)));
        frames.push(("ugly, huge", framed(ugly(seed + 10), [133, 70], 25.0, &brown(), SKY)));
    }
    frames
}

#[test]
fn every_pixel_shows_the_nearest_triangle() {
    for (name, frame) in single_meshes() {
        let seen_at = |x: u32, y: u32| {
            let p = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            let mut seen = (f64::INFINITY, coverage::NONE);
            for t in (0..frame.triangles.len()).filter(|t| covers(&frame, *t, p)) {
                let depths = frame.corners(t).map(|v| v.depth);
                let depth = frame.weights(t, p).iter().zip(depths).map(|(w, depth)| w * depth).sum();
                seen = if depth < seen.0 { (depth, t as u32) } else { seen };
            }
            seen.1
        };
        let visible: Vec<u32> = (0..frame.view.height)
            .flat_map(|y| (0..frame.view.width).map(move |x| (x, y)))
            .map(|(x, y)| seen_at(x, y))
            .collect();
        assert!(coverage::visible(&frame) == visible, "{name}");
        if name != "cube, huge" && !name.starts_with("ugly, huge") {
            assert!(visible.iter().any(|t| *t != coverage::NONE), "{name}: nothing is seen");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    for (name, frame) in single_meshes() {
        for shader in [Shader::Gouraud, Shader::Fixed, Shader::Patch, Shader::Phong] {
            let shade = Shade::new(shader);
            let bits = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| image(&frame, &shade)).data.into_iter().map(f32::to_bits).collect::<Vec<_>>()
            };
            assert!(bits(1) == bits(3), "{name}, {shader}");
        }
    }
}
