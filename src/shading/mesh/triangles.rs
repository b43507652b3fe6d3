//! Meshes of triangles.

use glam::DVec3;

/// A corner of triangles: a place, and the normal with which it is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where, in the mesh's own units.
    pub position: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// Which place this is: vertices on either side of a crease have one site and two normals.
    pub site: u32,
}

/// A surface of triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The vertices; a site at a crease has one for each of its normals. Sites that no triangle names have none.
    pub vertices: Vec<Vertex>,
    /// Indices of three vertices each. Triangles without area stay: they are never drawn.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// This mesh lit by other normals: at each place the one that `normal` gives for it, of any length above 0. Those of
    /// the surface itself, where that is known: averages over the faces of a mesh without order are off by degrees, which
    /// no shader can mend that takes its lights from them.
    #[must_use]
    pub fn with_normals(mut self, normal: impl Fn(DVec3) -> DVec3) -> Mesh {
        for vertex in &mut self.vertices {
            vertex.normal = normal(vertex.position).normalize_or(vertex.normal);
        }
        self
    }

    /// The three places of triangle `triangle`.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize].position)
    }

    /// Center and radius of a sphere around the mesh: the middle of its bounding box, and the farthest vertex from it.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, f64) {
        let used = || self.triangles.iter().flatten().map(|v| self.vertices[*v as usize].position);
        let (low, high) =
            used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let center = low + (high - low) / 2.0;
        (center, used().map(|p| p.distance(center)).fold(0.0, f64::max))
    }
}
