// A smooth field over a mesh: a reduced Clough–Tocher cubic whose slope is continuous over the whole surface. Includes
// the pixel shader of patch, light that was computed at the vertices. Needs no other file.

// Twelve numbers of four components for each triangle. For each corner: its value (0…2), and the ordinates a third of
// the way to the next corner (3…5) and to the one after it (6…8). For each edge (opposite corner A, B, or C): the middle
// ordinate of the third of the triangle at that edge (9…11).
StructuredBuffer<float4> ordinates : register(t0);

struct Pixel {
    float4 position : SV_Position;
    // In view space; interpolated as usual.
    float3 view_position : TEXCOORD0;
    float3 view_normal : TEXCOORD1;
    // The weights of the corners, linear on the screen.
    noperspective float3 weights : TEXCOORD2;
    nointerpolation uint which : TEXCOORD3;
};

// The cubic of one third: uv are the weights of the edge's ends after three times the smallest weight, s, has gone to
// the centroid.
float4 third_value(
    float4 b0, float4 b1, float4 b2, float4 b3, float4 near_i, float4 middle, float4 near_j, float4 far_i, float4 far_j,
    float4 center, float2 uv, float s
) {
    float4 edge = uv.x * uv.x * (uv.x * b0 + 3.0 * uv.y * b1) + uv.y * uv.y * (3.0 * uv.x * b2 + uv.y * b3);
    float4 near = uv.x * uv.x * near_i + 2.0 * uv.x * uv.y * middle + uv.y * uv.y * near_j;
    return edge + s * (3.0 * near + s * (3.0 * (uv.x * far_i + uv.y * far_j) + s * center));
}

// Returns the value at a pixel of a triangle, where w are the weights of the three corners, linear on the screen.
float4 patch_value(uint triangle_index, float3 w) {
    uint at = 12 * triangle_index;
    float4 a = ordinates[at], b = ordinates[at + 1], c = ordinates[at + 2];
    float4 ab = ordinates[at + 3], bc = ordinates[at + 4], ca = ordinates[at + 5];
    float4 ac = ordinates[at + 6], ba = ordinates[at + 7], cb = ordinates[at + 8];
    float4 middle_a = ordinates[at + 9], middle_b = ordinates[at + 10], middle_c = ordinates[at + 11];
    // The other ordinates follow: a third of the way from each corner to the centroid, two thirds of the way, and at
    // the centroid.
    float4 near_a = (a + ab + ac) / 3.0, near_b = (b + bc + ba) / 3.0, near_c = (c + ca + cb) / 3.0;
    float4 far_a = (near_a + middle_b + middle_c) / 3.0;
    float4 far_b = (near_b + middle_c + middle_a) / 3.0;
    float4 far_c = (near_c + middle_a + middle_b) / 3.0;
    float4 center = (far_a + far_b + far_c) / 3.0;
    // The third of the triangle that contains the pixel is at the edge opposite the corner with the smallest weight.
    if (w.x <= w.y && w.x <= w.z) {
        return third_value(b, bc, cb, c, near_b, middle_a, near_c, far_b, far_c, center, w.yz - w.x, 3.0 * w.x);
    }
    if (w.y <= w.z) {
        return third_value(c, ca, ac, a, near_c, middle_b, near_a, far_c, far_a, center, w.zx - w.y, 3.0 * w.y);
    }
    return third_value(a, ab, ba, b, near_a, middle_c, near_b, far_a, far_b, center, w.xy - w.z, 3.0 * w.z);
}

// True if the triangle has ordinates. It has none if it faces away or reaches behind the eye.
bool has_patch(uint triangle_index) {
    return any(ordinates[12 * triangle_index] != float4(0.0, 0.0, 0.0, 0.0));
}

// Returns linear light; the target should have an sRGB format. The ordinates are those of the light, with 1 as the
// fourth number.
float4 patch_pixel(Pixel input) : SV_Target {
    return float4(patch_value(input.which, input.weights).rgb, 1.0);
}
