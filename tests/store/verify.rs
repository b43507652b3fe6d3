//! `machband verify` confirms the files of a session, and reports every later change to them.

use std::{
    fs,
    path::{Path, PathBuf},
};

use machband::store::{dataset, sidecar::Sidecar};

use crate::common::{edit, machband, session_csv, succeeds, text, verified};

/// Records one session of `quick` with the simulated observer.
fn recorded() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["simulate", "quick", "--seed", "5"]);
    let csv = session_csv(&folder.path().join("results"), "quick", "S001");
    (folder, csv)
}

fn errors(csv: &Path) -> Vec<String> {
    let found = verified(csv);
    found.errors.iter().map(ToString::to_string).collect()
}

#[test]
fn an_unchanged_session_is_confirmed_and_another_picture_is_named() {
    let (folder, csv) = recorded();
    let found = verified(&csv);
    assert_eq!(found.errors, []);
    assert_eq!((found.rows, found.rated, found.sealed), (28, (28, 28), true));
    // All combinations of 4 widths, 3 depths and 2 orientations.
    assert_eq!(found.pictures, 24);
    let said = succeeds(folder.path(), &["verify", "results"]);
    assert!(
        said.contains("unchanged since it was recorded") && said.contains("1 session verified; no errors"),
        "{said}"
    );
    edit(&csv.with_extension("json"), |text| text.replacen("\"size\": 256", "\"size\": 255", 1));
    let found = errors(&csv);
    assert!(found.iter().any(|error| error.contains("condition 24 of sitting 1 renders to sha256")), "{found:?}");
    // An unreadable row does not hide that the file is another one.
    edit(&csv, |text| text.replacen("S001_1_main_0002_1,", "", 1));
    let found = errors(&csv);
    assert!(found.len() == 3 && found[1].contains("was changed since the session ended"), "{found:?}");
    assert!(text(&machband(folder.path(), &["verify", "results"]).stdout).contains("could not be read; 3 errors"));
}

/// Without a seal, the hash of the definition still shows that it was changed.
#[test]
fn a_changed_definition_is_noticed_without_a_seal() {
    let (folder, csv) = recorded();
    let path = csv.with_extension("json");
    let mut sidecar = Sidecar::read(&path).unwrap().unwrap();
    let sitting = &mut sidecar.sittings[0];
    (sitting.complete, sitting.ended_at, sitting.seal) = (false, None, None);
    sidecar.write(&path).unwrap();
    edit(&csv, |text| text.lines().take(9).map(|line| format!("{line}\n")).collect());
    assert_eq!(errors(&csv), [""; 0]);
    edit(&path, |text| text.replacen("\"duration_s\": 2.0", "\"duration_s\": 3.0", 1));
    let said = "the definition has sha256";
    assert!(errors(&csv).len() == 1 && errors(&csv)[0].contains(said), "{:?}", errors(&csv));
    for (command, status) in [
        (&["counts", "results", "--out", "c.csv"][..], 0),
        (&["export", "results", "--format", "bids", "--out", "out"], 1),
        (&["simulate", "quick", "--seed", "5", "--resume"], 1),
    ] {
        let output = machband(folder.path(), command);
        assert!(output.status.code() == Some(status) && text(&output.stderr).contains(said), "{command:?}: {output:?}");
    }
}

#[test]
fn interrupted_sessions_cause_notes_and_stray_files_cause_errors() {
    let (_folder, csv) = recorded();
    let data = csv.parent().unwrap();
    fs::write(data.join("subject-S009_session-1_task-quick_data.json"), "{}").unwrap();
    fs::write(data.join("subject-S001_session-1_task-quick_data.json.machband-a1b2C3d4E5f6G7h8.tmp"), "{").unwrap();
    fs::write(data.join("subject-S001_session-1_task-quick_data (conflicted copy).csv"), "").unwrap();
    fs::write(data.join("subject-S002_session-1_task-quick_data.csv.gz"), "").unwrap();
    fs::write(data.join(".DS_Store"), "").unwrap();
    let left = dataset::unexpected_files(data.parent().unwrap());
    assert_eq!(left.len(), 3, "{left:?}");
    // An analysis and an export say so, because rows may be missing.
    let folder = data.ancestors().nth(3).unwrap();
    let analyzed = machband(folder, &["counts", "results", "--out", "counts.csv"]);
    let exported = machband(folder, &["export", "results", "--format", "bids", "--out", "out"]);
    assert_eq!((analyzed.status.code(), exported.status.code()), (Some(1), Some(0)));
    for stray in [
        "subject-S009_session-1_task-quick_data.json: has no data file next to it",
        "(conflicted copy).csv: is not named like",
        "_data.csv.gz: is not named like",
    ] {
        for said in [text(&analyzed.stderr), text(&exported.stderr)] {
            assert!(said.contains(stray), "{said}");
        }
    }
    let mut sidecar = Sidecar::read(&csv.with_extension("json")).unwrap().unwrap();
    let sitting = &mut sidecar.sittings[0];
    (sitting.complete, sitting.ended_at, sitting.seal) = (false, None, None);
    sidecar.write(&csv.with_extension("json")).unwrap();
    edit(&csv, |text| text[..text.len() - 10].to_owned());
    let found = verified(&csv);
    assert_eq!(found.errors, []);
    assert!(
        !found.sealed && found.notes.iter().any(|note| note.contains("line 29 is incomplete")),
        "{:?}",
        found.notes
    );
}
