// Ours, *cut*: what one edge adds to Gouraud's light, −c·b'·Ψ_n(t/b'). Needs strips.wgsl.
//
// `foot` is where the perpendicular from the triangle's apex meets the edge, `reach` how far the feet of both apexes
// are from its ends, as a part of its length.
fn cut_strip(c: vec3f, foot: f32, reach: vec2f, t: f32, others: vec2f, b: f32) -> vec3f {
    // The pixel's own foot, from either end.
    let along = vec2f(others.y + t * foot, others.x + t * (1.0 - foot));
    let width = b * ease(along.x / (b * reach.x)) * ease(along.y / (b * reach.y));
    if t < width {
        return -c * (width * rest(t / width));
    }
    return vec3f(0.0);
}
