//! Identifies the type of a file and finds every error in it, not only the first.

use std::{
    collections::{BTreeSet, HashMap},
    path::Path,
};

use super::{
    FileError, FileErrors, StoreError,
    dataset::{self, DATA_FILE, FRAMES_SUFFIX},
    definition,
    file::{exists, read_bytes, read_text},
    image, matches, observer, profile,
    ratings::column_names,
    readings,
    recorded::{Order, Recorded},
    results,
    scene::{self, SceneFile},
    toml::Document,
};
use crate::{
    display::DisplayProfile,
    experiment::{Identity, OrderedLogit, Protocol, Schedule, VisionRater, columns_by_header},
    shading::Composition,
    system::{fonts, found},
};

/// A file without errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// A description of the file.
    pub sentence: String,
    /// The display profile, if the file is one. Callers need it because its reliability depends on today's date.
    pub profile: Option<DisplayProfile>,
    /// What does not work on this computer, or that a session did not end, if anything.
    pub warning: Option<String>,
}

impl From<String> for Checked {
    fn from(sentence: String) -> Self {
        Self { sentence, profile: None, warning: None }
    }
}

/// Checks a definition, display profile, observer or scene (`.toml`), a result file, photometer readings or visual matches
/// (`.csv`), an image (`.png`), or a built-in definition given by name, and describes it in one sentence.
///
/// # Errors
/// Returns every error in the file.
pub fn check(name_or_path: impl AsRef<Path>) -> Result<Checked, StoreError> {
    check_large(name_or_path, image::MAX_PIXELS)
}

/// Checks a file like [`check`]; an image may have up to `pixels` pixels.
///
/// # Errors
/// The same errors as [`check`].
pub fn check_large(name_or_path: impl AsRef<Path>, pixels: u64) -> Result<Checked, StoreError> {
    let path = name_or_path.as_ref();
    let name = path.display().to_string();
    if definition::built_in(path).is_some() {
        return check_definition(definition::open(path)?);
    }
    let checked = match path.extension().and_then(|extension| extension.to_str()) {
        // The seal of a session is also that of its frames.
        Some("csv") if name.ends_with(FRAMES_SUFFIX) && exists(path)? => {
            let session = check_session(Path::new(&format!("{}{DATA_FILE}", name.trim_end_matches(FRAMES_SUFFIX))))?;
            Checked { sentence: format!("frames of a {}", session.sentence), ..session }
        }
        Some("csv") => match column_names(path) {
            Ok(names) if names.first().is_some_and(|name| name == "channel") => {
                let readings = readings::open(path)?;
                let channels: Vec<&str> = readings.channels().iter().map(|channel| channel.name()).collect();
                format!("{} photometer readings, {}", readings.all().len(), channels.join(", ")).into()
            }
            Ok(names) if names.first().is_some_and(|name| name == "event") => {
                format!("{} visual matches of a display", matches::open(path)?.len()).into()
            }
            Err(error @ StoreError::Io { .. }) => return Err(error),
            // What is no table has the errors of a result file.
            _ => check_results(path)?,
        },
        Some("png") => image::verify(path, pixels)?.into(),
        Some("toml") => check_toml(path, &name, &read_text(path)?)?,
        _ => return Err(match found(path) {
            Ok(Some(metadata)) if metadata.is_file() => FileErrors::whole(
                path,
                "is not a known type of file; expected a definition, display profile, observer or scene (.toml), a result file or readings (.csv), or an image (.png)",
            ),
            _ => (definition::open(path).err())
                .unwrap_or_else(|| FileErrors::whole(path, "cannot be checked; expected a .toml, .csv or .png file")),
        }
        .into()),
    };
    Ok(checked)
}

/// Identifies the kind of TOML file by a required key that the other kinds lack.
fn check_toml(path: &Path, file: &str, text: &str) -> Result<Checked, StoreError> {
    let document = Document::parse(file, text)?;
    if document.has("mesh") || document.has("lamp") {
        let SceneFile { composition: Composition { bodies, lamps, .. }, notes, .. } = scene::read(path)?;
        let sentence = format!("scene; meshes: {}, lamps: {}", bodies.len(), lamps.len());
        let warning = (!notes.is_empty()).then(|| notes.join("; "));
        return Ok(Checked { sentence, profile: None, warning });
    }
    if document.has("transfer") {
        let profile = profile::parse(file, text)?;
        let sentence = format!("display profile {}", profile.sentence());
        return Ok(Checked { sentence, profile: Some(profile), warning: None });
    }
    if document.has("spread") {
        observer::parse::<VisionRater>(file, text)?;
        return Ok("parameters of the vision observer".to_owned().into());
    }
    if document.has("thresholds") {
        observer::parse::<OrderedLogit>(file, text)?;
        return Ok("parameters of the ordered-logit observer".to_owned().into());
    }
    check_definition(definition::parse(file, text)?)
}

fn check_definition(protocol: Protocol) -> Result<Checked, StoreError> {
    let trial = |error: String| FileErrors::whole(&protocol.name, error);
    let identity = Identity::new("S001", "1").map_err(trial)?;
    Schedule::new(&protocol, &identity, 1).map_err(|error| trial(error.to_string()))?;
    let sentence = format!(
        "definition {}: {} practice and {} main {}, order {}",
        protocol.name,
        protocol.design.practice,
        protocol.main_trials(),
        if protocol.main_trials() == 1 { "trial" } else { "trials" },
        protocol.design.order
    );
    let (_, missing) = fonts::covering(&protocol.foreign_letters());
    Ok(Checked { sentence, profile: None, warning: missing_fonts(&missing) })
}

/// How many characters a sentence lists.
const MOST_LISTED: usize = 20;

/// Says that no font of this computer has these characters; `None` if there are none.
pub fn missing_fonts(missing: &BTreeSet<char>) -> Option<String> {
    let listed: Vec<String> = missing.iter().take(MOST_LISTED).map(|c| format!("U+{:04X}", u32::from(*c))).collect();
    let more = if missing.len() > MOST_LISTED { ", …" } else { "" };
    let listed = listed.join(", ");
    (!missing.is_empty())
        .then(|| format!("No font on this computer has these characters of the participant's texts: {listed}{more}."))
}

/// Checks a result file against the definition and the seed in its sidecar. The sidecar may be missing only outside a
/// data set.
fn check_results(path: &Path) -> Result<Checked, StoreError> {
    let has_sidecar = exists(&path.with_extension("json"))? || dataset::described(path)?.is_some();
    if dataset::identity(path).is_ok() && has_sidecar {
        return check_session(path);
    }
    let content = read_bytes(path, results::MAX_FILE, "a result file")?;
    let header = content.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let columns = columns_by_header(String::from_utf8_lossy(header).trim_end().split(','));
    let rows = results::parse(&path.display().to_string(), &content, &columns)?;
    let (mut errors, mut orders) = (Vec::new(), HashMap::new());
    for (row, line) in rows.iter().zip(2..) {
        let session = (&row.subject_id, &row.session_id);
        let order = orders.entry(session).or_insert_with(|| Order::new(false, usize::MAX));
        errors.extend(order.add(row).into_iter().map(|message| FileError::at(path, (line, 1), message)));
    }
    FileErrors::none(errors)?;
    let sentence = format!(
        "result file: {} rows; the trial order was not checked because that requires a session's file and its sidecar",
        rows.len()
    );
    Ok(sentence.into())
}

fn check_session(path: &Path) -> Result<Checked, StoreError> {
    let session = Recorded::open(path)?;
    let mut errors = [session.row_errors(), &session.changed].concat();
    let interruption = session.interruption();
    if let Some((line, what)) = session.incomplete_line().filter(|_| interruption.is_none()) {
        errors.push(FileError::at(path, (line, 1), format!("{what}; expected complete rows")));
    }
    FileErrors::none(errors)?;
    let ((rated, planned), rows, name) = (session.rated(), session.rows.len(), &session.protocol.name);
    let sentence = format!("result file: {rows} rows; {rated} of {planned} planned trials of {name} rated");
    Ok(Checked { warning: interruption.map(|found| found.message), ..sentence.into() })
}
