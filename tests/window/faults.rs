//! The monitor, the display server, or the graphics card is lost in the middle of a trial.

use std::{ffi::OsString, fs, io::Write as _, path::Path, time::Duration};

use super::{
    common::{
        attacks::{ALL, withstood},
        c_library, skip,
    },
    harness::{Harness, Row, SCREEN, Shown, assert_complete, pattern, rows},
};

/// The monitor is replaced by one that is smaller than the stimulus. The session pauses and says why; once there is
/// enough room again, it continues.
#[test]
fn a_smaller_screen_pauses_the_session() {
    let Some((mut harness, planned, csv)) = Harness::with_session() else { return };
    harness.rate(&csv, pattern(0));
    harness.rate(&csv, pattern(1));
    harness.stimulus();
    harness.set_mode((640, 300), 60 * 640 * 300);
    // Until the window has followed the screen, the trial continues and a key would count.
    harness.at_rest();
    harness.until("the pause page", |harness| harness.shown() == Shown::Page);
    harness.press("2");
    harness.press("space");
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(harness.shown(), Shown::Page, "there is no room for a stimulus");
    harness.at_rest();
    assert_eq!(rows(&csv).len(), 2);

    harness.set_mode(SCREEN, 0);
    harness.at_rest();
    harness.resume();
    for i in 2..planned.len() {
        harness.rate(&csv, pattern(i));
    }
    harness.complete("swift");
    assert_complete(&csv, &planned);
    withstood("the screen becomes too small", 1, &ALL);
}

/// The program's message after the window or the graphics are lost: exactly one error of its own, and no panic.
fn error_of_lost_window(harness: &mut Harness) -> String {
    let status = harness.wait_for_end();
    let stderr = harness.stderr();
    assert_eq!(status.code(), Some(1), "{stderr}");
    let errors: Vec<_> = stderr.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(errors.len() == 1 && !stderr.contains("panicked"), "{stderr}");
    assert!(errors[0].contains("the window was lost") && errors[0].contains("--resume"), "{stderr}");
    errors[0].to_owned()
}

/// Checks that the rows of the first sitting are on disk and that the sitting is closed; then resumes and completes the
/// session.
fn resume_to_the_end(harness: &mut Harness, planned: &[Row], done: usize) {
    let csv = harness.csv("swift");
    assert_eq!(rows(&csv).len(), done);
    assert!(harness.sidecar("swift")["sittings"][0]["ended_at"].is_string(), "the sitting was not closed");
    let definition = harness.swift();
    harness.run(&definition, &["--resume"]);
    for i in done..planned.len() {
        harness.rate(&csv, pattern(i));
    }
    harness.complete("swift");
    assert_complete(&csv, planned);
}

/// Starts a session and rates three trials. It then shows the fourth, or the pause page.
fn interrupted_after_three(in_trial: bool) -> Option<(Harness, Vec<Row>)> {
    let (mut harness, planned, csv) = Harness::with_session()?;
    for i in 0..3 {
        harness.rate(&csv, pattern(i));
    }
    harness.stimulus();
    if !in_trial {
        harness.press("Escape");
        harness.until("the pause page", |harness| harness.shown() == Shown::Page);
        harness.at_rest();
    }
    Some((harness, planned))
}

/// The display server ends, once during a trial and once on the pause page.
#[test]
fn no_answer_is_lost_when_the_display_server_ends() {
    for in_trial in [true, false] {
        let Some((mut harness, planned)) = interrupted_after_three(in_trial) else { return };
        for mut server in harness.servers.drain(..) {
            server.kill().unwrap();
            server.wait().unwrap();
        }
        error_of_lost_window(&mut harness);
        harness.start_servers();
        resume_to_the_end(&mut harness, &planned, 3);
    }
    withstood("the display server ends", 2, &ALL);
}

/// The graphics card stops responding.
#[test]
fn no_answer_is_lost_when_the_graphics_card_is_lost() {
    let Some(mut harness) = Harness::new() else { return };
    let folders = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib"];
    let library = folders.map(|folder| Path::new(folder).join("libvulkan.so.1")).into_iter().find(|path| path.exists());
    let Some(library) = library else { return skip("FAULTS", "no faults are injected: no libvulkan.so.1") };
    let shim = harness.dir.path().join("vulkan");
    fs::create_dir(&shim).unwrap();
    if !c_library("vulkan_shim", &shim.join("libvulkan.so.1")) {
        return;
    }
    let lost = harness.dir.path().join("lost");
    harness.environment = [("LD_LIBRARY_PATH", &shim), ("MACHBAND_VULKAN", &library), ("MACHBAND_VULKAN_LOST", &lost)]
        .map(|(name, value)| (name, OsString::from(value)))
        .to_vec();
    let definition = harness.swift();
    let planned = harness.planned(&definition);
    harness.run(&definition, &["--seed", "7"]);
    let csv = harness.csv("swift");
    for i in 0..3 {
        harness.rate(&csv, pattern(i));
    }
    harness.stimulus();
    fs::write(&lost, "").unwrap();
    let error = error_of_lost_window(&mut harness);
    assert!(error.contains("the graphics card was lost"), "{error}");
    fs::remove_file(&lost).unwrap();
    resume_to_the_end(&mut harness, &planned, 3);
    withstood("the graphics card is lost", 1, &ALL);
}

/// A signal asks the program to end, once in the middle of a trial and once on the pause page, where the window waits
/// for input.
#[test]
fn a_signal_closes_the_sitting() {
    for (signal, number, in_trial) in [("TERM", 15, true), ("HUP", 1, false)] {
        let Some((mut harness, planned)) = interrupted_after_three(in_trial) else { return };
        harness.signal(signal);
        let status = harness.wait_for_end();
        let stderr = harness.stderr();
        assert_eq!(status.code(), Some(128 + number), "{stderr}");
        assert!(
            stderr.contains(&format!("ended by SIG{signal}; every saved answer is on disk; to resume,"))
                && stderr.contains("or press Resume")
                && !stderr.contains("panicked"),
            "{stderr}"
        );
        assert!(harness.sidecar("swift")["sittings"][0]["seal"].is_object(), "the session is not sealed");
        resume_to_the_end(&mut harness, &planned, 3);
    }
    withstood("signals in the window", 2, &ALL);
}

/// The disk refuses an answer, and a signal asks the program to end. The row is printed; appended to the file, it
/// agrees with the seal.
#[test]
fn an_answer_that_no_disk_accepts_is_printed() {
    let Some(mut harness) = Harness::new() else { return };
    let library = harness.dir.path().join("faults.so");
    if !c_library("shim", &library) {
        return;
    }
    let (definition, csv) = (harness.swift(), harness.csv("swift"));
    let planned = harness.planned(&definition);
    // The header and two rows are written before.
    harness.environment = vec![
        ("LD_PRELOAD", library.into()),
        ("MACHBAND_FAULT", "write:4:ENOSPC+".into()),
        ("MACHBAND_FAULT_UNDER", csv.clone().into()),
    ];
    harness.run(&definition, &["--seed", "7"]);
    harness.rate(&csv, pattern(0));
    harness.rate(&csv, pattern(1));
    harness.stimulus();
    harness.press(pattern(2));
    harness.until("the page for an answer that is not saved", |harness| harness.shown() == Shown::Page);
    harness.at_rest();
    harness.signal("INT");
    assert_eq!(harness.wait_for_end().code(), Some(128 + 2), "{}", harness.stderr());
    let stderr = harness.stderr();
    let (_, row) = stderr.split_once("expected it at the end of the file: ").unwrap_or_else(|| panic!("{stderr}"));
    assert_eq!(rows(&csv).len(), 2);
    let mut file = fs::File::options().append(true).open(&csv).unwrap();
    writeln!(file, "{}", row.lines().next().unwrap()).unwrap();
    harness.environment.clear();
    resume_to_the_end(&mut harness, &planned, 3);
    withstood("signals while an answer cannot be saved", 1, &ALL);
}
