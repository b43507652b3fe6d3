//! Proves recorded sessions: what the rows say follows from definition and seed, the pictures are rendered again and
//! hashed, and nothing was changed since the session ended.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    fs,
    path::Path,
};

use rayon::prelude::*;

use super::{
    dataset::{DATA_FILE, SIDECAR_SUFFIX},
    frames,
    recorded::Recorded,
};
use crate::{
    experiment::Condition,
    stimulus::recipe::Recipe,
    store::{
        FileFault, FileFaults, StoreError, definition,
        file::{TEMPORARY, sha256},
        image,
    },
};

/// What was found of one session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verified {
    /// Rows in the file.
    pub rows: usize,
    /// Planned trials that are rated, and all that are planned.
    pub rated: (usize, usize),
    /// Pictures rendered again, all of them equal unless `faults` says otherwise.
    pub pictures: usize,
    /// Whether the session was ended, so that touching its files shows.
    pub sealed: bool,
    /// What is wrong.
    pub faults: Vec<FileFault>,
    /// What is worth knowing and not wrong.
    pub notes: Vec<String>,
}

/// Renders pictures, each once, however many sessions showed it.
#[derive(Debug, Default)]
pub struct Renderer {
    /// Hash by recipe.
    known: HashMap<String, String>,
}

impl Renderer {
    /// The hashes of the pictures of several recipes.
    fn hashes(&mut self, recipes: &[Recipe]) -> Vec<String> {
        let keys: Vec<String> =
            recipes.iter().map(|recipe| serde_json::to_string(recipe).unwrap_or_default()).collect();
        let mut wanted = BTreeMap::new();
        for (key, recipe) in keys.iter().zip(recipes) {
            if !self.known.contains_key(key) {
                wanted.insert(key.clone(), recipe);
            }
        }
        if let Some(first) = wanted.values().next() {
            // Those of one sitting differ in their stimulus alone: one table from light to codes serves them all.
            let quantizer = first.quantizer();
            let made: Vec<_> =
                wanted.into_par_iter().map(|(key, recipe)| (key, image::hash(&recipe.codes(&quantizer)))).collect();
            self.known.extend(made);
        }
        keys.iter().map(|key| self.known[key].clone()).collect()
    }
}

/// Proves one session by the path of its data file.
pub fn session(csv: &Path, renderer: &mut Renderer) -> Verified {
    let mut found = Verified::default();
    match Recorded::open(csv) {
        Ok(recorded) => {
            found.rows = recorded.rows.len();
            check_definition(&recorded, &mut found);
            check_rows(&recorded, &mut found);
            check_seal(&recorded, &mut found);
            check_frames(&recorded, &mut found);
            check_pictures(&recorded, renderer, &mut found);
            found.notes.extend(incidents(&recorded));
        }
        Err(StoreError::Faults(FileFaults(faults))) => found.faults = faults,
        Err(error) => found.faults.push(fault(csv, error.to_string())),
    }
    found
}

fn fault(path: &Path, message: String) -> FileFault {
    FileFault::whole(path.display().to_string(), message)
}

fn check_definition(recorded: &Recorded, found: &mut Verified) {
    let hash = definition::hash(&recorded.protocol);
    if hash != recorded.sidecar.definition_sha256 {
        let message = format!(
            "the definition has the sha256 {hash}; expected {}, that of the definition recorded with",
            recorded.sidecar.definition_sha256
        );
        found.faults.push(fault(&recorded.sidecar_path, message));
    }
}

/// Every row is one that definition and seed plan, its attempts follow each other, and its times do not run back.
fn check_rows(recorded: &Recorded, found: &mut Verified) {
    let at = |index: usize, message: String| FileFault::at(recorded.csv.display().to_string(), (index + 2, 1), message);
    let context = recorded.context();
    let mut attempts: BTreeMap<usize, u32> = BTreeMap::new();
    let mut last: Option<(u32, f64)> = None;
    let mut clock_back = 0;
    for (index, row) in recorded.rows.iter().enumerate() {
        let trial = match row.planned_trial(&context) {
            Ok(trial) => trial,
            Err(message) => {
                found.faults.push(at(index, message));
                continue;
            }
        };
        let attempt = attempts.entry(trial).or_default();
        if row.attempt != *attempt + 1 {
            let message = format!("row {} is attempt {}; expected attempt {}", row.row_id, row.attempt, *attempt + 1);
            found.faults.push(at(index, message));
        }
        *attempt = row.attempt;
        if let Some((sitting, onset_s)) = last
            && (row.sitting < sitting || row.onset_s.0 < onset_s)
        {
            let message = format!("row {} lies before the row above it; expected the order of recording", row.row_id);
            found.faults.push(at(index, message));
        }
        last = Some((row.sitting, row.onset_s.0));
        clock_back += usize::from(index > 0 && row.started_at < recorded.rows[index - 1].started_at);
    }
    found.rated = (attempts.len(), recorded.schedule.trials.len());
    let complete = found.rated.0 == found.rated.1;
    if recorded.sidecar.complete && !complete {
        let message = format!(
            "{} of {} trials are rated; expected all of them, as the sidecar says that the session is complete",
            found.rated.0, found.rated.1
        );
        found.faults.push(fault(&recorded.csv, message));
    }
    if let Some(torn) = &recorded.torn {
        let line = recorded.rows.len() + 2;
        if recorded.sidecar.complete {
            let message = format!("the file ends within a row, {torn:?}; expected whole rows of a complete session");
            found.faults.push(at(line - 2, message));
        } else {
            let note = format!("line {line} is half written: the program was interrupted there; --resume asks again");
            found.notes.push(note);
        }
    } else if !complete && !recorded.sidecar.complete {
        found.notes.push("not complete; --resume continues it".to_owned());
    }
    if clock_back > 0 {
        found.notes.push(format!("the wall clock was turned back {clock_back} times; onset_s gives the order"));
    }
}

/// Whether the files are those that the session left.
fn check_seal(recorded: &Recorded, found: &mut Verified) {
    let Some(seal) = &recorded.sidecar.seal else {
        let ended = recorded.sidecar.complete;
        let why = if ended { "not sealed: an earlier version recorded it" } else { "not sealed: not ended" };
        found.notes.push(why.to_owned());
        return;
    };
    found.sealed = true;
    let mut touched = |path: &Path, is: Option<String>, was: &str| {
        let message = match is {
            Some(is) if is == was => return,
            Some(is) => format!("was changed since the session ended: sha256 {is}; expected {was}"),
            None => "is gone; expected the file that the session left".to_owned(),
        };
        found.faults.push(fault(path, message));
    };
    let of = |path: &Path| fs::read(path).ok().map(|content| sha256(&content));
    touched(&recorded.csv, of(&recorded.csv), &seal.data_sha256);
    touched(&recorded.sidecar_path, Some(recorded.sidecar.own_sha256()), &seal.sidecar_sha256);
    if let Some(was) = &seal.frames_sha256 {
        let path = recorded.csv.with_file_name(recorded.stem() + frames::SUFFIX);
        touched(&path, of(&path), was);
    }
}

fn check_frames(recorded: &Recorded, found: &mut Verified) {
    if let Some(path) = &recorded.frames
        && let Err(FileFaults(faults)) = frames::read(path)
    {
        found.faults.extend(faults);
    }
}

/// Renders what each sitting showed.
fn check_pictures(recorded: &Recorded, renderer: &mut Renderer, found: &mut Verified) {
    let mut proved = BTreeSet::new();
    for (sitting, pictures) in (1..).zip(recorded.sidecar.sittings.iter().map(|sitting| &sitting.pictures)) {
        let Some(pictures) = pictures else { continue };
        let conditions: Vec<(usize, &Condition)> = pictures
            .sha256
            .keys()
            .filter_map(|number| Some((*number, recorded.schedule.conditions.get(number.checked_sub(1)?)?)))
            .collect();
        let recipes: Vec<Recipe> = conditions.iter().map(|(_, condition)| pictures.recipe_of(condition)).collect();
        for ((number, _), hash) in conditions.iter().zip(renderer.hashes(&recipes)) {
            let was = &pictures.sha256[number];
            found.pictures += 1;
            proved.insert(*number - 1);
            if *was != hash {
                let message = format!(
                    "condition {number} of sitting {sitting} renders to sha256 {hash}; expected {was}, that of what was shown"
                );
                found.faults.push(fault(&recorded.sidecar_path, message));
            }
        }
        if conditions.len() < pictures.sha256.len() {
            let message = format!(
                "sitting {sitting} has hashes of conditions that the definition does not have; expected 1…{}",
                recorded.schedule.conditions.len()
            );
            found.faults.push(fault(&recorded.sidecar_path, message));
        }
    }
    let shown: BTreeSet<usize> = recorded.rows.iter().filter_map(|row| recorded.condition(row)).collect();
    let unproved = shown.difference(&proved).count();
    if unproved > 0 {
        found.notes.push(format!("{unproved} of {} pictures have no hash: their sitting was not ended", shown.len()));
    }
}

/// The incidents that the sidecar records.
fn incidents(recorded: &Recorded) -> Vec<String> {
    let sittings = (1..).zip(&recorded.sidecar.sittings);
    sittings
        .flat_map(|(number, sitting)| {
            sitting.incidents.iter().map(move |incident| format!("sitting {number}: {incident}"))
        })
        .collect()
}

/// What lies in the folder of an experiment and belongs to no session: sidecars without rows, and files that a killed
/// program left half written.
#[must_use]
pub fn leftovers(dataset: &Path) -> Vec<FileFault> {
    let mut faults = Vec::new();
    for folder in [dataset.to_owned(), dataset.join("data")] {
        let mut paths: Vec<_> =
            fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
        paths.sort();
        for path in paths {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if name.ends_with(TEMPORARY) {
                faults.push(fault(&path, "was left by a program that was killed; expected no such file".to_owned()));
            } else if let Some(stem) = name.strip_suffix(SIDECAR_SUFFIX)
                && !path.with_file_name(format!("{stem}{DATA_FILE}")).exists()
            {
                faults.push(fault(&path, "has no data file beside it; expected the rows of its session".to_owned()));
            }
        }
    }
    faults
}
