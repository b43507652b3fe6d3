//! What was asked: by a definition, or as the columns of a table say.

use crate::{
    analysis::tasks::psychometric::Model,
    experiment::{
        Factor, Protocol,
        task::{Adaptive, Common, Dial, Measures},
    },
    stimulus::ParameterValue,
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
    /// The factors; the last one is the second parameter of an adaptive method, if it has one.
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
        let mut factors = protocol.factors.clone();
        let mut conditions: Vec<Vec<usize>> =
            protocol.conditions().iter().map(|condition| condition.levels.clone()).collect();
        if let Some(second) = protocol.adaptive.as_ref().and_then(Adaptive::second) {
            let levels: Vec<ParameterValue> = second.levels.iter().map(|level| (*level).into()).collect();
            let with = |condition: &Vec<usize>| -> Vec<Vec<usize>> {
                (0..levels.len()).map(|level| [&condition[..], &[level]].concat()).collect()
            };
            conditions = conditions.iter().flat_map(with).collect();
            factors.push(Factor { name: second.parameter.clone(), levels });
        }
        Self {
            title: title.clone(),
            name: protocol.name.clone(),
            task: protocol.task.name().to_owned(),
            question: protocol.response.question.clone(),
            measures: protocol.task.measures(),
            factors,
            conditions,
            levels,
            dial: protocol.task.dial(),
            guess: protocol.task.guess(),
            protocol: Some(protocol.clone()),
        }
    }
}
