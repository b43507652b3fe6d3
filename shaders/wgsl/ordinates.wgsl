// The numbers that c1_phong needs, computed on the graphics card for every view: first `slopes` with one invocation for
// each vertex, then `ordinates` with one for each triangle. Both have work groups of 64. Needs no other file.
//
// The curvature comes from curvature() in ordinates.js or ordinates.rs, once per mesh. The model-view matrix may rotate,
// move and scale, but not distort.

struct Camera {
    model_view: mat4x4f,
    projection: mat4x4f,
    // Width and height of the viewport in pixels.
    size: vec2f,
}

struct Vertex {
    position: vec4f,
    normal: vec4f,
    // dN/dp, a symmetric matrix, column by column.
    curvature: mat3x3f,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> vertices: array<Vertex>;
// Three vertices for each triangle, counterclockwise as seen from outside.
@group(0) @binding(2) var<storage, read> triangles: array<u32>;
// The corners of the triangles around each vertex v are ring[starts[v]] to ring[starts[v + 1] - 1]; each has the vertices
// that follow v and that precede it.
@group(0) @binding(3) var<storage, read> starts: array<u32>;
@group(0) @binding(4) var<storage, read> ring: array<vec2u>;
// The slopes of the normal and of z at each vertex, per pixel to the right and per pixel up.
@group(0) @binding(5) var<storage, read_write> gradients: array<Gradient>;
// Twelve for each triangle: normals and z in view space. All are zero if the triangle faces away or reaches behind the
// eye.
@group(0) @binding(6) var<storage, read_write> cubics: array<vec4f>;

struct Gradient {
    right: vec4f,
    up: vec4f,
}

// The weight of the neighboring vertices, relative to the curvature. They decide near silhouettes.
const RING = 0.07;
// The smallest sine of the angle between an edge and the direction across it.
const MIN_SINE = 0.1;
// A matrix with a smaller determinant, relative to its squared trace, has only one direction.
const FLAT = 1e-6;

fn eye_of(v: u32) -> vec3f {
    return (camera.model_view * vec4f(vertices[v].position.xyz, 1.0)).xyz;
}

fn normal_of(v: u32) -> vec3f {
    return normalize((camera.model_view * vec4f(vertices[v].normal.xyz, 0.0)).xyz);
}

// The place on the screen in pixels, and w of the projection.
fn screen_of(v: u32) -> vec3f {
    let place = camera.projection * vec4f(eye_of(v), 1.0);
    return vec3f(place.xy / place.w * camera.size / 2.0, place.w);
}

// The movement on the screen of a point that moves along `step`, per step.
fn moved(eye: vec3f, step: vec3f) -> vec2f {
    let place = camera.projection * vec4f(eye, 1.0);
    let change = camera.projection * vec4f(step, 0.0);
    return (change.xy * place.w - place.xy * change.w) / (place.w * place.w) * camera.size / 2.0;
}

fn toward_eye(eye: vec3f) -> vec3f {
    if camera.projection[3][3] == 1.0 {
        return vec3f(0.0, 0.0, 1.0);
    }
    return normalize(-eye);
}

fn turn(a: vec2f, b: vec2f) -> f32 {
    return a.x * b.y - a.y * b.x;
}

fn is_drawn(a: vec3f, b: vec3f, c: vec3f) -> bool {
    return min(a.z, min(b.z, c.z)) > 0.0 && turn(b.xy - a.xy, c.xy - a.xy) > 0.0;
}

// A unit vector perpendicular to both.
fn across_both(normal: vec3f, other: vec3f) -> vec3f {
    let across = cross(normal, other);
    if dot(across, across) >= 1e-9 {
        return normalize(across);
    }
    return normalize(cross(normal, select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(normal.x) < 0.6)));
}

// The change of the unit normal for a step in view space.
fn bent(v: u32, step: vec3f) -> vec3f {
    let turn = mat3x3f(camera.model_view[0].xyz, camera.model_view[1].xyz, camera.model_view[2].xyz);
    let squared = dot(turn[0], turn[0]);
    return turn * (vertices[v].curvature * (step * turn)) / (squared * sqrt(squared));
}

// The equations of a slope on the screen: observations of the change along an offset.
struct Equations {
    // Sums of x², xy and y².
    matrix: vec3f,
    right: vec4f,
    up: vec4f,
}

fn observed(sum: Equations, offset: vec2f, change: vec4f, weight: f32) -> Equations {
    let squares = vec3f(offset.x * offset.x, offset.x * offset.y, offset.y * offset.y);
    return Equations(
        sum.matrix + weight * squares,
        sum.right + weight * offset.x * change,
        sum.up + weight * offset.y * change,
    );
}

@compute @workgroup_size(64)
fn slopes(@builtin(global_invocation_id) id: vec3u) {
    let v = id.x;
    if v >= arrayLength(&vertices) {
        return;
    }
    let eye = eye_of(v);
    let normal = normal_of(v);
    let own = screen_of(v);
    var sum = Equations();
    for (var i = starts[v]; i < starts[v + 1u]; i++) {
        let pair = ring[i];
        let corner = array(screen_of(pair.x), screen_of(pair.y));
        if !is_drawn(own, corner[0], corner[1]) {
            continue;
        }
        for (var k = 0u; k < 2u; k++) {
            // A vertex that precedes v in one triangle follows it in the next one, and counts there.
            var is_counted = false;
            for (var j = starts[v]; k == 1u && j < starts[v + 1u]; j++) {
                is_counted |= ring[j].x == pair.y && is_drawn(own, corner[1], screen_of(ring[j].y));
            }
            let offset = corner[k].xy - own.xy;
            let squared = dot(offset, offset);
            if !is_counted && squared > 0.0 {
                let change = vec4f(normal_of(pair[k]) - normal, eye_of(pair[k]).z - eye.z);
                sum = observed(sum, offset, change, 1.0 / squared);
            }
        }
    }
    let trace = sum.matrix.x + sum.matrix.z;
    let weight = select(0.0, RING / trace, trace > 0.0);
    sum = Equations(sum.matrix * weight, sum.right * weight, sum.up * weight);
    // Two steps on the surface: across the line of sight, and away from the eye if the vertex faces it.
    let toward = toward_eye(eye);
    let across = across_both(normal, toward);
    let away = cross(normal, across);
    let pixels = length(moved(eye, across_both(toward, normal)));
    sum = observed(sum, moved(eye, across) / pixels, vec4f(bent(v, across), across.z) / pixels, 1.0);
    if dot(normal, toward) > 0.0 {
        sum = observed(sum, moved(eye, away) / pixels, vec4f(bent(v, away), away.z) / pixels, 1.0);
    }
    gradients[v] = solved(sum);
}

// The slope is zero in a direction that nothing determines.
fn solved(sum: Equations) -> Gradient {
    let m = sum.matrix;
    let determinant = m.x * m.z - m.y * m.y;
    let trace = m.x + m.z;
    if determinant > FLAT * trace * trace {
        return Gradient((m.z * sum.right - m.y * sum.up) / determinant, (m.x * sum.up - m.y * sum.right) / determinant);
    }
    if trace > 0.0 {
        return Gradient(sum.right / trace, sum.up / trace);
    }
    return Gradient();
}

@compute @workgroup_size(64)
fn ordinates(@builtin(global_invocation_id) id: vec3u) {
    let t = id.x;
    if 3u * t >= arrayLength(&triangles) {
        return;
    }
    let v = array(triangles[3u * t], triangles[3u * t + 1u], triangles[3u * t + 2u]);
    let screen = array(screen_of(v[0]), screen_of(v[1]), screen_of(v[2]));
    if !is_drawn(screen[0], screen[1], screen[2]) {
        for (var k = 0u; k < 12u; k++) {
            cubics[12u * t + k] = vec4f(0.0);
        }
        return;
    }
    let eye = array(eye_of(v[0]), eye_of(v[1]), eye_of(v[2]));
    let normal = array(normal_of(v[0]), normal_of(v[1]), normal_of(v[2]));
    let centroid = (screen[0].xy + screen[1].xy + screen[2].xy) / 3.0;
    var value: array<vec4f, 3>;
    var next: array<vec4f, 3>;
    var previous: array<vec4f, 3>;
    for (var i = 0u; i < 3u; i++) {
        let to_next = screen[(i + 1u) % 3u].xy - screen[i].xy;
        let to_previous = screen[(i + 2u) % 3u].xy - screen[i].xy;
        let slope = gradients[v[i]];
        value[i] = vec4f(normal[i], eye[i].z);
        next[i] = value[i] + (slope.right * to_next.x + slope.up * to_next.y) / 3.0;
        previous[i] = value[i] + (slope.right * to_previous.x + slope.up * to_previous.y) / 3.0;
    }
    for (var k = 0u; k < 3u; k++) {
        let i = (k + 1u) % 3u;
        let j = (k + 2u) % 3u;
        // Across the edge: the direction on the surface that is perpendicular to it, as seen on the screen.
        let edge = screen[j].xy - screen[i].xy;
        var across = moved((eye[i] + eye[j]) / 2.0, cross(normal[i] + normal[j], eye[j] - eye[i]));
        if abs(turn(across, edge)) <= MIN_SINE * length(across) * length(edge) {
            across = vec2f(-edge.y, edge.x);
        }
        // Where the line through the centroid meets the edge: 0 at corner i, 1 at corner j.
        let at = turn(centroid - screen[i].xy, across) / turn(edge, across);
        let near_i = (value[i] + next[i] + previous[i]) / 3.0;
        let near_j = (value[j] + next[j] + previous[j]) / 3.0;
        let middle = (near_i + near_j) / 2.0 + (1.0 - at) * (next[i] - (value[i] + previous[j]) / 2.0)
            + at * (previous[j] - (next[i] + value[j]) / 2.0);
        cubics[12u * t + k] = value[k];
        cubics[12u * t + 3u + k] = next[k];
        cubics[12u * t + 6u + k] = previous[k];
        cubics[12u * t + 9u + k] = middle;
    }
}
