//! Tests the analysis page without a display: it shows the same document as the analysis, for any filters and settings.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use eframe::egui::{self, Key};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use machband::{
    analysis::{Options, Results, analyze, counts::Exclusions},
    report::{
        document::{Block, Shown},
        figures,
        study::document,
    },
    stimulus::MachBand,
    store::ratings::ReadOptions,
    work::Study,
};

use crate::{
    common::succeeds,
    window::{Role, Window, choose, click, export_to, home, press, texts, type_into, value, wait_for},
};

const DEFINITION: &str = "schema = 1\nname = \"tiny\"\ntitle = \"A tiny study\"\n[stimulus]\nkind = \"mach-band\"\n\
     [factors]\nwidth = [0.1, 0.4, 0.8]\ndepth = [1, \"inf\"]\n[design]\nrepetitions = 3\npractice = 2\n\
     [recovery]\nduration_s = 0.1\n";

/// A temporary folder with the results of this many simulated participants, and the path of the data set.
fn study(participants: usize) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.toml"), DEFINITION).unwrap();
    succeeds(folder.path(), &["simulate", "tiny.toml", "--participants", &participants.to_string()]);
    let data_set = folder.path().join("results/tiny");
    (folder, data_set)
}

fn read(data_set: &Path) -> (Study, Results) {
    let study = Study::read(&[data_set.to_owned()], &ReadOptions { details: true, ..ReadOptions::default() }).unwrap();
    let results =
        analyze(study.measured.clone(), &Options { parameters: Some(MachBand::PARAMETERS), ..Options::default() });
    (study, results)
}

/// The analysis page, opened from Home.
fn pane(size: [f32; 2]) -> Window {
    let mut window = home(size, 1.0 / 60.0);
    click(&mut window, "Analyze");
    wait_for(&mut window, "Drop files or a folder");
    window
}

/// The analysis page with these files open.
fn opened(path: &Path) -> Window {
    let mut window = pane([1280.0, 1400.0]);
    drop_on(&mut window, &[path]);
    wait_for(&mut window, "Participants: ");
    wait_until_idle(&mut window);
    window
}

/// A file to drop on the window.
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

/// Steps until nothing is being computed.
fn wait_until_idle(window: &mut Window) {
    window.run_steps(20);
    for _ in 0..3000 {
        let busy = ["Reading…", "Analyzing…", "Analyzing:", "Writing…"];
        if busy.iter().all(|busy| window.query_by_label_contains(busy).is_none()) {
            window.run_steps(2);
            return;
        }
        window.step();
        // A step takes a core from what it waits for.
        std::thread::sleep(Duration::from_millis(15));
    }
    panic!("the computation does not end");
}

fn has(window: &Window, text: &str) -> bool {
    window.query_all_by_label(text).next().is_some()
}

#[track_caller]
fn assert_has(window: &Window, part: &str) {
    let found = window.query_all_by_label_contains(part).next().is_some();
    assert!(found, "{part:?} is not in {:#?}", texts(window));
}

/// Clicks a control and waits until nothing is being computed.
fn click_and_rest(window: &mut Window, label: &str) {
    click(window, label);
    wait_until_idle(window);
}

fn enter_terms(window: &mut Window, terms: &str) {
    type_into(window, "Terms", terms);
    window.key_press(Key::Enter);
    wait_until_idle(window);
}

/// Checks, section by section, that the window shows the document of these results.
fn assert_document(window: &mut Window, study: &Study, results: &Results) {
    let figures = figures::all(results);
    let document = document(&study.source, results, &figures, None);
    assert!(document.sections.len() > 6 && figures.len() > 4);
    for section in &document.sections {
        click_and_rest(window, section.heading);
        for block in &section.blocks {
            match block {
                Block::Heading(text)
                | Block::Text(text)
                | Block::Note(text)
                | Block::Warning(text)
                | Block::Code(text) => assert!(has(window, text), "{text}"),
                Block::List(items) => items.iter().for_each(|item| assert!(has(window, item), "{item}")),
                Block::Table(table) => {
                    let mut tables = window.query_all_by_label(&table.caption);
                    assert!(tables.any(|node| node.accesskit_node().role() == Role::Table), "{}", table.caption);
                    table.header.iter().for_each(|name| assert!(has(window, &format!("Sort by {name}")), "{name}"));
                }
                Block::Figure(figure) => {
                    let label = format!("{}. {}", figure.title, figure.caption);
                    assert_eq!(window.get_by_label(&label).accesskit_node().role(), Role::Image);
                }
            }
        }
    }
    // The rows of a table are visible and can be sorted by the numbers in a column, first ascending and then descending.
    let blocks = document.sections.iter().flat_map(|section| &section.blocks);
    let tables = blocks.filter_map(|block| if let Block::Table(table) = block { Some(table) } else { None });
    let mut sorted =
        tables.filter_map(|table| Some((table, table.header.iter().position(|name| name == "Odds ratio")?)));
    let Some((table, column)) = sorted.next() else { return };
    click(window, "Model");
    for ascending in [true, false] {
        click_and_rest(window, "Sort by Odds ratio");
        let top = |name: &str| window.query_all_by_label(name).last().map(|cell| cell.rect().top());
        let place = |row: &Vec<Shown>| (top(&row[0]).unwrap(), row[column].value().as_number().unwrap());
        let mut rows: Vec<(f32, f64)> = table.rows.iter().map(place).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(rows.len() > 1, "{rows:?}");
        assert!(rows.is_sorted_by(|a, b| if ascending { a.1 <= b.1 } else { b.1 <= a.1 }), "{rows:?}");
    }
}

#[test]
fn the_window_shows_the_document_and_follows_the_settings() {
    let (_folder, data_set) = study(6);
    let (study, results) = read(&data_set);
    let mut window = opened(&data_set);
    for text in ["tiny: A tiny study", "are simulated"] {
        assert_has(&window, text);
    }
    window.get_by_label("108 ratings by 6 participants.");
    assert_document(&mut window, &study, &results);
    click(&mut window, "Data quality");
    assert_has(&window, "all sittings were run in the same way");

    // Another link function gives another model.
    choose(&mut window, "Link", "probit");
    wait_until_idle(&mut window);
    click(&mut window, "Model");
    assert_has(&window, "F is the normal distribution function");
    let below = |window: &Window| window.get_by_label("Random intercept per participant").rect();
    let place = below(&window);
    for (terms, expected) in [
        ("width,nothing", "nothing: no such factor; expected one of width, depth"),
        ("width,,depth", "an empty name"),
        ("num:width", "Participants may also differ in the effects of width"),
    ] {
        enter_terms(&mut window, terms);
        assert_has(&window, expected);
        assert_eq!(below(&window), place, "an error shifts nothing");
    }
    click(&mut window, "Copy as command");
    assert_has(&window, "--terms num:width --link probit");
}

/// The selected ratings are analyzed as if the others had never been measured, and the export contains what is shown.
#[test]
fn filters_narrow_the_analysis_and_its_export() {
    let (folder, data_set) = study(4);
    let (study, _) = read(&data_set);
    let mut window = opened(&data_set);
    click_and_rest(&mut window, "Participants: 4 of 4");
    click_and_rest(&mut window, "Participant S002");
    window.get_by_label("54 ratings by 3 participants, filtered.");
    click_and_rest(&mut window, "Width: 3 of 3 levels");
    click_and_rest(&mut window, "width 0.4");
    window.get_by_label("36 ratings by 3 participants, filtered.");
    let only = vec![("width".to_owned(), vec!["0.1".to_owned(), "0.8".to_owned()])];
    let left = study.measured.narrowed(&Exclusions { exclude: vec!["S002".to_owned()], only }).unwrap();
    let results = analyze(left, &Options { parameters: Some(MachBand::PARAMETERS), ..Options::default() });
    assert_document(&mut window, &study, &results);

    let out = folder.path().join("out");
    assert_has(&window, "The export includes only the data shown.");
    export_to(&mut window, &out);
    for file in ["report.html", "figure4a.svg", "figure4b.png", "by_width.csv", "tests.csv", "model.json"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    window.get_by_label("Open report");
    window.get_by_label("Open folder");
    // A figure saved by itself has the bytes of the exported one.
    click(&mut window, "Description");
    let figure = &figures::all(&results)[0];
    click(&mut window, &format!("Save the figure: {}", figure.title));
    for ending in ["svg", "png"] {
        let alone = folder.path().join(format!("alone.{ending}"));
        type_into(&mut window, "Save the figure as", alone.to_str().unwrap());
        click(&mut window, "Save");
        window.get_by_label(&format!("Saved to {}", alone.display()));
        let exported = out.join(format!("{}.{ending}", figure.name));
        assert!(std::fs::read(&alone).unwrap() == std::fs::read(exported).unwrap(), "{ending}");
    }
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(report.contains("18 ratings by participant S002"));
    // The command that repeats it names what is shown.
    click(&mut window, "Copy as command");
    let shown = texts(&window);
    let copied = shown.iter().find_map(|text| text.strip_prefix("Copied: machband "));
    assert!(copied.is_some_and(|line| line.contains("--exclude S002 --only 'width=0.1,0.8' --out")), "{shown:#?}");
    let cells = std::fs::read_to_string(out.join("cells.csv")).unwrap();
    assert_eq!(cells.lines().count(), 1 + 4);
    assert!(cells.lines().skip(1).all(|line| line.contains(",9,")), "3 participants × 3 repetitions: {cells}");
    // Existing files are never overwritten without a warning.
    click(&mut window, "Export");
    wait_for(&mut window, "The folder has files from before");
    click(&mut window, "Replace");
    wait_for(&mut window, "files written to");
    // If the folder cannot be written to, the page says so.
    type_into(&mut window, "Export to the folder", data_set.join("dataset_description.json").to_str().unwrap());
    click_and_rest(&mut window, "Export");
    assert_has(&window, "dataset_description.json: ");

    click_and_rest(&mut window, "None of participants");
    assert_has(&window, "No data are selected");
    // The results of the last selection stay, but cannot be exported.
    assert_has(&window, "Before: 36 ratings by 3 participants, filtered.");
    assert_has(&window, "Methods, ready to paste");
    assert!(!has(&window, "The export includes all data."));
    click_and_rest(&mut window, "Select everything");
    window.get_by_label("72 ratings by 4 participants.");
}

/// People are left out of the analysis of a task like of that of ratings, and the export contains what is shown.
#[test]
fn a_task_is_narrowed_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["simulate", "threshold-width", "--participants", "3", "--observer", "vision"]);
    let mut window = opened(&folder.path().join("results/threshold-width"));
    click_and_rest(&mut window, "Participants: 3 of 3");
    click_and_rest(&mut window, "Participant S002");
    wait_for(&mut window, "2 participants gave");
    assert_has(&window, "The export includes only the data shown.");
    let out = folder.path().join("out");
    export_to(&mut window, &out);
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(report.contains("Left out on request: S002"), "{report}");
    // Someone who took part meanwhile is read and can be left out, too.
    let more = ["simulate", "threshold-width", "--participants", "4", "--observer", "vision", "--resume"];
    succeeds(folder.path(), &more);
    window.event(egui::Event::WindowFocused(true));
    wait_for(&mut window, "3 participants gave");
    assert_has(&window, "3 participants, 240 answers.");
    window.get_by_label("Participant S004");
    click_and_rest(&mut window, "Select everything");
    wait_for(&mut window, "4 participants gave");
}

/// Tests the empty page, a missing file, a file with an error, and what was opened recently.
#[test]
fn the_empty_page_and_errors_in_files() {
    let (folder, data_set) = study(3);
    let mut window = pane([1280.0, 1400.0]);
    assert!(has(&window, "Open files…") && has(&window, "Open folder…"));
    let place = window.get_by_label("Open files…").rect();
    type_into(
        &mut window,
        "Or enter the path of a file or folder",
        folder.path().join("nothing.csv").to_str().unwrap(),
    );
    click(&mut window, "Open");
    wait_for(&mut window, "nothing.csv: ");
    assert_eq!(window.get_by_label("Open files…").rect(), place, "errors shift nothing");

    let csv = data_set.join("data/subject-S001_session-1_task-tiny_data.csv");
    let text = std::fs::read_to_string(&csv).unwrap();
    let (head, last) = text.trim_end().rsplit_once('\n').unwrap();
    let column = text.lines().next().unwrap().split(',').position(|name| name == "rating").unwrap();
    let mut cells: Vec<&str> = last.split(',').collect();
    cells[column] = "4";
    std::fs::write(&csv, format!("{head}\n{}\n", cells.join(","))).unwrap();
    drop_on(&mut window, &[&data_set]);
    wait_for(&mut window, "Errors: ");
    wait_until_idle(&mut window);
    assert_has(&window, &format!("_data.csv:{}:", text.lines().count()));
    window.get_by_label("53 ratings by 3 participants.");

    // Of two requests, the newer one counts, even if the older one is read first.
    let (_other_folder, other) = study(4);
    drop_on(&mut window, &[&other]);
    drop_on(&mut window, &[&data_set]);
    wait_for(&mut window, "Participants: 3 of 3");
    for _ in 0..30 {
        wait_until_idle(&mut window);
        std::thread::sleep(Duration::from_millis(5));
    }
    window.get_by_label("Participants: 3 of 3");
}

/// Nothing is analyzed before the user has put ratings in words in order, because their letters have no meaning. The
/// file has decimal commas, a factor `n` and two columns with the same name.
#[test]
fn ratings_in_words_are_put_in_order_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("words.csv");
    let mut text = "participant;n;answer;note;note\n".to_owned();
    for i in 0..48 {
        // The answers to the size 10 are higher.
        let (size, answers) = [("2,5", ["low", "low", "medium, mostly"]), ("10", ["high", "high", "low"])][i % 2];
        text += &format!("P{};{size};{};;\n", i % 4, answers[i / 2 % 3]);
    }
    std::fs::write(&path, text).unwrap();
    let mut window = pane([1280.0, 1000.0]);
    drop_on(&mut window, &[&path]);
    wait_for(&mut window, "What do the columns mean?");
    // Columns are suggested by their names.
    let suggested = ["Participant", "Rating", "Number of trials"].map(|label| value(&window, label));
    assert_eq!(suggested, ["participant", "answer", "one per row"]);
    assert!(!has(&window, "Factor note"));
    click(&mut window, "Factor n");
    click(&mut window, "Read these columns");
    wait_for(&mut window, "What is the order of the ratings?");
    wait_until_idle(&mut window);
    assert!(!has(&window, "Participants: 4 of 4") && !has(&window, "Summary"), "{:?}", texts(&window));
    let order = |window: &Window| -> Vec<String> {
        let is_listed = |text: &String| ["1. ", "2. ", "3. "].iter().any(|number| text.starts_with(number));
        window.query_all_by_label_contains(". ").filter_map(|node| node.value()).filter(is_listed).collect()
    };
    assert_eq!(order(&window), ["1. high (lowest)", "2. low", "3. medium, mostly (highest)"]);
    window.get_by_label("Up: low").focus();
    window.step();
    press(&mut window, Key::Space);
    window.run_steps(2);
    assert_eq!(order(&window), ["1. low (lowest)", "2. high", "3. medium, mostly (highest)"]);
    click(&mut window, "Down: high");
    assert_eq!(order(&window), ["1. low (lowest)", "2. medium, mostly", "3. high (highest)"]);
    click(&mut window, "Analyze in this order");
    wait_for(&mut window, "Participants: 4 of 4");
    wait_until_idle(&mut window);
    click(&mut window, "Copy as command");
    assert_has(&window, "--response answer --categories 'low,\"medium, mostly\",high' --factors n");
    let out = folder.path().join("out");
    type_into(&mut window, "Export to the folder", out.to_str().unwrap());
    click_and_rest(&mut window, "Export");
    let means = std::fs::read_to_string(out.join("by_n.csv")).unwrap();
    let means: Vec<Vec<&str>> = means.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let mean = |row: usize| means[row][2].parse::<f64>().unwrap();
    assert_eq!([means[0][0], means[1][0]], ["2.5", "10"]);
    assert!(mean(0) < mean(1), "{means:?}");
}

/// The pointer on a figure tells the exact value of what is drawn there.
#[test]
fn a_figure_tells_its_values() {
    let (_folder, data_set) = study(3);
    let (_, results) = read(&data_set);
    let figure = &figures::all(&results)[0];
    let value = figure.values.iter().find(|value| value.text.starts_with("width 0.4, depth ∞: ")).unwrap();
    let is_image = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() == Role::Image;
    let place = |window: &Window| window.query_all_by_label_contains(&figure.title).find(is_image).unwrap().rect();
    let mut window = pane([1280.0, 1400.0]);
    drop_on(&mut window, &[&data_set]);
    wait_for(&mut window, "There are no tests of these data yet.");
    let before = place(&window);
    // The command needs no result, and tests that take too long are stopped until they are asked for again.
    click(&mut window, "Copy as command");
    assert_has(&window, "Copied: machband analyze ");
    click(&mut window, "Stop");
    window.run_steps(30);
    assert_has(&window, "Stopped.");
    assert_has(&window, "There are no tests of these data yet.");
    click_and_rest(&mut window, "Continue");
    let rect = place(&window);
    assert_eq!(rect, before, "a figure stays where it is when the tests are there");
    let at = |(x, y): (f64, f64)| rect.min + egui::vec2(x as f32, y as f32) * rect.width() / 800.0;
    window.hover_at(at(value.center));
    window.run_steps(60);
    assert_has(&window, &value.text);
    window.hover_at(at((2.0, 2.0)));
    window.run_steps(5);
    assert!(window.query_by_label_contains(&value.text).is_none());
}

/// The names of the columns stay in view while the rows of a long table scroll.
#[test]
fn the_header_of_a_table_stays_in_view() {
    let (_folder, data_set) = study(16);
    let mut window = pane([1000.0, 420.0]);
    drop_on(&mut window, &[&data_set]);
    wait_for(&mut window, "such as Description");
    click(&mut window, "Description");
    let is_table = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() == Role::Table;
    let table = |window: &Window| {
        window.query_all_by_label("Ratings of every participant").find(is_table).unwrap().rect().top()
    };
    let head = |window: &Window| window.get_by_label("Sort by Participant").rect();
    let below = |window: &Window| head(window).top() - table(window);
    let at_first = below(&window);
    for _ in 0..60 {
        press(&mut window, Key::PageDown);
        window.run_steps(2);
    }
    assert!(below(&window) > at_first + 26.0, "it is {} points below the top of the table", below(&window));
    assert!(window.ctx.content_rect().contains_rect(head(&window)), "{:?}", head(&window));
}
