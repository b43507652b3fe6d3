//! Recorded data: reading, analyzing, verifying and exporting them.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use machband::{
    analysis::{Note, Results},
    experiment,
    report::{self, Provenance, Study, document::Section, study::shell_command},
    stimulus::Stimulus,
    store::{
        Writer,
        ratings::{self, Listed},
        results,
        sidecar::Sidecar,
    },
    system::now,
    text::{Cell, Table},
    work::{
        Analyze, Export, changed,
        verify::{Verified, Verify},
        words,
    },
};
use pyo3::{
    prelude::*,
    types::{PyBytes, PyDict},
};
use serde_json::Value;

use crate::{
    Field, Fields,
    job::{self, Job},
    request,
    table::{self, Column, Given},
};

/// Columns; for each its unit and its description; and whether an observer was simulated.
type Described = (Vec<(String, Column)>, Vec<(String, String, String)>, bool);

/// Returns the rows of all sessions in a folder as columns; the unit and the description of each column; and whether an
/// observer was simulated.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn read_results(
    py: Python<'_>,
    folder: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'_, PyDict>, Vec<(String, String, String)>, bool)> {
    let (columns, described, simulated) = job::run(py, progress, false, move |job, _| read(&folder, job))?;
    Ok((table::columns(py, columns)?, described, simulated))
}

fn read(folder: &Path, job: &Job) -> anyhow::Result<Described> {
    let files = Listed::sessions(folder).complete(folder)?.files;
    let (mut described, mut sessions, mut simulated) = (Vec::new(), Vec::new(), false);
    for (i, csv) in files.iter().enumerate() {
        job.set(i, files.len());
        let header = ratings::column_names(csv)?;
        let columns = experiment::columns_by_header(header.iter().map(String::as_str));
        let rows = results::read(csv, &columns)?.rows;
        let sidecar = Sidecar::read(&csv.with_extension("json"))?;
        simulated |= sidecar.is_some_and(|sidecar| sidecar.sittings.iter().any(|sitting| sitting.observer.is_some()));
        let kind = rows.first().and_then(|row| Stimulus::default_of(&row.stimulus));
        for mut column in columns.iter().cloned() {
            let known = kind.iter().flat_map(|kind| kind.parameters()).find(|known| known.name == column.name);
            if let Some(known) = known.filter(|_| column.description.is_empty()) {
                (column.unit, column.description) = (known.unit.to_owned(), known.description.to_owned());
            }
            if !described.iter().any(|known: &experiment::Column| known.name == column.name) {
                described.push(column);
            }
        }
        sessions.push((columns, rows));
    }
    // One list for each column, of the values in all rows.
    let mut values = vec![Vec::new(); described.len()];
    for (columns, rows) in sessions {
        let place = |known: &experiment::Column| columns.iter().position(|column| column.name == known.name);
        let places: Vec<Option<usize>> = described.iter().map(place).collect();
        for row in rows {
            let row = row.values();
            for (column, place) in values.iter_mut().zip(&places) {
                column.push(place.map_or(Cell::Missing, |place| row[place].clone()));
            }
        }
    }
    let columns =
        described.iter().zip(&values).map(|(known, values)| (known.name.clone(), Column::of(values))).collect();
    let described = described.into_iter().map(|column| (column.name, column.unit, column.description)).collect();
    Ok((columns, described, simulated))
}

/// An analysis: the ratings, and the results.
#[pyclass(frozen, module = "machband._machband")]
pub struct Analysis {
    study: Arc<Study>,
    results: Arc<Results>,
    command: String,
}

/// Where ratings come from.
#[derive(FromPyObject)]
pub enum Ratings<'py> {
    Paths(Vec<String>),
    /// A table: the names of its columns, and their cells.
    Columns(Vec<(String, Given<'py>)>),
}

/// The name of a table in messages.
const TABLE: &str = "table";

/// Analyzes ratings with the command's options. Progress counts the simulated studies.
#[pyfunction]
pub fn analyze(
    py: Python<'_>,
    mut fields: Fields,
    ratings: Ratings<'_>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Analysis> {
    let (paths, columns) = match ratings {
        Ratings::Paths(paths) => (paths, None),
        Ratings::Columns(columns) => (vec![TABLE.to_owned()], Some(table::given(&columns)?)),
    };
    fields.insert("paths".to_owned(), Field::List(paths));
    let asked: Analyze = request(fields)?;
    let command = if columns.is_some() { call(&asked) } else { command(&asked) };
    let (study, results) = job::run(py, progress, false, move |job, _| {
        let study = match columns {
            Some(columns) => asked.read_columns(TABLE, columns)?,
            None => asked.read()?,
        };
        let results = asked.analyze(&study, job)?;
        Ok((Arc::new(study), Arc::new(results)))
    })?;
    Ok(Analysis { study, results, command })
}

/// Returns the command that repeats an analysis of files.
fn command(asked: &Analyze) -> String {
    shell_command(std::iter::once("analyze".to_owned()).chain(words(asked)))
}

/// Returns the call that repeats the analysis of a table.
fn call(asked: &Analyze) -> String {
    let fields = changed(asked).into_iter().filter(|(name, _)| name != "paths");
    let fields: Vec<String> = fields.map(|(name, value)| format!(", {name}={}", argument(&value))).collect();
    format!("# The data came as a table from Python.\nmachband.analyze({TABLE}{})", fields.concat())
}

/// Writes a value as Python does.
fn argument(value: &Value) -> String {
    match value {
        Value::Bool(true) => "True".to_owned(),
        value => value.to_string(),
    }
}

/// A table: its name, its columns, and the name, unit and description of each column.
type DescribedTable<'py> = (String, Bound<'py, PyDict>, Vec<(String, String, String)>);

/// Files: their names and contents.
type Files<'py> = Vec<(String, Bound<'py, PyBytes>)>;

#[pymethods]
impl Analysis {
    /// Returns the tables, the model and the script as the command writes them.
    fn table_files<'py>(&self, py: Python<'py>) -> Files<'py> {
        let files = report::table_files(&self.study, &self.results).into_iter();
        files.map(|(name, content)| (name, PyBytes::new(py, &content))).collect()
    }

    /// Returns the tables as columns, with the name, unit and description of each column.
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<Vec<DescribedTable<'py>>> {
        let counts = report::tables::counts(self.results.modeled(), &self.study.source.shape);
        let mut tables = report::tables::all(&self.results);
        tables.push(("counts".to_owned(), counts));
        let described = |(name, table): (String, Table)| {
            let columns = table.columns.iter().map(|column| (column.name.clone(), Column::of(&column.cells)));
            let columns = table::columns(py, columns)?;
            let about =
                table.columns.into_iter().map(|column| (column.name, column.unit, column.description)).collect();
            Ok((name, columns, about))
        };
        tables.into_iter().map(described).collect()
    }

    /// Returns the report and the figures.
    fn report_files<'py>(&self, py: Python<'py>) -> PyResult<Files<'py>> {
        let (study, results, provenance) = (Arc::clone(&self.study), Arc::clone(&self.results), self.provenance());
        let files = job::run(py, None, false, move |_, _| {
            Ok(report::report_files(&study, &results, &provenance, Path::new("."))?.0)
        })?;
        Ok(files.into_iter().map(|(name, content)| (name, PyBytes::new(py, &content))).collect())
    }

    /// Writes all files into a folder.
    fn save(&self, py: Python<'_>, folder: PathBuf, tables_only: bool, force: bool) -> PyResult<Vec<PathBuf>> {
        let (study, results, provenance) = (Arc::clone(&self.study), Arc::clone(&self.results), self.provenance());
        job::run(py, None, true, move |_, _| {
            let read: Vec<PathBuf> = study.source.files.iter().map(|file| file.path.clone()).collect();
            let writer = Writer::new(read, force);
            Ok(report::write_all(&writer, &study, &results, &provenance, &folder, tables_only)?.files)
        })
    }

    /// Returns the sentences of the summary.
    fn summary(&self) -> Vec<String> {
        self.first_section(report::skins::terminal)
    }

    /// Returns the summary as HTML without a page around it.
    fn summary_html(&self) -> String {
        self.first_section(report::skins::fragment)
    }

    /// Returns the warnings about the input, and its errors. Ratings that the model cannot use are a warning.
    fn problems(&self) -> (Vec<String>, Vec<String>) {
        let texts = |errors: &[machband::store::FileError]| errors.iter().map(ToString::to_string).collect();
        let mut warnings: Vec<String> = texts(&self.study.source.warnings);
        let notes = self.results.model.iter().flat_map(|report| &report.model.notes);
        let lost = notes.filter(|note| matches!(note, Note::MissingValues { .. }));
        warnings.extend(lost.map(|note| format!("the model: {note}")));
        (warnings, texts(&self.study.source.errors))
    }
}

impl Analysis {
    /// Shows the summary with a skin.
    fn first_section<T: Default>(&self, skin: impl Fn(&Section) -> T) -> T {
        let document = report::study::document(&self.study.source, &self.results, report::study::Parts::default());
        document.sections.first().map(skin).unwrap_or_default()
    }

    fn provenance(&self) -> Provenance {
        Provenance::new(self.command.clone(), now())
    }
}

/// Verifies the sessions in a folder. Returns the path of each with a sentence about it, and all errors.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn verify(
    py: Python<'_>,
    folder: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Vec<(PathBuf, String)>, Vec<String>)> {
    let Verified { found, .. } = job::run(py, progress, false, move |job, _| Verify { folder }.verify(job))?;
    Ok((found.files, found.errors.iter().map(ToString::to_string).collect()))
}

/// Exports the sessions in a folder. Returns the names of the experiments, and the numbers of sessions, rows and
/// pictures.
#[pyfunction]
pub fn export(py: Python<'_>, fields: Fields) -> PyResult<(Vec<String>, [usize; 3])> {
    let request: Export = request(fields)?;
    let exported = job::run(py, None, true, move |job, _| request.export(job))?;
    Ok((exported.experiments, [exported.sessions, exported.rows, exported.pictures]))
}
