//! `machband verify`: what a session left is proved, and whatever is done to it afterwards is named.

use std::{
    fs,
    path::{Path, PathBuf},
};

use machband::store::{sidecar::Sidecar, verify};

use crate::common::{machband, session_csv, succeeds, text};

/// One session of `quick` by the simulated observer.
fn recorded() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["simulate", "quick", "--seed", "5"]);
    let csv = session_csv(&folder.path().join("results"), "quick", "S001");
    (folder, csv)
}

fn faults(csv: &Path) -> Vec<String> {
    let found = verify::session(csv, &mut verify::Renderer::default());
    found.faults.iter().map(ToString::to_string).collect()
}

fn edit(path: &Path, change: impl FnOnce(String) -> String) {
    let text = fs::read_to_string(path).unwrap();
    let changed = change(text.clone());
    assert_ne!(changed, text, "the test changes nothing");
    fs::write(path, changed).unwrap();
}

#[test]
fn an_untouched_session_is_proved() {
    let (folder, csv) = recorded();
    let found = verify::session(&csv, &mut verify::Renderer::default());
    assert_eq!(found.faults, []);
    assert_eq!((found.rows, found.rated, found.sealed), (28, (28, 28), true));
    // All of 4 widths × 3 depths × 2 orientations.
    assert_eq!(found.pictures, 24);
    let said = succeeds(folder.path(), &["verify", "results"]);
    assert!(said.contains("as it was recorded") && said.contains("1 sessions: nothing is wrong"), "{said}");
}

/// Each way to touch a session, and a part of what must be said of it.
#[test]
fn everything_that_is_touched_is_named() {
    type Touch = fn(&Path, &Path);
    fn lines(csv: &Path, change: impl FnOnce(&mut Vec<String>)) {
        edit(csv, |text| {
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            change(&mut lines);
            lines.join("\n") + "\n"
        });
    }
    let ways: &[(&str, Touch, &[&str])] = &[
        (
            "a rating",
            |csv, _| {
                lines(csv, |lines| {
                    let mut cells: Vec<&str> = lines[9].split(',').collect();
                    cells[16] = if cells[16] == "0" { "3" } else { "0" };
                    lines[9] = cells.join(",");
                });
            },
            &["_data.csv: was changed since the session ended"],
        ),
        (
            "a condition",
            |csv, _| edit(csv, |text| text.replacen("mach-band,0.4,1,", "mach-band,0.1,1,", 1)),
            &["is not planned by the definition and seed 5", "was changed since"],
        ),
        (
            "a row taken out",
            |csv, _| lines(csv, |lines| drop(lines.remove(12))),
            &["27 of 28 trials are rated", "was changed since"],
        ),
        (
            "a row twice",
            |csv, _| lines(csv, |lines| lines.extend_from_within(lines.len() - 1..)),
            &["is attempt 1; expected attempt 2", "was changed since"],
        ),
        (
            "rows in another order",
            |csv, _| lines(csv, |lines| lines.swap(7, 8)),
            &["was recorded before the row above it", "was changed since"],
        ),
        (
            "the end cut off",
            |csv, _| edit(csv, |text| text[..text.len() - 10].to_owned()),
            &["ends within a row", "27 of 28 trials are rated", "was changed since"],
        ),
        (
            "the seed",
            |_, sidecar| edit(sidecar, |text| text.replacen("\"seed\": 5", "\"seed\": 6", 1)),
            &["is not planned by the definition and seed 6", "_data.json: was changed since"],
        ),
        (
            "the definition",
            |_, sidecar| edit(sidecar, |text| text.replacen("\"duration_s\": 2.0", "\"duration_s\": 3.0", 1)),
            &["expected", "that of the definition used", "_data.json: was changed since"],
        ),
        (
            "the stimulus",
            |_, sidecar| edit(sidecar, |text| text.replacen("\"high\": 0.75", "\"high\": 0.8", 1)),
            &["renders to sha256", "that of the definition used"],
        ),
        (
            "a hash",
            |_, sidecar| {
                let mut read = Sidecar::read(sidecar).unwrap().unwrap();
                let pictures = read.sittings[0].pictures.as_mut().unwrap();
                pictures.sha256.insert(3, "0".repeat(64));
                // Even with a new seal, rendering reveals the change.
                let own = read.own_sha256();
                read.seal.as_mut().unwrap().sidecar_sha256 = own;
                read.write(sidecar).unwrap();
            },
            &["condition 3 of sitting 1 renders to sha256"],
        ),
        (
            "the size that was shown",
            |_, sidecar| edit(sidecar, |text| text.replacen("\"size\": 256", "\"size\": 255", 1)),
            &["condition 24 of sitting 1 renders to sha256", "_data.json: was changed since"],
        ),
        ("no sidecar", |_, sidecar| fs::remove_file(sidecar).unwrap(), &["does not exist; expected the sidecar"]),
        (
            "a broken sidecar",
            |_, sidecar| edit(sidecar, |text| text.replacen('{', "", 1)),
            &["is not a sidecar of a session"],
        ),
    ];
    for (what, touch, expected) in ways {
        let (folder, csv) = recorded();
        let sidecar = csv.with_extension("json");
        touch(&csv, &sidecar);
        let faults = faults(&csv);
        for part in *expected {
            assert!(faults.iter().any(|fault| fault.contains(part)), "{what}: {part:?} is not in {faults:#?}");
        }
        let said = machband(folder.path(), &["verify", "results"]);
        assert_eq!(said.status.code(), Some(1), "{what}");
        let lines = text(&said.stderr);
        assert!(
            lines.lines().count() >= faults.len() && lines.lines().all(|line| line.starts_with("error: ")),
            "{what}: {lines}"
        );
    }
}

#[test]
fn what_belongs_to_no_session_is_named() {
    let (_folder, csv) = recorded();
    let data = csv.parent().unwrap();
    fs::write(data.join("subject-S009_session-1_task-quick_data.json"), "{}").unwrap();
    fs::write(data.join("subject-S001_session-1_task-quick_data.json.77-0.tmp"), "{").unwrap();
    let left = verify::leftovers(data.parent().unwrap());
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn an_interrupted_session_is_a_note_and_not_a_fault() {
    let (_folder, csv) = recorded();
    let mut sidecar = Sidecar::read(&csv.with_extension("json")).unwrap().unwrap();
    (sidecar.complete, sidecar.seal) = (false, None);
    sidecar.write(&csv.with_extension("json")).unwrap();
    edit(&csv, |text| text[..text.len() - 10].to_owned());
    let found = verify::session(&csv, &mut verify::Renderer::default());
    assert_eq!(found.faults, []);
    assert!(
        !found.sealed && found.notes.iter().any(|note| note.contains("line 29 is incomplete")),
        "{:?}",
        found.notes
    );
}
