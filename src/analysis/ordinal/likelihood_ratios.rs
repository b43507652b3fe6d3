//! Likelihood-ratio tests of each term.

use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use super::{
    clm::{Fit, FitEnd},
    fitting::{Fitted, How},
    terms::Term,
};
use crate::statistics::{chi_squared_quantile, chi_squared_tail};

/// A test of one term: of the likelihood ratio or, for interactions that people's signs test, of scores.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TermTest {
    pub term: Term,
    /// Twice the difference of the log-likelihoods, or the statistic of a score test; `None` if one of the models has no
    /// maximum.
    pub chi_squared: Option<f64>,
    /// The difference in the number of parameters.
    pub df: usize,
    /// Probability of a ratio at least as large if the smaller model were true: from the χ² distribution or, if `draws`
    /// is given, from simulated studies. `None` if there is no ratio or the test is withheld.
    pub p: Option<f64>,
    /// Number of simulated studies that gave the probability.
    pub draws: Option<usize>,
    /// The Monte Carlo standard error of that probability; `None` if it is extrapolated.
    pub p_error: Option<f64>,
    /// Why there is no probability.
    pub withheld: Option<Withheld>,
    /// The limit of a ratio with one degree of freedom, which may be simulated.
    #[serde(skip)]
    pub(super) limit: f64,
}

/// Coverage of all intervals of a model.
const LEVEL: f64 = 0.95;

/// Smallest number of ratings for each parameter of a model that is wider than the main one.
pub(super) const LEAST_PER_PARAMETER: u64 = 5;

/// Smallest number of participants or items at each level of a factor that varies only between them.
const LEAST_PER_LEVEL: usize = 3;

/// Why a test has no probability.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Error)]
#[serde(rename_all = "kebab-case")]
pub enum Withheld {
    /// One of the two models has no maximum, or the interaction has too many columns.
    #[error("one of the two models has no maximum or too many parameters")]
    NoRatio,
    /// A level of a factor that varies only between participants, or only between items, has too few of them.
    #[error("a level has fewer than three participants or items")]
    FewPerLevel,
    /// Participants may differ in the effect, and the model does not let them.
    #[error(
        "the design has too few ratings for a random slope, and differences between participants would look like an effect"
    )]
    NoSlope,
    /// Both models are the same in the conditions that were rated.
    #[error("the conditions that were rated cannot separate it from the other terms")]
    Aliased,
    /// In an interaction that contains the term, not every combination of the levels has ratings, so that the mean effect over
    /// all of them is not known.
    #[error(
        "it is an average over the factors with which it interacts, and not every combination of their levels was rated"
    )]
    EmptyCells,
    /// A mixed model could not be fitted, and without one, ratings by the same participant would count as independent.
    #[error("no mixed model could be fitted, and ratings by the same participant are related")]
    NoMixedModel,
    /// There are too few ratings for the parameters of the wider model.
    #[error("there are too few ratings for the parameters of the model")]
    FewRatings,
    /// The interaction has too many coefficients for simulated studies.
    #[error(
        "the interaction has more than six coefficients, which are too many with items or fewer than six participants"
    )]
    FewPeople,
    /// More than a tenth of the simulated studies allowed no fit.
    #[error("more than a tenth of the simulated studies allowed no fit")]
    TooFew,
}

impl Fitted<'_> {
    /// Returns the likelihood ratio, twice the difference of the log-likelihoods, against a narrower model; `None` unless both
    /// found a maximum of the same kind of likelihood.
    pub(super) fn ratio(&self, narrower: &Fitted) -> Option<f64> {
        let is_fine = |fit: &Fit| !matches!(fit.end, FitEnd::Diverged | FitEnd::Stalled);
        let are_fine = |fitted: &Fitted| is_fine(&fitted.clm) && fitted.mixed.as_ref().is_none_or(is_fine);
        let is_same = self.mixed.is_some() == narrower.mixed.is_some();
        let difference = || self.best().loglik - narrower.best().loglik;
        (is_same && are_fine(self) && are_fine(narrower)).then(|| (2.0 * difference()).max(0.0))
    }

    /// Returns why there is no test of a term, if so: nothing accounts for related ratings, or the term has no mean effect over
    /// those with which it interacts.
    fn untestable(&self, term: &Term) -> Option<Withheld> {
        let terms = &self.spec.terms;
        if self.ignores_people() {
            return Some(Withheld::NoMixedModel);
        }
        let is_larger = |other: &Term| other.variables.len() > term.variables.len() && other.contains(term);
        let larger: Vec<usize> =
            terms.iter().enumerate().filter(|(_, other)| is_larger(other)).map(|(i, _)| i).collect();
        let is_empty = self.x.dropped.iter().any(|column| larger.contains(&column.term));
        is_empty.then_some(Withheld::EmptyCells)
    }

    /// Returns why the test of a term is withheld, if it is: there is none; the term varies only between participants or items,
    /// and a level has too few of them; participants may differ in its effect, although the model does not let them; or, without
    /// random effects, there are too few ratings.
    pub(crate) fn withheld(&self, term: &Term) -> Option<Withheld> {
        if let Some(reason) = self.untestable(term) {
            return Some(reason);
        }
        if self.mixed.is_none() {
            let parameters = self.frame.categories.len() - 1 + self.rank();
            let are_few = self.frame.total() < LEAST_PER_PARAMETER * parameters as u64;
            return are_few.then_some(Withheld::FewRatings);
        }
        let [people, items] = self.least_at_level(term);
        if self.is_between(term) && people < LEAST_PER_LEVEL || self.is_between_items(term) && items < LEAST_PER_LEVEL {
            return Some(Withheld::FewPerLevel);
        }
        self.lacks_slope(term).then_some(Withheld::NoSlope)
    }
}

/// Tests each term by the likelihood ratio against the model without it: a term that is part of a larger one in the [`recoded`]
/// model. If a combination of levels has no ratings, such a term has no test, because the sum contrasts would depend on the order
/// of the levels.
pub(super) fn without_terms(full: &Fitted, recoded: Option<&Fitted>) -> Vec<TermTest> {
    let test = |(place, term): (usize, &Term)| {
        let withheld = full.untestable(term);
        let model = if full.spec.terms.is_marginal(term) { recoded } else { Some(full) };
        match model.filter(|_| withheld.is_none()) {
            Some(model) => without_term(model, term),
            None => {
                let df = full.x.columns.iter().filter(|column| column.term == place).count();
                let test = TermTest::new(term, None, df);
                TermTest { withheld: withheld.or(test.withheld), ..test }
            }
        }
    };
    full.spec.terms.iter().enumerate().collect::<Vec<_>>().into_par_iter().map(test).collect()
}

/// Returns the same model in sum contrasts, in which a term that is part of a larger one is its mean effect over the other
/// variables (type III). None if there is no such term, or if these contrasts allow no fit.
pub(super) fn recoded<'a>(full: &Fitted<'a>, errors: bool) -> Option<Fitted<'a>> {
    full.spec.terms.iter().find(|term| full.spec.terms.is_marginal(term))?;
    let x = full.x.with_dropped().in_sum_contrasts(&full.frame).ok()?;
    let recoded = full.with_columns(x, How { errors, ..How::default() });
    full.ratio(&recoded).is_some().then_some(recoded)
}

/// Tests one term by the likelihood ratio against the model without its columns.
pub(crate) fn without_term(full: &Fitted, term: &Term) -> TermTest {
    let place = full.spec.terms.iter().position(|own| own == term).unwrap_or(usize::MAX);
    let reduced = full.with_columns(full.x.without_columns(place), How::default());
    TermTest::new(term, full.ratio(&reduced), full.rank().saturating_sub(reduced.rank()))
}

impl TermTest {
    /// Creates a test from a likelihood ratio, if there is one.
    pub(super) fn new(term: &Term, ratio: Option<f64>, df: usize) -> Self {
        let lr = ratio.filter(|_| df > 0);
        Self {
            term: term.clone(),
            chi_squared: lr,
            df,
            p: lr.map(|lr| chi_squared_tail(lr, df)),
            draws: None,
            p_error: None,
            withheld: lr.is_none().then_some(if df == 0 { Withheld::Aliased } else { Withheld::NoRatio }),
            limit: chi_squared_limit(1),
        }
    }

    /// Returns the limit of the likelihood ratio for one degree of freedom, or the reason why the test is withheld: there are
    /// then no intervals or comparisons either. Where a mean effect has no test, the coefficients of the term are effects in
    /// the larger one.
    pub(super) fn limit(&self) -> Result<f64, Withheld> {
        self.withheld.filter(|reason| *reason != Withheld::EmptyCells).map_or(Ok(self.limit), Err)
    }

    /// Replaces the probability and the limit by those from simulated ratios. If the ratings are separated, those of the
    /// simulated studies are too, and their ratios are too small.
    pub(crate) fn calibrate(&mut self, ratios: &[f64], is_separated: bool) {
        let Some(lr) = self.chi_squared else { return };
        let (usual, simulated) = (self.p, probability(ratios, lr));
        self.p = simulated.map(|(p, _)| p);
        self.draws = simulated.map(|(_, draws)| draws);
        let counted = simulated.filter(|(p, draws)| p * (*draws + 1) as f64 >= 1.0 - 1e-9);
        self.p_error = counted.map(|(p, draws)| (p * (1.0 - p) / draws as f64).sqrt());
        self.withheld = simulated.is_none().then_some(Withheld::TooFew);
        if is_separated && self.p.is_some() && self.p < usual {
            (self.p, self.draws, self.p_error) = (usual, None, None);
        }
        // The distribution of a ratio with several degrees of freedom differs from χ² by about the same factor.
        if let Some(simulated) = quantile(ratios, LEVEL) {
            let factor = simulated / chi_squared_limit(self.df);
            self.limit *= if is_separated { factor.max(1.0) } else { factor };
        }
    }
}

/// Returns the upper 5 % point of the χ² distribution.
pub(super) fn chi_squared_limit(df: usize) -> f64 {
    chi_squared_quantile(LEVEL, df as f64)
}

/// A simulated distribution is used only if at least this share of the studies allowed a fit.
const ENOUGH: f64 = 0.9;

/// No smaller probability is given from a tail of simulated ratios.
const LEAST_P: f64 = 1e-6;

/// Returns the finite ratios in ascending order; `None` if too few studies allowed a fit.
fn in_order(ratios: &[f64]) -> Option<Vec<f64>> {
    let mut finite: Vec<f64> = ratios.iter().copied().filter(|ratio| ratio.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    (!finite.is_empty() && finite.len() as f64 >= ENOUGH * ratios.len() as f64).then_some(finite)
}

/// Returns the probability of a ratio at least as large as `observed`, and the number of simulated ratios. If none is as
/// large, the probability is that of an exponential tail beyond the largest fifth, whose mean is taken at its upper 95 %
/// bound: for large ratios, the tails of χ² and of its small-sample forms are exponential. `None` if too few studies allowed
/// a fit.
pub(super) fn probability(ratios: &[f64], observed: f64) -> Option<(f64, usize)> {
    let finite = in_order(ratios)?;
    let (number, larger) = (finite.len(), finite.iter().filter(|ratio| **ratio >= observed - 1e-9).count());
    let counted = (1 + larger) as f64 / (1 + number) as f64;
    let tail = || {
        let largest = finite.len() / 5;
        let from = finite[finite.len() - 1 - largest];
        let mean = finite.iter().rev().take(largest).map(|ratio| ratio - from).sum::<f64>() / largest as f64;
        let df = 2.0 * largest as f64;
        let bound = mean * df / chi_squared_quantile(0.05, df);
        (largest as f64 / number as f64 * (-(observed - from) / bound).exp()).max(LEAST_P)
    };
    Some((if larger == 0 && number >= 50 { counted.min(tail()) } else { counted }, number))
}

/// True if more simulated ratios would not change what a probability at the level 0.05 says.
pub(super) fn is_decided(ratios: &[f64], observed: f64) -> bool {
    /// Enough studies to give a probability with a relative error of a third.
    const ENOUGH_LARGER: f64 = 10.0;
    /// A probability from the tail that is below .001 by more than its error.
    const CLEAR: f64 = 3e-4;
    probability(ratios, observed).is_none_or(|(p, number)| {
        let larger = p * (1 + number) as f64 - 1.0;
        p < CLEAR || larger >= ENOUGH_LARGER && (p - 0.05).abs() > 3.0 * (p / number as f64).sqrt()
    })
}

/// Returns the ratio that a share of the simulated ratios does not exceed, or `None` if too few studies allowed a fit.
fn quantile(ratios: &[f64], share: f64) -> Option<f64> {
    let finite = in_order(ratios)?;
    // A ratio above this one has a probability below 1 − share in [`probability`].
    let rank = (share * (finite.len() + 1) as f64 + 1e-9).floor() as usize + 1;
    finite.get(rank.clamp(1, finite.len()) - 1).copied()
}
