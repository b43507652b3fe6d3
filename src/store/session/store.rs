//! A running session on disk: its rows, its sidecar, its frames and its data set.

use std::{path::Path, sync::Arc};

use super::{
    dataset::{PARTICIPANTS, SessionPaths, enter},
    recorded::Recorded,
    results,
    seal::{accepted, previous},
    sidecar::{FrameSummary, Seal, Sidecar, Sitting, missing},
};
use crate::{
    experiment::{Answers, Course, Identity, Protocol, Resumed, TrialRecord, columns},
    stimulus::Stimulus,
    store::{
        FileErrors, StoreError, definition,
        file::{AppendFile, exists, sha256},
        table,
    },
};

/// The files of a running session.
#[derive(Debug)]
pub struct SessionStore {
    protocol: Protocol,
    identity: Identity,
    paths: SessionPaths,
    rows: AppendFile,
    sidecar: Sidecar,
    /// The frames file; `None` if a different file has its name.
    frames: Option<AppendFile>,
    /// True if a failure to write frames has already been noted.
    frames_refused: bool,
}

/// What happens to a session whose files were changed after it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changes {
    /// The session is not resumed.
    Refuse,
    /// The session is resumed, and its sidecar permanently records the hashes of the changed files.
    Accept,
}

/// The state of a session that begins, or of an interrupted one.
#[derive(Debug)]
pub struct Interrupted {
    /// Its trials, and the answers so far.
    pub course: Course,
    /// The trials that are already answered.
    pub resumed: Resumed,
    /// When the last rating was given, in seconds since the session's start; 0 if there is no rating yet.
    pub elapsed_s: f64,
    pub rows: Vec<TrialRecord>,
    /// The number of the sitting that begins now.
    pub sitting: u32,
    /// The incomplete last line that was removed, if there was one.
    pub partial_line: Option<String>,
}

impl Interrupted {
    /// Creates a session that has not shown a trial yet.
    pub fn before_the_first_trial(course: Course) -> Self {
        let (resumed, rows) = (Resumed::default(), Vec::new());
        Self { course, resumed, elapsed_s: 0.0, rows, sitting: 1, partial_line: None }
    }
}

impl SessionStore {
    /// Creates the files of a new session.
    ///
    /// # Errors
    /// [`StoreError::Exists`]; there is no such order of the trials; I/O errors.
    pub fn create(
        results: &Path,
        protocol: &Protocol,
        identity: &Identity,
        seed: u64,
        sitting: Sitting,
    ) -> Result<(Self, Interrupted), StoreError> {
        let paths = SessionPaths::new(results, protocol, identity);
        let course = Course::new(protocol, identity, seed);
        let course = course.map_err(|error| FileErrors::whole(&paths.csv, error.to_string()))?;
        // A sidecar or frames file without rows also belongs to an existing session.
        for taken in [&paths.csv, &paths.sidecar, &paths.frames] {
            if exists(taken)? {
                return Err(StoreError::Exists(taken.clone()));
            }
        }
        let undescribed = paths.prepare(protocol)?;
        let mut rows = AppendFile::new(&paths.csv, true, results::header(&columns(protocol)));
        rows.flush()?;
        let mut sidecar = Sidecar::new(protocol, seed, sitting);
        sidecar.sittings[0].incidents.extend(undescribed);
        sidecar.sittings[0].incidents.extend(rows.lock_incident());
        if let Err(error) = sidecar.write(&paths.sidecar) {
            // Nothing is recorded yet, so the next attempt must not find an existing session, least of all a sidecar
            // without rows. If the sidecar cannot be removed, the session can still be resumed.
            let removed = std::fs::remove_file(&paths.sidecar);
            drop(rows);
            if removed.is_ok() || !exists(&paths.sidecar).unwrap_or(true) {
                let _ = std::fs::remove_file(&paths.csv);
            }
            return Err(error);
        }
        let frames = Some(results::new_frames(&paths.frames));
        let (protocol, identity) = (protocol.clone(), identity.clone());
        let store = Self { protocol, identity, paths, rows, sidecar, frames, frames_refused: false };
        Ok((store, Interrupted::before_the_first_trial(course)))
    }

    /// Resumes an interrupted session.
    ///
    /// # Errors
    /// [`StoreError::NothingToResume`]; a definition, a seed or a row that does not belong to this session;
    /// [`StoreError::InUse`]; rows that cannot be parsed; files that were changed after they were
    /// sealed, unless `changes` accepts that. If there is an error, nothing is changed.
    pub fn resume(
        results: &Path,
        protocol: &Protocol,
        identity: &Identity,
        seed: Option<u64>,
        sitting: Sitting,
        changes: Changes,
    ) -> Result<(Self, Interrupted), StoreError> {
        let Found { paths, rows, recorded, is_finished } = Found::read(results, protocol, identity, seed, changes)?;
        let resumed = Resumed { done: recorded.done(), ..Resumed::default() };
        let Recorded { sidecar, course, rows: recovered, partial_line, changed, first_changed, .. } = recorded;
        // Times of answers are measured from the last interval, and onsets are those of the first.
        let lead_s = protocol.task.layout().lead_s();
        let elapsed_s = recovered.last().map_or(0.0, |row| row.onset_s.0 + lead_s + row.response_time_s.0);
        let sittings = sidecar.sittings.len() as u32 + 1;
        let interrupted = Interrupted { course, resumed, elapsed_s, rows: recovered, sitting: sittings, partial_line };
        let frames = results::open_frames(&paths.frames);
        let without_frames = frames.as_ref().err().map(ToString::to_string);
        let (protocol, identity, frames) = (protocol.clone(), identity.clone(), frames.ok());
        let mut store = Self { protocol, identity, paths, rows, sidecar, frames, frames_refused: false };
        store.paths.remove_temporary(true);
        // From here on, the files are changed, unless the session is complete.
        if !is_finished {
            if let Some(first) = first_changed {
                let now = store.seal_of_files();
                store.sidecar.reseal(first, &now);
            }
            store.sidecar.sittings.push(sitting);
            store.note_lock();
            changed.iter().for_each(|difference| store.note(accepted(difference)));
            if let Some(partial_line) = &interrupted.partial_line {
                store.note(format!(
                    "an incomplete last row was removed, and its trial was shown again: {partial_line:?}"
                ));
            }
            if let Some(error) = without_frames {
                store.note(format!("the frames of this sitting are not saved: {error}"));
            }
            store.sidecar.write(&store.paths.sidecar)?;
            store.rows.flush()?;
        }
        Ok((store, interrupted))
    }

    /// Returns whether every planned trial of a session is rated, so that there is nothing to resume. The rows decide,
    /// not the sidecar.
    ///
    /// # Errors
    /// The same errors as [`SessionStore::resume`].
    pub fn is_finished(
        results: &Path,
        protocol: &Protocol,
        identity: &Identity,
        seed: Option<u64>,
        changes: Changes,
    ) -> Result<bool, StoreError> {
        Ok(Found::read(results, protocol, identity, seed, changes)?.is_finished)
    }

    /// Keeps what the participant answered before the first page: in the sidecar, and in the participants of the data
    /// set. A failure is noted, and the session continues. The sidecar is written again when the sitting ends.
    pub fn keep_participant(&mut self, answers: Answers) {
        self.sidecar.participant = Some(answers);
        self.enter_participant();
        if let Err(error) = self.sidecar.write(&self.paths.sidecar) {
            self.note(format!("the answers about the participant were not saved immediately: {error}"));
        }
    }

    fn enter_participant(&mut self) {
        let Some(answers) = &self.sidecar.participant else { return };
        let (dataset, subject) = (&self.paths.dataset, self.identity.subject());
        if let Err(error) = enter(dataset, subject, &self.protocol.participant, answers) {
            self.note(format!("the participant could not be entered into {PARTICIPANTS}: {error}"));
        }
    }

    /// Returns the path of the data file.
    pub fn csv(&self) -> &Path {
        self.rows.path()
    }

    /// Appends a row. It is on disk when this returns without an error, and it is kept in memory in any case.
    ///
    /// # Errors
    /// The write failed; see [`SessionStore::retry`] and [`SessionStore::continue_in`].
    pub fn append(&mut self, record: &TrialRecord) -> Result<(), StoreError> {
        self.rows.append(&table::line(record.cells()))
    }

    /// Returns the rows that are only in memory, in the format of the file.
    pub fn unsaved(&self) -> Vec<String> {
        self.rows.unsaved().lines().map(str::to_owned).collect()
    }

    /// Appends frames. A failure is noted only once; the next frames trigger another attempt, and the session
    /// continues.
    pub fn append_frames(&mut self, lines: &[String]) {
        let written = self.frames.as_mut().map_or(Ok(()), |frames| frames.append(lines.concat().as_bytes()));
        if let Err(error) = written
            && !std::mem::replace(&mut self.frames_refused, true)
        {
            self.note(format!("frames could not be written when they were shown: {error}"));
        }
    }

    /// Returns the name of the frames file, if it contains frames.
    pub fn frames_file(&self) -> Option<String> {
        let frames = self.frames.as_ref().filter(|frames| !frames.is_empty())?;
        Some(frames.path().file_name()?.to_string_lossy().into_owned())
    }

    /// Tries again to write everything that is not on disk yet.
    ///
    /// # Errors
    /// The same errors as [`SessionStore::append`].
    pub fn retry(&mut self) -> Result<(), StoreError> {
        self.rows.flush().or_else(|error| {
            // If the file was deleted and its location is usable again, write everything into a new file with the same
            // name.
            if exists(&self.paths.csv)? {
                return Err(error);
            }
            self.copy_rows(&self.paths.clone())?;
            self.enter_participant();
            self.sidecar.write(&self.paths.sidecar)
        })
    }

    /// Writes all rows into a new file in this data set, and continues there.
    fn copy_rows(&mut self, paths: &SessionPaths) -> Result<(), StoreError> {
        let undescribed = paths.prepare(&self.protocol)?;
        self.rows.continue_in(&paths.csv)?;
        self.note_lock();
        self.sitting().incidents.extend(undescribed);
        Ok(())
    }

    /// Copies everything recorded so far to another results folder and continues there. The old files are not changed.
    ///
    /// # Errors
    /// The new folder cannot be written or already has this session. In that case, the session stays in the old folder.
    pub fn continue_in(&mut self, results: &Path) -> Result<(), StoreError> {
        let paths = SessionPaths::new(results, &self.protocol, &self.identity);
        if paths == self.paths {
            // The same folder was chosen again; it may have free space now.
            self.retry()?;
            return self.sidecar.write(&self.paths.sidecar);
        }
        let from = self.paths.csv.display().to_string();
        self.copy_rows(&paths)?;
        if let Some(Err(error)) = self.frames.as_mut().map(|frames| frames.continue_in(&paths.frames)) {
            self.note(format!("the frames could not be moved: {error}"));
            // Seals that include the frames would report them as missing in the new folder.
            let without = Seal { frames_bytes: None, frames_sha256: None, ..self.seal_of_files() };
            self.sidecar.reseal(0, &without);
        }
        self.paths = paths;
        self.note(format!("a row could not be saved; the session was moved from {from}"));
        self.enter_participant();
        self.sidecar.write(&self.paths.sidecar)
    }

    /// Notes that a lock file protects the session, if one does.
    fn note_lock(&mut self) {
        let incident = self.rows.lock_incident();
        self.sitting().incidents.extend(incident);
    }

    /// True if the session has ended with every planned trial rated.
    pub fn is_complete(&self) -> bool {
        self.sidecar.is_complete()
    }

    /// Returns the sitting that is running; every sidecar lists one.
    pub fn sitting(&mut self) -> &mut Sitting {
        let last = self.sidecar.sittings.len() - 1;
        &mut self.sidecar.sittings[last]
    }

    /// Notes an incident, to be saved with the sidecar.
    pub fn note(&mut self, incident: String) {
        self.sitting().incidents.push(incident);
    }

    /// Notes the hashes of displayed pictures, to be saved with the sidecar.
    pub fn note_pictures<'a>(&mut self, hashed: impl IntoIterator<Item = (&'a Stimulus, String)>) {
        let conditions = Arc::clone(self.protocol.conditions());
        if let Some(pictures) = &mut self.sitting().pictures {
            pictures.note(&conditions, hashed);
        }
    }

    /// Ends the sitting, seals the session and writes the sidecar.
    ///
    /// # Errors
    /// I/O errors. Even then, the rows are safe.
    pub fn finish(&mut self, complete: bool, ended_at: String, frames: Option<FrameSummary>) -> Result<(), StoreError> {
        let previous = previous(&self.paths.csv).unwrap_or_else(|error| {
            self.note(format!("the session that ended before this one is not known: {error}"));
            None
        });
        let sitting = self.sitting();
        (sitting.ended_at, sitting.complete) = (Some(ended_at), complete);
        (sitting.frames, sitting.previous) = (frames, previous);
        // Sealed data must survive a power failure.
        if let Some(Err(error)) = self.frames.as_mut().map(AppendFile::sync) {
            self.note(format!("the frames are not complete: {error}"));
            self.frames_refused = true;
            self.frames = None;
        }
        let files = self.seal_of_files();
        self.sidecar.seal(self.sidecar.sittings.len().saturating_sub(1), files);
        self.sidecar.write(&self.paths.sidecar)
    }

    /// Returns the hashes of the files as they are now, without that of the sidecar.
    fn seal_of_files(&self) -> Seal {
        let rows = &self.rows;
        let frames = self.frames.as_ref().filter(|file| !file.is_empty() && file.path() == self.paths.frames);
        Seal {
            data_bytes: rows.content().len() as u64,
            data_rows: results::count(rows.content()),
            data_sha256: sha256(rows.content()),
            frames_bytes: frames.map(|file| file.content().len() as u64),
            frames_sha256: frames.map(|file| sha256(file.content())),
            sidecar_sha256: String::new(),
        }
    }
}

/// A session on disk that may be resumed. Its data file is locked.
struct Found {
    paths: SessionPaths,
    rows: AppendFile,
    recorded: Recorded,
    /// True if every trial is rated and the sidecar says so too, so that there is nothing to do.
    is_finished: bool,
}

impl Found {
    /// Reads and locks a session without changing anything.
    ///
    /// # Errors
    /// The same errors as [`SessionStore::resume`].
    fn read(
        results: &Path,
        protocol: &Protocol,
        identity: &Identity,
        seed: Option<u64>,
        changes: Changes,
    ) -> Result<Self, StoreError> {
        let paths = SessionPaths::new(results, protocol, identity);
        if !exists(&paths.csv)? {
            for other in [&paths.sidecar, &paths.frames] {
                if exists(other)? {
                    let message =
                        format!("is missing, but {} is there; expected the rows of this session", other.display());
                    return Err(FileErrors::whole(paths.csv, message).into());
                }
            }
            return Err(StoreError::NothingToResume(paths.csv));
        }
        paths.refuse_links()?;
        // The file is locked before anything is read, because another program may be ending this very session.
        let rows = results::open(&paths.csv, &columns(protocol))?;
        let text = Sidecar::text(&paths.sidecar)?;
        let sidecar = if let Some(text) = &text {
            let sidecar = Sidecar::parse(&paths.sidecar, text)?;
            check_same(&sidecar, protocol, seed, &paths.sidecar)?;
            FileErrors::none(sidecar.protocol(&paths.sidecar)?.1.into_iter().collect())?;
            sidecar
        } else {
            let incidents = vec!["the sidecar of the first sitting was missing on resume".to_owned()];
            Sidecar::new(protocol, seed.unwrap_or_default(), Sitting { incidents, ..Sitting::default() })
        };
        let is_lost = text.is_none();
        let recorded = Recorded::of(&paths.csv, (sidecar, text.unwrap_or_default()), None).map_err(repairable)?;
        // A session without rows has recorded nothing that could belong to another definition.
        if is_lost && !recorded.rows.is_empty() {
            return Err(missing(&paths.sidecar).into());
        }
        if changes == Changes::Refuse && !recorded.changed.is_empty() {
            return Err(StoreError::Refused(FileErrors(recorded.changed), "accept_changes"));
        }
        let (errors, replayed) = (&recorded.row_errors, &recorded.replayed);
        if let Some(first) = errors.first().filter(|_| replayed.iter().all(Option::is_none)) {
            // The rows of another session cannot be repaired.
            return Err(FileErrors::whole(&paths.csv, first.message.clone()).into());
        }
        FileErrors::none(errors.clone()).map_err(|errors| repairable(errors.into()))?;
        let is_finished = recorded.is_complete() && recorded.sidecar.is_complete() && recorded.first_changed.is_none();
        Ok(Self { paths, rows, recorded, is_finished })
    }
}

/// Names the command that makes a session with errors in its rows resumable.
fn repairable(error: StoreError) -> StoreError {
    let how = "; machband repair moves such lines to another file and notes missing rows, so that it can be resumed";
    let StoreError::FileErrors(FileErrors(mut errors)) = error else { return error };
    errors.iter_mut().filter(|error| error.position.is_some()).for_each(|error| error.message += how);
    FileErrors(errors).into()
}

/// Checks that a session was recorded with this definition and this seed.
fn check_same(
    sidecar: &Sidecar,
    protocol: &Protocol,
    expected_seed: Option<u64>,
    path: &Path,
) -> Result<(), FileErrors> {
    let (hash, &Sidecar { ref definition_sha256, seed, .. }) = (definition::hash(protocol), sidecar);
    let what = if *definition_sha256 != hash {
        format!(
            "the session was recorded with another definition (sha256 {definition_sha256}); expected that one, not {} (sha256 {hash})",
            protocol.name
        )
    } else if let Some(other) = expected_seed.filter(|other| *other != seed) {
        format!("the session has seed {seed}; expected that seed or no seed, not {other}")
    } else {
        return Ok(());
    };
    Err(FileErrors::whole(path, what))
}
