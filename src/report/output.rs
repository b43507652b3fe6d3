//! What `machband analyze` and the pane's export write.

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

use rayon::prelude::*;

use super::{
    Study,
    figures::{self, Figure},
    html::{self, Repetition},
    tables,
};
use crate::{
    analysis::Results,
    store::{StoreError, write_file},
};

/// Which files are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// All of them.
    Everything,
    /// Tables and the model: no figures and no report.
    Tables,
}

/// Writes an analysis into a folder, and gives the files' names. Files of an earlier analysis are replaced.
///
/// # Errors
/// The folder cannot be made or written.
pub fn write_all(
    study: &Study,
    results: &Results,
    repetition: &Repetition,
    folder: &Path,
    extent: Extent,
) -> Result<Vec<PathBuf>, StoreError> {
    fs::create_dir_all(folder).map_err(|error| StoreError::io(folder, "make the folder", error))?;
    let mut files = tables(study, results);
    if extent == Extent::Everything {
        let figures = figures::all(results);
        files.push(("report.html".to_owned(), html::report(study, results, &figures, repetition).into_bytes()));
        let pictures: Result<Vec<_>, StoreError> = figures.par_iter().map(|figure| pictures(figure, folder)).collect();
        files.extend(pictures?.into_iter().flatten());
    }
    (files.into_iter())
        .map(|(name, content)| {
            let path = folder.join(name);
            write_file(&path, &content).map(|()| path)
        })
        .collect()
}

fn pictures(figure: &Figure, folder: &Path) -> Result<[(String, Vec<u8>); 2], StoreError> {
    let png = figure
        .png()
        .map_err(|error| StoreError::io(&folder.join(figure.name), "draw", std::io::Error::other(error.to_string())))?;
    Ok([(format!("{}.svg", figure.name), figure.svg.clone().into_bytes()), (format!("{}.png", figure.name), png)])
}

fn tables(study: &Study, results: &Results) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![
        ("cells.csv".to_owned(), tables::cells(results).csv()),
        ("subjects.csv".to_owned(), tables::subjects(results).csv()),
        ("tests.csv".to_owned(), tables::tests(results).csv()),
        ("agreement.csv".to_owned(), tables::agreement(results).csv()),
        ("counts.csv".to_owned(), tables::counts(&results.measured.counts, &study.source.shape).csv()),
    ];
    let mut model = serde_json::to_vec_pretty(&tables::model(results)).unwrap_or_default();
    model.push(b'\n');
    files.push(("model.json".to_owned(), model));
    files.extend(tables::predictions(results).map(|table| ("predictions.csv".to_owned(), table.csv())));
    let mut taken = HashSet::new();
    for factor in &results.factors {
        let mut name = format!("by_{}", file_part(&factor.name));
        while !taken.insert(name.clone()) {
            name.push('_');
        }
        files.push((format!("{name}.csv"), tables::by_factor(results, factor).csv()));
    }
    files
}

/// A factor's name as part of a file's: what is not a letter, digit, hyphen or dot becomes a line.
fn file_part(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || c == '-' || c == '.' { c } else { '_' }).collect()
}
