//! Power cuts. The library journals every change that a program makes. From the journal, the test simulates a disk that
//! loses unsynced changes at some moment. The content of a file that was last synced survives; later writes may survive
//! too, possibly torn. A name is certain only once its folder is synced, and later names may survive without earlier
//! ones.

use std::{
    collections::HashMap,
    fs,
    os::unix::fs::MetadataExt as _,
    path::{Path, PathBuf},
    process::Command,
};

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};
use rayon::prelude::*;

use crate::{
    common::{self, MACHBAND},
    disk, reads, run, shim,
    sweep::{self, Sweep},
};

/// One line of the journal. Files and folders are named by their inodes.
enum Change {
    Create {
        inode: u64,
        path: PathBuf,
        folder: bool,
    },
    Write {
        inode: u64,
        at: usize,
        bytes: Vec<u8>,
    },
    Truncate {
        inode: u64,
        length: usize,
    },
    Rename {
        from: PathBuf,
        to: PathBuf,
    },
    Remove(PathBuf),
    Sync(u64),
    /// The program reported this row as saved.
    Say(String),
}

impl Change {
    fn read(line: &str) -> Self {
        let parts: Vec<&str> = line.split('\t').collect();
        let number = |text: &str| text.parse().unwrap();
        match parts[..] {
            [what @ ("create" | "mkdir"), inode, path] => {
                Self::Create { inode: number(inode), path: path.into(), folder: what == "mkdir" }
            }
            ["write", inode, at, hex] => {
                let byte = |i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap();
                let bytes = (0..hex.len() / 2).map(byte).collect();
                Self::Write { inode: number(inode), at: number(at) as usize, bytes }
            }
            ["truncate", inode, length] => Self::Truncate { inode: number(inode), length: number(length) as usize },
            ["rename", from, to] => Self::Rename { from: from.into(), to: to.into() },
            ["remove", path] => Self::Remove(path.into()),
            ["sync", inode] => Self::Sync(number(inode)),
            ["say", row] => Self::Say(row.to_owned()),
            _ => panic!("an unknown line of the journal: {line}"),
        }
    }
}

/// The content of a file: what is certain, and the changes since.
#[derive(Clone, Default)]
struct Content {
    synced: Vec<u8>,
    since: Vec<(usize, Option<Vec<u8>>)>,
}

impl Content {
    /// The content after the first `count` changes since the last sync. With `torn`, the last of them is incomplete:
    /// half of its bytes are missing, or all are zero.
    fn after(&self, count: usize, torn: Option<bool>) -> Vec<u8> {
        let mut content = self.synced.clone();
        for (i, (at, bytes)) in self.since[..count].iter().enumerate() {
            let Some(bytes) = bytes else {
                content.resize(*at, 0);
                continue;
            };
            let last = i + 1 == count;
            let bytes = match torn.filter(|_| last) {
                None => bytes.clone(),
                Some(true) => vec![0; bytes.len()],
                Some(false) => bytes[..bytes.len() / 2].to_vec(),
            };
            content.resize(content.len().max(at + bytes.len()), 0);
            content[*at..at + bytes.len()].copy_from_slice(&bytes);
        }
        content
    }
}

/// The name of a file in a folder: the folder's inode and the name.
type Name = (u64, String);

/// A disk, including what would survive if the power failed now.
#[derive(Clone, Default)]
struct Disk {
    root: (PathBuf, u64),
    files: HashMap<u64, Content>,
    now: HashMap<Name, u64>,
    certain: HashMap<Name, u64>,
    /// Changes of names that are not certain yet. The changes in each entry happen together.
    pending: Vec<Vec<(Name, Option<u64>)>>,
}

impl Disk {
    /// The disk as it is, with everything synced.
    fn of(root: &Path) -> Self {
        let mut disk = Self { root: (root.to_owned(), fs::metadata(root).unwrap().ino()), ..Self::default() };
        let mut folders = vec![root.to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).unwrap() {
                let path = entry.unwrap().path();
                let inode = fs::metadata(&path).unwrap().ino();
                disk.now.insert(disk.name(&path).unwrap(), inode);
                if path.is_dir() {
                    folders.push(path);
                } else {
                    let synced = fs::read(&path).unwrap();
                    disk.files.insert(inode, Content { synced, since: Vec::new() });
                }
            }
        }
        disk.certain.clone_from(&disk.now);
        disk
    }

    fn inode(&self, path: &Path) -> Option<u64> {
        if path == self.root.0 {
            return Some(self.root.1);
        }
        self.now.get(&self.name(path)?).copied()
    }

    fn name(&self, path: &Path) -> Option<Name> {
        Some((self.inode(path.parent()?)?, path.file_name()?.to_str()?.to_owned()))
    }

    fn rename(&mut self, changes: Vec<(Name, Option<u64>)>) {
        set(&mut self.now, &changes);
        self.pending.push(changes);
    }

    fn apply(&mut self, change: &Change) {
        match change {
            Change::Create { inode, path, folder } => {
                if self.inode(path) == Some(*inode) {
                    return;
                }
                let Some(name) = self.name(path) else { return };
                if !folder {
                    self.files.insert(*inode, Content::default());
                }
                self.rename(vec![(name, Some(*inode))]);
            }
            Change::Write { inode, at, bytes } => {
                self.files.entry(*inode).or_default().since.push((*at, Some(bytes.clone())));
            }
            Change::Truncate { inode, length } => {
                self.files.entry(*inode).or_default().since.push((*length, None));
            }
            Change::Rename { from, to } => {
                let (Some(inode), Some(from), Some(to)) = (self.inode(from), self.name(from), self.name(to)) else {
                    return;
                };
                self.rename(vec![(from, None), (to, Some(inode))]);
            }
            Change::Remove(path) => {
                let Some(name) = self.name(path) else { return };
                self.rename(vec![(name, None)]);
            }
            Change::Sync(inode) => {
                if let Some(content) = self.files.get_mut(inode) {
                    content.synced = content.after(content.since.len(), None);
                    content.since.clear();
                }
                let touches = |changes: &mut Vec<(Name, Option<u64>)>| changes.iter().any(|((at, _), _)| at == inode);
                for changes in self.pending.extract_if(.., touches) {
                    set(&mut self.certain, &changes);
                }
            }
            Change::Say(_) => {}
        }
    }

    /// Writes what survives a power cut into a folder. A random part of the uncertain changes survives; without random
    /// numbers, none of them does.
    fn cut(&self, mut rng: Option<&mut ChaCha8Rng>, to: &Path) {
        let mut names = self.certain.clone();
        for changes in &self.pending {
            if rng.as_mut().is_some_and(|rng| rng.next_u64().is_multiple_of(2)) {
                set(&mut names, changes);
            }
        }
        let mut folders = vec![(self.root.1, to.to_owned())];
        while let Some((folder, path)) = folders.pop() {
            fs::create_dir_all(&path).unwrap();
            let mut entries: Vec<_> = names.iter().filter(|((at, _), _)| *at == folder).collect();
            entries.sort();
            for ((_, name), inode) in entries {
                let path = path.join(name);
                let Some(content) = self.files.get(inode) else {
                    folders.push((*inode, path));
                    continue;
                };
                let mut up_to = |most: usize| rng.as_mut().map_or(0, |rng| rng.next_u64() as usize % (most + 1));
                let count = up_to(content.since.len());
                let torn = [None, None, Some(true), Some(false)][up_to(3)];
                fs::write(path, content.after(count, torn)).unwrap();
            }
        }
    }
}

fn set(names: &mut HashMap<Name, u64>, changes: &[(Name, Option<u64>)]) {
    for (name, inode) in changes {
        match inode {
            Some(inode) => _ = names.insert(name.clone(), *inode),
            None => _ = names.remove(name),
        }
    }
}

/// A program that ran with a journal.
struct Recorded {
    name: String,
    folder: tempfile::TempDir,
    before: Disk,
    changes: Vec<Change>,
}

impl Recorded {
    /// Runs a program in a folder whose content is synced.
    fn run(name: String, folder: tempfile::TempDir, command: &mut Command) -> Self {
        let before = Disk::of(folder.path());
        let journal = tempfile::NamedTempFile::new().unwrap();
        command.env("MACHBAND_JOURNAL", journal.path());
        let (ended, _) = shim::run_with(command, &[], folder.path(), &journal.path().with_extension("log"));
        assert!(ended.status.success(), "{name}: {ended:?}");
        let text = fs::read_to_string(journal.path()).unwrap();
        let changes: Vec<_> = text.lines().map(Change::read).collect();
        assert!(!changes.is_empty(), "{name}: the journal is empty");
        Self { name, folder, before, changes }
    }

    /// The disk after this many changes.
    fn after(&self, count: usize) -> Disk {
        let mut disk = self.before.clone();
        self.changes[..count].iter().for_each(|change| disk.apply(change));
        disk
    }

    /// Cuts the power after the end and keeps only what is certain; returns the folder after the cut, and the number of
    /// changes before it.
    fn cut_at_end(&self) -> (tempfile::TempDir, usize) {
        let folder = sweep::folder();
        self.after(self.changes.len()).cut(None, folder.path());
        (folder, self.changes.len())
    }

    /// Cuts the power at a random moment or, in one of eight cases, after the end.
    fn cut(&self, rng: &mut ChaCha8Rng) -> (tempfile::TempDir, usize) {
        if rng.next_u64().is_multiple_of(8) {
            return self.cut_at_end();
        }
        let (folder, count) = (sweep::folder(), rng.next_u64() as usize % self.changes.len());
        self.after(count).cut(Some(rng), folder.path());
        (folder, count)
    }
}

/// Cuts the power `cuts` times, and returns every failure.
pub fn play(sweep: &Sweep, cuts: usize, seed: u64) -> Vec<String> {
    let sessions: Vec<_> = (0..run::DEFINITIONS.len()).flat_map(|i| [(i, 0), (i, 1)]).collect();
    let sessions: Vec<_> = sessions.into_iter().map(|(i, rows)| session(i, rows)).collect();
    let study = Study::new(sweep);
    let outputs: Vec<_> = OUTPUTS.iter().map(|line| study.output(line)).collect();
    let found = (0..cuts).into_par_iter().flat_map(|number| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(1_000_000 + number as u64);
        let which = number % (sessions.len() + outputs.len());
        let (recorded, wrong) = match sessions.get(which) {
            Some(session) => (session, session_after(sweep, session, which / 2, &mut rng)),
            None => {
                let output = &outputs[which - sessions.len()];
                (output, output_after(output, output.cut(&mut rng)))
            }
        };
        let name = &recorded.name;
        wrong.into_iter().map(|what| format!("cut {number}, {name}: {what}")).collect::<Vec<_>>()
    });
    let found: Vec<String> = found.collect();
    // Everything that a command wrote was synced before it ended, and so were the folders.
    outputs.iter().flat_map(|output| output_after(output, output.cut_at_end())).chain(found).collect()
}

/// A session, new or after some rows.
fn session(definition: usize, rows: usize) -> Recorded {
    let folder = sweep::folder();
    let results = folder.path().join("first");
    if rows > 0 {
        run::interrupted(definition, &results, rows.min(definition % 2 * rows));
    }
    let mut command = run::child(definition, &results, &folder.path().join("second"), rows > 0);
    Recorded::run("rows, sidecars".to_owned(), folder, &mut command)
}

/// Cuts the power during a session: no reported row is lost, every file can be read, and the session can be resumed and
/// verified.
fn session_after(sweep: &Sweep, recorded: &Recorded, definition: usize, rng: &mut ChaCha8Rng) -> Vec<String> {
    let (folder, count) = recorded.cut(rng);
    let results = folder.path().join("first");
    let said = |change: &Change| if let Change::Say(row) = change { Some(row.clone()) } else { None };
    let rows: Vec<String> = recorded.changes[..count].iter().filter_map(said).collect();
    let lost = disk::lost(&disk::paths(&results, definition).csv, &rows);
    let mut wrong = [lost, disk::unparsable(folder.path(), definition)].concat();
    wrong.extend(sweep.recovered(definition, &results, &rows));
    let verified = run::ended(Command::new(MACHBAND).arg("verify").arg(results.join(&run::protocol(definition).name)));
    if !verified.status.success() {
        wrong.push(format!("verify after {count} changes: {}{}", verified.stdout, verified.stderr));
    }
    wrong
}

/// Commands whose files are checked. IN is a folder with a study, OUT the folder for the files.
const OUTPUTS: &[&str] = &[
    "counts IN/results --out OUT/counts.csv",
    "analyze IN/results --out OUT/report --draws 99",
    "export IN/results --format bids --out OUT/bids",
    "export IN/results --format psych-ds --out OUT/psych-ds",
    "stimulus --size 64 --out OUT/stimulus.png --profile OUT/profile.csv",
    "stimuli IN/definition.toml --size 32 --out OUT/stimuli",
    "shade --size 64 --vertices 40 --shader phong --out OUT/shaded.png --metrics OUT/metrics.json",
    "predict IN/definition.toml --out OUT/predicted.csv",
    "plan quick --participants 2 --studies 1 --effect oblique=1 --out OUT/plan.csv",
    "calibrate IN/readings.csv --out OUT/profile.toml",
    "simulate IN/definition.toml --results OUT/results --participants 3",
];

/// A study for the commands to read.
struct Study(tempfile::TempDir);

impl Study {
    fn new(sweep: &Sweep) -> Self {
        let folder = sweep::folder();
        let definition = folder.path().join("definition.toml");
        fs::copy(sweep.definition(1), &definition).unwrap();
        let mut simulate = run::binary(&definition, &folder.path().join("results"), false);
        assert!(run::ended(simulate.args(["--participants", "4"])).status.success());
        let levels = (0..=8).map(|i| f64::from(i) / 8.0);
        let row = |level: f64| format!("gray,{level},{}\n", 0.1 + 100.0 * level.powf(2.2));
        let readings: String = levels.map(row).collect();
        fs::write(folder.path().join("readings.csv"), format!("channel,level,luminance_cd_m2\n{readings}")).unwrap();
        Self(folder)
    }

    fn output(&self, line: &str) -> Recorded {
        let folder = sweep::folder();
        let place = |path: &Path| path.display().to_string();
        let line = line.replace("IN/", &format!("{}/", place(self.0.path())));
        let line = line.replace("OUT/", &format!("{}/", place(folder.path())));
        let arguments = common::split(&line);
        Recorded::run(arguments[0].clone(), folder, Command::new(MACHBAND).args(arguments))
    }
}

/// Cuts the power during a command: every file under its final name is complete, and once the command has ended, all
/// files exist.
fn output_after(recorded: &Recorded, (folder, count): (tempfile::TempDir, usize)) -> Vec<String> {
    let files = |root: &Path| {
        let mut found = reads::files(root);
        found.retain(|(path, _)| !path.components().any(|part| part.as_os_str().to_string_lossy().ends_with(".tmp")));
        found
    };
    let (kept, whole) = (files(folder.path()), files(recorded.folder.path()));
    let mut wrong = Vec::new();
    for (path, content) in &kept {
        // Sessions in progress grow line by line.
        let is_growing = recorded.name == "simulate";
        if !is_growing && !whole.iter().any(|(name, expected)| name == path && expected == content) {
            wrong.push(format!("{} has {} bytes after {count} changes", path.display(), content.len()));
        }
    }
    let lost: Vec<_> = whole.iter().filter(|file| !kept.contains(file)).map(|(path, _)| path.display()).collect();
    // A file that was removed, such as a lock, may exist again.
    if count == recorded.changes.len() && !lost.is_empty() {
        wrong.push(format!("not whole after the end: {lost:?}"));
    }
    wrong
}
