//! What is wrong with the rows of a file: of many alike the first ones are kept, the others counted.

use crate::store::FileFault;

/// How many faults in one column are kept of one file.
const KEPT: usize = 10;

/// What is wrong with a row.
#[derive(Clone, Debug)]
pub(super) struct RowFault {
    /// Index of the cell; none where it is the row as a whole.
    pub cell: Option<usize>,
    /// What is wrong; what is expected.
    pub message: String,
}

/// The faulty rows of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct RowFaults {
    kept: Vec<FileFault>,
    /// How many there are in each column, kept or not.
    cells: Vec<(Option<usize>, usize)>,
}

impl RowFaults {
    /// Adds a fault; its place is asked for only if it is kept.
    pub fn add(&mut self, file: &str, fault: RowFault, place: impl FnOnce() -> (usize, usize)) {
        let index = self.cells.iter().position(|(cell, _)| *cell == fault.cell).unwrap_or_else(|| {
            self.cells.push((fault.cell, 0));
            self.cells.len() - 1
        });
        self.cells[index].1 += 1;
        if self.cells[index].1 <= KEPT {
            self.kept.push(FileFault::at(file, place(), fault.message));
        }
    }

    /// Every fault that was kept, and how many more there are.
    pub fn finish(self, file: &str, columns: &[String]) -> Vec<FileFault> {
        let mut faults = self.kept;
        faults.sort_by_key(|fault| fault.position);
        for (cell, n) in self.cells.into_iter().filter(|(_, n)| *n > KEPT) {
            let of = cell.and_then(|cell| columns.get(cell)).map_or(String::new(), |name| format!(" in {name}"));
            faults.push(FileFault::whole(file, format!("{} more rows have a fault{of}; expected none", n - KEPT)));
        }
        faults
    }
}
