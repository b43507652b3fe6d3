//! Plays a session of each task by keys, and compares what the screen shows with the pictures that the commands write.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

use crate::{
    common,
    harness::{Harness, Row, SCREEN, Shown, rows},
};

const HEAD: &str = "schema = 1\nname = \"NAME\"\n[stimulus]\nkind = \"mach-band\"\n[viewing]\nwindow_deg = 4.0\n[recovery]\nduration_s = 0.3\n";

/// The color of a pixel, at a distance from the center of the screen.
fn pixel(screen: &[u8], [x, y]: [i64; 2]) -> [u8; 3] {
    let (x, y) = (i64::from(SCREEN.0) / 2 + x, i64::from(SCREEN.1) / 2 + y);
    let at = 4 * (y * i64::from(SCREEN.0) + x) as usize;
    [screen[at + 2], screen[at + 1], screen[at]]
}

/// Whether the field of a trial is on the screen.
fn is_trial(screen: &[u8]) -> bool {
    let corner = pixel(screen, [-390, -290]);
    corner[0] > 150 && corner == pixel(screen, [389, -290]) && corner[2] == 0
}

/// Waits until something is drawn at this distance from the center of the screen, on the field of a trial.
fn wait_for(harness: &mut Harness, at: [i64; 2], is_drawn: bool) -> Vec<u8> {
    let mut found = Vec::new();
    let mut pressed = Instant::now();
    harness.until("a stimulus", |harness| {
        found = harness.screen();
        if !is_trial(&found) && pressed.elapsed() > Duration::from_millis(300) {
            harness.press("space");
            pressed = Instant::now();
        }
        is_trial(&found) && (pixel(&found, at) != pixel(&found, [-390, -290])) == is_drawn
    });
    // The whole stimulus may not have been copied yet.
    std::thread::sleep(Duration::from_millis(60));
    harness.screen()
}

/// Counts the pixels of a stimulus of `size` pixels that differ from the picture that `machband stimulus` writes.
fn differing(harness: &Harness, screen: &[u8], settings: &[(&str, &str)], center: i64, size: u32) -> usize {
    let expected = harness.image(size, settings.iter().copied());
    // From the center of the screen.
    let half = i64::from(size) / 2;
    let [left, top] = [center - half, (i64::from(SCREEN.1) - i64::from(size)) / 2 - i64::from(SCREEN.1) / 2];
    let shown = |x: u32, y: u32| pixel(screen, [left + i64::from(x), top + i64::from(y)]);
    let wrong = |x: u32, y: u32| shown(x, y) != expected.pixel(x, y).map(|code| code as u8);
    (0..size).flat_map(|y| (0..size).map(move |x| (x, y))).filter(|(x, y)| wrong(*x, *y)).count()
}

/// Starts a session of a definition.
fn start(harness: &mut Harness, name: &str, body: &str) -> std::path::PathBuf {
    let definition = harness.definition(name, &format!("{}{body}", HEAD.replace("NAME", name)));
    harness.run(&definition, &["--seed", "3"]);
    harness.csv(name)
}

/// Presses a key until there is one more row, which is returned.
fn answer(harness: &mut Harness, csv: &Path, keys: &[&str]) -> Row {
    let before = rows(csv).len();
    let mut pressed = None::<Instant>;
    harness.until("a row", |harness| {
        if pressed.is_none_or(|pressed| pressed.elapsed() > Duration::from_millis(500)) {
            keys.iter().for_each(|key| harness.press(key));
            pressed = Some(Instant::now());
        }
        rows(csv).len() > before
    });
    // The row is on disk before the stimulus has left the screen; the next one comes later.
    std::thread::sleep(Duration::from_millis(200));
    rows(csv)[before].clone()
}

/// Checks that the session is complete and proved.
fn complete(harness: &mut Harness, name: &str, csv: &Path) {
    harness.complete(name);
    let output = harness.machband(&["verify", csv.parent().unwrap().to_str().unwrap()]);
    let printed = common::text(&output.stdout) + &common::text(&output.stderr);
    assert!(output.status.success() && printed.contains("1 session verified; no errors"), "{printed}");
}

fn size(harness: &Harness, name: &str) -> u32 {
    harness.sidecar(name)["sittings"][0]["viewing"]["stimulus_px"].as_u64().unwrap() as u32
}

#[test]
fn two_intervals_show_the_target_and_the_reference() {
    let Some(mut harness) = Harness::new() else { return };
    let csv = start(
        &mut harness,
        "choice",
        "[task]\nkind = \"choice\"\nduration_s = 0.6\ngap_s = 0.5\nreference = { depth = \"inf\" }\n\
         [adaptive]\nmethod = \"staircase\"\nparameter = \"width\"\nstart = 0.4\nlow = 0.1\nhigh = 0.8\ntrials = 4\n",
    );
    let mut level = String::new();
    for _ in 0..4 {
        let first = wait_for(&mut harness, [-60, -40], true);
        wait_for(&mut harness, [-60, -40], false);
        let second = wait_for(&mut harness, [-60, -40], true);
        let row = answer(&mut harness, &csv, &["1"]);
        let side = size(&harness, "choice");
        for (place, screen) in [("1", first), ("2", second)] {
            let depth = if row["target"] == place { "1" } else { "inf" };
            assert_eq!(
                differing(&harness, &screen, &[("width", &row["level"]), ("depth", depth)], 0, side),
                0,
                "{row:?}"
            );
        }
        assert_eq!(row["correct"], u8::from(row["target"] == "1").to_string());
        assert_eq!(row["rating"], "");
        level.clone_from(&row["level"]);
    }
    assert_ne!(level, "");
    complete(&mut harness, "choice", &csv);
    // Both intervals last a whole number of refreshes, with the gap between them.
    let frames = fs::read_to_string(csv.to_str().unwrap().replace("_data.csv", "_frames.csv")).unwrap();
    let states: Vec<&str> = frames.lines().skip(1).map(|line| line.split(',').nth(4).unwrap()).collect();
    assert!(states.windows(4).any(|states| states == ["recovery", "stimulus", "gap", "stimulus"]), "{states:?}");
}

#[test]
fn pairs_are_shown_side_by_side() {
    let Some(mut harness) = Harness::new() else { return };
    let csv = start(
        &mut harness,
        "pair",
        "[factors]\ndepth = [1, 2, \"inf\"]\n[design]\nrepetitions = 1\n[task]\nkind = \"pair\"\n",
    );
    for i in 0..3 {
        let screen = wait_for(&mut harness, [70, -40], true);
        let row = answer(&mut harness, &csv, &[["1", "2"][i % 2]]);
        let side = size(&harness, "pair");
        let pitch = i64::from(side + side.div_ceil(10));
        for (depth, center) in [(&row["depth"], -pitch / 2), (&row["depth_2"], pitch / 2)] {
            // The places of an odd pitch are not on whole pixels around the center, and are rounded down.
            let best =
                (-1..=1).map(|shift| differing(&harness, &screen, &[("depth", depth)], center + shift, side)).min();
            assert_eq!(best, Some(0), "{row:?}");
        }
        assert_eq!(row["response"], ["1", "2"][i % 2]);
    }
    complete(&mut harness, "pair", &csv);
}

#[test]
fn a_value_is_set_by_keys_and_a_yes_is_said() {
    let Some(mut harness) = Harness::new() else { return };
    let csv = start(
        &mut harness,
        "adjust",
        "[design]\nrepetitions = 2\n[task]\nkind = \"adjust\"\nparameter = \"width\"\nlow = 0.1\nhigh = 0.9\nstep = 0.05\n",
    );
    for _ in 0..2 {
        wait_for(&mut harness, [-60, -40], true);
        harness.press("Right");
        harness.press("shift+Left");
        std::thread::sleep(Duration::from_millis(200));
        let screen = harness.screen();
        let row = answer(&mut harness, &csv, &["Return"]);
        let [start, value] = ["start", "response"].map(|name| row[name].parse::<f64>().unwrap());
        assert!((value - (start + 0.045)).abs() < 1e-5 || value == 0.9 - 0.005, "{row:?}");
        assert_eq!(row["path"].split(' ').count(), 2, "{row:?}");
        let side = size(&harness, "adjust");
        assert_eq!(differing(&harness, &screen, &[("width", &row["response"])], 0, side), 0, "{row:?}");
    }
    complete(&mut harness, "adjust", &csv);
    let csv = start(
        &mut harness,
        "yes",
        "[design]\nrepetitions = 4\n[task]\nkind = \"yes-no\"\ncatch = 0.5\nreference = { width = 0 }\n",
    );
    for _ in 0..4 {
        wait_for(&mut harness, [-60, -40], true);
        let row = answer(&mut harness, &csv, &["y"]);
        assert_eq!((&*row["response"], &*row["correct"]), ("yes", &*row["target"]));
    }
    complete(&mut harness, "yes", &csv);
    let csv =
        start(&mut harness, "slide", "[design]\nrepetitions = 1\n[task]\nkind = \"rating\"\nscale = \"slider\"\n");
    wait_for(&mut harness, [-60, -40], true);
    // Without a value, there is nothing to accept.
    harness.press("Return");
    harness.press("Right");
    let row = answer(&mut harness, &csv, &["Return"]);
    assert_eq!(row["response"], "51");
    complete(&mut harness, "slide", &csv);
}

#[test]
fn pictures_reach_the_screen_with_their_codes() {
    let Some(mut harness) = Harness::new() else { return };
    let folder = harness.dir.path().join("pictures");
    fs::create_dir(&folder).unwrap();
    for (name, width) in [("a", "0.2"), ("b", "0.7")] {
        let to = folder.join(format!("{name}.png"));
        let arguments = ["stimulus", "--size=150", "--width", width, "--out", to.to_str().unwrap()];
        assert!(harness.machband(&arguments).status.success());
    }
    let text = "schema = 1\nname = \"own\"\n[stimulus]\nkind = \"image\"\nfiles = \"pictures/*.png\"\nshow = \"codes\"\nsize = \"pixels\"\n[recovery]\nduration_s = 0.3\n";
    let definition = harness.definition("own", text);
    harness.run(&definition, &["--seed", "3"]);
    let csv = harness.csv("own");
    for _ in 0..2 {
        let mut screen = Vec::new();
        let mut pressed = Instant::now();
        harness.until("a picture", |harness| {
            screen = harness.screen();
            if harness.shown() == Shown::Page && pressed.elapsed() > Duration::from_millis(300) {
                harness.press("space");
                pressed = Instant::now();
            }
            // The field is gray here; the pictures are yellow. A row is on disk before its picture has left the screen.
            let is_shown = |screen: &[u8]| pixel(screen, [0, -40])[2] == 0 && pixel(screen, [-390, -290]) == [188; 3];
            is_shown(&screen) && {
                std::thread::sleep(Duration::from_millis(60));
                screen = harness.screen();
                is_shown(&screen)
            }
        });
        let row = answer(&mut harness, &csv, &["2"]);
        let width = if row["picture"] == "pictures/a.png" { "0.2" } else { "0.7" };
        assert_eq!(differing(&harness, &screen, &[("width", width)], 0, 150), 0, "{row:?}");
    }
    harness.complete("own");
}
