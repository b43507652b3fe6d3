//! `machband predict` and the vision observer, run as a user runs them.

use std::fs;

use crate::common::{fails, split, succeeds};

fn column(table: &str, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let place = reader.headers().unwrap().iter().position(|header| header == name).expect(name);
    reader.records().map(|record| record.unwrap()[place].to_owned()).collect()
}

fn numbers(table: &str, name: &str) -> Vec<f64> {
    column(table, name).iter().map(|text| text.parse().unwrap()).collect()
}

#[test]
fn a_stimulus_a_definition_and_an_image_agree() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    let (one, all) = (run("predict --width 0.1 --size 512"), run("predict bangay2003 --size 512"));
    assert!(all.starts_with("width,depth,orientation_deg,visibility,detection,predicted_rating,"), "{all}");
    assert_eq!(all.lines().count(), 121);
    let found = all.lines().find(|line| line.starts_with("0.1,1,0,")).unwrap();
    assert!(found.contains(&column(&one, "visibility")[0]), "{found} and {one}");
    let ratings = numbers(&all, "predicted_rating");
    assert!(ratings.iter().all(|rating| (0.0..=3.0).contains(rating)));
    for (pair, depths) in numbers(&all, "visibility").windows(2).zip(column(&all, "depth").windows(2)) {
        assert!(depths[0] >= depths[1] || depths[0] == depths[1] || pair[0] >= pair[1] - 0.5, "{pair:?} {depths:?}");
    }
    // 16 bits, because 8 bits add visible steps.
    run("stimulus --width 0.1 --size 512 --bits 16 --orientation 30 --out ramp.png");
    let image = run("predict --image ramp.png --map bands.png");
    let ratio = numbers(&image, "visibility")[0] / numbers(&one, "visibility")[0];
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
    assert!(fs::metadata(folder.path().join("bands.png")).unwrap().len() > 1000);
}

/// The codes of an image mean what the file says: the same light in linear codes and in sRGB codes has the same
/// prediction.
#[test]
fn images_mean_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    let json = |line: &str| -> serde_json::Value { serde_json::from_str(&run(line)).unwrap() };
    run("stimulus --width 0.1 --size 256 --bits 16 --color gray --out srgb.png");
    run("stimulus --width 0.1 --size 256 --bits 16 --color gray --transfer linear --out linear.png");
    let [srgb, linear] = ["srgb", "linear"].map(|name| json(&format!("predict --image {name}.png --json")));
    assert!(linear["lines_bright"].is_number() && linear["visibility_dark"].is_number(), "{linear}");
    for name in ["visibility", "detection"] {
        let ratio = srgb[name].as_f64().unwrap() / linear[name].as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 0.001, "{name}: {srgb} and {linear}");
    }
    // An option has precedence.
    let other = json("predict --image linear.png --transfer gamma:3 --json");
    assert!(other["detection"].as_f64().unwrap() > 1.2 * linear["detection"].as_f64().unwrap(), "{other}");
    run("simulate quick --participants 4 --observer vision");
    let fitted = json("predict quick --fit results/quick --json");
    assert!(fitted["rank_correlation"].is_number() && fitted["criterion"]["thresholds"].is_array(), "{fitted}");
}

/// Fitting simulated ratings recovers the thresholds of the simulated observer.
#[test]
fn a_criterion_is_recovered_from_ratings() {
    let folder = tempfile::tempdir().unwrap();
    let known = "schema = 1\nthresholds = [0.4, 0.8, 1.6]\nspread = 0.5\nsubject_sd = 0.0\nlapse = 0.0\n";
    fs::write(folder.path().join("known.toml"), known).unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    run("simulate bangay2003 --participants 20 --observer vision --observer-file known.toml");
    // The simulated observer saw a stimulus of 512 pixels.
    let output =
        run("predict bangay2003 --size 512 --fit results/bangay2003 --criterion found.toml --out predicted.csv");
    let found: toml::Table = fs::read_to_string(folder.path().join("found.toml")).unwrap().parse().unwrap();
    let thresholds: Vec<f64> = found["thresholds"].as_array().unwrap().iter().map(|t| t.as_float().unwrap()).collect();
    for (found, known) in thresholds.iter().zip([0.4_f64, 0.8, 1.6]) {
        assert!((found / known).ln().abs() < 0.08, "{found} for {known}");
    }
    assert!((found["spread"].as_float().unwrap() / 0.5 - 1.0).abs() < 0.1, "{found}");
    let rho = output.lines().find(|line| line.starts_with("rank correlation")).unwrap();
    assert!(rho.rsplit(' ').next().unwrap().parse::<f64>().unwrap() > 0.95, "{output}");
    assert!(output.contains("noise ceiling"), "{output}");
    assert_eq!(fs::read_to_string(folder.path().join("predicted.csv")).unwrap().lines().count(), 121);
}

#[test]
fn impossible_predictions_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let png = |name: &str, side: u32, color: png::ColorType, codes: &[u8]| {
        let file = fs::File::create(folder.path().join(name)).unwrap();
        let mut encoder = png::Encoder::new(file, side, side);
        encoder.set_color(color);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.write_header().unwrap().write_image_data(codes).unwrap();
    };
    png("alpha.png", 32, png::ColorType::Rgba, &[128; 32 * 32 * 4]);
    png("black.png", 64, png::ColorType::Grayscale, &[0; 64 * 64]);
    png("dot.png", 1, png::ColorType::Grayscale, &[128]);
    png("small.png", 20, png::ColorType::Rgb, &[128; 20 * 20 * 3]);
    fs::write(folder.path().join("text.png"), "no image").unwrap();
    for (file, what) in [
        ("alpha.png", "alpha"),
        ("black.png", "all black"),
        ("dot.png", "1 × 1 pixels is too small"),
        ("small.png", "20 × 20 pixels is too small"),
        ("text.png", "not a complete PNG"),
        ("none.png", "cannot be opened"),
    ] {
        let error = fails(folder.path(), &["predict", "--image", file, "--window", "0.1"], 1);
        assert!(error.starts_with(&format!("error: {file}")) && error.contains(what), "{error}");
    }
    for (line, status, part) in
        [("predict --window=-1", 2, "--window"), ("predict bangay2003 --fit nowhere", 1, "nowhere")]
    {
        let error = fails(folder.path(), &split(line), status);
        assert!(error.contains(part), "{error}");
    }
}
