//! What an analysis found, and its files: the output of `machband analyze` and of the export on the window's analysis page.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Map, Value};

use super::{
    document::Document,
    figures::{self, Figure},
    script, skins,
    study::{self, Provenance},
    tables,
    tasks::{self, TaskResults, TaskStudy},
};
use crate::{
    analysis::Results,
    store::{FileError, StoreError, Writer, ratings::Source},
    system::found,
    text::Table,
};

/// A file that every analysis of ratings has.
const CELLS: &str = "cells.csv";

/// The files of an analysis: their names and contents.
pub type Contents = Vec<(String, Vec<u8>)>;

/// What was analyzed, with the results: ratings, or the answers to another task.
#[derive(Debug)]
pub enum Analyzed {
    Ratings(Box<Source>, Box<Results>),
    Task(Box<TaskStudy>, Box<TaskResults>),
}

impl Analyzed {
    /// Draws every chart for which there are data.
    pub fn figures(&self) -> Vec<Figure> {
        match self {
            Self::Ratings(_, results) => figures::all(results),
            Self::Task(study, results) => tasks::figures(study, results),
        }
    }

    /// Describes everything in a document with these charts; `provenance` says how to repeat the analysis, for readers who do
    /// not have it open.
    pub fn document(&self, figures: &[Figure], provenance: Option<&Provenance>) -> Document {
        match self {
            Self::Ratings(source, results) => study::document(source, results, figures, provenance),
            Self::Task(study, results) => tasks::document(study, results, figures, provenance),
        }
    }

    /// Returns all tables but the sufficient statistic of ratings, with the names of their files without the extension.
    pub fn tables(&self) -> Vec<(String, Table)> {
        match self {
            Self::Ratings(_, results) => tables::all(results),
            Self::Task(study, results) => {
                tasks::tables(study, results).into_iter().map(|(name, table)| (name.to_owned(), table)).collect()
            }
        }
    }

    /// Returns the errors and the warnings about the input.
    pub fn problems(&self) -> [&[FileError]; 2] {
        match self {
            Self::Ratings(source, _) => [&source.errors, &source.warnings],
            Self::Task(study, _) => [&study.errors, &study.warnings],
        }
    }

    /// Returns the files that were read.
    pub fn inputs(&self) -> Vec<&Path> {
        match self {
            Self::Ratings(source, _) => source.files.iter().map(|file| &*file.path).collect(),
            Self::Task(study, _) => study.files.iter().map(|(path, _)| &**path).collect(),
        }
    }

    /// Returns the tables, a file that describes their columns and, of ratings, the model and the script that repeats it in R.
    pub fn table_files(&self) -> Contents {
        let (mut files, mut columns) = (Contents::new(), Map::new());
        for (name, table) in self.tables() {
            let name = format!("{name}.csv");
            columns.insert(name.clone(), table.described());
            files.push((name, table.csv()));
        }
        files.push(("columns.json".to_owned(), format!("{:#}\n", Value::from(columns)).into_bytes()));
        if let Self::Ratings(source, results) = self {
            files.extend([
                ("counts.csv".to_owned(), tables::counts_csv(results.modeled(), &source.shape)),
                ("model.json".to_owned(), format!("{:#}\n", tables::model(results)).into_bytes()),
                ("analysis.R".to_owned(), script::script(results).into_bytes()),
            ]);
        }
        files
    }

    /// Returns the report and the figures. `folder` is where they will be, for error messages.
    ///
    /// # Errors
    /// A figure cannot be drawn.
    pub fn report_files(&self, provenance: &Provenance, folder: &Path) -> Result<Contents, StoreError> {
        let protocol = match self {
            Self::Ratings(source, _) => &source.protocol,
            Self::Task(study, _) => &study.asked.protocol,
        };
        let mut figures = self.figures();
        figures.extend(protocol.as_ref().and_then(figures::stimulus));
        let page = skins::html(&self.document(&figures, Some(provenance)), provenance);
        let mut contents = vec![("report.html".to_owned(), page.into_bytes())];
        let drawn: Result<Vec<_>, StoreError> =
            figures.par_iter().map(|figure| png(figure, &folder.join(figure.name))).collect();
        for (Figure { name, svg, .. }, png) in figures.iter().zip(drawn?) {
            contents.extend([(format!("{name}.svg"), svg.clone().into_bytes()), (format!("{name}.png"), png)]);
        }
        Ok(contents)
    }

    /// Writes the tables and, unless `tables_only` is set, the report and the figures into a folder. Returns their paths.
    ///
    /// # Errors
    /// The same errors as [`Analyzed::report_files`] and [`write_files`].
    pub fn write(
        &self,
        writer: &Writer,
        folder: &Path,
        provenance: &Provenance,
        tables_only: bool,
    ) -> Result<Vec<PathBuf>, StoreError> {
        let mut contents = self.table_files();
        if !tables_only {
            contents.extend(self.report_files(provenance, folder)?);
        }
        write_files(writer, folder, contents)
    }
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

/// Checks before work starts that an analysis can be written into a folder, which need not exist yet.
///
/// # Errors
/// The same errors as [`Writer::check`], in particular if the folder has an earlier analysis.
pub fn check_folder(writer: &Writer, folder: &Path) -> Result<(), StoreError> {
    writer.check_folder(folder)?;
    let found = found(folder).map_err(|error| StoreError::io(folder, "access", error))?;
    found.map_or(Ok(()), |_| writer.check([folder.join(CELLS).as_path()]))
}

/// Returns a figure as the content of the PNG file at `path`.
///
/// # Errors
/// The figure cannot be drawn.
pub fn png(figure: &Figure, path: &Path) -> Result<Vec<u8>, StoreError> {
    figure.png().map_err(|error| StoreError::io(path, "draw", std::io::Error::other(error.to_string())))
}
