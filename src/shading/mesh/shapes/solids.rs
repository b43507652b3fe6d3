//! Solids with flat faces.

use glam::DVec3;

use crate::shading::mesh::{Mesh, Polygons};

/// The cube of side 2 around the origin, 12 triangles, its normals averaged at the corners as the paper's figures have
/// them.
#[must_use]
pub fn cube() -> Mesh {
    let positions: Vec<DVec3> = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from((i >> 1) & 1), f64::from((i >> 2) & 1)) * 2.0 - DVec3::ONE)
        .collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    solid(&positions, &Polygons::new(faces.iter().map(|face| &face[..])))
}

/// Shoaff's truncated pyramid (§4.1), closed by a base: V1…V8 are sites 0…7, 12 triangles.
///
/// Its normals are Shoaff's: the normalized sum of the three *plane equations* around a vertex, (−1, −1, 3)/√11 at V1.
/// They are not of unit length there: z − 1 = 0, −y + z − 2 = 0, −x + z − 2 = 0. The average of unit normals, as
/// elsewhere, would be along (−1, −1, 1 + √2 + 1).
#[must_use]
pub fn pyramid() -> Mesh {
    let square = |half: f64, z: f64| {
        [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| DVec3::new(x, y, z))
    };
    let positions = [square(1.0, 1.0), square(2.0, 0.0)].concat();
    let mut polygons = Polygons::default();
    for face in [[0, 1, 2, 3], [4, 5, 1, 0], [5, 6, 2, 1], [6, 7, 3, 2], [7, 4, 0, 3], [7, 6, 5, 4]] {
        polygons.push(face.map(|site: u32| {
            let p = positions[site as usize];
            let outward = DVec3::new(p.x.signum(), p.y.signum(), if p.z > 0.0 { 3.0 } else { 1.0 });
            (site, Some(outward.normalize()))
        }));
    }
    solid(&positions, &polygons)
}

fn solid(positions: &[DVec3], polygons: &Polygons) -> Mesh {
    Mesh::from_polygons(positions, polygons, 180.0).expect("a solid is a mesh")
}
