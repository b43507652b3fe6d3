//! Finds the first triangle on a line of sight that does not come straight from the eye.

use glam::DVec3;

/// A triangle that rays can meet.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// The body that it belongs to, and its index in the body's mesh.
    pub of: (u32, u32),
    /// Its corners.
    pub corners: [DVec3; 3],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The body and the triangle.
    pub of: (u32, u32),
    /// The distance along the ray, in lengths of its direction.
    pub distance: f64,
    /// The weights of the corners.
    pub weights: [f64; 3],
}

/// Triangles in a tree of boxes.
#[derive(Clone, Debug)]
pub struct Targets {
    targets: Vec<Target>,
    boxes: Vec<Box>,
}

/// A box around the targets from `first` to `end`; all of them follow each other.
#[derive(Clone, Copy, Debug)]
struct Box {
    low: DVec3,
    high: DVec3,
    first: u32,
    end: u32,
    /// The box after this one and everything inside it.
    next: u32,
}

/// The number of targets that a box need not divide.
const FEW: usize = 4;

impl Targets {
    /// Builds the tree.
    pub fn new(mut targets: Vec<Target>) -> Targets {
        let mut boxes = Vec::new();
        let end = targets.len();
        divide(&mut targets, 0, end, &mut boxes);
        Targets { targets, boxes }
    }

    /// Returns the first triangle that the ray meets farther away than `after`, and where it meets other bodies at the same
    /// place, within `reach`: one triangle of each body, the nearest first. Both sides of a triangle count.
    pub fn first(&self, from: DVec3, along: DVec3, after: f64, reach: f64) -> Vec<Meeting> {
        let (mut met, mut most, mut at) = (Vec::<Meeting>::new(), f64::INFINITY, 0);
        let inverse = along.recip();
        while let Some(Box { low, high, first, end, next }) = self.boxes.get(at).copied() {
            let (a, b) = ((low - from) * inverse, (high - from) * inverse);
            let (enters, leaves) = (a.min(b).max_element(), a.max(b).min_element());
            if leaves < enters.max(after) || most < enters {
                at = next as usize;
                continue;
            }
            at += 1;
            for target in &self.targets[first as usize..end as usize] {
                if let Some(found) = target.meet(from, along, after)
                    && found.distance <= most
                {
                    most = most.min(found.distance + reach);
                    met.push(found);
                }
            }
        }
        met.retain(|found| found.distance <= most);
        met.sort_by(|a, b| a.of.0.cmp(&b.of.0).then(a.distance.total_cmp(&b.distance)));
        met.dedup_by_key(|found| found.of.0);
        met.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        met
    }
}

/// Adds the boxes of the targets from `first` to `end`, divided at the median along the longest side.
fn divide(targets: &mut [Target], first: usize, end: usize, boxes: &mut Vec<Box>) {
    let corners = || targets[first..end].iter().flat_map(|target| target.corners);
    let (low, high) = corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let (own, is_few) = (boxes.len(), end - first <= FEW);
    // A box that is divided has no targets of its own.
    boxes.push(Box { low, high, first: first as u32, end: if is_few { end } else { first } as u32, next: 0 });
    if !is_few {
        let side = (high - low).max_position();
        let middle = (end - first) / 2;
        let center = |target: &Target| target.corners.iter().map(|p| p[side]).sum::<f64>();
        targets[first..end].select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)));
        divide(targets, first, first + middle, boxes);
        divide(targets, first + middle, end, boxes);
    }
    boxes[own].next = boxes.len() as u32;
}

/// Rounding errors of the weights: a ray through an edge meets at least one of its triangles.
const ROUNDING: f64 = 1e-12;

impl Target {
    fn meet(&self, from: DVec3, along: DVec3, after: f64) -> Option<Meeting> {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        let distance = (a - from).dot(normal) / along.dot(normal);
        let point = from + along * distance;
        let share = |p: DVec3, q: DVec3| (q - p).cross(point - p).dot(normal) / normal.length_squared();
        let weights = [share(b, c), share(c, a), share(a, b)];
        // The conditions are false for NaN.
        let is_met = distance > after && distance.is_finite() && weights.iter().all(|w| *w >= -ROUNDING);
        is_met.then_some(Meeting { of: self.of, distance, weights })
    }
}
