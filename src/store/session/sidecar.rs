//! The sidecar of a result file: everything about a session except its rows.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::sitting::{Seal, Sitting};
use crate::{
    experiment::{Answers, GENERATOR, Protocol, columns},
    store::{
        FileError, FileErrors, StoreError, definition,
        error::io,
        file::{parse_json, read_existing, sha256, write_json},
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

    /// Returns an error if the definition in the sidecar at `path`, of which this is [`definition::hash`], is not the one
    /// that was used.
    pub(in crate::store) fn definition_error(&self, path: &Path, hash: &str) -> Option<FileError> {
        let expected = &self.definition_sha256;
        let message = || format!("the definition has sha256 {hash}; expected {expected}, the hash of the one used");
        (hash != expected).then(|| FileError::whole(path, message()))
    }

    /// Returns the seals of the sittings, in their order.
    pub(super) fn seals(&self) -> impl DoubleEndedIterator<Item = &Seal> {
        self.sittings.iter().filter_map(|sitting| sitting.seal.as_ref())
    }

    /// Returns the latest seal; `None` if no sitting ended.
    pub fn last_seal(&self) -> Option<&Seal> {
        self.seals().next_back()
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

    /// Reads the sidecar of a data file; also returns its path.
    ///
    /// # Errors
    /// There is no sidecar, or it cannot be read.
    pub fn of(csv: &Path) -> Result<(PathBuf, Self), StoreError> {
        let path = csv.with_extension("json");
        let sidecar = Self::read(&path)?.ok_or_else(|| missing(&path))?;
        Ok((path, sidecar))
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
