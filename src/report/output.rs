//! The output of `machband analyze` and of the export on the window's analysis page.

use std::{
    fmt::Display,
    path::{Path, PathBuf},
};

use rayon::prelude::*;
use serde_json::{Map, Value};

use super::{
    document::Document,
    figures::{self, Figure},
    prediction::StudyPrediction,
    script, skins,
    study::{Parts, Provenance, Study, document},
    tables,
    tasks::{self, TaskResults, TaskStudy},
};
use crate::{
    analysis::Results,
    store::{StoreError, Writer},
    system::found,
    text::Table,
};

/// A file that every analysis has.
const CELLS: &str = "cells.csv";

/// The files of an analysis: their names and contents.
pub type Contents = Vec<(String, Vec<u8>)>;

/// Returns the files of an analysis: the tables and the model and, unless `tables_only` is set, the figures and the report,
/// with the prediction in it. `folder` is where they will be, for error messages.
///
/// # Errors
/// A figure cannot be drawn.
pub fn study_files(
    study: &Study,
    results: &Results,
    provenance: &Provenance,
    folder: &Path,
    tables_only: bool,
) -> Result<Contents, StoreError> {
    let mut contents = table_files(study, results);
    if !tables_only {
        contents.extend(report_files(study, results, provenance, folder)?);
    }
    Ok(contents)
}

/// Writes the files of an analysis into a folder, or none if one of them cannot be written. Returns their paths.
///
/// # Errors
/// The same errors as [`check_folder`] and [`Writer::write_all`].
pub fn write_files(writer: &Writer, folder: &Path, contents: Contents) -> Result<Vec<PathBuf>, StoreError> {
    check_folder(writer, folder)?;
    writer.make_folder(folder)?;
    let files: Vec<_> = contents.into_iter().map(|(name, content)| (folder.join(name), content)).collect();
    writer.write_all(&files)?;
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

/// Returns the report and the figures. `folder` is where they will be, for error messages.
///
/// # Errors
/// A figure cannot be drawn.
pub fn report_files(
    study: &Study,
    results: &Results,
    provenance: &Provenance,
    folder: &Path,
) -> Result<Contents, StoreError> {
    let predict = || StudyPrediction::of(&study.source, &results.measured.counts);
    let (predicted, mut figures) = rayon::join(predict, || figures::all(results));
    figures.extend(study.source.protocol.as_ref().and_then(figures::stimulus));
    figures.extend(predicted.iter().flat_map(|predicted| figures::predicted(results, &predicted.ratings)));
    let parts = Parts { figures: &figures, prediction: Some(&predicted), provenance: Some(provenance) };
    page(&document(&study.source, results, parts), &figures, provenance, folder)
}

/// Returns the files of the analysis of a task: its tables and, unless `tables_only` is set, the figures and the report.
/// `folder` is where they will be, for error messages.
///
/// # Errors
/// A figure cannot be drawn.
pub fn task_files(
    study: &TaskStudy,
    results: &TaskResults,
    provenance: &Provenance,
    folder: &Path,
    tables_only: bool,
) -> Result<Contents, StoreError> {
    let mut contents = csv_files(tasks::tables(study, results));
    if !tables_only {
        let mut figures = tasks::figures(study, results);
        figures.extend(study.asked.protocol.as_ref().and_then(figures::stimulus));
        contents.extend(page(
            &tasks::document(study, results, &figures, Some(provenance)),
            &figures,
            provenance,
            folder,
        )?);
    }
    Ok(contents)
}

/// Checks before work starts that an analysis can be written into a folder, which need not exist yet.
///
/// # Errors
/// The same errors as [`Writer::check`], in particular if the folder has an earlier analysis.
pub fn check_folder(writer: &Writer, folder: &Path) -> Result<(), StoreError> {
    writer.check_folder(folder)?;
    let found = found(folder).map_err(|error| StoreError::io(folder, "access", error))?;
    found.map_or(Ok(()), |_| writer.check([folder.join(CELLS).as_path()]))
}

/// Returns a document as a page, and its figures.
fn page(
    document: &Document,
    figures: &[Figure],
    provenance: &Provenance,
    folder: &Path,
) -> Result<Contents, StoreError> {
    let mut contents = vec![("report.html".to_owned(), skins::html(document, provenance).into_bytes())];
    let drawn: Result<Vec<_>, StoreError> =
        figures.par_iter().map(|figure| png(figure, &folder.join(figure.name))).collect();
    for (Figure { name, svg, .. }, png) in figures.iter().zip(drawn?) {
        contents.extend([(format!("{name}.svg"), svg.clone().into_bytes()), (format!("{name}.png"), png)]);
    }
    Ok(contents)
}

/// Returns a figure as the content of the PNG file at `path`.
///
/// # Errors
/// The figure cannot be drawn.
pub fn png(figure: &Figure, path: &Path) -> Result<Vec<u8>, StoreError> {
    figure.png().map_err(|error| StoreError::io(path, "draw", std::io::Error::other(error.to_string())))
}

/// Returns tables as CSV files, and a file that describes their columns.
fn csv_files(tables: Vec<(impl Display, Table)>) -> Contents {
    let (mut files, mut columns) = (Contents::new(), Map::new());
    for (name, table) in tables {
        let name = format!("{name}.csv");
        columns.insert(name.clone(), table.described());
        files.push((name, table.csv()));
    }
    files.push(("columns.json".to_owned(), format!("{:#}\n", Value::from(columns)).into_bytes()));
    files
}

/// Returns the tables, the model and the script that repeats it in R.
pub fn table_files(study: &Study, results: &Results) -> Contents {
    let mut model = serde_json::to_vec_pretty(&tables::model(results)).unwrap_or_default();
    model.push(b'\n');
    let mut files = csv_files(tables::all(results));
    files.extend([
        ("counts.csv".to_owned(), tables::counts_csv(results.modeled(), &study.source.shape)),
        ("model.json".to_owned(), model),
        ("analysis.R".to_owned(), script::script(&study.source.shape, results).into_bytes()),
    ]);
    files
}
