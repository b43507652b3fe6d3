// One triangle after another, three vertices each, pulled from the buffers; hidden surfaces by depth buffer.

// What a pixel knows of its triangle. All of it is the same at the three corners: it is handed on, not interpolated.
struct Corner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) triangle: u32,
    // Corner A, pixels, and the slopes of the weights of B and C: the weights of any pixel.
    @location(1) @interpolate(flat, either) origin: vec2f,
    @location(2) @interpolate(flat, either) slopes: vec4f,
    // Four rows, one entry each for corner A or the edge opposite it, for B, for C: see row() below.
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
        // Depths touch 0 and 1; kept off the clipping planes.
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

// Row 0: the corners' lights; for *phong* their normals, and row 1 their places. The others: the triangle's constants.
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
    if which == 0u {
        return Row(vertices[a].light, vertices[b].light, vertices[c].light);
    }
    if which <= ROWS {
        let first = 3u * (triangle * ROWS + which - 1u);
        return Row(constants[first], constants[first + 1u], constants[first + 2u]);
    }
    return Row(vec4f(0.0), vec4f(0.0), vec4f(0.0));
}

@fragment
fn shade_pixel(corner: Corner) -> @location(0) vec4f {
    let offset = corner.position.xy - corner.origin;
    let b = dot(corner.slopes.xy, offset);
    let c = dot(corner.slopes.zw, offset);
    return vec4f(encoded(pixel_light(corner, vec3f(1.0 - b - c, b, c))), 1.0);
}
