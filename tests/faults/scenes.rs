//! Faults around a session. Each is a scene with its own row in the table.

use std::{
    fs,
    io::{BufRead as _, BufReader, Read as _, Write as _},
    path::{Path, PathBuf},
    process::{Child, Stdio},
    time::Duration,
};

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};
use rustix::process::{Pid, Signal, kill_process};

use crate::{
    disk,
    run::{self, ProgramResult, Report},
    shim::{self, Fault},
    sweep::{self, Sweep},
    table::{Counts, Table},
};

/// The definition that the scenes use; it has eight trials.
const DEFINITION: usize = 1;

/// A temporary folder for one session.
struct Scene<'a> {
    sweep: &'a Sweep,
    folder: tempfile::TempDir,
}

impl<'a> Scene<'a> {
    fn new(sweep: &'a Sweep) -> Self {
        Self { sweep, folder: sweep::folder() }
    }

    fn first(&self) -> PathBuf {
        self.folder.path().join("first")
    }

    fn second(&self) -> PathBuf {
        self.folder.path().join("second")
    }

    fn csv(&self) -> PathBuf {
        disk::paths(&self.first(), DEFINITION).csv
    }

    fn resume(&self, results: &Path) -> ProgramResult {
        run::ended(&mut run::binary(&self.sweep.definition(DEFINITION), results, true))
    }

    /// Starts a child that waits after this many rows.
    fn waiting(&self, rows: usize) -> Waiting {
        self.waiting_with(rows, &[])
    }

    /// Starts such a child with these faults.
    fn waiting_with(&self, rows: usize, faults: &[Fault]) -> Waiting {
        let mut command = run::child(DEFINITION, &self.first(), &self.second(), self.csv().exists());
        shim::set(&mut command, faults, self.folder.path(), &self.folder.path().join("log of the child"));
        command.env("MACHBAND_CHILD_WAIT", rows.to_string());
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut stdout = BufReader::new(child.stdout.take().unwrap());
        let mut output = String::new();
        while !output.contains("@waiting\n") {
            assert!(stdout.read_line(&mut output).unwrap() > 0, "the child ended: {output}");
        }
        Waiting { child, stdout, output }
    }

    /// Checks that every reported row is on disk and that the resumed session is complete; returns the counts for the
    /// table.
    fn assert_kept(&self, report: &Report, results: &Path) -> Counts {
        let recorded = || disk::lines(&disk::paths(results, DEFINITION).csv);
        let lost = |rows: &[String]| report.rows.iter().filter(|row| !rows.contains(row)).count();
        assert_eq!(lost(&recorded()), 0, "{report:?}");
        let unparsable = disk::unparsable(self.folder.path(), DEFINITION);
        assert_eq!(unparsable, Vec::<String>::new());
        let resumed = self.resume(results);
        assert!(resumed.status.success(), "{resumed:?}");
        assert_eq!(lost(&recorded()), 0, "{report:?}");
        let faults = disk::faults_of_ended(results, DEFINITION, self.sweep.planned(DEFINITION));
        assert_eq!(faults, Vec::<String>::new());
        let mut counts = ["injected", "took effect", "sessions", "resumed"].map(|column| (column, 1)).to_vec();
        counts.push(("reported an error", usize::from(!report.errors.is_empty())));
        counts.push(("rows saved", report.rows.len()));
        counts
    }
}

struct Waiting {
    child: Child,
    stdout: BufReader<std::process::ChildStdout>,
    output: String,
}

impl Waiting {
    /// Lets the child continue and waits until it ends.
    fn end(mut self) -> Report {
        self.child.stdin.take().unwrap().write_all(b"\n").unwrap();
        self.stdout.read_to_string(&mut self.output).unwrap();
        self.child.wait().unwrap();
        Report::read(&self.output)
    }
}

/// Plays all scenes and adds them to the table.
pub fn play(sweep: &Sweep, table: &mut Table) {
    for rows in [1, 3, 7] {
        table.line("the folder is removed during the session", removed(sweep, rows));
        table.line("two programs open the same session", two_at_once(sweep, rows));
        table.line("two programs open the same session, without locks", without_locks(sweep, rows));
        table.line("a second program resumes a session before its file is locked", resumed_at_once(sweep, rows));
        table.line("the clock is turned back between sittings", clock_back(sweep, rows));
        for (name, what) in [("the disk becomes full", "ENOSPC"), ("the folder becomes read-only", "EROFS")] {
            table.line(name, lasting(sweep, rows, what));
        }
    }
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for _ in 0..40 {
        let (rows, wait) = (1 + rng.next_u64() as usize % 7, Duration::from_micros(rng.next_u64() % 3000));
        table.line("the program is killed at a random moment", killed(sweep, rows, wait));
    }
    cut(sweep, table);
}

/// The folder is removed while the program waits for the next answer. The program reports an error and writes all rows
/// again.
fn removed(sweep: &Sweep, rows: usize) -> Counts {
    let scene = Scene::new(sweep);
    let waiting = scene.waiting(rows);
    fs::remove_dir_all(scene.first()).unwrap();
    let report = waiting.end();
    assert!(report.done && report.errors[0].contains("no longer exists"), "{report:?}");
    scene.assert_kept(&report, &scene.first())
}

/// The second program reports an error and changes nothing; the first continues.
fn two_at_once(sweep: &Sweep, rows: usize) -> Counts {
    let scene = Scene::new(sweep);
    let waiting = scene.waiting(rows);
    let before = fs::read(scene.csv()).unwrap();
    let second = scene.resume(&scene.first());
    let (csv, code) = (scene.csv().display().to_string(), second.status.code());
    let sentence =
        format!("error: {csv}: another machband process is writing this session; expected it to be closed first\n");
    assert_eq!((code, &second.stderr), (Some(1), &sentence));
    let fresh = run::ended(&mut run::binary(&sweep.definition(DEFINITION), &scene.first(), false));
    assert!(fresh.status.code() == Some(1) && fresh.stderr.contains("of this participant already exists"), "{fresh:?}");
    assert_eq!(fs::read(scene.csv()).unwrap(), before);
    let report = waiting.end();
    assert!(report.done && report.errors.is_empty(), "{report:?}");
    [scene.assert_kept(&report, &scene.first()), vec![("reported an error", 1)]].concat()
}

/// The first program is stopped after it has created the file and before it locks it; the second one resumes the session.
/// The first program reports an error and changes nothing, whether the second has ended or not.
fn resumed_at_once(sweep: &Sweep, rows: usize) -> Counts {
    let mut counts = Vec::new();
    for has_ended in [false, true] {
        let scene = Scene::new(sweep);
        let first = stopped_before_the_lock(&scene);
        let waiting = scene.waiting(rows);
        let (report, waiting) = if has_ended { (Some(waiting.end()), None) } else { (None, Some(waiting)) };
        let before = fs::read(scene.csv()).unwrap();
        kill_process(Pid::from_child(&first), Signal::CONT).unwrap();
        let first = first.wait_with_output().unwrap();
        let error = String::from_utf8_lossy(&first.stderr);
        let sentence = ["is writing this session", "already exists"][usize::from(has_ended)];
        assert!(first.status.code() == Some(1) && error.contains(sentence), "{error}");
        assert_eq!(fs::read(scene.csv()).unwrap(), before);
        let report = report.unwrap_or_else(|| waiting.unwrap().end());
        assert!(report.done && report.errors.is_empty(), "{report:?}");
        counts = [scene.assert_kept(&report, &scene.first()), vec![("reported an error", 1)]].concat();
    }
    counts
}

/// Starts a program and stops it before it locks the new file of a session.
fn stopped_before_the_lock(scene: &Scene<'_>) -> Child {
    for n in 1.. {
        let _ = fs::remove_dir_all(scene.first());
        let log = scene.folder.path().join(format!("log {n}"));
        let mut command = run::binary(&scene.sweep.definition(DEFINITION), &scene.first(), false);
        let fault = Fault { op: "lock", n, what: "STOP", repeated: false };
        shim::set(&mut command, &[fault], scene.folder.path(), &log);
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let state = || fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap_or_default();
        while !state().contains(") T ") {
            std::thread::sleep(Duration::from_millis(1));
        }
        if fs::read_to_string(log).unwrap().contains("data.csv\n") {
            return child;
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }
    unreachable!("the loop ends only with a stopped program")
}

/// The file system does not support locks. The lock file of the first program keeps the second one out, and the sidecar
/// says that locks do not work.
fn without_locks(sweep: &Sweep, rows: usize) -> Counts {
    let scene = Scene::new(sweep);
    let fault = Fault { op: "lock", n: 1, what: "ENOLCK", repeated: true };
    let waiting = scene.waiting_with(rows, std::slice::from_ref(&fault));
    let before = fs::read(scene.csv()).unwrap();
    let mut command = run::binary(&sweep.definition(DEFINITION), &scene.first(), true);
    let log = scene.folder.path().join("log");
    let (second, _) = shim::run_with(&mut command, &[fault], scene.folder.path(), &log);
    let sentence = "data.csv.lock: means that another program is writing this session";
    assert!(second.status.code() == Some(1) && second.stderr.contains(sentence), "{second:?}");
    assert_eq!(fs::read(scene.csv()).unwrap(), before);
    let report = waiting.end();
    assert!(report.done && report.errors.is_empty(), "{report:?}");
    let sidecar = fs::read_to_string(disk::paths(&scene.first(), DEFINITION).sidecar).unwrap();
    assert!(sidecar.contains("does not support locks"), "{sidecar}");
    [scene.assert_kept(&report, &scene.first()), vec![("reported an error", 1)]].concat()
}

/// In the second sitting, the wall clock is an hour behind. The session's own time does not go back.
fn clock_back(sweep: &Sweep, rows: usize) -> Counts {
    let scene = Scene::new(sweep);
    let lines = run::interrupted(DEFINITION, &scene.first(), rows);
    let fault = Fault { op: "clock", n: 1, what: "back", repeated: false };
    let mut command = run::binary(&sweep.definition(DEFINITION), &scene.first(), true);
    let (ended, log) = shim::run_with(&mut command, &[fault], scene.folder.path(), &scene.folder.path().join("log"));
    assert!(ended.status.success() && log.hits.len() == 1, "{ended:?}");
    let report = Report { rows: lines, done: true, ..Report::default() };
    let found = disk::rows(&scene.csv(), DEFINITION).unwrap();
    assert!(found[rows].started_at < found[rows - 1].started_at, "the clock was not turned back");
    scene.assert_kept(&report, &scene.first())
}

/// From one write on, every write fails. The program reports the error, tries again, and moves the session to another
/// folder.
fn lasting(sweep: &Sweep, rows: usize, what: &'static str) -> Counts {
    let scene = Scene::new(sweep);
    // The rows are the last writes, except for the end of the sidecar.
    let writes = sweep.calls(DEFINITION, None, false).iter().find(|(op, _)| op == "write").map_or(0, |(_, n)| *n);
    let before = writes - 1 - sweep.planned(DEFINITION).len() as u64;
    let fault = Fault { op: "write", n: before + rows as u64, what, repeated: true };
    let mut command = run::child(DEFINITION, &scene.first(), &scene.second(), false);
    let (ended, log) = shim::run_with(&mut command, &[fault], &scene.first(), &scene.folder.path().join("log"));
    let report = Report::read(&ended.stdout);
    assert!(report.done && !log.hits.is_empty() && report.errors.len() == 3, "{report:?} {log:?}");
    assert_eq!(report.moved, Some(scene.second()));
    // The rows that were saved before also stay in the first folder.
    assert_eq!(disk::lines(&scene.csv())[1..], report.rows[..rows - 1]);
    scene.assert_kept(&report, &scene.second())
}

/// The program is killed from outside (SIGKILL) shortly after a row.
fn killed(sweep: &Sweep, rows: usize, wait: Duration) -> Counts {
    let scene = Scene::new(sweep);
    let mut waiting = scene.waiting(rows);
    waiting.child.stdin.take().unwrap().write_all(b"\n").unwrap();
    std::thread::sleep(wait);
    waiting.child.kill().unwrap();
    waiting.stdout.read_to_string(&mut waiting.output).unwrap();
    waiting.child.wait().unwrap();
    let report = Report::read(&waiting.output);
    assert!(report.rows.len() >= rows, "{report:?}");
    scene.assert_kept(&report, &scene.first())
}

/// The file is cut at each byte of its last two rows. Complete rows stay; an incomplete row is reported, and its trial
/// is shown again.
fn cut(sweep: &Sweep, table: &mut Table) {
    let scene = Scene::new(sweep);
    run::interrupted(DEFINITION, &scene.first(), 5);
    let sidecar = disk::paths(&scene.first(), DEFINITION).sidecar;
    let [whole, saved] = [&scene.csv(), &sidecar].map(|path| fs::read(path).unwrap());
    let ends: Vec<usize> = (0..whole.len()).filter(|i| whole[*i] == b'\n').map(|i| i + 1).collect();
    for length in ends[ends.len() - 3]..whole.len() {
        fs::write(scene.csv(), &whole[..length]).unwrap();
        fs::write(&sidecar, &saved).unwrap();
        let kept = disk::lines(&scene.csv()).split_off(1);
        let resumed = scene.resume(&scene.first());
        let torn = !ends.contains(&length);
        assert_eq!(resumed.stderr.contains("an incomplete last row was removed"), torn, "{length}: {resumed:?}");
        let errors = if torn { vec![resumed.stderr] } else { Vec::new() };
        let report = Report { rows: kept, errors, ..Report::default() };
        table.line("the file is cut within its last two rows", scene.assert_kept(&report, &scene.first()));
    }
}
