// Intensity reweighting, Bangay §4.4: on top of any shader.

// Bangay eq. 9 as printed, `normal` the length of the interpolated normal.
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

// Repaired: over the whole triangle, and sparing the ambient light.
fn reweight_repaired(value: vec3f, normal: f32, ambient: vec3f) -> vec3f {
    return ambient + (value - ambient) / max(normal, 1e-3);
}
