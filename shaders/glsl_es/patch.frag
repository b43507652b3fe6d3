// patch: light that was computed at the vertices, GLSL ES 3.00. Put it after patch.glsl and ordinates.glsl. The
// ordinates are those of the light, with 1 as the fourth number.

out vec4 color;

void main() {
    // A triangle without ordinates faces away.
    color = vec4(patch_value(patch_here(), corner_weights()).rgb, 1.0);
}
