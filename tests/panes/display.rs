//! A display profile from its file to the screen: what is shown is what the command writes, each code is the nearest, and
//! what is known of the screen stands with the data.

use std::path::Path;

use eframe::egui::Key;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use machband::{
    app::{App, Launch, Request},
    display::{DisplayProfile, LuminanceRange, Measurement},
    experiment::{Identity, Protocol, Schedule},
    light::{Bits, Dither, Transfer, TransferTable, Transfers},
    stimulus::recipe::Recipe,
    store::{definition, image, profile, session::SessionStore, sidecar::Sidecar},
};

use super::{
    common::machband,
    window::{
        self, Window, builder, click, has_graphics, home, press, take_picture, type_into, value, wait_for,
        walk_to_first_trial, wrong_pixels,
    },
};

const SIZE: [f32; 2] = [1000.0, 800.0];
const STEP_S: f32 = 1.0 / 60.0;

/// A screen whose channels are a table, a gain with an offset, and a plain gamma.
fn differing() -> DisplayProfile {
    let encoded: Vec<f64> = (0..=32).map(|i| f64::from(i) / 32.0).collect();
    // S-shaped, as no gamma is.
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

fn request(results: &Path, display: DisplayProfile) -> Request {
    Request { display, ..window::request(results, protocol()) }
}

fn sidecar(results: &Path) -> Sidecar {
    Sidecar::read(&results.join("shown/data/subject-P001_session-1_task-shown_data.json")).unwrap().unwrap()
}

/// Runs a command that must succeed; that the profile is old is only a warning.
fn shown_by(folder: &Path, arguments: &[&str]) {
    let output = machband(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn with_a_profile_the_screen_shows_what_the_command_writes() {
    if !has_graphics() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("screen.toml");
    profile::write(&file, &differing()).unwrap();
    let display = profile::open(&file).unwrap();
    let launch = Launch { request: Some(request(folder.path(), display.clone())) };
    let mut harness = builder(SIZE, STEP_S).wgpu().build_eframe(|cc| App::new(cc, launch));
    walk_to_first_trial(&mut harness);
    harness.run_steps(20);
    let shot = harness.render().unwrap();
    press(&mut harness, Key::Num1);

    let sidecar = sidecar(folder.path());
    let side = sidecar.sittings[0].viewing.as_ref().unwrap()["stimulus_px"].as_u64().unwrap() as u32;
    let schedule = Schedule::new(&protocol(), &Identity::new("P001", "1").unwrap(), 5).unwrap();
    let stimulus = schedule.conditions[schedule.trials[0].condition].stimulus.clone();
    let recipe = Recipe {
        stimulus,
        size: side,
        transfers: Transfer::Srgb.into(),
        bits: Bits::Eight,
        dither: Dither::None,
        seed: 1,
        display_sha256: None,
    };
    let command = recipe.command();
    let mut arguments: Vec<&str> = command.split(' ').skip(1).collect();
    arguments.extend(["--display", "screen.toml"]);
    shown_by(folder.path(), &arguments);
    let written = image::read(&folder.path().join("stimulus.png")).unwrap();
    assert_eq!(written.recipe.display_sha256, Some(profile::hash(&display)));
    let size = [shot.width(), shot.height()];
    assert_eq!(wrong_pixels(size, |x, y| shot.get_pixel(x, y).0, &written.image), 0);
    let codes: std::collections::BTreeSet<_> = (0..side).map(|x| written.image.pixel(x, side / 2)).collect();
    assert!(codes.len() > 20, "a ramp, and not one color: {}", codes.len());
}

/// Of the strongest channel, for every kind of transfer function and every dither-free kind of picture.
#[test]
fn what_is_emitted_is_within_half_a_code_of_what_was_asked() {
    let folder = tempfile::tempdir().unwrap();
    let all = differing();
    for (channel, color) in ["red", "green", "blue"].into_iter().enumerate() {
        profile::write(&folder.path().join("screen.toml"), &all).unwrap();
        let transfer = &all.transfers.channels()[channel];
        for (bits, max) in [("8", 255.0), ("16", 65_535.0)] {
            for kind in ["mach-band", "cornsweet", "chevreul"] {
                let common = ["stimulus", "--kind", kind, "--color", color, "--bits", bits, "--size", "777"];
                let files = ["--low=0", "--high=1", "--display", "screen.toml", "--profile", "profile.csv"];
                shown_by(folder.path(), &[&common[..], &files[..]].concat());
                let mut rows = csv::Reader::from_path(folder.path().join("profile.csv")).unwrap();
                let mut count = 0;
                for row in rows.records() {
                    let row = row.unwrap();
                    let [linear, emitted] = [1, 5].map(|column: usize| row[column].parse::<f64>().unwrap());
                    let code: f64 = row[2 + channel].parse().unwrap();
                    // The light of half a code to either side, by the profile itself.
                    let low = transfer.linear_from_encoded((code - 0.5) / max) - 1e-6;
                    let high = transfer.linear_from_encoded((code + 0.5) / max) + 1e-6;
                    assert!((low..=high).contains(&linear), "{kind} {color} {bits}: {row:?}");
                    assert!((low..=high).contains(&emitted), "{kind} {color} {bits}: {row:?}");
                    assert_eq!(emitted, transfer.linear_from_encoded(code / max));
                    count += 1;
                }
                assert_eq!(count, 777);
            }
        }
    }
}

#[test]
fn the_preflight_tells_an_old_profile_and_another_screen_and_keeps_what_was_confirmed() {
    let folder = tempfile::tempdir().unwrap();
    let launch = Launch { request: Some(request(folder.path(), differing())) };
    let mut harness = builder(SIZE, STEP_S).build_eframe(|cc| App::new(cc, launch));
    wait_for(&mut harness, "These findings are saved");
    harness.get_by_label_contains("days ago; after 30 days");
    harness.get_by_label_contains("Is it another screen?");
    harness.get_by_label_contains("This is the screen that the profile was measured on").click();
    harness.step();
    press(&mut harness, Key::Space);
    wait_for(&mut harness, "Welcome");
    harness.get_by_label_contains("can be shown in gray");
    let sidecar = sidecar(folder.path());
    let sitting = &sidecar.sittings[0];
    let note = |check: &str| {
        let found = sitting.preflight.iter().find(|note| note.check == check);
        found.unwrap_or_else(|| panic!("{check} is not in {:?}", sitting.preflight)).ok
    };
    assert!(note("right_monitor_asked") && !note("right_monitor") && !note("profile_age"));
    assert!(!note("other_programs_asked"), "nobody confirmed it");
    assert!(note("light_steps"));
    // What was shown can be told from the data alone.
    let display = sitting.display.as_ref().unwrap();
    assert_eq!(display["sha256"], profile::hash(&differing()).as_str());
    assert_eq!(display["profile"], profile::value(&differing()));
}

#[test]
fn the_size_of_the_screen_is_measured_and_goes_back_to_home() {
    let mut harness = home(SIZE, STEP_S);
    click(&mut harness, "Measure…");
    harness.get_by_label_contains("sRGB (srgb), assumed");
    take_picture(&mut harness, "display_tools");
    harness.get_by_label("Size and distance").click();
    harness.run_steps(2);
    for (field, text) in [
        ("Width of the lit part, cm", "30"),
        ("Distance from eye to screen, cm", "57.3"),
        ("Planned size of the stimulus, degrees", "40"),
    ] {
        type_into(&mut harness, field, text);
    }
    // 1000 pixels on 30 cm, seen from 57.3 cm: a degree is a centimetre, or 33.3 pixels.
    harness.get_by_label_contains("A degree is 33.3 pixels, or 1.00 cm");
    harness.get_by_label_contains("The screen is 30.0 × 24.0 cm");
    // 40° need 2 · 57.3 · tan 20° = 41.7 cm, and the lesser side has 24.
    harness.get_by_label_contains("only 58 % of that fits");
    harness.get_by_label_contains("It fits from 32 cm or less");
    take_picture(&mut harness, "display_size");
    press(&mut harness, Key::Escape);
    harness.run_steps(2);
    harness.get_by_label("Size and distance");
    press(&mut harness, Key::Escape);
    harness.run_steps(3);
    assert_eq!(value(&harness, "Screen width, cm"), "30");
    assert_eq!(value(&harness, "Viewing distance, cm"), "57.3");
}

/// The smallest window that the program allows, on its list of tools.
fn small() -> Window {
    let mut harness = home([420.0, 360.0], STEP_S);
    click(&mut harness, "Measure…");
    harness
}

#[test]
fn every_tool_fits_the_smallest_window() {
    let mut harness = small();
    for tool in
        ["Size and distance", "Photometer", "Gamma by eye", "Check the gamma", "Steps of equal brightness", "Timing"]
    {
        click(&mut harness, tool);
        let wide: Vec<String> = (harness.root().children_recursive())
            .filter_map(|node| Some((node.accesskit_node().label()?, node.accesskit_node().bounding_box()?.x1)))
            // The table of the steps scrolls by itself.
            .filter(|(label, right)| *right > 420.0 - 12.0 && label != "nearest j")
            .map(|(label, right)| format!("{label:?} up to {right}"))
            .collect();
        assert!(wide.is_empty(), "{tool}: {wide:#?}");
        press(&mut harness, Key::Escape);
        harness.run_steps(3);
    }
}

/// The width that a card gives follows from the outline alone: not from the window, and not from opening the dialog.
#[test]
fn the_card_is_matched_by_keys_and_a_small_window_changes_nothing() {
    let mut harness = small();
    click(&mut harness, "Size and distance");
    let width = |harness: &Window| value(harness, "Width of the lit part, cm");
    // 420 pixels at 96 an inch.
    assert_eq!(width(&harness), "11.1");
    harness.get_by_label_contains("This width is assumed");
    click(&mut harness, "Measure with a card…");
    harness.get_by_label("The screen is 11.1 cm wide.");
    // All of it can be reached.
    harness.get_by_label("Cancel").scroll_to_me();
    harness.run_steps(30);
    let cancel = harness.get_by_label("Cancel").rect();
    assert!(cancel.bottom() <= 360.0 - 24.0 && cancel.right() <= 420.0 - 24.0, "{cancel:?}");
    press(&mut harness, Key::Enter);
    harness.run_steps(3);
    assert_eq!(width(&harness), "11.1");
    // 8.56 · 420/11.1 is an outline of 324 pixels; 20 fewer are 8.56 · 420/304 = 11.8 cm.
    click(&mut harness, "Measure with a card…");
    for _ in 0..20 {
        press(&mut harness, Key::ArrowLeft);
    }
    harness.get_by_label("The screen is 11.8 cm wide.");
    press(&mut harness, Key::Enter);
    harness.run_steps(3);
    assert_eq!(width(&harness), "11.8");
    assert!(harness.query_by_label_contains("This width is assumed").is_none());
    // Escape leaves everything as it was.
    click(&mut harness, "Measure with a card…");
    press(&mut harness, Key::ArrowRight);
    press(&mut harness, Key::Escape);
    harness.run_steps(3);
    assert_eq!(width(&harness), "11.8");
}

#[test]
fn measured_light_is_told_with_three_digits() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.toml");
    let luminance = Some(LuminanceRange { black_cd_m2: 0.250_592_758_493_736_2, white_cd_m2: 134.217_6 });
    profile::write(&path, &DisplayProfile { luminance, ..differing() }).unwrap();
    let mut harness = home(SIZE, STEP_S);
    click(&mut harness, "Measure…");
    type_into(&mut harness, "Profile in use", path.to_str().unwrap());
    click(&mut harness, "Steps of equal brightness");
    harness.get_by_label("Measured: 0.251 to 134 cd/m².");
    assert!(harness.query_by_label_contains("0.25059").is_none());
}

#[test]
fn an_experiment_in_gray_is_one_of_its_own() {
    let quick = definition::open("quick").unwrap();
    let gray = quick.in_gray().unwrap();
    assert_eq!((gray.name.as_str(), gray.in_gray()), ("quick-gray", None));
    assert_eq!(gray.stimulus.field_light(0.3), [0.3; 3]);
    assert_eq!(gray.factors, quick.factors);
    assert_ne!(definition::hash(&gray), definition::hash(&quick));
    let text = "schema = 1\nname = \"c\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\ncolor = [\"red\", \"gray\"]\n";
    assert_eq!(definition::parse("c", text).unwrap().in_gray(), None);
    // Its sidecar's definition reads back the same.
    let folder = tempfile::tempdir().unwrap();
    let identity = Identity::new("P1", "1").unwrap();
    SessionStore::create(folder.path(), &gray, &identity, 1, Default::default()).unwrap();
    assert_eq!(SessionStore::exists(folder.path(), &gray, &identity), Some(false));
    assert_eq!(SessionStore::exists(folder.path(), &quick, &identity), None);
}
