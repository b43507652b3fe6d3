//! Export of behavioral data in BIDS 1.11: a table and a sidecar for each session, the metadata of each task at the top
//! level, the pictures in `stimuli`, re-rendered from the recipes in the sidecars and compared with the hashes there, and the
//! data as recorded in `sourcedata`.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    path::{Path, PathBuf},
    sync::Arc,
};

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::sessions::{self, Experiment};
use crate::{
    experiment::{Column, IN_BIDS, Protocol, SIMULATED, STIM_FILE, columns, task::Adaptive},
    stimulus::Stimulus,
    store::{
        FileErrors, StoreError,
        dataset::{DESCRIPTION, MISSING, PARTICIPANTS, PARTICIPANTS_DESCRIBED},
        file::{make_folder, parse_json, write_file, write_json},
        image,
        manifest::labeled,
        recorded::{Recorded, Renderer, picture_errors},
        sidecar::Sitting,
    },
    system::signals,
};

/// Version of the BIDS standard.
const VERSION: &str = "1.11.1";

/// Writes the data set into `to`, and returns its number of pictures.
pub(super) fn write(experiments: &[Experiment], to: &Path, notes: &mut Vec<String>) -> Result<usize, StoreError> {
    let mut tasks = BTreeMap::new();
    for experiment in experiments {
        // A task has one description, and some file systems ignore case.
        let task = experiment.sessions[0].protocol.file_task();
        if let Some(other) = tasks.insert(task.to_ascii_lowercase(), &experiment.name) {
            let message = format!(
                "the experiments {other} and {} have the same task name in BIDS, {task}; expected names that differ in more than hyphens and case",
                experiment.name
            );
            return Err(FileErrors::whole(&experiment.sessions[0].csv, message).into());
        }
    }
    let (stimuli, pictures) = write_stimuli(experiments, &to.join("stimuli"), notes)?;
    write_json(&to.join(DESCRIPTION), &description(experiments)?)?;
    write_file(&to.join("README.md"), readme(experiments).as_bytes())?;
    let (participants, described) = sessions::participants(experiments, notes)?;
    write_file(&to.join(PARTICIPANTS), participants.text().as_bytes())?;
    write_json(&to.join(PARTICIPANTS_DESCRIBED), &described)?;
    for experiment in experiments {
        sessions::copy(experiment, &to.join("sourcedata").join(&experiment.name), notes)?;
        let protocol = &experiment.sessions[0].protocol;
        // Sessions with one definition have the same columns with the same meaning.
        let common = experiment.sessions.iter().all(|session| session.protocol == *protocol);
        if common {
            write_json(&to.join(format!("task-{}_beh.json", protocol.file_task())), &of_task(protocol).into())?;
        }
        for session in &experiment.sessions {
            write_session(session, &stimuli, common, to)?;
        }
    }
    Ok(pictures)
}

fn write_session(session: &Recorded, stimuli: &Stimuli, common: bool, to: &Path) -> Result<(), StoreError> {
    let (subject, id) = (session.identity.subject(), session.identity.session());
    let folder = to.join(format!("sub-{subject}")).join(format!("ses-{id}")).join("beh");
    make_folder(&folder)?;
    let stem = format!("sub-{subject}_ses-{id}_task-{}_beh", session.protocol.file_task());
    write_file(&folder.join(format!("{stem}.tsv")), table(session, stimuli).as_bytes())?;
    let mut sidecar = of_session(session);
    if !common {
        // If sessions of the same experiment have different definitions, each session's sidecar has its own metadata.
        sidecar.append(&mut of_task(&session.protocol));
    }
    write_json(&folder.join(format!("{stem}.json")), &sidecar.into())
}

/// Returns the columns of a result file with their names in BIDS, and those that only BIDS has. Onset and duration keep our
/// names: with the BIDS names, a behavioral table would be mistaken for a table of events.
fn described_columns(protocol: &Protocol) -> Vec<Column> {
    let own = columns(protocol).into_iter().map(|column| {
        let theirs = IN_BIDS.iter().find(|(ours, _)| *ours == column.name).map(|(_, theirs)| (*theirs).to_owned());
        Column { name: theirs.unwrap_or(column.name), ..column }
    });
    let further = [
        (SIMULATED, "Whether a program answered instead of a person: 1 or 0."),
        (STIM_FILE, "File of the picture that was shown, in stimuli/."),
    ];
    own.chain(further.map(|(name, description)| Column {
        name: name.to_owned(),
        description: description.to_owned(),
        ..Column::default()
    }))
    .collect()
}

fn table(session: &Recorded, stimuli: &Stimuli) -> String {
    let names: Vec<String> = described_columns(&session.protocol).into_iter().map(|column| column.name).collect();
    let mut text = names.join("\t") + "\n";
    for (index, row) in session.rows.iter().enumerate() {
        let sitting = session.sidecar.sittings.get((row.sitting as usize).wrapping_sub(1));
        let is_simulated = sitting.is_some_and(|sitting| sitting.observer.is_some());
        let mut cells = row.cells();
        cells.push(u8::from(is_simulated).to_string());
        cells.push(stimuli.of(session, index).unwrap_or_default().to_owned());
        let cells = names.iter().zip(&cells).map(|(name, cell)| clean(name, cell));
        text += &(cells.collect::<Vec<_>>().join("\t") + "\n");
    }
    text
}

/// Makes a cell valid for the table: never empty, and without separators.
fn clean(name: &str, cell: &str) -> String {
    match name {
        _ if cell.is_empty() => MISSING.to_owned(),
        "participant_id" => format!("sub-{cell}"),
        "session_id" => format!("ses-{cell}"),
        _ => cell.replace(['\t', '\n', '\r'], " "),
    }
}

/// Returns the metadata that all sessions of a task share: the instructions and the meaning of the columns.
fn of_task(protocol: &Protocol) -> Map<String, Value> {
    let mut entries = keys([
        ("TaskName", Some(protocol.file_task().into())),
        ("TaskDescription", Some(protocol.title.as_str().into())),
        ("Instructions", Some(instructions(protocol).into())),
    ]);
    entries.extend(described_columns(protocol).into_iter().map(|column| (column.name.clone(), described(&column))));
    entries
}

/// Keeps only the keys that have a value.
fn keys<const N: usize>(entries: [(&str, Option<Value>); N]) -> Map<String, Value> {
    entries.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?))).collect()
}

/// Returns the page that a participant reads first, followed by the response scale.
fn instructions(protocol: &Protocol) -> String {
    let texts = &protocol.instructions;
    let scale: Vec<String> =
        protocol.response.categories.iter().map(|category| format!("{}: {}", category.key, category.label)).collect();
    [&texts.task, &texts.light, &texts.keys, &protocol.response.question, &scale.join("; ")]
        .map(String::as_str)
        .join("\n\n")
}

fn described(column: &Column) -> Value {
    let unit = column.unit.as_str();
    keys([
        ("Description", Some(column.description.as_str().into())),
        ("Units", (!unit.is_empty()).then(|| unit.into())),
        ("Levels", (!column.levels.is_empty()).then(|| column.levels.clone().into())),
    ])
    .into()
}

/// Returns the metadata of one session. BIDS allows additional keys.
fn of_session(session: &Recorded) -> Map<String, Value> {
    let sittings = &session.sidecar.sittings;
    let presented: Vec<Map<String, Value>> = sittings.iter().map(presentation).collect();
    // Where sittings differ, the session as a whole has no single value.
    let mut common = presented.first().cloned().unwrap_or_default();
    common.retain(|key, value| presented.iter().all(|other| other.get(key) == Some(value)));
    let each = sittings.iter().zip(presented).map(|(sitting, presented)| {
        let entries = keys([
            ("StartedAt", Some(sitting.started_at.as_str().into())),
            ("EndedAt", sitting.ended_at.as_deref().map(Value::from)),
            ("SimulatedObserver", sitting.observer.as_ref().map(|observer| json!(observer))),
            ("ResponseStamp", sitting.input.as_ref().map(|input| json!(input))),
            ("StimulusPresentation", Some(presented.into())),
            ("Incidents", (!sitting.incidents.is_empty()).then(|| sitting.incidents.clone().into())),
        ]);
        Value::from(entries)
    });
    let (rated, planned) = session.rated();
    let changed = session.changed.iter().map(|error| {
        let name = Path::new(&error.file).file_name().unwrap_or_default().to_string_lossy();
        format!("{name}: {}", error.message)
    });
    let changed: Vec<String> = changed.collect();
    keys([
        ("ChangedFiles", (!changed.is_empty()).then(|| changed.into())),
        ("StimulusPresentation", Some(common.into())),
        ("TrialsPlanned", Some(planned.into())),
        ("TrialsRated", Some(rated.into())),
        ("Seed", Some(session.sidecar.seed.into())),
        ("OnsetDefinition", Some(session.sidecar.onset.as_str().into())),
        ("Sittings", Some(each.collect())),
    ])
}

/// Describes the screen and the program with BIDS names and units; unknown values are omitted. `n/a` means that there
/// was no screen.
fn presentation(sitting: &Sitting) -> Map<String, Value> {
    let (monitor, viewing) = (sitting.monitor.as_ref(), sitting.viewing.as_ref());
    let pixels = monitor.map(|monitor| (monitor.width_px, monitor.height_px)).filter(|(wide, _)| *wide > 0);
    let width = viewing.filter(|viewing| viewing.screen_width_measured).map(|viewing| viewing.screen_width_cm);
    // The program assumes square pixels.
    let size = width
        .zip(pixels)
        .map(|(width, (wide, high))| json!([meters(width), meters(width * f64::from(high) / f64::from(wide))]));
    let refresh_s = sitting.frames.as_ref().and_then(|frames| frames.refresh_s).filter(|seconds| *seconds > 0.0);
    let refresh_hz = refresh_s.map(f64::recip).or(monitor.and_then(|monitor| monitor.refresh_hz));
    // `n/a` means that there was no screen.
    let no_screen = (sitting.observer.is_some() && sitting.viewing.is_none()).then(|| Value::from(MISSING));
    let program = &sitting.program;
    keys([
        ("ScreenDistance", viewing.map(|viewing| meters(viewing.distance_cm)).or(no_screen.clone())),
        ("ScreenSize", size.or(no_screen.clone())),
        ("ScreenResolution", pixels.map(|(wide, high)| json!([wide, high])).or(no_screen)),
        ("ScreenRefreshRate", refresh_hz.map(|hertz| rounded(hertz, 1e3))),
        ("OperatingSystem", Some(program.system.as_str().into())),
        ("SoftwareName", Some(program.name.as_str().into())),
        ("SoftwareVersion", Some(program.version.as_str().into())),
        ("SoftwareCommit", (program.commit != "unknown").then(|| program.commit.as_str().into())),
    ])
}

/// Converts centimeters to meters, rounded to a hundredth of a millimeter.
fn meters(centimeters: f64) -> Value {
    rounded(centimeters / 100.0, 1e5)
}

fn rounded(value: f64, steps: f64) -> Value {
    ((value * steps).round() / steps).into()
}

/// Returns the description of the whole data set, including the entries that people added to the descriptions of the
/// experiments.
fn description(experiments: &[Experiment]) -> Result<Value, StoreError> {
    let mut written = Vec::<Value>::new();
    for experiment in experiments {
        if let Some((path, text)) = sessions::described(DESCRIPTION, experiment)? {
            written.push(parse_json(&path, &text, "the description of a data set")?);
        }
    }
    let titles: Vec<&str> = experiments.iter().map(|one| one.sessions[0].protocol.title.as_str()).collect();
    let mut entries = keys([
        ("Name", Some(titles.join("; ").into())),
        ("BIDSVersion", Some(VERSION.into())),
        ("DatasetType", Some("raw".into())),
    ]);
    for (theirs, ours, is_list) in [
        ("Authors", "author", true),
        ("Funding", "funder", true),
        ("Keywords", "keywords", true),
        ("License", "license", false),
        ("HowToAcknowledge", "citation", false),
    ] {
        let mut all: Vec<String> = Vec::new();
        for text in written.iter().filter_map(|one| one.get(ours)).flat_map(texts) {
            if !all.contains(&text) {
                all.push(text);
            }
        }
        if !all.is_empty() {
            entries.insert(theirs.to_owned(), if is_list { all.into() } else { all.join("; ").into() });
        }
    }
    let program = json!({ "Name": env!("CARGO_PKG_NAME"), "Version": env!("CARGO_PKG_VERSION"), "Description": "machband export --format bids" });
    entries.insert("GeneratedBy".to_owned(), json!([program]));
    Ok(entries.into())
}

/// Returns the strings in a schema.org value, which is a string, an object with a name, or a list of these.
fn texts(value: &Value) -> Vec<String> {
    match value {
        Value::String(text) => vec![text.clone()],
        Value::Array(values) => values.iter().flat_map(texts).collect(),
        Value::Object(thing) => {
            let part = |key: &str| thing.get(key).and_then(Value::as_str);
            let full = || Some(format!("{} {}", part("givenName")?, part("familyName")?));
            let named = part("name").map(str::to_owned).or_else(full);
            named.or_else(|| part("url").or(part("@id")).map(str::to_owned)).into_iter().collect()
        }
        _ => Vec::new(),
    }
}

fn readme(experiments: &[Experiment]) -> String {
    let mut text = String::from("# Ratings of the visibility of Mach bands\n\n");
    for experiment in experiments {
        let protocol = &experiment.sessions[0].protocol;
        text += &format!(
            "- task `{}`: {} (sessions: {}; definition: `{}`)\n",
            protocol.file_task(),
            protocol.title,
            experiment.sessions.len(),
            experiment.name
        );
    }
    text + "
Each row of a `_beh.tsv` file is one trial; `n/a` is a missing value. Rows with the `trial_type` practice are not data.
A corrected response is a separate row with `attempt` + 1; the last attempt of a trial counts. If `TrialsRated` is less
than `TrialsPlanned`, the session is unfinished. `Sittings` describes the program and the screen. A sitting with a
`SimulatedObserver` had neither a participant nor a screen.

`stim_file` names the picture in `stimuli/`, which was re-rendered from its recipe; its hash matches what was shown. A
study's own pictures are not included.
`sourcedata/` contains the data as recorded: a Psych-DS data set for each experiment. The JSON file next to each CSV file
contains the definition, the display profile and a record of the session.
"
}

/// Number of digits of a hash in a file name.
const HASH_SHOWN: usize = 16;
/// Maximum length of the part of a file name that lists the levels.
const MAX_LABEL: usize = 150;

/// The picture's file name for each data file, sitting (from 1) and stimulus.
#[derive(Default)]
struct Stimuli(HashMap<(PathBuf, u32, String), String>);

impl Stimuli {
    /// Returns the file of the picture that a row describes, relative to the stimuli folder.
    fn of(&self, session: &Recorded, row: usize) -> Option<&str> {
        let described = session.stimuli(row).first()?.key();
        self.0.get(&(session.csv.clone(), session.rows[row].sitting, described)).map(String::as_str)
    }
}

/// Writes every picture into `folder`, and returns their file names and their number.
///
/// # Errors
/// Reports every picture that differs from the one that was shown; I/O errors.
fn write_stimuli(
    experiments: &[Experiment],
    folder: &Path,
    notes: &mut Vec<String>,
) -> Result<(Stimuli, usize), StoreError> {
    let sessions = || experiments.iter().flat_map(|experiment| &experiment.sessions);
    let mut renderer = Renderer::default();
    let mut wrong = Vec::new();
    for session in sessions() {
        signals::check(&session.csv)?;
        wrong.extend(picture_errors(session, &mut renderer));
    }
    FileErrors::none(wrong)?;
    // Identical pictures share one file.
    let (mut names, mut files) = (HashMap::<String, String>::new(), BTreeMap::new());
    let (mut shown, mut proved) = (HashMap::new(), HashSet::new());
    for session in sessions() {
        let mut sittings = BTreeMap::<u32, BTreeMap<String, &Stimulus>>::new();
        let mut has_own = false;
        for (index, row) in session.rows.iter().enumerate() {
            // Files of the study's own are not in the data set, so they cannot be exported either.
            let (drawable, own): (Vec<&Stimulus>, Vec<&Stimulus>) =
                session.stimuli(index).into_iter().partition(|stimulus| stimulus.is_drawable());
            has_own |= !own.is_empty();
            let stimuli = drawable.into_iter().map(|stimulus| (stimulus.key(), stimulus));
            sittings.entry(row.sitting).or_default().extend(stimuli);
        }
        notes.extend(has_own.then(|| {
            let name = &session.protocol.name;
            format!("{name}: the study's own pictures are not in the data set and not exported; their stim_file is n/a")
        }));
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
            let hashed = pictures.by_key(&session.course.schedule().conditions);
            let hashes = renderer.hashes(pictures, &stimuli.values().copied().collect::<Vec<_>>());
            for ((key, stimulus), hash) in stimuli.into_iter().zip(hashes) {
                if hashed.contains_key(&key) {
                    proved.insert(hash.clone());
                }
                let name = names.entry(hash).or_insert_with_key(|hash| {
                    let label = label(&session.protocol, stimulus);
                    let name = format!("{label}_{}.png", &hash[..HASH_SHOWN]);
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
        signals::check(&path)?;
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
