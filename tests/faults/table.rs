//! The table: what was injected, and what came of it.

use std::collections::BTreeMap;

use crate::shim::{Fault, Hit};

/// What came of the sessions of one line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Line {
    pub injected: usize,
    pub hit: usize,
    pub sessions: usize,
    /// Sessions that showed their user an error.
    pub errors: usize,
    /// Rows reported as recorded.
    pub acknowledged: usize,
    pub lost: usize,
    pub unparsable: usize,
    pub silent: usize,
    /// Sessions that were resumed without a fault to the end of the plan.
    pub resumed: usize,
}

impl Line {
    fn add(&mut self, other: &Self) {
        self.injected += other.injected;
        self.hit += other.hit;
        self.sessions += other.sessions;
        self.errors += other.errors;
        self.acknowledged += other.acknowledged;
        self.lost += other.lost;
        self.unparsable += other.unparsable;
        self.silent += other.silent;
        self.resumed += other.resumed;
    }
}

/// One line for each kind of fault.
#[derive(Debug, Default)]
pub struct Table(BTreeMap<String, Line>);

/// What a fault is called.
fn kind(fault: &Fault) -> String {
    let how = match fault.what {
        "kill-before" | "kill-after" | "kill-torn" => return format!("program killed at {}", fault.op),
        "EINTR" => "is interrupted by a signal",
        "short" => "is short",
        "torn" => "is short, then fails",
        "lie" => "is short but reports success",
        "back" => "goes back an hour",
        _ if fault.lasting => "fails repeatedly",
        _ => "fails once",
    };
    format!("{} {how}", fault.op)
}

impl Table {
    /// A session: what came of it counts for the first of its faults.
    pub fn add(&mut self, faults: &[Fault], hits: &[Hit], line: Line) {
        for (i, fault) in faults.iter().enumerate() {
            let what = format!("{}{}", fault.what, if fault.lasting { "+" } else { "" });
            let hit = hits.iter().any(|hit| hit.op == fault.op && hit.what == what);
            let entry = self.0.entry(kind(fault)).or_default();
            entry.add(&Line { injected: 1, hit: usize::from(hit), ..Line::default() });
            if i == 0 {
                entry.add(&Line { sessions: 1, ..line });
            }
        }
    }

    /// A line of its own.
    pub fn line(&mut self, name: &str, line: Line) {
        self.0.entry(name.to_owned()).or_default().add(&line);
    }

    pub fn total(&self) -> Line {
        let mut total = Line::default();
        self.0.values().for_each(|line| total.add(line));
        total
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(
            f,
            "| fault | injected | took effect | sessions | reported an error | rows saved | rows lost | unreadable files | silent failures | resumed |"
        )?;
        writeln!(f, "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|")?;
        let total = ("all".to_owned(), self.total());
        for (name, line) in self.0.iter().chain([(&total.0, &total.1)]) {
            let Line { injected, hit, sessions, errors, acknowledged, lost, unparsable, silent, resumed } = line;
            writeln!(
                f,
                "| {name} | {injected} | {hit} | {sessions} | {errors} | {acknowledged} | {lost} | {unparsable} | {silent} | {resumed} |"
            )?;
        }
        Ok(())
    }
}
