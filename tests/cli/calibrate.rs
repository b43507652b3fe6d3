//! `machband calibrate`, and the files it reads and writes.

use machband::{
    display::{Channel, photometer::Reading},
    light::Transfer,
    store::{Writer, profile, readings},
};

use crate::common::{machband, refuses, split, succeeds, text};

/// Luminance ranges of red, green, blue and gray, in cd/m².
const RANGES: [f64; 4] = [25.0, 80.0, 10.0, 115.0];

/// Noise-free readings of a display with γ = 2.2 and a black of 0.3 cd/m².
fn good(levels: usize) -> Vec<Reading> {
    let one = |channel: usize, step: usize| {
        let level = step as f64 / (levels - 1) as f64;
        Reading { channel: Channel::ALL[channel], level, luminance_cd_m2: 0.3 + RANGES[channel] * level.powf(2.2) }
    };
    (0..4).flat_map(|channel| (0..levels).map(move |step| one(channel, step))).collect()
}

fn errors(text: &str) -> Vec<String> {
    readings::parse("r.csv", text).unwrap_err().0.iter().map(ToString::to_string).collect()
}

#[test]
fn calibrate_writes_a_profile() {
    let folder = tempfile::tempdir().unwrap();
    readings::write(&Writer::default(), &folder.path().join("r.csv"), &good(9)).unwrap();
    let measured = "--name Left --by AB --with LS-150 --on 2026-02-03";
    let line = format!("calibrate r.csv --out left.toml {measured}");
    let output = machband(folder.path(), &split(&line));
    // The measurement is old, so there is a warning.
    let (warned, output) = (text(&output.stderr), text(&output.stdout));
    assert!(warned.starts_with("warning: left.toml: ") && warned.lines().count() == 1, "{warned}");
    for part in [
        "gamma  green    2.2000",
        "Chosen: gamma, the simplest of the models",
        "gamma       0.00\n",
        "Additivity: gray differs from red + green + blue − 2 black by at most 0.00 %",
        "white 115.30",
        "wrote left.toml: Left (γ 2.200",
    ] {
        assert!(output.contains(part), "{part}: {output}");
    }
    // `check` recognizes both files.
    let checked = machband(folder.path(), &["check", "r.csv", "left.toml"]);
    let found = text(&checked.stdout);
    assert!(found.contains("36 photometer readings, red, green, blue, gray"), "{found}");
    assert!(checked.status.success() && found.contains("display profile Left (γ 2.200"), "{found}");
    let made = profile::open(&folder.path().join("left.toml")).unwrap();
    assert_eq!(made.name, "Left");
    let Some(Transfer::Gamma(gamma)) = made.transfers.uniform() else { panic!("{:?}", made.transfers) };
    assert!((gamma - 2.2).abs() < 1e-6);
    let light = made.luminance.unwrap();
    assert!((light.black_cd_m2 - 0.3).abs() < 1e-6 && (light.white_cd_m2 - 115.3).abs() < 1e-5);
    let measured = made.measured.unwrap();
    assert_eq!((measured.on.unwrap().to_string().as_str(), measured.by.as_deref()), ("2026-02-03", Some("AB")));
    refuses(
        folder.path(),
        "calibrate r.csv --out new.toml {}",
        "2: --on 2026-02-30 => is not a date; expected one such as 2026-01-31
         2: --name '' => is empty; expected a name",
    );
    // Request the table model.
    let output = succeeds(folder.path(), &split("calibrate r.csv --out left.toml --model table --force"));
    assert!(output.contains("replaced left.toml: left"), "{output}");
    assert!(output.contains("Chosen: table, as requested; ") && output.contains("best is gamma."), "{output}");
    assert!(profile::open(&folder.path().join("left.toml")).unwrap().transfers.has_table());
}

#[test]
fn every_error_in_a_file_has_its_line_and_column() {
    let found = errors("channel,level,luminance_cd_m2\nr,0,0.3\nviolet,half,1\nr,0.5,\n\ng,1,x\nr,1.5,20\n");
    assert_eq!(
        found,
        [
            "r.csv:3:1: channel \"violet\" is not known; expected r, g, b or gray",
            "r.csv:4:7: luminance_cd_m2 \"\" is not a number; expected one such as 0.5",
            "r.csv:6:5: luminance_cd_m2 \"x\" is not a number; expected one such as 0.5",
            "r.csv:7:3: level 1.5 is outside 0…1; expected the code divided by the largest code",
        ]
    );
    let found = errors("channel,level,luminance_cd_m2\nr,0,0.3\nr,1.5,20\nr,1,-2\nr,0.25,NaN\nr,0.75,100001\n");
    assert_eq!(found[3], "r.csv:6:8: luminance 100001 is not that of a screen; expected cd/m², 0 to 100000");
    assert_eq!(found.len(), 4, "{found:?}");
    assert!(
        found[0].starts_with("r.csv:3:3: level 1.5") && found[1].starts_with("r.csv:4:5: luminance -2"),
        "{found:?}"
    );
    assert!(errors("channel,code,cd\n")[0].starts_with("r.csv:1:1: the header lacks level, luminance_cd_m2"));
    assert!(errors("")[0].starts_with("r.csv:1:1: "));
    assert!(errors("channel,level,luminance_cd_m2\n")[0].contains("there are no readings"));
    assert!(
        errors("channel,level,luminance_cd_m2\nr,0,0.3\nr,128,2\nr,255,9\n")[0]
            .starts_with("r.csv:3:3: level 128 is outside")
    );
}

#[test]
fn tables_from_other_programs_are_read() {
    let mut text = "note;Luminance_cd_m2;level;channel\r\n".to_owned();
    for one in good(6) {
        let channel = one.channel.name().to_uppercase();
        text += &format!("\"a;b\";{};{};{channel}\r\n", one.luminance_cd_m2, one.level).replace('.', ",");
    }
    let read = readings::parse("r.csv", &format!("\u{feff}{text}")).unwrap();
    assert_eq!(read.all(), good(6));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/r.csv");
    readings::write(&Writer::default(), &path, read.all()).unwrap();
    assert_eq!(readings::open(&path).unwrap(), read);
}

/// ArgyllCMS writes black once for all channels, and luminances relative to white; PsychoPy writes levels up to 255. Both
/// give the readings that the same measurements have in our own table.
#[test]
fn readings_of_other_programs() {
    let luminance = |level: f64| 0.3 + 99.7 * level.powf(2.2);
    let levels: Vec<f64> = (0..=8).map(|index| f64::from(index) / 8.0).collect();
    let mut ti3 =
        "CTI3\n\nDEVICE_CLASS \"DISPLAY\"\nLUMINANCE_XYZ_CDM2 \"95.0 100.0 108.9\"\nNORMALIZED_TO_Y_100 \"YES\"\n\
        NUMBER_OF_FIELDS 7\nBEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z\nEND_DATA_FORMAT\n\
        NUMBER_OF_SETS 19\nBEGIN_DATA\n"
            .to_owned();
    for (index, level) in levels.iter().enumerate() {
        let (code, y) = (100.0 * level, luminance(*level));
        ti3 += &format!("{index} {code} {code} {code} 0 {y} 0\n");
        if index > 0 {
            ti3 += &format!("{index}r {code} 0 0 0 {} 0\n", 0.3 + 0.2 * (y - 0.3));
        }
    }
    ti3 += "98 0 100 0 41.2 70.3 1.9\n99 20 40 60 1 2 3\nEND_DATA\n";
    let found = readings::parse("screen.ti3", &ti3).unwrap();
    assert_eq!(readings::parse("screen.ti3", &format!("\u{feff}{ti3}")).unwrap(), found);
    let of = |channel: Channel| -> Vec<(f64, f64)> {
        let own = found.all().iter().filter(|reading| reading.channel == channel);
        own.map(|reading| (reading.level, reading.luminance_cd_m2)).collect()
    };
    let gray = of(Channel::Gray);
    assert_eq!(gray.len(), 9);
    for ((level, read), expected) in gray.iter().zip(levels[1..].iter().chain(&levels[..1])) {
        assert!((level - expected).abs() < 1e-12 && (read - luminance(*expected)).abs() < 1e-9, "{level} {read}");
    }
    assert!(of(Channel::Red).contains(&(0.0, luminance(0.0))), "black is black in every channel");
    assert!(of(Channel::Green).is_empty(), "one patch is no curve");

    let pre: Vec<f64> = levels.iter().map(|level| 255.0 * level).collect();
    let lums: Vec<f64> = levels.iter().map(|level| luminance(*level)).collect();
    let json = format!("{{\"2026_11_01\": {{\"levelsPre\": {pre:?}, \"lumsPre\": {{\"__ndarray__\": {lums:?}}}}}}}");
    let found = readings::parse("monitor.json", &json).unwrap();
    assert!(found.all().iter().map(|reading| reading.luminance_cd_m2).eq(lums));
    for (text, expected) in [
        (
            "CTI3\nNORMALIZED_TO_Y_100 \"YES\"\nBEGIN_DATA_FORMAT\nRGB_R RGB_G RGB_B XYZ_Y\nEND_DATA_FORMAT\nBEGIN_DATA\n0 0 0 1\nEND_DATA",
            "relative to white only",
        ),
        ("CTI3\nBEGIN_DATA_FORMAT\nRGB_R LAB_L\nEND_DATA_FORMAT\nBEGIN_DATA\n0 1\nEND_DATA", "has no field"),
        ("CGATS.17\n", "has no data"),
        (&ti3[..ti3.len() - "END_DATA\n".len()], "expected END_DATA"),
        (&ti3.replace("SETS 19", "SETS 20"), "has 19 rows of data; expected 20"),
        (&ti3.replace("SETS 19", "SETS 1g"), "has 19 rows of data; expected 1g"),
        (&ti3.replace("98 0 100 0", "98 0 1x 0"), "other:29:1: RGB_G \"1x\" is not a number"),
        ("{\"name\": {}}", "levelsPre"),
        ("{\"levelsPre\": [0, 255], \"lumsPre\": [[1, 9], [1, 3]]}", "the number of rows in lumsPre is 2"),
    ] {
        let told = readings::parse("other", text).unwrap_err().to_string();
        assert!(told.contains(expected), "{told}");
    }
}

/// A file that SciPy 1.16 wrote (`savemat`, compressed) with two calibrations as Psychtoolbox saves them. In the newest, the
/// primaries have Gaussian spectra (610, 540 and 450 nm; σ 20, 25 and 15 nm; peaks .004, .005 and .003), the exponents 2.2,
/// 2.1 and 2.3, and black is 10⁻⁶ in each of 101 bands. The luminances come from the CIE's table of 1 nm.
#[test]
fn calibrations_of_psychtoolbox() {
    let whole = include_bytes!("../golden/psychtoolbox.mat");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("screen0.mat");
    std::fs::write(&path, whole).unwrap();
    let found = readings::open(&path).unwrap();
    assert_eq!(found.all().len(), 3 * 17);
    for (channel, half, full) in
        [(Channel::Red, 3.80367, 17.47710), (Channel::Green, 10.22507, 43.83584), (Channel::Blue, 0.18028, 0.88778)]
    {
        for (level, expected) in [(0.0, 0.0), (0.5, half), (1.0, full)] {
            let of = |one: &&Reading| one.channel == channel && one.level == level;
            let read = found.all().iter().find(of).unwrap().luminance_cd_m2;
            assert!((read / (expected + 0.018_246) - 1.0).abs() < 0.004, "{channel} {level}: {read}");
        }
    }
    let printed = succeeds(folder.path(), &split("calibrate screen0.mat --out screen.toml"));
    assert!(printed.contains("Chosen: gamma"), "{printed}");
    assert!(succeeds(folder.path(), &split("check screen0.mat")).contains("51 photometer readings"));

    // Damage is an error: no panic, and no calibration from half a file.
    for index in 0..whole.len() {
        std::fs::write(&path, &whole[..index]).unwrap();
        assert!(readings::open(&path).is_err(), "{index} bytes");
        let mut changed = whole.to_vec();
        changed[index] ^= 0x41;
        std::fs::write(&path, changed).unwrap();
        let _ = readings::open(&path);
    }
    for (content, expected) in [
        (&b"MATLAB 7.3 MAT-file"[..], "expected one that was saved with save -v7"),
        (b"# Created by Octave 8\n# name: cals\n", "expected one that was saved with save -v7"),
        (&whole[..128], "has no variable cals"),
    ] {
        std::fs::write(&path, content).unwrap();
        let told = readings::open(&path).unwrap_err().to_string();
        assert!(told.contains(expected), "{told}");
    }
}
