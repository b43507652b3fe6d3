//! Normals estimated from the triangles alone.

use glam::DVec3;
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::triangles::Mesh;
use crate::text::names::named;

named! {
    /// Where the normals at the vertices come from.
    Normals, UnknownNormals {
        /// The mesh's own normals.
        Given = "given",
        /// The mean of the unit normals of the faces around each vertex, Shoaff §4.1. Triangles in one plane count once.
        Averaged = "averaged",
        /// The mean in which a triangle's normal has the weight sin α / (|a||b|), where a and b are its sides at the
        /// vertex and α is the angle between them: exact for every mesh inscribed in a sphere. N. Max, J. Graphics
        /// Tools 4 (1999) 2.
        Max = "max",
        /// The slope of a cubic fitted to the neighbors' positions and normals.
        Cubic = "cubic",
        /// The mean in which a triangle's normal has its angle at the vertex as its weight; where the vertices sample a
        /// smooth surface, the cubic's slope at every vertex where its fit is sure. This is the default for meshes
        /// without normals.
        Best = "best",
    }
}

/// The number of times that the cubics are fitted: first to weighted means, then to the result.
const PASSES: usize = 2;

/// The largest standard error of a cubic's slope, in radians, at which it counts in [`Normals::Best`].
const SURE: f64 = 4.0 * DEGREE;

/// The largest median of these errors over the vertices at which the mesh samples a smooth surface. Decimated scans have
/// lost the detail between their vertices, and cubics through them swing.
const SMOOTH: f64 = 1.25 * DEGREE;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// The number of vertices from which the median is taken.
const SAMPLE: usize = 2000;

/// The weights of the triangles around a vertex.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Weights {
    /// Each plane once.
    Planes,
    Max,
    Angles,
}

impl Mesh {
    /// Returns this mesh with normals from `normals`. Vertices that are split at a crease stay split, and only the
    /// triangles on its side count for each.
    #[must_use]
    pub fn estimated(mut self, normals: Normals) -> Mesh {
        if normals == Normals::Given {
            return self;
        }
        let means = self.means(match normals {
            Normals::Averaged => Weights::Planes,
            Normals::Best => Weights::Angles,
            _ => Weights::Max,
        });
        for (vertex, mean) in self.vertices.iter_mut().zip(means) {
            vertex.normal = mean.normalize_or(vertex.normal);
        }
        let most = match normals {
            Normals::Cubic => f64::INFINITY,
            Normals::Best => SURE,
            _ => return self,
        };
        let rings = self.rings();
        if normals == Normals::Best && self.uncertainty(&rings) > SMOOTH {
            return self;
        }
        let start: Vec<DVec3> = self.vertices.iter().map(|vertex| vertex.normal).collect();
        for _ in 0..PASSES {
            let fits: Vec<Option<Fit>> = (0..rings.len()).into_par_iter().map(|v| self.fitted(v, &rings[v])).collect();
            for ((vertex, fit), start) in self.vertices.iter_mut().zip(fits).zip(&start) {
                let sure = fit.filter(|fit| normals == Normals::Cubic || fit.error < most);
                let otherwise = if normals == Normals::Cubic { vertex.normal } else { *start };
                vertex.normal = sure.map_or(otherwise, |fit| fit.normal);
            }
        }
        self
    }

    /// Returns the median standard error of the cubics' slopes over a sample of the vertices; infinite without cubics.
    fn uncertainty(&self, rings: &[Vec<u32>]) -> f64 {
        let step = rings.len().div_ceil(SAMPLE).max(1);
        let sample = (0..rings.len()).into_par_iter().step_by(step);
        let mut errors: Vec<f64> = sample.filter_map(|v| Some(self.fitted(v, &rings[v])?.error)).collect();
        let middle = errors.len() / 2;
        if errors.is_empty() { f64::INFINITY } else { *errors.select_nth_unstable_by(middle, f64::total_cmp).1 }
    }

    /// Returns the weighted sum of the normals of the triangles at each vertex.
    fn means(&self, weights: Weights) -> Vec<DVec3> {
        let is_unweighted = weights == Weights::Planes;
        let mut sums = vec![DVec3::ZERO; self.vertices.len()];
        let mut counted: Vec<Vec<DVec3>> = vec![Vec::new(); if is_unweighted { sums.len() } else { 0 }];
        for (t, corners) in self.triangles.iter().enumerate() {
            let places = self.corners(t);
            for (k, v) in corners.iter().enumerate() {
                let (a, b) = (places[(k + 1) % 3] - places[k], places[(k + 2) % 3] - places[k]);
                let normal = a.cross(b);
                if weights == Weights::Angles {
                    let angle = normal.length().atan2(a.dot(b));
                    sums[*v as usize] += normal.normalize_or_zero() * angle;
                    continue;
                }
                if !is_unweighted {
                    // |a × b| = |a||b| sin α.
                    let weighted = normal / (a.length_squared() * b.length_squared());
                    sums[*v as usize] += if weighted.is_finite() { weighted } else { DVec3::ZERO };
                    continue;
                }
                let (unit, planes) = (normal.normalize_or_zero(), &mut counted[*v as usize]);
                if planes.iter().all(|known| known.dot(unit) < 1.0 - 1e-9) {
                    planes.push(unit);
                    sums[*v as usize] += unit;
                }
            }
        }
        sums
    }

    /// Returns the other vertices of the triangles at each vertex, each once.
    fn rings(&self) -> Vec<Vec<u32>> {
        let mut rings: Vec<Vec<u32>> = vec![Vec::new(); self.vertices.len()];
        for corners in &self.triangles {
            for k in 0..3 {
                let ring = &mut rings[corners[k] as usize];
                for other in [corners[(k + 1) % 3], corners[(k + 2) % 3]] {
                    if !ring.contains(&other) {
                        ring.push(other);
                    }
                }
            }
        }
        rings
    }

    /// Returns the normal at vertex `v` of the surface z = g₁x + g₂y + a cubic polynomial without a constant, over the
    /// plane through the vertex perpendicular to its normal. The polynomial is fitted to the positions of the vertices
    /// of `ring`, with weights 1/d³, and to the slopes that their normals give there, with weights 1/d²; d is the
    /// distance in the plane. `None` if the ring does not determine it.
    ///
    /// J. Goldfeather & V. Interrante, *A novel cubic-order algorithm for approximating principal direction vectors*,
    /// ACM Trans. Graph. 23 (2004) 45, fit the same polynomial without the linear terms, because they trust the normal.
    fn fitted(&self, v: usize, ring: &[u32]) -> Option<Fit> {
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
        let (mut squares, mut used) = (0.0, 0);
        for (step, normal) in steps().filter(|(_, normal)| normal.z > MIN_FACING) {
            used += 1;
            let DVec3 { x, y, z } = step / size;
            let slope = -normal.truncate() / normal.z;
            let d = x.hypot(y);
            let rows = [
                ([x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y], z, d.powi(-3)),
                ([1.0, 0.0, 2.0 * x, y, 0.0, 3.0 * x * x, 2.0 * x * y, y * y, 0.0], slope.x, d.powi(-2)),
                ([0.0, 1.0, 0.0, x, 2.0 * y, 0.0, x * x, 2.0 * x * y, 3.0 * y * y], slope.y, d.powi(-2)),
            ];
            for (row, value, weight) in rows {
                let row = SVector::from(row) * weight;
                matrix += row * row.transpose();
                right_side += row * (value * weight);
                squares += (value * weight).powi(2);
            }
        }
        let cholesky = matrix.cholesky()?;
        let solved = cholesky.solve(&right_side);
        let normal = own.normal - right * solved[0] - up * solved[1];
        // The residual variance times the inverse of the matrix is the covariance of the terms.
        let freedom = (3 * used - TERMS as i32).max(0);
        let variance = (squares - solved.dot(&right_side)).max(0.0) / f64::from(freedom);
        let of_slopes = [0, 1].map(|k| cholesky.solve(&SVector::<f64, TERMS>::ith(k, 1.0))[k]);
        let error = (variance * (of_slopes[0] + of_slopes[1])).sqrt();
        normal
            .is_finite()
            .then(|| Fit { normal: normal.normalize(), error: if error.is_nan() { f64::INFINITY } else { error } })
    }
}

/// The normal from a fitted polynomial.
struct Fit {
    normal: DVec3,
    /// The standard error of its slope.
    error: f64,
}

/// The fewest neighbors to which a polynomial is fitted.
const MIN_RING: usize = 4;

/// The number of terms of the polynomial.
const TERMS: usize = 9;

/// The smallest cosine between a neighbor's normal and the vertex's at which its slope counts.
const MIN_FACING: f64 = 0.2;
