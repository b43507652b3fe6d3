//! The analysis pane, driven without a display: what it shows is held against the analysis itself.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::Command,
    sync::Arc,
    time::Duration,
};

use eframe::egui::{self, Key, Role};
use egui_kittest::{
    Harness,
    kittest::{NodeT as _, Queryable as _},
};
use machband::{
    analysis::{Options, Results, analyse},
    app::{App, Launch, Request},
    display::DisplayProfile,
    experiment::Identity,
    report::Study,
    store::{definition, ratings::Reading},
};

type Window = Harness<'static, App>;

const DEFINITION: &str = "schema = 1\nname = \"tiny\"\ntitle = \"A tiny study\"\n[stimulus]\nkind = \"mach-band\"\n\
     [factors]\nwidth = [0.1, 0.4, 0.8]\ndepth = [1, \"inf\"]\n[design]\nrepetitions = 3\npractice = 2\n\
     [recovery]\nduration_s = 0.1\n";

/// A results folder with sessions of this many simulated participants, and the experiment's folder in it.
fn study(participants: usize) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let definition = folder.path().join("tiny.toml");
    std::fs::write(&definition, DEFINITION).unwrap();
    let results = folder.path().join("results");
    let done = Command::new(env!("CARGO_BIN_EXE_machband"))
        .args(["simulate", definition.to_str().unwrap(), "--participants", &participants.to_string(), "--results"])
        .arg(&results)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let data_set = results.join("tiny");
    (folder, data_set)
}

fn results(data_set: &Path) -> Results {
    let study = Study::read(&[data_set.to_owned()], &Reading { details: true, ..Reading::default() }).unwrap();
    analyse(study.measured, &Options::default())
}

/// The pane, opened from Home.
fn pane(size: [f32; 2]) -> Window {
    let mut window =
        Harness::builder().with_size(size).with_step_dt(1.0 / 60.0).build_eframe(|cc| App::new(cc, Launch::default()));
    window.set_render_cursor(false);
    window.run_steps(3);
    window.get_by_label("Analyse results…").scroll_to_me();
    window.run_steps(30);
    click(&mut window, "Analyse results…");
    wait_for(&mut window, "Drop files or a folder");
    window
}

/// The pane with files in it.
fn opened(path: &Path) -> Window {
    let mut window = pane([1280.0, 1400.0]);
    drop_on(&mut window, &[path]);
    wait_for(&mut window, "Participants: ");
    rest(&mut window);
    window
}

/// A file that is dropped on the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

fn drop_on(window: &mut Window, paths: &[&Path]) {
    let files = paths.iter().map(|path| Arc::new(Dropped(path.to_path_buf())) as egui::DroppedFileHandle);
    window.input_mut().dropped_files = files.collect();
    window.step();
}

/// Steps until a text stands on the page; work goes on in threads of its own.
fn wait_for(window: &mut Window, text: &str) {
    for _ in 0..3000 {
        if window.query_all_by_label_contains(text).next().is_some() {
            return;
        }
        window.step();
        std::thread::sleep(Duration::from_millis(3));
    }
    panic!("{text:?} did not come; there is {:?}", texts(window));
}

/// Steps until nothing is being computed.
fn rest(window: &mut Window) {
    window.run_steps(2);
    for _ in 0..3000 {
        if ["Reading…", "Analysing…", "Writing…"].iter().all(|busy| window.query_by_label(busy).is_none()) {
            window.run_steps(2);
            return;
        }
        window.step();
        std::thread::sleep(Duration::from_millis(3));
    }
    panic!("it does not come to rest");
}

fn click(window: &mut Window, label: &str) {
    // A control, not a word of a table that reads the same.
    let control = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() != Role::Label;
    window.query_all_by_label(label).find(control).unwrap_or_else(|| panic!("no {label:?} to click")).click();
    window.run_steps(2);
    // Folding takes its time.
    window.run_steps(20);
}

fn type_into(window: &mut Window, label: &str, text: &str) {
    let field = |window: &Window| {
        window.query_all_by_label(label).find(|node| node.value().is_some()).unwrap().focus();
    };
    field(window);
    window.step();
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    window.step();
    window.query_all_by_label(label).find(|node| node.value().is_some()).unwrap().type_text(text);
    window.run_steps(2);
}

/// All texts on the page with their places.
fn texts(window: &Window) -> Vec<(egui::Rect, String)> {
    let text = |node: egui_kittest::Node<'_>| Some((node.rect(), node.accesskit_node().value()?));
    window.query_all_by_role(Role::Label).filter_map(text).collect()
}

/// The page's texts line by line, each from left to right.
fn lines(window: &Window) -> Vec<Vec<String>> {
    let mut lines: BTreeMap<i64, Vec<(i64, String)>> = BTreeMap::new();
    for (rect, text) in texts(window) {
        lines.entry(rect.center().y.round() as i64).or_default().push((rect.left() as i64, text));
    }
    let line = |mut texts: Vec<(i64, String)>| {
        texts.sort();
        texts.into_iter().map(|(_, text)| text).collect()
    };
    lines.into_values().map(line).collect()
}

/// Whether a line has these texts in this order, whatever else stands on it.
fn has_line(window: &Window, wanted: &[String]) -> bool {
    lines(window).iter().any(|line| {
        let mut rest = line.iter();
        wanted.iter().all(|text| rest.any(|other| other == text))
    })
}

fn assert_lines(window: &Window, wanted: impl IntoIterator<Item = Vec<String>>) {
    for line in wanted {
        assert!(has_line(window, &line), "{line:?} is not in {:#?}", lines(window));
    }
}

/// The cells of the design as the pane writes them.
fn cell_lines(results: &Results) -> impl Iterator<Item = Vec<String>> {
    results.cells.iter().map(|cell| {
        let summary = &cell.summary;
        let mean = if summary.mean.fract() == 0.0 { summary.mean.to_string() } else { format!("{:.3}", summary.mean) };
        let mut line = cell.names.clone();
        line.extend([summary.n.to_string(), mean]);
        line.extend(summary.interval.filter(|i| i.high.fract() != 0.0).map(|i| format!("{:.3}", i.high)));
        line
    })
}

/// Everything from Home to the numbers of every view.
#[test]
fn what_is_shown_is_what_the_analysis_says() {
    let (_folder, data_set) = study(6);
    let results = results(&data_set);
    let mut window = opened(&data_set);
    window.get_by_label_contains("tiny: A tiny study");
    window.get_by_label_contains("108 ratings in 6 sessions");
    window.get_by_label_contains("12 practice ratings");
    window.get_by_label_contains("Simulated");
    window.get_by_label("108 ratings of 6 participants.");
    window.get_by_label("Plot: Figure 4 (a). Mean rating by width, one line a level of depth");
    for (sort, plot) in [
        ("Factors", "Plot: Mean rating by width"),
        ("Proportions", "Plot: Proportions of the ratings by width"),
        ("Participants", "Plot: Mean rating by width, one line a participant"),
        ("Effects", "Plot: Effects in the model (logit)"),
        ("Response times", "Plot: Response times by rating"),
    ] {
        click(&mut window, sort);
        window.get_by_label(plot);
    }

    click(&mut window, "Tables");
    assert_lines(&window, cell_lines(&results));
    click(&mut window, "depth");
    let depth = results.factors.iter().find(|factor| factor.name == "depth").unwrap();
    let row = |name: &str, n: u64, mean: f64| vec![name.to_owned(), n.to_string(), format!("{mean:.3}")];
    assert_lines(&window, depth.levels.iter().map(|g| row(&g.names[0], g.summary.n, g.summary.mean)));

    click(&mut window, "Model");
    let report = results.model.as_ref().unwrap();
    let shown = |value: f64| format!("{value:.3}").replace('-', "−");
    assert_lines(
        &window,
        report.model.coefficients.iter().map(|c| vec![c.name.clone(), shown(c.estimate), shown(c.se.unwrap())]),
    );
    assert_lines(&window, report.model.thresholds.iter().map(|t| vec![t.name.clone(), shown(t.estimate)]));
    window.get_by_label_contains(&format!("log-likelihood {}", shown(report.model.loglik)));
    window.get_by_label("Likelihood-ratio tests");
    window.get_by_label("Proportional odds");

    click(&mut window, "Tests");
    let friedman = depth.friedman.as_ref().unwrap();
    assert_lines(
        &window,
        [vec!["depth".to_owned(), "6".to_owned(), "2".to_owned(), format!("{:.2}", friedman.chi_squared)]],
    );
    window.get_by_label_contains(&format!("Krippendorff's ordinal α {:.2}", results.alpha.as_ref().unwrap().alpha));

    // Another link is another model.
    window.get_by_label("Link").click();
    window.run_steps(4);
    window.get_by_label("probit").click();
    rest(&mut window);
    click(&mut window, "Model");
    window.get_by_label_contains("probit link");
    type_into(&mut window, "Terms", "width,colour");
    window.key_press(Key::Enter);
    rest(&mut window);
    window.get_by_label("colour: no such factor; expected one of width, depth");
    type_into(&mut window, "Terms", "width,,depth");
    window.key_press(Key::Enter);
    rest(&mut window);
    window.get_by_label_contains("an empty name");
    type_into(&mut window, "Terms", "num:width");
    window.key_press(Key::Enter);
    rest(&mut window);
    window.get_by_label_contains("probit link, num:width");
    click(&mut window, "Copy as command");
    window.get_by_label_contains("--terms num:width --link probit");
    // A column that is no factor of the design becomes one when the model needs it.
    type_into(&mut window, "Terms", "width,repetition");
    window.key_press(Key::Enter);
    window.run_steps(3);
    wait_for(&mut window, "repetition: 3 of 3 levels");
    rest(&mut window);
    window.get_by_label_contains("probit link, width, repetition");
}

/// What is filtered is analysed as if the rest had never been measured, and exported as it is shown.
#[test]
fn filters_narrow_the_analysis_and_its_export() {
    let (folder, data_set) = study(4);
    let whole = results(&data_set);
    let mut window = opened(&data_set);
    click(&mut window, "Tables");
    click(&mut window, "Participants: 4 of 4");
    click(&mut window, "Participant S002");
    rest(&mut window);
    window.get_by_label_contains("54 ratings of 3 participants. Filtered: 3 of 4 participants.");
    click(&mut window, "width: 3 of 3 levels");
    click(&mut window, "width 0.4");
    rest(&mut window);
    let counts = &whole.measured.counts;
    let second = counts.subjects.iter().position(|name| name == "S002").unwrap() as u32;
    let rest_of_it = whole.measured.filtered(|subject| subject != second, |levels| levels[0] != Some(1));
    let expected = analyse(rest_of_it, &Options::default());
    window.get_by_label_contains("36 ratings of 3 participants. Filtered: 3 of 4 participants; width 0.1, 0.8.");
    assert_lines(&window, cell_lines(&expected));
    assert!(!has_line(&window, &["0.4".to_owned(), "1".to_owned()]), "the level is gone");

    let out = folder.path().join("out");
    type_into(&mut window, "Export to the folder", out.to_str().unwrap());
    window.get_by_label_contains("Exported is what is shown: 3 of 4 participants; width 0.1, 0.8.");
    click(&mut window, "Export");
    rest(&mut window);
    window.get_by_label_contains("files written to");
    for file in ["report.html", "figure4a.svg", "figure4b.png", "by_width.csv", "tests.csv", "model.json"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(report.contains("filtered in the window: 3 of 4 participants; width 0.1, 0.8"));
    let cells = std::fs::read_to_string(out.join("cells.csv")).unwrap();
    assert_eq!(cells.lines().count(), 1 + 4);
    assert!(cells.lines().skip(1).all(|line| line.contains(",9,")), "3 participants × 3 repetitions: {cells}");
    // Never over other files without a word.
    click(&mut window, "Export");
    window.get_by_label_contains("has files in it");
    click(&mut window, "Write into it");
    rest(&mut window);
    window.get_by_label_contains("files written to");
    // Where nothing can be written, the pane says so.
    type_into(&mut window, "Export to the folder", data_set.join("dataset_description.json").to_str().unwrap());
    click(&mut window, "Export");
    rest(&mut window);
    window.get_by_label_contains("dataset_description.json: ");
    assert!(window.query_by_label_contains("files written to").is_none());

    click(&mut window, "None of participants");
    rest(&mut window);
    window.get_by_label_contains("Nothing is left to analyse");
    click(&mut window, "Everything again");
    rest(&mut window);
    window.get_by_label("72 ratings of 4 participants.");
    assert_lines(&window, cell_lines(&whole));
}

/// One person is described, not tested.
#[test]
fn one_participant_has_no_p_values() {
    let (_folder, data_set) = study(1);
    let mut window = opened(&data_set);
    click(&mut window, "Model");
    window.get_by_label_contains("the model describes this participant");
    window.get_by_label("Coefficients");
    click(&mut window, "Tests");
    window.get_by_label_contains("nothing is tested here");
    for tab in ["Model", "Tests"] {
        click(&mut window, tab);
        let p = lines(&window).concat().into_iter().find(|text| text == "p" || text.starts_with("p ("));
        assert_eq!(p, None, "{tab}");
        assert!(window.query_by_label("Likelihood-ratio tests").is_none());
    }
    // And the same where one is left of several.
    let (_folder, data_set) = study(2);
    drop_on(&mut window, &[&data_set]);
    wait_for(&mut window, "Participants: 2 of 2");
    rest(&mut window);
    window.get_by_label_contains("Friedman's test");
    click(&mut window, "Participants: 2 of 2");
    click(&mut window, "Participant S001");
    rest(&mut window);
    window.get_by_label_contains("nothing is tested here");
}

/// Nothing to show, something that is not there, a file with a fault in it, and what the results folder has.
#[test]
fn the_empty_pane_and_what_is_wrong_with_files() {
    let (folder, data_set) = study(2);
    let mut window = pane([1280.0, 1400.0]);
    window.get_by_label("Open files…");
    window.get_by_label("Open folder…");
    assert!(window.query_by_label_contains("Analyse tiny").is_none());
    let path = "Or the path of a file or folder";
    type_into(&mut window, path, folder.path().join("nothing.csv").to_str().unwrap());
    click(&mut window, "Open");
    wait_for(&mut window, "nothing.csv: ");
    window.get_by_label("Open files…");

    let csv = data_set.join("data/subject-S001_session-1_task-tiny_data.csv");
    let text = std::fs::read_to_string(&csv).unwrap();
    let (head, last) = text.trim_end().rsplit_once('\n').unwrap();
    let column = text.lines().next().unwrap().split(',').position(|name| name == "rating").unwrap();
    let mut cells: Vec<&str> = last.split(',').collect();
    cells[column] = "4";
    std::fs::write(&csv, format!("{head}\n{}\n", cells.join(","))).unwrap();
    drop_on(&mut window, &[&data_set]);
    wait_for(&mut window, "Faults: ");
    rest(&mut window);
    let line = text.lines().count();
    window.get_by_label_contains(&format!("_data.csv:{line}:"));
    window.get_by_label("35 ratings of 2 participants.");

    // Of two requests the newer one counts, whichever is read first.
    let (_other_folder, other) = study(3);
    drop_on(&mut window, &[&other]);
    drop_on(&mut window, &[&data_set]);
    wait_for(&mut window, "Participants: 2 of 2");
    for _ in 0..30 {
        rest(&mut window);
        std::thread::sleep(Duration::from_millis(5));
    }
    window.get_by_label("Participants: 2 of 2");

    // Back to the page without data, and Home with its folder.
    click(&mut window, "Other data…");
    window.get_by_label("Open files…");
    window.key_press(Key::Escape);
    wait_for(&mut window, "How visible are Mach bands?");
    type_into(&mut window, "Results folder", folder.path().join("results").to_str().unwrap());
    window.get_by_label("Analyse results…").scroll_to_me();
    window.run_steps(30);
    click(&mut window, "Analyse results…");
    click(&mut window, "Analyse tiny");
    wait_for(&mut window, "Participants: 2 of 2");
}

/// A file of another laboratory: its columns are named in the pane.
#[test]
fn columns_of_a_foreign_file_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("theirs.csv");
    let mut text = "participant,contrast,answer,noise\n".to_owned();
    for i in 0..48 {
        let contrast = ["low", "high"][i % 2];
        text += &format!("P{},{contrast},{},{i}\n", i % 4, 1 + (i / 4 * 7 + i % 2 * 3) % 5);
    }
    std::fs::write(&path, text).unwrap();
    let mut window = pane([1280.0, 900.0]);
    drop_on(&mut window, &[&path]);
    wait_for(&mut window, "Which column says what?");
    // Suggested by their names.
    assert_eq!(window.get_by_label("Participant").value().as_deref(), Some("participant"));
    assert_eq!(window.get_by_label("Rating").value().as_deref(), Some("answer"));
    click(&mut window, "Factor contrast");
    click(&mut window, "Read these columns");
    wait_for(&mut window, "Participants: 4 of 4");
    rest(&mut window);
    window.get_by_label("48 ratings of 4 participants.");
    window.get_by_label("contrast: 2 of 2 levels");
    click(&mut window, "Columns…");
    wait_for(&mut window, "Which column says what?");
    click(&mut window, "Leave the columns as they are");
    window.get_by_label("48 ratings of 4 participants.");
}

/// In a small window the data and filters are a view of their own, and every view is still there.
#[test]
fn a_small_window_has_everything() {
    let (_folder, data_set) = study(3);
    let mut window = pane([500.0, 380.0]);
    drop_on(&mut window, &[&data_set]);
    wait_for(&mut window, "54 ratings of 3 participants.");
    for tab in ["Plots", "Tables", "Model", "Tests"] {
        click(&mut window, tab);
        assert!(window.query_by_label_contains("Participants: ").is_none(), "{tab}");
    }
    click(&mut window, "Data");
    window.get_by_label_contains("Participants: 3 of 3");
}

/// From the end of a session to its analysis, and back.
#[test]
fn a_session_that_ends_can_be_analysed_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = DEFINITION.replace("repetitions = 3", "repetitions = 1").replace("practice = 2", "practice = 0");
    let request = Request {
        protocol: definition::parse("tiny", &text).unwrap(),
        identity: Identity::new("P001", "1").unwrap(),
        seed: Some(5),
        results: folder.path().to_owned(),
        display: DisplayProfile::default(),
        distance_cm: 50.0,
        screen_width_cm: Some(30.0),
        resume: false,
        windowed: true,
    };
    let mut window = Harness::builder()
        .with_size([1280.0, 1000.0])
        .with_step_dt(1.0 / 60.0)
        .build_eframe(|cc| App::new(cc, Launch { request: Some(request) }));
    for page in ["These findings are kept", "Welcome", "The four answers", "Now the main part"] {
        wait_for(&mut window, page);
        window.key_press(Key::Space);
        window.step();
    }
    for key in [Key::Num0, Key::Num1, Key::Num2, Key::Num3, Key::Num0, Key::Num1] {
        window.run_steps(12);
        window.key_press(key);
        window.step();
    }
    wait_for(&mut window, "Thank you!");
    click(&mut window, "Analyse these results…");
    wait_for(&mut window, "Participants: 1 of 1");
    rest(&mut window);
    window.get_by_label("6 ratings of 1 participant.");
    window.key_press(Key::Escape);
    wait_for(&mut window, "Thank you!");
}
