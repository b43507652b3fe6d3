// Vertex shading, Bangay §4.3, applied on top of any shader.

const PRINTED = 1u;
const REPAIRED = 2u;

// A corner and the other two: their weights, the steps on the screen to the other two, and their light values.
struct Around {
    w: vec3f,
    to_i: vec2f,
    to_j: vec2f,
    own: vec3f,
    i: vec3f,
    j: vec3f,
}

fn around(corners: vec3u, k: u32, w: vec3f) -> Around {
    let i = (k + 1u) % 3u;
    let j = (k + 2u) % 3u;
    let place = vertices[corners[k]].place.xy;
    return Around(
        vec3f(w[k], w[i], w[j]),
        vertices[corners[i]].place.xy - place,
        vertices[corners[j]].place.xy - place,
        vertices[corners[k]].light.rgb,
        vertices[corners[i]].light.rgb,
        vertices[corners[j]].light.rgb,
    );
}

// w_B²/(w_B² + w_C²).
fn squared_mix(a: Around) -> f32 {
    let scaled = a.w.yz / max(max(abs(a.w.y), abs(a.w.z)), 1e-30);
    let squares = scaled * scaled;
    return squares.x / max(squares.x + squares.y, 1e-30);
}

// 1 − d_A, Bangay eq. 7: 0 at the corner, 1 at the other two.
fn farness(a: Around, mixed: f32) -> f32 {
    let reach = length(a.to_i) * mixed + length(a.to_j) * (1.0 - mixed);
    let step = a.to_i * a.w.y + a.to_j * a.w.z;
    return dot(step, step) / (reach * reach);
}

// As printed: this darkens a uniform surface around its vertices.
fn vertex_printed(value: vec3f, corners: vec3u, w: vec3f, b: f32) -> vec3f {
    for (var k = 0u; k < 3u; k++) {
        if b > 0.0 && w[k] > 1.0 - 2.0 * b {
            let a = around(corners, k, w);
            let g = interpolation((1.0 - w[k]) / (2.0 * b));
            return value * g + a.own * ((1.0 - farness(a, squared_mix(a))) * (1.0 - g));
        }
    }
    return value;
}

// Repaired: the light approaches the neighbors' light instead of darkness.
fn vertex_repaired(value: vec3f, corners: vec3u, w: vec3f, b: f32) -> vec3f {
    let radius = 2.0 * min(b, 0.25);
    var corrected = value;
    for (var k = 0u; k < 3u; k++) {
        let a = around(corners, k, w);
        let mixed = squared_mix(a);
        let far = farness(a, mixed);
        let rho = sqrt(max(far, 0.0));
        if rho < radius {
            let neighbors = mix(a.j, a.i, mixed);
            let arc = neighbors + (a.own - neighbors) * (1.0 - far);
            // At wide angles, the arc reaches the opposite edge. No neighbor continues it there, so it must end at that
            // edge.
            corrected += (arc - value) * (smoothstep(0.0, 0.25, w[k]) * (1.0 - blend(rho / radius)));
        }
    }
    return corrected;
}

// Intensity reweighting, Bangay §4.4, applied on top of any shader.

// Bangay eq. 9 as printed; `normal` is the length of the interpolated normal.
fn reweight_printed(value: vec3f, normal: f32, w: vec3f, b: f32) -> vec3f {
    let k = smallest(w);
    let others = vec2f(w[(k + 1u) % 3u], w[(k + 2u) % 3u]);
    let width = min(b, min((1.0 - others.x) / 2.0, (1.0 - others.y) / 2.0));
    var inside = 1.0;
    if w[k] < width {
        inside = interpolation(w[k] / width);
    }
    return value / max(normal + (1.0 - normal) * inside, 1e-3);
}

// Repaired: applies to the whole triangle and leaves the ambient light unchanged.
fn reweight_repaired(value: vec3f, normal: f32, ambient: vec3f) -> vec3f {
    return ambient + (value - ambient) / max(normal, 1e-3);
}
