//! Reading ratings from files: which rows count, which do not, and that every error has its own message. Every reader
//! survives the files that fuzzers found.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::Read as _,
    path::{Path, PathBuf},
};

use flate2::read::GzDecoder;
use machband::{
    experiment::{Identity, Phase, Protocol, RatingRow, TrialRecord, columns},
    store::{
        Columns, FileErrors, definition,
        ratings::{self, FileRead, ReadOptions, Reason, Source},
        session::SessionStore,
        table::List,
    },
    work::Study,
};

use crate::{
    common::{
        self,
        attacks::{HANGS, PANICS, withstood},
        edit, set_cell,
    },
    recording::{self, SEED, sitting},
};

/// A definition with three practice and twelve main trials. Its color must be quoted, and `tanh_k` needs its own
/// column.
const TEXT: &str = "schema = 1\nname = \"small-one\"\n[stimulus]\nkind = \"mach-band\"\ncolor = \"1,0.5,0\"\n[factors]\nwidth = [0.1, 0.4, 0.8]\ntanh_k = [5, 7.5]\n[design]\npractice = 3\nrepetitions = 2\n";
const PRACTICE: u64 = 3;
const MAIN: u64 = 12;

/// Reads every row that counts, as text.
fn try_read(paths: &[&Path], how: &ReadOptions) -> Result<(Source, Vec<String>), FileErrors> {
    let paths: Vec<PathBuf> = paths.iter().map(|path| path.to_path_buf()).collect();
    let add = |rows: &mut Vec<String>, row: &RatingRow<'_>| {
        let RatingRow { subject, values, rating, count, session, repetition, response_time_s, .. } = row;
        let place = repetition.map(|repetition| (session, repetition));
        let details = place.map(|place| format!(" {place:?} {response_time_s:?}")).unwrap_or_default();
        rows.push(format!("{subject} {} {rating} {count}{details}", values.join("|")));
        Ok(())
    };
    ratings::read(&paths, how, |_| Vec::new(), add)
}

fn read(paths: &[&Path], how: &ReadOptions) -> (Source, Vec<String>) {
    try_read(paths, &ReadOptions { details: true, ..how.clone() }).unwrap_or_else(|errors| panic!("{errors}"))
}

fn sorted(mut rows: Vec<String>) -> Vec<String> {
    rows.sort();
    rows
}

/// Returns every error without its folder, whether or not anything can be read.
fn errors(paths: &[&Path], how: &ReadOptions) -> Vec<String> {
    let errors = match try_read(paths, how) {
        Ok((source, _)) => source.errors,
        Err(errors) => errors.0,
    };
    let mut texts: Vec<String> = errors.iter().map(ToString::to_string).collect();
    for path in paths {
        for folder in path.ancestors().filter(|folder| folder.components().count() > 1) {
            texts.iter_mut().for_each(|text| *text = text.replace(&format!("{}/", folder.display()), ""));
        }
    }
    texts
}

fn small() -> Protocol {
    definition::parse("small.toml", TEXT).unwrap()
}

/// Records a session that ends after at most `limit` trials, and returns its file. Every fourth rating is undone.
fn session(results: &Path, protocol: &Protocol, subject: &str, limit: usize) -> PathBuf {
    let identity = Identity::new(subject, "1").unwrap();
    let (mut store, _) = SessionStore::create(results, protocol, &identity, SEED, sitting()).unwrap();
    recording::rate(&mut store, (protocol, &identity), None, limit, true).unwrap();
    store.csv().to_owned()
}

/// Returns a folder with finished sessions of these participants, and their files.
fn study(subjects: &[&str]) -> (tempfile::TempDir, Vec<PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let files = subjects.iter().map(|subject| session(folder.path(), &small(), subject, usize::MAX)).collect();
    (folder, files)
}

/// Returns the rows that count according to the reader for running sessions: the last attempt at every main trial.
fn expected(files: &[PathBuf]) -> Vec<String> {
    let protocol = small();
    let mut last = BTreeMap::new();
    for file in files {
        for row in common::rows(file, &protocol) {
            if row.phase == Phase::Main {
                last.insert((row.subject_id.clone(), row.trial), row);
            }
        }
    }
    let text = |row: &TrialRecord| {
        let values: Vec<String> = ["width", "tanh_k"].iter().map(|name| row.level(&protocol, name).unwrap()).collect();
        let place = (row.session_id.as_str(), row.repetition);
        let (subject, rating, time) = (&row.subject_id, row.rating.unwrap().0, Some(row.response_time_s.0));
        format!("{subject} {} {rating} 1 {place:?} {time:?}", values.join("|"))
    };
    sorted(last.values().map(text).collect())
}

fn csv_rows(text: &str) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
    reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect()
}

fn csv_text(rows: &[Vec<String>]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().for_each(|row| writer.write_record(row).unwrap());
    String::from_utf8(writer.into_inner().unwrap()).unwrap()
}

fn file(folder: &tempfile::TempDir, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, content).unwrap();
    path
}

fn list(names: &[&str]) -> List {
    List(names.iter().map(|name| (*name).to_owned()).collect())
}

fn with_factors(names: &[&str]) -> ReadOptions {
    ReadOptions { factors: Some(list(names)), ..ReadOptions::default() }
}

/// The options of a table that names no program: its response and its factors.
fn of(response: &str, factors: &[&str]) -> ReadOptions {
    ReadOptions { response: Some(response.to_owned()), ..with_factors(factors) }
}

const LONG: &str = "who,width,depth,answer,n\nA,0.1,1,2,1\nB,0.4,inf,0,3\nA,NA,1,3,2\n";
const LONG_ROWS: [&str; 3] = ["A 0.1|1 2 1", "B 0.4|inf 0 3", "A |1 3 2"];

fn long() -> ReadOptions {
    let named = |name: &str| Some(name.to_owned());
    ReadOptions {
        subject: named("who"),
        response: named("answer"),
        count: named("n"),
        ..with_factors(&["width", "depth"])
    }
}

mod what_counts {
    use super::*;

    #[test]
    fn the_last_attempt_at_every_main_trial_counts() {
        let (folder, files) = study(&["S2", "S10", "S1"]);
        let (source, rows) = read(&[folder.path()], &ReadOptions::default());
        assert_eq!(sorted(rows), expected(&files));
        assert_eq!(source.errors, []);
        assert_eq!(source.shape.factors, ["width", "tanh_k"]);
        assert_eq!(source.protocol, Some(small()));
        assert_eq!(source.definition_sha256, Some(definition::hash(&small())));
        let sessions: Vec<_> = source.sessions.iter().map(|s| (s.subject.as_str(), s.planned, s.rated)).collect();
        assert_eq!(sessions, ["S1", "S2", "S10"].map(|subject| (subject, Some(MAIN), MAIN)));
        for read in &source.files {
            // Trials 3, 7 and 11 of 0…14 were corrected.
            assert_eq!((read.rows, read.practice, read.superseded), (MAIN + PRACTICE + 3, PRACTICE, 3), "{read:?}");
            assert_eq!((read.counted, read.ratings, read.erroneous), (MAIN, MAIN, 0));
        }
        // In any order of rows and columns.
        let expected = expected(&files);
        for file in &files {
            edit(file, |text| {
                let mut rows = csv_rows(text);
                rows[1..].reverse();
                rows.iter_mut().for_each(|row| row.rotate_left(3));
                csv_text(&rows)
            });
        }
        let (source, rows) = read(&[folder.path()], &ReadOptions::default());
        assert_eq!((sorted(rows), source.errors), (expected, vec![]));
    }

    #[test]
    fn unfinished_sessions_count_unless_only_complete_ones_are_requested() {
        let (folder, mut files) = study(&["S1"]);
        files.push(session(folder.path(), &small(), "S2", 9));
        files.push(session(folder.path(), &small(), "S3", 0));
        let (source, rows) = read(&[folder.path()], &ReadOptions::default());
        assert_eq!(sorted(rows), expected(&files));
        let rated: Vec<_> = source.sessions.iter().map(|s| (s.rated, s.is_unfinished())).collect();
        assert_eq!(rated, [(12, false), (6, true), (0, true)]);
        assert_eq!(source.errors, []);
        let (source, rows) = read(&[folder.path()], &ReadOptions { complete_only: true, ..ReadOptions::default() });
        assert_eq!(sorted(rows), expected(&files[..1]));
        assert_eq!(source.left_out(Reason::Unfinished), (6, 1));
    }
}

mod layouts {
    use super::*;

    #[test]
    fn any_csv_dialect_is_read_by_its_column_names() {
        let folder = tempfile::tempdir().unwrap();
        let quoted = csv_rows(LONG).iter().map(|row| format!("\"{}\"\n", row.join("\",\""))).collect::<String>();
        let stray =
            LONG.replace("A,0.1", "\"A\",\"0.1\"").replace("n\n", "n,note\n").replace("1\nB", "1,\"two\nlines\"\nB");
        let stray = stray.replace(",3\nA", ",3,\nA").replace("3,2\n", "3,2,\"say \"\"x\"\"\"\n");
        for (name, text) in [
            ("crlf", LONG.replace('\n', "\r\n")),
            ("cr", LONG.replace('\n', "\r")),
            ("blank", format!("\n{}\n\n\n", LONG.replace('\n', "\n\n"))),
            ("unended", LONG.trim_end().to_owned()),
            ("decimal comma", LONG.replace(',', ";").replace('.', ",")),
            ("tab and decimal comma", LONG.replace(',', "\t").replace('.', ",").replace("\t3\n", "\t3,0\n")),
            (
                "comma in a name",
                LONG.replace(',', ";")
                    .replacen("n\n", "n;\"notes, a,b,c,d\"\n", 1)
                    .replace("1\nB", "1;\nB")
                    .replace("3\nA", "3;\nA")
                    .replace("3;2\n", "3;2;\n"),
            ),
            ("spaced", LONG.replace(',', " , ")),
            ("separator line of Excel", format!("\u{feff}sep=;\r\n{}", LONG.replace(',', ";").replace('.', ","))),
            ("separator line with a point", format!("SEP=\t\n{}", LONG.replace(',', "\t"))),
            ("quoted crlf bom", format!("\u{feff}{}", quoted.replace('\n', "\r\n"))),
            ("stray", stray),
        ] {
            let path = file(&folder, "long.csv", text);
            let (source, rows) = read(&[&path], &long());
            assert_eq!(source.errors, [], "{name}");
            assert_eq!(rows, LONG_ROWS, "{name}");
            assert_eq!((source.files[0].counted, source.files[0].ratings), (3, 6), "{name}");
            assert_eq!(source.shape.categories, None);
        }
    }

    /// Words that stand for a missing value in some programs are levels if the column has texts.
    #[test]
    fn missing_values_are_no_levels() {
        let folder = tempfile::tempdir().unwrap();
        let rows = [
            "1,low,2,",
            "NA,NA,1,NA",
            "NULL,n/a,NaN,2",
            "#N/A,NULL,NULL,2",
            "None,None,None,2",
            ".,.,.,.",
            "null,null,null,null",
        ];
        let rows: String = rows.iter().map(|row| format!("A,{row}\n")).collect();
        let rows = rows + &"A,2,high,1,1\n".repeat(91) + "A,3,None,1,1\nA,2,high,9,1\nNA,2,high,1,1\n";
        let path = file(&folder, "t.csv", format!("who,size,mask,answer,response_time_s\n{rows}"));
        let how = ReadOptions { count: None, factors: with_factors(&["size", "mask"]).factors, ..long() };
        let how = ReadOptions { details: true, missing: Some(list(&["9.0"])), ..how };
        let study = Study::read(std::slice::from_ref(&path), &how).unwrap();
        let counts = &study.measured.counts;
        assert_eq!(
            (&counts.factors[0].levels[..], counts.categories.join(" ")),
            (&["1", "2", "3"].map(String::from)[..], "1 2".into())
        );
        assert_eq!(counts.factors[1].levels, ["None", "high", "low"]);
        // Rows without a rating or a participant are counted and named once.
        let said = study.source.warnings.iter().map(|warning| warning.message.as_str()).collect::<Vec<_>>();
        let without =
            ["size", "mask"].map(|name| format!("1 of 94 ratings has no value of {name}; expected one in every row"));
        assert_eq!(said[2..], without);
        assert!(said[0].starts_with("6 of 101 rows have no response ("), "{said:?}");
        assert!(said[1].starts_with("1 of 101 rows has no participant ("), "{said:?}");
        assert_eq!((study.source.left_out(Reason::NoResponse), counts.total()), ((6, 1), 94));
        // Among words, only words that never name a category are missing.
        let path = file(&folder, "t.csv", "who,size,answer\nA,1,None\nA,1,some\nA,.,NULL\nA,x,some\n");
        let how = ReadOptions { factors: with_factors(&["size"]).factors, ..how };
        let counts = Study::read(&[path], &how).unwrap().measured.counts;
        assert_eq!(
            (counts.categories.join(" "), counts.factors[0].levels.join(" ")),
            ("None some".into(), "1 x".into())
        );
    }

    /// Without a definition, the columns of the stimulus serve as factors, and the order of trials is kept.
    #[test]
    fn result_files_without_a_sidecar_are_read_too() {
        let (folder, files) = study(&["S1", "S2"]);
        for file in &files {
            fs::remove_file(file.with_extension("json")).unwrap();
        }
        let (source, rows) = read(&[folder.path()], &ReadOptions::default());
        assert!(source.shape.guessed && source.protocol.is_none());
        assert_eq!(
            source.shape.factors,
            ["stimulus", "width", "depth", "orientation_deg", "low", "high", "color", "tanh_k"]
        );
        assert!(rows.iter().all(|row| row.contains("mach-band|") && row.contains("|1,0.5,0|")), "{:?}", rows);
        assert_eq!(rows.len() as u64, 2 * MAIN);
        let (_, rows) = read(&[folder.path()], &with_factors(&["width", "tanh_k"]));
        assert_eq!(sorted(rows), expected(&files));
        // One sidecar is enough to determine the definition of all sessions.
        session(&folder.path().join("more"), &small(), "S3", usize::MAX);
        let (source, _) = read(&[folder.path()], &ReadOptions::default());
        assert_eq!((source.files.len(), source.protocol, source.errors), (3, Some(small()), vec![]));
        let planned: Vec<_> = source.sessions.iter().map(|session| session.planned).collect();
        assert_eq!(planned, [None, None, Some(MAIN)]);
    }

    /// IDs and levels are the texts of the file; only in result files is a level written as the definition writes it.
    #[test]
    fn nothing_is_merged_because_it_is_the_same_number() {
        let folder = tempfile::tempdir().unwrap();
        let ids = ["9007199254740993", "9007199254740992", "1", "01", "1.0", "+1", "1,0"];
        let row = |(index, id): (usize, &&str)| format!(" {id} ;{};1\n", ["0.1", "0.10"][index % 2]);
        let text = format!("subject_id;triangles;rating\n{}", ids.iter().enumerate().map(row).collect::<String>());
        let path = file(&folder, "t.csv", text);
        let study = |how: ReadOptions| Study::read(std::slice::from_ref(&path), &how).unwrap().measured.counts;
        let counts = study(with_factors(&["triangles"]));
        assert_eq!(counts.subjects.len(), ids.len(), "{:?}", counts.subjects);
        assert!(ids.iter().all(|id| counts.subjects.iter().any(|subject| subject == id)), "{:?}", counts.subjects);
        assert_eq!(counts.factors[0].levels, ["0.1", "0.10"]);
        assert!(counts.factors[0].is_ordered());

        let (_results, files) = super::study(&["S1"]);
        let before = Study::read(&files, &ReadOptions::default()).unwrap().measured.counts;
        edit(&files[0], |text| text.replace(",mach-band,0.1,", ",mach-band,0.10,").replace(",5\n", ",5.0\n"));
        assert_eq!(Study::read(&files, &ReadOptions::default()).unwrap().measured.counts, before);
    }

    /// A table in memory gives the same as a file; its errors count rows from 0.
    #[test]
    fn columns_in_memory_are_read_like_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let columns = Columns::default()
            .with_levels("who", &["A", "B"], &[0, 1, 0])
            .with_numbers("width", [0.1, 0.4, f64::NAN])
            .with_levels("depth", &["1", "inf"], &[0, 1, 0])
            .with_numbers("answer", [2.0, 0.0, 3.0])
            .with_numbers("n", [1.0, 3.0, 2.0]);
        let study = Study::from_columns("ratings", columns, &long()).unwrap();
        let path = file(&folder, "t.csv", LONG);
        assert_eq!(study.measured, Study::read(&[path], &long()).unwrap().measured);
        assert_eq!((&study.source.files[0].path, &study.source.files[0].sha256), (&PathBuf::from("ratings"), &None));
    }
}

/// Tables that other programs wrote.
mod elsewhere {
    use std::io::{Cursor, Write as _};

    use flate2::{Compression, write::GzEncoder};
    use sha2::{Digest as _, Sha256};
    use zip::{ZipWriter, write::SimpleFileOptions};

    use super::*;
    use crate::common::workbook;

    /// Reads a table with a response, a factor, and the usual name of the participants' column.
    fn study(path: &Path, response: &str, factor: &str) -> Study {
        Study::read(&[path.to_owned()], &of(response, &[factor])).unwrap_or_else(|error| panic!("{error}"))
    }

    fn warnings(study: &Study) -> Vec<String> {
        let all = study.source.warnings.iter().map(|warning| match warning.position {
            Some((line, column)) => format!("{line}:{column}: {}", warning.message),
            None => warning.message.clone(),
        });
        all.filter(|warning| !warning.contains("participants are in the column")).collect()
    }

    fn counts(study: &Study) -> Vec<(&str, Vec<&str>, &str, u64)> {
        let counts = &study.measured.counts;
        let row = |row: &machband::analysis::counts::CountRow| {
            let (subject, rating) = (&counts.subjects[row.subject as usize], &counts.categories[row.rating as usize]);
            (subject.as_str(), counts.level_names(row.condition), rating.as_str(), row.count)
        };
        counts.rows.iter().map(row).collect()
    }

    /// Text that is not UTF-8 is Windows-1252, in the header, in levels and in columns that nobody uses.
    #[test]
    fn text_that_is_not_utf_8_is_windows_1252() {
        let folder = tempfile::tempdir().unwrap();
        let text = "subject,gr\u{f6}\u{df}e,note,y\nM\u{fc}ller,\u{80}5,\u{e4},1\nMay,x,ok,2\nMay,x,\u{fc},3\n";
        let latin: Vec<u8> = text.chars().map(|char| char as u8).collect();
        let path = file(&folder, "latin1.csv", &latin);
        let read = study(&path, "y", "größe");
        let expected = [("May", vec!["x"], "2", 1), ("May", vec!["x"], "3", 1), ("Müller", vec!["€5"], "1", 1)];
        assert_eq!((counts(&read), &read.source.errors), (expected.to_vec(), &vec![]));
        assert_eq!(warnings(&read), ["1:11: is not UTF-8 text and was read as Windows-1252; expected UTF-8"]);
        // Excel's "Unicode text".
        for (bom, bytes) in [([0xff, 0xfe], u16::to_le_bytes as fn(u16) -> [u8; 2]), ([0xfe, 0xff], u16::to_be_bytes)] {
            let text = text.replace(',', "\t").replace('\u{80}', "€");
            let wide: Vec<u8> = bom.into_iter().chain(text.encode_utf16().flat_map(bytes)).collect();
            let wide = study(&file(&folder, "wide.txt", wide), "y", "größe");
            assert_eq!((counts(&wide), warnings(&wide)), (expected.to_vec(), vec![]));
        }
    }

    /// Whatever is in a column that is not used, only a wrong number of cells matters.
    #[test]
    fn a_column_that_is_not_used_drops_no_row() {
        let folder = tempfile::tempdir().unwrap();
        let text = b"subject,cond,note,y\nA,a,\0,1\nA,b,\xff\xfe\x81,2\nB,a,\0\xe4,3\nB,b,two,cells,2\n".to_vec();
        let how = of("y", &["cond"]);
        let path = file(&folder, "t.csv", text);
        assert_eq!(try_read(&[&path], &how).unwrap().1, ["A a 1 1", "A b 2 1", "B a 3 1"]);
        assert_eq!(errors(&[&path], &how), ["t.csv:5:1: the row has 5 cells; expected 4, as in the header"]);
    }

    fn gzip(text: &[u8]) -> Vec<u8> {
        let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(text).unwrap();
        packed.finish().unwrap()
    }

    /// Dates and times of a workbook are texts as in ISO 8601 and no numbers of days; what is no date of Excel's is a number.
    #[test]
    fn dates_of_workbooks_are_dates() {
        let folder = tempfile::tempdir().unwrap();
        let dates = [("45296", 1), ("45296.520833333336", 2), ("45296", 2), ("1.5416782407407408", 3), ("0.25", 4)];
        let cells = dates.into_iter().chain([("7.5", 0), ("-3", 1)]).enumerate();
        let row = |(i, (days, style)): (usize, (&str, usize))| {
            let row = i + 2;
            format!(
                "<row r=\"{row}\"><c r=\"A{row}\"><v>{i}</v></c><c r=\"B{row}\" s=\"{style}\"><v>{days}</v></c>\
                 <c r=\"C{row}\"><v>1</v></c></row>"
            )
        };
        let head =
            ["subject", "day", "y"].map(|name| format!("<c t=\"inlineStr\"><is><t>{name}</t></is></c>")).concat();
        let sheet = format!("<row r=\"1\">{head}</row>{}", cells.map(row).collect::<String>());
        let read = study(&file(&folder, "t.xlsx", workbook(&[("One", &sheet)], "")), "y", "day");
        let mut levels = read.measured.counts.factors[0].levels.clone();
        levels.sort_unstable();
        assert_eq!(levels, ["-3", "06:00:00", "2024-01-05", "2024-01-05T12:30:00", "37:00:01", "7.5"]);
    }

    /// The same table as text, packed, and as a workbook; what unpacks to too much is refused.
    #[test]
    fn gzip_and_workbooks_are_read_like_text() {
        let folder = tempfile::tempdir().unwrap();
        let cell = |place: &str, text: &str| match text.parse::<f64>() {
            Ok(number) => format!("<c r=\"{place}\"><v>{number}</v></c>"),
            Err(_) => format!("<c r=\"{place}\" t=\"inlineStr\"><is><t>{text}</t></is></c>"),
        };
        let text = "subject,note,c,y\nA,\"x, y\",0.5,1\n\nB,,2,2\n";
        let sheet = "<row r=\"1\">".to_owned()
            + &[cell("A1", "subject"), cell("B1", "note"), cell("C1", "c"), cell("D1", "y")].concat()
            + "</row><row r=\"2\">"
            + &[cell("A2", "A"), cell("B2", "x, y"), cell("C2", "0.5"), cell("D2", "1")].concat()
            + "</row><row r=\"4\">"
            + &[cell("A4", "B"), cell("C4", "2"), cell("D4", "2"), "<c r=\"F4\" s=\"0\"/>".to_owned()].concat()
            // The value of this formula is an empty text.
            + "<c r=\"G4\" t=\"str\"><f>IF(TRUE,\"\")</f><v></v></c>"
            + "</row>";
        let plain = study(&file(&folder, "t.csv", text), "y", "c");
        let book = workbook(&[("Data &amp; more", &sheet), ("Notes", "")], "");
        for (name, bytes) in
            [("d/t.csv.gz", gzip(text.as_bytes())), ("t.xlsx", book), ("e/u.xlsx", workbook(&[("One", &sheet)], ""))]
        {
            let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
            let path = file(&folder, name, bytes);
            let read = study(&path, "y", "c");
            assert_eq!((&read.measured, &read.source.errors), (&plain.measured, &vec![]), "{name}");
            assert_eq!(read.source.files[0].sha256, Some(hash));
            let note = "only the sheet Data & more was read; expected one sheet (the others were ignored: Notes)";
            assert_eq!(warnings(&read), [note; 1][..usize::from(name == "t.xlsx")], "{name}");
        }
        // In a folder, too.
        file(&folder, "e/~$u.xlsx", "the name of who opened it");
        for inside in ["d", "e"].map(|name| study(&folder.path().join(name), "y", "c")) {
            assert_eq!((&inside.measured, inside.source.errors), (&plain.measured, vec![]));
        }
        // The lines of a workbook are its rows.
        let wide = sheet.replace("<c r=\"F4\" s=\"0\"/>", "<c r=\"F4\"><v>1</v></c>");
        let how = of("y", &["c"]);
        let said = errors(&[&file(&folder, "w.xlsx", workbook(&[("One", &wide)], ""))], &how);
        assert_eq!(said, ["w.xlsx:4:1: the row has 6 cells; expected 4, as in the header"]);
        // The quoted comma in B2 ends no cell.
        let wrong = sheet.replace("<c r=\"D2\"><v>1</v>", "<c r=\"D2\"><v>1.5</v>");
        let counted = ReadOptions { count: Some("y".to_owned()), ..of("c", &["note"]) };
        let said = errors(&[&file(&folder, "c.xlsx", workbook(&[("One", &wrong)], ""))], &counted);
        assert_eq!(said, ["c.xlsx:2:4: y is \"1.5\"; expected a count, a whole number from 0 to 10^12"]);
        // A workbook keeps 53 bits of a number; a column that is not used may have more.
        for (number, column) in [("9007199254740991", "c"), ("9007199254740992", "note"), ("9007199254740993", "c")] {
            let long = sheet.replace("<v>0.5</v>", &format!("<v>{number}</v>"));
            let said = errors(&[&file(&folder, "n.xlsx", workbook(&[("One", &long)], ""))], &of("y", &[column]));
            let expected =
                "n.xlsx:2:3: is a number of 2^53 or more, whose last digits a workbook does not keep; expected text";
            assert_eq!(said, [expected; 1][..usize::from(number.ends_with('3'))], "{number}");
        }

        let zeros = vec![b'0'; (64 << 20) + 1];
        let mut bomb = ZipWriter::new(Cursor::new(Vec::new()));
        bomb.start_file("xl/sharedStrings.xml", SimpleFileOptions::default()).unwrap();
        bomb.write_all(&zeros).unwrap();
        let far = "<row r=\"1\"><c r=\"A1\"><v>1</v></c></row><row r=\"2\"><c r=\"XFD2\"><v>1</v></c></row>";
        let far: String = (1..6000)
            .map(|row| {
                far.replace("\"1\"", &format!("\"{}\"", 2 * row))
                    .replace("A1", &format!("A{}", 2 * row))
                    .replace("D2", &format!("D{}", 2 * row + 1))
                    .replace("\"2\"", &format!("\"{}\"", 2 * row + 1))
            })
            .collect();
        let short = gzip(text.as_bytes());
        let formula = sheet.replace("<c r=\"D4\"><v>2</v></c>", "<c r=\"D4\"><f>1+1</f></c>");
        let said = errors(&[&file(&folder, "formula.xlsx", workbook(&[("One", &formula)], ""))], &how);
        assert!(said.len() == 1 && said[0].starts_with("formula.xlsx:4:4: is a formula without a value"), "{said:?}");
        for (name, bytes, expected) in [
            ("bomb.csv.gz", gzip(&zeros), "unpacks to more than 67108864 bytes; expected fewer"),
            ("bomb.xlsx", bomb.finish().unwrap().into_inner(), "unpacks to more than 67108864 bytes; expected fewer"),
            (
                "far.xlsx",
                workbook(&[("One", &far)], ""),
                "the sheet has more than 67108864 bytes as CSV; expected fewer",
            ),
            ("cut.csv.gz", short[..short.len() - 9].to_vec(), "cannot be unpacked: "),
            ("no.xlsx", b"PK\x03\x04\0\0".to_vec(), "cannot be unpacked: "),
            ("row.xlsx", workbook(&[("One", &sheet.replace("\"A2\"", "\"A99999999999\""))], ""), ""),
        ] {
            let said = errors(&[&file(&folder, name, bytes)], &how);
            assert!(said.len() == 1 && said[0].starts_with(&format!("{name}: {expected}")), "{said:?}");
        }
    }

    /// Columns that are levels, and answers in JSON.
    #[test]
    fn wide_tables_have_a_column_for_each_level() {
        let folder = tempfile::tempdir().unwrap();
        let path = file(
            &folder,
            "t.csv",
            "subject,group,low,high\nA,x,1,\"{\"\"Q0\"\":2}\"\nB,y,{\"Q0\":null},\"{\"\"Q1\"\":\"\"3\"\"}\"\n",
        );
        let how = ReadOptions {
            wide: Some(("level".to_owned(), ["low", "high"].map(String::from).to_vec())),
            ..with_factors(&["group"])
        };
        let read = Study::read(std::slice::from_ref(&path), &how).unwrap();
        let expected =
            [("A", vec!["x", "high"], "2", 1), ("A", vec!["x", "low"], "1", 1), ("B", vec!["y", "high"], "3", 1)];
        assert_eq!((counts(&read), read.source.left_out(Reason::NoResponse)), (expected.to_vec(), (1, 1)));
        assert_eq!((read.source.files[0].rows, read.source.files[0].counted), (4, 3));
        let count = file(&folder, "c.csv", "subject,group,low,high,count\nA,x,1,2,1\nB,y,.,3,1\n");
        let of_counts = ReadOptions { factors: None, ..how };
        assert_eq!(Study::read(&[count], &of_counts).unwrap().measured.counts, read.measured.counts);
        let long = file(&folder, "l.csv", "subject,group,level,y\nA,x,low,1\nA,x,high,2\nB,y,high,3\n");
        assert_eq!(Study::read(&[long], &of("y", &["group", "level"])).unwrap().measured, read.measured);
    }

    #[test]
    fn names_that_look_alike_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let ids = [" MAR1", "mar1", "MAR1 ", "01", "1", "1.0", "S1", "S01", "S10", "5.1E+23"];
        let levels = ["-2", "-2.0", "NA", "nan"].into_iter().cycle();
        let rows: String = ids.iter().zip(levels).map(|(id, level)| format!("{id},{level},1\n")).collect();
        let read = study(&file(&folder, "ids.csv", format!("subject,cond,score\n{rows}")), "score", "cond");
        let expected = "the IDs 01, 1, 1.0; MAR1, mar1; S1, S01 differ only in capitals or in the form of a number, and are different participants; expected one ID for each participant";
        let found = warnings(&read);
        assert_eq!((&*found[0], read.measured.counts.subjects.len()), (expected, 9));
        let expected = "the ID 5.1E+23 is a rounded number, and may stand for several; expected IDs as text";
        assert_eq!(found[1], expected);
        let expected = "the levels -2, -2.0 of cond differ only in capitals or in the form of a number, and are different levels; expected one form of each level";
        assert_eq!(found[2], expected);
    }

    /// A result file that lost columns is a table like any other, whose rows count.
    #[test]
    fn practice_and_later_attempts_are_told_if_no_option_names_their_columns() {
        let folder = tempfile::tempdir().unwrap();
        let text = "subject_id,phase,attempt,c,score\nA,practice,1,a,1\nA,main,1,a,2\nA,main,2,a,3\nA,main,2,b,1\n";
        let path = file(&folder, "t.csv", text);
        let named = |names: &[&str]| warnings(&Study::read(std::slice::from_ref(&path), &of("score", names)).unwrap());
        let practice = "1:12: 1 of 4 rows are practice according to the column phase, which no option names, and count as ratings; expected this column among the factors, with only its other levels";
        let attempts = "1:18: 2 of 4 rows are later attempts according to the column attempt, which no option names, and count as ratings; expected one row for each trial, or the columns subject_id, session_id, phase, trial and attempt, by which only the last attempt counts";
        assert_eq!(named(&["c"]), [practice, attempts]);
        assert_eq!(named(&["c", "phase"]), [attempts]);
        assert_eq!(named(&["c", "phase", "attempt"]), [""; 0]);
    }

    /// Small exports in the form of PsychoPy 2023.2 (wide CSV), jsPsych 7 and OpenSesame 4.0, made by hand.
    #[test]
    fn exports_of_other_programs_need_few_options() {
        for (name, response, factor, participants, (ratings, missing)) in [
            ("psychopy", "slider.response", "contrast", "participant", (11, 3)),
            ("jspsych", "response", "gloss", "subject", (8, 10)),
            ("opensesame", "response", "image_size", "subject_nr", (11, 3)),
        ] {
            let path = common::golden_path(&format!("programs/{name}.csv"));
            let read = study(&path, response, factor);
            let counts = &read.measured.counts;
            assert_eq!((counts.total(), read.source.left_out(Reason::NoResponse).0), (ratings, missing), "{name}");
            assert_eq!((counts.subjects.len(), &read.source.errors), (2, &vec![]), "{name}");
            assert!(counts.is_ordered(None) && counts.factors[0].levels.len() > 1, "{name}: {counts:?}");
            let note = format!(
                "participants are in the column {participants}; expected subject_id, or a column that you name"
            );
            assert!(read.source.warnings.iter().any(|warning| warning.message == note), "{:?}", read.source.warnings);
        }
    }
}

mod discovery {
    use super::*;

    #[test]
    fn a_folder_stands_for_its_data_files_or_else_for_its_csv_files() {
        let folder = tempfile::tempdir().unwrap();
        let row = |subject: &str| format!("subject_id,width,rating,count\n{subject},0.1,1,1\n");
        for (name, subject) in
            [("b/S10_data.csv", "c"), ("b/S2_data.csv", "b"), ("a/x_data.csv", "a"), ("b/other.csv", "d")]
        {
            file(&folder, name, row(subject));
        }
        file(&folder, "a/._x_data.csv", [0xff, 0]);
        file(&folder, ".git/y_data.csv", row("e"));
        let subjects = |paths: &[&Path]| {
            let (source, rows) = read(paths, &ReadOptions::default());
            assert_eq!(source.errors, []);
            rows.iter().map(|row| row[..1].to_owned()).collect::<String>()
        };
        let b = folder.path().join("b");
        assert_eq!(subjects(&[folder.path()]), "abc");
        assert_eq!(
            subjects(&[&b.join("other.csv"), &b.join("S10_data.csv"), folder.path(), &b.join("../b/other.csv")]),
            "dcab"
        );
        fs::remove_file(b.join("S2_data.csv")).unwrap();
        fs::remove_file(b.join("S10_data.csv")).unwrap();
        assert_eq!(subjects(&[&b]), "d");
        // An analysis that was written into the folder counts nothing again, but can be read by its name.
        file(&folder, "b/analysis/cells.csv", row("z"));
        let counts = file(&folder, "b/analysis/counts.csv", row("z"));
        assert_eq!((subjects(&[&b]).as_str(), subjects(&[&counts]).as_str()), ("d", "z"));
        // One that was written into a data set does not hide its sessions.
        let (results, files) = study(&["S1"]);
        for name in ["cells.csv", "counts.csv"] {
            fs::write(files[0].ancestors().nth(2).unwrap().join(name), row("z")).unwrap();
        }
        assert_eq!(read(&[results.path()], &ReadOptions::default()).1.len(), expected(&files).len());
    }

    #[test]
    fn missing_files_and_folders_are_reported() {
        let folder = tempfile::tempdir().unwrap();
        let good = file(&folder, "good.csv", "subject_id,width,rating,count\nA,0.1,1,1\n");
        fs::create_dir(folder.path().join("void")).unwrap();
        let said =
            errors(&[&folder.path().join("void"), &folder.path().join("lost.csv"), &good], &ReadOptions::default());
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said[0].starts_with("void: contains no tables; expected "), "{said:?}");
        assert!(said[1].starts_with("lost.csv: does not exist; expected "), "{said:?}");
        assert!(try_read(&[], &ReadOptions::default()).is_err());
    }
}

mod errors {
    use super::*;

    /// Damages the first file of a study with two participants, and returns the errors and the number of rows that
    /// count.
    fn damaged(change: impl Fn(&Path)) -> (Vec<String>, u64) {
        let (folder, files) = study(&["S1", "S2"]);
        change(&files[0]);
        let (source, rows) = read(&[folder.path()], &ReadOptions::default());
        let sum = |count: fn(&FileRead) -> u64| source.files.iter().map(count).sum::<u64>();
        let counted = sum(|file| file.counted);
        assert_eq!(rows.len() as u64, counted);
        assert_eq!(rows.iter().filter(|row| row.starts_with("S2 ")).count() as u64, MAIN, "{:?}", source.errors);
        assert_eq!(sum(|file| file.counted + file.practice + file.superseded + file.erroneous), sum(|file| file.rows));
        let said = errors(&[folder.path()], &ReadOptions::default()).into_iter();
        let short =
            |text: String| text.replace("small-one/data/subject-", "").replace("_session-1_task-smallone_data", "");
        (said.map(short).collect(), counted)
    }

    /// For each kind of bad cell, row or file: its message, its place, and how many of 24 ratings still count.
    #[test]
    fn each_kind_has_its_own_message_and_the_rest_counts() {
        let interrupted = "as after an interrupted write; expected a complete row (this one is left out)";
        let names = "expected one of row_id, experiment, subject_id, session_id, phase, block,";
        // Line 18 is trial 11 of the main phase, which was rated once.
        for (column, cell, expected) in [
            ("rating", "4", "85: rating is \"4\"; expected a rating from 0 to 3"),
            ("rating", "", "85: rating is empty; expected a rating from 0 to 3"),
            ("trial", "0", "40: trial is \"0\"; expected the number of a trial, from 1 to 1,000,000"),
            ("subject_id", "", "28: subject_id is empty; expected a participant"),
            ("experiment", "ü,x", "18: experiment is \"ü,x\"; expected small-one, as in the first row"),
        ] {
            assert_eq!(damaged(|file| set_cell(file, 18, column, cell)), (vec![format!("S1.csv:18:{expected}")], 23));
        }
        let width = columns(&small()).len();
        type Damage = fn(String) -> Vec<u8>;
        let cases: [(Damage, String, u64); 13] = [
            (
                |text| {
                    let at = text.find("\nS1_1_main_0011_1").unwrap() + "\nS1_1_main_0011_1,small-".len();
                    [&text.as_bytes()[..at], b"\xff", &text.as_bytes()[at + 1..]].concat()
                },
                "18:24: the cell is not UTF-8 text; expected UTF-8".into(),
                23,
            ),
            (
                |text| text.replacen("\nS1_1_main_0011_1,", "\nS1_1_main_0011_1,more,", 1).into(),
                format!("18:1: the row has {} cells; expected {width}, as in the header", width + 1),
                23,
            ),
            (|text| text[..text.len() - 30].into(), format!("19:1: the last row is cut off, {interrupted}"), 23),
            // What is left of the last level looks like a level, and only the line feed is missing.
            (|text| text[..text.len() - 3].into(), format!("19:1: the last row is cut off, {interrupted}"), 23),
            (|text| text[..text.len() - 1].into(), format!("19:1: the last row is cut off, {interrupted}"), 23),
            (|text| (text + "S1_1_ma").into(), format!("20:1: the last row is cut off, {interrupted}"), 24),
            (|text| (text + &"\0".repeat(5000)).into(), format!("20:1: the last row contains zero bytes, {interrupted}"), 24),
            (
                |text| format!("{text}{}\n", text.lines().nth(17).unwrap()).into(),
                "20:1: row_id \"S1_1_main_0011_1\" already appears above; expected each row only once (this one is left out)".into(),
                24,
            ),
            (
                |text| text.replace(",rating,", ",ratings,").into(),
                format!("1:1: the column rating is missing; {names}"),
                12,
            ),
            (|_| b"".to_vec(), "1:1: the file is empty; expected a header row".into(), 12),
            (|_| b"P\0\x03\x04\0\0".to_vec(), "1:1: is not a CSV file: its first line contains zero bytes".into(), 12),
            (|_| b"\xfd7zXZ\0".to_vec(), "1:1: is a compressed file or an old spreadsheet".into(), 12),
            (|_| vec![b'x'; 2_000_000], format!("1:1: the first line has one cell, \"{}…\"; expected the", "x".repeat(40)), 12),
        ];
        for (change, expected, left) in cases {
            let (said, counted) = damaged(|file| fs::write(file, change(fs::read_to_string(file).unwrap())).unwrap());
            assert_eq!((said.len(), counted), (1, left), "{said:#?}");
            assert!(said[0].starts_with(&format!("S1.csv:{expected}")), "{}\nexpected\n{expected}", said[0]);
        }
        let (said, counted) = damaged(|file| fs::write(file.with_extension("json"), "{").unwrap());
        let broken = "S1.json:1:1: is not a sidecar of a session: EOF while parsing an object at line 1 column 1";
        assert!(said.len() == 1 && said[0].starts_with(broken) && counted == 24, "{said:?}");
        let (said, _) = damaged(|file| fs::write(file.with_extension("json"), "[]").unwrap());
        assert_eq!(said, ["S1.json:1:1: is not a sidecar of a session; expected a JSON object"]);
    }

    #[test]
    fn a_duplicated_session_counts_once() {
        let (folder, files) = study(&["S1", "S2"]);
        file(&folder, "z_data.csv", fs::read(&files[0]).unwrap());
        let said = super::errors(&[folder.path()], &ReadOptions::default());
        let first = "z_data.csv:2:1: row_id \"S1_1_practice_0001_1\" already appears in small-one/data/subject-S1_session-1_task-smallone_data.csv; expected each row only once (this one is left out)";
        assert_eq!((said.len(), &*said[0]), (6, first));
        assert_eq!(said[5], "z_data.csv: further rows with errors: 13; expected none");
        let (source, rows) = read(&[folder.path()], &ReadOptions::default());
        assert_eq!((sorted(rows), source.files[2].erroneous), (expected(&files), 18));
    }

    #[test]
    fn definitions_are_never_mixed() {
        let (folder, _) = study(&["S1", "S2"]);
        let other = definition::parse("x", &TEXT.replace("0.8]", "0.7]")).unwrap();
        session(&folder.path().join("a"), &other, "S3", usize::MAX);
        let said = super::errors(&[folder.path()], &ReadOptions::default());
        let [own, small] = [&other, &small()].map(|protocol| definition::hash(protocol)[..12].to_owned());
        let kind = |hash: &str| format!("is a session of the experiment small-one (definition {hash})");
        assert!(said.len() == 1 && said[0].contains(&kind(&own)) && said[0].contains(&kind(&small)), "{said:?}");
        assert!(
            said[0].ends_with("; expected files of one experiment")
                && try_read(&[folder.path()], &ReadOptions::default()).is_err()
        );
    }

    /// For tables from various sources: how each is read, its errors, and the rows that still count.
    #[test]
    fn each_error_in_a_table_has_its_message_and_place() {
        let folder = tempfile::tempdir().unwrap();
        let cases: [(&str, ReadOptions, &[&str], &[&str]); 3] = [
            (
                "subject_id,width,rating,count\nA,0.1,1,x\nA,0.1,1,-2\nA,0.1,1,1.5\nA,0.1,1,1e30\n,0.1,1,1\nA,0.1,,1\nA,0.1,1\nA,\0,1,1\nA,0.1,1,7",
                ReadOptions::default(),
                &[
                    "2:9: count is \"x\"; expected a count, a whole number from 0 to 10^12",
                    "3:9: count is \"-2\"; expected a count, a whole number from 0 to 10^12",
                    "4:9: count is \"1.5\"; expected a count, a whole number from 0 to 10^12",
                    "5:9: count is \"1e30\"; expected a count, a whole number from 0 to 10^12",
                    "8:1: the row has 3 cells; expected 4, as in the header",
                    "9:3: the cell contains a zero byte; expected text",
                ],
                &["A 0.1 1 7"],
            ),
            (
                "subject_id,width,rating\nA,0.1,1\n\"A,0.1,1\nA,0.1,2\nA,0.4,3\n",
                with_factors(&["width"]),
                &["3:1: a quote is never closed; expected a closing quote"],
                &["A 0.1 1 1", "A 0.1 2 1", "A 0.4 3 1"],
            ),
            (
                "subject_id,width,rating,note\nA,0.1,1,\"two\nlines\"\nA,0.1,2,\"x\nA,0.4,1,\"y\nA,0.4,3,\"z\" z\n",
                with_factors(&["width"]),
                &[
                    "4:1: a cell continues after its closing quote, in another line; expected quotes around whole cells",
                    "5:9: a quote is never closed; expected a closing quote",
                ],
                &["A 0.1 1 1", "A 0.4 3 1"],
            ),
        ];
        for (text, how, expected, left) in cases {
            let path = file(&folder, "t.csv", text);
            let expected: Vec<String> = expected.iter().map(|error| format!("t.csv:{error}")).collect();
            assert_eq!(super::errors(&[&path], &how), expected);
            assert_eq!(try_read(&[&path], &how).map(|(_, rows)| rows).unwrap_or_default(), left);
        }
    }

    #[test]
    fn without_rows_that_count_there_is_no_study() {
        let folder = tempfile::tempdir().unwrap();
        session(folder.path(), &small(), "S1", 2);
        let said = super::errors(&[folder.path()], &ReadOptions::default());
        assert!(try_read(&[folder.path()], &ReadOptions::default()).is_err());
        assert!(
            said[0].ends_with("none of the rows (2) counts: 2 from practice; expected ratings of main trials"),
            "{said:?}"
        );
    }
}

#[path = "../../fuzz/targets.rs"]
mod targets;

#[test]
fn every_corpus_file_is_accepted_or_rejected() {
    let archive = File::open(concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/corpus.tar.gz")).unwrap();
    let mut counts: BTreeMap<String, u32> = BTreeMap::new();
    for entry in tar::Archive::new(GzDecoder::new(archive)).entries().unwrap() {
        let mut entry = entry.unwrap();
        let path = entry.path().unwrap().display().to_string();
        let ["corpus", folder, file] = path.split('/').collect::<Vec<_>>()[..] else { continue };
        if file.is_empty() {
            continue;
        }
        let (_, target) = targets::ALL.iter().find(|(name, _)| *name == folder).unwrap();
        let mut content = Vec::new();
        entry.read_to_end(&mut content).unwrap();
        // A panic names only the target, so this names the file.
        println!("{path}");
        target(&content);
        *counts.entry(folder.to_owned()).or_default() += 1;
    }
    withstood("files that fuzzers found", counts.values().sum::<u32>() as usize, &[PANICS, HANGS]);
    for (name, _) in targets::ALL {
        assert!(counts.get(*name).is_some_and(|count| *count >= 30), "{name}: the corpus has lost files: {counts:?}");
    }
}
