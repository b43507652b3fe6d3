//! The hypotheses to test and the true size of each effect.

use std::collections::BTreeSet;

use nalgebra::DVector;
use serde::Serialize;

use super::scenario::{PlanError, Scenario};
use crate::analysis::{
    frame::{Frame, find_factor},
    ordinal::{
        Design, Span,
        terms::{Term, Terms},
    },
};

/// The kind of test of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Likelihood-ratio test of a term of the ordinal model. The model is mixed, or has no random intercept if there is
    /// only one participant.
    LikelihoodRatio,
    /// Friedman's test of a factor, applied to each participant's mean rating at each level.
    Friedman,
}

/// An existing effect: the largest difference that the term makes in the observer's linear predictor between two
/// conditions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// The difference in logits, which is positive; `None` if a level has no band, because the predictor is then not
    /// finite.
    pub logits: Option<f64>,
    /// The level that is rated higher. For an interaction, several levels joined by `:`.
    pub above: String,
    /// The level that is rated lower.
    pub below: String,
}

/// An effect and a test of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// The term of the model, or the factor of Friedman's test.
    pub term: Term,
    pub test: Test,
    /// The true effect; `None` if the term has no effect, so that finding one is a false alarm.
    pub effect: Option<Effect>,
    /// The observer's linear predictor for each condition without the effect; only for likelihood-ratio tests.
    pub(super) absent: Option<Vec<f64>>,
}

/// A predictor of −∞ is replaced by one this far below all others, where ratings other than 0 have almost no
/// probability.
const NO_BAND: f64 = 30.0;

/// Creates the tests of a list of terms.
pub(super) struct Layout<'a> {
    scenario: &'a Scenario,
    frame: &'a Frame<'a>,
    terms: &'a Terms,
    predictors: DVector<f64>,
    /// Whether every condition has a finite predictor.
    finite: bool,
}

impl<'a> Layout<'a> {
    pub fn new(scenario: &'a Scenario, frame: &'a Frame<'a>, terms: &'a Terms) -> Self {
        let finite = scenario.predictors.iter().copied().filter(|predictor| predictor.is_finite());
        let floor = finite.fold(scenario.observer.thresholds[0], f64::min) - NO_BAND;
        let predictors = scenario.predictors.iter().map(|predictor| predictor.max(floor));
        Self {
            predictors: DVector::from_iterator(scenario.predictors.len(), predictors),
            finite: scenario.predictors.iter().all(|predictor| predictor.is_finite()),
            scenario,
            frame,
            terms,
        }
    }

    /// Returns the test of every testable term, each followed by Friedman's test of its factor, and then Friedman's
    /// tests of the remaining factors.
    pub fn hypotheses(&self) -> Result<Vec<Hypothesis>, PlanError> {
        let (mut hypotheses, mut seen) = (Vec::new(), BTreeSet::new());
        for term in self.terms.iter().filter(|term| !self.terms.is_marginal(term)) {
            hypotheses.push(self.of_term(term)?);
            if let [factor] = self.factors(term)?[..] {
                hypotheses.extend(seen.insert(factor).then(|| self.of_factor(factor)).flatten());
            }
        }
        for term in self.terms.iter() {
            for factor in self.factors(term)? {
                hypotheses.extend(seen.insert(factor).then(|| self.of_factor(factor)).flatten());
            }
        }
        Ok(hypotheses)
    }

    /// Returns the indices of the factors of a term.
    fn factors(&self, term: &Term) -> Result<Vec<usize>, PlanError> {
        let mut factors = Vec::new();
        for variable in &term.variables {
            let (index, _) = find_factor(self.frame.counts, variable)?;
            if !factors.contains(&index) {
                factors.push(index);
            }
        }
        Ok(factors)
    }

    /// Creates the hypothesis for a term. Its effect is the part of the predictor that no other term of the model can
    /// express.
    fn of_term(&self, term: &Term) -> Result<Hypothesis, PlanError> {
        let whole = self.span(self.terms)?;
        let rest = self.span(&self.terms.without(term))?;
        if whole.basis.len() == rest.basis.len() {
            return Err(PlanError::Untestable { term: term.to_string() });
        }
        let part = whole.project(&self.predictors) - rest.project(&self.predictors);
        let extremes = self.extremes(&part);
        let factors = self.factors(term)?;
        let effect = extremes.map(|(above, below)| self.effect(&part, above, below, &factors));
        let predictors = (&self.predictors - &part).iter().copied().collect();
        Ok(Hypothesis { term: term.clone(), test: Test::LikelihoodRatio, effect, absent: Some(predictors) })
    }

    /// Creates the hypothesis for Friedman's test of a factor from the mean predictor at each level, or returns `None`
    /// if the factor has only one level.
    fn of_factor(&self, factor: usize) -> Option<Hypothesis> {
        let conditions = &self.scenario.empty.conditions;
        let description = &self.scenario.empty.factors[factor];
        if description.levels.len() < 2 {
            return None;
        }
        let means = (0..description.levels.len() as u32).map(|level| {
            let here = conditions.iter().zip(&self.predictors).filter(|(levels, _)| levels[factor] == Some(level));
            let (sum, number) = here.fold((0.0, 0.0), |(sum, number), (_, predictor)| (sum + predictor, number + 1.0));
            sum / number
        });
        let means: Vec<f64> = means.collect();
        let part = conditions.iter().map(|levels| levels[factor].map_or(0.0, |level| means[level as usize]));
        let part = DVector::from_iterator(conditions.len(), part);
        let extremes = self.extremes(&part);
        Some(Hypothesis {
            term: Term::factor(&description.name),
            test: Test::Friedman,
            effect: extremes.map(|(above, below)| self.effect(&part, above, below, &[factor])),
            absent: None,
        })
    }

    /// Returns the space spanned by a constant and these terms.
    fn span(&self, terms: &Terms) -> Result<Span, PlanError> {
        let design = Design::new(self.frame, terms)?.matrix(&self.scenario.conditions());
        let mut span = Span::with_constant(design.nrows());
        design.column_iter().for_each(|column| _ = span.add(column));
        Ok(span)
    }

    /// Returns the conditions where a part of the predictor is largest and smallest, or `None` if it is the same
    /// everywhere.
    fn extremes(&self, part: &DVector<f64>) -> Option<(usize, usize)> {
        // Differences caused by rounding do not count.
        let slack = 1e-9 * (1.0 + self.predictors.amax());
        let first = |better: &dyn Fn(f64, f64) -> bool| {
            (0..part.len()).fold(0, |best, place| if better(part[place], part[best]) { place } else { best })
        };
        let above = first(&|value, best| value > best + slack);
        let below = first(&|value, best| value < best - slack);
        (part[above] - part[below] > slack).then_some((above, below))
    }

    fn effect(&self, part: &DVector<f64>, above: usize, below: usize, factors: &[usize]) -> Effect {
        let name = |condition: usize| {
            let names = self.scenario.empty.level_names(condition as u32);
            factors.iter().map(|factor| names[*factor]).collect::<Vec<_>>().join(":")
        };
        Effect {
            // Remove the rounding errors of the projections.
            logits: self.finite.then(|| ((part[above] - part[below]) * 1e9).round() / 1e9),
            above: name(above),
            below: name(below),
        }
    }
}
