// The numbers that c1_phong and patch need, in plain JavaScript. Copy this file; it needs no other.
//
// Call curvature() once per mesh and ordinates() for every view of it. Vertices are shared between triangles: vertices
// with the same position and normal must be one vertex; shared() makes them so. The model-view matrix may rotate, move
// and scale, but not distort. Matrices are column by column, as in OpenGL and three.js.

// The weight of the neighboring vertices, relative to the curvature. They decide near silhouettes.
const RING = 0.07;
// The smallest sine of the angle between an edge and the direction across it.
const MIN_SINE = 0.1;

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => scale(a, 1 / Math.max(Math.hypot(...a), 1e-300));
const perp = (a, b) => a[0] * b[1] - a[1] * b[0];
const vector = (array, i) => [array[3 * i], array[3 * i + 1], array[3 * i + 2]];
const corners = (triangles, t) => [triangles[3 * t], triangles[3 * t + 1], triangles[3 * t + 2]];

// Joins vertices with the same position and normal, up to rounding errors: within a hundred-thousandth of the mesh's
// size and a ten-thousandth of a normal. Returns flat arrays of positions, normals and triangles.
export function shared(positions, normals, index) {
  const known = new Map(), out = { positions: [], normals: [], triangles: [] };
  const count = index ? index.length : positions.length / 3;
  const steps = 1e5 / Math.max(positions.reduce((most, x) => Math.max(most, Math.abs(x)), 0), 1e-300);
  for (let i = 0; i < count; i++) {
    const v = index ? index[i] : i, p = vector(positions, v), n = unit(vector(normals, v));
    const key = [...p.map((x) => Math.round(x * steps)), ...n.map((x) => Math.round(x * 1e4))].join();
    if (!known.has(key)) {
      known.set(key, known.size);
      out.positions.push(...p);
      out.normals.push(...n);
    }
    out.triangles.push(known.get(key));
  }
  return out;
}

// Rotates x as the shortest rotation from one unit vector to another does.
function turned(x, from, to) {
  const axis = cross(from, to), step = cross(axis, x);
  return add(add(x, step), scale(cross(axis, step), 1 / (1 + dot(from, to))));
}

// Returns dN/dp at each vertex, a symmetric matrix of nine numbers: the mean over its triangles, weighted by the area
// that is nearest to the vertex.
export function curvature({ positions, normals, triangles }) {
  const sums = new Float64Array(3 * positions.length), totals = new Float64Array(positions.length / 3);
  for (let t = 0; t < triangles.length / 3; t++) {
    const vs = corners(triangles, t), p = vs.map((v) => vector(positions, v)), n = vs.map((v) => vector(normals, v));
    const edges = [0, 1, 2].map((k) => sub(p[(k + 2) % 3], p[(k + 1) % 3])), squares = edges.map((e) => dot(e, e));
    const normal = cross(edges[2], sub(p[2], p[0])), area = Math.hypot(...normal) / 2;
    if (!(area > 1e-12 * Math.max(...squares))) continue;
    const face = unit(normal), u = unit(edges[0]), v = cross(face, u);
    // The symmetric matrix ((e, f), (f, g)) over (u, v) that best maps each edge to the change of the normal.
    let uu = 0, uv = 0, vv = 0, re = 0, rf = 0, rg = 0;
    for (let k = 0; k < 3; k++) {
      const change = sub(n[(k + 2) % 3], n[(k + 1) % 3]), x = dot(edges[k], u), y = dot(edges[k], v);
      const dx = dot(change, u), dy = dot(change, v);
      uu += x * x; uv += x * y; vv += y * y;
      re += x * dx; rf += x * dy + y * dx; rg += y * dy;
    }
    const f = (rf - (re * uv) / uu - (rg * uv) / vv) / (uu + vv - (uv * uv) / uu - (uv * uv) / vv);
    const e = (re - f * uv) / uu, g = (rg - f * uv) / vv;
    // The area nearest to each corner (Meyer et al. 2003).
    const cosines = [0, 1, 2].map((k) => squares[(k + 1) % 3] + squares[(k + 2) % 3] - squares[k]);
    const obtuse = cosines.findIndex((c) => c < 0);
    for (let k = 0; k < 3; k++) {
      const [i, j] = [(k + 1) % 3, (k + 2) % 3], side = dot(face, n[k]) < 0 ? scale(face, -1) : face;
      const [a, b] = [turned(u, side, n[k]), turned(v, side, n[k])];
      const weight = obtuse >= 0 ? area / (obtuse === k ? 2 : 4)
        : (squares[i] * cosines[i] + squares[j] * cosines[j]) / (32 * area);
      for (let m = 0; m < 9; m++) {
        const [r, c] = [Math.floor(m / 3), m % 3];
        sums[9 * vs[k] + m] += weight * (e * a[r] * a[c] + f * (a[r] * b[c] + b[r] * a[c]) + g * b[r] * b[c]);
      }
      totals[vs[k]] += weight;
    }
  }
  return sums.map((sum, i) => sum / Math.max(totals[Math.floor(i / 9)], 1e-300));
}

// What the compute passes need to find the triangles around each vertex: `starts`, where the list of each vertex starts,
// with the end of the last; and `ring`, for each triangle in a list, the vertices that follow and precede.
export function rings({ positions, triangles }) {
  const lists = Array.from({ length: positions.length / 3 }, () => []);
  for (let t = 0; t < triangles.length / 3; t++) {
    const vs = corners(triangles, t);
    vs.forEach((v, k) => lists[v].push(vs[(k + 1) % 3], vs[(k + 2) % 3]));
  }
  const starts = [0];
  for (const list of lists) starts.push(starts[starts.length - 1] + list.length / 2);
  return { starts: Uint32Array.from(starts), ring: Uint32Array.from(lists.flat()) };
}

// Two unit vectors perpendicular to `normal`; the first is also perpendicular to `other`.
function tangents(normal, other) {
  let across = cross(normal, other);
  if (dot(across, across) < 1e-12) across = cross(normal, Math.abs(normal[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0]);
  return [unit(across), cross(normal, unit(across))];
}

// Returns the twelve ordinates of every triangle for c1_phong, four numbers each (normal and z in view space): the
// corners, the ordinates a third of the way to the next corner, those to the previous corner, and the middles at the
// edges opposite each corner. A triangle that faces away, or that reaches behind the eye, gets zeros: the shader then
// interpolates its normals. `modelView` and `projection` have 16 numbers each; `size` is the viewport in pixels.
export function ordinates({ positions, normals, triangles }, tensors, modelView, projection, [width, height]) {
  const m = modelView, P = projection, squared = m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
  const direction = (d) => [0, 1, 2].map((i) => m[i] * d[0] + m[4 + i] * d[1] + m[8 + i] * d[2]);
  const projected = (p, w) => [0, 1, 3].map((i) => P[i] * p[0] + P[4 + i] * p[1] + P[8 + i] * p[2] + P[12 + i] * w);
  const toward = (eye) => (P[15] === 1 ? [0, 0, 1] : unit(scale(eye, -1)));
  const place = (eye) => {
    const [x, y, w] = projected(eye, 1);
    return w > 0 ? [((x / w) * width) / 2, ((y / w) * height) / 2] : null;
  };
  // The movement on the screen of a point that moves along `step`, per step.
  const moved = (eye, step) => {
    const [x, y, w] = projected(eye, 1), [dx, dy, dw] = projected(step, 0);
    return [(((dx * w - x * dw) / (w * w)) * width) / 2, (((dy * w - y * dw) / (w * w)) * height) / 2];
  };
  // The change of the unit normal of vertex v for a step in view space.
  const bent = (v, step) => {
    const back = [0, 4, 8].map((i) => m[i] * step[0] + m[i + 1] * step[1] + m[i + 2] * step[2]);
    const rows = [0, 3, 6].map((i) => dot([tensors[9 * v + i], tensors[9 * v + i + 1], tensors[9 * v + i + 2]], back));
    return scale(direction(rows), 1 / (squared * Math.sqrt(squared)));
  };
  const count = positions.length / 3, eyes = [], turns = [], screen = [], rings = [];
  for (let v = 0; v < count; v++) {
    eyes.push(add(direction(vector(positions, v)), [m[12], m[13], m[14]]));
    turns.push(unit(direction(vector(normals, v))));
    screen.push(place(eyes[v]));
    rings.push([]);
  }
  const drawn = (vs) => {
    const [a, b, c] = vs.map((v) => screen[v]);
    return a && b && c && perp([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]) > 0;
  };
  for (let t = 0; t < triangles.length / 3; t++) {
    const vs = corners(triangles, t);
    if (!drawn(vs)) continue;
    for (const v of vs) for (const other of vs) if (other !== v && !rings[v].includes(other)) rings[v].push(other);
  }
  const values = eyes.map((eye, v) => [...turns[v], eye[2]]);
  const slopes = eyes.map((eye, v) => {
    // The equations of the slope: matrix and right-hand sides.
    let sum = [0, 0, 0], right = [[0, 0], [0, 0], [0, 0], [0, 0]];
    const observe = ([x, y], change, weight) => {
      sum = [sum[0] + weight * x * x, sum[1] + weight * x * y, sum[2] + weight * y * y];
      right = right.map(([a, b], c) => [a + weight * x * change[c], b + weight * y * change[c]]);
    };
    if (!screen[v]) return right;
    for (const other of rings[v]) {
      const offset = [screen[other][0] - screen[v][0], screen[other][1] - screen[v][1]];
      const far = offset[0] ** 2 + offset[1] ** 2;
      if (far > 0) observe(offset, values[other].map((value, c) => value - values[v][c]), 1 / far);
    }
    const ring = sum[0] + sum[2] > 0 ? RING / (sum[0] + sum[2]) : 0;
    sum = sum.map((s) => s * ring);
    right = right.map((r) => r.map((s) => s * ring));
    // Two steps on the surface: across the line of sight, and away from the eye if the vertex faces it.
    const to = toward(eye), [across, away] = tangents(turns[v], to);
    const pixels = Math.hypot(...moved(eye, tangents(to, turns[v])[0]));
    for (const step of dot(turns[v], to) > 0 ? [across, away] : [across]) {
      observe(moved(eye, step).map((s) => s / pixels), [...bent(v, step), step[2]].map((c) => c / pixels), 1);
    }
    // The slope is zero in a direction that nothing determines.
    const [xx, xy, yy] = sum, determinant = xx * yy - xy * xy, trace = xx + yy;
    if (determinant > 1e-14 * trace * trace) {
      return right.map(([x, y]) => [(yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant]);
    }
    return right.map(([x, y]) => (trace > 0 ? [x / trace, y / trace] : [0, 0]));
  });
  const out = new Float32Array(16 * triangles.length);
  for (let t = 0; t < triangles.length / 3; t++) {
    const vs = corners(triangles, t);
    if (!drawn(vs)) continue;
    const across = [0, 1, 2].map((k) => {
      const [a, b] = [vs[(k + 1) % 3], vs[(k + 2) % 3]];
      return moved(scale(add(eyes[a], eyes[b]), 0.5), cross(add(turns[a], turns[b]), sub(eyes[b], eyes[a])));
    });
    cubic(vs.map((v) => screen[v]), vs.map((v) => values[v]), vs.map((v) => slopes[v]), across, out, 48 * t);
  }
  return out;
}

// Writes the ordinates of one triangle from the places, values and slopes of its corners, and the direction on the
// screen across each edge. For patch, pass light values and their slopes.
export function cubic(place, value, slope, across, out, at) {
  const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];
  const centroid = [0, 1].map((i) => (place[0][i] + place[1][i] + place[2][i]) / 3);
  // Where the line across each edge through the centroid meets the edge: 0 at its first corner, 1 at its second.
  const crossings = [0, 1, 2].map((k) => {
    const i = (k + 1) % 3, edge = minus(place[(k + 2) % 3], place[i]);
    const sine = Math.abs(perp(across[k], edge)) / (Math.hypot(...across[k]) * Math.hypot(...edge));
    const direction = sine > MIN_SINE ? across[k] : [-edge[1], edge[0]];
    const crossing = perp(minus(centroid, place[i]), direction) / perp(edge, direction);
    return Number.isFinite(crossing) ? crossing : 0.5;
  });
  for (let c = 0; c < 4; c++) {
    const toward = (i, j) => {
      const [x, y] = minus(place[j], place[i]);
      return value[i][c] + (slope[i][c][0] * x + slope[i][c][1] * y) / 3;
    };
    const next = [0, 1, 2].map((i) => toward(i, (i + 1) % 3)), previous = [0, 1, 2].map((i) => toward(i, (i + 2) % 3));
    const near = [0, 1, 2].map((i) => (value[i][c] + next[i] + previous[i]) / 3);
    for (let k = 0; k < 3; k++) {
      const [i, j] = [(k + 1) % 3, (k + 2) % 3], x = crossings[k];
      const bend = (1 - x) * (next[i] - (value[i][c] + previous[j]) / 2) + x * (previous[j] - (next[i] + value[j][c]) / 2);
      out[at + 4 * k + c] = value[k][c];
      out[at + 4 * (3 + k) + c] = next[k];
      out[at + 4 * (6 + k) + c] = previous[k];
      out[at + 4 * (9 + k) + c] = (near[i] + near[j]) / 2 + bend;
    }
  }
}
