// A smooth field over a mesh: a reduced Clough–Tocher cubic whose slope is continuous over the whole surface. Valid in
// GLSL 4.5 and in GLSL ES 3.00. Needs no other file.

// A triangle's Bézier ordinates. For each corner: its value, and the ordinates a third of the way to the next corner
// and to the one after it. For each edge (opposite corner A, B, or C): the middle ordinate of the third of the triangle
// at that edge.
struct Patch {
    vec4 corner[3];
    vec4 next[3];
    vec4 previous[3];
    vec4 middle[3];
};

// The cubic of one third: uv are the weights of the edge's ends after three times the smallest weight, s, has gone to
// the centroid.
vec4 third_value(
    vec4 b0, vec4 b1, vec4 b2, vec4 b3, vec4 near_i, vec4 middle, vec4 near_j, vec4 far_i, vec4 far_j, vec4 center,
    vec2 uv, float s
) {
    vec4 edge = uv.x * uv.x * (uv.x * b0 + 3.0 * uv.y * b1) + uv.y * uv.y * (3.0 * uv.x * b2 + uv.y * b3);
    vec4 near = uv.x * uv.x * near_i + 2.0 * uv.x * uv.y * middle + uv.y * uv.y * near_j;
    return edge + s * (3.0 * near + s * (3.0 * (uv.x * far_i + uv.y * far_j) + s * center));
}

// Returns the value at a pixel, where w are the weights of the three corners, linear on the screen.
vec4 patch_value(Patch p, vec3 w) {
    // The other ordinates follow: a third of the way from each corner to the centroid, two thirds of the way, and at
    // the centroid.
    vec4 near_a = (p.corner[0] + p.next[0] + p.previous[0]) / 3.0;
    vec4 near_b = (p.corner[1] + p.next[1] + p.previous[1]) / 3.0;
    vec4 near_c = (p.corner[2] + p.next[2] + p.previous[2]) / 3.0;
    vec4 far_a = (near_a + p.middle[1] + p.middle[2]) / 3.0;
    vec4 far_b = (near_b + p.middle[2] + p.middle[0]) / 3.0;
    vec4 far_c = (near_c + p.middle[0] + p.middle[1]) / 3.0;
    vec4 center = (far_a + far_b + far_c) / 3.0;
    // The third of the triangle that contains the pixel is at the edge opposite the corner with the smallest weight.
    if (w.x <= w.y && w.x <= w.z) {
        return third_value(p.corner[1], p.next[1], p.previous[2], p.corner[2], near_b, p.middle[0], near_c,
                           far_b, far_c, center, w.yz - w.x, 3.0 * w.x);
    }
    if (w.y <= w.z) {
        return third_value(p.corner[2], p.next[2], p.previous[0], p.corner[0], near_c, p.middle[1], near_a,
                           far_c, far_a, center, w.zx - w.y, 3.0 * w.y);
    }
    return third_value(p.corner[0], p.next[0], p.previous[1], p.corner[1], near_a, p.middle[2], near_b,
                       far_a, far_b, center, w.xy - w.z, 3.0 * w.z);
}

// True if the triangle has ordinates. It has none if it faces away or reaches behind the eye.
bool has_patch(Patch p) {
    return p.corner[0] != vec4(0.0);
}
