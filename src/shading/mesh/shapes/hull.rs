//! The convex hull of points on a sphere, which is their Delaunay triangulation there.

use delaunator::{Point, triangulate};
use glam::DVec3;

/// The triangles of the convex hull of `points`, at least 4 different ones on the unit sphere; counter-clockwise from
/// outside, two fewer than twice as many as there are points.
///
/// Projected from the last point onto a plane, circles on the sphere stay circles: the faces that do not touch that point
/// are the Delaunay triangulation of the others there, and the others' outline has the faces that do.
#[must_use]
pub fn hull(points: &[DVec3]) -> Vec<[u32; 3]> {
    let Some((pole, others)) = points.split_last() else { return Vec::new() };
    let (x, y) = pole.any_orthonormal_pair();
    let flat: Vec<Point> =
        others.iter().map(|p| *p / (1.0 - p.dot(*pole))).map(|p| Point { x: p.dot(x), y: p.dot(y) }).collect();
    let flat = triangulate(&flat);
    let outline = (0..flat.hull.len()).map(|i| [flat.hull[i], flat.hull[(i + 1) % flat.hull.len()], others.len()]);
    let faces = flat.triangles.as_chunks::<3>().0.iter().copied().chain(outline);
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let outward = |[a, b, c]: [usize; 3]| {
        let [p, q, r] = [a, b, c].map(|i| points[i]);
        if (q - p).cross(r - p).dot(p - middle) > 0.0 { [a, b, c] } else { [a, c, b] }
    };
    faces.map(|face| outward(face).map(|i| i as u32)).collect()
}
