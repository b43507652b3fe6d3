//! Targets for every reader of files from other sources. Each target takes the content of a file. It panics if the reader
//! panics, if an error has no message, or if data changes when it is written and read again.
//!
//! The fuzzers run the targets with generated input, and `tests/store/reading.rs` runs them with the saved input.
#![allow(dead_code, reason = "a fuzzer has one of the targets")]

use std::{fmt::Debug, path::PathBuf, sync::LazyLock};

use machband::{
    experiment::{Column, Identity, OrderedLogit, RatingRow, Schedule, VisionRater, columns},
    store::{
        FileErrors, StoreError, definition, image, mesh, observer, profile,
        ratings::{self, ReadOptions},
        readings, results,
    },
};

/// A target by its name.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const ALL: &[Target] = &[
    ("definition", definition),
    ("results", results),
    ("ratings", ratings),
    ("profile", profile),
    ("readings", readings),
    ("obj", obj),
    ("png", png),
    ("observer", observer),
];

/// A definition, and the schedule that follows from it.
pub fn definition(content: &[u8]) {
    let Some(text) = text(content) else { return };
    let Some(protocol) = checked(definition::parse("fuzz.toml", text)) else { return };
    let written = serde_json::to_value(&protocol).unwrap();
    let again = definition::from_json("fuzz.json", &written).unwrap();
    assert_eq!(definition::hash(&again), definition::hash(&protocol));
    let identity = Identity::new("S001", "1").unwrap();
    // The search for an order with max_run stops after about a second, which is ten seconds with the sanitizer.
    if protocol.design.max_run.is_some() {
        return;
    }
    // A design without a possible order gives an error; any other design plans every trial once.
    if let Ok(schedule) = Schedule::new(&protocol, &identity, 1) {
        assert_eq!(schedule.trials.len(), protocol.design.practice as usize + protocol.main_trials());
    }
}

/// A session's rows.
pub fn results(content: &[u8]) {
    static COLUMNS: LazyLock<Vec<Column>> = LazyLock::new(|| columns(&definition::open("quick").unwrap()));
    let columns = COLUMNS.as_slice();
    let Some(rows) = checked(results::parse("fuzz.csv", content, columns)) else { return };
    let header = columns.iter().map(|column| column.name.clone()).collect::<Vec<_>>().join(",");
    let mut written = header + "\n";
    for row in &rows {
        // The color is the only text that needs quotes.
        let quoted = row.cells().iter().map(|cell| format!("\"{}\"", cell.replace('"', "\"\""))).collect::<Vec<_>>();
        written += &(quoted.join(",") + "\n");
    }
    assert_eq!(results::parse("again.csv", written.as_bytes(), columns).unwrap(), rows);
}

/// Any table of ratings, as `analyze` takes it.
pub fn ratings(content: &[u8]) {
    let path = temporary("csv");
    std::fs::write(&path, content).unwrap();
    let count = |rows: &mut u64, row: &RatingRow<'_>| {
        assert!(!row.rating.is_empty());
        *rows += 1;
        Ok(())
    };
    let read = ratings::read(std::slice::from_ref(&path), &ReadOptions::default(), |_| 0, count);
    std::fs::remove_file(&path).unwrap();
    match read {
        Ok((source, rows)) => {
            assert!(rows > 0 || !source.errors.is_empty() || !source.files.is_empty());
            source.errors.iter().for_each(|error| assert!(!error.message.is_empty()));
        }
        Err(errors) => assert!(!errors.0.is_empty()),
    }
}

/// A display profile.
pub fn profile(content: &[u8]) {
    let Some(text) = text(content) else { return };
    let Some(profile) = checked(profile::parse("fuzz.toml", text)) else { return };
    assert!(!profile.sentence().is_empty());
    for level in [0.0, 0.25, 1.0] {
        let light = profile.transfers.linear_from_encoded([level; 3]);
        assert!(light.iter().all(|light| light.is_finite()), "{light:?}");
    }
}

/// A photometer's readings.
pub fn readings(content: &[u8]) {
    let Some(text) = text(content) else { return };
    checked(readings::parse("fuzz.csv", text));
}

/// A mesh, in any format.
pub fn obj(content: &[u8]) {
    let Some(file) = checked(mesh::parse("fuzz.obj", content, 30.0)) else { return };
    let mesh = file.mesh;
    let corners = mesh.vertices.len();
    assert!(!mesh.triangles.is_empty());
    assert!(mesh.triangles.iter().flatten().all(|corner| (*corner as usize) < corners));
}

/// An image, as `check` verifies it and as `compare` reads it.
pub fn png(content: &[u8]) {
    checked(image::verify_content("fuzz.png", content, image::MAX_PIXELS).map_err(of_file));
    if let Some(image) = checked(image::parse_picture("fuzz.png", content, None, image::MAX_PIXELS).map_err(of_file)) {
        let light = image.codes.light(&image.transfers);
        assert_eq!(light.data.len(), 3 * light.width as usize * light.height as usize);
    }
}

/// Parameters of an observer, of both kinds.
pub fn observer(content: &[u8]) {
    let Some(text) = text(content) else { return };
    checked(observer::parse::<OrderedLogit>("fuzz.toml", text));
    checked(observer::parse::<VisionRater>("fuzz.toml", text));
}

/// Invalid UTF-8 never reaches the readers of text.
fn text(content: &[u8]) -> Option<&str> {
    std::str::from_utf8(content).ok()
}

/// Nothing but the content of a file in memory can be wrong.
fn of_file(error: StoreError) -> FileErrors {
    match error {
        StoreError::FileErrors(errors) | StoreError::Refused(errors, _) => errors,
        error => panic!("{error}"),
    }
}

/// Returns the result. If there is none, checks that the error has a message.
fn checked<T: Debug>(read: Result<T, FileErrors>) -> Option<T> {
    match read {
        Ok(read) => Some(read),
        Err(FileErrors(errors)) => {
            assert!(!errors.is_empty(), "refused without a reason");
            for error in errors {
                assert!(!error.message.is_empty(), "{error:?}");
                assert!(error.position.is_none_or(|(line, column)| line > 0 && column > 0), "{error:?}");
            }
            None
        }
    }
}

/// A file that only this process uses, in memory if the system supports that.
fn temporary(extension: &str) -> PathBuf {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    folder.join(format!("machband-fuzz-{}.{extension}", std::process::id()))
}
