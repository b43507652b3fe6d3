// Bangay eq. 4, printed: t·I_n(t/b')·(I_A − I_E) + I_E. `apex` is I_A, `on_edge` I_E.
fn fixed_strip(apex: vec3f, on_edge: vec3f, t: f32, across: f32) -> vec3f {
    return on_edge + (apex - on_edge) * (t * interpolation(across));
}

