//! The library of faults, built once, and programs that run under it.

use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
    process::Command,
    sync::OnceLock,
};

use crate::{common, run};

/// The library, or `None` and a line about it where it cannot be made.
pub fn library() -> Option<&'static Path> {
    static BUILT: OnceLock<Option<PathBuf>> = OnceLock::new();
    let built = BUILT.get_or_init(|| {
        let to = Path::new(env!("CARGO_TARGET_TMPDIR")).join("faults.so");
        common::c_library("shim", &to).then_some(to)
    });
    built.as_deref()
}

/// A call that goes wrong: which, and how.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Name of the call as the library has it.
    pub op: &'static str,
    /// Which such call, from 1.
    pub n: u64,
    /// What happens.
    pub what: &'static str,
    /// And to every such call from then on.
    pub lasting: bool,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}{}", self.op, self.n, self.what, if self.lasting { "+" } else { "" })
    }
}

/// A fault that struck.
#[derive(Clone, Debug)]
pub struct Hit {
    pub op: String,
    pub what: String,
    pub path: String,
}

/// What the library logged of a run.
#[derive(Debug, Default)]
pub struct Log {
    pub hits: Vec<Hit>,
    /// Calls of each kind, where the program came to its end.
    pub counts: Vec<(String, u64)>,
}

/// Runs a program under these faults, for paths below `under`.
pub fn run_with(command: &mut Command, faults: &[Fault], under: &Path, log: &Path) -> (run::Ended, Log) {
    let spec: Vec<String> = faults.iter().map(Fault::to_string).collect();
    command
        .env("LD_PRELOAD", library().map_or(OsStr::new(""), Path::as_os_str))
        .env("MACHBAND_FAULT", spec.join(","))
        .env("MACHBAND_FAULT_UNDER", under)
        .env("MACHBAND_FAULT_LOG", log);
    let ended = run::ended(command);
    (ended, read(&std::fs::read_to_string(log).unwrap_or_default()))
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
