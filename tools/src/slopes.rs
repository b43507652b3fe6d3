//! The slopes of the light at the vertices of a frame; also compiled into the tests of the shaders.

use glam::{DMat2, DVec2, DVec3};
use machband::shading::Frame;

/// For every vertex of a drawn triangle, returns how far the light around it is from having a single slope there: the
/// root mean square difference between the slopes along the edges and medians that begin at the vertex and the gradient
/// that fits them best, in linear light per pixel.
pub fn at_vertices(frame: &Frame, light: impl Fn(usize, [f64; 3]) -> DVec3) -> Vec<f64> {
    let mut slopes: Vec<Vec<(DVec2, DVec3)>> = vec![Vec::new(); frame.vertices.len()];
    for (t, triangle) in frame.triangles.iter().enumerate() {
        let [a, b, c] = frame.corners(t).map(|v| v.screen);
        for k in 0..3 {
            let [own, next, last] = [0, 1, 2].map(|i| DVec3::AXES[(k + i) % 3]);
            for target in [next, last, (next + last) / 2.0] {
                let step = 1e-5 * (target - own);
                // The offset on the screen, relative to the first corner, because the changes of the weights sum to 0.
                let offset = step.y * (b - a) + step.z * (c - a);
                let [at_0, at_1, at_2] = [0.0, 1.0, 2.0].map(|steps| light(t, (own + steps * step).to_array()));
                // The error is proportional to the square of the step.
                let slope = (4.0 * at_1 - at_2 - 3.0 * at_0) / (2.0 * offset.length());
                slopes[triangle.vertices[k] as usize].push((offset.normalize(), slope));
            }
        }
    }
    let spread = |slopes: &Vec<(DVec2, DVec3)>| {
        let normal: DMat2 = slopes.iter().map(|(d, _)| DMat2::from_cols(d.x * d, d.y * d)).sum();
        let of_channel = |channel: usize| {
            let gradient = normal.inverse() * slopes.iter().map(|(d, slope)| slope[channel] * d).sum::<DVec2>();
            slopes.iter().map(|(d, slope)| (slope[channel] - d.dot(gradient)).powi(2)).sum::<f64>()
        };
        ((0..3).map(of_channel).sum::<f64>() / (3 * slopes.len()) as f64).sqrt()
    };
    slopes.iter().filter(|slopes| !slopes.is_empty()).map(spread).collect()
}
