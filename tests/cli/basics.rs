//! The commands as a user's script sees them: the real program, its files, and its exit status.

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
    process::{Child, Stdio},
    time::{Duration, Instant},
};

use jiff::Timestamp;
use machband::{
    experiment::{Protocol, TrialRecord, session_seed},
    store::definition,
};

use crate::common::{command, everything, fails, machband, pixels, refuses, rows, session_csv, split, succeeds, text};

fn csv(folder: &Path, protocol: &Protocol, number: usize) -> PathBuf {
    session_csv(folder, &protocol.name, &format!("S{number:03}"))
}

/// Returns what must be the same no matter how often a simulation was interrupted.
fn ratings(folder: &Path, protocol: &Protocol, participants: usize) -> Vec<(String, u8, String)> {
    let all = (1..=participants).flat_map(|number| rows(&csv(folder, protocol, number), protocol));
    all.map(|row| {
        (row.row_id, row.rating.unwrap().0, format!("{:?} {:?} {:?}", row.width, row.depth, row.response_time_s))
    })
    .collect()
}

#[test]
fn simulations_are_reproducible() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = definition::open("bangay2003").unwrap();
    let simulate = |results: &str| -> Vec<PathBuf> {
        let line = format!("simulate bangay2003 --participants 8 --seed 1 --results {results}");
        let output = succeeds(folder.path(), &split(&line));
        assert!(output.contains("8 sessions") && output.contains("2,016 rows"), "{output}");
        let root = folder.path().join(results);
        everything(&root).into_iter().map(|(path, _)| path.strip_prefix(&root).unwrap().to_owned()).collect()
    };
    let files = simulate("a");
    assert_eq!((files.len(), &simulate("b")), (8 * 2 + 5, &files));
    let mut orders = HashSet::new();
    for number in 1..=8 {
        let [rows, again] = ["a", "b"].map(|results| {
            let rows = rows(&csv(&folder.path().join(results), &protocol, number), &protocol).into_iter();
            rows.map(|row| TrialRecord { started_at: Timestamp::UNIX_EPOCH, ..row }).collect::<Vec<_>>()
        });
        assert_eq!((rows.len(), &rows), (6 * 5 * 4 * 2 + 12, &again));
        let shown = rows.iter().map(|row| format!("{:?}{:?}{:?}", row.width, row.depth, row.orientation_deg));
        orders.insert(shown.collect::<String>());
        let output = succeeds(folder.path(), &["check", csv(Path::new("a"), &protocol, number).to_str().unwrap()]);
        assert!(output.contains("252 rows; 252 of 252 planned trials"), "{output}");
    }
    assert_eq!(orders.len(), 8, "each participant has a different order");
}

/// The central guarantee: a program that is killed at any moment loses no ratings.
#[test]
fn killing_and_resuming_fifty_times_changes_nothing() {
    const PARTICIPANTS: usize = 20;
    let folder = tempfile::tempdir().unwrap();
    let protocol = definition::open("bangay2003").unwrap();
    let spawn = |results: &str| -> Child {
        let run = split(&format!("simulate bangay2003 --participants 20 --results {results} --resume"));
        command(folder.path(), &run).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let started = Instant::now();
    assert!(spawn("whole").wait().unwrap().success());
    let whole = started.elapsed();
    let expected = ratings(&folder.path().join("whole"), &protocol, PARTICIPANTS);
    assert_eq!(expected.len(), PARTICIPANTS * 252);
    let (mut kills, mut rounds, mut mid_run) = (0_u64, 0, 0);
    while kills < 50 {
        rounds += 1;
        let results = format!("killed{rounds}");
        let data = folder.path().join(&results).join("bangay2003/data");
        let rated = || -> usize {
            let files = fs::read_dir(&data).into_iter().flatten().flatten().map(|file| file.path());
            let csv = files.filter(|path| path.extension().is_some_and(|extension| extension == "csv"));
            let lines = |path| fs::read(path).unwrap().iter().filter(|byte| **byte == b'\n').count();
            csv.map(|path| lines(path).saturating_sub(1)).sum()
        };
        loop {
            // The kill comes at any point from the program's first instructions to 80 % of a complete run.
            let share = session_seed(kills * 1000 + rounds) as f64 / 2_f64.powi(32);
            let at_once = kills % 5 == 0;
            let delay = if at_once { Duration::from_secs_f64(share * 0.02) } else { whole.mul_f64(0.8 * share) };
            let before = rated();
            let mut child = spawn(&results);
            std::thread::sleep(delay);
            if kills < 50 && child.try_wait().unwrap().is_none() {
                child.kill().unwrap();
                child.wait().unwrap();
                kills += 1;
                let after = rated();
                assert!(after >= before, "{after} rows after {before}");
                mid_run += u32::from(after > before && after < expected.len());
            } else {
                let output = child.wait_with_output().unwrap();
                assert!(output.status.success(), "{results} cannot be resumed: {}", text(&output.stderr));
                break;
            }
        }
        let found = ratings(&folder.path().join(&results), &protocol, PARTICIPANTS);
        assert!(found == expected, "{results}: {} rows, not {}", found.len(), expected.len());
        assert_eq!(everything(&data).len(), 2 * PARTICIPANTS, "{results}: only rows and sidecars, no partial files");
    }
    assert!(mid_run >= 10, "only {mid_run} of {kills} kills happened while rows were being written");
}

#[test]
fn wrong_usage_is_an_error_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let cases = r"
        2: simulte => simulte
        2: run => EXPERIMENT
        2: run quick --participant ../../x => is not allowed
        2: run quick --participant Zoë => is not allowed
        2: run quick --participant S001 --session '1 2' => is not allowed
        2: run quick --resume => --participant
        2: run quick --seed -1 => outside 0…18446744073709551615
        2: simulate quick --participants -1 => outside 1…1000000
        2: simulate quick --participants 0 => 0
        2: simulate quick --observer nobody => nobody
        2: simulate quick --observer random --observer-file x.toml => --observer-file
        2: check => FILE
        2: stimulus => --out
        2: stimulus --out x.png --width 1.5 => width 1.5
        2: stimulus --out x.png --low 0.9 => below low
        2: stimulus --out x.png --color 1,1 => color
        2: stimulus --out x.png --size 99999999 => 99999999
        2: stimulus --out x.png --transfer gamma:0 => gamma 0 is outside
        2: stimulus --out x.png --transfer srgb --display p.toml => --transfer excludes a display profile
        2: stimulus --out x.png --bits 12 => 12
        2: stimulus --out x.png --halftone clustered3:1 --bits 16 => --halftone: a halftone has its own bits
        2: stimulus --out x.png --halftone clustered3:1 --dither ordered => expected 8 bits and no dither
        2: stimulus --out x.png --kind moire => moire";
    refuses(folder.path(), "{}", cases);
}

#[test]
fn failures_are_errors_that_name_their_place() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let bad = "schema = 1\nname = \"a\"\nstimulus.kind = \"mach-band\"\nfactors.width = [1.5]\n";
    fs::write(folder.path().join("bad.toml"), bad).unwrap();
    for (line, part) in [
        ("simulate quick --results file", "error: file/quick/data: cannot create the folder"),
        ("simulate quik", "error: quik: is neither a built-in definition nor a file"),
        ("simulate none.toml", "error: none.toml: cannot be opened"),
        ("simulate bad.toml", "error: bad.toml:4:18: width 1.5"),
        ("simulate quick --observer-file bad.toml", "error: bad.toml:2:1: unknown key"),
        ("stimulus --size 8 --out none/x.png", "error: none/x.png: cannot "),
        ("stimulus --size 8 --profile file/x.csv", "error: file/x.csv: cannot "),
        ("stimulus --size 8 --out x.png --display none.toml", "error: none.toml: cannot be opened"),
        ("run quick --participant S001 --resume", "no such session"),
        ("run bad.toml", "error: bad.toml:4:18: width 1.5"),
    ] {
        let error = fails(folder.path(), &split(line), 1);
        assert!(error.contains(part), "{line}: {error}");
        assert!(error.matches("os error").count() <= 1, "{line} states its cause more than once: {error}");
    }
    assert_eq!(everything(folder.path()).len(), 2, "no file was created");
}

#[test]
fn check_reports_every_error_in_every_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| fs::write(folder.path().join(name), content).unwrap();
    write(
        "bad.toml",
        "schema = 1\nname = \"Bad\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [1.5, 2]\n[desing]\n",
    );
    write("good.toml", definition::BUILT_IN[0].text);
    write("screen.toml", "schema = 1\nname = \"TV\"\ntransfer = \"gama:2\"\n");
    write("rows.csv", "row_id,experiment\nx\n");
    succeeds(folder.path(), &split("simulate quick --results r"));
    let path = csv(&folder.path().join("r"), &definition::open("quick").unwrap(), 1);
    let rows = fs::read_to_string(&path).unwrap();
    let mut lines: Vec<String> = rows.lines().map(str::to_owned).collect();
    lines[3] = lines[2].clone();
    lines[5] = lines[5].replacen(",yellow,", ",yellow,9", 1);
    write("twice.csv", &(lines.join("\n") + "\n"));
    fs::copy(path.with_extension("json"), folder.path().join("twice.json")).unwrap();
    let check = "check bad.toml good.toml quick screen.toml rows.csv twice.csv none.csv r";
    let output = machband(folder.path(), &[&split(check)[..], &[path.to_str().unwrap().to_owned()]].concat());
    assert_eq!((output.status.code(), text(&output.stdout).lines().count()), (Some(1), 3));
    let errors = text(&output.stderr);
    assert!(errors.lines().all(|line| line.starts_with("error: ")), "{errors}");
    let definition = ["bad.toml:2:1: ", "bad.toml:6:10: ", "bad.toml:6:15: ", "bad.toml:7:2: "];
    let others = ["screen.toml:3:1: ", "rows.csv:1:", "rows.csv:2:1: ", "twice.csv:6:", "none.csv: ", "r: "];
    for start in definition.iter().chain(&others) {
        let found = errors.lines().filter(|line| line["error: ".len()..].starts_with(start)).count();
        assert_eq!(found, 1, "{start}: {errors}");
    }
    // Once the unreadable cell is fixed, the repeated row is found; the trial whose row it replaced is missing.
    lines[5] = lines[5].replacen(",yellow,9", ",yellow,", 1);
    write("twice.csv", &(lines.join("\n") + "\n"));
    let error = fails(folder.path(), &["check", "twice.csv"], 1);
    assert!(error.contains("twice.csv:4:1: row S001_1_practice_0002_1 is attempt 1; expected attempt 2"), "{error}");
}

/// Arguments are text; another name of a file is refused.
#[cfg(target_os = "linux")]
#[test]
fn arguments_are_text() {
    use std::{ffi::OsString, os::unix::ffi::OsStringExt as _};
    let folder = tempfile::tempdir().unwrap();
    let output = machband(folder.path(), &["check".into(), OsString::from_vec(b"\xff.toml".to_vec())]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(text(&output.stderr), "error: \u{fffd}.toml: is not Unicode; expected text in UTF-8\n");
}

/// A closed pipe, as after `| head -1`, is not an error.
#[test]
fn a_closed_pipe_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    for line in ["check quick orientation", "simulate quick --resume"] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = command(folder.path(), &split(line)).stdout(writer).output().unwrap();
        assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
    }
}

/// The sRGB codes of the plateaus, computed by hand from IEC 61966-2-1: ¼ → 0.537099 · 255 = 136.96, ¾ → 0.880825 · 255
/// = 224.61.
#[test]
fn the_image_has_the_expected_plateaus_and_matches_the_profile() {
    let folder = tempfile::tempdir().unwrap();
    for (bits, dark, bright) in [("8", 137_u16, 225_u16), ("16", 35199, 57725)] {
        let line = format!("stimulus --size 100 --bits {bits} --out a.png --profile a.csv --force");
        assert_eq!(succeeds(folder.path(), &split(&line)), "wrote a.png\nwrote a.csv\n");
        let (info, data) = pixels(&folder.path().join("a.png"));
        assert_eq!((info.width, info.height, info.color_type), (100, 100, png::ColorType::Rgb));
        assert!(info.srgb.is_some(), "the file says what its codes mean");
        let sample = |x: usize, y: usize, channel: usize| {
            let at = (y * 100 + x) * 3 + channel;
            if bits == "8" { u16::from(data[at]) } else { u16::from_be_bytes([data[2 * at], data[2 * at + 1]]) }
        };
        let table = fs::read_to_string(folder.path().join("a.csv")).unwrap();
        let (header, rows) = table.split_once('\n').unwrap();
        assert_eq!((header, rows.lines().count()), ("x,linear,code_r,code_g,code_b,emitted", 100));
        let scale = if bits == "8" { 255.0 } else { 65535.0 };
        for (x, row) in rows.lines().enumerate() {
            let row: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            for y in [0, 50, 99] {
                let codes = [0, 1, 2].map(|channel| f64::from(sample(x, y, channel)));
                assert_eq!(codes, row[2..5], "column {x}");
            }
            assert!((row[0] - (x as f64 + 0.5 - 50.0) / 100.0).abs() < 1e-12);
            // Decoding according to IEC 61966-2-1.
            let v = row[2] / scale;
            let light = if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
            assert!((row[5] - light).abs() < 1e-6, "column {x}: {} is not {light}", row[5]);
            // A linear ramp over 0.4 of the window.
            let asked = 0.25 + 0.5 * (row[0] / 0.4 + 0.5).clamp(0.0, 1.0);
            assert!((row[1] - asked).abs() < 1e-6 && (row[5] - asked).abs() < 2.3 / scale, "column {x}");
        }
        let ends = [(sample(0, 0, 0), sample(0, 0, 2)), (sample(99, 99, 1), sample(99, 99, 2))];
        assert_eq!(ends, [(dark, 0), (bright, 0)]);
    }
}
