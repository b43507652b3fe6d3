//! The steps of reading: find the files, look at their heads, choose what belongs together, find out which rows count,
//! hand these on.

use std::{
    collections::{HashMap, HashSet},
    io::Read as _,
    path::{Path, PathBuf},
};

use rayon::prelude::*;
use sha2::{Digest as _, Sha256};

use super::{
    super::hash::hexadecimal,
    FileFault, Layout, Reading, SessionRead, Shape, Sink, Source,
    discovery::{self, natural, whole},
    emit::{Emitter, Rules, Tally, is_rating},
    faults::Place,
    header::count_lines,
    identity::Identity,
    ledger::{Doubt, Ledger, Said},
    plan::{Input, Plan},
    record::Record,
    source::{self, Segment, Stop},
    survey::Surveyed,
};
use crate::store::FileFaults;

/// Largest file whose hash is reported, bytes.
const HASHED: u64 = 64 << 20;
/// Least work for a thread, bytes: below it, more sinks cost more than more threads gain.
const LEAST_TASK: u64 = 1 << 20;

/// See [`super::read`].
pub(super) fn read<S: Sink>(
    paths: &[PathBuf],
    how: &Reading,
    new: impl Fn(&Shape) -> S + Sync,
) -> Result<(Source, S), FileFaults> {
    let (files, mut faults) = discovery::files(paths);
    let looked_at: Vec<_> = files.par_iter().map(|path| Surveyed::new(path, how)).collect();
    let mut surveyed = Vec::new();
    for found in looked_at {
        match found {
            Ok((file, found)) => {
                surveyed.push(file);
                faults.extend(found);
            }
            Err(fault) => faults.push(fault),
        }
    }
    let (plan, found) = Plan::new(surveyed, how);
    faults.extend(found);
    let Some(plan) = plan else {
        if faults.is_empty() {
            faults.push(whole(Path::new("."), "no files are named; expected result files or folders".to_owned()));
        }
        return Err(in_order(faults, &files));
    };
    let mut reading = Files { plan: &plan, odd: vec![false; plan.inputs.len()], ledger: Ledger::default() };
    reading.find_out();
    let unfinished = if how.complete_only { reading.unfinished() } else { HashSet::new() };
    let (tallies, sink) = reading.emit(&unfinished, new)?;
    let hashes: Vec<_> = plan.inputs.par_iter().map(sha256).collect();
    let mut reports = Vec::new();
    for ((input, tally), hash) in plan.inputs.iter().zip(tallies).zip(hashes) {
        reports.push(tally.0.report(input, hash));
        faults.extend(file_faults(&plan, input, tally));
    }
    if reports.iter().all(|report| report.ratings == 0) {
        faults.push(nothing(&reports));
        return Err(in_order(faults, &files));
    }
    let sessions = reading.sessions();
    let faults = in_order(faults, &files).0;
    let Plan { shape, protocol, definition_sha256, .. } = plan;
    Ok((Source { shape, protocol, definition_sha256, files: reports, sessions, faults }, sink))
}

/// Result files whose rows are being sorted out.
struct Files<'a> {
    plan: &'a Plan,
    /// Which files only the plain reader knows.
    odd: Vec<bool>,
    ledger: Ledger,
}

/// What became of a part of a file.
struct Part {
    file: usize,
    lines: u64,
    tally: Tally,
    stop: Option<Stop>,
}

/// What became of a file, and why it was not read to its end.
type FileTally = (Tally, Option<std::io::Error>);

impl Files<'_> {
    /// The work, and whether it is that of result files.
    fn tasks(&self) -> Vec<Vec<Segment>> {
        source::tasks(&self.plan.inputs.iter().collect::<Vec<_>>(), &self.odd, LEAST_TASK)
    }

    /// Goes through the rows of all result files, in parts. A file that the fast reader does not know is gone through
    /// once more, with all others.
    fn go<T: Send>(
        &mut self,
        new: impl Fn() -> T + Sync,
        note: impl Fn(&mut T, &Identity<'_>, &Seen<'_>) + Sync,
    ) -> Vec<T> {
        loop {
            let (plan, odd) = (self.plan, &self.odd);
            let done: Vec<(T, Vec<usize>)> = (self.tasks().par_iter())
                .map(|task| {
                    let mut noted = new();
                    let mut found_odd = Vec::new();
                    for Segment { file, bytes } in task {
                        let input = &plan.inputs[*file];
                        let Some(own) = input.columns.record else { continue };
                        let took = source::each(input, bytes, odd[*file], |record| {
                            let Some(cells) = record.cells.filter(|cells| cells.len() == input.header.names.len())
                            else {
                                return;
                            };
                            let experiment = plan.experiment.as_deref();
                            if let Ok(row) = Identity::new(&cells, input.columns.subject, &own, experiment) {
                                note(&mut noted, &row, &Seen { input, file: *file, record, cells });
                            }
                        });
                        // What cannot be read is a fault when the rows are handed on.
                        if matches!(took, Err(Stop::Odd)) {
                            found_odd.push(*file);
                        }
                    }
                    (noted, found_odd)
                })
                .collect();
            let found_odd: Vec<usize> = done.iter().flat_map(|(_, odd)| odd.iter().copied()).collect();
            if found_odd.is_empty() {
                return done.into_iter().map(|(noted, _)| noted).collect();
            }
            found_odd.into_iter().for_each(|file| self.odd[file] = true);
        }
    }

    /// Finds out which rows of result files count.
    fn find_out(&mut self) {
        if self.plan.inputs.iter().all(|input| input.layout != Layout::Results) {
            return;
        }
        let scale = self.plan.own_scale;
        let like = Ledger::default();
        let ledgers =
            self.go(|| Ledger::like(&like), |ledger, row, seen| ledger.note(row, &seen.said(scale), seen.file));
        self.ledger = Ledger::like(&like);
        ledgers.into_iter().for_each(|ledger| self.ledger.absorb(ledger));
        if self.ledger.has_doubts() {
            let ledger = std::mem::take(&mut self.ledger);
            let firsts = self.go(HashMap::<Doubt, Place>::new, |firsts, row, seen| {
                let place = Place { file: seen.file as u32, offset: seen.record.offset };
                ledger.place(row, seen.row_id(), place, firsts);
            });
            self.ledger = ledger;
            firsts.into_iter().for_each(|firsts| self.ledger.settle(firsts));
        }
    }

    /// Indices of the sessions in which planned trials are not rated.
    fn unfinished(&self) -> HashSet<usize> {
        (self.ledger.sessions.iter().enumerate())
            .filter(|(_, session)| self.plan.inputs[session.file].planned.is_some_and(|n| session.rated() < n))
            .map(|(index, _)| index)
            .collect()
    }

    /// Hands on the rows that count.
    fn emit<S: Sink>(
        &mut self,
        unfinished: &HashSet<usize>,
        new: impl Fn(&Shape) -> S + Sync,
    ) -> Result<(Vec<FileTally>, S), FileFaults> {
        let plan = self.plan;
        loop {
            let rules = Rules {
                experiment: plan.experiment.as_deref(),
                ledger: &self.ledger,
                unfinished,
                scale: plan.own_scale,
            };
            let done: Vec<(S, Vec<Part>)> = (self.tasks().par_iter())
                .map(|task| {
                    let mut sink = new(&plan.shape);
                    let parts =
                        task.iter().map(|segment| emit_part(plan, &rules, segment, self.odd[segment.file], &mut sink));
                    let parts = parts.collect();
                    (sink, parts)
                })
                .collect();
            let odd: Vec<usize> = (done.iter().flat_map(|(_, parts)| parts))
                .filter(|part| matches!(part.stop, Some(Stop::Odd)))
                .map(|part| part.file)
                .collect();
            if !odd.is_empty() {
                odd.into_iter().for_each(|file| self.odd[file] = true);
                continue;
            }
            let mut tallies: Vec<(FileTally, u64)> = plan.inputs.iter().map(|_| Default::default()).collect();
            let mut joined: Option<S> = None;
            for (sink, parts) in done {
                let name = parts.first().map_or(".", |part| &plan.inputs[part.file].name);
                match &mut joined {
                    Some(joined) => joined.absorb(sink).map_err(|error| FileFaults::whole(name, error))?,
                    None => joined = Some(sink),
                }
                for part in parts {
                    let ((tally, error), lines) = &mut tallies[part.file];
                    tally.append(part.tally, *lines);
                    *lines += part.lines;
                    if let Some(Stop::Io(stopped)) = part.stop {
                        *error = Some(stopped);
                    }
                }
            }
            let tallies = tallies.into_iter().map(|(tally, _)| tally).collect();
            return Ok((tallies, joined.unwrap_or_else(|| new(&plan.shape))));
        }
    }

    /// The sessions of all result files, those without rows too.
    fn sessions(&self) -> Vec<SessionRead> {
        let inputs = &self.plan.inputs;
        let of = |subject: &str, session: &str, file: usize| SessionRead {
            subject: subject.to_owned(),
            session: session.to_owned(),
            path: inputs[file].path.clone(),
            planned: inputs[file].planned,
            rated: 0,
            dropped: None,
            sidecar: inputs[file].sidecar.clone(),
        };
        let found = self.ledger.sessions.iter().map(|session| SessionRead {
            rated: session.rated(),
            dropped: session.measured.then(|| session.dropped()),
            ..of(&session.subject, &session.session, session.file)
        });
        let mut sessions: Vec<SessionRead> = found.collect();
        for (file, input) in inputs.iter().enumerate().filter(|(_, input)| input.header.first.is_none()) {
            if let Some((subject, session)) = named_session(&input.path).filter(|_| input.columns.record.is_some())
                && self.ledger.find(subject, session).is_none()
            {
                sessions.push(of(subject, session, file));
            }
        }
        sessions.sort_by(|a, b| natural(&a.subject, &b.subject).then_with(|| natural(&a.session, &b.session)));
        sessions
    }
}

/// A row of a result file, where it was seen.
struct Seen<'a> {
    input: &'a Input,
    file: usize,
    record: &'a Record<'a>,
    cells: super::record::Cells<'a>,
}

impl<'a> Seen<'a> {
    fn own(&self, column: impl Fn(&super::plan::RecordColumns) -> Option<usize>) -> &'a str {
        self.input.columns.record.as_ref().and_then(column).map_or("", |column| self.cells.get(column))
    }

    fn row_id(&self) -> &'a str {
        self.own(|own| own.row_id)
    }

    fn said(&self, scale: bool) -> Said<'a> {
        let dropped = self.own(|own| own.dropped);
        Said {
            row_id: self.row_id(),
            rated: is_rating(self.cells.get(self.input.columns.response), scale),
            dropped: (!dropped.is_empty()).then_some(dropped != "0"),
        }
    }
}

fn emit_part<S: Sink>(plan: &Plan, rules: &Rules<'_>, segment: &Segment, odd: bool, sink: &mut S) -> Part {
    let Segment { file, bytes } = segment;
    let input = &plan.inputs[*file];
    let mut emitter = Emitter { input, file: *file, rules, sink, tally: Tally::default() };
    let took = source::each(input, bytes, odd, |record| emitter.take(record));
    let (lines, stop) = match took {
        Ok(lines) => (lines, None),
        Err(stop) => (0, Some(stop)),
    };
    // The lines of the header are above the first part.
    let above = if bytes.start == input.header.end { input.header.lines } else { 0 };
    let mut tally = Tally::default();
    tally.append(emitter.tally, above);
    Part { file: *file, lines: lines + above, tally, stop }
}

/// Participant and session in the name of a data file.
fn named_session(path: &Path) -> Option<(&str, &str)> {
    let rest = path.file_name()?.to_str()?.strip_prefix("subject-")?;
    let (subject, rest) = rest.split_once("_session-")?;
    Some((subject, rest.split('_').next()?))
}

/// What is wrong with a file's rows.
fn file_faults(plan: &Plan, input: &Input, tally: FileTally) -> Vec<FileFault> {
    let (Tally { rows, elsewhere, copied, mut faults, .. }, error) = tally;
    let mut found = Vec::new();
    if let Some(error) = error {
        found.push(whole(&input.path, format!("cannot be read to its end: {error}; expected a readable file")));
    }
    if let Some(first) = copied.filter(|_| elsewhere == rows) {
        faults.without_repeated();
        let other = &plan.inputs[first.file as usize].name;
        let message =
            format!("all its {rows} rows stand in {other} already; expected every session once (it is left out)");
        found.push(whole(&input.path, message));
    }
    found.extend(faults.finish(&input.name, |place| {
        let input = &plan.inputs[place.file as usize];
        format!("{}:{}", input.name, line_of(input, place.offset))
    }));
    found
}

/// The line, from 1, that begins at a place of a file.
fn line_of(input: &Input, offset: u64) -> u64 {
    let Ok(reader) = source::open(input, 0) else { return 0 };
    let mut reader = reader.take(offset);
    let mut block = vec![0; 1 << 16];
    let mut lines = 0;
    while let Ok(n @ 1..) = reader.read(&mut block) {
        lines += count_lines(&block[..n]);
        // The `\r` of a `\r\n` that the blocks divide was counted by itself.
        if block[n - 1] == b'\r' {
            lines -= 1;
        }
    }
    lines + 1
}

fn sha256(input: &Input) -> Option<String> {
    if input.header.size > HASHED {
        return None;
    }
    let mut reader = source::open(input, 0).ok()?;
    let mut hash = Sha256::new();
    let mut block = vec![0; 1 << 16];
    loop {
        match reader.read(&mut block) {
            Ok(0) => return Some(hexadecimal(&hash.finalize())),
            Ok(n) => hash.update(&block[..n]),
            Err(_) => return None,
        }
    }
}

/// That no row counts, and why.
fn nothing(reports: &[super::FileRead]) -> FileFault {
    let sum = |of: fn(&super::FileRead) -> u64| reports.iter().map(of).sum::<u64>();
    let parts: Vec<String> = [
        (sum(|report| report.practice), "of practice"),
        (sum(|report| report.superseded), "superseded"),
        (sum(|report| report.unfinished), "of unfinished sessions"),
        (sum(|report| report.faulty), "with faults"),
    ]
    .iter()
    .filter(|(n, _)| *n > 0)
    .map(|(n, what)| format!("{n} {what}"))
    .collect();
    let rows = sum(|report| report.rows);
    let found = match (rows, parts.is_empty()) {
        (0, _) => "there are no rows".to_owned(),
        (_, true) => format!("none of the {rows} rows counts"),
        (_, false) => format!("none of the {rows} rows counts: {}", parts.join(", ")),
    };
    let path = reports.first().map_or(Path::new("."), |report| &report.path);
    let (others, n) = (reports.len() - 1, reports.len());
    let among = if others > 0 { format!(" in {n} files") } else { String::new() };
    whole(path, format!("{found}{among}; expected ratings of main trials"))
}

/// Faults in the order of the files; those of folders first.
fn in_order(mut faults: Vec<FileFault>, files: &[PathBuf]) -> FileFaults {
    // A sidecar is where its file is.
    let index: HashMap<PathBuf, usize> =
        files.iter().enumerate().map(|(i, path)| (path.with_extension(""), i)).collect();
    faults.sort_by_key(|fault| index.get(&Path::new(&fault.file).with_extension("")).map_or(0, |i| i + 1));
    FileFaults(faults)
}
