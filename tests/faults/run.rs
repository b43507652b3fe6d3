//! The test sessions, and the programs that run one and report what they did.

use std::{
    io::Write as _,
    path::{Path, PathBuf},
    process::{Command, ExitStatus, Stdio},
    time::Duration,
};

use jiff::Timestamp;
use machband::{
    experiment::{Identity, Protocol, TrialRecord},
    store::{
        StoreError, definition,
        session::{Changes, Interrupted, SessionStore},
        sidecar::Sitting,
    },
};

use crate::common::{self, MACHBAND};

pub const SEED: u64 = 7;

/// Short sessions that differ in structure: one with an extra column and a color that needs quotes, one with
/// repetitions and no practice, one with a single trial, and one whose levels follow from the answers.
pub const DEFINITIONS: [&str; 4] = [
    "schema = 1\nname = \"small-one\"\ntitle = \"Small\"\n[stimulus]\nkind = \"mach-band\"\ncolor = \"1,0.5,0\"\n[factors]\nwidth = [0.1, 0.4]\ntanh_k = [5, 7.5]\n[design]\npractice = 2\n",
    "schema = 1\nname = \"twice\"\ntitle = \"Twice\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\ndepth = [1, \"inf\"]\norientation_deg = [0, 90]\n[design]\nrepetitions = 2\n",
    "schema = 1\nname = \"single\"\ntitle = \"Single\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [0.3]\n",
    "schema = 1\nname = \"adaptive\"\ntitle = \"Adaptive\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\norientation_deg = [0, 90]\n[design]\npractice = 1\n[task]\nkind = \"choice\"\nreference = { depth = \"inf\" }\n[adaptive]\nmethod = \"quest-plus\"\nparameter = \"width\"\nlevels = [0.01, 0.02, 0.04, 0.08, 0.16]\ntrials = 5\n",
];

pub fn protocol(index: usize) -> Protocol {
    definition::parse("definition.toml", DEFINITIONS[index]).unwrap()
}

pub fn identity() -> Identity {
    Identity::new("S001", "1").unwrap()
}

pub fn sitting() -> Sitting {
    Sitting { started_at: Timestamp::now().to_string(), ..Sitting::default() }
}

/// A row as it is in its file, without the newline.
pub fn line(row: &TrialRecord) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(row.cells()).unwrap();
    String::from_utf8(writer.into_inner().unwrap()).unwrap().trim_end().to_owned()
}

/// A program's exit status and output.
#[derive(Debug)]
pub struct ProgramResult {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

impl ProgramResult {
    /// True if the program was killed, or gave up because it had no memory.
    pub fn was_killed(&self) -> bool {
        matches!(std::os::unix::process::ExitStatusExt::signal(&self.status), Some(6 | 9))
    }
}

pub fn ended(command: &mut Command) -> ProgramResult {
    let output = command.stdin(Stdio::null()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    ProgramResult { status: output.status, stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// `machband simulate` with [`SEED`], so that the order of the trials is known, and with an observer that answers at once.
pub fn binary(definition: &Path, results: &Path, resume: bool) -> Command {
    let mut command = Command::new(MACHBAND);
    command.args(["simulate", "--observer", "paper", "--seed", &SEED.to_string()]);
    command.arg(definition).arg("--results").arg(results);
    if resume {
        command.arg("--resume");
    }
    command
}

/// Starts this test program again as a [`Child`] that runs a session.
pub fn child(definition: usize, results: &Path, elsewhere: &Path, resume: bool) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(["--ignored", "--exact", "session_for_the_other_tests", "--nocapture", "--test-threads=1"])
        .env("MACHBAND_CHILD", format!("{definition} {}", u8::from(resume)))
        .env("MACHBAND_CHILD_RESULTS", results)
        .env("MACHBAND_CHILD_ELSEWHERE", elsewhere);
    command
}

/// The report of a child process.
#[derive(Debug, Default)]
pub struct Report {
    /// The rows that it reported as saved, as they are in the file.
    pub rows: Vec<String>,
    /// The errors that it reported to the user.
    pub errors: Vec<String>,
    /// The last results folder, if it moved to another one.
    pub moved: Option<PathBuf>,
    /// Whether it completed the session.
    pub done: bool,
}

impl Report {
    pub fn read(stdout: &str) -> Self {
        let mut report = Self::default();
        for line in stdout.lines() {
            match line.split_once(' ') {
                Some(("@row", row)) => report.rows.push(row.to_owned()),
                Some(("@error", error)) => report.errors.push(error.to_owned()),
                Some(("@moved", to)) => report.moved = Some(to.into()),
                _ => report.done |= line == "@done",
            }
        }
        report
    }
}

fn print_line(line: &str) {
    let mut stdout = std::io::stdout().lock();
    // In one write, so that a reader never gets half a line.
    stdout.write_all(format!("{line}\n").as_bytes()).unwrap();
    stdout.flush().unwrap();
}

/// Creates the files of a session, or opens them.
fn begin(protocol: &Protocol, results: &Path, resume: bool) -> Result<(SessionStore, Interrupted), StoreError> {
    if resume {
        return SessionStore::resume(results, protocol, &identity(), Some(SEED), sitting(), Changes::Refuse);
    }
    SessionStore::create(results, protocol, &identity(), SEED, sitting())
}

/// Rates every remaining trial, until `record` returns an error. Returns the store and whether the session was
/// completed.
fn rate(
    (mut store, found): (SessionStore, Interrupted),
    mut record: impl FnMut(&mut SessionStore, &TrialRecord) -> Result<(), ()>,
) -> (SessionStore, bool) {
    let origin = Timestamp::now() - Duration::from_secs_f64(found.elapsed_s);
    let rated = common::answer(&found, &identity(), |context, response| {
        record(&mut store, &TrialRecord::new(context, response, origin + response.onset))
    });
    (store, rated.is_ok())
}

/// Writes a session that was interrupted after this many rows; returns these rows.
pub fn interrupted(definition: usize, results: &Path, rows: usize) -> Vec<String> {
    let protocol = protocol(definition);
    let mut lines = Vec::new();
    rate(begin(&protocol, results, false).unwrap(), |store, row| {
        if lines.len() == rows {
            return Err(());
        }
        store.append(row).unwrap();
        lines.push(line(row));
        Ok(())
    });
    lines
}

/// Writes a complete session with frames in which every rating was undone once and given again.
pub fn undone(definition: usize, results: &Path) {
    let protocol = protocol(definition);
    let (mut store, _) = rate(begin(&protocol, results, false).unwrap(), |store, row| {
        let (mut undone, mut again) = (row.clone(), row.clone());
        // Narrow bands are seen more clearly, but not in the last trial.
        again.rating.as_mut().unwrap().0 =
            [3, 0, 1, 2][usize::from(row.width > Some(0.2)) * 2 + usize::from(row.trial == 4)];
        undone.rating.as_mut().unwrap().0 = 3 - again.rating.unwrap().0;
        again.attempt += 1;
        again.row_id = format!("{}_{}", again.row_id.rsplit_once('_').unwrap().0, again.attempt);
        again.onset_s.0 += 0.01;
        again.started_at += Duration::from_millis(10);
        store.append(&undone).and_then(|()| store.append(&again)).map_err(drop)
    });
    let intervals = ["16667"; 8].join(" ");
    store.append_frames(&[format!("1,main,1,1,stimulus,16666.667,{intervals}\n")]);
    store.finish(true, Timestamp::UNIX_EPOCH.to_string(), None).unwrap();
}

/// A session that uses the store as the window does: it reports each row once it is on disk. After an error, it reports
/// the error, tries again, and then moves the session to another folder.
pub struct Child {
    definition: usize,
    results: PathBuf,
    elsewhere: PathBuf,
    resume: bool,
    /// Number of rows after which it waits for a line on stdin.
    wait_after: Option<usize>,
}

impl Child {
    /// The child that the environment variables describe; `None` if they are not set.
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

    /// Runs the session; returns whether it was completed.
    pub fn run(&self) -> bool {
        // The test harness has already begun a line.
        print_line("");
        let error = |error: StoreError| print_line(&format!("@error {error}"));
        let protocol = protocol(self.definition);
        let Ok(begun) = begin(&protocol, &self.results, self.resume).map_err(error) else { return false };
        let mut count = 0;
        let (mut store, rated) = rate(begun, |store, row| {
            if let Err(error) = store.append(row) {
                self.remedy(store, &error)?;
            }
            print_line(&format!("@row {}", line(row)));
            count += 1;
            if self.wait_after == Some(count) {
                print_line("@waiting");
                std::io::stdin().read_line(&mut String::new()).unwrap();
            }
            Ok(())
        });
        let ended =
            rated && (0..2).any(|_| store.finish(true, Timestamp::now().to_string(), None).map_err(error).is_ok());
        if ended {
            print_line("@done");
        }
        ended
    }

    /// Does what an experimenter would do: tries twice more, and then moves to another folder.
    fn remedy(&self, store: &mut SessionStore, error: &StoreError) -> Result<(), ()> {
        print_line(&format!("@error {error}"));
        for again in 0..4 {
            let tried = if again < 2 { store.retry() } else { store.continue_in(&self.elsewhere) };
            match tried {
                Ok(()) if again < 2 => return Ok(()),
                Ok(()) => {
                    print_line(&format!("@moved {}", self.elsewhere.display()));
                    return Ok(());
                }
                Err(error) => print_line(&format!("@error {error}")),
            }
        }
        Err(())
    }
}
