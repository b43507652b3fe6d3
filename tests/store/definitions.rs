//! Definitions, display profiles and observers: what can be loaded, the message for every kind of mistake, and edits that
//! keep comments and layout.

use std::{collections::HashSet, fs, path::Path};

use machband::{
    display::DisplayProfile,
    experiment::{Order, OrderedLogit, Protocol, ResponseScale, columns},
    light::Transfer,
    stimulus::KINDS,
    store::{
        FileErrors, Writer,
        check::check,
        definition,
        draft::{Draft, Typed},
        observer, profile,
    },
};
use sha2::{Digest as _, Sha256};

use crate::common::{assert_documented, everything};

/// A definition with every table, one key per line.
const BASE: &str = r#"schema = 1
name = "mine"
title = "My study"

[stimulus]
kind = "mach-band"
low = 0.25
high = 0.75
color = "yellow"

[factors]
width = [0.1, 0.4]
depth = [1, 2, "inf"]

[design]
repetitions = 2
practice = 4
break_every = 10
order = "random"
max_run = 3

[recovery]
duration_s = 2.0
level = 0.5

[response]
question = "How?"
labels = ["a", "b", "c", "d"]
keys = ["0", "1", "2", "3"]

[viewing]
distance_cm = 50.0
window_deg = 10.0

[instructions]
welcome = "Hello"
"#;

/// Every kind of question about the participant, to replace the head of the last table.
const PARTICIPANT: &str = "[participant]\nage = { required = false }\nsex = { choice_labels = [\"w\", \"m\", \"d\"] }\nvision = {}\n\
     consent = { text = \"I take part.\" }\nhobby = { label = \"Hobby\", required = false }\nyears = { number = true }\n[instructions]";

/// Asserts that one error starts with `start`, which is its place, and contains `part` of its message.
fn assert_error(error: &FileErrors, start: &str, part: &str) {
    let fits = |m: &String| m.starts_with(start) && m.contains(part) && m.contains("expected");
    assert!(messages(error).iter().any(fits), "{start} {part}: {error}");
}

fn messages(error: &FileErrors) -> Vec<String> {
    error.to_string().lines().map(str::to_owned).collect()
}

/// Replaces a line of `BASE`, which must occur exactly once.
fn edited(line: &str, replacement: &str) -> String {
    assert_eq!(BASE.matches(line).count(), 1, "{line:?}");
    BASE.replace(line, replacement)
}

#[test]
fn every_file_in_experiments_is_the_built_in_definition_of_that_name() {
    let mut found = HashSet::new();
    let files = everything(Path::new("experiments")).into_iter().map(|(path, _)| path);
    for path in files.filter(|path| path.extension().is_some_and(|ending| ending == "toml")) {
        // Also that the trials of a definition have an order.
        check(&path).unwrap();
        if path.starts_with("experiments/observers") {
            continue;
        }
        let (file, stem) = (path.to_str().unwrap(), path.file_stem().unwrap().to_str().unwrap());
        let protocol = definition::open(file).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(protocol.name, stem);
        assert_eq!(protocol, definition::open(stem).unwrap(), "the built-in {stem} is different");
        found.insert(stem.to_owned());
    }
    let built_in: HashSet<String> = definition::BUILT_IN.iter().map(|built_in| built_in.name.to_owned()).collect();
    assert_eq!(found, built_in);
    assert_eq!(definition::BUILT_IN[0].name, "quick", "the default");
}

/// A line of `BASE`, its replacement, where the error is, and parts of its message.
const MISTAKES: &str = r##"
# Unknown keys, with the most similar known key.
title = "My study" => titel = "My study" => 3:1 => unknown key "titel" | did you mean title?
width = [0.1, 0.4] => widht = [0.1, 0.4] => 12:1 => "widht" | [factors] | did you mean width?
# Values out of range.
width = [0.1, 0.4] => width = [0.1, 1.5] => 12:15 => width 1.5 | 0…1
depth = [1, 2, "inf"] => depth = [1.5] => 13:10 => 1.5 | is not a whole number
depth = [1, 2, "inf"] => depth = [] => 13:1 => factor depth is empty | at least one level
depth = [1, 2, "inf"] => orientation_deg = [0, nan] => 13:23 => orientation_deg "NaN" is not a number
width = [0.1, 0.4] => width = [1, 1.0] => 12:13 => level 1 of width appears twice
duration_s = 2.0 => duration_s = -2.0 => 23:1 => duration_s -2 | 0…600 | seconds
low = 0.25 => low = 0.9 => 5:2 => high 0.75 | below low | 0.9
color = "yellow" => color = "purpel" => 9:1 => color "purpel" | yellow, gray
# Types.
name = "mine" => name = 7 => 2:1 => name is 7 | text in quotes
[recovery] => [presentation]\n[recovery] => 22:2 => presentation.duration_s is missing
[recovery] => [presentation]\nduration_s = "x"\n[recovery] => 23:1 => presentation.duration_s is the text "x" | a number
title = "My study" => title = "My study"\nplan = [9] => 4:1 => plan is a list | expected a table
# Top-level keys.
schema = 1\n => schema = 2\n => 1:1 => schema is 2 | expected 1
name = "mine" =>  => 1:1 => name is missing
kind = "mach-band" => kind = "mach-bend" => 6:1 => kind "mach-bend" | did you mean mach-band?
name = "mine" => name = "my/study" => 2:1 => name "my/study" | lowercase
# Order and scale.
order = "random" => order = "shuffled" => 19:1 => order "shuffled" | blocked:FACTOR
labels = ["a", "b", "c", "d"]\nkeys = ["0", "1", "2", "3"] => labels = ["a"]\nkeys = ["0"] => 28:1 => categories is 1 | expected 2 to 11
keys = ["0", "1", "2", "3"] => keys = ["0", "1", "2"] => 29:1 => length 3; expected 4
keys = ["0", "1", "2", "3"] => keys = ["0", "1", "2", "1"] => 29:24 => key '1' appears twice
keys = ["0", "1", "2", "3"] => keys = ["a", "s", "d", "f"] => 29:14 => key 's' cannot be an answer
labels = ["a", "b", "c", "d"] => labels = ["a", " ", "c", "d"] => 28:16 => label is empty
# The participant.
[instructions] => [participant]\nage = { requird = true }\n[instructions] => 36:9 => unknown key "requird" in [participant.age] | did you mean required?
[instructions] => [participant]\nconsent = {}\n[instructions] => 36:1 => consent has no text
[instructions] => [participant]\nage = [false]\n[instructions] => 36:1 => participant.age is a list | expected a table
[instructions] => [participant]\nx = { choices = ["a"], number = true }\n[instructions] => 36:1 => x has more than one of
[instructions] => [participant]\nx = { choices = ["n/a"] }\n[instructions] => 36:18 => choice "n/a" cannot be recorded
[instructions] => [participant]\nsex = { choices = ["femal"] }\n[instructions] => 36:20 => "femal" | did you mean female? | choice_labels
[instructions] => [participant]\nsex = { choice_labels = ["w"] }\n[instructions] => 36:9 => choice_labels has length 1; expected 3
[instructions] => [participant]\nspecies = {}\n[instructions] => 36:1 => species already has another meaning
# Scripts.
welcome = "Hello" => welcome = "שלום" => 36:1 => Hebrew, which is written from right to left
# Too many trials.
practice = 4 => practice = 4000000000 => 11:2 => 4000000012 trials | at most
# Invalid TOML.
practice = 4 => repetitions = 3 => 17:1 => not valid TOML | duplicate key
"##;

/// Each mistake causes exactly one error, at the right place, with a message that no other mistake has.
#[test]
fn every_mistake_has_its_own_message() {
    let mut seen = HashSet::new();
    for mistake in MISTAKES.lines().filter(|line| line.contains(" => ")) {
        let fields: Vec<String> = mistake.split(" => ").map(|field| field.replace("\\n", "\n")).collect();
        let [line, replacement, position, parts] = &fields[..] else { panic!("{mistake}") };
        let error = definition::parse("mine.toml", &edited(line, replacement)).expect_err(replacement);
        let found = messages(&error);
        assert_eq!(found.len(), 1, "{replacement}: {found:#?}");
        assert!(
            found[0].starts_with(&format!("mine.toml:{position}: ")),
            "{replacement}: {}, not {position}",
            found[0]
        );
        for part in parts.split(" | ") {
            assert!(found[0].contains(part), "{replacement}: {} lacks {part:?}", found[0]);
        }
        assert!(
            found[0].contains("expected") || found[0].contains("not valid TOML") || found[0].contains("twice"),
            "{}",
            found[0]
        );
        let message = found[0].split_once(": ").unwrap().1.to_owned();
        assert!(seen.insert(message), "{replacement}: {} is also the message of another mistake", found[0]);
    }
    // Names that would lead out of the results folder, or that a shell or a spreadsheet would interpret.
    for name in ["../up", "/etc", "a/b", "a\\b", "..", ".", "-x", "=x", "a b", "Ä"] {
        let text = edited("\"mine\"", &format!("{name:?}"));
        let error = definition::parse("mine.toml", &text).expect_err(name).to_string();
        assert!(error.starts_with("mine.toml:2:1: name"), "{name:?}: {error}");
    }
    definition::parse("mine.toml", BASE).unwrap();
}

#[test]
fn files_that_are_not_definitions_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let write = |name: &str, content: &[u8]| {
        fs::write(at(name), content).unwrap();
        at(name)
    };
    fs::File::create(at("large.toml")).unwrap().set_len(100 << 20).unwrap();
    let mut cut = BASE.as_bytes().to_vec();
    let at_study = BASE.find("study").unwrap();
    cut[at_study] = 0xff;
    let cases = [
        (at("missing.toml"), "", "cannot be opened"),
        (at("large.toml"), "", "has 104857600 bytes; expected at most"),
        (write("latin1.toml", &cut), ":3:13", "is not UTF-8 text"),
        (write("empty.toml", b""), ":1:1", "name is missing"),
        (write("words.toml", b"Not TOML, but words.\n"), ":1:5", "is not valid TOML"),
        ("quik".to_owned(), "", "did you mean quick?"),
    ];
    for (file, position, part) in cases {
        let error = definition::open(&file).unwrap_err();
        let found = messages(&error);
        let start = format!("{file}{position}: ");
        assert!(
            found.iter().any(|message| message.starts_with(&start) && message.contains(part)),
            "{file}: {found:#?}"
        );
        assert!(
            profile::open(Path::new(&file)).is_err() && observer::open::<OrderedLogit>(Path::new(&file)).is_err(),
            "{file}"
        );
        assert!(check(&file).is_err(), "{file}");
    }
    // Line endings and a byte order mark from other systems.
    let plain = definition::parse("mine.toml", BASE).unwrap();
    let windows = format!("\u{feff}{}", BASE.replace('\n', "\r\n"));
    assert_eq!(definition::open(write("windows.toml", windows.as_bytes())).unwrap(), plain);
    let error = definition::parse("w.toml", &windows.replace("low = 0.25", "low = 7")).unwrap_err();
    assert_eq!(error.0[0].position, Some((7, 1)));
}

#[test]
fn a_sidecar_preserves_the_definition_and_its_hash() {
    let other = "\u{22}\u{5c}\t\u{7f}é\u{1F600} '''\"\"\" \u{0}";
    let asking = definition::parse("mine.toml", &BASE.replace("[instructions]", PARTICIPANT)).unwrap();
    let odd = asking.with(|odd| {
        odd.title = other.to_owned();
        odd.instructions.welcome = format!("{other}\n\n{other}");
        odd.recovery.duration_s = 1.0 / 3.0;
        odd.design.order = Order::Latin("depth".to_owned());
        odd.design.max_run = None;
    });
    let built_in = definition::BUILT_IN.iter().map(|built_in| definition::open(built_in.name).unwrap());
    let timed = edited("[recovery]", "[presentation]\nduration_s = 0.5\n[recovery]");
    let others = [BASE, &timed].map(|text| definition::parse("mine.toml", text).unwrap());
    for protocol in built_in.chain(others).chain([odd.unwrap()]) {
        // Write the definition as text and read it back, as a sidecar does.
        let json: serde_json::Value =
            serde_json::from_str(&serde_json::to_string(&serde_json::to_value(&protocol).unwrap()).unwrap()).unwrap();
        let back: Protocol = definition::from_json("sidecar.json", &json).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(back, protocol);
        assert_eq!(definition::hash(&back), definition::hash(&protocol));
    }
    for (broken, part) in [("{}", "schema 1"), ("3", "expected a table"), ("{\"a\": null}", "a")] {
        let error = definition::from_json("sidecar.json", &serde_json::from_str(broken).unwrap()).unwrap_err();
        assert!(error.to_string().starts_with("sidecar.json") && error.to_string().contains(part), "{error}");
    }
}

fn sha256(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns the hash of a definition as a file.
fn hash(text: &str) -> String {
    definition::hash(&definition::parse("mine.toml", text).unwrap_or_else(|error| panic!("{text}: {error}")))
}

/// The hash is that of the canonical JSON, which has only what the file says, so no default is a part of it.
#[test]
fn the_hash_covers_exactly_what_a_definition_says() {
    let said = r#"{"name":"mine","title":"My study","stimulus":{"kind":"mach-band"},"factors":{"width":[0.1,0.4],"depth":[1.0,2.0,"inf"]},"design":{"repetitions":2,"practice":4,"break_every":10,"max_run":3},"response":{"question":"How?","labels":["a","b","c","d"]},"instructions":{"welcome":"Hello"}}"#;
    assert_eq!(hash(BASE), sha256(said));
    let (least, said) =
        ("schema = 1\nname = \"a\"\nstimulus.kind = \"chevreul\"\n", r#"{"name":"a","stimulus":{"kind":"chevreul"}}"#);
    assert_eq!(hash(least), sha256(said));
}

/// Layout, the order of keys, and keys with their default values do not affect the hash.
#[test]
fn what_means_the_same_has_the_same_hash() {
    let same = [
        BASE.replace("width = [0.1, 0.4]", "# comment\nwidth   = [ 1e-1,\n  4e-1, ] # and another"),
        BASE.replace("depth = [1, 2, \"inf\"]", "depth = [1.0, 2.0, inf]"),
        BASE.replace("[instructions]", "[participant]\n[instructions]"),
        // The order of keys and of tables.
        BASE.replace("low = 0.25\nhigh = 0.75", "high = 0.75\nlow = 0.25"),
        BASE.replace("[viewing]\ndistance_cm = 50.0\nwindow_deg = 10.0\n", "")
            .replace("[stimulus]", "[viewing]\nwindow_deg = 10\ndistance_cm = 5_0\n[stimulus]"),
    ];
    for text in same {
        assert_eq!(hash(&text), hash(BASE), "{text}");
    }
    // Every key, with its default in the same words as in the canonical form.
    let least = "schema = 1\nname = \"a\"\nstimulus.kind = \"mach-band\"\n";
    for [key, _, default] in machband::experiment::Texts::ALL {
        let text = format!("{least}[instructions]\n{key} = {}\n", serde_json::to_string(default).unwrap());
        assert_eq!(hash(&text), hash(least), "{key}");
    }
    let scale = ResponseScale::default();
    let labels: Vec<&str> = scale.categories.iter().map(|category| category.label.as_str()).collect();
    for default in [
        "title = \"a\"\n",
        "[factors]\n",
        "[design]\nrepetitions = 1\npractice = 0\nbreak_every = 0\norder = \"random\"\n",
        "[recovery]\nduration_s = 2\nlevel = 0.5\n",
        "[viewing]\ndistance_cm = 50\nwindow_deg = 10\n",
        "[response]\nkeys = [\"0\", \"1\", \"2\", \"3\"]\n",
        &format!("[response]\nquestion = {:?}\nlabels = {labels:?}\n", scale.question),
    ] {
        assert_eq!(hash(&format!("{least}{default}")), hash(least), "{default}");
    }
    let asking = format!("{least}[participant]\nage = {{}}\n");
    assert_eq!(hash(&asking.replace("{}", "{ required = true, number = false, choices = [] }")), hash(&asking));
}

/// Every parameter of every kind of stimulus can be a factor, has a column, and keeps its levels. With its default, it
/// does not affect the hash.
#[test]
fn any_parameter_of_any_kind_can_be_a_factor() {
    for kind in KINDS {
        let stimulus = machband::stimulus::Stimulus::default_of(kind).unwrap();
        for parameter in stimulus.parameters() {
            let value = serde_json::to_string(&stimulus.get(parameter.name).unwrap()).unwrap();
            let least = format!("schema = 1\nname = \"a\"\nstimulus.kind = \"{kind}\"\n");
            let said = format!("{least}stimulus.{} = {value}\n", parameter.name);
            assert_eq!(hash(&said), hash(&least), "{kind} {}", parameter.name);
            let text = format!("{least}factors.{} = [{value}]\n", parameter.name);
            let protocol = definition::parse("a.toml", &text).unwrap_or_else(|error| panic!("{text}: {error}"));
            let names: Vec<String> = columns(&protocol).into_iter().map(|column| column.name).collect();
            assert_eq!(names.iter().filter(|name| *name == parameter.name).count(), 1, "{kind} {}", parameter.name);
            assert_eq!(names.iter().collect::<HashSet<_>>().len(), names.len(), "{kind}: {names:?}");
            let json = serde_json::to_value(&protocol).unwrap();
            assert_eq!(definition::from_json("a.json", &json).unwrap(), protocol, "{text}");
        }
    }
}

#[test]
fn display_profiles_and_observers_are_validated_too() {
    let good = "schema = 1\nname = \"Left\"\ntransfer = \"gamma:2.2\"\nmeasured = { on = \"2026-01-31\" }\nscreen_width_cm = 53.1\n";
    let profile = profile::parse("p.toml", good).unwrap();
    assert_eq!((profile.transfers, profile.screen_width_cm), (Transfer::Gamma(2.2).into(), Some(53.1)));
    let table = "schema = 1\nname = \"T\"\ntransfer = { encoded = [0, 0.5, 1], linear = [0, 0.2, 1] }\n";
    profile::parse("p.toml", table).unwrap();
    let full = "schema = 1\nname = \"Full\"\ntransfer = \"gamma:2/gog:2.2,1,-0.02/srgb\"\nblack_cd_m2 = 0.1\n\
                white_cd_m2 = 200\nbits = 8\nnative_px = [1920, 1080]\n\
                measured = { on = \"2026-01-31\", by = \"N. N.\", with = \"photometer\" }\n\
                primaries = { red = [0.64, 0.33], green = [0.3, 0.6], blue = [0.15, 0.06], white = [0.3127, 0.329] }\n";
    let each = "schema = 1\nname = \"Each\"\n\
                transfer = [{ encoded = [0, 0.5, 1], linear = [0, 0.2, 1] }, \"gamma:2.1\", \"srgb\"]\n";
    // Sidecars contain the hash of this text, so it must not change.
    let canonical = "{\"schema\":1,\"name\":\"Left\",\"transfer\":\"gamma:2.2\",\"screen_width_cm\":53.1,\
                     \"measured\":{\"on\":\"2026-01-31\"}}";
    assert_eq!(profile::value(&profile::parse("p.toml", good).unwrap()).to_string(), canonical);
    // A written profile reads back unchanged, and equal profiles have equal hashes.
    let folder = tempfile::tempdir().unwrap();
    for text in [good, table, full, each] {
        let read = profile::parse("p.toml", text).unwrap();
        let path = folder.path().join("profile.toml");
        profile::write(&Writer::new([], true), &path, &read).unwrap();
        let again = profile::open(&path).unwrap();
        assert_eq!((&again, profile::hash(&again)), (&read, profile::hash(&read)), "{text}");
        assert_ne!(profile::hash(&read), profile::hash(&DisplayProfile { name: "x".to_owned(), ..read }));
    }
    let cases = [
        (full, "200", "0.1", "5:1", "not above black_cd_m2"),
        (full, "white_cd_m2 = 200\n", "", "4:1", "black_cd_m2 is given without white_cd_m2"),
        (full, "2026-01-31", "31.1.2026", "8:14", "measured.on"),
        (full, "[0.3, 0.6]", "[0.3, 0.8]", "9:35", "primaries.green"),
        (full, "gamma:2/gog:2.2,1,-0.02/srgb", "srgb/srgb", "3:1", "expected one, or three"),
        (each, ", \"srgb\"]", "]", "3:1", "or a list of three"),
        (good, "\"gamma:2.2\"", "\"table\"", "3:1", "expected"),
        (table, "0.2, 1]", "0.2, 0.1]", "3:1", "expected"),
        (table, "linear", "lineal", "3:1", "neither text nor a table with encoded and linear"),
    ];
    for (text, from, to, position, part) in cases {
        let error = profile::parse("p.toml", &text.replacen(from, to, 1)).expect_err(to);
        assert_error(&error, &format!("p.toml:{position}: "), part);
    }
    assert_eq!(observer::parse::<OrderedLogit>("o.toml", observer::PAPER).unwrap(), Default::default());
    assert_eq!(observer::parse::<OrderedLogit>("o.toml", "schema = 1\n").unwrap(), Default::default());
    let cases = [
        ("schema = 1", "schema = 9", "schema is 9"),
        ("[0.0, 1.5, 3.5]", "[0.0, 3.5, 1.5]", "three increasing numbers"),
        ("lapse = 0.01", "lapse = 1.01", "lapse 1.01 is outside 0…1"),
        ("lapse = 0.01", "lapes = 0.01", "did you mean lapse?"),
    ];
    for (from, to, part) in cases {
        assert_eq!(observer::PAPER.matches(from).count(), 1, "{from}");
        let text = observer::PAPER.replace(from, to);
        let line = text.lines().position(|line| line.contains(to)).unwrap() + 1;
        assert_error(
            &observer::parse::<OrderedLogit>("o.toml", &text).expect_err(to),
            &format!("o.toml:{line}:"),
            part,
        );
    }
}

/// `results/README.md` ends with the column dictionary, which is generated from the program's column definitions.
#[test]
fn the_column_dictionary_is_up_to_date() {
    const RULE: &str = "|---|---|---|\n";
    let found = fs::read_to_string("results/README.md").unwrap();
    let (head, _) = found.split_once(RULE).unwrap();
    let mut expected = format!("{head}{RULE}");
    for column in columns(&definition::open("bangay2003").unwrap()) {
        let levels: Vec<String> = column
            .levels
            .iter()
            .map(|(value, meaning)| format!("{value}: {}", meaning.as_str().unwrap_or_default()))
            .collect();
        let levels = if levels.is_empty() { String::new() } else { format!(" ({})", levels.join("; ")) };
        expected += &format!("| `{}` | {} | {}{levels} |\n", column.name, column.unit, column.description);
    }
    assert_documented("results/README.md", &expected);
}

/// A definition with comments and layouts that an editor must not change.
const COMMENTED: &str = r#"# A study, by hand.
schema = 1
name = "by-hand"      # also the folder
title = "Mach bands"

[stimulus]            # the same in all trials
kind = 'mach-band'
color = "gray"        # neutral

# What varies.
[factors]
width = [
    0.1,  # narrow
    0.4,  # as in the paper
    0.8,  # wide
]
# An infinite depth is smooth everywhere.
depth = [1, 2, "inf"] # not 3
orientation_deg = [0, 90]

[design]
repetitions = 4
order = "blocked:depth"

[response]
question = "Wie deutlich?"
labels = ["kein Band", "breit, weich", "schmal", "scharf"]

# The end.
"#;

fn draft(text: &str) -> Draft {
    Draft::parse("draft", text).unwrap()
}

#[test]
fn only_what_is_edited_changes() {
    let built_in = definition::BUILT_IN.iter().map(|built_in| built_in.text);
    for text in built_in.chain([COMMENTED]) {
        for text in [text.to_owned(), text.replace('\n', "\r\n")] {
            let mut draft = draft(&text);
            assert_eq!(draft.text(), text);
            // Typing what is already there changes nothing.
            for factor in draft.factors() {
                let key = format!("factors.{factor}");
                draft.set(&key, &draft.get(&key).unwrap(), Typed::Values);
            }
            if let Some(repetitions) = draft.get("design.repetitions") {
                draft.set("design.repetitions", &repetitions, Typed::Value);
            }
            draft.set("title", &draft.get("title").unwrap(), Typed::Text);
            assert_eq!(draft.text(), text);
            let name = draft.get("name").unwrap();
            draft.set("name", "a-copy", Typed::Text);
            assert_eq!(draft.text(), text.replacen(&format!("name = \"{name}\""), "name = \"a-copy\"", 1));
            assert_eq!(draft.check(None).unwrap().name, "a-copy");
        }
    }
}
