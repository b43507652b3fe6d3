//! The pictures that were shown, each once: rendered again from the sidecars' recipes and compared with the hashes there.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    path::{Path, PathBuf},
    sync::Arc,
};

use rayon::prelude::*;

use super::sessions::Experiment;
use crate::{
    experiment::{Condition, Protocol, TrialRecord},
    light::Quantizer,
    stimulus::recipe::Recipe,
    store::{FileFault, FileFaults, StoreError, file::make_folder, image, recorded::Recorded},
};

/// Digits of a hash in a file's name.
const HASH_SHOWN: usize = 8;
/// Longest part of a file's name that levels fill.
const LONGEST_LABEL: usize = 150;

/// Which file shows what: its name by data file, sitting from 1 and condition from 0.
#[derive(Default)]
pub(super) struct Stimuli(HashMap<(PathBuf, u32, usize), String>);

impl Stimuli {
    /// Name of the file that a row showed, below the folder of the stimuli.
    pub(super) fn of(&self, session: &Recorded, row: &TrialRecord) -> Option<&str> {
        let condition = session.condition(row)?;
        self.0.get(&(session.csv.clone(), row.sitting, condition)).map(String::as_str)
    }
}

/// A picture to be made, and every hash that it must have.
struct Wanted {
    recipe: Recipe,
    /// One table from light to codes serves all pictures of a display.
    quantizer: Arc<Quantizer>,
    /// For the name of its file.
    label: String,
    /// Hash, sidecar that records it, and number of the condition there.
    expected: BTreeMap<String, (PathBuf, usize)>,
}

/// Writes every picture into `folder`. Returns their number too.
///
/// # Errors
/// Every picture that differs from the one that was shown; the system's refusal.
pub(super) fn write(
    experiments: &[Experiment],
    folder: &Path,
    notes: &mut Vec<String>,
) -> Result<(Stimuli, usize), StoreError> {
    let mut wanted: Vec<Wanted> = Vec::new();
    let mut by_recipe: HashMap<String, usize> = HashMap::new();
    let mut shown = Vec::new();
    for session in experiments.iter().flat_map(|experiment| &experiment.sessions) {
        let rows = session.rows.iter().filter_map(|row| Some((row.sitting, session.condition(row)?)));
        for (sitting, index) in rows.collect::<BTreeSet<_>>() {
            let condition = &session.schedule.conditions[index];
            let known = session.sidecar.sittings.get((sitting as usize).saturating_sub(1));
            let Some(pictures) = known.and_then(|sitting| sitting.pictures.as_ref()) else {
                notes.push(format!(
                    "{}: does not say how its pictures of sitting {sitting} were made; their stim_file is n/a",
                    session.sidecar_path.display()
                ));
                continue;
            };
            let recipe = pictures.recipe_of(condition);
            let place = *by_recipe.entry(image::describe(&recipe)).or_insert_with(|| {
                let label = label(&session.protocol, condition);
                let alike =
                    |other: &&Wanted| other.recipe.transfers == recipe.transfers && other.recipe.bits == recipe.bits;
                let quantizer = match wanted.iter().find(alike) {
                    Some(other) => Arc::clone(&other.quantizer),
                    None => Arc::new(recipe.quantizer()),
                };
                wanted.push(Wanted { recipe, quantizer, label, expected: BTreeMap::new() });
                wanted.len() - 1
            });
            if let Some(hash) = pictures.sha256.get(&(index + 1)) {
                let source = (session.sidecar_path.clone(), index + 1);
                wanted[place].expected.entry(hash.clone()).or_insert(source);
            }
            shown.push(((session.csv.clone(), sitting, index), place));
        }
    }
    let hashes: Vec<String> = wanted.par_iter().map(|one| image::hash(&one.recipe.codes(&one.quantizer))).collect();
    prove(&wanted, &hashes)?;
    let unproved = wanted.iter().filter(|one| one.expected.is_empty()).count();
    if unproved > 0 {
        notes.push(format!(
            "stimuli: {unproved} of {} pictures have no recorded hash, because their sitting was not ended; they follow the sidecar",
            wanted.len()
        ));
    }
    let (names, files) = names(&wanted, &hashes);
    if !files.is_empty() {
        make_folder(folder)?;
    }
    files.par_iter().try_for_each(|(name, place)| {
        let one = &wanted[*place];
        image::write_recipe(&folder.join(name), &one.recipe, &one.quantizer).map(drop)
    })?;
    let stimuli = Stimuli(shown.into_iter().map(|(key, place)| (key, names[place].clone())).collect());
    Ok((stimuli, files.len()))
}

fn prove(wanted: &[Wanted], hashes: &[String]) -> Result<(), FileFaults> {
    let mut faults = Vec::new();
    for (one, hash) in wanted.iter().zip(hashes) {
        for (expected, (sidecar, number)) in one.expected.iter().filter(|(expected, _)| *expected != hash) {
            let message =
                format!("condition {number} renders to sha256 {hash}; expected {expected}, that of what was shown");
            faults.push(FileFault::whole(sidecar.display().to_string(), message));
        }
    }
    FileFaults::none(faults)
}

/// The name of each picture's file, and which picture each file is made from: equal pictures share one.
fn names(wanted: &[Wanted], hashes: &[String]) -> (Vec<String>, BTreeMap<String, usize>) {
    let mut by_hash: HashMap<&str, String> = HashMap::new();
    let mut files = BTreeMap::new();
    let mut names = Vec::new();
    for (place, (one, hash)) in wanted.iter().zip(hashes).enumerate() {
        let name = by_hash.entry(hash).or_insert_with(|| {
            let short = format!("{}_{}.png", one.label, &hash[..HASH_SHOWN]);
            let name = if files.contains_key(&short) { format!("{}_{hash}.png", one.label) } else { short };
            files.insert(name.clone(), place);
            name
        });
        names.push(name.clone());
    }
    (names, files)
}

/// `mach-band_width-0.4_depth-1`: for people; the hash after it makes it unique.
fn label(protocol: &Protocol, condition: &Condition) -> String {
    let mut label = condition.stimulus.kind().to_owned();
    for (factor, level) in protocol.factors.iter().zip(&condition.levels) {
        let level = factor.levels.get(*level).map_or_else(String::new, ToString::to_string);
        let clean = level.chars().map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' });
        label += &format!("_{}-{}", factor.name, clean.collect::<String>());
    }
    label.truncate(LONGEST_LABEL);
    label
}
