//! Identifies the type of a file and finds every error in it, not only the first.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use super::{
    FileErrors, StoreError,
    dataset::{self, DATA_FILE, FRAMES_SUFFIX},
    definition,
    file::{exists, read_text},
    image, matches, observer, profile,
    ratings::column_names,
    readings,
    recorded::Recorded,
    scene::{self, SceneFile},
    toml::Document,
};
use crate::{
    experiment::{Identity, OrderedLogit, Protocol, Schedule, VisionRater},
    shading::Composition,
    system::{fonts, found, today},
};

/// A file without errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// A description of the file.
    pub sentence: String,
    /// What does not work on this computer or on this day, or that a session did not end, if anything.
    pub warning: Option<String>,
}

impl From<String> for Checked {
    fn from(sentence: String) -> Self {
        Self { sentence, warning: None }
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
    if let Some(csv) = session_of_frames(path)? {
        let session = check_session(&csv)?;
        return Ok(Checked { sentence: format!("frames of a {}", session.sentence), ..session });
    }
    let is_named_like_data = dataset::identity(path).is_ok();
    let checked = match path.extension().and_then(|extension| extension.to_str()) {
        Some("csv") if is_named_like_data && exists(path)? => check_session(path)?,
        Some("csv") => match column_names(path)?.first().map(String::as_str) {
            Some("channel") => check_readings(path)?,
            Some("event") => format!("{} visual matches of a display", matches::open(path)?.len()).into(),
            _ => check_session(path)?,
        },
        Some("ti3" | "mat") => check_readings(path)?,
        Some("png") => image::verify(path, pixels)?.into(),
        Some("toml") => check_toml(path, &name, &read_text(path)?)?,
        _ => return Err(match found(path) {
            Ok(Some(metadata)) if metadata.is_file() => FileErrors::whole(
                path,
                "is not a known type of file; expected a definition, display profile, observer or scene (.toml), a result file (.csv), readings (.csv, .ti3, .mat), or an image (.png)",
            ),
            _ => (definition::open(path).err())
                .unwrap_or_else(|| FileErrors::whole(path, "cannot be checked; expected a .toml, .csv or .png file")),
        }
        .into()),
    };
    Ok(checked)
}

fn check_readings(path: &Path) -> Result<Checked, StoreError> {
    let readings = readings::open(path)?;
    let channels: Vec<&str> = readings.channels().iter().map(|channel| channel.name()).collect();
    Ok(format!("{} photometer readings, {}", readings.all().len(), channels.join(", ")).into())
}

/// Returns the data file of the session whose frames these are, which is checked together with them: the seal of a session
/// is also that of its frames. `None` if this is another file, or does not exist.
///
/// # Errors
/// The file cannot be accessed.
pub fn session_of_frames(path: &Path) -> Result<Option<PathBuf>, StoreError> {
    let name = path.file_name().and_then(|name| name.to_str()?.strip_suffix(FRAMES_SUFFIX));
    let csv = name.map(|stem| path.with_file_name(format!("{stem}{DATA_FILE}")));
    Ok(if csv.is_some() && exists(path)? { csv } else { None })
}

/// Identifies the kind of TOML file by a required key that the other kinds lack.
fn check_toml(path: &Path, file: &str, text: &str) -> Result<Checked, StoreError> {
    let document = Document::parse(file, text)?;
    if document.has("mesh") || document.has("lamp") {
        let SceneFile { composition: Composition { bodies, lamps, .. }, notes, .. } = scene::read(path)?;
        let sentence = format!("scene; meshes: {}, lamps: {}", bodies.len(), lamps.len());
        let warning = (!notes.is_empty()).then(|| notes.join("; "));
        return Ok(Checked { sentence, warning });
    }
    if document.has("transfer") {
        let profile = profile::parse(file, text)?;
        let sentence = format!("display profile {}", profile.sentence());
        return Ok(Checked { sentence, warning: profile.warning(today()) });
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
    Ok(Checked { sentence, warning: missing_fonts(&missing) })
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

/// Checks a result file against the definition, the seed and the seals in its sidecar.
fn check_session(path: &Path) -> Result<Checked, StoreError> {
    let session = Recorded::open(path)?;
    let cut = Vec::from_iter(session.cut_line());
    FileErrors::none([session.row_errors.clone(), session.changed.clone(), cut].concat())?;
    let ((rated, planned), rows, name) = (session.rated(), session.rows.len(), &session.protocol.name);
    let sentence = format!("result file: {rows} rows; {rated} of {planned} planned trials of {name} rated");
    Ok(Checked { warning: session.interruption().map(|found| found.message), ..sentence.into() })
}
