//! The cubic of *c1-phong* and *patch*, in plain Rust (edition 2021). The library includes this file; copy it, and you
//! need no other.
//!
//! Call [`Surface::new`] once per mesh and [`coefficients`] for every view of it. Vertices are shared between triangles:
//! vertices with the same position and normal must be one vertex. The model-view matrix may rotate, move and scale, but
//! not distort. Matrices are column by column, as in OpenGL.
//!
//! Every vertex has a value and its slope on the screen. A reduced Clough–Tocher cubic joins them: each triangle is
//! split at its centroid into three parts, each with a cubic, and along an edge the slope across it changes linearly.
//! Both triangles at an edge find the same value and slope there without knowing each other. Across an edge at which
//! the curvature of the mesh jumps, as between a plane and a rounding, only the values are the same.
//!
//! R. W. Clough & J. L. Tocher 1965; in Bézier form as in G. Farin, *Triangular Bernstein–Bézier patches*, Comput. Aided
//! Geom. Des. 3 (1986) 83. Curvature: S. Rusinkiewicz, *Estimating curvatures and their derivatives on triangle meshes*,
//! 3DPVT 2004.

use std::collections::HashMap;

/// Three numbers: a position, a direction, or red, green and blue.
pub type V = [f64; 3];
/// dN/dp, the change of the unit normal per step on the surface: the rows of a symmetric matrix.
pub type Tensor = [V; 3];
/// The slopes of three components on the screen, per pixel along x and along y.
pub type Gradient = [[f64; 2]; 3];
/// The twelve coefficients of a triangle, each with three components; see [`value`].
pub type Coefficients = [V; 12];

/// The weight of the neighboring vertices, relative to the curvature. Where the surface turns away by the angle θ, a
/// step on it is foreshortened on the screen by cos θ, and the curvature carries less and less information there. Of the
/// values from 0 to 0.5, this one gave the smallest errors on spheres, tori and bumpy surfaces that were traced pixel by
/// pixel; 0.05 and 0.1 are within a few percent of it.
pub const RING: f64 = 0.07;
/// The cosine between the normal and the direction to the eye below which the curvature counts less. Where the normal of
/// a corner faces away, as on a coarse bevel, its tangent plane is not what is seen of the triangle. Less abruptly than
/// at 0, so that nothing jumps while the mesh turns.
const FACING: f64 = 0.05;
/// The smallest sine of the angle between an edge and the direction across it.
const MIN_SINE: f64 = 0.1;
/// The smallest change of the normal across a face, in radians, that counts as a bend.
const BENT: f64 = 0.02;
/// A face counts as flat in one direction if its curvature is at most this share of its neighbor's, and two faces count
/// as parts of one cylinder or plane if their tensors differ by no more. Normals in files are rounded.
const FLAT: f64 = 2e-3;
/// No triangle.
pub const NONE: u32 = u32::MAX;

/// What [`coefficients`] and the passes on the graphics card need, once per mesh. At a jump of the curvature, a vertex is
/// several points: one for each of its fans, the triangles around it over which the curvature does not jump.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// The vertex of each point. The first points are those of the vertices, in the same order.
    pub vertices: Vec<u32>,
    /// The position of each point.
    pub positions: Vec<V>,
    /// The unit normal of each point.
    pub normals: Vec<V>,
    /// dN/dp at each point, in the mesh's own axes and units.
    pub curvature: Vec<Tensor>,
    /// The points at the corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The points whose slopes count along the edges of each triangle: for each corner, along the edge to the next corner
    /// and along the edge to the previous one. Where the curvature jumps, both triangles use the flatter fan, to which
    /// the edge belongs exactly.
    pub sides: Vec<[[u32; 2]; 3]>,
}

impl Surface {
    /// Computes the curvature of a mesh. Triangles go around counterclockwise as seen from outside.
    pub fn new(positions: &[V], normals: &[V], triangles: &[[u32; 3]]) -> Surface {
        Surface::joined(positions, normals, triangles, &neighbors(triangles))
    }

    /// Computes the curvature of a mesh whose triangles are joined as in `across`, which is what [`neighbors`] returns.
    ///
    /// Each face gets the tensor that best fits the differences between its corners' normals along its three edges. A
    /// point gets the mean of its faces' tensors, turned into the vertex's tangent plane and weighted by the part of each
    /// face that is nearest to the vertex. Faces without area do not count; a point without faces gets zero.
    pub fn joined(positions: &[V], normals: &[V], triangles: &[[u32; 3]], across: &[[u32; 3]]) -> Surface {
        let faces = triangles.iter().map(|t| Face::of(positions, normals, *t)).collect();
        let parts = Parts { positions, triangles, across, faces };
        let (vertices, triangles) = parts.divided();
        let of = |vectors: &[V]| -> Vec<V> { vertices.iter().map(|v| vectors[*v as usize]).collect() };
        let (positions, normals) = (of(positions), of(normals));
        let mut sums = vec![([[0.0; 3]; 3], 0.0); vertices.len()];
        for (t, face) in triangles.iter().zip(&parts.faces) {
            let Some(face) = face else { continue };
            let t = t.map(|point| point as usize);
            for (point, weight) in t.into_iter().zip(nearest_areas(t.map(|point| positions[point]))) {
                let tensor = turned(&face.tensor, face.normal, normals[point]);
                let (sum, total) = &mut sums[point];
                *sum = each(|i, j| sum[i][j] + weight * tensor[i][j]);
                *total += weight;
            }
        }
        let curvature: Vec<_> = sums.iter().zip(&normals).map(|((sum, total), n)| tangent(sum, *total, *n)).collect();
        let sides = sides(&curvature, &triangles, across);
        Surface { vertices, positions, normals, curvature, triangles, sides }
    }

    /// Returns what the passes on the card need to find the triangles around each point: where the list of each point
    /// starts, with the end of the last; and for each triangle in a list, the points that follow and precede, and the third
    /// point of the point's triangle across the edge to the one that precedes, or the point itself.
    pub fn rings(&self) -> (Vec<u32>, Vec<[u32; 4]>) {
        let (mut starts, mut lists) = (vec![0], vec![Vec::new(); self.positions.len()]);
        let vertices: Vec<_> = self.triangles.iter().map(|t| t.map(|point| self.vertices[point as usize])).collect();
        for (t, across) in self.triangles.iter().zip(neighbors(&vertices)) {
            for k in 0..3 {
                let corner = across[(k + 1) % 3] as usize;
                let other = self.triangles.get(corner / 3).filter(|other| other[(corner + 1) % 3] == t[k]);
                let beyond = other.map_or(t[k], |other| other[corner % 3]);
                lists[t[k] as usize].push([t[(k + 1) % 3], t[(k + 2) % 3], beyond, 0]);
            }
        }
        starts.extend(lists.iter().scan(0, |end, list| {
            *end += list.len() as u32;
            Some(*end)
        }));
        (starts, lists.concat())
    }
}

/// Returns, for each edge k of each triangle, opposite corner k, the corner of the triangle across it: 3 · triangle +
/// corner, or [`NONE`] unless exactly two triangles share both vertices and go along the edge in opposite directions.
pub fn neighbors(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut first: HashMap<[u32; 2], (u32, u32)> = HashMap::with_capacity(triangles.len() * 3 / 2);
    let mut across = vec![[NONE; 3]; triangles.len()];
    let edge = |corner: u32| {
        let t = triangles[corner as usize / 3];
        [t[(corner as usize + 1) % 3], t[(corner as usize + 2) % 3]]
    };
    for corner in 0..3 * triangles.len() as u32 {
        let [a, b, c] = triangles[corner as usize / 3];
        if a == b || b == c || c == a {
            continue;
        }
        let [from, to] = edge(corner);
        let known = first.entry([from.min(to), from.max(to)]).or_insert((corner, 0));
        known.1 += 1;
        let other = known.0;
        if known.1 == 2 && edge(other) == [to, from] {
            across[corner as usize / 3][corner as usize % 3] = other;
            across[other as usize / 3][other as usize % 3] = corner;
        } else if known.1 > 2 {
            // Three triangles at one edge: none of them is joined.
            let second = std::mem::replace(&mut across[other as usize / 3][other as usize % 3], NONE);
            if second != NONE {
                across[second as usize / 3][second as usize % 3] = NONE;
            }
        }
    }
    across
}

/// A mesh without its normals, and what its faces say about them.
struct Parts<'a> {
    positions: &'a [V],
    triangles: &'a [[u32; 3]],
    across: &'a [[u32; 3]],
    faces: Vec<Option<Face>>,
}

impl Parts<'_> {
    /// Divides the triangles around the vertices at jumps of the curvature: returns the vertex of each point, and the points
    /// at the corners. Other vertices keep one fan, even where their faces do not join.
    fn divided(&self) -> (Vec<u32>, Vec<[u32; 3]>) {
        let Parts { positions, triangles, across, .. } = *self;
        let (mut vertices, mut of_corners): (Vec<u32>, _) = ((0..positions.len() as u32).collect(), triangles.to_vec());
        let jumps: Vec<bool> = shared_edges(across).map(|edge| self.is_jump(edge)).collect();
        if !jumps.contains(&true) {
            return (vertices, of_corners);
        }
        let mut parent: Vec<u32> = (0..3 * triangles.len() as u32).collect();
        let mut at_jump = vec![false; positions.len()];
        for ((t, k, other), is_jump) in shared_edges(across).zip(jumps) {
            let (u, l) = (other / 3, other % 3);
            let ends = [1, 2].map(|end| (t * 3 + (k + end) % 3, u * 3 + (l + 3 - end) % 3));
            if is_jump {
                for (own, _) in ends {
                    at_jump[triangles[own as usize / 3][own as usize % 3] as usize] = true;
                }
            } else {
                for (own, their) in ends {
                    join(&mut parent, own, their);
                }
            }
        }
        let mut of_root: HashMap<u32, u32> = HashMap::new();
        let mut has_first = vec![false; positions.len()];
        for corner in 0..parent.len() as u32 {
            let of_corner = &mut of_corners[corner as usize / 3][corner as usize % 3];
            let vertex = *of_corner;
            if at_jump[vertex as usize] {
                *of_corner = *of_root.entry(root(&mut parent, corner)).or_insert_with(|| {
                    if std::mem::replace(&mut has_first[vertex as usize], true) {
                        vertices.push(vertex);
                        vertices.len() as u32 - 1
                    } else {
                        vertex
                    }
                });
            }
        }
        (vertices, of_corners)
    }

    /// True if the curvature across an edge jumps there, as between a plane and a rounding: one side is flat across the
    /// edge and continues into a face with the same curvature, and the other side is bent. Without such jumps, the slope of
    /// the normals would be averaged over both sides, and planes would ripple.
    fn is_jump(&self, (t, k, other): (u32, u32, u32)) -> bool {
        let Parts { positions, triangles, across, faces } = self;
        let [t, k, u] = [t, k, other / 3].map(|i| i as usize);
        let (Some(one), Some(other)) = (&faces[t], &faces[u]) else { return false };
        let [a, b] = [1, 2].map(|end| positions[triangles[t][(k + end) % 3] as usize]);
        // The change of the normal across each face, as far as the face extends.
        let bend = |face: &Face, t: usize| {
            let direction = unit(cross(face.normal, sub(b, a)));
            let corners = triangles[t].map(|v| dot(sub(positions[v as usize], a), direction));
            let extent = corners.into_iter().fold(0.0, f64::max) - corners.into_iter().fold(0.0, f64::min);
            (dot(direction, times(&face.tensor, direction)), extent)
        };
        let ((own, extent), (their, their_extent)) = (bend(one, t), bend(other, u));
        let continues = |t: usize, face: &Face, scale: f64| {
            across[t].iter().filter(|next| **next != NONE && **next as usize / 3 != t).any(|next| {
                let Some(neighbor) = &faces[*next as usize / 3] else { return false };
                let turned = turned(&neighbor.tensor, neighbor.normal, face.normal);
                squares(&each(|i, j| turned[i][j] - face.tensor[i][j])) <= (FLAT * scale).powi(2)
            })
        };
        let is_flat = |flat: f64, bent: f64, extent: f64| flat.abs() <= FLAT * bent.abs() && bent.abs() * extent > BENT;
        is_flat(own, their, their_extent) && continues(t, one, their.abs())
            || is_flat(their, own, extent) && continues(u, other, own.abs())
    }
}

/// Returns, for each of `count` points, the other vertices of its triangles, each once, in the order of the triangles. Each
/// triangle is given by the points and the vertices of its corners.
pub fn around(count: usize, triangles: impl Iterator<Item = ([u32; 3], [u32; 3])>) -> Vec<Vec<u32>> {
    let mut rings = vec![Vec::new(); count];
    for (points, vertices) in triangles {
        for k in 0..3 {
            let ring: &mut Vec<u32> = &mut rings[points[k] as usize];
            for other in [vertices[(k + 1) % 3], vertices[(k + 2) % 3]] {
                if !ring.contains(&other) {
                    ring.push(other);
                }
            }
        }
    }
    rings
}

/// Every shared edge once: the lower triangle, its corner opposite the edge, and the corner across.
fn shared_edges(across: &[[u32; 3]]) -> impl Iterator<Item = (u32, u32, u32)> + '_ {
    let sides = (0..across.len() as u32).flat_map(|t| [(t, 0), (t, 1), (t, 2)]);
    sides.map(|(t, k)| (t, k, across[t as usize][k as usize])).filter(|(t, _, other)| *other != NONE && other / 3 > *t)
}

/// Joins the fans of two corners. The lower index identifies the fan, whatever the order of the edges.
pub fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

/// Returns the corner that identifies the fan of a corner.
pub fn root(parent: &mut [u32], mut at: u32) -> u32 {
    while parent[at as usize] != at {
        parent[at as usize] = parent[parent[at as usize] as usize];
        at = parent[at as usize];
    }
    at
}

fn sides(curvature: &[Tensor], of_corners: &[[u32; 3]], across: &[[u32; 3]]) -> Vec<[[u32; 2]; 3]> {
    let mut sides: Vec<[[u32; 2]; 3]> = of_corners.iter().map(|fans| fans.map(|fan| [fan; 2])).collect();
    for (t, k, other) in shared_edges(across) {
        let ([t, k], [u, l]) = ([t, k].map(|i| i as usize), [other / 3, other % 3].map(|i| i as usize));
        // The two triangles go along the edge in opposite directions.
        for (order, own, their) in [(0, (k + 1) % 3, (l + 2) % 3), (1, (k + 2) % 3, (l + 1) % 3)] {
            let [one, another] = [of_corners[t][own], of_corners[u][their]];
            let is_flatter = squares(&curvature[one as usize]) <= squares(&curvature[another as usize]);
            let flatter = if is_flatter { one } else { another };
            (sides[t][own][order], sides[u][their][1 - order]) = (flatter, flatter);
        }
    }
    sides
}

/// The normal of a face and its dN/dp.
struct Face {
    normal: V,
    tensor: Tensor,
}

impl Face {
    /// Returns the data of a face; `None` if it has no area.
    fn of(positions: &[V], normals: &[V], t: [u32; 3]) -> Option<Face> {
        let (p, n) = (t.map(|v| positions[v as usize]), t.map(|v| normals[v as usize]));
        let edges = [0, 1, 2].map(|k| sub(p[(k + 2) % 3], p[(k + 1) % 3]));
        // In units of the longest edge, so that nothing overflows.
        let longest = edges.map(length).into_iter().fold(0.0, f64::max);
        let edges = edges.map(|edge| scale(edge, 1.0 / longest));
        let area = cross(edges[2], scale(edges[1], -1.0));
        if length(area).is_nan() || length(area) <= 1e-14 {
            return None;
        }
        let (normal, u) = (unit(area), unit(edges[0]));
        let v = cross(normal, u);
        // Least squares for the tensor ((e, f), (f, g)) in (u, v) that maps every edge to the change of the normal along
        // it. The normal equations have the matrix ((uu, uv, 0), (uv, uu + vv, uv), (0, uv, vv)).
        let [mut uu, mut uv, mut vv, mut right_e, mut right_f, mut right_g] = [0.0; 6];
        for k in 0..3 {
            let (x, y, change) = (dot(edges[k], u), dot(edges[k], v), sub(n[(k + 2) % 3], n[(k + 1) % 3]));
            let (dx, dy) = (dot(change, u), dot(change, v));
            (uu, uv, vv) = (uu + x * x, uv + x * y, vv + y * y);
            (right_e, right_f, right_g) = (right_e + x * dx, right_f + x * dy + y * dx, right_g + y * dy);
        }
        let f = (right_f - right_e * uv / uu - right_g * uv / vv) / (uu + vv - uv * uv / uu - uv * uv / vv);
        let (e, g) = ((right_e - f * uv) / uu, (right_g - f * uv) / vv);
        let tensor = each(|i, j| (e * u[i] * u[j] + f * (u[i] * v[j] + v[i] * u[j]) + g * v[i] * v[j]) / longest);
        tensor.as_flattened().iter().all(|x| x.is_finite()).then_some(Face { normal, tensor })
    }
}

/// Turns a face's tensor into the tangent plane of a vertex by the smallest possible rotation. A normal that points to
/// the other side of the face has the same tangent plane.
fn turned(tensor: &Tensor, face: V, vertex: V) -> Tensor {
    let face = if dot(face, vertex) < 0.0 { scale(face, -1.0) } else { face };
    let (axis, cosine) = (cross(face, vertex), dot(face, vertex));
    let turn = |x: V| {
        let step = cross(axis, x);
        add(add(x, step), scale(cross(axis, step), 1.0 / (1.0 + cosine)))
    };
    // R T Rᵀ: first the columns of T, which are its rows, then the rows of the result.
    let half = transposed(tensor.map(turn));
    transposed(half.map(turn))
}

/// Returns the weighted mean, without the rounding errors along the normal.
fn tangent(sum: &Tensor, total: f64, normal: V) -> Tensor {
    let flat = |x: V| sub(x, scale(normal, dot(normal, x)));
    let rows = transposed(sum.map(|row| flat(scale(row, 1.0 / total)))).map(flat);
    let mean = each(|i, j| (rows[i][j] + rows[j][i]) / 2.0);
    if mean.as_flattened().iter().all(|x| x.is_finite()) { mean } else { [[0.0; 3]; 3] }
}

/// Returns how much of a triangle's area is nearest to each corner. If an angle is obtuse, half of the area belongs to
/// that corner and a quarter to each of the others (Meyer et al. 2003).
fn nearest_areas([a, b, c]: [V; 3]) -> V {
    let squared = [sub(c, b), sub(a, c), sub(b, a)].map(|edge| dot(edge, edge));
    let area = length(cross(sub(b, a), sub(c, a))) / 2.0;
    // Twice the cosine at corner k, multiplied by the lengths of its two sides.
    let cosine = [0, 1, 2].map(|k| squared[(k + 1) % 3] + squared[(k + 2) % 3] - squared[k]);
    if let Some(k) = cosine.iter().position(|c| *c < 0.0) {
        return [0, 1, 2].map(|i| area / if i == k { 2.0 } else { 4.0 });
    }
    // (|e_i|² cot i + |e_j|² cot j) / 8, with cot = cosine/(4 area).
    [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        (squared[i] * cosine[i] + squared[j] * cosine[j]) / (32.0 * area)
    })
}

/// How a camera moves points on its screen.
pub trait Screen {
    /// Returns the movement on the screen, in pixels, of a point that moves from `eye` along `step` in view space, per
    /// step.
    fn moved(&self, eye: V, step: V) -> [f64; 2];
    /// Returns the unit vector from a point in view space to the eye.
    fn toward(&self, eye: V) -> V;
}

/// Returns the weight of the curvature at a vertex, and two unit steps on the surface: across the line of sight and away
/// from the eye; with each, its movement on the screen in units of a step seen face on, and that unit in pixels.
pub fn steps(screen: &impl Screen, eye: V, normal: V) -> (f64, [(V, [f64; 2], f64); 2]) {
    let toward = screen.toward(eye);
    let [x, y] = screen.moved(eye, tangents(toward, normal)[0]);
    let unit = x.hypot(y);
    let step = |step| (step, screen.moved(eye, step).map(|s| s / unit), unit);
    ((dot(normal, toward) / FACING).clamp(0.0, 1.0), tangents(normal, toward).map(step))
}

/// Returns two unit vectors perpendicular to `normal`; the first is also perpendicular to `other`.
fn tangents(normal: V, other: V) -> [V; 2] {
    let mut across = cross(normal, other);
    if dot(across, across) < 1e-12 {
        across = cross(normal, if normal[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] });
    }
    [unit(across), cross(normal, unit(across))]
}

/// Returns the direction on the screen in which slopes across an edge are taken, of any length, from the places, the
/// points in view space and the normals of its ends: the direction on the surface that is perpendicular to the edge. In
/// the other order of the ends, it is exactly the opposite.
///
/// Any direction on which both sides agree would make the slope continuous. This one meets the edges of thin triangles
/// well inside, whatever the neighbors' shapes. The perpendicular on the screen would not follow the foreshortening of
/// the surface, and its light bends by a tenth to a third more near silhouettes.
fn across(screen: &impl Screen, places: [[f64; 2]; 2], eyes: [V; 2], normals: [V; 2]) -> [f64; 2] {
    let edge = minus(places[1], places[0]);
    let middle = scale(add(eyes[0], eyes[1]), 0.5);
    let across = screen.moved(middle, cross(add(normals[0], normals[1]), sub(eyes[1], eyes[0])));
    let sine = perp(across, edge).abs() / (across[0].hypot(across[1]) * edge[0].hypot(edge[1]));
    // Near silhouettes, the mean normal can differ so much from the faces' that the direction runs along the edge.
    if sine > MIN_SINE { across } else { [-edge[1], edge[0]] }
}

/// The equations of a slope on the screen: observations of the change along an offset.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slope {
    /// Σ w·x², Σ w·xy, Σ w·y².
    matrix: V,
    /// Σ w·change·(x, y) of each component.
    right: Gradient,
}

impl Slope {
    /// Adds the observation that a step of `offset` changes the values by `change`.
    pub fn add(&mut self, [x, y]: [f64; 2], change: V, weight: f64) {
        self.matrix = [0, 1, 2].map(|i| self.matrix[i] + weight * [x * x, x * y, y * y][i]);
        for (right, change) in self.right.iter_mut().zip(change) {
            *right = [right[0] + weight * x * change, right[1] + weight * y * change];
        }
    }

    /// Gives everything so far this weight in all.
    pub fn weigh(&mut self, weight: f64) {
        let trace = self.matrix[0] + self.matrix[2];
        let factor = if trace > 0.0 { weight / trace } else { 0.0 };
        self.matrix = self.matrix.map(|m| m * factor);
        self.right = self.right.map(|r| r.map(|r| r * factor));
    }

    /// Returns the slope that fits best; it is zero in a direction that the observations do not determine.
    pub fn solve(&self) -> Gradient {
        let [xx, xy, yy] = self.matrix;
        let (determinant, trace) = (xx * yy - xy * xy, xx + yy);
        self.right.map(|[x, y]| match () {
            () if determinant > 1e-14 * trace * trace => {
                [(yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant]
            }
            // Only one direction is known: the matrix is trace·d·dᵀ, and its pseudo-inverse is d·dᵀ/trace.
            () if trace > 0.0 => [x / trace, y / trace],
            () => [0.0; 2],
        })
    }
}

/// Returns the coefficients of one triangle from the places on the screen, points in view space, normals, values and slopes
/// of its corners. For each corner, the first slope counts along the edge to the next corner, and the second along the
/// edge to the previous one.
pub fn cubic(
    screen: &impl Screen,
    (place, eye, normal): ([[f64; 2]; 3], [V; 3], [V; 3]),
    value: [V; 3],
    slope: [[&Gradient; 2]; 3],
) -> Coefficients {
    let centroid = [0, 1].map(|i| (place[0][i] + place[1][i] + place[2][i]) / 3.0);
    // Where the line across each edge through the centroid meets the edge: 0 at its first corner, 1 at its second.
    let crossing = [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let across = across(screen, [place[i], place[j]], [eye[i], eye[j]], [normal[i], normal[j]]);
        let at = perp(minus(centroid, place[i]), across) / perp(minus(place[j], place[i]), across);
        if at.is_finite() { at } else { 0.5 }
    });
    let mut out = [[0.0; 3]; 12];
    for c in 0..3 {
        let v = value.map(|value| value[c]);
        let along = |i: usize, j: usize, order: usize| {
            let ([x, y], step) = (slope[i][order][c], minus(place[j], place[i]));
            v[i] + (x * step[0] + y * step[1]) / 3.0
        };
        // The ordinates a third of the way from each corner to the next, to the previous one, and to the centroid.
        let next = [0, 1, 2].map(|i| along(i, (i + 1) % 3, 0));
        let previous = [0, 1, 2].map(|i| along(i, (i + 2) % 3, 1));
        let near = [0, 1, 2].map(|i| (v[i] + next[i] + previous[i]) / 3.0);
        // In the middle of each edge's part: it makes the slope across the edge linear along it. In general, that slope
        // is a quadratic, so its own middle ordinate must be the mean of its end ordinates.
        let middle = [0, 1, 2].map(|k| {
            let (i, j, x) = ((k + 1) % 3, (k + 2) % 3, crossing[k]);
            let bend = (1.0 - x) * (next[i] - (v[i] + previous[j]) / 2.0) + x * (previous[j] - (next[i] + v[j]) / 2.0);
            (near[i] + near[j]) / 2.0 + bend
        });
        // Two thirds of the way from each corner to the centroid, and at the centroid.
        let far = [0, 1, 2].map(|i| (near[i] + middle[(i + 1) % 3] + middle[(i + 2) % 3]) / 3.0);
        let center = (far[0] + far[1] + far[2]) / 3.0;
        let cube = |i: usize| v[i] - 3.0 * near[i] + 3.0 * far[i] - center;
        // From corner i toward j; the middle is that of their edge.
        let mixed = |i: usize, j: usize| {
            let ij = if j == (i + 1) % 3 { next[i] } else { previous[i] };
            3.0 * (ij - near[i] - 2.0 * middle[3 - i - j] + 2.0 * far[i] + far[j] - center)
        };
        let k = [
            center,
            3.0 * (far[0] - center),
            3.0 * (far[1] - center),
            3.0 * (near[0] - 2.0 * far[0] + center),
            6.0 * (middle[2] - far[0] - far[1] + center),
            3.0 * (near[1] - 2.0 * far[1] + center),
            cube(0),
            mixed(0, 1),
            mixed(1, 0),
            cube(1),
            -(cube(2) + mixed(2, 0) + mixed(0, 2) + cube(0)) - cube(1),
            -(cube(1) + mixed(1, 2) + mixed(2, 1) + cube(2)) - cube(0),
        ];
        for (out, k) in out.iter_mut().zip(k) {
            out[c] = k;
        }
    }
    out
}

/// Returns the value at the point where the corners have the weights `w`, linear on the screen.
///
/// A cubic with a continuous slope on a triangle that is split at its centroid has a continuous second derivative there,
/// so that its three parts share all terms up to the second degree and differ by two numbers: with x = w₀ − w₂ and
/// y = w₁ − w₂, by terms in x³ where corner 0 has the smallest weight, and in y³ where corner 1 has it.
pub fn value(k: &Coefficients, w: [f64; 3]) -> V {
    let (x, y) = (w[0] - w[2], w[1] - w[2]);
    let xx = if x < 0.0 && x <= y { x * x } else { 0.0 };
    let yy = if y < 0.0 && y < x { y * y } else { 0.0 };
    let (p, q) = (yy * (y - 2.0 * x) - xx * y, xx * (x - 2.0 * y) - yy * x);
    let of = |c: usize| {
        let along = k[0][c] + x * (k[1][c] + x * (k[3][c] + x * k[6][c]));
        let mixed = (k[2][c] + x * (k[4][c] + x * k[7][c])) + y * ((k[5][c] + x * k[8][c]) + y * k[9][c]);
        along + y * mixed + p * k[10][c] + q * k[11][c]
    };
    [of(0), of(1), of(2)]
}

/// A camera as OpenGL has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From the mesh's space to view space, in which y points up and the eye looks along −z.
    pub model_view: [f64; 16],
    /// From view space to clip space.
    pub projection: [f64; 16],
    /// Width and height of the viewport in pixels.
    pub size: [f64; 2],
}

impl Camera {
    fn direction(&self, d: V) -> V {
        let m = &self.model_view;
        [0, 1, 2].map(|i| m[i] * d[0] + m[4 + i] * d[1] + m[8 + i] * d[2])
    }

    /// Returns the change of the unit normal for a step in view space.
    fn bent(&self, tensor: &Tensor, step: V) -> V {
        let m = &self.model_view;
        let columns = [0, 1, 2].map(|i| [m[4 * i], m[4 * i + 1], m[4 * i + 2]]);
        let squared = dot(columns[0], columns[0]);
        let back = columns.map(|column| dot(column, step));
        scale(self.direction(times(tensor, back)), 1.0 / (squared * squared.sqrt()))
    }

    /// Returns x, y and w of the projection.
    fn projected(&self, p: V, w: f64) -> V {
        let m = &self.projection;
        [0, 1, 3].map(|i| m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i] * w)
    }

    /// Returns the place on the screen in pixels, y up; `None` behind the eye.
    fn place(&self, eye: V) -> Option<[f64; 2]> {
        let [x, y, w] = self.projected(eye, 1.0);
        (w > 0.0).then(|| [x / w * self.size[0] / 2.0, y / w * self.size[1] / 2.0])
    }
}

impl Screen for Camera {
    fn moved(&self, eye: V, step: V) -> [f64; 2] {
        let ([x, y, w], [dx, dy, dw]) = (self.projected(eye, 1.0), self.projected(step, 0.0));
        [(dx * w - x * dw) / (w * w) * self.size[0] / 2.0, (dy * w - y * dw) / (w * w) * self.size[1] / 2.0]
    }

    fn toward(&self, eye: V) -> V {
        if self.projection[15] == 1.0 { [0.0, 0.0, 1.0] } else { unit(scale(eye, -1.0)) }
    }
}

/// Returns the coefficients of the normal, in view space, of every triangle. A triangle that faces away, or that reaches
/// behind the eye, gets zeros: draw it with plain interpolated normals.
pub fn coefficients(surface: &Surface, camera: &Camera) -> Vec<[[f32; 3]; 12]> {
    let m = &camera.model_view;
    let eyes: Vec<V> = surface.positions.iter().map(|p| add(camera.direction(*p), [m[12], m[13], m[14]])).collect();
    let normals: Vec<V> = surface.normals.iter().map(|n| unit(camera.direction(*n))).collect();
    let places: Vec<Option<[f64; 2]>> = eyes.iter().map(|eye| camera.place(*eye)).collect();
    let drawn = |t: [u32; 3]| {
        let [a, b, c] = t.map(|v| places[v as usize]);
        let corners = [a?, b?, c?];
        (perp(minus(corners[1], corners[0]), minus(corners[2], corners[0])) > 0.0).then_some(corners)
    };
    let drawn_points = surface.triangles.iter().filter(|t| drawn(**t).is_some()).map(|t| (*t, *t));
    let rings = around(eyes.len(), drawn_points);
    let slope = |v: usize| {
        let mut sum = Slope::default();
        let Some(own) = places[v] else { return sum.solve() };
        for other in rings[v].iter().map(|other| *other as usize) {
            let offset = minus(places[other].unwrap_or(own), own);
            let squared = offset[0] * offset[0] + offset[1] * offset[1];
            if squared > 0.0 {
                sum.add(offset, sub(normals[other], normals[v]), 1.0 / squared);
            }
        }
        sum.weigh(RING);
        let (weight, steps) = steps(camera, eyes[v], normals[v]);
        for (step, offset, pixels) in steps {
            sum.add(offset, scale(camera.bent(&surface.curvature[v], step), 1.0 / pixels), weight);
        }
        sum.solve()
    };
    let slopes: Vec<Gradient> = (0..eyes.len()).map(slope).collect();
    let of_triangle = |(t, sides): (&[u32; 3], &[[u32; 2]; 3])| {
        let Some(place) = drawn(*t) else { return [[0.0; 3]; 12] };
        let of = |vectors: &[V]| t.map(|v| vectors[v as usize]);
        let slopes = sides.map(|sides| sides.map(|side| &slopes[side as usize]));
        let (eye, normal) = (of(&eyes), of(&normals));
        cubic(camera, (place, eye, normal), normal, slopes).map(|k| k.map(|x| x as f32))
    };
    surface.triangles.iter().zip(&surface.sides).map(of_triangle).collect()
}

fn each(of: impl Fn(usize, usize) -> f64) -> Tensor {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| of(i, j)))
}

fn transposed(t: Tensor) -> Tensor {
    each(|i, j| t[j][i])
}

fn times(t: &Tensor, x: V) -> V {
    t.map(|row| dot(row, x))
}

fn squares(t: &Tensor) -> f64 {
    t.as_flattened().iter().map(|x| x * x).sum()
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn perp(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
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

fn unit(a: V) -> V {
    scale(a, 1.0 / length(a).max(1e-300))
}
