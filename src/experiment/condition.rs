//! Factors, and the conditions they cross to.

use serde::{Serializer, ser::SerializeMap as _};

use crate::stimulus::{ParameterError, ParameterValue, Stimulus};

/// A stimulus parameter that the experiment varies, and its levels in the order of the definition.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// A stimulus parameter's name.
    pub name: String,
    /// At least one level, no two alike.
    pub levels: Vec<ParameterValue>,
}

/// One cell of the crossed factors: the stimulus with every parameter settled.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Index of the level of each factor, in the order of the factors.
    pub levels: Vec<usize>,
    /// What is drawn.
    pub stimulus: Stimulus,
}

/// All cells, the last factor fastest.
///
/// # Errors
/// Each parameter that a cell would set to an impossible value.
pub(super) fn cross(base: &Stimulus, factors: &[Factor]) -> Result<Vec<Condition>, ParameterError> {
    let mut cells = vec![Condition { levels: Vec::new(), stimulus: base.clone() }];
    for factor in factors {
        let mut next = Vec::with_capacity(cells.len() * factor.levels.len());
        for cell in &cells {
            for (index, level) in factor.levels.iter().enumerate() {
                let mut cell = cell.clone();
                cell.stimulus.set(&factor.name, level)?;
                cell.levels.push(index);
                next.push(cell);
            }
        }
        cells = next;
    }
    Ok(cells)
}

/// Factors as a JSON object, `{"width": [0.02, …], …}`, as in a definition.
pub(super) fn serialize_factors<S: Serializer>(factors: &[Factor], serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(factors.len()))?;
    for factor in factors {
        map.serialize_entry(&factor.name, &factor.levels)?;
    }
    map.end()
}
