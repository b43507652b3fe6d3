//! What was asked: by a definition, or as the columns of a table say.

use crate::{
    analysis::tasks::psychometric::Model,
    experiment::{
        Factor, Protocol,
        task::{Common, Dial, Measures},
    },
};

/// What was asked.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The title of the study, and the name of its experiment or file.
    pub title: String,
    /// That name.
    pub name: String,
    /// The kind of task.
    pub task: String,
    /// What participants were asked; empty if it is not known.
    pub question: String,
    /// What the answers are analyzed as.
    pub measures: Measures,
    /// The factors.
    pub factors: Vec<Factor>,
    /// Each condition's level of each factor.
    pub conditions: Vec<Vec<usize>>,
    /// The levels at which psychometric functions were measured, if they were.
    pub levels: Option<Levels>,
    /// The value that participants set.
    pub dial: Option<Dial>,
    /// The probability of a right answer without seeing anything.
    pub guess: Option<f64>,
    /// The definition; `None` for a table.
    pub protocol: Option<Protocol>,
}

/// The levels of a psychometric function.
#[derive(Clone, Debug)]
pub struct Levels {
    /// What is varied, and on which scale.
    pub common: Common,
    /// The lowest and the highest level that could be shown.
    pub range: [f64; 2],
    /// What is known about the functions.
    pub model: Model,
    /// What chose the levels, such as `staircase`; empty if it is not known.
    pub chosen_by: &'static str,
}

impl From<&Protocol> for Asked {
    fn from(protocol: &Protocol) -> Self {
        let title = if protocol.title.trim().is_empty() { &protocol.name } else { &protocol.title };
        let levels = protocol.adaptive.as_ref().zip(Model::of(protocol)).map(|(adaptive, model)| Levels {
            common: adaptive.common.clone(),
            range: adaptive.range(),
            model,
            chosen_by: adaptive.method.name(),
        });
        Self {
            title: title.clone(),
            name: protocol.name.clone(),
            task: protocol.task.name().to_owned(),
            question: protocol.response.question.clone(),
            measures: protocol.task.measures(),
            factors: protocol.factors.clone(),
            conditions: protocol.conditions().iter().map(|condition| condition.levels.clone()).collect(),
            levels,
            dial: protocol.task.dial(),
            guess: protocol.task.guess(),
            protocol: Some(protocol.clone()),
        }
    }
}
