//! Every control has a name for assistive technology, and the keyboard reaches it.

use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use crate::window::{Role, Window, click, home, press, session_form, type_into};

/// The controls without a name.
fn nameless(window: &Window) -> Vec<String> {
    let is_control = |role: Role| {
        matches!(
            role,
            Role::Button
                | Role::CheckBox
                | Role::ColorWell
                | Role::ComboBox
                | Role::Link
                | Role::MultilineTextInput
                | Role::RadioButton
                | Role::Slider
                | Role::SpinButton
                | Role::TextInput
        )
    };
    let nodes = window.root().children_recursive();
    let controls = nodes.filter(|node| is_control(node.accesskit_node().role()));
    let is_nameless = |label: Option<String>| label.is_none_or(|label| label.trim().is_empty());
    controls
        .filter(|node| is_nameless(node.accesskit_node().label()))
        .map(|node| {
            format!("{:?} with the value {:?} at {:?}", node.accesskit_node().role(), node.value(), node.rect())
        })
        .collect()
}

fn go(window: &mut Window, place: Key) {
    window.key_press_modifiers(Modifiers::COMMAND, place);
    window.run_steps(30);
}

#[test]
fn every_control_of_every_place_has_a_name() {
    let mut window = home([1366.0, 768.0], 1.0 / 60.0);
    let named = |window: &Window, page: &str| {
        let found = nameless(window);
        assert!(found.is_empty(), "{page}: {found:#?}");
        let buttons = window.query_all_by_role(Role::Button).count();
        assert!(buttons > 5, "{page}: only {buttons} buttons");
    };
    named(&window, "Studies");
    session_form(&mut window);
    named(&window, "the form of a session");
    press(&mut window, Key::Escape);
    window.run_steps(5);
    click(&mut window, "Duplicate as…");
    window.run_steps(10);
    named(&window, "the editor");
    press(&mut window, Key::Escape);
    window.run_steps(5);
    press(&mut window, Key::F1);
    window.run_steps(5);
    window.get_by_label_contains("Keys of this page");
    named(&window, "the help");
    press(&mut window, Key::Escape);
    window.run_steps(5);
    assert!(window.query_by_label_contains("Keys of this page").is_none(), "Escape closes only the dialog");
    click(&mut window, "Settings");
    named(&window, "the settings");
    click(&mut window, "Close");
    go(&mut window, Key::Num3);
    for entry in machband::stimulus::catalog::all() {
        click(&mut window, &format!("Show {}", entry.title));
        named(&window, entry.title);
        window.get_by_label_contains(&entry.about[..20]);
        for parameter in entry.default_stimulus().parameters() {
            assert!(window.query_all_by_label(&parameter.label()).count() > 0, "{}: {}", entry.kind, parameter.name);
        }
    }
    go(&mut window, Key::Num4);
    named(&window, "Shading");
    go(&mut window, Key::Num5);
    named(&window, "Display");
    for tool in ["Photometer", "Patch size", "Gamma by eye", "Timing"] {
        click(&mut window, tool);
        named(&window, tool);
        press(&mut window, Key::Escape);
        window.run_steps(5);
    }
    go(&mut window, Key::Num2);
    named(&window, "Analyze");
}

/// What has the focus after each press of Tab.
fn tabbed(window: &mut Window, presses: usize) -> Vec<String> {
    let mut press_tab = || {
        press(window, Key::Tab);
        let focused = window.root().children_recursive().find(|node| node.is_focused());
        let focused = focused.expect("something has the focus");
        focused.accesskit_node().label().or_else(|| focused.value()).expect("it says so")
    };
    (0..presses).map(|_| press_tab()).collect()
}

/// What has the focus is scrolled into view.
#[test]
fn the_focus_stays_in_view() {
    let mut window = home([1366.0, 768.0], 1.0 / 60.0);
    click(&mut window, "Duplicate as…");
    window.run_steps(5);
    for _ in 0..70 {
        press(&mut window, Key::Tab);
        window.run_steps(2);
        let focused = window.root().children_recursive().find(|node| node.is_focused()).unwrap();
        let rect = focused.rect();
        let page = window.ctx.content_rect();
        assert!(page.contains_rect(rect), "{:?} at {rect:?}", focused.accesskit_node().label());
    }
}

/// Tab reaches every enabled button of a page from the side bar to the lower edge, and what has the focus says so.
#[test]
fn the_keyboard_reaches_every_button_in_reading_order() {
    let places = ["Studies", "Analyze", "Stimuli", "Shading", "Display", "Settings", "Help"];
    let mut window = home([1366.0, 768.0], 1.0 / 60.0);
    let reached = tabbed(&mut window, 60);
    assert_eq!(reached[..7], places);
    let place = |label: &&str| reached.iter().position(|one| one == label).unwrap_or_else(|| panic!("{reached:?}"));
    let order = ["Duplicate as…", "More", "New session"];
    assert!(order.iter().map(place).is_sorted(), "{reached:?}");
}

/// Escape closes an open list, then leaves a field, then goes back to the start page.
#[test]
fn escape_closes_the_innermost_thing_first() {
    let mut window = home([1366.0, 768.0], 1.0 / 60.0);
    go(&mut window, Key::Num3);
    let shows = |window: &Window, text: &str| window.query_all_by_label(text).next().is_some();
    click(&mut window, "Dither");
    assert!(shows(&window, "blue-noise"));
    press(&mut window, Key::Escape);
    window.run_steps(20);
    assert!(!shows(&window, "blue-noise") && shows(&window, "Export to"), "Escape closes only the list");
    type_into(&mut window, "Export to", "ramp.png");
    press(&mut window, Key::Escape);
    window.run_steps(3);
    assert!(!window.ctx.text_edit_focused() && shows(&window, "Export to"), "Escape leaves only the field");
    press(&mut window, Key::Escape);
    window.run_steps(3);
    assert!(shows(&window, "New session"), "Escape leaves the page");
}
