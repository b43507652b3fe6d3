//! Polygons into triangles.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};

use super::normals;

/// The triangles of a polygon, as indices into its corners, in its own winding: always two fewer than it
/// has corners, none for fewer than three corners. A convex polygon becomes a fan around its first corner; a concave
/// one is cut ear by ear on its Newell plane, in time quadratic in its corners; one that crosses itself or has no
/// area becomes a fan where no ear is left.
#[must_use]
pub fn triangulated(corners: &[DVec3]) -> Vec<[u32; 3]> {
    let count = corners.len();
    if count < 4 {
        return if count == 3 { vec![[0, 1, 2]] } else { Vec::new() };
    }
    let flat = flattened(corners);
    let convex = (0..count).all(|i| turn(flat[i], flat[(i + 1) % count], flat[(i + 2) % count]) > FLAT)
        // A star turns one way only too, but more than once.
        && (1..count - 1).all(|i| turn(flat[0], flat[i], flat[i + 1]) > FLAT);
    if convex { fan(&(0..count as u32).collect::<Vec<_>>()) } else { ears(&flat) }
}

/// Twice the area, as a part of the polygon's extent squared, below which three corners are in a line.
const FLAT: f64 = 1e-12;

/// The corners on the Newell plane, counter-clockwise and within −1…1; all zero without one.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    let normal = normals::newell(corners);
    if normal == DVec3::ZERO {
        return vec![DVec2::ZERO; corners.len()];
    }
    let (x, y) = normal.any_orthonormal_pair();
    // any_orthonormal_pair is right-handed: x × y = normal.
    let flat: Vec<DVec2> = corners.iter().map(|p| *p - corners[0]).map(|p| DVec2::new(p.dot(x), p.dot(y))).collect();
    let size = flat.iter().map(|p| p.abs().max_element()).fold(f64::MIN_POSITIVE, f64::max);
    flat.iter().map(|p| *p / size).collect()
}

/// Twice the area of a triangle, positive counter-clockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn fan(ring: &[u32]) -> Vec<[u32; 3]> {
    (1..ring.len() - 1).map(|i| [ring[0], ring[i], ring[i + 1]]).collect()
}

/// Cuts off corners that hold no other corner, until three are left or none can be cut.
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
        // Mostly it is one of these that has become an ear.
        waiting.push_back(a);
        waiting.push_back(b);
    }
    let first = (0..count).find(|i| !is_cut[*i]).unwrap_or(0);
    let ring: Vec<u32> = std::iter::successors(Some(first), |i| Some(after[*i])).take(left).map(|i| i as u32).collect();
    triangles.extend(fan(&ring));
    triangles
}

/// Whether corner `at` turns to the left, and no other corner that is left lies in its triangle.
fn is_ear(flat: &[DVec2], before: &[usize], after: &[usize], at: usize) -> bool {
    let [a, b, c] = [before[at], at, after[at]].map(|i| flat[i]);
    if turn(a, b, c) <= FLAT {
        return false;
    }
    let mut other = after[after[at]];
    while other != before[at] {
        let p = flat[other];
        // A corner at the same place as one of these three is a pinch, not an obstacle.
        if p != a && p != b && p != c && turn(a, b, p) >= -FLAT && turn(b, c, p) >= -FLAT && turn(c, a, p) >= -FLAT {
            return false;
        }
        other = after[other];
    }
    true
}
