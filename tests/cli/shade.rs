//! `machband shade`, as a user types it.

use std::{fs, path::Path};

use machband::{
    light::{Bits, Quantizer, Transfer},
    shading::{Scene, Shade, Shader, Surface, image, shapes},
};

use crate::common::{json, machband, pixels, refuses, split, succeeds};

fn metrics(folder: &Path, options: &str) -> serde_json::Value {
    succeeds(folder, &split(&format!("shade {options} --metrics m.json --force")));
    json(&folder.join("m.json"))
}

/// The picture matches the library's, and records how it was made.
#[test]
fn the_picture_matches_the_library() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("shade --mesh torus --vertices 120 --shader patch --size 90 --out a.png"));
    let (info, codes) = pixels(&folder.path().join("a.png"));
    let surface = Surface::new(shapes::mesh(shapes::Shape::Torus, 120).unwrap());
    let frame = Scene::default().frame(&surface, 90, 90);
    let own = Quantizer::new(&Transfer::Srgb.into(), Bits::Eight).quantize(&image(&frame, &Shade::new(Shader::Patch)));
    assert_eq!(codes, own.bytes().unwrap().iter().step_by(3).copied().collect::<Vec<u8>>());
    let text = &info.uncompressed_latin1_text[0].text;
    let parameters: serde_json::Value = serde_json::from_str(text).unwrap();
    assert_eq!(parameters["shader"], "patch");
    assert_eq!(parameters["depth"], 1);
    assert_eq!(parameters["mesh"], "torus");
    succeeds(folder.path(), &split("shade --shader phong --highlight cook-torrance --facet-slope .4 --out c.png"));
    let idle = machband(
        folder.path(),
        &split(
            "shade --mesh cube --vertices 9 --crease 9 --shader flat --depth 7 --vertex repaired --facet-c1 1 --out d.png",
        ),
    );
    let notes = ["vertices", "crease", "depth", "vertex", "facet_c1"]
        .map(|name| format!("note: {name} has no effect, because "));
    let said = String::from_utf8(idle.stderr).unwrap();
    assert!(notes.iter().all(|note| said.contains(note)), "{said}");
}

/// All documented fields are present. The meshes have 622 and 1538 triangles. `patch` has no
/// creases.
#[test]
fn metrics_have_every_documented_field_and_patch_has_no_creases() {
    let folder = tempfile::tempdir().unwrap();
    for (vertices, triangles) in [(313, 622), (771, 1538)] {
        let options = format!("--mesh blob --vertices {vertices} --size 512 --shader patch");
        let found = metrics(folder.path(), &options);
        assert_eq!((&found["triangles"], &found["shader"]), (&triangles.into(), &"patch".into()));
        assert!(found["edges"].as_u64().unwrap() > 300, "{found}");
        assert!(found["crease_rms_over_gouraud"].as_f64().unwrap() < 1e-3, "{found}");
    }
    // Flat light has no slopes, but steps; the root mean square is left to the file.
    let line = succeeds(folder.path(), &split("shade --shader flat --size 64 --metrics flat.json"));
    assert!(line.contains("flat: crease median 0 per pixel over ") && line.contains("), but steps of 0.0"), "{line}");
    assert!(line.contains(" edges, 0 times Gouraud's (95 % of their length: at most 0, 0 times Gouraud's)"), "{line}");
    let gouraud = metrics(folder.path(), "--shader gouraud");
    assert!((gouraud["crease_rms_over_gouraud"].as_f64().unwrap() - 1.0).abs() < 1e-6, "{gouraud}");
}

/// The visible difference from the smooth surface is the same regardless of the size of the picture. Gouraud shading is
/// its own reference, and `patch` differs less.
#[test]
fn metrics_have_the_visible_difference() {
    let folder = tempfile::tempdir().unwrap();
    // A surface without real edges: no terminator, no highlight, and no part that hides another.
    let of = |options: &str| {
        metrics(folder.path(), &format!("--light 0,0,1 --specular 0 --rotate 0,-30,0 --shader {options}"))
    };
    let number = |found: &serde_json::Value, field: &str| found["difference"][field].as_f64().unwrap();
    let over = |found: &serde_json::Value, field: &str| found["difference"]["over_gouraud"][field].as_f64().unwrap();
    let (patch, gouraud, larger) = (of("patch --size 100"), of("gouraud --size 64"), of("patch --size 333"));
    for field in ["largest", "p95"] {
        assert_eq!(number(&patch, field), number(&larger, field), "{field}");
        assert_eq!(over(&gouraud, field), 1.0, "{field}");
        assert_eq!(over(&patch, field), number(&patch, field) / number(&gouraud, field));
        assert!(over(&patch, field) < 0.8, "{patch}");
    }
    assert!(number(&patch, "p95") < number(&patch, "largest"));
    // Half the width: finer structure, which is seen less well; without a black, black pixels have no contrast.
    assert_ne!(number(&of("gouraud --size 64 --window 5"), "largest"), number(&gouraud, "largest"));
    let cube = metrics(folder.path(), "--mesh cube --shader gouraud");
    assert!(cube["difference"].is_null() && cube["residual"].is_null() && cube["masked"].is_null(), "{cube}");
}

/// Every possible error has its own message, and wrong usage has its own exit status.
#[test]
fn every_error_has_its_own_message() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("range.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    let cases = r#"
        2: goraud => goraud
        2: fixed --depth 0 => 1…32
        2: flat --mesh teapot => "teapot" is not known; expected one of cube,
        2: flat --mesh blob --vertices 3 => --vertices
        2: flat --light 0,0,0 => too short or too long
        2: flat --rotate 1,2 => three numbers
        2: flat --distance 0.5 => outside 1.05…1000000
        2: flat --metrics x.png => is another output
        2: flat --window 0 => '0' for '--window <DEG>': outside 0.5…170
        1: flat --mesh none.obj => none.obj
        1: flat --mesh range.obj => range.obj:4:
        1: flat --display none.toml => none.toml"#;
    refuses(folder.path(), "shade --shader {} --out x.png", cases);
    let cases = r"
        2: --shader flat => nothing to write
        2: --shader gouraud --background 0 --black 0 --out x.png --metrics x.json => --black 0: no light";
    refuses(folder.path(), "shade {}", cases);
}

/// `--truth` alone draws the surface; a finer file is the surface of a mesh from a file; what is not known is said.
#[test]
fn the_smooth_surface_is_drawn_and_compared() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let torus = "shade --mesh torus --vertices 200 --size 128";
    succeeds(folder.path(), &split(&format!("{torus} --truth --out truth.png")));
    succeeds(folder.path(), &split(&format!("{torus} --shader c1-phong --out c1.png")));
    succeeds(folder.path(), &split(&format!("{torus} --shader gouraud --out gouraud.png")));
    let [truth, c1, gouraud] = ["truth.png", "c1.png", "gouraud.png"].map(|name| pixels(&at(name)).1);
    let apart = |a: &[u8]| a.iter().zip(&truth).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(truth != c1 && apart(&c1) < apart(&gouraud) / 2, "{} {}", apart(&c1), apart(&gouraud));

    let found =
        metrics(folder.path(), "--mesh uv-sphere --vertices 674 --shader c1-phong --specular 0.3 --light 0.5,0.5,0.7");
    let residual = &found["residual"];
    assert!(residual["over_gouraud"]["rms"].as_f64().unwrap() < 0.1, "{found}");
    assert!(residual["over_gouraud"]["p999"].as_f64().unwrap() < 0.2, "{found}");
    assert!(residual["rms"].as_f64().unwrap() < residual["p999"].as_f64().unwrap(), "{found}");
    assert!((0.0..0.3).contains(&found["masked"].as_f64().unwrap()), "{found}");
    assert_eq!(found["normals"], "given");
    // A cylinder's own edges are no difference.
    let sharp = metrics(folder.path(), "--mesh cylinder --vertices 48 --rotate 60,-35,0 --shader c1-phong");
    assert!(sharp["difference"]["largest"].as_f64().unwrap() < 1.0, "{sharp}");

    // A grid of four quads over a bent sheet, and the same sheet with many more.
    for (name, cells) in [("coarse.obj", 4), ("fine.obj", 80)] {
        let step = |i: usize| i as f64 / cells as f64 * 2.0 - 1.0;
        let mut obj = String::new();
        for i in 0..(cells + 1) * (cells + 1) {
            let (x, y) = (step(i % (cells + 1)), step(i / (cells + 1)));
            obj += &format!("v {x} {y} {}\nvn {} 0 1\n", 0.4 * (2.0 * x).sin(), -0.8 * (2.0 * x).cos());
        }
        for i in 0..cells * cells {
            let a = i / cells * (cells + 1) + i % cells + 1;
            obj += &format!("f {0}//{0} {1}//{1} {2}//{2} {3}//{3}\n", a, a + 1, a + cells + 2, a + cells + 1);
        }
        fs::write(at(name), obj).unwrap();
    }
    let coarse = "--mesh coarse.obj --rotate 0,0,0 --shader";
    assert!(metrics(folder.path(), &format!("{coarse} phong"))["residual"].is_null());
    let [phong, c1] = ["phong", "c1-phong"].map(|shader| {
        let found = metrics(folder.path(), &format!("{coarse} {shader} --truth fine.obj"));
        found["residual"]["over_gouraud"]["rms"].as_f64().unwrap()
    });
    assert!(c1 < 0.6 * phong, "{c1} {phong}");
    // Estimated normals are worse than the given ones, but a mesh without normals can have them.
    let estimated = metrics(folder.path(), &format!("{coarse} c1-phong --normals best --truth fine.obj"));
    assert!(estimated["residual"]["over_gouraud"]["rms"].as_f64().unwrap() > c1, "{estimated}");

    let cases = r"
        2: --mesh cube --truth --out x.png => the smooth surface behind cube is not known
        2: --mesh torus --truth --metrics x.json => --shader is missing, but the measurements need one
        2: --mesh torus --shader phong --truth --out x.png => --truth: draws the smooth surface itself; expected no
        2: --mesh torus --shader phong --truth fine.obj --out x.png => --truth: is compared only by the metrics
        2: --mesh torus --out x.png => --shader
        2: --mesh torus --shader phong --normals mean --out x.png => [possible values: given, averaged, best]
        1: --mesh torus --truth none.obj --out x.png => none.obj";
    refuses(folder.path(), "shade {}", cases);
}

/// A scene replaces the options for one mesh; its errors have their places.
#[test]
fn a_scene_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "schema = 1\n[[mesh]]\nmesh = \"torus\"\ncolor = [0.8, 0.05, 0.05]\n[[mesh]]\nmesh = \"sphere\"\nscale = 0.5\nspecular = 0.1\n\
                 transparency = \"filtered\"\nindex = 1.5\n[[lamp]]\ndirection = [0.3, 0.4, 0.9]\n";
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    succeeds(folder.path(), &split("shade scene.toml --size 120 --out scene.png"));
    let codes = pixels(&folder.path().join("scene.png")).1;
    assert!(codes.as_chunks::<3>().0.iter().filter(|[r, g, _]| *r > g.saturating_mul(2)).count() > 500);
    let cases = r"
        2: scene.toml --mesh torus --out x.png => --mesh: does not apply to a scene
        2: scene.toml => nothing to write
        2: scene.toml --metrics x.json => cannot be used with
        1: none.toml --out x.png => none.toml: cannot be opened";
    refuses(folder.path(), "shade {}", cases);
    fs::write(folder.path().join("bad.toml"), scene.replace("1.5", "\"glass\"")).unwrap();
    refuses(folder.path(), "shade {} --out x.png", "1: bad.toml => bad.toml:10:1:");
}
