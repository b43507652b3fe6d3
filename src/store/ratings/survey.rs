//! What each file is, before its rows are read.

use std::path::{Path, PathBuf};

use super::{FileFault, Layout, Reading, discovery::whole, header::Header};
use crate::{
    experiment::{Protocol, columns_by_header},
    store::{StoreError, definition, sidecar::Sidecar},
};

/// Columns without which a file is no result file.
pub(super) const KEYS: [&str; 5] = ["subject_id", "session_id", "phase", "trial", "attempt"];

/// A file that may be read.
#[derive(Debug)]
pub(super) struct Surveyed {
    pub path: PathBuf,
    pub header: Header,
    pub layout: Layout,
    pub sidecar: Option<Sidecar>,
    pub protocol: Option<Protocol>,
}

impl Surveyed {
    /// Looks at a file; what is wrong with its sidecar does not keep its rows from being read.
    ///
    /// # Errors
    /// What is wrong with its head.
    pub fn new(path: &Path, how: &Reading) -> Result<(Self, Vec<FileFault>), FileFault> {
        let header = Header::read(path)?;
        let sidecar_path = path.with_extension("json");
        let layout = layout(&header, how, sidecar_path.is_file());
        let mut file = Self { path: path.to_owned(), header, layout, sidecar: None, protocol: None };
        let mut faults = Vec::new();
        if layout == Layout::Results {
            match Sidecar::read(&sidecar_path) {
                Ok(sidecar) => file.sidecar = sidecar,
                Err(StoreError::Faults(found)) => faults.extend(found.0),
                Err(error) => faults.push(whole(&sidecar_path, format!("cannot be read: {error}"))),
            }
            if let Some(sidecar) = &file.sidecar {
                match definition::from_json(&sidecar_path.display().to_string(), &sidecar.definition) {
                    Ok(protocol) => file.protocol = Some(protocol),
                    Err(found) => faults.extend(found.0),
                }
            }
        }
        Ok((file, faults))
    }

    /// The name in messages.
    pub fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// A fault of the header.
    pub fn fault(&self, column: usize, message: String) -> FileFault {
        FileFault { position: Some((1, column)), ..whole(&self.path, message) }
    }

    /// The experiment of the first row.
    pub fn experiment(&self) -> Option<&str> {
        if let Some(protocol) = &self.protocol {
            return Some(&protocol.name);
        }
        let index = self.header.position("experiment")?;
        self.header.first.as_ref()?.get(index).map(String::as_str)
    }

    /// The columns that are neither a record's own nor the response.
    pub fn further(&self, response: &str) -> Vec<&str> {
        let fixed = record_columns();
        (self.header.names.iter().map(String::as_str))
            .filter(|name| !name.is_empty() && *name != response && !fixed.iter().any(|fixed| fixed == name))
            .collect()
    }
}

/// The columns of every result file.
pub(super) fn record_columns() -> Vec<String> {
    columns_by_header(std::iter::empty()).into_iter().map(|column| column.name).collect()
}

/// What a file with this header is. One that lacks a single column of a result file is meant as one if it has a
/// sidecar or names of rows, or if nobody has said how else to read it.
fn layout(header: &Header, how: &Reading, sidecar: bool) -> Layout {
    let has = |name: &str| header.position(name).is_some();
    if how.count.as_deref().is_some_and(has) {
        return Layout::Counts;
    }
    let keys = KEYS.iter().filter(|key| has(if **key == "subject_id" { subject(how) } else { key })).count();
    if keys == KEYS.len() || (keys + 1 == KEYS.len() && (sidecar || has("row_id") || how.factors.is_none())) {
        Layout::Results
    } else if how.count.is_none() && has("count") {
        Layout::Counts
    } else {
        Layout::Long
    }
}

/// Name of the column of the subject.
pub(super) fn subject(how: &Reading) -> &str {
    how.subject.as_deref().unwrap_or("subject_id")
}

/// Name of the column of the response.
pub(super) fn response(how: &Reading) -> &str {
    how.response.as_deref().unwrap_or("rating")
}

/// Name of the column of the count.
pub(super) fn count(how: &Reading) -> &str {
    how.count.as_deref().unwrap_or("count")
}
