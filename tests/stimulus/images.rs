//! Images of stimuli: the light of every kind matches an independent script, its codes match their recorded hash, and files
//! can be verified and made in shards.

use std::{path::Path, process::Stdio, time::Duration};

use glam::DVec2;
use machband::{
    light::{Bits, Dither, Quantizer, Transfer, Transfers},
    shading::{Frame, Scene, Shade, Shader, Surface, shapes},
    stimulus::{KINDS, Stimulus, along, catalog, emitted, recipe::Recipe},
    store::{Writer, image},
    work::stimulus,
};
use sha2::{Digest as _, Sha256};

use crate::{
    common::{command, everything, fails, machband, pixels, split, succeeds, text},
    transfers,
};

fn recipe(kind: &str) -> Recipe {
    Recipe {
        stimulus: Stimulus::default_of(kind).unwrap(),
        size: 40,
        transfers: Transfer::Srgb.into(),
        bits: Bits::Eight,
        dither: Dither::None,
        seed: 1,
        display_sha256: None,
        finish: None,
    }
}

fn table() -> Transfer {
    transfers().pop().unwrap()
}

/// Returns a writer that may replace the file of an earlier step of a test.
fn replacing() -> Writer {
    Writer::new([], true)
}

/// For every kind, transfer, depth and dither, a written image reads back as the codes that were rendered and passes
/// verification.
#[test]
fn images_read_back_and_can_be_verified() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    for entry in catalog::all() {
        for stimulus in crate::stimuli(entry.kind) {
            let differing = Transfers::new([Transfer::Gamma(2.0), table(), Transfer::gog(2.4, 1.1, -0.1).unwrap()]);
            let alike = [Transfer::Srgb, Transfer::Linear, Transfer::Gamma(2.2), table()].map(Transfers::from);
            for transfers in alike.into_iter().chain([differing]) {
                for (bits, dither) in [
                    (Bits::Eight, Dither::None),
                    (Bits::Sixteen, Dither::None),
                    (Bits::Eight, Dither::BlueNoise),
                    (Bits::Eight, Dither::Random),
                ] {
                    let (stimulus, transfers) = (stimulus.clone(), transfers.clone());
                    let recipe = Recipe { stimulus, transfers, bits, dither, seed: 7, ..recipe("mach-band") };
                    let quantizer = recipe.quantizer();
                    image::write_recipe(&replacing(), &path, &recipe, &quantizer).unwrap();
                    let read = image::read_picture(&path, Some(&recipe.transfers), image::MAX_PIXELS).unwrap();
                    assert_eq!(read.codes, recipe.codes(&quantizer), "{recipe:?}");
                    // The text of a random dither has no seed; the seed of the recipe applies.
                    image::verify(&path, image::MAX_PIXELS).unwrap();
                }
            }
        }
    }
}

#[test]
fn an_image_file_describes_its_codes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    let info = |recipe: &Recipe| {
        image::write_recipe(&replacing(), &path, recipe, &recipe.quantizer()).unwrap();
        pixels(&path).0
    };
    let yellow = info(&recipe("mach-band"));
    assert_eq!((yellow.color_type, yellow.srgb.is_some()), (png::ColorType::Rgb, true));
    let gray = info(&Recipe { bits: Bits::Sixteen, transfers: Transfer::Gamma(2.2).into(), ..recipe("chevreul") });
    assert_eq!((gray.color_type, gray.bit_depth), (png::ColorType::Grayscale, png::BitDepth::Sixteen));
    assert_eq!(gray.gamma().unwrap().into_scaled(), 45455);
    assert!(gray.chromaticities().is_some() && gray.srgb.is_none());
    for kind in ["mach-band", "chevreul"] {
        let measured = info(&Recipe { transfers: table().into(), ..recipe(kind) });
        let profile = moxcms::ColorProfile::new_from_slice(&measured.icc_profile.unwrap()).unwrap();
        // Equal inputs give equal bytes at any time.
        let date = &profile.creation_date_time;
        assert_eq!((date.year, date.month, date.day_of_the_month, date.hours, date.minutes), (2026, 1, 1, 0, 0));
        let curve = profile.red_trc.or(profile.gray_trc).unwrap();
        let moxcms::ToneReprCurve::Lut(points) = curve else { panic!("{curve:?}") };
        let middle = f64::from(points[points.len() / 2]) / 65535.0;
        let expected = table().linear_from_encoded((points.len() / 2) as f64 / (points.len() - 1) as f64);
        assert!((middle - expected).abs() < 1e-4, "{middle} {expected}");
    }
}

#[test]
fn a_changed_image_is_detected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    let recipe = recipe("kanizsa");
    image::write_recipe(&replacing(), &path, &recipe, &recipe.quantizer()).unwrap();
    // The same codes except for one, with the same recipe.
    let mut codes: Vec<u8> = recipe.codes(&recipe.quantizer()).bytes().unwrap().iter().step_by(3).copied().collect();
    codes[123] ^= 1;
    let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), 40, 40);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.add_text_chunk("machband".to_owned(), image::describe(&recipe)).unwrap();
    encoder.write_header().unwrap().write_image_data(&codes).unwrap();
    let message = image::verify(&path, image::MAX_PIXELS).unwrap_err().to_string();
    assert!(message.contains("has other codes than its recipe makes"), "{message}");

    for (content, expected) in [
        (&b"no image at all"[..], "is not a PNG; expected a PNG"),
        (&std::fs::read(&path).unwrap()[..200], "complete PNG"),
    ] {
        std::fs::write(&path, content).unwrap();
        let message = image::verify(&path, image::MAX_PIXELS).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), 1, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[0]).unwrap();
    assert!(image::verify(&path, image::MAX_PIXELS).unwrap_err().to_string().contains("no text chunk"));
}

#[test]
fn palettes_and_halftones_can_be_verified() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for method in ["popularity:8", "median-cut:16"] {
        succeeds(folder, &["stimulus", "--size", "64", "--palette", method, "--out", "p.png", "--force"]);
        assert!(succeeds(folder, &["check", "p.png"]).contains(method));
    }
    for screen in ["clustered3:1", "bayer4:2"] {
        succeeds(folder, &["stimulus", "--size", "32", "--halftone", screen, "--out", "h.png", "--force"]);
        assert!(succeeds(folder, &["check", "h.png"]).contains(screen));
    }
    fails(folder, &["stimulus", "--palette", "median-cut:0", "--out", "q.png"], 2);
}

/// The command that the gallery copies creates exactly the same file.
#[test]
fn the_copied_command_makes_the_same_image() {
    let folder = tempfile::tempdir().unwrap();
    for entry in catalog::all() {
        let settings = [
            (Bits::Eight, Dither::None, Transfer::Srgb, 1),
            (Bits::Sixteen, Dither::None, Transfer::Gamma(1.8), 1),
            (Bits::Eight, Dither::Random, Transfer::Srgb, 9),
        ];
        for (stimulus, (bits, dither, transfer, seed)) in crate::stimuli(entry.kind).into_iter().zip(settings) {
            let recipe = Recipe { stimulus, bits, dither, transfers: transfer.into(), seed, ..recipe(entry.kind) };
            let expected = folder.path().join("expected.png");
            image::write_recipe(&replacing(), &expected, &recipe, &recipe.quantizer()).unwrap();
            let command = stimulus::command(&recipe);
            succeeds(folder.path(), &split(&command)[1..]);
            let made = folder.path().join("stimulus.png");
            assert!(std::fs::read(&made).unwrap() == std::fs::read(&expected).unwrap(), "{command}");
            std::fs::remove_file(made).unwrap();
        }
    }
}

#[test]
fn shards_make_up_the_whole_and_a_killed_run_can_be_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let content = |name: &str| {
        let root = folder.path().join(name);
        let files = everything(&root).into_iter().filter(|(path, _)| path.extension().is_none_or(|end| end != "tmp"));
        files.map(|(path, content)| (path.strip_prefix(&root).unwrap().to_owned(), content)).collect::<Vec<_>>()
    };
    let options = ["stimuli", "bangay2003", "--size", "96", "--dither", "ordered", "--out"];
    let stimuli = |out: &str, more: &[&str]| succeeds(folder.path(), &[&options[..], &[out], more].concat());
    stimuli("whole", &[]);
    let whole = content("whole");
    assert_eq!(whole.len(), 121);
    assert_eq!(whole[120].0, Path::new("manifest.csv"));
    for shard in ["2/3", "1/3", "3/3"] {
        stimuli("parts", &["--shard", shard]);
    }
    assert!(content("parts") == whole);

    // Kill the run at several moments. Each time, complete files are kept.
    for delay in [3, 6, 9, 12, 20] {
        let mut child = command(folder.path(), &[&options[..], &["killed"]].concat()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(delay));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    stimuli("killed", &[]);
    assert!(content("killed") == whole);

    // If everything is complete, nothing is made again. If one file was changed and one is gone, only those are made.
    assert!(stimuli("whole", &[]).starts_with("0 images made, 120 kept"));
    std::fs::remove_file(folder.path().join("whole").join(&whole[5].0)).unwrap();
    std::fs::write(folder.path().join("whole").join(&whole[7].0), "touched").unwrap();
    // The changed file is replaced only on request.
    fails(folder.path(), &[&options[..], &["whole"]].concat(), 2);
    assert!(stimuli("whole", &["--force"]).starts_with("2 images made, 118 kept"));
    assert!(content("whole") == whole);
    // A file that became larger than any image is not read.
    let grown = folder.path().join("whole").join(&whole[9].0);
    std::fs::OpenOptions::new().append(true).open(&grown).unwrap().set_len(1 << 40).unwrap();
    let error = fails(folder.path(), &[&options[..], &["whole"]].concat(), 2);
    assert!(error.contains("already exists"), "{error}");
    assert!(stimuli("whole", &["--force"]).starts_with("1 image made, 119 kept"));
    assert!(content("whole") == whole);
    // With different options, everything is made again.
    assert!(stimuli("whole", &["--bits", "16", "--force"]).starts_with("120 images made"));
    fails(folder.path(), &["stimuli", "quick", "--out", "x", "--shard", "4/3"], 2);
}

/// Runs at the same time make one manifest with a row for each image.
#[test]
fn runs_at_once_make_one_manifest() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["stimuli", "bangay2003", "--size", "64", "--out", "s"];
    let manifest = |out: &str| std::fs::read_to_string(folder.path().join(out).join("manifest.csv"));
    succeeds(folder.path(), &["stimuli", "bangay2003", "--size", "64", "--out", "expected"]);
    for shards in [["1/1"; 3], ["1/3", "2/3", "3/3"], ["1/2", "1/2", "2/2"], ["1/1", "1/2", "2/2"]] {
        let started = shards.map(|shard| {
            let mut command = command(folder.path(), &[&options[..], &["--shard", shard]].concat());
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
        });
        for output in started.map(|child| child.wait_with_output().unwrap()) {
            assert!(output.status.success(), "{shards:?}: {}", text(&output.stderr));
        }
        assert_eq!(manifest("s").unwrap(), manifest("expected").unwrap(), "{shards:?}");
        std::fs::remove_dir_all(folder.path().join("s")).unwrap();
    }
}

#[test]
fn a_manifest_lists_only_images_of_one_definition_and_one_size() {
    let folder = tempfile::tempdir().unwrap();
    let shard = |shard: &str, options: &[&str]| {
        machband(folder.path(), &[&["stimuli", "quick", "--out", "x", "--shard", shard][..], options].concat())
    };
    assert!(shard("1/2", &["--size=16"]).status.success());
    let other = shard("2/2", &["--size=32"]);
    assert!(!other.status.success() && text(&other.stderr).contains("is another image than this command makes"));
    // Those of other shards may still be replaced.
    for (part, options, is_whole) in
        [("2/2", ["--size=16", "--bits=16"], false), ("1/2", ["--size=16", "--bits=16"], true)]
    {
        assert!(shard(part, &[&options[..], &["--force"]].concat()).status.success());
        assert_eq!(folder.path().join("x/manifest.csv").exists(), is_whole);
    }
    // A list of other images is replaced only on request.
    std::fs::write(folder.path().join("x/manifest.csv"), "file,sha256\n").unwrap();
    let said = fails(folder.path(), &["stimuli", "quick", "--out", "x", "--size=16", "--bits=16"], 2);
    assert!(said.contains("manifest.csv: already exists"), "{said}");
}

/// Side of the golden images.
const SIZE: u32 = 96;

#[test]
fn light_matches_the_independent_script() {
    let golden = include_str!("../golden/catalog.csv");
    let mut seen = 0;
    for line in golden.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<u32>().unwrap();
        let stimulus = crate::stimuli(cells[0])[number(1) as usize].clone();
        let light = stimulus.linear(SIZE).pixel(number(2), number(3))[stimulus.strongest_channel()];
        let expected: f64 = cells[5].parse().unwrap();
        let tolerance = if cells[4] == "1" { 3e-3 } else { 1e-6 };
        assert!((f64::from(light) - expected).abs() < tolerance, "{line}: {light}");
        seen += 1;
    }
    // The shaded mesh has its own references in tests/shading.
    assert_eq!(seen, 40 * 3 * (catalog::all().len() - 1));
}

/// `UPDATE_HASHES=1` writes the file again. A changed hash means a changed stimulus for everyone who has used it.
#[test]
fn codes_match_their_recorded_hashes() {
    let quantizer = Quantizer::new(&Transfer::Srgb.into(), Bits::Eight);
    let mut text =
        String::from("# SHA-256 of the 8-bit sRGB codes, 96 px a side, of every catalog entry and variant.\n");
    for entry in catalog::all() {
        for (variant, stimulus) in crate::stimuli(entry.kind).iter().enumerate() {
            let image = stimulus.codes(SIZE, &quantizer);
            let hash: String =
                Sha256::digest(image.bytes().unwrap()).iter().map(|byte| format!("{byte:02x}")).collect();
            text += &format!("{},{variant},{hash}\n", entry.kind);
        }
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/catalog_hashes.csv");
    if std::env::var_os("UPDATE_HASHES").is_some() {
        std::fs::write(path, &text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(path).unwrap(), text);
    assert!(catalog::all().iter().map(|entry| entry.kind).eq(KINDS.iter().copied()));
}

fn frame(mesh: shapes::Shape, size: u32) -> Frame {
    Scene::default().frame(&Surface::new(shapes::mesh(mesh, 200).unwrap()), size, size)
}

/// The light along a row of pixel centers equals that row of the picture, and there is none beyond the surface.
#[test]
fn light_along_a_row_matches_the_picture() {
    let frame = frame(shapes::Shape::Torus, 96);
    for shade in [Shader::Gouraud, Shader::Patch].map(Shade::new) {
        let image = emitted(&frame, &shade);
        for y in [10, 48, 70] {
            let ends = [0.0, 96.0].map(|x| DVec2::new(x, f64::from(y) + 0.5));
            for (x, light) in along(&frame, &shade, ends, 96).into_iter().enumerate() {
                let shown = image.pixel(x as u32, y)[0];
                let expected = light.map_or(frame.background.x, |light| light.x) as f32;
                assert!((shown - expected).abs() < 1e-5, "({x}, {y}): {shown}, not {expected}");
            }
        }
    }
}
