//! Injects faults into sessions wherever they can occur (the disk fails, the clock goes back, the program is killed)
//! and checks what is on disk afterward and what resuming does. The same faults meet the commands that read data.
//!
//! The tests need Linux and `cc`. If `cc` is missing, they print `SKIPPED` and pass, unless
//! `MACHBAND_REQUIRE_FAULTS=1`. `MACHBAND_FAULTS` is the number of sessions (1,000), `MACHBAND_CUTS` the number of
//! power cuts (50), `MACHBAND_READS` the number of faults while data are read (200), and `MACHBAND_FAULT_SEED` the seed
//! from which the faults are drawn (1).

#![cfg(all(target_os = "linux", target_env = "gnu"))]

#[path = "../common/mod.rs"]
mod common;
mod disk;
mod ext4;
mod power;
mod reads;
mod run;
mod scenes;
mod shim;
mod sweep;
mod system;

use std::io::Write as _;

use common::attacks::{ALL, FILES, LIES, PANICS, withstood};
use sweep::Sweep;

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name)
        .map_or(default, |value| value.parse().unwrap_or_else(|_| panic!("{name} is {value}; expected a number")))
}

/// Prints to stderr directly, because the test harness captures `println!`.
fn print(what: &str) {
    let _ = writeln!(std::io::stderr(), "{what}");
}

/// Fails if there are failures, and prints the first of them.
fn assert_none(wrong: &[String]) {
    wrong.iter().take(20).for_each(|what| print(what));
    assert!(wrong.is_empty(), "{} failures", wrong.len());
}

/// Runs a thousand sessions with faults: no row that was reported as saved is lost, every file can be read, every
/// failure is reported, and every session can be resumed and completed.
#[test]
fn no_row_is_lost_in_a_thousand_sessions_with_faults() {
    let Some(sweep) = Sweep::injecting(setting("MACHBAND_FAULT_SEED", 1)) else { return };
    let cases = setting("MACHBAND_FAULTS", 1000) as usize;
    let (struck, wrong) = sweep.run(cases);
    assert_none(&wrong);
    assert!(struck >= cases, "only {struck} faults took effect");
    withstood("sessions with faults in system calls, also while they recover", cases, &ALL);
}

/// The folder is removed, or a second program opens the session, with and without locks.
#[test]
fn no_row_is_lost_when_something_happens_around_a_session() {
    if let Some(sweep) = Sweep::injecting(1) {
        withstood("faults around a session", scenes::play(&sweep), &ALL);
    }
}

/// The power fails at any moment during a session or a command that writes files.
#[test]
fn nothing_that_was_reported_is_lost_in_a_power_cut() {
    let Some(sweep) = Sweep::injecting(1) else { return };
    let cuts = setting("MACHBAND_CUTS", 50) as usize;
    assert_none(&power::play(&sweep, cuts, setting("MACHBAND_FAULT_SEED", 1)));
    withstood("power cuts", cuts, &ALL);
}

/// The power fails during a session on a real file system. Needs root and loop devices.
#[test]
fn no_row_is_lost_in_a_power_cut_of_ext4() {
    let cuts = setting("MACHBAND_CUTS", 50) / 10;
    match ext4::play(&Sweep::new(1), cuts, setting("MACHBAND_FAULT_SEED", 1)) {
        Err(why) => common::skip("ROOT", &format!("no power cuts of ext4: {why}")),
        Ok(wrong) => {
            assert_none(&wrong);
            withstood("power cuts of ext4", cuts as usize, &ALL);
        }
    }
}

/// A call fails, ends early, is interrupted or kills the program while a command reads data. The command must do what
/// it does without the fault, or say an error and fail; it must not take an error for an absence.
#[test]
fn no_error_while_reading_passes_for_an_absence() {
    if shim::library().is_none() {
        return;
    }
    let (faults, wrong) = reads::play(setting("MACHBAND_READS", 200) as usize, setting("MACHBAND_FAULT_SEED", 1));
    assert_none(&wrong);
    withstood("faults while data are read", faults, &[LIES, FILES, PANICS]);
}

/// Not a test: does what the window does.
#[test]
#[ignore = "part of the other tests"]
fn window_for_the_other_tests() {
    if let (Ok(part), Some(folder)) = (std::env::var("MACHBAND_CHILD_PART"), std::env::var_os("MACHBAND_CHILD_FOLDER"))
    {
        std::process::exit(reads::window(&part, folder.as_ref()));
    }
}

/// Not a test: the other tests start this session in a separate process and disturb it.
#[test]
#[ignore = "part of the other tests"]
fn session_for_the_other_tests() {
    if let Some(child) = run::Child::from_environment() {
        std::process::exit(i32::from(!child.run()));
    }
}
