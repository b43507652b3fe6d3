//! What is wrong with rows: of many alike the first ones are kept, the others counted.

use super::FileFault;

/// How many faults of a kind are kept of one file.
const KEPT: usize = 10;

/// Kinds of faults; those of one kind in one file are alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// A wrong number of cells.
    Cells,
    /// Not UTF-8.
    Text,
    /// The last row is cut.
    Torn,
    /// Another experiment.
    Experiment,
    /// No participant.
    Subject,
    /// No session.
    Session,
    /// Neither practice nor main.
    Phase,
    /// No number of a trial.
    Trial,
    /// No number of an attempt.
    Attempt,
    /// The row stands elsewhere already.
    Repeated,
    /// No rating, or not one of the scale.
    Rating,
    /// No count.
    Count,
    /// No repetition.
    Repetition,
    /// No response time.
    Time,
}

impl Kind {
    /// What many rows of a kind have in common.
    fn of_many(self) -> &'static str {
        match self {
            Self::Cells => "have a wrong number of cells",
            Self::Text => "are not UTF-8 text",
            Self::Torn => "are cut",
            Self::Experiment => "are of another experiment",
            Self::Subject => "name no participant",
            Self::Session => "name no session",
            Self::Phase => "are neither practice nor main",
            Self::Trial => "have no number of a trial",
            Self::Attempt => "have no number of an attempt",
            Self::Repeated => "stand elsewhere already",
            Self::Rating => "have no rating of the scale",
            Self::Count => "have no count",
            Self::Repetition => "have no number of a repetition",
            Self::Time => "have no response time",
        }
    }
}

/// Where a row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    /// Index of the file.
    pub file: u32,
    /// First byte of the row.
    pub offset: u64,
}

/// One faulty row.
#[derive(Clone, Debug)]
pub(super) struct RowFault {
    pub kind: Kind,
    /// Lines above the row in its part of the file.
    pub line: u64,
    /// Column from 1.
    pub column: usize,
    /// What is wrong; what is expected.
    pub message: String,
    /// Where the row stands already.
    pub first: Option<Place>,
}

/// The faulty rows of a file, or of a part of it.
#[derive(Clone, Debug, Default)]
pub(super) struct RowFaults {
    kept: Vec<RowFault>,
    /// All of each kind, kept or not.
    all: Vec<(Kind, u64)>,
}

impl RowFaults {
    /// How many of a kind there are.
    fn of(&mut self, kind: Kind) -> &mut u64 {
        let index = self.all.iter().position(|(known, _)| *known == kind).unwrap_or_else(|| {
            self.all.push((kind, 0));
            self.all.len() - 1
        });
        &mut self.all[index].1
    }

    /// Adds a fault; its words are asked for only if they are kept.
    pub fn add(&mut self, kind: Kind, fault: impl FnOnce() -> RowFault) {
        let n = self.of(kind);
        *n += 1;
        if *n <= KEPT as u64 {
            self.kept.push(fault());
        }
    }

    /// Adds those of the part that follows after so many lines.
    pub fn append(&mut self, later: Self, lines: u64) {
        for fault in later.kept {
            if self.kept.iter().filter(|known| known.kind == fault.kind).count() < KEPT {
                self.kept.push(RowFault { line: fault.line + lines, ..fault });
            }
        }
        for (kind, n) in later.all {
            *self.of(kind) += n;
        }
    }

    /// Takes out those that stand elsewhere already.
    pub fn without_repeated(&mut self) {
        self.kept.retain(|fault| fault.kind != Kind::Repeated);
        self.all.retain(|(kind, _)| *kind != Kind::Repeated);
    }

    /// In the words of a message, by line; `place` says where a row is.
    pub fn finish(mut self, file: &str, place: impl Fn(Place) -> String) -> Vec<FileFault> {
        self.kept.sort_by_key(|fault| (fault.line, fault.column));
        let fault = |position, message| FileFault { file: file.to_owned(), position, message };
        let kept = self.kept.iter().map(|row| {
            let message = row.first.map_or_else(|| row.message.clone(), |at| row.message.replace("{}", &place(at)));
            fault(Some((row.line as usize + 1, row.column)), message)
        });
        let more = self.all.iter().filter(|(_, n)| *n > KEPT as u64).map(|(kind, n)| {
            let more = n - KEPT as u64;
            fault(None, format!("{more} more rows {}; expected none", kind.of_many()))
        });
        kept.chain(more).collect()
    }
}
