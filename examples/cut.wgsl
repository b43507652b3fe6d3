// `cut`: Gouraud's light with the corner that it makes at every edge cut off (n = 1). Take it: it needs nothing else.
//
// A triangle has the light of its corners A, B, C and one vec4f an edge, made once a frame (see cut.rs):
//   x  c, how much the light bends across the edge; 0 at borders, creases and silhouettes
//   y  where the perpendicular from the opposite corner meets the edge, 0…1
//   z, w  how near to the edge's two ends the strip at it may go
// `strip` is b, the width of the strips, above 0: b = 1/3 or more. Edge k lies opposite corner k. Weights are those of the screen: linear there, not perspective-corrected.

fn ease(x: f32) -> f32 {
    let t = clamp(x, 0.0, 2.0);
    return t - 0.25 * t * t;
}

// What one edge takes away: own is the weight of the corner opposite, first and second those at the edge's ends.
fn cut_at(edge: vec4f, own: f32, first: f32, second: f32, b: f32) -> f32 {
    let from_first = second + own * edge.y;
    let from_second = first + own * (1.0 - edge.y);
    let width = b * ease(from_first / (b * edge.z)) * ease(from_second / (b * edge.w));
    let v = max(1.0 - own / max(width, 1e-6), 0.0);
    return edge.x * width * 0.5 * v * v;
}

fn cut(weights: vec3f, light: vec3f, a: vec4f, b: vec4f, c: vec4f, strip: f32) -> f32 {
    return dot(weights, light)
        - cut_at(a, weights.x, weights.y, weights.z, strip)
        - cut_at(b, weights.y, weights.z, weights.x, strip)
        - cut_at(c, weights.z, weights.x, weights.y, strip);
}
