//! Tests both ways to measure the screen's light without a display, with a photometer and by eye, from the settings to
//! the profile.

use std::path::Path;

use eframe::egui::{self, Key};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use machband::{
    display::{
        Channel,
        matching::{Match, MatchSettings},
    },
    light::{Transfer, Transfers},
    store::{matches, profile, readings},
};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

use super::{
    common::eye::matched_code,
    window::{Window, click, home, press, type_into},
};

const GAMMAS: [f64; 3] = [1.9, 2.2, 2.5];

/// Opens a tool of the display lab; each frame takes `step_s` seconds.
fn tool(name: &str, step_s: f32) -> Window {
    let mut window = home([1000.0, 1000.0], step_s);
    click(&mut window, "Display");
    click(&mut window, name);
    window
}

fn press_and_step(window: &mut Window, key: Key) {
    press(window, key);
    window.step();
}

/// Channel and code of the displayed patch; `None` if no patch is shown.
fn patch(window: &Window) -> Option<(String, f64)> {
    let node = window.query_by_label_contains("Patch ")?;
    let name = node.accesskit_node().label()?;
    let mut words = name.split(' ').skip(1);
    Some((words.next()?.to_owned(), words.next()?.parse().ok()?))
}

/// The label of the field for the reading.
fn line(window: &Window) -> String {
    let (channel, code) = patch(window).unwrap();
    format!("{channel} {code} · cd/m²")
}

/// Color of the pixel in the middle of the window.
fn middle(window: &mut Window) -> [u8; 3] {
    let image = window.render().unwrap();
    let [red, green, blue, _] = image.get_pixel(image.width() / 2 + 50, image.height() / 2 + 50).0;
    [red, green, blue]
}

fn cd_m2(channel: &str, code: f64) -> f64 {
    let range = match channel {
        "r" | "red" => 25.0,
        "g" | "green" => 80.0,
        "b" | "blue" => 10.0,
        _ => 115.0,
    };
    0.3 + range * (code / 255.0f64).powf(2.2)
}

/// Waits until the patch has settled, types into the field, which has keyboard focus, and presses Enter.
fn answer(window: &mut Window, text: &str) {
    window.run_steps(22);
    window.event(egui::Event::Text(text.to_owned()));
    window.run_steps(2);
    press_and_step(window, Key::Enter);
}

/// Starts the patches for the gray channel only.
fn show_patches(csv: &Path) -> Window {
    let mut window = tool("Photometer", 0.1);
    type_into(&mut window, "File of measurements", csv.to_str().unwrap());
    click(&mut window, "red, green, blue");
    click(&mut window, "Begin");
    window
}

/// A screen that dims large bright areas is found; the readings are saved and can be read again.
#[test]
fn a_screen_that_dims_large_areas_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("sizes.csv");
    let mut window = tool("Patch size", 0.1);
    type_into(&mut window, "File of measurements", csv.to_str().unwrap());
    click(&mut window, "Begin");
    let mut heights = Vec::new();
    for reading in ["250", "250", "240", "210", "180"] {
        heights.push(window.get_by_label("Patch gray 255").rect().height());
        answer(&mut window, reading);
    }
    assert!(heights.is_sorted_by(|a, b| a < b), "{heights:?}");
    window.get_by_label_contains("White changes by 28 % with the size of the patch");
    assert_eq!(readings::open_incomplete(&csv).unwrap().len(), 5);
}

#[test]
fn patches_are_read_and_become_a_profile() {
    if !crate::common::has_graphics() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (csv, toml) = (folder.path().join("left.csv"), folder.path().join("left.toml"));
    let mut window = show_patches(&csv);
    // White comes first. Text that is not a number is rejected, and so is a reading before the patch has settled.
    assert_eq!(patch(&window), Some(("gray".to_owned(), 255.0)));
    assert_eq!(middle(&mut window), [255, 255, 255]);
    answer(&mut window, "bright");
    window.get_by_label_contains("is not a luminance; expected cd/m²");
    assert_eq!(readings::open_incomplete(&csv).unwrap(), []);
    type_into(&mut window, "gray 255 · cd/m²", "115.3");
    press_and_step(&mut window, Key::Enter);
    let second = patch(&window).unwrap();
    assert_eq!(middle(&mut window), [second.1 as u8; 3], "byte for byte");
    assert_eq!(readings::open_incomplete(&csv).unwrap().len(), 1, "saved at once");
    window.event(egui::Event::Text("1".to_owned()));
    press_and_step(&mut window, Key::Enter);
    window.get_by_label_contains("has not settled yet");
    // A reading above the reading for white must be confirmed. Here it is corrected, and the user goes back one patch.
    let label = line(&window);
    type_into(&mut window, &label, "900");
    window.run_steps(12);
    press_and_step(&mut window, Key::Enter);
    window.get_by_label_contains("does not fit gray 255");
    type_into(&mut window, &label, &cd_m2("gray", second.1).to_string());
    press_and_step(&mut window, Key::Enter);
    click(&mut window, "Previous");
    assert_eq!(patch(&window).unwrap(), second);
    window.run_steps(12);
    press_and_step(&mut window, Key::Enter);
    // After leaving and returning, the same settings resume the run.
    click(&mut window, "Pause");
    window.get_by_label_contains("This file exists already.");
    click(&mut window, "Back");
    click(&mut window, "Photometer");
    window.get_by_label_contains("This file exists already.");
    click(&mut window, "Resume");
    let mut n = 2;
    while let Some((channel, code)) = patch(&window) {
        answer(&mut window, &cd_m2(&channel, code).to_string());
        n += 1;
        assert!(n < 60, "the patches never end");
    }
    assert_eq!(readings::open(&csv).unwrap().all().len(), n);
    window.get_by_label_contains("Chosen: gamma");
    window.get_by_label_contains("red, green, blue not measured");
    for (label, text) in [("Measured by", "AB"), ("Measured with", "LS-150"), ("Save as", toml.to_str().unwrap())] {
        type_into(&mut window, label, text);
    }
    click(&mut window, "Save the profile");
    window.get_by_label_contains("Saved as");
    let made = profile::open(&toml).unwrap();
    let Some(Transfer::Gamma(gamma)) = made.transfers.uniform() else { panic!("{:?}", made.transfers) };
    assert!((gamma - 2.2).abs() < 1e-6, "{gamma}");
    let measured = made.measured.unwrap();
    assert_eq!((measured.by.as_deref(), measured.with.as_deref()), (Some("AB"), Some("LS-150")));
}

/// For a file with too few levels, the page gives the reason; a good file is fitted.
#[test]
fn a_file_of_readings_becomes_a_profile_and_a_bad_one_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let write = |name: &str, levels: &[f64]| {
        let row = |channel: &str, v: &f64| format!("{channel},{v},{}\n", cd_m2(channel, 255.0 * v));
        let rows = ["r", "g", "b", "gray"].iter().flat_map(|channel| levels.iter().map(move |v| row(channel, v)));
        std::fs::write(path(name), format!("channel,level,luminance_cd_m2\n{}", rows.collect::<String>())).unwrap();
    };
    write("bad.csv", &[0.0, 0.5, 1.0]);
    write("good.csv", &[0.0, 0.25, 0.5, 0.75, 1.0]);
    let mut window = tool("Photometer", 0.1);
    type_into(&mut window, "File of measurements", &path("bad.csv"));
    click(&mut window, "Use this file");
    window.get_by_label_contains("red: too few levels: 3");
    // The error is beside the field, where another file can be typed.
    type_into(&mut window, "File of measurements", &path("good.csv"));
    assert!(window.query_by_label_contains("too few levels").is_none());
    click(&mut window, "Use this file");
    window.get_by_label_contains("gray differs from red + green + blue");
    type_into(&mut window, "Save as", &path("left.toml"));
    click(&mut window, "Save the profile");
    window.get_by_label_contains("Saved as");
    assert!(profile::open(Path::new(&path("left.toml"))).unwrap().luminance.is_some());
}

/// The displayed match, read from its description; `None` at the end.
fn next_match(window: &mut Window) -> Option<Match> {
    for _ in 0..40 {
        let label = window.query_by_label_contains("rows lit in ").and_then(|node| node.accesskit_node().label());
        if let Some(label) = label {
            let channel = Channel::ALL.iter().find(|channel| label.contains(&format!("in {channel};")))?;
            let code = label.rsplit(' ').next()?.parse().ok()?;
            return Some(Match { channel: *channel, rows: MatchSettings::default().rows, code });
        }
        if window.query_by_label("Result").is_some() {
            return None;
        }
        window.step();
    }
    panic!("no match was shown");
}

/// Adjusts the square as an observer would, and accepts the match.
fn adjust(window: &mut Window, now: Match, rng: &mut ChaCha8Rng) {
    let display = Transfers::new(GAMMAS.map(Transfer::Gamma));
    let wanted = i32::from(matched_code(&display, &now, 0.004, rng));
    for _ in 0..60 {
        let key = match wanted - i32::from(next_match(window).unwrap().code) {
            10.. => Key::PageUp,
            1.. => Key::ArrowRight,
            0 => break,
            ..=-10 => Key::PageDown,
            _ => Key::ArrowLeft,
        };
        press_and_step(window, key);
    }
    press_and_step(window, Key::Enter);
}

#[test]
fn an_observer_finds_the_gamma_of_the_screen_with_the_keys() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, toml) = (folder.path().join("new/matches.csv"), folder.path().join("left.toml"));
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut window = tool("Gamma by eye", 1.0 / 30.0);
    window.get_by_label_contains("30 matches, about 5 min");
    click(&mut window, "red, green, blue");
    window.get_by_label_contains("expected red, green, and blue, or gray");
    click(&mut window, "red, green, blue");
    type_into(&mut window, "File of measurements", csv.to_str().unwrap());
    // The minimum of the slider.
    let slider = window.query_all_by_label("Matches per channel").find(|node| node.value().is_some());
    slider.unwrap().focus();
    window.step();
    (0..10).for_each(|_| press(&mut window, Key::ArrowLeft));
    window.get_by_label_contains("6 matches, about 1 min");
    click(&mut window, "Begin");
    // This press is too early, because no match is shown yet.
    press(&mut window, Key::Enter);
    for given in 0.. {
        let Some(now) = next_match(&mut window) else { break };
        adjust(&mut window, now, &mut rng);
        if given == 2 {
            // After Backspace, the match is shown again with its accepted code. A pause keeps the saved matches.
            press(&mut window, Key::Backspace);
            assert_eq!(next_match(&mut window).unwrap().channel, now.channel);
            press(&mut window, Key::Escape);
            window.run_steps(2);
            window.get_by_label_contains("This file exists already.");
            click(&mut window, "Back");
            click(&mut window, "Gamma by eye");
            click(&mut window, "Resume");
        }
    }
    // Gamma and, because there are only two matches, a warning about its precision.
    for label in ["Red: gamma", "Blue: gamma"] {
        assert!(window.get_all_by_label_contains(label).count() >= 1);
    }
    type_into(&mut window, "Measured by", "N. N.");
    type_into(&mut window, "Save as", toml.to_str().unwrap());
    click(&mut window, "Save the profile");
    window.get_by_label_contains("Saved as");

    let saved = profile::open(&toml).unwrap();
    for (transfer, gamma) in saved.transfers.channels().iter().zip(GAMMAS) {
        let Transfer::Gamma(found) = transfer else { panic!("{transfer}") };
        assert!((found - gamma).abs() < 0.06, "{found} for {gamma}");
    }
    let measured = saved.measured.unwrap();
    assert_eq!((measured.by.as_deref(), measured.with.as_deref()), (Some("N. N."), Some("matching by eye, 6 matches")));
    assert!(measured.on.is_some());

    let text = std::fs::read_to_string(&csv).unwrap();
    assert_eq!(text.lines().count(), 1 + 6 + 2, "every match is in the file, even the undone one: {text}");
    assert_eq!(matches::open(&csv).unwrap().len(), 6);
    let wrong = folder.path().join("m.csv");
    std::fs::write(&wrong, text.replace(",red,", ",rot,")).unwrap();
    let errors = matches::open(&wrong).unwrap_err().to_string();
    assert!(errors.contains("expected one of red, green, blue, gray"), "{errors}");
    // An incomplete row, as after a power failure, is removed, and the next row follows the last complete one.
    std::fs::write(&csv, &text[..text.len() - 5]).unwrap();
    let (mut file, done) = matches::MatchFile::begin(&csv, 0).unwrap();
    assert_eq!(done.len(), 5);
    file.record(6, &done[0], 1.0, false).unwrap();
    assert_eq!(matches::open(&csv).unwrap().len(), 6);
    assert!(matches::MatchFile::begin(&csv, 0).is_err(), "the file is already open");
}
