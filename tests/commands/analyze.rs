//! `machband analyze` and `machband counts`, as a user types them.

use std::{collections::BTreeMap, fs, path::Path};

use crate::common::{machband, succeeds};

/// What a run that fails with this status says.
fn fails(folder: &Path, arguments: &[&str], status: i32) -> String {
    let output = machband(folder, arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
    assert!(said.lines().all(|line| line.starts_with("error: ")), "{said}");
    said
}

fn read(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_path(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let header = reader.headers().unwrap().iter().map(str::to_owned).collect();
    (header, reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect())
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// A folder with the results of some simulated participants.
fn study(experiment: &str, participants: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["simulate", experiment, "--participants", participants, "--seed", "5"]);
    folder
}

/// Every file of the contract is there, with the columns of the contract, and its numbers are those of the rows.
#[test]
fn a_study_is_analysed() {
    let folder = study("bangay2003", "4");
    let said = succeeds(folder.path(), &["analyze", "results", "--out", "a"]);
    assert!(said.contains("960 ratings of 120 conditions by 4 participants"), "{said}");
    assert!(said.contains("48 practice rows"), "{said}");
    let out = folder.path().join("a");
    let (header, cells) = read(&out.join("cells.csv"));
    let contract = "width,depth,orientation_deg,n,mean,median,p0,p1,p2,p3,ci_low,ci_high";
    assert!(header.join(",").starts_with(contract), "{header:?}");
    assert_eq!(cells.len(), 120);

    // Means by hand, from the rows.
    let mut sums: BTreeMap<(String, String, String), (f64, f64)> = BTreeMap::new();
    for entry in fs::read_dir(folder.path().join("results/bangay2003/data")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "csv") {
            let (header, rows) = read(&path);
            let column = |name: &str| header.iter().position(|known| known == name).unwrap();
            for row in rows.iter().filter(|row| row[column("phase")] == "main") {
                let cell = |name| row[column(name)].clone();
                let sum = sums.entry((cell("width"), cell("depth"), cell("orientation_deg"))).or_default();
                sum.0 += row[column("rating")].parse::<f64>().unwrap();
                sum.1 += 1.0;
            }
        }
    }
    for row in &cells {
        let (sum, n) = sums[&(row[0].clone(), row[1].clone(), row[2].clone())];
        assert_eq!(row[3].parse::<f64>().unwrap(), n);
        assert!((row[4].parse::<f64>().unwrap() - sum / n).abs() < 1e-12, "{row:?}");
        let [low, high] = [10, 11].map(|i: usize| row[i].parse::<f64>().unwrap());
        assert!(low <= sum / n && sum / n <= high, "{row:?}");
    }
    for factor in ["width", "depth", "orientation_deg"] {
        let (header, rows) = read(&out.join(format!("by_{factor}.csv")));
        assert_eq!(header[0], factor);
        assert_eq!(rows.iter().map(|row| row[1].parse::<u64>().unwrap()).sum::<u64>(), 960);
    }
    let model = json(&out.join("model.json"));
    for name in ["link", "method", "nobs", "loglik", "thresholds", "coefficients", "random"] {
        assert!(!model[name].is_null(), "{name}");
    }
    assert_eq!(model["method"], "clmm-laplace");
    assert_eq!(model["thresholds"].as_array().unwrap().len(), 3);
    assert_eq!(model["coefficients"].as_array().unwrap().len(), 5 + 4 + 3);
    for name in ["name", "estimate", "se", "z", "p"] {
        assert!(!model["coefficients"][0][name].is_null(), "{name}");
    }
    assert!(model["random"]["sd"].as_f64().unwrap() >= 0.0);
    let (_, tests) = read(&out.join("tests.csv"));
    for kind in ["friedman", "wilcoxon", "likelihood-ratio", "proportional-odds"] {
        assert!(tests.iter().any(|row| row[0] == kind), "{kind}");
    }
    // 4 participants and 15 pairs of widths: the least possible corrected probability is 15 · 2/2⁴.
    assert!(tests.iter().any(|row| row[0] == "wilcoxon" && row[11].contains("no p_holm below")));
    let (_, agreement) = read(&out.join("agreement.csv"));
    assert!(agreement.iter().any(|row| row[0] == "krippendorff_alpha_ordinal"));
    assert_eq!(agreement.iter().filter(|row| row[0] == "retest_kappa_quadratic").count(), 4);
    for figure in ["figure4a", "figure4b"] {
        assert!(fs::read(out.join(format!("{figure}.png"))).unwrap().starts_with(b"\x89PNG"));
        assert!(fs::read_to_string(out.join(format!("{figure}.svg"))).unwrap().contains("<svg"));
    }
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<!DOCTYPE html>") || page.contains("<!doctype html>"));
}

/// Equal input and seed give equal bytes; another seed moves the intervals alone.
#[test]
fn an_analysis_can_be_repeated() {
    let folder = study("quick", "6");
    let analyze = |out: &str, seed: &str| {
        let fixed = ["analyze", "results", "--out", out, "--tables-only", "--replicates", "100"];
        succeeds(folder.path(), &[&fixed[..], &["--seed", seed]].concat());
        read(&folder.path().join(out).join("cells.csv")).1
    };
    let cells = analyze("a", "1");
    assert_eq!(cells, analyze("b", "1"));
    let other = analyze("c", "2");
    assert_ne!(cells, other);
    let without_interval = |rows: &[Vec<String>]| rows.iter().map(|row| row[..10].to_vec()).collect::<Vec<_>>();
    assert_eq!(without_interval(&cells), without_interval(&other));
    for file in ["model.json", "tests.csv", "counts.csv"] {
        let bytes = |out: &str| fs::read(folder.path().join(out).join(file)).unwrap();
        assert_eq!(bytes("a"), bytes("b"), "{file}");
    }
}

/// Counts say the same as the rows they were made of, whichever way they come.
#[test]
fn counts_are_taken_back() {
    let folder = study("bangay2003", "3");
    succeeds(folder.path(), &["analyze", "results/bangay2003", "--out", "rows", "--tables-only"]);
    succeeds(folder.path(), &["counts", "results/bangay2003", "--out", "counts.csv"]);
    succeeds(folder.path(), &["analyze", "counts.csv", "--out", "counts", "--tables-only"]);
    let bytes = |out: &str, file: &str| fs::read(folder.path().join(out).join(file)).unwrap();
    for file in ["cells.csv", "model.json", "tests.csv", "counts.csv"] {
        assert_eq!(bytes("rows", file), bytes("counts", file), "{file}");
    }
    assert_eq!(fs::read(folder.path().join("counts.csv")).unwrap(), bytes("rows", "counts.csv"));
    // Under other names, in two parts, and with a factor's name as a term.
    let text = fs::read_to_string(folder.path().join("counts.csv")).unwrap();
    let renamed = text.replacen("subject_id", "who", 1).replacen("rating,count", "score,times", 1);
    let lines: Vec<&str> = renamed.lines().collect();
    let part = |rows: &[&str]| format!("{}\n{}\n", lines[0], rows.join("\n"));
    fs::write(folder.path().join("p1.csv"), part(&lines[1..50])).unwrap();
    fs::write(folder.path().join("p2.csv"), part(&lines[50..])).unwrap();
    let named = ["--subject", "who", "--response", "score", "--count", "times"];
    let terms = ["--terms", "width,depth,orientation_deg", "--out", "named", "--tables-only"];
    succeeds(folder.path(), &[&["analyze", "p1.csv", "p2.csv"][..], &named, &terms].concat());
    let (a, b) = (json(&folder.path().join("rows/model.json")), json(&folder.path().join("named/model.json")));
    assert_eq!(a["coefficients"], b["coefficients"]);
    assert_eq!(a["loglik"], b["loglik"]);
}

/// Any scale and any names: the table of counts is analysed as the file was, and an order that nobody told is asked for.
#[test]
fn other_scales_need_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut rows = String::from("who,group,answer\n");
    for i in 0..240 {
        let answer = ["low", "medium", "high"][(i * 7 % 11 + i % 2 * 4) / 5];
        rows += &format!("p{},{},{answer}\n", i % 8, ["a", "b"][i % 2]);
    }
    fs::write(folder.path().join("d.csv"), rows).unwrap();
    let named = ["--subject", "who", "--response", "answer"];
    let with = |more: &[&'static str]| [&named[..], more].concat();
    let said = fails(folder.path(), &[&["analyze", "d.csv", "--out", "x", "--terms", "group"][..], &named].concat(), 2);
    assert!(said.contains("--categories high,low,medium"), "{said}");
    let order = ["--categories", "low,medium,high", "--tables-only"];
    let analyze = |file: &'static str, out: &'static str, terms: &'static str| {
        let fixed = with(&["--terms", terms, "--out", out]);
        succeeds(folder.path(), &[&["analyze", file][..], &fixed, &order].concat());
        fs::read(folder.path().join(out).join("model.json")).unwrap()
    };
    let model = analyze("d.csv", "a", "group");
    succeeds(folder.path(), &[&["counts", "d.csv", "--out", "c.csv", "--factors", "group,group"][..], &named].concat());
    assert_eq!(analyze("c.csv", "b", "group"), model);
    let text = String::from_utf8(model).unwrap();
    assert!(text.contains("low|medium") && text.contains("medium|high"), "{text}");
    // A name that stands in several terms is one factor; a column has one role.
    analyze("d.csv", "c", "group,group:group");
    assert_eq!(read(&folder.path().join("c/cells.csv")).0[..2], ["group", "n"]);
    let said =
        fails(folder.path(), &[&["analyze", "d.csv", "--out", "x", "--terms", "answer"][..], &named].concat(), 1);
    assert!(said.contains("the column answer has two uses"), "{said}");
}

/// A newcomer's one session is described, and nothing is inferred from it.
#[test]
fn one_person_is_described() {
    let folder = study("quick", "1");
    let said = succeeds(folder.path(), &["analyze", "results", "--out", "a"]);
    assert!(said.contains("24 ratings of 24 conditions by 1 participant, from 1 file"), "{said}");
    let out = folder.path().join("a");
    assert!(read(&out.join("tests.csv")).1.is_empty());
    assert!(read(&out.join("agreement.csv")).1.is_empty());
    assert!(read(&out.join("cells.csv")).1.iter().all(|row| row[10].is_empty() && row[11].is_empty()));
    let model = json(&out.join("model.json"));
    assert!(model["random"].is_null() && model["coefficients"][0]["p"].is_null(), "{model}");
    assert!(model["sentences"][0].as_str().unwrap().contains("only one participant"), "{model}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!page.contains("p &lt; ") && !page.contains("p = "), "a probability from one person");
}

/// Terms as in the contract: factors by name, numbers with num:, 1/n as num:inv_n; both links, both approximations.
#[test]
fn models_are_asked_for_by_their_terms() {
    let folder = study("bangay2003", "3");
    let model = |arguments: &[&str]| {
        let fixed = ["analyze", "results", "--out", "a", "--tables-only"];
        succeeds(folder.path(), &[&fixed, arguments].concat());
        json(&folder.path().join("a/model.json"))
    };
    let names = |model: &serde_json::Value| -> Vec<String> {
        let list = model["coefficients"].as_array().unwrap().iter();
        list.map(|coefficient| coefficient["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&model(&["--terms", "num:width,num:inv_n"])), ["width", "inv_n"]);
    assert_eq!(names(&model(&["--terms", "num:inv_n,num:inv_n:num:width"])), ["inv_n", "inv_n:width"]);
    // A column that is no factor of the definition can be one of the model.
    assert_eq!(names(&model(&["--terms", "repetition"])), ["repetition2"]);
    let probit = model(&["--terms", "width", "--link", "probit", "--random", "none"]);
    assert_eq!((&probit["link"], &probit["method"]), (&"probit".into(), &"clm".into()));
    assert_eq!(model(&["--terms", "width", "--quadrature", "10"])["method"], "clmm-aghq-10");
    for (arguments, expected) in [
        (["--terms", "widht"], "did you mean width"),
        (["--terms", "num:depth"], "num:inv_n"),
        (["--terms", "width,,depth"], "an empty name"),
        (["--quadrature", "0"], "--quadrature"),
        (["--link", "cloglog"], "logit"),
    ] {
        let fixed = ["analyze", "results", "--out", "b"];
        let output = machband(folder.path(), &[&fixed[..], &arguments].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
        assert!(!folder.path().join("b").exists(), "{arguments:?}");
    }
}

/// What is wrong is named with file, line and column; the rest is analysed, and the status tells.
#[test]
fn faults_are_named_and_the_rest_is_analysed() {
    let folder = study("quick", "3");
    let data = folder.path().join("results/quick/data");
    let path = data.join("subject-S002_session-1_task-quick_data.csv");
    let text = fs::read_to_string(&path).unwrap();
    let line = text.lines().nth(10).unwrap();
    let mut cells: Vec<&str> = line.split(',').collect();
    cells[16] = "4";
    fs::write(&path, text.replace(line, &cells.join(","))).unwrap();
    let said = fails(folder.path(), &["analyze", "results", "--out", "a", "--tables-only"], 1);
    let column = cells[..16].iter().map(|cell| cell.len() + 1).sum::<usize>() + 1;
    let place = format!("subject-S002_session-1_task-quick_data.csv:11:{column}: ");
    assert!(said.contains(&place) && said.contains('4') && said.contains("expected"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    let total: u64 = read(&folder.path().join("a/counts.csv")).1.iter().map(|row| row[5].parse::<u64>().unwrap()).sum();
    assert_eq!(total, 71);
    for (name, content, expected) in [
        ("nothing", &b""[..], "empty"),
        ("absent.csv", b"-", "absent.csv"),
        ("columns.csv", b"a,b\n1,2\n", "subject_id"),
    ] {
        if content != b"-" {
            fs::write(folder.path().join(name), content).unwrap();
        }
        let said = fails(folder.path(), &["analyze", name, "--out", "b"], 1);
        assert!(said.contains(expected) && said.contains("expected"), "{said}");
        assert!(!folder.path().join("b").exists());
    }
}
