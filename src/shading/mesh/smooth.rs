//! The smooth surfaces that meshes approximate: their normals, and where a line of sight meets them.

use glam::{DVec2, DVec3};

/// The radius of the torus's tube; its center line has the radius 1.
pub(super) const TUBE: f64 = 0.4;

/// Half the height of the cylinders; their radius is 1.
pub(super) const HALF_HEIGHT: f64 = 1.2;

/// The radius of the rounding between the side of the filleted cylinder and its caps.
pub(super) const FILLET: f64 = 0.25;

/// A surface that is known exactly, in the axes and units of its meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Smooth {
    /// The unit sphere.
    Sphere,
    /// Around the z axis, with radius 1 and a tube of radius 0.4.
    Torus,
    /// A closed surface with hollows and no symmetry.
    Blob,
    /// Hills over the square −1…1 × −1…1; z points up.
    Terrain,
    /// A cylinder around the z axis whose caps meet the side in a rounding of this radius, 0…1.
    Cylinder {
        /// The radius of the rounding.
        fillet: f64,
    },
}

/// The shortest step of a line of sight; features that are thinner are missed.
const MIN_STEP: f64 = 1e-5;

/// The number of times that the interval around a crossing is halved: the result is exact to rounding.
const HALVINGS: usize = 60;

impl Smooth {
    /// Returns the unit normal at a point of the surface, pointing outward or up.
    pub fn normal(self, p: DVec3) -> DVec3 {
        let normal = match self {
            Smooth::Sphere => p,
            Smooth::Torus => p - DVec3::new(p.x, p.y, 0.0).normalize_or_zero(),
            // The surface lies at the distance r(u) in the direction u. Its normal is along u − ∇r/r, where ∇r is the
            // part of the slope that is perpendicular to u.
            Smooth::Blob => {
                let out = p.normalize_or(DVec3::Z);
                let (radius, slope) = blob_radius(out);
                out - (slope - out * slope.dot(out)) / radius
            }
            Smooth::Terrain => {
                let (_, slope) = terrain_height(p.truncate());
                DVec3::new(-slope.x, -slope.y, 1.0)
            }
            Smooth::Cylinder { fillet } => {
                let out = p.truncate().normalize_or_zero();
                let [side, cap] = beyond_core(p, fillet);
                let up = p.z.signum();
                match (side > 0.0, cap > 0.0) {
                    (true, true) => (side * out).extend(cap * up),
                    _ if side > cap => out.extend(0.0),
                    _ => DVec3::new(0.0, 0.0, up),
                }
            }
        };
        normal.normalize_or(DVec3::Z)
    }

    /// Returns a number that is positive outside the surface or above it and negative on the other side. Its size is
    /// at most the distance to the surface.
    fn outside(self, p: DVec3) -> f64 {
        match self {
            Smooth::Sphere => p.length() - 1.0,
            Smooth::Torus => DVec2::new(p.truncate().length() - 1.0, p.z).length() - TUBE,
            // The slope of r is at most 0.97 per radian, and the surface is more than half a unit from the center.
            Smooth::Blob => (p.length() - blob_radius(p.normalize_or(DVec3::Z)).0) / 2.3,
            // The slope is at most 0.9.
            Smooth::Terrain => (p.z - terrain_height(p.truncate()).0) / 1.35,
            Smooth::Cylinder { fillet } => {
                let [side, cap] = beyond_core(p, fillet);
                side.max(cap).min(0.0) + DVec2::new(side, cap).max(DVec2::ZERO).length() - fillet
            }
        }
    }

    /// True if a line that leaves the surface's domain cannot meet the surface there.
    fn is_within(self, p: DVec3) -> bool {
        self != Smooth::Terrain || p.x.abs() <= 1.0 && p.y.abs() <= 1.0
    }

    /// Returns the first point at which the line from `from` along the unit vector `along` meets the surface within the
    /// distance `reach`.
    pub fn trace(self, from: DVec3, along: DVec3, reach: f64) -> Option<DVec3> {
        let at = |t: f64| self.outside(from + along * t);
        let (mut before, mut t) = (0.0, 0.0);
        let side = at(0.0).signum();
        while t < reach {
            let outside = at(t);
            if outside.signum() != side {
                let crossing = halved(before, t, |t| at(t).signum() == side);
                let point = from + along * crossing;
                return self.is_within(point).then_some(point).or_else(|| {
                    // The line passes under or over the edge of the terrain; it may come back.
                    self.trace(from + along * (t + MIN_STEP), along, reach - t - MIN_STEP)
                });
            }
            (before, t) = (t, t + outside.abs().max(MIN_STEP));
        }
        None
    }
}

/// Returns the end of the part of `from`…`to` that begins at `from` and in which `is_before` is true.
fn halved(mut from: f64, mut to: f64, is_before: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(from, to);
        *if is_before(middle) { &mut from } else { &mut to } = middle;
    }
    to
}

/// Returns the blob's distance from the center in the direction `p`, 0.66…1.34, and its derivatives along x, y and z.
pub(super) fn blob_radius(p: DVec3) -> (f64, DVec3) {
    let (sin, cos) = (2.1 * p.x + 0.4).sin_cos();
    let (down, up) = (2.6 * p.y - 0.3).sin_cos();
    let (wave, slope) = (3.1 * p.z + 1.3 * p.x).sin_cos();
    let (ripple, small) = (4.3 * p.y + 2.0 * p.z + 1.0).sin_cos();
    let radius = 1.0 + 0.16 * sin * up + 0.12 * wave + 0.06 * ripple;
    let (wave, ripple) = (0.12 * slope, 0.06 * small);
    (
        radius,
        DVec3::new(
            0.16 * 2.1 * cos * up + 1.3 * wave,
            -0.16 * 2.6 * sin * down + 4.3 * ripple,
            3.1 * wave + 2.0 * ripple,
        ),
    )
}

/// Returns the terrain's height and its derivatives along x and y.
pub(super) fn terrain_height(p: DVec2) -> (f64, DVec2) {
    let (sin, cos) = (2.3 * p.x + 0.4).sin_cos();
    let (down, up) = (2.9 * p.y - 0.7).sin_cos();
    let (ridge, slope) = (4.6 * p.x - 3.3 * p.y + 1.0).sin_cos();
    (
        0.16 * sin * up + 0.06 * ridge,
        DVec2::new(0.16 * 2.3 * cos * up + 0.06 * 4.6 * slope, -0.16 * 2.9 * sin * down - 0.06 * 3.3 * slope),
    )
}

/// Returns how far a point is beyond the side and the caps of the cylinder that the rounding surrounds.
fn beyond_core(p: DVec3, fillet: f64) -> [f64; 2] {
    [p.truncate().length() - (1.0 - fillet), p.z.abs() - (HALF_HEIGHT - fillet)]
}
