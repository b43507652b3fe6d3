//! Tests the predicted bands in the gallery and in the shading demo without a display: they agree with the library, and
//! the window does not wait for them.

use eframe::egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::kittest::{By, NodeT as _, Queryable as _};
use machband::stimulus::{MachBand, Stimulus, ViewingConditions, Visible};

use crate::{
    shading::await_numbers,
    window::{Window, choose, click, home, type_into, value},
};

fn open(page: &str, size: [f32; 2]) -> Window {
    let mut window = home(size, 1.0 / 60.0);
    click(&mut window, page);
    window.remove_cursor();
    window.run_steps(2);
    window
}

fn text(window: &Window, beginning: &str) -> String {
    let node = window.get_by_label_contains(beginning);
    node.accesskit_node().label().or_else(|| node.value()).unwrap()
}

/// The expected sentence for a stimulus in a window of 10°.
fn sentence(stimulus: &Stimulus, size: u32) -> String {
    let Visible::Ramp(bands) = ViewingConditions::new(10.0).visible(&[stimulus], Some(size)).unwrap().remove(0) else {
        panic!("no ramp")
    };
    format!("{:.1} times the threshold. The dark band is at {:.1}.", bands.bright, bands.dark)
}

#[test]
fn the_gallery_marks_both_ends_of_a_ramp_and_none_of_a_step() {
    let mut window = open("Stimuli", [1100.0, 860.0]);
    let ramp = |width| Stimulus::MachBand(MachBand { width, ..MachBand::default() });
    assert!(text(&window, "The bright band, which").ends_with(&sentence(&ramp(0.4), 512)));
    let set_width = |window: &mut Window, width: f64| {
        window.query_all_by_label("Width").find(|node| node.value().is_some()).unwrap().set_value_accesskit(width);
        window.run_steps(3);
    };
    // The dark plateau is on the left.
    set_width(&mut window, 0.1);
    let marks = text(&window, "Plot: light, ");
    let places: Vec<&str> = marks.trim_start_matches("Plot: light, predicted bands: ").split(", ").collect();
    assert_eq!(places.len(), 2, "{marks}");
    for (word, end) in [("dark", -0.05), ("bright", 0.05)] {
        let place =
            places.iter().find_map(|place| place.strip_prefix(word)).unwrap_or_else(|| panic!("{word}: {marks}"));
        let place: f64 = place.trim_start_matches(" at ").parse().unwrap();
        assert!((place - end).abs() < 0.015, "{word}: {marks}");
    }
    set_width(&mut window, 0.0);
    assert_eq!(text(&window, "Plot: light, "), "Plot: light, no predicted band");
    assert!(text(&window, "The bright band, which").ends_with(&sentence(&ramp(0.0), 512)));
}

/// Undo, Redo and Reset restore the settings, and each kind keeps its own.
#[test]
fn settings_of_the_gallery_are_undone_and_kept_for_each_kind() {
    let mut window = open("Stimuli", [1366.0, 740.0]);
    type_into(&mut window, "Depth", "3");
    choose(&mut window, "Dither", "ordered");
    let settings = |window: &Window| [value(window, "Depth"), value(window, "Dither")];
    click(&mut window, "Undo");
    assert_eq!(settings(&window), ["3", "none"]);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(2);
    assert_eq!(settings(&window), ["1", "none"]);
    for _ in 0..2 {
        window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
        window.run_steps(2);
    }
    assert_eq!(settings(&window), ["3", "ordered"]);
    choose(&mut window, "Stimulus", "Mach band");
    assert_eq!(settings(&window), ["3", "ordered"]);
    click(&mut window, "Reset");
    assert_eq!(settings(&window), ["1", "none"]);
    click(&mut window, "Undo");
    assert_eq!(settings(&window), ["3", "ordered"]);
}

/// The left and right cells of the row of the visible difference.
fn differences(window: &Window) -> Vec<String> {
    let head = window.get_by_label("visible difference, times the threshold").rect();
    let mut cells: Vec<_> = window
        .query_all(By::new().predicate(|node| node.role() == Role::Label))
        .map(|node| (node.rect(), node.accesskit_node().value().or_else(|| node.accesskit_node().label())))
        .filter(|(rect, _)| rect.left() > head.right() && rect.y_range().contains(head.center().y))
        .map(|(rect, text)| (rect.left(), text.unwrap()))
        .collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    cells.into_iter().map(|(_, text)| text).collect()
}

fn predicted(window: &mut Window) -> [f64; 2] {
    await_numbers(window);
    let numbers: Vec<f64> =
        differences(window).iter().map(|text| text.parse().unwrap_or_else(|_| panic!("{text:?}"))).collect();
    numbers.try_into().unwrap()
}

#[test]
fn the_demo_predicts_without_waiting() {
    let mut window = open("Shading", [900.0, 800.0]);
    click(&mut window, "Details");
    // The page has been drawn several times without waiting for the prediction.
    assert_eq!(differences(&window), ["…", "…"]);
    let [gouraud, c1] = predicted(&mut window);
    assert!(c1 < gouraud, "{c1} {gouraud}");
}
