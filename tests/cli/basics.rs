//! The commands as a user's script sees them: the real program, its files, and its exit status.

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

use jiff::Timestamp;
use machband::{
    experiment::{Protocol, TrialRecord},
    store::definition,
};

use crate::common::{
    command, everything, fails, machband, pixels, refuses, rows, session_csv, split, succeeds, table, text,
};

fn csv(folder: &Path, protocol: &Protocol, number: usize) -> PathBuf {
    session_csv(folder, &protocol.name, &format!("S{number:03}"))
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

#[test]
fn wrong_usage_is_an_error_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let cases = r"
        2: simulte => simulte
        2: run quick --participant ../../x => is not allowed
        2: run quick --participant S001 --session '1 2' => is not allowed
        2: run quick --resume => --participant
        2: run quick --seed -1 => outside 0…18446744073709551615
        2: simulate quick --participants -1 => outside 1…1000000
        2: simulate quick --observer random --observer-file x.toml => --observer-file
        2: stimulus => --out
        2: stimulus --out x.png --width 1.5 => width 1.5
        2: stimulus --out x.png --low 0.9 => below low
        2: stimulus --out x.png --size 99999999 => 99999999
        2: stimulus --out x.png --transfer gamma:0 => gamma 0 is outside
        2: stimulus --out x.png --transfer srgb --display p.toml => --transfer excludes a display profile
        2: stimulus --out x.png --halftone clustered3:1 --bits 16 => --halftone: a halftone has its own bits
        2: stimulus --out x.png --halftone clustered3:1 --dither ordered => expected 8 bits and no dither
        2: stimulus --out x.png --palette median-cut:257 => expected popularity or median-cut, a colon and 1…256 colors
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
    // A conflicted copy of a cloud service is no file of a session.
    fs::copy(&path, path.with_file_name("copy (1).csv")).unwrap();
    let check = "check bad.toml good.toml quick screen.toml rows.csv none.csv r 'r/quick/data/copy (1).csv'";
    let output = machband(folder.path(), &[&split(check)[..], &[path.to_str().unwrap().to_owned()]].concat());
    assert_eq!((output.status.code(), text(&output.stdout).lines().count()), (Some(1), 3));
    let errors = text(&output.stderr);
    assert!(errors.lines().all(|line| line.starts_with("error: ")), "{errors}");
    let definition = ["bad.toml:2:1: ", "bad.toml:6:10: ", "bad.toml:6:15: ", "bad.toml:7:2: "];
    let others = ["screen.toml:3:1: ", "rows.csv: ", "none.csv: ", "r: ", "r/quick/data/copy (1).csv: "];
    for start in definition.iter().chain(&others) {
        let found = errors.lines().filter(|line| line["error: ".len()..].starts_with(start)).count();
        assert_eq!(found, 1, "{start}: {errors}");
    }
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

#[test]
fn the_profile_has_the_codes_of_the_image() {
    let folder = tempfile::tempdir().unwrap();
    let line = "stimulus --size 100 --out a.png --profile a.csv";
    assert_eq!(succeeds(folder.path(), &split(line)), "wrote a.png\nwrote a.csv\n");
    let (_, codes) = pixels(&folder.path().join("a.png"));
    let (header, rows) = table(&folder.path().join("a.csv"));
    assert_eq!((header.join(","), rows.len()), ("x,linear,code_r,code_g,code_b,emitted".to_owned(), 100));
    for (x, row) in rows.iter().enumerate() {
        let row: Vec<f64> = row.iter().map(|cell| cell.parse().unwrap()).collect();
        let pixel = &codes[3 * (50 * 100 + x)..][..3];
        assert!(pixel.iter().zip(&row[2..5]).all(|(code, cell)| f64::from(*code) == *cell), "column {x}");
        // A linear ramp over 0.4 of the window.
        let asked = 0.25 + 0.5 * (row[0] / 0.4 + 0.5).clamp(0.0, 1.0);
        assert!((row[1] - asked).abs() < 1e-6 && (row[5] - asked).abs() < 2.3 / 255.0, "column {x}");
    }
}
