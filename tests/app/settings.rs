//! What the window remembers, and what it learns from the system: whether the screen is scaled, and when keys were pressed.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

use eframe::egui::Key;
use egui_kittest::kittest::Queryable as _;
use machband::app::{App, Input, Launch, Pressed, Stamps, is_resampled};
use x11rb::protocol::randr::{GetCrtcInfoReply, ModeInfo, Rotation};

use crate::window::{Window, builder, click, session_form, type_into, value};

fn opened(settings: &Path) -> Window {
    let launch = Launch { request: None, settings: Some(settings.to_owned()) };
    let mut window = builder([1366.0, 768.0], 1.0 / 60.0).build_eframe(|cc| App::new(cc, launch));
    window.run_steps(3);
    window
}

#[test]
fn what_was_typed_is_remembered_and_participants_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deeper/settings.toml");
    let results = folder.path().join("my results").display().to_string();
    let mut window = opened(&path);
    session_form(&mut window);
    type_into(&mut window, "Participant", "Secret7");
    type_into(&mut window, "Viewing distance, cm", "71");
    type_into(&mut window, "Screen width, cm", "40.5");
    type_into(&mut window, "Results folder", &results);
    click(&mut window, "Close");
    click(&mut window, "Display");
    type_into(&mut window, "Display profile", "/screens/left.toml");
    click(&mut window, "Settings");
    click(&mut window, "Light");
    click(&mut window, "Close");
    // Written once nothing has changed for a second.
    window.run_steps(90);
    drop(window);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("theme = \"light\"") && !text.contains("Secret7"), "{text}");
    let mut window = opened(&path);
    session_form(&mut window);
    for (field, expected) in [
        ("Viewing distance, cm", "71"),
        ("Screen width, cm", "40.5"),
        ("Results folder", &results),
        ("Display profile", "/screens/left.toml"),
        ("Participant", "P001"),
    ] {
        assert_eq!(value(&window, field), expected, "{field}");
    }
    assert!(!window.ctx.global_style().visuals.dark_mode);
}

/// Settings that could not be saved are not given up: the next chance writes them.
#[test]
fn settings_that_cannot_be_saved_are_told_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let blocked = folder.path().join("blocked");
    fs::write(&blocked, "").unwrap();
    let path = blocked.join("settings.toml");
    let mut window = opened(&path);
    click(&mut window, "Settings");
    click(&mut window, "Light");
    window.run_steps(90);
    assert!(window.query_all_by_label_contains("The settings cannot be saved.").next().is_some());
    fs::remove_file(&blocked).unwrap();
    eframe::App::on_exit(window.state_mut());
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("theme = \"light\""), "{text}");
    // The results folder is found again from any other folder.
    let results = std::path::absolute("results").unwrap().display().to_string();
    click(&mut window, "Close");
    session_form(&mut window);
    assert_eq!(value(&window, "Results folder"), results);
    assert!(text.contains(&format!("results = \"{results}\"")), "{text}");
}

/// A file that cannot be read is explained and left as it is, because its owner may want to repair it.
#[test]
fn a_broken_file_is_explained_and_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("settings.toml");
    for (broken, expected) in [
        ("schema = 1\ntheme = \"purple\"\n", "settings.toml:2:1: theme"),
        ("schema = 1\nzoom = 40.0\n", "zoom 40 is outside 0.2…5"),
        ("schema = 1\nresult = \"x\"\n", "settings.toml:2:1"),
        ("theme = [", "is not valid TOML"),
        ("", "schema is missing"),
    ] {
        fs::write(&path, broken).unwrap();
        let mut window = opened(&path);
        // The status line says it first, and then the settings do.
        window.get_by_label_contains(expected);
        click(&mut window, "Settings");
        assert_eq!(window.query_all_by_label_contains(expected).count(), 2);
        window.get_by_label_contains("changes are not remembered");
        click(&mut window, "Dark");
        window.run_steps(90);
        drop(window);
        assert_eq!(fs::read_to_string(&path).unwrap(), broken);
    }
}

#[test]
fn a_scaled_screen_is_resampled_and_a_rotated_one_is_not() {
    let mode = ModeInfo { width: 1920, height: 1080, ..ModeInfo::default() };
    for (width, height, rotation, expected) in [
        (1920, 1080, Rotation::ROTATE0, false),
        (1080, 1920, Rotation::ROTATE90, false),
        (1080, 1920, Rotation::ROTATE270, false),
        (1920, 1080, Rotation::ROTATE90, true),
        (2880, 1620, Rotation::ROTATE0, true),
    ] {
        let shown = GetCrtcInfoReply { width, height, rotation, ..GetCrtcInfoReply::default() };
        assert_eq!(is_resampled(&mode, &shown), expected, "{width} × {height}, {rotation:?}");
    }
}

#[test]
fn each_press_is_given_once_in_its_order_and_at_its_own_time() {
    let (start, ms) = (Instant::now(), Duration::from_millis);
    let stamps = Stamps::default();
    let mut input = Input::stamped(stamps.clone());
    // The first frame puts the window's zero at 2 ms, the second at 0.5 ms, which is nearer to the truth.
    input.frame(1.0, start + ms(1002));
    input.frame(2.0, start + Duration::from_micros(2_000_500));
    for (what, at, unseen) in
        [(Pressed::Key(Key::Num1), 2103, 3), (Pressed::Click, 2104, 1), (Pressed::Key(Key::Num1), 2108, 5)]
    {
        stamps.press(what, start + ms(at), ms(unseen));
    }
    assert_eq!(input.key(Key::Num1), None, "not before the frame");
    input.frame(2.11, start + ms(2112));
    let key = |key| input.key(key).map(|press| ((press.at_s * 1e4).round(), press.uncertainty));
    let expected = [Some((21_025.0, Some(ms(3)))), None, Some((21_075.0, Some(ms(5)))), None];
    assert_eq!([Key::Num1, Key::Num2, Key::Num1, Key::Num1].map(key), expected);
    assert_eq!(input.click().and_then(|press| press.uncertainty), Some(ms(1)));
    // The next frame discards presses that have not been read.
    stamps.press(Pressed::Click, start + ms(2113), ms(1));
    input.frame(2.12, start + ms(2120));
    input.frame(2.13, start + ms(2130));
    assert_eq!(input.click(), None);
}
