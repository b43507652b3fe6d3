//! The register of a data set, `sessions.csv`: one line for each event in the life of a session, with the hashes of its
//! files at that time. It reveals deleted and exchanged sessions. Lines are only ever appended.

use std::{
    collections::{BTreeMap, HashSet},
    fs,
    io::{BufRead as _, BufReader, ErrorKind},
    path::Path,
};

use jiff::Timestamp;

use super::{
    dataset::{self, DATA_FILE, REGISTER, REGISTER_HEADER as HEADER},
    seal::{self, Difference},
    sidecar::{Seal, Sidecar},
};
use crate::{
    experiment::Protocol,
    store::{
        FileError, FileErrors, StoreError,
        file::append_line,
        open::open_regular,
        table::{self, CellError, shortened},
    },
    system::{entries, now},
};

/// What happened to a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event {
    Started,
    Resumed,
    Ended,
    Moved,
    Repaired,
}

impl Event {
    const ALL: [(Self, &str); 5] = [
        (Self::Started, "started"),
        (Self::Resumed, "resumed"),
        (Self::Ended, "ended"),
        (Self::Moved, "moved here"),
        (Self::Repaired, "repaired"),
    ];

    pub fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|(event, _)| *event == self).map_or("", |(_, name)| name)
    }
}

/// One line of the register.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub event: Event,
    /// Name of the data file.
    pub data_file: String,
    pub definition_sha256: String,
    pub seed: u64,
    /// Number of bytes of the data file.
    pub data_bytes: u64,
    pub data_sha256: String,
    /// [`Sidecar::own_sha256`].
    pub sidecar_sha256: String,
}

impl Entry {
    /// Creates the entry for a session whose files are as in `seal`.
    pub fn new(event: Event, csv: &Path, sidecar: &Sidecar, seal: Seal) -> Self {
        Self {
            event,
            data_file: csv.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            definition_sha256: sidecar.definition_sha256.clone(),
            seed: sidecar.seed,
            data_bytes: seal.data_bytes.unwrap_or_default(),
            data_sha256: seal.data_sha256,
            sidecar_sha256: seal.sidecar_sha256,
        }
    }

    /// Appends the entry to the register of a data set. It is on disk when this returns without an error.
    ///
    /// # Errors
    /// I/O errors; or the file is not a register.
    pub fn append(&self, dataset: &Path) -> Result<(), StoreError> {
        let Self { event, data_file, definition_sha256, seed, data_bytes, data_sha256, sidecar_sha256 } = self;
        let (at, event) = (format!("{:.3}", now()), event.name());
        let line =
            format!("{at},{event},{data_file},{definition_sha256},{seed},{data_bytes},{data_sha256},{sidecar_sha256}");
        append_line(&dataset.join(REGISTER), HEADER, &line)
    }

    /// Returns the differences between the files of a session and this event; without a sidecar, only those of the data
    /// file. After the end of a session, the files must be as they were; after any other event, the rows that were
    /// there must still be there.
    pub fn differences(&self, csv: &Path, sidecar: Option<&Sidecar>) -> Vec<Difference> {
        // A sitting that could not be listed may have followed.
        let sealed = |seal: &Seal| seal.sidecar_sha256 == self.sidecar_sha256;
        let is_resumed =
            |sidecar: &&Sidecar| sidecar.sittings.iter().any(|sitting| sitting.seal.as_ref().is_some_and(sealed));
        let ended = sidecar.filter(|sidecar| self.event == Event::Ended && !is_resumed(sidecar));
        let rows = seal::sha256_of(csv, ended.is_none().then_some(self.data_bytes));
        let mut compared = vec![(csv.to_owned(), rows, &self.data_sha256)];
        compared.extend(ended.map(|own| (csv.with_extension("json"), Ok(own.own_sha256()), &self.sidecar_sha256)));
        let sitting = sidecar.map_or(0, |sidecar| sidecar.sittings.len().saturating_sub(1));
        let (is_prefix, listed) = (ended.is_none(), Some(self.event.name()));
        // A session without rows may have lost its header; nothing is missing then.
        let is_short = || fs::metadata(csv).is_ok_and(|found| found.len() < self.data_bytes);
        let is_lost = |is: &Result<_, _>| is.is_err() && self.event == Event::Started && is_short();
        compared.retain(|(_, is, was)| is.as_ref() != Ok(*was) && !is_lost(is));
        let difference = |(path, is, was): (_, _, &String)| Difference {
            path,
            sitting,
            is_prefix,
            listed,
            was: Some(was.clone()),
            is,
        };
        compared.into_iter().map(difference).collect()
    }

    fn parse(cells: &[&str]) -> Result<Self, CellError> {
        let &[at, event, data_file, definition, seed, bytes, data, sidecar] = cells else {
            return Err((0, "the row is incomplete; expected 8 cells".to_owned()));
        };
        let wrong = |index: usize, expected: &str| {
            let name = HEADER.split(',').nth(index).unwrap_or_default();
            (index, format!("{name} is {:?}; expected {expected}", shortened(cells[index])))
        };
        at.parse::<Timestamp>().map_err(|_| wrong(0, "an RFC 3339 time"))?;
        let known = Event::ALL.into_iter().find(|(_, name)| *name == event);
        let (event, _) =
            known.ok_or_else(|| wrong(1, &format!("one of {}", Event::ALL.map(|(_, name)| name).join(", "))))?;
        let is_name = data_file.ends_with(DATA_FILE) && !data_file.contains(['/', '\\']);
        if !is_name {
            return Err(wrong(2, "the name of a data file"));
        }
        let hash = |index: usize, text: &str| match text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit()) {
            true => Ok(text.to_owned()),
            false => Err(wrong(index, "a SHA-256 of 64 hexadecimal digits")),
        };
        Ok(Self {
            event,
            data_file: data_file.to_owned(),
            definition_sha256: hash(3, definition)?,
            seed: seed.parse().map_err(|_| wrong(4, "a whole number"))?,
            data_bytes: bytes.parse().map_err(|_| wrong(5, "a number of bytes"))?,
            data_sha256: hash(6, data)?,
            sidecar_sha256: hash(7, sidecar)?,
        })
    }
}

/// The last event of every session in a data set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Register {
    last: BTreeMap<String, Entry>,
}

impl Register {
    /// Reads the register of a data set. If there is none, no session is listed.
    ///
    /// # Errors
    /// Reports every line that cannot be read, with its line and column.
    pub fn read(dataset: &Path) -> Result<Self, FileErrors> {
        Self::read_file(&dataset.join(REGISTER))
    }

    /// Reads a register, given its path.
    ///
    /// # Errors
    /// The same errors as [`Register::read`].
    pub(crate) fn read_file(path: &Path) -> Result<Self, FileErrors> {
        let mut register = Self::default();
        let file = match open_regular(path) {
            Ok(file) => file,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(register),
            Err(error) => {
                let message = format!("cannot be opened: {error}; expected the register of the sessions");
                return Err(FileErrors::whole(path, message));
            }
        };
        let mut reader = BufReader::new(file);
        // A power failure during the first event may leave the beginning of the header, or zero bytes.
        let is_begun = |head: &[u8]| head.len() > HEADER.len() && head.iter().any(|byte| *byte != 0);
        if reader.fill_buf().is_ok_and(|head| !is_begun(head)) {
            return Ok(register);
        }
        table::each_line(&path.display().to_string(), reader, HEADER, |cells| {
            let entry = Entry::parse(cells)?;
            register.last.insert(entry.data_file.clone(), entry);
            Ok(())
        })?;
        Ok(register)
    }

    /// Returns the number of sessions.
    pub fn count(&self) -> usize {
        self.last.len()
    }

    /// Returns the last event of the session with this data file.
    pub(super) fn last(&self, csv: &Path) -> Option<&Entry> {
        self.last.get(&*csv.file_name()?.to_string_lossy())
    }

    /// Reports every listed session of the data set whose data file is gone.
    pub fn missing(&self, dataset: &Path) -> Vec<FileError> {
        let data = dataset.join("data");
        let is_gone = |entry: &&Entry| !data.join(&entry.data_file).exists();
        let error = |entry: &Entry| {
            let message =
                format!("no longer exists, but {REGISTER} lists it as {}; expected the session", entry.event.name());
            FileError::whole(data.join(&entry.data_file), message)
        };
        self.last.values().filter(is_gone).map(error).collect()
    }

    /// Compares a session with its last event. Returns the differences, and a note if the session is not listed.
    pub(super) fn compare(&self, csv: &Path, sidecar: &Sidecar) -> (Vec<FileError>, Option<String>) {
        let Some(entry) = self.last(csv) else {
            let note = format!("not in {REGISTER}: copied here, or recorded by an earlier version");
            return (Vec::new(), Some(note));
        };
        let mut errors = Vec::new();
        let mut expect = |what: &str, is: &str, was: &str| {
            if is != was {
                let event = entry.event.name();
                let message = format!("{REGISTER} lists it as {event}, with {what} {was}; expected that, not {is}");
                errors.push(FileError::whole(csv.with_extension("json"), message));
            }
        };
        expect("the definition", &sidecar.definition_sha256, &entry.definition_sha256);
        expect("the seed", &sidecar.seed.to_string(), &entry.seed.to_string());
        errors.extend(entry.differences(csv, Some(sidecar)).iter().map(Difference::error));
        (errors, None)
    }
}

/// Returns an error for each file of a session that differs from what the session wrote, according to the seals in its
/// sidecar, and to the register if the last sitting has no seal.
pub fn errors(csv: &Path, sidecar: &Sidecar) -> Vec<FileError> {
    let found = seal::differences(csv, sidecar).into_iter().chain(unsealed_differences(csv, sidecar));
    found.map(|difference| difference.error()).collect()
}

/// Returns the differences between a session and the register of its data set, unless the last sitting has a seal.
/// Without one, only the register knows what the files were: whoever removes a seal could have changed the rows.
pub(super) fn unsealed_differences(csv: &Path, sidecar: &Sidecar) -> Vec<Difference> {
    let dataset = dataset::of(csv).filter(|_| sidecar.seal.is_none());
    let register = dataset.and_then(|dataset| Register::read(dataset).ok());
    let last = register.as_ref().and_then(|register| register.last(csv));
    last.map_or_else(Vec::new, |last| last.differences(csv, Some(sidecar)))
}

/// Returns the first of `P001`, `P002`, … that has no file in this experiment's results and never had a session there.
pub fn free_participant(results: &Path, protocol: &Protocol) -> String {
    let dataset = results.join(&protocol.name);
    let listed = Register::read(&dataset).unwrap_or_default().last.into_keys();
    let files = entries(&dataset.join("data")).unwrap_or_default();
    let names = files.iter().filter_map(|path| Some(path.file_name()?.to_str()?.to_owned())).chain(listed);
    let participant = |name: String| Some(name.strip_prefix("subject-")?.split('_').next()?.to_ascii_uppercase());
    let taken: HashSet<String> = names.filter_map(participant).collect();
    (1..).map(|number| format!("P{number:03}")).find(|id| !taken.contains(id)).unwrap_or_default()
}
