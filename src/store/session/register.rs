//! The register of a data set, `sessions.csv`: one line for each event in the life of a session, with the hashes of its
//! files at that time. It reveals deleted and exchanged sessions. Lines are only ever appended.

use std::{
    collections::BTreeMap,
    io::{BufReader, ErrorKind},
    path::Path,
};

use jiff::Timestamp;

use super::{
    dataset::{DATA_FILE, REGISTER},
    seal,
    sidecar::{Seal, Sidecar},
};
use crate::{
    store::{
        FileError, FileErrors, StoreError,
        file::append_line,
        open::open_regular,
        table::{self, CellError, shortened},
    },
    system::now,
};

const HEADER: &str = "at,event,data_file,definition_sha256,seed,data_bytes,data_sha256,sidecar_sha256";

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

    fn name(self) -> &'static str {
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
        table::each_line(&path.display().to_string(), BufReader::new(file), HEADER, |cells| {
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
        let listed = format!("{REGISTER} lists it as {}", entry.event.name());
        let mut errors = Vec::new();
        let mut expect = |path: &Path, what: &str, is: String, was: String| {
            if is != was {
                errors.push(FileError::whole(path, format!("{listed}, with {what} {was}; expected that, not {is}")));
            }
        };
        let path = csv.with_extension("json");
        expect(&path, "the definition", sidecar.definition_sha256.clone(), entry.definition_sha256.clone());
        expect(&path, "the seed", sidecar.seed.to_string(), entry.seed.to_string());
        let is = seal::sha256_of_first(csv, entry.data_bytes).unwrap_or_else(|why| format!("a file that {why}"));
        expect(csv, "sha256", is, entry.data_sha256.clone());
        // Another sitting may have followed that could not be listed.
        let sealed = |seal: &Seal| seal.sidecar_sha256 == entry.sidecar_sha256;
        let is_resumed = sidecar.sittings.iter().any(|sitting| sitting.seal.as_ref().is_some_and(sealed));
        if entry.event == Event::Ended && !is_resumed {
            let bytes = std::fs::metadata(csv).map_or(0, |metadata| metadata.len());
            expect(csv, "this number of bytes:", bytes.to_string(), entry.data_bytes.to_string());
            expect(&path, "sha256", sidecar.own_sha256(), entry.sidecar_sha256.clone());
        }
        (errors, None)
    }
}
