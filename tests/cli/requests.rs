//! Requests: one struct that the command line, Python and the window fill in, and the words that repeat it.

use std::{collections::BTreeMap, fs, path::Path};

use clap::{Args, Command};
use machband::{
    store::profile,
    work::{
        Analyze, Check, Found, Repair, calibrate::Calibrate, from_names, plan::Plan, simulate::Simulate,
        verify::Verify, words,
    },
};
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::common::{change_rating, everything, machband, session_csv, split, succeeds, text};

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
        "complete_only": true, "large": false, "subject": null, "missing": "-99,n", "min_time": 0.25,
        "only": ["\"kind=x\"=a,b", "width=0.1"],
    }));
    let request: Analyze = from_names(&given).unwrap();
    let line = words(&request);
    assert_eq!(parsed::<Analyze>(&line), request, "{line:?}");
    assert!(line.contains(&u64::MAX.to_string()) && line.contains(&"--complete-only".to_owned()), "{line:?}");
    assert!(!line.iter().any(|word| word.contains("slopes") || word.contains("large")), "{line:?}");
    assert_eq!((request.ratings.how.only[0].0.as_str(), request.ratings.how.only[0].1.len()), ("kind=x", 2));
    assert!(line.contains(&"--missing=-99,n".to_owned()) && line.contains(&"0.25".to_owned()), "{line:?}");
    let wide: Analyze = from_names(&fields(json!({ "paths": ["r"], "wide": ["near", "far"] }))).unwrap();
    assert_eq!(words(&wide), ["r", "--wide", "condition=near,far"]);
    let defaults: Analyze = from_names(&fields(json!({ "paths": ["r"] }))).unwrap();
    assert_eq!(words(&defaults), ["r"]);
    let simulate: Simulate = from_names(&fields(json!({ "experiment": "quick", "observer": "random" }))).unwrap();
    assert_eq!(words(&simulate), ["quick", "--observer", "random"]);
}

#[test]
fn a_wrong_request_names_its_field() {
    for (given, expected) in [
        (json!({ "draws": 3 }), "draws 3: outside 99…1000000; expected a whole number in this range"),
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
    let line = "analyze results/quick --terms num:width --link=probit --draws=99 --seed 1 --out first";
    succeeds(folder.path(), &split(line));
    let report = fs::read_to_string(folder.path().join("first/report.html")).unwrap();
    let command = "machband analyze results/quick --terms num:width --link probit --draws 99 --out first";
    assert!(report.contains(command), "{line}");
    let again = command.trim_start_matches("machband ").replace("--out first", "--out second");
    succeeds(folder.path(), &split(&again));
    assert_eq!(contents(&folder.path().join("first")), contents(&folder.path().join("second")));
}

/// Makes a request from its fields, as Python and the window do, and the command that repeats it.
fn request<T: Args + Serialize>(command: &str, given: Value) -> (T, Vec<String>) {
    let request: T = from_names(&fields(given)).unwrap();
    let line = [vec![command.to_owned()], words(&request)].concat();
    (request, line)
}

#[test]
fn a_plan_and_a_calibration_are_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let given = json!({
        "experiment": "quick", "participants": ["3", "2"], "effects": ["oblique=1", "width:0.1=-0.5"],
        "deviations": ["width=0.5"], "studies": "4", "terms": "width,depth", "slopes": "none",
    });
    let (plan, line) = request::<Plan>("plan", given);
    succeeds(folder.path(), &[line, split("--out plan.csv")].concat());
    assert_eq!(fs::read(at("plan.csv")).unwrap(), plan.plan(&()).unwrap().table().csv());

    let levels = (0..=8).map(|i| f64::from(i) / 8.0);
    let readings: String = levels.map(|v| format!("gray,{v},{}\n", 0.3 + 90.0 * v.powf(2.2))).collect();
    fs::write(at("r.csv"), format!("channel,level,luminance_cd_m2\n{readings}")).unwrap();
    let given = json!({ "readings": at("r.csv"), "by": "A B", "on": "2026-02-03", "model": "table" });
    let (calibrate, line) = request::<Calibrate>("calibrate", given);
    assert!(machband(folder.path(), &[line, split("--out left.toml")].concat()).status.success());
    let made = calibrate.calibrate("left").unwrap();
    assert_eq!(profile::open(&at("left.toml")).unwrap(), made.profile);
}

/// Checks that a command says what was found about files.
fn assert_said(folder: &Path, line: &[String], found: &Found) {
    let files = found.files.iter().map(|(path, sentence)| format!("{}: {sentence}\n", path.display()));
    let errors = found.errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    let said = machband(folder, line);
    assert_eq!(text(&said.stdout), files.collect::<String>(), "{line:?}");
    assert_eq!(text(&said.stderr).replace("error: ", ""), format!("{errors}\n"), "{line:?}");
}

#[test]
fn what_is_found_about_files_is_what_the_command_says() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("simulate quick --participants 2"));
    let results = folder.path().join("results");
    let csv = session_csv(&results, "quick", "S002");
    change_rating(&csv);
    let (check, line) = request::<Check>("check", json!({ "files": ["quick", csv, "nothing"], "large": true }));
    assert_said(folder.path(), &line, &check.check(&()).unwrap());
    let (verify, line) = request::<Verify>("verify", json!({ "folder": results }));
    assert_said(folder.path(), &line, &verify.verify(&()).unwrap());

    // A file whose fourth line is damaged, and one that cannot be repaired.
    let damaged = fs::read_to_string(&csv).unwrap().replacen("S002_1_practice_0003", "", 1);
    fs::write(results.join("quick/data/other_data.csv"), "a,b\n").unwrap();
    let (repair, line) = request::<Repair>("repair", json!({ "path": results }));
    fs::write(&csv, &damaged).unwrap();
    let sidecar = fs::read(csv.with_extension("json")).unwrap();
    let found = repair.repair(&()).unwrap();
    let tables =
        || everything(&results).into_iter().filter(|(path, _)| path.extension().is_none_or(|end| end != "json"));
    let repaired: Vec<_> = tables().collect();
    assert!(repaired.iter().any(|(path, _)| path.to_string_lossy().ends_with("damaged-1")));
    fs::write(csv.with_extension("json"), sidecar).unwrap();
    fs::write(&csv, &damaged).unwrap();
    fs::remove_file(csv.with_extension("csv.damaged-1")).unwrap();
    assert_said(folder.path(), &line, &found);
    assert!(tables().eq(repaired));
}
