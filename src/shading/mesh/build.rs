//! Builds meshes from positions and faces, and triangulates polygons.

use std::{collections::VecDeque, ops::Range};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{
    normals,
    paint::{Coat, Paint, PaintedCorner},
    triangles::Mesh,
};
use crate::system::checkpoint;

/// The largest absolute coordinate of a mesh; it leaves room for products of several coordinates.
pub const MAX_COORDINATE: f64 = 1e30;

/// Faces with three or more corners, and optionally normals and paint at their corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygons {
    pub(super) sites: Vec<u32>,
    /// Has the same length as `sites`, or is empty until the first normal is given.
    pub(super) normals: Vec<Option<DVec3>>,
    pub ends: Vec<usize>,
    /// The paint at each corner and the coat of each polygon; empty if the polygons are not painted.
    pub(super) paint: Vec<PaintedCorner>,
    of_polygons: Vec<u32>,
    /// The coats to which painted polygons refer.
    pub coats: Vec<Coat>,
}

impl Polygons {
    /// Makes polygons from their sites, without normals.
    pub fn new<'a>(polygons: impl IntoIterator<Item = &'a [u32]>) -> Polygons {
        let mut all = Polygons::default();
        for sites in polygons {
            all.push(sites.iter().map(|site| (*site, None)));
        }
        all
    }

    /// Adds a polygon, given by its corners' sites and unit normals. A polygon with fewer than three corners is never
    /// drawn.
    pub fn push(&mut self, corners: impl IntoIterator<Item = (u32, Option<DVec3>)>) {
        for (site, normal) in corners {
            if normal.is_some() || !self.normals.is_empty() {
                self.normals.resize(self.sites.len(), None);
                self.normals.push(normal);
            }
            self.sites.push(site);
        }
        self.ends.push(self.sites.len());
    }

    /// True if any corner was given a normal.
    pub fn has_normals(&self) -> bool {
        self.normals.iter().any(Option::is_some)
    }

    /// True if every corner was given a normal.
    pub fn has_all_normals(&self) -> bool {
        self.has_normals() && self.normals.iter().all(Option::is_some)
    }

    /// Adds a polygon with paint and the index of its coat. Either all polygons are painted or none.
    pub fn push_painted(&mut self, corners: impl IntoIterator<Item = (u32, Option<DVec3>, PaintedCorner)>, coat: u32) {
        let (corners, paint): (Vec<_>, Vec<_>) = corners.into_iter().map(|(s, n, paint)| ((s, n), paint)).unzip();
        self.push(corners);
        self.paint.extend(paint);
        self.of_polygons.push(coat);
    }

    /// Makes polygons flat that were given no normal; returns whether there are any.
    pub fn flatten(&mut self, positions: &[DVec3]) -> bool {
        self.normals.resize(self.sites.len(), None);
        let mut are_any = false;
        for corners in self.corners() {
            let (sites, normals) = (&self.sites[corners.clone()], &mut self.normals[corners]);
            if normals.iter().all(Option::is_none) {
                let corners: Vec<DVec3> = sites.iter().map(|site| positions[*site as usize]).collect();
                normals.fill(normals::newell(&corners).try_normalize());
                are_any = true;
            }
        }
        are_any
    }

    /// Leaves out polygons that go around the same sites in the same direction as an earlier one, and returns how many.
    pub fn drop_repeated(&mut self) -> usize {
        let corners = self.corners();
        // From the lowest site on.
        let around = |face: &u32| {
            let sites = &self.sites[corners[*face as usize].clone()];
            let first = (0..sites.len()).min_by_key(|at| sites[*at]).unwrap_or_default();
            sites[first..].iter().chain(&sites[..first])
        };
        let mut faces: Vec<u32> = (0..self.ends.len() as u32).collect();
        faces.par_sort_by(|a, b| around(a).cmp(around(b)));
        let same = faces.chunk_by(|a, b| around(a).eq(around(b)));
        let mut kept: Vec<u32> = same.map(|same| same[0]).collect();
        kept.sort_unstable();
        let repeated = faces.len() - kept.len();
        if repeated > 0 {
            *self = self.only(kept.iter().map(|face| (*face as usize, corners[*face as usize].clone())));
        }
        repeated
    }

    /// Leaves out corners at the site of the next one, and polygons that have fewer than three others.
    pub(super) fn drop_collapsed(&mut self) {
        let others = self.corners().into_iter().map(|Range { start, end }| {
            let next = |at: usize| if at + 1 < end { at + 1 } else { start };
            (start..end).filter(|at| self.sites[*at] != self.sites[next(*at)]).collect::<Vec<usize>>()
        });
        *self = self.only(others.enumerate().filter(|(_, others)| others.len() >= 3));
    }

    /// Returns only these polygons, each with only these corners.
    fn only(&self, kept: impl Iterator<Item = (usize, impl IntoIterator<Item = usize> + Clone)>) -> Polygons {
        let mut left = Polygons { coats: self.coats.clone(), ..Polygons::default() };
        for (face, corners) in kept {
            left.sites.extend(corners.clone().into_iter().map(|at| self.sites[at]));
            left.normals.extend(corners.clone().into_iter().filter_map(|at| self.normals.get(at)));
            left.paint.extend(corners.into_iter().filter_map(|at| self.paint.get(at)));
            left.of_polygons.extend(self.of_polygons.get(face));
            left.ends.push(left.sites.len());
        }
        left
    }

    /// Returns the corners of each polygon, as indices into `sites`.
    pub(super) fn corners(&self) -> Vec<Range<usize>> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| start..*end).collect()
    }

    /// Returns the sides of all polygons in the order of their edges: the edge, with its lower site first; the polygon; and
    /// whether it goes along the edge from the lower site to the higher.
    pub(super) fn sides(&self) -> Vec<([u32; 2], u32, bool)> {
        let mut sides = Vec::with_capacity(self.sites.len());
        for (face, corners) in (0..).zip(self.corners()) {
            let sites = &self.sites[corners];
            let around = sites.iter().zip(sites.iter().cycle().skip(1));
            sides.extend(around.filter(|(a, b)| a != b).map(|(a, b)| ([*a.min(b), *a.max(b)], face, a < b)));
        }
        sides.sort_unstable();
        sides
    }
}

impl Mesh {
    /// Makes the mesh of `triangles` over `positions` (the sites). Each vertex's normal is the normalized sum of the
    /// unit normals of the faces around it, Shoaff §4.1. Faces that meet at an edge at more than `crease_deg` degrees
    /// do not share normals there. With 180, every vertex is smooth; with 0, only vertices within a plane are.
    ///
    /// # Errors
    /// No triangle has an area, or a position is not finite.
    pub fn new(positions: &[DVec3], triangles: &[[u32; 3]], crease_deg: f64) -> Result<Mesh, String> {
        Mesh::from_polygons(positions, &Polygons::new(triangles.iter().map(|t| &t[..])), crease_deg)
    }

    /// Makes the mesh of `polygons` over `positions`, which must have their sites, cut into triangles ([`triangulated`]).
    /// A polygon counts as one face in the averages, with its Newell normal. Corners with a given normal keep it. Given
    /// normals at one site that differ by less than 0.1° are merged, and an edge is a crease if the normals of its two
    /// sides differ.
    ///
    /// # Errors
    /// The same errors as [`Mesh::new`].
    pub fn from_polygons(positions: &[DVec3], polygons: &Polygons, crease_deg: f64) -> Result<Mesh, String> {
        // NaN does not count as within.
        let within = |p: &DVec3| p.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE);
        if let Some(at) = positions.iter().position(|p| !within(p)) {
            let expected = "expected three finite numbers within ±1e30";
            return Err(format!("position {at} is not finite or is beyond ±1e30; {expected}"));
        }
        let (mut triangles, mut normals, mut faces, mut given) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut paint = Paint { corners: Vec::new(), of_triangles: Vec::new(), coats: polygons.coats.clone() };
        for (face, range) in polygons.corners().into_iter().enumerate() {
            checkpoint();
            let (sites, theirs) = (&polygons.sites[range.clone()], polygons.normals.get(range.clone()));
            let corners: Vec<DVec3> = sites.iter().map(|i| positions[*i as usize]).collect();
            let normal = normals::newell(&corners);
            for triangle in triangulated(&corners) {
                triangles.push(triangle.map(|k| sites[k as usize]));
                normals.push(normal);
                faces.push(face as u32);
                given.extend(theirs.map(|theirs| triangle.map(|k| theirs[k as usize])));
                if !polygons.paint.is_empty() {
                    paint.corners.push(triangle.map(|k| polygons.paint[range.start + k as usize]));
                    paint.of_triangles.push(polygons.of_polygons[face]);
                }
            }
        }
        if normals.iter().all(|normal| *normal == DVec3::ZERO) {
            return Err("has no face with a nonzero area; expected at least one".to_owned());
        }
        let all_given = !given.is_empty() && given.iter().flatten().all(Option::is_some);
        let crease_deg = if all_given { 180.0 } else { crease_deg };
        let mesh = normals::averaged(positions, &triangles, &normals, &faces, crease_deg);
        let mesh = if given.is_empty() { mesh } else { normals::replaced(&mesh, &given) };
        Ok(if paint.corners.is_empty() { mesh } else { mesh.painted(paint) })
    }
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
    let normal = normals::newell(corners);
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
