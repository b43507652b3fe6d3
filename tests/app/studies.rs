//! Tests the page of a study without a display: the grid, its actions, and editing in place.

use std::{fs, path::Path};

use eframe::egui::{Event, Key};
use egui_kittest::kittest::Queryable as _;
use machband::{
    app::{App, Launch},
    store::definition,
};

use crate::{
    common,
    window::{self, Window, click, is_chosen, open_study, press, request, texts, type_into, value, wait_for, walk},
};

const DEFINITION: &str = "schema = 1\nname = \"five\"\ntitle = \"Five categories\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [0.1, 0.8]\n[design]\nrepetitions = 3\n[response]\nlabels = [\"none\", \"faint\", \"clear\", \"strong\", \"very strong\"]\nkeys = [\"1\", \"2\", \"3\", \"4\", \"5\"]\n[plan]\nparticipants = 3\nsessions = 2\n";

/// Opens the window with this results folder and this definition.
fn opened(folder: &Path, text: &str) -> Window {
    let path = folder.join("five.toml");
    if !path.exists() {
        fs::write(&path, text).unwrap();
    }
    let settings = folder.join("settings.toml");
    let written = format!(
        "schema = 1\nresults = {:?}\n[recent]\nexperiments = [{:?}]\n",
        folder.join("results").display().to_string(),
        path.display().to_string()
    );
    fs::write(&settings, written).unwrap();
    let launch = Launch { request: None, settings: Some(settings) };
    let mut window = window::builder([1366.0, 900.0], 1.0 / 60.0).build_eframe(|cc| App::new(cc, launch));
    window.run_steps(3);
    open_study(&mut window, path.to_str().unwrap());
    assert!(is_chosen(&window, "five.toml"), "{:?}", texts(&window));
    window
}

/// A scale of five is checked, recorded, analyzed and drawn like the paper's four.
#[test]
fn a_grid_shows_what_is_planned_recorded_and_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = opened(folder.path(), DEFINITION);
    wait_for(&mut window, "of 3 participants planned");
    window.get_by_label("P001, session 1: next");
    window.get_by_label("P003, session 2: not begun");
    let path = folder.path().join("five.toml");
    common::succeeds(folder.path(), &["simulate", path.to_str().unwrap(), "--participants", "2"]);
    let mut window = opened(folder.path(), DEFINITION);
    wait_for(&mut window, "S001, session 1: finished, 6 trials");
    window.get_by_label_contains("Simulated (a program answered): 2 sessions");
    window.get_by_label("S002, session 2: not begun");
    click(&mut window, "Check");
    wait_for(&mut window, "no errors");
    // A rating above the scale, or any other change, is found and named.
    let csv = common::session_csv(&folder.path().join("results"), "five", "S001");
    let text = fs::read_to_string(&csv).unwrap();
    let (rest, last) = text.trim_end().rsplit_once('\n').unwrap();
    fs::write(&csv, format!("{rest}\n{}\n", last.replace("0.1", "0.8"))).unwrap();
    click(&mut window, "Check");
    wait_for(&mut window, "S001, session 1: check failed");
    fs::write(&csv, &text).unwrap();
    // The scale ends at 4, in each definition at its own rating.
    let column = text.lines().next().unwrap().split(',').position(|name| name == "rating").unwrap();
    let mut cells: Vec<&str> = last.split(',').collect();
    cells[column] = "5";
    fs::write(&csv, format!("{rest}\n{}\n", cells.join(","))).unwrap();
    let told = common::fails(folder.path(), &["check", csv.to_str().unwrap()], 1);
    assert!(told.contains("has the rating 5; expected 0 to 4"), "{told}");
    fs::write(&csv, &text).unwrap();
    click(&mut window, "Analyze this study");
    wait_for(&mut window, "12 ratings by 2 participants.");
    wait_for(&mut window, "(none) to 4 (very strong)");
}

/// Titles are never cut, equal ones are told apart, and the menu of studies obeys the keyboard.
#[test]
fn studies_with_one_long_title_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let title = ["ramps and their bands"; 12].join(" ");
    let mut window = window::home([800.0, 600.0], 1.0 / 60.0);
    for name in ["one", "two"] {
        let path = folder.path().join(format!("{name}.toml"));
        fs::write(&path, DEFINITION.replace("\"five\"", &format!("{name:?}")).replace("Five categories", &title))
            .unwrap();
        window.get_by_label("Choose another study").focus();
        window.step();
        for key in [Key::Enter, Key::Tab, Key::Enter] {
            press(&mut window, key);
            window.run_steps(2);
        }
        type_into(&mut window, "Definition", path.to_str().unwrap());
        press(&mut window, Key::Enter);
        window.run_steps(3);
        assert!(is_chosen(&window, path.to_str().unwrap()), "{:?}", texts(&window));
        assert!(window.get_by_label(&title).rect().height() > 4.0 * 26.0, "it needs five lines");
    }
    click(&mut window, "Choose another study");
    for name in ["one", "two"] {
        window.get_by_label(&format!("{title}: {name} · no sessions yet"));
    }
}

/// Nothing is lost by leaving a session before its first rating, and its files can then be removed.
#[test]
fn a_session_without_ratings_can_be_removed() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = opened(folder.path(), DEFINITION);
    let results = folder.path().join("results");
    let protocol = definition::open(folder.path().join("five.toml")).unwrap();
    let mut session = window::builder([1000.0, 800.0], 1.0 / 60.0)
        .build_eframe(|cc| App::new(cc, Launch { request: Some(request(&results, protocol)), ..Launch::default() }));
    walk(&mut session, &["These findings are saved", "Welcome"]);
    wait_for(&mut session, "The answers");
    // Every category is listed with its key.
    session.get_by_label("very strong");
    drop(session);
    window.event(eframe::egui::Event::WindowFocused(true));
    wait_for(&mut window, "P001, session 1: unfinished, 0 of 6 trials");
    click(&mut window, "P001, session 1: unfinished, 0 of 6 trials");
    let legend = |window: &Window| window.get_by_label("unfinished").rect();
    let place = legend(&window);
    // The arrow keys move from the cell that was clicked, and Enter does what the card says.
    press(&mut window, Key::ArrowDown);
    press(&mut window, Key::ArrowRight);
    window.get_by_label("P002, session 2");
    // The buttons of the other session needed no more room.
    assert_eq!(legend(&window), place);
    press(&mut window, Key::Enter);
    wait_for(&mut window, "Viewing distance, cm");
    assert_eq!(["Participant", "Session"].map(|field| value(&window, field)), ["P002", "2"]);
    press(&mut window, Key::Escape);
    click(&mut window, "P001, session 1: unfinished, 0 of 6 trials");
    press(&mut window, Key::Enter);
    wait_for(&mut window, "Before the session");
    wait_for(&mut window, "participant P001 · session 1");
    press(&mut window, Key::Escape);
    wait_for(&mut window, "P001, session 1: unfinished, 0 of 6 trials");
    click(&mut window, "P001, session 1: unfinished, 0 of 6 trials");
    let csv = common::session_csv(&results, "five", "P001");
    assert!(csv.exists());
    click(&mut window, "Remove…");
    click(&mut window, "Keep");
    assert!(csv.exists());
    click(&mut window, "Remove…");
    click(&mut window, "Remove");
    wait_for(&mut window, "P001, session 1: next");
    assert_eq!(fs::read_dir(csv.parent().unwrap()).unwrap().count(), 0);
}

/// While there are sessions, only what no session depends on may change.
#[test]
fn a_study_is_edited_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("five.toml");
    let mut window = opened(folder.path(), DEFINITION);
    click(&mut window, "Edit");
    click(&mut window, "Remove rating 4");
    type_into(&mut window, "Label of rating 0", "nothing");
    window::choose(&mut window, "Add a question", "Age");
    click(&mut window, "Save");
    wait_for(&mut window, "of 3 participants planned");
    let protocol = definition::open(&path).unwrap();
    assert_eq!(protocol.response.highest(), 3);
    assert_eq!(protocol.response.categories[0].label, "nothing");
    assert_eq!(protocol.participant[0].name, "age");
    // What another program wrote meanwhile is not lost.
    click(&mut window, "Edit");
    type_into(&mut window, "Repetitions", "4");
    let meanwhile = fs::read_to_string(&path).unwrap() + "# by hand\n";
    fs::write(&path, &meanwhile).unwrap();
    click(&mut window, "Save");
    window.get_by_label_contains("was changed by another program");
    assert_eq!(fs::read_to_string(&path).unwrap(), meanwhile);
    let hash = definition::hash(&protocol);

    common::succeeds(folder.path(), &["simulate", path.to_str().unwrap(), "--participants", "1"]);
    let mut window = opened(folder.path(), DEFINITION);
    wait_for(&mut window, "S001, session 1: finished");
    click(&mut window, "Edit");
    window.get_by_label_contains("1 session was recorded with this definition.");
    type_into(&mut window, "Repetitions", "9");
    window.get_by_label_contains("Only the plan may change while there are sessions.");
    type_into(&mut window, "Repetitions", "3");
    type_into(&mut window, "Participants", "20");
    click(&mut window, "Save");
    wait_for(&mut window, "of 20 participants planned");
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(definition::hash(&definition::open(&path).unwrap()), hash, "the same experiment");
    // Another program can change more. The page says so, and its pictures are those of the file.
    window.get_by_label("width 0.1");
    assert!(!texts(&window).iter().any(|text| text.contains("another definition")));
    fs::write(&path, text.replace("[0.1, 0.8]", "[0.2, 0.8]")).unwrap();
    window.event(Event::WindowFocused(true));
    wait_for(&mut window, "Recorded with another definition of this name: 1 session.");
    window.get_by_label("width 0.2");
}

/// A plan says how many participants are enough; its fields have the bounds of the command.
#[test]
fn a_plan_says_how_many_participants_are_enough() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |window: &mut Window, participants: &str, effects: &str| {
        click(window, "Plan…");
        type_into(window, "Numbers of participants", participants);
        type_into(window, "Effects", effects);
        type_into(window, "Simulated studies", "3");
        click(window, "Simulate");
    };
    let mut window = opened(folder.path(), DEFINITION);
    plan(&mut window, "0", "");
    window.get_by_label_contains("outside 1…10000");
    // What is wrong can be typed over.
    window.run_steps(2);
    assert!(window.query_all_by_label("Numbers of participants").any(|node| node.is_focused()));
    type_into(&mut window, "Numbers of participants", "3, 2");
    type_into(&mut window, "Effects", "nothing=1");
    click(&mut window, "Simulate");
    // What was entered is still there.
    wait_for(&mut window, "the observer has no such parameter");
    type_into(&mut window, "Effects", " ");
    click(&mut window, "Simulate");
    wait_for(&mut window, "With 2 participants");
    let told = texts(&window);
    assert!(told.iter().any(|text| text.contains("“People differ by”")) && !told.concat().contains("--"), "{told:#?}");
    click(&mut window, "Close");
    open_study(&mut window, "threshold-width");
    // The answers of one person have no test, so they have no power.
    for (participants, powers) in [("1", 0), ("2", 1)] {
        plan(&mut window, participants, "orientation_deg:90=0.5");
        wait_for(&mut window, "mean threshold");
        window.run_steps(3);
        assert_eq!(texts(&window).iter().filter(|text| text.ends_with("\u{a0}%")).count(), powers);
        click(&mut window, "Close");
    }
}

/// A pilot is simulated beside the results of people, never among them, and then analyzed.
#[test]
fn a_pilot_is_simulated_in_a_folder_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = opened(folder.path(), DEFINITION);
    click(&mut window, "Simulate a pilot…");
    window.get_by_label_contains("pilot-1");
    click(&mut window, "Simulate");
    wait_for(&mut window, "18 ratings by 3 participants.");
    wait_for(&mut window, "These data are simulated");
    assert!(folder.path().join("five-pilot-1/five/data").is_dir() && !folder.path().join("results").exists());
}

/// What could not be read in the results folder is named, a line each, and the rest is shown.
#[test]
fn what_could_not_be_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    drop(opened(folder.path(), DEFINITION));
    let simulate = || common::succeeds(folder.path(), &["simulate", "five.toml", "--participants", "2"]);
    let results = folder.path().join("results");
    simulate();
    fs::rename(results.join("five"), results.join(".five")).unwrap();
    simulate();
    fs::write(common::session_csv(&results, "five", "S002").with_extension("json"), "{").unwrap();
    let mut window = opened(folder.path(), DEFINITION);
    wait_for(&mut window, "S001, session 1: finished, 6 trials");
    let told = texts(&window);
    for (file, why) in [(".five", "is a hidden data set and was not read"), ("S002", "json:1:")] {
        let found = told.iter().find(|text| text.contains(file) && text.contains(why));
        assert!(found.is_some_and(|text| !text.contains('\n')), "{file}: {told:#?}");
    }
    assert!(told.iter().any(|text| text == "S002, session 1: cannot be read"), "{told:#?}");
}
