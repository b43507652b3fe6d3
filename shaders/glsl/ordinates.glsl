// Reads a triangle's ordinates from a storage buffer, GLSL 4.5: twelve vec4 for each triangle, as ordinates.comp,
// ordinates.js and ordinates.rs write them. Put it after patch.glsl.

layout(std430, binding = 0) readonly buffer Ordinates { vec4 ordinates[]; };

Patch patch_of(int triangle) {
    Patch p;
    for (int k = 0; k < 3; k++) {
        p.corner[k] = ordinates[12 * triangle + k];
        p.next[k] = ordinates[12 * triangle + 3 + k];
        p.previous[k] = ordinates[12 * triangle + 6 + k];
        p.middle[k] = ordinates[12 * triangle + 9 + k];
    }
    return p;
}
