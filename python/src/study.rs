//! Recorded data: reading, analyzing, verifying and exporting them.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use machband::{
    analysis::Note,
    experiment,
    report::{self, Analyzed, Contents, Provenance},
    stimulus::Stimulus,
    store::{
        FileError, FileErrors, Writer,
        ratings::{self, Listed},
        results,
        sidecar::Sidecar,
    },
    system::now,
    text::{Cell, Column, Table},
    work::{Analyze, Export, Watcher as _, command, verify::Verify},
};
use numpy::{IntoPyArray as _, PyArrayMethods as _};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    Field, Fields,
    job::{self, Job},
    request,
    table::{self, Described, Given, described},
};

/// Returns the rows of all sessions in a folder as a table, the last column of which says whether a program answered.
#[pyfunction]
pub fn read_results(py: Python<'_>, folder: PathBuf, progress: Option<Py<PyAny>>) -> PyResult<Described<'_>> {
    described(py, job::run(py, progress, false, move |job| read(&folder, job))?)
}

fn read(folder: &Path, job: &Job) -> anyhow::Result<Table> {
    let files = Listed::sessions(folder).complete(folder)?.files;
    let (mut all, mut simulated) = (Vec::<Column>::new(), Vec::new());
    for (i, csv) in files.iter().enumerate() {
        job.progress(i as u64, files.len() as u64);
        let header = ratings::column_names(csv)?;
        let columns = experiment::columns_by_header(header.iter().map(String::as_str));
        let rows = results::read(csv, &columns)?;
        let before = simulated.len();
        let sidecar = Sidecar::read(&csv.with_extension("json"))?;
        let of_program = |sidecar: Sidecar| sidecar.sittings.iter().any(|sitting| sitting.observer.is_some());
        simulated.resize(before + rows.len(), u32::from(sidecar.is_some_and(of_program)).into());
        let kind = rows.first().and_then(|row| Stimulus::default_of(&row.stimulus));
        let place = |experiment::Column { name, unit, description, .. }: &experiment::Column| {
            all.iter().position(|known| known.name == *name).unwrap_or_else(|| {
                let mut parameters = kind.iter().flat_map(|kind| kind.parameters());
                let known = parameters.find(|known| description.is_empty() && known.name == name);
                let (unit, about) = known.map_or((&**unit, &**description), |known| (known.unit, known.description));
                all.push(Column { cells: vec![Cell::Missing; before], ..Column::new(name, unit, about) });
                all.len() - 1
            })
        };
        let places: Vec<usize> = columns.iter().map(place).collect();
        for row in rows {
            places.iter().zip(row.values()).for_each(|(place, cell)| all[*place].cells.push(cell));
        }
        // A cell that a session does not have is missing.
        all.iter_mut().for_each(|column| column.cells.resize(simulated.len(), Cell::Missing));
    }
    let about = "Whether a program answered instead of a person.";
    all.push(Column { cells: simulated, ..Column::new(experiment::SIMULATED, "", about) });
    Ok(Table { columns: all })
}

/// An analysis.
#[pyclass(frozen, module = "machband._machband")]
pub struct Analysis {
    found: Arc<Analyzed>,
    /// What repeats it.
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

/// Analyzes ratings or the answers to a task with the command's options; `call` has the arguments that repeat the analysis
/// of a table. `orders` are those of columns of the data. Rows with errors are an error unless they are to be dropped.
/// Progress counts the simulated studies.
#[pyfunction]
pub fn analyze(
    py: Python<'_>,
    mut fields: Fields,
    data: Data<'_>,
    orders: Vec<(String, Vec<String>)>,
    drop_errors: bool,
    call: String,
    progress: Option<Py<PyAny>>,
) -> PyResult<Analysis> {
    let (paths, columns) = match data {
        Data::Paths(paths) => (paths, None),
        Data::Columns(columns) => (vec![TABLE.to_owned()], Some(table::given(&columns)?)),
    };
    fields.insert("paths".to_owned(), Field::List(paths));
    let mut asked: Analyze = request(fields)?;
    asked.ratings.how.orders = orders;
    let table = format!("# The data came as a table from Python.\nmachband.analyze({TABLE}{call})");
    let command = if columns.is_some() { table } else { command("analyze", &asked, &[]) };
    let found = job::run(py, progress, false, move |job| {
        let refused = |errors: &[FileError], is_many: bool| match errors {
            [_, ..] if !drop_errors || is_many => Err(FileErrors(errors.to_vec())),
            _ => Ok(()),
        };
        let task = columns.as_ref().map_or_else(|| asked.read_task(), |columns| asked.answers_in(TABLE, columns))?;
        if let Some(study) = task {
            let wrong: usize = study.errors.iter().map(|error| error.rows.len()).sum();
            let right: usize = study.files.iter().map(|(_, rows)| rows).sum();
            // More than 2 % of the rows. Of ratings, the library itself drops no more.
            refused(&study.errors, 49 * wrong > right)?;
            return Ok(asked.analyze_task(study));
        }
        let study = columns.map_or_else(|| asked.read(), |columns| asked.read_columns(TABLE, columns))?;
        refused(&study.source.errors, false)?;
        Ok(asked.analyze(study, job)?)
    })?;
    Ok(Analysis { found: found.into(), command })
}

#[pymethods]
impl Analysis {
    /// Returns everything but the report and the figures, which take longer: the tables with their columns; the files, as
    /// the command writes them; the covariance of the model's parameters (thresholds, coefficients and standard
    /// deviations); the summary as text and as HTML without a page around it; the paths of the files that were read; and
    /// warnings and errors about the input. Ratings that the model cannot use are a warning.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (mut tables, [errors, warnings]) = (self.found.tables(), self.found.problems());
        let mut model = None;
        if let Analyzed::Ratings(source, results) = &*self.found {
            tables.push(("counts".to_owned(), report::tables::counts(results.modeled(), &source.shape)));
            model = results.model.as_ref().ok().map(|report| &report.model);
        }
        let tables = tables.into_iter().map(|(name, table)| Ok((name, described(py, table)?)));
        let size = model.map_or(0, |model| model.covariance.nrows());
        let covariance: Vec<f64> = model.iter().flat_map(|model| model.covariance.iter().copied()).collect();
        let document = self.found.document(&[], None);
        let summary = document.sections.first();
        let lost =
            model.iter().flat_map(|model| &model.notes).filter(|note| matches!(note, Note::MissingValues { .. }));
        let lost = lost.map(|note| format!("the model: {note}"));
        let texts = |errors: &[FileError]| errors.iter().map(ToString::to_string).collect::<Vec<_>>();
        let facts = PyDict::new(py);
        facts.set_item("tables", tables.collect::<PyResult<Vec<_>>>()?)?;
        facts.set_item("files", self.found.table_files())?;
        facts.set_item("covariance", covariance.into_pyarray(py).reshape([size, size])?)?;
        facts.set_item("summary", summary.map(report::skins::terminal).unwrap_or_default().join("\n"))?;
        facts.set_item("page", summary.map_or_else(String::new, report::skins::fragment))?;
        facts.set_item("inputs", self.found.inputs())?;
        facts.set_item("warnings", texts(warnings).into_iter().chain(lost).collect::<Vec<_>>())?;
        facts.set_item("errors", texts(errors))?;
        Ok(facts)
    }

    /// Returns the report and the figures: the names of files, and their contents.
    fn report_files(&self, py: Python<'_>) -> PyResult<Contents> {
        let (found, provenance) = (self.found.clone(), Provenance::new(self.command.clone(), now()));
        job::run(py, None, false, move |_| Ok(found.report_files(&provenance, Path::new("."))?))
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
