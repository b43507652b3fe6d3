// A smooth field over a mesh: a reduced Clough–Tocher cubic whose slope is continuous over the whole surface. Used for
// the light of *patch* and for the normals of *c1-phong*. Needs no other file.

// A triangle's Bézier ordinates. For each corner: its value, and the ordinates a third of the way to the next corner
// and to the one after it. For each edge (opposite corner A, B, or C): the middle ordinate of the third of the triangle
// at that edge.
struct Patch {
    corner: array<vec4f, 3>,
    next: array<vec4f, 3>,
    previous: array<vec4f, 3>,
    middle: array<vec4f, 3>,
}

// Returns the value at a pixel, where `w` are the weights of the three corners, linear on the screen.
fn patch_value(p: Patch, w: vec3f) -> vec4f {
    // The other ordinates follow: a third of the way from each corner to the centroid, two thirds of the way, and at
    // the centroid.
    let near_a = (p.corner[0] + p.next[0] + p.previous[0]) / 3.0;
    let near_b = (p.corner[1] + p.next[1] + p.previous[1]) / 3.0;
    let near_c = (p.corner[2] + p.next[2] + p.previous[2]) / 3.0;
    let far_a = (near_a + p.middle[1] + p.middle[2]) / 3.0;
    let far_b = (near_b + p.middle[2] + p.middle[0]) / 3.0;
    let far_c = (near_c + p.middle[0] + p.middle[1]) / 3.0;
    let center = (far_a + far_b + far_c) / 3.0;
    // The third of the triangle that contains the pixel is at the edge opposite the corner with the smallest weight.
    if w.x <= w.y && w.x <= w.z {
        let edge = edge_cubic(p.corner[1], p.next[1], p.previous[2], p.corner[2], w.yz - w.x);
        return third_value(edge, near_b, p.middle[0], near_c, far_b, far_c, center, w.yz - w.x, 3.0 * w.x);
    }
    if w.y <= w.z {
        let edge = edge_cubic(p.corner[2], p.next[2], p.previous[0], p.corner[0], w.zx - w.y);
        return third_value(edge, near_c, p.middle[1], near_a, far_c, far_a, center, w.zx - w.y, 3.0 * w.y);
    }
    let edge = edge_cubic(p.corner[0], p.next[0], p.previous[1], p.corner[1], w.xy - w.z);
    return third_value(edge, near_a, p.middle[2], near_b, far_a, far_b, center, w.xy - w.z, 3.0 * w.z);
}

// u³b₀ + 3u²v·b₁ + 3uv²·b₂ + v³b₃.
fn edge_cubic(b0: vec4f, b1: vec4f, b2: vec4f, b3: vec4f, uv: vec2f) -> vec4f {
    return uv.x * uv.x * (uv.x * b0 + 3.0 * uv.y * b1) + uv.y * uv.y * (3.0 * uv.x * b2 + uv.y * b3);
}

// The cubic of one third: u and v are the weights of the edge's ends, and s is the weight of the centroid.
fn third_value(
    edge: vec4f,
    near_i: vec4f,
    middle: vec4f,
    near_j: vec4f,
    far_i: vec4f,
    far_j: vec4f,
    center: vec4f,
    uv: vec2f,
    s: f32,
) -> vec4f {
    let near = uv.x * uv.x * near_i + 2.0 * uv.x * uv.y * middle + uv.y * uv.y * near_j;
    return edge + s * (3.0 * near + s * (3.0 * (uv.x * far_i + uv.y * far_j) + s * center));
}
