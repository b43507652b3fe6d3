//! OBJ files: a valid file becomes a mesh; any other file gives an error message.

use std::{fmt::Write as _, path::Path};

use glam::DVec3;
use machband::{
    shading::{EdgeKind, Edges, Mesh, Normals, mesh::newell, shapes},
    store::mesh as obj,
};

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
    // A comment does not go on in the next line.
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
    let edges = Edges::of(&sharp).edges;
    assert_eq!(edges.iter().filter(|e| e.kind == EdgeKind::Crease).count(), 12);
    assert_eq!(edges.iter().filter(|e| e.kind == EdgeKind::Smooth).count(), 6);
}

/// Without normals in the file, they are estimated.
#[test]
fn written_meshes_are_read_back_exactly() {
    let blob = shapes::blob(313);
    let places: Vec<DVec3> = blob.vertices.iter().map(|v| v.position).collect();
    let mut text: String = places.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
    for [a, b, c] in blob.triangles.iter().map(|t| t.map(|v| v + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    let (read, estimated) = (mesh(&text), Mesh::new(&places, &blob.triangles, 180.0).unwrap().estimated(Normals::Best));
    let corners = |m: &Mesh| m.triangles.iter().flatten().map(|v| m.vertices[*v as usize]).collect::<Vec<_>>();
    assert_eq!((read.vertices.len(), read.triangles.len()), (estimated.vertices.len(), estimated.triangles.len()));
    for (own, expected) in corners(&read).iter().zip(corners(&estimated)) {
        assert!(own.position == expected.position && own.normal.distance(expected.normal) < 1e-12, "{own:?}");
    }
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
    assert_eq!(
        message("f 1 2 3\nv 0 0 0\nv 0 0 x\n"),
        "it.obj:1:7: vertex 3 does not exist; expected 1…2\nit.obj:3:7: \"x\" is not a number; expected one"
    );
    assert!(obj::parse("it.obj", format!("f 1 2 3\n{triangle}").as_bytes(), 180.0).is_ok());
    // Several errors are listed in the order of the file, up to a limit.
    assert_eq!(message("v a 0 0\nv 0 b 0\nf 1 2\n").lines().count(), 3);
    assert_eq!(message("v a 0 0\n".repeat(1000)).lines().count(), 20);
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
