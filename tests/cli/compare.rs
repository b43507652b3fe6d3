//! `machband compare` and `predict`, and the vision observer, run as a user runs them: what they print, what they refuse,
//! and what pictures of other programs mean.

use std::{
    fs,
    path::{Path, PathBuf},
};

use machband::store::{definition, sidecar::Geometry};
use serde_json::Value;

use crate::common::{fails, json, machband, pixels, refuses, session_csv, split, succeeds, text};

/// Writes a PNG as another program would; `prepare` adds chunks.
fn png(
    path: &Path,
    [width, height]: [u32; 2],
    color: png::ColorType,
    codes: &[u8],
    prepare: impl FnOnce(&mut png::Info),
) {
    let mut info = png::Info::with_size(width, height);
    info.color_type = color;
    info.bit_depth = png::BitDepth::Eight;
    prepare(&mut info);
    let encoder = png::Encoder::with_info(fs::File::create(path).unwrap(), info).unwrap();
    encoder.write_header().unwrap().write_image_data(codes).unwrap();
}

/// A folder of pictures that commands compare.
struct Pictures(tempfile::TempDir);

impl Pictures {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a gray picture; `code` gives the code of each pixel.
    fn gray(&self, name: &str, size: [u32; 2], code: impl Fn(u32) -> u8) {
        let codes: Vec<u8> = (0..size[0] * size[1]).map(code).collect();
        png(&self.at(name), size, png::ColorType::Grayscale, &codes, |_| {});
    }

    /// The same with 16 bits.
    fn gray_16(&self, name: &str, size: [u32; 2], code: impl Fn(u32) -> u16, prepare: impl FnOnce(&mut png::Info)) {
        let codes: Vec<u8> = (0..size[0] * size[1]).flat_map(|i| code(i).to_be_bytes()).collect();
        png(&self.at(name), size, png::ColorType::Grayscale, &codes, |info| {
            info.bit_depth = png::BitDepth::Sixteen;
            prepare(info);
        });
    }

    /// What a command that may fail prints as JSON, if it does, and its messages.
    fn run(&self, line: &str) -> (Value, String) {
        let output = machband(self.0.path(), &split(line));
        (serde_json::from_slice(&output.stdout).unwrap_or_default(), text(&output.stderr))
    }

    /// What a command prints that must succeed without a message.
    fn said(&self, line: &str) -> String {
        succeeds(self.0.path(), &split(line))
    }

    fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.said(line)).unwrap()
    }

    fn refused(&self, line: &str, status: i32) -> String {
        fails(self.0.path(), &split(line), status)
    }
}

/// How many times the threshold a difference is.
fn times(found: &Value) -> f64 {
    found["times_threshold"].as_f64().unwrap_or_else(|| panic!("{found}"))
}

/// A gray picture with soft waves; `change` is added to the pixels of a square in the middle.
fn waves(side: u32, change: i16) -> impl Fn(u32) -> u8 {
    move |i: u32| {
        let (x, y) = (f64::from(i % side), f64::from(i / side));
        let wave = 120.0 + 40.0 * (x / 17.0).sin() * (y / 23.0).cos();
        let near = |at: f64| (at - 0.5 * f64::from(side)).abs() < 0.1 * f64::from(side);
        (wave as i16 + if near(x) && near(y) { change } else { 0 }) as u8
    }
}

#[test]
fn the_difference_decides_about_the_exit_status() {
    let pictures = Pictures::new();
    for (name, change) in [("same.png", 0), ("truth.png", 0), ("small.png", 2), ("large.png", 12)] {
        pictures.gray(name, [128; 2], waves(128, change));
    }
    let same = pictures.json("compare same.png truth.png --window 4 --max 0 --json");
    assert_eq!((times(&same), same["places"].as_array().unwrap().len()), (0.0, 0), "{same}");
    let [small, large] =
        ["small", "large"].map(|name| pictures.json(&format!("compare {name}.png truth.png --window 4 --json")));
    assert!(times(&large) > 3.0 * times(&small) && times(&small) > 0.0, "{small} {large}");
    let place = &large["places"][0];
    for axis in ["x", "y"] {
        assert!((45..83).contains(&place[axis].as_i64().unwrap()), "{large}");
    }
    assert_eq!(large["times_threshold"], place["times_threshold"]);
    assert!(large["light"].as_str().unwrap().contains("sRGB is assumed"), "{large}");
    for name in ["center", "window_deg", "white_cd_m2", "black_cd_m2", "picture", "reference"] {
        assert!(!large[name].is_null(), "{name}: {large}");
    }
    // A map with the size of the picture; pixels per degree instead of a width; the maximum.
    let line = pictures.said("compare large.png truth.png --ppd 32 --map map.png");
    assert!(line.starts_with(&format!("large.png: {:.3} times threshold", times(&large))), "{line}");
    let (map, _) = pixels(&pictures.at("map.png"));
    assert_eq!((map.width, map.height), (128, 128));
    let with_max = |max: f64| {
        let line = format!("compare large.png truth.png --window 4 --max {max}");
        machband(pictures.0.path(), &split(&line))
    };
    assert_eq!([0.5, times(&large) + 0.01].map(|max| with_max(max).status.code()), [Some(1), Some(0)]);
    // What a mask leaves out does not count.
    pictures.gray("mask.png", [128; 2], |i| if i % 128 < 20 { 255 } else { 0 });
    let masked = pictures.json("compare large.png truth.png --window 4 --mask mask.png --json");
    assert_eq!(times(&masked), 0.0, "{masked}");
}

#[test]
fn folders_are_compared_in_pairs() {
    let pictures = Pictures::new();
    let (folder, xml) = (pictures.0.path(), |name: &str| fs::read_to_string(pictures.at(name)).unwrap());
    ["new", "old"].iter().for_each(|name| fs::create_dir(pictures.at(name)).unwrap());
    for (name, change) in [("new/a.png", 0), ("new/b & c.png", 9), ("old/a.png", 0), ("old/b & c.png", 0)] {
        pictures.gray(name, [96; 2], waves(96, change));
    }
    let all = pictures.json("compare new old --window 3 --json");
    assert_eq!((all.as_array().unwrap().len(), times(&all[0])), (2, 0.0));
    let one = pictures.json("compare 'new/b & c.png' 'old/b & c.png' --window 3 --json");
    assert_eq!(all[1]["times_threshold"], one["times_threshold"]);
    let above = machband(folder, &split("compare new old --window 3 --max 0.1 --junit out.xml"));
    let errors = text(&above.stderr);
    assert_eq!(above.status.code(), Some(1));
    assert!(errors.starts_with("error: b & c.png: ") && errors.contains("expected at most 0.1"), "{errors}");
    let out = xml("out.xml");
    assert!(out.contains("tests=\"2\" failures=\"1\" errors=\"0\"") && out.contains("b &amp; c.png"), "{out}");
    // A picture without a counterpart, and one that cannot be read, are no successes.
    pictures.gray("new/d.png", [96; 2], waves(96, 0));
    let mixed = machband(folder, &split("compare new old --window 3 --junit lacks.xml"));
    let error = text(&mixed.stderr);
    assert!(mixed.status.code() == Some(1) && text(&mixed.stdout).lines().count() == 2, "{error}");
    let lacks = xml("lacks.xml");
    assert!(error.contains("old: lacks d.png") && lacks.contains("old: lacks d.png"), "{error} {lacks}");
    assert!(lacks.contains("tests=\"3\" failures=\"0\" errors=\"1\""), "{lacks}");
    fs::create_dir(pictures.at("empty")).unwrap();
    pictures.refused("compare empty empty --window 3 --junit empty.xml", 1);
    assert!(xml("empty.xml").contains("errors=\"1\"") && xml("empty.xml").contains("contains no PNG"));
    fs::write(pictures.at("old/d.png"), "no picture").unwrap();
    let (found, errors) = pictures.run("compare new old --window 3 --json");
    assert_eq!([&found[0]["picture"], &found[2]["picture"]], ["new/a.png", "new/d.png"]);
    assert!(errors.contains("old/d.png: is not a PNG; expected a PNG"), "{errors}");
    pictures.refused("compare new/d.png old/d.png --window 3 --junit d.xml", 1);
    assert!(xml("d.xml").contains("errors=\"1\"") && xml("d.xml").contains("is not a PNG"));
}

/// The light of a file is what its chunks say: profiles that machband writes, gray and colored, opaque alpha.
#[test]
fn pictures_mean_what_they_say() {
    let pictures = Pictures::new();
    let levels = (0..=10).map(|k| f64::from(k) / 10.0);
    let readings: String =
        levels.map(|v| format!("gray,{v},{}\n", 0.3 + 80.0 * v.powf(1.5) + 40.0 * v.powi(5))).collect();
    fs::write(pictures.at("readings.csv"), format!("channel,level,luminance_cd_m2\n{readings}")).unwrap();
    pictures.said("calibrate readings.csv --out profile.toml");
    for color in ["gray", "yellow"] {
        for (name, options) in [
            ("srgb", ""),
            ("linear", "--transfer linear"),
            ("gamma", "--transfer gamma:2.4"),
            ("icc", "--display profile.toml"),
        ] {
            let stimulus = format!("stimulus --width 0.1 --size 256 --bits 16 --color {color} {options}");
            pictures.said(&format!("{stimulus} --out {color}-{name}.png"));
        }
        // The same light in other codes is the same picture.
        for name in ["linear", "gamma", "icc"] {
            let found = pictures.json(&format!("compare {color}-{name}.png {color}-srgb.png --window 5 --json"));
            assert!(times(&found) < 0.1, "{color} {name}: {found}");
        }
        let light = pictures.json(&format!("compare {color}-icc.png {color}-icc.png --window 5 --json"));
        assert_eq!(light["light"], "by the file's iCCP chunk");
    }
    // Primaries may come with an exponent or alone. These are sRGB's in another order.
    let ramp: Vec<u8> = (0..64 * 64).flat_map(|i| [40, 200 - (i % 64) as u8, 90]).collect();
    let turned: Vec<u8> = ramp.chunks_exact(3).flat_map(|pixel| [pixel[1], pixel[0], pixel[2]]).collect();
    let [white, red, green, blue] = [[31_270, 32_900], [30_000, 60_000], [64_000, 33_000], [15_000, 6_000]]
        .map(|pair| pair.map(png::ScaledFloat::from_scaled).into());
    let primaries = png::SourceChromaticities { white, red, green, blue };
    for (name, gamma, said) in
        [("alone", None, "cHRM chunk (with sRGB's curve)"), ("both", Some(45_455), "gAMA and cHRM chunks")]
    {
        let files = [format!("{name}-turned.png"), format!("{name}.png")];
        for (file, codes, primaries) in [(&files[0], &turned, Some(primaries)), (&files[1], &ramp, None)] {
            png(&pictures.at(file), [64; 2], png::ColorType::Rgb, codes, |info| {
                info.source_chromaticities = primaries;
                info.source_gamma = gamma.map(png::ScaledFloat::from_scaled);
            });
        }
        let (found, _) = pictures.run(&format!("compare {} {} --window 2 --json", files[0], files[1]));
        assert!(times(&found) < 0.01, "{found}");
        assert!(found["light"].as_str().unwrap().contains(said), "{found}");
    }
    // An option has precedence.
    let (other, _) = pictures.run("compare gray-linear.png gray-srgb.png --window 5 --transfer gamma:3 --json");
    assert!(times(&other) > 3.0, "{other}");
    // 37 of red are as bright as 11 of green. The model does not see the edge, and says why.
    let half = |i: usize| if i % 64 < 32 { [100, 100, 50] } else { [137, 89, 50] };
    for (name, codes) in
        [("green.png", [100, 100, 50].repeat(64 * 64)), ("half.png", (0..64 * 64).flat_map(half).collect())]
    {
        png(&pictures.at(name), [64; 2], png::ColorType::Rgb, &codes, |_| {});
    }
    let line = pictures.said("compare half.png green.png --window 2 --transfer linear");
    assert!(line.starts_with("half.png: 0.00") && line.contains("(luminance only; "), "{line}");
    let rgba: Vec<u8> = (0..64 * 64).map(waves(64, 0)).flat_map(|code| [code, code, code, 255]).collect();
    png(&pictures.at("rgba.png"), [64; 2], png::ColorType::Rgba, &rgba, |_| {});
    pictures.gray("gray.png", [64; 2], waves(64, 0));
    assert_eq!(times(&pictures.json("compare rgba.png gray.png --window 2 --json")), 0.0);
}

#[test]
fn steps_are_judged_without_a_reference() {
    let pictures = Pictures::new();
    for (name, range) in [("slow.png", 10.0), ("flat.png", 0.0)] {
        pictures.gray(name, [512, 64], |i| (118.0 + range * f64::from(i % 512) / 512.0) as u8);
    }
    let [wide, narrow] = [16, 1].map(|deg| pictures.json(&format!("compare slow.png --steps --window {deg} --json")));
    let number = |of: &Value, name: &str| of[name].as_f64().unwrap();
    assert!(number(&wide, "steps") > 1.0 && number(&wide, "steps") > 1.5 * number(&narrow, "steps"), "{wide} {narrow}");
    assert!(number(&wide, "dithered") < number(&wide, "steps"), "{wide}");
    assert_eq!(number(&pictures.json("compare flat.png --steps --window 8 --json"), "steps"), 0.0);
    // A picture of 16 bits has no visible steps, but in 8 bits it would.
    pictures.gray_16("fine.png", [512, 64], |i| (30_326 + 2570 * (i % 512) / 512) as u16, |_| {});
    let of_fine = pictures.json("compare fine.png --steps --window 16 --json");
    assert!(number(&of_fine, "steps") < 0.2, "{of_fine}");
    assert!((number(&of_fine, "rounded") / number(&wide, "steps") - 1.0).abs() < 0.1 && wide["rounded"].is_null());
    let line = pictures.said("compare fine.png --steps --window 16");
    assert!(line.contains("which is grain; keep 16 bits, or dither to 8 (--dither-out) ("), "{line}");
    // What is written is what was judged: its steps are gone.
    let line = pictures.said("compare slow.png --steps --window 16 --dither-out out.png");
    assert!(line.contains("or dither to 8"), "{line}");
    let line = pictures.said("compare slow.png --steps --ppd 30");
    assert!(line.contains("17.0667° wide"), "{line}");
    assert!(times(&pictures.json("compare out.png slow.png --window 16 --json")) > 0.5);
}

/// Coarse codes in a file of more bits are judged as what they are: as far from the smooth picture as they really are.
#[test]
fn steps_are_those_of_the_bits_that_codes_have() {
    let pictures = Pictures::new();
    let level = |i: u32, bits: u32| {
        ((60.0 + 140.0 * f64::from(i % 256) / 256.0) / 255.0 * f64::from((1 << bits) - 1)).round() as u16
    };
    let write = |name: &str, of: fn(u16) -> u16, bits: u32, prepare: &dyn Fn(&mut png::Info)| {
        pictures.gray_16(name, [256, 64], |i| of(level(i, bits)), prepare);
    };
    write("smooth.png", |level| level, 16, &|_| {});
    write("shifted.png", |level| level << 10, 6, &|_| {});
    write("repeated.png", |level| level << 10 | level << 4 | level >> 2, 6, &|_| {});
    write("scaled.png", |level| (f64::from(level) * 65535.0 / 63.0).round() as u16, 6, &|_| {});
    write("said.png", |level| level << 7, 9, &|info| info.sbit = Some(vec![9].into()));
    let nibbles: Vec<u8> = (0..128 * 64).map(|i| (level(2 * i, 4) << 4 | level(2 * i + 1, 4)) as u8).collect();
    let four = pictures.at("four.png");
    png(&four, [256, 64], png::ColorType::Grayscale, &nibbles, |info| info.bit_depth = png::BitDepth::Four);
    pictures.gray("seventeens.png", [256, 64], |i| 17 * level(i, 4) as u8);
    // The usual ways to write 8 bits as 16; few steps, each of them larger than the threshold.
    let slow = |i: u32| 30 + (i % 256 / 64) as u16;
    pictures.gray("slow.png", [256, 64], |i| slow(i) as u8);
    for (name, factor) in [("times257.png", 257), ("times256.png", 256)] {
        pictures.gray_16(name, [256, 64], |i| slow(i) * factor, |_| {});
        let [eight, sixteen] =
            ["slow.png", name].map(|name| pictures.run(&format!("compare {name} --steps --window 20 --json")));
        let [steps, found] = [&eight.0, &sixteen.0].map(|of| of["steps"].as_f64().unwrap());
        assert!(steps > 0.5 && (found / steps - 1.0).abs() < 0.05, "{eight:?} {sixteen:?}");
        assert!(sixteen.0["rounded"].is_null() && sixteen.1.contains("16 bits hold codes of 8 bits"), "{sixteen:?}");
    }
    for (name, bits, is_noted) in [
        ("shifted.png", 6, true),
        ("repeated.png", 6, true),
        ("scaled.png", 6, true),
        ("said.png", 9, true),
        ("four.png", 4, false),
        ("seventeens.png", 4, true),
    ] {
        let (found, said) = pictures.run(&format!("compare {name} --steps --window 30 --json"));
        let (truth, _) = pictures.run(&format!("compare {name} smooth.png --window 30 --json"));
        let ratio = found["steps"].as_f64().unwrap() / times(&truth);
        assert!((ratio - 1.0).abs() < 0.15 && found["bits"] == bits, "{name}: {ratio} {found}");
        assert_eq!(said.contains(&format!("bits hold codes of {bits} bits")), is_noted, "{name}: {said}");
    }
    let (smooth, _) = pictures.run("compare smooth.png --steps --window 30 --json");
    assert!(smooth["bits"] == 16 && smooth["steps"].as_f64().unwrap() < 0.1, "{smooth}");
}

/// Codes that are skipped evenly, as after posterizing, are steps as large as they are; colors that are only few are none.
#[test]
fn steps_are_those_between_the_codes_that_occur() {
    let pictures = Pictures::new();
    let ramp = |i: u32| 12.0 + 225.0 * f64::from(i % 512) / 512.0;
    pictures.gray("tens.png", [512, 64], |i| ((ramp(i) / 10.0).floor() * 10.0 + 4.0) as u8);
    pictures.gray_16("fine.png", [512, 64], |i| ((ramp(i) - 1.0) * 257.0).round() as u16, |_| {});
    pictures.gray("few.png", [512, 64], |i| [17, 30, 96, 133, 150, 201, 222, 255][(i % 512 / 64 * 5 % 8) as usize]);
    let steps = |name: &str| {
        let (found, _) = pictures.run(&format!("compare {name} --steps --window 30 --json"));
        found["steps"].as_f64().unwrap()
    };
    let (truth, _) = pictures.run("compare tens.png fine.png --window 30 --json");
    let [tens, few] = ["tens.png", "few.png"].map(steps);
    assert!((tens / times(&truth) - 1.0).abs() < 0.3 && few < 1.0, "{tens}, expected {truth}; {few}");
}

#[test]
fn impossible_comparisons_are_refused() {
    let pictures = Pictures::new();
    let at = |name: &str| pictures.at(name);
    let with = |name: &str, color: png::ColorType, codes: &[u8], prepare: fn(&mut png::Info)| {
        png(&at(name), [64; 2], color, codes, prepare);
    };
    let (gray, waves) = (png::ColorType::Grayscale, (0..64 * 64).map(waves(64, 0)).collect::<Vec<u8>>());
    with("gray.png", gray, &waves, |_| {});
    pictures.gray("wide.png", [65, 64], |_| 9);
    pictures.gray("black.png", [64; 2], |_| 0);
    with("alpha.png", png::ColorType::Rgba, &[128; 64 * 64 * 4], |_| {});
    with("profile.png", gray, &waves, |info| info.icc_profile = Some(b"no profile".as_slice().into()));
    with("palette.png", png::ColorType::Indexed, &[3; 64 * 64], |info| {
        info.palette = Some([0, 0, 0, 9, 9, 9].as_slice().into());
    });
    with("turned.png", gray, &waves, |info| {
        info.exif_metadata = Some(b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0".as_slice().into());
    });
    let file = fs::File::create(at("hdr.png")).unwrap();
    let mut writer = png::Encoder::with_info(file, png::Info::with_size(64, 64)).unwrap().write_header().unwrap();
    writer.write_chunk(png::chunk::cICP, &[9, 16, 0, 1]).unwrap();
    writer.write_image_data(&waves).unwrap();
    drop(writer);
    // What the curve of a profile says is not repaired; one number is an exponent, whichever it is.
    for (name, points) in [("falling.png", &[65535, 30000, 0][..]), ("power.png", &[461])] {
        let mut profile = moxcms::ColorProfile::new_gray_with_gamma(1.0);
        profile.gray_trc = Some(moxcms::ToneReprCurve::Lut(points.to_vec()));
        let profile = profile.encode().unwrap();
        png(&at(name), [64; 2], gray, &waves, |info| info.icc_profile = Some(profile.into()));
    }
    png(&at("gama.png"), [64; 2], gray, &waves, |info| info.source_gamma = Some(png::ScaledFloat::from_scaled(55_531)));
    let (same, _) = pictures.run("compare power.png gama.png --window 2 --json");
    assert!(times(&same) < 0.1, "{same}");
    fs::write(at("text.png"), "no picture").unwrap();
    with("colored.png", png::ColorType::Rgb, &[255, 0, 0].repeat(64 * 64), |_| {});
    ["empty", "one"].iter().for_each(|name| fs::create_dir(at(name)).unwrap());
    fs::copy(at("gray.png"), at("one/gray.png")).unwrap();
    let cases = r"
        1: gray.png wide.png --window 2 => gray.png: has 64 × 64 pixels, but wide.png has 65 × 64
        1: black.png gray.png --window 2 --black 0 => black.png: no light in column 0, row 0
        2: gray.png gray.png --window 2 --max=-1 => outside 0…1000000
        1: alpha.png gray.png --window 2 => transparent pixels
        1: profile.png gray.png --window 2 => has a color profile that is damaged
        1: hdr.png gray.png --window 2 => has a cICP chunk (primaries 9, transfer 16), which is not supported
        1: falling.png gray.png --window 2 => whose curve does not rise from 0 to 1
        1: palette.png gray.png --window 2 => has a pixel whose color is not in its palette
        1: turned.png gray.png --window 2 --transfer srgb => orientation 6 in its eXIf chunk
        1: text.png gray.png --window 2 => text.png: is not a PNG; expected a PNG
        2: gray.png gray.png --window 2 --mask black.png => black.png selects no pixel
        2: gray.png gray.png --window 2 --mask colored.png => colored.png has colors
        1: none.png gray.png --window 2 => none.png: cannot be opened
        1: empty empty --window 2 => contains no PNG
        2: gray.png gray.png => --window is missing; expected the width of the picture in degrees, or the option --ppd
        2: gray.png gray.png --window 2 --dither-out out.png => expected --steps
        1: gray.png gray.png --window 400 => degrees
        1: one one --window 2 --mask wide.png => error: --mask: wide.png has 65 × 64 pixels
        2: empty empty --window 2 --map map.png => --map";
    refuses(pictures.0.path(), "compare {}", cases);
    // A mask of one bit per pixel may have few bytes.
    pictures.gray("large.png", [1024; 2], |_| 9);
    png(&at("bits.png"), [1024; 2], gray, &[255; 128 * 1024], |info| info.bit_depth = png::BitDepth::One);
    pictures.said("compare large.png large.png --window 9 --mask bits.png");
    // The transfer function that the user gives makes a broken profile harmless.
    pictures.said("compare profile.png gray.png --window 2 --transfer srgb");
}

// Predictions.

fn column(table: &str, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let place = reader.headers().unwrap().iter().position(|header| header == name).expect(name);
    reader.records().map(|record| record.unwrap()[place].to_owned()).collect()
}

fn numbers(table: &str, name: &str) -> Vec<f64> {
    column(table, name).iter().map(|text| text.parse().unwrap()).collect()
}

#[test]
fn a_stimulus_and_a_definition_agree() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    let (one, all) = (run("predict --width 0.1"), run("predict bangay2003"));
    assert!(all.starts_with("width,depth,orientation_deg,band_bright,band_dark,detection\n"), "{all}");
    assert_eq!(all.lines().count(), 121);
    let found = all.lines().find(|line| line.starts_with("0.1,1,0,")).unwrap();
    let own = ["band_bright", "band_dark", "detection"].map(|name| column(&one, name).remove(0)).join(",");
    assert!(found.ends_with(&own), "{found} and {one}");
    // A rating is predicted only by a criterion.
    fs::write(folder.path().join("lab.toml"), "schema = 1\nthresholds = [0.5, 1.0, 2.0]\nspread = 0.5\n").unwrap();
    let rated = run("predict bangay2003 --criterion lab.toml");
    assert!(numbers(&rated, "predicted_rating").iter().all(|rating| (0.0..=3.0).contains(rating)));
    let strongest = numbers(&rated, "band_bright").into_iter().zip(numbers(&rated, "predicted_rating"));
    let strongest = strongest.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    assert!(strongest.0 > 2.0 && strongest.1 > 1.5, "{strongest:?}");
    // Stimuli without a smooth reference have no bands, but can be detected; a mesh differs from its surface.
    let other = run("predict --kind kanizsa");
    assert_eq!([column(&other, "band_bright"), column(&other, "difference")], [[""], [""]]);
    assert!(numbers(&other, "detection")[0] > 1.0);
    let mesh = run("predict --kind shaded-mesh --shader gouraud");
    assert!(numbers(&mesh, "difference")[0] > 1.0 && column(&mesh, "band_bright") == [""], "{mesh}");
    let brighter = run("predict --width 0.1 --white 500 --black 0");
    assert_ne!(column(&brighter, "band_dark"), column(&one, "band_dark"));
    let other = format!(
        "schema = 1\nname = \"{0}\"\ntitle = \"Stairs\"\n[stimulus]\nkind = \"{0}\"\n[factors]\nsteps = [3, 5]\n[viewing]\ndistance_cm = 50.0\nwindow_deg = 10.0\n",
        "chevreul"
    );
    fs::write(folder.path().join("other.toml"), other).unwrap();
    let refused =
        fails(folder.path(), &split("simulate other.toml --observer vision --participants 1 --results none"), 1);
    assert!(refused.contains("expected a mach-band, or a mesh whose smooth surface is known"), "{refused}");
}

/// Fitting simulated ratings recovers the thresholds of the simulated observer.
#[test]
fn a_criterion_is_recovered_from_ratings() {
    let folder = tempfile::tempdir().unwrap();
    let known = "schema = 1\nthresholds = [0.4, 0.8, 1.6]\nspread = 0.5\nsubject_sd = 0.0\nlapse = 0.0\n";
    fs::write(folder.path().join("known.toml"), known).unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    run("simulate bangay2003 --participants 20 --observer vision --observer-file known.toml");
    let output = run("predict bangay2003 --fit results/bangay2003 --criterion found.toml --out predicted.csv");
    let found: toml::Table = fs::read_to_string(folder.path().join("found.toml")).unwrap().parse().unwrap();
    let thresholds: Vec<f64> = found["thresholds"].as_array().unwrap().iter().map(|t| t.as_float().unwrap()).collect();
    for (found, known) in thresholds.iter().zip([0.4_f64, 0.8, 1.6]) {
        assert!((found / known).ln().abs() < 0.08, "{found} for {known}");
    }
    let text = fs::read_to_string(folder.path().join("found.toml")).unwrap();
    assert!(
        text.starts_with("# approximate 95 % intervals") && text.contains("of 20 simulated participants"),
        "{text}"
    );
    assert!((found["spread"].as_float().unwrap() / 0.5 - 1.0).abs() < 0.1, "{found}");
    let rho = output.lines().find(|line| line.starts_with("rank correlation")).unwrap();
    assert!(rho.rsplit(' ').next().unwrap().parse::<f64>().unwrap() > 0.95, "{output}");
    assert_eq!(fs::read_to_string(folder.path().join("predicted.csv")).unwrap().lines().count(), 121);
}

/// A prediction that is compared with ratings is that for the mean of the widths that people saw.
#[test]
fn the_window_is_as_wide_as_people_saw_it() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("simulate quick --participants 8 --seed 5"));
    for (subject, stimulus_deg) in [("S001", 4.0), ("S002", 5.0)] {
        let path = session_csv(&folder.path().join("results"), "quick", subject).with_extension("json");
        let mut sidecar = json(&path);
        let viewing = Geometry { stimulus_deg, ..Geometry::default() };
        sidecar["sittings"][0]["viewing"] = serde_json::to_value(viewing).unwrap();
        fs::write(&path, sidecar.to_string()).unwrap();
    }
    // A warning says that the sidecars were changed.
    let output = machband(folder.path(), &split("predict quick --fit results --out seen.csv"));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let seen = fs::read_to_string(folder.path().join("seen.csv")).unwrap();
    let narrow = succeeds(folder.path(), &split("predict quick --window 4.5"));
    assert_eq!(column(&seen, "band_bright"), column(&narrow, "band_bright"));
}

#[test]
fn impossible_predictions_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    // The same factors, but another stimulus.
    let gray = definition::BUILT_IN.iter().find(|one| one.name == "quick").unwrap().text.replace("yellow", "gray");
    fs::write(folder.path().join("gray.toml"), gray.replace("\"quick\"", "\"gray\"")).unwrap();
    succeeds(folder.path(), &split("simulate quick --participants 2"));
    let cases = r"
        2: gray.toml --fit results/quick => those of quick; expected those of gray
        2: --window 361 => --window: the image extends over 361
        2: --window 1e-6 => --window: 1.024e9 pixels per degree; expected a number above 0 and at most 2000000
        2: --ppd 1e9 => --ppd: 1e9 pixels per degree
        2: --kind kanizsa --size 5000 => too large
        1: bangay2003 --fit nowhere => nowhere
        1: --low 0 --high 0 --black 0 => mach-band:
        1: --criterion none.toml => none.toml";
    refuses(folder.path(), "predict {}", cases);
    succeeds(folder.path(), &split("predict --width 0.2 --window 359"));
}

/// What the table of a study's own pictures says is a level as it is written, and sessions know their pictures by hashes.
#[test]
fn own_pictures_have_levels_and_hashes() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    fs::create_dir(folder.path().join("p")).unwrap();
    for name in ["a", "b", "c"] {
        run(&format!("stimulus --kind cornsweet --size 32 --out p/{name}.png"));
    }
    fs::write(folder.path().join("p/pictures.csv"), "file,code\na.png,007\nb.png,7\nc.png,7.0\n").unwrap();
    let definition = "schema = 1\nname = \"own\"\n[stimulus]\nkind = \"image\"\nfiles = \"p/*.png\"\n";
    fs::write(folder.path().join("own.toml"), definition).unwrap();
    assert_eq!(column(&run("predict own.toml"), "code"), ["007", "7", "7.0"]);
    run("simulate own.toml --participants 4 --results r");
    assert!(run("verify r").contains("4 sessions verified; no errors"));
    run("stimulus --kind cornsweet --size 64 --out p/a.png --force");
    let error = fails(folder.path(), &split("predict own.toml --fit r"), 2);
    assert!(error.contains("those of own in another version; expected those of own"), "{error}");
}
