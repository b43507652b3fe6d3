//! Functions that several test programs share: they run the real program and read its files.

// Each test program uses only some of these functions.
#![allow(dead_code)]

use std::{
    collections::BTreeMap,
    ffi::OsStr,
    fmt::{Debug, Display},
    fs,
    io::Write as _,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    str::FromStr,
    time::Duration,
};

use machband::{
    experiment::{
        FrameCount, Identity, OrderedLogit, Protocol, RowContext, Session, SessionOptions, TrialRecord, TrialResponse,
        columns, simulate,
    },
    store::{recorded, results, session::Interrupted},
};

pub const MACHBAND: &str = env!("CARGO_BIN_EXE_machband");

/// Splits a command line into arguments, as a shell does.
pub fn split(line: &str) -> Vec<String> {
    shlex::split(line).unwrap()
}

/// `machband` with these arguments, in a folder and without a display.
pub fn command<S: AsRef<OsStr>>(folder: &Path, arguments: &[S]) -> Command {
    let mut command = Command::new(MACHBAND);
    let command_line = command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command_line.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command
}

/// Runs `machband` with these arguments.
pub fn machband<S: AsRef<OsStr>>(folder: &Path, arguments: &[S]) -> Output {
    command(folder, arguments).output().unwrap()
}

/// Says why a test is skipped, or fails if `MACHBAND_REQUIRE_…` with this name is 1.
pub fn skip(name: &str, why: &str) {
    let variable = format!("MACHBAND_REQUIRE_{name}");
    assert!(std::env::var_os(&variable).is_none_or(|value| value != "1"), "{variable}=1, but {why}");
    // Not with `eprintln!`, because the test harness captures it.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {why}");
}

/// Whether there is a graphics adapter; otherwise, the test is skipped.
pub fn has_graphics() -> bool {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let found = !pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all())).is_empty();
    if !found {
        skip("GPU", "a test that renders the window: no graphics adapter");
    }
    found
}

/// The header information and the samples of a PNG.
pub fn pixels(path: &Path) -> (png::Info<'static>, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
    let mut samples = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut samples).unwrap();
    (reader.info().clone(), samples)
}

/// Reads and parses a JSON file.
pub fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Reads the header and the rows of a CSV file, without comments.
pub fn table(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path);
    let mut reader = reader.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let header = reader.headers().unwrap().iter().map(str::to_owned).collect();
    (header, reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect())
}

/// A row of a table: its cells by the names of their columns.
pub type Record = BTreeMap<String, String>;

/// The rows of a CSV file, without comments.
pub fn records(path: &Path) -> Vec<Record> {
    let (header, rows) = table(path);
    rows.into_iter().map(|row| header.iter().cloned().zip(row).collect()).collect()
}

/// A cell as a number.
#[track_caller]
pub fn number<T: FromStr<Err: Debug>>(row: &Record, column: &str) -> T {
    row[column].parse().unwrap_or_else(|error| panic!("{column} of {row:?}: {error:?}"))
}

/// A workbook with these sheets, as XML, and one text that cells may share.
pub fn workbook(sheets: &[(&str, &str)], shared: &str) -> Vec<u8> {
    const MAIN: &str = "xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\"";
    const OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let mut packed = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let mut add = |name: &str, text: String| {
        packed.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        packed.write_all(text.as_bytes()).unwrap();
    };
    let link = |id: &str, kind: &str, to: &str| {
        format!("<Relationship Id=\"{id}\" Type=\"{OFFICE}/{kind}\" Target=\"{to}\"/>")
    };
    let (mut names, mut links) = (String::new(), link("shared", "sharedStrings", "sharedStrings.xml"));
    for (index, (name, rows)) in sheets.iter().enumerate() {
        let (id, file) = (format!("r{}", index + 1), format!("worksheets/s{}.xml", index + 1));
        names += &format!("<sheet name=\"{name}\" sheetId=\"{}\" r:id=\"{id}\"/>", index + 1);
        links += &link(&id, "worksheet", &file);
        add(&format!("xl/{file}"), format!("<worksheet {MAIN}><sheetData>{rows}</sheetData></worksheet>"));
    }
    let relations = "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"";
    let of = link("r", "officeDocument", "xl/workbook.xml");
    add("_rels/.rels", format!("<Relationships {relations}>{of}</Relationships>"));
    add("xl/_rels/workbook.xml.rels", format!("<Relationships {relations}>{links}</Relationships>"));
    // Plain numbers, and the formats of dates and times.
    let styles = [0, 14, 22, 46, 21].map(|format| format!("<xf numFmtId=\"{format}\"/>")).concat();
    add("xl/styles.xml", format!("<styleSheet {MAIN}><cellXfs count=\"5\">{styles}</cellXfs></styleSheet>"));
    add("xl/sharedStrings.xml", format!("<sst {MAIN}><si><t>{shared}</t></si></sst>"));
    add("xl/workbook.xml", format!("<workbook {MAIN} xmlns:r=\"{OFFICE}\"><sheets>{names}</sheets></workbook>"));
    packed.finish().unwrap().into_inner()
}

/// The path of a file in `tests/golden`.
pub fn golden_path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(file)
}

/// The rows of a golden file: the first column if it is text, or else an empty string, and the numbers.
pub fn golden(file: &str) -> Vec<(String, Vec<f64>)> {
    let row = |row: Vec<String>| {
        let named = row[0].parse::<f64>().is_err();
        let numbers = row.iter().skip(usize::from(named)).map(|field| field.parse().unwrap()).collect();
        (if named { row[0].clone() } else { String::new() }, numbers)
    };
    table(&golden_path(file)).1.into_iter().map(row).collect()
}

/// Checks that a page of the documentation has what the program says. `UPDATE_DOCS=1` writes it.
pub fn assert_documented(page: &str, expected: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(path, expected).unwrap();
    } else {
        let found = fs::read_to_string(path).unwrap();
        assert!(found == expected, "{page} is out of date: run UPDATE_DOCS=1 cargo test --test store");
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The output of a run that must succeed. Nothing may be written to stderr when stdout is piped.
pub fn succeeds<S: AsRef<OsStr> + Debug>(folder: &Path, arguments: &[S]) -> String {
    let output = machband(folder, arguments);
    let errors = text(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {errors}");
    assert_eq!(errors, "", "{arguments:?}: stderr must be empty when piped");
    text(&output.stdout)
}

/// The errors of a run that must fail with `status` and print nothing to stdout.
pub fn fails<S: AsRef<OsStr> + Debug>(folder: &Path, arguments: &[S], status: i32) -> String {
    let output = machband(folder, arguments);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {errors}");
    assert!(errors.starts_with("error: "), "{arguments:?}: {errors}");
    assert_eq!(text(&output.stdout), "", "{arguments:?}");
    errors
}

/// Runs commands that must fail and write nothing. A line has an exit status and `: `, what stands for `{}` in the command,
/// ` => `, and a part of the error.
pub fn refuses(folder: &Path, command: &str, cases: &str) {
    let before = everything(folder);
    for case in cases.lines().map(str::trim).filter(|case| !case.is_empty()) {
        let (given, expected) = case.split_once(" => ").unwrap_or_else(|| panic!("{case}"));
        let (status, words) = given.split_once(":").unwrap();
        let line = command.replace("{}", words.trim());
        let error = fails(folder, &split(&line), status.parse().unwrap());
        assert!(error.contains(expected), "{line}: expected {expected}: {error}");
    }
    assert!(everything(folder) == before, "{command}");
}

/// Every file below a folder and its content, in a fixed order. The content of a link is its target.
pub fn everything(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_symlink() {
            found.push((path.clone(), fs::read_link(&path).unwrap().into_os_string().into_encoded_bytes()));
        } else if path.is_dir() {
            found.extend(everything(&path));
        } else {
            found.push((path.clone(), fs::read(path).unwrap()));
        }
    }
    found.sort();
    found
}

/// The error of what must fail and change no file in a folder.
#[track_caller]
pub fn refused<T, E: Display>(folder: &Path, act: impl FnOnce() -> Result<T, E>) -> E {
    let before = everything(folder);
    let Err(error) = act() else { panic!("this succeeded") };
    assert!(everything(folder) == before, "files were changed: {error}");
    error
}

/// The path of a participant's first session of an experiment.
pub fn session_csv(results: &Path, experiment: &str, participant: &str) -> PathBuf {
    results.join(format!("{experiment}/data/subject-{participant}_session-1_task-{experiment}_data.csv"))
}

/// Changes the text of a file.
pub fn edit(path: &Path, change: impl FnOnce(&str) -> String) {
    let before = fs::read_to_string(path).unwrap();
    let after = change(&before);
    assert_ne!(after, before, "{}: the test did not change the file", path.display());
    fs::write(path, after).unwrap();
}

/// Replaces the cell in a line, counted from 1, under a column name.
pub fn set_cell(csv: &Path, line: usize, column: &str, cell: &str) {
    let (header, rows) = table(csv);
    let mut rows = [vec![header], rows].concat();
    let index = rows[0].iter().position(|name| name == column).unwrap();
    cell.clone_into(&mut rows[line - 1][index]);
    let mut writer = csv::Writer::from_path(csv).unwrap();
    rows.iter().for_each(|row| writer.write_record(row).unwrap());
}

/// Changes the first rating in a session's file.
pub fn change_rating(csv: &Path) {
    let (header, rows) = table(csv);
    let rating = header.iter().position(|name| name == "rating").unwrap();
    set_cell(csv, 2, "rating", if rows[0][rating] == "0" { "3" } else { "0" });
}

/// The rows of a session's file.
pub fn rows(csv: &Path, protocol: &Protocol) -> Vec<TrialRecord> {
    let read = results::parse(csv.to_str().unwrap(), &fs::read(csv).unwrap(), &columns(protocol));
    read.unwrap_or_else(|error| panic!("{error}"))
}

/// Lets the simulated observer answer the trials that are left of a session, until `record` returns an error.
pub fn answer<E>(
    found: &Interrupted,
    identity: &Identity,
    mut record: impl FnMut(&RowContext<'_>, &TrialResponse) -> Result<(), E>,
) -> Result<(), E> {
    let (protocol, schedule) = (found.course.protocol(), found.course.schedule());
    let context = RowContext { protocol, schedule, identity, sitting: found.sitting };
    let options = SessionOptions { pages: 0, frames: FrameCount::Off };
    let mut session = Session::new(found.course.clone(), &found.resumed, options);
    let start = Duration::from_secs_f64(found.elapsed_s);
    simulate(&mut session, &OrderedLogit::default(), identity, start, |response| record(&context, response))
}

/// The findings of `machband verify` about a session.
pub fn verified(csv: &Path) -> recorded::Verified {
    recorded::verify(csv, &mut recorded::Renderer::default())
}

/// Builds the library `tests/faults/NAME.c` with `cc`, which also links Rust programs; returns whether it succeeded.
/// Otherwise, the test is skipped.
pub fn c_library(name: &str, to: &Path) -> bool {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/faults").join(name).with_extension("c");
    let mut compiler = Command::new("cc");
    compiler.args(["-O1", "-Wall", "-Wextra", "-shared", "-fPIC", "-o"]).arg(to).arg(source).arg("-ldl");
    let why = match compiler.output() {
        Ok(output) if output.status.success() => return true,
        Ok(output) => String::from_utf8_lossy(&output.stderr).into_owned(),
        Err(error) => format!("cc: {error}"),
    };
    skip("FAULTS", &format!("no faults are injected: {why}"));
    false
}

/// The table of attacks, of which `docs/faults.md` has a summary. `scripts/attacks.sh` runs all attacks and adds up what
/// they print.
pub mod attacks {
    use std::io::Write as _;

    /// What an attack must not cause; a column of the table.
    pub const ROWS: &str = "rows lost";
    pub const FILES: &str = "files destroyed";
    pub const LIES: &str = "silent lies";
    pub const PANICS: &str = "panics";
    pub const HANGS: &str = "hangs";
    pub const ALL: [&str; 5] = [ROWS, FILES, LIES, PANICS, HANGS];

    /// Prints how many attacks of a class were made. A test calls this after its assertions, so that the attacks caused
    /// none of what was `checked`.
    pub fn withstood(class: &str, attacks: usize, checked: &[&str]) {
        let cells = ALL.map(|what| if checked.contains(&what) { "0" } else { "–" });
        // Not with `println!`, because the test harness captures it.
        let _ = writeln!(std::io::stderr(), "ATTACKS | {class} | {attacks} | {} |", cells.join(" | "));
    }
}

/// A simulated observer who looks at a display with a known profile.
pub mod eye {
    use machband::{display::matching::Match, light::Transfers};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    /// Standard deviation of a normal distribution, divided by its upper quartile.
    const SD_PER_QUARTILE: f64 = 1.482_602_218_505_602;

    /// The code at which the square vanishes for an observer who judges a relative difference of `threshold` correctly in
    /// 75 % of all cases. It is the code whose light is nearest to the light of the field as perceived in this match.
    pub fn matched_code(display: &Transfers, shown: &Match, threshold: f64, rng: &mut ChaCha8Rng) -> u8 {
        let deviate: f64 = StandardNormal.sample(rng);
        let noise = deviate * threshold * SD_PER_QUARTILE;
        // Gray has the light of green.
        let [red, _, blue] = shown.channel.rgb(1).map(usize::from);
        let index = 1 + blue - red;
        let ratio = |code: u8| display.linear_from_encoded([f64::from(code) / 255.0; 3])[index] / shown.rows.share();
        let away = |code: &u8| (ratio(*code).ln() - noise).abs();
        (0..=255u8).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap()
    }
}
