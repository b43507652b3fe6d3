//! Definitions of experiments, their trials, and simulated sessions.

use std::path::PathBuf;

use machband::{
    experiment::{Condition, Identity, Protocol, SECOND, Schedule, Trial},
    stimulus::ParameterValue,
    store::definition,
    text::{Cell, Column, Table},
    work::simulate::{self as work, Simulate},
};
use pyo3::prelude::*;

use crate::{
    Field, Fields, error, job, request,
    table::{Described, described},
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

    /// Returns the conditions as a table: the kind, and every parameter of the stimulus.
    fn conditions<'py>(&self, py: Python<'py>) -> PyResult<Described<'py>> {
        let stimulus = &self.0.stimulus;
        let names = || stimulus.parameters().iter().map(|parameter| parameter.name);
        let columns = std::iter::once("stimulus").chain(names()).map(|name| Column::new(name, "", "")).collect();
        let row = |condition: &Condition| {
            let levels = names().map(|name| parameter(condition, name));
            std::iter::once(Cell::from(stimulus.kind())).chain(levels).collect()
        };
        described(py, Table::new(columns, self.0.conditions().iter().map(row)))
    }

    /// Returns the trials of a session as a table. `condition` counts the conditions from 0.
    fn schedule<'py>(&self, py: Python<'py>, participant: &str, session: &str, seed: u64) -> PyResult<Described<'py>> {
        let identity = Identity::new(participant, session).map_err(error)?;
        let schedule = py.detach(|| Schedule::new(&self.0, &identity, seed)).map_err(error)?;
        let shown = |trial: &Trial| match (trial.planned_pair(&self.0), self.0.pairs()) {
            (Some(pair), _) => pair.to_vec(),
            (None, None) => vec![trial.condition],
            // The answers decide which conditions are compared.
            (None, Some(_)) => Vec::new(),
        };
        let factors = || self.0.factors.iter().map(|factor| factor.name.as_str());
        let number = schedule.trials.first().map_or(0, |trial| shown(trial).len());
        let planned = ["", SECOND].into_iter().take(number).flat_map(|suffix| {
            std::iter::once("condition").chain(factors()).map(move |name| format!("{name}{suffix}"))
        });
        let names = ["phase", "block", "trial", "repetition"].map(str::to_owned).into_iter().chain(planned);
        let row = |trial: &Trial| {
            let mut row = vec![trial.phase.to_string().into(), trial.block.into(), trial.number.into()];
            row.push(trial.repetition.into());
            for place in shown(trial) {
                row.push(place.into());
                row.extend(factors().map(|name| parameter(&schedule.conditions[place], name)));
            }
            row
        };
        let columns = names.map(|name| Column::new(name, "", "")).collect();
        described(py, Table::new(columns, schedule.trials.iter().map(row)))
    }
}

/// Returns a parameter of a condition.
fn parameter(condition: &Condition, name: &str) -> Cell {
    match condition.stimulus.get(name) {
        // The only word among the levels of a number is an infinite depth.
        Some(ParameterValue::Text(text)) if text == "inf" => Cell::Number(f64::INFINITY),
        value => value.into(),
    }
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
