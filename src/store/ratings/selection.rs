//! Determines what each file is, which files belong together, and which of their columns are read.

use std::{
    collections::{BTreeSet, HashSet},
    path::{Path, PathBuf},
    sync::Arc,
};

use super::{
    files::{Header, SUBJECT},
    source::{Layout, ReadOptions, Shape},
};
use crate::{
    experiment::{Factor, Protocol, SIMULATED, STIMULUS, columns_by_header},
    stimulus::is_direction,
    store::{
        FileError, StoreError,
        file::exists,
        session::{results, seal},
        sidecar::Sidecar,
        table::shortened,
    },
    text::names::{expected_one_of, some_of},
};

/// Columns that a result file must have in addition to the participant's column.
const KEYS: [&str; 4] = ["session_id", "phase", "trial", "attempt"];

/// A file to read.
#[derive(Debug, Default)]
pub(super) struct Input {
    pub path: PathBuf,
    /// The path as shown in messages.
    pub name: String,
    pub header: Header,
    pub layout: Layout,
    pub columns: Columns,
    /// True if there is a sidecar, even if it has errors.
    pub has_sidecar: bool,
    pub sidecar: Option<Arc<Sidecar>>,
    pub protocol: Option<Protocol>,
    /// Files of the session that differ from the hashes recorded when it ended.
    pub changed: Vec<FileError>,
    /// A description of the file. Files with the same description are read together.
    kind: String,
}

/// Indices of the columns that are read.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    pub subject: usize,
    /// The column with the response; in a wide table, the columns with the responses at each level.
    pub responses: Vec<usize>,
    pub count: Option<usize>,
    pub factors: Vec<usize>,
    pub session: Option<usize>,
    pub repetition: Option<usize>,
    pub time: Option<usize>,
    /// The place of a row in its session.
    pub order: Option<usize>,
    /// Whether the response comes from a program.
    pub simulated: Option<usize>,
    /// The columns that only a result file needs.
    pub phase: Option<usize>,
    pub trial: Option<usize>,
    /// Without this column, every trial of a result file has one attempt.
    pub attempt: Option<usize>,
    pub experiment: Option<usize>,
    /// In a table that is no result file, the columns `phase` (in BIDS, `trial_type`) and `attempt`, unless they have another use.
    pub unnamed: [Option<usize>; 2],
}

/// The files that are selected for reading.
#[derive(Debug)]
pub(super) struct Selection {
    pub inputs: Vec<Input>,
    pub shape: Shape,
    pub protocol: Option<Protocol>,
    pub definition_sha256: Option<String>,
    /// The experiment that all rows belong to, if known.
    pub experiment: Option<String>,
    /// The highest rating, if ratings are on the scale of a definition.
    pub own_scale: Option<u8>,
    /// The columns of a wide table, which are levels of the last factor.
    pub wide: Vec<String>,
    /// For each factor, its levels in the definition, as result files have them; empty without a definition.
    pub levels: Vec<Vec<String>>,
}

impl Selection {
    /// Selects files, and reports an error for each file that is excluded.
    pub fn new(files: Vec<Input>, options: &ReadOptions) -> (Option<Self>, Vec<FileError>) {
        let (mut inputs, mut errors) = (Vec::new(), Vec::new());
        for mut file in files {
            match kind(&file, options) {
                Ok(kind) => {
                    file.kind = kind;
                    inputs.push(file);
                }
                Err(error) => errors.push(error),
            }
        }
        // The files of a folder lack the same.
        let mut said = HashSet::new();
        errors.retain(|error| said.insert(error.message.clone()));
        if let Some(error) = mixed(&inputs, options) {
            errors.push(error);
            return (None, errors);
        }
        let Some(first) = inputs.first() else { return (None, errors) };
        let protocol = inputs.iter().find_map(|file| file.protocol.clone());
        // Without a definition, any scale is possible.
        let own_scale = protocol.as_ref().filter(|_| options.own_scale()).map(|all| all.response.highest());
        let shape = shape(&inputs, (first, own_scale), protocol.as_ref(), options);
        let experiment = inputs.iter().find_map(|file| file.experiment().map(str::to_owned));
        let definition_sha256 = inputs.iter().find_map(|file| Some(file.sidecar.as_ref()?.definition_sha256.clone()));
        inputs.retain_mut(|file| match columns(file, &shape.factors, options) {
            Ok(columns) => {
                file.columns = columns;
                true
            }
            Err(found) => {
                errors.extend(found);
                false
            }
        });
        let defined = |name: &String| protocol.as_ref()?.factors.iter().find(|factor| factor.name == *name);
        let texts = |factor: &Factor| factor.levels.iter().map(ToString::to_string).collect();
        let levels = shape.factors.iter().map(|name| defined(name).map_or_else(Vec::new, texts)).collect();
        let wide = options.wide.clone().unwrap_or_default().1;
        let is_empty = inputs.is_empty();
        let selection = Self { inputs, shape, protocol, definition_sha256, experiment, own_scale, wide, levels };
        ((!is_empty).then_some(selection), errors)
    }
}

impl Columns {
    /// True if they are those of a result file.
    pub fn of_results(&self) -> bool {
        self.phase.is_some()
    }

    /// Returns the columns that are read.
    pub fn used(&self) -> BTreeSet<usize> {
        let mut all = BTreeSet::from([self.subject]);
        all.extend(&self.responses);
        let of_rating = [self.count, self.session, self.repetition, self.time, self.order, self.simulated];
        let of_trial = [self.phase, self.trial, self.attempt, self.experiment];
        let single = of_rating.into_iter().chain(of_trial).chain(self.unnamed).flatten();
        all.extend(self.factors.iter().copied().chain(single));
        all
    }
}

impl Input {
    /// Inspects a file. An error in its sidecar does not prevent its rows from being read.
    ///
    /// # Errors
    /// The head of the file has an error; the file or its sidecar cannot be read.
    pub fn new(path: &Path, options: &ReadOptions) -> Result<(Self, Vec<FileError>), StoreError> {
        let header = Header::read(path)?;
        let beside = path.with_extension("json");
        let has_sidecar = exists(&beside)?;
        let layout = layout(&header, options, has_sidecar);
        let (mut sidecar, mut protocol, mut errors, mut changed) = (None, None, Vec::new(), Vec::new());
        if layout == Layout::Results {
            match has_sidecar.then(|| Sidecar::read(&beside)).transpose() {
                Ok(found) => sidecar = found.flatten(),
                Err(StoreError::FileErrors(found)) => errors.extend(found.0),
                Err(error) => return Err(error),
            }
            if let Some(sidecar) = &sidecar {
                // Not the content of the header, which may have been converted.
                changed = seal::compare(path, sidecar, &results::content(path)?)?.differences;
                match sidecar.protocol(&beside) {
                    Ok((found, error)) => {
                        changed.extend(error);
                        protocol = Some(found);
                    }
                    Err(found) => errors.extend(found.0),
                }
            }
        }
        let sidecar = sidecar.map(Arc::new);
        let plain = Self::plain(path.to_owned(), header, layout);
        Ok((Self { has_sidecar, sidecar, protocol, changed, ..plain }, errors))
    }

    /// Describes a table without a sidecar.
    pub fn plain(path: PathBuf, header: Header, layout: Layout) -> Self {
        Self { name: path.display().to_string(), path, layout, header, ..Self::default() }
    }

    /// Returns the name of the column with the participant ID.
    pub fn subject<'a>(&'a self, options: &'a ReadOptions) -> &'a str {
        let usual = || self.header.subject().filter(|_| !self.is_results()).unwrap_or(SUBJECT);
        options.subject.as_deref().unwrap_or_else(usual)
    }

    fn is_results(&self) -> bool {
        self.layout == Layout::Results
    }

    /// True for a table in memory.
    pub fn in_memory(&self) -> bool {
        self.header.columns.is_some()
    }

    /// Returns the index of a column.
    ///
    /// # Errors
    /// It is missing or appears twice.
    pub fn place(&self, name: &str) -> Result<usize, FileError> {
        let header = &self.header;
        let places: Vec<usize> = header.positions(name).collect();
        match places[..] {
            [] if header.is_title => {
                let message = "the first line has one cell at most, and a line below it several; expected the names of the columns: \
                               remove the lines above them";
                Err(self.error(0, message.to_owned()))
            }
            [] if header.names.len() == 1 && !self.in_memory() => {
                let found = shortened(&header.names[0]);
                let expected = "expected the names of several columns, with commas, semicolons, tabs or vertical bars between them";
                Err(self.error(0, format!("the first line has one cell, {found:?}; {expected}")))
            }
            [] => {
                let known: Vec<&String> = header.names.iter().filter(|name| !name.is_empty()).collect();
                let sheet = header.text.note.as_ref().map_or_else(String::new, |[read, _]| format!(" ({read})"));
                let expected = expected_one_of(name, &known);
                Err(self.error(0, format!("the column {name} is missing{sheet}; {expected}")))
            }
            [place] => Ok(place),
            [_, second, ..] => Err(self.error(second, format!("the column {name} appears twice; expected it once"))),
        }
    }

    /// Creates an error in the header, at the name with this index.
    pub fn error(&self, index: usize, message: String) -> FileError {
        self.header.error(&self.name, index, message)
    }

    /// Returns the name of the experiment, from the definition or otherwise from the first row.
    fn experiment(&self) -> Option<&str> {
        if let Some(protocol) = &self.protocol {
            return Some(&protocol.name);
        }
        let index = self.header.position("experiment")?;
        self.header.first.as_ref()?.get(index).map(String::as_str)
    }

    /// Returns the columns that are neither standard columns of a result file nor named for another use. Columns without a
    /// name are excluded too, because they contain row numbers from R or pandas.
    fn other_columns(&self, options: &ReadOptions) -> Vec<String> {
        let (standard, count) = match self.layout {
            Layout::Results => (columns_by_header(std::iter::empty()), None),
            Layout::Counts | Layout::Long => (Vec::new(), Some(options.count())),
        };
        let named = [self.subject(options), options.response(), options.time(), SIMULATED].into_iter();
        let wide = options.wide.iter().flat_map(|(_, columns)| columns).map(String::as_str);
        let named = named.chain(count).chain(options.order.as_deref()).chain(wide);
        let known: HashSet<&str> = standard.iter().map(|column| column.name.as_str()).chain(named).collect();
        let names = self.header.names.iter().filter(|name| !name.is_empty() && !known.contains(name.as_str()));
        names.cloned().collect()
    }
}

/// True if a table has the columns of a session's file.
pub(super) fn has_session_rows(header: &Header) -> bool {
    KEYS.into_iter().chain([SUBJECT]).all(|name| header.position(name).is_some())
}

/// Determines the layout of a file with this header. A file that lacks only one column of a result file is still
/// treated as a result file if it has a sidecar or a `row_id` column, or if the options give no other way to read it.
pub(super) fn layout(header: &Header, options: &ReadOptions, sidecar: bool) -> Layout {
    let has = |name: &str| header.position(name).is_some();
    if options.count.as_deref().is_some_and(has) {
        return Layout::Counts;
    }
    let missing =
        KEYS.into_iter().chain([options.subject.as_deref().unwrap_or(SUBJECT)]).filter(|name| !has(name)).count();
    let is_result = missing == 0 || missing == 1 && (sidecar || has("row_id") || options.factors.is_none());
    if options.wide.is_none() && is_result {
        Layout::Results
    } else if options.count.is_none() && has("count") && !options.is_factor("count") {
        Layout::Counts
    } else {
        Layout::Long
    }
}

/// Describes what a file contains.
fn kind(file: &Input, options: &ReadOptions) -> Result<String, FileError> {
    match file.layout {
        Layout::Results => {
            let details = match &file.sidecar {
                Some(sidecar) => {
                    let hash = &sidecar.definition_sha256;
                    format!("definition {}", hash.get(..12).unwrap_or(hash))
                }
                None => match file.other_columns(options).join(", ") {
                    other if other.is_empty() => "no sidecar".to_owned(),
                    other => format!("no sidecar; additional columns {other}"),
                },
            };
            let name = file.experiment().unwrap_or("without a name");
            Ok(format!("a session of the experiment {name} ({details})"))
        }
        Layout::Counts if options.factors.is_none() => {
            let mut factors = file.other_columns(options);
            factors.sort();
            Ok(format!("a table of counts by {}", factors.join(", ")))
        }
        Layout::Long if options.factors.is_none() && options.also().next().is_none() && options.wide.is_none() => {
            Err(without_factors(file, options))
        }
        _ => Ok("a table of ratings".to_owned()),
    }
}

/// Creates the error for a table for which no factors were given.
fn without_factors(file: &Input, options: &ReadOptions) -> FileError {
    // If the file lacks columns that every table of ratings has, report that first.
    if let Err(missing) = columns(file, &[], options)
        && let Some(first) = missing.into_iter().next()
    {
        return first;
    }
    let others = file.other_columns(options);
    let message = if others.is_empty() {
        "no factors were given, and the file has no other columns; expected a column for each factor".to_owned()
    } else {
        format!("no factors were given; expected factors or terms that name some of the columns {}", some_of(&others))
    };
    file.error(0, message)
}

/// Returns an error if files do not belong together. If factors were given, tables may be read with sessions. A session that has
/// lost its sidecar belongs to any with its experiment's name; one that has no rows either belongs to all.
fn mixed(files: &[Input], options: &ReadOptions) -> Option<FileError> {
    let is_lost = |file: &Input| file.is_results() && file.sidecar.is_none();
    let may_differ = |file: &Input, other: &Input| {
        let are_sessions = file.is_results() && other.is_results();
        let [own, others] = [file, other].map(Input::experiment);
        file.kind == other.kind
            || options.factors.is_some() && file.is_results() != other.is_results()
            || are_sessions && (is_lost(file) && own.is_none() || is_lost(other) && others.is_none())
            || are_sessions && is_lost(file) != is_lost(other) && own == others
    };
    files.iter().find_map(|file| {
        let other = files.iter().find(|other| !may_differ(file, other))?;
        let (this, that) = (format!("is {}", file.kind), format!("{} is {}", other.name, other.kind));
        Some(FileError::whole(&file.name, format!("{this}, and {that}; expected files of one experiment")))
    })
}

/// Returns which factors are directions: stimulus parameters that are, and those that the options name.
fn directions(factors: &[String], protocol: Option<&Protocol>, options: &ReadOptions) -> Vec<String> {
    let parameters = protocol.map(|protocol| protocol.stimulus.parameters());
    let of_stimulus = |name: &String| match parameters {
        Some(all) => all.iter().any(|parameter| parameter.name == *name && parameter.is_direction),
        None => is_direction(name),
    };
    let is_named = |name: &String| options.direction.iter().any(|list| list.0.contains(name));
    factors.iter().filter(|name| is_named(name) || of_stimulus(name)).cloned().collect()
}

fn shape(
    files: &[Input],
    (first, own_scale): (&Input, Option<u8>),
    protocol: Option<&Protocol>,
    options: &ReadOptions,
) -> Shape {
    let has = |name: &str| files.iter().any(|file| file.header.position(name).is_some());
    let mut guessed = false;
    let mut factors: Vec<String> = match (&options.factors, protocol, first.layout) {
        (Some(named), ..) => named.0.clone(),
        (None, Some(protocol), _) => protocol.factors.iter().map(|factor| factor.name.clone()).collect(),
        (None, None, Layout::Results) => {
            guessed = true;
            let stimulus = STIMULUS.into_iter().filter(|name| first.header.position(name).is_some());
            stimulus.map(str::to_owned).chain(first.other_columns(options)).collect()
        }
        (None, None, Layout::Counts) => first.other_columns(options),
        (None, None, Layout::Long) => Vec::new(),
    };
    // `inv_n` is 1/n for the depth n; it is a term and not a column.
    // In a table from elsewhere, a missing column is reported later as an error in the file.
    factors.extend(options.also().filter_map(|name| match name.as_str() {
        "inv_n" if !has(name) => Some("depth".to_owned()).filter(|depth| has(depth)),
        _ => Some(name.clone()).filter(|name| has(name) || first.layout == Layout::Long),
    }));
    // A name may occur several times in a request such as `--terms a,b,a:b`.
    let mut known = HashSet::new();
    factors.retain(|name| known.insert(name.clone()) && Some(name) != options.wide_factor());
    factors.extend(options.wide_factor().cloned());
    let scale = |highest: u8| (0..=highest).map(|rating| rating.to_string()).collect();
    Shape {
        directions: directions(&factors, protocol, options),
        levels: [&options.levels[..], &options.orders].concat(),
        factors,
        subject: first.subject(options).to_owned(),
        response: options.response().to_owned(),
        categories: own_scale.map(scale).or_else(|| options.categories.clone().map(|list| list.0)),
        guessed,
        time_limits: (options.min_time, options.max_time),
    }
}

/// Returns the indices of the columns in a file.
///
/// # Errors
/// A column is missing, appears twice, or has two uses.
fn columns(file: &Input, factors: &[String], options: &ReadOptions) -> Result<Columns, Vec<FileError>> {
    let header = &file.header;
    let mut errors = Vec::new();
    let mut needed = |name: &str| {
        file.place(name).unwrap_or_else(|error| {
            errors.push(error);
            0
        })
    };
    let is_results = file.is_results();
    let is_detailed = options.details && file.layout != Layout::Counts;
    let is_timed = [options.time.is_some(), options.min_time.is_some(), options.max_time.is_some()].contains(&true);
    let details = [("session_id", is_results), ("repetition", false), (options.time(), is_timed)];
    let [session, repetition, time] =
        details.map(|(name, must)| (must || is_detailed && header.position(name).is_some()).then(|| needed(name)));
    let order = match &options.order {
        Some(order) => Some(needed(order)),
        None => (is_results && is_detailed).then(|| needed("trial")),
    };
    let mut columns = Columns {
        subject: needed(file.subject(options)),
        responses: match &options.wide {
            Some((_, names)) => names.iter().map(|name| needed(name)).collect(),
            None => vec![needed(options.response())],
        },
        count: match file.layout {
            Layout::Results => None,
            Layout::Counts => Some(needed(options.count())),
            Layout::Long => options.count.as_deref().map(&mut needed),
        },
        phase: is_results.then(|| needed("phase")),
        trial: is_results.then(|| needed("trial")),
        attempt: header.position("attempt").filter(|_| is_results),
        experiment: header.position("experiment").filter(|_| is_results),
        factors: (factors.iter())
            .filter(|name| Some(*name) != options.wide_factor())
            .map(|name| needed(name))
            .collect(),
        session,
        repetition,
        time,
        order,
        simulated: header.position(SIMULATED).filter(|_| !options.is_factor(SIMULATED)),
        unnamed: [None; 2],
    };
    let read = columns.used();
    let unnamed = |names: &[&str]| names.iter().find_map(|name| header.position(name)).filter(|at| !read.contains(at));
    columns.unnamed = [unnamed(&["phase", "trial_type"]), unnamed(&["attempt"])];
    let mut taken = HashSet::new();
    let places = [Some(columns.subject), columns.count].into_iter().flatten();
    for place in places.chain(columns.responses.iter().chain(&columns.factors).copied()) {
        if !taken.insert(place) && errors.is_empty() {
            let message = format!("the column {} has two uses; expected a column for each", header.names[place]);
            errors.push(file.error(place, message));
        }
    }
    // A file with a title above its header lacks every column.
    errors.dedup();
    if errors.is_empty() { Ok(columns) } else { Err(errors) }
}
