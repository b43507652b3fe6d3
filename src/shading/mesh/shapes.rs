//! Meshes that can be requested by name.
//!
//! All meshes are counterclockwise as seen from outside, and all but the terrain are closed. The round meshes have the
//! normals of the [`Smooth`] surface that they approximate; the normals of the others are averaged over the faces around
//! each vertex, as is usual.

use std::f64::consts::TAU;

use delaunator::{Point, triangulate};
use glam::{DVec2, DVec3};

use super::{
    build::{Corner, Polygons},
    smooth::{FILLET, HALF_HEIGHT, Smooth, TUBE, blob_radius, terrain_height},
    triangles::Mesh,
};
use crate::text::names::named;

named! {
    /// The name of a mesh.
    Shape, UnknownShape {
        /// Twelve triangles.
        Cube = "cube",
        /// Shoaff's truncated pyramid.
        Pyramid = "pyramid",
        /// A sphere of nearly equal triangles.
        Sphere = "sphere",
        /// A sphere of meridians and parallels, with twelve times as many meridians: slivers.
        UvSphere = "uv-sphere",
        /// A torus of nearly equal triangles.
        Torus = "torus",
        /// A torus whose vertices are moved at random along its surface.
        JitteredTorus = "jittered-torus",
        /// A round body with hollows.
        Blob = "blob",
        /// Hills over a square.
        Terrain = "terrain",
        /// A cylinder with sharp edges.
        Cylinder = "cylinder",
        /// A cylinder with rounded edges.
        FilletedCylinder = "filleted-cylinder",
    }
}

/// The maximum number of vertices of a shape.
pub const MAX_VERTICES: usize = 500_000;

impl Shape {
    /// True if the number of vertices can be chosen. It is fixed for the cube and the pyramid.
    pub const fn has_vertices(self) -> bool {
        !matches!(self, Shape::Cube | Shape::Pyramid)
    }

    /// The fewest vertices that the shape can have.
    pub const fn min_vertices(self) -> usize {
        match self {
            Shape::Cube | Shape::Pyramid => 8,
            // An icosahedron, or four rows of three.
            Shape::Sphere | Shape::Torus | Shape::JitteredTorus => 12,
            // Twelve times as many meridians as bands between parallels.
            Shape::UvSphere => 12 * MIN_PARALLELS * (MIN_PARALLELS - 1) + 2,
            // A tetrahedron, or the corners of a square.
            Shape::Blob | Shape::Terrain => 4,
            Shape::Cylinder => 2 * MIN_SIDES,
            Shape::FilletedCylinder => filleted_vertices(MIN_SIDES),
        }
    }
}

/// Makes the mesh of `shape` with `vertices` sites. The number is exact for the blob and approximate for the other round
/// shapes, whose triangles would otherwise be distorted; the cube and the pyramid always have 8.
///
/// # Errors
/// Returns an error if `vertices` is outside [`Shape::min_vertices`]…[`MAX_VERTICES`].
pub fn mesh(shape: Shape, vertices: usize) -> Result<Mesh, String> {
    if shape.has_vertices() && !(shape.min_vertices()..=MAX_VERTICES).contains(&vertices) {
        let least = shape.min_vertices();
        return Err(format!("a {shape} cannot have {vertices} vertices; expected {least}…{MAX_VERTICES}"));
    }
    match shape {
        Shape::Cube => Ok(cube()),
        Shape::Pyramid => Ok(pyramid()),
        Shape::Sphere => Ok(sphere((vertices.saturating_sub(2) as f64 / 10.0).sqrt().round() as usize)),
        Shape::UvSphere => {
            let parallels = (1.0 + (1.0 + vertices.saturating_sub(2) as f64 / 3.0).sqrt()) / 2.0;
            Ok(uv_sphere((parallels.round() as usize).max(MIN_PARALLELS)))
        }
        Shape::Torus => Ok(torus_of(vertices, 0.0)),
        Shape::JitteredTorus => Ok(torus_of(vertices, 0.35)),
        Shape::Blob => Ok(blob(vertices)),
        Shape::Terrain => Ok(terrain(((vertices as f64).sqrt().round() as usize).max(2) - 1)),
        Shape::Cylinder => Ok(cylinder(vertices / 2, false)),
        Shape::FilletedCylinder => {
            let sides = (MIN_SIDES..).take_while(|sides| filleted_vertices(*sides) <= vertices).last();
            Ok(cylinder(sides.unwrap_or(MIN_SIDES), true))
        }
    }
}

/// Makes the cube of side 2 around the origin, with 12 triangles and normals averaged at the corners as in the paper's
/// figures.
pub fn cube() -> Mesh {
    let positions: Vec<DVec3> = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from((i >> 1) & 1), f64::from((i >> 2) & 1)) * 2.0 - DVec3::ONE)
        .collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    solid(&Polygons::new(positions, &faces))
}

/// Makes Shoaff's truncated pyramid (§4.1), closed by a base: V1…V8 are sites 0…7, with 12 triangles.
///
/// The normals are Shoaff's: the normalized sum of the three *plane equations* around a vertex, (−1, −1, 3)/√11 at V1.
/// The normals in these equations do not have unit length: z − 1 = 0, −y + z − 2 = 0, −x + z − 2 = 0. The average of
/// unit normals, which the other shapes use, would be along (−1, −1, 1 + √2 + 1).
pub fn pyramid() -> Mesh {
    let square = |half: f64, z: f64| {
        [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| DVec3::new(x, y, z))
    };
    let positions = [square(1.0, 1.0), square(2.0, 0.0)].concat();
    let faces = [[0, 1, 2, 3], [4, 5, 1, 0], [5, 6, 2, 1], [6, 7, 3, 2], [7, 4, 0, 3], [7, 6, 5, 4]];
    let outward = |p: &DVec3| DVec3::new(p.x.signum(), p.y.signum(), if p.z > 0.0 { 3.0 } else { 1.0 });
    let normals = positions.iter().map(|p| Some(outward(p).normalize())).collect();
    solid(&Polygons { normals, ..Polygons::new(positions, &faces) })
}

fn solid(polygons: &Polygons) -> Mesh {
    polygons.mesh(180.0).expect("a solid is a mesh")
}

/// Makes the unit sphere: an icosahedron whose edges are cut into s = `subdivisions` parts (at least 1) and whose
/// vertices are projected onto the sphere. It has 10·s² + 2 vertices and 20·s² triangles of nearly the same size and
/// shape.
pub fn sphere(subdivisions: usize) -> Mesh {
    let s = subdivisions.max(1);
    let golden = f64::midpoint(1.0, 5f64.sqrt());
    let corner = |i: usize| {
        let (a, b) = (if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { golden } else { -golden });
        [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)][i / 4].normalize()
    };
    let corners: Vec<DVec3> = (0..12).map(corner).collect();
    let mut polygons = Polygons::default();
    for face in hull(&corners) {
        let first = polygons.positions.len();
        for (i, j) in (0..=s).flat_map(|i| (0..=s - i).map(move |j| (i, j))) {
            let mut weights = [(face[0], s - i - j), (face[1], i), (face[2], j)];
            // In one order, so that all faces that share a position agree.
            weights.sort_unstable();
            let sum: DVec3 = weights.iter().map(|(corner, weight)| corners[*corner as usize] * *weight as f64).sum();
            polygons.positions.push(sum.normalize());
        }
        // Row i has s + 1 − i positions.
        let site = |i: usize, j: usize| Corner::of((first + i * (2 * s + 3 - i) / 2 + j) as u32);
        for (i, j) in (0..s).flat_map(|i| (0..s - i).map(move |j| (i, j))) {
            polygons.push([site(i, j), site(i + 1, j), site(i, j + 1)]);
            if i + j + 2 <= s {
                polygons.push([site(i + 1, j), site(i + 1, j + 1), site(i, j + 1)]);
            }
        }
    }
    polygons.merge();
    round(&polygons, Smooth::Sphere)
}

/// Makes the torus around the z axis with radius 1 and a tube of radius 0.4. It has `around` sites (at least 3) in each
/// of `tube` rows (even, at least 4). Every other row is half a step ahead, which makes the triangles nearly
/// equilateral where the tube faces up and down. Each site is then moved along the surface at random, by up to `jitter`
/// steps in either direction.
pub fn torus(around: usize, tube: usize, jitter: f64) -> Mesh {
    let (around, tube) = (around.max(3), tube.max(4).next_multiple_of(2));
    let mut positions = Vec::with_capacity(around * tube);
    for row in 0..tube {
        for column in 0..around {
            let moved = |axis: usize| jitter * noise((2 * (row * around + column) + axis) as u64);
            let (sin, cos) = (TAU * (row as f64 + moved(0)) / tube as f64).sin_cos();
            let ahead = if row % 2 == 0 { 0.0 } else { 0.5 };
            let (y, x) = (TAU * (column as f64 + ahead + moved(1)) / around as f64).sin_cos();
            let out = 1.0 + TUBE * cos;
            positions.push(DVec3::new(out * x, out * y, TUBE * sin));
        }
    }
    let mut triangles = Vec::with_capacity(around * tube * 2);
    for row in 0..tube {
        for column in 0..around {
            let site = |up: usize, on: usize| ((row + up) % tube * around + (column + on) % around) as u32;
            if row % 2 == 0 {
                triangles.extend([[site(0, 0), site(0, 1), site(1, 0)], [site(0, 1), site(1, 1), site(1, 0)]]);
            } else {
                triangles.extend([[site(0, 0), site(1, 1), site(1, 0)], [site(0, 0), site(0, 1), site(1, 1)]]);
            }
        }
    }
    round(&Polygons::new(positions, &triangles), Smooth::Torus)
}

/// Returns a pseudo-random number from −1 to 1 that depends only on `at` (SplitMix64).
fn noise(at: u64) -> f64 {
    let mut z = at.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}

/// Makes the torus with about `vertices` sites.
fn torus_of(vertices: usize, jitter: f64) -> Mesh {
    // Equal sides of length a along the center line and rows a·√3/2 apart give around/tube = (1/0.4)·(√3/2).
    let tube = (vertices as f64 * TUBE * 2.0 / 3f64.sqrt()).sqrt() / 2.0;
    let tube = (tube.round() as usize).max(2) * 2;
    torus((vertices as f64 / tube as f64).round() as usize, tube, jitter)
}

/// Makes a mesh with the normals of a smooth surface.
fn round(polygons: &Polygons, smooth: Smooth) -> Mesh {
    Mesh { smooth: Some(smooth), ..solid(polygons).with_normals(|place| smooth.normal(place)) }
}

/// The fewest bands between parallels of a sphere.
const MIN_PARALLELS: usize = 2;

/// Makes the unit sphere from bands between `parallels` − 1 parallels and the poles, cut along 12·`parallels` meridians.
fn uv_sphere(parallels: usize) -> Mesh {
    let band = |band: usize| (std::f64::consts::PI * band as f64 / parallels as f64).sin_cos();
    let bands: Vec<(f64, f64)> = (1..parallels).map(band).collect();
    round(&turned(&bands, 12 * parallels, Some(1.0)), Smooth::Sphere)
}

/// Turns a profile of (radius, z), from top to bottom, around the z axis into `sides` sides.
/// The ends of the profile are closed by poles at z = ±`pole`, if given, or left open.
fn turned(profile: &[(f64, f64)], sides: usize, pole: Option<f64>) -> Polygons {
    let place = |(radius, z): (f64, f64), side: usize| {
        let (y, x) = (TAU * side as f64 / sides as f64).sin_cos();
        DVec3::new(radius * x, radius * y, z)
    };
    let mut positions: Vec<DVec3> =
        profile.iter().flat_map(|&ring| (0..sides).map(move |side| place(ring, side))).collect();
    let site = |ring: usize, side: usize| (ring * sides + side % sides) as u32;
    let mut triangles = Vec::new();
    for ring in 1..profile.len() {
        for side in 0..sides {
            let [a, b] = [site(ring - 1, side), site(ring - 1, side + 1)];
            let [c, d] = [site(ring, side), site(ring, side + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    if let Some(pole) = pole {
        let [top, bottom] = [positions.len() as u32, positions.len() as u32 + 1];
        positions.extend([DVec3::Z * pole, DVec3::NEG_Z * pole]);
        let last = profile.len() - 1;
        for side in 0..sides {
            triangles.push([top, site(0, side), site(0, side + 1)]);
            triangles.push([bottom, site(last, side + 1), site(last, side)]);
        }
    }
    Polygons::new(positions, &triangles)
}

/// The fewest sides of a cylinder.
const MIN_SIDES: usize = 3;

/// Returns the number of parts of the rounding between the side of a cylinder and a cap.
const fn fillet_parts(sides: usize) -> usize {
    if sides < 24 { 3 } else { sides / 8 }
}

/// Returns the number of vertices of a cylinder with roundings.
const fn filleted_vertices(sides: usize) -> usize {
    2 * (fillet_parts(sides) + 1) * sides + 2
}

/// Returns the profile of a cylinder, from the edge of the top cap to the edge of the bottom cap.
fn rings(fillet: f64, parts: usize) -> Vec<(f64, f64)> {
    let upper = (0..=parts).map(|part| {
        let (sin, cos) = (TAU / 4.0 * part as f64 / parts.max(1) as f64).sin_cos();
        (1.0 - fillet + fillet * sin, HALF_HEIGHT - fillet + fillet * cos)
    });
    let upper: Vec<(f64, f64)> = upper.collect();
    let lower = upper.iter().rev().map(|&(radius, z)| (radius, -z));
    upper.iter().copied().chain(lower).collect()
}

/// Makes a cylinder with `sides` sides. Without roundings, the caps are polygons with normals of their own.
fn cylinder(sides: usize, is_filleted: bool) -> Mesh {
    let sides = sides.max(MIN_SIDES);
    if is_filleted {
        let polygons = turned(&rings(FILLET, fillet_parts(sides)), sides, Some(HALF_HEIGHT));
        return round(&polygons, Smooth::Cylinder { fillet: FILLET });
    }
    let mut polygons = turned(&rings(0.0, 0), sides, None);
    let outward = |p: &DVec3| Some(p.truncate().normalize().extend(0.0));
    polygons.normals = polygons.positions.iter().map(outward).chain([Some(DVec3::Z), Some(DVec3::NEG_Z)]).collect();
    let (sides, top, bottom) = (sides as u32, 2 * sides as u32, 2 * sides as u32 + 1);
    polygons.push((0..sides).map(|side| Corner { normal: Some(top), ..Corner::of(side) }));
    polygons.push((0..sides).rev().map(|side| Corner { normal: Some(bottom), ..Corner::of(sides + side) }));
    Mesh { smooth: Some(Smooth::Cylinder { fillet: 0.0 }), ..solid(&polygons) }
}

/// Makes hills over a square of `cells` × `cells` cells with two triangles each.
fn terrain(cells: usize) -> Mesh {
    let along = |step: usize| step as f64 / cells as f64 * 2.0 - 1.0;
    let side = cells + 1;
    let place = |i: usize| {
        let at = DVec2::new(along(i % side), along(i / side));
        at.extend(terrain_height(at).0)
    };
    let positions: Vec<DVec3> = (0..side * side).map(place).collect();
    let corners = (0..cells).flat_map(|row| (0..cells).map(move |column| (row * side + column) as u32));
    let above = side as u32;
    let triangles: Vec<[u32; 3]> =
        corners.flat_map(|a| [[a, a + 1, a + above + 1], [a, a + above + 1, a + above]]).collect();
    round(&Polygons::new(positions, &triangles), Smooth::Terrain)
}

/// Returns `count` points spread evenly over the unit sphere: the i-th point is at z = 1 − (2i + 1)/`count`, rotated
/// from the previous one by the golden angle.
pub fn fibonacci_points(count: usize) -> Vec<DVec3> {
    let golden = f64::midpoint(1.0, 5f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let (y, x) = (TAU * (i as f64 / golden).fract()).sin_cos();
            let radius = ((1.0 - z) * (1.0 + z)).sqrt();
            DVec3::new(radius * x, radius * y, z)
        })
        .collect()
}

/// Makes a closed surface over `count` (at least 4) Fibonacci points: the 2·`count` − 4 triangles of their convex hull,
/// with each point then moved in or out by a smooth function of its direction. The surface is round but not a sphere:
/// it has hollows and no symmetry.
pub fn blob(count: usize) -> Mesh {
    let points = fibonacci_points(count);
    let positions = points.iter().map(|p| *p * blob_radius(*p).0).collect();
    round(&Polygons::new(positions, &hull(&points)), Smooth::Blob)
}

/// Returns the triangles of the convex hull of n `points`, which must be at least 4 different points on the unit
/// sphere. There are 2n − 4 triangles, counterclockwise as seen from outside.
///
/// The projection from the last point onto a plane maps circles on the sphere to circles. The faces that do not touch
/// the last point are therefore the Delaunay triangulation of the other points on the plane, and each side of its
/// outline belongs to a face that does touch the last point.
pub fn hull(points: &[DVec3]) -> Vec<[u32; 3]> {
    let Some((pole, others)) = points.split_last() else { return Vec::new() };
    let (x, y) = pole.any_orthonormal_pair();
    let flat: Vec<Point> =
        others.iter().map(|p| *p / (1.0 - p.dot(*pole))).map(|p| Point { x: p.dot(x), y: p.dot(y) }).collect();
    let flat = triangulate(&flat);
    let outline = (0..flat.hull.len()).map(|i| [flat.hull[i], flat.hull[(i + 1) % flat.hull.len()], others.len()]);
    let faces = flat.triangles.as_chunks::<3>().0.iter().copied().chain(outline);
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let outward = |[a, b, c]: [usize; 3]| {
        let [p, q, r] = [a, b, c].map(|i| points[i]);
        if (q - p).cross(r - p).dot(p - middle) > 0.0 { [a, b, c] } else { [a, c, b] }
    };
    faces.map(|face| outward(face).map(|i| i as u32)).collect()
}
