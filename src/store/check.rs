//! Is this file what it should be? Finds every fault, not the first only.

use std::{
    collections::{BTreeSet, HashMap},
    path::Path,
};

use super::{
    FileFault, FileFaults, definition, file::read_text, frames, image, matches, observer, profile, readings, results,
    sidecar::Sidecar, toml::Document,
};
use crate::{
    display::DisplayProfile,
    experiment::{Identity, Protocol, RowContext, Schedule, TrialRecord, columns, columns_by_header},
};

/// A file without a fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// What it is.
    pub sentence: String,
    /// The display profile, where it is one: what speaks against relying on it depends on the day.
    pub profile: Option<DisplayProfile>,
}

impl From<String> for Checked {
    fn from(sentence: String) -> Self {
        Self { sentence, profile: None }
    }
}

/// Checks a definition, a display profile, an observer (`.toml`), a result file, a photometer's readings or the answers of a
/// nulling (`.csv`), an image (`.png`), or a built-in definition by its name, and says in one sentence what it is.
///
/// # Errors
/// Every fault.
pub fn check(name_or_path: &str) -> Result<Checked, FileFaults> {
    if definition::BUILT_IN.iter().any(|built_in| built_in.name == name_or_path) {
        return check_definition(definition::open(name_or_path)?).map(Checked::from);
    }
    let path = Path::new(name_or_path);
    let sentence = match path.extension().and_then(|extension| extension.to_str()) {
        Some("csv") if name_or_path.ends_with(frames::SUFFIX) => check_frames(path),
        Some("csv") => match first_column(path).as_deref() {
            Some("channel") => check_readings(path),
            Some("event") => check_matches(path),
            _ => check_results(path),
        },
        Some("png") => image::prove(path),
        Some("toml") => return check_toml(name_or_path, &read_text(path)?),
        _ if path.is_dir() || !path.exists() => Err(definition::open(name_or_path)
            .err()
            .unwrap_or_else(|| FileFaults::whole(name_or_path, "cannot be checked; expected a .toml or .csv file"))),
        _ => Err(FileFaults::whole(
            name_or_path,
            "is not a known kind of file; expected a definition, display profile or observer (.toml), a result file or readings (.csv), or an image (.png)",
        )),
    };
    sentence.map(Checked::from)
}

/// The kinds of TOML file differ in a key that each must have.
fn check_toml(file: &str, text: &str) -> Result<Checked, FileFaults> {
    let document = Document::parse(file, text)?;
    if document.has("transfer") || document.has("channels") {
        let profile = profile::parse(file, text)?;
        return Ok(Checked { sentence: format!("display profile {}", profile.sentence()), profile: Some(profile) });
    }
    if document.has("spread") {
        observer::parse_vision(file, text)?;
        return Ok("parameters of the vision observer".to_owned().into());
    }
    if document.has("thresholds") {
        observer::parse(file, text)?;
        return Ok("parameters of the ordered-logit observer".to_owned().into());
    }
    check_definition(definition::parse(file, text)?).map(Checked::from)
}

fn check_definition(protocol: Protocol) -> Result<String, FileFaults> {
    let trial = |error: String| FileFaults::whole(&protocol.name, error);
    let identity = Identity::new("S001", "1").map_err(|error| trial(error.to_string()))?;
    Schedule::new(&protocol, &identity, 1).map_err(|error| trial(error.to_string()))?;
    Ok(format!(
        "definition {}: {} practice and {} main trials, order {}",
        protocol.name,
        protocol.design.practice,
        protocol.main_trials(),
        protocol.design.order
    ))
}

/// A result file, held against the definition and seed in its sidecar where there is one.
fn check_results(path: &Path) -> Result<String, FileFaults> {
    let file = path.display().to_string();
    let whole = |message: String| FileFaults::whole(&file, message);
    let content =
        std::fs::read(path).map_err(|error| whole(format!("cannot be read: {error}; expected a readable file")))?;
    let beside = path.with_extension("json");
    let sidecar = Sidecar::read(&beside).map_err(|error| whole(error.to_string()))?;
    let Some(sidecar) = sidecar else {
        let header = content.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let header = String::from_utf8_lossy(header);
        let rows = results::parse(&file, &content, &columns_by_header(header.trim_end().split(',')))?;
        let faults = repeated(&file, &rows);
        let summary = format!("result file: {} rows; no sidecar beside it, so the order was not checked", rows.len());
        return if faults.is_empty() { Ok(summary) } else { Err(FileFaults(faults)) };
    };
    let protocol = definition::from_json(&beside.display().to_string(), &sidecar.definition)?;
    let rows = results::parse(&file, &content, &columns(&protocol))?;
    let mut faults = repeated(&file, &rows);
    let Some(first) = rows.first() else {
        return Ok("result file: 0 rows; none of the planned trials is rated".to_owned());
    };
    let identity = Identity::new(&first.subject_id, &first.session_id).map_err(|error| whole(error.to_string()))?;
    let schedule = Schedule::new(&protocol, &identity, sidecar.seed).map_err(|error| whole(error.to_string()))?;
    let context = RowContext { protocol: &protocol, schedule: &schedule, identity: &identity, sitting: 1 };
    let mut rated = BTreeSet::new();
    for (row, line) in rows.iter().zip(2..) {
        match row.planned_trial(&context) {
            Ok(trial) => _ = rated.insert(trial),
            Err(message) => faults.push(FileFault::at(&file, (line, 1), message)),
        }
    }
    let (rows, rated, planned, name) = (rows.len(), rated.len(), schedule.trials.len(), &protocol.name);
    let summary = format!("result file: {rows} rows; {rated} of {planned} planned trials of {name} rated");
    if faults.is_empty() { Ok(summary) } else { Err(FileFaults(faults)) }
}

/// The name of a table's first column; `None` where there is none to be read.
fn first_column(path: &Path) -> Option<String> {
    let text = std::fs::read(path).ok()?;
    let name = text.split(|byte| b",;\r\n".contains(byte)).next()?;
    Some(String::from_utf8_lossy(name).trim_start_matches('\u{feff}').trim().to_owned())
}

fn check_readings(path: &Path) -> Result<String, FileFaults> {
    let readings = readings::open(path)?;
    let channels: Vec<&str> = readings.channels().iter().map(|channel| channel.name()).collect();
    Ok(format!("{} readings of a photometer, {}", readings.all().len(), channels.join(", ")))
}

fn check_matches(path: &Path) -> Result<String, FileFaults> {
    Ok(format!("{} matches of a display by eye", matches::open(path)?.len()))
}

/// The frames beside a result file.
fn check_frames(path: &Path) -> Result<String, FileFaults> {
    let rows = frames::read(path)?;
    let intervals: usize = rows.iter().map(|row| row.intervals_us.len()).sum();
    Ok(format!("frames of a session: {intervals} intervals in {} stretches", rows.len()))
}

fn repeated(file: &str, rows: &[TrialRecord]) -> Vec<FileFault> {
    let mut lines = HashMap::new();
    let repeated = rows.iter().zip(2..).filter_map(|(row, line)| {
        let first = lines.insert(row.row_id.as_str(), line)?;
        let message = format!("row_id {} stands in line {first} already; expected every row_id once", row.row_id);
        Some(FileFault::at(file, (line, 1), message))
    });
    repeated.collect()
}
