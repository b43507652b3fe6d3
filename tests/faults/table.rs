//! The table: what was injected, and what came of it.

use std::collections::BTreeMap;

use crate::shim::{Fault, Hit};

/// The columns.
const COLUMNS: [&str; 9] = [
    "injected",
    "struck",
    "sessions",
    "showed an error",
    "rows reported",
    "rows lost",
    "files unparsable",
    "silent",
    "resumed",
];

/// What came of a session: columns and numbers.
pub type Counts = Vec<(&'static str, usize)>;

/// One line for each kind of fault.
#[derive(Debug, Default)]
pub struct Table(BTreeMap<String, BTreeMap<&'static str, usize>>);

/// What a fault is called.
fn kind(fault: &Fault) -> String {
    let how = match fault.what {
        "kill-before" | "kill-after" | "kill-torn" => "killed there",
        "EINTR" => "interrupted by a signal",
        "short" => "does half",
        "torn" => "does half, then fails",
        "lie" => "does half and says all",
        "back" => "goes back an hour",
        _ if fault.lasting => "fails from then on",
        _ => "fails once",
    };
    format!("{} {how}", fault.op)
}

impl Table {
    /// A session: what came of it counts for the first of its faults.
    pub fn add(&mut self, faults: &[Fault], hits: &[Hit], counts: Counts) {
        for fault in faults {
            let what = format!("{}{}", fault.what, if fault.lasting { "+" } else { "" });
            let struck = hits.iter().any(|hit| hit.op == fault.op && hit.what == what);
            self.line(&kind(fault), vec![("injected", 1), ("struck", usize::from(struck))]);
        }
        self.line(&kind(&faults[0]), [counts, vec![("sessions", 1)]].concat());
    }

    /// Adds to a line.
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
