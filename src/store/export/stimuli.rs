//! The pictures that were shown, each once: rendered again from the sidecars' recipes and held against the hashes there.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    path::{Path, PathBuf},
};

use rayon::prelude::*;

use super::{Experiment, Exported, fault, make_folder, note_once};
use crate::{
    experiment::{Condition, Protocol, TrialRecord},
    light::Quantizer,
    stimulus::recipe::Recipe,
    store::{FileFaults, StoreError, image, pictures, recorded::Recorded},
};

/// Digits of a hash in a file's name.
const HASH_SHOWN: usize = 8;

/// Which file shows what.
pub(super) struct Stimuli {
    /// Name of the file by data file, sitting from 1 and condition from 0.
    files: HashMap<PathBuf, BTreeMap<(u32, usize), String>>,
}

impl Stimuli {
    /// Name of the file that a row showed, below the folder of the stimuli.
    pub(super) fn of(&self, session: &Recorded, row: &TrialRecord) -> Option<&str> {
        let shown = (row.sitting, session.condition(row)?);
        Some(self.files.get(&session.csv)?.get(&shown)?.as_str())
    }
}

/// A picture to be made, and every hash that it must have.
struct Wanted {
    recipe: Recipe,
    /// For the name of its file.
    label: String,
    /// Hash, sidecar that records it, and number of the condition there.
    expected: BTreeMap<String, (PathBuf, usize)>,
}

/// Writes every picture into `folder`.
///
/// # Errors
/// Pictures that are not those that were shown, all of them; the system's refusal.
pub(super) fn write(experiments: &[Experiment], folder: &Path, exported: &mut Exported) -> Result<Stimuli, StoreError> {
    let mut wanted: Vec<Wanted> = Vec::new();
    let mut by_recipe: HashMap<String, usize> = HashMap::new();
    let mut shown: Vec<(&Path, (u32, usize), usize)> = Vec::new();
    for session in experiments.iter().flat_map(|experiment| &experiment.sessions) {
        let rows = session.rows.iter().filter_map(|row| Some((row.sitting, session.condition(row)?)));
        for (sitting, index) in rows.collect::<BTreeSet<_>>() {
            let condition = &session.schedule.conditions[index];
            let known = session.sidecar.sittings.get((sitting as usize).saturating_sub(1));
            let Some(pictures) = known.and_then(|sitting| sitting.pictures.as_ref()) else {
                let file = session.sidecar_path.display();
                note_once(
                    &mut exported.notes,
                    format!(
                        "{file}: does not say how its pictures of sitting {sitting} were made; their stim_file is n/a"
                    ),
                );
                continue;
            };
            let recipe = pictures.recipe_of(condition);
            let place = *by_recipe.entry(image::describe(&recipe)).or_insert_with(|| {
                let label = label(&session.protocol, condition);
                wanted.push(Wanted { recipe, label, expected: BTreeMap::new() });
                wanted.len() - 1
            });
            if let Some(hash) = pictures.sha256.get(&(index + 1)) {
                let source = (session.sidecar_path.clone(), index + 1);
                wanted[place].expected.entry(hash.clone()).or_insert(source);
            }
            shown.push((&session.csv, (sitting, index), place));
        }
    }
    let quantizers = quantizers(&wanted);
    let hashes: Vec<String> =
        wanted.par_iter().map(|one| pictures::hash(&one.recipe.codes(quantizer(&quantizers, one)))).collect();
    prove(&wanted, &hashes)?;
    let unproved = wanted.iter().filter(|one| one.expected.is_empty()).count();
    if unproved > 0 {
        exported.notes.push(format!("stimuli: {unproved} of {} pictures have no recorded hash, since their sitting was not ended; they are as the sidecar says", wanted.len()));
    }
    let (names, files) = names(&wanted, &hashes);
    if !files.is_empty() {
        make_folder(folder)?;
    }
    files.par_iter().try_for_each(|(name, place)| {
        let one = &wanted[*place];
        image::write_recipe(&folder.join(name), &one.recipe, quantizer(&quantizers, one)).map(drop)
    })?;
    exported.pictures = files.len();
    let mut by_file: HashMap<PathBuf, BTreeMap<(u32, usize), String>> = HashMap::new();
    for (csv, key, place) in shown {
        by_file.entry(csv.to_owned()).or_default().insert(key, names[place].clone());
    }
    Ok(Stimuli { files: by_file })
}

/// One table from light to codes serves all pictures of a display.
fn quantizers(wanted: &[Wanted]) -> Vec<(&Recipe, Quantizer)> {
    let mut made: Vec<(&Recipe, Quantizer)> = Vec::new();
    for one in wanted {
        if !made.iter().any(|(recipe, _)| alike(recipe, &one.recipe)) {
            made.push((&one.recipe, one.recipe.quantizer()));
        }
    }
    made
}

fn alike(a: &Recipe, b: &Recipe) -> bool {
    a.transfers == b.transfers && a.bits == b.bits
}

fn quantizer<'a>(made: &'a [(&Recipe, Quantizer)], one: &Wanted) -> &'a Quantizer {
    // There is one for each; the first is never taken for want of it.
    let place = made.iter().position(|(recipe, _)| alike(recipe, &one.recipe)).unwrap_or_default();
    &made[place].1
}

fn prove(wanted: &[Wanted], hashes: &[String]) -> Result<(), FileFaults> {
    let mut faults = Vec::new();
    for (one, hash) in wanted.iter().zip(hashes) {
        for (expected, (sidecar, number)) in one.expected.iter().filter(|(expected, _)| *expected != hash) {
            let message =
                format!("condition {number} renders to sha256 {hash}; expected {expected}, that of what was shown");
            faults.push(fault(sidecar, None, message));
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(FileFaults(faults)) }
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
    /// Longest part of a name that levels fill.
    const LONGEST: usize = 150;
    let mut label = condition.stimulus.kind().to_owned();
    for (factor, level) in protocol.factors.iter().zip(&condition.levels) {
        let level = factor.levels.get(*level).map_or_else(String::new, ToString::to_string);
        let clean = level.chars().map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' });
        label += &format!("_{}-{}", factor.name, clean.collect::<String>());
    }
    label.truncate(LONGEST);
    label
}
