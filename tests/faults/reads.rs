//! Faults while data are read. Each command that reads runs over prepared data once for every call that concerns a file
//! and every fault of that call. It must do what it does without the fault, or say an error and fail.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use machband::store::{
    StoreError, Writer,
    dataset::free_participant,
    definition,
    draft::{Draft, Typed},
    session::overview::Overview,
    settings::{Settings, SettingsFile},
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};
use rayon::prelude::*;

use crate::{
    common::{self, MACHBAND, everything},
    disk,
    run::{self, DEFINITIONS},
    shim::{self, Fault},
    sweep::{self, Sweep},
};

/// What must hold when a command runs again, without faults, after it was killed or failed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Again {
    /// Its outcome is the reference.
    Same,
    /// Its files are those of the reference; it may say that they were there.
    Files,
    /// The data files are those of the reference, and the sidecar says that they were repaired.
    Repaired,
    /// The first session of the folder `open` is complete and correct.
    Session,
}

/// A command that reads: its name; its arguments, in which `./` stands for the folder of the data, and `CSV` and `IMAGE`
/// for files in it; its exit status; and what must hold when it runs again.
struct Reader(&'static str, &'static str, i32, Again);

const CSV: &str = "./results/small-one/data/subject-S001_session-1_task-smallone_data.csv";
const IMAGE: &str = "./done/1_width-0.1_tanh_k-5.png";

/// What the window does, for which this test program stands: its list of sessions, what it remembers, and a copy that its
/// editor saves.
const WINDOW: [&str; 3] = ["sessions", "settings", "editor"];

/// Where the only link in the data leads.
const LINK: &str = "../../study.toml";

const READERS: &[Reader] = &[
    Reader("verify", "verify ./results", 0, Again::Same),
    Reader("verify, damaged", "verify ./harmed", 1, Again::Same),
    Reader("check", "check ./study.toml ./observer.toml CSV IMAGE", 0, Again::Same),
    Reader("counts", "counts ./results/small-one --out ./counts.csv --force", 0, Again::Same),
    Reader("counts onto its input", "counts ./results/small-one --out CSV --force", 2, Again::Same),
    Reader("analyze", "analyze ./results/small-one --out ./analysis --tables-only --force", 0, Again::Same),
    Reader("analyze a task", "analyze ./answers/adaptive --out ./analysis --tables-only --force", 0, Again::Same),
    Reader(
        "predict",
        "predict ./study.toml --fit ./results/small-one --criterion ./fit.toml --size 64 --out ./predicted.csv --force",
        0,
        Again::Same,
    ),
    Reader("compare pictures", "compare IMAGE IMAGE --window 5", 0, Again::Same),
    Reader(
        "plan",
        "plan ./study.toml --participants 3 --studies 2 --effect width:0.4=1 --observer-file ./observer.toml",
        0,
        Again::Same,
    ),
    Reader("export as Psych-DS", "export ./results --format psych-ds --out ./exported", 0, Again::Files),
    Reader("export of a link", "export ./linked --format psych-ds --out ./exported", 1, Again::Files),
    Reader("export as BIDS", "export ./results --format bids --out ./exported", 0, Again::Files),
    Reader("stimuli, the last shard", "stimuli ./study.toml --size 16 --shard 2/2 --out ./images", 0, Again::Files),
    Reader("stimuli, again", "stimuli ./study.toml --size 16 --out ./done", 0, Again::Same),
    Reader("repair", "repair ./broken", 0, Again::Repaired),
    Reader("resume", "simulate ./study.toml --seed 7 --resume --results ./open", 0, Again::Session),
    Reader("list of sessions", WINDOW[0], 0, Again::Same),
    Reader("settings", WINDOW[1], 0, Again::Files),
    Reader("saving in the editor", WINDOW[2], 0, Again::Files),
];

/// What a command did: its exit status, what it printed, and every file. The name of the folder is replaced, because it
/// is a different one in every run.
type Outcome = BTreeMap<String, String>;

const STATUS: &str = "status";
const STDOUT: &str = "stdout";
const STDERR: &str = "stderr";

/// The data, as relative paths and contents, and what each reader does with them.
struct Readings {
    data: Vec<(PathBuf, Vec<u8>)>,
    planned: Vec<Vec<String>>,
    references: Vec<(Outcome, Vec<(String, u64)>)>,
}

/// Does one of the things that the window does, and returns the exit status.
pub fn window(part: &str, folder: &Path) -> i32 {
    let done = match part {
        "sessions" => return list(&folder.join("results")),
        "settings" => remember(&folder.join("settings.toml")),
        _ => save_copy(&folder.join("study.toml"), &folder.join("copy.toml")),
    };
    done.inspect_err(|error| eprintln!("error: {error}")).map_or(1, |()| 0)
}

/// Reads the settings, changes one, and writes them.
fn remember(path: &Path) -> Result<(), StoreError> {
    let (mut file, mut settings) = SettingsFile::open(path)?;
    println!("{settings:?}");
    settings.zoom = 2.0;
    file.save(&settings)
}

/// Saves a copy of a definition with another title, as the editor does.
fn save_copy(path: &Path, copy: &Path) -> Result<(), StoreError> {
    let mut draft = Draft::parse(&path.display().to_string(), &definition::text(path)?)?;
    draft.set("title", "Another title", Typed::Text);
    Writer::new([path.to_owned()], false).write(copy, draft.text().as_bytes())
}

/// Prints what the window's list of sessions shows, and returns the exit status.
fn list(results: &Path) -> i32 {
    let overview = Overview::of(results);
    println!("{:#?}", overview.sessions);
    let mut errors = overview.errors;
    match free_participant(results, &run::protocol(0)) {
        Ok(participant) => println!("{participant}"),
        Err(error) => errors.push(error.to_string()),
    }
    errors.iter().for_each(|error| eprintln!("error: {error}"));
    i32::from(!errors.is_empty())
}

/// Writes the data that the readers read.
fn prepare(folder: &Path) {
    let machband = |line: &str| common::succeeds(folder, &common::split(line));
    fs::write(folder.join("study.toml"), DEFINITIONS[0]).unwrap();
    fs::write(folder.join("twice.toml"), DEFINITIONS[1]).unwrap();
    fs::write(folder.join("adaptive.toml"), DEFINITIONS[3]).unwrap();
    fs::write(folder.join("observer.toml"), machband::store::observer::PAPER).unwrap();
    let csv = |results: &str| disk::paths(&folder.join(results), 0).csv;
    for results in ["results", "harmed", "broken"] {
        run::undone(0, &folder.join(results));
    }
    machband("simulate study.toml --participants 2 --seed 7 --resume --results results");
    for results in ["results", "harmed", "linked"] {
        machband(&format!("simulate twice.toml --results {results}"));
    }
    machband("simulate adaptive.toml --participants 2 --observer paper --results answers");
    let rows = fs::read_to_string(csv("harmed")).unwrap();
    fs::write(csv("harmed"), rows.trim_end().rsplit_once('\n').unwrap().0.to_owned() + "\n").unwrap();
    let rows = fs::read_to_string(csv("broken")).unwrap();
    fs::write(csv("broken"), rows.replacen("\nS001_1_main_0002_1", "\n\u{1}!S001_1_main_0002_1", 1)).unwrap();
    run::interrupted(0, &folder.join("open"), 3);
    fs::write(folder.join("results/small-one/participants.tsv"), "participant_id\tage\nsub-S001\t27\nsub-S002\t31\n")
        .unwrap();
    for (name, text) in [("LICENSE", "CC0\n"), ("README.md", "# Ours\n"), ("CHANGES.md", "# Changes\n\nNone.\n")] {
        fs::write(folder.join("results/twice").join(name), text).unwrap();
    }
    let description = folder.join("results/twice/dataset_description.json");
    let described = fs::read_to_string(&description).unwrap();
    fs::write(&description, described.replacen('{', "{\"license\": \"CC0\", \"author\": \"A\",", 1)).unwrap();
    std::os::unix::fs::symlink(LINK, folder.join("linked/twice/LICENSE")).unwrap();
    for results in ["results", "harmed"] {
        for foreign in ["lost+found", ".Trash-1000"] {
            fs::create_dir(folder.join(results).join(foreign)).unwrap();
            fs::write(folder.join(results).join(foreign).join("#12"), "").unwrap();
        }
    }
    SettingsFile::open(&folder.join("settings.toml"))
        .unwrap()
        .0
        .save(&Settings { zoom: 1.5, ..Settings::default() })
        .unwrap();
    machband("stimuli study.toml --size 16 --shard 1/2 --out images");
    machband("stimuli study.toml --size 16 --out done");
}

/// Every file below a folder, with its path in the folder.
pub fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let found = everything(folder).into_iter();
    found.map(|(path, content)| (path.strip_prefix(folder).unwrap().to_owned(), content)).collect()
}

impl Readings {
    fn new() -> Self {
        let folder = sweep::folder();
        prepare(folder.path());
        let data = files(folder.path());
        let planned = Sweep::new(1).planned(0).to_vec();
        let mut readings = Self { data, planned, references: Vec::new() };
        readings.references = READERS.par_iter().map(|reader| readings.reference(reader)).collect();
        readings
    }

    /// What a reader does without faults, always, and how often it makes each call.
    fn reference(&self, reader: &Reader) -> (Outcome, Vec<(String, u64)>) {
        let [(first, log), (second, _)] = [0; 2].map(|_| self.run(reader, &self.scene(), &[]));
        assert_eq!(first[STATUS], format!("exit status: {}", reader.2), "{}: {}", reader.0, first[STDERR]);
        assert_eq!(difference(&first, &second, |_| true), "", "{}", reader.0);
        (first, log.counts)
    }

    /// A folder with a copy of the data.
    fn scene(&self) -> tempfile::TempDir {
        let folder = sweep::folder();
        for (path, content) in &self.data {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            match content == LINK.as_bytes() {
                true => std::os::unix::fs::symlink(LINK, path).unwrap(),
                false => fs::write(path, content).unwrap(),
            }
        }
        folder
    }

    fn run(&self, reader: &Reader, scene: &tempfile::TempDir, faults: &[Fault]) -> (Outcome, shim::Log) {
        let (folder, log) = (scene.path(), sweep::folder());
        let named = format!("{}/", folder.display());
        let mut command = match reader.1 {
            part if WINDOW.contains(&part) => {
                let mut command = Command::new(std::env::current_exe().unwrap());
                command.args(["--ignored", "--exact", "window_for_the_other_tests", "--nocapture"]);
                command.env("MACHBAND_CHILD_PART", part).env("MACHBAND_CHILD_FOLDER", folder);
                command
            }
            line => {
                let mut command = Command::new(MACHBAND);
                let line = line.replace("CSV", CSV).replace("IMAGE", IMAGE).replace("./", &named);
                command.args(common::split(&line)).current_dir(folder);
                command
            }
        };
        // The order of the calls is the same in every run, and so are all times.
        command.env("RAYON_NUM_THREADS", "1");
        let still = Fault { op: "clock", n: 1, what: "still", repeated: false };
        let (ended, mut log) =
            shim::run_with(&mut command, &[&[still], faults].concat(), folder, &log.path().join("log"));
        log.hits.retain(|hit| hit.op != "clock");
        let plain = |text: &str| text.replace(&named, "./").replace(named.trim_end_matches('/'), ".");
        // The last number in what `simulate` says is its duration.
        let untimed =
            |line: &str| line.strip_suffix(" s").map_or(line, |line| line.rsplit_once(',').unwrap().0).to_owned();
        let mut outcome = Outcome::from([
            (STATUS.to_owned(), ended.status.to_string()),
            (STDOUT.to_owned(), plain(&ended.stdout).lines().map(|line| untimed(line) + "\n").collect()),
            (STDERR.to_owned(), plain(&ended.stderr)),
        ]);
        let files = files(folder).into_iter().map(|(path, content)| (format!("./{}", path.display()), content));
        // The leftovers of a killed program are not its result.
        let files = files.filter(|(path, _)| !path.contains(".tmp"));
        outcome.extend(files.map(|(path, content)| (path, plain(&String::from_utf8_lossy(&content)))));
        (outcome, log)
    }

    /// Every reader with every fault of every call.
    fn faults(&self) -> Vec<(usize, Fault)> {
        const OPS: [&str; 14] = [
            "open", "list", "names", "stat", "fstat", "link", "read", "seek", "write", "sync", "rename", "truncate",
            "unlink", "mkdir",
        ];
        for op in OPS {
            let mut counts = self.references.iter().flat_map(|(_, counts)| counts);
            assert!(counts.any(|(name, count)| name == op && *count > 0), "{op} is not seen");
        }
        let mut all = Vec::new();
        for (reader, (_, counts)) in self.references.iter().enumerate() {
            for (op, count) in
                OPS.iter().filter_map(|op| counts.iter().find(|(name, _)| name == op).map(|(_, n)| (*op, *n)))
            {
                for n in 1..=count {
                    let mut whats = vec!["kill-before"];
                    whats.extend(["read", "names", "write"].contains(&op).then_some("short"));
                    whats.extend((op == "read").then_some("end"));
                    // A file that cannot be removed does no harm.
                    if op != "unlink" {
                        whats.extend([["EIO", "EACCES", "EMFILE"][n as usize % 3], "EINTR"]);
                    }
                    all.extend(whats.into_iter().map(|what| (reader, Fault { op, n, what, repeated: false })));
                }
            }
        }
        all
    }

    /// Injects a fault. Returns what is wrong: another result, and not a word; a panic; or a next run, without faults, that
    /// does not do what it must.
    fn judge(&self, index: usize, fault: &Fault) -> Option<String> {
        let (reader, reference) = (&READERS[index], &self.references[index].0);
        let scene = self.scene();
        let (found, log) = self.run(reader, &scene, std::slice::from_ref(fault));
        let path = log.hits.first()?.path.replace(&*scene.path().to_string_lossy(), ".");
        let fails = |what: String| Some(format!("{} | {fault} {path} | {what}", reader.0));
        let is_in = |of: &Outcome, line: &str| of[STDERR].lines().any(|other| other == line);
        // A session also says in its sidecar what happened.
        let incidents = |of: &Outcome| of.values().filter(|text| text.contains("\"incidents\": [")).count();
        let is_new = found[STDERR].lines().any(|line| !is_in(reference, line))
            || reader.3 == Again::Session && incidents(&found) > incidents(reference);
        let is_whole = reference[STDERR].lines().all(|line| is_in(&found, line));
        let what = difference(reference, &found, |part| part != STDERR || !is_whole);
        let was_killed = fault.what.starts_with("kill") && found[STATUS].starts_with("signal: 9");
        match &*found[STATUS] {
            _ if what.is_empty() => return None,
            _ if was_killed => {}
            // Another result, but with a warning of its own.
            "exit status: 0" if is_new => return None,
            "exit status: 1" | "exit status: 2" if is_new => {}
            _ => return fails(what),
        }
        // If the files are as before, so is the next run.
        if files(scene.path()) == self.data {
            return None;
        }
        let (again, _) = self.run(reader, &scene, &[]);
        let wrong = match reader.3 {
            Again::Same => difference(reference, &again, |_| true),
            Again::Files => difference(reference, &again, |part| part.starts_with("./")),
            Again::Repaired => {
                let is_recorded = again.values().any(|text| text.contains("\"repaired: "));
                let rows = difference(reference, &again, |part| part.ends_with("_data.csv"));
                rows + if is_recorded { "" } else { "the sidecar does not say that the rows were repaired" }
            }
            Again::Session => disk::faults_of_ended(&scene.path().join("open"), 0, &self.planned).join("; "),
        };
        if wrong.is_empty() { None } else { fails(format!("the next run: {wrong}; {}", again[STDERR])) }
    }
}

/// How these parts of two outcomes differ; empty if they do not.
fn difference(expected: &Outcome, found: &Outcome, is_of: impl Fn(&str) -> bool) -> String {
    let names: BTreeSet<&String> = expected.keys().chain(found.keys()).collect();
    let differ =
        names.into_iter().filter(|name| is_of(name)).filter_map(|name| match (expected.get(name), found.get(name)) {
            (None, _) => Some(format!("{name} is new")),
            (_, None) => Some(format!("{name} is missing")),
            (Some(expected), Some(found)) => (expected != found).then(|| format!("{name}: {}", lines(expected, found))),
        });
    differ.collect::<Vec<_>>().join("; ")
}

/// The first line that differs.
fn lines(expected: &str, found: &str) -> String {
    let mut pairs = expected.lines().map(Some).chain([None]).zip(found.lines().map(Some).chain([None]));
    let (expected, found) = pairs.find(|(expected, found)| expected != found).unwrap_or_default();
    let short = |line: Option<&str>| {
        line.map_or("the end".to_owned(), |line| format!("{:?}", line.chars().take(160).collect::<String>()))
    };
    format!("{} instead of {}", short(found), short(expected))
}

/// Injects this many faults, drawn from a seed, or all of them if there are fewer; returns their number, and every failure.
pub fn play(most: usize, seed: u64) -> (usize, Vec<String>) {
    let readings = Readings::new();
    let mut faults = readings.faults();
    if faults.len() > most {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        faults = (0..most).map(|_| faults[rng.next_u64() as usize % faults.len()].clone()).collect();
    }
    let wrong = faults.par_iter().filter_map(|(reader, fault)| readings.judge(*reader, fault)).collect();
    (faults.len(), wrong)
}
