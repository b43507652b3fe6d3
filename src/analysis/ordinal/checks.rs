//! How well a model describes the data: it is compared with studies simulated from it.

use nalgebra::DMatrix;
use rayon::prelude::*;
use serde::Serialize;

use super::{fitting::Fitted, resampling::Simulator};
use crate::{
    analysis::counts::{Combinations, CountRow},
    statistics::{Interval, mean_and_sd},
};

/// Number of simulated studies for the comparison of observed with expected proportions.
const STUDIES: u64 = 200;
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

/// Compares the ratings with those of simulated studies.
pub(super) fn checks(full: &Fitted, seed: u64) -> Checks {
    let (counts, left_out) = (full.frame.counts, full.left_out());
    let described: Vec<usize> = (0..counts.factors.len()).filter(|factor| !left_out.contains(factor)).collect();
    let categories = &full.frame.categories;
    // The number of ratings in each category, one column for each condition.
    let tally = |rows: &[CountRow]| {
        let mut tally = DMatrix::zeros(categories.len(), counts.conditions.len());
        rows.iter().for_each(|row| tally[(row.rating.into(), row.condition as usize)] += row.count as f64);
        tally
    };
    let simulator = Simulator::new(full, false);
    // The streams after those of the calibration.
    let first = u64::from(u32::MAX);
    let simulate = |study: u64| tally(&simulator.ratings(seed, first + study));
    let observed = tally(&full.frame.rows);
    let studies: Vec<DMatrix<f64>> = (0..STUDIES).into_par_iter().map(simulate).collect();
    let compare = |factors: &[usize]| {
        let Combinations { all, of } = counts.combinations(factors);
        let combined = |tally: &DMatrix<f64>| {
            let mut sums = DMatrix::zeros(categories.len(), all.len());
            of.iter().zip(tally.column_iter()).for_each(|(group, own)| sums.column_mut(*group).axpy(1.0, &own, 1.0));
            sums
        };
        let (observed, studies) = (combined(&observed), studies.iter().map(combined).collect::<Vec<DMatrix<f64>>>());
        let names: Vec<&str> = factors.iter().map(|&factor| counts.factors[factor].name.as_str()).collect();
        let mut proportions = Vec::new();
        for (group, levels) in all.iter().enumerate().filter(|(_, levels)| levels[..] != [None]) {
            let n = observed.column(group).sum();
            for (category, label) in categories.iter().enumerate().filter(|_| n > 0.0) {
                let mut values: Vec<f64> = studies.iter().map(|study| study[(category, group)] / n).collect();
                let expected = mean_and_sd(&values).0;
                values.sort_by(f64::total_cmp);
                let at = |share: f64| values[((share * values.len() as f64) as usize).min(values.len() - 1)];
                proportions.push(Proportion {
                    factor: names.join(", "),
                    level: counts.names(factors, levels).join(", "),
                    category: label.clone(),
                    observed: observed[(category, group)] / n,
                    expected,
                    range: Interval { low: at(0.025), high: at(0.975) },
                });
            }
        }
        proportions
    };
    let has_cells = described.len() > 1 && (2..=MAX_CELLS).contains(&counts.combinations(&described).all.len());
    Checks {
        proportions: described.iter().flat_map(|factor| compare(&[*factor])).collect(),
        cells: if has_cells { compare(&described) } else { Vec::new() },
    }
}
