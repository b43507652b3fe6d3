//! Tests Home, sessions and the gallery without a display.

use std::{fs, path::Path};

use eframe::egui::{self, Key, Shape};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use machband::{
    app::{App, Launch, Request},
    experiment::{Course, Identity, Protocol, Replay, TrialRecord, columns},
    store::{definition, sidecar::Sidecar},
};

use crate::{
    common,
    window::{
        self, Window, click, leave, press, request, session_form, type_into, value, wait_for, walk, walk_to_first_trial,
    },
};

const STEP_S: f32 = 1.0 / 60.0;
const SIZE: [f32; 2] = [1000.0, 800.0];

fn protocol(recovery_s: f64, window_deg: f64) -> Protocol {
    let text = format!(
        "schema = 1\nname = \"panes\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [0.1, 0.8]\ndepth = [1, \"inf\"]\n\
         [design]\npractice = 1\nbreak_every = 2\n[recovery]\nduration_s = {recovery_s}\n[viewing]\nwindow_deg = {window_deg}\n"
    );
    definition::parse("panes", &text).unwrap()
}

fn harness(request: Request) -> Window {
    harness_of(SIZE, request)
}

fn harness_of(size: [f32; 2], request: Request) -> Window {
    let launch = Launch { request: Some(request), ..Launch::default() };
    window::builder(size, STEP_S).build_eframe(|cc| App::new(cc, launch))
}

fn rows(results: &Path, protocol: &Protocol) -> Vec<TrialRecord> {
    common::rows(&common::session_csv(results, "panes", "P001"), protocol)
}

fn sidecar(results: &Path) -> Sidecar {
    Sidecar::read(&common::session_csv(results, "panes", "P001").with_extension("json")).unwrap().unwrap()
}

#[test]
fn a_whole_session_with_a_break_a_pause_and_an_undone_rating() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = protocol(0.5, 10.0);
    let mut harness = harness(request(folder.path(), protocol.clone()));
    // The pages lead back too.
    walk(&mut harness, &["These findings are saved"]);
    for (page, key) in [
        ("Welcome", Key::Space),
        ("The answers", Key::Space),
        ("First, some practice", Key::Backspace),
        ("The answers", Key::ArrowLeft),
        ("Welcome", Key::Backspace),
        ("Welcome", Key::Space),
        ("The answers", Key::Space),
        ("First, some practice", Key::Space),
    ] {
        wait_for(&mut harness, page);
        press(&mut harness, key);
    }

    // This key is too early: there is nothing to rate yet.
    press(&mut harness, Key::Num3);
    harness.run_steps(32);
    // The scale is shown during practice and can be clicked.
    harness.get_by_label_contains("Broad band").click();
    walk(&mut harness, &["Now the main part"]);
    harness.run_steps(35);
    press(&mut harness, Key::Num2);
    // The rating is undone during the following recovery and given again.
    harness.run_steps(5);
    press(&mut harness, Key::Backspace);
    harness.run_steps(35);
    press(&mut harness, Key::Num0);
    // After a pause during a stimulus, the stimulus is shown again. The instructions can be read during the pause.
    harness.run_steps(35);
    press(&mut harness, Key::Escape);
    wait_for(&mut harness, "Paused");
    wait_for(&mut harness, "2 of 5 done");
    click(&mut harness, "Read the instructions again");
    for (page, key) in [("Welcome", Key::Space), ("The answers", Key::Backspace), ("Welcome", Key::Escape)] {
        wait_for(&mut harness, page);
        press(&mut harness, key);
    }
    walk(&mut harness, &["Paused"]);
    harness.run_steps(35);
    press(&mut harness, Key::Num3);
    wait_for(&mut harness, "Time for a break");
    walk(&mut harness, &["3 of 5 done"]);
    for _ in 0..2 {
        harness.run_steps(35);
        press(&mut harness, Key::Num1);
    }
    wait_for(&mut harness, "Thank you!");
    // What only the experimenter needs is in a closed section.
    assert!(harness.query_by_label("Open the folder").is_none());
    click(&mut harness, "For the experimenter");
    wait_for(&mut harness, "Open the folder");

    let rows = rows(folder.path(), &protocol);
    let seen: Vec<_> =
        rows.iter().map(|row| (row.phase.to_string(), row.trial, row.attempt, row.rating.unwrap().0)).collect();
    let main = |trial, attempt, rating| ("main".to_owned(), trial, attempt, rating);
    assert_eq!(
        seen,
        [("practice".to_owned(), 1, 1, 1), main(1, 1, 2), main(1, 2, 0), main(2, 1, 3), main(3, 1, 1), main(4, 1, 1)]
    );
    let identity = Identity::new("P001", "1").unwrap();
    let mut replay = Replay::new(&identity, Course::new(&protocol, &identity, 5).unwrap());
    for row in &rows {
        assert!(replay.row(row).is_ok_and(|replayed| replayed.gap.is_none()), "{row:?}");
        // The recovery lasts a whole number of frames and is never shorter than requested.
        assert!((0.5..0.5 + 1.5 / 60.0).contains(&row.recovery_s.0), "{row:?}");
        assert!(row.frames.unwrap() > 0);
    }
    // New code that forgets a column leaves it at its default in every row. Keys have no timestamps without the event loop
    // of the real window, whose own test reads response_uncertainty_s from every row.
    let default = TrialRecord::default().cells();
    let is_forgotten = |column: usize| rows.iter().all(|row| row.cells()[column] == default[column]);
    let columns = columns(&protocol).into_iter().enumerate();
    let forgotten: Vec<_> = columns.filter(|(i, _)| is_forgotten(*i)).map(|(_, column)| column.name).collect();
    assert_eq!(forgotten, ["response_uncertainty_s"]);
    let sidecar = sidecar(folder.path());
    assert!(sidecar.is_complete());
    assert_eq!(sidecar.sittings.len(), 1);
    assert!(sidecar.sittings[0].preflight.iter().any(|note| note.check == "stimulus_fits" && note.ok));
    let frames = sidecar.sittings[0].frames.as_ref().unwrap();
    assert_eq!((frames.dropped, frames.missed_refreshes, frames.late_onsets), (Some(0), Some(0), Some(0)));
    assert_eq!(frames.refresh_source, "measured");
    assert!((frames.refresh_s.unwrap() * 60.0 - 1.0).abs() < 1e-3, "{frames:?}");
    // The frames file contains every interval.
    let kept = fs::read_to_string(folder.path().join("panes/data").join(frames.file.as_ref().unwrap())).unwrap();
    let intervals = kept.lines().skip(1).flat_map(|row| row.rsplit(',').next().unwrap().split(' '));
    let intervals: Vec<&str> = intervals.collect();
    assert_eq!(frames.intervals, intervals.len());
    assert!(intervals.iter().all(|us| ["16666", "16667"].contains(us)));
    harness.get_by_label_contains("half of them within 16.7 ms and 99 % within 16.7 ms: 0 dropped at 60.00 Hz");
    // Without an event loop there are no timestamps, and the sidecar says so.
    let input = sidecar.sittings[0].input.as_ref().unwrap();
    assert_eq!((input.stamped, input.unstamped), (0, 6));
    // A click takes effect in the next frame, so the stimulus is shown longer than the response time.
    assert!(rows[1..].iter().all(|row| row.stimulus_s == Some(row.response_time_s)));
    assert!(rows.iter().all(|row| row.late_onset == Some(false)));
}

/// Returns the number of lines in the last frame, and its texts.
fn drawn(harness: &Window) -> (usize, Vec<String>) {
    let shapes = || harness.output().shapes.iter().map(|clipped| &clipped.shape);
    let lines = shapes().filter(|shape| matches!(shape, Shape::LineSegment { .. } | Shape::Path(_))).count();
    let text = |shape: &Shape| if let Shape::Text(text) = shape { Some(text.galley.text().to_owned()) } else { None };
    (lines, shapes().filter_map(text).collect())
}

/// The field acknowledges answers and names the keys; nothing is drawn on a stimulus.
#[test]
fn the_field_acknowledges_answers_and_the_stimulus_stays_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = harness(request(folder.path(), protocol(0.5, 10.0)));
    walk_to_first_trial(&mut harness);
    harness.run_steps(32);
    press(&mut harness, Key::Num1);
    wait_for(&mut harness, "Now the main part");
    walk(&mut harness, &["The scale is now hidden."]);
    harness.run_steps(35);
    let nothing = (0, Vec::new());
    press(&mut harness, Key::X);
    assert_eq!(drawn(&harness), nothing, "a stimulus");
    press(&mut harness, Key::Num2);
    assert_eq!(drawn(&harness), (1, vec!["Keys: 0, 1, 2, 3".to_owned()]));
    // Both are gone by the middle of the recovery.
    harness.run_steps(16);
    assert_eq!(drawn(&harness), nothing);
    press(&mut harness, Key::Backspace);
    assert_eq!(drawn(&harness), (2, Vec::new()), "an arrow");
    harness.run_steps(35);
    assert_eq!(drawn(&harness), nothing, "the same stimulus");
    press(&mut harness, Key::Num0);
    assert_eq!(drawn(&harness), (1, Vec::new()), "the same mark for every answer");
}

/// The plot at the end says no more than it shows: one factor gives one line, and few levels still have their numbers.
#[test]
fn the_last_page_has_a_plot_of_what_was_measured() {
    let staircase = "[task]\nkind = \"choice\"\nshown = \"places\"\nreference = { depth = \"inf\" }\n[adaptive]\n\
                     method = \"staircase\"\nparameter = \"width\"\nstart = 0.4\nlow = 0.3\nhigh = 0.5\ntrials = 2\n";
    for (factors, task, caption, mark) in [
        ("width = [0.1, 0.8]", "", "mean rating", "0.8"),
        ("orientation_deg = [0]", staircase, "The levels that you saw", "0.5"),
    ] {
        let text = format!(
            "schema = 1\nname = \"panes\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\n{factors}\n{task}[design]\n\
             practice = 0\n[recovery]\nduration_s = 0.2\n[viewing]\nwindow_deg = 3\n[session]\nown_means = true\n"
        );
        let folder = tempfile::tempdir().unwrap();
        let mut harness = harness(request(folder.path(), definition::parse("panes", &text).unwrap()));
        walk(&mut harness, &["These findings are saved", "Welcome", "The answers", "Now the main part"]);
        for _ in 0..2 {
            harness.run_steps(20);
            press(&mut harness, Key::Num1);
        }
        wait_for(&mut harness, "Thank you!");
        harness.run_steps(2);
        harness.get_all_by_label_contains(caption).next().unwrap();
        assert!(harness.query_by_label_contains("one line for each").is_none());
        assert!(drawn(&harness).1.iter().any(|text| text == mark), "{:?}", drawn(&harness).1);
    }
}

/// Questions about the participant: what is wrong is said in plain words, and the answers are kept.
#[test]
fn the_participant_is_asked_once() {
    let folder = tempfile::tempdir().unwrap();
    let asking = definition::parse("asking", ASKING).unwrap();
    let protocol = protocol(0.2, 10.0).with(|definition| definition.participant = asking.participant.clone()).unwrap();
    let mut first = harness(request(folder.path(), protocol.clone()));
    walk(&mut first, &["These findings are saved"]);
    wait_for(&mut first, "About you");
    assert!(first.query_by_label_contains("Please answer").is_none());
    let place = first.get_by_label("Continue").rect();
    click(&mut first, "Continue");
    wait_for(&mut first, "Please answer this question.");
    wait_for(&mut first, "Please read this and check the box.");
    assert_eq!(first.get_by_label("Continue").rect(), place, "errors shift nothing");
    type_into(&mut first, "Age in years *", "young");
    wait_for(&mut first, "Enter a number, e.g. 27.");
    type_into(&mut first, "Age in years *", "27");
    assert!(first.query_by_label_contains("Enter a number").is_none());
    click(&mut first, "d");
    click(&mut first, "I have read this and agree. *");
    assert!(!folder.path().join("panes").exists(), "nothing is written before the participant has agreed");
    click(&mut first, "Continue");
    wait_for(&mut first, "Welcome");
    let rows = std::fs::read_to_string(folder.path().join("panes/participants.tsv")).unwrap();
    let today = sidecar(folder.path()).participant.unwrap()["consent"].as_str().unwrap().to_owned();
    assert_eq!(rows, format!("participant_id\tage\tsex\thours\tconsent\nsub-P001\t27\tother\tn/a\t{today}\n"));
    assert_eq!((today.len(), today.matches('-').count()), (10, 2));
    drop(first);

    let mut second = harness(Request { resume: true, ..request(folder.path(), protocol) });
    walk(&mut second, &["These findings are saved"]);
    wait_for(&mut second, "Welcome");
}

const ASKING: &str = "schema = 1\nname = \"panes\"\n[stimulus]\nkind = \"mach-band\"\n[participant]\nage = {}\n\
     sex = { choice_labels = [\"w\", \"m\", \"d\"], required = false }\nhours = { label = \"How many hours a week do you usually look at a screen that is as near as this one?\", number = true, required = false }\nconsent = { text = \"I take part.\" }\n";

/// A session whose texts this computer has no font for does not begin.
#[test]
fn characters_without_a_font_are_reported_before_the_session() {
    let folder = tempfile::tempdir().unwrap();
    // The last character of the last private area.
    let protocol = protocol(0.2, 10.0).with(|definition| definition.instructions.welcome.push('\u{10fffd}')).unwrap();
    let mut harness = harness(request(folder.path(), protocol));
    walk(&mut harness, &["No font on this computer has these characters of the participant's texts: U+10FFFD."]);
    harness.run_steps(5);
    assert!(!folder.path().join("panes").exists());
}

/// Every character beyond ASCII in the sources, but for comments, has a glyph in the window's fonts.
#[test]
fn texts_have_glyphs() {
    let mut window = window::home([800.0, 600.0], STEP_S);
    window.run_steps(2);
    let font = egui::FontId::proportional(15.0);
    let mut read = 0;
    let sources = common::everything(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).into_iter();
    for (path, text) in sources.filter(|(path, _)| path.extension().is_some_and(|ending| ending == "rs")) {
        let text = String::from_utf8(text).unwrap();
        let code = text.lines().map(|line| line.split("// ").next().unwrap_or_default());
        let code = code.filter(|line| !line.trim_start().starts_with("//"));
        for character in code.flat_map(str::chars).filter(|c| !c.is_ascii() && !c.is_whitespace()) {
            read += 1;
            let has_glyph = window.ctx.fonts_mut(|fonts| fonts.has_glyph(&font, character));
            assert!(has_glyph, "{character:?} in {}", path.display());
        }
    }
    assert!(read > 100, "{read}");
}

/// Japanese texts are shown with a font of the system and stay within a narrow window. The window of a test fails at a
/// character that no font has.
#[test]
fn japanese_texts_fit_into_a_narrow_window() {
    let (_, missing) = machband::system::fonts::covering(&"あ帯".chars().collect());
    if !missing.is_empty() {
        return common::skip("FONT", "Japanese texts: no font is installed");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/quick-ja.toml");
    let protocol = definition::open(path).unwrap().with(|definition| definition.viewing.window_deg = 5.0).unwrap();
    let texts = protocol.instructions.clone();
    let request = request(folder.path(), protocol);
    let mut harness = harness_of([420.0, 900.0], request);
    walk(&mut harness, &["These findings are saved"]);
    let fits = |harness: &mut Window, text: &str| {
        wait_for(harness, text);
        harness.run_steps(2);
        for node in harness.query_all_by_label_contains("") {
            assert!(node.rect().right() <= 421.0, "{:?} at {:?}", node.accesskit_node().label(), node.rect());
        }
    };
    fits(&mut harness, &texts.about_you);
    click(&mut harness, "裸眼");
    click(&mut harness, &format!("{} *", texts.agree));
    click(&mut harness, &texts.next);
    for text in [&texts.welcome, &texts.categories, &texts.practice] {
        fits(&mut harness, text);
        press(&mut harness, Key::Space);
    }
    harness.run_steps(130);
    press(&mut harness, Key::Escape);
    fits(&mut harness, &texts.paused);
}

#[test]
fn a_stimulus_that_does_not_fit_is_reported_and_creates_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = harness(request(folder.path(), protocol(0.2, 40.0)));
    // Also beside the button that it blocks, whatever the height of the window.
    let reasons = |harness: &mut Window| {
        wait_for(harness, "Sit closer");
        harness.query_all_by_label_contains("Sit closer").count()
    };
    assert_eq!(reasons(&mut harness), 2);
    press(&mut harness, Key::Space);
    harness.run_steps(10);
    assert_eq!(reasons(&mut harness), 2);
    assert!(!folder.path().join("panes").exists());
}

/// A session that is resumed after the time in its definition shows the practice again; its answers are new attempts.
#[test]
fn a_late_resumption_repeats_the_practice() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = protocol(0.5, 10.0).with(|definition| definition.session.refresh_after_h = Some(0.0)).unwrap();
    let mut first = harness(request(folder.path(), protocol.clone()));
    walk_to_first_trial(&mut first);
    first.run_steps(35);
    press(&mut first, Key::Num1);
    walk(&mut first, &["Now the main part"]);
    first.run_steps(35);
    press(&mut first, Key::Num2);
    first.run_steps(5);
    press(&mut first, Key::Escape);
    wait_for(&mut first, "Paused");
    click(&mut first, "Leave the session");
    wait_for(&mut first, "The session is interrupted");
    drop(first);
    let mut second = harness(Request { resume: true, ..request(folder.path(), protocol.clone()) });
    walk_to_first_trial(&mut second);
    second.run_steps(35);
    press(&mut second, Key::Num3);
    walk(&mut second, &["Now the main part"]);
    for key in [Key::Num0, Key::Num1, Key::Num2] {
        second.run_steps(35);
        if second.query_by_label_contains("Time for a break").is_some() {
            press(&mut second, Key::Space);
            second.run_steps(35);
        }
        press(&mut second, key);
    }
    wait_for(&mut second, "Thank you!");
    // Participants see their own means only if the definition says so.
    assert!(second.query_by_label_contains("Your mean rating").is_none());
    let rows = rows(folder.path(), &protocol);
    let seen: Vec<_> = rows
        .iter()
        .map(|row| (row.sitting, row.phase.to_string(), row.trial, row.attempt, row.rating.unwrap().0))
        .collect();
    let [practice, main] = ["practice", "main"].map(str::to_owned);
    let expected = [
        (1, practice.clone(), 1, 1, 1),
        (1, main.clone(), 1, 1, 2),
        (2, practice, 1, 2, 3),
        (2, main.clone(), 2, 1, 0),
        (2, main.clone(), 3, 1, 1),
        (2, main, 4, 1, 2),
    ];
    assert_eq!(seen, expected);
    let told = common::succeeds(folder.path(), &["verify", "."]);
    assert!(told.contains("5 of 5 trials answered"), "{told}");
}

/// Two windows on one results folder do not begin the same session.
#[test]
fn another_window_takes_a_participant() {
    let folder = tempfile::tempdir().unwrap();
    let results = folder.path().join("results").display().to_string();
    let opened = || {
        let mut window = window::home(SIZE, STEP_S);
        session_form(&mut window);
        type_into(&mut window, "Results folder", &results);
        assert_eq!(value(&window, "Participant"), "P001");
        window
    };
    let [mut first, mut second, mut third] = [opened(), opened(), opened()];
    click(&mut first, "Start");
    walk_to_first_trial(&mut first);
    second.event(egui::Event::WindowFocused(true));
    second.run_steps(3);
    assert_eq!(value(&second, "Participant"), "P002");
    click(&mut third, "Start");
    third.get_by_label_contains("Another window or program has just changed this study.");
    assert_eq!(value(&third, "Participant"), "P002");
}

#[test]
fn home_shows_errors_next_to_their_fields() {
    let mut harness = window::home(SIZE, STEP_S);
    session_form(&mut harness);
    harness.query_all_by_label_contains("about 4 min").next().unwrap();
    type_into(&mut harness, "Participant", "../../x");
    harness.get_by_label_contains("expected letters A–Z");
    harness.get_by_label_contains("Something above needs attention");
    type_into(&mut harness, "Participant", "P7");
    assert!(harness.query_by_label_contains("expected letters A–Z").is_none());
    let place = |harness: &Window| harness.query_all_by_label("Results folder").next().unwrap().rect();
    type_into(&mut harness, "Viewing distance, cm", "57");
    let before = place(&harness);
    type_into(&mut harness, "Viewing distance, cm", "near");
    harness.get_by_label_contains("Enter a number of centimeters, e.g. 57.");
    assert_eq!(place(&harness), before, "errors shift nothing");
    type_into(&mut harness, "Viewing distance, cm", "500");
    harness.get_by_label_contains("Enter a shorter distance");
    type_into(&mut harness, "Viewing distance, cm", "50");
    type_into(&mut harness, "Display profile", "/nowhere.toml");
    harness.get_by_label_contains("cannot be opened");
    type_into(&mut harness, "Display profile", "");
    // A complete session, and the same one without its last row.
    let folder = tempfile::tempdir().unwrap();
    common::succeeds(folder.path(), &["simulate", "quick"]);
    let results = folder.path().join("results");
    type_into(&mut harness, "Participant", "S001");
    type_into(&mut harness, "Results folder", results.to_str().unwrap());
    harness.get_by_label_contains("has already completed session 1");
    let csv = common::session_csv(&results, "quick", "S001");
    let text = std::fs::read_to_string(&csv).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    lines.pop();
    std::fs::write(&csv, lines.join("\n") + "\n").unwrap();
    type_into(&mut harness, "Session", "2");
    type_into(&mut harness, "Session", "1");
    harness.get_by_label_contains("was changed since the session ended");
    harness.get_by_label_contains("Something above needs attention");
}

#[test]
fn the_gallery_explains_errors_and_exports() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window::home(SIZE, STEP_S);
    click(&mut harness, "Stimuli");
    let last = machband::stimulus::catalog::all().last().unwrap();
    click(&mut harness, &format!("Show {}", last.title));
    // This is a shaded cylinder: an unknown shading is rejected, a known one is accepted.
    let place = |harness: &Window| harness.query_all_by_label("Dither").next().unwrap().rect();
    let before = place(&harness);
    type_into(&mut harness, "Shading", "raytraced");
    harness.get_by_label_contains("Shading: \"raytraced\" is not known. Enter flat, gouraud or phong.");
    assert_eq!(place(&harness), before, "errors shift nothing");
    type_into(&mut harness, "Shading", "phong");
    assert!(harness.query_by_label_contains("Enter flat").is_none());

    // The exported file can be verified from its own recipe.
    let path = folder.path().join("cylinder.png");
    type_into(&mut harness, "Export to", &path.display().to_string());
    click(&mut harness, "Export");
    harness.get_by_label(&format!("Saved to {}", path.display()));
    let said = machband::store::image::verify(&path, u64::MAX).unwrap();
    assert!(said.contains("shaded-cylinder"), "{said}");
    // An existing file is replaced only after a question.
    std::fs::write(&path, "precious").unwrap();
    click(&mut harness, "Export");
    harness.get_by_label_contains("already exists");
    assert_eq!(std::fs::read(&path).unwrap(), b"precious");
    click(&mut harness, "Replace");
    machband::store::image::verify(&path, u64::MAX).unwrap();
    // The ending chooses the format.
    type_into(&mut harness, "Export to", &path.with_extension("jpg").display().to_string());
    click(&mut harness, "Export");
    harness.get_by_label_contains("end the name in .png or .csv");
    let csv = path.with_extension("csv");
    type_into(&mut harness, "Export to", &csv.display().to_string());
    click(&mut harness, "Export");
    assert!(std::fs::read_to_string(&csv).unwrap().starts_with("x,linear,code_r"));
    click(&mut harness, "Copy as command");
    harness.get_by_label_contains("--shading phong");
    leave(&mut harness);
    wait_for(&mut harness, "New session");
}
