//! Reads ratings in steps: find the files, read their heads, select the files that belong together, determine which
//! rows count, and pass those rows to the caller.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    path::{Path, PathBuf},
};

use rayon::prelude::*;

use super::{
    files,
    row::{self, Cells, RowError, is_rating},
    selection::{Definitions, Input, RecordColumns, Selection},
    source::{FileRead, Layout, ReadOptions, SessionRead, Shape, Source},
    survey::Survey,
    trials::{Identity, Status, Trial, Trials},
};
use crate::{
    experiment::RatingRow,
    store::{
        Columns, FileError, FileErrors, dataset,
        error::RowErrors,
        file,
        table::{self, Row},
    },
    text::names::natural,
};

/// Maximum size, in bytes, of a file for which a hash is reported.
const MAX_HASHED: u64 = 64 << 20;

/// Number of files that are read at the same time. Their results are all in memory at once.
const AT_A_TIME: usize = 256;

/// Reads files and folders of files. For each file, `new` creates a `T`, `add` adds to it every row that counts, and
/// `take` receives it, in the order of the files. If `add` fails, an error is reported at the line and column of the
/// rating, and the row is excluded.
///
/// # Errors
/// The reason why there is nothing to analyze, or the first error of `take`. If only part of the input has errors, they
/// are in [`Source::errors`], and the rest is read.
pub fn read<T: Send>(
    paths: &[PathBuf],
    options: &ReadOptions,
    new: impl Fn(&Shape) -> T + Sync,
    add: impl Fn(&mut T, &RatingRow<'_>) -> Result<(), String> + Sync,
    take: impl FnMut(&FileRead, T) -> Result<(), FileErrors>,
) -> Result<Source, FileErrors> {
    let (files, mut errors) = files::files(paths);
    let definitions = Definitions::default();
    let opened: Vec<_> = files.par_iter().map(|path| Input::new(path, options, &definitions)).collect();
    let mut inputs = Vec::new();
    for found in opened {
        match found {
            Ok((file, found)) => {
                inputs.push(file);
                errors.extend(found);
            }
            Err(error) => errors.push(error),
        }
    }
    read_inputs((inputs, &files), errors, options, new, add, take)
}

/// Reads a table in memory, as [`read`] does a file. Errors name the table and, for the rows with errors, the row,
/// counted from 0, and the column, counted from 1.
///
/// # Errors
/// The same errors as [`read`], or the columns differ in length.
pub fn read_columns<T: Send>(
    name: &str,
    columns: Columns,
    options: &ReadOptions,
    new: impl Fn(&Shape) -> T + Sync,
    add: impl Fn(&mut T, &RatingRow<'_>) -> Result<(), String> + Sync,
    take: impl FnMut(&FileRead, T) -> Result<(), FileErrors>,
) -> Result<Source, FileErrors> {
    columns.check(name)?;
    let input = Input::of(name, columns, options);
    read_inputs((vec![input], &[PathBuf::from(name)]), Vec::new(), options, new, add, take)
}

/// Reads what was opened; `errors` are those found so far.
fn read_inputs<T: Send>(
    (inputs, files): (Vec<Input>, &[PathBuf]),
    mut errors: Vec<FileError>,
    options: &ReadOptions,
    new: impl Fn(&Shape) -> T + Sync,
    add: impl Fn(&mut T, &RatingRow<'_>) -> Result<(), String> + Sync,
    mut take: impl FnMut(&FileRead, T) -> Result<(), FileErrors>,
) -> Result<Source, FileErrors> {
    let (selection, found) = Selection::new(inputs, options);
    errors.extend(found);
    let Some(mut selection) = selection else {
        if errors.is_empty() {
            errors.push(FileError::whole(".", "no files were given; expected result files or folders".to_owned()));
        }
        return Err(in_order(errors, files));
    };
    let (trials, survey) = first_pass(&selection);
    let measurements = selection.set_survey(survey);
    let sessions = sessions(&selection, &trials);
    let unfinished: HashSet<(&str, &str)> = (sessions.iter())
        .filter(|session| options.complete_only && session.is_unfinished())
        .map(|session| (session.subject.as_str(), session.session.as_str()))
        .collect();
    let one = |file: usize| -> (T, FileRead, Vec<FileError>) {
        let input = &selection.inputs[file];
        let mut reader = FileReader {
            selection: &selection,
            trials: &trials,
            unfinished: &unfinished,
            file,
            input,
            read: FileRead { path: input.path.clone(), layout: input.layout, ..FileRead::default() },
            errors: RowErrors::default(),
            repeated: HashSet::new(),
            recent: 0,
            elsewhere: (0, 0),
        };
        let mut found = new(&selection.shape);
        let read = each_row(input, |row, cells| reader.take(row, cells, |rating| add(&mut found, rating)));
        let (read, errors) = reader.finish(read.err());
        (found, read, errors)
    };
    let mut reports = Vec::new();
    let all = selection.inputs.len();
    for first in (0..all).step_by(AT_A_TIME) {
        let read: Vec<_> = (first..all.min(first + AT_A_TIME)).into_par_iter().map(one).collect();
        for (found, report, wrong) in read {
            take(&report, found)?;
            reports.push(report);
            errors.extend(wrong);
        }
    }
    if reports.iter().all(|report| report.ratings == 0) {
        errors.push(no_row_counts(&reports));
        return Err(in_order(errors, files));
    }
    let errors = in_order(errors, files).0;
    let mut warnings = warnings(&selection.inputs);
    warnings.extend(measurements);
    let Selection { shape, protocol, definition_sha256, .. } = selection;
    Ok(Source { shape, protocol, definition_sha256, files: reports, sessions, errors, warnings })
}

/// Returns the warnings about files that are read anyway: changed files, sessions without a sidecar, links that lead out
/// of a data set, and tables of counts.
fn warnings(inputs: &[Input]) -> Vec<FileError> {
    let beside = |input: &Input| input.path.with_extension("json");
    let changed = |input: &Input| match &input.sidecar {
        _ if input.header.columns.is_some() => Vec::new(),
        Some(_) => input.changed.clone(),
        None if input.columns.record.is_some()
            && dataset::described(&input.path).is_some()
            && !beside(input).exists() =>
        {
            let message =
                "has no sidecar, so nothing shows whether it was changed; expected the sidecar that belongs to it";
            vec![FileError::whole(&input.path, message)]
        }
        None => Vec::new(),
    };
    let mut warnings: Vec<FileError> = inputs.par_iter().flat_map_iter(changed).collect();
    // One warning for each data set, because a version control system may replace every file with a link.
    let mut links: BTreeMap<&Path, Vec<PathBuf>> = BTreeMap::new();
    for input in inputs.iter().filter(|input| input.header.columns.is_none()) {
        if let Some(folder) = dataset::described(&input.path) {
            links.entry(folder).or_default().extend(links_out(folder, &input.path));
        }
    }
    warnings.extend(links.into_iter().filter(|(_, paths)| !paths.is_empty()).map(|(folder, paths)| {
        let (first, all) = (paths[0].display(), paths.len());
        let message = format!(
            "some of its files are links to files outside (in total {all}, such as {first}); expected regular files (the \
             links were followed)"
        );
        FileError::whole(folder, message)
    }));
    warnings.extend(counts_warning(inputs));
    warnings
}

/// Returns the warning about what tables of counts do not contain; `None` if there are no such tables.
fn counts_warning(inputs: &[Input]) -> Option<FileError> {
    let mut tables = inputs.iter().filter(|input| input.layout == Layout::Counts);
    let first = tables.next()?;
    let others = tables.count();
    let are = if others == 0 { "is a table".to_owned() } else { format!("and {others} more are tables") };
    let message = format!(
        "{are} of counts, so it is not known whether ratings are simulated, or when and in which order they were given; \
         expected the result files for test–retest agreement, response times, sessions, and the prediction of the vision \
         model"
    );
    Some(FileError::whole(&first.path, message))
}

/// Returns those of a data file and its sidecar that are outside the data set once links are resolved.
fn links_out(dataset: &Path, csv: &Path) -> Vec<PathBuf> {
    let Ok(inside) = dataset.canonicalize() else { return Vec::new() };
    let leads_out = |path: &PathBuf| path.canonicalize().is_ok_and(|target| !target.starts_with(&inside));
    [csv.to_owned(), csv.with_extension("json")].into_iter().filter(leads_out).collect()
}

/// Reads the rows of all files to determine which rows of result files count, and what the columns contain. Errors are
/// reported later, when the rows are read again.
fn first_pass(selection: &Selection) -> (Trials, Survey) {
    let noted: Vec<(Trials, Survey)> = (selection.inputs.par_iter().enumerate())
        .map(|(file, input)| {
            let (mut trials, mut survey) = (Trials::default(), Survey::new(selection.shape.factors.len()));
            let columns = &input.columns;
            let _ = each_row(input, |_, cells| {
                let Ok(cells) = cells else { return };
                let factors = survey.factors.iter_mut().zip(&selection.guessed);
                for ((contents, guessed), &column) in factors.zip(&columns.factors) {
                    contents.add(cells.get(column), *guessed);
                }
                if !selection.own_scale {
                    survey.response.add(cells.get(columns.response), false);
                }
                let Some(own) = &columns.record else { return };
                let experiment = selection.experiment.as_deref();
                let Ok(identity) = row::identity(&cells, columns.subject, own, experiment) else { return };
                let dropped = own.dropped.map_or("", |column| cells.get(column));
                let rated = is_rating(cells.get(columns.response), selection.own_scale, false);
                trials.add(&identity, rated, (!dropped.is_empty()).then_some(dropped != "0"), file);
            });
            (trials, survey)
        })
        .collect();
    let mut all = (Trials::default(), Survey::new(selection.shape.factors.len()));
    for (trials, survey) in noted {
        all.0.absorb(trials);
        all.1.absorb(survey);
    }
    all.0.finish();
    all
}

/// Calls `take` with every row below the header, along with its cells or the error in them.
fn each_row(input: &Input, mut take: impl FnMut(&Row<'_>, Result<Cells<'_>, RowError>)) -> std::io::Result<()> {
    let (header, mut is_header) = (&input.header, true);
    table::each_row(header.content(&input.path), header.separator, |row| {
        if !std::mem::take(&mut is_header) {
            take(row, Cells::new(row, &header.names));
        }
    })
}

/// Returns the sessions of all result files, including sessions without rows.
fn sessions(selection: &Selection, trials: &Trials) -> Vec<SessionRead> {
    let of = |subject: &str, session: &str, input: &Input| SessionRead {
        subject: subject.to_owned(),
        session: session.to_owned(),
        path: input.path.clone(),
        planned: input.planned(),
        rated: 0,
        dropped: None,
        sidecar: input.sidecar.clone(),
    };
    let with_rows = trials.sessions.iter().map(|session| {
        let input = &selection.inputs[session.file()];
        let (rated, dropped) = (session.rated(), session.dropped());
        SessionRead { rated, dropped, ..of(&session.subject, &session.session, input) }
    });
    let mut sessions: Vec<SessionRead> = with_rows.collect();
    for input in selection.inputs.iter().filter(|input| input.columns.record.is_some() && input.header.first.is_none())
    {
        if let Ok((_, identity)) = dataset::identity(&input.path) {
            let (subject, session) = (identity.subject(), identity.session());
            if !sessions.iter().any(|known| known.subject == subject && known.session == session) {
                sessions.push(of(subject, session, input));
            }
        }
    }
    sessions.sort_by(|a, b| natural(&a.subject, &b.subject).then_with(|| natural(&a.session, &b.session)));
    sessions
}

/// The state while one file is read.
struct FileReader<'a> {
    selection: &'a Selection,
    trials: &'a Trials,
    /// Participant and session of the excluded sessions.
    unfinished: &'a HashSet<(&'a str, &'a str)>,
    file: usize,
    input: &'a Input,
    read: FileRead,
    errors: RowErrors,
    /// Trials that occur twice in the file, with their session, once their first row has been read.
    repeated: HashSet<(usize, Trial)>,
    /// The session of the previous row.
    recent: usize,
    /// The number of rows that also occur in another file, and the last such file.
    elsewhere: (u64, usize),
}

impl FileReader<'_> {
    fn take(
        &mut self,
        row: &Row<'_>,
        cells: Result<Cells<'_>, RowError>,
        add: impl FnMut(&RatingRow<'_>) -> Result<(), String>,
    ) {
        self.read.rows += 1;
        match cells.map_err(Some).and_then(|cells| self.rating(row, &cells, add)) {
            Ok(count) => {
                self.read.counted += 1;
                self.read.ratings += count;
            }
            Err(Some(error)) => {
                self.read.erroneous += 1;
                self.error(row, error);
            }
            Err(None) => {}
        }
    }

    fn error(&mut self, row: &Row<'_>, error: RowError) {
        let error = partial_row(row, &error).unwrap_or(error);
        let cell = error.cell.or(row.text().err()).unwrap_or(0);
        self.errors.add(&self.input.name, error.cell, error.message, || row.place(cell));
    }

    /// Calls `add` for a row that counts, and returns how many trials the row represents.
    ///
    /// # Errors
    /// The error in the row; `None` if the row is excluded for another reason and has already been counted as such.
    fn rating(
        &mut self,
        row: &Row<'_>,
        cells: &Cells<'_>,
        mut add: impl FnMut(&RatingRow<'_>) -> Result<(), String>,
    ) -> Result<u64, Option<RowError>> {
        let (own_scale, survey) = (self.selection.own_scale, &self.selection.survey);
        let columns = &self.input.columns;
        if let Some(own) = &columns.record {
            let experiment = self.selection.experiment.as_deref();
            let identity = row::identity(cells, columns.subject, own, experiment)?;
            self.check(&identity, cells, own)?;
        }
        let subject = cells.present(columns.subject, "a participant")?;
        let rating = row::rating(cells, columns, own_scale, survey.response.are_numbers())?;
        let count = row::count(cells, columns)?;
        // An unreadable position or time is an error, but the rating still counts.
        let place = row::place(cells, columns).unwrap_or_else(|error| self.unread(row, error));
        let response_time_s = row::response_time(cells, columns).unwrap_or_else(|error| self.unread(row, error));
        let factors = columns.factors.iter().zip(&survey.factors).zip(&self.selection.levels);
        let values: Vec<&str> = factors
            .map(|((&column, contents), defined)| {
                let defined = if columns.record.is_some() { &defined[..] } else { &[] };
                row::level(cells.optional(column, contents.are_numbers()), defined)
            })
            .collect();
        add(&RatingRow { subject, values: &values, rating, count, place, response_time_s })
            .map_err(|message| RowError { cell: Some(columns.response), message })?;
        Ok(count)
    }

    fn unread<T>(&mut self, row: &Row<'_>, error: RowError) -> Option<T> {
        self.error(row, error);
        None
    }

    /// Checks whether a row of a result file counts.
    ///
    /// # Errors
    /// The same errors as [`FileReader::rating`].
    fn check(&mut self, row: &Identity<'_>, cells: &Cells<'_>, own: &RecordColumns) -> Result<(), Option<RowError>> {
        let Some(session) = self.trials.find(row.subject, row.session, self.recent) else { return Ok(()) };
        self.recent = session;
        let is_new = |trial| self.repeated.insert((self.recent, trial));
        let status = self.trials.sessions[self.recent].status(row.trial, self.file, is_new);
        if let Status::Repeated(file) = status {
            self.elsewhere = (self.elsewhere.0 + u64::from(file != self.file), file);
            let name = match own.row_id.map_or("", |column| cells.get(column)) {
                "" => "the trial and attempt of this row".to_owned(),
                row_id => format!("row_id {row_id:?}"),
            };
            let place =
                if file == self.file { "above".to_owned() } else { format!("in {}", self.selection.inputs[file].name) };
            let message = format!("{name} already appears {place}; expected each row only once (this one is left out)");
            return Err(RowError { cell: None, message }.into());
        }
        let left_out = if !row.trial.is_main() {
            &mut self.read.practice
        } else if status == Status::Superseded {
            &mut self.read.superseded
        } else if self.unfinished.contains(&(row.subject, row.session)) {
            &mut self.read.unfinished
        } else {
            return Ok(());
        };
        *left_out += 1;
        Err(None)
    }

    fn finish(mut self, error: Option<std::io::Error>) -> (FileRead, Vec<FileError>) {
        let (name, rows) = (&self.input.name, self.read.rows);
        self.read.sha256 = sha256(self.input);
        let mut errors = Vec::new();
        if let Some(error) = error {
            let message = format!("cannot be read completely: {error}; expected a readable file");
            errors.push(FileError::whole(name, message));
        }
        if rows > 0 && self.elsewhere.0 == rows {
            let other = &self.selection.inputs[self.elsewhere.1].name;
            let message = format!(
                "all its rows ({rows}) already appear in {other}; expected each session only once (this file is left out)"
            );
            errors.push(FileError::whole(name, message));
        } else {
            errors.extend(self.errors.finish(name, &self.input.header.names));
        }
        (self.read, errors)
    }
}

/// Replaces the error of a row that an interrupted write left behind. This is the last row, and it either has no line
/// end and an error in its last cell or its number of cells, or contains zero bytes because the file was enlarged but
/// not filled.
fn partial_row(row: &Row<'_>, error: &RowError) -> Option<RowError> {
    if !row.last {
        return None;
    }
    let raw = row.raw();
    let is_ended = raw.ends_with(b"\n") || raw.ends_with(b"\r");
    let ends_badly = error.cell.is_none_or(|cell| cell + 1 == row.record.len());
    let what = if raw.contains(&0) {
        "contains zero bytes"
    } else if !is_ended && ends_badly {
        "is cut off"
    } else {
        return None;
    };
    let message =
        format!("the last row {what}, as after an interrupted write; expected a complete row (this one is left out)");
    Some(RowError { cell: None, message })
}

fn sha256(input: &Input) -> Option<String> {
    if input.header.size > MAX_HASHED || input.header.columns.is_some() {
        return None;
    }
    input.header.content(&input.path).bytes().ok().map(|bytes| file::sha256(&bytes))
}

/// Returns the error that no row counts, with the reasons.
fn no_row_counts(reports: &[FileRead]) -> FileError {
    let sum = |of: fn(&FileRead) -> u64| reports.iter().map(of).sum::<u64>();
    let parts = [
        (sum(|report| report.practice), "from practice"),
        (sum(|report| report.superseded), "superseded"),
        (sum(|report| report.unfinished), "from unfinished sessions"),
        (sum(|report| report.erroneous), "with errors"),
    ];
    let parts: Vec<String> = parts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
    let found = match sum(|report| report.rows) {
        0 => "there are no rows".to_owned(),
        rows => format!("none of the rows ({rows}) counts: {}", parts.join(", ")),
    };
    let among = if reports.len() > 1 { format!(" in {} files", reports.len()) } else { String::new() };
    let path = reports.first().map_or(".".to_owned(), |report| report.path.display().to_string());
    FileError::whole(path, format!("{found}{among}; expected ratings of main trials"))
}

/// Sorts errors in the order of the files; errors about folders come first.
fn in_order(mut errors: Vec<FileError>, files: &[PathBuf]) -> FileErrors {
    // Errors in a sidecar are sorted along with those in its data file.
    let index: HashMap<PathBuf, usize> =
        files.iter().enumerate().map(|(i, path)| (path.with_extension(""), i)).collect();
    errors.sort_by_key(|error| index.get(&Path::new(&error.file).with_extension("")).map_or(0, |i| i + 1));
    FileErrors(errors)
}
