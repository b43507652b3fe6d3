//! What was asked: by a definition, or as the columns of a table say.

use crate::{
    analysis::tasks::psychometric::Model,
    experiment::{
        Factor, Protocol,
        task::{Adaptive, Common, Dial, Measures, Method, Task},
    },
    report::names,
    stimulus::ParameterValue,
};

/// What was asked.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The title of the study, or the name of its experiment or file.
    pub title: String,
    /// The kind of task.
    pub task: String,
    /// What the answers are analyzed as; `None` for a table of answers at levels.
    pub measures: Option<Measures>,
    /// The factors; the last one is the second parameter of an adaptive method, if it has one.
    pub factors: Vec<Factor>,
    /// Each condition's level of each factor.
    pub conditions: Vec<Vec<usize>>,
    /// The levels at which psychometric functions were measured, if they were.
    pub levels: Option<Levels>,
    /// The value that participants set.
    pub dial: Option<Dial>,
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
    /// What chose the levels, such as `a staircase`; empty if it is not known.
    pub chosen_by: &'static str,
}

impl Asked {
    fn known(&self) -> names::Known {
        self.protocol.as_ref().map(|protocol| protocol.stimulus.parameters())
    }

    /// Returns the name of a factor or of another parameter in a sentence.
    pub fn factor(&self, name: &str) -> String {
        names::factor(self.known(), name)
    }

    /// Returns whether participants rated on a slider.
    pub fn is_slider(&self) -> bool {
        self.dial.as_ref().is_some_and(|dial| dial.parameter.is_none())
    }

    /// Formats a level of a factor.
    pub fn level(&self, factor: &str, level: &str) -> String {
        names::level(self.known(), factor, level).to_string()
    }

    /// Returns the title of an axis for a parameter, or for its logarithm.
    pub fn axis(&self, name: &str, log: bool) -> String {
        match log {
            true => format!("{} (base-10 logarithm)", names::heading(self.known(), name)),
            false => names::axis(self.known(), name),
        }
    }
}

/// Names a method that chooses levels in a sentence.
fn method(method: &Method) -> &'static str {
    match method {
        Method::Staircase(_) => "a staircase",
        Method::QuestPlus(_) => "QUEST+",
        Method::Constant(_) => "the method of constant stimuli",
    }
}

/// Names a task in words.
pub(crate) fn task(task: &Task) -> &'static str {
    match task.measures() {
        Measures::Ratings => "rating",
        Measures::Proportions => "forced choice",
        Measures::Detection => "detection (yes or no)",
        Measures::Comparisons => "comparison of pairs",
        Measures::Settings if task.dial().is_some_and(|dial| dial.parameter.is_none()) => "rating on a slider",
        Measures::Settings => "adjustment",
    }
}

/// Names the answers to a task other than a rating on a scale of categories.
pub(crate) fn answers(task: &Task) -> String {
    match task {
        Task::Rating(_) => "answers on a slider".to_owned(),
        _ => format!("answers to the task {}", task.name()),
    }
}

impl From<&Protocol> for Asked {
    fn from(protocol: &Protocol) -> Self {
        let title = if protocol.title.trim().is_empty() { &protocol.name } else { &protocol.title };
        let levels = protocol.adaptive.as_ref().zip(Model::of(protocol)).map(|(adaptive, model)| Levels {
            common: adaptive.common.clone(),
            range: adaptive.range(),
            model,
            chosen_by: method(&adaptive.method),
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
            task: task(&protocol.task).to_owned(),
            measures: Some(protocol.task.measures()),
            factors,
            conditions,
            levels,
            dial: protocol.task.dial(),
            protocol: Some(protocol.clone()),
        }
    }
}
