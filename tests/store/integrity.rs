//! Changes after a session are found: resuming refuses them or records them for good, `machband verify` reports them, the
//! session after a deleted one reveals it, and a repair deletes no byte.

use std::{
    fs,
    path::{Path, PathBuf},
};

use jiff::Timestamp;
use machband::store::{
    check, dataset,
    results::FRAMES_HEADER,
    session::{Changes, Interrupted, SessionStore, repair},
    sidecar::Sidecar,
};

use crate::{
    common::{change_rating, edit, machband, refused, session_csv, set_cell, succeeds, text, verified},
    recording::{self, SEED, create, identity, paths, resume, sitting, small},
};

/// Rates up to `limit` trials, and ends the sitting.
fn sit(store: &mut SessionStore, found: Option<&Interrupted>, limit: usize) {
    recording::rate(store, (&small(), &identity()), found, limit, false).unwrap();
    if !store.is_complete() {
        store.finish(false, Timestamp::now().to_string(), None).unwrap();
    }
}

/// A session whose first sitting ended after this many rows.
fn ended(rows: usize) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    sit(&mut create(folder.path()).unwrap(), None, rows);
    let csv = paths(folder.path()).csv;
    (folder, csv)
}

fn accept(results: &Path) -> (SessionStore, Interrupted) {
    SessionStore::resume(results, &small(), &identity(), Some(SEED), sitting(), Changes::Accept).unwrap()
}

fn edit_sidecar(csv: &Path, change: impl FnOnce(&mut Sidecar)) {
    let path = csv.with_extension("json");
    let mut sidecar = Sidecar::read(&path).unwrap().unwrap();
    change(&mut sidecar);
    sidecar.write(&path).unwrap();
}

fn without_last_row(text: &str) -> String {
    text[..=text.trim_end().rfind('\n').unwrap()].to_owned()
}

/// The errors of a session as one text.
fn errors(csv: &Path) -> String {
    verified(csv).errors.iter().map(|error| format!("{error}\n")).collect()
}

/// Writes a frames file.
fn with_frames(csv: &Path, content: &str) {
    let frames = csv.to_str().unwrap().replace("_data.csv", "_frames.csv");
    fs::write(frames, content).unwrap();
}

#[test]
fn resuming_refuses_a_changed_session_or_records_the_change_permanently() {
    type Touch = fn(&Path);
    let ways: [(&str, usize, Touch); 5] = [
        ("a rating of an ended sitting", 3, change_rating),
        ("a rating and the last row of a complete session", 6, |csv| {
            change_rating(csv);
            edit(csv, without_last_row);
        }),
        ("every row", 3, |csv| fs::write(csv, "").unwrap()),
        ("the seal", 6, |csv| edit_sidecar(csv, |sidecar| sidecar.sittings[0].seal = None)),
        // Nothing was shown on a screen, so there are no frames.
        ("the frames, of which there were none", 3, |csv| with_frames(csv, &format!("{FRAMES_HEADER}\n"))),
    ];
    for (what, rows, touch) in ways {
        let (folder, csv) = ended(rows);
        touch(&csv);
        assert!(check::check(&csv).is_err(), "{what}");
        let error = refused(folder.path(), || resume(folder.path()));
        assert_eq!(error.remedy(), Some("accept_changes"), "{what}: {error}");
        let error = error.to_string();
        assert!(error.contains("seal") || error.contains("was changed since"), "{what}: {error}");
        assert_eq!(error.contains(" rows instead of "), what.contains("row"), "{what}: {error}");
        let (mut store, found) = accept(folder.path());
        sit(&mut store, Some(&found), usize::MAX);
        drop(store);
        assert_eq!(errors(&csv), "", "{what}");
        let notes = verified(&csv).notes.join("; ");
        assert!(notes.contains("accepted"), "{what}: {notes}");
        let has_hashes = notes.contains(": sha256 ") && notes.contains("; expected ");
        assert!(has_hashes || what.starts_with("the "), "{what}: {notes}");
    }
}

/// Records a session of another participant in the same folder, up to `limit` trials.
fn record(results: &Path, subject: &str, limit: usize) -> PathBuf {
    let mut store = recording::record(results, subject, limit);
    if !store.is_complete() {
        store.finish(false, Timestamp::now().to_string(), None).unwrap();
    }
    store.csv().to_owned()
}

/// The notes of `verify` about gaps in the chain of sessions.
fn notes(csv: &Path) -> String {
    let notes = verified(csv).notes.into_iter();
    notes.filter(|note| note.contains("which ended before this session")).collect::<Vec<_>>().join("; ")
}

#[test]
fn the_session_after_a_deleted_one_reveals_it() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["S001", "S002", "S003"].map(|subject| record(folder.path(), subject, usize::MAX));
    assert_eq!(files.each_ref().map(|csv| (errors(csv), notes(csv))), [(); 3].map(|()| Default::default()));
    let sidecar = |csv: &Path| Sidecar::read(&csv.with_extension("json")).unwrap().unwrap();
    assert_eq!(sidecar(&files[0]).sittings[0].previous, None);
    // Other ratings under a valid seal.
    let forged = tempfile::tempdir().unwrap();
    let other = record(forged.path(), "S002", 2);
    let copy = |from: &Path, to: &Path| {
        for extension in ["csv", "json"] {
            fs::copy(from.with_extension(extension), to.with_extension(extension)).unwrap();
        }
    };
    let kept = forged.path().join("kept.csv");
    copy(&files[1], &kept);
    copy(&other, &files[1]);
    assert_eq!(errors(&files[1]), "");
    let expected = "S002_session-1_task-smallone_data.csv, which ended before this session, was replaced";
    assert!(notes(&files[2]).contains(expected), "{}", notes(&files[2]));
    copy(&kept, &files[1]);
    assert_eq!(notes(&files[2]), "");
    for extension in ["csv", "json"] {
        fs::remove_file(files[1].with_extension(extension)).unwrap();
    }
    let said = succeeds(folder.path(), &["verify", "small-one"]);
    assert!(said.contains("S002_session-1_task-smallone_data.csv, which ended before this session, is no longer here"));
    assert_eq!(errors(&files[2]), "");
}

#[test]
fn neither_resuming_nor_repairing_nor_concurrent_sessions_leave_a_gap() {
    let (folder, csv) = ended(3);
    let second = record(folder.path(), "S002", usize::MAX);
    let previous = Sidecar::read(&second.with_extension("json")).unwrap().unwrap().sittings[0].previous.clone();
    assert!(previous.unwrap().data_file.starts_with("subject-S001"));
    // A repair, a killed sitting, a sitting that ended early, and a complete one.
    edit(&csv, |text| text.to_owned() + "damaged\n");
    assert_eq!(repair(&csv).unwrap().lines, [5]);
    assert_eq!(notes(&second), "");
    let (mut store, found) = resume(folder.path()).unwrap();
    recording::rate(&mut store, (&small(), &identity()), Some(&found), 1, false).unwrap();
    let between = record(folder.path(), "S003", usize::MAX);
    drop(store);
    for limit in [1, usize::MAX] {
        let (mut store, found) = resume(folder.path()).unwrap();
        sit(&mut store, Some(&found), limit);
    }
    let last = record(folder.path(), "S004", usize::MAX);
    for csv in [&second, &between, &last] {
        assert_eq!((errors(csv), notes(csv)), Default::default());
    }
    assert_eq!((errors(&csv), notes(&csv)), Default::default());
}

#[cfg(feature = "window")]
#[test]
fn a_complete_session_is_not_run_again() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["simulate", "quick"]);
    let resume = ["run", "quick", "--participant", "S001", "--resume"];
    assert!(succeeds(folder.path(), &resume).contains("is already complete"));
}

/// After each of these edits, every row is still planned and can be read.
#[test]
fn rows_that_no_session_could_have_recorded_are_reported() {
    let (_folder, csv) = ended(usize::MAX);
    let whole = fs::read_to_string(&csv).unwrap();
    // Exchanges the cells `from` to `to` of two rows; the other cells stay in their place.
    let exchanged = |text: &str, a: usize, b: usize, from: usize, to: usize| {
        let mut rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        let (left, right) = (rows[a][from..to].to_vec(), rows[b][from..to].to_vec());
        rows[a].splice(from..to, right);
        rows[b].splice(from..to, left);
        rows.iter().map(|row| row.join(",") + "\n").collect::<String>()
    };
    // The color has two commas, so the rating is cell 18, and the measured times follow, up to `started_at`.
    let cells = whole.lines().last().unwrap().split(',').count();
    let swapped = |a: usize, b: usize| exchanged(&whole, a, b, 0, cells);
    let cases = [
        (exchanged(&swapped(4, 5), 4, 5, 18, 25), "not in the planned order"),
        (exchanged(&swapped(2, 3), 2, 3, 18, 25), "not in the planned order"),
        (swapped(4, 5), "was recorded before the row above it"),
        (exchanged(&whole, 4, 5, 18, 24), "was recorded before the row above it"),
        (exchanged(&whole, 4, 6, 24, 25), "differs in onset_s and started_at"),
        (whole.replace("_main_0003_1,", "_main_0003_0,").replace(",main,1,3,1,", ",main,1,3,0,"), "is attempt 0"),
        (whole.replace("_main_0003_1,", "_main_0003_2,").replace(",main,1,3,1,", ",main,1,3,2,"), "is attempt 2"),
    ];
    for (content, expected) in cases {
        assert_ne!(content, whole, "{expected}");
        fs::write(&csv, &content).unwrap();
        let error = check::check(&csv).map(|_| ()).expect_err(expected).to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
    fs::write(&csv, &whole).unwrap();
    check::check(&csv).unwrap();
}

#[test]
fn repair_moves_damaged_lines_and_deletes_no_byte() {
    let (folder, csv) = ended(5);
    let whole = fs::read_to_string(&csv).unwrap();
    let lines: Vec<&str> = whole.split_inclusive('\n').collect();
    // The beginning of row 3 and the end of row 4 are gone.
    let damaged = [lines[3].split_at(40).1, lines[4].trim_end().split_at(90).0, "\n"].concat();
    let (head, tail) = (lines[..3].concat(), lines[5..].concat());
    fs::write(&csv, [&*head, &*damaged, &*tail].concat()).unwrap();
    assert!(SessionStore::resume(folder.path(), &small(), &identity(), None, sitting(), Changes::Accept).is_err());
    let said = succeeds(folder.path(), &["repair", csv.to_str().unwrap()]);
    let aside = csv.with_file_name("subject-S001_session-1_task-smallone_data.csv.damaged-1");
    assert!(said.contains("damaged lines were moved to ") && said.contains("damaged-1: 4, 5"), "{said}");
    assert_eq!(fs::read_to_string(&csv).unwrap(), [head, tail].concat());
    assert_eq!(fs::read_to_string(&aside).unwrap(), damaged);
    assert!(succeeds(folder.path(), &["repair", "small-one"]).contains("_data.csv: no line is damaged"));
    // The lines were sealed, so a repair alone does not pass the file off as unchanged.
    let found = errors(&csv);
    assert!(found.lines().count() == 1 && found.contains("_data.csv: was changed since"), "{found}");
    assert!(resume(folder.path()).map(|_| ()).unwrap_err().remedy() == Some("accept_changes"));
    let (mut store, found) = accept(folder.path());
    assert_eq!(found.resumed.done.len(), 3);
    sit(&mut store, Some(&found), usize::MAX);
    drop(store);
    assert_eq!(errors(&csv), "");
    let notes = verified(&csv).notes.join("; ");
    assert!(notes.contains("repaired: damaged lines were moved"), "{notes}");
    check::check(&csv).unwrap();
    // A session that was killed is not sealed.
    let killed = tempfile::tempdir().unwrap();
    recording::rate(&mut create(killed.path()).unwrap(), (&small(), &identity()), None, 5, false).unwrap();
    let rows = paths(killed.path()).csv;
    edit(&rows, |text| text.replacen("S001_1_practice_0002", "2", 1).replacen(",small-one,", "", 2));
    let said = refused(killed.path(), || resume(killed.path())).to_string();
    assert!(said.contains("machband repair moves such lines"), "{said}");
    assert_eq!(repair(&rows).unwrap().lines, [2, 3]);
    assert_eq!(resume(killed.path()).unwrap().1.resumed.done.len(), 3);
    // A header that is damaged or gone follows from the rows; a repeated row is moved.
    let whole = fs::read_to_string(&csv).unwrap();
    let lines: Vec<&str> = whole.split_inclusive('\n').collect();
    let rows = &lines[1..];
    let moved = |damaged: &[&str]| {
        fs::write(&csv, damaged.concat()).unwrap();
        let before = repair(&csv).unwrap().lines;
        (before, fs::read_to_string(&csv).unwrap())
    };
    for header in [&["row_id,subj\n"][..], &["\0\0\0\n"], &[]] {
        assert_eq!(moved(&[header, rows].concat()), (if header.is_empty() { vec![] } else { vec![1] }, whole.clone()));
    }
    let files = || fs::read_dir(csv.parent().unwrap()).unwrap().count();
    let before = files();
    fs::write(&csv, rows.concat()).unwrap();
    let said = succeeds(folder.path(), &["repair", csv.to_str().unwrap()]);
    assert!(said.ends_with("_data.csv: the header was restored\n"), "{said}");
    assert_eq!((files(), fs::read_to_string(&csv).unwrap()), (before, whole.clone()));
    // The seal says how many rows are gone.
    fs::write(&csv, lines[0]).unwrap();
    let said = succeeds(folder.path(), &["repair", csv.to_str().unwrap()]);
    let expected = format!("no line is damaged; of the {} rows that were sealed, 0 are left\n", rows.len());
    assert!(said.ends_with(&expected), "{said}");
    let repeated = [&lines[..3], &lines[2..]].concat();
    assert_eq!(moved(&repeated), (vec![4], whole.clone()));
    // Rows in another order stay as they are: no intact row is moved.
    let mut swapped = lines.clone();
    swapped.swap(2, 3);
    fs::write(&csv, swapped.concat()).unwrap();
    let refused = || refused(folder.path(), || repair(&csv)).to_string();
    assert!(refused().contains("are not in the order"));
    fs::write(&csv, &whole).unwrap();
    set_cell(&csv, 4, "onset_s", "9.0000");
    assert!(refused().contains("are not in the order"));
    fs::write(&csv, &whole).unwrap();
    // The sidecar of another session does not make every row damaged.
    edit_sidecar(&csv, |sidecar| sidecar.seed = 8);
    assert!(refused().contains("no row is planned"));
}

#[test]
fn an_analysis_tells_missing_rows_and_a_repair_notes_them() {
    let folder = tempfile::tempdir().unwrap();
    recording::rate(&mut create(folder.path()).unwrap(), (&small(), &identity()), None, 5, false).unwrap();
    let csv = paths(folder.path()).csv;
    let analyzed = || machband(folder.path(), &["counts", "small-one", "--out", "counts.csv", "--force"]);
    assert!(!text(&analyzed().stderr).contains("without a row"));
    // Rows 1 and 2 are practice, so this is the second main trial.
    edit(&csv, |text| text.split_inclusive('\n').enumerate().filter(|(i, _)| *i != 4).map(|(_, line)| line).collect());
    let gap = "row S001_1_main_0003_1 has no row of main trial 2 above it";
    assert!(errors(&csv).contains(&format!("_data.csv:5:1: {gap}")), "{}", errors(&csv));
    let warning = text(&analyzed().stderr);
    assert!(warning.contains("main trials without a row, although later trials have one: 1"), "{warning}");
    assert!(succeeds(folder.path(), &["repair", "small-one"]).contains("no line is damaged; rows are missing before"));
    assert!(verified(&csv).notes.join("; ").contains("repaired: no line is damaged; rows are missing"));
    assert!(succeeds(folder.path(), &["repair", "small-one"]).contains("_data.csv: no line is damaged\n"));
    let (mut store, found) = resume(folder.path()).unwrap();
    sit(&mut store, Some(&found), usize::MAX);
    assert!(!text(&analyzed().stderr).contains("without a row"));
}

/// Records one session of `quick` with the simulated observer.
fn recorded() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["simulate", "quick", "--seed", "5"]);
    let csv = session_csv(&folder.path().join("results"), "quick", "S001");
    (folder, csv)
}

/// Without a seal, the hash of the definition still shows that it was changed.
#[test]
fn a_changed_definition_is_noticed_without_a_seal() {
    let (folder, csv) = recorded();
    edit_sidecar(&csv, |sidecar| {
        let sitting = &mut sidecar.sittings[0];
        (sitting.complete, sitting.ended_at, sitting.seal) = (false, None, None);
    });
    edit(&csv, |text| text.lines().take(9).map(|line| format!("{line}\n")).collect());
    assert_eq!(errors(&csv), "");
    edit(&csv.with_extension("json"), |text| text.replacen("\"duration_s\": 2.0", "\"duration_s\": 3.0", 1));
    let found = errors(&csv);
    assert!(found.lines().count() == 1 && found.contains("the definition has sha256"), "{found}");
    for (command, status) in [
        (&["counts", "results", "--out", "c.csv"][..], 0),
        (&["export", "results", "--format", "bids", "--out", "out"], 1),
        (&["simulate", "quick", "--seed", "5", "--resume"], 1),
    ] {
        let output = machband(folder.path(), command);
        let is_said = text(&output.stderr).contains("the definition has sha256");
        assert!(output.status.code() == Some(status) && is_said, "{command:?}: {output:?}");
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
