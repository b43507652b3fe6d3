//! What a session asks about its participant: which answers count, and that none is lost.

use std::{
    fs,
    path::{Path, PathBuf},
};

use machband::{
    experiment::{Answers, Identity, ParticipantField, Protocol},
    store::{
        dataset::SessionPaths,
        definition,
        export::{Choice, Format, export},
        session::SessionStore,
        sidecar::Sidecar,
    },
};
use serde_json::{Value, json};

use crate::{
    common::{json as read_json, verified},
    recording::{SEED, TEXT, rate, sitting},
};

const QUESTIONS: &str = "[participant]\nage = {}\nsex = { required = false }\nconsent = { text = \"I take part.\" }\n\
     hobby = { required = false }\n";

fn asking() -> Protocol {
    definition::parse("asking.toml", &format!("{TEXT}{QUESTIONS}")).unwrap()
}

fn answers(entries: &[(&str, Value)]) -> Answers {
    entries.iter().map(|(name, answer)| ((*name).to_owned(), answer.clone())).collect()
}

/// A complete session of a participant with these answers.
fn session(results: &Path, subject: &str, number: &str, answers: Answers) {
    let (protocol, identity) = (asking(), Identity::new(subject, number).unwrap());
    let (mut store, _) = SessionStore::create(results, &protocol, &identity, SEED, sitting()).unwrap();
    store.keep_participant(answers);
    rate(&mut store, (&protocol, &identity), None, 100, false).unwrap();
}

fn csv_of(results: &Path, subject: &str) -> PathBuf {
    SessionPaths::new(results, &asking(), &Identity::new(subject, "1").unwrap()).csv
}

fn table(path: &Path) -> Vec<Vec<String>> {
    fs::read_to_string(path).unwrap().lines().map(|line| line.split('\t').map(str::to_owned).collect()).collect()
}

#[test]
fn answers_are_checked_in_the_form_in_which_people_give_them() {
    let asking = asking();
    let fields = &asking.participant;
    let field = |name: &str| fields.iter().find(|field| field.name == name).unwrap();
    let texts = &asking.instructions;
    let age = |typed: &str| field("age").answer(typed, texts);
    assert_eq!([" 27 ", "27,5", "1e1"].map(|typed| age(typed).unwrap().unwrap()), [json!(27), json!(27.5), json!(10)]);
    for (typed, error) in [
        ("", &texts.answer_missing),
        (" ", &texts.answer_missing),
        ("old", &texts.number_expected),
        ("-1", &texts.age_expected),
        ("1999", &texts.age_expected),
        ("inf", &texts.number_expected),
    ] {
        assert_eq!(age(typed), Err(error.as_str()), "{typed:?}");
    }
    let hobby = |typed: &str| field("hobby").answer(typed, texts);
    assert_eq!(hobby("\tchess and \n go "), Ok(Some(json!("chess and go"))));
    assert_eq!((hobby(""), hobby("=1")), (Ok(None), Err(texts.letter_expected.as_str())));
    let labels: Vec<_> = fields.iter().map(ParticipantField::label).collect();
    assert_eq!(labels, ["Age in years", "Sex", "Consent", "Hobby"]);
    assert_eq!(field("sex").choices(), ["female", "male", "other"]);
}

#[test]
fn no_participant_is_lost_among_sessions_that_run_at_the_same_time() {
    let one = |results: &Path, i: i32| {
        let hobby = if i == 3 { json!("chess\tand go") } else { Value::Null };
        let given = [("age", json!(20 + i)), ("consent", json!("2026-01-31")), ("hobby", hobby)];
        let given = given.into_iter().filter(|(_, answer)| !answer.is_null());
        session(results, &format!("S{i:03}"), "1", answers(&given.collect::<Vec<_>>()));
    };
    // The first sessions also make the data set, and with it the file whose lock the others wait for.
    let rounds = || {
        let folder = tempfile::tempdir().unwrap();
        let start = std::sync::Barrier::new(8);
        std::thread::scope(|scope| {
            for i in 1..=8_u8 {
                let (one, start, results) = (&one, &start, folder.path());
                scope.spawn(move || {
                    start.wait();
                    std::thread::sleep(std::time::Duration::from_micros(200 * u64::from(i)));
                    one(results, i.into());
                });
            }
        });
        let rows = table(&folder.path().join("small-one/participants.tsv")).len();
        assert_eq!(rows, 9);
        folder
    };
    (1..15).for_each(|_| drop(rounds()));
    let folder = rounds();
    let results = folder.path();
    let dataset = results.join("small-one");
    let path = dataset.join("participants.tsv");
    let mut rows = table(&path);
    assert_eq!(rows.remove(0), ["participant_id", "age", "sex", "consent", "hobby"]);
    rows.sort();
    assert_eq!(rows.len(), 8);
    assert_eq!(rows[2], ["sub-S003", "23", "n/a", "2026-01-31", "chess and go"]);
    let exported = tempfile::tempdir().unwrap();
    export(results, &exported.path().join("out"), Format::Bids, Choice::default()).unwrap();
    let described = read_json(&exported.path().join("out/participants.json"));
    assert_eq!((&described["age"]["Units"], &described["consent"]["Text"]), (&json!("years"), &json!("I take part.")));
    assert_eq!(described["sex"]["Levels"], json!({ "female": "female", "male": "male", "other": "other" }));
    let csv = csv_of(results, "S003");
    let sidecar = Sidecar::read(&csv.with_extension("json")).unwrap().unwrap();
    assert_eq!(sidecar.participant.unwrap()["age"], 23);
    assert_eq!(verified(&csv).errors, []);

    // Columns and rows that people add are kept. A later session updates only what was answered.
    let edited = fs::read_to_string(&path).unwrap().replace('\n', "\tx\r\n").replacen("\tx\r", "\tgroup\r", 1);
    fs::write(&path, edited + "sub-lab\tn/a\tn/a\tn/a\tn/a\ty\r\n").unwrap();
    session(results, "S003", "2", answers(&[("age", json!(24)), ("sex", json!("other"))]));
    let rows = table(&path);
    let row = |id: &str| rows.iter().find(|row| row[0] == id).unwrap().join(" ");
    assert_eq!((rows.len(), row("sub-S003")), (10, "sub-S003 24 other 2026-01-31 chess and go x".to_owned()));
    assert_eq!((row("sub-lab"), rows[0][5].as_str()), ("sub-lab n/a n/a n/a n/a y".to_owned(), "group"));
}

/// A table that is not one of participants is not touched. The session has the answers, and says so.
#[test]
fn a_table_that_cannot_be_read_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small-one/participants.tsv");
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, "name\tage\nAnn\t3\n").unwrap();
    session(folder.path(), "S001", "1", answers(&[("age", json!(31)), ("consent", json!("2026-01-31"))]));
    assert_eq!(fs::read_to_string(&path).unwrap(), "name\tage\nAnn\t3\n");
    let csv = csv_of(folder.path(), "S001");
    let sidecar = Sidecar::read(&csv.with_extension("json")).unwrap().unwrap();
    assert_eq!(sidecar.participant.as_ref().unwrap()["age"], 31);
    let incident = &sidecar.sittings[0].incidents[0];
    assert!(incident.contains("participants.tsv:1:1") && incident.contains("expected participant_id"), "{incident}");
    // Another encoding and a row that is too short, after an empty line: nothing is replaced, and the line is right.
    for (number, (table, expected)) in [
        (&b"participant_id\tnote\nsub-S009\tM\xfcller\n"[..], "is not UTF-8 text"),
        (
            &b"participant_id\tnote\n\nsub-S009\n"[..],
            "participants.tsv:3:1: the number of cells in the row is 1; expected 2",
        ),
        (
            &b"participant_id\tnote\n\"sub-S009\"\tx\n"[..],
            "participants.tsv:2:1: the participant is \"sub-S009\"; expected",
        ),
    ]
    .into_iter()
    .enumerate()
    {
        fs::write(&path, table).unwrap();
        let subject = format!("T{number}");
        session(folder.path(), &subject, "1", answers(&[("age", json!(31)), ("consent", json!("2026-01-31"))]));
        assert_eq!(fs::read(&path).unwrap(), table);
        let sidecar = Sidecar::read(&csv_of(folder.path(), &subject).with_extension("json")).unwrap().unwrap();
        let incident = &sidecar.sittings[0].incidents[0];
        assert!(incident.contains(expected), "{incident}");
    }
}
