// The light of a pixel, by the shader chosen, then the corrections.

// The order of `Shader::ALL`.
const FLAT = 0u;
const GOURAUD = 1u;
const PHONG = 2u;
const QUADRATIC = 3u;
const FIXED = 4u;
const GRADIENT = 5u;
const GRADIENT_REPAIRED = 6u;
const EXACT = 7u;
const CUT = 8u;
const PATCH = 9u;

fn pixel_light(t: Corner, w: vec3f) -> vec3f {
    var light = shaded(t, w);
    let b = min(globals.boundary, 1.0 / 3.0);
    if VERTEX == PRINTED {
        light = vertex_printed(light, triangles[t.triangle].corners, w, b);
    }
    if VERTEX == REPAIRED {
        light = vertex_repaired(light, triangles[t.triangle].corners, w, b);
    }
    if REWEIGHT == PRINTED {
        light = reweight_printed(light, normal_length(t.triangle, w), w, b);
    }
    if REWEIGHT == REPAIRED {
        light = reweight_repaired(light, normal_length(t.triangle, w), ambient_at(t.triangle, w));
    }
    return light;
}

fn shaded(t: Corner, w: vec3f) -> vec3f {
    let b = globals.boundary;
    switch SHADER {
        case FLAT: {
            // Every entry is the triangle's light.
            return t.a1.rgb;
        }
        case PHONG: {
            let normal = t.a0.xyz * w.x + t.b0.xyz * w.y + t.c0.xyz * w.z;
            let place = t.a1.xyz * w.x + t.b1.xyz * w.y + t.c1.xyz * w.z;
            return light_at(place, normalized(normal));
        }
        case QUADRATIC: {
            // Row 1: how far the middle of each edge bulges, four times.
            let bulge = w.yzx * w.zxy;
            return gouraud(t, w) + t.a1.rgb * bulge.x + t.b1.rgb * bulge.y + t.c1.rgb * bulge.z;
        }
        case FIXED, GRADIENT, GRADIENT_REPAIRED: {
            return printed(t, w, b);
        }
        case EXACT: {
            // Row 1: c of each edge.
            if b <= 0.0 {
                return gouraud(t, w);
            }
            return gouraud(t, w) + exact_strip(t.a1.rgb, w.x, w.yz, b) + exact_strip(t.b1.rgb, w.y, w.zx, b)
                + exact_strip(t.c1.rgb, w.z, w.xy, b);
        }
        case CUT: {
            // Row 1: c and foot of each edge; row 2: its reaches.
            if b <= 0.0 {
                return gouraud(t, w);
            }
            return gouraud(t, w) + cut_strip(t.a1.rgb, t.a1.w, t.a2.xy, w.x, w.yz, b)
                + cut_strip(t.b1.rgb, t.b1.w, t.b2.xy, w.y, w.zx, b)
                + cut_strip(t.c1.rgb, t.c1.w, t.c2.xy, w.z, w.xy, b);
        }
        case PATCH: {
            let light = array(t.a0.rgb, t.b0.rgb, t.c0.rgb);
            let next = array(t.a1.rgb, t.b1.rgb, t.c1.rgb);
            let previous = array(t.a2.rgb, t.b2.rgb, t.c2.rgb);
            return patch_light(Patch(light, next, previous, array(t.a3.rgb, t.b3.rgb, t.c3.rgb)), w);
        }
        default: {
            return gouraud(t, w);
        }
    }
}

// Bangay eq. 2.
fn gouraud(t: Corner, w: vec3f) -> vec3f {
    return t.a0.rgb * w.x + t.b0.rgb * w.y + t.c0.rgb * w.z;
}

// *fixed* and *gradient*, in the strip of the smallest weight. The latter's row 1: the light of the neighbor's apex
// across each edge, w = 1 if there is one.
fn printed(t: Corner, w: vec3f, b: f32) -> vec3f {
    if min(w.x, min(w.y, w.z)) >= b {
        return gouraud(t, w);
    }
    let k = smallest(w);
    if k == 0u {
        return printed_strip(t.a0.rgb, t.b0.rgb, t.c0.rgb, t.a1, w, b);
    }
    if k == 1u {
        return printed_strip(t.b0.rgb, t.c0.rgb, t.a0.rgb, t.b1, w.yzx, b);
    }
    return printed_strip(t.c0.rgb, t.a0.rgb, t.b0.rgb, t.c1, w.zxy, b);
}

// The strip opposite the first of three corners.
fn printed_strip(own: vec3f, i: vec3f, j: vec3f, apex: vec4f, w: vec3f, b: f32) -> vec3f {
    let on_edge = (i * w.y + j * w.z) / (1.0 - w.x);
    let across = printed_across(w.x, w.yz, b);
    let flattened = fixed_strip(own, on_edge, w.x, across);
    if SHADER == FIXED || apex.w == 0.0 {
        return flattened;
    }
    let beyond = beyond_edge(i, j, apex.rgb, w.yz);
    let slope = select(own - beyond, beyond - on_edge, SHADER == GRADIENT);
    return flattened + slope * (w.x * interpolation(1.0 - across) / 2.0);
}

// Length of the interpolated normal, below 1 where the vertices' differ.
fn normal_length(triangle: u32, w: vec3f) -> f32 {
    let corners = triangles[triangle].corners;
    let a = vertices[corners.x].normal.xyz;
    let b = vertices[corners.y].normal.xyz;
    let c = vertices[corners.z].normal.xyz;
    return length(a * w.x + b * w.y + c * w.z);
}

fn ambient_at(triangle: u32, w: vec3f) -> vec3f {
    let corners = triangles[triangle].corners;
    let a = vertices[corners.x].ambient.rgb;
    let b = vertices[corners.y].ambient.rgb;
    let c = vertices[corners.z].ambient.rgb;
    return a * w.x + b * w.y + c * w.z;
}
