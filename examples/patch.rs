//! The shader `patch`, to be taken: `patch.wgsl` beside this file, and the 19 numbers that it needs of each triangle.
//! Computes them for two triangles, draws these and compares with the library.
//!
//! Every vertex needs the slope of the light on the screen. Two ways to have it without lighting more than vertices:
//! fit a plane to the lights of the vertices around (below), or, better, the chain rule through the surface's curvature
//! (`machband::shading::Patches` with `Gradients::Curvature`).
//!
//! `cargo run --example patch`

mod offscreen;

use offscreen::{CORNERS, TRIANGLES};

/// The slope of the light at vertex `v`, per pixel right and down: least squares over its neighbors, weighted by
/// 1/distance². A vertex needs neighbors in two directions; the library finds the shortest slope where it does not have them.
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

/// The 19 ordinates of a triangle from the places, lights and slopes of its corners: a reduced Clough–Tocher cubic.
///
/// `across` is the centroid of the neighbor at each edge: the slope along the line from centroid to centroid runs
/// linearly along the edge, so that both triangles agree about it. `None` at borders, creases and silhouettes.
fn ordinates(place: [[f32; 2]; 3], light: [f32; 3], slope: [[f32; 2]; 3], across: [Option<[f32; 2]>; 3]) -> [f32; 19] {
    let mut o = [0.0; 19];
    let toward = |i: usize, j: usize| {
        light[i] + (slope[i][0] * (place[j][0] - place[i][0]) + slope[i][1] * (place[j][1] - place[i][1])) / 3.0
    };
    for i in 0..3 {
        o[i] = light[i];
        o[3 + 2 * i] = toward(i, (i + 1) % 3);
        o[4 + 2 * i] = toward(i, (i + 2) % 3);
        o[9 + i] = (o[i] + o[3 + 2 * i] + o[4 + 2 * i]) / 3.0;
    }
    let own = centroid(place);
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        // Where the line between the centroids meets the edge, 0 at corner i and 1 at corner j.
        let crossing = across[k].map_or(0.5, |other| {
            let toward = minus(other, own);
            cross(minus(own, place[i]), toward) / cross(minus(place[j], place[i]), toward)
        });
        let (i_to_j, j_to_i) = (o[3 + 2 * i], o[4 + 2 * j]);
        o[12 + k] = (o[9 + i] + o[9 + j]) / 2.0
            + (1.0 - crossing) * (i_to_j - (o[i] + j_to_i) / 2.0)
            + crossing * (j_to_i - (i_to_j + o[j]) / 2.0);
    }
    for i in 0..3 {
        o[15 + i] = (o[9 + i] + o[12 + (i + 1) % 3] + o[12 + (i + 2) % 3]) / 3.0;
    }
    o[18] = (o[15] + o[16] + o[17]) / 3.0;
    o
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
    let light_of = "fn light_of(w: vec3f, at: u32) -> f32 {
        var o: array<f32, 19>;
        for (var i = 0u; i < 19u; i++) { o[i] = constants[at + i]; }
        return patch_light(w, o);
    }";
    let drawn = offscreen::draw(&format!("{}{light_of}", include_str!("patch.wgsl")), made.as_flattened(), 19);

    // The library's own, in f64, from the same slopes.
    let frame = frame();
    let vectors = slopes.iter().map(|s| [glam::DVec2::from(s.map(f64::from)); 3]).collect();
    let patches = machband::shading::Patches::with_gradients(&frame, vectors);
    offscreen::compare("patch", drawn, |triangle, w| patches.light(triangle, w).x);
}

/// The two triangles as the library knows them.
fn frame() -> machband::shading::Frame {
    use machband::shading::{Across, Frame, FrameTriangle, FrameVertex, Lighting, View};
    let vertex = |(place, light): ([f32; 2], f32)| FrameVertex {
        screen: glam::DVec2::from(place.map(f64::from)),
        depth: 0.5,
        eye: glam::DVec3::ZERO,
        normal: glam::DVec3::Z,
        curvature: glam::DMat3::ZERO,
        light: glam::DVec3::splat(f64::from(light)),
        ambient: glam::DVec3::ZERO,
    };
    let triangle = |t: usize| FrameTriangle {
        vertices: TRIANGLES[t].map(|v| v as u32),
        source: t as u32,
        normal: glam::DVec3::Z,
        across: [
            Across::Triangle { triangle: 1 - t as u32, apex: TRIANGLES[1 - t][0] as u32 },
            Across::Nothing,
            Across::Nothing,
        ],
    };
    Frame {
        width: offscreen::SIZE,
        height: offscreen::SIZE,
        background: glam::DVec3::ZERO,
        vertices: CORNERS.map(vertex).to_vec(),
        triangles: vec![triangle(0), triangle(1)],
        lighting: Lighting::standard(),
        view: View::square(offscreen::SIZE),
        encoding: None,
    }
}
