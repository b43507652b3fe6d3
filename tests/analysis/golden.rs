//! The files of `tests/golden/ordinal`.

use std::{fs, path::PathBuf};

use machband::analysis::counts::{Counts, MeasuredBuilder};

/// Header and rows of a file.
pub fn read(name: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/ordinal").join(name);
    let text = fs::read_to_string(&path).unwrap();
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let header = reader.headers().unwrap().iter().map(ToOwned::to_owned).collect();
    let rows = reader.records().map(|record| record.unwrap().iter().map(ToOwned::to_owned).collect()).collect();
    (header, rows)
}

/// The ratings of a data set: subject, factors, rating and count.
pub fn counts(name: &str) -> Counts {
    let (header, rows) = read(&format!("data_{name}.csv"));
    let last = header.len() - 2;
    let mut builder = MeasuredBuilder::new(&header[1..last]);
    for row in rows {
        builder.add_counts(&row[0], &row[1..last], &row[last], row[last + 1].parse().unwrap()).unwrap();
    }
    builder.finish().counts
}
