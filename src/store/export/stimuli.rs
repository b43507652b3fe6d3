//! The distinct pictures that were shown, re-rendered from the recipes in the sidecars and compared with the hashes
//! there.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    path::{Path, PathBuf},
    sync::Arc,
};

use rayon::prelude::*;

use super::sessions::Experiment;
use crate::{
    experiment::{Protocol, task::Adaptive},
    stimulus::Stimulus,
    store::{
        FileErrors, StoreError,
        file::{make_folder, write_file},
        image,
        manifest::labeled,
        recorded::Recorded,
        verify::{Renderer, picture_errors},
    },
};

/// Number of digits of a hash in a file name.
const HASH_SHOWN: usize = 8;
/// Maximum length of the part of a file name that lists the levels.
const MAX_LABEL: usize = 150;

/// The picture's file name for each data file, sitting (from 1) and stimulus.
#[derive(Default)]
pub(super) struct Stimuli(HashMap<(PathBuf, u32, String), String>);

impl Stimuli {
    /// Returns the file of the picture that a row describes, relative to the stimuli folder.
    pub(super) fn of(&self, session: &Recorded, row: usize) -> Option<&str> {
        let described = session.stimuli(row).first()?.key();
        self.0.get(&(session.csv.clone(), session.rows[row].sitting, described)).map(String::as_str)
    }
}

/// Writes every picture into `folder`, and returns their file names and their number.
///
/// # Errors
/// Reports every picture that differs from the one that was shown; I/O errors.
pub(super) fn write(
    experiments: &[Experiment],
    folder: &Path,
    notes: &mut Vec<String>,
) -> Result<(Stimuli, usize), StoreError> {
    let sessions = || experiments.iter().flat_map(|experiment| &experiment.sessions);
    let mut renderer = Renderer::default();
    FileErrors::none(sessions().flat_map(|session| picture_errors(session, &mut renderer)).collect())?;
    // Identical pictures share one file.
    let (mut names, mut files) = (HashMap::<String, String>::new(), BTreeMap::new());
    let (mut shown, mut proved) = (HashMap::new(), HashSet::new());
    for session in sessions() {
        let mut sittings = BTreeMap::<u32, BTreeMap<String, &Stimulus>>::new();
        for (index, row) in session.rows.iter().enumerate() {
            // Files of the study's own are not in the data set, so they cannot be exported either.
            let drawable = session.stimuli(index).into_iter().filter(|stimulus| stimulus.is_drawable());
            let stimuli = drawable.map(|stimulus| (stimulus.key(), stimulus));
            sittings.entry(row.sitting).or_default().extend(stimuli);
        }
        for (sitting, stimuli) in sittings {
            let known = session.sidecar.sittings.get((sitting as usize).saturating_sub(1));
            let Some(pictures) = known.and_then(|sitting| sitting.pictures.as_ref()) else {
                notes.push(format!(
                    "{}: does not describe how the pictures of sitting {sitting} were rendered; their stim_file is n/a",
                    session.sidecar_path.display()
                ));
                continue;
            };
            let quantizer = Arc::new(pictures.recipe.quantizer());
            let hashed = pictures.by_key(&session.schedule.conditions);
            let hashes = renderer.hashes(pictures, &stimuli.values().copied().collect::<Vec<_>>());
            for ((key, stimulus), hash) in stimuli.into_iter().zip(hashes) {
                if hashed.contains_key(&key) {
                    proved.insert(hash.clone());
                }
                let name = names.entry(hash).or_insert_with_key(|hash| {
                    let label = label(&session.protocol, stimulus);
                    let short = format!("{label}_{}.png", &hash[..HASH_SHOWN]);
                    let name = if files.contains_key(&short) { format!("{label}_{hash}.png") } else { short };
                    files.insert(name.clone(), (pictures.recipe_of(stimulus), Arc::clone(&quantizer)));
                    name
                });
                shown.insert((session.csv.clone(), sitting, key), name.clone());
            }
        }
    }
    let unproved = files.len() - proved.len();
    if unproved > 0 {
        notes.push(format!(
            "stimuli: {unproved} of {} pictures have no recorded hash, because their sitting did not end properly; they are rendered from the sidecar",
            files.len()
        ));
    }
    if !files.is_empty() {
        make_folder(folder)?;
    }
    files.par_iter().try_for_each(|(name, (recipe, quantizer))| {
        let path = folder.join(name);
        write_file(&path, &image::recipe_png(&path, recipe, quantizer)?)
    })?;
    Ok((Stimuli(shown), files.len()))
}

/// Returns a label such as `mach-band_width-0.4_depth-1`. It is meant for people; the hash after it makes the name
/// unique.
fn label(protocol: &Protocol, stimulus: &Stimulus) -> String {
    let adapted = protocol.adaptive.iter().flat_map(Adaptive::parameters);
    let names = protocol.factors.iter().map(|factor| factor.name.as_str()).chain(adapted);
    let level = |name| (name, stimulus.get(name).map_or_else(String::new, |level| level.to_string()));
    labeled(stimulus.kind().to_owned(), names.map(level), MAX_LABEL)
}
