//! Runs the program on a virtual screen with a window manager, sends it keys, and reads the screen and the files.

use std::{
    collections::{BTreeSet, HashMap},
    ffi::OsString,
    fs::{self, File},
    io::{BufRead as _, BufReader, Write as _},
    os::unix::fs::{FileExt as _, PermissionsExt as _},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Output, Stdio},
    sync::{Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use machband::{light::CodeImage, store::image};
use x11rb::{
    connection::Connection as _,
    protocol::randr::{ConnectionExt as _, ModeInfo, Rotation},
    rust_connection::RustConnection,
    wrapper::ConnectionExt as _,
};

use super::common::{self, MACHBAND};

pub const SCREEN: (u16, u16) = (800, 600);
/// Longest wait for any event. It is long because a software renderer on a busy machine is slow.
const PATIENCE: Duration = Duration::from_secs(90);
/// Time between two checks of the screen.
const POLL: Duration = Duration::from_millis(15);
/// The uniform field of linear light 0.5 in yellow, sRGB.
const FIELD: [u8; 3] = [188, 188, 0];
/// Four main and two practice trials with a short recovery.
pub const SHORT_DEFINITION: &str = r#"schema = 1
name = "swift"
title = "A short session for tests"
[stimulus]
kind = "mach-band"
[factors]
width = [0.1, 0.8]
depth = [1, "inf"]
[design]
practice = 2
[recovery]
duration_s = 0.4
"#;
/// The recovery of [`SHORT_DEFINITION`].
pub const RECOVERY_S: f64 = 0.4;
/// The keys 0…3 of the number pad, by key code. Given their names, xdotool would toggle Num Lock between press and
/// release.
pub const NUMPAD_KEYS: [&str; 4] = ["90", "87", "88", "89"];

/// The key for the `i`-th rating, which is `i % 4`. Four keys from the top row alternate with four from the number pad.
pub fn pattern(i: usize) -> &'static str {
    ["0", "1", "2", "3", NUMPAD_KEYS[0], NUMPAD_KEYS[1], NUMPAD_KEYS[2], NUMPAD_KEYS[3]][i % 8]
}

pub type Row = HashMap<String, String>;

/// The complete rows of a result file; empty if there is no file.
pub fn rows(path: &Path) -> Vec<Row> {
    let text = fs::read_to_string(path).unwrap_or_default();
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    csv::Reader::from_reader(whole.as_bytes()).deserialize().map(Result::unwrap).collect()
}

/// The output of `machband check` for a file that must be valid.
pub fn checked(path: &Path) -> String {
    let output = common::machband(path.parent().unwrap(), &["check", path.to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
    common::text(&output.stdout)
}

/// Checks that every planned trial is in the file once, in the planned order, with the rating of [`pattern`].
pub fn assert_complete(csv: &Path, planned: &[Row]) {
    let found = rows(csv);
    let names = ["phase", "trial", "block", "repetition", "stimulus", "width", "depth", "orientation_deg", "color"];
    let trials = |rows: &[Row]| rows.iter().map(|row| names.map(|name| row[name].clone())).collect::<Vec<_>>();
    assert_eq!(trials(&found), trials(planned), "every planned trial once, in the planned order");
    let ids: BTreeSet<_> = found.iter().map(|row| &row["row_id"]).collect();
    assert_eq!(ids.len(), found.len(), "row_id repeats");
    for (i, row) in found.iter().enumerate() {
        assert_eq!(row["rating"], (i % 4).to_string(), "row {i}");
    }
    assert!(checked(csv).contains(&format!("{0} of {0} planned trials", planned.len())));
}

/// What the participant sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shown {
    /// Anything but a trial: a page, or no window yet.
    Page,
    /// The uniform field.
    Field,
    /// A stimulus on the field.
    Stimulus,
}

/// A virtual screen and the program on it. Dropping it ends the servers and the program.
pub struct Harness {
    pub dir: tempfile::TempDir,
    display: String,
    pub servers: Vec<Child>,
    window: Option<Child>,
    /// Extra environment variables for the program.
    pub environment: Vec<(&'static str, OsString)>,
    /// Only one test with a window runs at a time, because these tests check timing.
    _alone: MutexGuard<'static, ()>,
}

impl Harness {
    /// Starts the screen; if a required tool is missing, prints which one and returns `None`.
    pub fn new() -> Option<Self> {
        static ALONE: Mutex<()> = Mutex::new(());
        let path = std::env::var_os("PATH").unwrap_or_default();
        let is_missing = |tool: &&str| !std::env::split_paths(&path).any(|folder| folder.join(tool).is_file());
        let missing: Vec<_> = ["Xvfb", "openbox", "xdotool"].into_iter().filter(is_missing).collect();
        if !missing.is_empty() {
            let missing = missing.join(", ");
            common::skip("DISPLAY", &format!("a test of the window: {missing} not found"));
            return None;
        }
        if !crate::common::has_graphics() {
            return None;
        }
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        let dir = tempfile::tempdir().unwrap();
        for folder in ["screen", "runtime", "home"] {
            fs::create_dir(dir.path().join(folder)).unwrap();
        }
        fs::set_permissions(dir.path().join("runtime"), fs::Permissions::from_mode(0o700)).unwrap();
        let (display, servers, environment) = Default::default();
        let mut harness = Self { dir, display, servers, window: None, environment, _alone: alone };
        harness.start_servers();
        Some(harness)
    }

    /// Starts a session of [`SHORT_DEFINITION`]; also returns its planned rows and its file.
    pub fn with_session() -> Option<(Self, Vec<Row>, PathBuf)> {
        let mut harness = Self::new()?;
        let definition = harness.swift();
        let planned = harness.planned(&definition);
        harness.run(&definition, &["--seed", "7"]);
        let csv = harness.csv("swift");
        Some((harness, planned, csv))
    }

    pub fn start_servers(&mut self) {
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
        // The window manager is ready once it reports the number of desktops.
        self.until("openbox", |harness| {
            harness.command("xdotool").arg("get_num_desktops").output().unwrap().status.success()
        });
        // Num Lock is on, as on most keyboards with a number pad. The program does not depend on it.
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

    /// The output of the program in the window.
    pub fn stderr(&self) -> String {
        self.read_log("machband")
    }

    // -- files

    pub fn results(&self) -> String {
        self.dir.path().join("results").display().to_string()
    }

    pub fn definition(&self, name: &str, text: &str) -> String {
        let path = self.dir.path().join(format!("{name}.toml"));
        fs::write(&path, text).unwrap();
        path.display().to_string()
    }

    pub fn swift(&self) -> String {
        self.definition("swift", SHORT_DEFINITION)
    }

    pub fn csv(&self, experiment: &str) -> PathBuf {
        common::session_csv(&self.dir.path().join("results"), experiment, "S001")
    }

    pub fn sidecar(&self, experiment: &str) -> serde_json::Value {
        let text = fs::read(self.csv(experiment).with_extension("json")).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }

    /// The rows that a session of S001 with seed 7 will have; the answers will differ.
    pub fn planned(&self, experiment: &str) -> Vec<Row> {
        let output = self.machband(&["simulate", experiment, "--seed", "7", "--results", "planned"]);
        assert!(output.status.success(), "{output:?}");
        let name = Path::new(experiment).file_stem().unwrap().to_str().unwrap();
        rows(&common::session_csv(&self.dir.path().join("planned"), name, "S001"))
    }

    // -- the program

    pub fn machband(&self, arguments: &[&str]) -> Output {
        self.command(MACHBAND).args(arguments).output().unwrap()
    }

    /// Starts the window with a session of S001.
    pub fn run(&mut self, experiment: &str, arguments: &[&str]) {
        let results = self.results();
        let session = ["run", experiment, "--participant", "S001", "--results", &results];
        self.start(&[&session[..], arguments].concat());
    }

    /// Starts the window with these arguments, once the previous window has disappeared from the screen. Otherwise its
    /// last stimulus could be taken for one that accepts keys.
    pub fn start(&mut self, arguments: &[&str]) {
        self.until("the previous window to disappear", |harness| harness.shown() == Shown::Page);
        let window = self
            .command(MACHBAND)
            .args(arguments)
            .envs(self.environment.iter().cloned())
            .stdout(self.log("machband"))
            .stderr(self.log("machband"))
            .spawn()
            .unwrap();
        self.window = Some(window);
    }

    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.window.as_mut().and_then(|window| window.try_wait().unwrap())
    }

    pub fn kill(&mut self) {
        let mut window = self.window.take().unwrap();
        window.kill().unwrap();
        window.wait().unwrap();
    }

    /// Sends the program a signal such as `TERM`.
    pub fn signal(&self, name: &str) {
        let program = self.window.as_ref().unwrap().id().to_string();
        assert!(Command::new("kill").args(["-s", name, &program]).status().unwrap().success());
    }

    pub fn wait_for_end(&mut self) -> ExitStatus {
        self.end_with(None)
    }

    /// Waits for the program to end and meanwhile presses `key` repeatedly.
    fn end_with(&mut self, key: Option<&str>) -> ExitStatus {
        let (start, mut pressed) = (Instant::now(), Instant::now());
        loop {
            if let Some(status) = self.ended() {
                self.window = None;
                return status;
            }
            assert!(start.elapsed() < PATIENCE, "the program does not end: {}", self.stderr());
            if let Some(key) = key.filter(|_| pressed.elapsed() > Duration::from_millis(300)) {
                self.press(key);
                pressed = Instant::now();
            }
            std::thread::sleep(POLL);
        }
    }

    /// Waits until the session is complete, and leaves its last page.
    pub fn complete(&mut self, experiment: &str) {
        self.until("the sidecar to say complete", |harness| {
            let sidecar = harness.sidecar(experiment);
            sidecar["sittings"].as_array().and_then(|all| all.last()).is_some_and(|last| last["complete"] == true)
        });
        self.until("the last page", |harness| harness.shown() == Shown::Page);
        assert!(self.end_with(Some("Return")).success());
    }

    // -- keys

    pub fn xdotool(&self, arguments: &[&str]) {
        let output = self.command("xdotool").args(arguments).output().unwrap();
        assert!(output.status.success() && output.stderr.is_empty(), "xdotool {arguments:?}: {output:?}");
    }

    /// What xdotool prints; empty if it fails, as when there is no such window.
    pub fn ask(&self, arguments: &[&str]) -> String {
        common::text(&self.command("xdotool").args(arguments).output().unwrap().stdout).trim().to_owned()
    }

    pub fn press(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    /// Presses Space on the current page and later ones until a stimulus appears. Space only continues, so it can be
    /// pressed repeatedly.
    pub fn stimulus(&mut self) {
        let mut pressed = Instant::now();
        self.until("a stimulus", |harness| {
            let shown = harness.shown();
            if shown == Shown::Page && pressed.elapsed() > Duration::from_millis(250) {
                harness.press("space");
                pressed = Instant::now();
            }
            shown == Shown::Stimulus
        });
    }

    /// Leaves the pause page; a single press of Space must be enough.
    pub fn resume(&mut self) {
        self.press("space");
        self.until("the end of the pause", |harness| harness.shown() != Shown::Page);
    }

    /// Waits for a stimulus, presses the key, and waits for the row and for the stimulus to disappear.
    pub fn rate(&mut self, csv: &Path, key: &str) {
        self.stimulus();
        let before = rows(csv).len();
        self.press(key);
        self.until(&format!("row {} after {key}", before + 1), |_| rows(csv).len() == before + 1);
        self.until("the stimulus to disappear", |harness| harness.shown() != Shown::Stimulus);
    }

    // -- the screen

    /// Waits until a condition holds; `what` describes it for the error message.
    pub fn until(&mut self, what: &str, is_so: impl FnMut(&mut Self) -> bool) {
        self.until_for(PATIENCE, what, is_so);
    }

    pub fn until_for(&mut self, patience: Duration, what: &str, mut is_so: impl FnMut(&mut Self) -> bool) {
        let start = Instant::now();
        while !is_so(self) {
            if let Some(status) = self.ended() {
                panic!("the program ended ({status}) while waiting for {what}: {}", self.stderr());
            }
            assert!(
                start.elapsed() < patience,
                "waited {patience:?} for {what}; the screen shows {:?}, the keys go to {:?}; stderr: {}",
                self.shown(),
                self.ask(&["getwindowfocus", "getwindowname"]),
                self.stderr()
            );
            std::thread::sleep(POLL);
        }
    }

    /// Waits until the screen has not changed for a while.
    pub fn at_rest(&mut self) {
        let mut last = Vec::new();
        let mut since = Instant::now();
        self.until("the screen to stop changing", |harness| {
            let now = harness.screen();
            if now != last {
                last = now;
                since = Instant::now();
            }
            since.elapsed() > Duration::from_millis(1200)
        });
    }

    /// The screen's memory, including the cursor, as an X window dump with 32 bits per pixel, blue first; and the
    /// offset of the pixels. The header has the same length for every screen of this server.
    fn memory(&self) -> (File, u64) {
        let file = File::open(self.dir.path().join("screen/Xvfb_screen0")).unwrap();
        let mut header = [0; 80];
        file.read_exact_at(&mut header, 0).unwrap();
        let word = |i: usize| u32::from_be_bytes(header[4 * i..4 * i + 4].try_into().unwrap());
        let (width, height) = (u32::from(SCREEN.0), u32::from(SCREEN.1));
        let found = [word(4), word(5), word(7), word(11), word(12)];
        assert_eq!(found, [width, height, 0, 32, 4 * width], "an unknown frame buffer");
        (file, u64::from(word(0) + 12 * word(19)))
    }

    /// The whole screen, four bytes per pixel.
    pub fn screen(&self) -> Vec<u8> {
        let (file, start) = self.memory();
        let mut pixels = vec![0; 4 * usize::from(SCREEN.0) * usize::from(SCREEN.1)];
        file.read_exact_at(&mut pixels, start).unwrap();
        pixels
    }

    pub fn shown(&self) -> Shown {
        let (file, start) = self.memory();
        let color = |(x, y): (u16, u16)| {
            let mut bgrx = [0; 4];
            let index = u64::from(y) * u64::from(SCREEN.0) + u64::from(x);
            file.read_exact_at(&mut bgrx, start + 4 * index).unwrap();
            [bgrx[2], bgrx[1], bgrx[0]]
        };
        // For a centered stimulus of 331 pixels, these points are on the plateaus at any width and orientation.
        let (x, y) = (SCREEN.0 / 2, SCREEN.1 / 2);
        let inside = [(x - 160, y - 160), (x + 160, y - 160), (x - 160, y + 160), (x + 160, y + 160)].map(color);
        let is_yellow = |[red, green, blue]: [u8; 3]| red == green && red > 0 && blue == 0;
        if [(4, 4), (SCREEN.0 - 5, 4)].map(color) != [FIELD; 2] {
            Shown::Page
        } else if inside == [FIELD; 4] {
            Shown::Field
        } else if inside.into_iter().all(is_yellow) {
            Shown::Stimulus
        } else {
            // The server is still copying the first field after a page. A key would be too early.
            Shown::Page
        }
    }

    /// The image that `machband stimulus` writes with these settings.
    pub fn image<'a>(&self, size: u32, settings: impl IntoIterator<Item = (&'a str, &'a str)>) -> CodeImage {
        let mut arguments = ["stimulus", "--force", "--out=stimulus.png"].map(str::to_owned).to_vec();
        arguments.push(format!("--size={size}"));
        let settings = settings.into_iter();
        arguments.extend(settings.map(|(name, value)| format!("--{}={value}", name.trim_end_matches("_deg"))));
        let output = self.machband(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(output.status.success(), "{output:?}");
        image::read_picture(&self.dir.path().join("stimulus.png"), None, image::MAX_PIXELS).unwrap().codes
    }

    /// Checks that the screen shows, byte for byte, the image that `machband stimulus` writes, on a uniform field.
    pub fn compare_with_image(&self, row: &Row, size: u32) {
        let names = ["width", "depth", "orientation_deg", "low", "high", "color"];
        let expected = self.image(size, names.map(|name| (name, &*row[name])));
        let (width, height) = (u32::from(SCREEN.0), u32::from(SCREEN.1));
        let (x0, y0) = ((width - size) / 2, (height - size) / 2);
        let screen = self.screen();
        let wrong = screen.chunks_exact(4).zip(0..).filter(|(bgrx, i)| {
            let (x, y) = ((i % width).wrapping_sub(x0), (i / width).wrapping_sub(y0));
            let inside = x < size && y < size;
            let expected = if inside { expected.pixel(x, y).map(|code| code as u8) } else { FIELD };
            [bgrx[2], bgrx[1], bgrx[0]] != expected
        });
        assert_eq!(wrong.count(), 0, "pixels that differ from the image or the field, {row:?}");
    }

    fn connect(&self) -> (RustConnection, u32) {
        let (x, number) = x11rb::connect(Some(&self.display)).unwrap();
        let root = x.setup().roots[number].root;
        (x, root)
    }

    /// Changes the size or refresh rate of the screen, as if another monitor were connected. `clock` is in pixels per
    /// second; 0 selects the server's initial mode.
    pub fn set_mode(&self, (width, height): (u16, u16), clock: u32) {
        let (x, root) = self.connect();
        let resources = x.randr_get_screen_resources(root).unwrap().reply().unwrap();
        let (crtc, output) = (resources.crtcs[0], resources.outputs[0]);
        let is_wanted = |mode: &&ModeInfo| (mode.width, mode.height, mode.dot_clock) == (width, height, clock);
        let mode = resources.modes.iter().find(is_wanted).map(|mode| mode.id).unwrap_or_else(|| {
            let name = format!("{width}x{height}-{clock}");
            let (htotal, vtotal, name_len) = (width, height, name.len() as u16);
            let info = ModeInfo { width, height, dot_clock: clock, htotal, vtotal, name_len, ..ModeInfo::default() };
            let mode = x.randr_create_mode(root, info, name.as_bytes()).unwrap().reply().unwrap().mode;
            x.randr_add_output_mode(output, mode).unwrap().check().unwrap();
            mode
        });
        let set_size = || {
            let [mm_w, mm_h] = [width, height].map(|side| u32::from(side) * 254 / 960);
            x.randr_set_screen_size(root, width, height, mm_w, mm_h).unwrap().check().unwrap();
        };
        let set_crtc = || {
            let (time, turned) = (x11rb::CURRENT_TIME, Rotation::ROTATE0);
            x.randr_set_crtc_config(crtc, time, time, 0, 0, mode, turned, &[output]).unwrap().reply().unwrap();
        };
        // The mode must fit on the screen at every moment.
        if (width, height) == SCREEN {
            set_size();
            set_crtc();
        } else {
            set_crtc();
            set_size();
        }
        x.sync().unwrap();
    }

    /// Sets the graphics card's gamma ramps: straight, but with blue dimmed to a share of its light, as a night light
    /// does.
    pub fn set_ramps(&self, blue: f64) {
        let (x, root) = self.connect();
        let crtc = x.randr_get_screen_resources(root).unwrap().reply().unwrap().crtcs[0];
        let last = x.randr_get_crtc_gamma_size(crtc).unwrap().reply().unwrap().size - 1;
        let ramp = |share: f64| -> Vec<u16> {
            (0..=last).map(|i| (f64::from(i) / f64::from(last) * share * 65_535.0).round() as u16).collect()
        };
        x.randr_set_crtc_gamma(crtc, &ramp(1.0), &ramp(1.0), &ramp(blue)).unwrap().check().unwrap();
        x.sync().unwrap();
    }
}

impl Drop for Harness {
    fn drop(&mut self) {
        if std::thread::panicking() && !self.display.is_empty() {
            // If ImageMagick is installed, take a picture of the screen at the failure.
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
