//! Edits recorded sessions by rule, and tests which commands notice each edit. `docs/faults.md` ends with the resulting
//! tables.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use machband::{
    experiment::Identity,
    store::{
        check::check,
        dataset,
        export::{Choice, Format, export},
        ratings::{Listed, ReadOptions},
        recorded,
        session::{Changes, SessionStore},
        sidecar::{Pictures, Sitting},
    },
    work::Study,
};
use serde_json::Value;

use crate::{
    common::{
        self, assert_documented,
        attacks::{LIES, withstood},
        edit, everything, json, set_cell,
    },
    recording::{SEED, identity, rate, sitting, small},
};

/// The commands that look at a session. The analysis page shows the same errors and warnings as `analyze`.
const WHO: [&str; 5] = ["verify", "check", "resume", "analyze", "export"];

/// How the session was left before it was edited.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// Its two sittings ended, and every trial is rated.
    Complete,
    /// Its only sitting ended before every trial was rated.
    Interrupted,
    /// The program was killed in its first sitting, so there is no seal.
    Killed,
}

impl State {
    fn sentence(self) -> &'static str {
        match self {
            Self::Complete => "complete, two sittings",
            Self::Interrupted => "ended early, one sitting",
            Self::Killed => "killed, not sealed",
        }
    }
}

/// The columns that follow from the definition, the seed, the identity and the sidecar of the session.
const PLANNED: &str = "row_id experiment subject_id session_id phase block trial attempt repetition stimulus width depth \
    orientation_deg low high color sitting seed";

/// An edit of a results folder.
struct Edit {
    class: &'static str,
    name: String,
    make: Box<dyn Fn(&Path)>,
}

/// The files of the session that is edited, relative to the results folder.
const DATA: &str = "small-one/data/subject-S001_session-1_task-smallone_data.csv";
const SIDECAR: &str = "small-one/data/subject-S001_session-1_task-smallone_data.json";
const FRAMES: &str = "small-one/data/subject-S001_session-1_task-smallone_frames.csv";
const ALL: [&str; 3] = [DATA, SIDECAR, FRAMES];

/// Records two participants with corrections, frames and pictures.
fn record(results: &Path, state: State) {
    let protocol = small();
    let sitting = || Sitting { pictures: Some(Pictures::without_screen(&protocol)), ..sitting() };
    let stimuli: Vec<_> = protocol.conditions().iter().map(|condition| &condition.stimulus).collect();
    let hashes = Pictures::without_screen(&protocol).hashes(&stimuli);
    for (subject, longest) in [("S001", 33_333), ("S002", 50_000)] {
        let identity = Identity::new(subject, "1").unwrap();
        let frames = |store: &mut SessionStore, sitting: u32, trials: [u32; 2]| {
            let row = |trial| format!("{sitting},main,{trial},1,stimulus,16666.667,16667 16666 {longest}\n");
            store.append_frames(&trials.map(row));
            store.note_pictures(stimuli.iter().copied().zip(hashes.iter().cloned()));
        };
        let (mut store, _) = SessionStore::create(results, &protocol, &identity, SEED, sitting()).unwrap();
        rate(&mut store, (&protocol, &identity), None, 4, true).unwrap();
        frames(&mut store, 1, [1, 2]);
        if state != State::Killed {
            store.finish(false, "1970-01-01T00:01:00Z".to_owned(), None).unwrap();
        }
        drop(store);
        if state == State::Complete {
            let (mut store, found) =
                SessionStore::resume(results, &protocol, &identity, None, sitting(), Changes::Refuse).unwrap();
            frames(&mut store, 2, [3, 4]);
            rate(&mut store, (&protocol, &identity), Some(&found), usize::MAX, true).unwrap();
        }
    }
}

/// All edits of a session that was left in this state.
fn edits(results: &Path, state: State) -> Vec<Edit> {
    let mut edits = Vec::new();
    for (class, file) in [("rows and cells of the data", DATA), ("rows and cells of the frames", FRAMES)] {
        table(class, results, file, &mut edits);
    }
    if state == State::Killed {
        return edits;
    }
    ALL.into_iter().for_each(|file| whole_file(file, &mut edits));
    exchanged(&mut edits);
    if state == State::Complete {
        keys(&json(&results.join(SIDECAR)), "", &mut edits);
        let describing = ["dataset_description.json", "README.md", "CHANGES.md", ".psychds-ignore"];
        for file in describing {
            let make = move |results: &Path| edit(&results.join("small-one").join(file), changed);
            let class = "the description of the data set";
            edits.push(Edit { class, name: format!("{file} changed"), make: Box::new(make) });
        }
    }
    edits
}

/// Changes a text so that it usually stays plausible: its last digit, if it has one.
fn changed(text: &str) -> String {
    match text {
        "" => "1".to_owned(),
        "main" => "practice".to_owned(),
        "practice" => "main".to_owned(),
        "true" => "false".to_owned(),
        "null" | "false" => "true".to_owned(),
        _ => match text.rfind(|c: char| c.is_ascii_digit()) {
            Some(at) => {
                let digit = text.as_bytes()[at] - b'0';
                // Ratings range from 0 to 3.
                let other = if digit == 3 { 2 } else { (digit + 1) % 10 };
                format!("{}{other}{}", &text[..at], &text[at + 1..])
            }
            None => format!("{text}x"),
        },
    }
}

/// Adds edits that make sense for any file.
fn whole_file(file: &'static str, edits: &mut Vec<Edit>) {
    type Way = fn(&Path);
    let ways: [(&str, Way); 6] = [
        ("deleted", |path| fs::remove_file(path).unwrap()),
        ("emptied", |path| fs::write(path, "").unwrap()),
        ("cut in half", |path| edit(path, |text| text[..text.len() / 2].to_owned())),
        ("without its last byte", |path| edit(path, |text| text[..text.len() - 1].to_owned())),
        ("with another letter", |path| edit(path, |text| format!("{text}x"))),
        ("with another line end", |path| edit(path, |text| format!("{text}\n"))),
    ];
    for (way, make) in ways {
        let name = format!("{} {way}", file.rsplit('_').next().unwrap());
        let make = Box::new(move |results: &Path| make(&results.join(file)));
        edits.push(Edit { class: "files as a whole", name, make });
    }
}

/// Adds edits of the rows and cells of a table.
fn table(class: &'static str, results: &Path, file: &'static str, edits: &mut Vec<Edit>) {
    type Way = fn(&mut Vec<String>);
    let ways: [(&str, Way); 10] = [
        ("first row deleted", |lines| drop(lines.remove(1))),
        ("second row deleted", |lines| drop(lines.remove(2))),
        ("last row deleted", |lines| drop(lines.pop())),
        ("last row repeated", |lines| lines.extend_from_within(lines.len() - 1..)),
        ("first row repeated at the end", |lines| lines.extend_from_within(1..2)),
        ("first two rows swapped", |lines| lines.swap(1, 2)),
        ("rows reversed", |lines| lines[1..].reverse()),
        ("header deleted", |lines| drop(lines.remove(0))),
        ("line ends of Windows", |lines| lines.iter_mut().for_each(|line| line.push('\r'))),
        ("a byte order mark", |lines| lines[0].insert(0, '\u{feff}')),
    ];
    for (name, change) in ways {
        let make = move |results: &Path| {
            edit(&results.join(file), |text| {
                let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
                change(&mut lines);
                lines.join("\n") + "\n"
            });
        };
        edits.push(Edit { class, name: name.to_owned(), make: Box::new(make) });
    }
    let (header, rows) = common::table(&results.join(file));
    for (row, which) in [(0, "first"), (rows.len() - 1, "last")] {
        for (column, cell) in header.iter().cloned().zip(&rows[row]) {
            let (name, cell) = (format!("{column} in the {which} row"), changed(cell));
            let make = move |results: &Path| set_cell(&results.join(file), row + 2, &column, &cell);
            edits.push(Edit { class, name, make: Box::new(make) });
        }
    }
}

/// Adds edits that remove and change every key of a sidecar, down to the fourth level.
fn keys(value: &Value, path: &str, edits: &mut Vec<Edit>) {
    let children: Vec<(String, &Value)> = match value {
        Value::Object(map) => map.iter().map(|(key, value)| (key.clone(), value)).collect(),
        Value::Array(items) if items.iter().any(Value::is_object) => {
            items.iter().enumerate().map(|(index, value)| (index.to_string(), value)).collect()
        }
        _ => return,
    };
    // One column, and one text of the instructions, stand for all of them.
    let is_typical = |key: &str| match path {
        "/columns" => key == "rating",
        "/definition/instructions" => key == "task",
        _ => true,
    };
    for (key, child) in children.into_iter().filter(|(key, _)| is_typical(key)) {
        let pointer = format!("{path}/{}", key.replace('/', "~1"));
        for removed in [true, false] {
            let (parent, key, at) = (path.to_owned(), key.clone(), pointer.clone());
            let make = move |results: &Path| {
                let path = results.join(SIDECAR);
                let mut sidecar = json(&path);
                match (removed, sidecar.pointer_mut(if removed { &parent } else { &at }).unwrap()) {
                    (true, Value::Object(map)) => drop(map.remove(&key)),
                    (true, Value::Array(items)) => drop(items.remove(key.parse().unwrap())),
                    (_, Value::Object(map)) => drop(map.insert("added".to_owned(), 1.into())),
                    (_, Value::Array(items)) => items.push(Value::Null),
                    (_, Value::String(text)) => *text = changed(text),
                    (_, other) => *other = serde_json::from_str(&changed(&other.to_string())).unwrap(),
                }
                fs::write(&path, sidecar.to_string()).unwrap();
            };
            let what = match child {
                _ if removed => "removed",
                Value::Object(_) => "with another key",
                _ => "changed",
            };
            edits.push(Edit { class: "keys of the sidecar", name: format!("{pointer} {what}"), make: Box::new(make) });
        }
        if pointer.matches('/').count() < 4 && pointer != "/@context" {
            keys(child, &pointer, edits);
        }
    }
}

/// Adds edits that exchange, rename, copy or delete files of sessions.
fn exchanged(edits: &mut Vec<Edit>) {
    let mut add = |name: String, files: &'static [&'static str], way: fn(&Path, &str)| {
        let make = move |results: &Path| files.iter().for_each(|file| way(results, file));
        edits.push(Edit { class: "exchanged and renamed files", name, make: Box::new(make) });
    };
    fn named(results: &Path, file: &str, from: &str, to: &str) -> PathBuf {
        results.join(file.replace(from, to))
    }
    let files: [(&str, &[&str]); 4] =
        [("data.csv", &ALL[..1]), ("data.json", &ALL[1..2]), ("frames.csv", &ALL[2..]), ("all files", &ALL)];
    for (which, files) in files {
        add(format!("{which} of another participant"), files, |results, file| {
            fs::copy(named(results, file, "S001", "S002"), results.join(file)).map(drop).unwrap();
        });
        add(format!("{which} renamed to a new participant"), files, |results, file| {
            fs::rename(results.join(file), named(results, file, "S001", "S003")).unwrap();
        });
        add(format!("{which} copied to a new session"), files, |results, file| {
            fs::copy(results.join(file), named(results, file, "session-1", "session-2")).map(drop).unwrap();
        });
    }
    add("all files deleted".to_owned(), &ALL, |results, file| fs::remove_file(results.join(file)).unwrap());
}

fn copy(from: &Path, to: &Path) {
    for (path, content) in everything(from) {
        let path = to.join(path.strip_prefix(from).unwrap());
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }
}

/// Returns which of [`WHO`] report something about these results. Resuming comes last because it may change them.
fn seen(results: &Path, renderer: &mut recorded::Renderer) -> [bool; 5] {
    let files = Listed::sessions(results).files;
    let data_set = results.join("small-one");
    let mut is_noticed = |csv: &PathBuf| {
        let found = recorded::verify(csv, renderer);
        !found.errors.is_empty() || found.notes.iter().any(|note| note.contains("which ended before this session"))
    };
    let verified = files.iter().any(&mut is_noticed) || !dataset::unexpected_files(&data_set).is_empty();
    let tables = fs::read_dir(data_set.join("data")).unwrap().flatten().map(|entry| entry.path());
    let mut tables = tables.filter(|path| path.extension().is_some_and(|extension| extension == "csv"));
    let checked = tables.any(|path| check(path).is_err());
    let options = ReadOptions { details: true, ..ReadOptions::default() };
    let analyzed = match Study::read(&[results.to_owned()], &options) {
        Ok(study) => !study.source.errors.is_empty() || !study.source.warnings.is_empty(),
        Err(_) => true,
    };
    let exported = tempfile::tempdir().unwrap();
    let exported = export(results, &exported.path().join("out"), Format::PsychDs, Choice::default()).is_err();
    let resumed = SessionStore::resume(results, &small(), &identity(), None, sitting(), Changes::Refuse).is_err();
    [verified, checked, resumed, analyzed, exported]
}

/// The edits that some command does not notice: their names (after an asterisk, the end of the names), the commands
/// that do not notice them, and why that is right. Without a seal, other rules apply; see [`PLANNED`].
const STATED: [(&[&str], &[&str], &str); 10] = [
    (
        &["data.json without its last byte", "data.json with another line end"],
        &WHO,
        "The layout of a sidecar is not its content.",
    ),
    (
        &[
            "/@context removed",
            "/sittings/0 with another key",
            "/sittings/1 with another key",
            "*/program with another key",
            "*/pictures with another key",
            "*/seal with another key",
        ],
        &WHO,
        "Keys that the program does not know are not read, and a missing `@context` is the usual one.",
    ),
    (
        &[
            "/sittings/1/seal/data_bytes changed",
            "/sittings/1/seal/data_rows changed",
            "/sittings/1/seal/frames_bytes removed",
            "/sittings/1/seal/frames_bytes changed",
            "/sittings/1/seal/frames_sha256 removed",
        ],
        &WHO,
        "Anyone who edits a seal can make a new one.",
    ),
    (
        &["dataset_description.json changed", "README.md changed", "CHANGES.md changed", ".psychds-ignore changed"],
        &WHO,
        "People may describe their data set.",
    ),
    (&["data.csv deleted"], &["export"], "It reads the data files that exist, and notes which sidecars have none."),
    (
        &["all files deleted"],
        &["check", "analyze", "export"],
        "They read the files that exist; `verify` misses the others from the session that ended next.",
    ),
    (
        &["data.csv copied to a new session", "all files copied to a new session"],
        &["resume"],
        "The session that is resumed is unchanged.",
    ),
    (
        &["all files renamed to a new participant"],
        &["analyze"],
        "It takes the participant from the rows, which are unchanged.",
    ),
    (
        &["data.json copied to a new session"],
        &["check", "resume", "export"],
        "It belongs to no data file and is not read; an export notes it.",
    ),
    (
        &["frames.csv copied to a new session"],
        &["resume", "export"],
        "They belong to no data file and are not read; an export notes them.",
    ),
];

#[test]
fn every_command_notices_every_edit_except_those_listed() {
    let folder = tempfile::tempdir().unwrap();
    let mut renderer = recorded::Renderer::default();
    let mut table =
        format!("| session | edits of | edits | {} |\n|---|---|--:|--:|--:|--:|--:|--:|\n", WHO.join(" | "));
    let (mut reasons, mut wrong, mut sealed) = (vec![0; STATED.len()], Vec::new(), 0);
    for state in [State::Complete, State::Interrupted, State::Killed] {
        let original = folder.path().join(format!("{state:?}"));
        record(&original, state);
        let mut seen_by = |make: &dyn Fn(&Path)| {
            let results = folder.path().join("edited");
            copy(&original, &results);
            make(&results);
            let said = seen(&results, &mut renderer);
            fs::remove_dir_all(&results).unwrap();
            said
        };
        assert_eq!(seen_by(&|_| ()), [false; 5], "an unchanged session, {state:?}");
        for edits in edits(&original, state).chunk_by(|a, b| a.class == b.class) {
            let mut counts = [0; WHO.len()];
            for Edit { name, make, .. } in edits {
                let said = seen_by(make);
                sealed += if state == State::Killed { 0 } else { WHO.len() };
                said.iter().zip(&mut counts).for_each(|(said, count)| *count += usize::from(*said));
                let is = |part: &&str| part.strip_prefix('*').map_or(name == part, |end| name.ends_with(end));
                let stated = STATED.iter().position(|(names, ..)| state != State::Killed && names.iter().any(is));
                let expected = WHO.map(|who| !stated.is_some_and(|index| STATED[index].1.contains(&who)));
                stated.into_iter().for_each(|index| reasons[index] += 1);
                if state == State::Killed {
                    // Without a seal, only what follows from the definition and the seed can be checked.
                    let planned = PLANNED.split(' ').any(|column| name.starts_with(&format!("{column} in")))
                        || ["first row deleted", "second row deleted"].contains(&name.as_str());
                    if planned && edits[0].class.ends_with("data") && !(said[0] && said[1] && said[2] && said[4]) {
                        wrong.push(format!("{state:?}: {name}: {said:?}"));
                    }
                } else if said != expected {
                    wrong.push(format!("{state:?}: {name}: {said:?}"));
                }
            }
            let (class, all) = (edits[0].class, edits.len());
            let counts = counts.map(|count| count.to_string()).join(" | ");
            writeln!(table, "| {} | {class} | {all} | {counts} |", state.sentence()).unwrap();
        }
    }
    table += "\n| edits | not seen by | because |\n|--:|---|---|\n";
    for ((_, who, why), number) in STATED.iter().zip(reasons) {
        let who = if who.len() == WHO.len() { "anyone".to_owned() } else { who.join(", ") };
        writeln!(table, "| {number} | {who} | {why} |").unwrap();
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    withstood("edits of a sealed session, with five commands", sealed, &[LIES]);
    let page = fs::read_to_string("docs/faults.md").unwrap();
    assert_documented("docs/faults.md", &format!("{}{table}", &page[..page.find("| session | edits of").unwrap()]));
}
