//! Meshes of triangles: their vertices, edges and curvature, and where they are.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::{paint::Paint, smooth::Smooth};
use crate::{shading::cubic, system::checkpoint};

/// A corner of triangles: a position, and the normal with which it is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Position in the mesh's own units.
    pub position: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// The index of the position: vertices on either side of a crease share one site but have different normals.
    pub site: u32,
}

/// A surface of triangles, counterclockwise as seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The vertices. A site at a crease has one vertex for each of its normals; a site that no triangle uses has none.
    pub vertices: Vec<Vertex>,
    /// The triangles, as indices of three vertices each. Triangles without area are kept, but never drawn.
    pub triangles: Vec<[u32; 3]>,
    /// The surface that the triangles approximate, if it is known.
    pub smooth: Option<Smooth>,
    /// The colors and textures, if there are any.
    pub paint: Option<Arc<Paint>>,
}

impl Mesh {
    /// Returns this mesh with other normals: at each position, the normal that `normal` gives for it, of any length
    /// above 0. Use the normals of the true surface if it is known: averages over the faces of an irregular mesh are
    /// off by degrees, and no shader can correct the resulting light values.
    pub fn with_normals(mut self, normal: impl Fn(DVec3) -> DVec3) -> Mesh {
        for vertex in &mut self.vertices {
            vertex.normal = normal(vertex.position).normalize_or(vertex.normal);
        }
        self
    }

    /// Returns the positions of the three corners of triangle `triangle`.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize].position)
    }

    /// Returns the center and radius of a sphere around the mesh: the center of its bounding box, and the distance of
    /// the farthest vertex from it.
    pub fn bounds(&self) -> (DVec3, f64) {
        Mesh::bounds_of(&[self])
    }

    /// Returns [`Mesh::bounds`] of several meshes together.
    pub(crate) fn bounds_of(meshes: &[&Mesh]) -> (DVec3, f64) {
        let used = || meshes.iter().flat_map(|mesh| (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)));
        let (low, high) =
            used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let center = low + (high - low) / 2.0;
        (center, used().map(|p| p.distance(center)).fold(0.0, f64::max))
    }
}

/// What is beyond a side of a triangle, independent of the view. A side of a mesh is three times the index of its triangle,
/// plus the corner that is opposite the side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// The side of a triangle that shares both vertices, including their normals.
    Smooth(u32),
    /// The side of a triangle that shares both sites but not both normals.
    Crease(u32),
    /// Nothing.
    Border,
    /// Several triangles, or one with the opposite winding. Also given to triangles that use one site twice, which have no
    /// area in any view.
    NonManifold,
}

/// A mesh with its edges and its curvature, which depend on neither the view nor the light.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The triangles.
    pub mesh: Mesh,
    /// What is beyond each side of the triangles; the k-th is opposite corner k.
    pub across: Vec<[Across; 3]>,
    /// The number of edges across which shading is not smooth because of their triangles.
    pub non_manifold: usize,
    /// The curvature at the vertices: dN/dp, the change of the unit normal along the surface, which is symmetric, and zero
    /// along the normal. A sphere of radius r with outward normals has (I − NNᵀ)/r.
    pub fans: cubic::Surface,
}

impl Surface {
    /// Computes the edges and the curvature of `mesh`, as [`cubic::Surface::joined`] does. Vertices on either side of a crease use
    /// only their own faces.
    pub fn new(mesh: Mesh) -> Surface {
        let vertex = |side: u32, on: u32| mesh.triangles[(side / 3) as usize][((side + on) % 3) as usize];
        let site = |vertex: u32| mesh.vertices[vertex as usize].site;
        let mut across = vec![[Across::NonManifold; 3]; mesh.triangles.len()];
        let mut non_manifold = 0;
        let mut sides = Vec::new();
        for (t, [a, b, c]) in (0..).zip(mesh.triangles.iter().map(|t| t.map(site))) {
            checkpoint();
            // Triangles that use one site twice must not separate two others.
            if a != b && b != c && c != a {
                sides.extend([(b, c, 0), (c, a, 1), (a, b, 2)].map(|(a, b, k)| ([a.min(b), a.max(b)], 3 * t + k)));
            }
        }
        sides.sort_unstable();
        for edge in sides.chunk_by(|a, b| a.0 == b.0) {
            let mut set = |side: u32, to: Across| across[(side / 3) as usize][(side % 3) as usize] = to;
            match *edge {
                [(_, side)] => set(side, Across::Border),
                [(_, a), (_, b)] if site(vertex(a, 1)) == site(vertex(b, 2)) => {
                    let is_smooth = vertex(a, 1) == vertex(b, 2) && vertex(a, 2) == vertex(b, 1);
                    let kind = if is_smooth { Across::Smooth } else { Across::Crease };
                    set(a, kind(b));
                    set(b, kind(a));
                }
                _ => non_manifold += 1,
            }
        }
        let joined = |side: Across| if let Across::Smooth(other) = side { other } else { cubic::NONE };
        let joined: Vec<[u32; 3]> = across.iter().map(|sides| sides.map(joined)).collect();
        checkpoint();
        let of = |vector: fn(&super::Vertex) -> DVec3| -> Vec<cubic::V> {
            mesh.vertices.iter().map(|vertex| vector(vertex).to_array()).collect()
        };
        let fans = cubic::Surface::joined(&of(|v| v.position), &of(|v| v.normal), &mesh.triangles, &joined);
        checkpoint();
        Surface { mesh, across, non_manifold, fans }
    }
}

impl Mesh {
    /// Returns this mesh with `paint`, unless that is plain.
    ///
    /// # Panics
    /// Panics if the paint is not that of as many triangles.
    pub fn painted(mut self, paint: Paint) -> Mesh {
        assert_eq!(paint.corners.len(), self.triangles.len(), "every triangle has its paint");
        self.paint = (!paint.is_plain()).then(|| Arc::new(paint));
        self
    }

    /// Returns this mesh scaled, then rotated, then moved. Which surface it approximates is no longer known.
    pub fn placed(mut self, scale: f64, rotation: DMat3, position: DVec3) -> Mesh {
        for vertex in &mut self.vertices {
            vertex.position = position + rotation * (scale * vertex.position);
            vertex.normal = rotation * vertex.normal;
        }
        self.smooth = None;
        self
    }
}
