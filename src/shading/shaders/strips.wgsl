// The strips at the edges of triangles. Needs nothing else.
//
// In a strip, t is the weight that is 0 on the edge, `others` the two weights of the edge's ends in order, b the width.

// φ(x) = x − x²/4, 1 from 2 on, 0 for negative x.
fn ease(x: f32) -> f32 {
    let y = clamp(x, 0.0, 2.0);
    return y - 0.25 * y * y;
}

// t/b', b' = min(b, (1−w_i)/2, (1−w_j)/2) as Bangay's pseudo-code narrows it; 0 at the corners.
fn printed_across(t: f32, others: vec2f, b: f32) -> f32 {
    let width = min(b, min((1.0 - others.x) / 2.0, (1.0 - others.y) / 2.0));
    return select(0.0, t / width, width > 0.0);
}

// The corner with the smallest weight; the first of equals.
fn smallest(w: vec3f) -> u32 {
    let k = select(0u, 1u, w.y < w.x);
    return select(k, 2u, w.z < w[k]);
}
