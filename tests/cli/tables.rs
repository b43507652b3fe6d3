//! What is printed as JSON is what the CSV file says.

use std::{collections::BTreeSet, fs, path::Path};

use machband::{
    stimulus::catalog,
    store::definition::{self, BUILT_IN, BuiltIn},
    text::{Cell, Column, Table, inert},
};
use proptest::prelude::*;
use serde_json::{Map, Value};

use crate::common::{machband, succeeds, text};

/// Reads a CSV file as one object per row, in which every value is the text of the cell.
fn rows(csv: &[u8]) -> Vec<Vec<(String, String)>> {
    let mut reader = csv::Reader::from_reader(csv);
    let header = reader.headers().unwrap().clone();
    let pairs = |row: csv::StringRecord| header.iter().map(str::to_owned).zip(row.iter().map(str::to_owned)).collect();
    reader.records().map(|row| pairs(row.unwrap())).collect()
}

/// Checks that every value is in both, and is the same.
fn same(csv: &[u8], json: &[Map<String, Value>], what: &str) {
    let rows = rows(csv);
    assert_eq!(rows.len(), json.len(), "{what}");
    for (row, object) in rows.iter().zip(json) {
        assert!(row.iter().map(|(name, _)| name).eq(object.keys()), "{what}: {row:?} {object:?}");
        for (name, cell) in row {
            let equal = match &object[name] {
                Value::Null => cell.is_empty(),
                Value::Number(number) => cell.parse() == Ok(number.as_f64().unwrap()),
                Value::String(text) => !text.is_empty() && *cell == inert(text),
                _ => false,
            };
            assert!(equal, "{what}: {name} is {cell:?} in CSV and {} in JSON", object[name]);
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

/// The levels of any file stay the texts that they are; `nan` and an empty cell are missing values.
#[test]
fn levels_keep_their_text() {
    let folder = tempfile::tempdir().unwrap();
    let levels = ["inf", "007", "nan", "\"a, \"\"b\"\"\"", "-1", "=2", ""];
    let rows = (0..8 * levels.len()).map(|i| format!("0{},{},{}\n", i % 8, levels[i / 8], (i * i / 3) % 4));
    let table = "subject_id,level,rating\n".to_owned() + &rows.collect::<String>();
    fs::write(folder.path().join("levels.csv"), table).unwrap();
    let analyze = ["analyze", "levels.csv", "--factors", "level", "--out", "a", "--tables-only", "--draws", "99"];
    let warnings = text(&machband(folder.path(), &analyze).stderr);
    assert_eq!(warnings, "warning: levels.csv: 16 of 56 ratings have no value of level; expected one in every row\n");
    let column = |file: &str, name: &str| -> BTreeSet<String> {
        let rows = self::rows(&fs::read(folder.path().join("a").join(file)).unwrap());
        rows.into_iter().flatten().filter(|(column, _)| column == name).map(|(_, cell)| cell).collect()
    };
    let known = ["", "'=2", "-1", "007", "a, \"b\"", "inf"].map(str::to_owned);
    assert_eq!(column("cells.csv", "level"), known.clone().into());
    assert_eq!(column("counts.csv", "level"), known.into());
    assert_eq!(column("subjects.csv", "subject_id"), (0..8).map(|i| format!("0{i}")).collect());
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
