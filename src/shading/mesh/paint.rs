//! Colors and textures on a mesh.

use std::sync::Arc;

use glam::{DVec2, DVec3};
pub use gltf::texture::WrappingMode as Wrap;

/// What a mesh is painted with. Its colors and textures multiply the diffuse color of the material.
#[derive(Clone, Debug, PartialEq)]
pub struct Paint {
    /// The corners of each triangle of the mesh.
    pub corners: Vec<[PaintedCorner; 3]>,
    /// The coat of each triangle, as an index into `coats`.
    pub of_triangles: Vec<u32>,
    /// The textures.
    pub coats: Vec<Coat>,
}

/// The paint at a corner of a triangle. Inside the triangle, it is interpolated with correction for perspective.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaintedCorner {
    /// Linear red, green and blue, 0…1.
    pub color: DVec3,
    /// The place on the textures: 0…1 to the right and down. They continue beyond as [`Wrap`] says.
    pub place: DVec2,
}

impl Default for PaintedCorner {
    /// White, without a place.
    fn default() -> Self {
        PaintedCorner { color: DVec3::ONE, place: DVec2::ZERO }
    }
}

/// The texture of some triangles, if they have one.
pub type Coat = Option<Arc<Texture>>;

/// An image on a surface, bilinearly interpolated between the centers of its texels, without smaller copies for
/// distant surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Texels per row, at least 1.
    pub width: u32,
    /// Number of rows, at least 1.
    pub height: u32,
    /// Linear red, green and blue of each texel, row by row from the top left.
    pub texels: Vec<[f32; 3]>,
    /// How it continues to the right and down.
    pub wrap: [Wrap; 2],
}

/// Returns the texel that is shown at texel `at` of `count`, which may be beyond them.
fn wrapped(wrap: Wrap, at: f64, count: u32) -> usize {
    let (at, count) = (at as i64, i64::from(count));
    let texel = match wrap {
        Wrap::Repeat => at.rem_euclid(count),
        Wrap::MirroredRepeat => at.rem_euclid(2 * count).min((-1 - at).rem_euclid(2 * count)),
        Wrap::ClampToEdge => at.clamp(0, count - 1),
    };
    texel as usize
}

impl Texture {
    /// Returns the texture at `place`.
    pub fn at(&self, place: DVec2) -> DVec3 {
        let size = DVec2::new(f64::from(self.width), f64::from(self.height));
        let [across, down] = self.wrap;
        let texel = place * size - 0.5;
        let (low, part) = (texel.floor(), texel - texel.floor());
        let of = |x: f64, y: f64| {
            let at = wrapped(down, y, self.height) * self.width as usize + wrapped(across, x, self.width);
            DVec3::from_array(self.texels[at].map(f64::from))
        };
        let row = |y: f64| of(low.x, y).lerp(of(low.x + 1.0, y), part.x);
        row(low.y).lerp(row(low.y + 1.0), part.y)
    }
}

impl Paint {
    /// Returns the color at a point of a triangle, from the weights of its corners on the surface.
    pub fn color(&self, triangle: usize, w: [f64; 3]) -> DVec3 {
        let corners = || self.corners[triangle].iter().zip(w);
        let color: DVec3 = corners().map(|(corner, w)| w * corner.color).sum();
        let place: DVec2 = corners().map(|(corner, w)| w * corner.place).sum();
        let texture = &self.coats[self.of_triangles[triangle] as usize];
        color * texture.as_ref().map_or(DVec3::ONE, |texture| texture.at(place))
    }

    /// True if the triangles have no color but white, and no textures.
    pub fn is_plain(&self) -> bool {
        let is_white = |corner: &PaintedCorner| corner.color == DVec3::ONE;
        self.coats.iter().all(Option::is_none) && self.corners.iter().flatten().all(is_white)
    }
}
