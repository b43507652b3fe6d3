// Input from the host. Lights are linear, or as stored in the frame; positions are in pixels, x right, y down.

struct Globals {
    // The window, pixels.
    size: vec2f,
    // b, the width of the strip at an edge as a barycentric weight.
    boundary: f32,
    // Distance of the eye from the origin of eye space; 0 for a parallel projection.
    distance: f32,
    // k_a·I_a·O_d.
    ambient: vec4f,
    // k_d·O_d; in w, m of Phong's and Blinn's highlight.
    diffuse: vec4f,
    // k_s·O_s; in w, m of Cook and Torrance's.
    specular: vec4f,
    // Indices of refraction of Cook and Torrance's; in w, c1 of the Gaussian distribution.
    index: vec4f,
    // How many of `lamps` shine.
    lamp_count: u32,
    // Points of the transfer table.
    points: u32,
    // 1/γ of a transfer function that is a power.
    exponent: f32,
    lamps: array<Lamp, 64>,
}

struct Lamp {
    // Unit vector toward the lamp; where it is, if w = 1.
    place: vec4f,
    // I_p of red, green and blue.
    intensity: vec4f,
    // c1, c2, c3 of its attenuation with distance.
    fading: vec4f,
}

struct Vertex {
    // Pixels x, y and depth, 0 nearest, 1 farthest.
    place: vec4f,
    light: vec4f,
    ambient: vec4f,
    // Unit normal and place in eye space.
    normal: vec4f,
    eye: vec4f,
}

struct Triangle {
    corners: vec3u,
    // Slopes of the weights of corners B and C, per pixel right and down.
    slopes: vec4f,
}

@group(0) @binding(0) var<uniform> globals: Globals;
@group(0) @binding(1) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(2) var<storage, read> triangles: array<Triangle>;
// The data of each triangle in addition to its vertices.
@group(0) @binding(3) var<storage, read> constants: array<vec4f>;
// The transfer table: light, encoded value, slope to the next point.
@group(0) @binding(4) var<storage, read> table: array<vec4f>;

// Known when the pipeline is created, so that the card runs only the necessary code.
override SHADER: u32;
override VERTEX: u32;
override REWEIGHT: u32;
override TRANSFER: u32;
override SPECULAR: u32;
// Rows of `constants` per triangle, three entries each.
override ROWS: u32;
