//! Meshes: their shapes, normals, edges, and curvature; and OBJ files, which become one or give an error message.

use std::{f64::consts::PI, path::Path};

use glam::{DMat3, DVec3};
use machband::{
    shading::{
        Across, Mesh, Normals, Surface,
        mesh::{newell, triangulated},
        shapes::{self, Shape},
    },
    store::mesh as obj,
};
use proptest::prelude::*;

fn volume(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t)).map(|[a, b, c]| a.cross(b).dot(c) / 6.0).sum()
}

/// Returns vertices − edges + triangles, after checking that every edge has two sides that traverse it in opposite
/// directions.
fn euler_of_closed(mesh: &Mesh, has_creases: bool) -> i64 {
    for side in Surface::new(mesh.clone()).across.as_flattened() {
        // Only the cylinder is meant to have creases.
        let is_closed = matches!(side, Across::Smooth(_)) || (has_creases && matches!(side, Across::Crease(_)));
        assert!(is_closed, "{side:?}");
    }
    let mut sites: Vec<u32> = mesh.vertices.iter().map(|v| v.site).collect();
    sites.sort_unstable();
    sites.dedup();
    sites.len() as i64 - mesh.triangles.len() as i64 * 3 / 2 + mesh.triangles.len() as i64
}

#[test]
fn shapes_are_closed_and_face_outward() {
    let sizes = [(4, Shape::Blob), (5, Shape::Blob), (6, Shape::Blob), (7, Shape::Blob)]
        .into_iter()
        .chain([12, 13, 40, 313, 771, 5000].into_iter().flat_map(|n| Shape::ALL.iter().map(move |s| (n, *s))));
    for (vertices, shape) in sizes {
        let mesh = shapes::mesh(shape, vertices.max(shape.min_vertices())).unwrap();
        if shape != Shape::Terrain {
            let euler = if matches!(shape, Shape::Torus | Shape::JitteredTorus) { 0 } else { 2 };
            assert_eq!(euler_of_closed(&mesh, shape == Shape::Cylinder), euler, "{shape} {vertices}");
            assert!(volume(&mesh) > 0.1, "{shape} {vertices}: {}", volume(&mesh));
        }
        for vertex in &mesh.vertices {
            assert!((vertex.normal.length() - 1.0).abs() < 1e-12, "{shape} {vertices}");
        }
        if shape.has_vertices() && vertices >= 100 {
            let sites = mesh.vertices.iter().map(|vertex| vertex.site + 1).max().unwrap();
            let ratio = f64::from(sites) / vertices as f64;
            assert!((0.7..1.25).contains(&ratio), "{shape} {vertices}: {sites} places");
        }
    }
}

#[test]
fn hull_has_no_point_outside() {
    for count in [4, 5, 6, 7, 10, 50, 313, 771, 2000] {
        let points = shapes::fibonacci_points(count);
        let triangles = shapes::hull(&points);
        assert_eq!(triangles.len(), 2 * count - 4);
        for t in &triangles {
            let [a, b, c] = t.map(|i| points[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            for (i, p) in points.iter().enumerate() {
                assert!(normal.dot(*p - a) < 1e-13, "{count}: point {i} is outside of {t:?}");
            }
        }
    }
}

#[test]
fn shoaffs_pyramid_has_shoaffs_normal() {
    let mesh = shapes::pyramid();
    let v1 = mesh.vertices.iter().find(|v| v.position == DVec3::new(-1.0, -1.0, 1.0)).unwrap();
    assert!(v1.normal.distance(DVec3::new(-1.0, -1.0, 3.0) / 11f64.sqrt()) < 1e-15, "{}", v1.normal);
    // Its faces lie in the planes that Shoaff gives: z = 1, z = y + 2, z = x + 2.
    for (plane, distance) in [(DVec3::Z, 1.0), (DVec3::new(0.0, -1.0, 1.0), 2.0), (DVec3::new(-1.0, 0.0, 1.0), 2.0)] {
        let within = (0..12).filter(|t| mesh.corners(*t).iter().all(|p| (plane.dot(*p) - distance).abs() < 1e-12));
        assert_eq!(within.count(), 2, "{plane}");
    }
    // A vertex of the cube has the mean normal of three faces, although up to six triangles meet there.
    for vertex in shapes::cube().vertices {
        assert!(vertex.normal.distance(vertex.position / 3f64.sqrt()) < 1e-15);
    }
}

proptest! {
    /// An edge below the crease angle is smooth: its faces share both vertices there.
    #[test]
    fn creases_are_where_faces_meet_at_an_angle(crease in 0.0..60f64, points in 6usize..60) {
        let whole = shapes::mesh(Shape::Blob, points).unwrap();
        let places: Vec<DVec3> = whole.vertices.iter().map(|v| v.position).collect();
        let mesh = Mesh::new(&places, &whole.triangles, crease).unwrap();
        let (mut is_any_joined, mut is_any_smooth) = (false, false);
        for (i, side) in Surface::new(mesh.clone()).across.into_flattened().into_iter().enumerate() {
            let (Across::Smooth(other) | Across::Crease(other)) = side else { panic!("{side:?}") };
            let [a, b] = [i / 3, other as usize / 3].map(|t| newell(&mesh.corners(t)));
            let angle = a.dot(b).clamp(-1.0, 1.0).acos().to_degrees();
            let is_smooth = matches!(side, Across::Smooth(_));
            is_any_joined |= angle < crease + 0.01;
            is_any_smooth |= is_smooth;
            prop_assert!(is_smooth || angle >= crease - 0.01);
        }
        // If no faces are joined, all edges are creases.
        prop_assert!(is_any_joined || !is_any_smooth);
    }

    /// For any simple polygon, the triangles have the polygon's area, none is flipped, and every edge of the polygon is
    /// an edge of a triangle.
    #[test]
    fn polygons_become_triangles(radii in prop::collection::vec(0.1..1f64, 3..40), tilt in 0.0..6f64) {
        let count = radii.len();
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, tilt, tilt * 1.7, 0.3);
        let corners: Vec<DVec3> = radii
            .iter()
            .enumerate()
            .map(|(i, r)| {
                let (y, x) = (2.0 * PI * i as f64 / count as f64).sin_cos();
                turn * DVec3::new(x, y, 0.0) * *r + 5.0
            })
            .collect();
        let normal = turn * DVec3::Z;
        let triangles = triangulated(&corners);
        prop_assert_eq!(triangles.len(), count - 2);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| corners[i as usize]);
            (b - a).cross(c - a).dot(normal) / 2.0
        };
        let true_area: f64 =
            (0..count).map(|i| radii[i] * radii[(i + 1) % count] * (2.0 * PI / count as f64).sin() / 2.0).sum();
        prop_assert!(triangles.iter().all(|t| area(t) > -1e-12));
        prop_assert!((triangles.iter().map(area).sum::<f64>() - true_area).abs() < 1e-9);
        for i in 0..count as u32 {
            let next = (i + 1) % count as u32;
            prop_assert!(triangles.iter().any(|t| (0..3).any(|k| t[k] == i && t[(k + 1) % 3] == next)));
        }
    }

    /// For any polygon, there are two fewer triangles than corners, and they use only the polygon's corners.
    #[test]
    fn degenerate_polygons_become_triangles(corners in prop::collection::vec((0..4i32, 0..4i32, 0..2i32), 0..12)) {
        let corners: Vec<DVec3> = corners.iter().map(|(x, y, z)| DVec3::from([*x, *y, *z].map(f64::from))).collect();
        let triangles = triangulated(&corners);
        prop_assert_eq!(triangles.len(), corners.len().saturating_sub(2));
        prop_assert!(triangles.iter().flatten().all(|i| (*i as usize) < corners.len()));
    }
}

/// Returns the largest difference between the curvature of the vertices and the true curvature, relative to the largest
/// true curvature.
fn curvature_error(mesh: &Mesh, truth: impl Fn(DVec3) -> DMat3) -> f64 {
    let surface = Surface::new(mesh.clone());
    let norm = |m: DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut worst = [0f64; 2];
    for (vertex, rows) in mesh.vertices.iter().zip(&surface.fans.curvature) {
        let curvature = DMat3::from_cols_array_2d(rows);
        assert!(norm(curvature - curvature.transpose()) < 1e-12 * norm(curvature));
        assert!((curvature * vertex.normal).length() < 1e-12 * norm(curvature));
        let truth = truth(vertex.position);
        worst = [worst[0].max(norm(curvature - truth)), worst[1].max(norm(truth))];
    }
    worst[0] / worst[1]
}

fn outer(a: DVec3) -> DMat3 {
    DMat3::from_cols(a * a.x, a * a.y, a * a.z)
}

#[test]
fn curvature_converges_on_uneven_triangles_with_true_normals() {
    // An ellipsoid over Fibonacci points, on which no two triangles are alike. N = ∇F/|∇F|, dN/dp =
    // P·diag(1/a²)·P/|∇F|.
    let axes = DVec3::new(1.0, 0.7, 1.4);
    let gradient = |p: DVec3| p / (axes * axes);
    let error = |count: usize| {
        let points = shapes::fibonacci_points(count);
        let places: Vec<DVec3> = points.iter().map(|p| *p * axes).collect();
        let mesh = Mesh::new(&places, &shapes::hull(&points), 180.0).unwrap();
        curvature_error(&mesh.clone().with_normals(gradient), |p| {
            let flat = DMat3::IDENTITY - outer(gradient(p).normalize());
            flat * DMat3::from_diagonal(1.0 / (axes * axes)) * flat * (1.0 / gradient(p).length())
        })
    };
    let [coarse, middle, fine] = [500, 2000, 8000].map(error);
    assert!(fine < 0.02, "{fine}");
    assert!(coarse / middle > 1.7 && middle / fine > 1.7, "not of first order: {coarse} {middle} {fine}");
}

proptest! {
    /// For any triangles, the curvature is finite and the normals have unit length.
    #[test]
    fn curvature_and_normals_are_always_finite(
        places in prop::collection::vec((-2..3i32, -2..3i32, -1..2i32), 3..12),
        corners in prop::collection::vec((0..12u32, 0..12u32, 0..12u32), 1..20),
        power in -28..30i32,
        crease in prop_oneof![Just(180.0), 0.0..180f64],
    ) {
        let unit = 10f64.powi(power);
        let places: Vec<DVec3> = places.iter().map(|(x, y, z)| DVec3::from([*x, *y, *z].map(f64::from)) * unit).collect();
        let count = places.len() as u32;
        let triangles: Vec<[u32; 3]> = corners.iter().map(|(a, b, c)| [a % count, b % count, c % count]).collect();
        match Mesh::new(&places, &triangles, crease) {
            Err(error) => prop_assert!(error.contains("; expected"), "{}", error),
            Ok(mesh) => {
                prop_assert!(mesh.vertices.iter().all(|v| (v.normal.length() - 1.0).abs() < 1e-12));
                let surface = Surface::new(mesh);
                prop_assert!(surface.fans.curvature.as_flattened().as_flattened().iter().all(|x| x.is_finite()));
                prop_assert_eq!(surface.mesh.triangles.len(), triangles.len());
            }
        }
    }
}

fn mesh(text: &str) -> Mesh {
    obj::parse("it.obj", text.as_bytes(), 180.0).unwrap_or_else(|errors| panic!("{errors}\n{text}")).mesh
}

fn message(content: impl AsRef<[u8]>) -> String {
    obj::parse("it.obj", content.as_ref(), 180.0).expect_err("a fault").to_string()
}

/// A cube of quads as a program would write it, including everything that is ignored.
const CUBE: &str = "\
# A cube, écrit à la main
mtllib cube.mtl
o cube
v -1 -1 -1
v  1 -1 -1 1.0 0.5 0.0
v -1  1 -1
v  1  1 -1 # far
v -1 -1  1 2
v  1 -1  1
v -1 +1  1e0
v  1  1  1.
vt 0 0
vt 1 1
g sides
usemtl red
s off
f 1/1 3/2 4/1 2/1
f 5/1/ 6 8 7
g others
f -8 -7 -3 -4
f 3 7 8 4
usemtl blue
f 1 5 7 3
f 2 4 8 6
l 1 2 3 4
p 1
";

#[test]
fn cube_of_quads_is_the_cube() {
    // A comment does not continue in the next line.
    let continued =
        CUBE.replace("3 7 8", "3 7 \\\n8").replace("cube.mtl\n", "cube.mtl \\\n").replace("main\n", "main \\\n");
    let returned = CUBE.replace('\n', "\r");
    for text in [CUBE.replace('\n', "\r\n"), returned, format!("\u{feff}{CUBE}"), continued] {
        assert_eq!(mesh(&text), mesh(CUBE));
    }
    let (read, cube) = (mesh(CUBE), shapes::cube());
    assert_eq!((read.vertices.len(), read.triangles.len()), (8, 12));
    let sorted = |mesh: &Mesh| {
        let mut all: Vec<_> = (0..12)
            .map(|t| {
                // Start at the lowest corner.
                let mut corners = mesh.triangles[t]
                    .map(|v| mesh.vertices[v as usize])
                    .map(|v| format!("{} {:.12}", v.position, v.normal));
                let lowest = (0..3).min_by_key(|k| corners[*k].clone()).unwrap();
                corners.rotate_left(lowest);
                corners.join(" ")
            })
            .collect();
        all.sort();
        all
    };
    assert_eq!(sorted(&read), sorted(&cube));
    // With a crease angle below 90°, all edges of the cube are sharp.
    let sharp = obj::parse("it.obj", CUBE.as_bytes(), 60.0).unwrap().mesh;
    assert_eq!(sharp.vertices.len(), 24);
    let across = Surface::new(sharp).across.into_flattened();
    // Each of the twelve edges and of the six diagonals has two sides.
    assert_eq!(across.iter().filter(|side| matches!(side, Across::Crease(_))).count(), 24);
    assert_eq!(across.iter().filter(|side| matches!(side, Across::Smooth(_))).count(), 12);
}

#[test]
fn normals_from_the_file_take_precedence() {
    let roof = "v 0 0 0\nv 1 0 -1\nv 0 1 0\nv -1 0 -1\n";
    // A missing normal, a zero normal, and a normal that is not a number are replaced by averages. A normal of any
    // other length is normalized.
    let text = format!("{roof}vn 0 0 0\nvn nan 0 0\nvn 3 0 4\nf 1//3 2 3//1\nf 1//3 3//2 4\n");
    let mesh = mesh(&text);
    let normal = |t: usize, k: usize| mesh.vertices[mesh.triangles[t][k] as usize].normal;
    assert!(normal(0, 0).distance(DVec3::new(0.6, 0.0, 0.8)) < 1e-15);
    assert!(normal(0, 2).distance(DVec3::Z) < 1e-15);
    assert!(normal(0, 1).distance(newell(&mesh.corners(0))) < 1e-15);
    assert_eq!(mesh.vertices.len(), 4);
    // Normals that a program rounded differently are merged; different normals stay separate.
    for (z, count) in [("1.0001", 4), ("1.1", 6)] {
        let text = format!("{roof}vn 1 0 1\nvn 1 0 {z}\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n");
        assert_eq!(self::mesh(&text).vertices.len(), count, "{z}");
    }
}

#[test]
fn errors_are_reported_with_their_position() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, expected) in [
        ("", "it.obj: is empty; expected an OBJ, PLY, glTF or GLB file"),
        ("v 0 0 0\n v 1 NaN 0\n", "it.obj:2:6: \"NaN\" is not finite or is beyond ±1e30; expected a finite coordinate"),
        ("v 1,5 0 1", "it.obj:1:3: \"1,5\" is not a number; expected one"),
        ("v 1 2", "it.obj:1:1: the line has too few numbers (2); expected three"),
        ("v 0 0 0\nf 1 1", "it.obj:2:1: the number of corners is 2; expected 3…1024"),
        ("v 0 0 0\nf 1 1 1", "it.obj: has no face with a nonzero area; expected at least one"),
        ("v 0 0 0\nf 1 1 0", "it.obj:2:7: vertex 0 does not exist; expected an index from 1, or -1 for the last one"),
        (
            "v 0 0 0\nf 1 1 -2",
            "it.obj:2:7: vertex -2 does not exist (1 so far); expected -1 for the last one, or an index from 1",
        ),
        ("v 0 0 0\nf 1 1 2", "it.obj:2:7: vertex 2 does not exist; expected 1…1"),
        ("v 0 0 0\nvn 0 0 1\nf 1//2 1 1", "it.obj:3:3: normal 2 does not exist; expected 1…1"),
        ("v 0 0 0\nf 1//a 1 1", "it.obj:2:3: \"1//a\" is not a corner of a face; expected 1, 1/1, 1//1 or 1/1/1"),
        ("v 0 0 0\nf 1 1 1.5", "it.obj:2:7: \"1.5\" is not a corner of a face; expected 1, 1/1, 1//1 or 1/1/1"),
    ] {
        assert_eq!(message(text), expected, "{text}");
    }
    // A face that comes before its vertices and before another error.
    assert_eq!(message("f 1 2 3\nv 0 0 0\nv 0 0 x\n"), "it.obj:1:7: vertex 3 does not exist; expected 1…2");
    assert!(obj::parse("it.obj", format!("f 1 2 3\n{triangle}").as_bytes(), 180.0).is_ok());
    assert!(message(format!("v {} 0 0\n", "x".repeat(100_000))).len() < 200);
}

#[test]
fn files_of_other_kinds_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let error = |path: &Path| obj::read(path, 180.0, Normals::Given).expect_err("a fault").to_string();
    let missing = folder.path().join("missing.obj");
    assert!(error(&missing).contains("missing.obj: cannot be opened: "), "{}", error(&missing));
    assert!(error(folder.path()).ends_with("is a folder; expected an OBJ, PLY, glTF or GLB file"));
    assert_eq!(message(b"\n"), "it.obj: is empty; expected an OBJ, PLY, glTF or GLB file");
    let picture = folder.path().join("picture.obj");
    std::fs::write(&picture, b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR").unwrap();
    assert!(error(&picture).ends_with("picture.obj:3:1: is not text; expected an OBJ file"), "{}", error(&picture));
    assert_eq!(message(b"v 0 0 0\nv 1 \xff 2\n"), "it.obj:2:5: is not UTF-8 text; expected numbers");
    assert!(obj::parse("it.txt", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 180.0).is_ok());
    // Names and comments in another encoding do no harm.
    let latin = b"# \xe9crit\no \xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    assert_eq!(obj::parse("it.obj", latin, 180.0).unwrap().mesh.triangles.len(), 1);
}
