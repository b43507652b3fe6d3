//! A mesh with the data that are computed once per mesh: its edges, and its curvature after Rusinkiewicz, *Estimating
//! curvatures and their derivatives on triangle meshes*, 3DPVT 2004.

use glam::{DMat3, DQuat, DVec3};

use super::{
    normals,
    triangles::{Edges, Mesh, Vertex},
};

/// A mesh with its edges and its curvature, which depend on neither the view nor the light.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The triangles.
    pub mesh: Mesh,
    /// The edges at which the triangles meet.
    pub edges: Edges,
    /// For each vertex, dN/dp, the change of the unit normal along the surface: symmetric, zero along the normal, in
    /// the mesh's own axes and units.
    pub curvature: Vec<DMat3>,
}

impl Surface {
    /// Computes the edges and the curvature of `mesh`.
    #[must_use]
    pub fn new(mesh: Mesh) -> Surface {
        let edges = Edges::of(&mesh);
        let curvature = curvature(&mesh);
        Surface { mesh, edges, curvature }
    }
}

/// Returns dN/dp at every vertex: the change of the unit normal along the surface per unit of the mesh's own length. It
/// is symmetric, and zero along the vertex's normal. A sphere of radius r with outward normals has (I − NNᵀ)/r.
///
/// Each face gets the tensor that best fits the differences between its vertices' normals along its three edges. A
/// vertex gets the mean of the tensors of its faces, rotated into its tangent plane and weighted by the part of each
/// face that is nearest to it. Vertices on either side of a crease use only their own faces. Faces without area do not
/// count; a vertex without faces gets zero.
fn curvature(mesh: &Mesh) -> Vec<DMat3> {
    let mut sums = vec![(DMat3::ZERO, 0.0); mesh.vertices.len()];
    for corners in &mesh.triangles {
        let vertices = corners.map(|v| &mesh.vertices[v as usize]);
        let Some((normal, tensor)) = of_face(vertices) else { continue };
        let weights = nearest_areas(vertices.map(|v| v.position));
        for ((corner, vertex), weight) in corners.iter().zip(vertices).zip(weights) {
            let (sum, total) = &mut sums[*corner as usize];
            *sum += turned(tensor, normal, vertex.normal) * weight;
            *total += weight;
        }
    }
    mesh.vertices.iter().zip(sums).map(|(vertex, (sum, total))| tangent(sum, total, vertex.normal)).collect()
}

/// Returns the weighted mean, without the rounding errors along the normal.
fn tangent(sum: DMat3, total: f64, normal: DVec3) -> DMat3 {
    let flat = DMat3::IDENTITY - outer(normal, normal);
    let mean = flat * (sum * (1.0 / total)) * flat;
    let symmetric = (mean + mean.transpose()) * 0.5;
    if symmetric.is_finite() { symmetric } else { DMat3::ZERO }
}

/// Returns the normal of a face and its dN/dp; `None` if the face has no area.
fn of_face(vertices: [&Vertex; 3]) -> Option<(DVec3, DMat3)> {
    let positions = vertices.map(|v| v.position);
    let normal = normals::newell(&positions);
    if normal == DVec3::ZERO {
        return None;
    }
    let [a, b, c] = positions;
    // The edges are in units of the longest edge, so that nothing overflows.
    let edges = [c - b, a - c, b - a];
    let longest = edges.iter().map(|e| e.length()).fold(0.0, f64::max);
    let u = edges[0].normalize();
    let v = normal.cross(u);
    // Least squares for the tensor ((e, f), (f, g)) in (u, v) that maps every edge to the difference of normals along
    // it. The normal equations have the matrix ((uu, uv, 0), (uv, uu + vv, uv), (0, uv, vv)).
    let [mut uu, mut uv, mut vv] = [0.0; 3];
    let [mut right_e, mut right_f, mut right_g] = [0.0; 3];
    for (k, edge) in edges.iter().enumerate() {
        let (x, y) = (edge.dot(u) / longest, edge.dot(v) / longest);
        let change = vertices[(k + 2) % 3].normal - vertices[(k + 1) % 3].normal;
        let (dx, dy) = (change.dot(u), change.dot(v));
        (uu, uv, vv) = (uu + x * x, uv + x * y, vv + y * y);
        (right_e, right_f, right_g) = (right_e + x * dx, right_f + x * dy + y * dx, right_g + y * dy);
    }
    let f = (right_f - right_e * uv / uu - right_g * uv / vv) / (uu + vv - uv * uv / uu - uv * uv / vv);
    let (e, g) = ((right_e - f * uv) / uu, (right_g - f * uv) / vv);
    let cross = outer(u, v);
    let tensor = (outer(u, u) * e + (cross + cross.transpose()) * f + outer(v, v) * g) * (1.0 / longest);
    tensor.is_finite().then_some((normal, tensor))
}

/// Rotates a face's tensor into the tangent plane of a vertex by the smallest possible rotation. A normal that points
/// to the other side of the face has the same tangent plane.
fn turned(tensor: DMat3, face: DVec3, vertex: DVec3) -> DMat3 {
    let face = if face.dot(vertex) < 0.0 { -face } else { face };
    let turn = DMat3::from_quat(DQuat::from_rotation_arc(face, vertex));
    turn * tensor * turn.transpose()
}

/// Returns how much of a triangle's area is nearest to each corner. If an angle is obtuse, half of the area belongs to
/// that corner and a quarter to each of the others (Meyer et al. 2003).
fn nearest_areas([a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let squared = [(c - b).length_squared(), (a - c).length_squared(), (b - a).length_squared()];
    let area = (b - a).cross(c - a).length() / 2.0;
    // Twice the cosine at corner k, multiplied by the lengths of its two sides.
    let cosine = [0, 1, 2].map(|k| squared[(k + 1) % 3] + squared[(k + 2) % 3] - squared[k]);
    if let Some(k) = cosine.iter().position(|c| *c < 0.0) {
        let mut parts = [area / 4.0; 3];
        parts[k] = area / 2.0;
        return parts;
    }
    // (|e_i|² cot i + |e_j|² cot j) / 8, with cot = cosine/(4 area).
    [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        (squared[i] * cosine[i] + squared[j] * cosine[j]) / (32.0 * area)
    })
}

/// abᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
