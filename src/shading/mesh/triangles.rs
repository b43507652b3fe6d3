//! Meshes of triangles: their vertices, edges and curvature, and where they are.

use std::{collections::HashMap, sync::Arc};

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

/// The kind of an edge, independent of the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// Two triangles that share both vertices, including their normals.
    Smooth,
    /// Two triangles that share both sites but not both normals.
    Crease,
    /// Only one triangle.
    Border,
    /// Three or more triangles, or two with opposite windings, or only triangles that use one site twice and thus have
    /// no sides.
    NonManifold,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The two sites at the ends of the edge, the lower index first.
    pub sites: [u32; 2],
    /// The triangles at the edge, each with the corner that is opposite the edge. Triangles that use one site twice are
    /// left out: they have no area in any view and must not separate two triangles that have an area.
    pub sides: Vec<(u32, u8)>,
    pub kind: EdgeKind,
}

/// All edges of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edges {
    /// Every edge once, in the order in which the triangles list them.
    pub edges: Vec<Edge>,
    /// The three edges of each triangle; the k-th is opposite corner k.
    pub of_triangle: Vec<[u32; 3]>,
}

impl Edges {
    /// Returns the edges of `mesh`.
    pub fn of(mesh: &Mesh) -> Edges {
        let mut all = Edges::among(mesh.triangles.iter().map(|t| t.map(|v| mesh.vertices[v as usize].site)));
        let corner = |t: u32, k: u8| mesh.triangles[t as usize][usize::from(k % 3)];
        let site = |t: u32, k: u8| mesh.vertices[corner(t, k) as usize].site;
        for edge in &mut all.edges {
            edge.kind = match edge.sides[..] {
                [_] => EdgeKind::Border,
                [(t, k), (u, l)] if site(t, k + 1) == site(u, l + 2) => {
                    if corner(t, k + 1) == corner(u, l + 2) && corner(t, k + 2) == corner(u, l + 1) {
                        EdgeKind::Smooth
                    } else {
                        EdgeKind::Crease
                    }
                }
                _ => EdgeKind::NonManifold,
            };
        }
        all
    }

    /// Returns the edges of triangles given by their sites; the kinds of the edges are not yet determined.
    pub(super) fn among(triangles: impl ExactSizeIterator<Item = [u32; 3]>) -> Edges {
        let likely = triangles.len() * 3 / 2 + 3;
        let mut index: HashMap<[u32; 2], u32> = HashMap::with_capacity(likely);
        let mut edges: Vec<Edge> = Vec::with_capacity(likely);
        let mut of_triangle = Vec::with_capacity(triangles.len());
        for (t, sites) in triangles.enumerate() {
            checkpoint();
            let [a, b, c] = sites;
            let has_sides = a != b && b != c && c != a;
            of_triangle.push([(b, c, 0u8), (c, a, 1), (a, b, 2)].map(|(a, b, k)| {
                let sites = [a.min(b), a.max(b)];
                let at = *index.entry(sites).or_insert_with(|| {
                    edges.push(Edge { sites, sides: Vec::new(), kind: EdgeKind::NonManifold });
                    (edges.len() - 1) as u32
                });
                if has_sides {
                    let sides = &mut edges[at as usize].sides;
                    if sides.is_empty() {
                        sides.reserve_exact(2);
                    }
                    sides.push((t as u32, k));
                }
                at
            }));
        }
        Edges { edges, of_triangle }
    }
}

/// A mesh with its edges and its curvature, which depend on neither the view nor the light.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The triangles.
    pub mesh: Mesh,
    /// The edges at which the triangles meet.
    pub edges: Edges,
    /// The curvature at the vertices: dN/dp, the change of the unit normal along the surface, which is symmetric, and zero
    /// along the normal. A sphere of radius r with outward normals has (I − NNᵀ)/r.
    pub fans: cubic::Surface,
}

impl Surface {
    /// Computes the edges and the curvature of `mesh`, as [`cubic::Surface::joined`] does. Vertices on either side of a crease use
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
        let fans = cubic::Surface::joined(&of(|v| v.position), &of(|v| v.normal), &mesh.triangles, &across);
        checkpoint();
        Surface { mesh, edges, fans }
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
