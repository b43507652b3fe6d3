//! The sidecar of a result file: everything about a session except its rows.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::{
    experiment::{Answers, Condition, GENERATOR, Protocol, columns},
    light::{Bits, Dither, Transfer, Transfers},
    stimulus::recipe::Recipe,
    store::{
        FileError, FileErrors, StoreError, definition,
        error::io,
        file::{sha256, write_json},
        image,
        open::read_regular,
    },
};

/// Maximum size in bytes of a sidecar. The largest has a hash for each of 100,000 conditions, 8 MB in all, for each
/// sitting.
const MAX_FILE: u64 = 64 << 20;

/// Side length of the pictures in a session without a screen, in pixels.
const SIZE_WITHOUT_SCREEN: u32 = 256;

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

/// Hashes of a session's files when a sitting ended. They reveal accidents and honest manual changes, but do not
/// protect against fraud: anyone can create new hashes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seal {
    /// Number of bytes of the data file.
    pub data_bytes: u64,
    /// SHA-256 of these bytes.
    pub data_sha256: String,
    /// Number of bytes of the frames file, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames_bytes: Option<u64>,
    /// SHA-256 of the frames file, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
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

/// Returns the linked-data context. schema.org does not define the keys of a sidecar; without this context, readers of
/// linked data would look for them there.
fn context() -> Value {
    let own = ["definition", "definition_sha256", "seed", "generator", "onset", "sittings", "columns", "participant"];
    let mut context = Map::from_iter([("@vocab".to_owned(), "http://schema.org/".into())]);
    context.extend(own.map(|key| (key.to_owned(), Value::Null)));
    context.into()
}

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
    /// Parameters of the simulated observer; absent for a person.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observer: Option<Value>,
    /// The display profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub display: Option<Value>,
    /// The monitor, as described by the system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub monitor: Option<Value>,
    /// Distance, screen size, size of the stimulus.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viewing: Option<Value>,
    /// The findings of the preflight, each in a plain sentence.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub preflight: Vec<PreflightNote>,
    /// Frame intervals over the sitting.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<Value>,
    /// How ratings are timestamped, and the maximum time that a key press may have waited for its timestamp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input: Option<Value>,
    /// What was shown, so that anyone can re-render it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pictures: Option<Pictures>,
    /// Repairs, moves and other incidents.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub incidents: Vec<String>,
    /// The session that ended before this sitting in the same folder; absent if there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub previous: Option<Previous>,
    /// Proves what was recorded until this sitting ended; absent after a crash. The seal of the last sitting covers the
    /// whole files, and the seals of earlier sittings cover their beginnings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
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
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.sittings.last().is_some_and(|sitting| sitting.complete)
    }

    /// Returns the latest seal; `None` if no sitting ended.
    #[must_use]
    pub fn last_seal(&self) -> Option<&Seal> {
        self.sittings.iter().rev().find_map(|sitting| sitting.seal.as_ref())
    }

    /// Computes the SHA-256 of the sidecar as it was when a sitting ended, without the seal of that sitting. `sitting` is
    /// an index.
    #[must_use]
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
    pub(super) fn is_repaired(&self) -> bool {
        self.sittings.iter().flat_map(|sitting| &sitting.incidents).any(|incident| incident.starts_with(REPAIRED))
    }

    /// Reads a sidecar; `None` if the file does not exist.
    ///
    /// # Errors
    /// The file is not readable, or it is not a sidecar, with the line and column.
    pub fn read(path: &Path) -> Result<Option<Self>, StoreError> {
        let text = match read_regular(path, MAX_FILE) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(io(path, "read")(error)),
        };
        let read: Self = serde_json::from_slice(&text).map_err(|error| {
            let message = format!("is not a sidecar of a session: {error}");
            FileErrors(vec![FileError::at(path, (error.line(), error.column()), message)])
        })?;
        if read.sittings.is_empty() {
            return Err(FileErrors::whole(path, "lists no sitting; expected at least one").into());
        }
        Ok(Some(read))
    }

    /// Reads the sidecar of a data file; also returns its path.
    ///
    /// # Errors
    /// There is no sidecar, or it cannot be read.
    pub fn of(csv: &Path) -> Result<(PathBuf, Self), StoreError> {
        let path = csv.with_extension("json");
        match Self::read(&path)? {
            Some(sidecar) => Ok((path, sidecar)),
            None => {
                let what = "does not exist; expected the sidecar that belongs to the data file";
                Err(FileErrors::whole(&path, what).into())
            }
        }
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

/// The pictures of a sitting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pictures {
    /// How light was converted to codes. The stimulus in it is the definition's, before any factor is set.
    pub recipe: Recipe,
    /// [`image::hash`] of each condition's picture, by condition number. Conditions are numbered from 1 by crossing the
    /// factors, with the last factor varying fastest.
    pub sha256: BTreeMap<usize, String>,
}

impl Pictures {
    /// Creates the pictures for a screen: `size` pixels per side, 8 bits, no dither. None of them is hashed yet.
    #[must_use]
    pub fn new(protocol: &Protocol, size: u32, transfers: &Transfers, display_sha256: Option<String>) -> Self {
        let recipe = Recipe {
            stimulus: protocol.stimulus.clone(),
            size,
            transfers: transfers.clone(),
            bits: Bits::Eight,
            dither: Dither::None,
            seed: 0,
            display_sha256,
        };
        Self { recipe, sha256: BTreeMap::new() }
    }

    /// Creates the pictures of a session without a screen: 256 pixels per side, sRGB. None of them is hashed yet.
    #[must_use]
    pub fn without_screen(protocol: &Protocol) -> Self {
        Self::new(protocol, SIZE_WITHOUT_SCREEN, &Transfer::Srgb.into(), None)
    }

    /// Renders every condition's picture and returns the hashes, in order.
    #[must_use]
    pub fn hashes(&self, conditions: &[Condition]) -> Vec<String> {
        let quantizer = self.recipe.quantizer();
        conditions.par_iter().map(|condition| image::hash(&self.recipe_of(condition).codes(&quantizer))).collect()
    }

    /// Returns the recipe of a condition's picture.
    #[must_use]
    pub fn recipe_of(&self, condition: &Condition) -> Recipe {
        Recipe { stimulus: condition.stimulus.clone(), ..self.recipe.clone() }
    }
}
