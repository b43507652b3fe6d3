//! The conditions of a definition, and how visible the bands in each condition are to the observer.

use std::collections::HashMap;

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};
use rand_distr::{Distribution as _, StandardNormal};
use thiserror::Error;

use crate::{
    analysis::{
        ModelError,
        counts::{CountRow, Counts, MeasuredBuilder},
        levels,
    },
    experiment::{Condition, MAX_RATING, OrderedLogit, Protocol},
    light::names::expected_one_of,
    stimulus::ParameterError,
};

/// The reason why a plan is impossible.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// A term or the number of nodes is not valid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A condition of the definition is not valid.
    #[error(transparent)]
    Condition(#[from] ParameterError),
    /// An effect was given for a factor that is not in the definition.
    #[error("--effect {name}: no such factor; {}", expected_one_of(name, known))]
    UnknownFactor {
        name: String,
        /// Names of the definition's factors.
        known: Vec<String>,
    },
    /// An effect was given for a level that the factor does not have.
    #[error("--effect {factor}:{level}: no such level; {}", expected_one_of(level, known))]
    UnknownLevel {
        factor: String,
        /// The level, as given.
        level: String,
        /// The factor's levels.
        known: Vec<String>,
    },
    /// A term has no column of its own.
    #[error("--terms {term}: the term adds nothing to the other terms; expected terms that each add something")]
    Untestable { term: String },
    /// The definition has too many levels or conditions.
    #[error("{0}")]
    TooLarge(String),
    /// There is no term to test.
    #[error("nothing to test; expected a definition with a factor of two levels or more, and a term in --terms")]
    NothingVaries,
}

/// An effect for which the observer has no parameter: the contribution of a level to the linear predictor.
#[derive(Clone, Debug, PartialEq)]
pub struct Shift {
    /// A factor of the definition.
    pub factor: String,
    /// One of its levels.
    pub level: String,
    /// Contribution in logits; positive values give higher ratings.
    pub logits: f64,
}

/// A definition and its observer.
#[derive(Clone, Debug)]
pub(super) struct Scenario {
    /// Every condition of the definition, without participants or ratings.
    pub empty: Counts,
    /// The observer's linear predictor for each condition, for a participant with an intercept of 0; −∞ if there is no
    /// band.
    pub predictors: Vec<f64>,
    observer: OrderedLogit,
    repetitions: u32,
}

impl Scenario {
    /// Computes the conditions of a definition for an observer.
    pub fn new(protocol: &Protocol, observer: &OrderedLogit, shifts: &[Shift]) -> Result<Self, PlanError> {
        let conditions = protocol.conditions()?;
        let shifts = shifts.iter().map(|shift| resolve(protocol, shift)).collect::<Result<Vec<_>, _>>()?;
        let added = |condition: &Condition| -> f64 {
            let here = shifts.iter().filter(|(factor, level, _)| condition.levels[*factor] == *level);
            here.map(|(_, _, logits)| logits).sum()
        };
        let factors: Vec<&str> = protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
        let categories: Vec<String> = (0..=MAX_RATING).map(|rating| rating.to_string()).collect();
        let mut builder = MeasuredBuilder::new(&factors).with_categories(&categories);
        let names: Vec<Vec<String>> = conditions.iter().map(|condition| level_names(protocol, condition)).collect();
        for names in &names {
            // This cannot fail: the levels of a definition are never empty, and the rating is a declared one.
            let _ = builder.add_counts("S", names, "0", 1);
        }
        let mut empty = builder.finish().counts;
        let mut predictors = vec![0.0; empty.conditions.len()];
        let places: HashMap<Vec<&str>, u32> = (0..).map(|c| (empty.level_names(c), c)).take(predictors.len()).collect();
        for (condition, names) in conditions.iter().zip(&names) {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            if let Some(place) = places.get(&names) {
                predictors[*place as usize] = observer.predictor(&condition.stimulus, 0.0) + added(condition);
            }
        }
        empty.rows.clear();
        empty.subjects.clear();
        Ok(Self { empty, predictors, observer: observer.clone(), repetitions: protocol.design.repetitions })
    }

    /// Returns every condition, in order.
    pub fn conditions(&self) -> Vec<u32> {
        (0..self.empty.conditions.len() as u32).collect()
    }

    /// Returns the number of ratings that each participant gives.
    pub fn ratings(&self) -> u64 {
        self.predictors.len() as u64 * u64::from(self.repetitions)
    }

    /// Returns the observer's parameters.
    pub fn observer(&self) -> &OrderedLogit {
        &self.observer
    }

    /// Returns counts in which one participant rates every condition both lowest and highest, so that a design can be
    /// laid out.
    pub fn outline(&self) -> Counts {
        let ratings = [0, MAX_RATING];
        let rows = self
            .conditions()
            .into_iter()
            .flat_map(|condition| ratings.map(|rating| CountRow { subject: 0, condition, rating, count: 1 }));
        Counts { subjects: vec!["S".to_owned()], rows: rows.collect(), ..self.empty.clone() }
    }

    /// Simulates one study. A participant's ratings depend only on the seed, the study and the participant's number, so
    /// a larger study contains every smaller one.
    pub fn study(&self, people: u32, study: u32, seed: u64) -> Counts {
        let mut rows = Vec::new();
        for subject in 0..people {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(u64::from(study) << 32 | u64::from(subject));
            let deviate: f64 = StandardNormal.sample(&mut rng);
            for (condition, predictor) in (0..).zip(&self.predictors) {
                let mut counts = [0; MAX_RATING as usize + 1];
                for _ in 0..self.repetitions {
                    let rating = self.observer.rate_at(predictor + self.observer.subject_sd * deviate, &mut rng);
                    counts[usize::from(rating)] += 1;
                }
                let given = (0..).zip(counts).filter(|(_, count)| *count > 0);
                rows.extend(given.map(|(rating, count)| CountRow { subject, condition, rating, count }));
            }
        }
        // The names sort in the same order as the numbers.
        let subjects = (1..=people).map(|number| format!("S{number:010}")).collect();
        Counts { subjects, rows, ..self.empty.clone() }
    }
}

fn level_names(protocol: &Protocol, condition: &Condition) -> Vec<String> {
    let levels = protocol.factors.iter().zip(&condition.levels);
    levels.map(|(factor, level)| factor.levels[*level].to_string().trim().to_owned()).collect()
}

/// Returns the indices of a shift's factor and level, and its logits.
fn resolve(protocol: &Protocol, shift: &Shift) -> Result<(usize, usize, f64), PlanError> {
    let known = || protocol.factors.iter().map(|factor| factor.name.clone()).collect();
    let factor = (protocol.factors.iter().position(|factor| factor.name == shift.factor))
        .ok_or_else(|| PlanError::UnknownFactor { name: shift.factor.clone(), known: known() })?;
    let names: Vec<String> = protocol.factors[factor].levels.iter().map(ToString::to_string).collect();
    let number = levels::number_of(&shift.level);
    let same = |name: &String| *name == shift.level || (number.is_some() && levels::number_of(name) == number);
    let level = names.iter().position(same).ok_or_else(|| PlanError::UnknownLevel {
        factor: shift.factor.clone(),
        level: shift.level.clone(),
        known: names.clone(),
    })?;
    Ok((factor, level, shift.logits))
}
