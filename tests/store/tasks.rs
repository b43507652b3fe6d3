//! Tasks and adaptive methods: what they show follows from the answers, in a session, after every interruption, and in
//! the proof of its rows.

use std::{collections::BTreeSet, fs, path::Path};

use machband::{
    experiment::{
        Protocol, Schedule,
        task::{Common, Curve, Grid, Pick, Quest, Ranking, Staircase, Stairs, Track},
    },
    store::{
        StoreError, definition,
        session::{Changes, SessionStore},
    },
};

use crate::{
    common::{
        edit, fails, golden_path, json, machband, number, records, set_cell, split, succeeds, table, text, verified,
    },
    recording::{SEED, identity, rate, sitting},
};

const HEAD: &str = "schema = 1\nname = \"tasks\"\n[stimulus]\nkind = \"mach-band\"\ncolor = \"gray\"\n";
const CHOICE: &str = "[task]\nkind = \"choice\"\nreference = { depth = \"inf\" }\n";
const YES_NO: &str = "[task]\nkind = \"yes-no\"\nreference = { depth = \"inf\" }\n";
const ORIENTATIONS: &str = "[factors]\norientation_deg = [0, 90]\n[design]\npractice = 2\n";
const DEPTHS: &str = "[factors]\ndepth = [1, 2, 3, \"inf\"]\n[design]\npractice = 2\n";
const LEVELS: &str = "parameter = \"width\"\nlevels = [0.01, 0.02, 0.04, 0.08, 0.16]\n";

/// Every task with every method, by name.
fn tasks() -> Vec<(&'static str, String)> {
    let quest = format!("[adaptive]\nmethod = \"quest-plus\"\ntrials = 12\n{LEVELS}");
    let constant = format!("[adaptive]\nmethod = \"constant\"\ntrials = 10\n{LEVELS}");
    let second = format!(
        "{quest}second = {{ parameter = \"high\", levels = [0.5, 0.75], gradient = [-1, 0, 1] }}\nstop_width = 0.3\n"
    );
    let stairs = "[adaptive]\nmethod = \"staircase\"\nparameter = \"width\"\nstart = 0.2\nlow = 0.01\nhigh = 0.4\nreversals = 3\n";
    vec![
        ("quest", format!("{ORIENTATIONS}{CHOICE}{quest}")),
        ("two", format!("{ORIENTATIONS}{CHOICE}{second}")),
        ("four", format!("{ORIENTATIONS}{CHOICE}alternatives = 4\nshown = \"places\"\nfeedback = true\n{constant}")),
        ("plain", format!("{ORIENTATIONS}repetitions = 4\n{CHOICE}")),
        ("stairs", format!("{ORIENTATIONS}{CHOICE}{stairs}")),
        ("yes", format!("{ORIENTATIONS}{YES_NO}{quest}")),
        ("signal", format!("{DEPTHS}repetitions = 8\n{}", YES_NO.replace("depth = \"inf\"", "width = 0"))),
        ("all", format!("{DEPTHS}repetitions = 2\n[task]\nkind = \"pair\"\n")),
        ("chain", format!("{DEPTHS}[task]\nkind = \"pair\"\npairs = \"chain\"\n[recovery]\nduration_s = 0\n")),
        ("ranking", format!("{DEPTHS}[task]\nkind = \"pair\"\npairs = \"adaptive\"\ntrials = 15\n")),
        ("equal", format!("{ORIENTATIONS}[task]\nkind = \"pair\"\nreference = {{ depth = \"inf\" }}\n{constant}")),
        (
            "adjust",
            format!(
                "{DEPTHS}repetitions = 2\n[task]\nkind = \"adjust\"\nparameter = \"width\"\nlow = 0.01\nhigh = 0.8\nlog = true\n"
            ),
        ),
        // Durations that are not a whole number of nanoseconds, and none.
        (
            "slider",
            format!("{DEPTHS}[task]\nkind = \"rating\"\nscale = \"slider\"\n[recovery]\nduration_s = {}\n", 1.0 / 3.0),
        ),
    ]
}

/// The tables of one of them.
fn body(name: &str) -> String {
    tasks().into_iter().find(|(task, _)| *task == name).unwrap().1
}

fn protocol(body: &str) -> Protocol {
    definition::parse("tasks.toml", &format!("{HEAD}{body}")).unwrap()
}

/// Answers up to `limit` trials of a session, which is resumed if it exists. Returns whether it is complete.
fn sit(results: &Path, protocol: &Protocol, limit: usize) -> bool {
    let identity = identity();
    let resumed = SessionStore::resume(results, protocol, &identity, Some(SEED), sitting(), Changes::Refuse);
    let (mut store, found) = match resumed {
        Err(StoreError::NothingToResume(_)) => {
            SessionStore::create(results, protocol, &identity, SEED, sitting()).unwrap()
        }
        resumed => resumed.unwrap(),
    };
    rate(&mut store, (protocol, &identity), Some(&found), limit, false).unwrap();
    store.is_complete()
}

fn csv(results: &Path) -> std::path::PathBuf {
    results.join("tasks/data/subject-S001_session-1_task-tasks_data.csv")
}

/// Returns what the rows show and answer: everything but the number of the sitting and the times since the session's
/// start, which a later sitting knows only as they were written.
fn shown(results: &Path) -> Vec<Vec<String>> {
    let (header, mut rows) = table(&csv(results));
    let without =
        ["sitting", "onset_s", "started_at"].map(|wanted| header.iter().position(|name| name == wanted).unwrap());
    rows.iter_mut().for_each(|row| without.iter().for_each(|column| row[*column].clear()));
    rows
}

#[test]
fn every_task_resumes_after_every_interruption_as_if_there_had_been_none() {
    for (name, body) in tasks() {
        let protocol = protocol(&body);
        let whole = tempfile::tempdir().unwrap();
        assert!(sit(whole.path(), &protocol, usize::MAX), "{name}");
        let expected = shown(whole.path());
        assert_eq!(verified(&csv(whole.path())).errors, [], "{name}");
        for each in [1, 2, 5, 9] {
            let folder = tempfile::tempdir().unwrap();
            let mut sittings = 1;
            while !sit(folder.path(), &protocol, each) {
                sittings += 1;
                assert!(sittings < 200, "{name}");
            }
            // A sitting that ends with its last answer leaves nothing for the next one but to notice.
            assert_eq!(shown(folder.path()), expected, "{name}, {each} at a time");
            let found = verified(&csv(folder.path()));
            assert_eq!(found.errors, [], "{name}");
            assert_eq!(found.rated.0, found.rated.1, "{name}");
        }
    }
}

#[test]
fn every_task_notices_a_row_that_is_missing_and_shows_its_trial_again() {
    for (name, body) in tasks() {
        let protocol = protocol(&body);
        for row in [1, 3] {
            let folder = tempfile::tempdir().unwrap();
            assert!(!sit(folder.path(), &protocol, 4), "{name}");
            let csv = csv(folder.path());
            let lines = |text: &str| text.split_inclusive('\n').map(str::to_owned).collect::<Vec<String>>();
            edit(&csv, |text| {
                lines(text).into_iter().enumerate().filter(|(i, _)| *i != row).map(|(_, line)| line).collect()
            });
            let found = verified(&csv).errors;
            assert!(found[0].message.contains("has no row of") && found[0].position.unwrap().0 == row + 1, "{name}");
            fails(folder.path(), &["analyze", "tasks", "--out", "analysis"], 1);
            let resumed =
                SessionStore::resume(folder.path(), &protocol, &identity(), Some(SEED), sitting(), Changes::Refuse);
            let refused = resumed.map(|_| ()).unwrap_err().to_string();
            assert!(refused.contains("has no row of") && refused.contains("machband repair"), "{name}: {refused}");
            let said = succeeds(folder.path(), &["repair", "tasks"]);
            assert!(said.contains("rows are missing"), "{name}: {said}");
            assert!(sit(folder.path(), &protocol, usize::MAX), "{name}");
            let found = verified(&csv);
            assert_eq!(found.errors, [], "{name}");
            assert_eq!(found.rated.0, found.rated.1, "{name}");
        }
    }
}

#[test]
fn a_cell_that_a_trial_cannot_have_is_named() {
    let folder = tempfile::tempdir().unwrap();
    // SET stands for what was set.
    let paths = "garbage|1:0.2|2:0.2 1:SET|-1:SET|1:SET |1:NaN|1000:SET";
    for (name, column, cells, first) in [
        ("adjust", "path", paths, 3),
        ("slider", "path", paths, 3),
        ("plain", "path", paths, 3),
        ("quest", "level", "0.16|0.03", 4),
        ("quest", "correct", "0", 4),
        ("quest", "target", "3", 4),
        ("quest", "response", "5|yes", 4),
    ] {
        let results = folder.path().join(name).join(column);
        sit(&results, &protocol(&body(name)), if column == "path" { 5 } else { usize::MAX });
        let csv = csv(&results);
        let (original, rows) = (fs::read_to_string(&csv).unwrap(), records(&csv));
        for cell in cells.split('|') {
            let row = (first..rows.len()).find(|row| rows[*row][column] != cell).unwrap();
            let cell = cell.replace("SET", &rows[row]["response"]);
            set_cell(&csv, row + 2, column, &cell);
            let errors = verified(&csv).errors;
            let of_row = errors.iter().filter(|error| error.position.is_some_and(|at| at.0 == row + 2));
            let of_row: String = of_row.map(|error| error.message.as_str()).collect();
            let expected = match column {
                "path" => format!("has the path {cell:?}"),
                "correct" => "contradicts its response; expected \"1\"".to_owned(),
                _ => format!(" {column} "),
            };
            assert!(of_row.contains(&expected), "{name} {column} {cell}: {errors:?}");
            assert!(column != "path" || errors.len() == 1, "{name} {cell}: {errors:?}");
            fs::write(&csv, &original).unwrap();
        }
        assert_eq!(verified(&csv).errors, [], "{name}");
        // Its rows are not answers at levels: practice and earlier attempts are among them.
        let line = format!("analyze {} --level=level --correct=correct --guess=0.5 --out=a", csv.display());
        let told = fails(folder.path(), &split(&line), 1);
        assert!(told.contains("has the rows of a session") && told.contains("expected the folder"), "{told}");
    }
}

#[test]
fn an_altered_answer_is_found_by_the_trials_that_no_longer_follow() {
    let (mut altered, mut without_effect) = (0, 0);
    for name in ["quest", "two", "stairs", "yes", "ranking"] {
        let protocol = protocol(&body(name));
        let folder = tempfile::tempdir().unwrap();
        sit(folder.path(), &protocol, usize::MAX);
        let csv = csv(folder.path());
        // The seal would find any change. Here, the rows themselves must.
        let mut sidecar = json(&csv.with_extension("json"));
        sidecar["sittings"][0].as_object_mut().unwrap().remove("seal");
        fs::write(csv.with_extension("json"), sidecar.to_string()).unwrap();
        let text = fs::read_to_string(&csv).unwrap();
        let rows = records(&csv);
        for row in (0..rows.len() - 5).filter(|row| rows[*row]["phase"] == "main") {
            let answer = match rows[row]["response"].as_str() {
                "yes" => "no",
                "no" => "yes",
                "1" => "2",
                _ => "1",
            };
            fs::write(&csv, &text).unwrap();
            set_cell(&csv, row + 2, "response", answer);
            if !rows[row]["correct"].is_empty() {
                set_cell(&csv, row + 2, "correct", if rows[row]["correct"] == "1" { "0" } else { "1" });
            }
            // Without a seal, the session as a whole is an error; only the rows count here.
            let found = verified(&csv).errors;
            match found.iter().find(|error| error.position.is_some()) {
                Some(error) => {
                    assert!(error.message.contains("does not follow from the answers before it"), "{error}");
                    assert!(error.position.unwrap().0 > row + 2, "{error}");
                    altered += 1;
                }
                None => without_effect += 1,
            }
        }
        fs::write(&csv, &text).unwrap();
        assert!(verified(&csv).errors.iter().all(|error| error.position.is_none()));
    }
    assert!(altered >= 100 && without_effect * 15 <= altered, "{altered} {without_effect}");
}

#[test]
fn sides_places_and_catch_trials_are_balanced() {
    for (name, body) in tasks() {
        let protocol = protocol(&body);
        if protocol.task.catches().is_some() {
            continue;
        }
        let places: Vec<u32> = (0..protocol.task.places()).collect();
        for seen in dealt(&protocol) {
            let whole = &seen[..seen.len() / places.len() * places.len()];
            for place in &places {
                let count = whole.iter().filter(|one| *one == place).count();
                assert_eq!(count, whole.len() / places.len(), "{name}");
            }
        }
    }
    for (catch, trials, expected) in
        [(0.25, 1, 0), (0.25, 2, 1), (0.05, 3, 1), (0.95, 2, 1), (0.25, 27, 7), (0.13, 100, 13), (0.5, 40, 20)]
    {
        let body = format!("{ORIENTATIONS}repetitions = {trials}\n{YES_NO}catch = {catch}\n");
        for seen in dealt(&protocol(&body)) {
            let catches = |trials: usize| seen[..trials].iter().filter(|place| **place == 0).count();
            assert_eq!(catches(trials), expected, "{catch} of {trials}");
            for done in (0..trials).step_by(10) {
                let share = expected as f64 / trials as f64 * done as f64;
                assert!((catches(done) as f64 - share).abs() <= 0.5, "{catch} of {trials} after {done}");
            }
        }
    }
}

/// Returns the places of the main trials of each condition, in their order.
fn dealt(protocol: &Protocol) -> Vec<Vec<u32>> {
    let trials = Schedule::new(protocol, &identity(), SEED).unwrap().trials;
    let of = |condition: usize| {
        let main = trials.iter().filter(move |trial| trial.phase.name() == "main" && trial.condition == condition);
        main.map(|trial| trial.place).collect()
    };
    (0..=trials.iter().map(|trial| trial.condition).max().unwrap()).map(of).collect()
}

/// The levels of a 1-up-2-down staircase on a linear scale, worked out by hand.
#[test]
fn staircases_follow_their_rules() {
    let common = Common { log: false, ..Common::default() };
    let stairs = Staircase { start: 10.0, low: 0.0, high: 20.0, steps: vec![4.0, 2.0, 1.0], ..Staircase::default() };
    let run = |stairs: &Staircase, common: &Common, answers: &str| {
        let mut state = Stairs::new(stairs, common);
        let step = |answer| {
            state.answer(answer == '1');
            state.level
        };
        (answers.chars().map(step).collect::<Vec<f64>>(), state.reversals)
    };
    // Two right: down 4. Wrong: up, the first reversal, with step 2. Two right: down, the second, with step 1.
    let (levels, reversals) = run(&stairs, &common, "11011111000");
    assert_eq!(levels, [10.0, 6.0, 8.0, 8.0, 7.0, 7.0, 6.0, 6.0, 7.0, 8.0, 9.0]);
    assert_eq!(reversals, 3);
    // Weighted: a step up is three times a step down, which converges to 75 % with one right answer.
    let weighted = Staircase { down: 1, weight: 3.0, steps: vec![1.0], ..stairs.clone() };
    assert_eq!(run(&weighted, &common, "1101").0, [9.0, 8.0, 11.0, 10.0]);
    // Where low levels are easier, right answers raise the level.
    let low = Common { easier: "low".parse().unwrap(), ..common.clone() };
    assert_eq!(run(&weighted, &low, "110").0, [11.0, 12.0, 9.0]);
    // On a logarithmic scale, steps are ratios; levels stay within their range.
    let log = Staircase { down: 1, start: 1.0, low: 0.5, high: 2.0, steps: vec![std::f64::consts::LOG10_2], ..stairs };
    assert_eq!(run(&log, &Common::default(), "110001").0, [0.5, 0.5, 1.0, 2.0, 2.0, 1.0]);
}

/// 1,000 runs of the Python package `questplus`: the same level in every trial, the same posterior means at the end.
#[test]
fn quest_plus_chooses_what_another_program_chooses() {
    let numbers = |text: &str| text.split(' ').map(|number| number.parse::<f64>().unwrap()).collect::<Vec<_>>();
    let (_, configurations) = table(&golden_path("tasks").join("questplus_configurations.csv"));
    let (_, runs) = table(&golden_path("tasks").join("questplus.csv"));
    assert_eq!(runs.len(), 1000);
    for configuration in &configurations {
        let [name, function, levels, thresholds, slopes, guesses, lapses] = configuration.as_slice() else { panic!() };
        let curve: Curve = function.replace("norm_cdf", "normal").parse().unwrap();
        let [thresholds, slopes, guesses, lapses] = [thresholds, slopes, guesses, lapses].map(|text| numbers(text));
        let grid = Grid { thresholds, slopes, guesses, lapses, gradients: vec![0.0] };
        let stimuli: Vec<(f64, f64)> = numbers(levels).into_iter().map(|x| (x, 0.0)).collect();
        let start = Quest::new(curve, 1.0, &stimuli, grid);
        for run in runs.iter().filter(|run| run[0] == *name) {
            let mut quest = start.clone();
            for (trial, (pick, answer)) in numbers(&run[2]).into_iter().zip(run[3].chars()).enumerate() {
                assert_eq!(quest.choose(), pick as usize, "{name}, seed {}, trial {trial}", run[1]);
                quest.learn(Some(pick as usize), answer == '1');
            }
            let slope = |slope: f64| if curve == Curve::Normal { 1.0 / slope } else { slope };
            let means = [
                quest.mean(|one| one.threshold),
                quest.mean(|one| slope(one.slope)),
                quest.mean(|one| one.guess),
                quest.mean(|one| one.lapse),
            ];
            for (mean, expected) in means.iter().zip(&run[4..8]) {
                assert!((mean - expected.parse::<f64>().unwrap()).abs() < 1e-9, "{name}, seed {}", run[1]);
            }
        }
    }
}

#[test]
fn adaptive_pairs_compare_neighbors_most() {
    // Eight items whose order is told without noise.
    let mut ranking = Ranking::new(8);
    let mut distance = 0.0;
    for trial in 0..60 {
        let [i, j] = ranking.choose(0.37);
        assert!(i < j && j < 8);
        ranking.learn(i.max(j), i.min(j));
        distance += if trial >= 30 { (j - i) as f64 / 30.0 } else { 0.0 };
    }
    // All pairs have a mean distance of 3.
    assert!(distance < 2.0, "{distance}");
    // Every pair is equally informative at first, and the tie decides.
    let first: BTreeSet<[usize; 2]> = (0..28).map(|i| Ranking::new(8).choose((f64::from(i) + 0.5) / 28.0)).collect();
    assert_eq!(first.len(), 28);
    let track = Track::Ranking(ranking);
    assert!(matches!(track.pick(0.5), Pick::Pair(_)) && !track.is_over());
}

/// Tables of a definition, where its only error is, and a part of its message, or nothing where there is none. Words in
/// capitals stand for the tables above and below. What a trial could not show as asked is an error, and not a default; so
/// is an option that would have no effect.
const MISTAKES: &str = r##"
[task]\nkind = "chioce"\n => 7:1 => kind "chioce" is not known; expected one of rating, choice, yes-no, pair, adjust; did you mean choice?
[task]\nscale = "slider"\n => 6:2 => task.kind is missing; expected kind = …
[task]\nkind = "choice"\nreference = { depth = 1 }\n => 8:1 => the reference looks like the target
[task]\nkind = "pair"\n => 1:1 => there is nothing to compare
DEPTHSorder = "blocked:depth"\n[task]\nkind = "pair"\n => 10:1 => pairs have no levels of their own
DEPTHS[task]\nkind = "pair"\npairs = "chain"\nalong = "low"\n => 13:1 => along "low" is not a factor; expected depth
HIGHSADJUST"high"\nlow = 0.6\nhigh = 0.7\n => 10:1 => high is a factor
[task]\nkind = "adjust"\nparameter = "tanh_k"\nlow = 1\nhigh = 9\n => 8:1 => tanh_k changes nothing that is shown
CHOICE[adaptive]\nmethod = "constant"\nLEVELStrials = 7\n => 13:1 => trials 7 is not a multiple of the 5 levels
CHOICE[adaptive]\nmethod = "quest-plus"\nparameter = "width"\nlevels = [0.01, 0.01]\n => 12:17 => level 0.01 appears twice
QUESTguess = [0.1]\n => 13:1 => expected no guess rates
QUESTsecond = { parameter = "width", levels = [0.1, 0.2], gradient = [1] }\n => 13:12 => width is varied already
[design]\nrepetitions = 3\nCHOICE[adaptive]\nmethod = "constant"\ntrials = 10\nLEVELS => 7:1 => repetitions is 3, but trials says that there are 10
[adaptive]\nmethod = "quest-plus"\nLEVELS => 6:2 => a task of the kind rating has no levels to choose
CHOICECONSTANTparameter = "depth"\neasier = "low"\ntrials = 9\nlevels = [2, 2.5, 3]\n => 14:14 => depth 2.5 is not a whole number
ADJUST"low"\nlow = 0.1\nhigh = 0.5\n[response]\nkeys = ["1"]\n => 12:1 => expected no keys
[task]\nkind = "rating"\nscale = "slider"\n[response]\nkeys = ["1", "2"]\n => 10:1 => expected no keys
QUESTsecond = { parameter = "low", levels = [0.1, 0.9], gradient = [1] }\n => 11:1 => high 0.75 is below low, which is 0.9
QUESTsecond = { parameter = "low", levels = [0.1, 0.2], gradient = [0, 1, 0] }\n => 13:70 => 0 appears twice
QUESTsecond = { parameter = "tanh_k", levels = [3, 5], gradient = [0, 1] }\n => 
[task]\nkind = "choice"\nreference = { low = 0.3 }\n[adaptive]\nmethod = "quest-plus"\nLEVELSsecond = { parameter = "tanh_k", levels = [3, 5], gradient = [0, 1] }\n => 13:12 => tanh_k changes nothing that is shown
QUESTthreshold = [5, 10]\n => 13:1 => no threshold lies within the levels; expected values from 0.01 to 0.16
[presentation]\nduration_s = 1\nCHOICE => 6:2 => [presentation] does not apply to this task
[task]\nkind = "choice"\nreference = { tanh_k = 9 }\n => 8:1 => the reference looks like the target
[task]\nkind = "choice"\nreference = { depth = [1] }\n => 8:15 => the value is neither a number nor text; expected one of them
CHOICEshown = "places"\nduration_s = 0.3\n => 10:1 => duration_s applies to intervals only
DEPTHS[task]\nkind = "pair"\nalong = "depth"\n => 12:1 => along applies to chains only
[task]\nkind = "pair"\npairs = "chain"\nreference = { depth = "inf" }\n[adaptive]\nmethod = "constant"\ntrials = 10\nLEVELS => 8:1 => pairs applies to pairs of conditions only
CHOICESTAIRSparameter = "width"\nstart = 0.2\nlow = 0.1\nhigh = 0.4\nsteps = [5]\n => 15:10 => steps 5 is outside 0.000001…0.60206; expected a size in base-10 logarithms
QUESTsecond = { parameter = "high", levels = [0.5, 0.6], gradient = [nan] }\n => 13:65 => is NaN; expected a finite number
[design]\norder = "latin:width"\n => 7:1 => expected random, because there are none
[factors]\ndepth = [1, "inf"]\nCHOICE => 10:1 => the reference looks like the target
"##;

#[test]
fn bad_tasks_are_named_with_their_place() {
    let tables = [
        ("QUEST", "CHOICE[adaptive]\nmethod = \"quest-plus\"\nLEVELS"),
        ("CONSTANT", "[adaptive]\nmethod = \"constant\"\n"),
        ("STAIRS", "[adaptive]\nmethod = \"staircase\"\n"),
        ("ADJUST", "[task]\nkind = \"adjust\"\nparameter = "),
        ("HIGHS", "[factors]\nhigh = [0.6, 0.75]\n"),
        ("CHOICE", CHOICE),
        ("YES_NO", YES_NO),
        ("DEPTHS", DEPTHS),
        ("LEVELS", LEVELS),
        ("\\n", "\n"),
    ];
    for mistake in MISTAKES.lines().filter(|line| line.contains(" => ")) {
        let (body, expected) = mistake.split_once(" => ").unwrap();
        let text = tables.iter().fold(format!("{HEAD}{body}"), |text, (name, table)| text.replace(name, table));
        let errors = definition::parse("t.toml", &text).map(drop).err().map(|errors| errors.to_string());
        let is_told = match (&errors, expected.split_once(" => ")) {
            (Some(error), Some((place, message))) => {
                error.starts_with(&format!("t.toml:{place}: ")) && error.contains(message) && error.lines().count() == 1
            }
            (errors, _) => errors.is_none(),
        };
        assert!(is_told, "{text}\nexpected {expected}\n{errors:?}");
    }
}

/// The commands that read ratings say that there are none; `analyze` reads every task.
#[test]
fn every_task_is_analyzed_and_none_is_taken_for_ratings() {
    for (name, body) in tasks() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("tasks.toml"), format!("{HEAD}{body}")).unwrap();
        let simulate = ["simulate", "tasks.toml", "--observer", "paper", "--participants", "3", "--results", "results"];
        let told = succeeds(folder.path(), &simulate);
        let data = fs::read_dir(folder.path().join("results/tasks/data")).unwrap().map(|entry| entry.unwrap().path());
        let rows = data.filter(|path| path.extension().is_some_and(|ext| ext == "csv")).map(|csv| table(&csv).1.len());
        assert!(told.contains(&format!(", {} rows, ", rows.sum::<usize>())), "{name}: {told}");
        let printed = succeeds(folder.path(), &["analyze", "results/tasks", "--out", "analysis"]);
        assert!(printed.starts_with("3 participants gave "), "{name}: {printed}");
        assert!(
            printed.contains("These data are simulated: a program gave the answers of 3 sessions."),
            "{name}: {printed}"
        );
        let report = fs::read_to_string(folder.path().join("analysis/report.html")).unwrap();
        assert!(report.contains("Repeat this analysis") && report.contains("<svg"), "{name}");
        if name == "two" {
            // Each level of the second parameter has its own threshold.
            let rows = records(&folder.path().join("analysis/thresholds.csv"));
            assert_eq!(rows.iter().map(|row| &*row["high"]).collect::<BTreeSet<_>>(), BTreeSet::from(["0.5", "0.75"]));
        }
        let without = ["analyze", "results/tasks", "--out", "without", "--exclude", "S002", "--tables-only"];
        assert!(succeeds(folder.path(), &without).contains("Left out on request: S002."), "{name}");
        let refused = fails(folder.path(), &["counts", "results/tasks", "--out", "counts.csv"], 1);
        let answers = if name == "slider" { "answers on a slider" } else { "answers to the task" };
        assert!(refused.contains(&format!("has {answers}")), "{name}: {refused}");
        let refused = fails(folder.path(), &["analyze", "results/tasks", "--out", "x", "--terms", "depth"], 2);
        assert!(refused.contains(&format!("does not apply to {answers}")), "{name}: {refused}");
    }
}

/// What the seals do not prove is told, no session counts twice, and a lost sidecar hides no other session.
#[test]
fn answers_are_analyzed_as_they_were_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let body = body("signal");
    fs::write(at("tasks.toml"), format!("{HEAD}{body}")).unwrap();
    succeeds(folder.path(), &["simulate", "tasks.toml", "--participants", "3", "--results", "results"]);
    let analyze = |paths: &[&str]| {
        machband(folder.path(), &[&["analyze", "--out=a", "--force", "--tables-only"], paths].concat())
    };
    let first = csv(&at("results"));
    let path = first.to_string_lossy().into_owned();
    let once = analyze(&["results/tasks"]);
    assert!(once.stderr.is_empty(), "{}", text(&once.stderr));
    assert_eq!(text(&analyze(&["results/tasks", &path]).stdout), text(&once.stdout));
    succeeds(folder.path(), &["simulate", "tasks.toml", "--participants", "3", "--results", "copy"]);
    let twice = text(&analyze(&["results/tasks", "copy/tasks"]).stderr);
    assert!(twice.contains("has the same participant and session as"), "{twice}");

    set_cell(&first, 4, "response_time_s", "0.1234");
    let changed = analyze(&["results/tasks"]);
    assert!(text(&changed.stderr).contains("was changed since the session ended"), "{}", text(&changed.stderr));
    assert!(machband(folder.path(), &["analyze", "results/tasks", "--out=b"]).status.success());
    assert!(fs::read_to_string(at("b/report.html")).unwrap().contains("was changed since the session ended"));

    fs::remove_file(first.with_extension("json")).unwrap();
    let lost = analyze(&["results/tasks"]);
    assert!(text(&lost.stdout).starts_with("2 participants"), "{}", text(&lost.stdout));
    assert_eq!((lost.status.code(), text(&lost.stderr).contains("rating")), (Some(1), false), "{}", text(&lost.stderr));
}

/// Where every answer is right, however hard the level, there is a threshold somewhere below, and no number for it.
#[test]
fn a_threshold_beyond_the_levels_is_no_number() {
    let folder = tempfile::tempdir().unwrap();
    let simulate = "simulate threshold-width --participants 8 --observer paper";
    succeeds(folder.path(), &simulate.split(' ').collect::<Vec<_>>());
    let printed = succeeds(folder.path(), &["analyze", "results/threshold-width", "--out", "analysis"]);
    assert_eq!(printed.matches("was not measured").count(), 2, "{printed}");
    assert!(printed.contains("lies beyond the levels, 0.005 to"), "{printed}");
    assert!(!printed.contains("differ") && !printed.contains("on average"), "{printed}");
    let rows = records(&folder.path().join("analysis/thresholds.csv"));
    assert!(rows.iter().filter(|row| row["is_beyond"] == "1").count() >= 14, "{rows:?}");
    assert!(table(&folder.path().join("analysis/population.csv")).1.is_empty());
}

/// Conditions that no comparison connects have no common order, and every column has a name of its own.
#[test]
fn unconnected_comparisons_have_scales_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let body = "[factors]\nlow = [0.1, 0.2]\ndepth = [1, 2]\n[design]\nrepetitions = 6\n[task]\nkind = \"pair\"\npairs = \"chain\"\n\
        along = \"depth\"\n";
    fs::write(folder.path().join("tasks.toml"), format!("{HEAD}{body}")).unwrap();
    succeeds(folder.path(), &["simulate", "tasks.toml", "--participants", "4", "--results", "results"]);
    let printed = succeeds(folder.path(), &["analyze", "results/tasks", "--out", "a", "--tables-only"]);
    assert_eq!(printed.matches("From the highest to the lowest").count(), 2, "{printed}");
    assert!(printed.contains("No comparison leads from one group of conditions to another"), "{printed}");
    let (header, _) = table(&folder.path().join("a/scale.csv"));
    let names: BTreeSet<&String> = header.iter().collect();
    assert_eq!((names.len(), &*header[0], &*header[1]), (header.len(), "low_", "depth"), "{header:?}");
    let rows = records(&folder.path().join("a/scale.csv"));
    for pair in rows.chunks(2) {
        let values = pair.iter().map(|row| number::<f64>(row, "thurstone"));
        assert!(values.sum::<f64>().abs() < 1e-9 && pair[0]["group"] == pair[1]["group"], "{rows:?}");
    }
    assert_ne!(rows[0]["group"], rows[2]["group"]);
    // The scale of all people comes first, and then that of each.
    let people: Vec<&str> = rows.iter().step_by(4).map(|row| &*row["subject_id"]).collect();
    assert_eq!(people, ["", "S001", "S002", "S003", "S004"]);
}
