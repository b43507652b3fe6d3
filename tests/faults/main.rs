//! Nothing brings a session down: a disk that fails, a clock that runs back, a program that is killed, at every place
//! where that can happen, and what is on disk and what resume does afterwards.
//!
//! Linux only, with `cc`: where one is missing the tests say `SKIPPED` and pass, unless `MACHBAND_REQUIRE_FAULTS=1`.
//! `MACHBAND_FAULTS` sessions (1,000) with the faults of `MACHBAND_FAULT_SEED` (1) are run.

#![cfg(all(target_os = "linux", target_env = "gnu"))]

#[path = "../common/mod.rs"]
mod common;
mod disk;
mod run;
mod scenes;
mod shim;
mod sweep;
mod table;

use std::io::Write as _;

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name)
        .map_or(default, |value| value.parse().unwrap_or_else(|_| panic!("{name} is {value}; expected a number")))
}

/// Not by println, which the test harness keeps to itself.
fn print(what: &str) {
    let _ = writeln!(std::io::stderr(), "{what}");
}

/// A thousand sessions with faults: no row lost that was reported as recorded, no file that cannot be read, no failure
/// without an error, and every session resumed to its end.
#[test]
fn a_thousand_faults_take_nothing_with_them() {
    if shim::library().is_none() {
        return;
    }
    let cases = setting("MACHBAND_FAULTS", 1000) as usize;
    let started = std::time::Instant::now();
    let (table, wrong) = sweep::Sweep::new(setting("MACHBAND_FAULT_SEED", 1)).run(cases);
    print(&format!("{table}\n{cases} sessions in {:.1} s", started.elapsed().as_secs_f64()));
    for what in wrong.iter().take(20) {
        print(what);
    }
    assert!(wrong.is_empty(), "{} faults were not borne", wrong.len());
    let total = ["rows lost", "files unparsable", "silent", "resumed"].map(|column| table.total(column));
    assert_eq!(total, [0, 0, 0, cases]);
    let [struck, injected] = ["struck", "injected"].map(|column| table.total(column));
    assert!(struck >= cases, "only {struck} of {injected} faults struck");
}

/// A disk that is full or read-only for good, a folder that is removed, a second program, a clock that is turned back, a
/// program that is killed from outside, a file that is cut at any byte.
#[test]
fn what_happens_around_a_session_takes_nothing_with_it() {
    if shim::library().is_none() {
        return;
    }
    let mut table = table::Table::default();
    scenes::play(&sweep::Sweep::new(1), &mut table);
    print(&table.to_string());
}

/// Not a test: the session that the tests of this file start and disturb.
#[test]
#[ignore = "a part of the other tests"]
fn a_session_for_the_faults() {
    if let Some(child) = run::Child::from_environment() {
        std::process::exit(i32::from(!child.run()));
    }
}
