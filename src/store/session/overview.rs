//! The sessions in a results folder and their states, for a list to choose from. Nothing is changed or locked.

use std::{
    cmp::Reverse,
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

use super::{
    dataset::{SessionPaths, identity},
    results,
    sidecar::Sidecar,
};
use crate::{
    experiment::{Identity, Protocol, columns},
    store::{FileErrors, StoreError, error::io, file::held, ratings::Listed},
    system::{found, unless_missing},
};

/// A session as a list shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionState {
    /// Path of the data file.
    pub csv: PathBuf,
    /// Name of the experiment.
    pub experiment: String,
    /// The hash of its definition.
    pub definition_sha256: String,
    pub identity: Identity,
    /// Number of rated trials.
    pub rated: usize,
    /// Number of planned trials.
    pub planned: usize,
    /// Whether the session ended with every planned trial rated. If fewer are `rated`, its file was cut since.
    pub complete: bool,
    /// When the last sitting began, RFC 3339, UTC.
    pub started_at: String,
    /// Whether a program rated.
    pub simulated: bool,
    /// What the participant answered before the first page, without their consent: `24, right`.
    pub answers: String,
    /// Whether its files can be read. If not, only the experiment and the identity are known, from the path, and the session
    /// counts as `complete`, because it cannot be resumed.
    pub is_readable: bool,
}

impl SessionState {
    /// Reads the definition and the viewing distance in cm of the last sitting, to resume the session.
    ///
    /// # Errors
    /// The sidecar cannot be read.
    pub fn to_resume(&self) -> Result<(Protocol, Option<f64>), StoreError> {
        let (path, sidecar, protocol) = Sidecar::of(&self.csv)?;
        let viewing = sidecar.sittings.last().and_then(|sitting| sitting.viewing.as_ref());
        let distance_cm = viewing.map(|viewing| viewing.distance_cm);
        if protocol.conditions().iter().any(|condition| !condition.stimulus.is_drawable()) {
            let what = "shows pictures of its own; expected to be resumed with the definition beside them";
            return Err(FileErrors::whole(path, what).into());
        }
        Ok((protocol, distance_cm))
    }

    /// Removes the files of a session in which nothing was rated. What the participant answered stays in the table of
    /// participants.
    ///
    /// # Errors
    /// There are or were rows, the session is being recorded, or a file cannot be read or removed. Then nothing is lost.
    pub fn remove(&self) -> Result<(), StoreError> {
        let (_, sidecar, protocol) = Sidecar::of(&self.csv)?;
        if held(&self.csv)?.is_some() {
            return Err(StoreError::InUse(self.csv.clone()));
        }
        if sidecar.is_complete() || !results::read(&self.csv, &columns(&protocol))?.is_empty() {
            return Err(StoreError::protected(&self.csv, "has or had ratings; expected a session without any"));
        }
        let results = self.csv.ancestors().nth(3).unwrap_or(Path::new(""));
        let paths = SessionPaths::new(results, &protocol, &self.identity);
        // The rows go last: without them, nobody would find the others.
        for path in [paths.frames, paths.sidecar, paths.csv] {
            unless_missing(fs::remove_file(&path)).map_err(io(&path, "remove"))?;
        }
        Ok(())
    }

    /// Returns whether the session cannot be read, or was finished, but some of its trials are missing now.
    pub fn is_damaged(&self) -> bool {
        !self.is_readable || self.complete && self.rated < self.planned
    }

    /// Returns whether nothing was ever rated, so that the session can be removed.
    pub fn is_empty(&self) -> bool {
        self.rated == 0 && !self.complete
    }

    /// Returns what the path tells about a session that cannot be read; `None` if it tells nothing.
    fn unreadable(csv: PathBuf) -> Option<Self> {
        let identity = identity(&csv).ok()?;
        let experiment = csv.ancestors().nth(2)?.file_name()?.to_str()?.to_owned();
        Some(Self {
            csv,
            experiment,
            definition_sha256: String::new(),
            identity,
            rated: 0,
            planned: 0,
            complete: true,
            started_at: String::new(),
            simulated: false,
            answers: String::new(),
            is_readable: false,
        })
    }

    fn read(csv: PathBuf) -> Result<Self, StoreError> {
        let identity = identity(&csv)?;
        let (_, sidecar, protocol) = Sidecar::of(&csv)?;
        let planned = protocol.main_trials() + protocol.design.practice as usize;
        // A complete session was rated to the end, so its rows need not be read unless the file has another size since.
        let complete = sidecar.is_complete();
        let size = found(&csv).map_err(io(&csv, "read"))?.map_or(0, |metadata| metadata.len());
        let is_whole = sidecar.seals().next_back().is_some_and(|seal| size == seal.data_bytes);
        let rated = if complete && is_whole {
            planned
        } else {
            let rows = results::read(&csv, &columns(&protocol))?;
            rows.iter().map(|row| (row.phase, row.trial)).collect::<HashSet<_>>().len()
        };
        let started_at = sidecar.sittings.last().map(|sitting| sitting.started_at.clone()).unwrap_or_default();
        let simulated = sidecar.sittings.iter().any(|sitting| sitting.observer.is_some());
        let answers = sidecar.participant.unwrap_or_default();
        let answers = answers.iter().filter(|(field, _)| *field != "consent");
        let answer = |(_, answer): (&String, &serde_json::Value)| {
            answer.as_str().map_or_else(|| answer.to_string(), ToOwned::to_owned)
        };
        let answers = answers.map(answer).collect::<Vec<_>>().join(", ");
        Ok(Self {
            csv,
            experiment: protocol.name.clone(),
            definition_sha256: sidecar.definition_sha256,
            identity,
            rated,
            planned,
            complete,
            started_at,
            simulated,
            answers,
            is_readable: true,
        })
    }
}

/// The sessions in a results folder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overview {
    /// Unfinished sessions first, then the latest first.
    pub sessions: Vec<SessionState>,
    /// The errors of sessions and folders that cannot be read, and folders that were not examined.
    pub errors: Vec<String>,
}

impl Overview {
    /// Reads the states of all sessions in a results folder. A folder that does not exist has no sessions.
    pub fn of(results: &Path) -> Self {
        let mut overview = Self::default();
        if matches!(found(results), Ok(None)) {
            return overview;
        }
        let listed = Listed::sessions(results);
        overview.errors.extend(listed.errors.iter().chain(&listed.warnings).map(ToString::to_string));
        // A session is resumed in the results folder, so not in a folder further down.
        let is_own = |csv: &PathBuf| {
            csv.ancestors().nth(3) == Some(results) && csv.parent().is_some_and(|data| data.ends_with("data"))
        };
        for csv in listed.files.into_iter().filter(is_own) {
            let read = SessionState::read(csv.clone());
            overview.errors.extend(read.as_ref().err().map(ToString::to_string));
            overview.sessions.extend(read.ok().or_else(|| SessionState::unreadable(csv)));
        }
        overview.sessions.sort_by_cached_key(|session| (session.complete, Reverse(session.started_at.clone())));
        overview
    }
}
