// c1_phong: Phong shading with normals whose slope is continuous over the whole mesh, and patch: the same cubic for light
// that was computed at the vertices. Replace the lighting below with your material's: it may use the normal in any way.
// Needs no other file.
//
// Draw un-indexed vertices: the three vertices of triangle t are 3t, 3t + 1 and 3t + 2, because each must know its
// triangle and its corner.

struct Scene {
    model_view: mat4x4f,
    projection: mat4x4f,
    // A vector toward a distant lamp, in view space.
    lamp: vec3f,
    shininess: f32,
    // Linear light.
    ambient: vec3f,
    is_orthographic: u32,
    diffuse: vec3f,
    specular: vec3f,
}

@group(0) @binding(0) var<uniform> scene: Scene;
// Twelve coefficients for each triangle, row by row: for c1_phong, three components in nine texels, as coefficients.wgsl,
// ordinates.rs and ordinates.js write them; for patch, one in three texels, or red, green and blue in nine.
@group(0) @binding(1) var coefficients: texture_2d<f32>;

// The corner whose flat outputs count: the first one in WebGPU, Vulkan, Metal and Direct3D, the last one in OpenGL.
const PROVOKING = 0u;

fn texel(at: u32) -> vec4f {
    let width = textureDimensions(coefficients).x;
    return textureLoad(coefficients, vec2u(at % width, at / width), 0);
}

// A weight of 1 at this corner, times w of the projection. Such weights are interpolated as Σ b e divided by Σ b / w,
// where b are the weights on the screen. Divided by their sum, they give Σ b e, which is linear on the screen. This also
// holds for a triangle that the near plane clips.
fn corner_weights(index: u32, w: f32) -> vec3f {
    let corner = index % 3u;
    return vec3f(f32(corner == 0u), f32(corner == 1u), f32(corner == 2u)) * w;
}

// The terms of the cubic: x, y, and the two that make its three parts differ. Corners 0 and 1 have the smallest weight
// where xx and yy, respectively, are not zero.
fn terms_of(weights: vec3f) -> vec4f {
    let w = weights / (weights.x + weights.y + weights.z);
    let x = w.x - w.z;
    let y = w.y - w.z;
    let xx = select(0.0, x * x, (x < 0.0) & (x <= y));
    let yy = select(0.0, y * y, (y < 0.0) & (y < x));
    return vec4f(x, y, yy * (y - 2.0 * x) - xx * y, xx * (x - 2.0 * y) - yy * x);
}

// The value at a pixel from twelve coefficients of three components.
fn cubic_value(a: vec4f, b: vec4f, c: vec4f, d: vec4f, e: vec4f, f: vec4f, g: vec4f, h: vec4f, i: vec4f, t: vec4f) -> vec3f {
    let along = a.xyz + t.x * (vec3f(a.w, b.xy) + t.x * (c.yzw + t.x * vec3f(e.zw, f.x)));
    let mixed = vec3f(b.zw, c.x) + t.x * (d.xyz + t.x * f.yzw)
        + t.y * (vec3f(d.w, e.xy) + t.x * g.xyz + t.y * vec3f(g.w, h.xy));
    return along + t.y * mixed + t.z * vec3f(h.zw, i.x) + t.w * i.yzw;
}

// The same for twelve numbers.
fn scalar_value(a: vec4f, b: vec4f, c: vec4f, t: vec4f) -> f32 {
    let along = a.x + t.x * (a.y + t.x * (a.w + t.x * b.z));
    let mixed = a.z + t.x * (b.x + t.x * b.w) + t.y * (b.y + t.x * c.x + t.y * c.y);
    return along + t.y * mixed + t.z * c.z + t.w * c.w;
}

struct Pixel {
    @builtin(position) position: vec4f,
    @location(0) weights: vec3f,
    // In view space; only c1_phong needs these two.
    @location(1) place: vec3f,
    @location(2) normal: vec3f,
    @location(3) @interpolate(flat) a: vec4f,
    @location(4) @interpolate(flat) b: vec4f,
    @location(5) @interpolate(flat) c: vec4f,
    @location(6) @interpolate(flat) d: vec4f,
    @location(7) @interpolate(flat) e: vec4f,
    @location(8) @interpolate(flat) f: vec4f,
    @location(9) @interpolate(flat) g: vec4f,
    @location(10) @interpolate(flat) h: vec4f,
    @location(11) @interpolate(flat) i: vec4f,
}

@vertex
fn c1_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @builtin(vertex_index) index: u32,
) -> Pixel {
    let place = scene.model_view * vec4f(position, 1.0);
    var out = Pixel();
    out.position = scene.projection * place;
    out.weights = corner_weights(index, out.position.w);
    out.place = place.xyz;
    out.normal = (scene.model_view * vec4f(normal, 0.0)).xyz;
    if index % 3u == PROVOKING {
        let at = index / 3u * 9u;
        out.a = texel(at);
        out.b = texel(at + 1u);
        out.c = texel(at + 2u);
        out.d = texel(at + 3u);
        out.e = texel(at + 4u);
        out.f = texel(at + 5u);
        out.g = texel(at + 6u);
        out.h = texel(at + 7u);
        out.i = texel(at + 8u);
    }
    return out;
}

fn value_of(p: Pixel) -> vec3f {
    return cubic_value(p.a, p.b, p.c, p.d, p.e, p.f, p.g, p.h, p.i, terms_of(p.weights));
}

// Phong's light from a normal of any length and a place on the line of sight.
fn lit(direction: vec3f, place: vec3f) -> vec3f {
    let normal = normalize(direction);
    let to_eye = select(normalize(-place), vec3f(0.0, 0.0, 1.0), scene.is_orthographic != 0u);
    let to_lamp = normalize(scene.lamp);
    let cosine = dot(normal, to_lamp);
    var light = scene.ambient;
    if cosine > 0.0 {
        let shine = max(2.0 * cosine * dot(normal, to_eye) - dot(to_lamp, to_eye), 0.0);
        light += scene.diffuse * cosine + scene.specular * pow(shine, scene.shininess);
    }
    return light;
}

// Returns linear light; the target should have an sRGB format.
@fragment
fn c1_phong_pixel(pixel: Pixel) -> @location(0) vec4f {
    var normal = pixel.normal;
    // A triangle without coefficients faces away or reaches behind the eye.
    if any(pixel.a != vec4f(0.0)) {
        normal = value_of(pixel);
    }
    return vec4f(lit(normal, pixel.place), 1.0);
}

// patch in color: the coefficients are those of red, green and blue.
@fragment
fn patch_color_pixel(pixel: Pixel) -> @location(0) vec4f {
    return vec4f(value_of(pixel), 1.0);
}

struct PatchPixel {
    @builtin(position) position: vec4f,
    @location(0) weights: vec3f,
    @location(1) @interpolate(flat) a: vec4f,
    @location(2) @interpolate(flat) b: vec4f,
    @location(3) @interpolate(flat) c: vec4f,
}

@vertex
fn patch_vertex(@location(0) position: vec3f, @builtin(vertex_index) index: u32) -> PatchPixel {
    var out = PatchPixel();
    out.position = scene.projection * (scene.model_view * vec4f(position, 1.0));
    out.weights = corner_weights(index, out.position.w);
    if index % 3u == PROVOKING {
        let at = index / 3u * 3u;
        out.a = texel(at);
        out.b = texel(at + 1u);
        out.c = texel(at + 2u);
    }
    return out;
}

// patch: one number for the light, times the color of the surface.
@fragment
fn patch_pixel(pixel: PatchPixel) -> @location(0) vec4f {
    return vec4f(scene.diffuse * scalar_value(pixel.a, pixel.b, pixel.c, terms_of(pixel.weights)), 1.0);
}
