//! The measurement of frames, driven without a display: here every frame takes a 60th of a second.

use std::{fs, sync::mpsc};

use eframe::egui::Key;
use egui_kittest::kittest::Queryable as _;
use machband::app::{
    App,
    timing::{Patch, Scene, TimingPlan, TimingRequest},
};

use super::window::{Window, builder, click, home, take_picture, type_into};

/// Display, then Timing, from Home.
fn pane() -> Window {
    let mut window = home([1000.0, 900.0], 1.0 / 60.0);
    click(&mut window, "Measure…");
    click(&mut window, "Timing");
    window
}

fn says(window: &Window, text: &str) -> bool {
    window.query_all_by_label_contains(text).next().is_some()
}

#[test]
fn the_pane_measures_tells_and_exports() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("frames.csv");
    let mut window = pane();
    assert!(!says(&window, "photosensitive"), "the trial does not flicker");
    click(&mut window, "Measure");
    window.run_steps(640);
    for text in ["600", "60.000 Hz, 16.667 ms, measured", "dropped frames", "missed refreshes"] {
        assert!(says(&window, text), "{text}");
    }
    assert!(says(&window, "16.667 ms"));
    assert!(says(&window, "The frames follow the refresh of 60.00 Hz one by one: none of 600 was dropped."));
    take_picture(&mut window, "display_timing");
    type_into(&mut window, "Export to", out.to_str().unwrap());
    click(&mut window, "Export");
    let csv = fs::read_to_string(&out).unwrap();
    assert_eq!(csv.lines().next(), Some("frame,interval_us,dropped"));
    let intervals: Vec<u32> =
        csv.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    assert_eq!(intervals.len(), 600);
    assert!(intervals.iter().all(|us| (16_666..=16_667).contains(us)));
    assert!(csv.lines().skip(1).all(|line| line.ends_with(",0")));
    assert!(fs::read_to_string(out.with_extension("svg")).unwrap().starts_with("<svg"));
    // Keys lead back.
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert!(window.query_by_label("Timing").is_some());
}

#[test]
fn frames_that_follow_no_refresh_are_told_and_not_judged() {
    let mut window = pane();
    click(&mut window, "Measure");
    let mut now = 100.0;
    for frame in 0_u32..640 {
        // From 5 to 21 ms, in no order.
        now += 0.005 + f64::from(frame.wrapping_mul(2_654_435_761) >> 16) / 65_536.0 * 0.016;
        window.input_mut().time = Some(now);
        window.step();
    }
    window.input_mut().time = None;
    window.run_steps(3);
    assert!(says(&window, "The frames follow no steady refresh, so none can be judged as dropped"));
    assert!(says(&window, "unknown") && !says(&window, "measured"));
}

#[test]
fn a_flicker_is_warned_of_twice_and_can_be_stopped() {
    let mut window = pane();
    click(&mut window, "A patch that flickers");
    assert!(says(&window, "photosensitive epilepsy"));
    click(&mut window, "Measure");
    assert!(says(&window, "It begins in 3 s. Esc stops.") && says(&window, "photosensitive epilepsy"));
    window.run_steps(60);
    assert!(says(&window, "It begins in 2 s"));
    window.run_steps(150);
    assert!(!says(&window, "photosensitive"), "it flickers");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(says(&window, "Measure") && !says(&window, "median"));
}

#[test]
fn the_command_gets_its_report_and_the_window_closes() {
    for scene in [Scene::Patch, Scene::Trial] {
        let (report, measured) = mpsc::channel();
        let plan = TimingPlan { scene, frames: 50, patch: Patch::default() };
        let request = TimingRequest { plan, fullscreen: false, report };
        let mut window: Window = builder([1000.0, 900.0], 1.0 / 60.0).build_eframe(|cc| App::timing(cc, request));
        window.run_steps(40);
        assert!(measured.try_recv().is_err(), "not before its end");
        window.run_steps(250);
        let report = measured.try_recv().expect("measured");
        assert_eq!(report.intervals_us().len(), 50, "{scene:?}");
        assert_eq!(report.csv().lines().count(), 51);
        let rows = report.rows();
        assert!(rows.contains(&("median", "16.667 ms".to_owned())), "{rows:?}");
    }
}
