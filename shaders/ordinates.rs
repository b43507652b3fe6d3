//! The numbers that *c1-phong* and *patch* need, in plain Rust. Copy this file; it needs no other.
//!
//! Call [`curvature`] once per mesh and [`ordinates`] for every view of it. Vertices are shared between triangles:
//! vertices with the same position and normal must be one vertex. The model-view matrix may rotate, move and scale, but
//! not distort. Matrices are column by column, as in OpenGL.

pub type V = [f64; 3];
/// A smooth field: three components of the normal (or red, green and blue) and z in view space.
pub type Value = [f64; 4];
/// The change of the normal per step on the surface: the rows of a symmetric matrix.
pub type Tensor = [V; 3];

pub struct Camera {
    pub model_view: [f64; 16],
    pub projection: [f64; 16],
    /// Width and height of the viewport in pixels.
    pub size: [f64; 2],
}

/// The weight of the neighboring vertices, relative to the curvature. They decide near silhouettes.
const RING: f64 = 0.07;
/// The smallest sine of the angle between an edge and the direction across it.
const MIN_SINE: f64 = 0.1;

/// Returns what the compute passes need to find the triangles around each of `count` vertices: where the list of each
/// vertex starts, with the end of the last; and for each triangle in a list, the vertices that follow and precede.
pub fn rings(count: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 2]>) {
    let mut pairs = vec![Vec::new(); count];
    for t in triangles {
        for k in 0..3 {
            pairs[t[k] as usize].push([t[(k + 1) % 3], t[(k + 2) % 3]]);
        }
    }
    let mut starts = vec![0];
    for pairs in &pairs {
        starts.push(starts[starts.len() - 1] + pairs.len() as u32);
    }
    (starts, pairs.concat())
}

/// Returns dN/dp at each vertex: the mean over its triangles, weighted by the area that is nearest to the vertex.
pub fn curvature(positions: &[V], normals: &[V], triangles: &[[u32; 3]]) -> Vec<Tensor> {
    let mut sums = vec![([[0.0; 3]; 3], 0.0); positions.len()];
    for t in triangles {
        let (p, n) = (t.map(|v| positions[v as usize]), t.map(|v| normals[v as usize]));
        let edges = [0, 1, 2].map(|k| sub(p[(k + 2) % 3], p[(k + 1) % 3]));
        let cross_product = cross(edges[2], sub(p[2], p[0]));
        let area = length(cross_product) / 2.0;
        if area <= 1e-12 * edges.map(|e| dot(e, e)).into_iter().fold(0.0, f64::max) {
            continue;
        }
        let normal = scale(cross_product, 0.5 / area);
        let (u, v) = (unit(edges[0]), cross(normal, unit(edges[0])));
        // The symmetric matrix ((e, f), (f, g)) over (u, v) that best maps each edge to the change of the normal.
        let [mut uu, mut uv, mut vv, mut re, mut rf, mut rg] = [0.0; 6];
        for k in 0..3 {
            let change = sub(n[(k + 2) % 3], n[(k + 1) % 3]);
            let (x, y, dx, dy) = (dot(edges[k], u), dot(edges[k], v), dot(change, u), dot(change, v));
            (uu, uv, vv) = (uu + x * x, uv + x * y, vv + y * y);
            (re, rf, rg) = (re + x * dx, rf + x * dy + y * dx, rg + y * dy);
        }
        let f = (rf - re * uv / uu - rg * uv / vv) / (uu + vv - uv * uv / uu - uv * uv / vv);
        let (e, g) = ((re - f * uv) / uu, (rg - f * uv) / vv);
        for k in 0..3 {
            let own = n[k];
            let face = if dot(normal, own) < 0.0 { scale(normal, -1.0) } else { normal };
            let (u, v) = (turned(u, face, own), turned(v, face, own));
            let weight = nearest_area(edges, area, k);
            let (sum, total) = &mut sums[t[k] as usize];
            for (i, row) in sum.iter_mut().enumerate() {
                for (j, sum) in row.iter_mut().enumerate() {
                    *sum += weight * (e * u[i] * u[j] + f * (u[i] * v[j] + v[i] * u[j]) + g * v[i] * v[j]);
                }
            }
            *total += weight;
        }
    }
    sums.into_iter().map(|(sum, total)| sum.map(|row| scale(row, 1.0 / f64::max(total, 1e-300)))).collect()
}

/// Rotates `x` as the shortest rotation from `from` to `to` does.
fn turned(x: V, from: V, to: V) -> V {
    let axis = cross(from, to);
    let step = cross(axis, x);
    add(add(x, step), scale(cross(axis, step), 1.0 / (1.0 + dot(from, to))))
}

/// Returns the part of a triangle that is nearest to corner k (Meyer et al. 2003).
fn nearest_area(edges: [V; 3], area: f64, k: usize) -> f64 {
    let squares = edges.map(|e| dot(e, e));
    let cosines = [0, 1, 2].map(|k| squares[(k + 1) % 3] + squares[(k + 2) % 3] - squares[k]);
    match cosines.iter().position(|c| *c < 0.0) {
        Some(obtuse) => area / if obtuse == k { 2.0 } else { 4.0 },
        None => [1, 2].map(|i| squares[(k + i) % 3] * cosines[(k + i) % 3]).iter().sum::<f64>() / (32.0 * area),
    }
}

/// Returns the twelve ordinates of every triangle for *c1-phong*: the three corners, the ordinates a third of the way
/// to the next corner, those to the previous corner, and the middles at the edges opposite each corner. A triangle that
/// faces away, or that reaches behind the eye, gets zeros: draw it with plain interpolated normals.
pub fn ordinates(
    positions: &[V],
    normals: &[V],
    triangles: &[[u32; 3]],
    curvature: &[Tensor],
    camera: &Camera,
) -> Vec<[[f32; 4]; 12]> {
    let eyes: Vec<V> = positions.iter().map(|p| camera.point(*p)).collect();
    let turned: Vec<V> = normals.iter().map(|n| unit(camera.direction(*n))).collect();
    let screen: Vec<Option<[f64; 2]>> = eyes.iter().map(|eye| camera.screen(*eye)).collect();
    let values: Vec<Value> = eyes.iter().zip(&turned).map(|(eye, n)| [n[0], n[1], n[2], eye[2]]).collect();
    // The triangles that are drawn, and the other vertices of those around each vertex.
    let drawn = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| screen[v as usize]);
        let corners = [a?, b?, c?];
        (turn(corners[0], corners[1], corners[2]) > 0.0).then_some(corners)
    };
    let mut rings = vec![Vec::new(); eyes.len()];
    for t in triangles.iter().filter(|t| drawn(t).is_some()) {
        for k in 0..3 {
            for other in [t[(k + 1) % 3], t[(k + 2) % 3]] {
                if !rings[t[k] as usize].contains(&other) {
                    rings[t[k] as usize].push(other);
                }
            }
        }
    }
    let slopes: Vec<[[f64; 2]; 4]> = (0..eyes.len())
        .map(|v| {
            let Some(own) = screen[v] else { return [[0.0; 2]; 4] };
            let mut sum = Slope::default();
            for other in rings[v].iter().map(|other| *other as usize) {
                let Some(place) = screen[other] else { continue };
                let offset = [place[0] - own[0], place[1] - own[1]];
                let squared = offset[0] * offset[0] + offset[1] * offset[1];
                if squared > 0.0 {
                    sum.add(offset, std::array::from_fn(|c| values[other][c] - values[v][c]), 1.0 / squared);
                }
            }
            sum.weigh(RING);
            // Two steps on the surface: across the line of sight, and away from the eye.
            let (eye, normal, toward) = (eyes[v], turned[v], camera.toward(eyes[v]));
            let [across, away] = tangents(normal, toward);
            let pixels = length2(camera.moved(eye, tangents(toward, normal)[0]));
            for step in [Some(across), (dot(normal, toward) > 0.0).then_some(away)].into_iter().flatten() {
                let change = camera.bent(&curvature[v], step);
                let change = [change[0], change[1], change[2], step[2]].map(|c| c / pixels);
                sum.add(camera.moved(eye, step).map(|s| s / pixels), change, 1.0);
            }
            sum.solve()
        })
        .collect();
    let of_triangle = |t: &[u32; 3]| {
        let Some(place) = drawn(t) else { return [[0.0; 4]; 12] };
        let across = [0, 1, 2].map(|k| {
            let (a, b) = (t[(k + 1) % 3] as usize, t[(k + 2) % 3] as usize);
            let middle = scale(add(eyes[a], eyes[b]), 0.5);
            camera.moved(middle, cross(add(turned[a], turned[b]), sub(eyes[b], eyes[a])))
        });
        let [value, slope] = [(); 2].map(|()| t.map(|v| v as usize));
        cubic(place, value.map(|v| values[v]), slope.map(|v| slopes[v]), across)
    };
    triangles.iter().map(of_triangle).collect()
}

/// Returns the ordinates of one triangle from the places, values and slopes of its corners, and the direction on the
/// screen across each edge. For *patch*, pass light values and their slopes.
pub fn cubic(
    place: [[f64; 2]; 3],
    value: [Value; 3],
    slope: [[[f64; 2]; 4]; 3],
    across: [[f64; 2]; 3],
) -> [[f32; 4]; 12] {
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let perp = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let centroid = [0, 1].map(|i| (place[0][i] + place[1][i] + place[2][i]) / 3.0);
    let mut out = [[0.0; 4]; 12];
    for c in 0..4 {
        let toward = |i: usize, j: usize| {
            let step = minus(place[j], place[i]);
            value[i][c] + (slope[i][c][0] * step[0] + slope[i][c][1] * step[1]) / 3.0
        };
        let next = [0, 1, 2].map(|i| toward(i, (i + 1) % 3));
        let previous = [0, 1, 2].map(|i| toward(i, (i + 2) % 3));
        let near = [0, 1, 2].map(|i| (value[i][c] + next[i] + previous[i]) / 3.0);
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            // Where the line across the edge through the centroid meets the edge: 0 at corner i, 1 at corner j.
            let edge = minus(place[j], place[i]);
            let sine = perp(across[k], edge).abs() / (length2(across[k]) * length2(edge));
            let direction = if sine > MIN_SINE { across[k] } else { [-edge[1], edge[0]] };
            let at = perp(minus(centroid, place[i]), direction) / perp(edge, direction);
            let at = if at.is_finite() { at } else { 0.5 };
            let middle = (near[i] + near[j]) / 2.0
                + (1.0 - at) * (next[i] - (value[i][c] + previous[j]) / 2.0)
                + at * (previous[j] - (next[i] + value[j][c]) / 2.0);
            (out[k][c], out[3 + k][c]) = (value[k][c] as f32, next[k] as f32);
            (out[6 + k][c], out[9 + k][c]) = (previous[k] as f32, middle as f32);
        }
    }
    out
}

/// The equations of a slope on the screen: observations of the change along an offset.
#[derive(Default)]
struct Slope {
    matrix: [f64; 3],
    right: [[f64; 2]; 4],
}

impl Slope {
    fn add(&mut self, [x, y]: [f64; 2], change: Value, weight: f64) {
        self.matrix = std::array::from_fn(|i| self.matrix[i] + weight * [x * x, x * y, y * y][i]);
        for (right, change) in self.right.iter_mut().zip(change) {
            *right = [right[0] + weight * x * change, right[1] + weight * y * change];
        }
    }

    /// Gives everything so far this weight in all.
    fn weigh(&mut self, weight: f64) {
        let trace = self.matrix[0] + self.matrix[2];
        let factor = if trace > 0.0 { weight / trace } else { 0.0 };
        self.matrix = self.matrix.map(|m| m * factor);
        self.right = self.right.map(|r| r.map(|r| r * factor));
    }

    /// The slope is zero in a direction that the observations do not determine.
    fn solve(&self) -> [[f64; 2]; 4] {
        let [xx, xy, yy] = self.matrix;
        let (determinant, trace) = (xx * yy - xy * xy, xx + yy);
        self.right.map(|[x, y]| match () {
            () if determinant > 1e-14 * trace * trace => {
                [(yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant]
            }
            () if trace > 0.0 => [x / trace, y / trace],
            () => [0.0; 2],
        })
    }
}

impl Camera {
    fn direction(&self, d: V) -> V {
        let m = &self.model_view;
        [0, 1, 2].map(|i| m[i] * d[0] + m[4 + i] * d[1] + m[8 + i] * d[2])
    }

    fn point(&self, p: V) -> V {
        let m = &self.model_view;
        add(self.direction(p), [m[12], m[13], m[14]])
    }

    /// Returns the change of the unit normal for a step in view space.
    fn bent(&self, tensor: &Tensor, step: V) -> V {
        let m = &self.model_view;
        let columns = [0, 1, 2].map(|i| [m[4 * i], m[4 * i + 1], m[4 * i + 2]]);
        let squared = dot(columns[0], columns[0]);
        let back = columns.map(|column| dot(column, step));
        scale(self.direction(tensor.map(|row| dot(row, back))), 1.0 / (squared * squared.sqrt()))
    }

    /// Returns x, y and w of the projection.
    fn projected(&self, p: V, w: f64) -> V {
        let m = &self.projection;
        [0, 1, 3].map(|i| m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i] * w)
    }

    /// Returns the place on the screen in pixels, y up; `None` behind the eye.
    fn screen(&self, eye: V) -> Option<[f64; 2]> {
        let [x, y, w] = self.projected(eye, 1.0);
        (w > 0.0).then(|| [x / w * self.size[0] / 2.0, y / w * self.size[1] / 2.0])
    }

    /// Returns the movement on the screen of a point that moves along `step`, per step.
    fn moved(&self, eye: V, step: V) -> [f64; 2] {
        let ([x, y, w], [dx, dy, dw]) = (self.projected(eye, 1.0), self.projected(step, 0.0));
        [(dx * w - x * dw) / (w * w) * self.size[0] / 2.0, (dy * w - y * dw) / (w * w) * self.size[1] / 2.0]
    }

    /// Returns the unit vector toward the eye.
    fn toward(&self, eye: V) -> V {
        if self.projection[15] == 1.0 { [0.0, 0.0, 1.0] } else { unit(scale(eye, -1.0)) }
    }
}

/// Returns two unit vectors perpendicular to `normal`; the first is also perpendicular to `other`.
fn tangents(normal: V, other: V) -> [V; 2] {
    let mut across = cross(normal, other);
    if dot(across, across) < 1e-12 {
        across = cross(normal, if normal[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] });
    }
    [unit(across), cross(normal, unit(across))]
}

fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn scale(a: V, s: f64) -> V {
    a.map(|x| x * s)
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: V) -> f64 {
    dot(a, a).sqrt()
}

fn length2([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

fn unit(a: V) -> V {
    scale(a, 1.0 / length(a).max(1e-300))
}
