//! `machband shade`, as a user types it.

use std::{fs, path::Path, process::Output};

use machband::{
    light::{Bits, Quantizer, Transfer},
    shading::{Reference, Scene, Shade, Shader, Surface, picture, shapes},
};

use crate::common::{machband, pixels, succeeds};

fn shade(folder: &Path, arguments: &[&str]) -> Output {
    machband(folder, &[&["shade"], arguments].concat())
}

fn metrics(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let output = shade(folder, &[arguments, &["--metrics", "m.json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&fs::read(folder.join("m.json")).unwrap()).unwrap()
}

/// The picture matches the library's, is within one code of the reference's, and records how it was made.
#[test]
fn the_picture_matches_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--mesh", "torus", "--vertices", "120", "--shader", "cut", "--size", "90", "--out", "a.png"];
    assert!(shade(folder.path(), &arguments).status.success());
    let (info, codes) = pixels(&folder.path().join("a.png"));
    let surface = Surface::new(shapes::mesh(shapes::Shape::Torus, 120).unwrap());
    let frame = Scene::default().frame(&surface, 90, 90);
    let shade = Shade::new(Shader::Cut);
    let [own, exact] = [picture(&frame, &shade), Reference::new(&frame, &shade).image()].map(|image| {
        let codes = Quantizer::new(&Transfer::Srgb, Bits::Eight).quantize(&image);
        codes.bytes().unwrap().iter().step_by(3).copied().collect::<Vec<u8>>()
    });
    assert_eq!(codes, own);
    assert!(own.iter().zip(&exact).all(|(own, exact)| own.abs_diff(*exact) <= 1));
    let text = &info.uncompressed_latin1_text[0].text;
    let parameters: serde_json::Value = serde_json::from_str(text).unwrap();
    assert_eq!(parameters["shader"], "cut");
    assert_eq!(parameters["depth"], 1);
    assert_eq!(parameters["mesh"], "torus");
}

/// All documented fields are present. The meshes have 622 and 1538 triangles. `exact`, `cut` and `patch` have no
/// creases, whatever n and b are.
#[test]
fn metrics_have_every_documented_field_and_smooth_shaders_have_no_creases() {
    let folder = tempfile::tempdir().unwrap();
    for (vertices, triangles) in [("313", 622), ("771", 1538)] {
        for options in [
            &["--shader", "exact", "--depth", "3", "--boundary", "0.05"][..],
            &["--shader", "exact", "--depth", "2", "--boundary", "0.33"],
            &["--shader", "cut", "--boundary", "1"],
            &["--shader", "patch"],
        ] {
            let found = metrics(
                folder.path(),
                &[&["--mesh", "blob", "--vertices", vertices, "--size", "512"][..], options].concat(),
            );
            assert_eq!(found["triangles"], triangles);
            assert_eq!(found["shader"], options[1]);
            assert!(found["edges"].as_u64().unwrap() > 300, "{found}");
            assert!(found["crease_rms_over_gouraud"].as_f64().unwrap() < 1e-3, "{found}");
        }
    }
    let gouraud = metrics(folder.path(), &["--shader", "gouraud"]);
    assert!((gouraud["crease_rms_over_gouraud"].as_f64().unwrap() - 1.0).abs() < 1e-6, "{gouraud}");
}

/// The visibility of bands matches the prediction for the same surface, regardless of the size of the picture. Gouraud
/// shading is its own reference, and the bands of `patch` are less visible.
#[test]
fn metrics_have_the_visibility_of_bands() {
    let folder = tempfile::tempdir().unwrap();
    let number = |found: &serde_json::Value, field: &str| found[field].as_f64().unwrap_or_else(|| panic!("{field}"));
    let fields = ["visibility", "visibility_bright", "visibility_dark", "band_density"];
    // A surface without real edges: no terminator, no highlight, and no part that hides another.
    let plain = ["--light", "0,0,1", "--specular", "0", "--rotate", "0,-30,0"];
    let of = |shader: &str, size: &str| {
        metrics(folder.path(), &[&plain[..], &["--shader", shader, "--size", size]].concat())
    };
    let (patch, gouraud, larger) = (of("patch", "100"), of("gouraud", "64"), of("patch", "333"));
    for field in fields {
        assert_eq!(number(&patch, field), number(&larger, field), "{field}");
    }
    for field in ["visibility", "band_density"] {
        let of_gouraud = format!("{field}_gouraud");
        assert_eq!(number(&gouraud, &format!("{field}_over_gouraud")), 1.0, "{field}");
        assert_eq!(number(&patch, &of_gouraud), number(&gouraud, field));
        let over = number(&patch, &format!("{field}_over_gouraud"));
        assert!(over < 0.3, "{field}: {over}");
    }

    // The lamp, highlight and surroundings of the stimulus, in case the command's defaults ever change.
    let scene = ["--ambient", "0.1", "--diffuse", "0.6", "--specular", "0.2", "--background", "0.05"];
    let shown = ["--shader", "patch", "--size", "64", "--window", "5", "--white", "250"];
    let shaded = metrics(folder.path(), &[&scene[..], &shown].concat());
    assert_ne!(number(&shaded, "visibility"), number(&patch, "visibility"));
    let predict = ["predict", "--kind", "shaded-mesh", "--shader", "patch", "--window", "5", "--white", "250"];
    let text = succeeds(folder.path(), &predict);
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let at = table.headers().unwrap().iter().position(|name| name == "visibility").unwrap();
    let predicted: f64 = table.records().next().unwrap().unwrap()[at].parse().unwrap();
    assert!((number(&shaded, "visibility") - predicted).abs() < 1e-3 * predicted, "{shaded} and {predicted}");

    // A renderer that interpolates codes emits a different picture; a black picture has no bands.
    let naive = metrics(folder.path(), &[&plain[..], &["--shader", "gouraud", "--size", "64", "--naive"]].concat());
    assert_eq!(number(&naive, "visibility_gouraud"), number(&gouraud, "visibility"));
    assert_ne!(number(&naive, "visibility"), number(&gouraud, "visibility"));
    let dark = ["--ambient", "0", "--diffuse", "0", "--specular", "0", "--background", "0"];
    let black = metrics(folder.path(), &[&["--shader", "patch", "--size", "64"][..], &dark].concat());
    assert_eq!(number(&black, "visibility"), 0.0);
    assert!(black["visibility_over_gouraud"].is_null());
}

/// Every possible error has its own message, and wrong usage has its own exit status.
#[test]
fn every_error_has_its_own_message() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("range.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    let out = ["--out", "x.png"];
    for (options, status, words) in [
        (&["--shader", "goraud"][..], 2, "goraud"),
        (&["--shader", "exact", "--depth", "0"], 2, "1…32"),
        (&["--shader", "exact", "--boundary", "1.5"], 2, "'1.5' for '--boundary <B>': outside 0…1"),
        (&["--shader", "flat", "--mesh", "teapot"], 2, "teapot"),
        (&["--shader", "flat", "--mesh", "blob", "--vertices", "3"], 2, "--vertices"),
        (&["--shader", "flat", "--light", "0,0,0"], 2, "too short or long"),
        (&["--shader", "flat", "--rotate", "1,2"], 2, "three numbers"),
        (&["--shader", "flat", "--distance", "0.5"], 2, "outside 1.05…1000000"),
        (&["--shader", "phong", "--reweight", "repaired"], 2, "expected off for phong"),
        (&["--shader", "flat", "--metrics", "x.png"], 2, "same file as --out"),
        (&["--shader", "flat", "--ambient", "NaN"], 2, "'--ambient <L>': outside 0…1"),
        (&["--shader", "flat", "--window", "0"], 2, "'0' for '--window <DEG>': outside 0.5…170"),
        (&["--shader", "flat", "--white", "-1"], 2, "'-1' for '--white <CD_M2>'"),
        (&["--shader", "flat", "--mesh", "none.obj"], 1, "none.obj"),
        (&["--shader", "flat", "--mesh", "range.obj"], 1, "range.obj:4:"),
        (&["--shader", "flat", "--display", "none.toml"], 1, "none.toml"),
    ] {
        let output = shade(folder.path(), &[options, &out].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{options:?}: {error}");
        assert!(error.starts_with("error: ") && error.contains(words), "{options:?}: {error}");
        assert!(!folder.path().join("x.png").exists(), "{options:?}");
    }
    let nothing = shade(folder.path(), &["--shader", "flat"]);
    assert_eq!(nothing.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&nothing.stderr).contains("nothing to write"));
}

/// An OBJ file with a quad, a polygon, relative indices and normals can be rendered.
#[test]
fn an_obj_file_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        "o roof\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1\nf -5 -4 -1\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 4 3 2 1\n";
    fs::write(folder.path().join("roof.obj"), text).unwrap();
    let found = metrics(folder.path(), &["--mesh", "roof.obj", "--shader", "exact", "--depth", "2"]);
    assert_eq!(found["triangles"], 6);
    assert!(found["crease_rms_over_gouraud"].as_f64().unwrap() < 1e-3, "{found}");
}
