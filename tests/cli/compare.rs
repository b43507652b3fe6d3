//! `machband compare`, run as a user runs it: what it prints, what it refuses, and what pictures of other programs mean.

use std::{fs, path::Path};

use serde_json::Value;

use crate::common::{fails, machband, split, succeeds, text};

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

/// Codes of a gray picture with soft waves; `change` is added to the pixels of a square in the middle.
fn waves(side: u32, change: i16) -> Vec<u8> {
    let code = |i: u32| {
        let (x, y) = (f64::from(i % side), f64::from(i / side));
        let wave = 120.0 + 40.0 * (x / 17.0).sin() * (y / 23.0).cos();
        let near = |at: f64| (at - 0.5 * f64::from(side)).abs() < 0.1 * f64::from(side);
        wave as i16 + if near(x) && near(y) { change } else { 0 }
    };
    (0..side * side).map(|i| code(i) as u8).collect()
}

#[test]
fn the_difference_decides_about_the_exit_status() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let gray = |name: &str, change: i16| {
        png(&at(name), [128; 2], png::ColorType::Grayscale, &waves(128, change), |_| {});
    };
    for (name, change) in [("same.png", 0), ("truth.png", 0), ("small.png", 2), ("large.png", 12)] {
        gray(name, change);
    }
    let run = |line: &str| succeeds(folder.path(), &split(line));
    let json = |line: &str| -> Value { serde_json::from_str(&run(line)).unwrap() };
    let same = json("compare same.png truth.png --window 4 --max 0 --json");
    assert_eq!((same["times_threshold"].as_f64(), same["places"].as_array().unwrap().len()), (Some(0.0), 0), "{same}");
    let [small, large] =
        ["small", "large"].map(|name| json(&format!("compare {name}.png truth.png --window 4 --json")));
    let times = |of: &Value| of["times_threshold"].as_f64().unwrap();
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
    let line = run("compare large.png truth.png --ppd 32 --map map.png");
    assert!(line.starts_with(&format!("large.png: {:.3} times threshold", times(&large))), "{line}");
    let map = png::Decoder::new(std::io::BufReader::new(fs::File::open(at("map.png")).unwrap())).read_info().unwrap();
    assert_eq!((map.info().width, map.info().height), (128, 128));
    let status = |words: &str| machband(folder.path(), &split(words)).status.code();
    assert_eq!(status("compare large.png truth.png --window 4 --max 0.5"), Some(1));
    assert_eq!(status(&format!("compare large.png truth.png --window 4 --max {}", times(&large) + 0.01)), Some(0));
    // Where three decimals would say that the difference is the maximum, there are more.
    let just_below = times(&large) - 1e-7;
    let above = machband(folder.path(), &split(&format!("compare large.png truth.png --window 4 --max {just_below}")));
    let error = text(&above.stderr);
    let shown: f64 = error.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!(shown > just_below && just_below > times(&large) - 1e-6, "{just_below}: {error}");
    // What a mask leaves out does not count.
    let mask: Vec<u8> = (0..128 * 128).map(|i| if i % 128 < 20 { 255 } else { 0 }).collect();
    png(&at("mask.png"), [128; 2], png::ColorType::Grayscale, &mask, |_| {});
    let masked = json("compare large.png truth.png --window 4 --mask mask.png --json");
    assert_eq!(times(&masked), 0.0, "{masked}");
    assert_eq!(masked["color_ignored"], false);
    // Gray and a color of its luminance: nothing is judged, and a warning says so.
    let flat = |name: &str, code: [u8; 3]| png(&at(name), [64; 2], png::ColorType::Rgb, &code.repeat(64 * 64), |_| {});
    flat("gray.png", [128; 3]);
    flat("green.png", [60, 149, 110]);
    let green = machband(folder.path(), &split("compare green.png gray.png --window 4 --json --junit out.xml"));
    let found: Value = serde_json::from_str(&text(&green.stdout)).unwrap();
    assert!(found["color_ignored"] == true && times(&found) < 0.1, "{found}");
    let warning = "the pictures differ in color at equal luminance, which is not judged";
    assert!(text(&green.stderr).contains(warning) && fs::read_to_string(at("out.xml")).unwrap().contains(warning));
}

#[test]
fn folders_are_compared_in_pairs() {
    let folder = tempfile::tempdir().unwrap();
    for (name, change) in [("new/a.png", 0), ("new/b & c.png", 9), ("old/a.png", 0), ("old/b & c.png", 0)] {
        fs::create_dir_all(folder.path().join(name).parent().unwrap()).unwrap();
        png(&folder.path().join(name), [96; 2], png::ColorType::Grayscale, &waves(96, change), |_| {});
    }
    let all: Value =
        serde_json::from_str(&succeeds(folder.path(), &split("compare new old --window 3 --json"))).unwrap();
    assert_eq!(all.as_array().unwrap().len(), 2);
    assert_eq!(all[0]["times_threshold"], 0.0);
    let one: Value = serde_json::from_str(&succeeds(
        folder.path(),
        &["compare", "new/b & c.png", "old/b & c.png", "--window", "3", "--json"],
    ))
    .unwrap();
    assert_eq!(all[1]["times_threshold"], one["times_threshold"]);
    let above = machband(folder.path(), &split("compare new old --window 3 --max 0.1 --junit out.xml"));
    let errors = text(&above.stderr);
    assert_eq!(above.status.code(), Some(1));
    assert!(errors.starts_with("error: b & c.png: ") && errors.contains("expected at most 0.1"), "{errors}");
    let xml = fs::read_to_string(folder.path().join("out.xml")).unwrap();
    assert!(xml.contains("tests=\"2\" failures=\"1\" errors=\"0\"") && xml.contains("b &amp; c.png"), "{xml}");
    // A picture without a counterpart, and one that cannot be read, are no successes.
    png(&folder.path().join("new/d.png"), [96; 2], png::ColorType::Grayscale, &waves(96, 0), |_| {});
    let mixed = machband(folder.path(), &split("compare new old --window 3 --junit lacks.xml"));
    let error = text(&mixed.stderr);
    assert!(mixed.status.code() == Some(1) && text(&mixed.stdout).lines().count() == 2, "{error}");
    let xml = fs::read_to_string(folder.path().join("lacks.xml")).unwrap();
    assert!(error.contains("old: lacks d.png") && xml.contains("old: lacks d.png"), "{error} {xml}");
    assert!(xml.contains("tests=\"3\" failures=\"0\" errors=\"1\""), "{xml}");
    fs::create_dir(folder.path().join("empty")).unwrap();
    fails(folder.path(), &split("compare empty empty --window 3 --junit empty.xml"), 1);
    let xml = fs::read_to_string(folder.path().join("empty.xml")).unwrap();
    assert!(xml.contains("errors=\"1\"") && xml.contains("contains no PNG"), "{xml}");
    fs::write(folder.path().join("old/d.png"), "no picture").unwrap();
    let mixed = machband(folder.path(), &split("compare new old --window 3"));
    let errors = text(&mixed.stderr);
    assert_eq!(mixed.status.code(), Some(1));
    assert!(errors.contains("old/d.png: is not a PNG; expected a PNG"), "{errors}");
    fails(folder.path(), &split("compare new/d.png old/d.png --window 3 --junit d.xml"), 1);
    let xml = fs::read_to_string(folder.path().join("d.xml")).unwrap();
    assert!(xml.contains("errors=\"1\"") && xml.contains("is not a PNG"), "{xml}");
    // What is left out is named.
    fs::create_dir(folder.path().join("new/more")).unwrap();
    fs::write(folder.path().join("new/e.jpg"), b"\xff\xd8\xff").unwrap();
    let errors = text(&machband(folder.path(), &split("compare new old --window 3")).stderr);
    assert!(errors.contains("warning: new: only PNG files are compared, not e.jpg, more"), "{errors}");
    assert_eq!(text(&mixed.stdout).lines().count(), 2, "the other pairs are compared");
}

/// The light of a file is what its chunks say: profiles that machband writes, gray and colored, opaque alpha.
#[test]
fn pictures_mean_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    let json = |line: &str| -> Value { serde_json::from_str(&run(line)).unwrap() };
    let readings: String = (0..=10)
        .map(|k| {
            format!(
                "gray,{},{}\n",
                f64::from(k) / 10.0,
                0.3 + 80.0 * (f64::from(k) / 10.0).powf(1.5) + 40.0 * (f64::from(k) / 10.0).powi(5)
            )
        })
        .collect();
    fs::write(folder.path().join("readings.csv"), format!("channel,level,luminance_cd_m2\n{readings}")).unwrap();
    run("calibrate readings.csv --out profile.toml");
    for color in ["gray", "yellow"] {
        for (name, options) in [
            ("srgb", ""),
            ("linear", "--transfer linear"),
            ("gamma", "--transfer gamma:2.4"),
            ("icc", "--display profile.toml"),
        ] {
            run(&format!(
                "stimulus --width 0.1 --size 256 --bits 16 --color {color} {options} --out {color}-{name}.png"
            ));
        }
        // The same light in other codes is the same picture.
        for name in ["linear", "gamma", "icc"] {
            let found = json(&format!("compare {color}-{name}.png {color}-srgb.png --window 5 --json"));
            assert!(found["times_threshold"].as_f64().unwrap() < 0.1, "{color} {name}: {found}");
        }
        let light = json(&format!("compare {color}-icc.png {color}-icc.png --window 5 --json"));
        assert_eq!(light["light"], "by the file's iCCP chunk");
    }
    // Primaries may come with an exponent or alone. These are sRGB's in another order.
    let ramp: Vec<u8> = (0..64 * 64).flat_map(|i| [40, 200 - (i % 64) as u8, 90]).collect();
    let turned: Vec<u8> = ramp.chunks_exact(3).flat_map(|pixel| [pixel[1], pixel[0], pixel[2]]).collect();
    let pair = |[x, y]: [u32; 2]| (png::ScaledFloat::from_scaled(x), png::ScaledFloat::from_scaled(y));
    let primaries = png::SourceChromaticities {
        white: pair([31_270, 32_900]),
        red: pair([30_000, 60_000]),
        green: pair([64_000, 33_000]),
        blue: pair([15_000, 6_000]),
    };
    for (name, gamma, said) in
        [("alone", None, "cHRM (with sRGB's curve)"), ("both", Some(45_455), "gAMA (with its cHRM)")]
    {
        let files = [format!("{name}-turned.png"), format!("{name}.png")];
        for (file, codes, primaries) in [(&files[0], &turned, Some(primaries)), (&files[1], &ramp, None)] {
            png(&folder.path().join(file), [64; 2], png::ColorType::Rgb, codes, |info| {
                info.source_chromaticities = primaries;
                info.source_gamma = gamma.map(png::ScaledFloat::from_scaled);
            });
        }
        let line = format!("compare {} {} --window 2 --json", files[0], files[1]);
        let found: Value = serde_json::from_str(&text(&machband(folder.path(), &split(&line)).stdout)).unwrap();
        assert!(found["times_threshold"].as_f64().unwrap() < 0.01 && found["color_ignored"].is_null(), "{found}");
        assert!(found["light"].as_str().unwrap().contains(said), "{found}");
    }
    // A profile of the display says how bright its channels are.
    let profile = "schema = 1\nname = \"turned\"\ntransfer = \"srgb\"\n[primaries]\nred = [0.3, 0.6]\ngreen = [0.64, 0.33]\n\
        blue = [0.15, 0.06]\nwhite = [0.3127, 0.329]\n";
    fs::write(folder.path().join("turned.toml"), profile).unwrap();
    let redder: Vec<u8> =
        ramp.chunks_exact(3).enumerate().flat_map(|(i, of)| [of[0] + (i % 64 / 32 * 30) as u8, of[1], of[2]]).collect();
    png(&folder.path().join("redder.png"), [64; 2], png::ColorType::Rgb, &redder, |_| {});
    let [own, turned] = ["--transfer srgb", "--display turned.toml"].map(|option| {
        let found = machband(folder.path(), &split(&format!("compare redder.png both.png --window 2 --json {option}")));
        serde_json::from_slice::<Value>(&found.stdout).unwrap()["times_threshold"].as_f64().unwrap()
    });
    assert!(turned > 1.5 * own, "{turned}, expected much more than {own}");
    // An option has precedence.
    let line = "compare gray-linear.png gray-srgb.png --window 5 --transfer gamma:3 --json";
    let other: Value = serde_json::from_str(&text(&machband(folder.path(), &split(line)).stdout)).unwrap();
    assert!(other["times_threshold"].as_f64().unwrap() > 3.0, "{other}");
    let gray = waves(64, 0);
    let rgba: Vec<u8> = gray.iter().flat_map(|code| [*code, *code, *code, 255]).collect();
    png(&folder.path().join("rgba.png"), [64; 2], png::ColorType::Rgba, &rgba, |_| {});
    png(&folder.path().join("gray.png"), [64; 2], png::ColorType::Grayscale, &gray, |_| {});
    let found = json("compare rgba.png gray.png --window 2 --json");
    assert_eq!(found["times_threshold"], 0.0);
}

#[test]
fn steps_are_judged_without_a_reference() {
    let folder = tempfile::tempdir().unwrap();
    let codes =
        |codes: f64| -> Vec<u8> { (0..512 * 64).map(|i| (118.0 + codes * f64::from(i % 512) / 512.0) as u8).collect() };
    for (name, range) in [("slow.png", 10.0), ("flat.png", 0.0)] {
        png(&folder.path().join(name), [512, 64], png::ColorType::Grayscale, &codes(range), |_| {});
    }
    let run = |line: &str| succeeds(folder.path(), &split(line));
    let json = |line: &str| -> Value { serde_json::from_str(&run(line)).unwrap() };
    let [wide, narrow] = [16, 1].map(|deg| json(&format!("compare slow.png --steps --window {deg} --json")));
    let number = |of: &Value, name: &str| of[name].as_f64().unwrap();
    assert!(number(&wide, "steps") > 1.0 && number(&wide, "steps") > 1.5 * number(&narrow, "steps"), "{wide} {narrow}");
    assert!(number(&wide, "dithered") < number(&wide, "steps"), "{wide}");
    assert_eq!(number(&json("compare flat.png --steps --window 8 --json"), "steps"), 0.0);
    // A picture of 16 bits has no visible steps, but in 8 bits it would.
    let fine: Vec<u8> = (0..512 * 64).flat_map(|i| ((30_326 + 2570 * (i % 512) / 512) as u16).to_be_bytes()).collect();
    png(&folder.path().join("fine.png"), [512, 64], png::ColorType::Grayscale, &fine, |info| {
        info.bit_depth = png::BitDepth::Sixteen;
    });
    let of_fine = json("compare fine.png --steps --window 16 --json");
    assert!(number(&of_fine, "steps") < 0.2, "{of_fine}");
    assert!((number(&of_fine, "rounded") / number(&wide, "steps") - 1.0).abs() < 0.1 && wide["rounded"].is_null());
    // What is written is what was judged: its steps are gone.
    let line = run("compare slow.png --steps --window 16 --dither-out out.png");
    assert!(line.contains("or dither to 8"), "{line}");
    let line = run("compare slow.png --steps --ppd 30");
    assert!(line.contains("(17.0667° wide"), "{line}");
    let out = json("compare out.png slow.png --window 16 --json");
    assert!(number(&out, "times_threshold") > 0.5, "{out}");
}

/// Coarse codes in a file of more bits are judged as what they are: as far from the smooth picture as they really are.
#[test]
fn steps_are_those_of_the_bits_that_codes_have() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let level = |i: u32, bits: u32| {
        ((60.0 + 140.0 * f64::from(i % 256) / 256.0) / 255.0 * f64::from((1 << bits) - 1)).round() as u16
    };
    let write = |name: &str, of: fn(u16) -> u16, bits: u32, prepare: &dyn Fn(&mut png::Info)| {
        let codes: Vec<u8> = (0..256 * 64).flat_map(|i| of(level(i, bits)).to_be_bytes()).collect();
        png(&at(name), [256, 64], png::ColorType::Grayscale, &codes, |info| {
            info.bit_depth = png::BitDepth::Sixteen;
            prepare(info);
        });
    };
    write("smooth.png", |level| level, 16, &|_| {});
    write("shifted.png", |level| level << 10, 6, &|_| {});
    write("repeated.png", |level| level << 10 | level << 4 | level >> 2, 6, &|_| {});
    write("scaled.png", |level| (f64::from(level) * 65535.0 / 63.0).round() as u16, 6, &|_| {});
    write("said.png", |level| level << 7, 9, &|info| info.sbit = Some(vec![9].into()));
    let nibbles: Vec<u8> = (0..128 * 64).map(|i| (level(2 * i, 4) << 4 | level(2 * i + 1, 4)) as u8).collect();
    png(&at("four.png"), [256, 64], png::ColorType::Grayscale, &nibbles, |info| info.bit_depth = png::BitDepth::Four);
    let bytes: Vec<u8> = (0..256 * 64).map(|i| 17 * level(i, 4) as u8).collect();
    png(&at("seventeens.png"), [256, 64], png::ColorType::Grayscale, &bytes, |_| {});
    let run = |line: &str| -> (Value, String) {
        let output = machband(folder.path(), &split(line));
        (serde_json::from_slice(&output.stdout).unwrap(), text(&output.stderr))
    };
    for (name, bits, is_noted) in [
        ("shifted.png", 6, true),
        ("repeated.png", 6, true),
        ("scaled.png", 6, true),
        ("said.png", 9, true),
        ("four.png", 4, false),
        ("seventeens.png", 4, true),
    ] {
        let (found, said) = run(&format!("compare {name} --steps --window 30 --json"));
        let (truth, _) = run(&format!("compare {name} smooth.png --window 30 --json"));
        let ratio = found["steps"].as_f64().unwrap() / truth["times_threshold"].as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 0.15 && found["bits"] == bits, "{name}: {ratio} {found}");
        assert_eq!(said.contains(&format!("bits hold codes of {bits} bits")), is_noted, "{name}: {said}");
    }
    let (smooth, _) = run("compare smooth.png --steps --window 30 --json");
    assert!(smooth["bits"] == 16 && smooth["steps"].as_f64().unwrap() < 0.1, "{smooth}");
}

/// Codes that are skipped evenly, as after posterizing or stretching the contrast, are steps as large as they are; colors
/// that are only few are none.
#[test]
fn steps_are_those_between_the_codes_that_occur() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let ramp = |i: u32| 12.0 + 225.0 * f64::from(i % 512) / 512.0;
    let gray = |name: &str, code: &dyn Fn(u32) -> f64| {
        let codes: Vec<u8> = (0..512 * 64).map(|i| code(i).clamp(0.0, 255.0) as u8).collect();
        png(&at(name), [512, 64], png::ColorType::Grayscale, &codes, |_| {});
    };
    let run = |line: &str| -> (Value, String) {
        let output = machband(folder.path(), &split(line));
        (serde_json::from_slice(&output.stdout).unwrap(), text(&output.stderr))
    };
    // What is rounded, what the codes become, and what they stand for.
    type Code = Box<dyn Fn(f64) -> f64>;
    let mut cases: Vec<(String, Code, Code)> = [2.0, 3.0, 5.0, 10.0, 16.0, 32.0]
        .map(|by: f64| -> (String, Code, Code) {
            let code = move |value: f64| (value / by).floor() * by + ((by - 1.0) / 2.0).floor();
            (format!("by{by}"), Box::new(code), Box::new(move |value| value - by / 2.0 + ((by - 1.0) / 2.0).floor()))
        })
        .into();
    let stretched = |value: f64| ((value.floor() - 60.0) * 1.7).round();
    cases.push(("stretched".to_owned(), Box::new(stretched), Box::new(|value| (value - 60.5) * 1.7)));
    for (name, code, truth) in &cases {
        gray(&format!("{name}.png"), &|i| code(ramp(i)));
        let fine = |i: u32| ((truth(ramp(i)).clamp(0.0, 255.0) * 257.0).round() as u16).to_be_bytes();
        let codes: Vec<u8> = (0..512 * 64).flat_map(fine).collect();
        png(&at("fine.png"), [512, 64], png::ColorType::Grayscale, &codes, |info| {
            info.bit_depth = png::BitDepth::Sixteen;
        });
        let (found, said) = run(&format!("compare {name}.png --steps --window 30 --json"));
        let (truth, _) = run(&format!("compare {name}.png fine.png --window 30 --json"));
        let [steps, truth] = [&found["steps"], &truth["times_threshold"]].map(|of| of.as_f64().unwrap());
        assert!((steps / truth - 1.0).abs() < 0.3, "{name}: {steps}, expected {truth}");
        assert!(
            said.contains("its codes skip values") || said.contains("hold codes of") || name == "stretched",
            "{name}: {said}"
        );
    }
    // Text of many codes over a part does not hide steps.
    gray("over.png", &|i| match (i % 512, i / 512) {
        (x, ..8) if x % 5 == 0 => f64::from(i * 37 % 251),
        _ => (ramp(i) / 10.0).floor() * 10.0 + 4.0,
    });
    let [over, alone] = ["over.png", "by10.png"].map(|name| {
        let (found, said) = run(&format!("compare {name} --steps --window 30 --json"));
        assert!(said.contains("its codes skip values"), "{name}: {said}");
        found["steps"].as_f64().unwrap()
    });
    assert!(over > 0.7 * alone, "{over}, expected about {alone}");
    // Few levels may be colors: nothing is said about the steps between them.
    gray("few.png", &|i| f64::from(112 + i % 512 / 128 * 4));
    let few = machband(folder.path(), &split("compare few.png --steps --window 30"));
    assert!(!text(&few.stdout).contains("no dither") && text(&few.stderr).contains("not judged"), "{few:?}");
    let colors = [17.0, 30.0, 96.0, 133.0, 150.0, 201.0, 222.0, 255.0];
    gray("flat.png", &|i| colors[(i % 512 / 64 * 5 % 8) as usize]);
    // Letters of two codes with soft edges.
    gray("text.png", &|i| match (i % 512 + i / 512) % 16 {
        0 => 30.0,
        1 => 90.0 + f64::from(i / 512 % 3) * 41.0,
        _ => 240.0,
    });
    let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 24) / 64.0;
    gray("noisy.png", &|i| 110.0 + 20.0 * f64::from(i % 512) / 512.0 + noise(i));
    // The web's colors are evenly spaced, but are no steps of a ramp.
    gray("web.png", &|i| (noise(i % 512 / 32 + i / 512 / 16 * 16) * 64.0 % 6.0) * 51.0);
    for (name, most) in [("flat", 1.0), ("text", 1.0), ("noisy", 3.0), ("web", 20.0)] {
        let (found, said) = run(&format!("compare {name}.png --steps --window 30 --json"));
        assert!(found["steps"].as_f64().unwrap() < most && !said.contains("skip"), "{name}: {found} {said}");
    }
}

#[test]
fn impossible_comparisons_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    png(&at("gray.png"), [64; 2], png::ColorType::Grayscale, &waves(64, 0), |_| {});
    png(&at("wide.png"), [65, 64], png::ColorType::Grayscale, &[9; 65 * 64], |_| {});
    png(&at("black.png"), [64; 2], png::ColorType::Grayscale, &[0; 64 * 64], |_| {});
    png(&at("alpha.png"), [64; 2], png::ColorType::Rgba, &[128; 64 * 64 * 4], |_| {});
    png(&at("profile.png"), [64; 2], png::ColorType::Grayscale, &waves(64, 0), |info| {
        info.icc_profile = Some(b"no profile".as_slice().into());
    });
    png(&at("palette.png"), [64; 2], png::ColorType::Indexed, &[3; 64 * 64], |info| {
        info.palette = Some([0, 0, 0, 9, 9, 9].as_slice().into());
    });
    png(&at("turned.png"), [64; 2], png::ColorType::Grayscale, &waves(64, 0), |info| {
        info.exif_metadata = Some(b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0".as_slice().into());
    });
    fs::write(at("text.png"), "no picture").unwrap();
    fs::write(at("photo.png"), b"\xff\xd8\xff\xe0").unwrap();
    png(&at("colored.png"), [64; 2], png::ColorType::Rgb, &[255, 0, 0].repeat(64 * 64), |_| {});
    fs::create_dir(at("empty")).unwrap();
    for (line, status, part) in [
        ("compare gray.png wide.png --window 2", 1, "gray.png: has 64 × 64 pixels, but wide.png has 65 × 64"),
        ("compare black.png gray.png --window 2 --black 0", 1, "black.png: no light in column 0, row 0"),
        ("compare alpha.png gray.png --window 2", 1, "transparent pixels"),
        ("compare profile.png gray.png --window 2", 1, "has a color profile that is damaged"),
        ("compare palette.png gray.png --window 2", 1, "has a pixel of color 3, but its palette has 2"),
        ("compare turned.png gray.png --window 2 --transfer srgb", 1, "orientation 6 in its eXIf chunk"),
        ("compare text.png gray.png --window 2", 1, "text.png: is not a PNG; expected a PNG"),
        ("compare photo.png gray.png --window 2", 1, "photo.png: is a JPEG; expected a PNG"),
        ("compare gray.png gray.png --window 2 --mask black.png", 2, "black.png selects no pixel"),
        ("compare gray.png gray.png --window 2 --mask colored.png", 2, "colored.png has colors"),
        ("compare none.png gray.png --window 2", 1, "none.png: cannot be opened"),
        ("compare empty empty --window 2", 1, "contains no PNG"),
        ("compare gray.png gray.png", 2, "--window"),
        ("compare gray.png --window 2", 2, "REFERENCE"),
        ("compare gray.png gray.png --steps --window 2", 2, "--steps"),
        ("compare gray.png gray.png --window 2 --dither-out out.png", 2, "--dither-out"),
        ("compare gray.png gray.png --window=-1", 2, "--window"),
        ("compare gray.png gray.png --window 400", 1, "degrees"),
        ("compare gray.png gray.png --window 2 --mask wide.png", 2, "--mask"),
        ("compare empty empty --window 2 --map map.png", 2, "--map"),
    ] {
        let error = fails(folder.path(), &split(line), status);
        assert!(error.contains(part), "{line}: {error}");
    }
    // The transfer function that the user gives makes a broken profile harmless.
    succeeds(folder.path(), &split("compare profile.png gray.png --window 2 --transfer srgb"));
}

/// What a color profile says is not repaired, and a damaged chunk is no absent one; outputs keep what codes mean, and no
/// picture in a folder is an output.
#[test]
fn what_codes_mean_is_kept_and_never_guessed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let profile = |change: &dyn Fn(&mut moxcms::ColorProfile)| {
        let mut profile = moxcms::ColorProfile::new_srgb();
        profile.cicp = None;
        change(&mut profile);
        profile.encode().unwrap()
    };
    let curve = |points: &[u16]| Some(moxcms::ToneReprCurve::Lut(points.to_vec()));
    let colors: Vec<u8> =
        (0..64 * 64).flat_map(|i| [(i * 7 % 256) as u8, (i * 13 % 256) as u8, (i / 16) as u8]).collect();
    let with = |name: &str, icc: Option<Vec<u8>>| {
        png(&at(name), [64; 2], png::ColorType::Rgb, &colors, |info| info.icc_profile = icc.map(Into::into));
    };
    with("none.png", None);
    with("srgb.png", Some(profile(&|_| {})));
    with("falling.png", Some(profile(&|of| of.green_trc = curve(&[65535, 30000, 0]))));
    with("dark.png", Some(profile(&|of| of.red_trc = curve(&[0, 10000, 30000]))));
    // One number is an exponent, whichever it is.
    for gamma in [265, 461, 512, 563, 800] {
        with(
            "gamma.png",
            Some(profile(&|of| {
                (of.red_trc, of.green_trc, of.blue_trc) = (curve(&[gamma]), curve(&[gamma]), curve(&[gamma]));
            })),
        );
        let line = format!("compare gamma.png none.png --window 4 --transfer gamma:{}", f64::from(gamma) / 256.0);
        let [own, given] =
            ["compare gamma.png gamma.png --window 4 --json", &line].map(|line| succeeds(folder.path(), &split(line)));
        assert!(own.contains("iCCP") && given.contains("as asked"), "{own} {given}");
    }
    // The profile of sRGB means what sRGB means, in blue too.
    let found = succeeds(folder.path(), &split("compare srgb.png none.png --window 4 --json"));
    let found: Value = serde_json::from_str(&found).unwrap();
    assert!(found["times_threshold"].as_f64().unwrap() < 0.1, "{found}");
    for name in ["falling.png", "dark.png"] {
        let error = fails(folder.path(), &["compare", name, "none.png", "--window", "4"], 1);
        assert!(error.contains("whose curve does not rise from 0 to 1"), "{name}: {error}");
    }
    let mut bytes = fs::read(at("srgb.png")).unwrap();
    let place = bytes.windows(4).position(|window| window == b"iCCP").unwrap();
    bytes[place + 20] ^= 0xff;
    fs::write(at("damaged.png"), bytes).unwrap();
    let error = fails(folder.path(), &split("compare damaged.png none.png --window 4"), 1);
    assert!(error.contains("damaged iCCP chunk") || error.contains("not a complete PNG"), "{error}");
    // Dither for linear codes writes linear codes.
    let slow: Vec<u8> = (0..96 * 96).map(|i| 40 + (i % 96 / 12) as u8).collect();
    png(&at("linear.png"), [96; 2], png::ColorType::Grayscale, &slow, |info| {
        info.source_gamma = Some(png::ScaledFloat::from_scaled(100_000));
    });
    succeeds(folder.path(), &split("compare linear.png --steps --window 8 --dither-out out.png"));
    let found = succeeds(folder.path(), &split("compare out.png linear.png --window 8 --json"));
    let found: Value = serde_json::from_str(&found).unwrap();
    let ratio = found["mean_ratio"].as_f64().unwrap();
    assert!((ratio - 1.0).abs() < 0.02 && found["light"] == "by the file's gAMA chunk", "{found}");
    // Codes for other primaries are not written as sRGB's.
    png(&at("wide.png"), [96; 2], png::ColorType::Grayscale, &slow, |info| {
        let xy = |x, y| (png::ScaledFloat::from_scaled(x), png::ScaledFloat::from_scaled(y));
        info.source_chromaticities = Some(png::SourceChromaticities {
            white: xy(31_270, 32_900),
            red: xy(68_000, 32_000),
            green: xy(26_500, 69_000),
            blue: xy(15_000, 6_000),
        });
    });
    let error = fails(folder.path(), &split("compare wide.png --steps --window 8 --dither-out wide8.png"), 2);
    assert!(error.contains("--dither-out writes sRGB's primaries") && !at("wide8.png").exists(), "{error}");
    // The pictures of a folder are inputs; a brighter picture is said to be one.
    fs::create_dir_all(at("a")).unwrap();
    fs::copy(at("none.png"), at("a/none.png")).unwrap();
    let error = fails(folder.path(), &split("compare a a --window 4 --junit a/none.png --force"), 2);
    assert!(error.contains("is an input of this command"), "{error}");
    png(&at("bright.png"), [64; 2], png::ColorType::Grayscale, &[200; 64 * 64], |_| {});
    png(&at("dim.png"), [64; 2], png::ColorType::Grayscale, &[100; 64 * 64], |_| {});
    let said = machband(folder.path(), &split("compare bright.png dim.png --window 4"));
    assert!(said.status.success() && text(&said.stderr).starts_with("warning: bright.png: mean luminance +"));
    for (line, part) in [
        ("compare none.png --steps --window 4 --mask dim.png", "--mask"),
        ("compare none.png none.png --window 4 --white 1e306", "--white"),
        ("predict quick --low 0.1", "the definition determines the stimuli"),
    ] {
        assert!(fails(folder.path(), &split(line), 2).contains(part), "{line}");
    }
}

/// What is ignored, assumed or at fault is named: colors under rounded and other primaries, 8 bits in 16, the black picture.
#[test]
fn comparisons_say_what_they_rest_on() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let run = |line: &str| {
        let done = machband(folder.path(), &split(line));
        (serde_json::from_str::<Value>(&text(&done.stdout)).unwrap_or_default(), text(&done.stderr))
    };
    let flat = |name: &str, code: [u8; 3], green: u32| {
        png(&at(name), [64; 2], png::ColorType::Rgb, &code.repeat(64 * 64), |info| {
            let pair = |x, y| (png::ScaledFloat::from_scaled(x), png::ScaledFloat::from_scaled(y));
            info.source_chromaticities = (green > 0).then(|| png::SourceChromaticities {
                white: pair(31_270, 32_900),
                red: pair(64_000, 33_000),
                green: pair(30_000, green),
                blue: pair(15_000, 6_000),
            });
        });
    };
    flat("gray.png", [128; 3], 0);
    flat("stated.png", [60, 149, 110], 60_000);
    flat("other.png", [60, 149, 110], 69_000);
    let (found, said) = run("compare stated.png gray.png --window 4 --json");
    assert!(found["color_ignored"] == true && said.contains("differ in color"), "{found} {said}");
    let (found, said) = run("compare other.png gray.png --window 4 --json");
    assert!(found["color_ignored"].is_null() && said.contains("their colors are not compared"), "{found} {said}");

    let slow = |i: u16| 30 + i % 256 / 64;
    png(
        &at("slow.png"),
        [256, 64],
        png::ColorType::Grayscale,
        &(0..256 * 64).map(|i| slow(i) as u8).collect::<Vec<_>>(),
        |_| {},
    );
    let (eight, _) = run("compare slow.png --steps --window 20 --json");
    for (name, factor) in [("times257.png", 257), ("times256.png", 256)] {
        let codes: Vec<u8> = (0..256 * 64).flat_map(|i| (slow(i) * factor).to_be_bytes()).collect();
        png(&at(name), [256, 64], png::ColorType::Grayscale, &codes, |info| {
            info.bit_depth = png::BitDepth::Sixteen;
        });
        let (found, said) = run(&format!("compare {name} --steps --window 20 --json"));
        let [found_steps, steps] = [&found, &eight].map(|of| of["steps"].as_f64().unwrap());
        assert!(steps > 0.5 && (found_steps / steps - 1.0).abs() < 0.05, "{found} {eight}");
        assert!(found["rounded"].is_null() && said.contains("16 bits hold codes of 8 bits"), "{found} {said}");
    }

    png(&at("black.png"), [64; 2], png::ColorType::Grayscale, &[0; 64 * 64], |_| {});
    let (_, error) = run("compare gray.png black.png --window 4 --black 0");
    assert!(error.contains("black.png: no light in column 0, row 0"), "{error}");
    let (_, error) = run("compare gray.png gray.png --window 4 --max -1");
    assert!(error.contains("outside 0…1000000"), "{error}");
    fs::create_dir_all(at("new")).unwrap();
    fs::create_dir_all(at("old")).unwrap();
    for name in ["new/a.png", "old/a.png", "old/b.png"] {
        fs::copy(at("gray.png"), at(name)).unwrap();
    }
    fs::write(at("new/b.png"), "no picture").unwrap();
    let (found, _) = run("compare new old --window 4 --json");
    assert_eq!([&found[0]["picture"], &found[1]["picture"]], ["new/a.png", "new/b.png"]);
}
