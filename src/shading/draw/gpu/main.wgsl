// Draws one triangle after another. Its three vertices are read from the buffers. A depth buffer hides surfaces.

// The triangle's data for a pixel. All values are the same at the three corners and are not interpolated.
struct Corner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) triangle: u32,
    // Corner A in pixels, and the slopes of the weights of B and C. They give the weights of any pixel.
    @location(1) @interpolate(flat, either) origin: vec2f,
    @location(2) @interpolate(flat, either) slopes: vec4f,
    // Four rows, each with one entry for A, one for B, and one for C (the corner or the edge opposite it); see row()
    // below.
    @location(3) @interpolate(flat, either) a0: vec4f,
    @location(4) @interpolate(flat, either) b0: vec4f,
    @location(5) @interpolate(flat, either) c0: vec4f,
    @location(6) @interpolate(flat, either) a1: vec4f,
    @location(7) @interpolate(flat, either) b1: vec4f,
    @location(8) @interpolate(flat, either) c1: vec4f,
    @location(9) @interpolate(flat, either) a2: vec4f,
    @location(10) @interpolate(flat, either) b2: vec4f,
    @location(11) @interpolate(flat, either) c2: vec4f,
    @location(12) @interpolate(flat, either) a3: vec4f,
    @location(13) @interpolate(flat, either) b3: vec4f,
    @location(14) @interpolate(flat, either) c3: vec4f,
}

@vertex
fn place_corner(@builtin(vertex_index) index: u32) -> Corner {
    let t = index / 3u;
    let triangle = triangles[t];
    let place = vertices[triangle.corners[index % 3u]].place;
    let x = 2.0 * place.x / globals.size.x - 1.0;
    let y = 1.0 - 2.0 * place.y / globals.size.y;
    let r0 = row(t, triangle.corners, 0u);
    let r1 = row(t, triangle.corners, 1u);
    let r2 = row(t, triangle.corners, 2u);
    let r3 = row(t, triangle.corners, 3u);
    return Corner(
        // Depths range from 0 to 1; keep them away from the clipping planes.
        vec4f(x, y, 0.25 + 0.5 * place.z, 1.0),
        t,
        vertices[triangle.corners.x].place.xy,
        triangle.slopes,
        r0.a, r0.b, r0.c,
        r1.a, r1.b, r1.c,
        r2.a, r2.b, r2.c,
        r3.a, r3.b, r3.c,
    );
}

struct Row {
    a: vec4f,
    b: vec4f,
    c: vec4f,
}

// Row 0 holds the corners' light values. For *phong*, row 0 holds their normals and row 1 their positions; for
// *c1-phong*, row 0 holds their normals and z. The other rows hold the triangle's constants.
fn row(triangle: u32, corners: vec3u, which: u32) -> Row {
    let a = corners.x;
    let b = corners.y;
    let c = corners.z;
    if SHADER == PHONG && which == 0u {
        return Row(vertices[a].normal, vertices[b].normal, vertices[c].normal);
    }
    if SHADER == PHONG && which == 1u {
        return Row(vertices[a].eye, vertices[b].eye, vertices[c].eye);
    }
    if SHADER == C1_PHONG && which == 0u {
        return Row(normal_and_z(a), normal_and_z(b), normal_and_z(c));
    }
    if which == 0u {
        return Row(vertices[a].light, vertices[b].light, vertices[c].light);
    }
    if which <= ROWS {
        let first = 3u * (triangle * ROWS + which - 1u);
        return Row(constants[first], constants[first + 1u], constants[first + 2u]);
    }
    return Row(vec4f(0.0), vec4f(0.0), vec4f(0.0));
}

fn normal_and_z(vertex: u32) -> vec4f {
    return vec4f(vertices[vertex].normal.xyz, vertices[vertex].eye.z);
}

@fragment
fn shade_pixel(corner: Corner) -> @location(0) vec4f {
    let offset = corner.position.xy - corner.origin;
    let b = dot(corner.slopes.xy, offset);
    let c = dot(corner.slopes.zw, offset);
    return vec4f(encoded(pixel_light(corner, vec3f(1.0 - b - c, b, c))), 1.0);
}

// Returns the light of a pixel: the chosen shader, followed by the corrections.

fn pixel_light(t: Corner, w: vec3f) -> vec3f {
    var light = shaded(t, w);
    let b = globals.boundary;
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
    // Shaders that light every pixel have applied the tint themselves.
    if PAINTED != 0u && SHADER != PHONG && SHADER != C1_PHONG {
        set_tint(painted_at(t.triangle, w));
        light *= tint;
    }
    return light;
}

fn shaded(t: Corner, w: vec3f) -> vec3f {
    let b = globals.boundary;
    switch SHADER {
        case FLAT: {
            // Every entry of row 1 is the triangle's light.
            return t.a1.rgb;
        }
        case PHONG: {
            let normal = t.a0.xyz * w.x + t.b0.xyz * w.y + t.c0.xyz * w.z;
            let place = t.a1.xyz * w.x + t.b1.xyz * w.y + t.c1.xyz * w.z;
            return painted_light(t.triangle, w, place, normalized(normal));
        }
        case QUADRATIC: {
            // Row 1 holds four times the bulge at the midpoint of each edge.
            let bulge = w.yzx * w.zxy;
            return gouraud(t, w) + t.a1.rgb * bulge.x + t.b1.rgb * bulge.y + t.c1.rgb * bulge.z;
        }
        case FIXED, GRADIENT, GRADIENT_REPAIRED: {
            return printed(t, w, b);
        }
        case PATCH: {
            return patch_value(patch_of(t), w).rgb;
        }
        case C1_PHONG: {
            // The line of sight through the pixel is exact and does not bend at edges.
            let shape = patch_value(patch_of(t), w);
            let place = (t.position.xy - 0.5 * globals.size) / globals.pixels_per_unit;
            let sight = vec3f(place.x, -place.y, 0.0);
            return painted_light(t.triangle, w, on_sight(sight, shape.w), normalized(shape.xyz));
        }
        default: {
            return gouraud(t, w);
        }
    }
}

// Returns the light of a pixel with the unit normal `normal`, under the paint.
fn painted_light(triangle: u32, w: vec3f, place: vec3f, normal: vec3f) -> vec3f {
    if PAINTED == 0u {
        return light_at(place, normal);
    }
    let painted = painted_at(triangle, w);
    set_tint(painted);
    return light_at(place, bumped(painted, normal));
}

fn patch_of(t: Corner) -> Patch {
    return Patch(
        array(t.a0, t.b0, t.c0), array(t.a1, t.b1, t.c1), array(t.a2, t.b2, t.c2), array(t.a3, t.b3, t.c3)
    );
}

// Returns the point with the given z on the line of sight that meets the plane z = 0 at `sight`.
fn on_sight(sight: vec3f, z: f32) -> vec3f {
    if globals.distance == 0.0 {
        return vec3f(sight.xy, z);
    }
    return vec3f(sight.xy * (1.0 - z / globals.distance), z);
}

// Bangay eq. 2.
fn gouraud(t: Corner, w: vec3f) -> vec3f {
    return t.a0.rgb * w.x + t.b0.rgb * w.y + t.c0.rgb * w.z;
}

// *fixed* and *gradient*, in the strip of the smallest weight. For *gradient*, row 1 holds the light of the neighbor's
// apex across each edge, with w = 1 if there is a neighbor.
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

// The strip opposite the first of the three corners.
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

// Returns the length of the interpolated normal, which is below 1 if the vertex normals differ.
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

// Encoding: the encoded values, 0…1, that produce a light on the display.

const LINEAR = 0u;
const SRGB = 1u;
const GAMMA = 2u;
const TABLE = 3u;

fn encoded(linear: vec3f) -> vec3f {
    let l = clamp(linear, vec3f(0.0), vec3f(1.0));
    if TRANSFER == SRGB {
        // IEC 61966-2-1.
        return select(1.055 * pow(l, vec3f(1.0 / 2.4)) - 0.055, 12.92 * l, l <= vec3f(0.04045 / 12.92));
    }
    if TRANSFER == GAMMA {
        return select(vec3f(0.0), pow(l, vec3f(globals.exponent)), l > vec3f(0.0));
    }
    if TRANSFER == TABLE {
        return vec3f(from_table(l.r), from_table(l.g), from_table(l.b));
    }
    return l;
}

// Linear interpolation between two points of the table.
fn from_table(linear: f32) -> f32 {
    // Zero light has code 0, even if the first segment of a table begins above 0.
    if linear <= 0.0 {
        return 0.0;
    }
    var low = 0u;
    var high = globals.points - 1u;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if table[middle].x <= linear {
            low = middle;
        } else {
            high = middle;
        }
    }
    let point = table[low];
    return point.y + (linear - point.x) * point.z;
}
