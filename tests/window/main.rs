//! The real window, on a virtual screen, driven by real keys.
//!
//! Each test starts its own Xvfb and openbox and ends them. Nothing waits for a fixed time where it can look: at the
//! result file for rows, and at the screen itself, which Xvfb keeps in a mapped file.
//!
//! Needs `Xvfb`, `openbox`, `xdotool` and ImageMagick's `import`. Where one is missing the tests say `SKIPPED` and
//! pass, unless `MACHBAND_REQUIRE_DISPLAY=1`.

#![cfg(feature = "window")]
#![cfg(target_os = "linux")]

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    fs::{self, File},
    io::{BufRead as _, BufReader, Write as _},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Output, Stdio},
    sync::{Mutex, MutexGuard},
    time::{Duration, Instant},
};

#[path = "../faults/build.rs"]
mod build;
mod faults;

const MACHBAND: &str = env!("CARGO_BIN_EXE_machband");
const SCREEN: (usize, usize) = (1280, 1024);
/// Longest wait for anything: a software renderer on a busy machine is slow.
const PATIENCE: Duration = Duration::from_secs(90);
/// Between two looks.
const GLANCE: Duration = Duration::from_millis(15);
/// The uniform field of linear light 0.5 in yellow, sRGB.
const FIELD: [u8; 3] = [188, 188, 0];
/// Eight main and two practice trials with a short recovery.
const SWIFT: &str = r#"schema = 1
name = "swift"
title = "A short session for tests"
[stimulus]
kind = "mach-band"
[factors]
width = [0.1, 0.8]
depth = [1, "inf"]
orientation_deg = [0, 90]
[design]
practice = 2
[recovery]
duration_s = 0.5
"#;

/// Half a refresh at 60 Hz, the rate of the test's screen.
const HALF_REFRESH_S: f64 = 1.0 / 120.0;

// ---------------------------------------------------------------------------------------------------------------
// The tests

/// A whole session of the built-in `quick`, and what is on the screen meanwhile.
#[test]
fn a_full_session_records_every_key_and_shows_the_exact_stimulus() {
    let Some(mut harness) = Harness::new() else { return };
    let planned = harness.planned("quick", 7);
    assert_eq!(planned.len(), 28);
    harness.run("quick", &["--participant", "S001", "--session", "1", "--seed", "7"]);
    let csv = harness.csv("quick");
    let mut size = 0;
    let mut looked_at = BTreeSet::new();
    for (i, row) in planned.iter().enumerate() {
        harness.stimulus();
        if size == 0 {
            size = harness.sidecar("quick")["sittings"][0]["viewing"]["stimulus_px"].as_u64().unwrap() as usize;
        }
        let look = (row["orientation_deg"].clone(), row["depth"].clone());
        if row["phase"] == "main" && looked_at.insert(look) {
            harness.compare_with_image(row, size);
        }
        harness.rate(&csv, pattern(i));
    }
    assert_eq!(looked_at.len(), 6, "two orientations, three depths");
    harness.until("the sidecar to say complete", |harness| harness.sidecar("quick")["complete"] == true);
    let status = harness.close_at_end();
    assert!(status.success(), "{status}");

    let rows = rows(&csv);
    assert_planned_once(&rows, &planned);
    // Held to the nearest refresh.
    let definition_recovery = 2.0 - HALF_REFRESH_S;
    let mut earliest = 0.0;
    for (i, row) in rows.iter().enumerate() {
        let seconds = |name: &str| row[name].parse::<f64>().unwrap_or_else(|_| panic!("{name} of row {i}: {row:?}"));
        assert_eq!(row["rating"], (i % 4).to_string(), "row {i}");
        assert_eq!((&*row["subject_id"], &*row["session_id"], &*row["attempt"]), ("S001", "1", "1"));
        assert!(seconds("recovery_s") >= definition_recovery, "row {i}: recovery {}", row["recovery_s"]);
        assert!(seconds("recovery_s") < definition_recovery + 10.0, "row {i}: recovery {}", row["recovery_s"]);
        assert!((0.0..60.0).contains(&seconds("response_time_s")), "row {i}: {}", row["response_time_s"]);
        assert!(seconds("response_time_s") > 0.0);
        // Rounded to a tenth of a millisecond each.
        assert!(seconds("onset_s") >= earliest - 0.001, "row {i}: onset {} before {earliest}", row["onset_s"]);
        earliest = seconds("onset_s") + seconds("response_time_s") + definition_recovery;
        assert!(seconds("frames") >= 1.0, "row {i}");
    }
    assert!(checked(&csv).contains("28 of 28 planned trials"));
    // Every picture that was on the screen is rendered again, and is the same.
    let proved = Command::new(MACHBAND).arg("verify").arg(csv.parent().unwrap()).output().unwrap();
    let said = String::from_utf8_lossy(&proved.stdout).into_owned() + &String::from_utf8_lossy(&proved.stderr);
    assert!(proved.status.success() && said.contains("24 pictures rendered again; as it was recorded"), "{said}");
}

/// Backspace gives a second attempt; Esc holds the trial and Space brings it back.
#[test]
fn answers_can_be_taken_back_and_sessions_paused() {
    let Some((mut harness, planned, csv)) = Harness::with_session() else { return };
    harness.rate(&csv, "0");
    harness.rate(&csv, "1");
    // The third trial: paused while the stimulus is up. It comes again after a new recovery, and counts once.
    harness.stimulus();
    harness.press("Escape");
    harness.until("the pause page", |harness| harness.see() == Sight::Page);
    harness.press("2");
    harness.press("BackSpace");
    harness.resume();
    harness.until("the field after the pause", |harness| harness.see() == Sight::Field);
    assert_eq!(rows(&csv).len(), 2, "a key on the pause page must not rate or take back");
    harness.rate(&csv, "2");
    // Paused in the recovery, where nothing is lost either.
    harness.press("Escape");
    harness.until("the pause page", |harness| harness.see() == Sight::Page);
    harness.resume();
    harness.rate(&csv, "3");
    // Taken back: the same trial again, as a second attempt.
    harness.press("BackSpace");
    harness.rate(&csv, PAD[0]);
    // Twice Backspace takes back one answer only: the one before has been looked at with another in mind.
    harness.rate(&csv, "1");
    harness.press("BackSpace");
    harness.press("BackSpace");
    harness.rate(&csv, "2");
    for _ in 0..planned.len() - 5 {
        harness.rate(&csv, "3");
    }
    // The last one can be taken back too, while the field stands.
    harness.press("BackSpace");
    harness.rate(&csv, "0");
    harness.complete("swift");

    let rows = rows(&csv);
    let mut attempts: BTreeMap<(String, u32), Vec<(String, String)>> = BTreeMap::new();
    for row in &rows {
        let key = (row["phase"].clone(), row["trial"].parse().unwrap());
        attempts.entry(key).or_default().push((row["attempt"].clone(), row["rating"].clone()));
    }
    assert_eq!(attempts.len(), planned.len(), "every planned trial is rated");
    let of = |phase: &str, trial| attempts[&(phase.to_owned(), trial)].clone();
    let pair = |attempt: &str, rating: &str| (attempt.to_owned(), rating.to_owned());
    assert_eq!(of("practice", 1), [pair("1", "0")]);
    assert_eq!(of("practice", 2), [pair("1", "1")]);
    assert_eq!(of("main", 1), [pair("1", "2")]);
    assert_eq!(of("main", 2), [pair("1", "3"), pair("2", "0")]);
    assert_eq!(of("main", 3), [pair("1", "1"), pair("2", "2")]);
    assert_eq!(of("main", 7), [pair("1", "3")]);
    assert_eq!(of("main", 8), [pair("1", "3"), pair("2", "0")]);
    for row in &rows {
        assert!(row["recovery_s"].parse::<f64>().unwrap() >= 0.5 - HALF_REFRESH_S, "{row:?}");
    }
    assert!(checked(&csv).contains("10 of 10 planned trials"));
}

/// A key may mean something else when it is released than when it was pressed: the number pad when Num Lock is switched
/// meanwhile, the digits of a Czech keyboard when Shift goes up first. The next press of that digit counts all the same.
#[test]
fn a_key_that_changes_its_meaning_while_held_is_not_lost_the_next_time() {
    let Some(mut harness) = Harness::new() else { return };
    let definition = harness.swift();
    harness.run(&definition, &["--participant", "S001", "--seed", "7"]);
    let csv = harness.csv("swift");
    harness.rate(&csv, "2");
    harness.stimulus();
    for (action, key) in [("keydown", PAD[1]), ("key", "Num_Lock"), ("keyup", PAD[1])] {
        harness.xdotool(&[action, key]);
    }
    harness.until("the row of the number pad", |_| rows(&csv).len() == 2);
    harness.until("the stimulus to go", |harness| harness.see() != Sight::Stimulus);
    harness.stimulus();
    harness.press("1");
    harness.until_for(Duration::from_secs(15), "the row of the same digit", |_| rows(&csv).len() == 3);
    let ratings: Vec<_> = rows(&csv).iter().map(|row| row["rating"].clone()).collect();
    assert_eq!(ratings, ["2", "1", "1"]);
}

/// The process is killed twice, once while it waits and once while it writes: `--resume` asks exactly what is missing.
#[test]
fn a_killed_session_resumes_without_loss() {
    let Some((mut harness, planned, csv)) = Harness::with_session() else { return };
    for i in 0..3 {
        harness.rate(&csv, pattern(i));
    }
    harness.stimulus();
    harness.kill();
    assert_eq!(rows(&csv).len(), 3);
    checked(&csv);

    // An existing session is not overwritten.
    let definition = harness.swift();
    let refused = harness.machband(&["run", &definition, "--participant", "S001", "--results", &harness.results()]);
    assert_eq!(refused.status.code(), Some(1), "{refused:?}");

    harness.run(&definition, &["--participant", "S001", "--resume"]);
    harness.rate(&csv, pattern(3));
    harness.stimulus();
    harness.press(pattern(4));
    harness.kill();
    let done = rows(&csv).len();
    assert!((4..=5).contains(&done), "{done} rows");

    harness.run(&definition, &["--participant", "S001", "--resume"]);
    for i in done..planned.len() {
        harness.rate(&csv, pattern(i));
    }
    harness.complete("swift");
    let rows = rows(&csv);
    assert_planned_once(&rows, &planned);
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row["rating"], (i % 4).to_string(), "row {i}");
    }
    let onsets: Vec<f64> = rows.iter().map(|row| row["onset_s"].parse().unwrap()).collect();
    assert!(onsets.is_sorted(), "{onsets:?}");
    assert_eq!(harness.sidecar("swift")["sittings"].as_array().unwrap().len(), 3);
    assert!(checked(&csv).contains("10 of 10 planned trials"));
}

/// The results vanish in the middle: the window says so, keeps every answer and the window itself, and goes on when
/// they can be written again.
#[test]
fn a_lost_results_folder_loses_no_answer() {
    let Some((mut harness, planned, csv)) = Harness::with_session() else { return };
    for i in 0..4 {
        harness.rate(&csv, pattern(i));
    }
    harness.stimulus();
    let folder = harness.dir.path().join("results/swift");
    fs::remove_dir_all(&folder).unwrap();
    // Nor can it be made again, for now.
    fs::write(&folder, "in the way").unwrap();
    let trouble = Instant::now();
    harness.press(pattern(4));
    harness.until("the trouble page", |harness| harness.see() == Sight::Page);

    // Closing the window now would lose the answers: it stays.
    harness.press("alt+F4");
    let before = harness.screen();
    harness.press("Tab");
    harness.until("the focus on the button", |harness| harness.screen() != before);
    harness.press("Return");
    // Long enough to tell it from a recovery.
    std::thread::sleep(Duration::from_secs(3).saturating_sub(trouble.elapsed()) + Duration::from_secs(1));
    assert!(harness.ended().is_none(), "the window closed with an answer unsaved: {}", harness.said());
    assert_eq!(harness.see(), Sight::Page, "nothing can be written yet");

    fs::remove_file(&folder).unwrap();
    let over = Instant::now();
    let held = trouble.elapsed().as_secs_f64();
    harness.press("Return");
    harness.until("the rows to be back", |_| rows(&csv).len() == 5);
    harness.rate(&csv, pattern(5));
    let since = over.elapsed().as_secs_f64();
    for i in 6..planned.len() {
        harness.rate(&csv, pattern(i));
    }
    harness.complete("swift");
    let rows = rows(&csv);
    assert_planned_once(&rows, &planned);
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row["rating"], (i % 4).to_string(), "row {i}");
    }
    assert!(checked(&csv).contains("10 of 10 planned trials"));
    let recovery: f64 = rows[5]["recovery_s"].parse().unwrap();
    assert!(
        (0.5..since).contains(&recovery),
        "the eye recovers on the field, not on the page of the trouble: that stood {held:.1} s, the picture was rated {since:.1} s after it, recovery_s is {recovery}"
    );
}

/// A stimulus larger than the window is found before anything is recorded.
#[test]
fn a_window_too_small_for_the_stimulus_is_refused() {
    let Some(mut harness) = Harness::new() else { return };
    // At 50 cm and 96 pixels an inch 40° are 1376 pixels.
    let definition = harness.definition(
        "large",
        &SWIFT.replace("swift", "large").replace("[recovery]", "[viewing]\nwindow_deg = 40.0\n[recovery]"),
    );
    harness.run(&definition, &["--participant", "S001", "--seed", "7", "--windowed"]);
    harness.until("the window", |harness| harness.window_found());
    harness.at_rest();
    let findings = harness.screen();
    harness.press("space");
    harness.press("Return");
    harness.at_rest();
    assert!(!harness.csv("large").exists(), "a session began");
    assert!(harness.ended().is_none());
    assert!(harness.screen() == findings, "the page changed");
    // Esc leaves, with nothing written.
    harness.press("Escape");
    assert!(harness.wait_for_end().success());
    assert!(!harness.dir.path().join("results").exists());
}

/// Without a display the program says what to do, in one sentence; no display server is needed to see that.
#[test]
fn without_a_display_there_is_one_sentence() {
    let without = |display: Option<&str>, arguments: &[&str]| {
        let mut command = Command::new(MACHBAND);
        command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        if let Some(display) = display {
            command.env("DISPLAY", display);
        }
        command.output().unwrap()
    };
    let dir = tempfile::tempdir().unwrap();
    let results = dir.path().join("results").display().to_string();
    let run = ["run", "quick", "--participant", "S001", "--results", &results];
    for (display, arguments) in [(None, &[][..]), (None, &run), (Some(":987"), &[]), (Some(":987"), &run)] {
        let output = without(display, arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{display:?} {arguments:?}: {stderr}");
        assert!(output.stdout.is_empty(), "{display:?} {arguments:?}");
        let lines: Vec<_> = stderr.lines().collect();
        assert_eq!(lines.len(), 1, "{display:?} {arguments:?}: {stderr}");
        assert!(lines[0].starts_with("error: display: "), "{stderr}");
        assert!(lines[0].contains("machband simulate"), "{stderr}");
        assert!(!stderr.contains("panic"), "{stderr}");
    }
    assert!(!dir.path().join("results").exists());
}

/// The key for the `i`-th rating `i % 4`: four from the top row, four from the number pad, and so on.
fn pattern(i: usize) -> &'static str {
    ["0", "1", "2", "3", PAD[0], PAD[1], PAD[2], PAD[3]][i % 8]
}

/// The keys 0…3 of the number pad by their key codes: by name, xdotool would switch Num Lock with each of them, between
/// press and release.
const PAD: [&str; 4] = ["90", "87", "88", "89"];

// ---------------------------------------------------------------------------------------------------------------
// Result files

type Row = HashMap<String, String>;

/// The whole rows of a result file; none where there is no file.
fn rows(path: &Path) -> Vec<Row> {
    let text = fs::read_to_string(path).unwrap_or_default();
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    csv::Reader::from_reader(whole.as_bytes()).deserialize().map(Result::unwrap).collect()
}

/// What identifies a trial and its condition.
fn trial_of(row: &Row) -> Vec<String> {
    ["phase", "trial", "block", "repetition", "stimulus", "width", "depth", "orientation_deg", "low", "high", "color"]
        .map(|name| row[name].clone())
        .to_vec()
}

fn assert_planned_once(rows: &[Row], planned: &[Row]) {
    let trials = |rows: &[Row]| rows.iter().map(trial_of).collect::<Vec<_>>();
    assert_eq!(trials(rows), trials(planned), "every planned trial once, in the planned order");
    let ids: BTreeSet<_> = rows.iter().map(|row| &row["row_id"]).collect();
    assert_eq!(ids.len(), rows.len(), "row_id repeats");
}

/// What `machband check` says of a file that must be well.
fn checked(path: &Path) -> String {
    let output = Command::new(MACHBAND).arg("check").arg(path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

// ---------------------------------------------------------------------------------------------------------------
// The virtual screen

/// What the participant sees.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sight {
    /// Anything but a trial: a page, or no window yet.
    Page,
    /// The uniform field.
    Field,
    /// A stimulus on the field.
    Stimulus,
}

/// A screen with a window manager and the program on it; ends all of them when it goes.
struct Harness {
    dir: tempfile::TempDir,
    display: String,
    servers: Vec<Child>,
    window: Option<Child>,
    /// For the program, beside what every command here has.
    environment: Vec<(&'static str, std::ffi::OsString)>,
    /// One window at a time has the machine to itself: timing is what is tested.
    _alone: MutexGuard<'static, ()>,
}

impl Harness {
    /// `None`, and a word about it, where the tools are missing.
    fn new() -> Option<Self> {
        static ALONE: Mutex<()> = Mutex::new(());
        let path = std::env::var_os("PATH").unwrap_or_default();
        let missing: Vec<_> = ["Xvfb", "openbox", "xdotool", "import"]
            .into_iter()
            .filter(|tool| !std::env::split_paths(&path).any(|folder| folder.join(tool).is_file()))
            .collect();
        if !missing.is_empty() {
            let missing = missing.join(", ");
            assert!(std::env::var_os("MACHBAND_REQUIRE_DISPLAY").is_none_or(|v| v != "1"), "not installed: {missing}");
            // Not by eprintln, which the test harness keeps to itself.
            let _ = writeln!(std::io::stderr(), "SKIPPED: a test of the window, since {missing} cannot be found");
            return None;
        }
        let alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let dir = tempfile::tempdir().unwrap();
        for folder in ["screen", "runtime", "home"] {
            fs::create_dir(dir.path().join(folder)).unwrap();
        }
        let runtime = std::os::unix::fs::PermissionsExt::from_mode(0o700);
        fs::set_permissions(dir.path().join("runtime"), runtime).unwrap();
        let (display, servers, environment) = (String::new(), Vec::new(), Vec::new());
        let mut harness = Self { dir, display, servers, window: None, environment, _alone: alone };
        harness.start_servers();
        Some(harness)
    }

    /// With a session of [`SWIFT`] that has begun: its planned rows and its file.
    fn with_session() -> Option<(Self, Vec<Row>, PathBuf)> {
        let mut harness = Self::new()?;
        let definition = harness.swift();
        let planned = harness.planned(&definition, 7);
        harness.run(&definition, &["--participant", "S001", "--seed", "7"]);
        let csv = harness.csv("swift");
        Some((harness, planned, csv))
    }

    fn start_servers(&mut self) {
        let mut xvfb = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &format!("{}x{}x24", SCREEN.0, SCREEN.1)])
            .args(["-dpi", "96", "-noreset", "-nolisten", "tcp", "-fbdir"])
            .arg(self.dir.path().join("screen"))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(self.log("xvfb"))
            .spawn()
            .unwrap();
        let numbers = xvfb.stdout.take().unwrap();
        self.servers.push(xvfb);
        let mut number = String::new();
        BufReader::new(numbers).read_line(&mut number).unwrap();
        assert!(!number.trim().is_empty(), "Xvfb did not start: {}", self.read_log("xvfb"));
        self.display = format!(":{}", number.trim());
        let openbox = self.command("openbox").stdout(Stdio::null()).stderr(self.log("openbox")).spawn().unwrap();
        self.servers.push(openbox);
        // A window manager is there when it answers for its desktops.
        self.until("openbox", |harness| {
            harness.command("xdotool").arg("get_num_desktops").output().unwrap().status.success()
        });
        // As on most keyboards with a number pad; the program does not depend on it.
        self.press("Num_Lock");
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command
            .env("DISPLAY", &self.display)
            .env("HOME", self.dir.path().join("home"))
            .env("XDG_RUNTIME_DIR", self.dir.path().join("runtime"))
            .env("WINIT_X11_SCALE_FACTOR", "1")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .current_dir(self.dir.path())
            .stdin(Stdio::null());
        command
    }

    fn log(&self, name: &str) -> File {
        File::options().create(true).append(true).open(self.dir.path().join(name).with_extension("log")).unwrap()
    }

    fn read_log(&self, name: &str) -> String {
        fs::read_to_string(self.dir.path().join(name).with_extension("log")).unwrap_or_default()
    }

    /// What the window's process wrote.
    fn said(&self) -> String {
        self.read_log("machband")
    }

    // -- files

    fn results(&self) -> String {
        self.dir.path().join("results").display().to_string()
    }

    fn definition(&self, name: &str, text: &str) -> String {
        let path = self.dir.path().join(format!("{name}.toml"));
        fs::write(&path, text).unwrap();
        path.display().to_string()
    }

    fn swift(&self) -> String {
        self.definition("swift", SWIFT)
    }

    fn csv(&self, experiment: &str) -> PathBuf {
        self.dir.path().join(format!("results/{experiment}/data/subject-S001_session-1_task-{experiment}_data.csv"))
    }

    fn sidecar(&self, experiment: &str) -> serde_json::Value {
        let text = fs::read(self.csv(experiment).with_extension("json")).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }

    /// The rows that a session of S001 with this seed will have, but for the answers.
    fn planned(&self, experiment: &str, seed: u32) -> Vec<Row> {
        let folder = self.dir.path().join("planned");
        let seed = seed.to_string();
        let output =
            self.machband(&["simulate", experiment, "--seed", &seed, "--results", &folder.display().to_string()]);
        assert!(output.status.success(), "{output:?}");
        let name = Path::new(experiment).file_stem().unwrap().to_str().unwrap();
        rows(&folder.join(format!("{name}/data/subject-S001_session-1_task-{name}_data.csv")))
    }

    // -- the program

    fn machband(&self, arguments: &[&str]) -> Output {
        self.command(MACHBAND).args(arguments).output().unwrap()
    }

    fn run(&mut self, experiment: &str, arguments: &[&str]) {
        let window = self
            .command(MACHBAND)
            .args(["run", experiment, "--results", &self.results()])
            .args(arguments)
            .envs(self.environment.iter().cloned())
            .stdout(self.log("machband"))
            .stderr(self.log("machband"))
            .spawn()
            .unwrap();
        self.window = Some(window);
    }

    fn ended(&mut self) -> Option<ExitStatus> {
        self.window.as_mut().and_then(|window| window.try_wait().unwrap())
    }

    fn kill(&mut self) {
        let mut window = self.window.take().unwrap();
        window.kill().unwrap();
        window.wait().unwrap();
        self.until("the window to vanish", |harness| harness.see() == Sight::Page);
    }

    fn wait_for_end(&mut self) -> ExitStatus {
        let mut status = None;
        let start = Instant::now();
        while status.is_none() {
            assert!(start.elapsed() < PATIENCE, "the program does not end: {}", self.said());
            status = self.ended();
            std::thread::sleep(GLANCE);
        }
        self.window = None;
        status.unwrap()
    }

    /// From the last page out of the program.
    fn close_at_end(&mut self) -> ExitStatus {
        self.until("the last page", |harness| harness.see() == Sight::Page);
        self.at_rest();
        self.press("Return");
        self.wait_for_end()
    }

    /// Waits for a session to be complete, and leaves its last page.
    fn complete(&mut self, experiment: &str) {
        self.until("the sidecar to say complete", |harness| harness.sidecar(experiment)["complete"] == true);
        assert!(self.close_at_end().success());
    }

    // -- keys

    fn xdotool(&self, arguments: &[&str]) {
        let output = self.command("xdotool").args(arguments).output().unwrap();
        assert!(output.status.success() && output.stderr.is_empty(), "xdotool {arguments:?}: {output:?}");
    }

    fn press(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    fn window_found(&self) -> bool {
        self.command("xdotool")
            .args(["search", "--onlyvisible", "--name", "^machband$"])
            .output()
            .unwrap()
            .status
            .success()
    }

    /// Goes on, from whatever page there is, to a stimulus. Space does nothing but go on, so it can be pressed until
    /// it has had its effect.
    fn stimulus(&mut self) {
        let mut pressed = Instant::now();
        self.until("a stimulus", |harness| match harness.see() {
            Sight::Stimulus => true,
            Sight::Field => false,
            Sight::Page => {
                if pressed.elapsed() > Duration::from_millis(400) {
                    harness.press("space");
                    pressed = Instant::now();
                }
                false
            }
        });
    }

    /// Off the pause page: one Space must do.
    fn resume(&mut self) {
        self.press("space");
        self.until("the end of the pause", |harness| harness.see() != Sight::Page);
    }

    /// Waits for a stimulus, presses the key, waits for the row, and for the stimulus to go.
    fn rate(&mut self, csv: &Path, key: &str) {
        self.stimulus();
        let before = rows(csv).len();
        self.press(key);
        self.until(&format!("row {} after {key}", before + 1), |_| rows(csv).len() == before + 1);
        self.until("the stimulus to go", |harness| harness.see() != Sight::Stimulus);
    }

    // -- the screen

    /// Looks until something is so.
    fn until(&mut self, what: &str, so: impl FnMut(&mut Self) -> bool) {
        self.until_for(PATIENCE, what, so);
    }

    fn until_for(&mut self, patience: Duration, what: &str, mut so: impl FnMut(&mut Self) -> bool) {
        let start = Instant::now();
        while !so(self) {
            if let Some(status) = self.ended() {
                panic!("the program ended ({status}) while waiting for {what}: {}", self.said());
            }
            assert!(start.elapsed() < patience, "waited {patience:?} for {what}; stderr: {}", self.said());
            std::thread::sleep(GLANCE);
        }
    }

    /// Until nothing has moved on the screen for a while.
    fn at_rest(&mut self) {
        let mut last = Vec::new();
        let mut since = Instant::now();
        self.until("the screen to come to rest", |harness| {
            let now = harness.screen();
            if now != last {
                last = now;
                since = Instant::now();
            }
            since.elapsed() > Duration::from_secs(2)
        });
    }

    /// The screen as red, green, blue, cursor included: Xvfb's frame buffer, an X window dump of 32 bits a pixel.
    fn screen(&self) -> Vec<u8> {
        let dump = fs::read(self.dir.path().join("screen/Xvfb_screen0")).unwrap();
        let word = |i: usize| u32::from_be_bytes(dump[4 * i..4 * i + 4].try_into().unwrap()) as usize;
        let (header, width, height, stride, colors) = (word(0), word(4), word(5), word(12), word(19));
        assert_eq!((width, height, word(7), word(11)), (SCREEN.0, SCREEN.1, 0, 32), "an unknown frame buffer");
        dump[header + 12 * colors..]
            .chunks_exact(stride)
            .flat_map(|line| line[..4 * width].chunks_exact(4).flat_map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]]))
            .collect()
    }

    /// Takes a picture of the screen, to be looked at: where `MACHBAND_PICTURES` names a folder.
    fn keep_picture(&self, name: &str) {
        if let Some(folder) = std::env::var_os("MACHBAND_PICTURES") {
            let to = Path::new(&folder).join(name).with_extension("png");
            let _ = self.command("import").args(["-window", "root"]).arg(to).output();
        }
    }

    fn see(&self) -> Sight {
        let screen = self.screen();
        let at = |x: usize, y: usize| &screen[3 * (y * SCREEN.0 + x)..][..3];
        // Of a stimulus of 331 pixels in the centre, points on both plateaus of every width and orientation.
        let inside = [(480, 352), (800, 352), (480, 672), (800, 672)];
        if at(4, 4) != FIELD || at(SCREEN.0 - 5, 4) != FIELD {
            Sight::Page
        } else if inside.iter().all(|(x, y)| at(*x, *y) == FIELD) {
            Sight::Field
        } else {
            Sight::Stimulus
        }
    }

    /// What is on the screen is, byte for byte, the image that the program writes, on a uniform field.
    fn compare_with_image(&mut self, row: &Row, size: usize) {
        let shot = self.dir.path().join("shot.png");
        let output = self
            .command("import")
            .args(["-window", "root", "-depth", "8", &format!("PNG24:{}", shot.display())])
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        let image = self.dir.path().join("stimulus.png");
        let side = size.to_string();
        let path = image.display().to_string();
        let output = self.machband(&[
            "stimulus",
            "--width",
            &row["width"],
            "--depth",
            &row["depth"],
            "--orientation",
            &row["orientation_deg"],
            "--low",
            &row["low"],
            "--high",
            &row["high"],
            "--color",
            &row["color"],
            "--size",
            &side,
            "--out",
            &path,
        ]);
        assert!(output.status.success(), "{output:?}");
        let ((width, height), screen) = decode(&shot);
        assert_eq!((width, height), SCREEN);
        assert!(screen == self.screen(), "{row:?}: the screen's memory, cursor included, is not what was taken");
        let (square, stimulus) = decode(&image);
        assert_eq!(square, (size, size));
        let (x0, y0) = ((width - size) / 2, (height - size) / 2);
        let mut wrong = 0;
        for (i, pixel) in screen.chunks_exact(3).enumerate() {
            let (x, y) = (i % width, i / width);
            let inside = (x0..x0 + size).contains(&x) && (y0..y0 + size).contains(&y);
            let expected = if inside { &stimulus[3 * ((y - y0) * size + x - x0)..][..3] } else { &FIELD[..] };
            wrong += usize::from(pixel != expected);
        }
        assert_eq!(wrong, 0, "pixels that differ from the image or the field, {row:?}");
    }
}

impl Drop for Harness {
    fn drop(&mut self) {
        if std::thread::panicking() && !self.display.is_empty() {
            // Best effort: a picture of what went wrong.
            let test = std::thread::current().name().unwrap_or("window").to_owned();
            let shot = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{test}.png"));
            let _ = self.command("import").args(["-window", "root"]).arg(&shot).output();
            let _ = writeln!(std::io::stderr(), "the screen at the failure: {}", shot.display());
        }
        for child in self.window.iter_mut().chain(self.servers.iter_mut().rev()) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Size, and pixels as red, green, blue.
fn decode(path: &Path) -> ((usize, usize), Vec<u8>) {
    let mut decoder = png::Decoder::new(BufReader::new(File::open(path).unwrap()));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight), "{}", path.display());
    bytes.truncate(info.buffer_size());
    ((info.width as usize, info.height as usize), bytes)
}
