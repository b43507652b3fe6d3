//! Which triangles meet at which edge.

use std::collections::HashMap;

use super::triangles::Mesh;

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

/// One edge.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The two sites at its ends, the lower first.
    pub sites: [u32; 2],
    /// The triangles at it, and which corner of each is opposite the edge. Triangles that name one site twice are left
    /// out: they have no area in any view, and must not separate two that have one.
    pub sides: Vec<(u32, u8)>,
    /// Its kind.
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
