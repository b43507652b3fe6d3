//! Recomputes a session from its rows: what each trial showed must follow from the definition, the seed and the answers
//! before it.

use super::{
    course::Course,
    participant::Identity,
    record::{RowContext, TrialRecord, columns},
    schedule::{Phase, Trial},
    task::{Answer, Pick, Presentation},
};

/// What a row records.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// Index into the trials of the schedule.
    pub trial: usize,
    /// What the trial showed.
    pub shown: Presentation,
    /// The answer.
    pub answer: Answer,
    /// Says that rows are missing before this one, or that what an adaptive method showed does not follow from them; both are
    /// as they must be if a repair removed rows.
    pub gap: Option<String>,
}

/// Recomputes a session from its rows, one after the other.
#[derive(Debug)]
pub struct Replay<'a> {
    identity: &'a Identity,
    /// The session after the rows so far.
    pub course: Course,
    /// The trial after the furthest one that has a row.
    next: usize,
}

impl<'a> Replay<'a> {
    /// Begins a session.
    pub fn new(identity: &'a Identity, course: Course) -> Self {
        Self { identity, course, next: 0 }
    }

    /// Takes the next row, and returns what it records.
    ///
    /// # Errors
    /// Returns a message if the schedule does not plan this trial, or if there is no such answer. The row then teaches an
    /// adaptive method nothing.
    pub fn row(&mut self, row: &TrialRecord) -> Result<Replayed, String> {
        let next = self.next;
        let replayed = self.recompute(row);
        if replayed.is_err() {
            // The row stands in the place of a trial, which is thus not missing as well.
            self.next = self.next.max(next + 1);
        }
        replayed
    }

    fn recompute(&mut self, row: &TrialRecord) -> Result<Replayed, String> {
        let protocol = self.course.protocol();
        let highest = protocol.response.highest();
        if let Some(rating) = row.rating.filter(|rating| row.answer.is_none() && rating.0 > highest) {
            return Err(format!("row {} has the rating {}; expected 0 to {highest}", row.row_id, rating.0));
        }
        let given = row.given(protocol).ok_or_else(|| {
            let response = row.answer.as_ref().map_or("", |answer| &answer.response);
            format!(
                "row {} has the response {response:?}; expected an answer of the task {}",
                row.row_id,
                protocol.task.name()
            )
        })?;
        if !row.leads_to(&given, protocol) {
            let path = row.answer.as_ref().and_then(|answer| answer.path.as_deref()).unwrap_or_default();
            return Err(format!(
                "row {} has the path {path:?}; expected the changes of the value in order, the last one to the response",
                row.row_id
            ));
        }
        // Practice trials come first, and each phase is numbered from 1.
        let practice = protocol.design.practice as usize;
        let before = if row.phase == Phase::Main { practice } else { 0 };
        let trials = &self.course.schedule().trials;
        let index = (before + row.trial as usize).checked_sub(1);
        let index = index.filter(|index| trials.get(*index).is_some_and(|trial| trial.phase == row.phase));
        let index = index.ok_or_else(|| self.unplanned(row, &format!("no {} trial {}", row.phase, row.trial)))?;
        self.course.take_back(index);
        let skipped = (self.next..index).find(|trial| !self.course.is_over(*trial));
        self.next = self.next.max(index + 1);
        let mut gap = skipped.map(|trial| {
            let Trial { phase, number, .. } = self.course.schedule().trials[trial];
            let id = &row.row_id;
            format!("row {id} has no row of {phase} trial {number} above it; expected a row of every earlier trial")
        });
        let is_over = self.course.is_over(index);
        let mut shown = self.course.presentation(index);
        if is_over || !self.shows(row, index, (&shown, &given)) {
            let level = row.answer.as_ref().and_then(|answer| answer.level);
            let possible = self.course.possible(index, level);
            let Some(found) = possible.iter().find(|shown| self.shows(row, index, (shown, &given))) else {
                return Err(self.difference(row, index, &given, &[&[shown][..], &possible].concat()));
            };
            gap.get_or_insert_with(|| {
                let expected = match shown.pick {
                    _ if is_over => "no further trial of its condition".to_owned(),
                    Pick::Level(level, None) => format!("the level {level}"),
                    Pick::Level(level, Some(second)) => format!("the level {level} with {second}"),
                    _ => "the most informative pair".to_owned(),
                };
                format!("row {} does not follow from the answers before it; expected {expected}", row.row_id)
            });
            shown.clone_from(found);
        }
        self.course.answer(index, &shown, &given);
        Ok(Replayed { trial: index, shown, answer: given, gap })
    }

    /// Returns whether a row is the one that a trial with this presentation and answer records.
    fn shows(&self, row: &TrialRecord, index: usize, trial: (&Presentation, &Answer)) -> bool {
        self.planned(row, index, trial) == *row
    }

    /// Returns the row that a trial with this presentation and answer records.
    fn planned(&self, row: &TrialRecord, index: usize, trial: (&Presentation, &Answer)) -> TrialRecord {
        let context = RowContext {
            protocol: self.course.protocol(),
            schedule: self.course.schedule(),
            identity: self.identity,
            sitting: row.sitting,
        };
        row.clone().of_trial(&context, index, row.attempt, trial)
    }

    /// Says in which cells a row differs from what is most like it of what its trial could show.
    fn difference(&self, row: &TrialRecord, index: usize, given: &Answer, possible: &[Presentation]) -> String {
        let (cells, columns) = (row.cells(), columns(self.course.protocol()));
        let differing = |shown: &Presentation| -> Vec<_> {
            let planned = self.planned(row, index, (shown, given)).cells();
            let all = columns.iter().zip(cells.iter().zip(planned));
            all.filter(|(_, (cell, planned))| *cell != planned)
                .map(|(column, (cell, is))| (&*column.name, cell, is))
                .collect()
        };
        let found = possible.iter().map(differing).min_by_key(Vec::len).unwrap_or_default();
        if let [("correct", cell, is)] = &found[..] {
            return format!("row {} has correct {cell:?}, which contradicts its response; expected {is:?}", row.row_id);
        }
        let all = found.iter().map(|(name, cell, is)| format!("{name} {is:?} instead of {cell:?}"));
        self.unplanned(row, &all.collect::<Vec<_>>().join(", "))
    }

    fn unplanned(&self, row: &TrialRecord, expected: &str) -> String {
        format!(
            "row {} is not planned by the definition and seed {}; expected {expected}",
            row.row_id,
            self.course.schedule().seed
        )
    }
}
