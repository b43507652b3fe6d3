//! Tests of meshes, lighting and shaders on the CPU and on a graphics card, and handmade frames for them: triangles in
//! the plane of the screen.

#[path = "../common/mod.rs"]
mod common;
mod files;
mod illumination;
mod kit;
mod meshes;
mod scenes;
mod shaders;
mod truth;

use std::collections::HashMap;

use glam::{DMat3, DVec2, DVec3};
use machband::{
    light::{Depth, LinearImage},
    shading::{Fan, Frame, FrameTriangle, FrameVertex, Lighting, Scene, Shade, Shader, Side, View},
};

/// Makes a vertex at `screen` that faces the eye and has the light `light`.
fn vertex(screen: DVec2, light: DVec3) -> FrameVertex {
    FrameVertex {
        screen,
        depth: 0.5,
        eye: DVec3::new(screen.x / 100.0 - 1.0, 1.0 - screen.y / 100.0, 0.0),
        normal: DVec3::Z,
        light,
    }
}

/// Makes a frame of 200 × 200 pixels. Edges are identified by the indices of their vertices: two triangles at an edge
/// are smooth neighbors; at an edge of more than two, nothing is joined.
fn joined(vertices: Vec<FrameVertex>, triangles: &[[u32; 3]], lighting: Lighting) -> Frame {
    let ends = |t: usize, k: usize| (triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]);
    let mut sides: HashMap<[u32; 2], Vec<(usize, usize)>> = HashMap::new();
    for (t, k) in (0..triangles.len()).flat_map(|t| [(t, 0), (t, 1), (t, 2)]) {
        let (a, b) = ends(t, k);
        sides.entry([a.min(b), a.max(b)]).or_default().push((t, k));
    }
    let across = |t: usize, k: usize| {
        let (a, b) = ends(t, k);
        let others: Vec<_> = sides[&[a.min(b), a.max(b)]].iter().filter(|side| side.0 != t).collect();
        match others[..] {
            [&(u, l)] if ends(u, l) == (b, a) => Some(Side { triangle: u as u32, corner: l as u32 }),
            _ => None,
        }
    };
    let triangle = |t: usize| FrameTriangle {
        vertices: triangles[t],
        fans: triangles[t],
        sides: triangles[t].map(|fan| [fan; 2]),
        of_mesh: t as u32,
        is_back: false,
        across: [0, 1, 2].map(|k| across(t, k)),
    };
    Frame {
        background: DVec3::splat(0.25),
        triangles: (0..triangles.len()).map(triangle).collect(),
        creases: Vec::new(),
        sphere: (DVec3::ZERO, 1.0),
        smooth: None,
        paint: None,
        fans: (0..vertices.len() as u32).map(|vertex| Fan { vertex, curvature: DMat3::ZERO }).collect(),
        vertices,
        lighting,
        view: View::square(200),
    }
}

/// Lights a white surface from this direction.
fn lit_from(toward: DVec3) -> Lighting {
    Scene { light: toward, specular: 0.3, ..Scene::default() }.lighting()
}

fn standard() -> Lighting {
    lit_from(Scene::default().light)
}

/// Makes the frame of `triangles` over `places` (in pixels) with the given lights, which do not come from its lighting.
fn frame(places: &[DVec2], triangles: &[[u32; 3]], light: impl Fn(DVec2) -> DVec3) -> Frame {
    let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| facing(places, *t)).collect();
    let vertices = places.iter().map(|&screen| vertex(screen, light(screen))).collect();
    joined(vertices, &triangles, standard())
}

fn facing(places: &[DVec2], t: [u32; 3]) -> [u32; 3] {
    let [a, b, c] = t.map(|v| places[v as usize]);
    if Frame::area2(a, b, c) > 0.0 { t } else { [t[0], t[2], t[1]] }
}

/// Returns every shader with its defaults and with these depths (0 for ∞) and widths of its strips.
fn shades(strips: &[(u8, f64)]) -> Vec<Shade> {
    let depth = |n| if n == 0 { Depth::Infinite } else { Depth::Finite(n) };
    let with_options = |&shader: &Shader| {
        let plain = Shade::new(shader);
        let strips = strips.iter().filter(|_| plain.has_strip());
        let strips = strips.map(|&(n, boundary)| Shade { depth: depth(n), boundary, ..plain });
        [plain].into_iter().chain(strips).collect::<Vec<_>>()
    };
    Shader::ALL.iter().flat_map(with_options).collect()
}

/// Returns the largest difference between the light of two pictures.
fn apart(a: &LinearImage, b: &LinearImage) -> f32 {
    a.data.iter().zip(&b.data).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Returns the rows of one kind in `golden/shading.csv`, which says what their fields are, without the kind.
fn golden(kind: &str) -> Vec<Vec<&'static str>> {
    let rows = include_str!("../golden/shading.csv").lines().map(|line| line.split(',').collect::<Vec<_>>());
    rows.filter(|row| row[0] == kind).map(|row| row[1..].to_vec()).collect()
}

fn numbers(fields: &[&str]) -> Vec<f64> {
    fields.iter().map(|field| field.parse().expect("a number")).collect()
}

/// Returns a number within 0…1 that depends only on `seed`: a hash of multiples of the golden ratio.
fn random(seed: u64) -> f64 {
    let mut x = seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (x ^ (x >> 31)) as f64 / u64::MAX as f64
}

/// Makes a square of `size` pixels with `n` × `n` cells of two triangles each. Each cell is split along a random
/// diagonal, and the corners, except on the border, are moved by up to `jitter` of a cell.
fn grid(n: usize, size: f64, jitter: f64, seed: u64) -> (Vec<DVec2>, Vec<[u32; 3]>) {
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    let mut places = Vec::new();
    let mut triangles = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let shift = |axis: u64| (random(seed * 1_000_003 + u64::from(at(i, j)) * 2 + axis) * 2.0 - 1.0) * jitter;
            let inside = (1..n).contains(&i) && (1..n).contains(&j);
            let moved = if inside { DVec2::new(shift(0), shift(1)) } else { DVec2::ZERO };
            places.push((DVec2::new(i as f64, j as f64) + moved) * size / n as f64);
            if i < n && j < n {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
                let rising = random(seed * 7_000_003 + u64::from(a)) < 0.5;
                triangles.extend(if rising { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] });
            }
        }
    }
    (places, triangles)
}

/// True if a triangle contains a point, including points on its left and top edges. This is exact because positions are
/// multiples of 1/256 pixel.
fn covers(frame: &Frame, triangle: usize, p: DVec2) -> bool {
    let [a, b, c] = frame.corners(triangle).map(|v| v.screen);
    [(b, c), (c, a), (a, b)].into_iter().all(|(from, to)| {
        let owns = to.y > from.y || (to.y == from.y && to.x < from.x);
        let area = Frame::area2(p, from, to);
        area > 0.0 || (area == 0.0 && owns)
    })
}
