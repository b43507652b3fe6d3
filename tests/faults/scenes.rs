//! Faults around a session.

use std::{
    fs,
    io::{BufRead as _, BufReader, Read as _, Write as _},
    path::{Path, PathBuf},
    process::{Child, Stdio},
    time::Duration,
};

use rustix::process::{Pid, Signal, kill_process};

use crate::{
    common, disk,
    run::{self, ProgramResult, Report},
    shim::{self, Fault},
    sweep::{self, Sweep},
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

    /// Checks that every reported row is on disk and that the resumed session is complete.
    fn assert_kept(&self, report: &Report) {
        let results = self.first();
        let lost = disk::lost(&disk::paths(&results, DEFINITION).csv, &report.rows);
        let wrong = [lost, disk::unparsable(self.folder.path(), DEFINITION)].concat();
        assert_eq!([wrong, self.sweep.recovered(DEFINITION, &results, &report.rows)].concat(), [""; 0]);
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

/// Plays all scenes, and returns their number.
pub fn play(sweep: &Sweep) -> usize {
    let (scenes, moments) = ([removed, two_at_once, without_locks, resumed_at_once], [1, 3, 7]);
    moments.iter().for_each(|rows| scenes.iter().for_each(|scene| scene(sweep, *rows)));
    scenes.len() * moments.len()
}

/// The folder is removed while the program waits for the next answer. The program reports an error and writes all rows
/// again.
fn removed(sweep: &Sweep, rows: usize) {
    let scene = Scene::new(sweep);
    let waiting = scene.waiting(rows);
    fs::remove_dir_all(scene.first()).unwrap();
    let report = waiting.end();
    assert!(report.done && report.errors[0].contains("no longer exists"), "{report:?}");
    scene.assert_kept(&report);
}

/// The second program reports an error and changes nothing; the first continues.
fn two_at_once(sweep: &Sweep, rows: usize) {
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
    scene.assert_kept(&report);
}

/// The first program is stopped after it has created the file and before it locks it; the second one resumes the session.
/// The first program reports an error and changes nothing, whether the second has ended or not.
fn resumed_at_once(sweep: &Sweep, rows: usize) {
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
        scene.assert_kept(&report);
    }
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
fn without_locks(sweep: &Sweep, rows: usize) {
    let scene = Scene::new(sweep);
    let fault = Fault { op: "lock", n: 1, what: "ENOLCK", repeated: true };
    let waiting = scene.waiting_with(rows, std::slice::from_ref(&fault));
    let before = fs::read(scene.csv()).unwrap();
    let mut command = run::binary(&sweep.definition(DEFINITION), &scene.first(), true);
    let log = scene.folder.path().join("log");
    let command_fault = [fault];
    let (second, _) = shim::run_with(&mut command, &command_fault, scene.folder.path(), &log);
    let sentence = "data.csv.lock: means that another program is writing this session";
    assert!(second.status.code() == Some(1) && second.stderr.contains(sentence), "{second:?}");
    assert_eq!(fs::read(scene.csv()).unwrap(), before);
    // The library knows files by their full paths.
    let mut verify = common::command(scene.folder.path(), &["verify", scene.first().to_str().unwrap()]);
    let verified = shim::set(&mut verify, &command_fault, scene.folder.path(), &log).output().unwrap();
    let said = String::from_utf8_lossy(&verified.stdout);
    let sentence = "another program is recording this session (";
    assert!(said.contains(sentence) && said.contains(".lock says so; if no program on any computer"), "{said}");
    let report = waiting.end();
    assert!(report.done && report.errors.is_empty(), "{report:?}");
    let sidecar = fs::read_to_string(disk::paths(&scene.first(), DEFINITION).sidecar).unwrap();
    assert!(sidecar.contains("does not support locks"), "{sidecar}");
    scene.assert_kept(&report);
}
