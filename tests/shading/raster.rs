//! Which pixels show which triangle, for any number of threads.

use glam::{DVec2, DVec3};
use machband::shading::{Frame, Lighting, Material, Mesh, Shade, Shader, Surface, View, coverage, image, shapes};

use crate::{covers, random, standard};

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

fn frame(mesh: Mesh, [width, height]: [u32; 2], fill: f64, lighting: &Lighting, background: DVec3) -> Frame {
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
fn scenes() -> Vec<(&'static str, Frame)> {
    let yellow = colored(DVec3::new(1.0, 1.0, 0.0));
    let mut yellow_dull = yellow.clone();
    yellow_dull.material.specular = 0.0;
    let mut scenes = vec![
        ("cube", frame(shapes::cube(), [131, 97], 0.9, &brown(), DVec3::ZERO)),
        ("cube, gray", frame(shapes::cube(), [97, 131], 0.9, &standard(), DVec3::splat(0.5))),
        ("cube, huge", frame(shapes::cube(), [75, 130], 40.0, &brown(), SKY)),
        ("torus, yellow", frame(shapes::torus(20, 12, 0.0), [160, 160], 1.0, &yellow_dull, DVec3::ZERO)),
        ("sphere", frame(shapes::sphere(8), [64, 64], 1.3, &yellow, DVec3::ZERO)),
        ("blob", frame(shapes::blob(313), [200, 180], 0.9, &brown(), SKY)),
        ("blob, one pixel", frame(shapes::blob(20), [1, 1], 0.9, &brown(), SKY)),
        ("blob, tiny", frame(shapes::blob(771), [37, 3], 0.9, &brown(), SKY)),
    ];
    for seed in 0..4 {
        scenes.push(("ugly", frame(ugly(seed), [150, 101], 1.1, &brown(), SKY)));
        scenes.push(("ugly, huge", frame(ugly(seed + 10), [133, 70], 25.0, &brown(), SKY)));
    }
    scenes
}

#[test]
fn every_pixel_shows_the_nearest_triangle() {
    for (name, mut frame) in scenes() {
        // Separate all triangles, and use each triangle's number as its light.
        let corners = frame.triangles.iter().flat_map(|t| t.vertices).map(|v| frame.vertices[v as usize]);
        let numbered = corners.enumerate().map(|(i, mut vertex)| {
            vertex.light = DVec3::splat((i / 3) as f64);
            vertex
        });
        frame.vertices = numbered.collect();
        for (t, triangle) in (0..).zip(&mut frame.triangles) {
            triangle.vertices = [3 * t, 3 * t + 1, 3 * t + 2];
        }
        frame.background = DVec3::splat(-1.0);
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
        let expected: Vec<f32> = visible.iter().map(|t| if *t == coverage::NONE { -1.0 } else { *t as f32 }).collect();
        let image = image(&frame, &Shade::new(Shader::Gouraud));
        let seen: Vec<f32> = image.data.iter().step_by(3).copied().collect();
        assert!(seen == expected, "{name}");
        if name != "cube, huge" && !name.starts_with("ugly, huge") {
            assert!(seen.iter().any(|t| *t >= 0.0), "{name}: nothing is seen");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    for (name, frame) in scenes() {
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
