// The paint of a mesh. It follows the rows of `constants`: nine entries for each triangle, then two for each coat, then
// the texels.

// What the light of a pixel is multiplied by: white, unless the mesh is painted.
var<private> tint: vec3f = vec3f(1.0);

struct Painted {
    color: vec3f,
    place: vec2f,
    tangent: vec4f,
    // The first entry of its coat: the base texture, followed by the normal map.
    coat: u32,
}

// Interpolates the corners with correction for perspective. Three entries for each corner: its color, and 1 over its
// distance from the eye; its tangent; its place on the textures, and the number of the coat.
fn painted_at(triangle: u32, w: vec3f) -> Painted {
    let first = globals.paint.x + 9u * triangle;
    let near = w * vec3f(constants[first].w, constants[first + 3u].w, constants[first + 6u].w);
    let p = near / (near.x + near.y + near.z);
    return Painted(
        constants[first].xyz * p.x + constants[first + 3u].xyz * p.y + constants[first + 6u].xyz * p.z,
        constants[first + 2u].xy * p.x + constants[first + 5u].xy * p.y + constants[first + 8u].xy * p.z,
        constants[first + 1u] * p.x + constants[first + 4u] * p.y + constants[first + 7u] * p.z,
        globals.paint.y + 2u * bitcast<u32>(constants[first + 2u].z),
    );
}

// Returns a texture that repeats, bilinearly interpolated. Its entry holds where its texels begin, and its size; no
// width means no texture.
fn texture_at(entry: u32, place: vec2f) -> vec3f {
    let header = bitcast<vec4u>(constants[entry]);
    let size = header.yz;
    let texel = fract(place) * vec2f(size) - 0.5;
    let low = floor(texel);
    let part = texel - low;
    let x0 = u32(low.x + f32(size.x)) % size.x;
    let y0 = u32(low.y + f32(size.y)) % size.y;
    let x1 = (x0 + 1u) % size.x;
    let y1 = (y0 + 1u) % size.y;
    let start = globals.paint.z + header.x;
    let top = mix(constants[start + y0 * size.x + x0].xyz, constants[start + y0 * size.x + x1].xyz, part.x);
    let bottom = mix(constants[start + y1 * size.x + x0].xyz, constants[start + y1 * size.x + x1].xyz, part.x);
    return mix(top, bottom, part.y);
}

fn has_texture(entry: u32) -> bool {
    return bitcast<vec4u>(constants[entry]).y > 0u;
}

// Sets the tint of a pixel.
fn set_tint(painted: Painted) {
    tint = painted.color;
    if has_texture(painted.coat) {
        tint *= texture_at(painted.coat, painted.place);
    }
}

// Returns the normal that the normal map gives a surface with the unit normal `normal`.
fn bumped(painted: Painted, normal: vec3f) -> vec3f {
    let tangent = normalized(painted.tangent.xyz - normal * dot(normal, painted.tangent.xyz));
    if !has_texture(painted.coat + 1u) || dot(tangent, tangent) == 0.0 {
        return normal;
    }
    let bitangent = cross(normal, tangent) * sign(painted.tangent.w);
    let map = texture_at(painted.coat + 1u, painted.place);
    return normalized(tangent * map.x + bitangent * map.y + normal * map.z);
}
