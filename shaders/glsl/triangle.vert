// The vertex shader of c1_phong and patch, GLSL 4.5. Put "#version 450" before it. Draw un-indexed vertices: the three
// vertices of triangle t are 3t, 3t + 1 and 3t + 2, because each must know its triangle and its corner.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;

layout(location = 0) uniform mat4 model_view;
layout(location = 1) uniform mat4 projection;

// In view space; interpolated as usual.
layout(location = 0) out vec3 view_position;
layout(location = 1) out vec3 view_normal;
// The weights of the corners, linear on the screen.
layout(location = 2) noperspective out vec3 weights;
layout(location = 3) flat out int triangle;

void main() {
    vec4 place = model_view * vec4(position, 1.0);
    view_position = place.xyz;
    view_normal = mat3(model_view) * normal;
    int corner = gl_VertexID % 3;
    weights = vec3(corner == 0, corner == 1, corner == 2);
    triangle = gl_VertexID / 3;
    gl_Position = projection * place;
}
