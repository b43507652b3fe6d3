// `patch`: a smooth surface through the lights of the vertices, with the slopes of the light there. Take it: it needs
// nothing else.
//
// A triangle has 19 numbers, made once a frame (see patch.rs): the ordinates of three cubics that meet at its centroid.
//   0…2    the corners' lights
//   3+2i, 4+2i  a third of the way from corner i to the next, to the one after
//   9+i    a third of the way from corner i to the centroid
//   12+k   the middle of the part at edge k
//   15+i   two thirds of the way from corner i to the centroid
//   18     the centroid
// Weights are those of the screen: linear there, not perspective-corrected.

fn patch_light(weights: vec3f, p: array<f32, 19>) -> f32 {
    var o = p; // An array that is indexed by a variable must be one.
    // The part whose edge is nearest.
    var k = 2u;
    if weights.x <= weights.y && weights.x <= weights.z { k = 0u; } else if weights.y <= weights.z { k = 1u; }
    let i = (k + 1u) % 3u;
    let j = (k + 2u) % 3u;
    var w = weights;
    let u = w[i] - w[k];
    let v = w[j] - w[k];
    let s = 3.0 * w[k];
    let edge = u * u * (u * o[i] + 3.0 * v * o[3u + 2u * i]) + v * v * (3.0 * u * o[4u + 2u * j] + v * o[j]);
    let near = u * u * o[9u + i] + 2.0 * u * v * o[12u + k] + v * v * o[9u + j];
    return edge + s * (3.0 * near + s * (3.0 * (u * o[15u + i] + v * o[15u + j]) + s * o[18u]));
}
