// Input from the host. Light values are linear or as stored in the frame. Positions are in pixels, with x to the right
// and y down.

struct Globals {
    // The size of the window in pixels.
    size: vec2f,
    // b, the width of the strip at an edge as a barycentric weight.
    boundary: f32,
    // The distance of the eye from the origin of eye space; 0 for a parallel projection.
    distance: f32,
    // The ambient light, k_a·I_a·O_d.
    ambient: vec4f,
    // k_d·O_d; w is m of the Phong and Blinn highlights.
    diffuse: vec4f,
    // k_s·O_s; w is m of the Cook–Torrance highlight.
    specular: vec4f,
    // Indices of refraction for the Cook–Torrance highlight; w is c1 of the Gaussian distribution.
    index: vec4f,
    // The number of `lamps` in use.
    lamp_count: u32,
    // The number of points in the transfer table.
    points: u32,
    // 1/γ if the transfer function is a power.
    exponent: f32,
    // Pixels per unit of the plane z = 0 in eye space.
    pixels_per_unit: f32,
    // Where the paint of the triangles, the coats and the texels begin in `constants`.
    paint: vec4u,
    lamps: array<Lamp, 64>,
}

struct Lamp {
    // The unit vector toward the lamp; its position if w = 1.
    place: vec4f,
    // I_p of red, green and blue.
    intensity: vec4f,
    // c1, c2, c3 of the lamp's attenuation with distance.
    fading: vec4f,
}

struct Vertex {
    // Position x, y in pixels, and depth: 0 is nearest, 1 farthest.
    place: vec4f,
    light: vec4f,
    ambient: vec4f,
    // The unit normal and the position in eye space.
    normal: vec4f,
    eye: vec4f,
}

struct Triangle {
    corners: vec3u,
    // The slopes of the weights of corners B and C per pixel, to the right and down.
    slopes: vec4f,
}

@group(0) @binding(0) var<uniform> globals: Globals;
@group(0) @binding(1) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(2) var<storage, read> triangles: array<Triangle>;
// The data of each triangle in addition to its vertices, followed by the paint.
@group(0) @binding(3) var<storage, read> constants: array<vec4f>;
// The transfer table: light, encoded value, and slope to the next point.
@group(0) @binding(4) var<storage, read> table: array<vec4f>;

// These are known when the pipeline is created, so the card runs only the necessary code.
override SHADER: u32;
override VERTEX: u32;
override REWEIGHT: u32;
override TRANSFER: u32;
override SPECULAR: u32;
// Rows of `constants` per triangle, three entries each.
override ROWS: u32;
// 1 if the mesh is painted.
override PAINTED: u32;
