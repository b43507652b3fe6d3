//! Runs a thousand sessions, in each of which calls to the disk or the clock fail.

use std::{
    collections::HashMap,
    fs,
    path::{Path, PathBuf},
    sync::Mutex,
};

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};
use rayon::prelude::*;

use crate::{
    disk,
    run::{self, DEFINITIONS, Report},
    shim::{self, Fault, Hit, Log},
};

/// How each call can fail. Frequent calls are listed twice, so that they are drawn more often.
const KINDS: &[(&str, &[&str])] = &[
    ("open", &["EIO", "EMFILE", "EACCES", "EROFS", "EINTR", "kill-before", "kill-after"]),
    ("read", &["EIO", "EINTR", "short", "end"]),
    ("write", &["EIO", "ENOSPC", "EINTR", "short", "lie", "torn", "kill-before", "kill-after", "kill-torn"]),
    ("write", &["EIO", "ENOSPC", "EROFS", "lie", "torn", "kill-before", "kill-after", "kill-torn"]),
    ("sync", &["EIO", "ENOSPC", "EINTR", "kill-before", "kill-after"]),
    ("sync", &["EIO", "ENOSPC", "kill-before", "kill-after"]),
    ("rename", &["EIO", "ENOSPC", "EACCES", "EROFS", "kill-before", "kill-after"]),
    ("truncate", &["EIO", "EROFS", "EINTR", "kill-before", "kill-after"]),
    ("seek", &["EIO"]),
    ("stat", &["EIO", "EACCES", "kill-before"]),
    ("unlink", &["EIO", "EROFS", "kill-before", "kill-after"]),
    ("mkdir", &["ENOSPC", "EROFS", "EACCES", "kill-before", "kill-after"]),
    ("lock", &["EIO", "kill-after"]),
    ("list", &["EIO", "EACCES", "EMFILE", "kill-after"]),
    ("close", &["EIO", "kill-before"]),
    ("thread", &["EAGAIN"]),
    ("alloc", &["ENOMEM"]),
    ("clock", &["back"]),
];

/// The state of a session before the faults.
#[derive(Clone, Debug)]
struct Before {
    /// Rows from an earlier sitting; `None` for a new session.
    rows: Option<usize>,
    /// Number of bytes missing at the end of the last row.
    torn: usize,
    /// Whether the sidecar of a session without rows is missing.
    sidecar_lost: bool,
    /// Whether a killed program left a half-written file.
    leftover: bool,
}

/// One session with its faults.
#[derive(Clone, Debug)]
struct Case {
    /// The faults of the first attempt to resume; none in most cases.
    again: Vec<Fault>,
    definition: usize,
    before: Before,
    /// Whether to run `machband simulate` instead of the child, which reports every row.
    binary: bool,
    faults: Vec<Fault>,
}

/// A run without faults: its definition, the rows that it resumes from, and whether it is `machband simulate`.
type Undisturbed = (usize, Option<usize>, bool);

/// What all cases share.
pub struct Sweep {
    folder: tempfile::TempDir,
    seed: u64,
    /// The rows that each definition plans.
    planned: Vec<Vec<Vec<String>>>,
    /// The number of calls of each kind in runs without faults.
    calls: Mutex<HashMap<Undisturbed, Vec<(String, u64)>>>,
}

/// A temporary folder, in memory if possible, because the speed of the disk is not tested.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap()
}

fn pick<T: Clone>(rng: &mut ChaCha8Rng, from: &[T]) -> T {
    from[rng.next_u64() as usize % from.len()].clone()
}

fn one_in(rng: &mut ChaCha8Rng, n: u64) -> bool {
    rng.next_u64().is_multiple_of(n)
}

/// Draws one to three faults of calls that a program makes; `binary` is false for the child.
fn draw(rng: &mut ChaCha8Rng, calls: &[(String, u64)], binary: bool) -> Vec<Fault> {
    let count = pick(rng, &[1, 1, 1, 2, 3]);
    let fault = |_| {
        let (op, whats, count) = loop {
            let (op, whats) = pick(rng, KINDS);
            let count = calls.iter().find(|(name, _)| name == op).map_or(0, |(_, count)| *count);
            // The child's threads belong to the test harness.
            if count > 0 && (binary || op != "thread") {
                break (op, whats, count);
            }
        };
        let what = pick(rng, whats);
        let once = what.starts_with("kill") || ["EINTR", "short", "end", "back", "ENOMEM"].contains(&what);
        Fault { op, n: 1 + rng.next_u64() % count, what, repeated: one_in(rng, 4) && !once }
    };
    (0..count).map(fault).collect()
}

impl Sweep {
    /// `None` if no faults can be injected.
    pub fn injecting(seed: u64) -> Option<Self> {
        shim::library().map(|_| Self::new(seed))
    }

    pub fn new(seed: u64) -> Self {
        let folder = folder();
        let mut sweep = Self { folder, seed, planned: Vec::new(), calls: Mutex::default() };
        for (i, text) in DEFINITIONS.iter().enumerate() {
            fs::write(sweep.definition(i), text).unwrap();
            let results = sweep.folder.path().join("planned");
            let ended = run::ended(&mut run::binary(&sweep.definition(i), &results, false));
            assert!(ended.status.success(), "{ended:?}");
            let rows = disk::rows(&disk::paths(&results, i).csv, i).unwrap();
            sweep.planned.push(rows.iter().map(disk::planned).collect());
        }
        sweep
    }

    /// The path of a definition's file.
    pub fn definition(&self, index: usize) -> PathBuf {
        self.folder.path().join(format!("definition{index}.toml"))
    }

    /// The rows that a definition plans.
    pub fn planned(&self, definition: usize) -> &[Vec<String>] {
        &self.planned[definition]
    }

    /// Runs this many cases, several at a time; returns the number of faults that took effect, and every failure.
    pub fn run(&self, cases: usize) -> (usize, Vec<String>) {
        let found: Vec<_> = (0..cases).into_par_iter().map(|number| self.run_case(number)).collect();
        (found.iter().map(|(struck, _)| struck).sum(), found.into_iter().flat_map(|(_, wrong)| wrong).collect())
    }

    /// The case with this number. The same seed always gives the same case.
    fn case(&self, number: usize) -> Case {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(number as u64);
        let rng = &mut rng;
        let definition = pick(rng, &[0, 0, 1, 1, 2, 3, 3]);
        let rows = pick(rng, &[None, None, Some(0), Some(2), Some(4)]).filter(|rows| *rows < 4 || definition != 2);
        let rows = rows.map(|rows| rows.min(self.planned[definition].len() - 1));
        let before = Before {
            rows,
            torn: if one_in(rng, 3) { 1 + rng.next_u64() as usize % 40 } else { 0 },
            sidecar_lost: one_in(rng, 5) && rows == Some(0),
            leftover: one_in(rng, 3),
        };
        let binary = one_in(rng, 3);
        let calls = self.calls(definition, rows, binary);
        let faults = draw(rng, &calls, binary);
        // A second fault, during the recovery from the first.
        let again =
            if one_in(rng, 3) { draw(rng, &self.calls(definition, rows.or(Some(0)), true), true) } else { Vec::new() };
        Case { again, definition, before, binary, faults }
    }

    /// How often each call is made in a run without faults.
    pub fn calls(&self, definition: usize, rows: Option<usize>, binary: bool) -> Vec<(String, u64)> {
        if let Some(known) = self.calls.lock().unwrap().get(&(definition, rows, binary)) {
            return known.clone();
        }
        let before = Before { rows, torn: 0, sidecar_lost: false, leftover: true };
        let case = Case { again: Vec::new(), definition, before, binary, faults: Vec::new() };
        let folder = folder();
        self.prepare(&case, folder.path());
        let (ended, log) = self.disturbed(&case, folder.path());
        assert!(ended.status.success(), "{ended:?}");
        self.calls.lock().unwrap().insert((definition, rows, binary), log.counts.clone());
        log.counts
    }

    /// Prepares the files of an earlier sitting; returns the rows that count as saved.
    fn prepare(&self, case: &Case, folder: &Path) -> Vec<String> {
        let results = folder.join("first");
        let Some(rows) = case.before.rows else { return Vec::new() };
        let mut lines = run::interrupted(case.definition, &results, rows);
        let paths = disk::paths(&results, case.definition);
        if case.before.torn > 0 && rows > 0 {
            let whole = fs::read(&paths.csv).unwrap();
            fs::write(&paths.csv, &whole[..whole.len() - case.before.torn]).unwrap();
            lines.pop();
        }
        if case.before.sidecar_lost {
            fs::remove_file(&paths.sidecar).unwrap();
        }
        if case.before.leftover {
            let name =
                format!("{}.machband-a1b2C3d4E5f6G7h8.tmp", paths.sidecar.file_name().unwrap().to_str().unwrap());
            fs::write(paths.sidecar.with_file_name(name), "{").unwrap();
        }
        lines
    }

    /// Runs the session with its faults.
    fn disturbed(&self, case: &Case, folder: &Path) -> (run::ProgramResult, Log) {
        let (first, second) = (folder.join("first"), folder.join("second"));
        let resume = case.before.rows.is_some();
        let mut command = if case.binary {
            run::binary(&self.definition(case.definition), &first, resume)
        } else {
            run::child(case.definition, &first, &second, resume)
        };
        // A repeated fault affects only the first folder, so that the session can move to the second; other faults
        // affect both.
        let repeated = case.faults.iter().any(|fault| fault.repeated);
        let under = if repeated { &first } else { folder };
        shim::run_with(&mut command, &case.faults, under, &folder.join("log"))
    }

    /// Resumes a session an hour later, without faults; returns what is wrong then. `rows` were reported as saved.
    pub fn recovered(&self, definition: usize, results: &Path, rows: &[String]) -> Vec<String> {
        let folder = results.parent().unwrap();
        disk::age_temporary_files(folder);
        let ended = run::ended(&mut run::binary(&self.definition(definition), results, true));
        let failed = (!ended.status.success()).then(|| format!("resuming failed: {}", ended.stderr));
        let faults = disk::faults_of_ended(results, definition, &self.planned[definition]);
        let lost = disk::lost(&disk::paths(results, definition).csv, rows);
        failed.into_iter().chain(faults).chain(lost).chain(disk::unparsable(folder, definition)).collect()
    }

    /// Tries to resume, with new faults; returns every failure. The rows and the clean resume are checked afterward.
    fn disturbed_again(&self, case: &Case, results: &Path, folder: &Path) -> Vec<String> {
        if case.again.is_empty() {
            return Vec::new();
        }
        let mut command = run::binary(&self.definition(case.definition), results, true);
        let (ended, log) = shim::run_with(&mut command, &case.again, folder, &folder.join("log again"));
        let report = report_of_binary(&ended);
        let mut wrong = unreported(&ended, &report, &log, folder);
        if report.done {
            wrong.extend(disk::faults_of_ended(results, case.definition, &self.planned[case.definition]));
        }
        wrong.extend(disk::unparsable(folder, case.definition));
        wrong.into_iter().map(|what| format!("while resuming: {what}")).collect()
    }

    /// Runs one case; returns the number of faults that took effect, and every failure.
    fn run_case(&self, number: usize) -> (usize, Vec<String>) {
        let case = self.case(number);
        let folder = folder();
        let mut recorded = self.prepare(&case, folder.path());
        let (ended, log) = self.disturbed(&case, folder.path());
        let report = if case.binary { report_of_binary(&ended) } else { Report::read(&ended.stdout) };
        recorded.extend(report.rows.iter().cloned());
        let results = report.moved.clone().unwrap_or_else(|| folder.path().join("first"));
        let mut wrong = unreported(&ended, &report, &log, folder.path());
        if report.done {
            let faults = disk::faults_of_ended(&results, case.definition, &self.planned[case.definition]);
            wrong.extend(faults.into_iter().map(|fault| format!("reported as complete, but {fault}")));
        }
        wrong.extend(disk::unparsable(folder.path(), case.definition));
        wrong.extend(disk::lost(&disk::paths(&results, case.definition).csv, &recorded));

        wrong.extend(self.disturbed_again(&case, &results, folder.path()));
        wrong.extend(self.recovered(case.definition, &results, &recorded));
        let undeletable =
            log.hits.iter().any(|hit| hit.op == "unlink" || hit.op == "list" || hit.path.ends_with(".tmp"))
                || case.again.iter().any(|f| f.op == "unlink");
        let left = disk::temporary_files(&results);
        if !undeletable && !left.is_empty() {
            wrong.push(format!("left behind: {left:?}"));
        }
        let is_hit = |fault: &&Fault| {
            let what = format!("{}{}", fault.what, if fault.repeated { "+" } else { "" });
            log.hits.iter().any(|hit| hit.op == fault.op && hit.what == what)
        };
        let seed = self.seed;
        let wrong = wrong.into_iter().map(|what| format!("seed {seed}, case {number}: {what}\n    {case:?}"));
        (case.faults.iter().filter(is_hit).count(), wrong.collect())
    }
}

/// The report of `machband simulate`, which reports errors and its end but no rows.
fn report_of_binary(ended: &run::ProgramResult) -> Report {
    let errors = ended.stderr.lines().filter_map(|line| line.strip_prefix("error: ")).map(str::to_owned).collect();
    Report { errors, done: ended.status.success(), ..Report::default() }
}

/// The failures that were not reported, or whose error does not name the file or folder.
fn unreported(ended: &run::ProgramResult, report: &Report, log: &Log, folder: &Path) -> Vec<String> {
    let mut wrong = Vec::new();
    if ended.stderr.contains("panicked") {
        wrong.push(format!("a panic: {}", ended.stderr));
    }
    // The folder is also listed to find the session that ended before; the sidecar says if this failed.
    let noted = disk::sidecars(folder).iter().any(|sidecar| sidecar.contains("ended before this one is not known"));
    let is_of_folder = |hit: &Hit| hit.op == "open" && Path::new(&hit.path).extension().is_none();
    let folder = folder.display().to_string();
    let is_of_definition = |error: &str| error.contains(".toml: cannot be opened: out of memory");
    wrong.extend(
        report
            .errors
            .iter()
            .filter(|error| !error.starts_with(&folder) && !error.starts_with("threads: ") && !is_of_definition(error))
            .map(|e| format!("names no place: {e}")),
    );
    if ended.was_killed() {
        return wrong;
    }
    let unreported: Vec<&Hit> = log.hits.iter().filter(|hit| matters(hit) && !(noted && is_of_folder(hit))).collect();
    if report.errors.is_empty() && !unreported.is_empty() {
        wrong.push(format!("no error for {unreported:?}"));
    }
    if !report.done && report.errors.is_empty() {
        wrong.push("ended early without an error".to_owned());
    }
    if !report.done && ended.status.code() != Some(1) {
        wrong.push(format!("ended by {} with {:?}", ended.status, report.errors));
    }
    wrong
}

/// Whether a fault must be reported. It need not be if the standard library tries again or continues with the rest, or
/// if only an unneeded file could not be removed.
fn matters(hit: &Hit) -> bool {
    let again = ["open", "read", "write", "sync", "truncate"].contains(&&*hit.op) && hit.what == "EINTR";
    // A folder that can be written to but not opened cannot be synced, and need not be.
    let hidden = hit.op == "open" && hit.what.starts_with("EACCES") && Path::new(&hit.path).extension().is_none();
    // If frames cannot be saved, the sidecar says so, and the session continues.
    let frames = ["open", "stat"].contains(&&*hit.op) && hit.path.ends_with("_frames.csv");
    // The same holds for the file that protects a session where there are no locks.
    let beside = hit.path.ends_with(".lock");
    // If `stat` fails, a leftover file that is not found does no harm, nor does a failed query about the results
    // folder.
    let leftover = hit.op == "stat"
        && (hit.path.ends_with(".tmp") || ["/first", "/second"].iter().any(|end| hit.path.ends_with(end)));
    // Memory that was refused ends the program, or is asked for again in smaller pieces.
    let unneeded = ["unlink", "clock", "list", "close", "thread", "alloc"].contains(&&*hit.op);
    !again && !hidden && !frames && !beside && !leftover && hit.what != "short" && !unneeded
}
