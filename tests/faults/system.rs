//! The operating system refuses or demands something: full standard streams, threads that cannot be created, an
//! impossible clock, folders that cannot be closed, and signals. No command panics, and no reported row is lost.

use std::{
    fs::{self, File},
    path::Path,
    process::{Command, Stdio},
};

use crate::{
    common::{
        MACHBAND,
        attacks::{ALL, withstood},
        json, split,
    },
    disk,
    run::{self, ProgramResult},
    shim::{self, Fault},
    sweep::{self, Sweep},
};

/// The definition of the sessions; it has eight trials.
const DEFINITION: usize = 1;

fn fault(op: &'static str, n: u64, what: &'static str, repeated: bool) -> Fault {
    Fault { op, n, what, repeated }
}

fn assert_no_panic(what: &str, ended: &ProgramResult) {
    let code = ended.status.code();
    assert!(code.is_some_and(|code| code != 101) && !ended.stderr.contains("panicked"), "{what}: {ended:?}");
}

/// Runs `machband simulate`, new or resumed, with faults in a folder.
fn simulate(sweep: &Sweep, folder: &Path, faults: &[Fault], resume: bool) -> ProgramResult {
    let mut command = run::binary(&sweep.definition(DEFINITION), &folder.join("first"), resume);
    shim::run_with(&mut command, faults, folder, &folder.join("log")).0
}

/// Resumes without faults and checks that the session is complete and that `verify` finds nothing.
fn assert_resumes(sweep: &Sweep, folder: &Path, what: &str) {
    assert_eq!(sweep.recovered(DEFINITION, &folder.join("first"), &[]), [""; 0], "{what}");
    let verified = run::ended(Command::new(MACHBAND).arg("verify").arg(folder.join("first/twice")));
    assert!(verified.status.success(), "{what}: {verified:?}");
}

#[test]
fn no_command_panics_if_a_standard_stream_is_full() {
    let sweep = Sweep::new(1);
    let folder = sweep::folder();
    let rows = run::interrupted(DEFINITION, &folder.path().join("first"), 3);
    let csv = disk::paths(&folder.path().join("first"), DEFINITION).csv;
    let whole = fs::read(&csv).unwrap();
    fs::write(&csv, &whole[..whole.len() - 5]).unwrap();
    let full = || Stdio::from(File::options().write(true).open("/dev/full").unwrap());
    let mut resume = run::binary(&sweep.definition(DEFINITION), &folder.path().join("first"), true);
    let mut runs = 1;
    // The warning about the incomplete row cannot be printed, nor can the summary.
    assert_eq!(resume.stdout(full()).stderr(full()).status().unwrap().code(), Some(1));
    assert_eq!(disk::lines(&csv).len(), 1 + sweep.planned(DEFINITION).len());
    assert_eq!(disk::lines(&csv)[1], rows[0]);
    for line in [
        "stimulus --size 16 --palette median-cut:4 --out picture.png",
        "stimulus --size 16 --width nonsense",
        "predict --size 64",
        "check first/twice/data",
        "verify first/twice",
        "counts first --out counts.csv",
        "plan quick --participants 2 --studies 5",
        "shade --size 16 --out shade.png",
        "no-such-command",
        "--help",
    ] {
        for stdout in [false, true] {
            let mut command = Command::new(MACHBAND);
            command.args(split(line)).current_dir(folder.path()).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
            command.stdin(Stdio::null()).stderr(full());
            command.stdout(if stdout { full() } else { Stdio::null() });
            let code = command.status().unwrap().code();
            assert!(matches!(code, Some(0..=2)), "{line}: {code:?}");
            runs += 1;
        }
    }
    withstood("standard streams that are full", runs, &ALL);
}

#[test]
fn threads_that_cannot_be_created_are_an_error_or_fewer_threads() {
    let Some(sweep) = Sweep::injecting(1) else { return };
    let mut runs = 0;
    for line in ["analyze first --out report --draws 99", "stimulus --size 64 --out a.png", "verify first/twice"] {
        for n in [1, 2, 5] {
            let folder = sweep::folder();
            assert!(simulate(&sweep, folder.path(), &[], false).status.success());
            let mut command = Command::new(MACHBAND);
            command.args(split(line)).current_dir(folder.path());
            let faults = [fault("thread", n, "EAGAIN", true)];
            let (ended, _) = shim::run_with(&mut command, &faults, folder.path(), &folder.path().join("log"));
            assert_no_panic(line, &ended);
            assert_eq!(ended.status.success(), n > 1, "{line}, thread {n}: {ended:?}");
            runs += 1;
        }
    }
    withstood("threads that cannot be created", runs, &ALL);
}

#[test]
fn a_clock_in_an_impossible_year_is_an_error_or_a_time_at_the_limit() {
    let Some(sweep) = Sweep::injecting(1) else { return };
    for what in ["far", "ancient"] {
        let folder = sweep::folder();
        let ended = simulate(&sweep, folder.path(), &[fault("clock", 1, what, false)], false);
        assert!(ended.status.code() == Some(1) && ended.stderr.starts_with("error: clock: "), "{what}: {ended:?}");
        // The clock changes while the session runs.
        for n in 2..12 {
            let folder = sweep::folder();
            let ended = simulate(&sweep, folder.path(), &[fault("clock", n, what, false)], false);
            assert_no_panic(&format!("{what} at {n}"), &ended);
            assert_resumes(&sweep, folder.path(), &format!("{what} at {n}"));
        }
    }
    withstood("clocks in impossible years", 22, &ALL);
}

#[test]
fn a_folder_that_cannot_be_closed_causes_no_panic() {
    let Some(sweep) = Sweep::injecting(1) else { return };
    let folder = sweep::folder();
    let close = [fault("close", 1, "EIO", true)];
    assert!(simulate(&sweep, folder.path(), &close, false).status.success());
    assert!(simulate(&sweep, folder.path(), &close, true).status.success());
    let lines = [
        "verify FOLDER/first/twice",
        "counts FOLDER/first --out FOLDER/counts.csv",
        "export FOLDER/first --format bids --out FOLDER/bids",
        "export FOLDER/first --format psych-ds --out FOLDER/psych-ds",
    ];
    for line in lines {
        let line = line.replace("FOLDER", folder.path().to_str().unwrap());
        let mut command = Command::new(MACHBAND);
        let log = folder.path().join("log");
        let (ended, log) = shim::run_with(command.args(split(&line)), &close, folder.path(), &log);
        assert!(ended.status.success() && log.hits.len() > 1, "{line}: {ended:?}");
    }
    withstood("folders that cannot be closed", 2 + lines.len(), &ALL);
}

/// In each run, a signal arrives just before a different write, such as the one of a row or of the sidecar.
#[test]
fn a_signal_closes_the_sitting() {
    let Some(sweep) = Sweep::injecting(1) else { return };
    let trials = sweep.planned(DEFINITION).len();
    let writes = sweep.calls(DEFINITION, None, true).iter().find(|(op, _)| op == "write").map_or(0, |(_, n)| *n);
    let mut closed = 0;
    for n in 1..=writes {
        let (what, number) = [("TERM", 15), ("INT", 2), ("HUP", 1)][n as usize % 3];
        let folder = sweep::folder();
        let ended = simulate(&sweep, folder.path(), &[fault("write", n, what, false)], false);
        let name = format!("SIG{what} at write {n}");
        assert_eq!(ended.status.code(), Some(128 + number), "{name}: {ended:?}");
        let paths = disk::paths(&folder.path().join("first"), DEFINITION);
        let rows = disk::lines(&paths.csv).len().saturating_sub(1);
        if paths.sidecar.exists() {
            let sidecar = json(&paths.sidecar);
            assert!(sidecar["sittings"][0]["ended_at"].is_string(), "{name}: {sidecar}");
            let sitting = &sidecar["sittings"][0];
            assert!(sitting["seal"].is_object() && sitting["complete"] == (rows == trials), "{name}: {sidecar}");
            let hashes = &sitting["pictures"]["sha256"];
            assert!(rows == 0 || hashes.as_object().is_some_and(|all| !all.is_empty()), "{name}: {sidecar}");
            closed += usize::from((1..trials).contains(&rows));
        }
        assert!(rows == trials || ended.stderr.contains(&format!("ended by SIG{what}")), "{name}: {ended:?}");
        assert_resumes(&sweep, folder.path(), &name);

        // A system that shuts down may send SIGHUP right after SIGTERM.
        let folder = sweep::folder();
        let faults = [fault("write", n, "TERM", false), fault("write", n + 1, "HUP", false)];
        let ended = simulate(&sweep, folder.path(), &faults, false);
        assert!(matches!(ended.status.code(), Some(143 | 129)), "{name}, then SIGHUP: {ended:?}");
        let sidecar = disk::paths(&folder.path().join("first"), DEFINITION).sidecar;
        assert!(
            !sidecar.exists() || json(&sidecar)["sittings"][0]["seal"].is_object(),
            "{name}, then SIGHUP: {ended:?}"
        );

        // The next SIGTERM ends the program at once.
        let folder = sweep::folder();
        let faults = [fault("write", n, what, false), fault("write", n + 1, "TERM", false)];
        let ended = simulate(&sweep, folder.path(), &faults, false);
        assert!(matches!(ended.status.code(), Some(code) if code == 128 + number || code == 143), "{name}: {ended:?}");
        assert_resumes(&sweep, folder.path(), &name);
    }
    assert!(closed >= trials / 2, "only {closed} sittings were closed before their end");
    withstood("signals, once and twice", 3 * writes as usize, &ALL);
}

#[test]
fn an_export_that_a_signal_ends_leaves_nothing() {
    let Some(sweep) = Sweep::injecting(1) else { return };
    let folder = sweep::folder();
    assert!(simulate(&sweep, folder.path(), &[], false).status.success());
    for format in ["bids", "psych-ds"] {
        let mut command = Command::new(MACHBAND);
        command.args(["export", "first", "--out", "out", "--format", format]).current_dir(folder.path());
        let faults = [fault("write", 1, "INT", false)];
        let (ended, _) = shim::run_with(&mut command, &faults, folder.path(), &folder.path().join("log"));
        assert_eq!(ended.status.code(), Some(130), "{ended:?}");
        assert_eq!(ended.stderr, "error: out: ended by SIGINT; nothing was written\n");
        let left: Vec<_> = fs::read_dir(folder.path()).unwrap().flatten().map(|entry| entry.file_name()).collect();
        assert!(left.iter().all(|name| name == "first" || name == "log"), "{left:?}");
    }
}

/// `nohup` starts a program with SIGHUP ignored; it must stay ignored.
#[test]
fn an_ignored_signal_stays_ignored() {
    let Some(library) = shim::library() else { return };
    let sweep = Sweep::new(1);
    let folder = sweep::folder();
    let mut command = Command::new("sh");
    command.args(["-c", "trap '' HUP; exec \"$@\"", "sh", MACHBAND, "simulate"]).arg(sweep.definition(DEFINITION));
    command.arg("--results").arg(folder.path().join("first"));
    command.env("LD_PRELOAD", library).env("MACHBAND_FAULT", "write:5:HUP").env("MACHBAND_FAULT_UNDER", folder.path());
    let ended = run::ended(&mut command);
    assert!(ended.status.success(), "{ended:?}");
}

/// Where a limit forbids a file to grow, the system sends a signal that would end the program.
#[test]
fn a_file_that_may_not_grow_is_an_error() {
    let (sweep, folder) = (Sweep::new(1), sweep::folder());
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -f 3; exec \"$@\"", "sh", MACHBAND, "simulate", "--observer", "paper", "--seed", "7"]);
    command.arg(sweep.definition(DEFINITION)).arg("--results").arg(folder.path().join("first"));
    let ended = run::ended(&mut command);
    assert!(ended.status.code() == Some(1) && ended.stderr.contains("File too large"), "{ended:?}");
    assert_resumes(&sweep, folder.path(), "a limit on the size of files");
}

/// The folder that the window proposes if an answer cannot be saved is the user's own, not the shared temporary folder.
#[test]
fn the_proposed_folder_belongs_to_the_user() {
    use std::os::unix::fs::PermissionsExt as _;

    let proposed = machband::system::data_folder().unwrap();
    assert!(proposed.ends_with("machband") && !proposed.starts_with(std::env::temp_dir()), "{}", proposed.display());
    let folder = sweep::folder();
    let made = folder.path().join("new/rescued");
    machband::system::make_private_folder(&made).unwrap();
    for path in [&made, made.parent().unwrap()] {
        assert_eq!(fs::metadata(path).unwrap().permissions().mode() & 0o777, 0o700);
    }
}
