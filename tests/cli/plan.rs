//! Power planning, compared with R and with results that must hold exactly; `machband plan` as a user's script sees it; and
//! thresholds, from plans and from tables of other programs.

use std::{fs, path::Path};

use machband::{
    analysis::{
        Options, Slopes,
        power::{Plan, Power, Sampling, Slope, Test},
    },
    experiment::{OrderedLogit, Protocol},
    statistics::Interval,
    store::definition,
};

use crate::common::{command, fails, golden_path, records, refuses, split, succeeds, table, text};

const DESIGN: &str = include_str!("../golden/power.toml");

fn design() -> Protocol {
    definition::parse("power.toml", DESIGN).unwrap()
}

fn oblique(oblique: f64) -> OrderedLogit {
    OrderedLogit { oblique, ..OrderedLogit::default() }
}

/// Plans the design for people who differ in the effect of the orientation by this standard deviation.
fn plan_with_slopes(observer: &OrderedLogit, sd: f64, slopes: Slopes) -> Plan {
    let slope = Slope { factor: "orientation_deg".to_owned(), sd };
    let model = Options { slopes, ..Options::default() };
    Plan::new(&design(), observer, &[], &[slope], &model).unwrap()
}

/// Compares with `tests/golden/power.csv`: a different program with different random numbers finds the same power and the
/// same estimates, with p from studies without the effect for six people and from the χ² distribution for more, also if
/// people differ in the effect.
#[test]
fn power_matches_r() {
    let number = |text: &str| text.parse::<f64>().unwrap();
    let (_, rows) = table(&golden_path("power.csv"));
    for group in rows.chunk_by(|one, other| one[1..3] == other[1..3]) {
        let slopes = if group[0][2] == "none" { Slopes::None } else { Slopes::Independent };
        let plan = plan_with_slopes(&oblique(0.6), number(&group[0][1]), slopes);
        let mut participants: Vec<u32> = group.iter().map(|row| row[0].parse().unwrap()).collect();
        participants.dedup();
        let studies = number(&group[0][4]).min(500.0);
        let sampling = Sampling { studies: studies as u32, ..Sampling::default() };
        let all = plan.run(&participants, &sampling, &|_| ());
        let of = |term: &str, row: &[String]| {
            let test = if row[3] == "friedman" { Test::Friedman } else { Test::LikelihoodRatio };
            let index = plan.hypotheses.iter().position(|asked| asked.term.to_string() == term && asked.test == test);
            let is_asked = |power: &&Power| Some(power.hypothesis) == index && power.participants.to_string() == row[0];
            all.iter().find(is_asked).unwrap()
        };
        for row in group {
            let ours = of("orientation_deg", row);
            let (share, theirs) = (ours.share(), number(&row[5]) / number(&row[4]));
            let both = (share + theirs) / 2.0;
            let binomial = both * (1.0 - both) * (1.0 / studies + 1.0 / number(&row[4]));
            // The standard error of the level in each of the two programs, if it comes from simulated studies. Where a
            // test with one degree of freedom has a power of one half, it rises by φ(0) / (2 φ(1.96)) = 3.4 times as
            // much as its level; elsewhere by less.
            let is_simulated = row[0] == "6" && row[3] == "likelihood-ratio";
            let alpha_error = if is_simulated { (0.05_f64 * 0.95 / 999.0).sqrt() } else { 0.0 };
            let error = (binomial + 2.0 * (3.4 * alpha_error).powi(2)).sqrt();
            assert!((share - theirs).abs() <= 3.0 * error, "{row:?}: {share}");
            assert!(ours.studies as f64 == studies && ours.untested == 0, "{ours:?}");
            if row[0] == "14" {
                // Four logits: the model without them exists in every study, although its random slope must take their
                // place.
                assert_eq!(of("depth", row).found as f64, studies, "{row:?}");
            }
        }
    }
}

/// With few people who differ in an effect that is 0 on average, a model with random slopes finds it as often as α says.
/// A model without them mistakes the differences for an effect.
#[test]
fn slopes_keep_the_false_alarm_rate() {
    let rate = |slopes| {
        let plan = plan_with_slopes(&OrderedLogit::default(), 0.5, slopes);
        let all = plan.run(&[8], &Sampling { studies: 300, ..Sampling::default() }, &|_| ());
        let is_asked = |power: &&Power| {
            let hypothesis = &plan.hypotheses[power.hypothesis];
            hypothesis.term.name() == "orientation_deg" && hypothesis.test == Test::LikelihoodRatio
        };
        let ours = all.iter().find(is_asked).unwrap();
        assert_eq!(ours.untested, 0);
        ours.share()
    };
    // Of the 300 studies, and of the 300 without the effect that they are compared with.
    let error = (0.05_f64 * 0.95 * 2.0 / 300.0).sqrt();
    let (with, without) = (rate(Slopes::Independent), rate(Slopes::None));
    assert!((with - 0.05).abs() < 3.0 * error, "{with}");
    assert!(without > 0.05 + 3.0 * error, "{without}");
}

/// The expected values come from `binom.test(found, all)$conf.int` in R 4.2.2.
#[test]
fn intervals_of_proportions_match_r() {
    for (found, all, low, high) in [
        (0, 200, 0.0, 0.0182753403551),
        (10, 200, 0.0242341654721, 0.0900275377014),
        (166, 200, 0.770628399606, 0.879304376764),
        (200, 200, 0.981724659645, 1.0),
        (1, 1, 0.025, 1.0),
        (50, 1000, 0.0373353976047, 0.0653904879155),
    ] {
        let interval = Interval::of_proportion(found, all);
        assert!(
            (interval.low - low).abs() < 1e-11 && (interval.high - high).abs() < 1e-11,
            "{found}/{all}: {interval:?}"
        );
    }
}

/// Returns what `machband plan` prints.
fn planned(folder: &Path, line: &str) -> String {
    succeeds(folder, &split(&format!("plan {line}")))
}

#[test]
fn the_number_of_threads_does_not_change_a_plan() {
    let folder = tempfile::tempdir().unwrap();
    let [one, three] = ["1", "3"].map(|threads| {
        let line =
            "plan quick --participants 3,2 --studies 3 --effect oblique=1 --terms orientation_deg --out p.csv --force";
        let output = command(folder.path(), &split(line)).env("RAYON_NUM_THREADS", threads).output().unwrap();
        (text(&output.stdout), fs::read_to_string(folder.path().join("p.csv")).unwrap())
    });
    assert_eq!(one, three);
}

#[test]
fn effects_null_effects_and_missing_models_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let line = "shaders --participants 3 --studies 40 --effect shader:gouraud=3 --out p.csv";
    let said = planned(folder.path(), line);
    let rows = records(&folder.path().join("p.csv"));
    let cell = |row: usize, name: &str| rows[row][name].clone();
    // The mixed model and Friedman's test for shader, then for mesh.
    let first = ["term", "test", "truth", "effect_logits", "above"].map(|name| cell(0, name));
    assert_eq!((rows.len(), first), (6, ["shader", "likelihood-ratio", "effect", "3", "gouraud"].map(str::to_owned)));
    assert_eq!(["term", "truth", "power"].map(|name| cell(2, name)), ["mesh", "none", ""]);
    let share = |row, name| 100.0 * cell(row, name).parse::<f64>().unwrap();
    assert!(said.contains("Effect of shader (3.00 logits between gouraud and "), "{said}");
    let (power, alarms) = (share(0, "power"), share(2, "false_alarms"));
    assert!(power > 80.0 && alarms < 30.0, "{power} {alarms}");
    // The observer has no effect of any factor, so there is no power to report.
    let said = planned(folder.path(), "shaders --participants 2 --studies 5 --terms shader");
    assert!(said.contains("No factor has an effect on this observer") && !said.contains("power  "), "{said}");
}

/// A plan does not promise what an analysis would withhold: here, the design has too few ratings for people who differ in the
/// effect of the width.
#[test]
fn a_test_that_an_analysis_withholds_has_no_power() {
    let folder = tempfile::tempdir().unwrap();
    let design = "schema = 1\nname = \"few\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [0.1, 0.4, 0.8]\n\
                  orientation_deg = [0, 45]\n[design]\nrepetitions = 1\n";
    std::fs::write(folder.path().join("few.toml"), design).unwrap();
    let line = "few.toml --participants 6 --studies 20 --effect width:0.1=3 --out p.csv";
    let said = planned(folder.path(), line);
    let withheld =
        "With 6 participants, 20 of 20 studies could not test width with the mixed model: the design has too few";
    assert!(said.contains(withheld), "{said}");
    let rows = records(&folder.path().join("p.csv"));
    let cell = |row: usize, name: &str| rows[row][name].clone();
    assert_eq!(
        ["term", "test", "found", "untested"].map(|name| cell(0, name)),
        ["width", "likelihood-ratio", "0", "20"]
    );
    assert_eq!([cell(1, "test"), cell(1, "untested")], ["friedman", "0"]);
}

#[test]
fn wrong_usage_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let cases = r"
        2: --participants 2 --effect oblik=1 => did you mean oblique?
        2: --participants 2 --effect oblique => 'oblique' for '--effect <NAME=VALUE>': contains no =; expected NAME=VALUE
        2: --participants 2 --effect lapse=2 => lapse 2 is outside 0…1
        2: --participants 2 --effect width=2 => the observer has no such parameter
        2: --participants 2 --effect widht:0.1=2 => no such factor; expected one of width, depth
        2: --participants 2 --effect width:0.3=2 => --effect width:0.3: no such level; expected one of 0.02
        2: --participants 2 --effect fall=1 --effect fall=2 => --effect fall=2: fall is given twice
        2: --participants 2 --slope width=inf => 'width=inf' for '--slope <FACTOR=SD>': the value is not a finite number
        2: --participants 2 --slope width=-1 => '--slope <FACTOR=SD>': the value is out of range; expected 0…1000
        2: --participants 2 --terms widht => did you mean width?
        2: --participants 2 --terms width,,depth => width,,depth: an empty name
        2: --participants 2 --terms depth,num:inv_n => --terms num:inv_n: the term adds nothing to the other terms
        2: --participants 2 --alpha 0 => expected a number between 0 and 1";
    refuses(folder.path(), "plan quick {}", cases);
    std::fs::write(folder.path().join("bad.toml"), "schema = 1\noblique = \"much\"\n").unwrap();
    let errors = fails(folder.path(), &split("plan quick --participants 2 --observer-file bad.toml"), 1);
    assert!(errors.starts_with("error: bad.toml:2:"), "{errors}");
}

/// The preregistration says what the plan found, and ends with the commands that plan and analyze.
#[test]
fn a_preregistration_says_what_was_planned() {
    let folder = tempfile::tempdir().unwrap();
    let line = "quick --participants 2,6 --effect width:0.1=1 --studies 100 --preregistration plan.md";
    planned(folder.path(), line);
    let text = std::fs::read_to_string(folder.path().join("plan.md")).unwrap();
    for expected in [
        "- width: ratings at 0.1 are higher than at 0.8. The effect planned for is 3.10 logits.",
        "- orientation: no effect is predicted.",
        "24 conditions, each once, which makes 24 ratings",
        "participants will be tested: the smallest number tried (2 and 6) at which the 95 % interval of the power lies at or above 80\u{a0}%",
        "p below 0.05 with a higher estimate at 0.1 than at 0.8 supports the hypothesis",
        "    machband plan quick --participants 2,6 --effect width:0.1=1 --studies 100\n",
        "    machband analyze results/quick --terms width,depth,orientation_deg --link logit --slopes independent --out analysis",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    // Three studies that all find the effect are no proof that most would.
    let said = planned(folder.path(), "quick --participants 6 --effect width:0.1=1 --studies 3 --terms width");
    assert!(said.contains("6 participants may be enough"), "{said}");
    // Without an effect, no number of participants is enough.
    let line = "quick --participants 2 --studies 100 --terms orientation_deg --preregistration none.md";
    planned(folder.path(), line);
    let text = std::fs::read_to_string(folder.path().join("none.md")).unwrap();
    assert!(text.contains("[N] participants will be tested. No effect is planned for"), "{text}");
    fails(folder.path(), &split(&format!("plan {line}")), 2);
}

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
        // A function that falls has the mirrored slope and interval.
        let [slope, low, high] =
            ["slope", "slope_low", "slope_high"].map(|end| numbers(&path(&out).join("thresholds.csv"), end)[0]);
        assert!(low < slope && slope < high && sign * slope > 0.0 && low * high > 0.0, "{file}: {slope}");
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
    assert!(left.contains("people.csv: has no answers to analyze; expected at least one"), "{left}");
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
    for (total, answers) in [("0", "0"), ("1e9", "5000000000")] {
        fs::write(path("wrong.csv"), format!("x,right,n\n{}", format!("0.1,0,{total}\n").repeat(5))).unwrap();
        refused(&format!("1: => wrong.csv: has {answers} answers; expected 1 to 4294967295"));
    }
}

/// Every task has a plan: a difference that is there is found in most studies, and one that is not in few; more trials say
/// more about one person, and more people more about the mean.
#[test]
fn studies_of_every_task_are_planned() {
    let folder = tempfile::tempdir().unwrap();
    let head = "schema = 1\nname = \"t\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\ndepth = [1, 2, 3]\n[task]\n";
    let adjust = "kind = \"adjust\"\nparameter = \"width\"\nlow = 0.01\nhigh = 1\nlog = true\n";
    let quest = "kind = \"choice\"\nreference = { depth = \"inf\" }\n[adaptive]\nmethod = \"quest-plus\"\nparameter = \"width\"\n\
                 levels = [0.01, 0.013, 0.017, 0.022, 0.028, 0.036, 0.046, 0.06, 0.077, 0.1, 0.13, 0.17, 0.22, 0.28, 0.36]\n";
    for (task, observer, shift, trials) in [
        ("kind = \"rating\"\nscale = \"slider\"\n", "rating=50 subject_sd=5 sd=10", "25", "2,12"),
        ("kind = \"choice\"\nreference = { depth = \"inf\" }\n", "proportion=0.75 subject_sd=0.05", "0.2", "10,60"),
        (
            "kind = \"yes-no\"\nreference = { width = 0 }\n",
            "d_prime=1.5 subject_sd=0.5 false_alarms=0.1",
            "1.5",
            "20,100",
        ),
        ("kind = \"pair\"\n", "subject_sd=0.5 lapse=0.02", "2", "4,24"),
        ("kind = \"pair\"\npairs = \"adaptive\"\n", "subject_sd=0.5 lapse=0.02", "2", "12,72"),
        (adjust, "setting=0.1 subject_sd=0.1 sd=0.2", "0.4", "2,12"),
        (quest, "threshold=0.06 subject_sd=0.078 slope=3.9 lapse=0.02", "0.5", "16,90"),
    ] {
        fs::write(folder.path().join("t.toml"), format!("{head}{task}")).unwrap();
        let options = format!("--trials {trials} --studies 16 --effect depth:2={shift} --out p.csv --force");
        let printed = planned(folder.path(), &format!("t.toml --participants 4,8 {options}"));
        assert!(printed.contains(&format!("observer {observer};")), "{task}: {printed}");
        let column = |name: &str| numbers(&folder.path().join("p.csv"), name);
        // Rows: few trials of 4 people and of 8, then many; each with a person, the mean, depth 2 and depth 3.
        let (power, alarms) = (column("power"), column("false_alarms"));
        let (error, width) = (column("error"), column("half_width"));
        assert!(power.len() == 16 && power[14] > 0.8 && alarms[15] < 0.2, "{task}: {power:?} {alarms:?}");
        assert!(error[12] < 0.8 * error[4] && width[13] < width[9], "{task}: {error:?} {width:?}");
    }

    // Trials that no session could order are no reason to simulate.
    let definition = fs::read_to_string("experiments/threshold-width.toml").unwrap();
    let two = definition.replace("high = 0.75\n", "").replace("[0, 90]", "[0, 90]\nhigh = [0.7, 0.75]");
    let definition = two.replace("[design]", "[design]\nmax_run = 1");
    fs::write(folder.path().join("run.toml"), definition).unwrap();
    let cases = r"
        1: run.toml => max_run = 1
        2: quick --trials 20 => --trials: does not apply to ratings
        2: threshold-width --effect orientation:90=0.3 => --effect orientation: no such factor; expected orientation_deg
        2: threshold-width --effect orientation_deg:45=0.3 => --effect orientation_deg:45: no such level; expected one of 0, 90
        2: threshold-width --effect slop=3 => the observer has no such parameter; expected one of threshold
        2: threshold-width --effect lapse=0.9 => lapse 0.9 is outside 0…0.5
        2: pairs-shaders --effect slope=3 => the observer has no such parameter; expected one of subject_sd, lapse
        2: threshold-width --terms width => does not apply to answers to the task choice
        2: threshold-width --preregistration p.md => --preregistration: does not apply to this task
        2: pairs-shaders --alpha 0.01 => --alpha: does not apply to answers to the task pair";
    refuses(folder.path(), "plan {} --participants 4", cases);
}
