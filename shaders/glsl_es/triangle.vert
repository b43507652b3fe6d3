// The vertex shader of c1_phong and patch, GLSL ES 3.00. Put "#version 300 es" and "precision highp float;" before it;
// three.js does so itself. Draw un-indexed vertices: the three vertices of triangle t are 3t, 3t + 1 and 3t + 2,
// because each must know its triangle and its corner.

in vec3 position;
in vec3 normal;

uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform mat3 normalMatrix;

// In view space; interpolated as usual.
out vec3 view_position;
out vec3 view_normal;
// The weights of the corners times w of the projection; see corner_weights() in ordinates.glsl.
out vec3 weights_times_w;
flat out int triangle;

void main() {
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    view_position = place.xyz;
    view_normal = normalMatrix * normal;
    gl_Position = projectionMatrix * place;
    int corner = gl_VertexID % 3;
    weights_times_w = gl_Position.w * vec3(corner == 0, corner == 1, corner == 2);
    triangle = gl_VertexID / 3;
}
