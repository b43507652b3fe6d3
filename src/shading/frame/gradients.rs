//! Slopes of the light at the vertices: from the lights of the surrounding vertices, or from the curvature of the mesh,
//! dI/dp = (∂I/∂N)·(dN/dp) + the light's own change, brought to the screen.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::projected::{Frame, FrameVertex};
use crate::light::names::named;

named! {
    /// How the slopes at the vertices, which *patch* needs, are computed.
    Gradients, GradientsError {
        /// The chain rule through the curvature of the mesh.
        Curvature = "curvature",
        /// A plane fitted to the lights of the surrounding vertices.
        Ring = "ring",
        /// A quadric fitted to the lights of the surrounding vertices.
        Quadric = "quadric",
    }
}

/// The slope of the light at a vertex: of red, green and blue, per pixel right and per pixel down.
pub type Gradient = [DVec2; 3];

/// The gradient at each of [`Frame::vertices`].
pub(super) fn of(frame: &Frame, gradients: Gradients) -> Vec<Gradient> {
    let ring = Ring::of(frame);
    let gradient = |v: usize| match gradients {
        Gradients::Ring => ring.plane(frame, v).solve(),
        Gradients::Quadric => quadric(frame, v, &ring).unwrap_or_else(|| ring.plane(frame, v).solve()),
        Gradients::Curvature => of_curvature(frame, v, &ring),
    };
    (0..frame.vertices.len()).into_par_iter().map(gradient).collect()
}

/// Weight of the ring relative to the chain rule's. Where the surface turns away by the angle θ, a step on it shortens
/// on the screen by cos θ, and the chain rule's weight along it by cos² θ: it carries less and less information, and
/// its slope grows without bound, unlike that of the image. Of 0 … 0.5, this gave the least error of light and slope
/// against spheres, tori and bumpy surfaces traced pixel by pixel; 0.05 and 0.1 are within a few percent of it.
const RING_WEIGHT: f64 = 0.07;

/// Step of the central differences, in radii of the mesh's bounding sphere.
const STEP: f64 = 1e-5;

/// Largest difference between a vertex's light and its lighting's at which the light is that of the lighting.
const SAME: f64 = 1e-9;

/// The gradient of vertex `v`.
fn of_curvature(frame: &Frame, v: usize, ring: &Ring) -> Gradient {
    let mut equations = ring.plane(frame, v);
    if equations.trace() > 0.0 && is_lit(frame, &frame.vertices[v]) {
        equations.scale(RING_WEIGHT / equations.trace());
        for (offset, light) in steps(frame, &frame.vertices[v]) {
            equations.add(offset, light, 1.0);
        }
    }
    equations.solve()
}

/// Whether the light of `vertex` is that of the frame's lighting.
fn is_lit(frame: &Frame, vertex: &FrameVertex) -> bool {
    let lit = frame.lit(vertex.eye, vertex.normal);
    // False for NaN.
    (lit - vertex.light).abs().max_element() <= SAME
}

/// Two steps on the surface: how far each goes on the screen, in units of a step seen face on, and by how much the
/// light changes.
fn steps(frame: &Frame, vertex: &FrameVertex) -> impl Iterator<Item = (DVec2, DVec3)> {
    let toward = frame.view.to_viewer(vertex.eye);
    let facing = vertex.normal.dot(toward);
    let (across, away) = tangents(vertex.normal, toward);
    // Pixels a radius, face on.
    let (here, _) = frame.view.project(vertex.eye);
    let sideways = toward.any_orthonormal_vector();
    let scale = (frame.view.project(vertex.eye + STEP * sideways).0 - here).length() / STEP;
    // A vertex that faces away has only the direction along the silhouette.
    [Some(across), (facing > 0.0).then_some(away)].into_iter().flatten().map(move |tangent| {
        let ahead = moved(frame, vertex, tangent * STEP);
        let behind = moved(frame, vertex, tangent * -STEP);
        ((ahead.0 - behind.0) / (2.0 * STEP * scale), (ahead.1 - behind.1) / (2.0 * STEP * scale))
    })
}

/// Unit tangents: across the line of sight, and the one that leads away from the eye.
fn tangents(normal: DVec3, toward: DVec3) -> (DVec3, DVec3) {
    let across = normal.cross(toward);
    let across = if across.length_squared() > 1e-12 { across.normalize() } else { normal.any_orthonormal_vector() };
    (across, normal.cross(across))
}

/// The position of the surface on the screen, and its light, a small step from a vertex.
fn moved(frame: &Frame, vertex: &FrameVertex, step: DVec3) -> (DVec2, DVec3) {
    let eye = vertex.eye + step;
    let normal = (vertex.normal + vertex.curvature * step).normalize_or(vertex.normal);
    (frame.view.project(eye).0, frame.lit(eye, normal))
}

/// For each vertex, the vertices that it shares a drawn triangle with, each once.
struct Ring(Vec<Vec<u32>>);

impl Ring {
    fn of(frame: &Frame) -> Ring {
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
    fn plane(&self, frame: &Frame, vertex: usize) -> Equations {
        let mut sum = Equations::default();
        for (offset, light) in self.differences(frame, vertex) {
            sum.add(offset, light, 1.0 / offset.length_squared());
        }
        sum
    }
}

/// Normal equations of a gradient, the same matrix for every channel.
#[derive(Clone, Copy, Debug, Default)]
struct Equations {
    /// Σ w·dx², Σ w·dx·dy, Σ w·dy².
    matrix: [f64; 3],
    /// Σ w·dI·(dx, dy) of each channel.
    right: [DVec2; 3],
}

/// Below this ratio of its eigenvalues, a matrix counts as having only one direction.
const FLAT: f64 = 1e-14;

impl Equations {
    /// One more: a step of `offset` changes the light by `light`.
    fn add(&mut self, offset: DVec2, light: DVec3, weight: f64) {
        let weighted = weight * offset;
        self.matrix[0] += weighted.x * offset.x;
        self.matrix[1] += weighted.x * offset.y;
        self.matrix[2] += weighted.y * offset.y;
        for (right, light) in self.right.iter_mut().zip(light.to_array()) {
            *right += weighted * light;
        }
    }

    /// All weights times `factor`.
    fn scale(&mut self, factor: f64) {
        self.matrix = self.matrix.map(|m| m * factor);
        self.right = self.right.map(|r| r * factor);
    }

    /// Σ w·d².
    fn trace(&self) -> f64 {
        self.matrix[0] + self.matrix[2]
    }

    /// The best-fitting gradient; without change along a direction about which nothing is known.
    fn solve(&self) -> Gradient {
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
fn quadric(frame: &Frame, vertex: usize, ring: &Ring) -> Option<Gradient> {
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
