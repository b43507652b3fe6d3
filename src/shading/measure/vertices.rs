//! Whether the light has one slope at a vertex.

use glam::{DVec2, DVec3};

use super::creases::{STEP, slope};
use crate::shading::frame::Frame;

/// How far the light around a vertex is from having one slope there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexCrease {
    /// Index into [`Frame::vertices`].
    pub vertex: u32,
    /// Slopes along the edges and the medians that begin at the vertex, against those of the gradient that fits them
    /// best: root mean square over them and over red, green and blue, in linear light per pixel.
    pub spread: f64,
}

/// The spread of slopes at every vertex of a drawn triangle, in the order of [`Frame::vertices`]. `light` as for
/// [`Creases::of_field`](super::Creases::of_field).
#[must_use]
pub fn at_vertices(frame: &Frame, light: impl Fn(usize, [f64; 3]) -> DVec3) -> Vec<VertexCrease> {
    let mut slopes: Vec<Vec<(DVec2, DVec3)>> = vec![Vec::new(); frame.vertices.len()];
    for (t, triangle) in frame.triangles.iter().enumerate() {
        for k in 0..3 {
            let (own, next, last) = (corner(k), corner((k + 1) % 3), corner((k + 2) % 3));
            for target in [next, last, (next + last) / 2.0] {
                let step = STEP * (target - own);
                let offset = on_screen(frame, t, step);
                let length = offset.length();
                if length > 0.0 {
                    let (_, slope) = slope(length, |steps| light(t, (own + steps * step).to_array()));
                    slopes[triangle.vertices[k] as usize].push((offset / length, slope));
                }
            }
        }
    }
    let seen = slopes.iter().enumerate().filter(|(_, slopes)| !slopes.is_empty());
    seen.map(|(v, slopes)| VertexCrease { vertex: v as u32, spread: spread(slopes) }).collect()
}

fn spread(slopes: &[(DVec2, DVec3)]) -> f64 {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    let (mut x, mut y) = (DVec3::ZERO, DVec3::ZERO);
    for (d, slope) in slopes {
        (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
        (x, y) = (x + d.x * slope, y + d.y * slope);
    }
    let determinant = xx * yy - xy * xy;
    if determinant <= 0.0 {
        return 0.0;
    }
    let (gx, gy) = ((yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant);
    let squares: f64 = slopes.iter().map(|(d, slope)| (*slope - d.x * gx - d.y * gy).length_squared()).sum();
    (squares / (3 * slopes.len()) as f64).sqrt()
}

/// Weights with corner `k` at 1.
fn corner(k: usize) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|i| f64::from(u8::from(i == k))))
}

/// The length of a step on the screen that changes the weights by `change`.
fn on_screen(frame: &Frame, triangle: usize, change: DVec3) -> DVec2 {
    let [a, b, c] = frame.corners(triangle).map(|v| v.screen);
    // Against the first corner: the change sums to 0.
    change.y * (b - a) + change.z * (c - a)
}
