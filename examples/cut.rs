//! Shows how to use the shader *cut* in your own program: the library's WGSL, unchanged, and the four numbers per edge
//! that it needs. The example computes these numbers for two triangles, draws the triangles, and compares the image
//! with the library's.
//!
//! `cargo run --example cut`

mod offscreen;

use machband::shading::{Reference, Shade, Shader};
use offscreen::{CORNERS, TRIANGLES};

/// The complete WGSL of *cut*, including the code for strips.
const CUT: &str =
    concat!(include_str!("../src/shading/shaders/strips.wgsl"), include_str!("../src/shading/shaders/cut.wgsl"),);

/// A position on the screen and its light value.
type Corner = ([f32; 2], f32);

/// The width b of the strip at each edge.
const STRIP: f32 = 1.0 / 3.0;

/// Twice the area of a triangle, positive if the triangle is counterclockwise with y pointing down.
fn area2(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f32 {
    (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
}

/// The point where the perpendicular from `p` meets the line from `b` (0) to `c` (1), as a fraction.
fn foot(p: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f32 {
    let (x, y) = (c[0] - b[0], c[1] - b[1]);
    ((p[0] - b[0]) * x + (p[1] - b[1]) * y) / (x * x + y * y)
}

/// Returns the four numbers of the edge from `b` to `c`. The opposite corner of the triangle is `a`; the opposite
/// corner of the neighbor is `d`. The first number is c = −(h_D·a_A + h_A·a_D)/(h_A + h_D), where a is the amount by
/// which the light at an opposite corner exceeds the line through the edge, and h is the corner's height above the
/// edge.
///
/// `d` is `None` where the light need not be smooth: at a border, at a crease, at an edge of more than two triangles,
/// and at an edge whose neighbor faces away from the viewer or has no area on the screen.
fn edge(a: Corner, b: Corner, c: Corner, d: Option<Corner>) -> [f32; 4] {
    let excess = |p: Corner, at: f32| p.1 - (b.1 * (1.0 - at) + c.1 * at);
    let own = foot(a.0, b.0, c.0);
    let Some(d) = d else { return [0.0, own, own.max(0.0625), (1.0 - own).max(0.0625)] };
    let across = foot(d.0, b.0, c.0);
    let (height, height_across) = (area2(a.0, b.0, c.0), area2(d.0, c.0, b.0));
    let bend = -(height_across * excess(a, own) + height * excess(d, across)) / (height + height_across);
    [bend, own, own.max(across).max(0.0625), (1.0 - own).max(1.0 - across).max(0.0625)]
}

fn main() {
    // The light values of the corners, followed by the numbers of the edges opposite them. The two triangles share
    // their first edge.
    let mut constants: Vec<f32> = Vec::new();
    for (t, [a, b, c]) in TRIANGLES.map(|triangle| triangle.map(|corner| CORNERS[corner])).into_iter().enumerate() {
        let opposite = CORNERS[TRIANGLES[1 - t][0]];
        constants.extend([a.1, b.1, c.1]);
        for (k, numbers) in [edge(a, b, c, Some(opposite)), edge(b, c, a, None), edge(c, a, b, None)].iter().enumerate()
        {
            println!("triangle {t} edge {k}: {numbers:?}");
            constants.extend(numbers);
        }
    }
    let light_of = format!(
        "fn strip(at: u32, own: f32, others: vec2f) -> f32 {{
            let c = constants[at];
            let foot = constants[at + 1u];
            let reach = vec2f(constants[at + 2u], constants[at + 3u]);
            return cut_strip(vec3f(c), foot, reach, own, others, {STRIP:?}).x;
        }}
        fn light_of(w: vec3f, at: u32) -> f32 {{
            let gouraud = dot(w, vec3f(constants[at], constants[at + 1u], constants[at + 2u]));
            return gouraud + strip(at + 3u, w.x, w.yz) + strip(at + 7u, w.y, w.zx) + strip(at + 11u, w.z, w.xy);
        }}"
    );
    let drawn = offscreen::draw(&format!("{CUT}{light_of}"), 1, &constants, 15);

    // The library's result, in f64.
    let frame = offscreen::frame();
    let shade = Shade { boundary: f64::from(STRIP), ..Shade::new(Shader::Cut) };
    let reference = Reference::new(&frame, &shade);
    offscreen::compare("cut", drawn, |triangle, w| reference.light(triangle, w).x);
}
