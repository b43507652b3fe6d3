//! Builds the library that injects faults, and runs programs with it.

use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
    process::Command,
    sync::OnceLock,
};

use crate::{common, run};

/// The library; if it cannot be built, prints the reason and returns `None`.
pub fn library() -> Option<&'static Path> {
    static BUILT: OnceLock<Option<PathBuf>> = OnceLock::new();
    let built = BUILT.get_or_init(|| {
        let to = Path::new(env!("CARGO_TARGET_TMPDIR")).join("faults.so");
        common::c_library("shim", &to).then_some(to)
    });
    built.as_deref()
}

/// A call that fails, and how it fails.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Name of the call in the library.
    pub op: &'static str,
    /// Which call of this kind, counted from 1.
    pub n: u64,
    /// What happens: an errno name or an action (see `shim.c`).
    pub what: &'static str,
    /// Whether every later call of this kind fails too.
    pub repeated: bool,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}{}", self.op, self.n, self.what, if self.repeated { "+" } else { "" })
    }
}

/// A fault that took effect.
#[derive(Clone, Debug)]
pub struct Hit {
    pub op: String,
    pub what: String,
    pub path: String,
}

/// What the library logged during a run.
#[derive(Debug, Default)]
pub struct Log {
    pub hits: Vec<Hit>,
    /// Number of calls of each kind; empty if the program was killed.
    pub counts: Vec<(String, u64)>,
}

/// Runs a program with these faults, which affect only paths below `under`.
pub fn run_with(command: &mut Command, faults: &[Fault], under: &Path, log: &Path) -> (run::ProgramResult, Log) {
    let ended = run::ended(set(command, faults, under, log));
    (ended, read(&std::fs::read_to_string(log).unwrap_or_default()))
}

/// Sets the environment variables for these faults.
pub fn set<'a>(command: &'a mut Command, faults: &[Fault], under: &Path, log: &Path) -> &'a mut Command {
    let spec: Vec<String> = faults.iter().map(Fault::to_string).collect();
    command
        .env("LD_PRELOAD", library().map_or(OsStr::new(""), Path::as_os_str))
        .env("MACHBAND_FAULT", spec.join(","))
        .env("MACHBAND_FAULT_UNDER", under)
        .env("MACHBAND_FAULT_LOG", log)
        // The standard library waits for itself if memory runs out while it records a backtrace.
        .env("RUST_BACKTRACE", "0")
}

fn read(text: &str) -> Log {
    let mut log = Log::default();
    for line in text.lines() {
        let parts: Vec<&str> = line.splitn(5, ' ').collect();
        match parts[..] {
            ["hit", op, _, what, path] => {
                log.hits.push(Hit { op: op.to_owned(), what: what.to_owned(), path: path.to_owned() });
            }
            ["count", op, n] => log.counts.push((op.to_owned(), n.parse().unwrap())),
            _ => panic!("an unknown line of the log: {line}"),
        }
    }
    log
}
