//! Tests the real window on a virtual screen with real key events.
//!
//! Each test starts and ends its own Xvfb and openbox. Instead of waiting for a fixed time, the tests watch the result
//! file for rows and the screen itself, which Xvfb keeps in a mapped file.
//!
//! The tests need `Xvfb`, `openbox` and `xdotool`. If one is missing, they print `SKIPPED` and pass, unless
//! `MACHBAND_REQUIRE_DISPLAY=1`.

#![cfg(feature = "window")]
#![cfg(target_os = "linux")]

#[path = "../common/mod.rs"]
mod common;
mod faults;
mod harness;
mod tasks;

use std::{
    collections::BTreeSet,
    fs,
    process::Command,
    time::{Duration, Instant},
};

use common::MACHBAND;
use harness::{
    Harness, NUMPAD_KEYS, RECOVERY_S, SCREEN, SHORT_DEFINITION, Shown, assert_complete, checked, pattern, rows,
};

/// Half a refresh interval of the test's screen, which runs at 60 Hz.
const HALF_REFRESH_S: f64 = 1.0 / 120.0;

#[test]
fn a_full_session_records_every_key_and_shows_the_exact_stimulus() {
    let Some(mut harness) = Harness::new() else { return };
    let text =
        SHORT_DEFINITION.replace("swift", "full").replace("depth = [1,", "orientation_deg = [0, 90]\ndepth = [1, 2,");
    let definition = harness.definition("full", &text);
    let planned = harness.planned(&definition);
    assert_eq!(planned.len(), 14);
    harness.run(&definition, &["--seed", "7"]);
    let csv = harness.csv("full");
    let mut compared = BTreeSet::new();
    for (i, row) in planned.iter().enumerate() {
        harness.stimulus();
        if row["phase"] == "main" && compared.insert((row["orientation_deg"].clone(), row["depth"].clone())) {
            let viewing = harness.sidecar("full")["sittings"][0]["viewing"].clone();
            harness.compare_with_image(row, viewing["stimulus_px"].as_u64().unwrap() as u32);
        }
        harness.rate(&csv, pattern(i));
    }
    assert_eq!(compared.len(), 6, "two orientations, three depths");
    harness.complete("full");

    let rows = rows(&csv);
    assert_complete(&csv, &planned);
    let least_s = RECOVERY_S - HALF_REFRESH_S;
    let mut earliest = 0.0;
    for (i, row) in rows.iter().enumerate() {
        let seconds = |name: &str| row[name].parse::<f64>().unwrap_or_else(|_| panic!("{name} of row {i}: {row:?}"));
        assert_eq!((&*row["subject_id"], &*row["session_id"], &*row["attempt"]), ("S001", "1", "1"));
        assert!((least_s..least_s + 10.0).contains(&seconds("recovery_s")), "row {i}: {}", row["recovery_s"]);
        assert!((1e-6..60.0).contains(&seconds("response_time_s")), "row {i}: {}", row["response_time_s"]);
        // Each time is rounded to a tenth of a millisecond.
        assert!(seconds("onset_s") >= earliest - 0.001, "row {i}: onset {} before {earliest}", row["onset_s"]);
        earliest = seconds("onset_s") + seconds("response_time_s") + least_s;
        assert!(seconds("frames") >= 1.0, "row {i}");
        // For digits and the number pad alike, the recorded time is the time of the key, not of the frame.
        assert!((0.0..10.0).contains(&seconds("response_uncertainty_s")), "row {i}");
    }
    let input = &harness.sidecar("full")["sittings"][0]["input"];
    assert_eq!((&input["stamped"], &input["unstamped"]), (&planned.len().into(), &0.into()), "{input}");
    let mut waits: Vec<f64> = rows.iter().map(|row| row["response_uncertainty_s"].parse().unwrap()).collect();
    waits.sort_by(f64::total_cmp);
    for (name, expected) in [("median_uncertainty_s", waits[waits.len() / 2]), ("max_uncertainty_s", waits[13])] {
        assert!((input[name].as_f64().unwrap() - expected).abs() < 1e-4, "{name}: {input}");
    }
    // `verify` renders every picture that was shown again and finds no difference.
    let output = Command::new(MACHBAND).arg("verify").arg(csv.parent().unwrap()).output().unwrap();
    let printed = common::text(&output.stdout) + &common::text(&output.stderr);
    let expected = "12 pictures rendered again; unchanged since it was recorded";
    assert!(output.status.success() && printed.contains(expected), "{printed}");
}

/// The meaning of a key can change while it is held: on the number pad if Num Lock is toggled, and for the digits of a
/// Czech keyboard if Shift is released first. The next press of that digit must still count.
#[test]
fn a_key_whose_meaning_changes_while_held_counts_when_pressed_again() {
    let Some((mut harness, _, csv)) = Harness::with_session() else { return };
    harness.rate(&csv, "2");
    harness.stimulus();
    for (action, key) in [("keydown", NUMPAD_KEYS[1]), ("key", "Num_Lock"), ("keyup", NUMPAD_KEYS[1])] {
        harness.xdotool(&[action, key]);
    }
    harness.until("the row of the number pad", |_| rows(&csv).len() == 2);
    harness.until("the stimulus to disappear", |harness| harness.shown() != Shown::Stimulus);
    harness.stimulus();
    harness.press("1");
    harness.until_for(Duration::from_secs(15), "the row of the same digit", |_| rows(&csv).len() == 3);
    let ratings: Vec<_> = rows(&csv).iter().map(|row| row["rating"].clone()).collect();
    assert_eq!(ratings, ["2", "1", "1"]);
}

/// The process is killed twice, once while it waits and once while it writes. `--resume` shows exactly the missing
/// trials. Each sitting finds a changed screen: first no gamma ramp and no refresh rate, then a night light and a
/// refresh rate, then straight ramps and a refresh rate.
#[test]
fn a_killed_session_resumes_without_loss() {
    let Some((mut harness, planned, csv)) = Harness::with_session() else { return };
    for i in 0..3 {
        harness.rate(&csv, pattern(i));
    }
    harness.stimulus();
    harness.kill();
    assert_eq!(rows(&csv).len(), 3);
    checked(&csv);

    // An existing session is not overwritten.
    let definition = harness.swift();
    let refused = harness.machband(&["run", &definition, "--participant", "S001", "--results", &harness.results()]);
    assert_eq!(refused.status.code(), Some(1), "{refused:?}");

    let pixels = f64::from(SCREEN.0) * f64::from(SCREEN.1);
    harness.set_mode(SCREEN, (59.94 * pixels).round() as u32);
    harness.set_ramps(0.8);
    harness.run(&definition, &["--resume"]);
    harness.rate(&csv, pattern(3));
    harness.stimulus();
    harness.press(pattern(4));
    harness.kill();
    let done = rows(&csv).len();
    assert!((4..=5).contains(&done), "{done} rows");

    harness.set_ramps(1.0);
    harness.run(&definition, &["--resume"]);
    for i in done..planned.len() {
        harness.rate(&csv, pattern(i));
    }
    harness.complete("swift");
    assert_complete(&csv, &planned);
    let onsets: Vec<f64> = rows(&csv).iter().map(|row| row["onset_s"].parse().unwrap()).collect();
    assert!(onsets.is_sorted(), "{onsets:?}");

    let sidecar = harness.sidecar("swift");
    let sittings = sidecar["sittings"].as_array().unwrap();
    let notes = |check: &str| -> Vec<Option<bool>> {
        let of = |sitting: &serde_json::Value| {
            sitting["preflight"].as_array()?.iter().find(|note| note["check"] == check)?["ok"].as_bool()
        };
        sittings.iter().map(of).collect()
    };
    // A ramp that is dark throughout, as on this server at first, does not count as a ramp.
    assert_eq!(notes("color_ramps"), [None, Some(false), Some(true)]);
    assert_eq!(notes("refresh"), [Some(false), Some(true), Some(true)]);
    assert_eq!(notes("resolution"), [Some(true); 3]);
    assert!(sittings[1].to_string().contains("59.940 Hz"), "{}", sittings[1]);
}

/// The results folder disappears during a session. The window says so, keeps every answer in memory, stays open, and
/// continues once the answers can be saved again.
#[test]
fn a_lost_results_folder_loses_no_answer() {
    let Some((mut harness, planned, csv)) = Harness::with_session() else { return };
    for i in 0..4 {
        harness.rate(&csv, pattern(i));
    }
    harness.stimulus();
    let folder = harness.dir.path().join("results/swift");
    fs::remove_dir_all(&folder).unwrap();
    // A file prevents the program from creating the folder again for now.
    fs::write(&folder, "in the way").unwrap();
    let trouble = Instant::now();
    harness.press(pattern(4));
    harness.until("the page for unsaved answers", |harness| harness.shown() == Shown::Page);

    // Closing the window now would lose the answers, so it stays open.
    harness.press("alt+F4");
    let before = harness.screen();
    harness.press("Tab");
    harness.until("the focus on the button", |harness| harness.screen() != before);
    harness.press("Return");
    // Long enough to distinguish this time from a recovery.
    std::thread::sleep(Duration::from_secs(2).saturating_sub(trouble.elapsed()) + Duration::from_secs(1));
    assert!(harness.ended().is_none(), "the window closed with an answer unsaved: {}", harness.stderr());
    assert_eq!(harness.shown(), Shown::Page, "nothing can be written yet");

    fs::remove_file(&folder).unwrap();
    let over = Instant::now();
    let held = trouble.elapsed().as_secs_f64();
    harness.press("Return");
    harness.until("the rows to be restored", |_| rows(&csv).len() == 5);
    harness.rate(&csv, pattern(5));
    let since = over.elapsed().as_secs_f64();
    harness.complete("swift");
    assert_complete(&csv, &planned);
    let recovery: f64 = rows(&csv)[5]["recovery_s"].parse().unwrap();
    assert!(
        (RECOVERY_S - HALF_REFRESH_S..since).contains(&recovery),
        "recovery must count only the field, not the page, which was shown for {held:.1} s; the stimulus was rated {since:.1} s after the page, and recovery_s is {recovery}"
    );
}

/// Without a display, the program prints a single error that says what to do. This test needs no display server.
#[test]
fn without_a_display_there_is_one_error() {
    let dir = tempfile::tempdir().unwrap();
    let run = ["run", "quick", "--participant", "S001", "--results", "results"];
    for (display, arguments) in [(None, &[][..]), (None, &run), (Some(":987"), &[]), (Some(":987"), &run)] {
        let output = common::command(dir.path(), arguments)
            .env_remove("WAYLAND_SOCKET")
            .envs(display.map(|display| ("DISPLAY", display)))
            .output()
            .unwrap();
        let stderr = common::text(&output.stderr);
        assert_eq!((output.status.code(), &*output.stdout), (Some(1), &b""[..]), "{display:?} {arguments:?}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{display:?} {arguments:?}: {stderr}");
        assert!(stderr.starts_with("error: display: ") && stderr.contains("machband simulate"), "{stderr}");
        assert!(!stderr.contains("panic"), "{stderr}");
    }
    assert!(!dir.path().join("results").exists());
}

/// The start page begins and resumes a session by its keys, and quitting during a trial asks.
#[test]
fn an_aborted_session_is_offered_and_resumed() {
    let Some(mut harness) = Harness::new() else { return };
    let definition = harness.swift();
    let path = harness.dir.path().join("settings.toml");
    let settings = format!(
        "schema = 1\ntheme = \"light\"\nresults = {:?}\nstudy = {definition:?}\n[recent]\nexperiments = [{definition:?}]\n",
        harness.results()
    );
    fs::write(&path, settings).unwrap();
    let opened = |harness: &mut Harness| {
        harness.start(&["--config", "settings.toml"]);
        harness.until("the window", |harness| !harness.ask(&["search", "--name", "^machband$"]).is_empty());
        // The sessions are read on another thread.
        harness.at_rest();
    };
    opened(&mut harness);
    let geometry = harness.ask(&["search", "--name", "^machband$", "getwindowgeometry", "--shell"]);
    let height = geometry.lines().find_map(|line| line.strip_prefix("HEIGHT=")).unwrap().parse::<u16>().unwrap();
    assert!(height < SCREEN.1, "the window and its title bar fit the screen");
    harness.press("Return");
    let csv = common::session_csv(&harness.dir.path().join("results"), "swift", "P001");
    harness.rate(&csv, "1");
    harness.rate(&csv, "2");
    // Esc answers no, and the same session continues. Quitting again answers yes.
    for (answer, waits) in [("Escape", true), ("ctrl+q", false)] {
        harness.stimulus();
        harness.press("ctrl+q");
        harness.until("the question", |harness| harness.shown() == Shown::Page);
        std::thread::sleep(Duration::from_millis(700));
        assert!(harness.ended().is_none(), "quitting must ask");
        harness.press(answer);
        if waits {
            std::thread::sleep(Duration::from_millis(300));
            harness.rate(&csv, "3");
        }
    }
    assert!(harness.wait_for_end().success());
    assert_eq!(rows(&csv).len(), 3);
    // The settings have survived; they name no participant.
    let settings = fs::read_to_string(&path).unwrap();
    assert!(settings.contains("theme = \"light\"") && !settings.contains("P001"), "{settings}");
    opened(&mut harness);
    // From the next participant to the session that was interrupted.
    harness.press("Up");
    harness.at_rest();
    harness.press("Return");
    for key in ["0", "1", "2"] {
        harness.rate(&csv, key);
    }
    harness.until("the sidecar to say complete", |_| {
        fs::read_to_string(csv.with_extension("json")).unwrap_or_default().contains("\"complete\": true")
    });
    let output = common::machband(harness.dir.path(), &["verify", csv.parent().unwrap().to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
}
