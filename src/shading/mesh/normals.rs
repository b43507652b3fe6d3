//! Normals of faces and of vertices, also estimated from the triangles alone.

use glam::DVec3;
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::triangles::Mesh;
use crate::{shading::cubic, text::names::named};

/// Returns Newell's normal of a polygon: it has unit length, and the polygon is counterclockwise as seen from its tip;
/// zero for a polygon without area. Shoaff §3.5. For corners that are not in one plane, it is the normal of the plane
/// that fits them best.
///
/// The corners are taken relative to the first corner and to the polygon's size because the sums as printed lose
/// precision far from the origin.
pub fn newell(corners: &[DVec3]) -> DVec3 {
    let Some(&origin) = corners.first() else { return DVec3::ZERO };
    let size = corners.iter().map(|p| (*p - origin).abs().max_element()).fold(0.0, f64::max);
    if !(size > 0.0 && size.is_finite()) {
        return DVec3::ZERO;
    }
    let at = |i: usize| (corners[i] - origin) / size;
    let mut sum = DVec3::ZERO;
    for i in 0..corners.len() {
        let (p, q) = (at(i), at(if i + 1 == corners.len() { 0 } else { i + 1 }));
        sum += DVec3::new((p.y - q.y) * (p.z + q.z), (p.z - q.z) * (p.x + q.x), (p.x - q.x) * (p.y + q.y));
    }
    // Anything smaller is rounding error.
    if sum.length() > 1e-14 { sum.normalize() } else { DVec3::ZERO }
}

named! {
    /// Where the normals at the vertices come from.
    Normals, UnknownNormals {
        /// The mesh's own normals.
        Given = "given",
        /// The mean of the unit normals of the faces around each vertex, Shoaff §4.1. Triangles in one plane count once.
        Averaged = "averaged",
        /// Between the mean in which a triangle's normal has its area as its weight, and the slope of a cubic that is fitted
        /// to the neighbors' positions and normals, which counts as far as it fits. The default for meshes without normals.
        Best = "best",
    }
}

/// The number of times that the cubics are fitted: first to weighted means, then to the result.
const PASSES: usize = 2;

/// In [`Normals::Best`], a cubic counts by T²/(T² + e²), where e is the root mean square by which its slope misses the
/// neighbors'. On decimated meshes, whose detail between the vertices is gone, cubics swing and e is large. From 3° to 5°,
/// the results hardly differ (`scripts/shading_table.py`).
const TOLERANCE: f64 = 4.0 * std::f64::consts::PI / 180.0;

impl Mesh {
    /// Returns this mesh with normals from `normals`. Vertices that are split at a crease stay split, and only the
    /// triangles on its side count for each.
    pub fn estimated(mut self, normals: Normals) -> Mesh {
        if normals == Normals::Given {
            return self;
        }
        let means = match normals {
            Normals::Averaged => self.means_of_planes(),
            _ => self.means(|a, b| a.cross(b).normalize_or_zero() * a.cross(b).length().atan2(a.dot(b))),
        };
        for (vertex, mean) in self.vertices.iter_mut().zip(means) {
            vertex.normal = mean.normalize_or(vertex.normal);
        }
        if normals == Normals::Averaged {
            return self;
        }
        let rings = cubic::around(self.vertices.len(), self.triangles.iter().map(|corners| (*corners, *corners)));
        let areas = self.means(DVec3::cross);
        for _ in 0..PASSES {
            let fits: Vec<Option<(DVec3, f64)>> =
                rings.par_iter().enumerate().map(|(v, ring)| self.fitted(v, ring)).collect();
            for ((vertex, fit), area) in self.vertices.iter_mut().zip(fits).zip(&areas) {
                let mean = area.normalize_or(vertex.normal);
                let (cubic, share) = fit
                    .map_or((mean, 0.0), |(normal, missed)| (normal, TOLERANCE.powi(2) / (TOLERANCE.powi(2) + missed)));
                vertex.normal = (share * cubic + (1.0 - share) * mean).normalize_or(mean);
            }
        }
        self
    }

    /// Returns the sum of the weighted normals of the triangles at each vertex; `weighted` gets the two sides there.
    fn means(&self, weighted: impl Fn(DVec3, DVec3) -> DVec3) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.vertices.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            let places = self.corners(t);
            for (k, v) in corners.iter().enumerate() {
                let normal = weighted(places[(k + 1) % 3] - places[k], places[(k + 2) % 3] - places[k]);
                sums[*v as usize] += if normal.is_finite() { normal } else { DVec3::ZERO };
            }
        }
        sums
    }

    /// Returns the sum of the unit normals of the triangles at each vertex, each plane once.
    fn means_of_planes(&self) -> Vec<DVec3> {
        let mut planes: Vec<Vec<DVec3>> = vec![Vec::new(); self.vertices.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            let [a, b, c] = self.corners(t);
            let unit = (b - a).cross(c - a).normalize_or_zero();
            for v in corners {
                let known = &mut planes[*v as usize];
                if known.iter().all(|known| known.dot(unit) < 1.0 - 1e-9) {
                    known.push(unit);
                }
            }
        }
        planes.into_iter().map(|planes| planes.into_iter().sum()).collect()
    }

    /// Returns the normal at vertex `v` of the surface z = g₁x + g₂y + a cubic polynomial without a constant, over the
    /// plane through the vertex perpendicular to its normal. The polynomial is fitted to the positions of the vertices
    /// of `ring`, with weights 1/d³, and to the slopes that their normals give there, with weights 1/d²; d is the
    /// distance in the plane. Also returns the mean square by which its slope misses those of the neighbors. `None` if the
    /// ring does not determine it.
    ///
    /// J. Goldfeather & V. Interrante, *A novel cubic-order algorithm for approximating principal direction vectors*,
    /// ACM Trans. Graph. 23 (2004) 45, fit the same polynomial without the linear terms, because they trust the normal.
    fn fitted(&self, v: usize, ring: &[u32]) -> Option<(DVec3, f64)> {
        if ring.len() < MIN_RING {
            return None;
        }
        let own = &self.vertices[v];
        let (right, up) = own.normal.any_orthonormal_pair();
        let in_plane = |p: DVec3| DVec3::new(p.dot(right), p.dot(up), p.dot(own.normal));
        let steps = || {
            let others = ring.iter().map(|other| &self.vertices[*other as usize]);
            others.map(|other| (in_plane(other.position - own.position), in_plane(other.normal)))
        };
        let size = (steps().map(|(step, _)| step.truncate().length_squared()).sum::<f64>() / ring.len() as f64).sqrt();
        let mut matrix = SMatrix::<f64, TERMS, TERMS>::zeros();
        let mut right_side = SVector::<f64, TERMS>::zeros();
        let mut slopes = Vec::with_capacity(ring.len());
        for (step, normal) in steps().filter(|(_, normal)| normal.z > MIN_FACING) {
            let DVec3 { x, y, z } = step / size;
            let slope = -normal.truncate() / normal.z;
            let d = x.hypot(y);
            let rows = [
                ([x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y], z, d.powi(-3)),
                ([1.0, 0.0, 2.0 * x, y, 0.0, 3.0 * x * x, 2.0 * x * y, y * y, 0.0], slope.x, d.powi(-2)),
                ([0.0, 1.0, 0.0, x, 2.0 * y, 0.0, x * x, 2.0 * x * y, 3.0 * y * y], slope.y, d.powi(-2)),
            ];
            slopes.extend([1, 2].map(|k| (SVector::from(rows[k].0), rows[k].1)));
            for (row, value, weight) in rows {
                let row = SVector::from(row) * weight;
                matrix += row * row.transpose();
                right_side += row * (value * weight);
            }
        }
        let solved = matrix.cholesky()?.solve(&right_side);
        let normal = own.normal - right * solved[0] - up * solved[1];
        let missed: f64 = slopes.iter().map(|(row, slope)| (solved.dot(row) - slope).powi(2)).sum();
        let missed = 2.0 * missed / slopes.len() as f64;
        (normal.is_finite() && missed.is_finite()).then(|| (normal.normalize(), missed))
    }
}

/// The fewest neighbors to which a polynomial is fitted.
const MIN_RING: usize = 4;

/// The number of terms of the polynomial.
const TERMS: usize = 9;

/// The smallest cosine between a neighbor's normal and the vertex's at which its slope counts.
const MIN_FACING: f64 = 0.2;
