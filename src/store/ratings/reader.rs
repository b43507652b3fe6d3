//! Reads ratings in steps: find the files, read their heads, select the files that belong together, read their rows,
//! determine which rows count, and pass those rows to the caller.

use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

use rayon::{iter::Either, prelude::*};

use super::{
    cells::{Known, add_rows},
    files::{self, Header},
    rows::{self, MAX_ROWS, RowError, Rows, Status, column_of},
    selection::{Input, Selection, layout},
    source::{FileRead, Layout, ReadOptions, Reason, SessionRead, Shape, Source},
};
use crate::{
    experiment::{Phase, Protocol, RatingRow},
    store::{Columns, FileError, FileErrors, StoreError, columns::Texts, dataset, recorded::interrupted},
    text::names::natural,
};

/// Reads files and folders of files. Every row that counts is added, in the order of the files, to what `new` returns. If
/// `add` fails, an error is reported at the line and column of the rating, and the row is excluded.
///
/// # Errors
/// The reason why there is nothing to analyze; or a file or folder that cannot be read, because what is in it could change
/// what the other files mean. If the content of a file has errors, they are in [`Source::errors`], and the rest is read.
pub fn read<T>(
    paths: &[PathBuf],
    options: &ReadOptions,
    new: impl FnOnce(&Shape) -> T,
    add: impl FnMut(&mut T, &RatingRow<'_>) -> Result<(), String>,
) -> Result<(Source, T), FileErrors> {
    let files::Listed { files, errors, warnings, .. } = files::files(paths)?;
    let opened: Vec<_> = files.par_iter().map(|path| Input::new(path, options)).collect();
    let (mut inputs, mut errors, mut failed) = (Vec::new(), errors, Vec::new());
    for (found, path) in opened.into_iter().zip(&files) {
        match found {
            Ok((file, found)) => {
                inputs.push(file);
                errors.extend(found);
            }
            Err(StoreError::FileErrors(FileErrors(found))) => errors.extend(found),
            Err(error) => failed.extend(error.errors(path)),
        }
    }
    FileErrors::none(failed)?;
    let (mut source, all) = read_inputs((inputs, &files), errors, options, new, add)?;
    source.warnings.splice(..0, warnings);
    Ok((source, all))
}

/// Reads a table in memory, as [`read`] does a file. An error in a row names the table and the row, counted from 0.
///
/// # Errors
/// The same errors as [`read`], or the columns differ in length.
pub fn read_columns<T>(
    name: &str,
    columns: Columns,
    options: &ReadOptions,
    new: impl FnOnce(&Shape) -> T,
    add: impl FnMut(&mut T, &RatingRow<'_>) -> Result<(), String>,
) -> Result<(Source, T), FileErrors> {
    columns.check(name)?;
    let header = Header::of(columns);
    let layout = layout(&header, options, false);
    let input = Input::plain(name.into(), header, layout);
    read_inputs((vec![input], &[PathBuf::from(name)]), Vec::new(), options, new, add)
}

/// Reads what was opened; `errors` are those found so far.
fn read_inputs<T>(
    (inputs, files): (Vec<Input>, &[PathBuf]),
    mut errors: Vec<FileError>,
    options: &ReadOptions,
    new: impl FnOnce(&Shape) -> T,
    mut add: impl FnMut(&mut T, &RatingRow<'_>) -> Result<(), String>,
) -> Result<(Source, T), FileErrors> {
    let (selection, found) = Selection::new(inputs, options);
    errors.extend(found);
    let Some(selection) = selection else {
        if errors.is_empty() {
            errors.push(FileError::whole(".", "no files were given; expected result files or folders".to_owned()));
        }
        return Err(in_order(errors, files));
    };
    let (mut tables, failed): (Vec<Rows>, Vec<FileError>) =
        selection.inputs.par_iter().partition_map(|input| match Rows::read(input) {
            Ok(rows) => Either::Left(rows),
            Err(error) => Either::Right(error),
        });
    FileErrors::none(failed)?;
    if tables.iter().map(|rows| rows.status.len()).sum::<usize>() > MAX_ROWS {
        let message = format!("there are more than {MAX_ROWS} rows; expected fewer, or a table of counts");
        return Err(FileErrors::whole(&selection.inputs[0].name, message));
    }
    let mut notes = about_names(&selection, options, &tables);
    notes.extend(selection.inputs.iter().zip(&tables).flat_map(|(input, rows)| how_read(input, rows)));
    notes.extend(unnamed(&selection, &tables));
    let mut sessions = sessions(&selection, &mut tables);
    let unfinished: Vec<bool> =
        sessions.iter().map(|session| options.complete_only && session.is_unfinished()).collect();
    let words = options.missing.as_ref().map_or(&[][..], |list| &list.0);
    let known = Known::new(&selection, &tables, words, unfinished);
    let mut all = new(&selection.shape);
    let (mut reports, mut contents) = (Vec::new(), HashMap::new());
    for (input, mut rows) in selection.inputs.iter().zip(tables) {
        let mut read = add_rows(&selection, &known, input, &mut rows, |row| add(&mut all, row));
        read.sha256.clone_from(&input.header.sha256);
        let may_repeat = input.layout != Layout::Results && selection.inputs.len() > 1;
        if let Some(hash) = read.sha256.clone().filter(|_| may_repeat)
            && let Some(other) = contents.insert(hash, &input.name)
        {
            let message = format!("has the same content as {other}; expected each rating once");
            notes.push(FileError::whole(&input.name, message));
        }
        errors.extend(rows.errors.finish(&input.name, &input.header.names));
        reports.push(read);
    }
    if reports.iter().all(|report| report.ratings == 0) {
        errors.push(no_row_counts(&reports));
        return Err(in_order(errors, files));
    }
    let errors = in_order(errors, files).0;
    let mut warnings = warnings(&selection.inputs)?;
    warnings.extend(gaps(&selection, &sessions, &reports));
    warnings.extend(notes.into_iter().chain(missing(&selection, &reports, words)));
    sessions.sort_by(|a, b| natural(&a.subject, &b.subject).then_with(|| natural(&a.session, &b.session)));
    let Selection { shape, protocol, definition_sha256, .. } = selection;
    let files = reports;
    Ok((Source { shape, protocol, definition_sha256, files, sessions, errors, warnings }, all))
}

/// Says which column has the participants, if it was not named, and which IDs and levels look alike.
fn about_names(selection: &Selection, options: &ReadOptions, tables: &[Rows]) -> Vec<FileError> {
    let Some(first) = selection.inputs.first() else { return Vec::new() };
    let mut notes = Vec::new();
    if options.subject.is_none() && !first.columns.of_results() {
        notes.extend(first.header.note_of_subject(&first.name, first.columns.subject));
    }
    notes.extend(about_ids(&first.name, &column_of(&selection.inputs, tables, |columns| columns.subject)));
    // Levels are those of the definition, if there is one.
    let factors = selection.shape.factors.iter().take(first.columns.factors.len()).enumerate();
    notes.extend(factors.filter(|_| selection.protocol.is_none()).filter_map(|(index, name)| {
        alike(&first.name, Some(name), &column_of(&selection.inputs, tables, |columns| columns.factors[index]))
    }));
    notes
}

/// Says which IDs of participants look alike, and which ones a spreadsheet has rounded, such as 5.1E+23.
pub(super) fn about_ids(file: &str, column: &[&Texts]) -> impl Iterator<Item = FileError> {
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit() || b".,".contains(&byte));
    let is_rounded = |id: &&str| id.split_once("E+").is_some_and(|(a, b)| is_digits(a) && is_digits(b));
    let rounded = column.iter().flat_map(|file| &file.texts).map(AsRef::as_ref).find(is_rounded).map(|id| {
        let message = format!("the ID {id} is a rounded number, and may stand for several; expected IDs as text");
        FileError::whole(file, message)
    });
    alike(file, None, column).into_iter().chain(rounded)
}

/// Says which IDs of participants, or levels of a factor, look alike in a column of all files.
pub(super) fn alike(file: &str, factor: Option<&str>, column: &[&Texts]) -> Option<FileError> {
    let (names, of, different, expected) = match factor {
        None => ("IDs", String::new(), "participants", "ID for each participant"),
        Some(name) => ("levels", format!(" of {name}"), "levels", "form of each level"),
    };
    let all = column.iter().flat_map(|file| &file.texts).map(AsRef::as_ref);
    let alike = rows::alike(all.filter(|text| !rows::is_missing(text, true)));
    let groups: Vec<String> = alike.iter().take(6).map(|group| group.join(", ")).collect();
    let others = if alike.len() > groups.len() { " and others" } else { "" };
    let message = format!(
        "the {names} {}{others}{of} differ only in capitals or in the form of a number, and are different {different}; expected one {expected}",
        groups.join("; ")
    );
    (!groups.is_empty()).then(|| FileError::whole(file, message))
}

/// Returns a warning for each kind of missing value that leaves out rows; for each factor of which some ratings have no
/// value, unless it was guessed and may be about other rows; and if ratings without a response time are kept although the
/// time was limited.
fn missing(selection: &Selection, reports: &[FileRead], named: &[String]) -> Vec<FileError> {
    let sum = |of: &dyn Fn(&FileRead) -> u64| reports.iter().map(of).sum::<u64>();
    let rows = format!("{} rows", sum(&|report| report.rows));
    let ratings = format!("{} ratings", sum(&|report| report.ratings));
    // The warning is about the first file with such rows.
    let lacking = |of: &dyn Fn(&FileRead) -> u64, all: &str, what: &str, fate: &str| {
        let (first, found) = (reports.iter().find(|report| of(report) > 0)?, sum(of));
        let [have, are] = if found == 1 { ["has", "is"] } else { ["have", "are"] };
        let fate = if fate.is_empty() { String::new() } else { format!(" and {are} {fate}") };
        let message = format!("{found} of {all} {have} no {what}{fate}; expected one in every row");
        Some(FileError::whole(&first.path, message))
    };
    let (mut warnings, Shape { factors, guessed, time_limits, .. }) = (Vec::new(), &selection.shape);
    let named: String = named.iter().map(|text| format!("{text}, ")).collect();
    for (why, what) in [(Reason::NoResponse, "response"), (Reason::NoParticipant, "participant")] {
        let of = |report: &FileRead| report.left_out.get(&why).map_or(0, |people| people.values().sum());
        let what = format!("{what} (an empty cell, NA, {named}or another text for a missing value)");
        warnings.extend(lacking(&of, &rows, &what, "left out"));
    }
    for (at, name) in factors.iter().enumerate().filter(|_| !guessed) {
        warnings.extend(lacking(&|report| report.without_level[at], &ratings, &format!("value of {name}"), ""));
    }
    if *time_limits != (None, None) {
        warnings.extend(lacking(&|report| report.without_time, &ratings, "response time", "kept"));
    }
    warnings
}

/// Says how many rows are practice or later attempts according to columns that no option names. In a table from elsewhere,
/// the columns may mean something else, so these rows count.
fn unnamed(selection: &Selection, tables: &[Rows]) -> Vec<FileError> {
    type Kind = (fn(&str) -> bool, &'static str, &'static str);
    const KINDS: [Kind; 2] = [
        (
            |text| text.eq_ignore_ascii_case("practice"),
            "are practice",
            "this column among the factors, with only its other levels",
        ),
        (
            |text| rows::number(text).is_some_and(|attempt| attempt > 1.0),
            "are later attempts",
            "one row for each trial, or the columns subject_id, session_id, phase, trial and attempt, by which only the last \
             attempt counts",
        ),
    ];
    let mut warnings = Vec::new();
    for (which, (is, what, expected)) in KINDS.into_iter().enumerate() {
        let (mut first, mut found, mut all) = (None, 0, 0);
        for (input, rows) in selection.inputs.iter().zip(tables) {
            let Some(column) = input.columns.unnamed[which] else { continue };
            let here = rows.columns[column].map(is).iter().filter(|is| **is).count();
            (found, all) = (found + here, all + rows.status.len());
            first = first.or((here > 0).then_some((input, column)));
        }
        warnings.extend(first.map(|(input, column)| {
            let name = &input.header.names[column];
            let where_to = format!("according to the column {name}, which no option names, and count as ratings");
            input.error(column, format!("{found} of {all} rows {what} {where_to}; expected {expected}"))
        }));
    }
    warnings
}

/// Says how a file was read if it is not plain text in UTF-8, or that its session did not end.
pub(super) fn how_read(input: &Input, rows: &Rows) -> impl Iterator<Item = FileError> {
    let sheet = input.header.text.note.as_ref().map(|note| note.join("; "));
    let foreign = rows.foreign.map(|place| {
        let message = "is not UTF-8 text and was read as Windows-1252; expected UTF-8";
        FileError::at(&input.name, place, message)
    });
    let interrupted = rows.interrupted.map(|line| FileError::whole(&input.name, interrupted(line)));
    sheet.map(|note| FileError::whole(&input.name, note)).into_iter().chain(foreign).chain(interrupted)
}

/// Returns the warnings about files that are read anyway: changed files, sessions without a sidecar, and tables of counts.
///
/// # Errors
/// A folder cannot be accessed.
fn warnings(inputs: &[Input]) -> Result<Vec<FileError>, FileErrors> {
    let mut warnings = Vec::new();
    for input in inputs {
        warnings.extend(input.changed.iter().cloned());
        if input.columns.of_results()
            && !input.has_sidecar
            && !input.in_memory()
            && dataset::described(&input.path).map_err(|error| FileErrors(error.errors(&input.path)))?.is_some()
        {
            let message =
                "has no sidecar, so nothing shows whether it was changed; expected the sidecar that belongs to it";
            warnings.push(FileError::whole(&input.path, message));
        }
    }
    let counts = inputs.iter().find(|input| input.layout == Layout::Counts);
    warnings.extend(counts.map(|first| {
        let message = "is a table of counts, so it is not known whether ratings are simulated, or when and in which order they \
                       were given; expected the result files for test–retest agreement, response times, sessions, and the \
                       prediction of the vision model";
        FileError::whole(&first.path, message)
    }));
    Ok(warnings)
}

/// Returns a warning for each session of which rows are missing between others. An adaptive method leaves out trials, and
/// rows with errors are reported as such.
fn gaps(selection: &Selection, sessions: &[SessionRead], reports: &[FileRead]) -> Vec<FileError> {
    let is_planned = |protocol: &Protocol| protocol.adaptive.is_none() && protocol.task.ranking().is_none();
    if !selection.protocol.as_ref().is_some_and(is_planned) {
        return Vec::new();
    }
    let with_errors: HashSet<&PathBuf> =
        reports.iter().filter(|report| report.erroneous > 0).map(|report| &report.path).collect();
    let is_unexplained = |session: &&SessionRead| {
        let is_whole = session.sidecar.as_ref().is_some_and(|sidecar| !sidecar.is_repaired());
        session.skipped > 0 && is_whole && !with_errors.contains(&session.path)
    };
    let warning = |session: &SessionRead| {
        let message = format!(
            "main trials without a row, although later trials have one: {}; expected a row for every trial before the last",
            session.skipped
        );
        FileError::whole(&session.path, message)
    };
    sessions.iter().filter(is_unexplained).map(warning).collect()
}

/// Returns the sessions of all result files, and determines how the rows of these files are used.
fn sessions(selection: &Selection, tables: &mut [Rows]) -> Vec<SessionRead> {
    let (mut sessions, mut attempts, mut index) = (Vec::new(), Vec::new(), HashMap::new());
    let mut enter = |subject: &str, session: &str, input: &Input| {
        *index.entry((subject.to_owned(), session.to_owned())).or_insert_with(|| {
            sessions.push(SessionRead {
                subject: subject.to_owned(),
                session: session.to_owned(),
                path: input.path.clone(),
                planned: input.protocol.as_ref().map(|protocol| protocol.main_trials() as u64),
                rated: 0,
                skipped: 0,
                sidecar: input.sidecar.clone(),
            });
            sessions.len() as u32 - 1
        })
    };
    for (file, (input, rows)) in (0..).zip(selection.inputs.iter().zip(&mut *tables)) {
        let (mut wrong, mut errors) = (Vec::new(), std::mem::take(&mut rows.errors));
        read_attempts(selection, input, rows, |row, attempt| match attempt {
            Ok((subject, session, attempt)) => {
                attempts.push(Attempt { session: enter(subject, session, input), file, row: row as u32, ..attempt });
            }
            Err(error) => {
                wrong.push(row);
                rows.report(&mut errors, error, input, &selection.inputs);
            }
        });
        wrong.iter().for_each(|row| rows.status[*row] = Status::Wrong);
        rows.errors = errors;
    }
    for input in selection.inputs.iter().filter(|input| input.columns.of_results() && input.header.first.is_none()) {
        if let Ok(identity) = dataset::identity(&input.path) {
            enter(identity.subject(), identity.session(), input);
        }
    }
    decide(attempts, &mut sessions, tables);
    sessions
}

/// Calls `take` with every readable row of a result file: its participant, session and trial, or the first error. Other files
/// have no such rows.
fn read_attempts<'a>(
    selection: &Selection,
    input: &Input,
    rows: &'a Rows,
    mut take: impl FnMut(usize, Result<(&'a str, &'a str, Attempt), RowError>),
) {
    let columns = &input.columns;
    let (Some(session), Some(phase), Some(number)) = (columns.session, columns.phase, columns.trial) else { return };
    let texts = |column: usize| &rows.columns[column];
    let experiment = columns.experiment.zip(selection.experiment.as_deref());
    let needed = |column: usize, of: fn(&str) -> Option<u32>, expected: &'static str| {
        let values = texts(column).map(of);
        move |row: usize| values.get(row).ok_or_else(|| RowError::new(row, column, expected))
    };
    let is_main = |text: &str| Some(u32::from(text.parse::<Phase>().ok()? == Phase::Main));
    let is_main = needed(phase, is_main, "practice or main");
    let trial = needed(number, rows::ordinal, "the number of a trial, from 1 to 1,000,000");
    let expected = "the number of an attempt, from 1 to 1,000,000";
    let attempt = columns.attempt.map(|column| needed(column, rows::ordinal, expected));
    let rated = texts(columns.responses[0]).map(|text| rows::is_rating(text, selection.own_scale, false));
    let one = |row: usize| {
        let present = |column: usize, expected: &'static str| match texts(column).get(row) {
            "" => Err(RowError::new(row, column, expected)),
            text => Ok(text),
        };
        if let Some((column, expected)) = experiment
            && texts(column).get(row) != expected
        {
            return Err(RowError::new(row, column, format!("{expected}, as in the first row")));
        }
        let (is_main, trial) = (is_main(row)? == 1, trial(row)?);
        let attempt = attempt.as_ref().map_or(Ok(1), |attempt| attempt(row))?;
        let subject = present(columns.subject, "a participant")?;
        let session = present(session, "a session")?;
        let rated = *rated.get(row);
        Ok((subject, session, Attempt { session: 0, is_main, trial, attempt, file: 0, row: 0, rated }))
    };
    (0..rows.status.len()).filter(|row| rows.status[*row] != Status::Wrong).for_each(|row| take(row, one(row)));
}

/// A row of a result file: an attempt at a trial. The order is that of the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Attempt {
    /// Index of the session.
    session: u32,
    is_main: bool,
    trial: u32,
    attempt: u32,
    /// Index of the file.
    file: u32,
    /// Index of the row in the file.
    row: u32,
    rated: bool,
}

/// Sets how these rows are used, and counts the trials of the sessions.
fn decide(mut attempts: Vec<Attempt>, sessions: &mut [SessionRead], files: &mut [Rows]) {
    attempts.sort_unstable();
    let trial = |row: &Attempt| (row.session, row.is_main, row.trial);
    let mut furthest = (u32::MAX, 0);
    for same_trial in attempts.chunk_by(|a, b| trial(a) == trial(b)) {
        let last = same_trial.last().map(|row| row.attempt);
        let Attempt { session, is_main, trial, .. } = same_trial[0];
        if is_main {
            let before = if furthest.0 == session { furthest.1 } else { 0 };
            sessions[session as usize].skipped += u64::from(trial - before - 1);
            furthest = (session, trial);
        }
        for same in same_trial.chunk_by(|a, b| a.attempt == b.attempt) {
            let (first, session) = (same[0], &mut sessions[same[0].session as usize]);
            let mut set = |row: &Attempt, status| files[row.file as usize].status[row.row as usize] = status;
            same[1..].iter().for_each(|row| set(row, Status::Repeated(first.file)));
            if !first.is_main {
                set(&first, Status::Practice);
            } else if Some(first.attempt) < last {
                set(&first, Status::Superseded);
            } else {
                set(&first, Status::Counts(first.session));
                session.rated += u64::from(first.rated);
            }
        }
    }
}

/// Returns the error that no row counts, with the reasons.
fn no_row_counts(reports: &[FileRead]) -> FileError {
    let sum = |of: fn(&FileRead) -> u64| reports.iter().map(of).sum::<u64>();
    let of = |reason: &Reason| {
        reports.iter().filter_map(|report| report.left_out.get(reason)).flatten().map(|(_, n)| n).sum()
    };
    let reasons: Vec<_> = Reason::ALL.iter().map(|reason| (of(reason), reason.to_string())).collect();
    let parts = [
        (sum(|report| report.practice), "from practice".to_owned()),
        (sum(|report| report.superseded), "superseded".to_owned()),
        (sum(|report| report.erroneous), "with errors".to_owned()),
    ];
    let parts = parts.iter().chain(&reasons).filter(|(n, _)| *n > 0);
    let parts: Vec<String> = parts.map(|(n, what)| format!("{n} {what}")).collect();
    let found = match sum(|report| report.rows) {
        0 => "there are no rows".to_owned(),
        rows if parts.is_empty() => format!("the rows ({rows}) have counts of 0"),
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
