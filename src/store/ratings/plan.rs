//! Which of the files belong together, and which of their columns are read.

use std::path::PathBuf;

use super::{
    FileFault, Layout, Reading, Shape,
    header::Header,
    survey::{self, Surveyed},
};
use crate::{
    experiment::{Protocol, RATING_MAX},
    store::{sidecar::Sidecar, toml::nearest},
};

/// Columns of a record that say what was shown.
const STIMULUS: [&str; 7] = ["stimulus", "width", "depth", "orientation_deg", "low", "high", "color"];

/// A file to read.
#[derive(Debug)]
pub(super) struct Input {
    pub path: PathBuf,
    /// The path in messages.
    pub name: String,
    pub header: Header,
    pub layout: Layout,
    pub columns: Columns,
    pub sidecar: Option<Sidecar>,
    /// Main trials that its definition plans.
    pub planned: Option<u64>,
}

/// Indices of the columns that are read.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    pub subject: usize,
    pub response: usize,
    pub count: Option<usize>,
    pub factors: Vec<usize>,
    pub session: Option<usize>,
    pub repetition: Option<usize>,
    pub time: Option<usize>,
    /// Of a result file.
    pub record: Option<RecordColumns>,
}

/// Indices of a result file's own columns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RecordColumns {
    pub row_id: Option<usize>,
    pub experiment: Option<usize>,
    pub session: usize,
    pub phase: usize,
    pub trial: usize,
    pub attempt: usize,
    pub dropped: Option<usize>,
}

/// What is to be read.
#[derive(Debug)]
pub(super) struct Plan {
    pub inputs: Vec<Input>,
    pub shape: Shape,
    pub protocol: Option<Protocol>,
    pub definition_sha256: Option<String>,
    /// The experiment of all rows, where it is known.
    pub experiment: Option<String>,
    /// Whether ratings are on our own scale, 0…3.
    pub own_scale: bool,
}

/// Files of one group may be read together.
#[derive(Clone, Debug, PartialEq)]
enum Group {
    /// Result files of one definition, by its hash.
    Definition(String),
    /// Result files without a definition, by the experiment's name and the further columns.
    Experiment(String, Vec<String>),
    /// A session's file without rows and definition: it may belong to any experiment.
    Unknown,
    /// Tables of counts with just these factors.
    Counts(Vec<String>),
    /// Files whose factors were named.
    Named,
}

impl Group {
    fn is_results(&self) -> bool {
        matches!(self, Self::Definition(_) | Self::Experiment(..) | Self::Unknown)
    }
}

impl Plan {
    /// Chooses among files; gives faults of those that are left out.
    pub fn new(files: Vec<Surveyed>, how: &Reading) -> (Option<Self>, Vec<FileFault>) {
        let mut faults = Vec::new();
        let files: Vec<(Surveyed, Group)> = (files.into_iter())
            .filter_map(|file| match group(&file, how) {
                Ok(group) => Some((file, group)),
                Err(fault) => {
                    faults.push(fault);
                    None
                }
            })
            .collect();
        let files = with_lost_sidecars(files);
        let Some(chosen) = chosen(&files, how) else { return (None, faults) };
        let belongs = |group: &Group| {
            chosen.contains(group) || (*group == Group::Unknown && chosen.iter().any(Group::is_results))
        };
        let (read, others): (Vec<_>, Vec<_>) = files.into_iter().partition(|(_, group)| belongs(group));
        faults.extend(others.iter().map(|(file, group)| left_out(file, group, &read)));
        let read: Vec<Surveyed> = read.into_iter().map(|(file, _)| file).collect();
        let protocol = read.iter().find_map(|file| file.protocol.clone());
        let shape = shape(&read, protocol.as_ref(), how);
        let mut plan = Self {
            inputs: Vec::new(),
            own_scale: how.response.is_none(),
            experiment: read.iter().find_map(|file| file.experiment().map(str::to_owned)),
            definition_sha256: read.iter().find_map(|file| Some(file.sidecar.as_ref()?.definition_sha256.clone())),
            shape,
            protocol,
        };
        for file in read {
            match columns(&file, &plan.shape.factors, how) {
                Ok(columns) => plan.inputs.push(Input {
                    name: file.name(),
                    path: file.path,
                    header: file.header,
                    layout: file.layout,
                    columns,
                    planned: file.protocol.as_ref().map(|protocol| protocol.main_trials() as u64),
                    sidecar: file.sidecar,
                }),
                Err(found) => faults.extend(found),
            }
        }
        if plan.inputs.is_empty() { (None, faults) } else { (Some(plan), faults) }
    }
}

/// The group of a file.
fn group(file: &Surveyed, how: &Reading) -> Result<Group, FileFault> {
    match (file.layout, &file.sidecar) {
        (Layout::Results, Some(sidecar)) => Ok(Group::Definition(sidecar.definition_sha256.clone())),
        (Layout::Results, None) => Ok(match file.experiment() {
            Some(name) => {
                let further = file.further(survey::response(how)).into_iter().map(str::to_owned).collect();
                Group::Experiment(name.to_owned(), further)
            }
            None => Group::Unknown,
        }),
        (Layout::Counts | Layout::Long, _) if how.factors.is_some() => Ok(Group::Named),
        (Layout::Counts, _) => {
            let mut factors: Vec<String> = count_factors(file, how).map(str::to_owned).collect();
            factors.sort();
            Ok(Group::Counts(factors))
        }
        (Layout::Long, _) if !how.also.is_empty() => Ok(Group::Named),
        (Layout::Long, _) => {
            // A file of another kind is told by the columns that every table of ratings has.
            if let Err(missing) = columns(file, &[], how)
                && let Some(first) = missing.into_iter().next()
            {
                return Err(first);
            }
            let others: Vec<&str> = count_factors(file, how).collect();
            let message = if others.is_empty() {
                "no factors are named, and there are no further columns; expected a column for each factor".to_owned()
            } else {
                format!(
                    "no factors are named; expected --factors or --terms with some of the columns {}",
                    others.join(", ")
                )
            };
            Err(file.fault(1, message))
        }
    }
}

/// All columns but subject, response and count. A column without a name is the row numbers of R or pandas.
fn count_factors<'a>(file: &'a Surveyed, how: &'a Reading) -> impl Iterator<Item = &'a str> {
    let known = [survey::subject(how), survey::response(how), survey::count(how)];
    file.header.names.iter().map(String::as_str).filter(move |name| !name.is_empty() && !known.contains(name))
}

/// A session whose sidecar is lost belongs to the definition of its experiment's name, if there is just one.
fn with_lost_sidecars(files: Vec<(Surveyed, Group)>) -> Vec<(Surveyed, Group)> {
    let definitions: Vec<(Protocol, Group)> = files.iter().fold(Vec::new(), |mut known, (file, group)| {
        if let Some(protocol) = &file.protocol
            && !known.iter().any(|(_, other)| other == group)
        {
            known.push((protocol.clone(), group.clone()));
        }
        known
    });
    let definition_of = |file: &Surveyed, name: &str| {
        let mut fitting = definitions.iter().filter(|(protocol, _)| {
            protocol.name == name && protocol.factors.iter().all(|f| file.header.position(&f.name).is_some())
        });
        let only = fitting.next()?;
        fitting.next().is_none().then(|| only.1.clone())
    };
    (files.into_iter())
        .map(|(file, group)| {
            let found = match &group {
                Group::Experiment(name, _) => definition_of(&file, name),
                _ => None,
            };
            (file, found.unwrap_or(group))
        })
        .collect()
}

/// The groups that are read: the one with the most files, of equal ones the first; with named factors the largest of
/// the result files and everything else.
fn chosen(files: &[(Surveyed, Group)], how: &Reading) -> Option<Vec<Group>> {
    let mut groups: Vec<(&Group, usize)> = Vec::new();
    for (_, group) in files {
        match groups.iter_mut().find(|(known, _)| *known == group) {
            Some((_, n)) => *n += 1,
            None => groups.push((group, 1)),
        }
    }
    let largest = |wanted: &dyn Fn(&Group) -> bool| {
        let fitting = groups.iter().filter(|(group, _)| wanted(group));
        fitting.rev().max_by_key(|(_, n)| n).map(|(group, _)| (*group).clone())
    };
    let known = |group: &Group| *group != Group::Unknown;
    let results = || largest(&|group| group.is_results() && known(group)).or_else(|| largest(&Group::is_results));
    if how.factors.is_some() {
        let named = groups.iter().any(|(group, _)| **group == Group::Named).then_some(Group::Named);
        let both: Vec<Group> = results().into_iter().chain(named).collect();
        (!both.is_empty()).then_some(both)
    } else {
        largest(&known).or_else(results).map(|group| vec![group])
    }
}

/// The fault of a file that does not belong to those that are read.
fn left_out(file: &Surveyed, group: &Group, read: &[(Surveyed, Group)]) -> FileFault {
    let others = if read.len() == 1 { "the other file".to_owned() } else { format!("the other {} files", read.len()) };
    let (this, that) = match read.iter().find(|(_, other)| other.is_results() == group.is_results()).or(read.first()) {
        Some((other, other_group)) => (describe(file, group), describe(other, other_group)),
        None => (describe(file, group), "another".to_owned()),
    };
    file.fault(1, format!("is {this} and is left out; expected {that} as {others}: only one is analysed at a time"))
}

fn describe(file: &Surveyed, group: &Group) -> String {
    match group {
        Group::Definition(hash) => {
            let name = file.experiment().unwrap_or("without a name");
            format!("of the experiment {name} (definition {})", hash.get(..12).unwrap_or(hash))
        }
        Group::Experiment(name, further) if further.is_empty() => format!("of the experiment {name} (no sidecar)"),
        Group::Experiment(name, further) => {
            format!("of the experiment {name} (no sidecar; further columns {})", further.join(", "))
        }
        Group::Unknown => "a session's file without rows".to_owned(),
        Group::Counts(factors) => format!("a table of counts by {}", factors.join(", ")),
        Group::Named => "a table of ratings".to_owned(),
    }
}

fn shape(files: &[Surveyed], protocol: Option<&Protocol>, how: &Reading) -> Shape {
    let has = |name: &str| files.iter().any(|file| file.header.position(name).is_some());
    let first = &files[0];
    let mut guessed = false;
    let mut factors: Vec<String> = match (&how.factors, protocol) {
        (Some(named), _) => named.clone(),
        (None, Some(protocol)) => protocol.factors.iter().map(|factor| factor.name.clone()).collect(),
        (None, None) if first.layout == Layout::Results => {
            guessed = true;
            let stimulus = STIMULUS.into_iter().filter(|name| first.header.position(name).is_some());
            stimulus.chain(first.further(survey::response(how))).map(str::to_owned).collect()
        }
        (None, None) if first.layout == Layout::Counts => count_factors(first, how).map(str::to_owned).collect(),
        // A missing one is a fault of the file.
        (None, None) => how.also.iter().filter(|name| has(name) || *name != "inv_n").cloned().collect(),
    };
    for name in &how.also {
        // 1/n of the depth n: a term, not a column.
        let name = if !has(name) && name == "inv_n" { "depth" } else { name };
        if has(name) && !factors.iter().any(|known| known == name) {
            factors.push(name.to_owned());
        }
    }
    let scale = (0..=RATING_MAX).map(|rating| rating.to_string()).collect();
    // A name may stand twice in what was asked: `--terms a,b,a:b`.
    let mut seen = std::collections::HashSet::new();
    factors.retain(|name| seen.insert(name.clone()));
    Shape {
        factors,
        subject: survey::subject(how).to_owned(),
        response: survey::response(how).to_owned(),
        categories: if how.response.is_none() { Some(scale) } else { how.categories.clone() },
        guessed,
    }
}

/// Where the columns of a file are.
///
/// # Errors
/// Those that are missing.
fn columns(file: &Surveyed, factors: &[String], how: &Reading) -> Result<Columns, Vec<FileFault>> {
    let header = &file.header;
    let mut faults = Vec::new();
    let mut needed = |name: &str| {
        let known: Vec<&str> = header.names.iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
        let places: Vec<usize> = (0..header.names.len()).filter(|&i| header.names[i] == name).collect();
        match places[..] {
            [] => faults.push(file.fault(1, format!("the column {name} is missing; {}", nearest(name, &known)))),
            [_] => {}
            [_, second, ..] => faults
                .push(file.fault(header.column(second), format!("the column {name} stands twice; expected it once"))),
        }
        places.first().copied().unwrap_or(0)
    };
    let subject = needed(survey::subject(how));
    let response = needed(survey::response(how));
    let count = match file.layout {
        Layout::Results => None,
        Layout::Counts => Some(needed(survey::count(how))),
        Layout::Long => how.count.as_deref().map(&mut needed),
    };
    let record = (file.layout == Layout::Results).then(|| RecordColumns {
        row_id: header.position("row_id"),
        experiment: header.position("experiment"),
        session: needed("session_id"),
        phase: needed("phase"),
        trial: needed("trial"),
        attempt: needed("attempt"),
        dropped: header.position("dropped_frames"),
    });
    let factors = factors.iter().map(|name| needed(name)).collect();
    let details = |name: &str| if how.details && file.layout != Layout::Counts { header.position(name) } else { None };
    let (session, repetition, time) = (details("session_id"), details("repetition"), details("response_time_s"));
    let columns = Columns { subject, response, count, factors, session, repetition, time, record };
    if faults.is_empty() {
        let roles =
            [("subject", Some(columns.subject)), ("response", Some(columns.response)), ("count", columns.count)]
                .into_iter()
                .filter_map(|(role, place)| Some((role, place?)))
                .chain(columns.factors.iter().map(|&place| ("factor", place)));
        let mut taken: Vec<(&str, usize)> = Vec::new();
        for (role, place) in roles {
            if let Some((other, _)) = taken.iter().find(|(_, other)| *other == place) {
                let name = &header.names[place];
                let message = format!("the column {name} is the {other} and the {role}; expected a column for each");
                faults.push(file.fault(header.column(place), message));
            }
            taken.push((role, place));
        }
    }
    if faults.is_empty() { Ok(columns) } else { Err(faults) }
}
