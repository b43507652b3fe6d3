// The cubic of C1 normals, in plain JavaScript: what the shaders need, computed on the CPU. Copy this file; it needs no
// other.
//
// Call welded() and curvature() once per mesh and coefficients() for every view of it. The model-view matrix may rotate,
// move and scale, but not distort. Matrices are column by column, as in OpenGL and three.js. Corners go around
// counterclockwise as seen from outside.

// The weight of the neighboring points, relative to the curvature. They decide near silhouettes.
const RING = 0.07;
// The cosine between the normal and the direction to the eye below which the curvature counts less.
const FACING = 0.05;
// The smallest sine of the angle between an edge and the direction across it.
const MIN_SINE = 0.1;
// The smallest change of the normal across a face, in radians, that counts as a bend.
const BENT = 0.02;
// A face counts as flat if its curvature is at most this share of its neighbor's.
const FLAT = 2e-3;
// Vertices are one if they are nearer than this share of the median edge, and their unit normals than NORMALS.
const PLACES = 1e-4, NORMALS = 1.75e-3;

// Joins vertices whose positions and normals differ by no more than rounding errors, however large the mesh is. Returns
// a mesh, which is flat arrays: positions, unit normals and triangles. Without an index, each three vertices are a triangle.
// Throws a RangeError if a position or a normal is missing or not finite, or an index is not that of a position.
export function welded(positions, normals, index) {
  const count = positions.length / 3;
  if (normals.length !== positions.length) {
    throw new RangeError(`${positions.length} numbers of positions, but ${normals.length} of normals; expected the same number`);
  }
  const wrong = index?.find((i) => !(Number.isInteger(i) && i >= 0 && i < count));
  if (wrong !== undefined) throw new RangeError(`index ${wrong} is not that of a position; expected 0 to ${count - 1}`);
  for (const [name, array] of [["position", positions], ["normal", normals]]) {
    const at = Float64Array.from(array).findIndex((x) => !Number.isFinite(x));
    if (at >= 0) throw new RangeError(`${name} ${Math.floor(at / 3)} is not finite; expected three finite numbers`);
  }
  const vertices = new Uint32Array(count).map((_, v) => v), triangles = Uint32Array.from(index ?? vertices);
  const units = new Float64Array(3 * count);
  vertices.forEach((v) => units.set(unit(vector(normals, v)), 3 * v));
  const far = (of, a, b) => squared(step(of, a, b));
  const edges = new Float64Array(triangles.length).map((_, h) => far(positions, triangles[h], triangles[next(h)]));
  // Edges without length are no scale.
  const lengths = edges.filter((square) => square > 0).sort(), near = PLACES ** 2 * (lengths[lengths.length >> 1] ?? 0);
  // In their order along a direction that is perpendicular to hardly any plane of a mesh, few vertices are near each other.
  const direction = [Math.sqrt(0.125), 0.5, Math.sqrt(0.625)];
  const along = new Float64Array(count).map((_, v) => dot(vector(positions, v), direction));
  const own = new Uint32Array(count), kept = [];
  let start = 0;
  for (const v of vertices.sort((a, b) => along[a] - along[b])) {
    while (start < kept.length && along[v] - along[kept[start]] > 2 * Math.sqrt(near)) start++;
    let at = start;
    while (at < kept.length && !(far(positions, v, kept[at]) <= near && far(units, v, kept[at]) <= NORMALS ** 2)) at++;
    own[v] = at;
    if (at === kept.length) kept.push(v);
  }
  const taken = (of) => new Float64Array(3 * kept.length).map((_, i) => of[3 * kept[Math.floor(i / 3)] + (i % 3)]);
  return { positions: taken(positions), normals: taken(units), triangles: triangles.map((v) => own[v]) };
}

// Everything about a mesh that depends on neither the view nor the light. A *point* is a vertex, or a part of one: where
// the curvature jumps, as between a plane and a rounding, the triangles on either side have points of their own. The
// first point of each vertex has the vertex's number; more follow. Returns:
//
// vertices             the vertex of each point
// tensors              nine numbers for each point: dN/dp, a symmetric matrix
// triangles            three points for each triangle
// sides                six points for each triangle: those with the slopes along its edges, from each corner to the next
//                      corner and from each corner to the previous one
// starts, ring         where the triangles around each point are: for i from starts[p] to starts[p + 1] − 1, ring[4 i] and
//                      ring[4 i + 1] follow and precede p in one of its triangles; ring[4 i + 2] is the third point of the
//                      triangle of p across the edge to the one that precedes, or p
export function curvature({ positions, normals, triangles }) {
  const opposite = twins(triangles, positions.length / 3), faces = facesOf(positions, normals, triangles);
  const { points, vertices } = pointsOf(positions, triangles, opposite, faces);
  const tensors = tensorsOf(normals, points, vertices, faces), sides = sidesOf(points, opposite, tensors);
  return { vertices, tensors, triangles: points, sides, ...rings({ vertices, triangles: points }, opposite) };
}

// Returns `starts` and `ring` alone, around the vertices of a mesh or the points of what curvature() returns. `across` is
// what twins() returns for the vertices, if it is known.
export function rings({ positions, vertices, triangles }, across) {
  const count = vertices?.length ?? positions.length / 3;
  const opposite = across ?? twins(vertices ? triangles.map((p) => vertices[p]) : triangles, count);
  const starts = new Uint32Array(count + 1), ring = new Uint32Array(4 * triangles.length);
  for (const p of triangles) starts[p + 1]++;
  for (let p = 0; p < count; p++) starts[p + 1] += starts[p];
  const at = starts.slice();
  triangles.forEach((p, h) => {
    const beyond = opposite[next(h)];
    const i = 4 * at[p]++;
    ring[i] = triangles[next(h)];
    ring[i + 1] = triangles[previous(h)];
    ring[i + 2] = beyond >= 0 && triangles[next(beyond)] === p ? triangles[beyond] : p;
  });
  return { starts, ring };
}

// The corners before and after corner h = 3 t + k of triangle t. Edge h is opposite corner h, from next(h) to previous(h).
const next = (h) => (h % 3 === 2 ? h - 2 : h + 1);
const previous = (h) => (h % 3 === 0 ? h + 2 : h - 1);

// For each edge of each triangle, the same edge of its neighbor; −1 unless exactly two triangles have it, with opposite
// directions.
function twins(triangles, count) {
  // The edges of each vertex with a higher one, each at the triangle that has it first.
  const first = new Int32Array(count).fill(-1), later = new Int32Array(triangles.length), uses = later.slice();
  const opposite = later.slice().fill(-1);
  for (let h = 0; h < triangles.length; h++) {
    const a = triangles[next(h)], b = triangles[previous(h)], low = Math.min(a, b);
    if (a === b || a === triangles[h] || b === triangles[h]) continue;
    let g = first[low];
    while (g >= 0 && triangles[next(g)] + triangles[previous(g)] !== a + b) g = later[g];
    if (g < 0) {
      later[h] = first[low];
      first[low] = h;
    } else if (++uses[g] === 1) {
      if (triangles[next(g)] === b) [opposite[g], opposite[h]] = [h, g];
    } else if (opposite[g] >= 0) {
      opposite[opposite[g]] = -1;
      opposite[g] = -1;
    }
  }
  return opposite;
}

const vector = (array, i) => [array[3 * i], array[3 * i + 1], array[3 * i + 2]];
// From vertex a to vertex b.
const step = (of, a, b) => [of[3 * b] - of[3 * a], of[3 * b + 1] - of[3 * a + 1], of[3 * b + 2] - of[3 * a + 2]];
const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (a, by) => [a[0] * by, a[1] * by, a[2] * by];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const squared = (a) => dot(a, a);
const unit = (a) => scaled(a, 1 / Math.max(Math.sqrt(squared(a)), 1e-300));

// Five vectors for each triangle: its normal, zero without area; a unit vector u along edge 0, and v = normal × u; the tensor
// e, f, g over u and v that best maps each edge to the change of the normal (Rusinkiewicz 2004); and the parts of its area
// that are nearest to each corner (Meyer et al. 2003).
function facesOf(positions, normals, triangles) {
  const faces = new Float64Array(5 * triangles.length);
  for (let t = 0; 3 * t < triangles.length; t++) {
    const vs = vector(triangles, t), edge = (of, k) => step(of, vs[(k + 1) % 3], vs[(k + 2) % 3]);
    const edges = [edge(positions, 0), edge(positions, 1), edge(positions, 2)], squares = edges.map(squared);
    const product = cross(edges[2], edges[0]), double = Math.sqrt(squared(product));
    // Anything smaller is rounding error.
    if (!(double > 1e-14 * Math.max(...squares) && double < Infinity)) continue;
    const normal = scaled(product, 1 / double), u = unit(edges[0]), v = cross(normal, u);
    let uu = 0, uv = 0, vv = 0, re = 0, rf = 0, rg = 0;
    for (let k = 0; k < 3; k++) {
      const change = edge(normals, k), x = dot(edges[k], u), y = dot(edges[k], v), dx = dot(change, u), dy = dot(change, v);
      uu += x * x; uv += x * y; vv += y * y;
      re += x * dx; rf += x * dy + y * dx; rg += y * dy;
    }
    const f = (rf - (re * uv) / uu - (rg * uv) / vv) / (uu + vv - (uv * uv) / uu - (uv * uv) / vv);
    const e = (re - f * uv) / uu, g = (rg - f * uv) / vv;
    if (!Number.isFinite(e + f + g)) continue;
    const cosine = (k) => squares[(k + 1) % 3] + squares[(k + 2) % 3] - squares[k], part = (k) => squares[k] * cosine(k);
    const obtuse = [0, 1, 2].findIndex((k) => cosine(k) < 0), all = part(0) + part(1) + part(2);
    const area = (k) => (obtuse < 0 ? (all - part(k)) / (16 * double) : double / (k === obtuse ? 4 : 8));
    faces.set([...normal, ...u, ...v, e, f, g, area(0), area(1), area(2)], 15 * t);
  }
  return faces;
}

// The tensor of a face, rotated to a unit normal as the shortest rotation does, in nine numbers.
function turned(faces, t, to) {
  const normal = vector(faces, 5 * t), [e, f, g] = vector(faces, 5 * t + 3);
  // A normal that points to the other side of the face has the same tangent plane.
  const sign = dot(normal, to) < 0 ? -1 : 1, axis = cross(normal, to), share = 1 / (1 + sign * dot(normal, to));
  const rotated = (x) => {
    const once = cross(axis, x), twice = cross(axis, once), at = (i) => x[i] + sign * once[i] + share * twice[i];
    return [at(0), at(1), at(2)];
  };
  const a = rotated(vector(faces, 5 * t + 1)), b = rotated(vector(faces, 5 * t + 2));
  const of = (i, j) => e * a[i] * a[j] + f * (a[i] * b[j] + b[i] * a[j]) + g * b[i] * b[j];
  const xy = of(0, 1), xz = of(0, 2), yz = of(1, 2);
  return [of(0, 0), xy, xz, xy, of(1, 1), yz, xz, yz, of(2, 2)];
}

// True if the curvature across an edge jumps: one side is flat across the edge and continues into a face with the same
// curvature, and the other side is bent. Without such jumps, slopes would be the mean of both sides, and planes ripple.
function isJump(positions, triangles, opposite, faces, h) {
  const of = (corner) => Math.floor(corner / 3), isFace = (corner) => corner >= 0 && squared(vector(faces, 5 * of(corner))) > 0;
  if (!isFace(h) || !isFace(opposite[h])) return false;
  const start = triangles[next(h)], edge = step(positions, start, triangles[previous(h)]);
  // The curvature across the edge, and how far the face extends from it.
  const side = (corner) => {
    const at = 5 * of(corner), normal = vector(faces, at), u = vector(faces, at + 1), v = vector(faces, at + 2);
    const [e, f, g] = vector(faces, at + 3);
    const across = unit(cross(normal, edge)), x = dot(across, u), y = dot(across, v);
    const extent = Math.abs(dot(step(positions, start, triangles[corner]), across));
    return { corner, extent, bend: Math.abs(e * x * x + 2 * f * x * y + g * y * y) };
  };
  const isFlat = ({ corner, bend }, bent) => bend <= FLAT * bent.bend && bent.bend * bent.extent > BENT
    && [corner, next(corner), previous(corner)].some((other) => {
      const normal = vector(faces, 5 * of(corner)), own = turned(faces, of(corner), normal), g = opposite[other];
      const apart = isFace(g) ? turned(faces, of(g), normal).map((x, i) => x - own[i]) : [Infinity];
      return apart.reduce((sum, x) => sum + x * x, 0) <= (FLAT * bent.bend) ** 2;
    });
  const [one, other] = [side(h), side(opposite[h])];
  return isFlat(one, other) || isFlat(other, one);
}

// Gives each fan of triangles around a vertex, over which the curvature does not jump, a point. Returns the point of each
// corner and the vertex of each point.
function pointsOf(positions, triangles, opposite, faces) {
  const points = Uint32Array.from(triangles), vertices = Array.from({ length: positions.length / 3 }, (_, v) => v);
  // Only vertices at the ends of a jump are divided.
  const divided = new Set(), parent = points.map((_, h) => h), known = new Map(), hasFirst = new Set();
  const root = (h) => {
    while (parent[h] !== h) h = parent[h] = parent[parent[h]];
    return h;
  };
  for (let h = 0; h < triangles.length; h++) {
    if (opposite[h] < h) continue;
    if (isJump(positions, triangles, opposite, faces, h)) {
      divided.add(triangles[next(h)]).add(triangles[previous(h)]);
    } else {
      // The two triangles go along the edge in opposite directions.
      parent[root(next(h))] = root(previous(opposite[h]));
      parent[root(previous(h))] = root(next(opposite[h]));
    }
  }
  for (let h = 0; h < triangles.length; h++) {
    const v = triangles[h], fan = root(h);
    if (!divided.has(v)) continue;
    if (!known.has(fan)) known.set(fan, hasFirst.has(v) ? vertices.push(v) - 1 : v);
    hasFirst.add(v);
    points[h] = known.get(fan);
  }
  return { points, vertices: Uint32Array.from(vertices) };
}

// dN/dp at each point: the mean over its triangles, weighted by the area that is nearest to the point.
function tensorsOf(normals, triangles, vertices, faces) {
  const sums = new Float64Array(9 * vertices.length), totals = new Float64Array(vertices.length);
  triangles.forEach((p, h) => {
    const t = Math.floor(h / 3), weight = faces[15 * t + 12 + (h % 3)];
    if (weight === 0) return;
    const tensor = turned(faces, t, vector(normals, vertices[p]));
    for (let i = 0; i < 9; i++) sums[9 * p + i] += weight * tensor[i];
    totals[p] += weight;
  });
  return sums.map((sum, i) => sum / (totals[Math.floor(i / 9)] || 1));
}

// Where the curvature jumps, both sides of an edge use the slope of the flatter side along it, to which the edge belongs
// exactly: on the rim of a cap, edges are chords that run beside the rounding.
function sidesOf(points, opposite, tensors) {
  const sides = new Uint32Array(2 * points.length).map((_, i) => points[i >> 1]);
  const bend = (p) => tensors.subarray(9 * p, 9 * p + 9).reduce((sum, x) => sum + x * x, 0);
  for (let h = 0; h < points.length; h++) {
    const g = opposite[h];
    // One triangle goes to the next corner, the other to the previous one.
    for (let end = 0; end < 2 && g > h; end++) {
      const own = end ? 2 * previous(h) + 1 : 2 * next(h), their = end ? 2 * next(g) : 2 * previous(g) + 1;
      const p = points[own >> 1], q = points[their >> 1];
      if (p !== q) sides[own] = sides[their] = bend(p) <= bend(q) ? p : q;
    }
  }
  return sides;
}

// The 36 numbers of every triangle for c1_phong: the twelve coefficients k0 to k11 of the normal in view space, three
// components each. A triangle that faces away, or that reaches behind the eye, gets zeros: the shader then interpolates
// its normals. `modelView` and `projection` have 16 numbers each; `size` is the viewport, of which only the aspect ratio
// matters.
export function coefficients(
  { positions, normals }, points, modelView, projection, [width, height], out = new Float32Array(12 * points.triangles.length),
) {
  const { vertices, tensors, triangles, sides, starts, ring } = points, m = modelView, P = projection;
  const columns = [vector(m, 0), [m[4], m[5], m[6]], [m[8], m[9], m[10]]], scale = Math.sqrt(squared(columns[0]));
  const direction = ([x, y, z]) => [
    m[0] * x + m[4] * y + m[8] * z, m[1] * x + m[5] * y + m[9] * z, m[2] * x + m[6] * y + m[10] * z,
  ];
  // The projection's x, y and w of a place (w = 1) or a step (w = 0).
  const projected = ([x, y, z], w) => [
    P[0] * x + P[4] * y + P[8] * z + P[12] * w, P[1] * x + P[5] * y + P[9] * z + P[13] * w, P[3] * x + P[7] * y + P[11] * z + P[15] * w,
  ];
  const eyes = Array.from(vertices, (v) => plus(direction(vector(positions, v)), [m[12], m[13], m[14]]));
  const units = Array.from(vertices, (v) => unit(direction(vector(normals, v))));
  const clips = eyes.map((eye) => projected(eye, 1));
  const places = clips.map(([x, y, w]) => [((x / w) * width) / 2, ((y / w) * height) / 2]);
  const isDrawn = (p, q, r) => {
    const [a, b, c] = [places[p], places[q], places[r]];
    return Math.min(clips[p][2], clips[q][2], clips[r][2]) > 0 && (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]);
  };
  // The movement on the screen of a point that moves by a step, from its projection.
  const moved = ([x, y, w], by) => {
    const [dx, dy, dw] = projected(by, 0), pixels = 1 / (2 * w * w);
    return [(dx * w - x * dw) * pixels * width, (dy * w - y * dw) * pixels * height];
  };
  const counted = new Int32Array(vertices.length).fill(-1);
  // The slope of the normal at a point, per pixel to the right and per pixel up.
  const slopeAt = (p) => {
    // The equations: sums of x², xy and y²; right-hand sides of the three components for x, and for y.
    const sum = [0, 0, 0, 0, 0, 0, 0, 0, 0], normal = units[p];
    const observe = (x, y, change, weight) => {
      sum[0] += weight * x * x; sum[1] += weight * x * y; sum[2] += weight * y * y;
      for (let i = 0; i < 3; i++) {
        sum[3 + i] += weight * x * change[i];
        sum[6 + i] += weight * y * change[i];
      }
    };
    for (let i = 4 * starts[p]; i < 4 * starts[p + 1]; i += 4) {
      if (!isDrawn(p, ring[i], ring[i + 1])) continue;
      for (const other of [ring[i], ring[i + 1]]) {
        const x = places[other][0] - places[p][0], y = places[other][1] - places[p][1];
        if (counted[vertices[other]] === p || !(x * x + y * y > 0)) continue;
        counted[vertices[other]] = p;
        observe(x, y, minus(units[other], normal), 1 / (x * x + y * y));
      }
    }
    const weight = sum[0] + sum[2] > 0 ? RING / (sum[0] + sum[2]) : 0;
    for (let i = 0; i < 9; i++) sum[i] *= weight;
    // Two steps on the surface: across the line of sight, which gives the scale, and away from the eye.
    const toward = P[15] === 1 ? [0, 0, 1] : unit(scaled(eyes[p], -1)), across = perpendicular(normal, toward);
    const [dx, dy] = moved(clips[p], perpendicular(toward, normal)), pixels = Math.sqrt(dx * dx + dy * dy);
    const facing = Math.min(Math.max(dot(normal, toward) / FACING, 0), 1);
    for (const by of [across, cross(normal, across)]) {
      // The change of the unit normal for the step, through the mesh's own axes.
      const own = columns.map((column) => dot(column, by)), bent = [0, 1, 2].map((i) => dot(vector(tensors, 3 * p + i), own));
      const [x, y] = moved(clips[p], by);
      observe(x / pixels, y / pixels, scaled(direction(bent), 1 / (scale ** 3 * pixels)), facing);
    }
    // The slope is zero in a direction that nothing determines.
    const [xx, xy, yy] = sum, determinant = xx * yy - xy * xy, trace = xx + yy, isPlane = determinant > 1e-14 * trace * trace;
    return [0, 1, 2].map((i) => {
      const right = sum[3 + i], up = sum[6 + i];
      if (isPlane) return [(yy * right - xy * up) / determinant, (xx * up - xy * right) / determinant];
      return trace > 0 ? [right / trace, up / trace] : [0, 0];
    });
  };
  const slopes = new Array(vertices.length);
  for (let h = 0; h < triangles.length; h += 3) {
    const ps = vector(triangles, h / 3);
    if (!isDrawn(...ps)) {
      out.fill(0, 12 * h, 12 * h + 36);
      continue;
    }
    // The direction on the surface that is perpendicular to each edge and to its mean normal.
    const across = [0, 1, 2].map((k) => {
      const a = ps[(k + 1) % 3], b = ps[(k + 2) % 3];
      return moved(scaled(plus(clips[a], clips[b]), 0.5), cross(plus(units[a], units[b]), minus(eyes[b], eyes[a])));
    });
    const thirds = (k) => ps.map((p, i) => {
      const side = sides[2 * (h + i) + k], slope = (slopes[side] ??= slopeAt(side)), to = places[ps[(i + 1 + k) % 3]];
      const x = (to[0] - places[p][0]) / 3, y = (to[1] - places[p][1]) / 3;
      return units[p].map((n, c) => n + slope[c][0] * x + slope[c][1] * y);
    });
    cubic(ps.map((p) => places[p]), across, ps.map((p) => units[p]), thirds(0), thirds(1), out, 12 * h);
  }
  return out;
}

// The same numbers for every view, for meshes that are skinned or drawn in many places: what the cubic adds to the
// interpolated normal, in the mesh's own axes, with weights that are linear on the surface. Normals are continuous; their
// slopes across an edge agree only as far as its triangles lie in one plane.
export function bulges({ positions, normals }, { vertices, tensors, triangles, sides }) {
  const out = new Float32Array(12 * triangles.length);
  for (let h = 0; h < triangles.length; h += 3) {
    const vs = vector(triangles, h / 3).map((p) => vertices[p]), value = vs.map((v) => vector(normals, v));
    const between = (i, j) => step(positions, vs[i], vs[j]), u = unit(between(0, 1)), v = cross(unit(cross(u, between(0, 2))), u);
    const flat = (x) => [dot(x, u), dot(x, v)];
    const across = [[1, 2], [2, 0], [0, 1]].map(([i, j]) => flat(cross(plus(value[i], value[j]), between(i, j))));
    const thirds = (k) => value.map((normal, i) => {
      const edge = between(i, (i + 1 + k) % 3), side = sides[2 * (h + i) + k];
      return normal.map((n, c) => n + dot(vector(tensors, 3 * side + c), edge) / 3);
    });
    cubic([0, 1, 2].map((i) => flat(between(0, i))), across, value, thirds(0), thirds(1), out, 12 * h);
    for (let c = 0; c < 3; c++) {
      const [a, b, d] = value.map((normal) => normal[c]);
      out[12 * h + c] -= (a + b + d) / 3;
      out[12 * h + 3 + c] -= (2 * a - b - d) / 3;
      out[12 * h + 6 + c] -= (2 * b - a - d) / 3;
    }
  }
  return out;
}

// A unit vector perpendicular to the unit vector a, and to b where they differ.
function perpendicular(a, b) {
  const across = cross(a, b);
  return unit(squared(across) >= 1e-12 ? across : cross(a, Math.abs(a[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0]));
}

// Writes the twelve coefficients of one triangle with corners a, b, c. `places` has a pair for each corner, its place on the
// screen; `across` one for each edge opposite a corner, the direction on the screen across it; `value` three numbers for each
// corner, and `next` and `previous` those a third of the way to the next and to the previous corner. For patch, pass light in
// place of normals.
//
// With the weights w of the corners, x = w_a − w_c and y = w_b − w_c are zero at the centroid. The cubic has three parts
// that share all terms but k10 and k11: X = x² where corner a has the smallest weight (x < 0 and x ≤ y), Y = y² where b
// has (y < 0 and y < x), else zero. It is
// k0 + x (k1 + x (k3 + x k6)) + y (k2 + x (k4 + x k7) + y (k5 + x k8 + y k9))
//   + (Y (y − 2x) − X y) k10 + (X (x − 2y) − Y x) k11
export function cubic(places, across, value, next, previous, out, at) {
  // Where the line across an edge through the centroid meets it: 0 at its first corner, 1 at its second.
  const [atA, atB, atC] = [0, 1, 2].map((k) => {
    const [p, q] = [places[(k + 1) % 3], places[(k + 2) % 3]], ex = q[0] - p[0], ey = q[1] - p[1];
    let [dx, dy] = across[k];
    const turn = dx * ey - dy * ex;
    if (!(turn * turn > MIN_SINE * MIN_SINE * (dx * dx + dy * dy) * (ex * ex + ey * ey))) [dx, dy] = [-ey, ex];
    const cx = (places[0][0] + places[1][0] + places[2][0]) / 3 - p[0], cy = (places[0][1] + places[1][1] + places[2][1]) / 3 - p[1];
    const found = (cx * dy - cy * dx) / (ex * dy - ey * dx);
    return Number.isFinite(found) ? found : 0.5;
  });
  for (let c = 0; c < 3; c++) {
    const of = (three) => [three[0][c], three[1][c], three[2][c]];
    const [a, b, d] = of(value), [ab, bd, da] = of(next), [ad, ba, db] = of(previous);
    // A third of the way to the centroid; the middles of the three parts; two thirds of the way; the centroid.
    const na = (a + ab + ad) / 3, nb = (b + bd + ba) / 3, nd = (d + da + db) / 3;
    const ma = (nb + nd) / 2 + (1 - atA) * (bd - (b + db) / 2) + atA * (db - (bd + d) / 2);
    const mb = (nd + na) / 2 + (1 - atB) * (da - (d + ad) / 2) + atB * (ad - (da + a) / 2);
    const md = (na + nb) / 2 + (1 - atC) * (ab - (a + ba) / 2) + atC * (ba - (ab + b) / 2);
    const fa = (na + mb + md) / 3, fb = (nb + md + ma) / 3, fd = (nd + ma + mb) / 3, center = (fa + fb + fd) / 3;
    const Ka = a - 3 * na + 3 * fa - center, Kb = b - 3 * nb + 3 * fb - center, Kd = d - 3 * nd + 3 * fd - center;
    const Dab = 3 * (ab - na - 2 * md + 2 * fa + fb - center), Dba = 3 * (ba - nb - 2 * md + 2 * fb + fa - center);
    const Dad = 3 * (ad - na - 2 * mb + 2 * fa + fd - center), Dda = 3 * (da - nd - 2 * mb + 2 * fd + fa - center);
    const Dbd = 3 * (bd - nb - 2 * ma + 2 * fb + fd - center), Ddb = 3 * (db - nd - 2 * ma + 2 * fd + fb - center);
    const k = [
      center, 3 * (fa - center), 3 * (fb - center), 3 * (na - 2 * fa + center), 6 * (md - fa - fb + center),
      3 * (nb - 2 * fb + center), Ka, Dab, Dba, Kb, -(Kd + Dda + Dad + Ka) - Kb, -(Kb + Dbd + Ddb + Kd) - Ka,
    ];
    for (let i = 0; i < 12; i++) out[at + 3 * i + c] = k[i];
  }
}
