//! What cannot be read is not absent: readers say so and conclude nothing, and exports are snapshots.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
};

use machband::{
    store::{
        export::{Choice, Exported, Format, export},
        ratings::{Listed, ReadOptions},
        session::repair,
    },
    work::Study,
};

use crate::{
    common::{command, everything, fails, machband, refused, rows, session_csv, skip, succeeds, text, verified},
    recording::{record, small},
};

const FORMATS: [Format; 2] = [Format::Bids, Format::PsychDs];

fn csv(results: &Path, subject: &str) -> PathBuf {
    session_csv(results, "small-one", subject)
        .with_file_name(format!("subject-{subject}_session-1_task-smallone_data.csv"))
}

#[test]
fn nothing_is_verified_only_if_nothing_is_there() {
    let scratch = tempfile::tempdir().unwrap();
    let results = scratch.path().join("results");
    record(&results, "S001", usize::MAX);
    fs::rename(results.join("small-one"), results.join(".small-one")).unwrap();
    for command in
        [&["verify", "results"][..], &["repair", "results"], &["export", "results", "--format", "bids", "--out", "out"]]
    {
        let said = fails(scratch.path(), command, 1);
        assert!(said.contains("contains no session data files"), "{said}");
        assert!(said.contains(".small-one: is a hidden data set and was not read"), "{said}");
    }
    // A hidden folder is a warning as soon as there is something to read.
    record(&results, "S002", usize::MAX);
    let output = command(scratch.path(), &["verify", "results"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("1 session verified; no errors"), "{}", text(&output.stdout));
    assert!(text(&output.stderr).contains("is a hidden data set and was not read"), "{}", text(&output.stderr));
}

/// A folder of another user, such as `lost+found`, is a warning; one of the same user is an error. The rest is examined.
#[cfg(target_os = "linux")]
#[test]
fn folders_that_cannot_be_read_are_named_and_the_rest_is_examined() {
    use std::os::unix::fs::{PermissionsExt as _, chown};

    const OTHER: u32 = 65534;
    let scratch = tempfile::tempdir().unwrap();
    let results = scratch.path().join("results");
    record(&results, "S001", usize::MAX);
    let own = |path: &Path| chown(path, Some(OTHER), Some(OTHER));
    if own(scratch.path()).is_err() {
        return skip("ROOT", "folders of other users: only root can give a folder to somebody else");
    }
    let program = scratch.path().join("machband");
    fs::copy(env!("CARGO_BIN_EXE_machband"), &program).unwrap();
    everything(&results).iter().for_each(|(path, _)| own(&results.join(path)).unwrap());
    [&results, &results.join("small-one"), &results.join("small-one/data")].iter().for_each(|path| own(path).unwrap());
    let run = |arguments: &[&str]| {
        let ids = ["--reuid=65534", "--regid=65534", "--clear-groups", "./machband"];
        let mut command = std::process::Command::new("setpriv");
        let output = command.current_dir(scratch.path()).args(ids).args(arguments).output().unwrap();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let commands = [
        &["verify", "results"][..],
        &["repair", "results"],
        &["counts", "results", "--out", "counts.csv"],
        &["analyze", "results", "--tables-only", "--out", "analysis"],
        &["export", "results", "--format", "psych-ds", "--out", "out"],
    ];
    let locked = results.join("lost+found");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o700)).unwrap();
    for command in commands {
        let (status, out, said) = run(command);
        assert_eq!(status, Some(0), "{command:?}: {out}{said}");
        let all = format!("{out}{said}");
        assert!(all.contains("lost+found: belongs to another user and cannot be read"), "{command:?}: {all}");
    }
    fs::remove_dir_all(scratch.path().join("analysis")).unwrap();
    fs::remove_dir_all(scratch.path().join("out")).unwrap();
    fs::remove_file(scratch.path().join("counts.csv")).unwrap();
    fs::create_dir(results.join("own")).unwrap();
    own(&results.join("own")).unwrap();
    fs::set_permissions(results.join("own"), fs::Permissions::from_mode(0o000)).unwrap();
    for command in commands {
        let (status, out, said) = run(command);
        assert_eq!(status, Some(1), "{command:?}: {out}{said}");
        assert!(said.contains("own: the folder cannot be read: Permission denied"), "{command:?}: {said}");
    }
    // The data are there, but they cannot be searched.
    fs::set_permissions(results.join("small-one/data"), fs::Permissions::from_mode(0o000)).unwrap();
    for command in commands {
        let (status, _, said) = run(command);
        assert!(status == Some(1) && said.contains("Permission denied") && !said.contains("no longer"), "{said}");
    }
}

/// Whatever a session does meanwhile, the table of an export has the rows of its source data, and nothing counts as
/// changed.
#[test]
fn an_export_is_a_snapshot() {
    let scratch = tempfile::tempdir().unwrap();
    let results = scratch.path().join("results");
    record(&results, "S000", usize::MAX);
    let running = record(&results, "S001", 3);
    // A killed program left this file, and the locks of the operating system work.
    fs::write(csv(&results, "S000").with_extension("csv.lock"), "").unwrap();
    assert!(!verified(&csv(&results, "S000")).notes.join("; ").contains("is recording"));
    let out = |name: String| scratch.path().join(name);
    for format in FORMATS {
        let to = out(format!("{format:?}"));
        let exported = export(&results, &to, format, Choice::default()).unwrap();
        assert_eq!(exported.sessions, 1);
        let notes = exported.notes.join("\n");
        assert!(notes.contains("S001_session-1") && notes.contains("is recording this session"), "{notes}");
    }
    drop(running);
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            (2..60).for_each(|number| drop(record(&results, &format!("S{number:03}"), usize::MAX)));
            ended.store(true, Ordering::Relaxed);
        });
        let mut copies = 0;
        while !ended.load(Ordering::Relaxed) {
            let to = out(format!("copy-{copies}"));
            let Exported { sessions, rows: of_tables, notes, .. } =
                export(&results, &to, Format::Bids, Choice::default()).unwrap();
            let listed = Listed::sessions(&to.join("sourcedata")).files;
            let of_source: usize = listed.iter().map(|csv| rows(csv, &small()).len()).sum();
            let tables = everything(&to).into_iter().filter(|(path, _)| path.to_string_lossy().ends_with("_beh.tsv"));
            let of_files: usize = tables.map(|(_, table)| text(&table).lines().count() - 1).sum();
            assert_eq!((listed.len(), of_source, of_files), (sessions, of_tables, of_tables));
            assert!(!notes.iter().any(|note| note.contains("changed")), "{notes:?}");
            copies += 1;
        }
        assert!(copies > 1);
    });
}

#[test]
fn the_descriptions_of_two_labs_are_not_mixed_up() {
    let scratch = tempfile::tempdir().unwrap();
    let both = scratch.path().join("both");
    let [a, b] = ["a", "b"].map(|lab| both.join(lab));
    record(&a, "S001", usize::MAX);
    record(&b, "S002", usize::MAX);
    let exported = |format: Format| {
        let to = tempfile::tempdir().unwrap();
        export(&both, &to.path().join("out"), format, Choice::default()).map_err(|error| error.to_string())
    };
    for format in FORMATS {
        assert_eq!(exported(format).unwrap().sessions, 2);
        for (name, of_a, of_b) in [
            ("LICENSE", "CC0", "CC-BY-4.0"),
            ("CHANGES.md", "2026-01-01: a", "2026-02-02: b"),
            ("dataset_description.json", r#"{"author": ["A"]}"#, r#"{"author": ["B"]}"#),
        ] {
            let [a, b] = [&a, &b].map(|lab| lab.join("small-one").join(name));
            let before = fs::read(&a).ok();
            fs::write(&a, of_a).unwrap();
            fs::write(&b, of_b).unwrap();
            let error = exported(format).unwrap_err();
            let expected = format!("{}: differs from {}", b.display(), a.display());
            assert!(error.starts_with(&expected), "{format:?} {name}: {error}");
            // What one lab says, such as its license, does not hold for the data of the other.
            fs::remove_file(&a).unwrap();
            let error = exported(format).unwrap_err();
            let expected = format!("{}: is missing, but there is {}", a.display(), b.display());
            assert!(error.starts_with(&expected), "{format:?} {name}: {error}");
            fs::write(&a, of_a).unwrap();
            [&a, &b].iter().for_each(|path| {
                before.as_ref().map_or_else(|| fs::remove_file(path), |text| fs::write(path, text)).unwrap()
            });
        }
    }
}

#[test]
fn repair_leaves_a_file_that_another_program_saved_as_it_is() {
    let scratch = tempfile::tempdir().unwrap();
    record(scratch.path(), "S001", usize::MAX);
    let csv = csv(scratch.path(), "S001");
    let whole = fs::read_to_string(&csv).unwrap();
    let utf_16: Vec<u8> = whole.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for saved in [whole.replace(',', ";").into_bytes(), [&[0xff, 0xfe], &utf_16[..]].concat()] {
        fs::write(&csv, saved).unwrap();
        let error = refused(scratch.path(), || repair(&csv)).to_string();
        assert!(error.contains("lines are damaged, as if another program had saved the file"), "{error}");
    }
    // An analysis reads the UTF-16 text, but says that this is not the file that was sealed.
    let warnings = Study::read(&[csv], &ReadOptions::default()).unwrap().source.warnings;
    assert!(warnings.iter().any(|warning| warning.message.starts_with("was changed since")), "{warnings:?}");
}

/// What people do to the table by hand: no `sub-`, lower case, the line ends of an old spreadsheet. An export has the
/// answers, or says whose are missing.
#[test]
fn answers_survive_edits_by_hand() {
    let scratch = tempfile::tempdir().unwrap();
    let results = scratch.path().join("results");
    for subject in ["S001", "S002", "S003"] {
        record(&results, subject, usize::MAX);
    }
    let table = "participant_id\tage\rS001\t31\rSUB-s002\t32\r";
    fs::write(results.join("small-one/participants.tsv"), table).unwrap();
    for (format, copy) in [(Format::Bids, "participants.tsv"), (Format::PsychDs, "small-one/participants.tsv")] {
        let to = scratch.path().join(format!("{format:?}"));
        let notes = export(&results, &to, format, Choice::default()).unwrap().notes.join("\n");
        assert!(notes.contains("participants.tsv: has no row for S003"), "{notes}");
        let table = fs::read_to_string(to.join(copy)).unwrap();
        for (subject, age) in [("sub-S001", "31"), ("sub-S002", "32")] {
            let row = table.lines().find(|line| line.starts_with(subject)).unwrap();
            assert!(row.split('\t').any(|cell| cell == age), "{table}");
        }
    }
}

/// The data of a study are the same from whatever folder they are read, and so is what is missing.
#[test]
fn a_data_folder_is_one_under_any_path() {
    let scratch = tempfile::tempdir().unwrap();
    let results = scratch.path().join("results");
    for subject in ["S001", "S002"] {
        record(&results, subject, usize::MAX);
    }
    let study = results.join("small-one");
    fs::write(study.join("LICENSE"), "ours").unwrap();
    let mut places = vec![(study.clone(), "data"), (study.join("data"), ".")];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(study.join("data"), scratch.path().join("rows")).unwrap();
        places.push((scratch.path().to_owned(), "rows"));
    }
    for (i, (folder, name)) in places.iter().enumerate() {
        let out = scratch.path().join(format!("out{i}"));
        let said = machband(folder, &["export", name, "--format", "psych-ds", "--out", out.to_str().unwrap()]);
        assert!(said.status.success(), "{name}: {}", text(&said.stderr));
        assert_eq!(fs::read_to_string(out.join("small-one/LICENSE")).unwrap(), "ours", "{name}");
        let counts = scratch.path().join(format!("counts{i}.csv"));
        succeeds(folder, &["counts", name, "--out", counts.to_str().unwrap()]);
    }
    fs::remove_file(csv(&results, "S001")).unwrap();
    for (folder, name) in places {
        let said = text(&machband(&folder, &["verify", name]).stderr);
        assert!(said.contains("has no data file next to it"), "{name}: {said}");
    }
}
