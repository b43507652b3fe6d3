//! Requests: one struct that the command line, Python and the window fill in, and the words that repeat it.

use std::{collections::BTreeMap, fs, path::Path};

use clap::{Args, Command};
use machband::work::{Analyze, from_names, simulate::Simulate, words};
use serde_json::{Map, Value, json};

use crate::common::{split, succeeds};

fn fields(value: Value) -> Map<String, Value> {
    value.as_object().unwrap().clone()
}

/// Reads words as the command line does.
fn parsed<T: Args>(words: &[String]) -> T {
    let command = T::augment_args(Command::new("machband").no_binary_name(true));
    T::from_arg_matches(&command.get_matches_from(words)).unwrap()
}

#[test]
fn words_repeat_a_request_and_leave_out_defaults() {
    let given = fields(json!({
        "paths": ["a b.csv", "-c.csv"], "response": "score", "categories": ["low", "medium, mostly", "-high"],
        "terms": "width,num:inv_n", "link": "probit", "random": "none", "draws": "199", "seed": u64::MAX,
        "complete_only": true, "large": false, "subject": null,
    }));
    let request: Analyze = from_names(&given).unwrap();
    let line = words(&request);
    assert_eq!(parsed::<Analyze>(&line), request, "{line:?}");
    assert!(line.contains(&u64::MAX.to_string()) && line.contains(&"--complete-only".to_owned()), "{line:?}");
    assert!(!line.iter().any(|word| word.contains("slopes") || word.contains("large")), "{line:?}");
    let defaults: Analyze = from_names(&fields(json!({ "paths": ["r"] }))).unwrap();
    assert_eq!(words(&defaults), ["r"]);
    let simulate: Simulate = from_names(&fields(json!({ "experiment": "quick", "observer": "random" }))).unwrap();
    assert_eq!(words(&simulate), ["quick", "--observer", "random"]);
}

/// A path that is not UTF-8 is written as well as possible, and nothing else is lost.
#[cfg(unix)]
#[test]
fn words_keep_the_rest_of_a_request_with_a_strange_path() {
    use std::{ffi::OsStr, os::unix::ffi::OsStrExt as _};

    let mut request: Simulate = from_names(&fields(json!({ "experiment": "quick", "participants": "3" }))).unwrap();
    request.results = OsStr::from_bytes(b"caf\xe9").into();
    assert_eq!(words(&request), ["quick", "--participants", "3", "--results", "caf\u{fffd}"]);
    let mut request: Analyze = from_names(&fields(json!({ "paths": ["a"], "exclude": ["S001"] }))).unwrap();
    request.ratings.paths = vec![OsStr::from_bytes(b"\xff.csv").into(), "b.csv".into()];
    assert_eq!(words(&request), ["\u{fffd}.csv", "b.csv", "--exclude", "S001"]);
}

#[test]
fn a_wrong_request_names_its_field() {
    for (given, expected) in [
        (json!({ "draws": 3 }), "draws 3: 3 is not in 19..=1000000"),
        (
            json!({ "link": "probits" }),
            "link \"probits\" is not known; expected one of logit, probit; did you mean probit?",
        ),
        (json!({ "slope": "none" }), "slope is not known; expected one of "),
        (json!({ "categories": ["a", "a"], "response": "x" }), "categories a,a: a appears twice"),
    ] {
        let mut given = fields(given);
        given.insert("paths".to_owned(), json!(["a.csv"]));
        let error = from_names::<Analyze>(&given).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{error}");
        assert!(error.told(|field| format!("--{field}")).starts_with("--"), "{error}");
    }
}

/// The names and contents of all files in a folder; the report without the time at which it was made.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(folder).unwrap().map(Result::unwrap);
    let named = files.map(|file| (file.file_name().into_string().unwrap(), fs::read(file.path()).unwrap()));
    named.filter(|(name, _)| name != "report.html").collect()
}

#[test]
fn the_command_in_a_report_repeats_the_analysis_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("simulate quick --participants 3 --seed 5"));
    let line = "analyze results/quick --terms num:width --link=probit --draws=39 --seed 1 --out first";
    succeeds(folder.path(), &split(line));
    let report = fs::read_to_string(folder.path().join("first/report.html")).unwrap();
    let command = "machband analyze results/quick --terms num:width --link probit --draws 39 --out first";
    assert!(report.contains(command), "{line}");
    let again = command.trim_start_matches("machband ").replace("--out first", "--out second");
    succeeds(folder.path(), &split(&again));
    assert_eq!(contents(&folder.path().join("first")), contents(&folder.path().join("second")));
}
