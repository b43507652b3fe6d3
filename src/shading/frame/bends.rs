//! How the light bends at the edges of triangles, Bangay §4: for each edge, data about its two triangles.
//!
//! The corners are A, B, C; the edge opposite A runs from B to C, and D is the neighbor's apex across it. All positions
//! are positions on the **screen**.

use glam::{DVec2, DVec3};

use super::projected::{Across, Frame};

/// The minimum m of [`Bend`]: the minimum distance of an apex's foot from a corner, in edge lengths.
const MIN_REACH: f64 = 1.0 / 16.0;

/// A triangle's data about one of its edges. [`bends`] computes it once per frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// c = I_BC(X) − I_AD(X), where the lines AD and BC cross at X on the screen: the height of the light at the edge
    /// above a straight line from A to D. Increasing the slope of the light along w_A by c on both sides makes the two
    /// slopes equal. For a parallelogram, c = (I_B + I_C − I_A − I_D)/2. The value is the same, bit for bit, on both
    /// sides of an edge, and zero if there is no neighbor to join smoothly; see `level` for [`Across::NonManifold`].
    pub c: DVec3,
    /// s_A, the point where the perpendicular from the triangle's own apex meets the edge: 0 at corner k+1, 1 at corner
    /// k+2.
    pub foot: f64,
    /// m at corner k+1: max(s_A, s_D, 1/16).
    pub start: f64,
    /// m at corner k+2: max(1−s_A, 1−s_D, 1/16).
    pub end: f64,
}

/// A corner: its position on the screen and its light.
type Corner = (DVec2, DVec3);

/// Returns the point where the perpendicular from `p` meets the line from `b` (0) to `c` (1); 0 if `b` and `c`
/// coincide.
fn foot(p: DVec2, b: DVec2, c: DVec2) -> f64 {
    let along = c - b;
    let length2 = along.length_squared();
    if length2 > 0.0 { (p - b).dot(along) / length2 } else { 0.0 }
}

/// Returns how much lighter the apex is than the edge at the apex's foot: a = I_A − I_BC(s_A).
fn excess(apex: DVec3, s: f64, b: DVec3, c: DVec3) -> DVec3 {
    apex - (b * (1.0 - s) + c * s)
}

/// Returns the constants of the edge from `b` to `c` for the triangle with apex `a`, and the mirrored constants for the
/// triangle with apex `d`: `c = −(h_D·a_A + h_A·a_D)/(h_A + h_D)`, where h are the heights above the edge. `None` if
/// either height is zero or if both apexes lie on the same side.
fn between(a: Corner, b: Corner, c: Corner, d: Corner) -> Option<(Bend, Bend)> {
    // Twice the areas, which are proportional to the heights.
    let (ha, hd) = (Frame::area2(a.0, b.0, c.0), Frame::area2(d.0, c.0, b.0));
    if !(ha > 0.0 && hd > 0.0) {
        return None;
    }
    let (sa, sd) = (foot(a.0, b.0, c.0), foot(d.0, b.0, c.0));
    let (aa, ad) = (excess(a.1, sa, b.1, c.1), excess(d.1, sd, b.1, c.1));
    let bend = (aa * hd + ad * ha) * (-1.0 / (ha + hd));
    let start = sa.max(sd).max(MIN_REACH);
    let end = (1.0 - sa).max(1.0 - sd).max(MIN_REACH);
    Some((Bend { c: bend, foot: sa, start, end }, Bend { c: bend, foot: 1.0 - sd, start: end, end: start }))
}

/// Returns the constants of an edge at which the light of every triangle must have zero slope across the edge: `c =
/// I_BC(s_A) − I_A`. Used for edges that three or more triangles share.
fn level(a: Corner, b: Corner, c: Corner) -> Bend {
    let s = foot(a.0, b.0, c.0);
    let (start, end) = (s.max(MIN_REACH), (1.0 - s).max(MIN_REACH));
    Bend { c: excess(a.1, s, b.1, c.1) * -1.0, foot: s, start, end }
}

/// Returns the constants of every edge of every triangle of `frame`; edge k is opposite corner k. The constants are
/// computed from the side of the triangle that comes first, so both sides get the same values.
#[must_use]
pub fn bends(frame: &Frame) -> Vec<[Bend; 3]> {
    let corner = |v: u32| (frame.vertices[v as usize].screen, frame.vertices[v as usize].light);
    let mut bends: Vec<[Bend; 3]> = Vec::with_capacity(frame.triangles.len());
    for triangle in &frame.triangles {
        let corners = triangle.vertices.map(corner);
        bends.push([0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let level = level(corners[k], corners[i], corners[j]);
            match triangle.across[k] {
                Across::NonManifold => level,
                // If there is one neighbor, the loop below replaces this value.
                Across::Nothing | Across::Triangle { .. } => Bend { c: DVec3::ZERO, ..level },
            }
        }));
    }
    for [(t, k), (u, l)] in frame.shared_edges() {
        let vertices = frame.triangles[t].vertices;
        let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| corner(vertices[k]));
        if let Some((ours, theirs)) = between(a, b, c, corner(frame.triangles[u].vertices[l])) {
            (bends[t][k], bends[u][l]) = (ours, theirs);
        }
    }
    bends
}
