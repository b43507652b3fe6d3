//! PLY, glTF and GLB files, winding, and what paint does to a picture.

use base64::{Engine as _, prelude::BASE64_STANDARD};
use glam::{DVec2, DVec3};
use machband::{
    light::Transfer,
    shading::{Across, Creases, Frame, Normals, Scene, Shade, Shader, Surface, Texture, Wrap, coverage, image},
    store::mesh::{self, MeshFile},
};
use serde_json::{Value, json};

/// Two triangles over the square −1…1, in the plane z = 0.
const PLACES: [[f32; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
const INDICES: [u16; 6] = [0, 1, 2, 0, 2, 3];

/// A texture of two by two texels: red, green; blue, white.
fn png(codes: &[[u8; 3]; 4]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(codes.as_flattened()).unwrap();
    bytes
}

/// Makes a GLB of the square with a normal, a place and a color at each corner. `edit` may change the JSON.
fn glb(edit: impl FnOnce(&mut Value)) -> Vec<u8> {
    let mut bin: Vec<u8> = PLACES.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bin.extend((0..4).flat_map(|_| [0.0_f32, 0.0, 1.0]).flat_map(f32::to_le_bytes));
    bin.extend([[0.0_f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].iter().flatten().flat_map(|x| x.to_le_bytes()));
    bin.extend(
        [[255_u8, 255, 255, 255], [255, 255, 255, 255], [51, 255, 255, 255], [255, 255, 255, 255]].as_flattened(),
    );
    bin.extend(INDICES.iter().flat_map(|i| i.to_le_bytes()));
    let image = png(&[[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]]);
    bin.extend(&image);
    let mut json = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3 }, "indices": 4, "material": 0,
        }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "baseColorFactor": [1, 1, 0.5, 1] } }],
        "textures": [{ "source": 0 }],
        "images": [{ "bufferView": 5, "mimeType": "image/png" }],
        "buffers": [{ "byteLength": bin.len() }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 32 },
            { "buffer": 0, "byteOffset": 128, "byteLength": 16 },
            { "buffer": 0, "byteOffset": 144, "byteLength": 12 },
            { "buffer": 0, "byteOffset": 156, "byteLength": image.len() },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 3, "componentType": 5121, "count": 4, "type": "VEC4", "normalized": true },
            { "bufferView": 4, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
    });
    edit(&mut json);
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut glb = Vec::from(*b"glTF");
    for word in [2, 28 + text.len() + bin.len(), text.len()] {
        glb.extend((word as u32).to_le_bytes());
    }
    glb.extend(b"JSON");
    glb.extend(text);
    glb.extend((bin.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bin);
    glb
}

fn parsed(content: &[u8]) -> MeshFile {
    mesh::parse("it", content, 180.0).unwrap_or_else(|errors| panic!("{errors}"))
}

fn message(content: &[u8]) -> String {
    mesh::parse("it", content, 180.0).expect_err("a fault").to_string()
}

/// The square faces the eye, so its light is the same everywhere but for the paint.
#[test]
fn a_glb_file_shows_its_colors_and_textures() {
    // Attributes that belong to an application are ignored.
    let mesh = parsed(&glb(|json| json["meshes"][0]["primitives"][0]["attributes"]["_ID"] = json!(4))).mesh;
    assert_eq!((mesh.triangles.len(), mesh.vertices.len()), (2, 4));
    let scene = Scene { rotate_deg: [0.0; 3], specular: 0.0, ambient: 1.0, diffuse: 0.0, ..Scene::default() };
    let frame = scene.frame(&Surface::new(mesh), 101, 101);
    let image = image(&frame, &Shade::new(Shader::Phong));
    let half = 50.0 - 0.9 * 101.0 / 2.0 / 2.0_f64.sqrt() / 2.0;
    let center_of = |x: f64, y: f64| {
        let pixel = image.pixel(x.round() as u32, y.round() as u32);
        DVec3::from_array(pixel.map(f64::from))
    };
    // The middles of the four texels, times the blue factor of the material; the red of the corner at the top right, 0.2,
    // counts a quarter here.
    let far = 100.0 - half;
    for (x, y, texel) in [
        (half, half, DVec3::new(1.0, 0.0, 0.0)),
        (half, far, DVec3::new(0.0, 0.0, 1.0)),
        (far, far, DVec3::new(1.0, 1.0, 1.0)),
    ] {
        assert!(center_of(x, y).distance(texel * DVec3::new(0.8, 1.0, 0.5)) < 0.06, "{x} {y}: {}", center_of(x, y));
    }
    let corner = center_of(far, half);
    assert!(corner.distance(DVec3::new(0.0, 1.0, 0.0)) < 0.06, "{corner}");
    // White light times white paint is as bright as without paint; no shader's creases count the edges of a texture.
    assert!(Creases::of(&frame.clone().unpainted(), &Shade::new(Shader::Gouraud)).rms < 1e-12);
}

/// A JPEG image of 8 × 8 pixels with the code (200, 100, 50).
const JPEG: &str = "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAUDBAQEAwUEBAQFBQUGBwwIBwcHBw8LCwkMEQ8SEhEPERETFhwXExQaFRERGCEYGh0d\
    Hx8fExciJCIeJBweHx7/2wBDAQUFBQcGBw4ICA4eFBEUHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4e\
    Hh4eHh4eHh7/wAARCAAIAAgDAREAAhEBAxEB/8QAFAABAAAAAAAAAAAAAAAAAAAAA//EABQQAQAAAAAAAAAAAAAAAAAAAAD/xAAU\
    AQEAAAAAAAAAAAAAAAAAAAAH/8QAFBEBAAAAAAAAAAAAAAAAAAAAAP/aAAwDAQACEQMRAD8AEeFZ/9k=";

#[test]
fn textures_may_be_jpeg_images() {
    let content = glb(|json| json["images"] = json!([{ "uri": format!("data:image/jpeg;base64,{JPEG}") }]));
    let paint = parsed(&content).mesh.paint.unwrap();
    let color = paint.coats[0].as_ref().unwrap().at(DVec2::splat(0.3));
    let expected = [200.0, 100.0, 50.0].map(|code| Transfer::Srgb.linear_from_encoded(code / 255.0));
    assert!(color.distance(DVec3::from_array(expected)) < 0.02, "{color}");
    // A file beside the mesh, whose name is written as a URI.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ü b.jpg"), BASE64_STANDARD.decode(JPEG).unwrap()).unwrap();
    let path = folder.path().join("it.glb");
    std::fs::write(&path, glb(|json| json["images"] = json!([{ "uri": "./%C3%BC%20b.jpg" }]))).unwrap();
    let beside = mesh::read(&path, 180.0, Normals::Given).unwrap().mesh.paint.unwrap();
    assert_eq!(beside.coats, paint.coats);
}

/// A node may place, scale and mirror its mesh.
#[test]
fn nodes_of_a_glb_file_are_placed() {
    let nodes = json!([{ "children": [1], "translation": [0, 0, 5] }, { "mesh": 0, "scale": [-2, 1, 1] }]);
    let mesh = parsed(&glb(|json| json["nodes"] = nodes.clone())).mesh;
    // Without scenes, the roots are the nodes that are nobody's children.
    let rootless = glb(|json| {
        json["nodes"] = nodes;
        json.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
    });
    assert_eq!(parsed(&rootless).mesh, mesh);
    assert!(mesh.vertices.iter().all(|v| v.position.z == 5.0 && v.position.x.abs() == 2.0 && v.normal == DVec3::Z));
    for t in 0..2 {
        let [a, b, c] = mesh.corners(t);
        assert!((b - a).cross(c - a).z > 0.0, "a mirrored face still goes around counterclockwise");
    }
}

#[test]
fn errors_of_glb_files_say_what_is_expected() {
    let set = |path: &'static str, value: Value| glb(move |json| *json.pointer_mut(path).unwrap() = value);
    for (content, words) in [
        (set("/accessors/0/count", json!(40_000)), "its positions (accessor 0) reach beyond their buffer view"),
        (
            glb(|json| {
                let indices = json!({ "bufferView": 4, "componentType": 5123 });
                json["accessors"][0]["sparse"] =
                    json!({ "count": 1, "indices": indices, "values": { "bufferView": 0 } });
            }),
            "its positions (accessor 0) are sparse, compressed or missing; expected them in a buffer view",
        ),
        (set("/asset/version", json!("3.0")), "is glTF 3.0; expected glTF 2.0"),
        (glb(|_| {})[..700].to_vec(), "ends after 700 bytes; expected 1"),
        (
            set("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": 0 }, "mode": 1 })),
            "expected at least one primitive with triangles",
        ),
        (set("/nodes/0", json!({ "mesh": 0, "children": [0] })), "node 0 has two parents; expected a tree"),
        (
            set("/buffers/0", json!({ "byteLength": 4, "uri": "../secret.bin" })),
            "expected a file in the same folder or below",
        ),
        (b"glTF\x02\0\0\0\x03\0\0\0".to_vec(), "its header is damaged; expected a GLB file"),
        (b"{}".to_vec(), "expected a glTF 2.0 file"),
        (
            set("/images/0", json!({ "uri": "data:image/webp;base64,UklGRg==" })),
            "image 0 is neither a PNG nor a JPEG image; expected one of them",
        ),
    ] {
        let message = message(&content);
        assert!(message.starts_with("it: ") && message.contains(words), "{words}: {message}");
    }
}

/// No change of single bytes makes the readers panic.
#[test]
fn damaged_files_are_errors() {
    let check = |content: &[u8]| match mesh::parse("it", content, 180.0) {
        Ok(MeshFile { mesh, .. }) => {
            let count = mesh.vertices.len() as u32;
            assert!(mesh.triangles.iter().flatten().all(|v| *v < count));
        }
        Err(errors) => assert!(errors.to_string().contains("; expected"), "{errors}"),
    };
    for whole in [glb(|_| {}), ply("ascii"), ply("binary_little_endian"), ply("binary_big_endian")] {
        for at in 0..whole.len() {
            for byte in [0, b'9', 0xff, whole[at].wrapping_add(1)] {
                let mut damaged = whole.clone();
                damaged[at] = byte;
                check(&damaged);
            }
            check(&whole[..at]);
        }
    }
}

/// The square with colored vertices as a face of four corners.
fn ply(format: &str) -> Vec<u8> {
    let mut ply = format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\nproperty \
         float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int \
         vertex_indices\nend_header\n"
    )
    .into_bytes();
    for (i, place) in PLACES.iter().enumerate() {
        let color = [if i == 2 { 0 } else { 255 }, 255, 255];
        if format == "ascii" {
            ply.extend(format!("{} {} {} {} 255 255\n", place[0], place[1], place[2], color[0]).bytes());
        } else {
            let big = format == "binary_big_endian";
            ply.extend(place.iter().flat_map(|x| if big { x.to_be_bytes() } else { x.to_le_bytes() }));
            ply.extend(color);
        }
    }
    if format == "ascii" {
        ply.extend(b"4 0 1 2 3\n");
    } else {
        let big = format == "binary_big_endian";
        ply.push(4);
        ply.extend((0..4_i32).flat_map(|i| if big { i.to_be_bytes() } else { i.to_le_bytes() }));
    }
    ply
}

#[test]
fn every_kind_of_ply_file_gives_the_same_mesh() {
    let [text, little, big] = ["ascii", "binary_little_endian", "binary_big_endian"].map(|format| parsed(&ply(format)));
    assert!(text == little && text == big);
    assert_eq!((text.mesh.triangles.len(), text.mesh.vertices.len()), (2, 4));
    let paint = text.mesh.paint.unwrap();
    let cyan = paint.corners.iter().flatten().filter(|corner| corner.color == DVec3::new(0.0, 1.0, 1.0)).count();
    let white = paint.corners.iter().flatten().filter(|corner| corner.color == DVec3::ONE).count();
    assert_eq!((cyan, white), (2, 4));

    let ascii = String::from_utf8(ply("ascii")).unwrap();
    assert_eq!(parsed(ascii.replace('\n', "\r").as_bytes()), parsed(ascii.as_bytes()));
    for (from, to, words) in [
        ("4 0 1 2 3", "4 0 1 2 9", "face 0 refers to vertex 9, which does not exist; expected 0…3"),
        ("4 0 1 2 3\n", "", "it: ends within face 0 of 1; expected as many as its header says"),
        ("4 0 1 2 3", "2 0 1", "face 0 has 2 corners; expected 3…1024"),
        ("4 0 1 2 3", "4 0 1 2.5 3", "it:18:1: vertex_indices is \"2.5\"; expected a whole number"),
        ("-1 -1 0", "-1 one 0", "it:14:1: y is \"one\"; expected a number"),
        (" 255 255\n", " 255 256\n", "it:14:1: blue is 256; expected 0…255"),
        ("property uchar red", "property int red", "it:8:1: red has another type; expected uchar, ushort or float"),
    ] {
        let message = message(ascii.replace(from, to).as_bytes());
        assert!(message.contains(words) && message.contains("; expected"), "{words}: {message}");
    }
    // Some programs write codes as real numbers, and the format lets faces come first.
    let codes = parsed(ascii.replace("property uchar", "property float").as_bytes());
    assert_eq!(codes.notes, ["colors above 1 are taken as codes of 8 bits"]);
    assert_eq!(codes.mesh, parsed(ascii.as_bytes()).mesh);
    let (vertices, faces) =
        ("element vertex 1\nproperty float x\n", "element face 1\nproperty list uchar int vertex_index\n");
    let first = format!("ply\nformat ascii 1.0\n{faces}{vertices}end_header\n3 0 1 2\n0\n");
    assert_eq!(message(first.as_bytes()), "it: face 0 comes before the vertices; expected them first");
    let binary = ply("binary_big_endian");
    let ended = message(&binary[..binary.len() - 3]);
    assert_eq!(ended, "it: ends within face 0 of 1; expected as many as its header says");
    // Properties of other elements do not count, whatever their names.
    let other = "element material 1\nproperty list uchar short b\nproperty int red\nelement vertex 4";
    let with_other = ascii.replace("element vertex 4", other).replace("end_header\n", "end_header\n2 7 8 9\n");
    assert_eq!(parsed(with_other.as_bytes()), parsed(ascii.as_bytes()));
    // Rhino ends the lines of a header with a return alone.
    let start = binary.windows(11).position(|at| at == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8_lossy(&binary[..start]).replace('\n', "\r").replace(' ', " \t");
    assert_eq!(parsed(&[header.as_bytes(), &binary[start..]].concat()), big);
    // Numbers as C reads and writes them, between tabs and spaces.
    let as_written = ascii.replace("-1 -1 0", " -1.\t-.1e1  +.0").replace("4 0 1", "4\t0 1");
    assert_eq!(parsed(as_written.as_bytes()), parsed(ascii.as_bytes()));
}

/// Faces that go around the other way are reversed, whichever they are; a Möbius strip stays as it is.
#[test]
fn mixed_winding_is_repaired() {
    let mut whole = None;
    for reversed in [vec![], vec![3], vec![0, 5], vec![1, 2, 4], vec![0, 2, 3, 5], (0..6).collect()] {
        let mut obj = String::new();
        for [x, y, z] in [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]] {
            obj += &format!("v {x} {y} {z}\n");
        }
        let faces = [[1, 4, 3, 2], [5, 6, 7, 8], [1, 2, 6, 5], [2, 3, 7, 6], [3, 4, 8, 7], [4, 1, 5, 8]];
        for (i, mut face) in faces.into_iter().enumerate() {
            if reversed.contains(&i) {
                face.reverse();
            }
            obj += &format!("f {} {} {} {}\n", face[0], face[1], face[2], face[3]);
        }
        let found = parsed(obj.as_bytes());
        let note = match reversed.len() {
            0 => String::new(),
            1 => "reversed 1 face, because the neighbors go around the other way".to_owned(),
            6 => "reversed 6 faces, because the surface was inside out".to_owned(),
            count => format!("reversed {count} faces, because the neighbors go around the other way"),
        };
        assert_eq!(found.notes.concat(), note);
        let volume: f64 = (0..12).map(|t| found.mesh.corners(t)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
        assert!((volume - 1.0).abs() < 1e-12, "{reversed:?}: {volume}");
        whole.get_or_insert(found.mesh.vertices.len());
        assert_eq!(whole, Some(found.mesh.vertices.len()));
    }
}

/// Textures wrap as the file says, and what is ignored is named.
#[test]
fn textures_of_glb_files_wrap_and_what_is_ignored_is_named() {
    let file = parsed(&glb(|json| {
        json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }, { "POSITION": 0 }]);
        json["meshes"][0]["weights"] = json!([0.5, 0.0]);
        json["nodes"] = json!([{ "mesh": 0, "skin": 0 }, {}]);
        json["skins"] = json!([{ "joints": [1] }]);
        json["animations"] = json!([{ "channels": [], "samplers": [] }]);
        json["materials"][0]["alphaMode"] = json!("BLEND");
        json["materials"][0]["normalTexture"] = json!({ "index": 0 });
        json["extensionsUsed"] = json!(["EXT_b", "EXT_a", "EXT_b"]);
        json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33648 }]);
        json["textures"][0]["sampler"] = json!(0);
    }));
    assert_eq!(
        file.notes,
        [
            "animations were ignored",
            "morph targets were ignored",
            "normal maps were ignored",
            "skins were ignored",
            "transparency was ignored",
            "extensions were ignored: EXT_a, EXT_b"
        ]
    );
    let base = file.mesh.paint.as_ref().unwrap().coats[0].clone().unwrap();
    assert_eq!(base.wrap, [Wrap::ClampToEdge, Wrap::MirroredRepeat]);
    let texture = |wrap| Texture { width: 2, height: 1, texels: vec![[0.0; 3], [1.0; 3]], wrap: [wrap; 2] };
    for (wrap, wanted) in [
        (Wrap::Repeat, [0.0, 1.0, 0.5, 0.0, 1.0]),
        (Wrap::MirroredRepeat, [0.0, 1.0, 1.0, 1.0, 0.0]),
        (Wrap::ClampToEdge, [0.0, 1.0, 1.0, 1.0, 0.0]),
    ] {
        let found = [0.25, 0.75, 1.0, 5.25, -0.25].map(|x| texture(wrap).at(DVec2::new(x, 0.5)).x);
        assert_eq!(found, wanted, "{wrap:?}");
    }
}

/// At each pixel, the paint and Phong's normal are those of the point of the triangle that the line of sight meets.
#[test]
fn paint_and_normals_follow_perspective() {
    let mesh = parsed(&glb(|json| {
        json["materials"] = json!([{}]);
    }));
    let scene = Scene {
        rotate_deg: [50.0, 20.0, 0.0],
        distance: 1.5,
        ambient: 1.0,
        diffuse: 0.0,
        specular: 0.0,
        ..Scene::default()
    };
    let frame: Frame = scene.frame(&Surface::new(mesh.mesh), 120, 120);
    let mut lit = Frame { paint: None, lighting: Scene::default().lighting(), ..frame.clone() };
    lit.vertices.iter_mut().for_each(|vertex| vertex.normal = (DVec3::Z + 0.7 * vertex.eye).normalize());
    let phong = image(&lit, &Shade::new(Shader::Phong));
    let (image, visible) = (image(&frame, &Shade::new(Shader::Gouraud)), coverage::visible(&frame));
    let mut seen = 0;
    for (i, t) in visible.iter().enumerate().filter(|(_, t)| **t != coverage::NONE) {
        let center = DVec2::new((i % 120) as f64 + 0.5, (i / 120) as f64 + 0.5);
        let (from, along) = frame.view.ray(center);
        let [a, b, c] = frame.corners(*t as usize).map(|v| v.eye);
        let normal = (b - a).cross(c - a);
        let point = from + along * ((a - from).dot(normal) / along.dot(normal));
        // Red is 0.2 at the corner at the top right and 1 at the others.
        let corners = frame.paint.as_ref().unwrap().corners[frame.triangles[*t as usize].of_mesh as usize];
        let area = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal) / normal.length_squared();
        let weights = [area(point, b, c), area(point, c, a), area(point, a, b)];
        let red: f64 = corners.iter().zip(weights).map(|(corner, w)| corner.color.x * w).sum();
        let shown = f64::from(image.pixel((i % 120) as u32, (i / 120) as u32)[0]);
        assert!((shown - red).abs() < 5e-3, "{center}: {shown}, not {red}");
        let normal: DVec3 = lit.corners(*t as usize).iter().zip(weights).map(|(corner, w)| corner.normal * w).sum();
        let (shown, light) = (phong.pixel((i % 120) as u32, (i / 120) as u32)[0], lit.lit(point, normal.normalize()).x);
        assert!((f64::from(shown) - light).abs() < 5e-3, "{center}: {shown}, not {light}");
        seen += 1;
    }
    assert!(seen > 2000);
}

/// A strip of four cells around a cylinder whose seam is given twice, with this gap.
fn with_seam(gap: f64) -> String {
    let mut obj = String::new();
    for i in 0..=8 {
        let (sin, cos) = (f64::from(i % 8) * std::f64::consts::TAU / 8.0).sin_cos();
        let gap = if i == 8 { gap } else { 0.0 };
        obj += &format!("v {} {} 0\nv {} {} 1\n", cos + gap, sin, cos + gap, sin);
    }
    for i in 0..8 {
        let a = 2 * i + 1;
        obj += &format!("f {} {} {} {}\n", a, a + 2, a + 3, a + 1);
    }
    obj
}

/// Vertices on both sides of a seam are joined if they differ by no more than a thousandth of an edge, whatever the size
/// of the mesh; a wider seam stays.
#[test]
fn narrow_seams_are_joined() {
    for (gap, joined, told) in [
        (0.0, true, ""),
        (1e-7, true, "joined vertices within a thousandth of an edge at 2 places"),
        (7e-4, true, "joined vertices within a thousandth of an edge at 2 places"),
        (0.01, false, ""),
    ] {
        let found = parsed(with_seam(gap).as_bytes());
        let across = Surface::new(found.mesh).across;
        let smooth = across.as_flattened().iter().filter(|side| matches!(side, Across::Smooth(_))).count() / 2;
        // Each of the eight quads has a diagonal, and there are eight edges between them.
        assert_eq!(smooth, 15 + usize::from(joined), "{gap}");
        let notes = found.notes.join("; ");
        assert!(notes.is_empty() == told.is_empty() && notes.contains(told), "{gap}: {notes}");
    }
}

/// A sphere whose vertices at a pole differ by rounding alone, as sin 180° is not quite 0, is the sphere with one vertex
/// at each pole.
#[test]
fn edges_without_a_length_have_one_vertex() {
    let [exact, rounded] = [0.0, 1.2e-16].map(|rounding| {
        let (mut obj, count) = (String::new(), 12);
        for (row, column) in (0..7 * count).map(|i| (i / count, i % count)) {
            let (sin, cos) = (f64::from(column) * std::f64::consts::TAU / f64::from(count)).sin_cos();
            let (across, up) = (f64::from(row) * std::f64::consts::PI / 6.0).sin_cos();
            let across = if row % 6 == 0 { rounding } else { across };
            obj += &format!("v {} {} {up}\n", across * cos, across * sin);
        }
        for (row, column) in (0..6 * count).map(|i| (i / count, i % count)) {
            let [a, b] = [column, (column + 1) % count].map(|column| row * count + column + 1);
            obj += &format!("f {a} {} {} {b}\n", a + count, b + count);
        }
        parsed(obj.as_bytes())
    });
    assert_eq!((rounded.mesh.vertices.len(), rounded.mesh.triangles.len()), (62, 120));
    assert_eq!((exact.mesh.triangles, exact.notes), (rounded.mesh.triangles, Vec::new()));
    assert_eq!(rounded.notes, ["joined vertices within a thousandth of an edge at 22 places"]);
}

#[test]
fn obj_vertices_may_have_colors_and_ply_files_strips() {
    let obj = b"v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 0 0.5 0\nf 1 2 3\n";
    let corners = parsed(obj).mesh.paint.unwrap().corners[0].map(|corner| corner.color);
    let half = Transfer::Srgb.linear_from_encoded(0.5);
    assert_eq!(corners, [DVec3::X, DVec3::ONE, DVec3::new(0.0, half, 0.0)]);
    // Codes of 8 bits, and a vertex without a color.
    let corners = parsed(b"v 0 0 0\nv 1 0 0 255 0 0\nv 0 1 0 0 0 0\nf 1 2 3\n").mesh.paint.unwrap().corners[0];
    assert_eq!(corners.map(|corner| corner.color), [DVec3::ONE, DVec3::X, DVec3::ZERO]);
    assert!(message(b"v 0 0 0 1 0 red\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").contains("\"red\" is not a number"));
    let ply = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 0 0\n8 0 1 2 3 -1 1 4 3\n";
    let mesh = parsed(ply.as_bytes()).mesh;
    assert_eq!(mesh.triangles.len(), 3);
    assert!((0..3).all(|t| {
        let [a, b, c] = mesh.corners(t);
        (b - a).cross(c - a).z > 0.0
    }));
}

#[test]
fn extensions_of_glb_files_are_read_or_named() {
    let required = |name: &'static str| glb(move |json| json["extensionsRequired"] = json!([name]));
    assert!(parsed(&required("KHR_mesh_quantization")).notes.is_empty());
    let refused = message(&required("KHR_draco_mesh_compression"));
    assert!(refused.contains("requires extensions that are not read (KHR_draco_mesh_compression)"), "{refused}");
    assert!(refused.contains("as \"gltf-transform copy"), "{refused}");
    let used = glb(|json| json["extensionsUsed"] = json!(["KHR_materials_ior", "KHR_texture_transform"]));
    assert_eq!(parsed(&used).notes, ["extensions were ignored: KHR_materials_ior"]);
    assert_eq!(parsed(&required("KHR_materials_unlit")).notes, ["extensions were ignored: KHR_materials_unlit"]);
    // A quarter turn of the texture, in f32: u becomes v.
    let place = json!({ "KHR_texture_transform": { "rotation": std::f64::consts::FRAC_PI_2, "offset": [0.25, 0], "scale": [2, 2] } });
    let turned = glb(move |json| {
        let base = &mut json["materials"][0];
        base["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = place.clone();
    });
    let places = |content: &[u8]| {
        parsed(content).mesh.paint.unwrap().corners.concat().iter().map(|c| c.place).collect::<Vec<_>>()
    };
    for (before, after) in places(&glb(|_| {})).iter().zip(places(&turned)) {
        assert!(after.distance(DVec2::new(0.25 + 2.0 * before.y, -2.0 * before.x)) < 1e-6, "{before}: {after}");
    }
}

/// Faces without normals are flat, unless normals are to be estimated.
#[test]
fn a_glb_file_without_normals_is_flat() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tent.glb");
    let mut content = glb(|json| {
        json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    });
    // One corner is lifted, so that the square becomes a roof.
    let first = content.windows(4).position(|bytes| bytes == b"BIN\0").unwrap() + 4;
    content[first + 20..first + 24].copy_from_slice(&1.0_f32.to_le_bytes());
    std::fs::write(&path, content).unwrap();
    let flat = mesh::read(&path, 180.0, Normals::Given).unwrap();
    assert!(flat.notes[0].starts_with("faces without normals are flat"), "{:?}", flat.notes);
    assert_eq!(flat.mesh.vertices.len(), 6);
    let smooth = mesh::read(&path, 180.0, Normals::Averaged).unwrap();
    assert!(smooth.notes.is_empty() && smooth.mesh.vertices.len() == 4);
}

/// Given normals decide to which side a surface faces, and a face that repeats another one is left out: both are said.
#[test]
fn faces_agree_with_their_normals_and_occur_once() {
    let axes = ["1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0 0 1", "0 0 -1"];
    let faces = [[1, 3, 5], [3, 2, 5], [2, 4, 5], [4, 1, 5], [3, 1, 6], [2, 3, 6], [4, 2, 6], [1, 4, 6]];
    let octahedron = |faces: &[[u8; 3]]| {
        let [v, vn] = ["v", "vn"].map(|key| axes.map(|axis| format!("{key} {axis}\n")).concat());
        let face = |[a, b, c]: &[u8; 3]| format!("f {a}//{a} {b}//{b} {c}//{c}\n");
        let text = v + &vn + &faces.iter().map(face).collect::<String>();
        machband::store::mesh::parse("o.obj", text.as_bytes(), 180.0).unwrap()
    };
    let sum = |mesh: &machband::shading::Mesh| -> f64 {
        (0..mesh.triangles.len()).map(|t| mesh.corners(t)).map(|[a, b, c]| a.dot(b.cross(c))).sum()
    };
    let right = octahedron(&faces);
    assert!(right.notes.is_empty() && sum(&right.mesh) == 8.0, "{:?}", right.notes);
    let reversed = octahedron(&faces.map(|[a, b, c]| [a, c, b]));
    assert_eq!(reversed.notes, ["reversed 8 faces, because the normals point to the other side"]);
    assert_eq!(sum(&reversed.mesh), 8.0);
    // In another order, but in the same direction.
    let repeated: Vec<_> = faces.into_iter().chain([[5, 1, 3], [1, 4, 6]]).collect();
    let repeated = octahedron(&repeated);
    assert_eq!(repeated.notes, ["left out 2 repeated faces"]);
    assert_eq!(repeated.mesh, right.mesh);
}
