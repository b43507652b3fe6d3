//! A mesh with the data that are computed once per mesh: its edges, and its curvature.

use glam::DVec3;

use super::triangles::{EdgeKind, Edges, Mesh};
use crate::{shading::cubic, system::checkpoint};

/// A mesh with its edges and its curvature, which depend on neither the view nor the light.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The triangles.
    pub mesh: Mesh,
    /// The edges at which the triangles meet.
    pub edges: Edges,
    /// The curvature at the vertices: dN/dp, the change of the unit normal along the surface, which is symmetric, and zero
    /// along the normal. A sphere of radius r with outward normals has (I − NNᵀ)/r.
    pub fans: cubic::Fans,
}

impl Surface {
    /// Computes the edges and the curvature of `mesh`, as [`cubic::fans`] does. Vertices on either side of a crease use
    /// only their own faces.
    pub fn new(mesh: Mesh) -> Surface {
        let edges = Edges::of(&mesh);
        let mut across = vec![[cubic::NONE; 3]; mesh.triangles.len()];
        for edge in edges.edges.iter().filter(|edge| edge.kind == EdgeKind::Smooth) {
            let [(t, k), (u, l)] = [edge.sides[0], edge.sides[1]];
            across[t as usize][usize::from(k)] = 3 * u + u32::from(l);
            across[u as usize][usize::from(l)] = 3 * t + u32::from(k);
        }
        checkpoint();
        let of = |vector: fn(&super::Vertex) -> DVec3| -> Vec<cubic::V> {
            mesh.vertices.iter().map(|vertex| vector(vertex).to_array()).collect()
        };
        let fans = cubic::fans(&of(|v| v.position), &of(|v| v.normal), &mesh.triangles, &across);
        checkpoint();
        Surface { mesh, edges, fans }
    }
}
