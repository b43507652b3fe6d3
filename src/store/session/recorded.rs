//! Reads and verifies recorded sessions. Nothing is changed or locked.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap, HashSet},
    path::{Path, PathBuf},
};

use super::{
    dataset::{FRAMES_SUFFIX, beside, identity},
    results,
    seal::{self, ACCEPTED, Compared, gaps},
    sidecar::{Pictures, Sidecar, missing},
};
use crate::{
    experiment::{Course, GENERATOR, Identity, Phase, Protocol, Replay, Replayed, TrialRecord, columns},
    stimulus::Stimulus,
    store::{
        FileError, FileErrors, StoreError,
        file::{exists, held},
    },
};

/// A session with all its data and metadata, as it was at one moment.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Path of the data file.
    pub csv: PathBuf,
    /// Path of the sidecar.
    pub sidecar_path: PathBuf,
    /// Path of the frames file, if there is one.
    pub frames: Option<PathBuf>,
    /// The SHA-256 of the frames file, if it was compared with the seals.
    pub(in crate::store) frames_sha256: Option<String>,
    /// The bytes of the data file.
    pub(in crate::store) data: Vec<u8>,
    /// The bytes of the sidecar.
    pub(in crate::store) sidecar_text: Vec<u8>,
    /// Says that another program is recording the session, if one is.
    pub(in crate::store) running: Option<String>,
    /// Participant and session, from the file names.
    pub identity: Identity,
    /// The definition, from the sidecar.
    pub protocol: Protocol,
    /// The session after the rows, from the definition and the seed.
    pub course: Course,
    pub sidecar: Sidecar,
    /// The rows, in the order of the file.
    pub rows: Vec<TrialRecord>,
    /// What each row records, as it was recomputed; `None` if the row is not planned.
    pub replayed: Vec<Option<Replayed>>,
    /// An error for each row that no session could have recorded in its place: the definition and the seed do not plan it, or
    /// the rows before it are not those that a session records first.
    pub row_errors: Vec<FileError>,
    /// An incomplete last line, if the session was interrupted and not resumed.
    pub partial_line: Option<String>,
    /// The files that differ from what the session wrote, according to its seals and the hash of its definition.
    pub changed: Vec<FileError>,
    /// The index of the first sitting whose seal differs.
    pub(super) first_changed: Option<usize>,
}

/// How often a session is read if its sidecar changes in the meantime, which happens at the beginning and end of a sitting.
const ATTEMPTS: usize = 5;

impl Recorded {
    /// Reads a session, given the path of its data file. Each file is read once.
    ///
    /// # Errors
    /// The file is not named like a data file; there is no sidecar; a file cannot be read; or a file cannot be parsed,
    /// with the location of every error. [`StoreError::InUse`] if another program is just creating the session.
    pub fn open(csv: &Path) -> Result<Self, StoreError> {
        identity(csv)?;
        let sidecar_path = csv.with_extension("json");
        let mut before = Sidecar::text(&sidecar_path)?;
        for _ in 0..ATTEMPTS {
            let running = held(csv)?;
            let parsed = |text: &Vec<u8>| Ok((Sidecar::parse(&sidecar_path, text)?, text.clone()));
            let sidecar = before.as_ref().map_or_else(|| Err(missing(&sidecar_path).into()), parsed);
            let read = sidecar.and_then(|sidecar| Self::of(csv, sidecar, running.clone()));
            // A sitting that begins or ends in the meantime writes the sidecar again.
            let after = Sidecar::text(&sidecar_path)?;
            if before == after {
                // A session that is just being created has no sidecar yet.
                return match read {
                    Err(_) if running.is_some() || held(csv)?.is_some() => Err(StoreError::InUse(csv.to_owned())),
                    read => read,
                };
            }
            before = after;
        }
        let what = "was changed again and again while it was read; expected a session that is not being recorded";
        Err(FileErrors::whole(&sidecar_path, what).into())
    }

    /// Reads a session with this sidecar and its text.
    ///
    /// # Errors
    /// The same errors as [`Recorded::open`]; those in the rows have a place.
    pub(super) fn of(
        csv: &Path,
        (sidecar, sidecar_text): (Sidecar, Vec<u8>),
        running: Option<String>,
    ) -> Result<Self, StoreError> {
        let (identity, sidecar_path) = (identity(csv)?, csv.with_extension("json"));
        let (protocol, definition_error) = sidecar.protocol(&sidecar_path)?;
        let course = Course::new(&protocol, &identity, sidecar.seed)
            .map_err(|error| FileErrors::whole(&sidecar_path, error.to_string()))?;
        let (data, columns) = (results::content(csv)?, columns(&protocol));
        let (whole, partial_line) = results::whole(csv, data.clone(), &columns)?;
        let Compared { differences, first, frames_sha256 } = seal::compare(csv, &sidecar, &data)?;
        let changed: Vec<FileError> = differences.into_iter().chain(definition_error).collect();
        let frames_path = beside(csv, FRAMES_SUFFIX);
        // Rows that cannot be read say nothing about whether the file is the one that was sealed.
        let rows = results::parse(&csv.display().to_string(), &whole, &columns)
            .map_err(|FileErrors(errors)| FileErrors([errors, changed.clone()].concat()))?;
        let is_repaired = sidecar.is_repaired();
        let mut replay = Replay::new(&identity, course);
        let mut order = Order::new(is_repaired, sidecar.sittings.len());
        let (mut replayed, mut row_errors) = (Vec::new(), Vec::new());
        for (row, line) in rows.iter().zip(2..) {
            let found = replay.row(row);
            let wrong = match &found {
                Ok(planned) => {
                    let gap = planned.gap.clone().filter(|_| !is_repaired);
                    gap.into_iter().chain(order.add(row)).collect()
                }
                Err(message) => vec![message.clone()],
            };
            row_errors.extend(wrong.into_iter().map(|message| FileError::at(csv, (line, 1), message)));
            replayed.push(found.ok());
        }
        let course = replay.course;
        Ok(Self {
            changed,
            first_changed: first,
            frames_sha256,
            rows,
            replayed,
            row_errors,
            data,
            sidecar_text,
            running,
            csv: csv.to_owned(),
            sidecar_path,
            frames: exists(&frames_path)?.then_some(frames_path),
            identity,
            protocol,
            course,
            sidecar,
            partial_line,
        })
    }

    /// Returns the number of the incomplete line at the end of the data file, which may be the header.
    fn incomplete_line(&self) -> Option<usize> {
        let line = self.rows.len() + 1 + usize::from(self.data.contains(&b'\n'));
        self.partial_line.is_some().then_some(line)
    }

    /// Says that the last line is incomplete, if the session did not end.
    pub fn interruption(&self) -> Option<FileError> {
        let line = self.incomplete_line().filter(|_| !self.sidecar.is_sealed())?;
        Some(FileError::whole(&self.csv, interrupted(line)))
    }

    /// Returns the error that the last line is incomplete although the session ended.
    pub(in crate::store) fn cut_line(&self) -> Option<FileError> {
        let line = self.incomplete_line().filter(|_| self.sidecar.is_sealed())?;
        let what = match self.partial_line.as_deref() {
            Some("") | None => "the line has only zero bytes".to_owned(),
            Some(text) => format!("the line is incomplete, {text:?}"),
        };
        Some(FileError::at(&self.csv, (line, 1), format!("{what}; expected complete rows")))
    }

    /// Returns what a row's trial showed, the stimulus that the row describes first; nothing if the row is not planned.
    pub fn stimuli(&self, row: usize) -> Vec<&Stimulus> {
        let Some(Replayed { shown, .. }) = &self.replayed[row] else { return Vec::new() };
        let described = shown.described();
        let others = shown.stimuli.iter().filter(|other| *other != described);
        std::iter::once(described).chain(others).collect()
    }

    /// Returns the different stimuli that the rows show.
    pub fn shown(&self) -> Vec<&Stimulus> {
        let (mut known, mut conditions) = (HashSet::new(), HashSet::new());
        // A rating shows its condition, so most rows need not be looked at.
        let is_rating = self.protocol.task.is_default();
        let is_new =
            |row: &&Replayed| !is_rating || conditions.insert(self.course.schedule().trials[row.trial].condition);
        let all = self.replayed.iter().flatten().filter(is_new).flat_map(|row| &row.shown.stimuli);
        all.filter(|stimulus| known.insert(stimulus.key())).collect()
    }

    /// Returns the number of answered trials and the number of planned trials.
    pub fn rated(&self) -> (usize, usize) {
        let done = self.done();
        let is_left = |trial: &usize| !done.contains(trial) && !self.course.is_over(*trial);
        let left = (0..self.course.schedule().trials.len()).filter(is_left).count();
        (done.len(), done.len() + left)
    }

    /// Returns the trials that are answered.
    pub(super) fn done(&self) -> BTreeSet<usize> {
        self.replayed.iter().flatten().map(|row| row.trial).collect()
    }

    /// True if every planned trial is rated and the last row is complete.
    pub fn is_complete(&self) -> bool {
        let (rated, planned) = self.rated();
        rated == planned && self.partial_line.is_none()
    }
}

/// Says that this line, the last one of a session that did not end, is incomplete.
pub(in crate::store) fn interrupted(line: usize) -> String {
    let again = if line == 1 { "it is written" } else { "it does not count, and its trial is shown" };
    format!("line {line} is incomplete because the program was interrupted; {again} again when the session is resumed")
}

/// Times may differ by this much, because they are rounded and come from different clocks.
const TOLERANCE_S: f64 = 0.002;

/// Phase (true for main) and number of a trial.
type Place = (bool, u32);

/// The order in which a session records rows. Within a sitting, first attempts are in the planned order, practice before
/// main; a correction directly follows the rating that it corrects; and time advances equally in `onset_s` and
/// `started_at`. A repair may have removed any row.
pub(in crate::store) struct Order<'a> {
    is_repaired: bool,
    /// The number of sittings.
    sittings: usize,
    /// The last attempt of each trial.
    attempts: HashMap<Place, u32>,
    /// The last row, and the furthest trial of its sitting.
    last: Option<(&'a TrialRecord, Place)>,
}

impl<'a> Order<'a> {
    pub fn new(is_repaired: bool, sittings: usize) -> Self {
        Self { is_repaired, sittings, attempts: HashMap::new(), last: None }
    }

    /// Returns each reason why a row cannot follow the rows so far.
    pub fn errors(&self, row: &'a TrialRecord) -> Vec<String> {
        let (place, attempt, mut errors) = (place_of(row), row.attempt, Vec::new());
        let mut fault = |what: &str| errors.push(format!("row {} {what}", row.row_id));
        let (sitting, sittings) = (row.sitting, self.sittings);
        if !(1..=sittings).contains(&(sitting as usize)) {
            fault(&format!("is of sitting {sitting}; expected 1 to {sittings}, as in the sidecar"));
        }
        let expected = self.attempts.get(&place).copied().unwrap_or(0) + 1;
        if attempt != expected && !(self.is_repaired && attempt > expected) {
            fault(&format!("is attempt {attempt}; expected attempt {expected}"));
        }
        let Some((above, furthest)) = self.last else { return errors };
        let same_sitting = sitting == above.sitting;
        let since = |of: fn(&TrialRecord) -> f64| of(row) - of(above);
        let onset = since(|row| row.onset_s.0);
        if sitting < above.sitting || onset < 0.0 {
            fault("was recorded before the row above it; expected the order of recording");
        } else if attempt == 1 && onset < above.response_time_s.0 - TOLERANCE_S {
            fault("begins before the row above it was rated; expected the order of recording");
        } else if same_sitting
            && (since(|row| row.started_at.as_millisecond() as f64 / 1e3) - onset).abs() > TOLERANCE_S
        {
            fault("differs in onset_s and started_at; expected the same time since the row above");
        }
        if attempt == 1 && same_sitting && place <= furthest {
            fault("is not in the planned order; expected practice before main, and trials in ascending order");
        } else if attempt > 1
            && !self.is_repaired
            && !(same_sitting && place == place_of(above))
            // A later sitting may repeat the practice, in the planned order.
            && !(row.phase == Phase::Practice && (!same_sitting || place > furthest))
        {
            fault("corrects a rating that is not directly above it; expected a correction directly after the rating");
        }
        errors
    }

    /// Adds a row as the last one, and returns its errors.
    pub fn add(&mut self, row: &'a TrialRecord) -> Vec<String> {
        let errors = self.errors(row);
        let place = place_of(row);
        self.attempts.insert(place, row.attempt);
        let before = self.last.filter(|(above, _)| above.sitting == row.sitting);
        self.last = Some((row, before.map_or(place, |(_, furthest)| place.max(furthest))));
        errors
    }
}

fn place_of(row: &TrialRecord) -> Place {
    (row.phase == Phase::Main, row.trial)
}

/// The findings about one session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verified {
    /// Number of rows in the file.
    pub rows: usize,
    /// Number of rated trials, and number of planned trials.
    pub rated: (usize, usize),
    /// Number of re-rendered pictures. All are identical to those shown unless `errors` says otherwise.
    pub pictures: usize,
    /// True if the session was sealed when it ended, so that later changes to its files can be detected.
    pub sealed: bool,
    /// True if a change to its files was accepted when it was resumed.
    pub accepted: bool,
    /// Everything that is wrong with the session.
    pub errors: Vec<FileError>,
    /// Other information.
    pub notes: Vec<String>,
}

/// Maximum side length of a picture that is rendered again. No screen is larger.
const MAX_SIDE: u32 = 8192;
/// Maximum number of pixels rendered for one session. A hundred pictures for a 4K screen have half a billion, and a
/// session may be resumed on another screen.
const MAX_RENDERED: u64 = 2_000_000_000;
/// Number of pixels rendered at the same time, unless a single picture has more. Each pixel needs about 16 bytes.
const AT_A_TIME: u64 = 16_000_000;

/// Renders each picture once, regardless of how many sessions showed it.
#[derive(Debug, Default)]
pub struct Renderer {
    /// Hash of the picture for each recipe, as JSON.
    known: HashMap<String, String>,
}

impl Renderer {
    /// Returns the hashes of several pictures of one sitting.
    pub(crate) fn hashes(&mut self, pictures: &Pictures, stimuli: &[&Stimulus]) -> Vec<String> {
        let key = |stimulus: &&Stimulus| serde_json::to_string(&pictures.recipe_of(stimulus)).unwrap_or_default();
        let keys: Vec<String> = stimuli.iter().map(key).collect();
        let wanted = keys.iter().zip(stimuli).filter(|(key, _)| !self.known.contains_key(*key));
        let (keys_of, wanted): (Vec<&String>, Vec<&Stimulus>) = wanted.collect::<BTreeMap<_, _>>().into_iter().unzip();
        let at_a_time = (AT_A_TIME / u64::from(pictures.recipe.size).pow(2).max(1)).max(1) as usize;
        for (keys, stimuli) in keys_of.chunks(at_a_time).zip(wanted.chunks(at_a_time)) {
            self.known.extend(keys.iter().copied().cloned().zip(pictures.hashes(stimuli)));
        }
        keys.iter().map(|key| self.known[key].clone()).collect()
    }
}

/// Verifies one session, given the path of its data file: its rows follow from the definition and the seed, its re-rendered
/// pictures have the recorded hashes, and nothing was changed after the session ended.
pub fn verify(csv: &Path, renderer: &mut Renderer) -> Verified {
    let mut found = Verified::default();
    match Recorded::open(csv) {
        Ok(recorded) => {
            found.rows = recorded.rows.len();
            found.rated = recorded.rated();
            if recorded.sidecar.generator != GENERATOR {
                let message = format!(
                    "the generator is {:?}; expected {GENERATOR:?}, which orders the trials",
                    recorded.sidecar.generator
                );
                found.errors.push(FileError::whole(&recorded.sidecar_path, message));
            }
            found.errors.extend(recorded.row_errors.iter().cloned());
            check_end(&recorded, &mut found);
            found.sealed = recorded.sidecar.is_sealed();
            // What is sealed is not being recorded, even if another program has it open.
            if !found.sealed && (recorded.running.is_some() || recorded.changed.is_empty()) {
                let why = || "not sealed: the session did not end".to_owned();
                found.notes.push(recorded.running.clone().unwrap_or_else(why));
            }
            found.errors.extend(recorded.changed.iter().cloned());
            match gaps(csv, &recorded.sidecar) {
                Ok(gaps) => found.notes.extend(gaps),
                Err(error) => found.errors.extend(error.errors(csv)),
            }
            check_pictures(&recorded, renderer, &mut found);
            found.accepted = recorded.sidecar.incidents(ACCEPTED).next().is_some();
            for (number, sitting) in (1..).zip(&recorded.sidecar.sittings) {
                found.notes.extend(sitting.incidents.iter().map(|incident| format!("sitting {number}: {incident}")));
            }
        }
        Err(error) => found.errors = error.errors(csv),
    }
    found
}

/// Checks that no rows are missing at the end of the file.
fn check_end(recorded: &Recorded, found: &mut Verified) {
    let ((rated, planned), is_complete) = (found.rated, recorded.sidecar.is_complete());
    if is_complete && rated < planned {
        let message = format!(
            "{rated} of {planned} trials are answered; expected all, because the sidecar says that the session is complete"
        );
        found.errors.push(FileError::whole(&recorded.csv, message));
    }
    found.errors.extend(recorded.cut_line());
    match recorded.interruption() {
        Some(interruption) => found.notes.push(interruption.message),
        None if !is_complete && rated < planned => found.notes.push("not complete; it can be resumed".to_owned()),
        None => {}
    }
}

fn check_pictures(recorded: &Recorded, renderer: &mut Renderer, found: &mut Verified) {
    found.errors.extend(picture_errors(recorded, renderer));
    let pictures = recorded.sidecar.sittings.iter().filter_map(|sitting| sitting.pictures.as_ref());
    let pictures: Vec<_> = pictures.collect();
    found.pictures = pictures.iter().map(|pictures| pictures.sha256.len() + pictures.others.len()).sum();
    if recorded.course.schedule().conditions.iter().any(|condition| !condition.stimulus.is_drawable()) {
        found.notes.push(format!(
            "{} pictures are the study's own files and were not rendered again; the sidecar has the hashes of the files",
            std::mem::take(&mut found.pictures)
        ));
    }
    let shown = recorded.shown();
    let hashed: HashSet<String> =
        pictures.iter().flat_map(|of| of.by_key(&recorded.course.schedule().conditions).into_keys()).collect();
    let unproved = shown.iter().filter(|stimulus| !hashed.contains(&stimulus.key())).count();
    if unproved > 0 {
        found.notes.push(format!(
            "{unproved} of {} pictures have no hash because their sitting did not end properly",
            shown.len()
        ));
    }
}

/// Re-renders the pictures of each sitting, and reports those that differ from what was shown.
pub(crate) fn picture_errors(recorded: &Recorded, renderer: &mut Renderer) -> Vec<FileError> {
    let (path, conditions) = (&recorded.sidecar_path, &recorded.course.schedule().conditions);
    let mut errors = Vec::new();
    let mut rendered = 0;
    for (sitting, pictures) in (1..).zip(recorded.sidecar.sittings.iter().map(|sitting| &sitting.pictures)) {
        let Some(pictures) = pictures else { continue };
        let known: Vec<_> = pictures.sha256.iter().filter(|hash| (1..=conditions.len()).contains(hash.0)).collect();
        let side = pictures.recipe.size;
        rendered += (known.len() + pictures.others.len()) as u64 * u64::from(side).pow(2);
        if side > MAX_SIDE || rendered > MAX_RENDERED {
            let message = format!(
                "the {} pictures of sitting {sitting} have {side} × {side} pixels and were not rendered; expected at most {MAX_SIDE} per side, and {MAX_RENDERED} pixels for the session",
                known.len()
            );
            errors.push(FileError::whole(path, message));
            break;
        }
        let numbered =
            known.iter().map(|(n, sha256)| (format!("condition {n}"), &conditions[**n - 1].stimulus, *sha256));
        let others = (1..).zip(&pictures.others);
        let others = others.map(|(n, other)| (format!("picture {n} of the others"), &other.stimulus, &other.sha256));
        let all: Vec<_> = numbered.chain(others).filter(|(_, stimulus, _)| stimulus.is_drawable()).collect();
        let stimuli: Vec<&Stimulus> = all.iter().map(|(_, stimulus, _)| *stimulus).collect();
        for ((name, _, expected), hash) in all.iter().zip(renderer.hashes(pictures, &stimuli)) {
            if **expected != hash {
                let message = format!(
                    "{name} of sitting {sitting} renders to sha256 {hash}; expected {expected}, the hash of what was shown"
                );
                errors.push(FileError::whole(path, message));
            }
        }
        if known.len() < pictures.sha256.len() {
            let message = format!(
                "sitting {sitting} has hashes for conditions that the definition lacks; expected conditions 1…{}",
                conditions.len()
            );
            errors.push(FileError::whole(path, message));
        }
    }
    errors
}
