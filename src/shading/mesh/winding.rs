//! Gives neighboring faces the same winding.

use glam::DVec3;

use super::build::Polygons;

impl Polygons {
    /// Reverses faces so that the two faces at an edge go along it in opposite directions, and returns how many. In each
    /// connected part, these are the fewer, or those that face inward if the part is closed and no normal is given. Parts
    /// for which there is no such choice, as a Möbius strip, stay as they are; edges of one face or of more than two do
    /// not connect. If closed parts without such edges enclose a negative volume together, all of these are reversed; the
    /// second number counts their faces. A part with given normals faces to their side; the third number counts the faces
    /// that are reversed for it.
    pub fn unify_winding(&mut self, positions: &[DVec3]) -> [usize; 3] {
        let (corners, has_normals) = (self.corners(), self.has_normals());
        let mut neighbors = vec![Vec::new(); self.ends.len()];
        let mut is_open = vec![false; self.ends.len()];
        for sides in self.sides().chunk_by(|a, b| a.0 == b.0) {
            if sides.len() != 2 {
                sides.iter().for_each(|(_, face, _)| is_open[*face as usize] = true);
            }
            if let [(_, a, forth), (_, b, back)] = sides[..]
                && a != b
            {
                neighbors[a as usize].push((b, forth == back));
                neighbors[b as usize].push((a, forth == back));
            }
        }
        let mut is_reversed: Vec<Option<bool>> = vec![None; self.ends.len()];
        let place = |site: &u32| positions.get(*site as usize).copied().unwrap_or_default();
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
            let origin = place(&self.sites[corners[part[0]].start]);
            // The sum over the part of what `of` is for a triangle of one of its faces.
            let sum = |of: &dyn Fn(usize, [DVec3; 3]) -> f64| -> f64 {
                let of_face = |face: &usize| {
                    let sites = &self.sites[corners[*face].clone()];
                    let fan = sites.windows(2).map(|pair| [sites[0], pair[0], pair[1]].map(|s| place(&s) - origin));
                    let sum: f64 = fan.map(|triangle| of(*face, triangle)).sum();
                    if is_reversed[*face] == Some(true) { -sum } else { sum }
                };
                part.iter().map(of_face).sum()
            };
            let along_normals = |face: usize, [a, b, c]: [DVec3; 3]| {
                let normals = self.normals.get(corners[face].clone()).into_iter().flatten().flatten();
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
                self.reverse(corners[face].clone());
                *(if agreement == 0.0 { &mut count } else { &mut opposed }) += 1;
            }
        }
        if volume < 0.0 {
            turned = right.len();
            right.into_iter().for_each(|face: usize| self.reverse(corners[face].clone()));
        }
        [count, turned, opposed]
    }

    fn reverse(&mut self, corners: std::ops::Range<usize>) {
        self.sites[corners.clone()].reverse();
        self.normals.get_mut(corners.clone()).map(<[_]>::reverse);
        self.paint.get_mut(corners).map(<[_]>::reverse);
    }
}
