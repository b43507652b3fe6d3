//! Requests: one struct that the command line, Python and the window fill in, and the words that repeat it. Tables: what is
//! printed as JSON is what the CSV file says.

use std::{collections::BTreeMap, fs, path::Path};

use clap::{Args, Command};
use machband::{
    stimulus::catalog,
    store::{
        definition::{self, BUILT_IN, BuiltIn},
        profile,
    },
    text::{Cell, Column, Table, inert},
    work::{
        Analyze, Check, Found, Repair, calibrate::Calibrate, from_names, plan::Plan, simulate::Simulate,
        verify::Verify, words,
    },
};
use proptest::prelude::*;
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::common::{change_rating, everything, machband, records, session_csv, split, succeeds, text};

fn fields(value: Value) -> Map<String, Value> {
    value.as_object().unwrap().clone()
}

/// Reads words as the command line does.
fn parsed<T: Args>(words: &[String]) -> T {
    let command = T::augment_args(Command::new("machband").no_binary_name(true));
    T::from_arg_matches(&command.get_matches_from(words)).unwrap()
}

#[test]
fn words_repeat_a_request_and_leave_out_defaults() {
    let given = fields(json!({
        "paths": ["a b.csv", "-c.csv"], "response": "score", "categories": ["low", "medium, mostly", "-high"],
        "terms": "width,num:inv_n", "link": "probit", "random": "none", "draws": "199", "seed": u64::MAX,
        "complete_only": true, "large": false, "subject": null, "missing": "-99,n", "min_time": 0.25,
        "only": ["\"kind=x\"=a,b", "width=0.1"],
    }));
    let request: Analyze = from_names(&given).unwrap();
    let line = words(&request);
    assert_eq!(parsed::<Analyze>(&line), request, "{line:?}");
    assert!(line.contains(&u64::MAX.to_string()) && line.contains(&"--complete-only".to_owned()), "{line:?}");
    assert!(!line.iter().any(|word| word.contains("slopes") || word.contains("large")), "{line:?}");
    assert_eq!((request.ratings.how.only[0].0.as_str(), request.ratings.how.only[0].1.len()), ("kind=x", 2));
    assert!(line.contains(&"--missing=-99,n".to_owned()) && line.contains(&"0.25".to_owned()), "{line:?}");
    let wide: Analyze = from_names(&fields(json!({ "paths": ["r"], "wide": ["near", "far"] }))).unwrap();
    assert_eq!(words(&wide), ["r", "--wide", "condition=near,far"]);
    let defaults: Analyze = from_names(&fields(json!({ "paths": ["r"] }))).unwrap();
    assert_eq!(words(&defaults), ["r"]);
    let simulate: Simulate = from_names(&fields(json!({ "experiment": "quick", "observer": "random" }))).unwrap();
    assert_eq!(words(&simulate), ["quick", "--observer", "random"]);
}

#[test]
fn a_wrong_request_names_its_field() {
    for (given, expected) in [
        (json!({ "draws": 3 }), "draws 3: outside 99…1000000; expected a whole number in this range"),
        (
            json!({ "link": "probits" }),
            "link \"probits\" is not known; expected one of logit, probit; did you mean probit?",
        ),
        (json!({ "slope": "none" }), "slope is not known; expected one of "),
        (json!({ "categories": ["a", "a"], "response": "x" }), "categories a,a: a appears twice"),
    ] {
        let mut given = fields(given);
        given.insert("paths".to_owned(), json!(["a.csv"]));
        let error = from_names::<Analyze>(&given).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{error}");
        assert!(error.told(|field| format!("--{field}")).starts_with("--"), "{error}");
    }
}

/// The names and contents of all files in a folder; the report without the time at which it was made.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(folder).unwrap().map(Result::unwrap);
    let named = files.map(|file| (file.file_name().into_string().unwrap(), fs::read(file.path()).unwrap()));
    named.filter(|(name, _)| name != "report.html").collect()
}

#[test]
fn the_command_in_a_report_repeats_the_analysis_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("simulate quick --participants 3 --seed 5"));
    let line = "analyze results/quick --terms num:width --link=probit --draws=99 --seed 1 --out first";
    succeeds(folder.path(), &split(line));
    let report = fs::read_to_string(folder.path().join("first/report.html")).unwrap();
    let command = "machband analyze results/quick --terms num:width --link probit --draws 99 --out first";
    assert!(report.contains(command), "{line}");
    let again = command.trim_start_matches("machband ").replace("--out first", "--out second");
    succeeds(folder.path(), &split(&again));
    assert_eq!(contents(&folder.path().join("first")), contents(&folder.path().join("second")));
}

/// Makes a request from its fields, as Python and the window do, and the command that repeats it.
fn request<T: Args + Serialize>(command: &str, given: Value) -> (T, Vec<String>) {
    let request: T = from_names(&fields(given)).unwrap();
    let line = [vec![command.to_owned()], words(&request)].concat();
    (request, line)
}

#[test]
fn a_plan_and_a_calibration_are_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let given = json!({
        "experiment": "quick", "participants": ["3", "2"], "effects": ["oblique=1", "width:0.1=-0.5"],
        "deviations": ["width=0.5"], "studies": "4", "terms": "width,depth", "slopes": "none",
    });
    let (plan, line) = request::<Plan>("plan", given);
    succeeds(folder.path(), &[line, split("--out plan.csv")].concat());
    assert_eq!(fs::read(at("plan.csv")).unwrap(), plan.plan(&()).unwrap().table().csv());

    let levels = (0..=8).map(|i| f64::from(i) / 8.0);
    let readings: String = levels.map(|v| format!("gray,{v},{}\n", 0.3 + 90.0 * v.powf(2.2))).collect();
    fs::write(at("r.csv"), format!("channel,level,luminance_cd_m2\n{readings}")).unwrap();
    let given = json!({ "readings": at("r.csv"), "by": "A B", "on": "2026-02-03", "model": "table" });
    let (calibrate, line) = request::<Calibrate>("calibrate", given);
    assert!(machband(folder.path(), &[line, split("--out left.toml")].concat()).status.success());
    let made = calibrate.calibrate("left").unwrap();
    assert_eq!(profile::open(&at("left.toml")).unwrap(), made.profile);
}

/// Checks that a command says what was found about files.
fn assert_said(folder: &Path, line: &[String], found: &Found) {
    let files = found.files.iter().map(|(path, sentence)| format!("{}: {sentence}\n", path.display()));
    let errors = found.errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    let said = machband(folder, line);
    assert_eq!(text(&said.stdout), files.collect::<String>(), "{line:?}");
    assert_eq!(text(&said.stderr).replace("error: ", ""), format!("{errors}\n"), "{line:?}");
}

#[test]
fn what_is_found_about_files_is_what_the_command_says() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("simulate quick --participants 2"));
    let results = folder.path().join("results");
    let csv = session_csv(&results, "quick", "S002");
    change_rating(&csv);
    let (check, line) = request::<Check>("check", json!({ "files": ["quick", csv, "nothing"], "large": true }));
    assert_said(folder.path(), &line, &check.check(&()).unwrap());
    let (verify, line) = request::<Verify>("verify", json!({ "folder": results }));
    assert_said(folder.path(), &line, &verify.verify(&()).unwrap());

    // A file whose fourth line is damaged, and one that cannot be repaired.
    let damaged = fs::read_to_string(&csv).unwrap().replacen("S002_1_practice_0003", "", 1);
    fs::write(results.join("quick/data/other_data.csv"), "a,b\n").unwrap();
    let (repair, line) = request::<Repair>("repair", json!({ "path": results }));
    fs::write(&csv, &damaged).unwrap();
    let sidecar = fs::read(csv.with_extension("json")).unwrap();
    let found = repair.repair(&()).unwrap();
    let tables =
        || everything(&results).into_iter().filter(|(path, _)| path.extension().is_none_or(|end| end != "json"));
    let repaired: Vec<_> = tables().collect();
    assert!(repaired.iter().any(|(path, _)| path.to_string_lossy().ends_with("damaged-1")));
    fs::write(csv.with_extension("json"), sidecar).unwrap();
    fs::write(&csv, &damaged).unwrap();
    fs::remove_file(csv.with_extension("csv.damaged-1")).unwrap();
    assert_said(folder.path(), &line, &found);
    assert!(tables().eq(repaired));
}

/// Reads a CSV file as one object per row, in which every value is the text of the cell.
fn rows(csv: &[u8]) -> Vec<Vec<(String, String)>> {
    let mut reader = csv::Reader::from_reader(csv);
    let header = reader.headers().unwrap().clone();
    let pairs = |row: csv::StringRecord| header.iter().map(str::to_owned).zip(row.iter().map(str::to_owned)).collect();
    reader.records().map(|row| pairs(row.unwrap())).collect()
}

/// Whether the cell of a CSV file has a value of JSON.
fn is_equal(cell: &str, value: &Value) -> bool {
    match value {
        Value::Null => cell.is_empty(),
        Value::Number(number) => cell.parse() == Ok(number.as_f64().unwrap()),
        Value::String(text) => !text.is_empty() && cell == inert(text),
        _ => false,
    }
}

/// Checks that every value is in both, and is the same.
fn same(csv: &[u8], json: &[Map<String, Value>], what: &str) {
    let rows = rows(csv);
    assert_eq!(rows.len(), json.len(), "{what}");
    for (row, object) in rows.iter().zip(json) {
        assert!(row.iter().map(|(name, _)| name).eq(object.keys()), "{what}: {row:?} {object:?}");
        for (name, cell) in row {
            assert!(is_equal(cell, &object[name]), "{what}: {name} is {cell:?} in CSV and {} in JSON", object[name]);
        }
    }
}

fn same_output(folder: &Path, arguments: &[&str]) -> Vec<Map<String, Value>> {
    let csv = succeeds(folder, arguments);
    let json = succeeds(folder, &[arguments, &["--json"]].concat());
    let json: Value = serde_json::from_str(&json).unwrap();
    let json = if json.is_array() { json } else { Value::Array(vec![json]) };
    let objects: Vec<Map<String, Value>> = serde_json::from_value(json).unwrap();
    same(csv.as_bytes(), &objects, &arguments.join(" "));
    objects
}

#[test]
fn every_cell_is_the_same_in_csv_and_in_json() {
    let folder = tempfile::tempdir().unwrap();
    // Where the answers decide what is shown, there is nothing to predict.
    let is_planned = |built_in: &&BuiltIn| definition::open(built_in.name).unwrap().adaptive.is_none();
    for built_in in BUILT_IN.iter().filter(is_planned) {
        let rows = same_output(folder.path(), &["predict", built_in.name, "--size", "32", "--large"]);
        let level = |row: &Map<String, Value>, name: &str, level: Value| row.get(name) == Some(&level);
        if built_in.name == "bangay2003" {
            assert_eq!(rows.iter().filter(|row| level(row, "depth", "inf".into())).count(), 24);
            assert_eq!(rows.iter().filter(|row| level(row, "depth", 1.0.into())).count(), 24);
        }
    }
    for entry in catalog::all() {
        same_output(folder.path(), &["predict", "--kind", entry.kind, "--size", "32"]);
    }
    let infinite = same_output(folder.path(), &["predict", "--depth", "inf"]);
    assert_eq!(infinite[0]["depth"], "inf");
    succeeds(folder.path(), &["stimulus", "--size", "64", "--out", "image.png"]);
    for name in ["007", "inf", "nan", "1e3", "a, \"b\"", "=1+1", " "] {
        fs::copy(folder.path().join("image.png"), folder.path().join(name)).unwrap();
        let found = succeeds(folder.path(), &["compare", name, "image.png", "--window", "5", "--json"]);
        let found: serde_json::Value = serde_json::from_str(&found).unwrap();
        assert_eq!(found["picture"], name);
    }
}

/// All ratings at b are alike, so that its coefficient is infinite and has no standard error.
#[test]
fn a_model_says_what_its_tables_say() {
    let folder = tempfile::tempdir().unwrap();
    let row = |i: usize| format!("p{},{},{}\n", i % 5, ["a", "b", "c"][i % 3], if i % 3 == 1 { 1 } else { i / 7 % 2 });
    let rows: String = (0..90).map(row).collect();
    fs::write(folder.path().join("d.csv"), format!("subject_id,level,rating\n{rows}")).unwrap();
    succeeds(folder.path(), &split("analyze d.csv --factors level --draws 99 --tables-only --out a"));
    let out = folder.path().join("a");
    let model: Value = serde_json::from_slice(&fs::read(out.join("model.json")).unwrap()).unwrap();
    let coefficients = model["coefficients"].as_array().unwrap();
    for (row, own) in records(&out.join("coefficients.csv")).iter().zip(coefficients) {
        for name in ["name", "estimate", "se", "z", "p"] {
            assert!(is_equal(&row[name], &own[name]), "{name}: {row:?} {own}");
        }
    }
    assert_eq!((&coefficients[0]["estimate"], &coefficients[0]["se"]), (&"inf".into(), &Value::Null));
}

proptest! {
    #[test]
    fn any_value_is_the_same_in_csv_and_in_json(
        texts in proptest::collection::vec(".*", 4),
        numbers in proptest::array::uniform4(proptest::num::f64::ANY),
        wholes in proptest::array::uniform4(any::<u64>()),
    ) {
        let numbers = numbers.map(Cell::from).into_iter().chain([f64::INFINITY, f64::NAN, -0.0, 1e300].map(Cell::from));
        let texts = texts.iter().map(|text| Cell::from(text.as_str()))
            .chain(["007", "inf", "nan", "\"", ""].map(Cell::from))
            .chain([Cell::Level("0.10".to_owned(), Some(0.1)), Cell::Missing]);
        let cells: Vec<Cell> = texts.chain(numbers).chain(wholes.map(Cell::from)).collect();
        let table = Table { columns: vec![Column { cells, ..Column::new("a \"name\"", "", "") }, ] };
        // With a second column, because the csv crate skips empty lines.
        let second = Column { cells: table.columns[0].cells.iter().map(|_| Cell::from(1_u64)).collect(), ..Column::new("b", "", "") };
        let table = Table { columns: [table.columns, vec![second]].concat() };
        same(&table.csv(), &table.json(), "any table");
    }
}
