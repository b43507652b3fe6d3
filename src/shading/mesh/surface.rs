//! A mesh with the data that are computed once per mesh: its edges, and its curvature.

use glam::{DMat3, DVec3};

use super::triangles::{EdgeKind, Edges, Mesh};
use crate::{shading::cubic, system::checkpoint};

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
    /// The fans whose slopes count along the edges of each triangle; see [`cubic::Fans::sides`].
    pub sides: Vec<[[u32; 2]; 3]>,
}

/// Triangles around a vertex over which the curvature does not jump; usually all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fan {
    /// The index of the vertex.
    pub vertex: u32,
    /// dN/dp, the change of the unit normal along the surface: symmetric, zero along the normal, in the mesh's own axes
    /// and units. A sphere of radius r with outward normals has (I − NNᵀ)/r.
    pub curvature: DMat3,
}

impl Surface {
    /// Computes the edges and the curvature of `mesh`, as [`cubic::fans`] does. Vertices on either side of a crease use
    /// only their own faces.
    #[must_use]
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
        let cubic::Fans { vertices, curvature, of_corners, sides } =
            cubic::fans(&of(|v| v.position), &of(|v| v.normal), &mesh.triangles, &across);
        checkpoint();
        // The tensors are symmetric, so that their rows are their columns.
        let fan = |(vertex, rows): (u32, cubic::Tensor)| Fan { vertex, curvature: DMat3::from_cols_array_2d(&rows) };
        Surface { fans: vertices.into_iter().zip(curvature).map(fan).collect(), mesh, edges, of_corners, sides }
    }
}
