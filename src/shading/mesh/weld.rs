//! Joins open edges that lie in the same place.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec3;

use super::build::Polygons;

/// Positions on open edges are joined if they differ by no more than this share of the shortest open edge at them, or of
/// the median one if that is shorter. Programs that compute a position once for each side of a seam round it differently.
const SAME: f64 = 1e-3;

/// Open edges whose ends differ by no more than this share are reported.
const NEAR: f64 = 0.05;

/// What was found along the open edges of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seams {
    /// The number of positions that were joined with another one.
    pub joined: usize,
    /// The number of edges that are still open and run beside another open edge.
    pub beside: usize,
}

impl Polygons {
    /// Joins positions on open edges that are almost the same, and counts open edges that run beside others.
    pub fn weld(&mut self, positions: &[DVec3]) -> Seams {
        let open = self.open_edges();
        let length = |[a, b]: &[u32; 2]| positions[*a as usize].distance(positions[*b as usize]);
        let mut lengths: Vec<f64> = open.iter().map(length).filter(|length| *length > 0.0).collect();
        if lengths.is_empty() {
            return Seams::default();
        }
        let middle = lengths.len() / 2;
        let size = *lengths.select_nth_unstable_by(middle, f64::total_cmp).1;
        if !size.is_finite() {
            return Seams::default();
        }
        let mut joined: HashMap<u32, u32> = HashMap::new();
        for (site, others) in near(&open, positions, SAME, size) {
            // The ends of one edge are never joined.
            let is_end = |other: &u32| open.contains(&[site.min(*other), site.max(*other)]);
            if let Some(first) = others.into_iter().find(|other| *other < site && !is_end(other)) {
                joined.insert(site, *joined.get(&first).unwrap_or(&first));
            }
        }
        for site in &mut self.sites {
            *site = *joined.get(site).unwrap_or(site);
        }
        let open = if joined.is_empty() { open } else { self.open_edges() };
        let beside: HashMap<u32, Vec<u32>> = near(&open, positions, NEAR, size).into_iter().collect();
        let is_beside = |[a, b]: &&[u32; 2]| {
            let pairs = beside[a].iter().flat_map(|c| beside[b].iter().map(move |d| [*c.min(d), *c.max(d)]));
            pairs
                .into_iter()
                .any(|edge| edge != [*a, *b] && !edge.contains(a) && !edge.contains(b) && open.contains(&edge))
        };
        Seams { joined: joined.len(), beside: open.iter().filter(is_beside).count() }
    }

    /// Returns the edges of only one face, each with its lower site first.
    fn open_edges(&self) -> BTreeSet<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(self.sites.len());
        let mut start = 0;
        for end in &self.ends {
            let sites = &self.sites[start..*end];
            let around = sites.iter().zip(sites.iter().cycle().skip(1));
            edges.extend(around.filter(|(a, b)| a != b).map(|(a, b)| [*a.min(b), *a.max(b)]));
            start = *end;
        }
        edges.sort_unstable();
        edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect()
    }
}

/// Returns each site of these edges in ascending order, with the other ones within `share` of the shortest edge at both, or
/// of `size` if that is shorter.
fn near(edges: &BTreeSet<[u32; 2]>, positions: &[DVec3], share: f64, size: f64) -> Vec<(u32, Vec<u32>)> {
    let place = |site: u32| positions[site as usize];
    let mut reach: BTreeMap<u32, f64> = BTreeMap::new();
    for [a, b] in edges {
        let most = share * place(*a).distance(place(*b)).min(size);
        for site in [a, b] {
            reach.entry(*site).and_modify(|reach| *reach = reach.min(most)).or_insert(most);
        }
    }
    // Boxes of the longest reach: all that are near lie in the same box or in one of its neighbors.
    let cell = |site: u32| (place(site) / (share * size)).floor();
    let key = |cell: DVec3| cell.to_array().map(|x| (x + 0.0).to_bits());
    let mut boxes: HashMap<[u64; 3], Vec<u32>> = HashMap::with_capacity(reach.len());
    for site in reach.keys() {
        boxes.entry(key(cell(*site))).or_default().push(*site);
    }
    let steps = (0..27).map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)) - 1.0);
    let around = |(site, most): (&u32, &f64)| {
        let is_near = |other: &&u32| *other != site && place(**other).distance(place(*site)) <= most.min(reach[*other]);
        let others = steps.clone().filter_map(|step| boxes.get(&key(cell(*site) + step)));
        let mut found: Vec<u32> = others.flatten().filter(is_near).copied().collect();
        found.sort_unstable();
        found.dedup();
        (*site, found)
    };
    reach.iter().map(around).collect()
}
