//! Gives neighboring faces the same winding.

use std::collections::HashMap;

use glam::DVec3;

use super::build::Polygons;

impl Polygons {
    /// Reverses faces so that the two faces at an edge go along it in opposite directions, and returns how many. In each
    /// connected part, these are the fewer, or those that face inward if the part is closed and no normal is given. Parts
    /// for which there is no such choice, as a Möbius strip, stay as they are; edges of one face or of more than two do
    /// not connect. If closed parts without such edges enclose a negative volume together, all of these are reversed; the
    /// second number counts their faces.
    pub fn unify_winding(&mut self, positions: &[DVec3]) -> [usize; 2] {
        let starts: Vec<usize> = std::iter::once(0).chain(self.ends.iter().copied()).collect();
        // The faces at each edge, and whether they go along it from the lower site to the higher.
        let mut edges: HashMap<[u32; 2], Vec<(u32, bool)>> = HashMap::with_capacity(self.sites.len());
        for face in 0..self.ends.len() {
            let sites = &self.sites[starts[face]..starts[face + 1]];
            for (i, from) in sites.iter().enumerate() {
                let to = sites[(i + 1) % sites.len()];
                if *from != to {
                    edges.entry([*from.min(&to), *from.max(&to)]).or_default().push((face as u32, *from < to));
                }
            }
        }
        let mut neighbors = vec![Vec::new(); self.ends.len()];
        let mut is_open = vec![false; self.ends.len()];
        for sides in edges.values() {
            if sides.len() != 2 {
                sides.iter().for_each(|(face, _)| is_open[*face as usize] = true);
            }
            if let [(a, forth), (b, back)] = sides[..]
                && a != b
            {
                neighbors[a as usize].push((b, forth == back));
                neighbors[b as usize].push((a, forth == back));
            }
        }
        let mut is_reversed: Vec<Option<bool>> = vec![None; self.ends.len()];
        let place = |site: &u32| positions.get(*site as usize).copied().unwrap_or_default();
        let (mut count, mut turned, mut volume, mut right) = (0, 0, 0.0, Vec::new());
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
            if !self.has_normals() && !part.iter().any(|face| is_open[*face]) {
                let origin = place(&self.sites[starts[part[0]]]);
                let of = |face: &usize| {
                    let sites = &self.sites[starts[*face]..starts[*face + 1]];
                    let fan = sites.windows(2).map(|pair| [sites[0], pair[0], pair[1]].map(|s| place(&s) - origin));
                    let sum: f64 = fan.map(|[a, b, c]| a.dot(b.cross(c))).sum();
                    if is_reversed[*face] == Some(true) { -sum } else { sum }
                };
                let own: f64 = part.iter().map(of).sum();
                if reversed == 0 {
                    volume += own;
                    right.extend(&part);
                } else if own != 0.0 {
                    fewer = own > 0.0;
                }
            }
            for face in part.into_iter().filter(|face| is_reversed[*face] == Some(fewer)) {
                self.reverse(starts[face]..starts[face + 1]);
                count += 1;
            }
        }
        if volume < 0.0 {
            turned = right.len();
            right.into_iter().for_each(|face: usize| self.reverse(starts[face]..starts[face + 1]));
        }
        [count, turned]
    }

    fn reverse(&mut self, corners: std::ops::Range<usize>) {
        self.sites[corners.clone()].reverse();
        self.normals.get_mut(corners.clone()).map(<[_]>::reverse);
        self.paint.get_mut(corners).map(<[_]>::reverse);
    }
}
