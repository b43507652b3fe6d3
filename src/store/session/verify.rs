//! Verifies recorded sessions: their rows follow from the definition and the seed, their re-rendered pictures have the
//! recorded hashes, and nothing was changed after the session ended.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    path::Path,
};

use super::{
    recorded::{Recorded, interrupted},
    seal::{ACCEPTED, gaps},
    sitting::{OtherPicture, Pictures},
};
use crate::{experiment::GENERATOR, stimulus::Stimulus, store::FileError};

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

/// Verifies one session, given the path of its data file.
pub fn session(csv: &Path, renderer: &mut Renderer) -> Verified {
    let mut found = Verified::default();
    match Recorded::open(csv) {
        Ok(recorded) => {
            found.rows = recorded.rows.len();
            found.rated = recorded.rated();
            check_generator(&recorded, &mut found);
            found.errors.extend(recorded.row_errors().iter().cloned());
            check_end(&recorded, &mut found);
            check_seal(&recorded, &mut found);
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

fn check_generator(recorded: &Recorded, found: &mut Verified) {
    let generator = &recorded.sidecar.generator;
    if generator != GENERATOR {
        let message = format!("the generator is {generator:?}; expected {GENERATOR:?}, which orders the trials");
        found.errors.push(FileError::whole(&recorded.sidecar_path, message));
    }
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
    match recorded.incomplete_line() {
        Some((line, what)) if is_complete => {
            let message = format!("{what}; expected the complete rows of a complete session");
            found.errors.push(FileError::at(&recorded.csv, (line, 1), message));
        }
        Some((line, _)) => found.notes.push(interrupted(line)),
        None if !is_complete && rated < planned => found.notes.push("not complete; it can be resumed".to_owned()),
        None => {}
    }
}

/// Checks that the files have not changed since the session ended.
fn check_seal(recorded: &Recorded, found: &mut Verified) {
    found.sealed = recorded.sidecar.is_sealed();
    // What is sealed is not being recorded, even if another program has it open.
    if !found.sealed && (recorded.running.is_some() || recorded.changed.is_empty()) {
        let why = || "not sealed: the session did not end".to_owned();
        found.notes.push(recorded.running.clone().unwrap_or_else(why));
    }
    found.errors.extend(recorded.changed.iter().cloned());
}

fn check_pictures(recorded: &Recorded, renderer: &mut Renderer, found: &mut Verified) {
    found.errors.extend(picture_errors(recorded, renderer));
    let pictures = recorded.sidecar.sittings.iter().filter_map(|sitting| sitting.pictures.as_ref());
    let pictures: Vec<_> = pictures.collect();
    found.pictures = pictures.iter().map(|pictures| pictures.sha256.len() + pictures.others.len()).sum();
    if recorded.schedule.conditions.iter().any(|condition| !condition.stimulus.is_drawable()) {
        found.notes.push(format!(
            "{} pictures are files of their own and were not rendered again; the sidecar has the hashes of the files",
            std::mem::take(&mut found.pictures)
        ));
    }
    let shown = recorded.shown();
    let hashed: HashSet<String> =
        pictures.iter().flat_map(|of| of.by_key(&recorded.schedule.conditions).into_keys()).collect();
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
    let (path, conditions) = (&recorded.sidecar_path, &recorded.schedule.conditions);
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
        let mut all: Vec<(String, &Stimulus, &String)> = Vec::new();
        all.extend(known.iter().map(|(n, hash)| (format!("condition {n}"), &conditions[**n - 1].stimulus, *hash)));
        for (number, OtherPicture { stimulus, sha256 }) in (1..).zip(&pictures.others) {
            all.push((format!("picture {number} of the others"), stimulus, sha256));
        }
        all.retain(|(_, stimulus, _)| stimulus.is_drawable());
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
