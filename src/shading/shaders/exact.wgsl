// *exact*, new in machband: what one edge adds to Gouraud's light, c·t·(1 − I_n(t/b')). Needs strips.wgsl.
//
// `c` is half the bend across the edge, the same for both of its triangles; see bends.rs.
fn exact_strip(c: vec3f, t: f32, others: vec2f, b: f32) -> vec3f {
    let width = b * smooth_clamp((1.0 - others.x) / (2.0 * b)) * smooth_clamp((1.0 - others.y) / (2.0 * b));
    if t < width {
        return c * (t * (1.0 - blend(t / width)));
    }
    return vec3f(0.0);
}
