//! Edits definitions without losing comments and layout.

use machband::store::{
    definition,
    draft::{Draft, Typed},
};

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

#[test]
fn edits_keep_comments_and_give_the_expected_definition() {
    let mut draft = draft(COMMENTED);
    draft.set("factors.width", "0.1, .4, 0.9, 1", Typed::Values);
    draft.set("factors.depth", "1, inf", Typed::Values);
    draft.set("design.repetitions", "2", Typed::Value);
    draft.set("design.order", "latin:depth", Typed::Text);
    draft.remove("design.max_run");
    draft.set("stimulus.color", "0.5,0.5,0.5", Typed::Value);
    draft.set("presentation.duration_s", "0.5", Typed::Value);
    draft.set("instructions.welcome", "Guten Tag\n\"Freund\"", Typed::Text);
    draft.set_texts("response.labels", &["kein Band", "breit", "schmal", "scharf"].map(str::to_owned));
    let expected = COMMENTED
        .replace(
            "[\n    0.1,  # narrow\n    0.4,  # as in the paper\n    0.8,  # wide\n]",
            "[0.1, 0.4, 0.9, 1]",
        )
        .replace(
            "depth = [1, 2, \"inf\"] # not 3\n",
            "depth = [1, \"inf\"] # not 3\n",
        )
        .replace("repetitions = 4", "repetitions = 2")
        .replace("blocked:depth", "latin:depth")
        .replace("\"gray\"  ", "\"0.5,0.5,0.5\"  ")
        .replace("\"breit, weich\"", "\"breit\"")
        .replace("scharf\"]\n", "scharf\"]\n\n[presentation]\nduration_s = 0.5\n\n[instructions]\nwelcome = \"\"\"\nGuten Tag\n\"Freund\"\"\"\"\n");
    assert_eq!(draft.text(), expected);
    let protocol = draft.check(None).unwrap();
    let levels = protocol.factors.iter().map(|factor| {
        let levels: Vec<_> = factor.levels.iter().map(ToString::to_string).collect();
        (factor.name.as_str(), levels.join(" "))
    });
    let levels: Vec<_> = levels.collect();
    assert_eq!(
        levels,
        [("width", "0.1 0.4 0.9 1".into()), ("depth", "1 inf".into()), ("orientation_deg", "0 90".to_owned())]
    );
    assert_eq!((protocol.design.repetitions, protocol.design.order.to_string()), (2, "latin:depth".to_owned()));
    assert_eq!(protocol.presentation.map(|presentation| presentation.duration_s), Some(0.5));
    assert_eq!(protocol.instructions.welcome, "Guten Tag\n\"Freund\"");
    assert_eq!(protocol.main_trials(), 4 * 2 * 2 * 2);

    // Parameters that the new kind does not have are removed. Factors are kept, with an error.
    draft.set_kind("kanizsa");
    let errors = draft.check(None).unwrap_err();
    let keys: Vec<&str> = errors.0.iter().map(|error| error.key.as_str()).collect();
    assert_eq!(keys, ["factors.width", "factors.depth", "design.order"], "{errors}");
    draft.remove("factors.width");
    draft.remove("factors.depth");
    draft.set("design.order", "random", Typed::Text);
    assert_eq!(draft.check(None).unwrap().main_trials(), 2 * 2);
    assert!(draft.text().contains("# What varies.\n[factors]\norientation_deg"), "{}", draft.text());
}
