// The coefficients of C1 normals, computed on the graphics card for every view. First `slopes`, then `coefficients`: as
// compute passes, with one invocation for each point and then for each triangle and work groups of 64, or, where there is
// no compute shader, as `slopes_texel` and `coefficients_texel`, which draw one triangle over the whole target. Needs no
// other file.
//
// The points come from Surface in ordinates.rs or curvature() in ordinates.js, once per mesh. The model-view matrix may rotate,
// move and scale, but not distort. Textures are filled row by row; their widths are multiples of the texels of an entry.

struct Camera {
    model_view: mat4x4f,
    projection: mat4x4f,
    // Width and height of the viewport in pixels.
    size: vec2f,
    // How many there are; only the compute passes need it.
    points: u32,
    triangles: u32,
    // Width of the target in texels; only the passes that draw need it.
    width: u32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
// Five texels for each point: its position and where its list in `ring` starts; its normal and where the list ends; and
// the columns of dN/dp, a symmetric matrix.
@group(0) @binding(1) var points: texture_2d<f32>;
// For each triangle in a point's list, the points that follow and that precede, and the third point of the triangle across
// the edge to the one that precedes, or the point itself.
@group(0) @binding(2) var ring: texture_2d<u32>;
// Three texels for each triangle, one for each corner: its point, and the points whose slopes count along the edges to
// the next corner and to the previous one.
@group(0) @binding(3) var corners: texture_2d<u32>;
// Two texels for each point, as the first pass writes them: the slopes of the normal per pixel to the right and up.
@group(0) @binding(4) var gradients: texture_2d<f32>;
@group(0) @binding(5) var slopes_out: texture_storage_2d<rgba32float, write>;
// Nine texels for each triangle: twelve coefficients of three components. All are zero if the triangle faces away or
// reaches behind the eye.
@group(0) @binding(6) var coefficients_out: texture_storage_2d<rgba32float, write>;

// The weight of the neighboring vertices, relative to the curvature. They decide near silhouettes.
const RING = 0.07;
// The cosine between the normal and the direction to the eye below which the curvature counts less.
const FACING = 0.05;
// The smallest sine of the angle between an edge and the direction across it.
const MIN_SINE = 0.1;
// A matrix with a smaller determinant, relative to its squared trace, has only one direction.
const FLAT = 1e-6;

fn texel(at: u32, width: u32) -> vec2u {
    return vec2u(at % width, at / width);
}

fn point(v: u32, which: u32) -> vec4f {
    return textureLoad(points, texel(5u * v + which, textureDimensions(points).x), 0);
}

fn around(at: u32) -> vec3u {
    return textureLoad(ring, texel(at, textureDimensions(ring).x), 0).xyz;
}

fn eye_of(v: u32) -> vec3f {
    return (camera.model_view * vec4f(point(v, 0u).xyz, 1.0)).xyz;
}

fn normal_of(v: u32) -> vec3f {
    return normalize((camera.model_view * vec4f(point(v, 1u).xyz, 0.0)).xyz);
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
    let curvature = mat3x3f(point(v, 2u).xyz, point(v, 3u).xyz, point(v, 4u).xyz);
    let squared = dot(turn[0], turn[0]);
    return turn * (curvature * (step * turn)) / (squared * sqrt(squared));
}

// The equations of a slope on the screen: observations of the change along an offset.
struct Equations {
    // Sums of x², xy and y².
    matrix: vec3f,
    right: vec3f,
    up: vec3f,
}

fn observed(sum: Equations, offset: vec2f, change: vec3f, weight: f32) -> Equations {
    let squares = vec3f(offset.x * offset.x, offset.x * offset.y, offset.y * offset.y);
    return Equations(
        sum.matrix + weight * squares,
        sum.right + weight * offset.x * change,
        sum.up + weight * offset.y * change,
    );
}

// The slopes of the normal, per pixel to the right and per pixel up.
struct Slope {
    right: vec3f,
    up: vec3f,
}

fn slope_of(v: u32) -> Slope {
    let eye = eye_of(v);
    let normal = normal_of(v);
    let own = screen_of(v);
    let start = u32(point(v, 0u).w);
    let end = u32(point(v, 1u).w);
    var sum = Equations(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    for (var i = start; i < end; i++) {
        let others = around(i);
        let next = screen_of(others.x);
        let previous = screen_of(others.y);
        if is_drawn(own, next, previous) {
            sum = neighbor(sum, others.x, next.xy - own.xy, normal);
            // A point that precedes v in one triangle follows it in the next one, and counts there.
            if !is_drawn(own, previous, screen_of(others.z)) {
                sum = neighbor(sum, others.y, previous.xy - own.xy, normal);
            }
        }
    }
    let trace = sum.matrix.x + sum.matrix.z;
    let weight = select(0.0, RING / trace, trace > 0.0);
    sum = Equations(sum.matrix * weight, sum.right * weight, sum.up * weight);
    // Two steps on the surface: across the line of sight, and away from the eye.
    let toward = toward_eye(eye);
    let across = across_both(normal, toward);
    let away = cross(normal, across);
    let pixels = length(moved(eye, across_both(toward, normal)));
    let facing = clamp(dot(normal, toward) / FACING, 0.0, 1.0);
    sum = observed(sum, moved(eye, across) / pixels, bent(v, across) / pixels, facing);
    sum = observed(sum, moved(eye, away) / pixels, bent(v, away) / pixels, facing);
    return solved(sum);
}

fn neighbor(sum: Equations, other: u32, offset: vec2f, normal: vec3f) -> Equations {
    let squared = dot(offset, offset);
    if squared > 0.0 {
        return observed(sum, offset, normal_of(other) - normal, 1.0 / squared);
    }
    return sum;
}

// The slope is zero in a direction that nothing determines.
fn solved(sum: Equations) -> Slope {
    let m = sum.matrix;
    let determinant = m.x * m.z - m.y * m.y;
    let trace = m.x + m.z;
    if determinant > FLAT * trace * trace {
        return Slope((m.z * sum.right - m.y * sum.up) / determinant, (m.x * sum.up - m.y * sum.right) / determinant);
    }
    let scale = select(0.0, 1.0 / trace, trace > 0.0);
    return Slope(sum.right * scale, sum.up * scale);
}

// The change of the normal along a step on the screen, by the slope of point v.
fn along(v: u32, step: vec2f) -> vec3f {
    let width = textureDimensions(gradients).x;
    let right = textureLoad(gradients, texel(2u * v, width), 0).xyz;
    let up = textureLoad(gradients, texel(2u * v + 1u, width), 0).xyz;
    return right * step.x + up * step.y;
}

// Where the line across the edge from i to j through the centroid meets the edge: 0 at i, 1 at j. Across is the
// direction on the surface that is perpendicular to the edge, as seen on the screen.
fn crossing(i: vec2f, j: vec2f, centroid: vec2f, eyes: mat2x3f, normals: vec3f) -> f32 {
    let edge = j - i;
    var across = moved((eyes[0] + eyes[1]) / 2.0, cross(normals, eyes[1] - eyes[0]));
    if abs(turn(across, edge)) <= MIN_SINE * length(across) * length(edge) {
        across = vec2f(-edge.y, edge.x);
    }
    return turn(centroid - i, across) / turn(edge, across);
}

// The ordinate in the middle of the part at the edge from i to j.
fn middle(x: f32, i: vec3f, ij: vec3f, ji: vec3f, j: vec3f, near_i: vec3f, near_j: vec3f) -> vec3f {
    return (near_i + near_j) / 2.0 + (1.0 - x) * (ij - (i + ji) / 2.0) + x * (ji - (ij + j) / 2.0);
}

// Twelve coefficients in nine texels; cubic() in ordinates.rs says how they follow from the ordinates.
fn cubic_of(t: u32) -> array<vec4f, 9> {
    let width = textureDimensions(corners).x;
    let ia = textureLoad(corners, texel(3u * t, width), 0).xyz;
    let ib = textureLoad(corners, texel(3u * t + 1u, width), 0).xyz;
    let ic = textureLoad(corners, texel(3u * t + 2u, width), 0).xyz;
    let pa = screen_of(ia.x);
    let pb = screen_of(ib.x);
    let pc = screen_of(ic.x);
    if !is_drawn(pa, pb, pc) {
        let zero = vec4f(0.0);
        return array(zero, zero, zero, zero, zero, zero, zero, zero, zero);
    }
    let ea = eye_of(ia.x);
    let eb = eye_of(ib.x);
    let ec = eye_of(ic.x);
    let a = normal_of(ia.x);
    let b = normal_of(ib.x);
    let c = normal_of(ic.x);
    let centroid = (pa.xy + pb.xy + pc.xy) / 3.0;
    // The ordinates a third of the way along each edge, from both ends.
    let ab = a + along(ia.y, pb.xy - pa.xy) / 3.0;
    let ac = a + along(ia.z, pc.xy - pa.xy) / 3.0;
    let bc = b + along(ib.y, pc.xy - pb.xy) / 3.0;
    let ba = b + along(ib.z, pa.xy - pb.xy) / 3.0;
    let ca = c + along(ic.y, pa.xy - pc.xy) / 3.0;
    let cb = c + along(ic.z, pb.xy - pc.xy) / 3.0;
    // Toward the centroid: a third of the way, in the middle of each edge's part, two thirds of the way, and there.
    let na = (a + ab + ac) / 3.0;
    let nb = (b + bc + ba) / 3.0;
    let nc = (c + ca + cb) / 3.0;
    let ma = middle(crossing(pb.xy, pc.xy, centroid, mat2x3f(eb, ec), b + c), b, bc, cb, c, nb, nc);
    let mb = middle(crossing(pc.xy, pa.xy, centroid, mat2x3f(ec, ea), c + a), c, ca, ac, a, nc, na);
    let mc = middle(crossing(pa.xy, pb.xy, centroid, mat2x3f(ea, eb), a + b), a, ab, ba, b, na, nb);
    let fa = (na + mb + mc) / 3.0;
    let fb = (nb + mc + ma) / 3.0;
    let fc = (nc + ma + mb) / 3.0;
    let n = (fa + fb + fc) / 3.0;
    let cube_a = a - 3.0 * na + 3.0 * fa - n;
    let cube_b = b - 3.0 * nb + 3.0 * fb - n;
    let cube_c = c - 3.0 * nc + 3.0 * fc - n;
    let dab = 3.0 * (ab - na - 2.0 * mc + 2.0 * fa + fb - n);
    let dba = 3.0 * (ba - nb - 2.0 * mc + 2.0 * fb + fa - n);
    let dac = 3.0 * (ac - na - 2.0 * mb + 2.0 * fa + fc - n);
    let dca = 3.0 * (ca - nc - 2.0 * mb + 2.0 * fc + fa - n);
    let dbc = 3.0 * (bc - nb - 2.0 * ma + 2.0 * fb + fc - n);
    let dcb = 3.0 * (cb - nc - 2.0 * ma + 2.0 * fc + fb - n);
    let k1 = 3.0 * (fa - n);
    let k2 = 3.0 * (fb - n);
    let k3 = 3.0 * (na - 2.0 * fa + n);
    let k4 = 6.0 * (mc - fa - fb + n);
    let k5 = 3.0 * (nb - 2.0 * fb + n);
    let k10 = -(cube_c + dca + dac + cube_a) - cube_b;
    let k11 = -(cube_b + dbc + dcb + cube_c) - cube_a;
    return array(
        vec4f(n, k1.x),
        vec4f(k1.yz, k2.xy),
        vec4f(k2.z, k3),
        vec4f(k4, k5.x),
        vec4f(k5.yz, cube_a.xy),
        vec4f(cube_a.z, dab),
        vec4f(dba, cube_b.x),
        vec4f(cube_b.yz, k10.xy),
        vec4f(k10.z, k11),
    );
}

@compute @workgroup_size(64)
fn slopes(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= camera.points {
        return;
    }
    let slope = slope_of(id.x);
    let width = textureDimensions(slopes_out).x;
    textureStore(slopes_out, texel(2u * id.x, width), vec4f(slope.right, 0.0));
    textureStore(slopes_out, texel(2u * id.x + 1u, width), vec4f(slope.up, 0.0));
}

@compute @workgroup_size(64)
fn coefficients(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= camera.triangles {
        return;
    }
    let cubic = cubic_of(id.x);
    let width = textureDimensions(coefficients_out).x;
    for (var k = 0u; k < 9u; k++) {
        textureStore(coefficients_out, texel(9u * id.x + k, width), cubic[k]);
    }
}

// A triangle that covers the target.
@vertex
fn everywhere(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn index_of(place: vec4f) -> u32 {
    return u32(place.y) * camera.width + u32(place.x);
}

@fragment
fn slopes_texel(@builtin(position) place: vec4f) -> @location(0) vec4f {
    let at = index_of(place);
    let slope = slope_of(at / 2u);
    return vec4f(select(slope.right, slope.up, at % 2u == 1u), 0.0);
}

@fragment
fn coefficients_texel(@builtin(position) place: vec4f) -> @location(0) vec4f {
    let at = index_of(place);
    let cubic = cubic_of(at / 9u);
    return cubic[at % 9u];
}
