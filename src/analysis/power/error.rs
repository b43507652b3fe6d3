//! Why nothing can be planned.

use thiserror::Error;

use crate::{analysis::ModelError, stimulus::ParameterError};

/// Why nothing can be planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// A term, or the number of nodes.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A condition of the definition.
    #[error(transparent)]
    Condition(#[from] ParameterError),
    /// An effect of a factor that is not in the definition.
    #[error("--effect {name}: no such factor; {}", expected(name, known))]
    UnknownFactor {
        /// The name.
        name: String,
        /// The definition's factors.
        known: Vec<String>,
    },
    /// An effect of a level that the factor does not have.
    #[error("--effect {factor}:{level}: no such level; {}", expected(level, known))]
    UnknownLevel {
        /// The factor.
        factor: String,
        /// The level as it was given.
        level: String,
        /// The factor's levels.
        known: Vec<String>,
    },
    /// A term without a column of its own.
    #[error("--terms {term}: the term adds nothing to the other terms; expected terms that each add something")]
    Untestable {
        /// The term.
        term: String,
    },
    /// No term.
    #[error("nothing to test; expected a definition with a factor of two levels or more, and a term in --terms")]
    NothingVaries,
}

/// What is expected in place of a name that is none of those known.
fn expected(name: &str, known: &[String]) -> String {
    let asked = nearest(name, known).map(|near| format!("; did you mean {near}?")).unwrap_or_default();
    format!("expected one of {}{asked}", known.join(", "))
}

/// The name that another one may be a slip of: no more than half of it differs.
pub(crate) fn nearest<'a, S: AsRef<str>>(name: &str, known: &'a [S]) -> Option<&'a str> {
    let distance = |other: &&str| strsim::damerau_levenshtein(name, other);
    let best = known.iter().map(AsRef::as_ref).min_by_key(distance)?;
    (2 * distance(&best) <= best.chars().count()).then_some(best)
}
