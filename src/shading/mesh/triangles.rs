//! Meshes of triangles, and the triangles that meet at each edge.

use std::collections::HashMap;

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

/// A surface of triangles, counterclockwise as seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The vertices; a site at a crease has one for each of its normals. Sites that no triangle names have none.
    pub vertices: Vec<Vertex>,
    /// Indices of three vertices each. Triangles without area stay: they are never drawn.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// This mesh lit by other normals: at each place the one that `normal` gives for it, of any length above 0. Those
    /// of the surface itself, where that is known: averages over the faces of an irregular mesh are off by degrees,
    /// which no shader that uses these lights can correct.
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

/// The kind of an edge, independent of the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// Two triangles that share both vertices, normals and all.
    Smooth,
    /// Two triangles that share both places but not both normals.
    Crease,
    /// One triangle only.
    Border,
    /// Three triangles or more, or two with opposite windings; or only triangles that name one place twice, which have
    /// no sides.
    NonManifold,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The two sites at its ends, the lower first.
    pub sites: [u32; 2],
    /// The triangles at it, and which corner of each is opposite the edge. Triangles that name one site twice are left
    /// out: they have no area in any view, and must not separate two that have one.
    pub sides: Vec<(u32, u8)>,
    pub kind: EdgeKind,
}

/// All edges of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edges {
    /// Every edge once, in the order in which the triangles name them.
    pub edges: Vec<Edge>,
    /// The three edges of each triangle; the k-th is opposite corner k.
    pub of_triangle: Vec<[u32; 3]>,
}

impl Edges {
    /// The edges of `mesh`.
    #[must_use]
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

    /// The edges among triangles given by their sites; their kinds are not known yet.
    pub(super) fn among(triangles: impl ExactSizeIterator<Item = [u32; 3]>) -> Edges {
        let likely = triangles.len() * 3 / 2 + 3;
        let mut index: HashMap<[u32; 2], u32> = HashMap::with_capacity(likely);
        let mut edges: Vec<Edge> = Vec::with_capacity(likely);
        let mut of_triangle = Vec::with_capacity(triangles.len());
        for (t, sites) in triangles.enumerate() {
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
