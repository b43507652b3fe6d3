//! Exports: every row and cell is found again, pictures are those that were shown, nothing half or doubtful is written.

use std::{
    collections::{BTreeMap, HashMap},
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use machband::{
    experiment::columns,
    store::{
        export::{Exported, Format, export},
        image, pictures,
        ratings::data_files,
        recorded::Recorded,
        verify,
    },
};
use parquet::{
    file::reader::{FileReader as _, SerializedFileReader},
    record::Field,
};
use serde_json::{Value, json};

const FORMATS: [Format; 4] = [Format::Bids, Format::PsychDs, Format::Psychopy, Format::Parquet];

/// A folder that is there while the test runs.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("machband-export-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn simulate(results: &Path, more: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_machband"));
    let output = command.args(["simulate"]).args(more).arg("--results").arg(results).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn data(results: &Path, experiment: &str, subject: &str, end: &str) -> PathBuf {
    results.join(experiment).join("data").join(format!("subject-{subject}_session-1_task-{experiment}{end}"))
}

/// Writes a session as if it had been interrupted: `rows` whole ones, then a corrected response, then half a row.
fn interrupt(csv: &Path, rows: usize) {
    let text = fs::read_to_string(csv).unwrap();
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    // Attempt stands in the row's name and in a cell of its own.
    let last = lines[rows];
    let mut cells: Vec<String> = last.trim_end().split(',').map(str::to_owned).collect();
    let id = cells[0].strip_suffix("_1").unwrap().to_owned() + "_2";
    cells[0] = id;
    cells[7] = "2".to_owned();
    let corrected = cells.join(",") + "\n";
    fs::write(csv, lines[..=rows].concat() + &corrected + "S001_1_ma").unwrap();
    let sidecar = csv.with_file_name(csv.file_name().unwrap().to_str().unwrap().replace(".csv", ".json"));
    let mut value: Value = serde_json::from_slice(&fs::read(&sidecar).unwrap()).unwrap();
    value["complete"] = false.into();
    value.as_object_mut().unwrap().remove("seal");
    fs::write(&sidecar, value.to_string()).unwrap();
}

/// Two participants of `quick`, the first interrupted, corrected and resumed, the second interrupted and not resumed; and
/// a task with shaded meshes whose file is of an earlier version, without the last column.
fn study(results: &Path) {
    simulate(results, &["quick", "--participants", "2"]);
    simulate(results, &["shaders"]);
    interrupt(&data(results, "quick", "S001", "_data.csv"), 9);
    simulate(results, &["quick", "--participants", "1", "--resume"]);
    interrupt(&data(results, "quick", "S002", "_data.csv"), 7);
    let older = data(results, "shaders", "S001", "_data.csv");
    let text = fs::read_to_string(&older).unwrap();
    fs::write(&older, text.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned() + "\n").collect::<String>())
        .unwrap();
    let sidecar = data(results, "shaders", "S001", "_data.json");
    let mut value: Value = serde_json::from_slice(&fs::read(&sidecar).unwrap()).unwrap();
    value.as_object_mut().unwrap().remove("seal");
    fs::write(&sidecar, value.to_string()).unwrap();
}

fn sessions(results: &Path) -> Vec<Recorded> {
    data_files(results).unwrap().iter().map(|csv| Recorded::open(csv).unwrap()).collect()
}

/// Every row by its experiment and its name, as cells by column.
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

fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
    found
}

fn table(text: &str, separator: u8) -> Vec<HashMap<String, String>> {
    let mut reader = csv::ReaderBuilder::new().delimiter(separator).from_reader(text.as_bytes());
    reader.deserialize().map(|row| row.unwrap()).collect()
}

/// Rows of all tables that end so, by experiment and name.
fn tables(
    folder: &Path,
    end: &str,
    separator: u8,
    experiment: &str,
) -> BTreeMap<(String, String), HashMap<String, String>> {
    let mut all = BTreeMap::new();
    for (path, content) in files(folder) {
        let inside = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
        if !inside.ends_with(end) || inside.starts_with("sourcedata") || inside.starts_with("participants") {
            continue;
        }
        for row in table(std::str::from_utf8(&content).unwrap(), separator) {
            let key = (row[experiment].clone(), row["row_id"].clone());
            assert!(all.insert(key.clone(), row).is_none(), "{key:?} stands twice");
        }
    }
    all
}

fn written(results: &Path, to: &Path, format: Format) -> Exported {
    export(results, to, format, false).unwrap()
}

#[test]
fn every_cell_of_every_row_is_found_again_in_every_format() {
    let scratch = Scratch::new("cells");
    let results = scratch.at("results");
    study(&results);
    let expected = rows(&results);
    // 28 and a correction; 7 and a correction; 128.
    assert_eq!(expected.len(), 29 + 8 + 128);

    let bids = scratch.at("bids");
    let exported = written(&results, &bids, Format::Bids);
    assert_eq!((exported.sessions, exported.rows), (3, expected.len()));
    assert!(
        exported.notes.iter().any(|note| note.contains("S002") && note.contains("7 of 28")),
        "{:?}",
        exported.notes
    );
    let found = tables(&bids, ".tsv", b'\t', "experiment");
    assert_eq!(found.len(), expected.len());
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
            assert_eq!(found[key][name], cell, "{key:?} {name}");
        }
    }

    let psychopy = scratch.at("psychopy");
    written(&results, &psychopy, Format::Psychopy);
    let found = tables(&psychopy, ".csv", b',', "expName");
    assert_eq!(found.len(), expected.len());
    for (key, cells) in &expected {
        let row = &found[key];
        for (name, cell) in cells {
            let name = match name.as_str() {
                "experiment" => "expName",
                "subject_id" => "participant",
                "session_id" => "session",
                "response_time_s" => "key_resp.rt",
                other => other,
            };
            assert_eq!(&row[name], cell, "{key:?} {name}");
        }
        let (own, other) = if cells["phase"] == "practice" { ("practice", "trials") } else { ("trials", "practice") };
        let number: usize = cells["trial"].parse().unwrap();
        assert_eq!(row[&format!("{own}.thisN")], (number - 1).to_string());
        assert!(row[&format!("{other}.thisN")].is_empty());
        assert_eq!(row["stimulus.started"], cells["onset_s"]);
    }

    let psych_ds = scratch.at("psych-ds");
    written(&results, &psych_ds, Format::PsychDs);
    assert_eq!(rows(&psych_ds), expected);
    for csv in data_files(&psych_ds).unwrap() {
        let found = verify::session(&csv, &mut verify::Renderer::default());
        assert_eq!(found.faults, [], "{}", csv.display());
        assert!(Recorded::open(&csv).unwrap().torn.is_none());
    }

    let parquet = scratch.at("parquet");
    written(&results, &parquet, Format::Parquet);
    let mut found = 0;
    for experiment in ["quick", "shaders"] {
        let file = fs::File::open(parquet.join(format!("{experiment}.parquet"))).unwrap();
        for row in SerializedFileReader::new(file).unwrap().get_row_iter(None).unwrap() {
            let row = row.unwrap();
            let fields: HashMap<&String, &Field> = row.get_column_iter().collect();
            let Field::Str(id) = fields[&"row_id".to_owned()] else { panic!("a row's name is text") };
            let cells = &expected[&(experiment.to_owned(), id.clone())];
            assert_eq!(fields.len(), cells.len());
            for (name, cell) in cells {
                assert!(same(fields[name], cell), "{id} {name}: {:?} is not {cell:?}", fields[name]);
            }
            found += 1;
        }
    }
    assert_eq!(found, expected.len());
}

/// Whether a typed value is that of a cell.
fn same(field: &Field, cell: &str) -> bool {
    match field {
        Field::Null => cell.is_empty(),
        Field::Bool(value) => cell == u8::from(*value).to_string(),
        Field::Int(value) => cell == value.to_string(),
        Field::ULong(value) => cell == value.to_string(),
        Field::Double(value) => cell.parse::<f64>() == Ok(*value),
        Field::TimestampMillis(value) => {
            cell.parse::<jiff::Timestamp>().is_ok_and(|time| time.as_millisecond() == *value)
        }
        Field::Str(value) => cell == value,
        _ => false,
    }
}

#[test]
fn every_stim_file_is_the_picture_that_was_shown() {
    let scratch = Scratch::new("pictures");
    let (results, bids) = (scratch.at("results"), scratch.at("bids"));
    study(&results);
    let exported = written(&results, &bids, Format::Bids);
    let found = tables(&bids, ".tsv", b'\t', "experiment");
    let mut hashes = HashMap::new();
    for session in sessions(&results) {
        for row in &session.rows {
            let file = found[&(row.experiment.clone(), row.row_id.clone())]["stim_file"].clone();
            let pictures = session.sidecar.sittings[row.sitting as usize - 1].pictures.as_ref().unwrap();
            let shown = &pictures.sha256[&(session.condition(row).unwrap() + 1)];
            let hash = hashes.entry(file).or_insert_with_key(|file| {
                pictures::hash(&image::read(&bids.join("stimuli").join(file)).unwrap().image)
            });
            assert_eq!(hash, shown);
        }
    }
    // Each once, and none that nobody saw.
    assert_eq!(hashes.len(), exported.pictures);
    assert_eq!(fs::read_dir(bids.join("stimuli")).unwrap().count(), exported.pictures);

    // Another hash in a sidecar: what would be written is not what was shown.
    let sidecar = data(&results, "quick", "S001", "_data.json");
    let text = fs::read_to_string(&sidecar).unwrap();
    let shown = sessions(&results)[0].sidecar.sittings[0].pictures.clone().unwrap().sha256[&1].clone();
    fs::write(&sidecar, text.replace(&shown, &"0".repeat(64))).unwrap();
    let error = export(&results, &scratch.at("no"), Format::Bids, false).unwrap_err().to_string();
    assert!(error.contains("that of what was shown"), "{error}");
    assert!(!scratch.at("no").exists());
}

#[test]
fn equal_sessions_give_equal_bytes_from_any_of_their_folders() {
    let scratch = Scratch::new("equal");
    let results = scratch.at("results");
    simulate(&results, &["quick", "--participants", "2"]);
    for format in FORMATS {
        let inside = |to: &str, from: &Path| {
            let to = scratch.at(to);
            written(from, &to, format);
            let all =
                files(&to).into_iter().map(|(path, content)| (path.strip_prefix(&to).unwrap().to_owned(), content));
            all.collect::<BTreeMap<_, _>>()
        };
        let name = |of: &str| format!("{format:?}-{of}");
        let first = inside(&name("a"), &results);
        assert!(!first.is_empty());
        assert!(first == inside(&name("b"), &results.join("quick")), "{format:?}");
        assert!(first == inside(&name("c"), &results.join("quick/data")), "{format:?}");
    }
}

#[test]
fn what_cannot_be_exported_is_named_and_nothing_is_written() {
    let scratch = Scratch::new("refused");
    let results = scratch.at("results");
    simulate(&results, &["quick", "--participants", "2"]);
    let refused = |to: &Path, expected: &str| {
        for format in FORMATS {
            let error = export(&results, to, format, false).unwrap_err().to_string();
            assert!(error.contains(expected), "{format:?}: {error}");
        }
    };
    fs::create_dir(scratch.at("full")).unwrap();
    fs::write(scratch.at("full").join("x"), "x").unwrap();
    refused(&scratch.at("full"), "is not empty");
    refused(&scratch.at("full").join("x"), "is a file");
    refused(&results.join("out"), "lies in");
    refused(&results.join("quick/data/../out"), "lies in");
    assert_eq!(fs::read_dir(scratch.at("full")).unwrap().count(), 1);

    // Every fault of every session.
    let whole: Vec<_> = ["S001", "S002"].map(|subject| data(&results, "quick", subject, "_data.csv")).into();
    let before: Vec<_> = whole.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    for (path, text) in whole.iter().zip(&before) {
        fs::write(path, text.replace(",yellow,", ",=1+1,")).unwrap();
    }
    let error = export(&results, &scratch.at("out"), Format::Psychopy, false).unwrap_err().to_string();
    assert!(error.contains("S001_session") && error.contains("S002_session"), "{error}");
    assert!(error.contains("take for a formula") && error.contains("is not planned"), "{error}");
    assert!(!scratch.at("out").exists());
    for (path, text) in whole.iter().zip(&before) {
        fs::write(path, text).unwrap();
    }

    // The same session twice.
    fs::create_dir_all(results.join("copy/data")).unwrap();
    for end in ["_data.csv", "_data.json"] {
        let name = data(&results, "quick", "S001", end);
        fs::copy(&name, results.join("copy/data").join(name.file_name().unwrap())).unwrap();
    }
    refused(&scratch.at("out"), "is the same session");
    // Nothing is left of any try.
    let left: Vec<_> = fs::read_dir(&scratch.0).unwrap().flatten().map(|entry| entry.file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn unfinished_sessions_can_be_left_out() {
    let scratch = Scratch::new("complete");
    let results = scratch.at("results");
    simulate(&results, &["quick", "--participants", "2"]);
    interrupt(&data(&results, "quick", "S002", "_data.csv"), 7);
    let exported = export(&results, &scratch.at("out"), Format::Bids, true).unwrap();
    assert_eq!((exported.sessions, exported.rows), (1, 28));
    assert!(!files(&scratch.at("out")).keys().any(|path| path.to_string_lossy().contains("S002")));
    interrupt(&data(&results, "quick", "S001", "_data.csv"), 7);
    let error = export(&results, &scratch.at("none"), Format::Bids, true).unwrap_err().to_string();
    assert!(error.contains("no session that is complete"), "{error}");
}

#[test]
fn what_is_known_of_screen_and_people_stands_in_the_words_and_units_of_bids() {
    let scratch = Scratch::new("words");
    let (results, bids) = (scratch.at("results"), scratch.at("bids"));
    simulate(&results, &["quick"]);
    // As the window writes it, for a person.
    let change = |path: &Path, change: &dyn Fn(&mut Value)| {
        let mut value: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
        change(&mut value);
        fs::write(path, value.to_string()).unwrap();
    };
    change(&data(&results, "quick", "S001", "_data.json"), &|sidecar| {
        let sitting = sidecar["sittings"][0].as_object_mut().unwrap();
        sitting.remove("observer");
        sitting.insert(
            "viewing".to_owned(),
            json!({ "distance_cm": 57.0, "screen_width_cm": 53.1, "screen_width_measured": true }),
        );
        sitting.insert("monitor".to_owned(), json!({ "width_px": 2560, "height_px": 1440, "refresh_hz": 60.0 }));
        sitting.insert("frames".to_owned(), json!({ "refresh_s": 0.016683350 }));
    });
    change(&results.join("quick/dataset_description.json"), &|description| {
        description["author"] =
            json!([{ "@type": "Person", "givenName": "Ada", "familyName": "Beispiel" }, "B. Muster"]);
        description["license"] = "CC0".into();
        description["identifier"] = "https://doi.org/10.1234/abc".into();
    });
    written(&results, &bids, Format::Bids);
    let read = |path: &str| serde_json::from_slice::<Value>(&fs::read(bids.join(path)).unwrap()).unwrap();
    let screen = &read("sub-S001/ses-1/beh/sub-S001_ses-1_task-quick_beh.json")["StimulusPresentation"];
    assert_eq!(screen["ScreenDistance"], 0.57);
    // 53.1 cm × 1440 / 2560.
    assert_eq!(screen["ScreenSize"], json!([0.531, 0.29869]));
    assert_eq!(screen["ScreenResolution"], json!([2560, 1440]));
    assert_eq!(screen["ScreenRefreshRate"], 59.94);
    let description = read("dataset_description.json");
    assert_eq!(description["Authors"], json!(["Ada Beispiel", "B. Muster"]));
    assert_eq!((&description["License"], &description["DatasetDOI"]), (&json!("CC0"), &json!("doi:10.1234/abc")));
    let participants = fs::read_to_string(bids.join("participants.tsv")).unwrap();
    assert!(participants.ends_with("sub-S001\tperson\t1\t1\n"), "{participants}");
    // Every column of the table is described.
    let described = read("task-quick_beh.json");
    let table = fs::read_to_string(bids.join("sub-S001/ses-1/beh/sub-S001_ses-1_task-quick_beh.tsv")).unwrap();
    for name in table.lines().next().unwrap().split('\t') {
        assert!(described[name]["Description"].is_string(), "{name}");
    }
}

#[test]
fn sessions_of_one_name_may_differ_in_their_definition() {
    let scratch = Scratch::new("definitions");
    let results = scratch.at("results");
    for (folder, participants, factor) in [("a", "1", "tanh_k = [5, 7.5]"), ("b", "2", "color = [\"red\", \"gray\"]")] {
        let definition = scratch.at("small.toml");
        let text =
            "schema = 1\nname = \"small\"\ntitle = \"Small\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\n".to_owned();
        fs::write(&definition, text + factor + "\n").unwrap();
        simulate(&results.join(folder), &[definition.to_str().unwrap(), "--participants", participants]);
    }
    for end in ["_data.csv", "_data.json"] {
        fs::remove_file(data(&results.join("b"), "small", "S001", end)).unwrap();
    }
    let (bids, tables) = (scratch.at("bids"), scratch.at("tables"));
    assert_eq!(written(&results, &bids, Format::Bids).sessions, 2);
    assert!(!bids.join("task-small_beh.json").exists());
    let described = |subject: &str| -> Value {
        let path = format!("sub-{subject}/ses-1/beh/sub-{subject}_ses-1_task-small_beh.json");
        serde_json::from_slice(&fs::read(bids.join(path)).unwrap()).unwrap()
    };
    assert!(described("S001")["tanh_k"].is_object() && described("S002")["tanh_k"].is_null());
    written(&results, &tables, Format::Parquet);
    let file = fs::File::open(tables.join("small.parquet")).unwrap();
    let rows: Vec<_> =
        SerializedFileReader::new(file).unwrap().get_row_iter(None).unwrap().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let fields: HashMap<&String, &Field> = row.get_column_iter().collect();
        let first = fields[&"subject_id".to_owned()] == &Field::Str("S001".to_owned());
        assert_eq!(matches!(fields[&"tanh_k".to_owned()], Field::Double(_)), first);
        assert_eq!(matches!(fields[&"tanh_k".to_owned()], Field::Null), !first);
    }
}
