//! Tests of the two-way interactions that a model leaves out, from its residuals: no wider model is fitted.
//!
//! A participant's score for an interaction is the sum of the residuals times the interaction's columns, which are made
//! orthogonal to the columns of the model. If there is no interaction, each participant's scores might as well have the
//! opposite sign, however participants differ. The statistic is the squared sum of the scores in units of their
//! information, and its distribution that over these signs (a score bootstrap: Kline & Santos 2012, J. Econom. Methods 1).
//! The fit has removed the part of the scores that the model explains, and other signs bring some of it back: the scores that
//! get other signs are enlarged, such that their sum varies as much, on average, as the sum of the scores as they are. The
//! statistic is shown in units in which its mean over the signs is that of χ², the number of degrees of freedom: the
//! information does not know how participants differ, least of all in what varies only between them. Fewer than [`LEAST_FOR_SIGNS`] participants have too few signs, and items are shared by participants:
//! likelihood ratios of wider models in simulated studies take their place.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::RngExt;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use rayon::prelude::*;
use serde::Serialize;

use super::{
    fitting::{Fitted, Layout, fit_terms, lay_out},
    likelihood_ratios::{LEAST_PER_PARAMETER, TermTest, Withheld, without_term},
    model::ModelSpec,
    resampling::{Resampling, simulate},
    terms::{Term, Terms},
};
use crate::{analysis::frame::factors_of, statistics::holm};

/// With five participants, no p could be below 1/16.
pub const LEAST_FOR_SIGNS: usize = 6;
/// Up to this number of participants, all signs are enumerated.
const MAX_ENUMERATED: usize = 14;
/// Number of random signs of more participants.
const SIGNS: usize = 9_999;
/// Maximum number of columns of an interaction.
const MAX_COLUMNS: usize = 300;
/// Maximum number of columns of an interaction that is tested by a wider model.
const MAX_SIMULATED: usize = 6;

/// The test of an interaction that is not in the model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Interaction {
    /// True if the statistic is that of the scores, and the probability comes from patterns of signs.
    pub by_signs: bool,
    /// The test; its probability is corrected for the number of interactions that are tested.
    #[serde(flatten)]
    pub test: TermTest,
}

/// Tests every pair of factors whose main effects, but not their interaction, are in the model.
pub(super) fn interactions(full: &Fitted, settings: Resampling) -> Vec<Interaction> {
    // Effects of items have no signs that could be changed by participant.
    let by_signs = full.frame.subjects.len() >= LEAST_FOR_SIGNS && !full.random.is_crossed();
    let residuals = by_signs.then(|| Residuals::of(full));
    let tested = |(test, terms): (TermTest, [usize; 2])| match &residuals {
        Some(residuals) => self::by_signs(full, residuals, test, terms, settings.seed),
        None => by_ratio(full, test, settings),
    };
    let tests: Vec<TermTest> = pairs(full).into_par_iter().map(tested).collect();
    let corrected = holm(&tests.iter().map(|test| test.p).collect::<Vec<_>>());
    let interaction = |(test, p)| Interaction { by_signs, test: TermTest { p, ..test } };
    tests.into_iter().zip(corrected).map(interaction).collect()
}

/// Returns the interactions that the model leaves out, not tested yet, each with the indices of the main effects.
fn pairs(full: &Fitted) -> Vec<(TermTest, [usize; 2])> {
    let main: Vec<(usize, &Term)> = full.spec.terms.iter().enumerate().filter(|(_, term)| term.is_main()).collect();
    let factor = |term: &Term| factors_of(full.frame.counts, term).next();
    let pair = |(i, one): (usize, &Term), (j, other): (usize, &Term)| {
        let term = Term { variables: [&one.variables[..], &other.variables].concat() };
        let is_known = full.spec.terms.iter().any(|known| known.contains(&term));
        let columns = |index: usize| full.x.columns.iter().filter(|column| column.term == index).count();
        let test = TermTest::new(&term, None, columns(i) * columns(j));
        (!is_known && factor(one) != factor(other) && test.df > 0).then_some((test, [i, j]))
    };
    let all =
        main.iter().enumerate().flat_map(|(place, one)| main[place + 1..].iter().map(move |other| (*one, *other)));
    all.filter_map(|(one, other)| pair(one, other)).collect()
}

fn by_signs(full: &Fitted, residuals: &Residuals, test: TermTest, terms: [usize; 2], seed: u64) -> TermTest {
    if test.df > MAX_COLUMNS {
        return test;
    }
    let Some(Scores { observed, enlarged }) = residuals.scores(full, terms) else {
        return TermTest { withheld: Some(Withheld::Aliased), ..test };
    };
    let df = enlarged.nrows();
    let chi_squared = Some(observed * df as f64 / enlarged.norm_squared());
    let (p, patterns) = sign_test(&enlarged, observed, seed);
    TermTest { chi_squared, df, p: Some(p), draws: Some(patterns), withheld: None, ..test }
}

/// Returns the proportion of the patterns of signs, one for each column, in which the squared sum of the columns is at least as
/// large as `observed`, and the number of patterns: all that differ by more than a common sign, or the one without negative signs
/// and random ones. They are made block by block, because all of them would need gigabytes for thousands of participants.
pub(super) fn sign_test(scores: &DMatrix<f64>, observed: f64, seed: u64) -> (f64, usize) {
    const BLOCK: usize = 64;
    let people = scores.ncols();
    let is_enumerated = people <= MAX_ENUMERATED;
    let patterns = if is_enumerated { 1 << (people - 1) } else { 1 + SIGNS };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut sign = |pattern: usize, person: usize| {
        let is_positive = if is_enumerated { pattern >> person & 1 == 0 } else { rng.random() };
        if is_positive { 1.0 } else { -1.0 }
    };
    // The signs as they are reach it.
    let mut reached = 1;
    for first in (1..patterns).step_by(BLOCK) {
        let columns = BLOCK.min(patterns - first);
        let sums = scores * DMatrix::from_fn(people, columns, |person, column| sign(first + column, person));
        reached += sums.column_iter().filter(|sum| sum.norm_squared() >= observed * (1.0 - 1e-9)).count();
    }
    (reached as f64 / patterns as f64, patterns)
}

/// The scores of the participants for an interaction, in units of their information.
struct Scores {
    /// The squared sum of the scores as they are.
    observed: f64,
    /// The scores to which other signs are given, each participant's in a column.
    enlarged: DMatrix<f64>,
}

/// The residuals of a fit.
struct Residuals {
    /// The columns of the model, one row for each distinct condition, with a constant.
    x: DMatrix<f64>,
    /// For each participant: row, derivative of the log-probability of the ratings with respect to the location, and their
    /// information on it.
    of_subjects: Vec<Vec<(usize, f64, f64)>>,
    /// The information on the location in each row.
    information: DVector<f64>,
}

impl Residuals {
    fn of(full: &Fitted) -> Self {
        let Layout { data, .. } = lay_out(full, false);
        let parameters = full.searched(&data);
        let modes = full.usable().map_or_else(|| data.modes(), |mixed| mixed.modes.clone());
        let mut information = DVector::zeros(data.x.nrows());
        let of_subjects = data.residuals(&parameters, &modes);
        of_subjects.iter().flatten().for_each(|(row, _, own)| information[*row] += own);
        Self { x: data.x.insert_column(0, 1.0), of_subjects, information }
    }

    /// Returns the scores for the interaction of two terms; `None` if the design does not tell the interaction from the
    /// model.
    fn scores(&self, full: &Fitted, [one, other]: [usize; 2]) -> Option<Scores> {
        let columns = |term: usize| {
            let own = full.x.columns.iter().enumerate().filter(move |(_, column)| column.term == term);
            own.map(|(index, _)| self.x.column(1 + index)).collect::<Vec<_>>()
        };
        let (ones, others) = (columns(one), columns(other));
        let products: Vec<DVector<f64>> =
            ones.iter().flat_map(|a| others.iter().map(move |b| a.component_mul(b))).collect();
        let z = DMatrix::from_columns(&products);
        let weighted = |matrix: &DMatrix<f64>| {
            let mut weighted = matrix.clone();
            weighted.row_iter_mut().zip(self.information.iter()).for_each(|(mut row, weight)| row *= *weight);
            weighted
        };
        let xw = weighted(&self.x);
        let solver = (xw.transpose() * &self.x).svd(true, true);
        let explained = solver.solve(&(xw.transpose() * &z), 1e-10).ok()?;
        let most = z.component_mul(&weighted(&z)).sum();
        let z = z - &self.x * explained;
        let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(z.transpose() * weighted(&z));
        let kept: Vec<usize> =
            (0..eigenvalues.len()).filter(|&i| eigenvalues[i] > 1e-8 * eigenvalues.max().max(1e-4 * most)).collect();
        let unit = DMatrix::from_fn(z.ncols(), kept.len(), |row, column| {
            eigenvectors[(row, kept[column])] / eigenvalues[kept[column]].sqrt()
        });
        let z = z * unit;
        if kept.is_empty() {
            return None;
        }
        let mut scores = DMatrix::zeros(kept.len(), self.of_subjects.len());
        let mut varied = DMatrix::identity(kept.len(), kept.len());
        for (rows, mut score) in self.of_subjects.iter().zip(scores.column_iter_mut()) {
            let mut shared = DMatrix::zeros(self.x.ncols(), kept.len());
            for (row, residual, information) in rows {
                score += z.row(*row).transpose() * *residual;
                shared += self.x.row(*row).transpose() * z.row(*row) * *information;
            }
            varied -= shared.transpose() * solver.solve(&shared, 1e-10).ok()?;
        }
        let observed = scores.column_sum().norm_squared();
        varied.cholesky()?.l().solve_lower_triangular_mut(&mut scores);
        Some(Scores { observed, enlarged: scores })
    }
}

/// Tests an interaction by the likelihood ratio of a wider model in simulated studies.
fn by_ratio(full: &Fitted, test: TermTest, settings: Resampling) -> TermTest {
    let parameters = full.frame.categories.len() - 1 + full.rank() + test.df;
    let withheld = if full.ignores_people() {
        Some(Withheld::NoMixedModel)
    } else if full.mixed.is_some() && test.df > MAX_SIMULATED {
        Some(Withheld::FewPeople)
    } else {
        (full.frame.total() < LEAST_PER_PARAMETER * parameters as u64).then_some(Withheld::FewRatings)
    };
    if withheld.is_some() {
        return TermTest { withheld, ..test };
    }
    let term = &test.term;
    let spec = ModelSpec { terms: Terms::new(full.spec.terms.iter().chain([term]).cloned()), ..full.spec.clone() };
    let Ok(wider) = fit_terms(full.frame.clone(), spec, Vec::new(), false) else { return test };
    let mut own = without_term(&wider, term);
    if let Some(lr) = own.chi_squared {
        own.calibrate(&simulate(&wider, None, &[(term, lr)], settings, &|| ())[0], false);
    }
    own
}
