//! Exports contain every row and cell and the pictures that were shown. Incomplete or inconsistent data are never
//! written.

use std::{
    collections::{BTreeMap, HashMap},
    fs,
    path::{Path, PathBuf},
};

use machband::{
    display::Monitor,
    experiment::columns,
    store::{
        export::{Choice, Exported, Format, export},
        image,
        ratings::Listed,
        recorded::Recorded,
        sidecar::{FrameSummary, Geometry, Sidecar},
    },
};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::common::{change_rating, everything, fails, json as read_json, session_csv, succeeds, verified};

const FORMATS: [Format; 2] = [Format::Bids, Format::PsychDs];
const COMPLETE: Choice = Choice { complete_only: true, accept_changes: false };

/// Simulates `study` in a new folder, and returns that folder and its results folder.
fn simulated(study: &[&str]) -> (TempDir, PathBuf) {
    let scratch = tempfile::tempdir().unwrap();
    succeeds(scratch.path(), &[&["simulate", "--results", "results"], study].concat());
    let results = scratch.path().join("results");
    (scratch, results)
}

fn sidecar(results: &Path, experiment: &str, subject: &str) -> PathBuf {
    session_csv(results, experiment, subject).with_extension("json")
}

fn edit_json(path: &Path, edit: impl FnOnce(&mut Value)) {
    let mut value = read_json(path);
    edit(&mut value);
    fs::write(path, value.to_string()).unwrap();
}

/// Edits a sidecar as if the program had written it that way.
fn rewrite(path: &Path, edit: impl FnOnce(&mut Value)) {
    edit_json(path, edit);
    let mut sidecar = Sidecar::read(path).unwrap().unwrap();
    let own = sidecar.sha256_at_end_of(sidecar.sittings.len() - 1);
    sidecar.sittings.last_mut().unwrap().seal.as_mut().unwrap().sidecar_sha256 = own;
    sidecar.write(path).unwrap();
}

/// Rewrites a session as if it had been interrupted: `rows` complete rows, then a corrected response, then half a row.
fn interrupt(results: &Path, subject: &str, rows: usize) {
    let csv = session_csv(results, "quick", subject);
    let text = fs::read_to_string(&csv).unwrap();
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    // The attempt is part of the row_id and also has its own cell.
    let mut cells: Vec<String> = lines[rows].trim_end().split(',').map(str::to_owned).collect();
    cells[0] = cells[0].strip_suffix("_1").unwrap().to_owned() + "_2";
    cells[7] = "2".to_owned();
    fs::write(&csv, lines[..=rows].concat() + &cells.join(",") + "\nS001_1_ma").unwrap();
    edit_json(&sidecar(results, "quick", subject), |sidecar| {
        let last = sidecar["sittings"].as_array_mut().unwrap().last_mut().unwrap();
        last["complete"] = false.into();
        ["seal", "ended_at"].iter().for_each(|key| drop(last.as_object_mut().unwrap().remove(*key)));
    });
}

/// Simulates two participants of `quick`: the first is interrupted, corrected and resumed; the second is interrupted
/// and not resumed. Also simulates a task with shaded meshes.
fn study() -> (TempDir, PathBuf) {
    let (scratch, results) = simulated(&["quick", "--participants", "2"]);
    succeeds(scratch.path(), &["simulate", "shaders"]);
    interrupt(&results, "S001", 9);
    let resumed = ["simulate", "quick", "--participants", "1", "--resume"];
    assert!(crate::common::machband(scratch.path(), &resumed).status.success());
    interrupt(&results, "S002", 7);
    (scratch, results)
}

fn sessions(results: &Path) -> Vec<Recorded> {
    Listed::sessions(results).files.iter().map(|csv| Recorded::open(csv).unwrap()).collect()
}

/// Returns every row by its experiment and its row_id, as cells by column.
fn rows(results: &Path) -> BTreeMap<(String, String), BTreeMap<String, String>> {
    let mut all = BTreeMap::new();
    for session in sessions(results) {
        let names: Vec<String> = columns(&session.protocol).into_iter().map(|column| column.name).collect();
        for row in &session.rows {
            let cells = names.iter().cloned().zip(row.cells()).collect();
            all.insert((row.experiment.clone(), row.row_id.clone()), cells);
        }
    }
    all
}

/// Returns the rows of all tables of a BIDS data set, by experiment and row_id.
fn tables(bids: &Path) -> BTreeMap<(String, String), HashMap<String, String>> {
    let mut all = BTreeMap::new();
    for (path, content) in everything(bids) {
        if path.to_string_lossy().ends_with("_beh.tsv") {
            let mut reader = csv::ReaderBuilder::new().delimiter(b'\t').from_reader(&content[..]);
            for row in reader.deserialize::<HashMap<String, String>>().map(Result::unwrap) {
                let key = (row["experiment"].clone(), row["row_id"].clone());
                assert!(all.insert(key.clone(), row).is_none(), "{key:?} occurs twice");
            }
        }
    }
    all
}

fn written(results: &Path, to: &Path, format: Format) -> Exported {
    export(results, to, format, Choice::default()).unwrap()
}

#[test]
fn every_cell_and_every_picture_is_exported() {
    let (scratch, results) = study();
    let expected = rows(&results);
    // 28 rows and a correction; 7 rows and a correction; 104 rows.
    assert_eq!(expected.len(), 29 + 8 + 104);

    let bids = scratch.path().join("bids");
    let exported = written(&results, &bids, Format::Bids);
    assert_eq!((exported.sessions, exported.rows), (3, expected.len()));
    assert!(
        exported.notes.iter().any(|note| note.contains("S002") && note.contains("7 of 28")),
        "{:?}",
        exported.notes
    );
    let cells_of = tables(&bids);
    assert_eq!(cells_of.len(), expected.len());
    for (key, cells) in &expected {
        for (name, cell) in cells {
            let (name, cell) = match name.as_str() {
                "phase" => ("trial_type", cell.clone()),
                "response_time_s" => ("response_time", cell.clone()),
                "subject_id" => ("participant_id", format!("sub-{cell}")),
                "session_id" => ("session_id", format!("ses-{cell}")),
                other => (other, cell.clone()),
            };
            let cell = if cell.is_empty() { "n/a".to_owned() } else { cell };
            assert_eq!(cells_of[key][name], cell, "{key:?} {name}");
        }
        assert_eq!(cells_of[key]["simulated"], "1");
    }
    let psych_ds = scratch.path().join("psych-ds");
    written(&results, &psych_ds, Format::PsychDs);
    assert_eq!(rows(&psych_ds), expected);
    for csv in Listed::sessions(&psych_ds).files {
        let found = verified(&csv);
        assert_eq!(found.errors, [], "{}", csv.display());
        assert!(Recorded::open(&csv).unwrap().partial_line.is_none());
    }

    // Every picture is identical to the one that was shown.
    let mut hashes = HashMap::new();
    for session in sessions(&results) {
        for (index, row) in session.rows.iter().enumerate() {
            let file = cells_of[&(row.experiment.clone(), row.row_id.clone())]["stim_file"].clone();
            let pictures = session.sidecar.sittings[row.sitting as usize - 1].pictures.as_ref().unwrap();
            let by_key = pictures.by_key(&session.course.schedule().conditions);
            let shown = by_key[&session.stimuli(index)[0].key()];
            let hash = hashes.entry(file).or_insert_with_key(|file| {
                let path = bids.join("stimuli").join(file);
                image::hash(&image::read_picture(&path, None, image::MAX_PIXELS).unwrap().codes)
            });
            assert_eq!(hash, shown);
        }
    }
    // Each picture is exported once, and only if it was shown.
    assert_eq!(hashes.len(), exported.pictures);
    assert_eq!(fs::read_dir(bids.join("stimuli")).unwrap().count(), exported.pictures);

    // With a different hash in a sidecar, the exported picture would differ from the one that was shown.
    let shown = sessions(&results)[0].sidecar.sittings[0].pictures.clone().unwrap().sha256[&1].clone();
    let path = sidecar(&results, "quick", "S001");
    rewrite(&path, |sidecar| {
        *sidecar = serde_json::from_str(&sidecar.to_string().replace(&shown, &"0".repeat(64))).unwrap();
    });
    let refused = scratch.path().join("refused");
    let error = export(&results, &refused, Format::Bids, Choice::default()).unwrap_err().to_string();
    assert!(error.contains("the hash of what was shown"), "{error}");
    assert!(!refused.exists());
}

#[test]
fn errors_are_reported_and_nothing_is_written() {
    let (scratch, results) = simulated(&["quick", "--participants", "2"]);
    let at = |name: &str| scratch.path().join(name);
    let refused = |to: &Path, expected: &str| {
        for format in FORMATS {
            let error = export(&results, to, format, Choice::default()).unwrap_err().to_string();
            assert!(error.contains(expected), "{format:?}: {error}");
        }
    };
    fs::write(at("file"), "x").unwrap();
    refused(&at("file"), "is a file");

    // Every error in every session is reported.
    let files: Vec<_> = ["S001", "S002"].map(|subject| session_csv(&results, "quick", subject)).into();
    let before: Vec<_> = files.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    for (path, text) in files.iter().zip(&before) {
        fs::write(path, text.replace(",yellow,", ",=1+1,")).unwrap();
    }
    let error = export(&results, &at("out"), Format::PsychDs, Choice::default()).unwrap_err().to_string();
    assert!(error.contains("S001_session") && error.contains("S002_session"), "{error}");
    assert!(error.contains("treat as a formula") && error.contains("is not planned"), "{error}");
    assert!(!at("out").exists());
    for (path, text) in files.iter().zip(&before) {
        fs::write(path, text).unwrap();
    }

    // The same session exists twice.
    fs::create_dir_all(results.join("copy/data")).unwrap();
    for file in [session_csv(&results, "quick", "S001"), sidecar(&results, "quick", "S001")] {
        fs::copy(&file, results.join("copy/data").join(file.file_name().unwrap())).unwrap();
    }
    refused(&at("out"), "is the same session");
    // No attempt has left any files.
    let left: Vec<_> = fs::read_dir(scratch.path()).unwrap().flatten().map(|entry| entry.file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
    fs::remove_dir_all(results.join("copy")).unwrap();

    // Unfinished sessions can be excluded.
    interrupt(&results, "S002", 7);
    let out = scratch.path().join("out");
    let exported = export(&results, &out, Format::Bids, COMPLETE).unwrap();
    assert_eq!((exported.sessions, exported.rows), (1, 28));
    assert!(!everything(&out).iter().any(|(path, _)| path.to_string_lossy().contains("S002")));
    interrupt(&results, "S001", 7);
    let error = export(&results, &scratch.path().join("none"), Format::Bids, COMPLETE).unwrap_err().to_string();
    assert!(error.contains("no session to export") && error.contains("7 of 28 trials are answered"), "{error}");
}

#[test]
fn screens_and_participants_are_described_in_bids_terms_and_units() {
    let (scratch, results) = simulated(&["quick"]);
    // As the window writes the sidecar for a person.
    rewrite(&sidecar(&results, "quick", "S001"), |sidecar| {
        let sitting = &mut sidecar["sittings"][0];
        sitting.as_object_mut().unwrap().remove("observer");
        sitting["viewing"] = json!(Geometry {
            distance_cm: 57.0,
            screen_width_cm: 53.1,
            screen_width_measured: true,
            ..Geometry::default()
        });
        sitting["monitor"] =
            json!(Monitor { width_px: 2560, height_px: 1440, refresh_hz: Some(60.0), ..Monitor::default() });
        sitting["frames"] = json!(FrameSummary { refresh_s: Some(0.016683350), ..FrameSummary::default() });
    });
    edit_json(&results.join("quick/dataset_description.json"), |description| {
        description["author"] =
            json!([{ "@type": "Person", "givenName": "Ada", "familyName": "Beispiel" }, "B. Muster"]);
        description["license"] = "CC0".into();
    });
    let bids = scratch.path().join("bids");
    written(&results, &bids, Format::Bids);
    let session = bids.join("sub-S001/ses-1/beh/sub-S001_ses-1_task-quick_beh.json");
    let screen = &read_json(&session)["StimulusPresentation"];
    assert_eq!(screen["ScreenDistance"], 0.57);
    // The height is 53.1 cm × 1440 / 2560.
    assert_eq!(screen["ScreenSize"], json!([0.531, 0.29869]));
    assert_eq!(screen["ScreenResolution"], json!([2560, 1440]));
    assert_eq!(screen["ScreenRefreshRate"], 59.94);
    let description = read_json(&bids.join("dataset_description.json"));
    assert_eq!(description["Authors"], json!(["Ada Beispiel", "B. Muster"]));
    assert_eq!(description["License"], "CC0");
    let participants = fs::read_to_string(bids.join("participants.tsv")).unwrap();
    assert_eq!(participants, "participant_id\nsub-S001\n");
    // Every column of the table is described.
    let described = read_json(&bids.join("task-quick_beh.json"));
    let table = fs::read_to_string(session.with_extension("tsv")).unwrap();
    for name in table.lines().next().unwrap().split('\t') {
        assert!(described[name]["Description"].is_string(), "{name}");
    }
}

#[test]
fn a_changed_file_is_exported_only_on_request_and_the_export_names_it() {
    let (scratch, results) = simulated(&["quick"]);
    let csv = session_csv(&results, "quick", "S001");
    change_rating(&csv);
    let (name, what) = ("subject-S001_session-1_task-quick_data.csv", "was changed since the session ended: sha256");
    let error = fails(scratch.path(), &["export", "results", "--format", "bids", "--out", "out"], 1);
    assert!(error.contains(name) && error.contains(what) && error.contains("--accept-changes"), "{error}");
    for format in FORMATS {
        let to = scratch.path().join(format!("{format:?}"));
        export(&results, &to, format, Choice::default()).unwrap_err();
        assert!(!to.exists());
        let accepted = Choice { accept_changes: true, ..Choice::default() };
        let exported = export(&results, &to, format, accepted).unwrap();
        assert!(exported.notes[0].contains(name) && exported.notes[0].contains(what), "{:?}", exported.notes);
        if format == Format::Bids {
            let text = fs::read_to_string(to.join("sub-S001/ses-1/beh/sub-S001_ses-1_task-quick_beh.json")).unwrap();
            assert!(text.contains(&format!("{name}: {what}")), "{text}");
        }
        // The seal still reveals the change in the copy.
        let copy = Listed::sessions(&to).files.remove(0);
        let found = verified(&copy);
        assert!(found.errors.iter().any(|error| error.message.contains(what)), "{:?}", found.errors);
    }
    // If the change was accepted when the session was resumed, the export names the incident.
    let resumed = crate::common::machband(scratch.path(), &["simulate", "quick", "--resume", "--accept-changes"]);
    assert!(resumed.status.success(), "{resumed:?}");
    let verified = crate::common::succeeds(scratch.path(), &["verify", "results"]);
    assert!(verified.contains("unchanged since changes were accepted"), "{verified}");
    let exported = written(&results, &scratch.path().join("accepted"), Format::Bids);
    assert!(exported.notes[0].contains(name) && exported.notes[0].contains("accepted that "), "{exported:?}");
    let sidecar = scratch.path().join("accepted/sub-S001/ses-1/beh/sub-S001_ses-1_task-quick_beh.json");
    assert!(fs::read_to_string(&sidecar).unwrap().contains("accepted that "), "{}", sidecar.display());
}

/// Nothing below a results folder leads out of it, whatever reads or writes there.
#[cfg(unix)]
#[test]
fn links_in_the_data_are_refused_by_name() {
    let (scratch, results) = simulated(&["quick"]);
    let secret = scratch.path().join("secret");
    fs::create_dir(&secret).unwrap();
    let data = "data/subject-S001_session-1_task-quick";
    let describing = ["LICENSE", "README.md", "CHANGES.md", ".psychdsignore", "dataset_description.json"];
    let of_session = ["_data.csv", "_data.json", "_frames.csv"].map(|end| format!("{data}{end}"));
    let places = describing.map(str::to_owned).into_iter().chain(of_session).chain(["data".to_owned(), String::new()]);
    for place in places {
        // The link leads to exactly what would otherwise be read, so nothing else can be wrong.
        let (path, target) = (results.join("quick").join(&place), secret.join("target"));
        // Without its trailing slash, this is the path of the folder `quick`.
        let path: PathBuf = path.components().collect();
        let is_new = !path.exists();
        if is_new {
            fs::write(&target, "private").unwrap()
        } else {
            fs::rename(&path, &target).unwrap()
        }
        std::os::unix::fs::symlink(&target, &path).unwrap();
        let before = everything(scratch.path());
        let expected = format!("{}: is a link to {}", path.display(), target.display());
        for format in FORMATS {
            let to = scratch.path().join("out");
            let error = export(&results, &to, format, Choice::default()).unwrap_err().to_string();
            assert!(error.starts_with(&expected), "{format:?} {place}: {error}");
        }
        let results = results.to_str().unwrap();
        if !describing.contains(&&*place) {
            let resume = ["simulate", "quick", "--resume", "--results", results];
            assert!(fails(scratch.path(), &resume, 1).contains(&expected), "{place}");
        }
        if !describing.contains(&&*place) && !is_new {
            let said = crate::common::machband(scratch.path(), &["repair", results]);
            assert!(String::from_utf8_lossy(&said.stderr).contains(&expected), "{place}: {said:?}");
        }
        assert_eq!(everything(scratch.path()), before, "{place}");
        fs::remove_file(&path).unwrap();
        if is_new { fs::remove_file(&target).unwrap() } else { fs::rename(&target, &path).unwrap() }
    }
    // The folder that the user names may be a link.
    let link = scratch.path().join("link");
    std::os::unix::fs::symlink(&results, &link).unwrap();
    written(&link, &scratch.path().join("out"), Format::Bids);
    succeeds(scratch.path(), &["simulate", "quick", "--participants", "2", "--resume", "--results", "link"]);
}

#[test]
fn tasks_whose_names_become_the_same_are_not_joined() {
    let scratch = tempfile::tempdir().unwrap();
    // In BIDS, names of tasks lose their hyphens.
    let definition = fs::read_to_string("experiments/quick.toml").unwrap();
    for (name, subject) in [("my-study", "1"), ("mystudy", "2")] {
        fs::write(scratch.path().join("one.toml"), definition.replace("\"quick\"", &format!("\"{name}\""))).unwrap();
        succeeds(scratch.path(), &["simulate", "one.toml", "--participants", subject, "--results", "twins"]);
    }
    for end in ["data.csv", "data.json"] {
        fs::remove_file(scratch.path().join(format!("twins/mystudy/data/subject-S001_session-1_task-mystudy_{end}")))
            .unwrap();
    }
    let said = fails(scratch.path(), &["export", "twins", "--format", "bids", "--out", "twins-bids"], 1);
    assert!(said.contains("my-study and mystudy have the same task name in BIDS, mystudy"), "{said}");
    succeeds(scratch.path(), &["export", "twins", "--format", "psych-ds", "--out", "twins-psych-ds"]);
}
