//! A mesh with the data that are computed once per mesh: its edges, and its curvature after Rusinkiewicz, *Estimating
//! curvatures and their derivatives on triangle meshes*, 3DPVT 2004.

use std::collections::HashMap;

use glam::{DMat3, DQuat, DVec3};

use super::{
    normals,
    triangles::{Edge, EdgeKind, Edges, Mesh, Vertex},
};

/// A mesh with its edges and its curvature, which depend on neither the view nor the light.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The triangles.
    pub mesh: Mesh,
    /// The edges at which the triangles meet.
    pub edges: Edges,
    /// The curvature at the vertices. The first fans are those of the vertices, in the same order; others follow for
    /// vertices at which the curvature jumps.
    pub fans: Vec<Fan>,
    /// The fan of each corner of each triangle.
    pub of_corners: Vec<[u32; 3]>,
}

/// Triangles around a vertex over which the curvature does not jump; usually all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fan {
    /// The index of the vertex.
    pub vertex: u32,
    /// dN/dp, the change of the unit normal along the surface: symmetric, zero along the normal, in the mesh's own axes
    /// and units.
    pub curvature: DMat3,
}

impl Surface {
    /// Computes the edges and the curvature of `mesh`.
    ///
    /// dN/dp is the change of the unit normal along the surface per unit of the mesh's own length. It is symmetric, and
    /// zero along the vertex's normal. A sphere of radius r with outward normals has (I − NNᵀ)/r.
    ///
    /// Each face gets the tensor that best fits the differences between its vertices' normals along its three edges. A
    /// fan gets the mean of the tensors of its faces, rotated into the vertex's tangent plane and weighted by the part
    /// of each face that is nearest to it. Vertices on either side of a crease use only their own faces. Faces without
    /// area do not count; a vertex without faces gets zero.
    #[must_use]
    pub fn new(mesh: Mesh) -> Surface {
        let edges = Edges::of(&mesh);
        let faces: Vec<Option<Face>> =
            mesh.triangles.iter().map(|t| Face::of(t.map(|v| &mesh.vertices[v as usize]))).collect();
        let (mut fans, of_corners) = fans(&mesh, &edges, &faces);
        let mut sums = vec![(DMat3::ZERO, 0.0); fans.len()];
        for ((corners, face), of_corners) in mesh.triangles.iter().zip(&faces).zip(&of_corners) {
            let Some(face) = face else { continue };
            let vertices = corners.map(|v| &mesh.vertices[v as usize]);
            let weights = nearest_areas(vertices.map(|v| v.position));
            for ((fan, vertex), weight) in of_corners.iter().zip(vertices).zip(weights) {
                let (sum, total) = &mut sums[*fan as usize];
                *sum += turned(face.tensor, face.normal, vertex.normal) * weight;
                *total += weight;
            }
        }
        for (fan, (sum, total)) in fans.iter_mut().zip(sums) {
            fan.curvature = tangent(sum, total, mesh.vertices[fan.vertex as usize].normal);
        }
        Surface { mesh, edges, fans, of_corners }
    }
}

/// Finds the fans of all vertices, without their curvature.
fn fans(mesh: &Mesh, edges: &Edges, faces: &[Option<Face>]) -> (Vec<Fan>, Vec<[u32; 3]>) {
    let fan = |vertex: u32| Fan { vertex, curvature: DMat3::ZERO };
    let mut fans: Vec<Fan> = (0..mesh.vertices.len() as u32).map(fan).collect();
    let mut of_corners = mesh.triangles.clone();
    let has_jump: Vec<bool> = edges.edges.iter().map(|edge| is_jump(mesh, edges, faces, edge)).collect();
    if !has_jump.contains(&true) {
        return (fans, of_corners);
    }
    let mut parent: Vec<u32> = (0..mesh.triangles.len() as u32 * 3).collect();
    for (edge, _) in edges.edges.iter().zip(&has_jump).filter(|(edge, jump)| edge.kind == EdgeKind::Smooth && !**jump) {
        // The two triangles go along the edge in opposite directions.
        let [(t, k), (u, l)] = [edge.sides[0], edge.sides[1]];
        normals::join(&mut parent, 3 * t + u32::from(k + 1) % 3, 3 * u + u32::from(l + 2) % 3);
        normals::join(&mut parent, 3 * t + u32::from(k + 2) % 3, 3 * u + u32::from(l + 1) % 3);
    }
    // Only vertices at the ends of a jump are divided: other vertices keep one fan even where their faces do not join.
    let mut at_jump = vec![false; mesh.vertices.len()];
    for (edge, _) in edges.edges.iter().zip(&has_jump).filter(|(_, jump)| **jump) {
        let (t, k) = edge.sides[0];
        for end in [1, 2] {
            at_jump[mesh.triangles[t as usize][usize::from(k + end) % 3] as usize] = true;
        }
    }
    let mut of_root: HashMap<u32, u32> = HashMap::new();
    let mut has_first = vec![false; mesh.vertices.len()];
    for corner in 0..parent.len() as u32 {
        let of_corner = &mut of_corners[corner as usize / 3][corner as usize % 3];
        let vertex = *of_corner;
        if at_jump[vertex as usize] {
            *of_corner = *of_root.entry(normals::root(&mut parent, corner)).or_insert_with(|| {
                if std::mem::replace(&mut has_first[vertex as usize], true) {
                    fans.push(fan(vertex));
                    fans.len() as u32 - 1
                } else {
                    vertex
                }
            });
        }
    }
    (fans, of_corners)
}

/// The smallest change of the normal across a face, in radians, that counts as a bend.
const BENT: f64 = 0.02;

/// A face counts as flat in one direction if its curvature is at most this share of its neighbor's, and two faces count
/// as parts of one cylinder or plane if their tensors differ by no more. Normals in files are rounded.
const FLAT: f64 = 2e-3;

/// True if the curvature across an edge jumps there, as between a plane and a rounding: one side is flat across the
/// edge and continues into a face with the same curvature, and the other side is bent. Without such jumps, the slope of
/// the normals would be averaged over both sides, and planes would ripple.
fn is_jump(mesh: &Mesh, edges: &Edges, faces: &[Option<Face>], edge: &Edge) -> bool {
    let [(t, k), (u, _)] = edge.sides[..] else { return false };
    let (EdgeKind::Smooth, Some(one), Some(other)) = (edge.kind, &faces[t as usize], &faces[u as usize]) else {
        return false;
    };
    let [a, b] =
        [1, 2].map(|end| mesh.vertices[mesh.triangles[t as usize][usize::from(k + end) % 3] as usize].position);
    // The change of the normal across each face, as far as the face extends.
    let across = |face: &Face, t: u32| {
        let direction = face.normal.cross(b - a).normalize_or_zero();
        let corners = mesh.corners(t as usize).map(|p| (p - a).dot(direction));
        let extent = corners.into_iter().fold(0.0, f64::max) - corners.into_iter().fold(0.0, f64::min);
        (direction.dot(face.tensor * direction), extent)
    };
    let ((own, extent), (their, their_extent)) = (across(one, t), across(other, u));
    let continues = |t: u32, face: &Face, scale: f64| {
        edges.of_triangle[t as usize].iter().any(|e| {
            let next = &edges.edges[*e as usize];
            let same = |&(v, _): &(u32, u8)| {
                let Some(neighbor) = faces[v as usize].as_ref().filter(|_| v != t) else { return false };
                let turned = turned(neighbor.tensor, neighbor.normal, face.normal);
                (turned - face.tensor).to_cols_array().map(|x| x * x).iter().sum::<f64>() <= (FLAT * scale).powi(2)
            };
            next.kind == EdgeKind::Smooth && next.sides.iter().any(same)
        })
    };
    let is_flat = |flat: f64, bent: f64, extent: f64| flat.abs() <= FLAT * bent.abs() && bent.abs() * extent > BENT;
    is_flat(own, their, their_extent) && continues(t, one, their.abs())
        || is_flat(their, own, extent) && continues(u, other, own.abs())
}

/// Returns the weighted mean, without the rounding errors along the normal.
fn tangent(sum: DMat3, total: f64, normal: DVec3) -> DMat3 {
    let flat = DMat3::IDENTITY - outer(normal, normal);
    let mean = flat * (sum * (1.0 / total)) * flat;
    let symmetric = (mean + mean.transpose()) * 0.5;
    if symmetric.is_finite() { symmetric } else { DMat3::ZERO }
}

/// The normal of a face and its dN/dp.
struct Face {
    normal: DVec3,
    tensor: DMat3,
}

impl Face {
    /// Returns the data of a face; `None` if it has no area.
    fn of(vertices: [&Vertex; 3]) -> Option<Face> {
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
        tensor.is_finite().then_some(Face { normal, tensor })
    }
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
