// The numbers that c1_phong needs, computed on the graphics card for every view, GLSL 4.5: first with PASS 1 and one
// invocation for each vertex, then, after a barrier, with PASS 2 and one for each triangle. Put "#version 450" and
// "#define PASS 1" or "#define PASS 2" before it. Needs no other file.
//
// The curvature comes from curvature() in ordinates.js or ordinates.rs, once per mesh. The model-view matrix may rotate,
// move and scale, but not distort.

layout(local_size_x = 64) in;

layout(location = 0) uniform mat4 model_view;
layout(location = 1) uniform mat4 projection;
// Width and height of the viewport in pixels.
layout(location = 2) uniform vec2 size;

struct Vertex {
    vec4 position;
    vec4 normal;
    // dN/dp, a symmetric matrix, column by column.
    mat3 curvature;
};

// The slopes of the normal and of z at a vertex, per pixel to the right and per pixel up.
struct Gradient {
    vec4 right;
    vec4 up;
};

layout(std430, binding = 1) readonly buffer Vertices { Vertex vertices[]; };
// Three vertices for each triangle, counterclockwise as seen from outside.
layout(std430, binding = 2) readonly buffer Triangles { uint triangles[]; };
// The corners of the triangles around each vertex v are ring[starts[v]] to ring[starts[v + 1] - 1]; each has the vertices
// that follow v and that precede it.
layout(std430, binding = 3) readonly buffer Starts { uint starts[]; };
layout(std430, binding = 4) readonly buffer Ring { uvec2 ring[]; };
layout(std430, binding = 5) buffer Gradients { Gradient gradients[]; };
// Twelve for each triangle: normals and z in view space. All are zero if the triangle faces away or reaches behind the
// eye.
layout(std430, binding = 6) writeonly buffer Cubics { vec4 cubics[]; };

// The weight of the neighboring vertices, relative to the curvature. They decide near silhouettes.
const float RING = 0.07;
// The smallest sine of the angle between an edge and the direction across it.
const float MIN_SINE = 0.1;
// A matrix with a smaller determinant, relative to its squared trace, has only one direction.
const float FLAT = 1e-6;

vec3 eye_of(uint v) {
    return (model_view * vec4(vertices[v].position.xyz, 1.0)).xyz;
}

vec3 normal_of(uint v) {
    return normalize(mat3(model_view) * vertices[v].normal.xyz);
}

// The place on the screen in pixels, and w of the projection.
vec3 screen_of(uint v) {
    vec4 place = projection * vec4(eye_of(v), 1.0);
    return vec3(place.xy / place.w * size / 2.0, place.w);
}

// The movement on the screen of a point that moves along a step, per step.
vec2 moved(vec3 eye, vec3 step) {
    vec4 place = projection * vec4(eye, 1.0), change = projection * vec4(step, 0.0);
    return (change.xy * place.w - place.xy * change.w) / (place.w * place.w) * size / 2.0;
}

float turn(vec2 a, vec2 b) {
    return a.x * b.y - a.y * b.x;
}

bool is_drawn(vec3 a, vec3 b, vec3 c) {
    return min(a.z, min(b.z, c.z)) > 0.0 && turn(b.xy - a.xy, c.xy - a.xy) > 0.0;
}

#if PASS == 1

vec3 toward_eye(vec3 eye) {
    return projection[3][3] == 1.0 ? vec3(0.0, 0.0, 1.0) : normalize(-eye);
}

// A unit vector perpendicular to both.
vec3 across_both(vec3 normal, vec3 other) {
    vec3 across = cross(normal, other);
    if (dot(across, across) >= 1e-9) {
        return normalize(across);
    }
    return normalize(cross(normal, abs(normal.x) < 0.6 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0)));
}

// The change of the unit normal for a step in view space.
vec3 bent(uint v, vec3 step) {
    mat3 turned = mat3(model_view);
    float squared = dot(turned[0], turned[0]);
    return turned * (vertices[v].curvature * (step * turned)) / (squared * sqrt(squared));
}

// The equations of a slope on the screen: observations of the change along an offset. The matrix has the sums of x², xy
// and y².
vec3 matrix = vec3(0.0);
Gradient sums = Gradient(vec4(0.0), vec4(0.0));

void observe(vec2 offset, vec4 change, float weight) {
    matrix += weight * vec3(offset.x * offset.x, offset.x * offset.y, offset.y * offset.y);
    sums.right += weight * offset.x * change;
    sums.up += weight * offset.y * change;
}

// The slope is zero in a direction that nothing determines.
Gradient solved() {
    float determinant = matrix.x * matrix.z - matrix.y * matrix.y, trace = matrix.x + matrix.z;
    if (determinant > FLAT * trace * trace) {
        return Gradient(
            (matrix.z * sums.right - matrix.y * sums.up) / determinant,
            (matrix.x * sums.up - matrix.y * sums.right) / determinant
        );
    }
    if (trace > 0.0) {
        return Gradient(sums.right / trace, sums.up / trace);
    }
    return Gradient(vec4(0.0), vec4(0.0));
}

void main() {
    uint v = gl_GlobalInvocationID.x;
    if (v >= uint(vertices.length())) {
        return;
    }
    vec3 eye = eye_of(v), normal = normal_of(v), own = screen_of(v);
    for (uint i = starts[v]; i < starts[v + 1]; i++) {
        vec3 corners[2] = vec3[2](screen_of(ring[i].x), screen_of(ring[i].y));
        if (!is_drawn(own, corners[0], corners[1])) {
            continue;
        }
        for (int k = 0; k < 2; k++) {
            // A vertex that precedes v in one triangle follows it in the next one, and counts there.
            bool is_counted = false;
            for (uint j = starts[v]; k == 1 && j < starts[v + 1]; j++) {
                is_counted = is_counted || ring[j].x == ring[i].y && is_drawn(own, corners[1], screen_of(ring[j].y));
            }
            vec2 offset = corners[k].xy - own.xy;
            float squared = dot(offset, offset);
            if (!is_counted && squared > 0.0) {
                uint other = ring[i][k];
                observe(offset, vec4(normal_of(other) - normal, eye_of(other).z - eye.z), 1.0 / squared);
            }
        }
    }
    float trace = matrix.x + matrix.z, weight = trace > 0.0 ? RING / trace : 0.0;
    matrix *= weight;
    sums = Gradient(sums.right * weight, sums.up * weight);
    // Two steps on the surface: across the line of sight, and away from the eye if the vertex faces it.
    vec3 toward = toward_eye(eye), across = across_both(normal, toward), away = cross(normal, across);
    float pixels = length(moved(eye, across_both(toward, normal)));
    observe(moved(eye, across) / pixels, vec4(bent(v, across), across.z) / pixels, 1.0);
    if (dot(normal, toward) > 0.0) {
        observe(moved(eye, away) / pixels, vec4(bent(v, away), away.z) / pixels, 1.0);
    }
    gradients[v] = solved();
}

#else

void main() {
    uint t = gl_GlobalInvocationID.x;
    if (3 * t >= uint(triangles.length())) {
        return;
    }
    uint v[3] = uint[3](triangles[3 * t], triangles[3 * t + 1], triangles[3 * t + 2]);
    vec3 screen[3] = vec3[3](screen_of(v[0]), screen_of(v[1]), screen_of(v[2]));
    if (!is_drawn(screen[0], screen[1], screen[2])) {
        for (uint k = 0; k < 12; k++) {
            cubics[12 * t + k] = vec4(0.0);
        }
        return;
    }
    vec3 eye[3] = vec3[3](eye_of(v[0]), eye_of(v[1]), eye_of(v[2]));
    vec3 normal[3] = vec3[3](normal_of(v[0]), normal_of(v[1]), normal_of(v[2]));
    vec2 middle_place = (screen[0].xy + screen[1].xy + screen[2].xy) / 3.0;
    vec4 value[3], next[3], previous[3];
    for (int i = 0; i < 3; i++) {
        vec2 to_next = screen[(i + 1) % 3].xy - screen[i].xy, to_previous = screen[(i + 2) % 3].xy - screen[i].xy;
        Gradient slope = gradients[v[i]];
        value[i] = vec4(normal[i], eye[i].z);
        next[i] = value[i] + (slope.right * to_next.x + slope.up * to_next.y) / 3.0;
        previous[i] = value[i] + (slope.right * to_previous.x + slope.up * to_previous.y) / 3.0;
    }
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        // Across the edge: the direction on the surface that is perpendicular to it, as seen on the screen.
        vec2 edge = screen[j].xy - screen[i].xy;
        vec2 across = moved((eye[i] + eye[j]) / 2.0, cross(normal[i] + normal[j], eye[j] - eye[i]));
        if (abs(turn(across, edge)) <= MIN_SINE * length(across) * length(edge)) {
            across = vec2(-edge.y, edge.x);
        }
        // Where the line through the centroid meets the edge: 0 at corner i, 1 at corner j.
        float at = turn(middle_place - screen[i].xy, across) / turn(edge, across);
        vec4 near_i = (value[i] + next[i] + previous[i]) / 3.0, near_j = (value[j] + next[j] + previous[j]) / 3.0;
        vec4 middle = (near_i + near_j) / 2.0 + (1.0 - at) * (next[i] - (value[i] + previous[j]) / 2.0)
            + at * (previous[j] - (next[i] + value[j]) / 2.0);
        cubics[12 * t + k] = value[k];
        cubics[12 * t + 3 + k] = next[k];
        cubics[12 * t + 6 + k] = previous[k];
        cubics[12 * t + 9 + k] = middle;
    }
}

#endif
