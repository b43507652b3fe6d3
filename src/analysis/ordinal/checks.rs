//! How well a model describes the data: studies simulated from it.

use rayon::prelude::*;
use serde::Serialize;

use super::{fitting::Fitted, resampling::Simulator};
use crate::{analysis::counts::CountRow, statistics::Interval};

/// Number of simulated studies for the comparison of observed with expected proportions.
const STUDIES: usize = 200;
/// Maximum number of conditions whose proportions are compared.
const MAX_CELLS: usize = 300;

/// Checks of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Checks {
    /// Observed proportions and those in simulated studies, at each level of each factor.
    pub proportions: Vec<Proportion>,
    /// The same in each condition, if there are at most 300: `factor` and `level` list the factors and levels.
    pub cells: Vec<Proportion>,
}

/// The proportion of ratings in a category at a level of a factor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Proportion {
    pub factor: String,
    pub level: String,
    pub category: String,
    pub observed: f64,
    /// The mean over simulated studies.
    pub expected: f64,
    /// The range of the middle 95 % of simulated studies.
    pub range: Interval,
}

impl Proportion {
    /// Returns whether the observed proportion lies outside the range.
    pub fn is_outside(&self) -> bool {
        self.observed < self.range.low - 1e-9 || self.observed > self.range.high + 1e-9
    }
}

impl Checks {
    /// Returns whether more proportions in the single conditions lie outside than chance allows: three standard deviations more
    /// than 5 % of them. The conditions of a single factor are its levels.
    pub fn is_poor(&self) -> bool {
        let single = if self.cells.is_empty() { &self.proportions } else { &self.cells };
        let (all, share) = (single.len() as f64, 0.05);
        let outside = single.iter().filter(|cell| cell.is_outside()).count() as f64;
        outside > all * share + 3.0 * (all * share * (1.0 - share)).sqrt()
    }
}

/// The counts of each category at each level of each factor and in each condition.
struct Tally {
    levels: Vec<Vec<Vec<f64>>>,
    cells: Vec<Vec<f64>>,
}

/// Counts the ratings; `cell_of` is the cell of each condition of the table.
fn tally(full: &Fitted, cell_of: &[usize], rows: &[CountRow]) -> Tally {
    let counts = full.frame.counts;
    let categories = full.frame.categories.len();
    let mut levels: Vec<Vec<Vec<f64>>> =
        counts.factors.iter().map(|factor| vec![vec![0.0; categories]; factor.levels.len()]).collect();
    let mut cells = vec![vec![0.0; categories]; counts.conditions.len()];
    for row in rows {
        let n = row.count as f64;
        cells[cell_of[row.condition as usize]][usize::from(row.rating)] += n;
        for (tallies, level) in levels.iter_mut().zip(&counts.conditions[row.condition as usize]) {
            if let Some(level) = level {
                tallies[*level as usize][usize::from(row.rating)] += n;
            }
        }
    }
    Tally { levels, cells }
}

/// Compares the ratings with those of simulated studies.
pub(super) fn checks(full: &Fitted, seed: u64) -> Checks {
    let (counts, left_out) = (full.frame.counts, full.left_out());
    let described: Vec<usize> = (0..counts.factors.len()).filter(|factor| !left_out.contains(factor)).collect();
    let levels_of =
        |levels: &Vec<Option<u32>>| described.iter().map(|&factor| levels[factor]).collect::<Vec<Option<u32>>>();
    let mut cells: Vec<Vec<Option<u32>>> = counts.conditions.iter().map(levels_of).collect();
    let own = cells.clone();
    cells.sort_unstable();
    cells.dedup();
    let cell_of: Vec<usize> = own.iter().map(|own| cells.partition_point(|cell| cell < own)).collect();
    let simulator = Simulator::new(full, false);
    let observed = tally(full, &cell_of, &full.frame.rows);
    // The streams after those of the calibration.
    let first = u64::from(u32::MAX);
    let simulate = |study: usize| tally(full, &cell_of, &simulator.ratings(seed, first + study as u64));
    let studies: Vec<Tally> = (0..STUDIES).into_par_iter().map(simulate).collect();
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((share * values.len() as f64) as usize).min(values.len() - 1)];
        Interval { low: at(0.025), high: at(0.975) }
    };
    let compare = |factor: &str, level: &str, of: &dyn Fn(&Tally) -> &[f64], all: &mut Vec<Proportion>| {
        let n: f64 = of(&observed).iter().sum();
        for (category, label) in full.frame.categories.iter().enumerate().filter(|_| n > 0.0) {
            let values: Vec<f64> = studies.iter().map(|study| of(study)[category] / n).collect();
            all.push(Proportion {
                factor: factor.to_owned(),
                level: level.to_owned(),
                category: label.clone(),
                observed: of(&observed)[category] / n,
                expected: values.iter().sum::<f64>() / values.len() as f64,
                range: middle(values),
            });
        }
    };
    let (mut proportions, mut in_cells) = (Vec::new(), Vec::new());
    for &index in &described {
        let factor = &counts.factors[index];
        for (level, name) in factor.levels.iter().enumerate() {
            compare(&factor.name, name, &|tally| &tally.levels[index][level], &mut proportions);
        }
    }
    if described.len() > 1 && (2..=MAX_CELLS).contains(&cells.len()) {
        let names: Vec<&str> = described.iter().map(|&factor| counts.factors[factor].name.as_str()).collect();
        for (cell, levels) in cells.iter().enumerate() {
            let level = |(level, factor): (&Option<u32>, &usize)| {
                level.map_or("", |level| counts.factors[*factor].levels[level as usize].as_str())
            };
            let levels: Vec<&str> = levels.iter().zip(&described).map(level).collect();
            compare(&names.join(", "), &levels.join(", "), &|tally| &tally.cells[cell], &mut in_cells);
        }
    }
    Checks { proportions, cells: in_cells }
}
