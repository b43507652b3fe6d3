//! Tests display profiles, from the file to the screen, and the tools that measure the screen, without a display.

use std::path::Path;

use eframe::egui::{Key, Modifiers, ViewportEvent, ViewportId};
use egui_kittest::kittest::Queryable as _;
use machband::{
    app::{App, Launch, Request},
    display::{DisplayProfile, LuminanceRange, Measurement},
    experiment::{Identity, Protocol, Schedule},
    light::{Bits, Dither, Transfer, TransferTable, Transfers},
    stimulus::recipe::Recipe,
    store::{Writer, definition, image, profile, sidecar::Sidecar},
    work,
};

use super::{
    common::{machband, pixels, split},
    window::{
        self, Window, builder, click, home, press, type_into, value, wait_for, walk_to_first_trial, wrong_pixels,
    },
};

const SIZE: [f32; 2] = [1000.0, 800.0];
const STEP_S: f32 = 1.0 / 60.0;

/// A screen with a different transfer function per channel: a table, a gain with an offset, and a plain gamma.
fn differing() -> DisplayProfile {
    let encoded: Vec<f64> = (0..=32).map(|i| f64::from(i) / 32.0).collect();
    // An S-shaped curve, which no gamma can fit.
    let linear = encoded.iter().map(|v| v * v * (1.6 - 0.6 * v * v)).collect();
    let table = Transfer::Table(TransferTable::new(encoded, linear).unwrap());
    DisplayProfile {
        name: "Three kinds".to_owned(),
        transfers: Transfers::new([table, Transfer::gog(2.3, 1.04, -0.04).unwrap(), Transfer::Gamma(1.9)]),
        luminance: Some(LuminanceRange { black_cd_m2: 0.2, white_cd_m2: 180.0 }),
        measured: Some(Measurement {
            on: Some("2026-01-31".parse().unwrap()),
            by: None,
            with: Some("photometer".to_owned()),
        }),
        native_px: Some([1234, 777]),
        ..DisplayProfile::default()
    }
}

fn protocol() -> Protocol {
    let text = "schema = 1\nname = \"shown\"\n[stimulus]\nkind = \"mach-band\"\ncolor = \"1,0.6,0.3\"\n[factors]\n\
                width = [0.3, 0.8]\norientation_deg = [0, 30]\n[design]\npractice = 1\n[recovery]\nduration_s = 0.2\n";
    definition::parse("shown", text).unwrap()
}

/// Launches a session on that screen.
fn launch(results: &Path) -> Launch {
    let request = Request { display: differing(), ..window::request(results, protocol()) };
    Launch { request: Some(request), ..Launch::default() }
}

fn sidecar(results: &Path) -> Sidecar {
    Sidecar::read(&results.join("shown/data/subject-P001_session-1_task-shown_data.json")).unwrap().unwrap()
}

/// At every scale, the screen shows exactly the bytes that `machband stimulus` writes with the same profile.
#[test]
fn with_a_profile_the_screen_shows_what_the_command_writes() {
    if !crate::common::has_graphics() {
        return;
    }
    for scale in [1.0, 1.25, 1.5, 2.0] {
        let folder = tempfile::tempdir().unwrap();
        profile::write(&Writer::default(), &folder.path().join("screen.toml"), &differing()).unwrap();
        let builder = builder([900.0, 700.0], STEP_S).with_pixels_per_point(scale).wgpu();
        let launch = launch(folder.path());
        let mut harness = builder.build_eframe(|cc| App::new(cc, launch));
        walk_to_first_trial(&mut harness);
        harness.run_steps(20);
        let shot = harness.render().unwrap();
        press(&mut harness, Key::Num1);
        let viewing = sidecar(folder.path()).sittings[0].viewing.clone().unwrap();
        let size = viewing.stimulus_px;
        let schedule = Schedule::new(&protocol(), &Identity::new("P001", "1").unwrap(), 5).unwrap();
        let stimulus = schedule.conditions[schedule.trials[0].condition].stimulus.clone();
        let (transfers, bits, dither) = (Transfer::Srgb.into(), Bits::Eight, Dither::None);
        let recipe = Recipe { stimulus, size, transfers, bits, dither, seed: 1, display_sha256: None, finish: None };
        let arguments = split(&format!("{} --display screen.toml", work::stimulus::command(&recipe)));
        // An old profile causes only a warning.
        let output = machband(folder.path(), &arguments[1..]);
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        let path = folder.path().join("stimulus.png");
        let texts = &pixels(&path).0.uncompressed_latin1_text;
        assert!(texts[0].text.contains(&profile::hash(&differing())));
        let written = image::read_picture(&path, None, image::MAX_PIXELS).unwrap().codes;
        let wrong = wrong_pixels([shot.width(), shot.height()], |x, y| shot.get_pixel(x, y).0, &written);
        assert_eq!(wrong, 0, "of {size} × {size} pixels at scale {scale}");
        let codes: std::collections::BTreeSet<_> = (0..size).map(|x| written.pixel(x, size / 2)).collect();
        assert!(codes.len() > 20, "a ramp, not a single color: {}", codes.len());
    }
}

#[test]
fn the_preflight_detects_an_old_profile_and_another_screen_and_records_confirmations() {
    let folder = tempfile::tempdir().unwrap();
    let launch = launch(folder.path());
    let mut harness = builder(SIZE, STEP_S).build_eframe(|cc| App::new(cc, launch));
    wait_for(&mut harness, "These findings are saved");
    harness.get_by_label_contains("days ago; after 30 days");
    harness.get_by_label_contains("Is this a different screen?");
    harness.get_by_label_contains("This is the screen on which the profile was measured").click();
    harness.step();
    press(&mut harness, Key::Space);
    wait_for(&mut harness, "Welcome");
    harness.get_by_label_contains("say so before you begin");
    let sidecar = sidecar(folder.path());
    let sitting = &sidecar.sittings[0];
    let note = |check: &str| {
        let found = sitting.preflight.iter().find(|note| note.check == check);
        found.unwrap_or_else(|| panic!("{check} is not in {:?}", sitting.preflight)).ok
    };
    assert!(note("right_monitor_asked") && !note("right_monitor") && !note("profile_age"));
    assert!(!note("other_programs_asked"), "nobody confirmed it");
    assert!(note("light_steps"));
    // The data alone say what was shown.
    let display = sitting.display.as_ref().unwrap();
    assert_eq!(display.sha256, profile::hash(&differing()));
    assert_eq!(display.profile, profile::value(&differing()));
}

#[test]
fn the_measured_size_of_the_screen_is_used_on_home() {
    let mut harness = home(SIZE, STEP_S);
    click(&mut harness, "Display");
    harness.get_by_label_contains("sRGB, assumed: this screen");
    type_into(&mut harness, "Screen width, cm", "30");
    type_into(&mut harness, "Viewing distance, cm", "57.3");
    // With 1000 pixels across 30 cm, viewed from 57.3 cm, a degree is a centimeter, or 33.3 pixels.
    harness.get_by_label_contains("One degree is 1.00 cm, 33.3 pixels. The study's stimulus is 334 pixels wide.");
    type_into(&mut harness, "Viewing distance, cm", "200");
    // 10° needs 2 · 200 · tan 5° = 35.0 cm; the shorter side is 24 cm long.
    harness.get_by_label_contains("Enter a shorter distance");
    click(&mut harness, "Studies");
    window::session_form(&mut harness);
    assert_eq!(value(&harness, "Screen width, cm"), "30");
    assert_eq!(value(&harness, "Viewing distance, cm"), "200");
}

/// The pixels per inch that a system assumes rise with its scale.
#[test]
fn the_assumed_width_follows_the_scale_of_the_system() {
    let mut window =
        builder(SIZE, STEP_S).with_pixels_per_point(1.5).build_eframe(|cc| App::new(cc, Launch::default()));
    window.run_steps(3);
    window::session_form(&mut window);
    window.get_by_label_contains("Assumed (144 pixels per inch, from the system's scale of 1.5); measure it");
}

fn says(window: &Window, text: &str) -> bool {
    window.query_all_by_label_contains(text).next().is_some()
}

/// A page that measures shows what a trial shows and nothing else, and closing the window asks first.
#[test]
fn measuring_pages_show_nothing_else_and_leaving_asks() {
    let folder = tempfile::tempdir().unwrap();
    for (tool, shown) in [("Photometer", "Patch gray"), ("Gamma by eye", "rows lit"), ("Timing", "")] {
        let mut window = home([1000.0, 900.0], STEP_S);
        click(&mut window, "Display");
        click(&mut window, tool);
        if tool != "Timing" {
            let csv = folder.path().join(format!("{tool}.csv"));
            type_into(&mut window, "File of measurements", csv.to_str().unwrap());
        }
        let places = ["Studies", "Stimuli", "Analyze", "Help", "Settings"];
        assert!(places.iter().all(|place| says(&window, place)), "{tool}");
        click(&mut window, "Begin");
        window.run_steps(60);
        for _ in 0..2 {
            assert!(places.iter().all(|place| window.query_by_label(place).is_none()), "{tool}");
            if !shown.is_empty() {
                let middle = window.get_by_label_contains(shown).rect().center();
                assert!((middle.x - 500.0).abs() < 1.0 && (middle.y - 450.0).abs() < 1.0, "{tool}: {middle:?}");
            }
            window.key_press_modifiers(Modifiers::COMMAND, Key::Num1);
            window.run_steps(3);
        }
        for (answer, paused) in [("Stay", true), ("Quit", false)] {
            let root = window.input_mut().viewports.entry(ViewportId::ROOT).or_default();
            root.events.push(ViewportEvent::Close);
            window.run_steps(2);
            assert!(says(&window, "Quit during the measurement?"), "{tool}");
            click(&mut window, answer);
            assert!(!says(&window, "Quit during the measurement?") && says(&window, "Studies"), "{tool}");
            if paused {
                click(&mut window, if tool == "Timing" { "Begin" } else { "Resume" });
                window.run_steps(60);
            }
        }
    }
}

/// Two warnings precede a flickering patch, and Escape stops it.
#[test]
fn timing_measures_and_reports() {
    let mut window = home([1000.0, 900.0], STEP_S);
    click(&mut window, "Display");
    click(&mut window, "Timing");
    click(&mut window, "A flickering patch");
    assert!(says(&window, "photosensitive epilepsy"));
    click(&mut window, "Begin");
    assert!(says(&window, "It begins in 3 s. Press Esc to stop.") && says(&window, "photosensitive epilepsy"));
    window.run_steps(60);
    assert!(says(&window, "It begins in 2 s"));
    window.run_steps(150);
    assert!(!says(&window, "photosensitive"), "it flickers");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(says(&window, "Begin") && !says(&window, "Median"));
    click(&mut window, "A flickering patch");
    click(&mut window, "Begin");
    window.run_steps(640);
    let verdict = "Every refresh at 60.00 Hz showed a new frame: none of 600 was dropped.";
    for text in [verdict, "600", "60.000 Hz, 16.667 ms, measured", "Dropped frames", "Missed refreshes"] {
        assert!(says(&window, text), "{text}");
    }
    // Escape leads back.
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert!(window.query_by_label("Timing").is_some());
}
