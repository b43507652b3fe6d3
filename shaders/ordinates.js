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
  const triangles = Uint32Array.from(index ?? new Uint32Array(count).keys());
  for (const [name, array] of [["position", positions], ["normal", normals]]) {
    const at = Float64Array.from(array).findIndex((x) => !Number.isFinite(x));
    if (at >= 0) throw new RangeError(`${name} ${Math.floor(at / 3)} is not finite; expected three finite numbers`);
  }
  const units = Float64Array.from(normals), edges = new Float64Array(triangles.length);
  for (let v = 0; v < 3 * count; v += 3) {
    const length = Math.hypot(units[v], units[v + 1], units[v + 2]) || 1;
    for (let i = 0; i < 3; i++) units[v + i] /= length;
  }
  const far = (of, a, b) => (of[a] - of[b]) ** 2 + (of[a + 1] - of[b + 1]) ** 2 + (of[a + 2] - of[b + 2]) ** 2;
  for (let h = 0; h < triangles.length; h++) {
    edges[h] = far(positions, 3 * triangles[h], 3 * triangles[h % 3 === 2 ? h - 2 : h + 1]);
  }
  // Edges without length are no scale.
  const lengths = edges.filter((square) => square > 0).sort(), near = PLACES * Math.sqrt(lengths[lengths.length >> 1] ?? 0);
  // Cells twice as wide as vertices may differ: those within reach lie in at most eight cells.
  const size = 2 * near || 1, cells = 1 << Math.max(Math.ceil(Math.log2(count + 1)), 4);
  const first = new Int32Array(cells).fill(-1), following = new Int32Array(count), own = new Uint32Array(count), kept = [];
  const cell = (x, y, z) => (Math.imul(x, 73856093) ^ Math.imul(y, 19349663) ^ Math.imul(z, 83492791)) & (cells - 1);
  const place = (v, i, more) => Math.floor((positions[3 * v + i] + more) / size);
  const places = (v, i) => {
    const [low, high] = [place(v, i, -near), place(v, i, near)];
    return low === high ? [low] : [low, high];
  };
  for (let v = 0; v < count; v++) {
    let found = -1;
    const [rows, columns, layers] = [0, 1, 2].map((i) => places(v, i));
    for (const x of rows) for (const y of columns) for (const z of layers) {
      for (let o = first[cell(x, y, z)]; o >= 0 && found < 0; o = following[o]) {
        if (far(positions, 3 * v, 3 * o) <= near * near && far(units, 3 * v, 3 * o) <= NORMALS * NORMALS) found = o;
      }
    }
    if (found < 0) {
      const at = cell(place(v, 0, 0), place(v, 1, 0), place(v, 2, 0));
      following[v] = first[at];
      first[at] = v;
      own[v] = kept.push(v) - 1;
    } else own[v] = own[found];
  }
  return { positions: taken(positions, kept), normals: taken(units, kept), triangles: triangles.map((v) => own[v]) };
}

// Three numbers of each of the given vertices.
function taken(array, vertices) {
  const result = new Float64Array(3 * vertices.length);
  for (let i = 0; i < result.length; i++) result[i] = array[3 * vertices[Math.floor(i / 3)] + (i % 3)];
  return result;
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
// starts, ring         what rings() returns for the points
export function curvature({ positions, normals, triangles }) {
  const count = positions.length / 3, opposite = twins(triangles, count), faces = facesOf(positions, normals, triangles);
  const { points, vertices } = pointsOf(positions, triangles, opposite, faces, count);
  const tensors = tensorsOf(taken(normals, vertices), points, faces), sides = sidesOf(points, opposite, tensors);
  return { vertices: Uint32Array.from(vertices), tensors, triangles: points, sides, ...rings({ vertices, triangles: points }) };
}

// Where the triangles around each vertex are, or around each point: `starts` and `ring`, of which ring[2 i] and
// ring[2 i + 1], for i from starts[p] to starts[p + 1] − 1, follow and precede p in each of its triangles. The triangles
// of p go around it.
export function rings({ positions, vertices, triangles }) {
  const count = vertices ? vertices.length : positions.length / 3;
  const starts = new Uint32Array(count + 1), ring = new Uint32Array(2 * triangles.length);
  for (const p of triangles) starts[p + 1]++;
  for (let p = 0; p < count; p++) starts[p + 1] += starts[p];
  const at = starts.slice(), corners = new Uint32Array(triangles.length);
  for (let h = 0; h < triangles.length; h++) corners[at[triangles[h]]++] = h;
  // Of each point, the point around which it was last seen to follow or to precede, and at which corner it follows.
  const follows = new Int32Array(count).fill(-1), precedes = new Int32Array(count).fill(-1), corner = new Uint32Array(count);
  const isUsed = new Uint8Array(triangles.length);
  for (let p = 0, i = 0; p < count; p++) {
    for (let k = starts[p]; k < starts[p + 1]; k++) {
      const h = corners[k];
      follows[triangles[next(h)]] = precedes[triangles[previous(h)]] = p;
      corner[triangles[next(h)]] = h;
    }
    // First the fans that begin at a border, then the closed ones.
    for (let k = starts[p], pass = 0; pass < 2; k++) {
      if (k === starts[p + 1]) {
        [k, pass] = [starts[p] - 1, pass + 1];
        continue;
      }
      let h = corners[k];
      if (pass === 0 && precedes[triangles[next(h)]] === p) continue;
      while (!isUsed[h]) {
        isUsed[h] = 1;
        ring[i++] = triangles[next(h)];
        const last = (ring[i++] = triangles[previous(h)]);
        if (follows[last] !== p) break;
        h = corner[last];
      }
    }
  }
  return { starts, ring };
}

// The corners before and after corner h = 3 t + k of triangle t. Edge h is opposite corner h, from next(h) to previous(h).
const next = (h) => (h % 3 === 2 ? h - 2 : h + 1);
const previous = (h) => (h % 3 === 0 ? h + 2 : h - 1);

// For each edge of each triangle, the same edge of its neighbor; −1 unless exactly two triangles have it, with opposite
// directions.
function twins(triangles, count) {
  const corners = triangles.length, low = new Uint32Array(corners), high = new Uint32Array(corners);
  let order = new Uint32Array(corners), used = 0;
  for (let h = 0; h < corners; h++) {
    const a = triangles[next(h)], b = triangles[previous(h)];
    low[h] = Math.min(a, b);
    high[h] = Math.max(a, b);
    if (a !== b && a !== triangles[h] && b !== triangles[h]) order[used++] = h;
  }
  // Sorted by the higher and then by the lower vertex, so that the same edges follow each other.
  for (const key of [high, low]) {
    const at = new Uint32Array(count + 1), result = new Uint32Array(used);
    for (let i = 0; i < used; i++) at[key[order[i]] + 1]++;
    for (let v = 0; v < count; v++) at[v + 1] += at[v];
    for (let i = 0; i < used; i++) result[at[key[order[i]]]++] = order[i];
    order = result;
  }
  const opposite = new Int32Array(corners).fill(-1);
  for (let i = 0, end; i < used; i = end) {
    const h = order[i], g = order[i + 1];
    for (end = i + 1; end < used && low[order[end]] === low[h] && high[order[end]] === high[h]; end++);
    if (end === i + 2 && triangles[next(h)] === triangles[previous(g)]) {
      opposite[h] = g;
      opposite[g] = h;
    }
  }
  return opposite;
}

const minus = (of, a, b) => [of[3 * a] - of[3 * b], of[3 * a + 1] - of[3 * b + 1], of[3 * a + 2] - of[3 * b + 2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const vector = (array, i) => [array[3 * i], array[3 * i + 1], array[3 * i + 2]];

// Twelve numbers for each triangle: its normal, zero without area; a unit vector u along edge 0; the tensor e, f, g over u
// and v = normal × u that best maps each edge to the change of the normal (Rusinkiewicz 2004); and the parts of its area
// that are nearest to each corner (Meyer et al. 2003).
const FACE = 12;
function facesOf(positions, normals, triangles) {
  const faces = new Float64Array(4 * triangles.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const vs = [triangles[t], triangles[t + 1], triangles[t + 2]];
    const edges = [minus(positions, vs[2], vs[1]), minus(positions, vs[0], vs[2]), minus(positions, vs[1], vs[0])];
    const squares = [dot(edges[0], edges[0]), dot(edges[1], edges[1]), dot(edges[2], edges[2])];
    const longest = Math.max(squares[0], squares[1], squares[2]), normal = cross(edges[2], edges[0]);
    const double = Math.sqrt(dot(normal, normal));
    // Anything smaller is rounding error.
    if (!(double > 1e-14 * longest && double < Infinity)) continue;
    const side = Math.sqrt(squares[0]), u = [edges[0][0] / side, edges[0][1] / side, edges[0][2] / side];
    for (let i = 0; i < 3; i++) normal[i] /= double;
    const v = cross(normal, u);
    let uu = 0, uv = 0, vv = 0, re = 0, rf = 0, rg = 0;
    for (let k = 0; k < 3; k++) {
      const change = minus(normals, vs[(k + 2) % 3], vs[(k + 1) % 3]), x = dot(edges[k], u), y = dot(edges[k], v);
      const dx = dot(change, u), dy = dot(change, v);
      uu += x * x; uv += x * y; vv += y * y;
      re += x * dx; rf += x * dy + y * dx; rg += y * dy;
    }
    const f = (rf - (re * uv) / uu - (rg * uv) / vv) / (uu + vv - (uv * uv) / uu - (uv * uv) / vv);
    const e = (re - f * uv) / uu, g = (rg - f * uv) / vv, area = double / 2;
    if (!Number.isFinite(e + f + g)) continue;
    for (let i = 0; i < 3; i++) {
      faces[4 * t + i] = normal[i];
      faces[4 * t + 3 + i] = u[i];
    }
    faces[4 * t + 6] = e;
    faces[4 * t + 7] = f;
    faces[4 * t + 8] = g;
    const cosine = (k) => squares[(k + 1) % 3] + squares[(k + 2) % 3] - squares[k];
    const obtuse = cosine(0) < 0 ? 0 : cosine(1) < 0 ? 1 : cosine(2) < 0 ? 2 : -1;
    for (let k = 0; k < 3; k++) {
      const i = (k + 1) % 3, j = (k + 2) % 3;
      faces[4 * t + 9 + k] = obtuse >= 0 ? area / (obtuse === k ? 2 : 4)
        : (squares[i] * cosine(i) + squares[j] * cosine(j)) / (32 * area);
    }
  }
  return faces;
}

// The tensor of a face, rotated to a unit normal as the shortest rotation does: xx, xy, xz, yy, yz, zz.
function turned(faces, t, to) {
  const at = FACE * t, from = [faces[at], faces[at + 1], faces[at + 2]], u = [faces[at + 3], faces[at + 4], faces[at + 5]];
  const v = cross(from, u), [e, f, g] = [faces[at + 6], faces[at + 7], faces[at + 8]];
  // A normal that points to the other side of the face has the same tangent plane.
  const sign = dot(from, to) < 0 ? -1 : 1, axis = cross(from, to), share = 1 / (1 + sign * dot(from, to));
  const rotated = (x) => {
    const step = cross(axis, x), twice = cross(axis, step);
    const moved = (i) => x[i] + sign * step[i] + share * twice[i];
    return [moved(0), moved(1), moved(2)];
  };
  const a = rotated(u), b = rotated(v);
  const element = (r, c) => e * a[r] * a[c] + f * (a[r] * b[c] + b[r] * a[c]) + g * b[r] * b[c];
  return [element(0, 0), element(0, 1), element(0, 2), element(1, 1), element(1, 2), element(2, 2)];
}
const squared = ([xx, xy, xz, yy, yz, zz]) => xx * xx + yy * yy + zz * zz + 2 * (xy * xy + xz * xz + yz * yz);

// True if the curvature across an edge jumps: one side is flat across the edge and continues into a face with the same
// curvature, and the other side is bent. Without such jumps, slopes would be the mean of both sides, and planes ripple.
function isJump(positions, triangles, opposite, faces, h) {
  const isFace = (t) => faces[FACE * t + 9] + faces[FACE * t + 10] > 0, of = (g) => Math.floor(g / 3);
  const [t, u] = [of(h), of(opposite[h])];
  if (!isFace(t) || !isFace(u)) return false;
  const start = triangles[next(h)], edge = minus(positions, triangles[previous(h)], start);
  // The curvature across the edge, and how far the face extends from it.
  const across = (corner) => {
    const at = FACE * of(corner), normal = [faces[at], faces[at + 1], faces[at + 2]];
    const along = [faces[at + 3], faces[at + 4], faces[at + 5]];
    const direction = cross(normal, edge), length = Math.sqrt(dot(direction, direction)) || 1;
    const x = dot(direction, along) / length, y = dot(direction, cross(normal, along)) / length;
    const bend = faces[at + 6] * x * x + 2 * faces[at + 7] * x * y + faces[at + 8] * y * y;
    return [Math.abs(bend), Math.abs(dot(minus(positions, triangles[corner], start), direction)) / length];
  };
  const continues = (side, bend) => [0, 1, 2].some((k) => {
    const g = opposite[3 * side + k];
    if (g < 0 || !isFace(of(g))) return false;
    const normal = vector(faces, 4 * side), own = turned(faces, side, normal);
    return squared(turned(faces, of(g), normal).map((x, i) => x - own[i])) <= (FLAT * bend) ** 2;
  });
  const [own, extent] = across(h), [their, theirExtent] = across(opposite[h]);
  return (own <= FLAT * their && their * theirExtent > BENT && continues(t, their))
    || (their <= FLAT * own && own * extent > BENT && continues(u, own));
}

// Gives each fan of triangles around a vertex, over which the curvature does not jump, a point. Returns the point of each
// corner and the vertex of each point.
function pointsOf(positions, triangles, opposite, faces, count) {
  const points = Uint32Array.from(triangles), vertices = Array.from({ length: count }, (_, v) => v);
  // Only vertices at the ends of a jump are divided.
  const jumps = new Set(), divided = new Set();
  for (let h = 0; h < triangles.length; h++) {
    if (opposite[h] < h || !isJump(positions, triangles, opposite, faces, h)) continue;
    jumps.add(h);
    divided.add(triangles[next(h)]).add(triangles[previous(h)]);
  }
  if (divided.size === 0) return { points, vertices };
  const parent = Uint32Array.from(triangles.keys());
  const root = (h) => {
    while (parent[h] !== h) h = parent[h] = parent[parent[h]];
    return h;
  };
  for (let h = 0; h < triangles.length; h++) {
    if (opposite[h] < h || jumps.has(h)) continue;
    // The two triangles go along the edge in opposite directions.
    parent[root(next(h))] = root(previous(opposite[h]));
    parent[root(previous(h))] = root(next(opposite[h]));
  }
  const known = new Map(), hasFirst = new Set();
  for (let h = 0; h < triangles.length; h++) {
    const v = triangles[h], fan = root(h);
    if (!divided.has(v)) continue;
    if (!known.has(fan)) known.set(fan, hasFirst.has(v) ? vertices.push(v) - 1 : v);
    hasFirst.add(v);
    points[h] = known.get(fan);
  }
  return { points, vertices };
}

const FIRST = [0, 1, 2, 4, 5, 8], SECOND = [0, 3, 6, 4, 7, 8];

// dN/dp at each point: the mean over its triangles, weighted by the area that is nearest to the point.
function tensorsOf(normals, triangles, faces) {
  const count = normals.length / 3, sums = new Float64Array(6 * count), totals = new Float64Array(count);
  for (let h = 0; h < triangles.length; h++) {
    const t = Math.floor(h / 3), weight = faces[FACE * t + 9 + (h % 3)], p = triangles[h];
    if (!(weight > 0)) continue;
    const tensor = turned(faces, t, vector(normals, p));
    for (let i = 0; i < 6; i++) sums[6 * p + i] += weight * tensor[i];
    totals[p] += weight;
  }
  const result = new Float64Array(9 * count);
  for (let p = 0; p < count; p++) {
    // The place of each of the six numbers, and its mirror image.
    for (let i = 0; i < 6 && totals[p] > 0; i++) {
      result[9 * p + FIRST[i]] = result[9 * p + SECOND[i]] = sums[6 * p + i] / totals[p];
    }
  }
  return result;
}

// Where the curvature jumps, both sides of an edge use the slope of the flatter side along it, to which the edge belongs
// exactly: on the rim of a cap, edges are chords that run beside the rounding.
function sidesOf(points, opposite, tensors) {
  const sides = new Uint32Array(2 * points.length);
  for (let h = 0; h < points.length; h++) sides[2 * h] = sides[2 * h + 1] = points[h];
  const bend = (p) => {
    let sum = 0;
    for (let i = 9 * p; i < 9 * p + 9; i++) sum += tensors[i] * tensors[i];
    return sum;
  };
  for (let h = 0; h < points.length; h++) {
    const g = opposite[h];
    if (g < h) continue;
    for (let end = 0; end < 2; end++) {
      // One triangle goes to the next corner, the other to the previous one.
      const own = end === 0 ? 2 * next(h) : 2 * previous(h) + 1, their = end === 0 ? 2 * previous(g) + 1 : 2 * next(g);
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
  const count = vertices.length, squared = m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
  const back = 1 / (squared * Math.sqrt(squared));
  const isParallel = P[15] === 1;
  // For each point: eye space, unit normal, the projection's x, y and w, the place on the screen, and the slopes of the
  // normal per pixel to the right and per pixel up.
  const eyes = new Float64Array(3 * count), turns = new Float64Array(3 * count), clip = new Float64Array(3 * count);
  const screen = new Float64Array(2 * count), slopes = new Float64Array(6 * count);
  for (let p = 0; p < count; p++) {
    const v = 3 * vertices[p], [x, y, z] = [positions[v], positions[v + 1], positions[v + 2]];
    const [a, b, c] = [normals[v], normals[v + 1], normals[v + 2]];
    for (let i = 0; i < 3; i++) {
      eyes[3 * p + i] = m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i];
      turns[3 * p + i] = m[i] * a + m[4 + i] * b + m[8 + i] * c;
    }
    normalize(turns, 3 * p);
    project(P, eyes[3 * p], eyes[3 * p + 1], eyes[3 * p + 2], clip, 3 * p);
    screen[2 * p] = ((clip[3 * p] / clip[3 * p + 2]) * width) / 2;
    screen[2 * p + 1] = ((clip[3 * p + 1] / clip[3 * p + 2]) * height) / 2;
  }
  const isDrawn = (a, b, c) => clip[3 * a + 2] > 0 && clip[3 * b + 2] > 0 && clip[3 * c + 2] > 0
    && (screen[2 * b] - screen[2 * a]) * (screen[2 * c + 1] - screen[2 * a + 1])
      > (screen[2 * b + 1] - screen[2 * a + 1]) * (screen[2 * c] - screen[2 * a]);
  // The movement on the screen of a point that moves by a step, from its projection.
  const move = new Float64Array(2), place = new Float64Array(3), step = new Float64Array(3);
  const moved = (cx, cy, cw, x, y, z) => {
    const dw = P[3] * x + P[7] * y + P[11] * z, pixels = 1 / (2 * cw * cw);
    move[0] = ((P[0] * x + P[4] * y + P[8] * z) * cw - cx * dw) * pixels * width;
    move[1] = ((P[1] * x + P[5] * y + P[9] * z) * cw - cy * dw) * pixels * height;
  };
  // The equations of a slope: sums of x², xy and y²; right-hand sides of the three components for x, and for y.
  const sum = new Float64Array(9), change = new Float64Array(3), toward = new Float64Array(3), across = new Float64Array(3);
  const observe = (x, y, weight) => {
    sum[0] += weight * x * x; sum[1] += weight * x * y; sum[2] += weight * y * y;
    for (let i = 0; i < 3; i++) {
      sum[3 + i] += weight * x * change[i];
      sum[6 + i] += weight * y * change[i];
    }
  };
  const counted = new Int32Array(count).fill(-1);
  const setSlope = (p) => {
    const at = 3 * p, [cx, cy, cw] = [clip[at], clip[at + 1], clip[at + 2]];
    sum.fill(0);
    for (let i = starts[p]; i < starts[p + 1]; i++) {
      if (!isDrawn(p, ring[2 * i], ring[2 * i + 1])) continue;
      for (let k = 0; k < 2; k++) {
        const other = ring[2 * i + k], x = screen[2 * other] - screen[2 * p], y = screen[2 * other + 1] - screen[2 * p + 1];
        if (counted[other] === p || !(x * x + y * y > 0)) continue;
        counted[other] = p;
        for (let c = 0; c < 3; c++) change[c] = turns[3 * other + c] - turns[at + c];
        observe(x, y, 1 / (x * x + y * y));
      }
    }
    const weight = sum[0] + sum[2] > 0 ? RING / (sum[0] + sum[2]) : 0;
    for (let i = 0; i < 9; i++) sum[i] *= weight;
    // Two steps on the surface: across the line of sight, and away from the eye.
    for (let i = 0; i < 3; i++) toward[i] = isParallel ? (i === 2 ? 1 : 0) : -eyes[at + i];
    normalize(toward, 0);
    // A direction across the line of sight gives the scale.
    tangent(toward, 0, turns, at, across);
    moved(cx, cy, cw, across[0], across[1], across[2]);
    const pixels = Math.sqrt(move[0] * move[0] + move[1] * move[1]);
    tangent(turns, at, toward, 0, across);
    const cosine = turns[at] * toward[0] + turns[at + 1] * toward[1] + turns[at + 2] * toward[2];
    const facing = Math.min(Math.max(cosine / FACING, 0), 1);
    for (let k = 0; k < 2; k++) {
      for (let i = 0; i < 3; i++) {
        const [j, l] = [(i + 1) % 3, (i + 2) % 3];
        step[i] = k === 0 ? across[i] : turns[at + j] * across[l] - turns[at + l] * across[j];
      }
      // The change of the unit normal for the step, through the mesh's own axes.
      for (let i = 0; i < 3; i++) place[i] = m[4 * i] * step[0] + m[4 * i + 1] * step[1] + m[4 * i + 2] * step[2];
      const K = tensors, bent = (i) => K[9 * p + i] * place[0] + K[9 * p + i + 1] * place[1] + K[9 * p + i + 2] * place[2];
      const [x, y, z] = [bent(0), bent(3), bent(6)];
      for (let i = 0; i < 3; i++) change[i] = ((m[i] * x + m[4 + i] * y + m[8 + i] * z) * back) / pixels;
      moved(cx, cy, cw, step[0], step[1], step[2]);
      observe(move[0] / pixels, move[1] / pixels, facing);
    }
    // The slope is zero in a direction that nothing determines.
    const [xx, xy, yy] = [sum[0], sum[1], sum[2]], determinant = xx * yy - xy * xy, trace = xx + yy;
    for (let i = 0; i < 3; i++) {
      const right = sum[3 + i], up = sum[6 + i], isPlane = determinant > 1e-14 * trace * trace;
      slopes[6 * p + i] = isPlane ? (yy * right - xy * up) / determinant : trace > 0 ? right / trace : 0;
      slopes[6 * p + 3 + i] = isPlane ? (xx * up - xy * right) / determinant : trace > 0 ? up / trace : 0;
    }
  };
  const isDone = new Uint8Array(count), places = new Float64Array(6), directions = new Float64Array(6);
  const [value, forth, back_] = [new Float64Array(9), new Float64Array(9), new Float64Array(9)];
  for (let h = 0; h < triangles.length; h += 3) {
    if (!isDrawn(triangles[h], triangles[h + 1], triangles[h + 2])) {
      out.fill(0, 12 * h, 12 * h + 36);
      continue;
    }
    for (let i = 0; i < 3; i++) {
      const p = triangles[h + i];
      [places[2 * i], places[2 * i + 1]] = [screen[2 * p], screen[2 * p + 1]];
      const a = 3 * triangles[h + ((i + 1) % 3)], b = 3 * triangles[h + ((i + 2) % 3)];
      // The direction on the surface that is perpendicular to the edge opposite corner i and to its mean normal.
      const [nx, ny, nz] = [turns[a] + turns[b], turns[a + 1] + turns[b + 1], turns[a + 2] + turns[b + 2]];
      const [ex, ey, ez] = [eyes[b] - eyes[a], eyes[b + 1] - eyes[a + 1], eyes[b + 2] - eyes[a + 2]];
      moved((clip[a] + clip[b]) / 2, (clip[a + 1] + clip[b + 1]) / 2, (clip[a + 2] + clip[b + 2]) / 2,
        ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex);
      [directions[2 * i], directions[2 * i + 1]] = [move[0], move[1]];
      for (let k = 0; k < 2; k++) {
        const side = sides[2 * (h + i) + k], other = triangles[h + ((i + 1 + k) % 3)], to = k === 0 ? forth : back_;
        if (!isDone[side]) setSlope(side);
        isDone[side] = 1;
        const x = (screen[2 * other] - screen[2 * p]) / 3, y = (screen[2 * other + 1] - screen[2 * p + 1]) / 3;
        for (let c = 0; c < 3; c++) {
          value[3 * i + c] = turns[3 * p + c];
          to[3 * i + c] = turns[3 * p + c] + slopes[6 * side + c] * x + slopes[6 * side + 3 + c] * y;
        }
      }
    }
    cubic(places, directions, value, forth, back_, out, 12 * h);
  }
  return out;
}

// The same numbers for every view, for meshes that are skinned or drawn in many places: what the cubic adds to the
// interpolated normal, in the mesh's own axes, with weights that are linear on the surface. Normals are continuous; their
// slopes across an edge agree only as far as its triangles lie in one plane.
export function bulges({ positions, normals }, { vertices, tensors, triangles, sides }) {
  const out = new Float32Array(12 * triangles.length), places = new Float64Array(6), across = new Float64Array(6);
  const ways = [new Float64Array(9), new Float64Array(9)], value = new Float64Array(9);
  for (let h = 0; h < triangles.length; h += 3) {
    const ps = [vertices[triangles[h]], vertices[triangles[h + 1]], vertices[triangles[h + 2]]], u = minus(positions, ps[1], ps[0]);
    const v = cross(cross(u, minus(positions, ps[2], ps[0])), u);
    normalize(u, 0);
    normalize(v, 0);
    for (let i = 0; i < 3; i++) {
      const [j, l] = [(i + 1) % 3, (i + 2) % 3], place = minus(positions, ps[i], ps[0]), n = vector(normals, ps[i]);
      const edge = minus(positions, ps[l], ps[j]), sum = vector(normals, ps[j]).map((x, c) => x + normals[3 * ps[l] + c]);
      const direction = cross(sum, edge);
      for (const [array, of] of [[places, place], [across, direction]]) {
        array[2 * i] = dot(of, u);
        array[2 * i + 1] = dot(of, v);
      }
      value.set(n, 3 * i);
      for (let k = 0; k < 2; k++) {
        const step = minus(positions, ps[k === 0 ? j : l], ps[i]), K = 9 * sides[2 * (h + i) + k];
        for (let c = 0; c < 3; c++) ways[k][3 * i + c] = n[c] + dot(tensors.subarray(K + 3 * c, K + 3 * c + 3), step) / 3;
      }
    }
    cubic(places, across, value, ways[0], ways[1], out, 12 * h);
    for (let c = 0; c < 3; c++) {
      const [a, b, d] = [value[c], value[3 + c], value[6 + c]];
      out[12 * h + c] -= (a + b + d) / 3;
      out[12 * h + 3 + c] -= (2 * a - b - d) / 3;
      out[12 * h + 6 + c] -= (2 * b - a - d) / 3;
    }
  }
  return out;
}

function normalize(array, at) {
  const length = Math.max(Math.sqrt(array[at] ** 2 + array[at + 1] ** 2 + array[at + 2] ** 2), 1e-300);
  for (let i = 0; i < 3; i++) array[at + i] /= length;
}

// The projection's x, y and w of a place.
function project(P, x, y, z, out, at) {
  out[at] = P[0] * x + P[4] * y + P[8] * z + P[12];
  out[at + 1] = P[1] * x + P[5] * y + P[9] * z + P[13];
  out[at + 2] = P[3] * x + P[7] * y + P[11] * z + P[15];
}

// A unit vector perpendicular to the unit vector a, and to b where they differ.
function tangent(a, i, b, j, out) {
  let [x, y, z] = [b[j], b[j + 1], b[j + 2]];
  for (let k = 0; k < 2; k++) {
    out[0] = a[i + 1] * z - a[i + 2] * y;
    out[1] = a[i + 2] * x - a[i] * z;
    out[2] = a[i] * y - a[i + 1] * x;
    if (out[0] * out[0] + out[1] * out[1] + out[2] * out[2] >= 1e-12) break;
    [x, y, z] = Math.abs(a[i]) < 0.6 ? [1, 0, 0] : [0, 1, 0];
  }
  normalize(out, 0);
}

// Writes the twelve coefficients of one triangle with corners a, b, c. `places` has two numbers for each corner, its
// place on the screen; `across` two for each edge opposite a corner, the direction on the screen across it; `value` three
// for each corner, and `next` and `previous` those a third of the way to the next and to the previous corner. For patch,
// pass light in place of normals.
//
// With the weights w of the corners, x = w_a − w_c and y = w_b − w_c are zero at the centroid. The cubic has three parts
// that share all terms but k10 and k11: X = x² where corner a has the smallest weight (x < 0 and x ≤ y), Y = y² where b
// has (y < 0 and y < x), else zero. It is
// k0 + x (k1 + x (k3 + x k6)) + y (k2 + x (k4 + x k7) + y (k5 + x k8 + y k9))
//   + (Y (y − 2x) − X y) k10 + (X (x − 2y) − Y x) k11
export function cubic(places, across, value, next, previous, out, at) {
  const crossing = (k) => {
    const i = (k + 1) % 3, j = (k + 2) % 3, [px, py] = [places[2 * i], places[2 * i + 1]];
    const ex = places[2 * j] - px, ey = places[2 * j + 1] - py;
    let [dx, dy] = [across[2 * k], across[2 * k + 1]];
    const turn = dx * ey - dy * ex;
    if (!(turn * turn > MIN_SINE * MIN_SINE * (dx * dx + dy * dy) * (ex * ex + ey * ey))) [dx, dy] = [-ey, ex];
    const [cx, cy] = [(places[0] + places[2] + places[4]) / 3 - px, (places[1] + places[3] + places[5]) / 3 - py];
    // Where the line across the edge through the centroid meets it: 0 at its first corner, 1 at its second.
    const found = (cx * dy - cy * dx) / (ex * dy - ey * dx);
    return Number.isFinite(found) ? found : 0.5;
  };
  const [atA, atB, atC] = [crossing(0), crossing(1), crossing(2)];
  for (let c = 0; c < 3; c++) {
    const [a, b, d] = [value[c], value[3 + c], value[6 + c]], [ab, bd, da] = [next[c], next[3 + c], next[6 + c]];
    const [ad, ba, db] = [previous[c], previous[3 + c], previous[6 + c]];
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
    const o = at + c;
    out[o] = center;
    out[o + 3] = 3 * (fa - center);
    out[o + 6] = 3 * (fb - center);
    out[o + 9] = 3 * (na - 2 * fa + center);
    out[o + 12] = 6 * (md - fa - fb + center);
    out[o + 15] = 3 * (nb - 2 * fb + center);
    out[o + 18] = Ka;
    out[o + 21] = Dab;
    out[o + 24] = Dba;
    out[o + 27] = Kb;
    out[o + 30] = -(Kd + Dda + Dad + Ka) - Kb;
    out[o + 33] = -(Kb + Dbd + Ddb + Kd) - Ka;
  }
}
