//! Tests the editor of definitions without a display.

use eframe::egui::{self, Key};
use egui_kittest::kittest::Queryable as _;
use machband::{
    experiment::{
        FieldKind,
        task::{Adaptive, ChoiceShown, Method, Task},
    },
    store::definition,
};

use crate::window::{
    self, Window, choose, click, is_chosen, open_study, press, save_as, texts, type_into, value, wait_for,
};

const SIZE: [f32; 2] = [1366.0, 768.0];

/// Chooses a definition on the first page and opens a copy of it.
fn duplicate(definition: &str) -> Window {
    let mut window = window::home(SIZE, 1.0 / 60.0);
    open_study(&mut window, definition);
    click(&mut window, "Duplicate as…");
    wait_for(&mut window, "Stimulus size");
    window
}

/// Leaves the editor with Escape; `experiment` is then chosen on the first page.
fn is_left(window: &mut Window, experiment: &str) {
    window.run_steps(10);
    assert!(window.query_by_label("Stimulus size, °").is_none(), "{:?}", texts(window));
    assert!(is_chosen(window, experiment), "{:?}", texts(window));
}

#[test]
fn a_copy_is_edited_and_saved() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = duplicate("quick");
    wait_for(&mut window, "28 trials, 4 of them practice, about 4 min");
    wait_for(&mut window, "24 conditions");
    assert_eq!(value(&window, "Name"), "quick-copy");
    // Errors appear next to their fields, and saving waits until they are corrected.
    type_into(&mut window, "Levels of width", "0.05, wide, 0.05");
    window.get_by_label_contains("Width \"wide\" is not a number; expected");
    window.get_by_label_contains("Level 0.05 of width appears twice");
    window.get_by_label_contains("2 errors, first in factors.width");
    type_into(&mut window, "Levels of width", "0.05, 0.5, 1");
    assert!(window.query_by_label_contains("appears twice").is_none());
    type_into(&mut window, "Repetitions", "many");
    window.get_by_label_contains("Enter a whole number.");
    type_into(&mut window, "Repetitions", "0");
    window.get_by_label_contains("Enter at least 1.");
    type_into(&mut window, "Repetitions", "2");
    type_into(&mut window, "Name", "My study");
    window.get_by_label_contains("Enter at most 64 lowercase letters");
    type_into(&mut window, "Name", "my-study");
    type_into(&mut window, "Stimulus, s", "0.5");
    click(&mut window, "Remove orientation");
    choose(&mut window, "Add a factor", "High");
    type_into(&mut window, "Levels of high", "0.2, 0.75");
    window.get_by_label_contains("High 0.2 is below low, which is 0.25");
    type_into(&mut window, "Levels of high", "0.75");
    choose(&mut window, "Order", "Blocks by depth, Latin square");
    type_into(&mut window, "Label of rating 1", "Broad, weak band");
    type_into(&mut window, "Key for rating 3", "s");
    window.get_by_label_contains("Key 's' cannot be an answer");
    type_into(&mut window, "Key for rating 3", "4");
    click(&mut window, "What participants read");
    type_into(&mut window, "Welcome", "Willkommen");
    wait_for(&mut window, "22 trials, 4 of them practice");
    wait_for(&mut window, "9 conditions");
    window.get_by_label("width 0.05; depth ∞; high 0.75");
    type_into(&mut window, "Folder", folder.path().to_str().unwrap());
    // An existing file is never replaced: a study with sessions may need it.
    let path = folder.path().join("my-study.toml");
    std::fs::write(&path, "precious").unwrap();
    click(&mut window, "Save");
    window.get_by_label_contains("my-study.toml: already exists; expected a new file");
    assert_eq!(std::fs::read(&path).unwrap(), b"precious");
    std::fs::remove_file(&path).unwrap();
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::S);
    is_left(&mut window, path.to_str().unwrap());

    let original = definition::BUILT_IN.iter().find(|built_in| built_in.name == "quick").unwrap().text;
    let protocol = definition::open(&path).unwrap();
    // The comment at the top is about the original.
    let expected = original[original.find("schema").unwrap()..]
        .replace("\"quick\"", "\"my-study\"")
        .replace("A first look at Mach bands", "A first look at Mach bands (copy)")
        .replace("width = [0.02, 0.1, 0.4, 0.8]\n", "width = [0.05, 0.5, 1]\n")
        .replace("orientation_deg = [0, 90]\n", "high = [0.75]\n")
        .replace("repetitions = 1", "repetitions = 2")
        .replace("\"random\"", "\"latin:depth\"")
        .replace("own_means = true", "own_means = false");
    let saved = std::fs::read_to_string(&path).unwrap();
    assert!(saved.starts_with(&expected), "{saved}");
    assert_eq!(protocol.instructions.welcome, "Willkommen");
    assert_eq!(protocol.presentation.map(|presentation| presentation.duration_s), Some(0.5));
    let scale = protocol.response.categories.iter().map(|category| (category.label.as_str(), category.key));
    let expected = [
        ("No band", '0'),
        ("Broad, weak band", '1'),
        ("Narrow band, indistinct boundaries", '2'),
        ("Narrow band, clearly defined", '4'),
    ];
    assert!(scale.eq(expected), "{saved}");
}

/// A question of one's own has a name, which is its column in the data, and a kind.
#[test]
fn a_question_of_ones_own_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = duplicate("quick");
    choose(&mut window, "Add a question", "Age");
    let add = |window: &mut Window, name: &str| {
        type_into(window, "Or one of your own, named", name);
        click(window, "Add");
    };
    add(&mut window, "age");
    assert_eq!(window.query_all_by_label("Remove Age").count(), 1, "a name is a question once");
    add(&mut window, "dominant_eye");
    choose(&mut window, "Answers to Dominant eye", "one of several");
    type_into(&mut window, "Answers of Dominant eye", "left, right, unknown");
    type_into(&mut window, "Label of Dominant eye", "Your dominant eye");
    add(&mut window, "height");
    choose(&mut window, "Answers to Height", "a number");
    let protocol = save_as(&mut window, "quick-copy", folder.path());
    let fields = protocol.participant.iter().map(|field| (field.name.as_str(), field.kind()));
    let expected = [("age", FieldKind::Number), ("dominant_eye", FieldKind::Choice), ("height", FieldKind::Number)];
    assert!(fields.eq(expected), "{:?}", protocol.participant);
    assert_eq!(protocol.participant[1].choices(), ["left", "right", "unknown"]);
    assert_eq!(protocol.participant[1].label(), "Your dominant eye");
}

/// The form has every task, and their methods with levels to begin with.
#[test]
fn a_task_and_its_method_are_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = duplicate("orientation");
    click(&mut window, "Choice");
    window.get_by_label_contains("Choose a parameter in which it differs from the target.");
    // The reference begins with a value that the target does not have.
    choose(&mut window, "Add to reference", "High");
    assert_ne!(value(&window, "Reference high"), "0.75");
    click(&mut window, "Remove Reference high");
    click(&mut window, "Remove depth");
    choose(&mut window, "Add to reference", "Depth");
    assert_eq!(value(&window, "Reference depth"), "inf");
    choose(&mut window, "Shown as", "places");
    type_into(&mut window, "Question", "Which has a line?");
    click(&mut window, "Remove width");
    choose(&mut window, "Levels chosen by", "Staircase");
    wait_for(&mut window, "One trial");
    type_into(&mut window, "First level", "7");
    window.get_by_label_contains("Start 7 is outside");
    type_into(&mut window, "First level", "0.5");
    type_into(&mut window, "Steps", "0.3, 0.1");
    type_into(&mut window, "Stops after reversals", "9");
    let (protocol, path) = (save_as(&mut window, "narrow", folder.path()), folder.path().join("narrow.toml"));
    is_left(&mut window, path.to_str().unwrap());
    let Task::Choice(choice) = &protocol.task else { panic!("{:?}", protocol.task) };
    assert_eq!((choice.shown, choice.reference.0["depth"].to_string()), (ChoiceShown::Places, "inf".to_owned()));
    let Some(Adaptive { common, method: Method::Staircase(stairs) }) = &protocol.adaptive else { panic!() };
    assert_eq!((common.parameter.as_str(), stairs.start, stairs.reversals), ("width", 0.5, Some(9)));
    assert_eq!(stairs.steps, [0.3, 0.1]);
    assert_eq!(protocol.response.question, "Which has a line?");

    // Each task can be chosen after each other one, and a rating says nothing of a task again.
    let mut window = duplicate(path.to_str().unwrap());
    for (task, shown) in [
        ("Yes-no", "Catch trials, proportion"),
        ("Pair", "Chain along"),
        ("Adjust", "Lowest value"),
        ("Rating", "Scale"),
        ("Choice", "Add to reference"),
        ("Pair", "Adaptive trials"),
        ("Rating", "Rating 3"),
    ] {
        click(&mut window, task);
        window.run_steps(3);
        assert!(window.query_all_by_label(shown).next().is_some(), "{task}: {:?}", texts(&window));
    }
    let protocol = save_as(&mut window, "rated", folder.path());
    assert!(protocol.task.is_default() && protocol.adaptive.is_none());
}

/// A study of pictures is designed in the form, beside the pictures.
#[test]
fn pictures_are_chosen() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("renders")).unwrap();
    for (name, gray) in [("a", 60), ("b", 120), ("truth", 200)] {
        let file = std::fs::File::create(folder.path().join(format!("renders/{name}.png"))).unwrap();
        let mut encoder = png::Encoder::new(file, 16, 16);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.write_header().unwrap().write_image_data(&[gray; 256]).unwrap();
    }
    let table = "file,shader\na.png,gouraud\nb.png,phong\ntruth.png,phong\n";
    std::fs::write(folder.path().join("renders/pictures.csv"), table).unwrap();
    let mut window = duplicate("quick");
    choose(&mut window, "Kind", "Pictures of your own");
    type_into(&mut window, "Name", "renders");
    type_into(&mut window, "Files", "renders/*.png");
    window.get_by_label_contains("renders");
    type_into(&mut window, "Folder", folder.path().to_str().unwrap());
    wait_for(&mut window, "3 pictures; levels from pictures.csv: shader.");
    choose(&mut window, "Size", "pixels");
    click(&mut window, "Choice");
    choose(&mut window, "Add to reference", "Picture");
    type_into(&mut window, "Reference picture", "renders/truth.png");
    wait_for(&mut window, "2 pictures; levels from pictures.csv: shader.");
    click(&mut window, "Save");
    let protocol = definition::open(folder.path().join("renders.toml")).unwrap();
    assert_eq!(protocol.conditions().len(), 2);
    assert_eq!(protocol.task.name(), "choice");
}

/// Every built-in definition and example can be opened without being changed, and the form works in a small window too.
#[test]
fn only_unsaved_changes_need_an_answer() {
    for built_in in definition::BUILT_IN {
        let mut window = duplicate(built_in.name);
        window.run_steps(5);
        press(&mut window, Key::Escape);
        is_left(&mut window, built_in.name);
    }
    for example in std::fs::read_dir("examples/tasks").unwrap() {
        let path = example.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "toml") {
            let mut window = duplicate(path.to_str().unwrap());
            press(&mut window, Key::Escape);
            is_left(&mut window, path.to_str().unwrap());
        }
    }
    let mut window = duplicate("shaders");
    window.set_size([600.0, 500.0].into());
    window.run_steps(5);
    choose(&mut window, "Kind", "Kanizsa triangle");
    // The factors of the old kind are still there, with errors, until they are removed.
    window.get_by_label_contains("Unknown key \"mesh\" in [factors]");
    click(&mut window, "Remove mesh");
    assert!(window.query_by_label_contains("Unknown key \"mesh\"").is_none());
    click(&mut window, "Undo");
    window.get_by_label_contains("Unknown key \"mesh\" in [factors]");
    click(&mut window, "Redo");
    assert!(window.query_by_label_contains("Unknown key \"mesh\"").is_none());
    press(&mut window, Key::Escape);
    wait_for(&mut window, "Discard changes?");
    click(&mut window, "Keep editing");
    assert_eq!(value(&window, "Name"), "shaders-copy");
    click(&mut window, "Back");
    click(&mut window, "Discard changes");
    is_left(&mut window, "shaders");
}

/// A definition with errors can be opened, so that they can be corrected; text that is not TOML cannot.
#[test]
fn files_with_errors() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let path =
        write("odd.toml", "schema = 1\nname = \"odd\"\nextra = 1\n[stimulus]\nkind = \"mach-band\"\nlow = 0.9\n");
    let mut window = duplicate(path.to_str().unwrap());
    window.get_by_label_contains("unknown key \"extra\"");
    window.get_by_label_contains("is below low");
    assert_eq!(value(&window, "Folder"), folder.path().to_str().unwrap());
    click(&mut window, "Remove");
    assert!(window.query_by_label_contains("unknown key").is_none());
    let path = write("none.toml", "name = ");
    let mut window = window::home(SIZE, 1.0 / 60.0);
    open_study(&mut window, path.to_str().unwrap());
    click(&mut window, "Duplicate as…");
    // The study's page says why, and the status line says that it is also why there is no form.
    assert_eq!(window.query_all_by_label_contains("none.toml:1:8: is not valid TOML").count(), 2);
    assert!(is_chosen(&window, "none.toml"));
}
