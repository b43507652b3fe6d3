//! Round surfaces.

use std::{collections::HashMap, f64::consts::TAU};

use glam::DVec3;

use crate::shading::mesh::Mesh;

/// The icosahedron.
pub(super) const LEAST_SPHERE: usize = 12;

/// Four rows of three.
pub(super) const LEAST_TORUS: usize = 12;

/// Radius of the torus's tube; its middle line has the radius 1.
const TUBE: f64 = 0.4;

/// Into how many parts each edge of the icosahedron is cut for about `vertices` vertices.
pub(super) fn subdivisions(vertices: usize) -> usize {
    ((vertices.saturating_sub(2) as f64 / 10.0).sqrt().round() as usize).max(1)
}

/// The unit sphere: an icosahedron whose edges are cut into `subdivisions` parts (at least 1), thrown onto the sphere:
/// 10·s² + 2 vertices and 20·s² triangles, all of nearly one size and shape.
#[must_use]
pub fn sphere(subdivisions: usize) -> Mesh {
    let s = subdivisions.max(1);
    let (corners, faces) = icosahedron();
    let mut positions: Vec<DVec3> = Vec::with_capacity(10 * s * s + 2);
    // A place on a face by the whole weights of the face's corners, those without weight left out: faces that share it
    // name it alike.
    let mut index: HashMap<[(usize, usize); 3], u32> = HashMap::with_capacity(10 * s * s + 2);
    let mut triangles = Vec::with_capacity(20 * s * s);
    for face in faces {
        let mut site = |i: usize, j: usize| {
            let mut key =
                [(face[0], s - i - j), (face[1], i), (face[2], j)].map(|(c, w)| if w == 0 { (0, 0) } else { (c, w) });
            key.sort_unstable();
            *index.entry(key).or_insert_with(|| {
                let sum: DVec3 = key.iter().map(|(corner, weight)| corners[*corner] * *weight as f64).sum();
                positions.push(sum.normalize());
                (positions.len() - 1) as u32
            })
        };
        for i in 0..s {
            for j in 0..s - i {
                let (a, b, c) = (site(i, j), site(i + 1, j), site(i, j + 1));
                triangles.push([a, b, c]);
                if i + j + 2 <= s {
                    triangles.push([b, site(i + 1, j + 1), c]);
                }
            }
        }
    }
    closed(&positions, &triangles).with_normals(|place| place)
}

/// Corners of length 1, and faces counter-clockwise from outside.
fn icosahedron() -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let golden = f64::midpoint(1.0, 5f64.sqrt());
    let corners: Vec<DVec3> = (0..12)
        .map(|i| {
            let (a, b) = (if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { golden } else { -golden });
            [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)][i / 4].normalize()
        })
        .collect();
    let near = |i: usize, j: usize| corners[i].dot(corners[j]) > 0.4;
    let mut faces = Vec::with_capacity(20);
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outward = (corners[j] - corners[i]).cross(corners[k] - corners[i]).dot(corners[i]) > 0.0;
                    faces.push(if outward { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    (corners, faces)
}

/// The torus around the z axis, radius 1, its tube of radius 0.4: `around` places (at least 3) along each of `tube`
/// rows (even, at least 4), every other row half a place ahead, which makes the triangles nearly equal-sided where the
/// tube looks up and down.
#[must_use]
pub fn torus(around: usize, tube: usize) -> Mesh {
    let (around, tube) = (around.max(3), tube.max(4).next_multiple_of(2));
    let mut positions = Vec::with_capacity(around * tube);
    for row in 0..tube {
        let (sin, cos) = (TAU * row as f64 / tube as f64).sin_cos();
        for column in 0..around {
            let turn = (column as f64 + if row % 2 == 0 { 0.0 } else { 0.5 }) / around as f64;
            let (y, x) = (TAU * turn).sin_cos();
            let out = 1.0 + TUBE * cos;
            positions.push(DVec3::new(out * x, out * y, TUBE * sin));
        }
    }
    let mut triangles = Vec::with_capacity(around * tube * 2);
    for row in 0..tube {
        for column in 0..around {
            let site = |up: usize, on: usize| ((row + up) % tube * around + (column + on) % around) as u32;
            if row % 2 == 0 {
                triangles.extend([[site(0, 0), site(0, 1), site(1, 0)], [site(0, 1), site(1, 1), site(1, 0)]]);
            } else {
                triangles.extend([[site(0, 0), site(1, 1), site(1, 0)], [site(0, 0), site(0, 1), site(1, 1)]]);
            }
        }
    }
    closed(&positions, &triangles).with_normals(|place| place - DVec3::new(place.x, place.y, 0.0).normalize_or_zero())
}

/// The torus with about `vertices` places.
pub(super) fn torus_of(vertices: usize) -> Mesh {
    // Equal sides a along the middle line, and rows a·√3/2 apart: around/tube = (1/0.4)·(√3/2).
    let tube = (vertices as f64 * TUBE * 2.0 / 3f64.sqrt()).sqrt() / 2.0;
    let tube = (tube.round() as usize).max(2) * 2;
    torus((vertices as f64 / tube as f64).round() as usize, tube)
}

fn closed(positions: &[DVec3], triangles: &[[u32; 3]]) -> Mesh {
    Mesh::new(positions, triangles, 180.0).expect("a round surface is a mesh")
}
