// The light that a point of a surface sends to the eye, in eye space, Shoaff §3: k_a·I_a·O_d + Σ
// f_att·I_p·(k_d·O_d·(N·L)⁺ + k_s·O_s·s).

const PHONG_HIGHLIGHT = 0u;
const BLINN_HIGHLIGHT = 1u;
const GAUSSIAN_FACETS = 2u;
const BECKMANN_FACETS = 3u;

fn normalized(v: vec3f) -> vec3f {
    let length2 = dot(v, v);
    return select(vec3f(0.0), v * inverseSqrt(length2), length2 > 1e-30);
}

// Returns the unit vector toward the eye.
fn to_viewer(position: vec3f) -> vec3f {
    if globals.distance == 0.0 {
        return vec3f(0.0, 0.0, 1.0);
    }
    return normalize(vec3f(0.0, 0.0, globals.distance) - position);
}

// Returns the light that a point with the unit normal `normal` sends to the eye.
fn light_at(position: vec3f, normal: vec3f) -> vec3f {
    let viewer = to_viewer(position);
    var sum = globals.ambient.rgb * tint;
    for (var i = 0u; i < globals.lamp_count; i++) {
        let lamp = globals.lamps[i];
        var toward = lamp.place.xyz;
        var attenuation = 1.0;
        if lamp.place.w != 0.0 {
            let offset = lamp.place.xyz - position;
            let d = length(offset);
            toward = normalized(offset);
            attenuation = min(1.0 / (lamp.fading.x + (lamp.fading.y + lamp.fading.z * d) * d), 1.0);
        }
        sum += attenuation * lamp.intensity.rgb * reflected(normal, toward, viewer);
    }
    return sum;
}

// Returns the share of a lamp's light that reaches the eye, for unit vectors N, L, and V.
fn reflected(normal: vec3f, lamp: vec3f, viewer: vec3f) -> vec3f {
    let cosine = dot(normal, lamp);
    if cosine > 0.0 {
        return globals.diffuse.rgb * tint * cosine + globals.specular.rgb * highlight(normal, lamp, viewer);
    }
    return vec3f(0.0);
}

fn highlight(normal: vec3f, lamp: vec3f, viewer: vec3f) -> vec3f {
    let shininess = globals.diffuse.w;
    if SPECULAR == PHONG_HIGHLIGHT {
        let mirrored = 2.0 * dot(normal, lamp) * normal - lamp;
        return vec3f(power(dot(mirrored, viewer), shininess));
    }
    let halfway = normalized(lamp + viewer);
    if SPECULAR == BLINN_HIGHLIGHT {
        return vec3f(power(dot(normal, halfway), shininess));
    }
    return microfacets(normal, lamp, viewer, halfway);
}

// Returns x^m, and 0 for x ≤ 0, where pow() is undefined.
fn power(x: f32, m: f32) -> f32 {
    if x > 0.0 {
        return pow(x, m);
    }
    return 0.0;
}

// F·D·G/(π·(N·V)) of Torrance and Sparrow or of Cook and Torrance, Shoaff §3.8.1.
fn microfacets(normal: vec3f, lamp: vec3f, viewer: vec3f, halfway: vec3f) -> vec3f {
    let nl = dot(normal, lamp);
    let nv = dot(normal, viewer);
    let nh = dot(normal, halfway);
    let vh = dot(viewer, halfway);
    if nv <= 0.0 || nh <= 0.0 || vh <= 0.0 {
        return vec3f(0.0);
    }
    let geometry = clamp(2.0 * nh * min(nv, nl) / vh, 0.0, 1.0);
    let shape = distribution(normal, halfway, nh) * geometry / (3.14159265 * max(nv, 1e-6));
    let index = globals.index.rgb;
    return shape * vec3f(fresnel(vh, index.x), fresnel(vh, index.y), fresnel(vh, index.z));
}

// D, the fraction of the small mirrors that face `halfway`. The sine is computed from the cross product because 1 −
// cos² loses all digits in the highlight.
fn distribution(normal: vec3f, halfway: vec3f, nh: f32) -> f32 {
    let slope = globals.specular.w;
    let sine = length(cross(normal, halfway));
    if SPECULAR == GAUSSIAN_FACETS {
        let tilt = atan2(sine, nh) / slope;
        return globals.index.w * exp(-tilt * tilt);
    }
    let tangent = sine / (nh * slope);
    // When exp() underflows, the fourth power may underflow, too.
    if tangent > 10.0 {
        return 0.0;
    }
    let cosine2 = nh * nh;
    return exp(-tangent * tangent) / (slope * slope * cosine2 * cosine2);
}

// F, the fraction of unpolarized light that is reflected at the cosine L·H.
fn fresnel(cosine: f32, index: f32) -> f32 {
    let c = min(cosine, 1.0);
    let g2 = index * index - 1.0 + c * c;
    if g2 < 0.0 {
        return 1.0;
    }
    let g = sqrt(g2);
    // g − c without cancellation.
    let difference = (index * index - 1.0) / max(g + c, 1e-20);
    let across = difference / max(g + c, 1e-20);
    let along = (c * (g + c) - 1.0) / (c * difference + 1.0);
    return min(0.5 * across * across * (1.0 + along * along), 1.0);
}
