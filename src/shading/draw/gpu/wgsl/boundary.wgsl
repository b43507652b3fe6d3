// The strips at the edges of triangles. Needs interpolation.wgsl.
//
// In a strip, t is the weight that is 0 on the edge, `others` the two weights of the edge's ends in order, b the width.

// φ(x) = x − x²/4, 1 from 2 on, 0 for negative x.
fn ease(x: f32) -> f32 {
    let y = clamp(x, 0.0, 2.0);
    return y - 0.25 * y * y;
}

// Ours, *exact*: what one edge adds to Gouraud's light, c·t·(1 − I_n(t/b')). `c` is half the bend across the edge, the
// same for both its triangles: see edge_constants on the CPU.
fn exact_strip(c: vec3f, t: f32, others: vec2f, b: f32) -> vec3f {
    let width = b * ease((1.0 - others.x) / (2.0 * b)) * ease((1.0 - others.y) / (2.0 * b));
    if t < width {
        return c * (t * (1.0 - blend(t / width)));
    }
    return vec3f(0.0);
}

// Ours, *cut*: what one edge adds, −c·b'·Ψ_n(t/b'). `foot` is where the triangle's apex stands over the edge, `reach`
// how far the feet of both apexes are from its ends, as a part of its length.
fn cut_strip(c: vec3f, foot: f32, reach: vec2f, t: f32, others: vec2f, b: f32) -> vec3f {
    // The pixel's own foot, from either end.
    let along = vec2f(others.y + t * foot, others.x + t * (1.0 - foot));
    let width = b * ease(along.x / (b * reach.x)) * ease(along.y / (b * reach.y));
    if t < width {
        return -c * (width * rest(t / width));
    }
    return vec3f(0.0);
}

// t/b', b' = min(b, (1−w_i)/2, (1−w_j)/2) as Bangay's pseudo-code narrows it; 0 at the corners.
fn printed_across(t: f32, others: vec2f, b: f32) -> f32 {
    let width = min(b, min((1.0 - others.x) / 2.0, (1.0 - others.y) / 2.0));
    return select(0.0, t / width, width > 0.0);
}

// Bangay eq. 4, printed: t·I_n(t/b')·(I_A − I_E) + I_E. `apex` is I_A, `on_edge` I_E.
fn fixed_strip(apex: vec3f, on_edge: vec3f, t: f32, across: f32) -> vec3f {
    return on_edge + (apex - on_edge) * (t * interpolation(across));
}

// I_F: the light on the neighbour's far edge, Bangay eqs. 5 and 6, from the lights at the edge's ends and at the
// neighbour's apex.
fn beyond_edge(i: vec3f, j: vec3f, apex: vec3f, others: vec2f) -> vec3f {
    let a = 2.0 * others.x / (others.x + others.y) - 1.0;
    if a < 0.0 {
        return mix(apex, j, -2.0 * a / (1.0 - a));
    }
    return mix(apex, i, 2.0 * a / (1.0 + a));
}
