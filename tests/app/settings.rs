//! What the window remembers, without a display.

use std::{fs, path::Path};

use machband::app::{App, Launch};

use egui_kittest::kittest::Queryable as _;

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
    click(&mut window, "Cancel");
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
