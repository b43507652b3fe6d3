//! Power cuts of a real file system: ext4 on a loop device. At a random moment of a session, the kernel shuts the file
//! system down without writing its journal. Mounting it again shows what a disk has after a power failure.

use std::{
    fs::{self, File},
    io::Read as _,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};

use crate::{
    disk,
    run::{self, Report},
    shim,
    sweep::Sweep,
};

/// The definition of the sessions; it has eight trials.
const DEFINITION: usize = 1;

fn tool(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    let why = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    if output.status.success() { Ok(()) } else { Err(format!("{command:?}: {} {why}", output.status)) }
}

/// A file system in a file. It is mounted until this is dropped.
struct FileSystem(tempfile::TempDir);

impl FileSystem {
    fn new() -> Result<Self, String> {
        let new = Self(tempfile::tempdir().unwrap());
        File::create(new.image()).unwrap().set_len(32 << 20).unwrap();
        fs::create_dir(new.root()).unwrap();
        tool(Command::new("mkfs.ext4").args(["-q", "-F"]).arg(new.image()))?;
        new.mount()?;
        Ok(new)
    }

    fn image(&self) -> PathBuf {
        self.0.path().join("image")
    }

    fn root(&self) -> PathBuf {
        self.0.path().join("root")
    }

    fn mount(&self) -> Result<(), String> {
        tool(Command::new("mount").args(["-o", "loop"]).arg(self.image()).arg(self.root()))
    }

    fn unmount(&self) -> Result<(), String> {
        tool(Command::new("umount").arg(self.root()))
    }

    fn cut_power(&self, library: &Path) -> Result<(), String> {
        tool(Command::new("true").env("LD_PRELOAD", library).env("MACHBAND_SHUTDOWN", self.root()))
    }
}

impl Drop for FileSystem {
    fn drop(&mut self) {
        let _ = self.unmount();
    }
}

/// Stops a process between two system calls. A sync that is in progress when the file system is shut down may report
/// success although the kernel drops it, for any program, which no power failure does.
fn stop(process: u32) {
    let _ = Command::new("kill").args(["-s", "STOP", &process.to_string()]).status();
    let is_running = |task: PathBuf| {
        fs::read_to_string(task.join("stat")).is_ok_and(|stat| ![") T", ") Z"].iter().any(|state| stat.contains(state)))
    };
    let tasks = || fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten().flatten();
    let patience = Instant::now();
    while tasks().any(|task| is_running(task.path())) && patience.elapsed() < Duration::from_secs(5) {
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Runs sessions and cuts the power during each; returns every failure, or why this system cannot do it.
pub fn play(sweep: &Sweep, cuts: u64, seed: u64) -> Result<Vec<String>, String> {
    let library = shim::library().ok_or("no library")?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let begun = Instant::now();
    session(sweep, library, None)?;
    let longest = begun.elapsed().as_micros() as u64;
    let mut wrong = Vec::new();
    for _ in 0..cuts {
        wrong.extend(session(sweep, library, Some(Duration::from_micros(rng.next_u64() % longest)))?);
    }
    Ok(wrong)
}

fn session(sweep: &Sweep, library: &Path, cut: Option<Duration>) -> Result<Vec<String>, String> {
    let file_system = FileSystem::new()?;
    let results = file_system.root().join("first");
    let mut command = run::child(DEFINITION, &results, &file_system.root().join("second"), false);
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut done = Ok(());
    if let Some(cut) = cut {
        std::thread::sleep(cut);
        stop(child.id());
        done = file_system.cut_power(library);
        child.kill().unwrap();
    }
    let mut said = String::new();
    child.stdout.take().unwrap().read_to_string(&mut said).unwrap();
    child.wait().unwrap();
    done?;
    if cut.is_none() {
        return Ok(Vec::new());
    }
    file_system.unmount()?;
    file_system.mount()?;
    let report = Report::read(&said);
    let lost = disk::lost(&disk::paths(&results, DEFINITION).csv, &report.rows);
    let unreadable = disk::unparsable(&file_system.root(), DEFINITION);
    let after = sweep.recovered(DEFINITION, &results, &report.rows);
    let wrong = [lost, unreadable, after].concat();
    Ok(wrong.into_iter().map(|what| format!("after {cut:?}: {what}")).collect())
}
