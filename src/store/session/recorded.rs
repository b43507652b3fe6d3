//! Read-only access to recorded sessions, for code that reads whole data sets. Nothing is changed or locked.

use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

use super::{
    dataset::{DATA_FILE, SIDECAR_SUFFIX, identity},
    frames, results, seal,
    sidecar::Sidecar,
};
use crate::{
    experiment::{Identity, Protocol, RowContext, Schedule, TrialRecord, columns},
    store::{FileError, FileErrors, StoreError, definition},
};

/// A session with all its data and metadata.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Path of the data file.
    pub csv: PathBuf,
    /// Path of the sidecar.
    pub sidecar_path: PathBuf,
    /// Path of the frames file, if there is one.
    pub frames: Option<PathBuf>,
    /// Participant and session, from the file names.
    pub identity: Identity,
    /// The definition, from the sidecar.
    pub protocol: Protocol,
    /// The order of the trials, from the definition and the seed.
    pub schedule: Schedule,
    pub sidecar: Sidecar,
    /// The rows, in the order of the file.
    pub rows: Vec<TrialRecord>,
    /// An incomplete last line, if the session was interrupted and not resumed.
    pub partial_line: Option<String>,
    /// The files that differ from what the session wrote, according to its seal.
    pub changed: Vec<FileError>,
}

impl Recorded {
    /// Reads a session, given the path of its data file.
    ///
    /// # Errors
    /// The file is not named like a data file; there is no sidecar; or a file cannot be parsed, with the location of
    /// every error.
    pub fn open(csv: &Path) -> Result<Self, StoreError> {
        let (stem, identity) = identity(csv).map_err(|message| FileErrors::whole(csv, message))?;
        let sidecar_path = csv.with_file_name(format!("{stem}{SIDECAR_SUFFIX}"));
        let sidecar = Sidecar::read(&sidecar_path)?.ok_or_else(|| {
            FileErrors::whole(&sidecar_path, "does not exist; expected the sidecar that belongs to the data file")
        })?;
        let protocol = definition::from_json(&sidecar_path.display().to_string(), &sidecar.definition)?;
        let schedule = Schedule::new(&protocol, &identity, sidecar.seed)
            .map_err(|error| StoreError::Mismatch { path: sidecar_path.clone(), what: error.to_string() })?;
        let read = results::read(csv, &columns(&protocol))?;
        let frames = csv.with_file_name(format!("{stem}{}", frames::SUFFIX));
        Ok(Self {
            changed: seal::errors(csv, &sidecar),
            csv: csv.to_owned(),
            sidecar_path,
            frames: frames.exists().then_some(frames),
            identity,
            protocol,
            schedule,
            sidecar,
            rows: read.rows,
            partial_line: read.partial_line,
        })
    }

    /// Returns the part that all file names of the session share.
    pub fn stem(&self) -> String {
        let name = self.csv.file_name().unwrap_or_default().to_string_lossy();
        name.strip_suffix(DATA_FILE).unwrap_or(&name).to_owned()
    }

    /// Returns the context of the rows. Its `sitting` is a placeholder, because each row has its own.
    pub fn context(&self) -> RowContext<'_> {
        RowContext { protocol: &self.protocol, schedule: &self.schedule, identity: &self.identity, sitting: 1 }
    }

    /// Returns the index in [`Schedule::conditions`] of a row's condition; `None` if the row is not planned.
    pub fn condition(&self, row: &TrialRecord) -> Option<usize> {
        Some(self.schedule.trials[row.planned_trial(&self.context()).ok()?].condition)
    }

    /// Returns the number of rated trials and the number of planned trials.
    pub fn rated(&self) -> (usize, usize) {
        let context = self.context();
        let rated: HashSet<_> = self.rows.iter().filter_map(|row| row.planned_trial(&context).ok()).collect();
        (rated.len(), self.schedule.trials.len())
    }

    /// Returns all errors in the rows. The definition and the seed must plan every row, attempts must be consecutive,
    /// and times must not decrease.
    pub fn row_errors(&self) -> Vec<FileError> {
        let context = self.context();
        let (mut attempts, mut errors) = (HashMap::new(), Vec::new());
        let mut last = (0, f64::NEG_INFINITY);
        for (row, line) in self.rows.iter().zip(2..) {
            let mut add = |message: String| errors.push(FileError::at(&self.csv, (line, 1), message));
            let trial = match row.planned_trial(&context) {
                Ok(trial) => trial,
                Err(message) => {
                    add(message);
                    continue;
                }
            };
            let expected = attempts.insert(trial, row.attempt).unwrap_or(0) + 1;
            if row.attempt != expected {
                add(format!("row {} is attempt {}; expected attempt {expected}", row.row_id, row.attempt));
            }
            if row.sitting < last.0 || row.onset_s.0 < last.1 {
                add(format!(
                    "row {} was recorded before the row above it; expected the order of recording",
                    row.row_id
                ));
            }
            last = (row.sitting, row.onset_s.0);
        }
        errors
    }
}
