//! The shader `cut`, to be taken: `cut.wgsl` beside this file, and the four numbers that it needs of each edge. Computes
//! them for two triangles, draws these and compares with the library.
//!
//! `cargo run --example cut`

mod offscreen;

use offscreen::{CORNERS, TRIANGLES};

/// A place on the screen, and the light there.
type Corner = ([f32; 2], f32);

/// Width b of the strip at each edge.
const STRIP: f32 = 1.0 / 3.0;

/// Twice the area of a triangle, positive if it is counter-clockwise with y down.
fn area2(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f32 {
    (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
}

/// Where the perpendicular from `p` meets the line from `b` (0) to `c` (1).
fn foot(p: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f32 {
    let (x, y) = (c[0] - b[0], c[1] - b[1]);
    ((p[0] - b[0]) * x + (p[1] - b[1]) * y) / (x * x + y * y)
}

/// `d` is `None` where there is nothing to be smooth with: at a border, a crease, an edge of more than two triangles, and
/// where the neighbor faces away from the viewer or has no area on the screen.
///
/// The four numbers of the edge from `b` to `c` of the triangle with the corner `a` opposite, and the neighbor's `d`
/// across it. `c` = −(h_D·a_A + h_A·a_D)/(h_A + h_D): a the excess of an opposite corner over the edge's line, h its height.
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
    // Lights of the corners, then the edges opposite them; the two triangles share their first edge.
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
        "fn edge_of(at: u32) -> vec4f {{ return vec4f(constants[at], constants[at + 1u], constants[at + 2u], constants[at + 3u]); }}
        fn light_of(w: vec3f, at: u32) -> f32 {{
            let light = vec3f(constants[at], constants[at + 1u], constants[at + 2u]);
            return cut(w, light, edge_of(at + 3u), edge_of(at + 7u), edge_of(at + 11u), {STRIP:?});
        }}"
    );
    let drawn = offscreen::draw(&format!("{}{light_of}", include_str!("cut.wgsl")), &constants, 15);

    // The library's own, in f64.
    use machband::{
        light::Depth,
        shading::{boundary, shaders},
    };
    let corner = |k: usize| (glam::DVec2::from(CORNERS[k].0.map(f64::from)), f64::from(CORNERS[k].1));
    let blend = boundary::Blend::new(Depth::Finite(1));
    offscreen::compare("cut", drawn, |t, w| {
        let [a, b, c] = TRIANGLES[t].map(corner);
        let open = |a, b, c| boundary::EdgeConstants { c: 0.0, ..boundary::level(a, b, c) };
        let shared = boundary::between(a, b, c, corner(TRIANGLES[1 - t][0])).map_or(open(a, b, c), |(ours, _)| ours);
        let edges = [shared, open(b, c, a), open(c, a, b)];
        shaders::cut::cut(w, [a.1, b.1, c.1], &edges, f64::from(STRIP), &blend)
    });
}
