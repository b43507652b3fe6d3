// Reads a triangle's ordinates from a texture, GLSL ES 3.00: RGBA32F without filtering, twelve texels for each triangle,
// row by row; the width must be a multiple of 12. Put it after patch.glsl.

uniform highp sampler2D ordinates;

in vec3 weights_times_w;
flat in int triangle;

// The weights of the corners, linear on the screen. GLSL ES has no noperspective. A varying v is interpolated as
// Σ b v / w divided by Σ b / w, where b are the weights on the screen, and gl_FragCoord.w is Σ b / w. With v = e w, the
// product of the two is Σ b e. This also holds for a triangle that the near plane clips.
vec3 corner_weights() {
    return weights_times_w * gl_FragCoord.w;
}

vec4 ordinate(int k) {
    int at = 12 * triangle + k, width = textureSize(ordinates, 0).x;
    return texelFetch(ordinates, ivec2(at % width, at / width), 0);
}

Patch patch_here() {
    Patch p;
    for (int k = 0; k < 3; k++) {
        p.corner[k] = ordinate(k);
        p.next[k] = ordinate(3 + k);
        p.previous[k] = ordinate(6 + k);
        p.middle[k] = ordinate(9 + k);
    }
    return p;
}
