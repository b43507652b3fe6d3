//! `machband analyze` and `machband counts`, as a user types them.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
    process::Command,
};

use crate::common::{fails, json, machband, number, records, refuses, session_csv, skip, split, succeeds, table, text};

/// Returns a folder with the results of some simulated participants.
fn study(experiment: &str, participants: u32) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let line = format!("simulate {experiment} --participants {participants} --seed 5");
    succeeds(folder.path(), &split(&line));
    folder
}

/// Checks that `columns.json` describes every column of the tables in a folder.
fn describes_columns(folder: &Path) {
    let described = json(&folder.join("columns.json"));
    for (file, columns) in described.as_object().unwrap() {
        let (header, _) = table(&folder.join(file));
        let names: Vec<&String> = columns.as_object().unwrap().keys().collect();
        assert_eq!(names, header.iter().collect::<Vec<_>>(), "{file}");
        let is_told = |name: &String| columns[name]["description"].as_str().is_some_and(|told| told.ends_with('.'));
        assert!(header.iter().all(is_told), "{file}: {columns}");
    }
    assert!(described["subjects.csv"].is_object() || described["thresholds.csv"].is_object(), "{described}");
}

/// Every documented file is written with its documented columns, and its numbers match the rows.
#[test]
fn analyze_writes_every_documented_file() {
    let folder = study("bangay2003", 4);
    let output = succeeds(folder.path(), &split("analyze results --out a"));
    assert!(output.contains("4 participants gave 960 ratings of 120 conditions"), "{output}");
    let out = folder.path().join("a");
    let (header, cells) = table(&out.join("cells.csv"));
    let contract = "width,depth,orientation_deg,n,mean,median,p0,p1,p2,p3,ci_low,ci_high";
    assert!(header.join(",").starts_with(contract) && cells.len() == 120, "{header:?}");

    // Means computed directly from the rows.
    let mut sums: BTreeMap<Vec<String>, (f64, f64)> = BTreeMap::new();
    let results = folder.path().join("results");
    for csv in ["S001", "S002", "S003", "S004"].map(|subject| session_csv(&results, "bangay2003", subject)) {
        for row in records(&csv).iter().filter(|row| row["phase"] == "main") {
            let levels = ["width", "depth", "orientation_deg"].map(|name| row[name].clone());
            let sum = sums.entry(levels.to_vec()).or_default();
            sum.0 += number::<f64>(row, "rating");
            sum.1 += 1.0;
        }
    }
    for row in &cells {
        let (sum, n) = sums[&row[..3]];
        let number = |i: usize| row[i].parse::<f64>().unwrap();
        assert!(number(3) == n && (number(4) - sum / n).abs() < 1e-12, "{row:?}");
        // If all participants have the same mean, there is no interval.
        assert!(row[10].is_empty() || (number(10) <= sum / n && sum / n <= number(11)), "{row:?}");
    }
    for factor in ["width", "depth", "orientation_deg"] {
        let (header, rows) = table(&out.join(format!("by_{factor}.csv")));
        let total: u64 = rows.iter().map(|row| row[1].parse::<u64>().unwrap()).sum();
        assert_eq!((header[0].as_str(), total), (factor, 960));
    }
    let model = json(&out.join("model.json"));
    let length = |name: &str| model[name].as_array().unwrap().len();
    assert_eq!((length("thresholds"), length("coefficients")), (3, 5 + 4 + 3));
    assert!(model["method"] == "clmm-laplace" && model["random"]["sd"].as_f64().unwrap() >= 0.0);
    let (header, coefficients) = table(&out.join("coefficients.csv"));
    assert_eq!(header.join(","), "name,term,estimate,se,z,p,ci_low,ci_high,odds_ratio,odds_ratio_low,odds_ratio_high");
    for (row, known) in coefficients.iter().zip(model["coefficients"].as_array().unwrap()) {
        let number = |i: usize| row[i].parse::<f64>().unwrap();
        assert!(row[0] == known["name"].as_str().unwrap() && number(2) == known["estimate"].as_f64().unwrap());
        assert!(number(8) == number(2).exp() && number(6) < number(2) && number(2) < number(7), "{row:?}");
        assert!(row[5].is_empty() && known["p"].is_null(), "z is not normal with 4 participants");
    }
    assert_eq!(coefficients.len(), length("coefficients"));
    let tests = records(&out.join("tests.csv"));
    let compared = tests.iter().filter(|row| row["test"] == "comparison");
    for (row, known) in compared.zip(model["comparisons"].as_array().unwrap()) {
        let told = |name: &str| number::<f64>(row, name);
        let [estimate, se] = ["estimate", "se"].map(|name| known[name].as_f64().unwrap());
        assert!(told("effect") == estimate && told("se") == se && row["df"].is_empty(), "{row:?}");
        assert!(told("ci_low") < estimate && estimate < told("ci_high"), "{row:?}");
    }
    for expected in ["friedman", "likelihood-ratio"] {
        assert!(tests.iter().any(|row| row["test"] == expected), "{expected}");
    }
    describes_columns(&out);
    let (_, agreement) = table(&out.join("agreement.csv"));
    assert!(agreement.iter().any(|row| row[0] == "krippendorff_alpha_ordinal"));
    assert_eq!(agreement.iter().filter(|row| row[0] == "retest_kappa_quadratic").count(), 4);
    for figure in ["figure4a", "figure4b"] {
        assert!(fs::read(out.join(format!("{figure}.png"))).unwrap().starts_with(b"\x89PNG"));
        assert!(fs::read_to_string(out.join(format!("{figure}.svg"))).unwrap().contains("<svg"));
    }
    assert!(fs::read_to_string(out.join("report.html")).unwrap().to_lowercase().contains("<!doctype html>"));
    assert!(fs::read_to_string(out.join("analysis.R")).unwrap().contains("Rscript analysis.R"));
}

/// Factors that are named after columns of the tables, or differ only in case, have columns and files of their own.
#[test]
fn no_table_has_two_columns_of_one_name() {
    let folder = tempfile::tempdir().unwrap();
    let factors = "n,mean,p0,count,rating,file,subjects,N,n_";
    let mut rows = format!("who,{factors},answer,times\n");
    for (person, condition) in (0..5).flat_map(|person| (0..12).map(move |condition| (person, condition))) {
        let levels: Vec<&str> = (0..9).map(|factor| ["a", "b"][(condition * (factor + 3) / 5) % 2]).collect();
        for answer in 0..3 {
            let times = 1 + (person * 5 + condition * 3 + answer * answer) % 4;
            rows += &format!("{person},{},{answer},{times}\n", levels.join(","));
        }
    }
    fs::write(folder.path().join("rows.csv"), rows).unwrap();
    let analyze = |input: &str, names: &str, terms: &str, out: &str| {
        let options = "--subject who --response answer --draws 99 --tables-only";
        let line = format!("analyze {input} {options} --factors {names} --terms {terms} --out {out}");
        let output = machband(folder.path(), &split(&line));
        // A warning says what counts do not tell.
        assert!(output.status.success(), "{}", text(&output.stderr));
    };
    analyze("rows.csv --count times", factors, "n,count", "a");
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder.path().join("a")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert_eq!(files.insert(name.to_lowercase(), ()), None, "{name}");
        if !name.ends_with(".csv") {
            continue;
        }
        let (header, _) = table(&folder.path().join("a").join(&name));
        let names: BTreeSet<&String> = header.iter().collect();
        assert_eq!(names.len(), header.len(), "{name}: {header:?}");
    }
    assert!(files.contains_key("coefficients.csv"), "{files:?}");
    let (header, _) = table(&folder.path().join("a/cells.csv"));
    assert_eq!(header[..9].join(","), "n__,mean_,p0_,count,rating,file,subjects_,N,n_");
    assert_eq!(header[9..12].join(","), "n,mean,median");
}

/// Analyzing a table of counts gives the same results as analyzing the rows it was made from.
#[test]
fn counts_give_the_same_analysis_as_rows() {
    let folder = study("bangay2003", 3);
    let options = "--slopes none --draws 99";
    let of_rows = format!("analyze results/bangay2003 --out rows --tables-only {options}");
    for line in [&of_rows, "counts results/bangay2003 --out counts.csv"] {
        succeeds(folder.path(), &split(line));
    }
    // A warning says what is lost.
    let from_counts = |line: &str, tables: &str| {
        let output = machband(folder.path(), &split(line));
        let expected = format!("warning: {tables} of counts, so it is not known whether ratings are simulated, ");
        let warnings = text(&output.stderr);
        assert!(output.status.success() && warnings.starts_with(&expected), "{warnings}");
        assert_eq!(warnings.lines().count(), 1, "{warnings}");
    };
    from_counts(&format!("analyze counts.csv --out counts {options}"), "counts.csv: is a table");
    let report = fs::read_to_string(folder.path().join("counts/report.html")).unwrap();
    assert!(report.contains("it is not known whether ratings are simulated"));
    let bytes = |out: &str, file: &str| fs::read(folder.path().join(out).join(file)).unwrap();
    for file in ["cells.csv", "counts.csv"] {
        assert_eq!(bytes("rows", file), bytes("counts", file), "{file}");
    }
    // Only the rows tell the order of the trials.
    let of_order = |line: &&str| !line.starts_with("drift,") && !line.starts_with("lag-one,");
    let [tests, from_counts_only] = ["rows", "counts"].map(|out| text(&bytes(out, "tests.csv")));
    assert_eq!(tests.lines().filter(of_order).collect::<Vec<_>>(), from_counts_only.lines().collect::<Vec<_>>());
    let [mut model, same] = ["rows", "counts"].map(|out| json(&folder.path().join(out).join("model.json")));
    assert!(model["order"]["ratings"].as_u64() == Some(720) && same["order"].is_null(), "{}", model["order"]);
    model["order"] = serde_json::Value::Null;
    assert_eq!(model, same);
    assert_eq!(bytes("", "counts.csv"), bytes("rows", "counts.csv"));
    // With renamed columns, split into two files, and with factor names as terms.
    let renamed =
        text(&bytes("", "counts.csv")).replacen("subject_id", "who", 1).replacen("rating,count", "score,n", 1);
    let lines: Vec<&str> = renamed.lines().collect();
    for (name, part) in [("p1.csv", &lines[1..50]), ("p2.csv", &lines[50..])] {
        fs::write(folder.path().join(name), format!("{}\n{}\n", lines[0], part.join("\n"))).unwrap();
    }
    let columns = "--subject who --response score --count n --terms width,depth,orientation_deg";
    let line = format!("analyze p1.csv p2.csv {columns} --out named --tables-only {options}");
    from_counts(&line, "p1.csv: is a table");
    let [a, b] = ["rows", "named"].map(|out| json(&folder.path().join(out).join("model.json")));
    assert_eq!((&a["coefficients"], &a["loglik"]), (&b["coefficients"], &b["loglik"]));
}

/// The scale of a table without a definition is that of its ratings.
#[test]
fn counts_and_exports_keep_a_scale_of_any_length() {
    let folder = tempfile::tempdir().unwrap();
    let five = "schema = 1\nname = \"five\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [0.1, 0.4]\n[design]\n\
                repetitions = 12\n[response]\nlabels = [\"a\", \"b\", \"c\", \"d\", \"e\"]\n";
    fs::write(folder.path().join("five.toml"), five).unwrap();
    for line in
        ["simulate five.toml --participants 3 --results r", "counts r --out c.csv", "export r --format bids --out b"]
    {
        succeeds(folder.path(), &split(line));
    }
    let tables: String =
        (1..=3).map(|n| format!(" b/sub-S00{n}/ses-1/beh/sub-S00{n}_ses-1_task-five_beh.tsv")).collect();
    let means = ["r", "c.csv", &tables].map(|input| {
        let line = format!("analyze {input} --factors width --tables-only --draws 99 --out a --force");
        let output = machband(folder.path(), &split(&line));
        assert!(output.status.success(), "{line}: {}", text(&output.stderr));
        let cells = records(&folder.path().join("a/cells.csv"));
        cells.iter().map(|row| [&row["width"], &row["n"], &row["mean"]].map(String::clone)).collect::<Vec<_>>()
    });
    assert!(means[0].len() == 2 && means.iter().all(|other| *other == means[0]), "{means:?}");
}

/// Other scales and column names work: counts give the same analysis as the file, and if the order of the categories is
/// unknown, the error asks for it.
#[test]
fn non_numeric_scales_need_an_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut rows = String::from("who,group,answer\n");
    for i in 0..240 {
        let answer = ["low", "medium", "high"][(i * 7 % 11 + i % 2 * 4) / 5];
        rows += &format!("p{},{},{answer}\n", i % 8, ["a", "b"][i % 2]);
    }
    fs::write(folder.path().join("d.csv"), rows).unwrap();
    let arguments = |line: &str| split(&format!("{line} --subject who --response answer"));
    let error = fails(folder.path(), &arguments("analyze d.csv --out x --terms group"), 2);
    // In no order that somebody would copy.
    let expected = "answer: high,low,medium are not numbers; expected numbers, or the order of all categories, lowest first, such as --categories 'LOWEST,…,HIGHEST'";
    assert!(error.contains(expected), "{error}");
    let analyze = |file: &str, out: &str, terms: &str| {
        let line = format!("analyze {file} --out {out} --terms {terms} --categories low,medium,high --tables-only");
        assert!(machband(folder.path(), &arguments(&line)).status.success(), "{line}");
        fs::read(folder.path().join(out).join("model.json")).unwrap()
    };
    let model = analyze("d.csv", "a", "group");
    succeeds(folder.path(), &arguments("counts d.csv --out c.csv --factors group,group"));
    assert_eq!(analyze("c.csv", "b", "group"), model);
    let model = text(&model);
    assert!(model.contains("low|medium") && model.contains("medium|high"), "{model}");
    // A name that occurs in several terms is a single factor; a column cannot have two roles.
    analyze("d.csv", "c", "group,group:group");
    assert_eq!(table(&folder.path().join("c/cells.csv")).0[..2], ["group", "n"]);
    let error = fails(folder.path(), &arguments("analyze d.csv --out x --terms answer"), 1);
    assert!(error.contains("the column answer has two uses"), "{error}");
}

/// Terms as documented: factors by name, numbers with num:, 1/n as num:inv_n; with both links and both approximations.
#[test]
fn terms_select_the_model() {
    let folder = study("bangay2003", 3);
    let model = |options: &str| {
        succeeds(folder.path(), &split(&format!("analyze results --draws 99 --out a --tables-only --force {options}")));
        json(&folder.path().join("a/model.json"))
    };
    for (terms, expected) in [
        ("num:width,num:inv_n", &["width", "inv_n"][..]),
        ("num:inv_n*num:width", &["inv_n", "width", "inv_n:width"]),
        // A column that is not a factor of the definition can still be a factor of the model.
        ("repetition", &["repetition2"]),
    ] {
        let model = model(&format!("--terms {terms}"));
        let names = model["coefficients"].as_array().unwrap().iter().map(|coefficient| &coefficient["name"]);
        assert_eq!(names.collect::<Vec<_>>(), expected, "{terms}");
    }
    let probit = model("--terms width --link probit --random none");
    assert_eq!((&probit["link"], &probit["method"]), (&"probit".into(), &"clm".into()));
    assert_eq!(model("--terms width")["method"], "clmm-laplace");
    let cases = r"
        2: --terms widht => did you mean width
        2: --terms num:depth => num:inv_n
        2: --terms width,depth,orientation_deg --slopes correlated => expected at most 10
        2: --link cloglog => logit";
    refuses(folder.path(), "analyze results --out b {}", cases);
}

/// Returns whole numbers below a bound that look random but are the same on every machine.
fn random(mut state: u32) -> impl FnMut(u32) -> u32 {
    move |below: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) % below
    }
}

/// Runs `analysis.R` in a folder. Returns what it printed, or `None` if there is no R with the package ordinal.
fn run_script(folder: &Path) -> Option<String> {
    let r = |arguments: &[&str]| Command::new("Rscript").args(arguments).current_dir(folder).output();
    if !r(&["-e", "library(ordinal)"]).is_ok_and(|output| output.status.success()) {
        skip("R", "analysis.R was not run: no Rscript with the package ordinal");
        return None;
    }
    let output = r(&["analysis.R"]).unwrap();
    let all = text(&output.stdout) + &text(&output.stderr);
    assert!(output.status.success(), "{all}");
    Some(all)
}

/// Checks that the script of an analysis has a call, and that R finds the log-likelihood of the model and prints a name.
fn assert_same_in_r(out: &Path, call: &str, name: &str) {
    let script = fs::read_to_string(out.join("analysis.R")).unwrap();
    assert!(script.contains(call) && script.lines().count() <= 60, "{script}");
    let loglik = json(&out.join("model.json"))["loglik"].as_f64().unwrap();
    if let Some(printed) = run_script(out) {
        let mut numbers = printed.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
        let is_same = numbers.any(|number| (number - loglik).abs() < 0.02);
        assert!(is_same && printed.contains(name), "{loglik}: {printed}");
    }
}

/// The script fits the model of the analysis, and R finds its log-likelihood.
#[test]
fn the_script_finds_the_same_numbers_in_r() {
    let folder = study("quick", 8);
    for (out, options, call, expected) in [
        ("zero", "--terms width --slopes none", "clmm(rating ~ width + (1 | subject),", "width0.1"),
        (
            "slopes",
            "--terms width,num:inv_n",
            "clmm(rating ~ width + num_inv_n + (1 | subject) + (1 | subject:width) + (0 + num_inv_n | subject),",
            "num_inv_n",
        ),
        (
            "correlated",
            "--terms orientation_deg --slopes correlated --link probit",
            "clmm(rating ~ orientation_deg + (1 + orientation_deg | subject),",
            "orientation_deg90",
        ),
        ("plain", "--terms width*num:inv_n --random none", "clm(rating ~ width + num_inv_n +", "width0.1:num_inv_n"),
    ] {
        let line = format!("analyze results --out {out} --tables-only --draws 99 {options}");
        succeeds(folder.path(), &split(&line));
        assert_same_in_r(&folder.path().join(out), call, expected);
    }
    // Pictures crossed with participants, and an age, which R's fit would not survive if it were not about its mean.
    let mut rows = String::from("subject_id,age,picture,style,rating\n");
    let mut random = random(7);
    for (person, picture) in (0..16).flat_map(|person| (0..12).map(move |picture| (person, picture))) {
        let latent = person % 4 + [0, 5, 2, 4, 1, 3, 6, 2, 0, 4, 3, 1][picture as usize] + random(8);
        let style = ["old", "new"][picture as usize % 2];
        rows += &format!("p{person},{},photo {picture},{style},{}\n", 20 + 3 * person, (latent / 4).min(3));
    }
    fs::write(folder.path().join("pictures.csv"), rows).unwrap();
    let line = "analyze pictures.csv --factors style,age --items picture --out pictures --tables-only --draws 99";
    succeeds(folder.path(), &split(line));
    let call = "clmm(rating ~ style + num_age + (1 | subject) + (1 | subject:style) + (1 | item),";
    assert_same_in_r(&folder.path().join("pictures"), call, "style");
    // Without division by its range, clmm stops far from the maximum.
    let mut rows = String::from("subject_id,isi,rating\n");
    for (person, step) in (0..8).flat_map(|person| (0..20).map(move |step| (person, step))) {
        rows += &format!("p{person},{},{}\n", 100 + 40 * step, ((step + random(9)) / 7).min(3));
    }
    fs::write(folder.path().join("isi.csv"), rows).unwrap();
    succeeds(folder.path(), &split("analyze isi.csv --terms num:isi --out isi --tables-only --draws 99"));
    assert_same_in_r(&folder.path().join("isi"), "num_isi = centered(as.numeric(", "num_isi");
    // An option that contradicts the columns is refused.
    let cases = r"
        2: --factors style,picture --items picture => is also a factor
        2: --items picture => no factors were given
        2: --factors style --direction style => not numbers
        2: --factors style --covariate style => --covariate style: has levels that are not numbers
        2: --factors style --only style=old,age=20 => repeat the option for another factor
        2: --factors style --levels style=odd,new => odd";
    refuses(folder.path(), "analyze pictures.csv --out refused {}", cases);
    // A table of counts has the conditions of the analysis, not one for each age.
    let printed = succeeds(folder.path(), &split("counts pictures.csv --factors style,age --out counts.csv"));
    assert!(printed.contains("192 ratings of 2 conditions by 16 participants"), "{printed}");
    // Without a model, there is nothing to fit.
    fs::write(folder.path().join("same.csv"), "subject_id,width,rating\na,1,2\nb,2,2\n").unwrap();
    succeeds(folder.path(), &split("analyze same.csv --out none --terms width --tables-only"));
    let script = fs::read_to_string(folder.path().join("none/analysis.R")).unwrap();
    assert!(
        script.ends_with("# There is nothing to repeat: every rating is 2; expected at least two different ones.\n")
    );
}

/// Names and levels with quotes, backslashes, spaces and other letters, words as categories, missing values, a number
/// in the hundreds, and a level whose ratings are all the same.
#[test]
fn the_script_quotes_any_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut rows = String::from("who is it,\"odd \"\"name\"\"\",time-ms,=group,answer\n");
    let levels = ["\"a\"\"b\"", "c\\d", "é — ü", "it's", ""];
    let mut random = random(1);
    let mut random = |below: usize| random(below as u32) as usize;
    for trial in 0..360 {
        let (who, level, time) = (trial % 9, random(levels.len()), random(4));
        let latent = [0, 4, 1, 3, 2][who % 5] + level + time * [0, 1, 2, 3][who % 4] + random(8);
        let answer = ["low", "\"medium, mostly\"", "high"][if level == 3 { 2 } else { (latent / 5).min(2) }];
        rows += &format!("p {who},{},{},{},{answer}\n", levels[level], [100, 250, 400, 900][time], ["a", "b"][who % 2]);
    }
    fs::write(folder.path().join("odd.csv"), rows).unwrap();
    let arguments =
        ["analyze", "odd.csv", "--out", "a", "--subject", "who is it", "--response", "answer", "--tables-only"];
    let categories = ["--categories", r#"low,"medium, mostly",high"#, "--draws", "99"];
    let terms = ["--terms", r#"odd "name",num:time-ms,=group"#];
    // Missing levels are a warning.
    assert!(machband(folder.path(), &[&arguments[..], &categories, &terms].concat()).status.success());
    let out = folder.path().join("a");
    let script = fs::read_to_string(out.join("analysis.R")).unwrap();
    assert!(script.is_ascii() && script.contains(r#"levels = c("a\"b", "c\\d", "it\'s", "#), "{script}");
    if let Some(printed) = run_script(&out) {
        assert!(printed.contains("num_time.ms"), "{printed}");
    }
}

/// Tables of other programs: what is wrong is said once, with what to do.
#[test]
fn tables_of_other_programs_are_understood_or_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let rows = |rating: &dyn Fn(usize) -> String| -> String {
        let row = |i: usize| format!("p{},{},{},{},{}\n", i / 12, ["n", "f"][i % 2], ["u", "v"][i % 2], i, rating(i));
        "id,a:b,count,trial,y\n".to_owned() + &(0..96).map(row).collect::<String>()
    };
    let usual = rows(&|i| ((i * i / 3 + i % 2) % 4).to_string());
    write("stray.csv", &rows(&|i| if i == 7 { "33".to_owned() } else { (i * i / 3 % 4).to_string() }));
    write("word.csv", &rows(&|i| if i == 7 { "oops".to_owned() } else { (i * i / 3 % 4).to_string() }));
    write("words.csv", &rows(&|i| if i % 9 == 7 { "oops".to_owned() } else { (i * i / 3 % 4).to_string() }));
    write("usual.csv", &usual);
    write("blank.csv", &(usual.replace("p1,", ",,,,\n\np1,") + &", ,,,\n".repeat(9)));
    write("nobody.csv", &usual.replace("p1,", ","));
    write("data.json", "[{\"id\": 1, \"y\": 2}]");
    write("half.csv", &rows(&|i| if i == 7 { "1.5".to_owned() } else { (i * i / 3 % 4).to_string() }));
    let labels = "y\nID,A,Count,Trial,Rating\n\"{\"\"ImportId\"\":\"\"id\"\"}\",a,count,trial,y\n";
    write("q.csv", &usual.replacen("y\n", labels, 1));
    write("bars.csv", &usual.replace(',', "|"));
    write("carets.csv", &usual.replace(',', "^"));
    write("thousands.csv", &usual.replace(',', ";").replace(";u;", ";1,000;").replace(";v;", ";100;"));
    write("empty.csv", &format!(",,,,\n{usual}"));
    write("title.csv", &format!("C:\\data.emrg\n{}", usual.replace(',', "\t")));
    let numbered =
        |(number, row): (usize, &str)| if number == 0 { format!("{row}\n") } else { format!("{number},{row}\n") };
    write("r.csv", &usual.lines().enumerate().map(numbered).collect::<String>());
    write("ends.csv", &usual.replace('\n', ",\n").replacen("y,", "y", 1));
    let run = |file: &str, options: &[&str]| {
        let columns = ["analyze", file, "--subject", "id", "--response", "y"];
        let output = ["--out", "out", "--tables-only", "--draws", "99", "--force"];
        let output = machband(folder.path(), &[&columns, options, &output].concat());
        (output.status.code(), text(&output.stderr), text(&output.stdout))
    };
    for (file, options, status, expected) in [
        ("stray.csv", &["--terms", "count"][..], 2, "y: 33 (1 rating) is far from the other values"),
        ("stray.csv", &["--terms", "count", "--missing", "33"], 0, "1 of 96 rows has no response"),
        ("word.csv", &["--terms", "count"], 1, "word.csv:9:10: y is \"oops\"; expected a number, as in other rows"),
        ("words.csv", &["--terms", "count"], 2, "y: oops is not a number; expected numbers"),
        ("usual.csv", &["--terms", "count,trial"], 2, "--terms trial determines count"),
        ("usual.csv", &["--terms", "\"a:b\",count"], 2, "a:b determines count: each level of a:b occurs"),
        ("usual.csv", &["--terms", "\"a:b\",num:trial", "--factors", "count"], 0, ""),
        ("usual.csv", &["--terms", "count", "--categories", "3,2,1,0"], 2, "ascending order"),
        ("usual.csv", &["--terms", "count", "--order", "y"], 2, "y: several ratings by p0 have the place"),
        ("blank.csv", &["--terms", "count"], 0, ""),
        ("usual.csv", &["--terms", "count:y"], 2, "count:y: the effects and interactions that it contains"),
        (
            "usual.csv",
            &["--terms", "count", "--random", "none", "--slopes", "correlated"],
            2,
            "expected independent or none",
        ),
        ("nobody.csv", &["--terms", "count"], 1, "12 of 96 rows have no participant"),
        ("data.json", &["--terms", "a"], 1, "is JSON; expected CSV"),
        ("half.csv", &["--terms", "count"], 2, "y: 1.5 (1 rating) is far from the other values, or not a whole number"),
        ("q.csv", &["--terms", "count"], 0, ""),
        ("bars.csv", &["--terms", "count"], 0, ""),
        ("carets.csv", &["--terms", "count"], 1, "the first line has one cell, \"id^a:b^count^trial^y\"; expected the"),
        ("thousands.csv", &["--terms", "count"], 1, "it is not clear whether 1,000 in the column count has decimals"),
        ("empty.csv", &["--terms", "count"], 1, "empty.csv:1:1: the first line has one cell at most"),
        ("title.csv", &["--terms", "count"], 1, "the first line has one cell at most, and a line below it several"),
        ("r.csv", &["--terms", "count"], 0, ""),
        ("ends.csv", &["--terms", "count"], 0, ""),
    ] {
        let (code, error, output) = run(file, options);
        assert!(code == Some(status) && error.contains(expected), "{file} {options:?}: {code:?} {error} {output}");
    }
    let counts = "counts words.csv --subject id --response y --factors count --out counts.csv";
    let said = fails(folder.path(), &split(counts), 2);
    assert!(said.contains("--response y: oops is not a number; expected numbers"), "{said}");
}

/// What is left out on request or because it is missing is in the report; above 2 % of unreadable rows, there is none.
#[test]
fn what_is_left_out_is_told_and_too_many_errors_stop_the_analysis() {
    let folder = tempfile::tempdir().unwrap();
    let row = |i: usize| {
        let rating = if i % 40 == 7 { "-99".to_owned() } else { ((i * 7 % 11 + i % 2 * 4) / 4).to_string() };
        format!("p{},{},{rating},{}\n", i % 8, ["a", "b", "c"][i % 3], [2.5, 0.1, 9.0].get(i % 60).unwrap_or(&2.5))
    };
    let rows: String = (0..240).map(row).collect();
    fs::write(folder.path().join("d.csv"), format!("subj,group,answer,rt\n{rows}")).unwrap();
    let line = "analyze d.csv --subject subj --response answer --terms group --time rt --min-time 0.2 --max-time 8 --only group=a,b --exclude p3 \
                --draws 99 --out";
    let error = fails(folder.path(), &split(&format!("{line} x")), 2);
    assert!(
        error.contains("answer: -99 (6 ratings) is far from") && error.ends_with("such as --missing -99\n"),
        "{error}"
    );
    let output = machband(folder.path(), &split(&format!("{line} a --missing -99")));
    let warnings = text(&output.stderr);
    assert!(warnings.contains("warning: d.csv: 6 of 240 rows have no response ("), "{warnings}");
    let report = fs::read_to_string(folder.path().join("a/report.html")).unwrap();
    let left_out = report.split("What was left out, and why").nth(1).and_then(|rest| rest.split("</table>").next());
    let cells = left_out.unwrap().split('<').filter_map(|tag| tag.split_once('>')).map(|(_, text)| text.trim());
    let cells = cells.filter(|text| !text.is_empty()).collect::<Vec<_>>().join("|");
    let expected = "Left out|Number|Participants|rows without a response|6|1|rows answered in less than 0.2 s|4|2|\
                    rows answered in more than 8 s|4|2|ratings by participant p3|30|1|\
                    ratings at levels of group other than a and b|64|7";
    assert_eq!(cells, expected);
    assert!(report.contains("6 rows without a response, 4 rows answered in less than 0.2 s, 4 rows"), "{report}");
    assert!(report.contains("--min-time 0.2"), "the command repeats the analysis");
    // Six of 240 rows are not on the scale that is named.
    let error = fails(folder.path(), &split(&format!("{line} x --categories 0,1,2,3")), 1);
    let expected = "error: d.csv: 6 of 240 rows cannot be read, so nothing is analyzed; expected at most 2";
    assert!(error.contains("d.csv:9:6: rating -99; expected one of 0, 1, 2, 3") && error.contains(expected), "{error}");
    assert!(!folder.path().join("x").exists());
}

/// Analyzes a table of answers; returns what is printed to stdout and to stderr.
fn answers(folder: &Path, rows: &str, options: &str) -> [String; 2] {
    fs::write(folder.join("answers.csv"), rows).unwrap();
    let line = format!("analyze answers.csv --level level --correct right --total n --out a --force {options}");
    let output = machband(folder, &split(&line));
    assert!(output.status.success(), "{options}: {}", text(&output.stderr));
    [text(&output.stdout), text(&output.stderr)]
}

/// Answers of people in conditions to eight levels; `level` returns that of a condition and a person at a distance from 0.
fn of_people(conditions: usize, people: usize, level: impl Fn(usize, usize, f64) -> f64) -> String {
    let right = [10, 11, 12, 14, 17, 19, 20, 20];
    let mut rows = "who,cond,level,right,n\n".to_owned();
    for (condition, person) in (0..conditions).flat_map(|condition| (0..people).map(move |person| (condition, person)))
    {
        for (i, right) in right.iter().enumerate() {
            rows += &format!("p{person},c{condition},{},{right},20\n", level(condition, person, i as f64 - 3.5));
        }
    }
    rows
}

/// Functions that fall where they should rise have no threshold anywhere, and no part in a mean.
#[test]
fn reversed_functions_have_no_threshold() {
    let folder = tempfile::tempdir().unwrap();
    let says = "According to the answers, the other end of the levels is easier, so these functions mean nothing and are left out";
    let [printed, _] = answers(folder.path(), "level,right,n\n1,19,20\n2,14,20\n3,9,20\n", "--guess 0.1");
    assert!(printed.contains(says) && !printed.contains("threshold"), "{printed}");
    describes_columns(&folder.path().join("a"));
    let (header, rows) = table(&folder.path().join("a/thresholds.csv"));
    let of_function = header.iter().zip(&rows[0]).filter(|(name, _)| name.starts_with("threshold"));
    assert!(of_function.clone().count() == 3 && of_function.clone().all(|(_, cell)| cell.is_empty()), "{rows:?}");
    let rows = of_people(1, 4, |_, person, at| at + 0.3 * person as f64);
    let reversed = |line: &str| match line.strip_prefix("p3,c0,") {
        Some(rest) => format!("p3,c0,{}\n", rest.strip_prefix('-').map_or(format!("-{rest}"), str::to_owned)),
        None => format!("{line}\n"),
    };
    let rows: String = rows.lines().map(reversed).collect();
    let [printed, _] = answers(folder.path(), &rows, "--guess 0.5 --subject who");
    assert!(printed.contains(&format!("{says} (")) && printed.contains(": p3."), "{printed}");
    assert_eq!(table(&folder.path().join("a/population.csv")).1[0][0], "3");
    let report = fs::read_to_string(folder.path().join("a/report.html")).unwrap();
    assert!(!report.contains("lies beyond the levels"), "{report}");
}

/// With many pairs of conditions, some would seem to differ by chance.
#[test]
fn comparisons_of_many_conditions_are_corrected() {
    let folder = tempfile::tempdir().unwrap();
    let shifts = [[0.05, -0.05, 0.02, -0.03, 0.01], [0.1, 0.3, 0.5, 0.7, 0.9], [0.6, -0.2, 0.4, -0.1, 0.5]];
    for (conditions, verdict) in [(2, "so they differ"), (3, "so it is not clear that they differ")] {
        let rows = of_people(conditions, 5, |condition, person, at| at + shifts[condition][person]);
        let [printed, _] = answers(folder.path(), &rows, "--guess 0.5 --subject who --factors cond");
        let first = printed.lines().find(|line| line.contains("at cond c0 from that at cond c1")).unwrap();
        let interval = first.split(['(', ')']).nth(1).unwrap();
        let report = fs::read_to_string(folder.path().join("a/report.html")).unwrap();
        assert_eq!(report.contains("Holm"), conditions > 2);
        assert!(first.contains(verdict) && interval.contains("to −"), "{printed}");
    }
}

/// Answers that do not depend on the level say nothing about a threshold, not even on which side it lies.
#[test]
fn a_flat_function_has_no_threshold_on_any_side() {
    let folder = tempfile::tempdir().unwrap();
    let rows = "level,right,n\n1,10,20\n2,10,20\n4,10,20\n8,10,20\n";
    let [printed, _] = answers(folder.path(), rows, "--guess free --log");
    assert!(printed.contains("is not determined by the answers") && !printed.contains("lies"), "{printed}");
    // Equal answers near the highest that are possible say that it lies below them.
    let [printed, _] = answers(folder.path(), "level,right,n\n5,10,10\n6,10,10\n7,10,10\n", "--guess 0.5");
    assert!(printed.contains("was not measured: the most probable one lies beyond the levels, 5 to 7."), "{printed}");
    // Nor do equal answers say which end of the levels is easier.
    let rows = [0.01, 0.02, 0.04, 0.08, 0.16, 0.32].map(|level| format!("{level},30,30\n")).concat();
    let [printed, _] = answers(folder.path(), &format!("level,right,n\n{rows}"), "--guess 0.5 --log");
    assert!(printed.contains("all: the threshold of level") && !printed.contains("easier"), "{printed}");
}
