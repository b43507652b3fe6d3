//! A mesh, with what is computed once a mesh.

use glam::DMat3;

use super::{curvature, edges::Edges, triangles::Mesh};

/// A mesh with its edges and its curvature, which depend neither on view nor on light.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The triangles.
    pub mesh: Mesh,
    /// Which of them meet where.
    pub edges: Edges,
    /// For each vertex dN/dp, how the unit normal changes along the surface: symmetric, zero along the normal, in
    /// the mesh's own axes and units.
    pub curvature: Vec<DMat3>,
}

impl Surface {
    /// `mesh` with all that.
    #[must_use]
    pub fn new(mesh: Mesh) -> Surface {
        let edges = Edges::of(&mesh);
        let curvature = curvature::of(&mesh);
        Surface { mesh, edges, curvature }
    }
}
