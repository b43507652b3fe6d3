// I_F, the light on the neighbor's far edge, Bangay eqs. 5 and 6, from the light values at the edge's ends and at the
// neighbor's apex.
fn beyond_edge(i: vec3f, j: vec3f, apex: vec3f, others: vec2f) -> vec3f {
    let a = 2.0 * others.x / (others.x + others.y) - 1.0;
    if a < 0.0 {
        return mix(apex, j, -2.0 * a / (1.0 - a));
    }
    return mix(apex, i, 2.0 * a / (1.0 + a));
}
