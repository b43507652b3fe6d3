// patch: light that was computed at the vertices, GLSL 4.5. Put "#version 450", patch.glsl and ordinates.glsl before
// it. The ordinates are those of the light, with 1 as the fourth number.

layout(location = 2) noperspective in vec3 weights;
layout(location = 3) flat in int triangle;

// Linear light; the target should have an sRGB format.
layout(location = 0) out vec4 color;

void main() {
    // A triangle without ordinates faces away.
    color = vec4(patch_value(patch_of(triangle), weights).rgb, 1.0);
}
