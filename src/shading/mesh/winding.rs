//! Gives neighboring faces the same winding.

use std::collections::HashMap;

use super::build::Polygons;

impl Polygons {
    /// Reverses faces so that the two faces at an edge go along it in opposite directions, and returns how many. In each
    /// connected part, these are the fewer. Parts for which there is no such choice, as a Möbius strip, stay as they are;
    /// edges of one face or of more than two do not connect.
    pub fn unify_winding(&mut self) -> usize {
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
        for sides in edges.values() {
            if let [(a, forth), (b, back)] = sides[..]
                && a != b
            {
                neighbors[a as usize].push((b, forth == back));
                neighbors[b as usize].push((a, forth == back));
            }
        }
        let mut is_reversed: Vec<Option<bool>> = vec![None; self.ends.len()];
        let mut count = 0;
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
            let fewer = 2 * reversed <= part.len();
            for face in part.into_iter().filter(|face| is_reversed[*face] == Some(fewer)) {
                self.reverse(starts[face]..starts[face + 1]);
                count += 1;
            }
        }
        count
    }

    fn reverse(&mut self, corners: std::ops::Range<usize>) {
        self.sites[corners.clone()].reverse();
        self.normals.get_mut(corners.clone()).map(<[_]>::reverse);
        self.paint.get_mut(corners).map(<[_]>::reverse);
    }
}
