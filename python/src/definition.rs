//! Definitions of experiments, their trials, and simulated sessions.

use std::path::PathBuf;

use machband::{
    experiment::{Condition, Identity, Protocol, SECOND, Schedule},
    stimulus::ParameterValue,
    store::definition,
    text::Cell,
    work::simulate::{self as work, Simulate},
};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    Field, Fields, error, job, request,
    table::{self, Column},
};

/// The definition of an experiment.
#[pyclass(frozen, module = "machband._machband")]
pub struct Definition(Protocol);

#[pymethods]
impl Definition {
    /// Reads a built-in definition or a file.
    #[staticmethod]
    fn load(name_or_path: PathBuf) -> PyResult<Self> {
        definition::open(name_or_path).map(Self).map_err(error)
    }

    /// Reads a definition that has the keys of a file, as JSON.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let value: serde_json::Value = serde_json::from_str(text).map_err(error)?;
        let text = toml::to_string(&value).map_err(error)?;
        definition::parse("definition", &text).map(Self).map_err(|errors| {
            // The lines of the text mean nothing to the caller.
            let messages: Vec<&str> = errors.0.iter().map(|error| error.message.as_str()).collect();
            error(messages.join("\n"))
        })
    }

    /// Reads what `to_json` returned.
    #[staticmethod]
    fn from_canonical(text: &str) -> PyResult<Self> {
        let value: serde_json::Value = serde_json::from_str(text).map_err(error)?;
        definition::from_json("definition", &value).map(Self).map_err(error)
    }

    /// Returns all keys as the text of a definition file.
    fn to_toml(&self) -> PyResult<String> {
        let value = serde_json::to_value(&self.0).map_err(error)?;
        let text = toml::to_string(&value).map_err(error)?;
        let read = definition::parse("definition", &text).map_err(error)?;
        if read == self.0 { Ok(text) } else { Err(error("the definition cannot be written as a file")) }
    }

    /// Returns all keys as JSON, with their defaults but without default texts.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.0).map_err(error)
    }

    /// SHA-256 of the content, as in the sidecars.
    #[getter]
    fn sha256(&self) -> String {
        definition::hash(&self.0)
    }

    /// Returns the conditions as columns: the kind, and every parameter of the stimulus.
    fn conditions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let conditions = self.0.conditions();
        let kind: Vec<_> = conditions.iter().map(|_| Cell::from(self.0.stimulus.kind())).collect();
        let names = self.0.stimulus.parameters().iter().map(|parameter| parameter.name);
        let parameters = names.map(|name| (name.to_owned(), parameter(conditions, name)));
        table::columns(py, [("stimulus".to_owned(), Column::of(&kind))].into_iter().chain(parameters))
    }

    /// Returns the trials of a session as columns. `condition` counts the conditions from 0.
    fn schedule<'py>(
        &self,
        py: Python<'py>,
        participant: &str,
        session: &str,
        seed: u64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let identity = Identity::new(participant, session).map_err(error)?;
        let (protocol, seed) = (self.0.clone(), seed);
        let schedule = job::run(py, None, false, move |_| Ok(Schedule::new(&protocol, &identity, seed)?))?;
        let whole =
            |of: fn(&machband::experiment::Trial) -> i64| Column::Whole(schedule.trials.iter().map(of).collect());
        let phases = schedule.trials.iter().map(|trial| Some(trial.phase.to_string())).collect();
        let fixed = [
            ("phase", Column::Text(phases)),
            ("block", whole(|trial| trial.block.into())),
            ("trial", whole(|trial| trial.number.into())),
            ("repetition", whole(|trial| trial.repetition.into())),
        ];
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for trial in &schedule.trials {
            match (trial.planned_pair(&self.0), self.0.pairs()) {
                (Some([left, right]), _) => {
                    first.push(left);
                    second.push(right);
                }
                (None, None) => first.push(trial.condition),
                // The answers decide which conditions are compared.
                (None, Some(_)) => {}
            }
        }
        let planned = [("", first), (SECOND, second)].into_iter().filter(|(_, places)| !places.is_empty());
        let shown = planned.flat_map(|(suffix, places)| {
            let conditions: Vec<Condition> = places.iter().map(|place| schedule.conditions[*place].clone()).collect();
            let place = Column::Whole(places.iter().map(|place| *place as i64).collect());
            let factor = |name: &str| (format!("{name}{suffix}"), parameter(&conditions, name));
            let factors: Vec<_> = self.0.factors.iter().map(|of| factor(&of.name)).collect();
            std::iter::once((format!("condition{suffix}"), place)).chain(factors)
        });
        table::columns(py, fixed.map(|(name, column)| (name.to_owned(), column)).into_iter().chain(shown))
    }
}

/// Returns a parameter of each condition.
fn parameter(conditions: &[Condition], name: &str) -> Column {
    let value = |condition: &Condition| match condition.stimulus.get(name) {
        // The only word among the levels of a number is an infinite depth.
        Some(ParameterValue::Text(text)) if text == "inf" => Cell::Number(f64::INFINITY),
        value => value.into(),
    };
    Column::of(&conditions.iter().map(value).collect::<Vec<_>>())
}

/// Runs simulated sessions as the command does, with its options.
#[pyfunction]
pub fn simulate(
    py: Python<'_>,
    definition: &Bound<'_, Definition>,
    mut fields: Fields,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let protocol = definition.get().0.clone();
    fields.insert("experiment".to_owned(), Field::Text(protocol.name.clone()));
    let asked: Simulate = request(fields)?;
    job::run(py, progress, true, move |job| work::simulate(&asked, &protocol, job).map(drop))
}
