//! A window without a display; the test supplies clicks, keys and time.

use std::{path::Path, time::Duration};

use eframe::egui::{Key, Modifiers};
use egui_kittest::{
    Harness, HarnessBuilder,
    kittest::{NodeT as _, Queryable as _},
};
use machband::{
    app::{App, Launch, Request},
    display::DisplayProfile,
    experiment::{Identity, Protocol},
    light::CodeImage,
    store::{definition, session::Changes},
};

pub use eframe::egui::accesskit::Role;

pub type Window = Harness<'static, App>;

/// Builds a window of this size in which each frame takes `step_s` seconds.
pub fn builder(size: [f32; 2], step_s: f32) -> HarnessBuilder<App> {
    Harness::builder().with_size(size).with_pixels_per_point(1.0).with_step_dt(step_s)
}

/// A window that shows Home.
pub fn home(size: [f32; 2], step_s: f32) -> Window {
    let mut window = builder(size, step_s).build_eframe(|cc| App::new(cc, Launch::default()));
    window.set_render_cursor(false);
    window.run_steps(3);
    window
}

pub fn press(window: &mut Window, key: Key) {
    window.key_press(key);
    window.step();
}

/// Leaves a page with Escape, which first leaves the field in which the user is typing.
pub fn leave(window: &mut Window) {
    if window.ctx.text_edit_focused() {
        press(window, Key::Escape);
    }
    press(window, Key::Escape);
    window.run_steps(2);
}

/// Clicks a control; scrolls to it first if it is out of view.
pub fn click(window: &mut Window, label: &str) {
    // Finds a control, not a label with the same text.
    let find = |window: &Window| {
        let mut found = window.query_all_by_label(label).filter(|node| node.accesskit_node().role() != Role::Label);
        let node = found.next().unwrap_or_else(|| panic!("no {label:?} to click; there is {:?}", texts(window)));
        // The status line is above the lower edge.
        let (all, rect) = (window.ctx.content_rect(), node.rect());
        let is_on_page = all.contains_rect(rect) && rect.bottom() <= all.bottom() - 28.0;
        if is_on_page {
            node.click();
            return true;
        }
        node.scroll_to_me();
        false
    };
    if !find(window) {
        window.run_steps(30);
        window.query_all_by_label(label).find(|node| node.accesskit_node().role() != Role::Label).unwrap().click();
    }
    window.run_steps(3);
}

/// Replaces the text of a field, which keeps keyboard focus.
pub fn type_into(window: &mut Window, label: &str, text: &str) {
    let field = window.query_all_by_label(label).find(|node| node.value().is_some());
    field.unwrap_or_else(|| panic!("no field {label:?}; there is {:?}", texts(window))).focus();
    window.step();
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.step();
    window.query_all_by_label(label).find(|node| node.value().is_some()).unwrap().type_text(text);
    window.run_steps(2);
}

/// Opens the form of a session.
pub fn session_form(window: &mut Window) {
    click(window, "New session");
}

/// Chooses a study by the path of its definition, or the name of a built-in one.
pub fn open_study(window: &mut Window, definition: &str) {
    click(window, "Open a definition…");
    type_into(window, "Definition", definition);
    click(window, "Open");
}

/// Whether a study is chosen.
pub fn is_chosen(window: &Window, definition: &str) -> bool {
    let file = Path::new(definition).file_name().unwrap().to_str().unwrap().to_owned();
    let facts = format!("{file} · ");
    texts(window).iter().any(|text| *text == file || text.starts_with(&facts) && text.contains(" condition"))
}

/// The text in a field.
pub fn value(window: &Window, label: &str) -> String {
    window.query_all_by_label(label).find_map(|node| node.value()).unwrap_or_default()
}

/// Chooses an entry from a drop-down list.
pub fn choose(window: &mut Window, label: &str, entry: &str) {
    // A field of the page may have the name of an entry.
    let is_entry = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() == Role::Button;
    click(window, label);
    let found = window.query_all_by_label(entry).rfind(is_entry);
    found.unwrap_or_else(|| panic!("{label} has no {entry:?}; there is {:?}", texts(window))).scroll_to_me();
    window.run_steps(30);
    window.query_all_by_label(entry).rfind(is_entry).unwrap().click();
    window.run_steps(3);
    window.remove_cursor();
    // Wait until the list has faded out.
    window.run_steps(20);
}

/// Steps until the page shows a text. Computations on other threads may take a while.
pub fn wait_for(window: &mut Window, text: &str) {
    for step in 0..3000 {
        if window.query_all_by_label_contains(text).next().is_some() {
            return;
        }
        window.step();
        if step > 30 {
            std::thread::sleep(Duration::from_millis(10));
        }
    }
    panic!("{text:?} did not appear; there is {:?}", texts(window));
}

/// Every text on the page.
pub fn texts(window: &Window) -> Vec<String> {
    // A label's text is its value.
    let nodes = window.query_all_by_label_contains("").map(|node| node.accesskit_node());
    nodes.filter_map(|node| if node.label_comes_from_value() { node.value() } else { node.label() }).collect()
}

/// A session of P001 with the seed 5.
pub fn request(results: &Path, protocol: Protocol) -> Request {
    Request {
        protocol,
        identity: Identity::new("P001", "1").unwrap(),
        seed: Some(5),
        results: results.to_owned(),
        display: DisplayProfile::default(),
        distance_cm: 50.0,
        screen_width_cm: Some(30.0),
        resume: false,
        changes: Changes::Refuse,
        windowed: true,
    }
}

/// Waits for each of these pages and continues with Space.
pub fn walk(window: &mut Window, pages: &[&str]) {
    for page in pages {
        wait_for(window, page);
        press(window, Key::Space);
    }
}

/// Continues from the preflight to the first recovery field.
pub fn walk_to_first_trial(window: &mut Window) {
    walk(window, &["These findings are saved", "Welcome", "The answers", "First, some practice"]);
}

/// Types a folder and exports the analysis into it.
pub fn export_to(window: &mut Window, folder: &Path) {
    type_into(window, "Export to the folder", folder.to_str().unwrap());
    click(window, "Export");
    wait_for(window, "files written to");
}

/// Names the definition in the editor, and saves it in a folder.
pub fn save_as(window: &mut Window, name: &str, folder: &Path) -> Protocol {
    type_into(window, "Name", name);
    type_into(window, "Folder", folder.to_str().unwrap());
    click(window, "Save");
    definition::open(folder.join(format!("{name}.toml"))).unwrap()
}

/// Counts the pixels that differ between an image and the middle of a picture of the window. The picture has `size`
/// pixels.
pub fn wrong_pixels(size: [u32; 2], pixel: impl Fn(u32, u32) -> [u8; 4], image: &CodeImage) -> usize {
    let [left, top] = [size[0] - image.width, size[1] - image.height].map(|rest| rest / 2);
    let is_wrong = |(x, y): &(u32, u32)| {
        let [r, g, b] = image.pixel(*x, *y).map(|code| code as u8);
        pixel(left + x, top + y) != [r, g, b, 255]
    };
    (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y))).filter(is_wrong).count()
}
