// Phong with C1 normals. Put it after patch.wgsl. Replace the lighting below with your material's: it may use the normal
// and the position in any way.

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
// Twelve for each triangle, as ordinates.wgsl writes them.
@group(0) @binding(1) var<storage, read> ordinates: array<vec4f>;

struct Pixel {
    @builtin(position) position: vec4f,
    // In view space; interpolated as usual.
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    // The weights of the corners, linear on the screen.
    @location(2) @interpolate(linear) weights: vec3f,
    @location(3) @interpolate(flat) triangle: u32,
}

// Draw un-indexed vertices: the three vertices of triangle t are 3t, 3t + 1 and 3t + 2, because each must know its
// triangle and its corner.
@vertex
fn triangle_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @builtin(vertex_index) index: u32,
) -> Pixel {
    let place = scene.model_view * vec4f(position, 1.0);
    let corner = index % 3u;
    return Pixel(
        scene.projection * place,
        place.xyz,
        (scene.model_view * vec4f(normal, 0.0)).xyz,
        vec3f(f32(corner == 0u), f32(corner == 1u), f32(corner == 2u)),
        index / 3u,
    );
}

fn patch_of(triangle: u32) -> Patch {
    let at = 12u * triangle;
    return Patch(
        array(ordinates[at], ordinates[at + 1u], ordinates[at + 2u]),
        array(ordinates[at + 3u], ordinates[at + 4u], ordinates[at + 5u]),
        array(ordinates[at + 6u], ordinates[at + 7u], ordinates[at + 8u]),
        array(ordinates[at + 9u], ordinates[at + 10u], ordinates[at + 11u]),
    );
}

// Returns linear light; the target should have an sRGB format.
@fragment
fn c1_phong_pixel(pixel: Pixel) -> @location(0) vec4f {
    var normal = pixel.normal;
    var place = pixel.place;
    let cubic = patch_of(pixel.triangle);
    // A triangle without ordinates faces away or reaches behind the eye.
    if any(cubic.corner[0] != vec4f(0.0)) {
        let shape = patch_value(cubic, pixel.weights);
        normal = shape.xyz;
        // The pixel's line of sight with a smooth depth. Only lamps that are near need this.
        place = select(place * (shape.w / place.z), vec3f(place.xy, shape.w), scene.is_orthographic != 0u);
    }
    normal = normalize(normal);
    let to_eye = select(normalize(-place), vec3f(0.0, 0.0, 1.0), scene.is_orthographic != 0u);
    let to_lamp = normalize(scene.lamp);
    let cosine = dot(normal, to_lamp);
    var light = scene.ambient;
    if cosine > 0.0 {
        let shine = max(2.0 * cosine * dot(normal, to_eye) - dot(to_lamp, to_eye), 0.0);
        light += scene.diffuse * cosine + scene.specular * pow(shine, scene.shininess);
    }
    return vec4f(light, 1.0);
}
