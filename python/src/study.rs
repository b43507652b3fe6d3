//! Recorded data: reading, analyzing, verifying and exporting them.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use machband::{
    analysis::{Note, Results},
    experiment,
    report::{
        self, Contents, Provenance, Study, StudyError,
        study::shell_command,
        tasks::{self, TaskResults, TaskStudy},
    },
    stimulus::Stimulus,
    store::{
        FileError, FileErrors, Writer,
        ratings::{self, Listed},
        results,
        sidecar::Sidecar,
        table::List,
    },
    system::now,
    text::{Cell, Table},
    work::{Analyze, Export, Only, Ratings, Watcher as _, changed, verify::Verify, words},
};
use numpy::{IntoPyArray as _, PyArrayMethods as _};
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

/// Columns; and for each its unit and its description.
type Described = (Vec<(String, Column)>, Vec<(String, String, String)>);

/// Returns the rows of all sessions in a folder as columns, the last of which says whether a program answered; and the unit
/// and the description of each column.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn read_results(
    py: Python<'_>,
    folder: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'_, PyDict>, Vec<(String, String, String)>)> {
    let (columns, described) = job::run(py, progress, false, move |job| read(&folder, job))?;
    Ok((table::columns(py, columns)?, described))
}

fn read(folder: &Path, job: &Job) -> anyhow::Result<Described> {
    let files = Listed::sessions(folder).complete(folder)?.files;
    let (mut described, mut sessions, mut simulated) = (Vec::new(), Vec::new(), Vec::new());
    for (i, csv) in files.iter().enumerate() {
        job.progress(i as u64, files.len() as u64);
        let header = ratings::column_names(csv)?;
        let columns = experiment::columns_by_header(header.iter().map(String::as_str));
        let rows = results::read(csv, &columns)?;
        let sidecar = Sidecar::read(&csv.with_extension("json"))?;
        let of_program = |sidecar: Sidecar| sidecar.sittings.iter().any(|sitting| sitting.observer.is_some());
        let of_program = sidecar.is_some_and(of_program);
        simulated.extend(rows.iter().map(|_| i64::from(of_program)));
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
    let columns = described.iter().zip(&values).map(|(known, values)| (known.name.clone(), Column::of(values)));
    let columns = columns.chain([(experiment::SIMULATED.to_owned(), Column::Whole(simulated))]).collect();
    let described = described.into_iter().map(|column| (column.name, column.unit, column.description));
    let about =
        (experiment::SIMULATED.to_owned(), String::new(), "Whether a program answered instead of a person.".to_owned());
    Ok((columns, described.chain([about]).collect()))
}

/// The answers of a study and their analysis.
#[derive(Clone)]
enum Found {
    Ratings(Arc<Study>, Arc<Results>),
    Task(Arc<TaskStudy>, Arc<TaskResults>),
}

/// An analysis.
#[pyclass(frozen, module = "machband._machband")]
pub struct Analysis {
    found: Found,
    command: String,
}

/// Where the data come from.
#[derive(FromPyObject)]
pub enum Data<'py> {
    Paths(Vec<String>),
    /// A table: the names of its columns, and their cells.
    Columns(Vec<(String, Given<'py>)>),
}

/// The name of a table in messages.
const TABLE: &str = "table";

/// Analyzes ratings or the answers to a task with the command's options. `orders` are those of columns of the data. Rows with errors are an error unless they are to
/// be dropped. Progress counts the simulated studies.
#[pyfunction]
pub fn analyze(
    py: Python<'_>,
    mut fields: Fields,
    data: Data<'_>,
    orders: Vec<(String, Vec<String>)>,
    drop_errors: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Analysis> {
    let (paths, columns) = match data {
        Data::Paths(paths) => (paths, None),
        Data::Columns(columns) => (vec![TABLE.to_owned()], Some(table::given(&columns)?)),
    };
    fields.insert("paths".to_owned(), Field::List(paths));
    let mut asked: Analyze = request(fields)?;
    asked.ratings.orders = orders.into_iter().map(|(factor, levels)| Only { factor, levels }).collect();
    let command = if columns.is_some() { call(&asked) } else { command(&asked) };
    let found = job::run(py, progress, false, move |job| {
        let refused = |errors: &[FileError], is_many: bool| match errors {
            [_, ..] if !drop_errors || is_many => Err(StudyError::Files(FileErrors(errors.to_vec()))),
            _ => Ok(()),
        };
        let of_task = |study: TaskStudy| {
            let wrong: usize = study.errors.iter().map(|error| error.rows.len()).sum();
            let right: usize = study.files.iter().map(|(_, rows)| rows).sum();
            // More than 2 % of the rows. Of ratings, the library itself drops no more.
            refused(&study.errors, 49 * wrong > right)?;
            let results = TaskResults::of(&study, asked.resampling.seed);
            Ok(Found::Task(Arc::new(study), Arc::new(results)))
        };
        let study = match columns {
            Some(columns) => match asked.answers_in(TABLE, &columns)? {
                Some(study) => return of_task(study),
                None => asked.read_columns(TABLE, columns)?,
            },
            None => match asked.read_task()? {
                Some(study) => return of_task(study),
                None => asked.read()?,
            },
        };
        refused(&study.source.errors, false)?;
        let results = asked.analyze(&study, job)?;
        Ok(Found::Ratings(Arc::new(study), Arc::new(results)))
    })?;
    Ok(Analysis { found, command })
}

/// Returns the command that repeats an analysis of files.
fn command(asked: &Analyze) -> String {
    shell_command(std::iter::once("analyze".to_owned()).chain(words(asked)))
}

/// Returns the call that repeats the analysis of a table.
fn call(asked: &Analyze) -> String {
    let dict = |all: &mut dyn Iterator<Item = (&String, &[String])>| {
        let all: Vec<String> = all.map(|(factor, levels)| format!("{factor:?}: {levels:?}")).collect();
        format!("{{{}}}", all.join(", "))
    };
    let Ratings { only, levels, factors, .. } = &asked.ratings;
    let order = |name: &String| levels.iter().find(|one| one.factor == *name).map_or(&[][..], |one| &one.levels);
    let field = |(name, value): (String, Value)| match (name.as_str(), factors) {
        ("paths" | "levels", _) => String::new(),
        ("only", _) => format!(", only={}", dict(&mut only.iter().map(|one| (&one.factor, &one.levels[..])))),
        ("factors", Some(List(names))) if !levels.is_empty() => {
            format!(", factors={}", dict(&mut names.iter().map(|name| (name, order(name)))))
        }
        _ => format!(", {name}={}", argument(&value)),
    };
    let fields: Vec<String> = changed(asked).into_iter().map(field).collect();
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

fn files<'py>(py: Python<'py>, contents: Contents) -> Files<'py> {
    contents.into_iter().map(|(name, content)| (name, PyBytes::new(py, &content))).collect()
}

#[pymethods]
impl Analysis {
    /// Returns the tables, the model and the script as the command writes them.
    fn table_files<'py>(&self, py: Python<'py>) -> PyResult<Files<'py>> {
        let contents = match &self.found {
            Found::Ratings(study, results) => report::table_files(study, results),
            Found::Task(study, results) => {
                let tables = tasks::tables(study, results).into_iter();
                tables.map(|(name, table)| (format!("{name}.csv"), table.csv())).collect()
            }
        };
        Ok(files(py, contents))
    }

    /// Returns the tables as columns, with the name, unit and description of each column.
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<Vec<DescribedTable<'py>>> {
        let tables: Vec<(String, Table)> = match &self.found {
            Found::Ratings(study, results) => {
                let counts = report::tables::counts(results.modeled(), &study.source.shape);
                report::tables::all(results).into_iter().chain([("counts".to_owned(), counts)]).collect()
            }
            Found::Task(study, results) => {
                tasks::tables(study, results).into_iter().map(|(name, table)| (name.to_owned(), table)).collect()
            }
        };
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
        let (found, provenance) = (self.found.clone(), Provenance::new(self.command.clone(), now()));
        let here = Path::new(".");
        let contents = job::run(py, None, false, move |_| match found {
            Found::Ratings(study, results) => Ok(report::report_files(&study, &results, &provenance, here)?.0),
            Found::Task(study, results) => {
                let mut contents = report::task_files(&study, &results, &provenance, here, false)?;
                contents.drain(..tasks::tables(&study, &results).len());
                Ok(contents)
            }
        })?;
        Ok(files(py, contents))
    }

    /// Returns the paths of the files that were read.
    fn inputs(&self) -> Vec<PathBuf> {
        match &self.found {
            Found::Ratings(study, _) => study.source.files.iter().map(|file| file.path.clone()).collect(),
            Found::Task(study, _) => study.files.iter().map(|(path, _)| path.clone()).collect(),
        }
    }

    /// Returns the covariance of the model's parameters, row by row: thresholds, coefficients and standard deviations.
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let model = match &self.found {
            Found::Ratings(_, results) => results.model.as_ref().ok().map(|report| &report.model),
            Found::Task(..) => None,
        };
        let size = model.map_or(0, |model| model.covariance.nrows());
        let cells: Vec<f64> = model.iter().flat_map(|model| model.covariance.iter().copied()).collect();
        Ok(cells.into_pyarray(py).reshape([size, size])?.into_any())
    }

    /// Returns the sentences of the summary, and the summary as HTML without a page around it.
    fn summaries(&self) -> (Vec<String>, String) {
        let document = match &self.found {
            Found::Ratings(study, results) => {
                report::study::document(&study.source, results, report::study::Parts::default())
            }
            Found::Task(study, results) => tasks::document(study, results, &[], None),
        };
        let summary = document.sections.first();
        (
            summary.map(report::skins::terminal).unwrap_or_default(),
            summary.map_or_else(String::new, report::skins::fragment),
        )
    }

    /// Returns the warnings about the input, and its errors. Ratings that the model cannot use are a warning.
    fn problems(&self) -> (Vec<String>, Vec<String>) {
        let texts = |errors: &[FileError]| errors.iter().map(ToString::to_string).collect();
        let (study, results) = match &self.found {
            Found::Ratings(study, results) => (study, results),
            Found::Task(study, _) => return (texts(&study.warnings), texts(&study.errors)),
        };
        let mut warnings: Vec<String> = texts(&study.source.warnings);
        let notes = results.model.iter().flat_map(|report| &report.model.notes);
        let lost = notes.filter(|note| matches!(note, Note::MissingValues { .. }));
        warnings.extend(lost.map(|note| format!("the model: {note}")));
        (warnings, texts(&study.source.errors))
    }
}

/// Writes the files of an analysis into a folder, which none of the `inputs` may be in; `force` replaces an earlier
/// analysis. Returns their paths.
#[pyfunction]
pub fn write_analysis(
    py: Python<'_>,
    folder: PathBuf,
    files: Vec<(String, Vec<u8>)>,
    inputs: Vec<PathBuf>,
    force: bool,
) -> PyResult<Vec<PathBuf>> {
    job::run(py, None, true, move |_| {
        let writer = Writer::new(inputs, force);
        Ok(report::write_files(&writer, &folder, files)?)
    })
}

/// Verifies the sessions in a folder. Returns the path of each with a sentence about it, and all errors.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn verify(
    py: Python<'_>,
    folder: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Vec<(PathBuf, String)>, Vec<String>)> {
    let found = job::run(py, progress, false, move |job| Verify { folder }.verify(job))?;
    Ok((found.files, found.errors.iter().map(ToString::to_string).collect()))
}

/// Exports the sessions in a folder. Returns the names of the experiments, and the numbers of sessions, rows and
/// pictures.
#[pyfunction]
pub fn export(py: Python<'_>, fields: Fields) -> PyResult<(Vec<String>, [usize; 3])> {
    let request: Export = request(fields)?;
    let exported = job::run(py, None, true, move |job| request.export(job))?;
    Ok((exported.experiments, [exported.sessions, exported.rows, exported.pictures]))
}
