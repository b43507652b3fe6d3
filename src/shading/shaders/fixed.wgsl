// Bangay eq. 4 as printed: t·I_n(t/b')·(I_A − I_E) + I_E, where `apex` is I_A and `on_edge` is I_E.
fn fixed_strip(apex: vec3f, on_edge: vec3f, t: f32, across: f32) -> vec3f {
    return on_edge + (apex - on_edge) * (t * interpolation(across));
}

