//! The conditions of a definition, how visible the bands in each condition are to the observer, the hypotheses to test, and the
//! true size of each effect.

use std::collections::{BTreeSet, HashMap};

use nalgebra::DVector;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};
use rand_distr::{Distribution as _, StandardNormal};
use serde::Serialize;
use thiserror::Error;

use crate::{
    analysis::{
        ModelError,
        counts::{CountRow, Counts, MeasuredBuilder},
        frame::{Frame, factors_of},
        levels,
        ordinal::{
            Design, Span,
            terms::{Term, Terms},
        },
    },
    experiment::{Factor, OrderedLogit, Protocol},
    text::names::{expected_one_of, named},
};

/// The reason why a plan is impossible.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// A term is not valid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// An effect or a slope was given for a factor that is not in the definition.
    #[error("{name}: no such factor; {}", expected_one_of(name, known))]
    UnknownFactor {
        /// True if it was a slope.
        is_slope: bool,
        name: String,
        /// Names of the definition's factors.
        known: Vec<String>,
    },
    /// An effect was given for a level that the factor does not have.
    #[error("{factor}:{level}: no such level; {}", expected_one_of(level, known))]
    UnknownLevel {
        factor: String,
        /// The level, as given.
        level: String,
        /// The factor's levels.
        known: Vec<String>,
    },
    /// A term has no column of its own.
    #[error("{term}: the term adds nothing to the other terms; expected terms that each add something")]
    Untestable { term: String },
    /// The definition has too many levels or conditions.
    #[error("{0}")]
    TooLarge(String),
    /// There is no term to test.
    #[error("nothing to test; expected a definition with a factor of two levels or more, and a model with a term")]
    NothingVaries,
}

/// An effect for which the observer has no parameter: the contribution of a level to the linear predictor or, in a task
/// other than a rating, to what is estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct Shift {
    /// A factor of the definition.
    pub factor: String,
    /// One of its levels.
    pub level: String,
    /// Contribution, in logits for ratings; positive values give higher ratings.
    pub size: f64,
}

/// How much people differ in the effect of a factor: each participant's predictor deviates at each of its levels by an
/// independent normal value. These are the deviations of R's `(1 | subject:factor)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Slope {
    /// A factor of the definition.
    pub factor: String,
    /// Standard deviation, in logits for ratings.
    pub sd: f64,
}

/// A definition and its observer.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Every condition of the definition, rated lowest by one participant and highest by another, so that a design can be laid
    /// out.
    pub outline: Counts,
    /// The observer's linear predictor for each condition, for a participant with an intercept of 0; −∞ if there is no
    /// band.
    pub predictors: Vec<f64>,
    /// How much people differ in the effects, in the order of the factors.
    pub slopes: Vec<Slope>,
    pub observer: OrderedLogit,
    pub repetitions: u32,
}

impl Scenario {
    /// Computes the conditions of a definition for an observer.
    pub fn new(
        protocol: &Protocol,
        observer: &OrderedLogit,
        shifts: &[Shift],
        slopes: &[Slope],
    ) -> Result<Self, PlanError> {
        let added = Shift::sum(shifts, &protocol.factors)?;
        let categories: Vec<String> = (0..=protocol.response.highest()).map(|rating| rating.to_string()).collect();
        let names: Vec<&str> = protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
        let mut builder = MeasuredBuilder::new(&names).with_categories(&categories);
        let mut known = HashMap::new();
        for condition in protocol.conditions().iter() {
            let places = protocol.factors.iter().zip(&condition.levels);
            let levels: Vec<String> =
                places.map(|(factor, level)| factor.levels[*level].to_string().trim().to_owned()).collect();
            for (subject, rating) in [("S1", &categories[0]), ("S2", &categories[categories.len() - 1])] {
                builder
                    .add_counts(subject, &levels, rating, protocol.design.repetitions.into())
                    .map_err(PlanError::TooLarge)?;
            }
            known.insert(levels, observer.predictor(&condition.stimulus, 0.0) + added(&condition.levels));
        }
        let outline = builder.finish().counts;
        let names = |condition: u32| outline.level_names(condition).into_iter().map(str::to_owned).collect::<Vec<_>>();
        let predictors = (0..outline.conditions.len() as u32).map(|condition| known[&names(condition)]).collect();
        let mut slopes = slopes.to_vec();
        for slope in &slopes {
            slope.resolve(&protocol.factors)?;
        }
        slopes.sort_by_key(|slope| protocol.factors.iter().position(|factor| factor.name == slope.factor));
        Ok(Self { outline, predictors, slopes, observer: observer.clone(), repetitions: protocol.design.repetitions })
    }

    /// Simulates a study with these predictors and slopes: one of those that are planned, or one without the effect of a
    /// term, which has other random numbers. A participant's ratings depend only on the seed, the study and the
    /// participant's number, so a larger study contains every smaller one.
    pub fn study(
        &self,
        (predictors, slopes): (&[f64], &[Slope]),
        is_planned: bool,
        people: u32,
        study: u32,
        seed: u64,
    ) -> Counts {
        let study = if is_planned { study } else { !study };
        let mut rows = Vec::new();
        let categories = self.outline.categories.len();
        for subject in 0..people {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(u64::from(study) << 32 | u64::from(subject));
            let deviations = self.deviations(slopes, &mut rng);
            let deviate: f64 = StandardNormal.sample(&mut rng);
            let own = predictors.iter().zip(deviations).map(|(predictor, deviation)| predictor + deviation);
            for (condition, predictor) in (0..).zip(own) {
                let mut counts = vec![0; categories];
                for _ in 0..self.repetitions {
                    let rating =
                        self.observer.rate_at(predictor + self.observer.subject_sd * deviate, categories, &mut rng);
                    counts[usize::from(rating)] += 1;
                }
                let given = (0..).zip(counts).filter(|(_, count)| *count > 0);
                rows.extend(given.map(|(rating, count)| CountRow { subject, condition, rating, count }));
            }
        }
        // The names sort in the same order as the numbers.
        let subjects = (1..=people).map(|number| format!("S{number:010}")).collect();
        Counts { subjects, rows, ..self.outline.clone() }
    }

    /// Draws one participant's deviations at the levels of each factor, and returns their sum for each condition.
    fn deviations(&self, slopes: &[Slope], rng: &mut ChaCha8Rng) -> Vec<f64> {
        let mut sums = vec![0.0; self.outline.conditions.len()];
        for slope in slopes {
            let Some((factor, description)) = self.outline.factor(&slope.factor) else { continue };
            let of_levels: Vec<f64> = description.levels.iter().map(|_| StandardNormal.sample(rng)).collect();
            for (sum, levels) in sums.iter_mut().zip(&self.outline.conditions) {
                *sum += levels[factor].map_or(0.0, |level| slope.sd * of_levels[level as usize]);
            }
        }
        sums
    }
}

/// Returns the index of the factor with this name, which a slope or an effect gave.
fn factor_of(factors: &[Factor], is_slope: bool, name: &str) -> Result<usize, PlanError> {
    (factors.iter().position(|factor| factor.name == name)).ok_or_else(|| PlanError::UnknownFactor {
        is_slope,
        name: name.to_owned(),
        known: factors.iter().map(|factor| factor.name.clone()).collect(),
    })
}

impl Slope {
    /// Returns the index of the factor.
    ///
    /// # Errors
    /// There is no such factor.
    pub fn resolve(&self, factors: &[Factor]) -> Result<usize, PlanError> {
        factor_of(factors, true, &self.factor)
    }
}

impl Shift {
    /// Returns how much these shifts add to a condition, given its level of each factor.
    ///
    /// # Errors
    /// There is no such factor or level.
    pub fn sum(shifts: &[Self], factors: &[Factor]) -> Result<impl Fn(&[usize]) -> f64 + use<>, PlanError> {
        let shifts = shifts.iter().map(|shift| shift.resolve(factors)).collect::<Result<Vec<_>, _>>()?;
        Ok(move |levels: &[usize]| {
            shifts.iter().filter(|(factor, level, _)| levels[*factor] == *level).map(|(.., size)| size).sum()
        })
    }

    /// Returns the indices of the factor and of its level, and the size.
    fn resolve(&self, factors: &[Factor]) -> Result<(usize, usize, f64), PlanError> {
        let factor = factor_of(factors, false, &self.factor)?;
        let names: Vec<String> = factors[factor].levels.iter().map(ToString::to_string).collect();
        let number = levels::number_of(&self.level);
        let same = |name: &String| *name == self.level || (number.is_some() && levels::number_of(name) == number);
        let level = names.iter().position(same).ok_or_else(|| PlanError::UnknownLevel {
            factor: self.factor.clone(),
            level: self.level.clone(),
            known: names.clone(),
        })?;
        Ok((factor, level, self.size))
    }
}

named! {
    /// The kind of test of an effect.
    Test, TestError {
        /// Likelihood-ratio test of a term of the ordinal model. The model is mixed, or has no random intercept if there is
        /// only one participant.
        LikelihoodRatio = "likelihood-ratio",
        /// Friedman's test of a factor, applied to each participant's mean rating at each level.
        Friedman = "friedman",
    }
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

impl Scenario {
    /// Returns the test of every testable term, each followed by Friedman's test of its factor, and then Friedman's
    /// tests of the remaining factors.
    pub(super) fn hypotheses(&self, frame: &Frame, terms: &Terms) -> Result<Vec<Hypothesis>, PlanError> {
        let (mut hypotheses, mut seen) = (Vec::new(), BTreeSet::new());
        let mut friedman = |factor| seen.insert(factor).then(|| self.of_factor(frame, factor))?;
        for term in terms.iter().filter(|term| !terms.is_marginal(term)) {
            hypotheses.push(self.of_term(frame, terms, term)?);
            if let [factor] = self.factors(term)[..] {
                hypotheses.extend(friedman(factor));
            }
        }
        hypotheses.extend(terms.iter().flat_map(|term| self.factors(term)).filter_map(friedman));
        Ok(hypotheses)
    }

    /// Returns the indices of the factors of a term.
    fn factors(&self, term: &Term) -> Vec<usize> {
        let mut seen = BTreeSet::new();
        factors_of(&self.outline, term).filter(|factor| seen.insert(*factor)).collect()
    }

    /// Creates the hypothesis for a term. Its effect is the part of the predictor that no other term of the model can
    /// express.
    fn of_term(&self, frame: &Frame, terms: &Terms, term: &Term) -> Result<Hypothesis, PlanError> {
        let whole = self.span(frame, terms)?;
        let rest = self.span(frame, &terms.without(term))?;
        if whole.basis.len() == rest.basis.len() {
            return Err(PlanError::Untestable { term: term.to_string() });
        }
        let predictors = self.floored();
        let part = whole.project(&predictors) - rest.project(&predictors);
        let extremes = self.extremes(&part);
        let factors = self.factors(term);
        let effect = extremes.map(|(above, below)| self.effect(&part, above, below, &factors));
        let absent = Some((predictors - &part).iter().copied().collect());
        Ok(Hypothesis { term: term.clone(), test: Test::LikelihoodRatio, effect, absent })
    }

    /// Creates the hypothesis for Friedman's test of a factor: about its main effect. Returns `None` if the factor has only one
    /// level.
    fn of_factor(&self, frame: &Frame, factor: usize) -> Option<Hypothesis> {
        let names: Vec<&str> = self.outline.factors.iter().map(|factor| factor.name.as_str()).collect();
        let main = self.of_term(frame, &Terms::factors(&names), &Term::factor(names[factor]));
        Some(Hypothesis { test: Test::Friedman, absent: None, ..main.ok()? })
    }

    /// Returns the predictors of all conditions, those of conditions without a band far below all others.
    fn floored(&self) -> DVector<f64> {
        let finite = self.predictors.iter().copied().filter(|predictor| predictor.is_finite());
        let floor = finite.fold(self.observer.thresholds[0], f64::min) - NO_BAND;
        self.predictors.iter().map(|predictor| predictor.max(floor)).collect::<Vec<_>>().into()
    }

    /// Returns the space spanned by a constant and these terms.
    fn span(&self, frame: &Frame, terms: &Terms) -> Result<Span, PlanError> {
        let design = Design::new(frame, terms)?.matrix(&frame.conditions());
        let mut span = Span::with_constant(design.nrows());
        design.column_iter().for_each(|column| _ = span.add(column));
        Ok(span)
    }

    /// Returns the conditions where a part of the predictor is largest and smallest, or `None` if it is the same
    /// everywhere.
    fn extremes(&self, part: &DVector<f64>) -> Option<(usize, usize)> {
        // Differences caused by rounding do not count.
        let slack = 1e-9 * (1.0 + self.floored().amax());
        let first = |better: &dyn Fn(f64, f64) -> bool| {
            (0..part.len()).fold(0, |best, place| if better(part[place], part[best]) { place } else { best })
        };
        let above = first(&|value, best| value > best + slack);
        let below = first(&|value, best| value < best - slack);
        (part[above] - part[below] > slack).then_some((above, below))
    }

    fn effect(&self, part: &DVector<f64>, above: usize, below: usize, factors: &[usize]) -> Effect {
        let name = |condition: usize| {
            let names = self.outline.level_names(condition as u32);
            factors.iter().map(|factor| names[*factor]).collect::<Vec<_>>().join(":")
        };
        let is_finite = self.predictors.iter().all(|predictor| predictor.is_finite());
        Effect {
            // Remove the rounding errors of the projections.
            logits: is_finite.then(|| ((part[above] - part[below]) * 1e9).round() / 1e9),
            above: name(above),
            below: name(below),
        }
    }
}
