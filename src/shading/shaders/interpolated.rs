//! The shaders without strips: light that is constant or a polynomial over a triangle, and light at every pixel, with the
//! colors of a painted mesh there.

use glam::DVec3;

use crate::shading::frame::{Field, Frame, FrameVertex, Patches};

/// For each corner, the other two, in order.
pub const OTHERS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// Returns Σ w_k·values_k.
#[inline]
pub fn weighted(w: [f64; 3], values: [DVec3; 3]) -> DVec3 {
    w[0] * values[0] + w[1] * values[1] + w[2] * values[2]
}

/// One light value per triangle: the light at its centroid, with the normal of the face. Shoaff §3.4.
pub fn flat(frame: &Frame, triangle: usize) -> DVec3 {
    let [a, b, c] = frame.corners(triangle).map(|v| v.eye);
    frame.lit((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero())
}

/// Quadratic light after Mohamed et al., whose shader uses three additional samples of the light per triangle: through
/// the light values of the corners and M_k of the midpoints of the edges, where M_k is opposite corner k. It is Gouraud's
/// light plus Σ_k w_i·w_j·4(M_k − (I_i + I_j)/2).
pub fn quadratic(bulges: &[DVec3; 3], w: [f64; 3], gouraud: DVec3) -> DVec3 {
    OTHERS.iter().zip(bulges).fold(gouraud, |light, (&(i, j), bulge)| light + w[i] * w[j] * bulge)
}

/// Returns 4(M_k − (I_i + I_j)/2) of each edge of `triangle`, where M_k is lit as `phong` would light it. Both
/// triangles at an edge get the same values.
pub fn bulges(frame: &Frame, triangle: usize) -> [DVec3; 3] {
    let corners = frame.corners(triangle);
    OTHERS.map(|(i, j)| {
        let place = (corners[i].eye + corners[j].eye) / 2.0;
        let normal = (corners[i].normal + corners[j].normal).normalize_or_zero();
        4.0 * (frame.lit(place, normal) - (corners[i].light + corners[j].light) / 2.0)
    })
}

impl Frame {
    /// Returns the light at the weights `w` of a triangle, at a position with a unit normal and a unit vector toward the
    /// viewer, all in eye space.
    fn pixel(&self, triangle: usize, w: [f64; 3], position: DVec3, normal: DVec3, to_viewer: DVec3) -> DVec3 {
        let color = self.paint_color(triangle, w).unwrap_or(DVec3::ONE);
        self.lighting.painted(position, normal, to_viewer, color)
    }

    /// Returns the color of the paint, if there is any, at the weights `w` of a triangle, with correction for perspective.
    pub(super) fn paint_color(&self, triangle: usize, w: [f64; 3]) -> Option<DVec3> {
        let (paint, drawn) = (self.paint.as_deref()?, &self.triangles[triangle]);
        let near = self.corners(triangle).map(|v| self.view.nearness(v.eye.z));
        let weights = [0, 1, 2].map(|k| w[k] * near[k]);
        let sum: f64 = weights.iter().sum();
        let [a, b, c] = weights.map(|weight| weight / sum);
        Some(paint.color(drawn.of_mesh as usize, if drawn.is_back { [a, c, b] } else { [a, b, c] }))
    }
}

/// Phong interpolates the normal and lights every pixel, Shoaff §3.4. The surface has the normalized normal Σ a_i·N_i at
/// the position Σ a_i·P_i, where a_i are the weights on the flat triangle: as on graphics cards, w_i/z_i divided by their
/// sum, with the weights w_i on the screen and the distances z_i from the eye's plane.
pub fn phong(frame: &Frame, triangle: usize, w: [f64; 3]) -> DVec3 {
    let [a, b, c] = frame.corners(triangle);
    let near = |v: &FrameVertex| frame.view.nearness(v.eye.z);
    let on_surface = [w[0] * near(a), w[1] * near(b), w[2] * near(c)];
    let normal = weighted(on_surface, [a.normal, b.normal, c.normal]).normalize_or_zero();
    let far = 1.0 / (on_surface[0] + on_surface[1] + on_surface[2]);
    let place = weighted(on_surface, [a.eye, b.eye, c.eye]) * far;
    frame.pixel(triangle, w, place, normal, frame.view.to_viewer(place))
}

/// New in machband: Phong's lighting at every pixel, with normals that change with a continuous slope: the reduced
/// Clough–Tocher cubics of [`Patches`], normalized.
///
/// The line of sight through a pixel is known exactly, so the direction to the eye is smooth. The position on it
/// matters only if a lamp is near. It then comes from a cubic of z, because the depths of flat triangles bend at their
/// edges.
pub fn c1_phong(frame: &Frame) -> impl Fn(usize, [f64; 3]) -> DVec3 + Send + Sync + '_ {
    let places = frame.lighting.has_near_lamps().then(|| Patches::new(frame, Field::Position));
    let normals = Patches::new(frame, Field::Normal);
    // Where the line of sight to each vertex meets the plane z = 0.
    let sights: Vec<DVec3> = frame.vertices.iter().map(|v| frame.view.sight(v.screen).extend(0.0)).collect();
    move |triangle, w| {
        let normal = normals.value(triangle, w).normalize_or_zero();
        let mut place = weighted(w, frame.triangles[triangle].vertices.map(|v| sights[v as usize]));
        let to_viewer = frame.view.to_viewer(place);
        if let Some(places) = &places {
            place.z = places.value(triangle, w).z;
            // A parallel projection moves only z; a perspective one moves along the line of sight.
            let nearer = 1.0 - place.z / frame.view.distance;
            (place.x, place.y) = (place.x * nearer, place.y * nearer);
        }
        frame.pixel(triangle, w, place, normal, to_viewer)
    }
}
