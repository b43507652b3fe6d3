//! Repairs faces from files: joins open edges that lie in the same place, and gives neighboring faces the same winding.

use std::{
    collections::{BTreeMap, HashMap},
    ops::Range,
};

use glam::DVec3;

use super::build::Polygons;

/// A position on an open edge is joined with the nearest one that is kept, if they differ by no more than this share of the
/// shortest open edge at them, or of the median edge of the mesh if that is shorter. Programs that compute a position once
/// for each side of a seam round it differently.
const SAME: f64 = 1e-3;

/// The ends of an edge are joined if it is no longer than this share of the longest edges at both: it is there by rounding
/// alone, as at the pole of a sphere. A small part of a mesh has no longer edges.
const SHORT: f64 = 1e-6;

impl Polygons {
    /// Joins positions on open edges that are almost the same, and the ends of edges without a length to speak of. Returns
    /// the number of positions that were joined with another one.
    pub fn weld(&mut self) -> usize {
        let (edges, positions) = (self.edges(), &self.positions);
        let length = |[a, b]: &[u32; 2]| positions[*a as usize].distance(positions[*b as usize]);
        let mut lengths: Vec<f64> = edges.iter().map(|(edge, _)| length(edge)).filter(|length| *length > 0.0).collect();
        lengths.sort_unstable_by(f64::total_cmp);
        let Some(size) = lengths.get(lengths.len() / 2).copied().filter(|size| size.is_finite()) else {
            return 0;
        };
        let mut longest: HashMap<u32, f64> = HashMap::new();
        for (edge, _) in &edges {
            for site in edge {
                longest.entry(*site).and_modify(|longest| *longest = longest.max(length(edge))).or_insert(length(edge));
            }
        }
        let mut reach: BTreeMap<u32, f64> = BTreeMap::new();
        for (edge, faces) in &edges {
            let short = SHORT * longest[&edge[0]].min(longest[&edge[1]]);
            let most = match length(edge) {
                length if length <= short => short,
                length if *faces == 1 => SAME * length.min(size),
                _ => continue,
            };
            for site in edge {
                reach.entry(*site).and_modify(|reach| *reach = reach.min(most)).or_insert(most);
            }
        }
        let mut joined: HashMap<u32, u32> = HashMap::new();
        let line = Line::new(reach.keys().map(|site| (*site, positions[*site as usize])));
        for (&site, &own) in &reach {
            let place = positions[site as usize];
            let away = |other: u32| positions[other as usize].distance(place);
            let kept = line.near(place, own).filter(|other| *other < site && !joined.contains_key(other));
            let near = kept.filter(|other| away(*other) <= own.min(reach[other]));
            if let Some(other) = near.min_by(|a, b| away(*a).total_cmp(&away(*b))) {
                joined.insert(site, other);
            }
        }
        for corner in &mut self.corners {
            corner.site = *joined.get(&corner.site).unwrap_or(&corner.site);
        }
        if !joined.is_empty() {
            self.drop_collapsed();
        }
        joined.len()
    }

    /// Returns the edges in order, each with its lower site first, and the number of faces at each.
    fn edges(&self) -> Vec<([u32; 2], usize)> {
        self.sides().chunk_by(|a, b| a.edge == b.edge).map(|same| (same[0].edge, same.len())).collect()
    }
}

/// Points in their order along a direction to which hardly any plane of a mesh is perpendicular, so that few of them lie
/// at one place.
struct Line(Vec<(f64, u32)>);

impl Line {
    fn along(place: DVec3) -> f64 {
        place.dot(DVec3::new(0.125_f64.sqrt(), 0.5, 0.625_f64.sqrt()))
    }

    fn new(places: impl Iterator<Item = (u32, DVec3)>) -> Line {
        let mut points: Vec<_> = places.map(|(number, place)| (Line::along(place), number)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Line(points)
    }

    /// Returns the points that may be within `reach` of a place.
    fn near(&self, place: DVec3, reach: f64) -> impl Iterator<Item = u32> {
        let at = Line::along(place);
        // The product rounds.
        let reach = 1.001 * reach + 1e-15 * place.abs().element_sum();
        let first = self.0.partition_point(|point| point.0 < at - reach);
        self.0[first..].iter().take_while(move |point| point.0 <= at + reach).map(|point| point.1)
    }
}

impl Polygons {
    /// Reverses faces so that the two faces at an edge go along it in opposite directions, and returns how many. In each
    /// connected part, these are the fewer, or those that face inward if the part is closed and no normal is given. Parts
    /// for which there is no such choice, as a Möbius strip, stay as they are; edges of one face or of more than two do
    /// not connect. If closed parts without such edges enclose a negative volume together, all of these are reversed; the
    /// second number counts their faces. A part with given normals faces to their side; the third number counts the faces
    /// that are reversed for it.
    pub fn unify_winding(&mut self) -> [usize; 3] {
        let (ranges, has_normals) = (self.ranges(), self.has_normals());
        let mut neighbors = vec![Vec::new(); self.ends.len()];
        let mut is_open = vec![false; self.ends.len()];
        for sides in self.sides().chunk_by(|a, b| a.edge == b.edge) {
            if sides.len() != 2 {
                sides.iter().for_each(|side| is_open[side.face as usize] = true);
            }
            if let [a, b] = sides
                && a.face != b.face
            {
                let differs = self.corners[a.corners[0] as usize].site == self.corners[b.corners[0] as usize].site;
                neighbors[a.face as usize].push((b.face, differs));
                neighbors[b.face as usize].push((a.face, differs));
            }
        }
        let mut is_reversed: Vec<Option<bool>> = vec![None; self.ends.len()];
        let (mut count, mut turned, mut opposed, mut volume, mut right) = (0, 0, 0, 0.0, Vec::new());
        for first in 0..self.ends.len() {
            if is_reversed[first].is_some() {
                continue;
            }
            is_reversed[first] = Some(false);
            let (mut part, mut next, mut is_consistent) = (vec![first], 0, true);
            while let Some(&face) = part.get(next) {
                next += 1;
                for &(other, differs) in &neighbors[face] {
                    let wanted = is_reversed[face].map(|reversed| reversed != differs);
                    match is_reversed[other as usize] {
                        None => {
                            is_reversed[other as usize] = wanted;
                            part.push(other as usize);
                        }
                        found => is_consistent &= found == wanted,
                    }
                }
            }
            let reversed = part.iter().filter(|face| is_reversed[**face] == Some(true)).count();
            if !is_consistent {
                continue;
            }
            let mut fewer = 2 * reversed <= part.len();
            let place = |corner: usize| self.positions[self.corners[corner].site as usize];
            let origin = place(ranges[part[0]].start);
            // The sum over the part of what `of` is for a triangle of one of its faces.
            let sum = |of: &dyn Fn(usize, [DVec3; 3]) -> f64| -> f64 {
                let of_face = |face: &usize| {
                    let Range { start, end } = ranges[*face];
                    let fan = (start + 1..end).map(|at| [start, at - 1, at].map(|at| place(at) - origin));
                    let sum: f64 = fan.map(|triangle| of(*face, triangle)).sum();
                    if is_reversed[*face] == Some(true) { -sum } else { sum }
                };
                part.iter().map(of_face).sum()
            };
            let along_normals = |face: usize, [a, b, c]: [DVec3; 3]| {
                let normals = self.corners[ranges[face].clone()].iter().filter_map(|corner| self.normal(corner));
                (b - a).cross(c - a).dot(normals.sum())
            };
            let agreement = if has_normals { sum(&along_normals) } else { 0.0 };
            if agreement != 0.0 {
                fewer = agreement > 0.0;
            } else if !has_normals && !part.iter().any(|face| is_open[*face]) {
                let own = sum(&|_, [a, b, c]| a.dot(b.cross(c)));
                if reversed == 0 {
                    volume += own;
                    right.extend(&part);
                } else if own != 0.0 {
                    fewer = own > 0.0;
                }
            }
            for face in part.into_iter().filter(|face| is_reversed[*face] == Some(fewer)) {
                self.corners[ranges[face].clone()].reverse();
                *(if agreement == 0.0 { &mut count } else { &mut opposed }) += 1;
            }
        }
        if volume < 0.0 {
            turned = right.len();
            right.into_iter().for_each(|face: usize| self.corners[ranges[face].clone()].reverse());
        }
        [count, turned, opposed]
    }
}
