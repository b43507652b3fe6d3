//! Tests the start page and what surrounds it in the real window. A copy of the page without a display tells where each
//! control is; the mouse and the keyboard of the virtual screen do the rest.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use eframe::egui::{Key, Modifiers, Pos2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use machband::app::{App, Launch};

use crate::{
    common,
    harness::{Harness, SCREEN, SHORT_DEFINITION, Shown, pattern, rows},
    pane::{self, Role},
};

/// The zoom of the window: more of a page fits the small screen.
const ZOOM: f32 = 0.75;

/// The program in the window, started without arguments, and a copy of it without a display.
struct Desk {
    harness: Harness,
    /// The X window.
    window: String,
    copy: pane::Window,
}

impl Desk {
    /// Starts the program with settings that name a results folder and a definition.
    fn open() -> Option<Self> {
        let mut harness = Harness::new()?;
        let definition = harness.swift();
        let settings = format!(
            "schema = 1\ntheme = \"light\"\nzoom = {ZOOM:?}\nresults = {:?}\n[recent]\nexperiments = [{definition:?}]\n",
            harness.results()
        );
        fs::write(harness.dir.path().join("settings.toml"), settings).unwrap();
        harness.start(&["--config", "settings.toml"]);
        Some(Self::of(harness))
    }

    /// Copies the program in the window, which shows the start page.
    fn of(mut harness: Harness) -> Self {
        harness.until("the window", |harness| !harness.ask(&["search", "--name", "^machband$"]).is_empty());
        harness.at_rest();
        let window = harness.ask(&["search", "--name", "^machband$"]);
        let geometry = harness.ask(&["getwindowgeometry", "--shell", &window]);
        let side = |name: &str| {
            let line = geometry.lines().find_map(|line| line.strip_prefix(name)).unwrap();
            line.parse::<f32>().unwrap()
        };
        assert!(side("HEIGHT=") < f32::from(SCREEN.1), "the window and its title bar fit the screen");
        // The copy must not write the program's file. Without a window, it has the same layout in a larger size.
        let settings = harness.dir.path().join("copy.toml");
        let text = fs::read_to_string(harness.dir.path().join("settings.toml")).unwrap();
        assert!(text.contains(&format!("zoom = {ZOOM:?}")), "{text}");
        fs::write(&settings, text.replace(&format!("zoom = {ZOOM:?}"), "zoom = 1.0")).unwrap();
        let launch = Launch { request: None, settings: Some(settings) };
        let size = [side("WIDTH=") / ZOOM, side("HEIGHT=") / ZOOM];
        let mut copy = pane::builder(size, 1.0 / 60.0).build_eframe(|cc| App::new(cc, launch));
        // The sessions are read on another thread.
        for _ in 0..20 {
            copy.step();
            std::thread::sleep(Duration::from_millis(10));
        }
        Self { harness, window, copy }
    }

    /// Clicks a control, in the window and in the copy.
    fn click(&mut self, label: &str) {
        let found =
            self.copy.query_all_by_label_contains(label).find(|node| node.accesskit_node().role() != Role::Label);
        let at =
            found.unwrap_or_else(|| panic!("no {label:?}; there is {:?}", pane::texts(&self.copy))).rect().center();
        self.click_at(at);
        self.copy
            .query_all_by_label_contains(label)
            .find(|node| node.accesskit_node().role() != Role::Label)
            .unwrap()
            .click();
        self.copy.run_steps(20);
        std::thread::sleep(Duration::from_millis(400));
    }

    /// Clicks only in the window.
    fn click_at(&self, at: Pos2) {
        let [x, y] = [at.x, at.y].map(|points| (points * ZOOM).to_string());
        self.harness.xdotool(&["mousemove", "--window", &self.window, &x, &y, "click", "1"]);
    }

    /// Moves the focus with Tab until a control has it; the page scrolls to where it is.
    fn tab_to(&mut self, label: &str) {
        let has_focus =
            |copy: &pane::Window| copy.query_all_by_label(label).any(|node| node.accesskit_node().is_focused());
        let mut presses = 0;
        while !has_focus(&self.copy) {
            self.copy.key_press(Key::Tab);
            self.copy.run_steps(3);
            presses += 1;
            assert!(presses < 200, "Tab does not reach {label:?}; there is {:?}", pane::texts(&self.copy));
        }
        // Two presses within one frame would move the focus once.
        self.harness.xdotool(&["key", "--repeat", &presses.to_string(), "--delay", "250", "Tab"]);
        std::thread::sleep(Duration::from_millis(300));
    }

    /// Goes to a place by its number.
    fn go(&mut self, place: usize) {
        self.harness.press(&format!("ctrl+{place}"));
        let key = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5][place - 1];
        self.copy.key_press_modifiers(Modifiers::COMMAND, key);
        self.copy.run_steps(30);
    }

    /// Replaces the text of a field, in the window and in the copy.
    fn type_into(&mut self, label: &str, text: &str) {
        // A click on a field that is out of view would miss it in the window.
        let field = self.copy.query_all_by_label(label).find(|node| node.value().is_some()).unwrap().rect();
        assert!(self.copy.ctx.content_rect().contains_rect(field), "{label}: {field:?}");
        self.click(label);
        self.harness.xdotool(&["key", "ctrl+a"]);
        self.harness.xdotool(&["type", "--delay", "30", text]);
        pane::type_into(&mut self.copy, label, text);
        std::thread::sleep(Duration::from_millis(300));
    }

    /// The screen once it no longer changes, with the mouse where it hovers over nothing.
    fn screen(&mut self) -> Vec<u8> {
        self.harness.xdotool(&["mousemove", "1", "1"]);
        self.harness.at_rest();
        self.harness.screen()
    }

    /// The rows of the first participant of an experiment.
    fn csv(&self, experiment: &str) -> PathBuf {
        common::session_csv(&self.harness.dir.path().join("results"), experiment, "P001")
    }

    fn wait_until_complete(&mut self, csv: &Path) {
        self.harness.until("the sidecar to say complete", |_| {
            let sidecar = fs::read_to_string(csv.with_extension("json")).unwrap_or_default();
            sidecar.contains("\"complete\": true")
        });
    }

    fn settings(&self) -> String {
        fs::read_to_string(self.harness.dir.path().join("settings.toml")).unwrap()
    }
}

#[test]
fn an_aborted_session_is_offered_and_resumed_by_one_click() {
    let Some(mut desk) = Desk::open() else { return };
    desk.click("A short session for tests");
    desk.harness.press("Return");
    let csv = desk.csv("swift");
    desk.harness.rate(&csv, "1");
    desk.harness.rate(&csv, "2");
    // Quitting during a trial asks. Esc answers no, and the same session continues.
    desk.harness.stimulus();
    desk.harness.press("ctrl+q");
    desk.harness.until("the question", |harness| harness.shown() == Shown::Page);
    std::thread::sleep(Duration::from_millis(700));
    assert!(desk.harness.ended().is_none(), "quitting must ask");
    desk.harness.press("Escape");
    std::thread::sleep(Duration::from_millis(300));
    desk.harness.rate(&csv, "3");
    desk.harness.stimulus();
    desk.harness.press("ctrl+q");
    desk.harness.until("the question", |harness| harness.shown() == Shown::Page);
    std::thread::sleep(Duration::from_millis(300));
    // Quitting again answers yes.
    desk.harness.press("ctrl+q");
    assert!(desk.harness.wait_for_end().success());
    assert_eq!(rows(&csv).len(), 3);

    // The settings have survived; they name no participant.
    let settings = desk.settings();
    assert!(settings.contains("theme = \"light\""), "{settings}");
    assert!(!settings.contains("P001"), "{settings}");
    let mut harness = desk.harness;
    harness.start(&["--config", "settings.toml"]);
    let mut desk = Desk::of(harness);
    desk.copy.get_by_label_contains("P001, session 1: unfinished, 3 of 6 trials");
    desk.click("Resume P001, session 1");
    for key in ["0", "1", "2"] {
        desk.harness.rate(&csv, key);
    }
    desk.wait_until_complete(&csv);
    let output = common::machband(desk.harness.dir.path(), &["verify", csv.parent().unwrap().to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
}

/// Escape closes an open list, then leaves a field, then goes back to the start page.
#[test]
fn escape_closes_the_innermost_thing_first() {
    let Some(mut desk) = Desk::open() else { return };
    let start = desk.screen();
    desk.go(3);
    let gallery = desk.screen();
    assert!(gallery != start);
    desk.click("Dither");
    assert!(desk.harness.screen() != gallery, "the list is open");
    desk.harness.press("Escape");
    assert!(desk.screen() == gallery, "Escape closes only the list");
    desk.click("Export to");
    desk.harness.press("Escape");
    assert!(desk.screen() == gallery, "Escape leaves only the field");
    desk.harness.press("Escape");
    assert!(desk.screen() == start, "Escape leaves the page");
    desk.harness.press("ctrl+q");
    assert!(desk.harness.wait_for_end().success(), "outside a session, quitting does not ask");
}

/// An experiment is duplicated, changed, run and analyzed without a text editor.
#[test]
fn an_experiment_is_duplicated_run_and_analyzed() {
    let Some(mut desk) = Desk::open() else { return };
    desk.click("A short session for tests");
    desk.click("Duplicate as…");
    desk.type_into("Name", "own");
    desk.tab_to("Levels of width");
    desk.harness.xdotool(&["key", "ctrl+a"]);
    desk.harness.xdotool(&["type", "--delay", "30", "0.3, 0.6, 0.9"]);
    pane::type_into(&mut desk.copy, "Levels of width", "0.3, 0.6, 0.9");
    desk.tab_to("Remove depth");
    desk.harness.press("space");
    let path = desk.harness.dir.path().join("own.toml");
    desk.harness.press("ctrl+s");
    desk.harness.until("the definition", |_| path.exists());
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(
        text,
        SHORT_DEFINITION
            .replace("swift", "own")
            .replace("for tests", "for tests (copy)")
            .replace("[0.1, 0.8]\ndepth = [1, \"inf\"]", "[0.3, 0.6, 0.9]")
    );
    desk.screen();
    desk.harness.press("Return");
    let csv = desk.csv("own");
    for i in 0..5 {
        desk.harness.rate(&csv, pattern(i));
    }
    desk.wait_until_complete(&csv);
    let main: Vec<_> = rows(&csv).into_iter().filter(|row| row["phase"] == "main").collect();
    assert_eq!(main.len(), 3);
    // Back to the start page, and on to the results.
    desk.harness.until("the last page", |harness| harness.shown() == Shown::Page);
    desk.screen();
    desk.harness.press("Return");
    desk.screen();
    let mut desk = Desk::of(desk.harness);
    let offered = desk.screen();
    desk.click("More actions");
    desk.click("Analyze this study");
    pane::wait_for(&mut desk.copy, "3 ratings by 1 participant.");
    desk.harness.until("the results", |harness| harness.screen() != offered);
    desk.harness.press("ctrl+q");
    assert!(desk.harness.wait_for_end().success());
}
