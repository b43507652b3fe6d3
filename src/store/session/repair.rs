//! Repairs a data file whose lines are damaged, so that its session can be resumed.

use std::{
    collections::HashSet,
    fmt,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use super::{
    dataset::{self, DAMAGED, identity, refuse_link},
    recorded::Order,
    results,
    sidecar::{REPAIRED, Sidecar},
};
use crate::{
    experiment::{Column, Course, Identity, Protocol, Replay, TrialRecord, columns},
    store::{
        FileErrors, StoreError,
        error::io,
        file::{put, sha256, sync_folder, write_whole},
        open::read_regular,
    },
};

/// The result of a repair.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Repaired {
    /// Numbers of the damaged lines, counted from 1.
    pub lines: Vec<usize>,
    /// The file to which they were moved; `None` if no line was damaged.
    pub moved_to: Option<PathBuf>,
    /// True if the header was damaged or gone and was written again.
    pub header_restored: bool,
    /// True if rows are missing although no line is damaged, and the sidecar did not say so.
    pub has_gaps: bool,
    /// The number of rows that are left, and the number that were sealed, if fewer are left.
    pub left: Option<(usize, usize)>,
}

/// Says what was done, and what is missing.
impl fmt::Display for Repaired {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.moved_to.as_ref().and_then(|path| path.file_name()).unwrap_or_default().to_string_lossy();
        let numbers = self.lines.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let moved = self.moved_to.as_ref().map(|_| format!("damaged lines were moved to {name}: {numbers}"));
        let header = self.header_restored.then(|| "the header was restored".to_owned());
        let gaps = self.has_gaps.then(|| "rows are missing before others".to_owned());
        let left = self.left.map(|(left, sealed)| format!("of the {sealed} rows that were sealed, {left} are left"));
        let none = (moved.is_none() && header.is_none()).then(|| "no line is damaged".to_owned());
        let all: Vec<String> = none.into_iter().chain(moved).chain(header).chain(gaps).chain(left).collect();
        f.write_str(&all.join("; "))
    }
}

/// Moves the damaged lines of a session's data file to a new file next to it: lines that cannot be read, and rows that
/// the definition and the seed do not plan or that repeat another row. A damaged header is replaced. Every byte is kept. The
/// sidecar records the repair, also that rows are missing, and the trials of the moved and the missing lines are shown again
/// when the session is resumed. The seals are not renewed.
///
/// # Errors
/// Another program is writing the session; the sidecar is missing or cannot be read; no row is planned, so the sidecar
/// belongs to another session; more than half of the lines would be moved; planned rows are not in the order of recording; a
/// link; I/O errors. The data file is not changed before the other file is on disk.
pub fn repair(csv: &Path) -> Result<Repaired, StoreError> {
    let (identity, dataset) = (identity(csv)?, dataset::of(csv)?);
    [csv, &csv.with_extension("json")]
        .into_iter()
        .chain(dataset.as_deref())
        .chain(csv.parent())
        .try_for_each(refuse_link)?;
    let (sidecar_path, mut sidecar, protocol) = Sidecar::of(csv)?;
    let columns = columns(&protocol);
    // This locks the file.
    let _locked = results::open(csv, &columns)?;
    let before = results::content(csv)?;
    let (mut repaired, damaged, kept) = sort(&before, (&protocol, &identity, &sidecar), &columns, csv)?;
    repaired.has_gaps &= repaired.lines.is_empty() && !sidecar.is_repaired();
    if kept == before && !repaired.has_gaps {
        return Ok(repaired);
    }
    repaired.moved_to = (!damaged.is_empty()).then(|| write_new(csv, &damaged)).transpose()?;
    let [was, is] = [&before, &kept].map(|content| sha256(content));
    record(format!("{REPAIRED}{repaired}; sha256 {was} before, {is} now"), &mut sidecar);
    // If the repair ends in the middle, it is recorded and can be repeated; rows must not disappear without a record.
    sidecar.write(&sidecar_path)?;
    if kept != before {
        write_whole(csv, &kept, true)?;
    }
    Ok(repaired)
}

/// Tells damaged lines from others. Returns what is to repair, the damaged lines, and the header with the other ones.
fn sort(
    content: &[u8],
    (protocol, identity, sidecar): (&Protocol, &Identity, &Sidecar),
    columns: &[Column],
    csv: &Path,
) -> Result<(Repaired, Vec<u8>, Vec<u8>), FileErrors> {
    let mismatch = |what: String| FileErrors::whole(csv, what);
    let seed = sidecar.seed;
    let course = Course::new(protocol, identity, seed).map_err(|error| mismatch(error.to_string()))?;
    let count = content.iter().filter(|byte| **byte == b'\n').count();
    let empty = content.windows(2).filter(|pair| *pair == b"\n\n").count();
    if 2 * empty > count {
        return Err(mismatch(format!("{empty} of {count} lines are empty; expected the rows of a session")));
    }
    let mut lines: Vec<&[u8]> = content.split_inclusive(|byte| *byte == b'\n').collect();
    let (header, header_restored) = match lines.first() {
        Some(first) if results::parse("", first, columns).is_ok() => (lines.remove(0).to_vec(), false),
        // The header is damaged or gone.
        _ => (results::header(columns), true),
    };
    let first = if header_restored { 1 } else { 2 };
    let rows: Vec<Option<TrialRecord>> = lines.iter().map(|line| row(&header, line, columns)).collect();
    let mut replay = Replay::new(identity, course);
    let (mut order, mut known, mut faults) = (Order::new(true, sidecar.sittings.len()), HashSet::new(), Vec::new());
    let mut found = Repaired { header_restored, ..Repaired::default() };
    // The last sitting that has a seal, which counts its rows and those of the sittings before it.
    let mut sittings = sidecar.sittings.iter().enumerate().rev();
    let sealed = sittings.find_map(|(index, sitting)| Some((index, sitting.seal.as_ref()?)));
    let mut left = 0;
    let (mut damaged, mut kept, mut planned) = (Vec::new(), header.clone(), 0);
    for ((line, row), number) in lines.iter().zip(&rows).zip(first..) {
        let row = row.as_ref().and_then(|row| Some((row, replay.row(row).ok()?)));
        planned += usize::from(row.is_some());
        let errors = row.as_ref().map_or_else(Vec::new, |(row, _)| order.errors(row));
        if let Some((row, replayed)) = row.as_ref().filter(|_| errors.is_empty()) {
            order.add(row);
            known.insert(&row.row_id);
            left += usize::from(sealed.is_some_and(|(index, _)| row.sitting as usize <= index + 1));
            found.has_gaps |= replayed.gap.is_some();
            kept.extend_from_slice(line);
        } else {
            found.lines.push(number);
            damaged.extend_from_slice(line);
            faults.extend(row.map(|(row, _)| row).zip(errors.into_iter().next()));
        }
    }
    // A row of which a copy is kept is only repeated.
    faults.retain(|(row, _)| !known.contains(&row.row_id));
    if let Some((_, first)) = faults.first() {
        return Err(mismatch(format!(
            "{} of {planned} planned rows are not in the order in which a session records them ({first}); expected rows as \
             recorded: sort them by sitting and onset_s, or take a copy of the file",
            faults.len()
        )));
    }
    if planned == 0 && rows.iter().any(Option::is_some) {
        let what = format!(
            "no row is planned by the definition and seed {seed} in its sidecar; expected the rows and the sidecar of one session"
        );
        return Err(mismatch(what));
    }
    found.left = sealed.map(|(_, seal)| (left, seal.data_rows)).filter(|(left, sealed)| left < sealed);
    // The beginning of a row that an interrupted write left does not count.
    let open = lines.last().filter(|last| !last.ends_with(b"\n")).map_or(0, |_| 1);
    let (moved, all) = (found.lines.len().saturating_sub(open), lines.len() - open);
    if 2 * moved > all {
        let what = "as if another program had saved the file; expected at most half of them";
        return Err(mismatch(format!("{moved} of {all} lines are damaged, {what}")));
    }
    Ok((found, damaged, kept))
}

/// Parses one line of a data file with this header; `None` if it is not a row.
fn row(header: &[u8], line: &[u8], columns: &[Column]) -> Option<TrialRecord> {
    if !line.ends_with(b"\n") || line.contains(&0) {
        return None;
    }
    results::parse("", &[header, line].concat(), columns).ok()?.pop()
}

/// Writes the damaged lines to the first `…_data.csv.damaged-N` that does not exist or already contains them.
fn write_new(csv: &Path, content: &[u8]) -> Result<PathBuf, StoreError> {
    let mut number = 1_u32;
    loop {
        let mut name = csv.file_name().unwrap_or_default().to_owned();
        name.push(format!("{DAMAGED}{number}"));
        let path = csv.with_file_name(name);
        match put(&path, content, true, false) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                // An earlier repair may have ended after this step.
                if read_regular(&path, results::MAX_FILE).map_err(io(&path, "read"))? == content {
                    return Ok(path);
                }
                number += 1;
            }
            written => {
                written.map_err(io(&path, "write"))?;
                return sync_folder(&path).map(|()| path);
            }
        }
    }
}

/// Adds the incident to the sidecar. The seals of the rows stay as they are, because a repair cannot know what the damaged
/// lines contained: if they were sealed, the user must accept the change.
fn record(incident: String, sidecar: &mut Sidecar) {
    let index = sidecar.sittings.len().saturating_sub(1);
    let own = sidecar.sha256_at_end_of(index);
    let Some(last) = sidecar.sittings.last_mut() else { return };
    let seal = last.seal.clone().filter(|seal| seal.sidecar_sha256 == own);
    last.complete = false;
    if last.incidents.last() != Some(&incident) {
        last.incidents.push(incident);
    }
    // The incident itself is not a manual change.
    seal.into_iter().for_each(|seal| sidecar.seal(index, seal));
}
