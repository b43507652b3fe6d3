//! Gradients from the lights of the vertices around.

use glam::{DVec2, DVec3};

use super::clough_tocher::Gradient;
use crate::shading::frame::Frame;

/// For each vertex, the vertices that it shares a drawn triangle with, each once.
pub(super) struct Ring(Vec<Vec<u32>>);

impl Ring {
    pub fn of(frame: &Frame) -> Ring {
        let mut neighbors = vec![Vec::new(); frame.vertices.len()];
        for triangle in &frame.triangles {
            for k in 0..3 {
                let own: &mut Vec<u32> = &mut neighbors[triangle.vertices[k] as usize];
                for other in [triangle.vertices[(k + 1) % 3], triangle.vertices[(k + 2) % 3]] {
                    if !own.contains(&other) {
                        own.push(other);
                    }
                }
            }
        }
        Ring(neighbors)
    }

    /// Offset on the screen and difference in light of every neighbor of `vertex` that lies elsewhere.
    fn differences<'a>(&'a self, frame: &'a Frame, vertex: usize) -> impl Iterator<Item = (DVec2, DVec3)> + 'a {
        let own = &frame.vertices[vertex];
        self.0[vertex]
            .iter()
            .map(|other| &frame.vertices[*other as usize])
            .map(move |other| (other.screen - own.screen, other.light - own.light))
            .filter(|(offset, _)| offset.length_squared() > 0.0)
    }

    /// The equations of the plane through `vertex` that fits its neighbors best, weighted 1/d².
    pub fn plane(&self, frame: &Frame, vertex: usize) -> Equations {
        let mut sum = Equations::default();
        for (offset, light) in self.differences(frame, vertex) {
            sum.add(offset, light, 1.0 / offset.length_squared());
        }
        sum
    }
}

/// Normal equations of a gradient, the same matrix for every channel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Equations {
    /// Σ w·dx², Σ w·dx·dy, Σ w·dy².
    matrix: [f64; 3],
    /// Σ w·dI·(dx, dy) of each channel.
    right: [DVec2; 3],
}

/// Below this ratio of its eigenvalues a matrix has one direction only.
const FLAT: f64 = 1e-14;

impl Equations {
    /// One more: a step of `offset` changes the light by `light`.
    pub fn add(&mut self, offset: DVec2, light: DVec3, weight: f64) {
        let weighted = weight * offset;
        self.matrix[0] += weighted.x * offset.x;
        self.matrix[1] += weighted.x * offset.y;
        self.matrix[2] += weighted.y * offset.y;
        for (right, light) in self.right.iter_mut().zip(light.to_array()) {
            *right += weighted * light;
        }
    }

    /// All weights times `factor`.
    pub fn scale(&mut self, factor: f64) {
        self.matrix = self.matrix.map(|m| m * factor);
        self.right = self.right.map(|r| r * factor);
    }

    /// Σ w·d².
    pub fn trace(&self) -> f64 {
        self.matrix[0] + self.matrix[2]
    }

    /// The gradient that fits best; without change along a direction in which nothing is known.
    pub fn solve(&self) -> Gradient {
        let [xx, xy, yy] = self.matrix;
        let (determinant, trace) = (xx * yy - xy * xy, xx + yy);
        if determinant > FLAT * trace * trace {
            return self.right.map(|r| DVec2::new(yy * r.x - xy * r.y, xx * r.y - xy * r.x) / determinant);
        }
        // One direction: the matrix is trace·d·dᵀ, and so is its pseudo-inverse with 1/trace.
        if trace > 0.0 { self.right.map(|r| r / trace) } else { [DVec2::ZERO; 3] }
    }
}

/// Smallest pivot of the quadric's equations, relative to the largest, for which they settle it.
const UNSETTLED: f64 = 0.03;

/// The slope of the quadric through `vertex` that fits its neighbors best, weighted 1/d²; `None` where they do not settle
/// one.
pub(super) fn quadric(frame: &Frame, vertex: usize, ring: &Ring) -> Option<Gradient> {
    let steps: Vec<(DVec2, DVec3)> = ring.differences(frame, vertex).collect();
    if steps.len() < 5 {
        return None;
    }
    // In units of the ring's size the unknowns are of one size.
    let size = (steps.iter().map(|(offset, _)| offset.length_squared()).sum::<f64>() / steps.len() as f64).sqrt();
    // Five unknowns, then the three channels' right sides.
    let mut rows = [[0.0; 8]; 5];
    for (offset, light) in &steps {
        let (d, l) = (*offset / size, light.to_array());
        let terms = [d.x, d.y, d.x * d.x, d.x * d.y, d.y * d.y, l[0], l[1], l[2]];
        let weight = 1.0 / d.length_squared();
        for (row, term) in rows.iter_mut().zip(terms) {
            for (sum, other) in row.iter_mut().zip(terms) {
                *sum += weight * term * other;
            }
        }
    }
    let solved = eliminate(&mut rows)?;
    Some([0, 1, 2].map(|c| DVec2::new(solved[0][c], solved[1][c]) / size))
}

/// Gauss's elimination with pivots from the diagonal, as fits a symmetric positive matrix.
fn eliminate(rows: &mut [[f64; 8]; 5]) -> Option<[[f64; 3]; 5]> {
    let largest = (0..5).map(|i| rows[i][i]).fold(0.0, f64::max);
    for i in 0..5 {
        let pivot = rows[i][i];
        if pivot.is_nan() || pivot <= UNSETTLED * largest {
            return None;
        }
        let own = rows[i];
        for (j, row) in rows.iter_mut().enumerate() {
            if j != i {
                let factor = row[i] / pivot;
                for (value, own) in row.iter_mut().zip(own) {
                    *value -= factor * own;
                }
            }
        }
    }
    Some([0, 1, 2, 3, 4].map(|i| [5, 6, 7].map(|c| rows[i][c] / rows[i][i])))
}
