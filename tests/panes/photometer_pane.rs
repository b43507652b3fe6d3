//! The photometer's page, driven without a display: patches, typed readings, the fit, the profile.

use std::path::Path;

use eframe::egui::{self, Key};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use machband::{
    light::Transfer,
    store::{profile, readings},
};

use super::window::{self, Window, click, home, take_picture, type_into as fill, value};

fn harness() -> Window {
    home([1000.0, 1000.0], 1.0 / 10.0)
}

fn press(harness: &mut Window, key: Key) {
    window::press(harness, key);
    harness.step();
}

fn open(harness: &mut Window) {
    click(harness, "Measure…");
    click(harness, "Photometer");
    harness.get_by_label("Show patches");
}

/// Channel and code of the patch on the screen.
fn patch(harness: &Window) -> Option<(String, f64)> {
    let node = harness.query_by_label_contains("Patch ")?;
    let name = node.accesskit_node().label()?;
    let mut words = name.split(' ').skip(1);
    Some((words.next()?.to_owned(), words.next()?.parse().ok()?))
}

/// The pixel in the middle of the window.
fn middle(harness: &mut Window) -> [u8; 3] {
    let image = harness.render().unwrap();
    let [red, green, blue, _] = image.get_pixel(image.width() / 2 + 50, image.height() / 2 + 50).0;
    [red, green, blue]
}

fn cd_m2(channel: &str, code: f64) -> f64 {
    let range = match channel {
        "red" => 25.0,
        "green" => 80.0,
        "blue" => 10.0,
        _ => 115.0,
    };
    0.3 + range * (code / 255.0f64).powf(2.2)
}

fn answer(harness: &mut Window, text: &str) {
    // The line has the keyboard.
    harness.run_steps(12);
    harness.event(egui::Event::Text(text.to_owned()));
    harness.run_steps(2);
    press(harness, Key::Enter);
}

fn begin(harness: &mut Window, csv: &Path) {
    open(harness);
    fill(harness, "Keep the measurements in", &csv.display().to_string());
    fill(harness, "Seconds to settle", "0.5");
    click(harness, "red, green, blue");
    click(harness, "Show patches");
}

#[test]
fn patches_are_read_and_become_a_profile() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, toml) = (folder.path().join("left.csv"), folder.path().join("left.toml"));
    let mut harness = harness();
    begin(&mut harness, &csv);
    // White first. What is no number is told, and so is a reading before the patch has settled.
    assert_eq!(patch(&harness), Some(("gray".to_owned(), 255.0)));
    assert_eq!(middle(&mut harness), [255, 255, 255]);
    answer(&mut harness, "bright");
    harness.get_by_label_contains("is not a luminance; expected cd/m²");
    take_picture(&mut harness, "display_patch");
    assert_eq!(readings::open_begun(&csv).unwrap(), []);
    fill(&mut harness, "gray 255 · cd/m²", "115.3");
    press(&mut harness, Key::Enter);
    let second = patch(&harness).unwrap();
    assert_eq!(middle(&mut harness), [second.1 as u8; 3], "byte for byte");
    assert_eq!(readings::open_begun(&csv).unwrap().len(), 1, "kept at once");
    // Too soon.
    harness.event(egui::Event::Text("1".to_owned()));
    press(&mut harness, Key::Enter);
    harness.get_by_label_contains("has not settled yet");
    assert_eq!(patch(&harness).unwrap(), second);
    // More light than white: asked once more, then taken back by going to the patch before.
    fill(&mut harness, &format!("gray {} · cd/m²", second.1), "900");
    harness.run_steps(8);
    press(&mut harness, Key::Enter);
    harness.get_by_label_contains("does not fit gray 255");
    fill(&mut harness, &format!("gray {} · cd/m²", second.1), &cd_m2("gray", second.1).to_string());
    press(&mut harness, Key::Enter);
    click(&mut harness, "Previous");
    assert_eq!(patch(&harness).unwrap(), second);
    harness.run_steps(8);
    press(&mut harness, Key::Enter);
    // Left and come back to: the same settings go on where they were.
    click(&mut harness, "Pause");
    take_picture(&mut harness, "display_photometer");
    harness.get_by_label_contains("Paused after 2 of");
    click(&mut harness, "Back");
    click(&mut harness, "Photometer");
    harness.get_by_label_contains("Paused after 2 of");
    click(&mut harness, "Resume");
    let mut n = 2;
    while let Some((channel, code)) = patch(&harness) {
        answer(&mut harness, &cd_m2(&channel, code).to_string());
        n += 1;
        assert!(n < 60, "the patches do not end");
    }
    let read = readings::open(&csv).unwrap();
    assert_eq!(read.all().len(), n);
    harness.get_by_label_contains("Chosen: gamma");
    harness.get_by_label_contains("red, green, blue not read");
    fill(&mut harness, "Measured by", "AB");
    fill(&mut harness, "Measured with", "LS-150");
    fill(&mut harness, "Save as", &toml.display().to_string());
    click(&mut harness, "Save the profile");
    harness.get_by_label_contains("Saved as");
    let made = profile::open(&toml).unwrap();
    let Some(Transfer::Gamma(gamma)) = made.transfers.uniform() else { panic!("{:?}", made.transfers) };
    assert!((gamma - 2.2).abs() < 1e-6, "{gamma}");
    let measured = made.measured.unwrap();
    assert_eq!((measured.by.as_deref(), measured.with.as_deref()), (Some("AB"), Some("LS-150")));
}

/// What the line holds.
fn typed(harness: &Window) -> String {
    let (channel, code) = patch(harness).unwrap();
    value(harness, &format!("{channel} {code} · cd/m²"))
}

#[test]
fn typing_over_a_reading_that_was_gone_back_to_replaces_it() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("left.csv");
    let read = |index: usize| readings::open_begun(&csv).unwrap()[index].luminance_cd_m2;
    let mut harness = harness();
    begin(&mut harness, &csv);
    answer(&mut harness, "100");
    let (_, second) = patch(&harness).unwrap();
    assert_eq!((read(0), typed(&harness).as_str()), (100.0, ""));
    // An empty line is written from its beginning, one letter after the other.
    for letter in ["1", "2"] {
        harness.event(egui::Event::Text(letter.to_owned()));
        harness.step();
    }
    assert_eq!(typed(&harness), "12");
    for _ in 0..2 {
        press(&mut harness, Key::Backspace);
    }
    assert_eq!(typed(&harness), "");
    // By the key: the old value is there, and the next letters take its place.
    harness.key_press(Key::Backspace);
    harness.step();
    harness.run_steps(1);
    assert_eq!((patch(&harness).unwrap().1, typed(&harness).as_str()), (255.0, "100"));
    answer(&mut harness, "90");
    assert_eq!((read(0), patch(&harness).unwrap().1), (90.0, second));
    assert_eq!(typed(&harness), "", "the next patch was not read yet");
    // By the button, and with the letters right behind it.
    harness.get_by_label("Previous").click();
    harness.run_steps(2);
    harness.event(egui::Event::Text("8".to_owned()));
    harness.step();
    assert_eq!(typed(&harness), "8");
    // What is refused is selected too.
    answer(&mut harness, "x");
    harness.get_by_label_contains("is not a luminance");
    answer(&mut harness, "95.5");
    assert_eq!(read(0), 95.5);
    // The value as it was stays with Enter alone.
    harness.key_press(Key::Backspace);
    harness.run_steps(12);
    press(&mut harness, Key::Enter);
    assert_eq!((read(0), patch(&harness).unwrap().1), (95.5, second));
}

#[test]
fn replacing_a_profile_is_told_until_another_is_in_use() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, toml) = (folder.path().join("left.csv"), folder.path().join("left.toml"));
    let rows = [0.0, 0.25, 0.5, 0.75, 1.0].map(|v| format!("gray,{v},{}\n", cd_m2("gray", 255.0 * v)));
    std::fs::write(&csv, format!("channel,level,luminance_cd_m2\n{}", rows.concat())).unwrap();
    let mut harness = harness();
    click(&mut harness, "Measure…");
    for said in ["Saved as", "Replaced"] {
        click(&mut harness, "Photometer");
        fill(&mut harness, "File of readings", &csv.display().to_string());
        click(&mut harness, "Use this file");
        // The choice and the way to keep it come before the plots and the table.
        let top = |harness: &Window, text: &str| harness.get_by_label_contains(text).rect().top();
        assert!(top(&harness, "Chosen: gamma") < top(&harness, "Name of the screen"));
        assert!(top(&harness, "Save as") < top(&harness, "Luminance: readings"));
        assert!(top(&harness, "Distance of each reading") < top(&harness, "Largest error"));
        fill(&mut harness, "Save as", &toml.display().to_string());
        click(&mut harness, if said == "Replaced" { "Replace the profile" } else { "Save the profile" });
        harness.get_by_label_contains(said);
    }
    fill(&mut harness, "Profile in use", "other.toml");
    assert!(harness.query_by_label_contains("Replaced").is_none());
}

#[test]
fn a_file_of_readings_is_fitted_and_a_bad_one_explained() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |levels: &[f64]| {
        let row = |channel: &str, v: &f64| {
            format!("{},{v},{}\n", &channel[..if channel == "gray" { 4 } else { 1 }], cd_m2(channel, 255.0 * v))
        };
        let channels = ["red", "green", "blue", "gray"];
        let rows: String = channels.iter().flat_map(|channel| levels.iter().map(move |v| row(channel, v))).collect();
        format!("channel,level,luminance_cd_m2\n{rows}")
    };
    let good = folder.path().join("good.csv");
    std::fs::write(&good, rows(&[0.0, 0.25, 0.5, 0.75, 1.0])).unwrap();
    let bad = folder.path().join("bad.csv");
    std::fs::write(&bad, rows(&[0.0, 0.5, 1.0])).unwrap();
    let mut harness = harness();
    open(&mut harness);
    fill(&mut harness, "File of readings", &bad.display().to_string());
    click(&mut harness, "Use this file");
    harness.get_by_label_contains("red: too few levels: 3");
    take_picture(&mut harness, "display_photometer_fault");
    click(&mut harness, "Back");
    fill(&mut harness, "File of readings", &good.display().to_string());
    click(&mut harness, "Use this file");
    harness.get_by_label_contains("Chosen: gamma");
    harness.get_by_label_contains("Gray differs from the sum of its channels");
    take_picture(&mut harness, "display_photometer_result");
    press(&mut harness, Key::Escape);
    harness.get_by_label("Show patches");
}
