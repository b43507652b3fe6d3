//! A closed surface with any number of vertices.

use std::f64::consts::TAU;

use glam::DVec3;

use super::hull::hull;
use crate::shading::mesh::Mesh;

/// A tetrahedron.
pub(super) const LEAST: usize = 4;

/// `count` points spread evenly over the unit sphere: the i-th is at z = 1 − (2i + 1)/`count`, turned on by the golden
/// angle from the last.
#[must_use]
pub fn fibonacci_points(count: usize) -> Vec<DVec3> {
    let golden = f64::midpoint(1.0, 5f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let (y, x) = (TAU * (i as f64 / golden).fract()).sin_cos();
            let radius = ((1.0 - z) * (1.0 + z)).sqrt();
            DVec3::new(radius * x, radius * y, z)
        })
        .collect()
}

/// A closed surface over `count` Fibonacci points, at least 4: the triangles of their convex hull, 2·`count` − 4, each
/// place then moved in or out by a smooth function of its direction, so that the surface is round but no ball: it has
/// hollows, and no symmetry.
#[must_use]
pub fn blob(count: usize) -> Mesh {
    let points = fibonacci_points(count);
    let positions: Vec<DVec3> = points.iter().map(|p| *p * radius(*p)).collect();
    Mesh::new(&positions, &hull(&points), 180.0).expect("a blob is a mesh").with_normals(normal)
}

/// The surface is at the distance r(u) in the direction u; its normal is along u − ∇r/r, of the slope the part across u.
fn normal(place: DVec3) -> DVec3 {
    let out = place.normalize();
    let slope = radius_slope(out);
    out - (slope - out * slope.dot(out)) / radius(out)
}

/// Distance from the middle in the direction `p`: 0.66…1.34.
fn radius(p: DVec3) -> f64 {
    1.0 + 0.16 * (2.1 * p.x + 0.4).sin() * (2.6 * p.y - 0.3).cos()
        + 0.12 * (3.1 * p.z + 1.3 * p.x).sin()
        + 0.06 * (4.3 * p.y + 2.0 * p.z + 1.0).sin()
}

/// How [`radius`] changes along x, y and z.
fn radius_slope(p: DVec3) -> DVec3 {
    let (sin, cos) = (2.1 * p.x + 0.4).sin_cos();
    let (down, up) = (2.6 * p.y - 0.3).sin_cos();
    let wave = 0.12 * (3.1 * p.z + 1.3 * p.x).cos();
    let ripple = 0.06 * (4.3 * p.y + 2.0 * p.z + 1.0).cos();
    DVec3::new(0.16 * 2.1 * cos * up + 1.3 * wave, -0.16 * 2.6 * sin * down + 4.3 * ripple, 3.1 * wave + 2.0 * ripple)
}
