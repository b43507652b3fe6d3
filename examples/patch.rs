//! Shows how to use the shader *patch* in your own program: the library's WGSL, unchanged, and the twelve numbers per
//! triangle that it needs. The example computes these numbers for two triangles, draws the triangles, and compares the
//! image with the library's.
//!
//! Every vertex needs the slope of its light value on the screen. There are two ways to compute it from lighting at the
//! vertices only: fit a plane to the light values of the neighboring vertices (as below) or, better, apply the chain
//! rule to the curvature of the surface (`machband::shading::Patches` with `Gradients::Curvature`).
//!
//! `cargo run --example patch`

mod offscreen;

use machband::shading::{
    Channels, Patches,
    shaders::{Patch, ShaderKernel as _},
};
use offscreen::{CORNERS, TRIANGLES};

/// Returns the slope of the light at vertex `v`, per pixel to the right and down: a least-squares fit over its
/// neighbors, weighted by 1/distance². A vertex needs neighbors in two directions; otherwise, the library uses the
/// smallest possible slope.
fn gradient(v: usize) -> [f32; 2] {
    let (place, light) = CORNERS[v];
    let (mut xx, mut xy, mut yy, mut xl, mut yl) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (n, (other, their_light)) in CORNERS.iter().enumerate() {
        let joined = n != v && TRIANGLES.iter().any(|triangle| triangle.contains(&n) && triangle.contains(&v));
        let (x, y, l) = (other[0] - place[0], other[1] - place[1], their_light - light);
        let weight = if joined { 1.0 / (x * x + y * y) } else { 0.0 };
        xx += weight * x * x;
        xy += weight * x * y;
        yy += weight * y * y;
        xl += weight * x * l;
        yl += weight * y * l;
    }
    let determinant = xx * yy - xy * xy;
    [(yy * xl - xy * yl) / determinant, (xx * yl - xy * xl) / determinant]
}

fn minus(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[1] - a[1] * b[0]
}

fn centroid(place: [[f32; 2]; 3]) -> [f32; 2] {
    [0, 1].map(|axis| (place[0][axis] + place[1][axis] + place[2][axis]) / 3.0)
}

/// Returns the twelve ordinates of a triangle (a reduced Clough–Tocher cubic) from the positions, light values and
/// slopes of its corners: the light values of the corners, the ordinates toward the next corner and toward the corner
/// after that, and the midpoints of the parts at the edges.
///
/// `across` is the centroid of the neighbor at each edge, or `None` at borders, creases and silhouettes. The slope
/// along the line between the centroids changes linearly along the edge, so it is the same in both triangles.
fn ordinates(place: [[f32; 2]; 3], light: [f32; 3], slope: [[f32; 2]; 3], across: [Option<[f32; 2]>; 3]) -> [f32; 12] {
    let toward = |i: usize, j: usize| {
        light[i] + (slope[i][0] * (place[j][0] - place[i][0]) + slope[i][1] * (place[j][1] - place[i][1])) / 3.0
    };
    let next = [0, 1, 2].map(|i| toward(i, (i + 1) % 3));
    let previous = [0, 1, 2].map(|i| toward(i, (i + 2) % 3));
    let near = [0, 1, 2].map(|i| (light[i] + next[i] + previous[i]) / 3.0);
    let own = centroid(place);
    let middle = [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        // The point where the line between the centroids meets the edge: 0 at corner i, 1 at corner j.
        let crossing = across[k].map_or(0.5, |other| {
            let toward = minus(other, own);
            cross(minus(own, place[i]), toward) / cross(minus(place[j], place[i]), toward)
        });
        let (i_to_j, j_to_i) = (next[i], previous[j]);
        (near[i] + near[j]) / 2.0
            + (1.0 - crossing) * (i_to_j - (light[i] + j_to_i) / 2.0)
            + crossing * (j_to_i - (i_to_j + light[j]) / 2.0)
    });
    let [a, b, c, d] = [light, next, previous, middle];
    [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2], d[0], d[1], d[2]]
}

fn main() {
    let slopes: Vec<[f32; 2]> = (0..CORNERS.len()).map(gradient).collect();
    let made = [0, 1].map(|t| {
        let triangle = TRIANGLES[t];
        // The two triangles share their first edge.
        let across = [Some(centroid(TRIANGLES[1 - t].map(|v| CORNERS[v].0))), None, None];
        ordinates(triangle.map(|v| CORNERS[v].0), triangle.map(|v| CORNERS[v].1), triangle.map(|v| slopes[v]), across)
    });
    for (t, numbers) in made.iter().enumerate() {
        println!("triangle {t}: {numbers:?}");
    }
    let light_of = "fn three(at: u32) -> array<vec3f, 3> {
        return array(vec3f(constants[at]), vec3f(constants[at + 1u]), vec3f(constants[at + 2u]));
    }
    fn light_of(w: vec3f, at: u32) -> f32 {
        return patch_light(Patch(three(at), three(at + 3u), three(at + 6u), three(at + 9u)), w).x;
    }";
    let wgsl = concat!(include_str!("../src/shading/shaders/patch.wgsl"), "\n");
    let drawn = offscreen::draw(&format!("{wgsl}{light_of}"), 0, made.as_flattened(), 12);

    // The library's result in f64, from the same slopes.
    let frame = offscreen::frame();
    let vectors = slopes.iter().map(|s| [glam::DVec2::from(s.map(f64::from)); 3]).collect();
    let patch = Patch::<f64, 3>::new(&frame, Channels::Color, &Patches::with_gradients(&frame, vectors));
    offscreen::compare("patch", drawn, |triangle, w| patch.light(triangle, w, [0.0; 3])[0]);
}
