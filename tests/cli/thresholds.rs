//! Thresholds as a user's script sees them: planned studies, and tables of answers from other programs.

use std::{fs, path::Path};

use crate::common::{fails, golden_path, records, refuses, split, succeeds, table};

/// Writes the rows of a golden file, without comments, that `keep` chooses.
fn copied(name: &str, to: &Path, keep: impl Fn(&str) -> bool) {
    let text = fs::read_to_string(golden_path("tasks").join(name)).unwrap();
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    let rows = lines[1..].iter().filter(|line| keep(line)).map(|line| format!("{line}\n"));
    fs::write(to, format!("{}\n{}", lines[0], rows.collect::<String>())).unwrap();
}

/// Returns a column of a table as numbers.
fn numbers(path: &Path, column: &str) -> Vec<f64> {
    records(path).iter().map(|row| row[column].parse().unwrap_or(f64::NAN)).collect()
}

/// The example of psignifit's documentation has psignifit's threshold, also as single trials, with decimal commas, and on
/// levels that fall.
#[test]
fn tables_of_other_programs_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    copied("psignifit_data.csv", &path("counts.csv"), |line| line.starts_with("documentation,"));
    let (_, rows) = table(&path("counts.csv"));
    let expected = 0.004646442173983336;
    let commas: String =
        rows.iter().map(|row| format!("{};{};{}\n", row[1].replace('.', ","), row[2], row[3])).collect();
    let commas = format!("Reiz;richtig;Anzahl\n{commas}");
    fs::write(path("commas.csv"), &commas).unwrap();
    fs::write(path("tabs.tsv"), commas.replace(';', "\t")).unwrap();
    let single = rows.iter().flat_map(|row| {
        let [right, total] = [2, 3].map(|at| row[at].parse::<u32>().unwrap());
        (0..total).map(move |trial| format!("-{},{}\n", row[1], u32::from(trial < right)))
    });
    fs::write(path("trials.csv"), format!("x,right\n{}", single.collect::<String>())).unwrap();
    for (file, columns, sign) in [
        ("counts.csv", &["--level=level", "--correct=correct", "--total=total"][..], 1.0),
        ("commas.csv", &["--level=Reiz", "--correct=richtig", "--total=Anzahl"], 1.0),
        ("tabs.tsv", &["--level=Reiz", "--correct=richtig", "--total=Anzahl"], 1.0),
        ("trials.csv", &["--level=x", "--correct=right", "--easier=low"], -1.0),
    ] {
        let out = format!("{file}.analysis");
        let fixed = ["analyze", file, "--guess=0.5", "--out", &out];
        succeeds(folder.path(), &[&fixed[..], columns].concat());
        let threshold = numbers(&path(&out).join("thresholds.csv"), "threshold")[0];
        assert!((sign * threshold / expected - 1.0).abs() < 0.01, "{file}: {threshold}");
    }

    copied("people.csv", &path("people.csv"), |_| true);
    let mut arguments = vec!["analyze", "people.csv", "--level=level", "--correct=correct", "--total=total"];
    arguments.extend(["--guess=0.5", "--subject=person", "--factors=condition", "--out=people"]);
    let printed = succeeds(folder.path(), &arguments);
    assert!(printed.contains("12 participants gave 5,040 answers."), "{printed}");
    let [low, high] = ["threshold_low", "threshold_high"].map(|end| numbers(&path("people/population.csv"), end));
    let everyone = (1..=12).map(|person| format!("P{person:02}")).collect::<Vec<_>>().join(",");
    arguments[8] = "--out=no-one";
    let left = fails(folder.path(), &[&arguments[..], &["--exclude", &everyone]].concat(), 1);
    assert!(left.contains("people.csv: has no answers at levels; expected at least one"), "{left}");
    for (i, mean) in [3.0, 3.8, 5.1].into_iter().enumerate() {
        assert!(low[i] < mean && mean < high[i], "{mean} is not in {}…{}", low[i], high[i]);
    }

    fs::write(path("wrong.csv"), "x,right,n\n0.1,5,10\n0.2,12,10\nhigh,3,10\n").unwrap();
    let columns = ["analyze", "wrong.csv", "--level=x", "--correct=right", "--total=n", "--guess=0.5", "--out=wrong"];
    let refused = |cases: &str| refuses(folder.path(), &format!("{} {{}}", columns.join(" ")), cases);
    refused(
        r#"1: => wrong.csv:3:5: right is "12"; expected no more correct answers than trials
           1: => wrong.csv:4:1: x is "high"; expected a level, which is a number
           1: --log => wrong.csv:3:5
           2: --function weibull => --function weibull: uses logarithms of the level; expected logistic or normal, or the option --log
           2: --link probit => --link: does not apply to answers at levels"#,
    );
}

/// Planned studies find a difference that is not there in about 5 % of cases, and a large one nearly always; more people
/// and more trials are more precise.
#[test]
fn studies_of_thresholds_are_planned() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |options: &str| {
        let printed =
            succeeds(folder.path(), &split(&format!("plan threshold-width --out plan.csv --force {options}")));
        // A number stands below the end of the name of its column.
        let lines: Vec<&str> =
            printed.lines().filter(|line| line.contains("mean threshold") || line.contains("error")).collect();
        let end = lines[1].find("half_width").unwrap() + "half_width".len();
        let shown: f64 = lines[2][..end].rsplit(' ').next().unwrap().parse().unwrap();
        let width = &numbers(&folder.path().join("plan.csv"), "half_width")[1];
        assert!((shown - width).abs() < 6e-4, "{printed}");
        folder.path().join("plan.csv")
    };
    let false_alarms = numbers(&plan("--participants 5 --studies 100"), "false_alarms")[2];
    assert!((0.01..0.1).contains(&false_alarms), "{false_alarms}");

    let large = plan("--participants 4,10 --trials 20,50 --studies 16 --effect orientation_deg:90=0.3");
    let (error, width, power) = (numbers(&large, "error"), numbers(&large, "half_width"), numbers(&large, "power"));
    // Rows: 20 trials of 4 people, of 10, 50 trials of 4, of 10; each with person, mean and difference.
    assert_eq!(numbers(&large, "participants").len(), 12);
    assert!(power[11] > 0.8, "{power:?}");
    assert!(error[6] < 0.8 * error[0], "{error:?}");
    assert!(width[4] < width[1] && width[7] < width[1] && width[10] < width[4], "{width:?}");

    // Trials that no session could order are no reason to simulate.
    let definition = fs::read_to_string("experiments/threshold-width.toml").unwrap();
    let two = definition.replace("high = 0.75\n", "").replace("[0, 90]", "[0, 90]\nhigh = [0.7, 0.75]");
    let definition = two.replace("[design]", "[design]\nmax_run = 1");
    fs::write(folder.path().join("run.toml"), definition).unwrap();
    let adjust = "schema = 1\nname = \"adj\"\n[stimulus]\nkind = \"mach-band\"\n[task]\nkind = \"adjust\"\nparameter = \"low\"\nhigh = 0.5\n";
    fs::write(folder.path().join("a.toml"), adjust).unwrap();
    let cases = r"
        1: run.toml => max_run = 1
        2: a.toml => expected a rating on a scale of categories
        2: pairs-shaders => expected a rating on a scale of categories, or a task with [adaptive]
        2: quick --trials 20 => --trials: does not apply to ratings
        2: threshold-width --effect orientation:90=0.3 => --effect orientation: no such factor; expected orientation_deg
        2: threshold-width --effect orientation_deg:45=0.3 => --effect orientation_deg:45: no such level; expected one of 0, 90
        2: threshold-width --effect slop=3 => the observer has no such parameter; expected one of threshold
        2: threshold-width --effect lapse=0.9 => lapse 0.9 is outside 0…0.5
        2: threshold-width --terms width => does not apply to thresholds
        2: threshold-width --preregistration p.md => --preregistration: does not apply to thresholds";
    refuses(folder.path(), "plan {} --participants 4", cases);
}
