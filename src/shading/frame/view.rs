//! The viewpoint, and the size of the window.

use glam::{DMat3, DVec2, DVec3};

/// A window of pixels, and the mesh turned before it.
///
/// Eye space: x right, y up, z toward the eye; the mesh's bounding sphere is the unit sphere around the origin.
/// On the screen: physical pixels, x right, y **down**, pixel centers at halves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Pixels across.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The mesh's own axes to eye space.
    pub rotation: DMat3,
    /// How much of the smaller side of the window the bounding sphere fills.
    pub fill: f64,
    /// Distance of the eye from the mesh's center in radii of the bounding sphere, above 1; infinite for a parallel
    /// projection.
    pub distance: f64,
}

impl View {
    /// A square window of `size` pixels, nine tenths of it filled in parallel projection, with no rotation.
    #[must_use]
    pub fn square(size: u32) -> View {
        View { width: size, height: size, rotation: DMat3::IDENTITY, fill: 0.9, distance: f64::INFINITY }
    }

    /// The same with the mesh turned by `degrees` about x, then y, then z, counter-clockwise seen from the axis's tip.
    #[must_use]
    pub fn rotated(mut self, degrees: [f64; 3]) -> View {
        let [x, y, z] = degrees.map(f64::to_radians);
        self.rotation = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
        self
    }

    /// Unit vector from a point in eye space to the eye.
    #[must_use]
    pub fn to_viewer(&self, eye: DVec3) -> DVec3 {
        if self.distance.is_finite() { (DVec3::new(0.0, 0.0, self.distance) - eye).normalize() } else { DVec3::Z }
    }

    /// Where a point in eye space falls on the screen, and its depth there: 0 nearest, 1 farthest, affine on the screen
    /// within a plane.
    #[must_use]
    pub fn project(&self, eye: DVec3) -> (DVec2, f64) {
        let scale = f64::from(self.width.min(self.height)) * self.fill / 2.0;
        // In perspective the rim of the sphere, not its equator, fills the window.
        let d = self.distance;
        let (xy, depth) = if d.is_finite() {
            let ratio = (d * d - 1.0).sqrt() / (d - eye.z);
            // 1/(d − z) is affine on the screen.
            (
                eye.truncate() * ratio,
                1.0 - ((1.0 / (d - eye.z)) - 1.0 / (d + 1.0)) / (1.0 / (d - 1.0) - 1.0 / (d + 1.0)),
            )
        } else {
            (eye.truncate(), (1.0 - eye.z) / 2.0)
        };
        let middle = DVec2::new(f64::from(self.width), f64::from(self.height)) / 2.0;
        (middle + DVec2::new(xy.x, -xy.y) * scale, depth)
    }
}
