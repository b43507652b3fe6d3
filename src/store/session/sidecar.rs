//! The sidecar of a result file: everything about a session except its rows, in an entry for each sitting.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    path::{Path, PathBuf},
};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::{
    display::{DisplayProfile, Monitor},
    experiment::{Answers, Condition, GENERATOR, OrderedLogit, Protocol, VisionRater, columns},
    light::{Bits, Dither, Transfer, Transfers},
    stimulus::{Stimulus, recipe::Recipe},
    store::{
        FileError, FileErrors, StoreError, definition,
        error::io,
        file::{parse_json, read_existing, sha256, write_json},
        image, profile,
    },
};

/// Maximum size in bytes of a sidecar. The largest has a hash for each of 100,000 conditions, 8 MB in all, for each
/// sitting.
const MAX_FILE: u64 = 64 << 20;

/// The beginning of the incident that records a repair.
pub(super) const REPAIRED: &str = "repaired: ";

/// The definition of an onset, for readers of the data.
const ONSET: &str = "Start of the frame that presents the stimulus, according to the program's monotonic clock. The graphics system does not report presentation times: the light appears later, after the latency of the compositor and the screen. The `input` entry of each sitting describes how ratings are timestamped and the maximum delay.";

/// The sidecar's content.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sidecar {
    /// Tells readers of linked data, such as Psych-DS tools, which of these keys are specific to machband.
    #[serde(rename = "@context", default = "context")]
    pub context: Value,
    /// The definition, with the keys of its file.
    pub definition: Value,
    /// [`definition::hash`] of it.
    pub definition_sha256: String,
    /// Seed of the order of the trials.
    pub seed: u64,
    /// The random number generator that produces the order from the seed.
    pub generator: String,
    /// How an onset is defined.
    pub onset: String,
    /// One entry for each time the session was started or resumed.
    pub sittings: Vec<Sitting>,
    /// Description, unit and levels of every column.
    pub columns: Map<String, Value>,
    /// What the participant answered before the first page; absent if nothing was asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub participant: Option<Answers>,
}

/// Returns the linked-data context. schema.org does not define the keys of a sidecar; without this context, readers of
/// linked data would look for them there.
fn context() -> Value {
    let own = ["definition", "definition_sha256", "seed", "generator", "onset", "sittings", "columns", "participant"];
    let mut context = Map::from_iter([("@vocab".to_owned(), "http://schema.org/".into())]);
    context.extend(own.map(|key| (key.to_owned(), Value::Null)));
    context.into()
}

/// Returns the error that a data file has no sidecar.
pub(super) fn missing(path: &Path) -> FileErrors {
    FileErrors::whole(path, "does not exist; expected the sidecar that belongs to the data file")
}

impl Sidecar {
    /// Creates the sidecar of a new session.
    pub fn new(protocol: &Protocol, seed: u64, sitting: Sitting) -> Self {
        let columns = columns(protocol)
            .into_iter()
            .map(|column| (column.name.clone(), serde_json::to_value(&column).unwrap_or_default()))
            .collect();
        Self {
            context: context(),
            definition: serde_json::to_value(protocol).unwrap_or_default(),
            definition_sha256: definition::hash(protocol),
            seed,
            generator: GENERATOR.to_owned(),
            onset: ONSET.to_owned(),
            sittings: vec![sitting],
            columns,
            participant: None,
        }
    }

    /// True if the last sitting ended with every planned trial rated.
    pub fn is_complete(&self) -> bool {
        self.sittings.last().is_some_and(|sitting| sitting.complete)
    }

    /// True if the last sitting ended and was sealed.
    pub(in crate::store) fn is_sealed(&self) -> bool {
        self.sittings.last().is_some_and(|sitting| sitting.seal.is_some())
    }

    /// Returns the definition in the sidecar at `path`, and an error if it is not the one that was used.
    ///
    /// # Errors
    /// It is not a definition.
    pub(in crate::store) fn protocol(&self, path: &Path) -> Result<(Protocol, Option<FileError>), FileErrors> {
        let protocol = definition::from_json(&path.display().to_string(), &self.definition)?;
        let (hash, expected) = (definition::hash(&protocol), &self.definition_sha256);
        let message = || format!("the definition has sha256 {hash}; expected {expected}, the hash of the one used");
        let error = (hash != *expected).then(|| FileError::whole(path, message()));
        Ok((protocol, error))
    }

    /// Returns the seals of the sittings, in their order.
    pub(super) fn seals(&self) -> impl DoubleEndedIterator<Item = &Seal> {
        self.sittings.iter().filter_map(|sitting| sitting.seal.as_ref())
    }

    /// Computes the SHA-256 of the sidecar as it was when a sitting ended, without the seal of that sitting. `sitting` is
    /// an index.
    pub fn sha256_at_end_of(&self, sitting: usize) -> String {
        let mut then = self.clone();
        then.sittings.truncate(sitting + 1);
        if let Some(last) = then.sittings.last_mut() {
            last.seal = None;
        }
        // A sidecar is plain data, so serialization cannot fail.
        sha256(&serde_json::to_vec(&then).unwrap_or_default())
    }

    /// Seals a sitting, given by its index, with these hashes of the files and the hash of the sidecar.
    pub(super) fn seal(&mut self, sitting: usize, files: Seal) {
        let sidecar_sha256 = self.sha256_at_end_of(sitting);
        if let Some(sitting) = self.sittings.get_mut(sitting) {
            sitting.seal = Some(Seal { sidecar_sha256, ..files });
        }
    }

    /// Seals the sittings that ended, from this index on, with the files as they are now, because the user accepted a
    /// change.
    pub(super) fn reseal(&mut self, from: usize, files: &Seal) {
        for sitting in from..self.sittings.len() {
            if self.sittings[sitting].ended_at.is_some() || self.sittings[sitting].seal.is_some() {
                self.seal(sitting, files.clone());
            }
        }
    }

    /// True if damaged lines were moved from the data file.
    pub(in crate::store) fn is_repaired(&self) -> bool {
        self.incidents(REPAIRED).next().is_some()
    }

    /// Returns the incidents of all sittings that begin like this.
    pub fn incidents(&self, beginning: &str) -> impl Iterator<Item = &String> {
        let all = self.sittings.iter().flat_map(|sitting| &sitting.incidents);
        all.filter(move |incident| incident.starts_with(beginning))
    }

    /// Reads a sidecar; `None` if the file does not exist.
    ///
    /// # Errors
    /// The file is not readable, or it is not a sidecar, with the line and column.
    pub fn read(path: &Path) -> Result<Option<Self>, StoreError> {
        Self::text(path)?.map(|text| Self::parse(path, &text)).transpose()
    }

    /// Reads the text of a sidecar; `None` if the file does not exist.
    ///
    /// # Errors
    /// The file is not readable.
    pub(super) fn text(path: &Path) -> Result<Option<Vec<u8>>, StoreError> {
        read_existing(path, MAX_FILE)
    }

    /// Parses the text of the sidecar at `path`.
    ///
    /// # Errors
    /// It is not a sidecar, with the line and column.
    pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Self, StoreError> {
        let read: Self = parse_json(path, text, "a sidecar of a session")?;
        if read.sittings.is_empty() {
            return Err(FileErrors::whole(path, "lists no sitting; expected at least one").into());
        }
        Ok(read)
    }

    /// Reads the sidecar of a data file; also returns its path, and the definition in it.
    ///
    /// # Errors
    /// There is no sidecar, or it cannot be read.
    pub(super) fn of(csv: &Path) -> Result<(PathBuf, Self, Protocol), StoreError> {
        let path = csv.with_extension("json");
        let sidecar = Self::read(&path)?.ok_or_else(|| missing(&path))?;
        let (protocol, _) = sidecar.protocol(&path)?;
        Ok((path, sidecar, protocol))
    }

    /// Writes the sidecar atomically.
    ///
    /// # Errors
    /// I/O errors.
    pub fn write(&self, path: &Path) -> Result<(), StoreError> {
        let value = serde_json::to_value(self).map_err(|error| io(path, "encode")(std::io::Error::other(error)))?;
        write_json(path, &value)
    }
}

/// Side length of the pictures in a session without a screen, in pixels.
const SIZE_WITHOUT_SCREEN: u32 = 256;

/// One sitting of a session: from a start or resumption to the next end or interruption.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sitting {
    /// RFC 3339, UTC.
    pub started_at: String,
    /// RFC 3339, UTC; absent after a crash.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended_at: Option<String>,
    /// True if every planned trial was rated when it ended.
    pub complete: bool,
    /// The program that ran it.
    pub program: Program,
    /// The simulated observer; absent for a person.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observer: Option<SimulatedObserver>,
    /// The display profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub display: Option<UsedDisplay>,
    /// The monitor, as described by the system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub monitor: Option<Monitor>,
    /// Distance, screen size, size of the stimulus.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viewing: Option<Geometry>,
    /// The findings of the preflight, each in a plain sentence.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub preflight: Vec<PreflightNote>,
    /// Frame intervals over the sitting.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<FrameSummary>,
    /// How ratings are timestamped, and the maximum time that a key press may have waited for its timestamp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input: Option<InputSummary>,
    /// What was shown, so that anyone can re-render it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pictures: Option<Pictures>,
    /// Repairs, moves and other incidents.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub incidents: Vec<String>,
    /// The session that ended before this sitting in the same folder; absent if there was none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub previous: Option<Previous>,
    /// Proves what was recorded until this sitting ended; absent after a crash. The seal of the last sitting covers the
    /// whole files, and the seals of earlier sittings cover their beginnings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seal: Option<Seal>,
}

/// The program that ran a sitting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// `machband`.
    pub name: String,
    /// Version of the package.
    pub version: String,
    /// The commit from which it was built, or `unknown`.
    pub commit: String,
    /// The operating system for which it was built, such as `linux`.
    pub system: String,
}

impl Default for Program {
    fn default() -> Self {
        Self {
            name: env!("CARGO_PKG_NAME").to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: env!("MACHBAND_COMMIT").to_owned(),
            system: std::env::consts::OS.to_owned(),
        }
    }
}

/// A program that rated in place of a person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "observer", rename_all = "kebab-case")]
pub enum SimulatedObserver {
    /// An ordered logit model.
    Paper {
        /// Its parameters.
        ordered_logit: OrderedLogit,
    },
    /// The model of vision.
    Vision {
        /// Its parameters.
        vision: VisionRater,
    },
    /// Every key is equally likely.
    Random,
    /// Another program.
    Program {
        /// Its name.
        name: String,
    },
}

impl SimulatedObserver {
    /// Returns the name of the observer.
    pub fn name(&self) -> &str {
        match self {
            Self::Paper { .. } => "paper",
            Self::Vision { .. } => "vision",
            Self::Random => "random",
            Self::Program { name } => name,
        }
    }
}

/// The display profile of a sitting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UsedDisplay {
    /// [`profile::hash`] of the profile.
    pub sha256: String,
    /// The whole profile, with the keys of its file.
    pub profile: Value,
}

impl From<&DisplayProfile> for UsedDisplay {
    fn from(display: &DisplayProfile) -> Self {
        Self { sha256: profile::hash(display), profile: profile::value(display) }
    }
}

/// The viewing geometry of a sitting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// Viewing distance, cm.
    pub distance_cm: f64,
    /// Width of the visible screen, cm.
    pub screen_width_cm: f64,
    /// False if the width of the screen is an assumption.
    pub screen_width_measured: bool,
    /// Pixels per degree of visual angle at the center of the screen.
    pub pixels_per_degree: f64,
    /// Side length of the stimulus, pixels.
    pub stimulus_px: u32,
    /// Side length of the stimulus, degrees of visual angle.
    pub stimulus_deg: f64,
    /// Width and height of the window, pixels.
    pub window_px: [u32; 2],
    /// True if the session ran in a window instead of the full screen.
    pub windowed: bool,
}

/// One finding of the preflight before a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PreflightNote {
    /// What was checked.
    pub check: String,
    /// True if the check passed.
    pub ok: bool,
    /// The finding as a sentence.
    pub sentence: String,
}

/// The frame intervals of a sitting, in seconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameSummary {
    /// Number of intervals.
    pub intervals: usize,
    /// Half of the intervals do not exceed it.
    pub median_s: f64,
    /// 1 % of the intervals do not exceed it.
    pub p01_s: f64,
    /// 99 % of the intervals do not exceed it.
    pub p99_s: f64,
    /// The refresh interval of the screen, if known.
    pub refresh_s: Option<f64>,
    /// Its source: `reported` by the system, `measured`, or `unknown`.
    pub refresh_source: String,
    /// Number of dropped frames; `None` if the refresh was never known.
    pub dropped: Option<u64>,
    /// Number of refreshes without a new frame; `None` if the refresh was never known.
    pub missed_refreshes: Option<u64>,
    /// Number of onsets that came later than planned; `None` if the refresh was never known.
    pub late_onsets: Option<u32>,
    /// Name of the file with every interval, if there is one.
    pub file: Option<String>,
}

/// How the ratings of a sitting were timestamped.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InputSummary {
    /// What a timestamp means, in sentences.
    pub stamp: String,
    /// Number of ratings that were timestamped when the window system delivered them.
    pub stamped: usize,
    /// Number of the other ratings.
    pub unstamped: u32,
    /// Median of the maximum time that a rating may have waited for its timestamp, in seconds.
    pub median_uncertainty_s: Option<f64>,
    /// Maximum of it, in seconds.
    pub max_uncertainty_s: Option<f64>,
}

/// Hashes of a session's files when a sitting ended. They reveal accidents and honest manual changes, but do not
/// protect against fraud: anyone can create new hashes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seal {
    /// Number of bytes of the data file.
    pub data_bytes: u64,
    /// Number of rows in them.
    pub data_rows: usize,
    /// SHA-256 of these bytes.
    pub data_sha256: String,
    /// Number of bytes of the frames file, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames_bytes: Option<u64>,
    /// SHA-256 of the frames file, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames_sha256: Option<String>,
    /// [`Sidecar::sha256_at_end_of`] the sitting.
    pub sidecar_sha256: String,
}

/// The session that ended before a sitting in the same folder. If it is deleted, this entry reveals that it existed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Previous {
    /// Name of its data file.
    pub data_file: String,
    /// [`Seal::data_sha256`] of its last seal. That seal stays in its sidecar when it is resumed or repaired.
    pub data_sha256: String,
}

/// The pictures of a sitting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pictures {
    /// How light was converted to codes. The stimulus in it is the definition's, before any factor is set.
    pub recipe: Recipe,
    /// [`image::hash`] of each condition's picture, by condition number. Conditions are numbered from 1 by crossing the
    /// factors, with the last factor varying fastest.
    pub sha256: BTreeMap<usize, String>,
    /// The other pictures: what a task compares with a condition, and the levels that an adaptive method chose.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<OtherPicture>,
}

/// A picture that is not a condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherPicture {
    /// What it shows.
    pub stimulus: Stimulus,
    /// [`image::hash`] of the picture.
    pub sha256: String,
}

impl Pictures {
    /// Creates the pictures for a screen: `size` pixels per side, 8 bits, no dither. None of them is hashed yet.
    pub fn new(protocol: &Protocol, size: u32, transfers: &Transfers, display_sha256: Option<String>) -> Self {
        let recipe = Recipe {
            stimulus: protocol.stimulus.clone(),
            size,
            transfers: transfers.clone(),
            bits: Bits::Eight,
            dither: Dither::None,
            seed: 0,
            display_sha256,
            finish: None,
        };
        Self { recipe, sha256: BTreeMap::new(), others: Vec::new() }
    }

    /// Creates the pictures of a session without a screen: 256 pixels per side, sRGB. None of them is hashed yet.
    pub fn without_screen(protocol: &Protocol) -> Self {
        let size = protocol.stimulus.side().unwrap_or(SIZE_WITHOUT_SCREEN);
        Self::new(protocol, size, &Transfer::Srgb.into(), None)
    }

    /// Renders pictures and returns their hashes, in order.
    pub fn hashes(&self, stimuli: &[&Stimulus]) -> Vec<String> {
        let quantizer = self.recipe.quantizer();
        stimuli.par_iter().map(|stimulus| image::hash(&self.recipe_of(stimulus).codes(&quantizer))).collect()
    }

    /// Returns the recipe of a picture.
    pub fn recipe_of(&self, stimulus: &Stimulus) -> Recipe {
        Recipe { stimulus: stimulus.clone(), ..self.recipe.clone() }
    }

    /// Notes the hashes of pictures, each by the number of its condition if it is one.
    pub fn note<'a>(&mut self, conditions: &[Condition], hashed: impl IntoIterator<Item = (&'a Stimulus, String)>) {
        let numbers: HashMap<String, usize> =
            conditions.iter().zip(1..).map(|(condition, number)| (condition.stimulus.key(), number)).collect();
        let mut known: HashSet<String> = self.others.iter().map(|other| other.stimulus.key()).collect();
        for (stimulus, sha256) in hashed {
            let key = stimulus.key();
            if let Some(number) = numbers.get(&key) {
                self.sha256.insert(*number, sha256);
            } else if known.insert(key) {
                self.others.push(OtherPicture { stimulus: stimulus.clone(), sha256 });
            }
        }
    }

    /// Returns the hash of each picture by [`Stimulus::key`].
    pub fn by_key(&self, conditions: &[Condition]) -> HashMap<String, &str> {
        let numbered = self.sha256.iter().filter_map(|(number, sha256)| {
            Some((conditions.get(number.checked_sub(1)?)?.stimulus.key(), sha256.as_str()))
        });
        let others = self.others.iter().map(|other| (other.stimulus.key(), other.sha256.as_str()));
        numbered.chain(others).collect()
    }
}
