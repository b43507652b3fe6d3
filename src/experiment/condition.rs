//! Factors and the conditions that result from crossing them.

use serde::Serializer;

use crate::stimulus::{ParameterError, ParameterValue, Stimulus};

/// A stimulus parameter that the experiment varies, and its levels in the order of the definition.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// Name of the stimulus parameter.
    pub name: String,
    /// At least one level; no two are equal.
    pub levels: Vec<ParameterValue>,
}

/// One cell of the crossed factors: the stimulus with every parameter set.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// The index of each factor's level, in the order of the factors.
    pub levels: Vec<usize>,
    /// The stimulus to draw.
    pub stimulus: Stimulus,
}

/// Returns all cells. The last factor varies fastest.
///
/// # Errors
/// Returns an error for the first parameter that a cell would set to an impossible value.
pub(super) fn cross(base: &Stimulus, factors: &[Factor]) -> Result<Vec<Condition>, ParameterError> {
    if let Stimulus::Image(pictures) = base {
        return Ok(pictures.each().map(|picture| of_picture(picture.into(), factors)).collect());
    }
    let cells = vec![Condition { levels: Vec::new(), stimulus: base.clone() }];
    factors.iter().try_fold(cells, |cells, factor| {
        let with = |mut cell: Condition, index: usize| {
            cell.stimulus.set(&factor.name, &factor.levels[index])?;
            cell.levels.push(index);
            Ok(cell)
        };
        let all = cells.iter().flat_map(|cell| (0..factor.levels.len()).map(move |index| (cell.clone(), index)));
        all.map(|(cell, index)| with(cell, index)).collect()
    })
}

/// Returns the condition of a picture, which has its own level of each factor.
fn of_picture(stimulus: Stimulus, factors: &[Factor]) -> Condition {
    let level = |factor: &Factor| {
        let own = stimulus.get(&factor.name);
        factor.levels.iter().position(|level| Some(level) == own.as_ref()).unwrap_or(0)
    };
    Condition { levels: factors.iter().map(level).collect(), stimulus }
}

/// Serializes factors as they appear in a definition, in JSON `{"width": [0.02, …], …}`.
pub(super) fn serialize_factors<S: Serializer>(factors: &[Factor], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(factors.iter().map(|factor| (&factor.name, &factor.levels)))
}
