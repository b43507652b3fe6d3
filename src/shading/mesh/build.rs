//! Builds meshes from positions and faces, and triangulates polygons.

use std::{collections::HashMap, collections::VecDeque, ops::Range};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{
    normals::newell,
    paint::{Coat, Paint, PaintedCorner},
    triangles::{Mesh, Vertex},
};
use crate::{
    shading::cubic::{NONE, join, root},
    system::checkpoint,
};

/// The largest absolute coordinate of a mesh; it leaves room for products of several coordinates.
pub const MAX_COORDINATE: f64 = 1e30;

/// A corner of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// The index of its position.
    pub site: u32,
    /// The index of its paint.
    pub vertex: u32,
    /// The index of its normal; it need not exist.
    pub normal: Option<u32>,
}

impl Corner {
    /// Returns a corner whose position, paint and normal have the same index.
    pub const fn of(vertex: u32) -> Corner {
        Corner { site: vertex, vertex, normal: Some(vertex) }
    }
}

/// Faces with three or more corners, and the positions, normals and paint to which the corners refer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygons {
    pub positions: Vec<DVec3>,
    /// Unit normals; `None` for a normal that is to be estimated.
    pub normals: Vec<Option<DVec3>>,
    /// Empty if the polygons are not painted.
    pub paint: Vec<PaintedCorner>,
    /// The corners of all polygons.
    pub corners: Vec<Corner>,
    /// Where each polygon ends in `corners`.
    pub ends: Vec<usize>,
    /// The coat of each polygon, as an index into `coats`, if they are painted.
    pub of_polygons: Vec<u32>,
    pub coats: Vec<Coat>,
}

/// A side of a polygon.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// The sites at its ends, the lower first.
    pub edge: [u32; 2],
    pub face: u32,
    /// The corners at its ends, in the order in which the polygon goes around.
    pub corners: [u32; 2],
}

impl Polygons {
    /// Makes polygons from the sites of their corners, without normals.
    pub fn new<P: AsRef<[u32]>>(positions: Vec<DVec3>, polygons: &[P]) -> Polygons {
        let mut all = Polygons { positions, ..Polygons::default() };
        for sites in polygons {
            all.push(sites.as_ref().iter().map(|site| Corner::of(*site)));
        }
        all
    }

    /// Adds a polygon.
    pub fn push(&mut self, corners: impl IntoIterator<Item = Corner>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    /// Returns the normal that a corner was given, if any.
    pub(super) fn normal(&self, corner: &Corner) -> Option<DVec3> {
        self.normals.get(corner.normal? as usize).copied().flatten()
    }

    /// True if any corner was given a normal.
    pub fn has_normals(&self) -> bool {
        self.corners.iter().any(|corner| self.normal(corner).is_some())
    }

    /// True if every corner was given a normal.
    pub fn has_all_normals(&self) -> bool {
        !self.corners.is_empty() && self.corners.iter().all(|corner| self.normal(corner).is_some())
    }

    /// Checks the positions of the corners.
    ///
    /// # Errors
    /// A position is not finite.
    pub fn check(&self) -> Result<(), String> {
        // NaN does not count as within.
        let within = |p: DVec3| p.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE);
        let wrong = self.corners.iter().find(|corner| !within(self.positions[corner.site as usize]));
        wrong.map_or(Ok(()), |Corner { site, .. }| {
            let expected = "expected three finite numbers within ±1e30";
            Err(format!("position {site} is not finite or is beyond ±1e30; {expected}"))
        })
    }

    /// Gives corners at exactly the same position the same site.
    pub fn merge(&mut self) {
        let (mut merged, mut sites) = (Vec::new(), HashMap::new());
        let mut of_position: Vec<Option<u32>> = vec![None; self.positions.len()];
        for corner in &mut self.corners {
            let before = corner.site as usize;
            corner.site = *of_position[before].get_or_insert_with(|| {
                // Adding 0 turns −0 into 0.
                let position = self.positions[before] + DVec3::ZERO;
                *sites.entry(position.to_array().map(f64::to_bits)).or_insert_with(|| {
                    merged.push(position);
                    merged.len() as u32 - 1
                })
            });
        }
        self.positions = merged;
    }

    /// Makes polygons flat that were given no normal; returns whether there are any.
    pub fn flatten(&mut self) -> bool {
        let mut are_any = false;
        for corners in self.ranges() {
            if self.corners[corners.clone()].iter().all(|corner| self.normal(corner).is_none()) {
                let normal = Some(self.normals.len() as u32);
                self.normals.push(newell(&self.places(corners.clone())).try_normalize());
                self.corners[corners].iter_mut().for_each(|corner| corner.normal = normal);
                are_any = true;
            }
        }
        are_any
    }

    /// Leaves out polygons that go around the same sites in the same direction as an earlier one, and returns how many.
    pub fn drop_repeated(&mut self) -> usize {
        let ranges = self.ranges();
        // From the lowest site on.
        let around = |face: &u32| {
            let corners = &self.corners[ranges[*face as usize].clone()];
            let first = (0..corners.len()).min_by_key(|at| corners[*at].site).unwrap_or_default();
            corners[first..].iter().chain(&corners[..first]).map(|corner| corner.site)
        };
        let mut faces: Vec<u32> = (0..self.ends.len() as u32).collect();
        faces.par_sort_by(|a, b| around(a).cmp(around(b)));
        let mut is_kept = vec![false; faces.len()];
        let mut repeated = 0;
        for same in faces.chunk_by(|a, b| around(a).eq(around(b))) {
            is_kept[same[0] as usize] = true;
            repeated += same.len() - 1;
        }
        if repeated > 0 {
            self.retain(|face, _| is_kept[face]);
        }
        repeated
    }

    /// Leaves out corners at the site of the one before, and polygons that have fewer than three others.
    pub fn drop_collapsed(&mut self) {
        self.retain(|_, corners| {
            corners.dedup_by_key(|corner| corner.site);
            if corners.len() > 1 && corners[0].site == corners[corners.len() - 1].site {
                corners.pop();
            }
            corners.len() >= 3
        });
    }

    /// Lets `of` change the corners of each polygon, and leaves out the polygons for which it returns false.
    fn retain(&mut self, of: impl Fn(usize, &mut Vec<Corner>) -> bool) {
        let mut left = Polygons::default();
        let mut corners = Vec::new();
        for (face, range) in self.ranges().into_iter().enumerate() {
            corners.clear();
            corners.extend_from_slice(&self.corners[range]);
            if of(face, &mut corners) {
                left.push(corners.iter().copied());
                left.of_polygons.extend(self.of_polygons.get(face));
            }
        }
        (self.corners, self.ends, self.of_polygons) = (left.corners, left.ends, left.of_polygons);
    }

    /// Returns the corners of each polygon, as indices into `corners`.
    pub(super) fn ranges(&self) -> Vec<Range<usize>> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| start..*end).collect()
    }

    /// Returns the positions of some corners.
    pub(super) fn places(&self, corners: Range<usize>) -> Vec<DVec3> {
        self.corners[corners].iter().map(|corner| self.positions[corner.site as usize]).collect()
    }

    /// Returns the sides of all polygons in the order of their edges.
    pub(super) fn sides(&self) -> Vec<Side> {
        let mut sides = Vec::with_capacity(self.corners.len());
        for (face, range) in (0..).zip(self.ranges()) {
            for at in range.clone() {
                let corners = [at, if at + 1 < range.end { at + 1 } else { range.start }];
                let [a, b] = corners.map(|at| self.corners[at].site);
                if a != b {
                    sides.push(Side { edge: [a.min(b), a.max(b)], face, corners: corners.map(|at| at as u32) });
                }
            }
        }
        sides.sort_unstable();
        sides
    }

    /// Makes the mesh of these polygons, cut into triangles ([`triangulated`]). Each vertex's normal is the normalized sum of
    /// the unit normals of the faces around it, Shoaff §4.1; a polygon counts as one face, with its Newell normal. Faces
    /// that meet at an edge at more than `crease_deg` degrees do not share normals there. With 180, every vertex is smooth;
    /// with 0, only vertices within a plane are. Corners with a given normal keep it. Given normals at one site that differ
    /// by less than 0.1° are merged, and an edge is a crease if the normals of its two sides differ.
    ///
    /// # Errors
    /// No polygon has an area, or a position is not finite.
    pub fn mesh(&self, crease_deg: f64) -> Result<Mesh, String> {
        self.check()?;
        let (mut cut, mut normals) = (Vec::new(), Vec::with_capacity(self.ends.len()));
        for (face, range) in self.ranges().into_iter().enumerate() {
            checkpoint();
            let corners = self.places(range.clone());
            normals.push(newell(&corners));
            let triangles = triangulated(&corners).into_iter();
            cut.extend(triangles.map(|triangle| (face, triangle.map(|k| range.start + k as usize))));
        }
        if normals.iter().all(|normal| *normal == DVec3::ZERO) {
            return Err("has no face with a nonzero area; expected at least one".to_owned());
        }
        let (vertices, of_corners) = vertices(self, &normals, crease_deg);
        let triangles = cut.iter().map(|(_, corners)| corners.map(|at| of_corners[at])).collect();
        let mesh = Mesh { vertices, triangles, smooth: None, paint: None };
        if self.paint.is_empty() {
            return Ok(mesh);
        }
        let painted = |at: usize| self.paint[self.corners[at].vertex as usize];
        Ok(mesh.painted(Paint {
            corners: cut.iter().map(|(_, corners)| corners.map(painted)).collect(),
            of_triangles: cut.iter().map(|(face, _)| self.of_polygons[*face]).collect(),
            coats: self.coats.clone(),
        }))
    }
}

impl Mesh {
    /// Makes the mesh of `triangles` over `positions` (the sites), as [`Polygons::mesh`] does.
    ///
    /// # Errors
    /// The same errors as [`Polygons::mesh`].
    pub fn new(positions: &[DVec3], triangles: &[[u32; 3]], crease_deg: f64) -> Result<Mesh, String> {
        Polygons::new(positions.to_vec(), triangles).mesh(crease_deg)
    }
}

/// Given normals at one site that differ by no more than this are merged, because files contain rounded normals.
const SAME_DEG: f64 = 0.1;

/// The number of a site's normals, newest first, with which another one is compared; this keeps fans of any size fast.
const COMPARED: usize = 64;

/// Returns the vertices of polygons whose faces have these unit normals, or zero without an area, and the vertex of each
/// corner. Normals that were not given are averaged, split where faces meet at more than `crease_deg` degrees. A face
/// counts once at each of its corners, as in Shoaff.
fn vertices(polygons: &Polygons, faces: &[DVec3], crease_deg: f64) -> (Vec<Vertex>, Vec<u32>) {
    let (Polygons { positions, corners, .. }, has_normals) = (polygons, polygons.has_normals());
    // Corners of one group share their averaged normal.
    let groups: Vec<u32> = if crease_deg >= 180.0 || polygons.has_all_normals() {
        corners.iter().map(|corner| corner.site).collect()
    } else {
        fans(polygons, faces, crease_deg)
    };
    let count = corners.len().max(positions.len());
    let (mut sums, mut last) = (vec![DVec3::ZERO; count], vec![NONE; count]);
    for (face, range) in polygons.ranges().into_iter().enumerate() {
        for group in &groups[range] {
            if std::mem::replace(&mut last[*group as usize], face as u32) != face as u32 {
                sums[*group as usize] += faces[face];
            }
        }
    }
    let least_cosine = SAME_DEG.to_radians().cos();
    let mut vertices: Vec<Vertex> = Vec::with_capacity(positions.len());
    // The newest vertex of each group or, with given normals, of each site; and the one before each vertex.
    let (mut newest, mut before) = (vec![NONE; count], Vec::with_capacity(positions.len()));
    let mut of_corners = Vec::with_capacity(corners.len());
    for (face, range) in polygons.ranges().into_iter().enumerate() {
        for (corner, group) in corners[range.clone()].iter().zip(&groups[range]) {
            let averaged = || match sums[*group as usize] {
                sum if sum.length() > 1e-9 => sum.normalize(),
                // Faces that point in opposite directions have no mean normal, so each keeps its own. A face without
                // area is never drawn, but needs some normal.
                _ if faces[face] == DVec3::ZERO => DVec3::Z,
                _ => faces[face],
            };
            let normal = polygons.normal(corner).unwrap_or_else(averaged);
            let newest = &mut newest[if has_normals { corner.site } else { *group } as usize];
            let older = |vertex: u32| (vertex != NONE).then_some(vertex);
            let known = std::iter::successors(older(*newest), |vertex| older(before[*vertex as usize]));
            let mut known = known.take(COMPARED).filter(|vertex| {
                let other = vertices[*vertex as usize].normal;
                if has_normals { other.dot(normal) >= least_cosine } else { other == normal }
            });
            of_corners.push(known.next().unwrap_or_else(|| {
                before.push(std::mem::replace(newest, vertices.len() as u32));
                vertices.push(Vertex { position: positions[corner.site as usize], normal, site: corner.site });
                *newest
            }));
        }
    }
    (vertices, of_corners)
}

/// For each corner, returns the fan of faces around its site to which it belongs, identified by one of the fan's
/// corners. A fan continues across every edge at which the faces meet at no more than `crease_deg` degrees, so the two
/// faces at such an edge share the vertices at both of its ends.
fn fans(polygons: &Polygons, faces: &[DVec3], crease_deg: f64) -> Vec<u32> {
    // The tolerance keeps the two triangles of a flat quad together at 0°.
    let least_cosine = crease_deg.max(0.0).to_radians().cos() - 1e-9;
    let mut parent: Vec<u32> = (0..polygons.corners.len() as u32).collect();
    let site = |corner: u32| polygons.corners[corner as usize].site;
    let mut sides = polygons.sides();
    // A face without area must not separate two others.
    sides.retain(|side| faces[side.face as usize] != DVec3::ZERO);
    // Compare only with the next side. At an edge of two faces, that is the only pair; at an edge of many, it keeps the
    // cost linear.
    for pair in sides.windows(2).filter(|pair| pair[0].edge == pair[1].edge) {
        checkpoint();
        let [a, b] = [0, 1].map(|k| faces[pair[k].face as usize]);
        if a.dot(b) < least_cosine {
            continue;
        }
        for own in pair[0].corners {
            let theirs = pair[1].corners.into_iter().find(|other| site(*other) == site(own));
            theirs.into_iter().for_each(|other| join(&mut parent, own, other));
        }
    }
    (0..parent.len() as u32).map(|corner| root(&mut parent, corner)).collect()
}

/// Returns the triangles of a polygon as indices into its corners, in the polygon's own winding. There are always two
/// fewer triangles than corners, and none for fewer than three corners. A convex polygon becomes a fan around its first
/// corner. A concave polygon is cut ear by ear on its Newell plane, in time quadratic in the number of corners. A
/// polygon that crosses itself or has no area becomes a fan once no ear is left.
pub fn triangulated(corners: &[DVec3]) -> Vec<[u32; 3]> {
    let count = corners.len();
    if count < 4 {
        return if count == 3 { vec![[0, 1, 2]] } else { Vec::new() };
    }
    let flat = flattened(corners);
    let convex = (0..count).all(|i| turn(flat[i], flat[(i + 1) % count], flat[(i + 2) % count]) > FLAT)
        // A star polygon also turns in only one direction, but goes around more than once.
        && (1..count - 1).all(|i| turn(flat[0], flat[i], flat[i + 1]) > FLAT);
    if convex { fan(&(0..count as u32).collect::<Vec<_>>()) } else { ears(&flat) }
}

/// Three corners count as collinear if twice the area of their triangle, relative to the square of the polygon's
/// extent, is at most this.
const FLAT: f64 = 1e-12;

/// Returns the corners on the Newell plane, counterclockwise and within −1…1; all zero if there is no such plane.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    let normal = newell(corners);
    if normal == DVec3::ZERO {
        return vec![DVec2::ZERO; corners.len()];
    }
    let (x, y) = normal.any_orthonormal_pair();
    // `any_orthonormal_pair` is right-handed: x × y = normal.
    let flat: Vec<DVec2> = corners.iter().map(|p| *p - corners[0]).map(|p| DVec2::new(p.dot(x), p.dot(y))).collect();
    let size = flat.iter().map(|p| p.abs().max_element()).fold(f64::MIN_POSITIVE, f64::max);
    flat.iter().map(|p| *p / size).collect()
}

/// Returns twice the area of a triangle, positive if counterclockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn fan(ring: &[u32]) -> Vec<[u32; 3]> {
    (1..ring.len() - 1).map(|i| [ring[0], ring[i], ring[i + 1]]).collect()
}

/// Cuts off corners whose triangles contain no other corner, until three corners are left or none can be cut.
fn ears(flat: &[DVec2]) -> Vec<[u32; 3]> {
    let count = flat.len();
    let mut before: Vec<usize> = (0..count).map(|i| (i + count - 1) % count).collect();
    let mut after: Vec<usize> = (0..count).map(|i| (i + 1) % count).collect();
    let mut is_cut = vec![false; count];
    let mut waiting: VecDeque<usize> = (0..count).collect();
    let mut triangles = Vec::with_capacity(count - 2);
    let (mut left, mut left_last_round) = (count, usize::MAX);
    while left > 3 {
        let Some(at) = waiting.pop_front() else {
            if left == left_last_round {
                break;
            }
            left_last_round = left;
            waiting.extend((0..count).filter(|i| !is_cut[*i]));
            continue;
        };
        if is_cut[at] || !is_ear(flat, &before, &after, at) {
            continue;
        }
        let (a, b) = (before[at], after[at]);
        triangles.push([a as u32, at as u32, b as u32]);
        (after[a], before[b], is_cut[at]) = (b, a, true);
        left -= 1;
        // Often, one of these two has now become an ear.
        waiting.push_back(a);
        waiting.push_back(b);
    }
    let first = (0..count).find(|i| !is_cut[*i]).unwrap_or(0);
    let ring: Vec<u32> = std::iter::successors(Some(first), |i| Some(after[*i])).take(left).map(|i| i as u32).collect();
    triangles.extend(fan(&ring));
    triangles
}

/// True if the polygon turns left at corner `at` and no other remaining corner lies in the triangle there.
fn is_ear(flat: &[DVec2], before: &[usize], after: &[usize], at: usize) -> bool {
    let [a, b, c] = [before[at], at, after[at]].map(|i| flat[i]);
    if turn(a, b, c) <= FLAT {
        return false;
    }
    let mut other = after[after[at]];
    while other != before[at] {
        let p = flat[other];
        // A corner at the same position as one of these three is a pinch, not an obstacle.
        if p != a && p != b && p != c && turn(a, b, p) >= -FLAT && turn(b, c, p) >= -FLAT && turn(c, a, p) >= -FLAT {
            return false;
        }
        other = after[other];
    }
    true
}
