// *cut*, new in machband: what one edge adds to Gouraud's light, −c·b'·Ψ_n(t/b'). Needs strips.wgsl.
//
// `foot` is the point where the perpendicular from the triangle's apex meets the edge. `reach` is, for each end of the
// edge, the distance of the farther foot of the two apexes from that end. Both are fractions of the edge's length.
fn cut_strip(c: vec3f, foot: f32, reach: vec2f, t: f32, others: vec2f, b: f32) -> vec3f {
    // The distance of the pixel's own foot from either end.
    let along = vec2f(others.y + t * foot, others.x + t * (1.0 - foot));
    let width = b * smooth_clamp(along.x / (b * reach.x)) * smooth_clamp(along.y / (b * reach.y));
    if t < width {
        return -c * (width * remaining_integral(t / width));
    }
    return vec3f(0.0);
}
