//! A study's ratings as the model of vision predicts them.

use super::comparison::{Comparison, LEAST, PredictionError, check_categories, compare, mean};
use crate::{
    analysis::{
        counts::{Counts, Factor},
        summary::category_values,
    },
    experiment::{Condition, Protocol, visibilities},
    stimulus::{ParameterValue, ViewingConditions},
    store::{ratings::Source, sidecar::Sitting},
    vision::Visibility,
};

/// Most conditions that a report predicts: each takes about a millisecond.
const MOST_LINES: usize = 5000;
/// Most of them where each needs a picture: these take a few tenths of a second.
const MOST_PICTURES: usize = 100;

/// What the model of vision says of a study's conditions.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyPrediction {
    /// How the conditions were looked at.
    pub viewing: ViewingConditions,
    /// How the prediction compares with the ratings.
    pub comparison: Comparison,
    /// The rating expected in each of the counts' conditions, in the numbers of the categories; `None` where a
    /// condition is none of the definition's.
    pub ratings: Vec<Option<f64>>,
}

impl StudyPrediction {
    /// Predicts every condition of the definition beside the ratings, in the window of their sessions, and compares that
    /// with the ratings.
    ///
    /// # Errors
    /// Why that cannot be done.
    pub fn of(source: &Source, counts: &Counts) -> Result<Self, PredictionError> {
        let protocol = source.protocol.as_ref().ok_or(PredictionError::NoDefinition)?;
        check_categories(counts)?;
        let conditions = protocol.conditions().map_err(|error| PredictionError::Conditions(error.to_string()))?;
        let most = if protocol.stimulus.is_line() { MOST_LINES } else { MOST_PICTURES };
        if conditions.len() > most {
            let name = protocol.name.clone();
            return Err(PredictionError::TooMany { conditions: conditions.len(), most, name });
        }
        let places = places(counts, protocol, &conditions)?;
        let viewing = ViewingConditions::new(window_deg(source, protocol));
        let predicted = visibilities(&conditions, &viewing, None)?;
        let predicted: Vec<Option<f64>> = at(&places, &predicted);
        let comparison = compare(counts, &predicted)?;
        let values = category_values(counts);
        let expected = |visibility: f64| {
            comparison
                .criterion
                .probabilities(visibility.max(LEAST))
                .iter()
                .zip(&values)
                .map(|(share, value)| share * value)
                .sum()
        };
        let ratings = predicted.iter().map(|visibility| visibility.map(expected)).collect();
        Ok(Self { viewing, comparison, ratings })
    }
}

/// Compares what is predicted of a definition's conditions with ratings of it.
///
/// # Errors
/// Where they have nothing in common, no criterion can be fitted, or the ratings do not record a factor of the
/// definition.
pub fn compare_conditions(
    counts: &Counts,
    protocol: &Protocol,
    conditions: &[Condition],
    predicted: &[Visibility],
) -> Result<Comparison, PredictionError> {
    compare(counts, &at(&places(counts, protocol, conditions)?, predicted))
}

/// The width of the window in the sessions, degrees: the mean of what their sidecars record, else what the
/// definition plans.
#[must_use]
pub fn window_deg(source: &Source, protocol: &Protocol) -> f64 {
    let width = |sitting: &Sitting| sitting.viewing.as_ref()?.get("stimulus_deg")?.as_f64();
    let sidecars = source.sessions.iter().filter_map(|session| session.sidecar.as_ref());
    let known: Vec<f64> = sidecars
        .flat_map(|sidecar| &sidecar.sittings)
        .filter_map(width)
        .filter(|deg| deg.is_finite() && *deg > 0.0)
        .collect();
    mean(&known).unwrap_or(protocol.viewing.window_deg)
}

/// Visibilities by the counts' conditions.
fn at(places: &[Option<usize>], predicted: &[Visibility]) -> Vec<Option<f64>> {
    places.iter().map(|place| place.and_then(|place| predicted.get(place)).map(Visibility::max)).collect()
}

/// For each of the counts' conditions the place of the definition's condition that was shown; `None` where it is none
/// of them. Columns that are no parameters of the stimulus say nothing of what was shown.
fn places(
    counts: &Counts,
    protocol: &Protocol,
    conditions: &[Condition],
) -> Result<Vec<Option<usize>>, PredictionError> {
    let missing =
        |factor: &&crate::experiment::Factor| factor.levels.len() > 1 && counts.factor(&factor.name).is_none();
    if let Some(factor) = protocol.factors.iter().find(missing) {
        return Err(PredictionError::Factor(factor.name.clone()));
    }
    let columns: Vec<_> = counts.factors.iter().map(|factor| steps(factor, protocol, conditions)).collect();
    let place = |levels: &Vec<Option<u32>>| {
        let mut place = 0;
        for (steps, level) in columns.iter().zip(levels) {
            if let Some(steps) = steps {
                place += (*steps.get((*level)? as usize)?)?;
            }
        }
        Some(place)
    };
    Ok(counts.conditions.iter().map(place).collect())
}

/// How many conditions on each level of a column leads, `None` for a value that was not shown; no steps where the column
/// is no parameter of the stimulus.
fn steps(column: &Factor, protocol: &Protocol, conditions: &[Condition]) -> Option<Vec<Option<usize>>> {
    let fixed = protocol.stimulus.get(&column.name)?;
    let factor = protocol.factors.iter().position(|factor| factor.name == column.name);
    let step = |text: &String| match factor {
        None => is_same(&fixed, text).then_some(0),
        Some(f) => {
            // Conditions are crossed with the last factor fastest.
            let each: usize = protocol.factors[f + 1..].iter().map(|factor| factor.levels.len()).product();
            let value = |level: &usize| conditions.get(level * each)?.stimulus.get(&column.name);
            let mut levels = 0..protocol.factors[f].levels.len();
            let found = levels.find(|level| value(level).is_some_and(|value| is_same(&value, text)));
            found.map(|level| level * each)
        }
    };
    Some(column.levels.iter().map(step).collect())
}

/// Whether a file's text is this value: numbers may be written in several ways.
fn is_same(value: &ParameterValue, text: &str) -> bool {
    let value = value.to_string();
    match (value.parse::<f64>(), text.parse::<f64>()) {
        (Ok(a), Ok(b)) => a == b || (a - b).abs() <= 1e-12 * a.abs(),
        _ => value == text,
    }
}
