//! Programs that run a session and tell what they did, and what such a session is.

use std::{
    io::Write as _,
    path::{Path, PathBuf},
    process::{Command, ExitStatus, Stdio},
    time::Duration,
};

use jiff::Timestamp;
use machband::{
    experiment::{
        FrameCount, Identity, OrderedLogit, Protocol, Resumed, RowContext, Schedule, Session, SessionOptions,
        TrialRecord, simulate,
    },
    store::{StoreError, definition, session::SessionStore, sidecar::Sitting},
};

pub const MACHBAND: &str = env!("CARGO_BIN_EXE_machband");
pub const SEED: u64 = 7;

/// Short sessions of different shape: a column of its own and a colour that needs quotes; repetitions and no practice;
/// one trial.
pub const DEFINITIONS: [&str; 3] = [
    "schema = 1\nname = \"small-one\"\ntitle = \"Small\"\n[stimulus]\nkind = \"mach-band\"\ncolor = \"1,0.5,0\"\n[factors]\nwidth = [0.1, 0.4]\ntanh_k = [5, 7.5]\n[design]\npractice = 2\n",
    "schema = 1\nname = \"twice\"\ntitle = \"Twice\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\ndepth = [1, \"inf\"]\norientation_deg = [0, 90]\n[design]\nrepetitions = 2\n",
    "schema = 1\nname = \"single\"\ntitle = \"Single\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [0.3]\n",
];

pub fn protocol(index: usize) -> Protocol {
    definition::parse("definition.toml", DEFINITIONS[index]).unwrap()
}

pub fn someone() -> Identity {
    Identity::new("S001", "1").unwrap()
}

pub fn sitting() -> Sitting {
    Sitting { started_at: Timestamp::now().to_string(), ..Sitting::default() }
}

/// A row as it is in its file, without the line's end.
pub fn line(row: &TrialRecord) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(row.cells()).unwrap();
    String::from_utf8(writer.into_inner().unwrap()).unwrap().trim_end().to_owned()
}

/// How a program ended, and what it said.
#[derive(Debug)]
pub struct Ended {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

impl Ended {
    pub fn was_killed(&self) -> bool {
        std::os::unix::process::ExitStatusExt::signal(&self.status) == Some(9)
    }
}

pub fn ended(command: &mut Command) -> Ended {
    let output = command.stdin(Stdio::null()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    Ended { status: output.status, stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// `machband simulate`, with a seed that gives the order of [`SEED`].
pub fn binary(definition: &Path, results: &Path, resume: bool) -> Command {
    let mut command = Command::new(MACHBAND);
    command.arg("simulate").arg(definition).args(["--seed", &SEED.to_string(), "--results"]).arg(results);
    if resume {
        command.arg("--resume");
    }
    command
}

/// This program once more as the [`session`] of a child.
pub fn child(definition: usize, results: &Path, elsewhere: &Path, resume: bool) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(["--ignored", "--exact", "a_session_for_the_faults", "--nocapture", "--test-threads=1"])
        .env("MACHBAND_CHILD", format!("{definition} {}", u8::from(resume)))
        .env("MACHBAND_CHILD_RESULTS", results)
        .env("MACHBAND_CHILD_ELSEWHERE", elsewhere);
    command
}

/// What a child said.
#[derive(Debug, Default)]
pub struct Said {
    /// Rows that it reported as recorded, as they are in the file.
    pub rows: Vec<String>,
    /// What it told its user to be wrong.
    pub errors: Vec<String>,
    /// The results folder that it had last, where it went elsewhere.
    pub moved: Option<PathBuf>,
    /// It ended well.
    pub done: bool,
}

impl Said {
    pub fn read(stdout: &str) -> Self {
        let mut said = Self::default();
        for line in stdout.lines() {
            match line.split_once(' ') {
                Some(("@row", row)) => said.rows.push(row.to_owned()),
                Some(("@error", error)) => said.errors.push(error.to_owned()),
                Some(("@moved", to)) => said.moved = Some(to.into()),
                _ => said.done |= line == "@done",
            }
        }
        said
    }
}

fn say(what: &str) {
    let mut stdout = std::io::stdout().lock();
    // In one piece: what the reader has got was said.
    stdout.write_all(format!("{what}\n").as_bytes()).unwrap();
    stdout.flush().unwrap();
}

/// A session as the window runs it: each row reported when it is on disk, each error told, then tried again, and then
/// moved to another folder.
pub struct Child {
    pub definition: usize,
    pub results: PathBuf,
    pub elsewhere: PathBuf,
    pub resume: bool,
    /// Rows before it waits for a line on stdin.
    pub wait_after: Option<usize>,
}

impl Child {
    /// As the environment says; `None` where it says nothing.
    pub fn from_environment() -> Option<Self> {
        let what = std::env::var("MACHBAND_CHILD").ok()?;
        let (definition, resume) = what.split_once(' ')?;
        Some(Self {
            definition: definition.parse().ok()?,
            resume: resume == "1",
            results: std::env::var_os("MACHBAND_CHILD_RESULTS")?.into(),
            elsewhere: std::env::var_os("MACHBAND_CHILD_ELSEWHERE")?.into(),
            wait_after: std::env::var("MACHBAND_CHILD_WAIT").ok().and_then(|rows| rows.parse().ok()),
        })
    }

    /// Runs the session; whether it ended well.
    pub fn run(&self) -> bool {
        // The test harness has begun a line.
        say("");
        let (protocol, identity) = (protocol(self.definition), someone());
        let begun = self.begin(&protocol, &identity);
        let (mut store, schedule, resumed, elapsed, sitting) = match begun {
            Ok(begun) => begun,
            Err(error) => {
                say(&format!("@error {error}"));
                return false;
            }
        };
        let origin = Timestamp::now() - elapsed;
        let options = SessionOptions { pages: 0, frames: FrameCount::Off };
        let mut session = Session::new(protocol.clone(), schedule.clone(), &resumed, options);
        let context = RowContext { protocol: &protocol, schedule: &schedule, identity: &identity, sitting };
        let mut count = 0;
        let rated: Result<(), ()> = simulate(&mut session, &OrderedLogit::default(), &identity, elapsed, |response| {
            let row = TrialRecord::new(&context, response, origin + response.onset);
            if let Err(error) = store.append(&row) {
                self.remedy(&mut store, error)?;
            }
            say(&format!("@row {}", line(&row)));
            count += 1;
            if self.wait_after == Some(count) {
                say("@waiting");
                std::io::stdin().read_line(&mut String::new()).unwrap();
            }
            Ok(())
        });
        if rated.is_err() {
            return false;
        }
        for _ in 0..2 {
            match store.finish(true, Timestamp::now().to_string(), None) {
                Ok(()) => {
                    say("@done");
                    return true;
                }
                Err(error) => say(&format!("@error {error}")),
            }
        }
        false
    }

    #[allow(clippy::type_complexity)]
    fn begin(
        &self,
        protocol: &Protocol,
        identity: &Identity,
    ) -> Result<(SessionStore, Schedule, Resumed, Duration, u32), StoreError> {
        if self.resume {
            let (store, found) = SessionStore::resume(&self.results, protocol, identity, Some(SEED), sitting())?;
            return Ok((store, found.schedule, found.resumed, Duration::from_secs_f64(found.elapsed_s), found.sitting));
        }
        let store = SessionStore::create(&self.results, protocol, identity, SEED, sitting())?;
        let schedule = Schedule::new(protocol, identity, SEED).unwrap();
        Ok((store, schedule, Resumed::default(), Duration::ZERO, 1))
    }

    /// What an experimenter does: once more, once more, and then elsewhere.
    fn remedy(&self, store: &mut SessionStore, error: StoreError) -> Result<(), ()> {
        say(&format!("@error {error}"));
        for again in 0..4 {
            let tried = if again < 2 { store.retry() } else { store.move_to(&self.elsewhere) };
            match tried {
                Ok(()) if again < 2 => return Ok(()),
                Ok(()) => {
                    say(&format!("@moved {}", self.elsewhere.display()));
                    return Ok(());
                }
                Err(error) => say(&format!("@error {error}")),
            }
        }
        Err(())
    }
}

/// A session that was left after so many rows, and these rows.
pub fn interrupted(definition: usize, results: &Path, rows: usize) -> Vec<String> {
    let (protocol, identity) = (protocol(definition), someone());
    let schedule = Schedule::new(&protocol, &identity, SEED).unwrap();
    let mut store = SessionStore::create(results, &protocol, &identity, SEED, sitting()).unwrap();
    let options = SessionOptions { pages: 0, frames: FrameCount::Off };
    let mut session = Session::new(protocol.clone(), schedule.clone(), &Resumed::default(), options);
    let context = RowContext { protocol: &protocol, schedule: &schedule, identity: &identity, sitting: 1 };
    let origin = Timestamp::now();
    let mut lines = Vec::new();
    // Left by refusing the row after the last.
    let _ = simulate(&mut session, &OrderedLogit::default(), &identity, Duration::ZERO, |response| {
        if lines.len() == rows {
            return Err(());
        }
        let row = TrialRecord::new(&context, response, origin + response.onset);
        store.append(&row).unwrap();
        lines.push(line(&row));
        Ok(())
    });
    lines
}
