// The strips at the edges of triangles. Needs no other file.
//
// In a strip, t is the weight that is 0 on the edge, `others` are the two weights of the edge's ends in order, and b is
// the width.

// t/b', where b' = min(b, (1−w_i)/2, (1−w_j)/2) is narrowed as in Bangay's pseudocode; 0 at the corners.
fn printed_across(t: f32, others: vec2f, b: f32) -> f32 {
    let width = min(b, min((1.0 - others.x) / 2.0, (1.0 - others.y) / 2.0));
    return select(0.0, t / width, width > 0.0);
}

// Returns the corner with the smallest weight; the first of equal weights.
fn smallest(w: vec3f) -> u32 {
    let k = select(0u, 1u, w.y < w.x);
    return select(k, 2u, w.z < w[k]);
}

// I_n(u), the profile from 0 to 1 across a strip, Bangay eq. 1.

// The continuity depth n, 1…32; 0 stands for ∞.
override DEPTH: u32 = 3u;

// I_n(u): 0 for u < 0, 1 for u ≥ 1.
fn interpolation(u: f32) -> f32 {
    if u >= 1.0 {
        return 1.0;
    }
    if u > 0.5 {
        return 1.0 - lower_half(1.0 - u);
    }
    if u >= 0.0 {
        return lower_half(u);
    }
    return 0.0;
}

// I_n on 0…½: uⁿ·Σ C(n−1+k, k)·(1−u)^k with k < n. A sum of powers of u alone would suffer from cancellation.
fn lower_half(u: f32) -> f32 {
    if DEPTH == 0u {
        return 1.0 / (1.0 + exp(5.0 - 10.0 * u));
    }
    var power = u;
    var term = 1.0;
    var sum = 1.0;
    for (var k = 1u; k < DEPTH; k++) {
        power *= u;
        term *= (1.0 - u) * (f32(DEPTH - 1u + k) / f32(k));
        sum += term;
    }
    return power * sum;
}

// I_n as the repaired vertex shading needs it: it reaches 0 and 1 even for n = ∞, where the printed tanh misses them.
fn blend(u: f32) -> f32 {
    let value = interpolation(clamp(u, 0.0, 1.0));
    if DEPTH == 0u && u < 1.0 {
        let residual = lower_half(0.0);
        return max(value - residual, 0.0) / (1.0 - 2.0 * residual);
    }
    return value;
}
