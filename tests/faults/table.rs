//! The table of faults and their effects.

use std::collections::BTreeMap;

use crate::shim::{Fault, Hit};

const COLUMNS: [&str; 9] = [
    "injected",
    "took effect",
    "sessions",
    "reported an error",
    "rows saved",
    "rows lost",
    "unreadable files",
    "silent failures",
    "resumed",
];

/// The counts of a session: column and number.
pub type Counts = Vec<(&'static str, usize)>;

/// One row for each kind of fault.
#[derive(Debug, Default)]
pub struct Table(BTreeMap<String, BTreeMap<&'static str, usize>>);

/// The name of a fault's row.
fn kind(fault: &Fault) -> String {
    let how = match fault.what {
        "kill-before" | "kill-after" | "kill-torn" => return format!("program killed at {}", fault.op),
        "EINTR" => "is interrupted by a signal",
        "short" => "is short",
        "end" => "ends early",
        "torn" => "is short, then fails",
        "lie" => "is short but reports success",
        "back" => "goes back an hour",
        _ if fault.op == "thread" => return "no thread can be created".to_owned(),
        _ if fault.op == "alloc" => return "memory is refused".to_owned(),
        _ if fault.repeated => "fails repeatedly",
        _ => "fails once",
    };
    format!("{} {how}", fault.op)
}

impl Table {
    /// Adds a session. Its counts go to the row of its first fault.
    pub fn add(&mut self, faults: &[Fault], hits: &[Hit], counts: Counts) {
        for fault in faults {
            let what = format!("{}{}", fault.what, if fault.repeated { "+" } else { "" });
            let struck = hits.iter().any(|hit| hit.op == fault.op && hit.what == what);
            self.line(&kind(fault), vec![("injected", 1), ("took effect", usize::from(struck))]);
        }
        self.line(&kind(&faults[0]), [counts, vec![("sessions", 1)]].concat());
    }

    /// Adds counts to a row.
    pub fn line(&mut self, name: &str, counts: Counts) {
        let line = self.0.entry(name.to_owned()).or_default();
        counts.into_iter().for_each(|(column, n)| *line.entry(column).or_default() += n);
    }

    pub fn total(&self, column: &str) -> usize {
        self.0.values().filter_map(|line| line.get(column)).sum()
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "| fault | {} |\n|---|{}", COLUMNS.join(" | "), "--:|".repeat(COLUMNS.len()))?;
        for (name, line) in &self.0 {
            let cells = COLUMNS.map(|column| line.get(column).copied().unwrap_or_default().to_string());
            writeln!(f, "| {name} | {} |", cells.join(" | "))?;
        }
        writeln!(f, "| all | {} |", COLUMNS.map(|column| self.total(column).to_string()).join(" | "))
    }
}
