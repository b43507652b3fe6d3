//! What `machband analyze` and the pane's export write.

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use rayon::prelude::*;

use super::{
    Repetition, Study,
    figures::{self, Figure},
    html,
    prediction::{Predicted, Unpredicted},
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

/// What was written.
#[derive(Debug)]
pub struct Written {
    /// The files.
    pub files: Vec<PathBuf>,
    /// What the model of vision says of the ratings, and how long it took; none where tables alone were wanted.
    pub vision: Option<(Result<Predicted, Unpredicted>, Duration)>,
}

/// Writes an analysis into a folder. Files of an earlier analysis are replaced.
///
/// # Errors
/// The folder cannot be made or written.
pub fn write_all(
    study: &Study,
    results: &Results,
    repetition: &Repetition,
    folder: &Path,
    extent: Extent,
) -> Result<Written, StoreError> {
    fs::create_dir_all(folder).map_err(|error| StoreError::io(folder, "make the folder", error))?;
    let mut contents = tables(study, results);
    let mut vision = None;
    if extent == Extent::Everything {
        let ((predicted, took), mut figures) = rayon::join(|| predict(study, results), || figures::all(results));
        figures.extend(predicted.iter().flat_map(|predicted| figures::predicted(results, &predicted.ratings)));
        let page = html::report(study, results, &figures, &predicted, repetition);
        contents.push(("report.html".to_owned(), page.into_bytes()));
        let pictures: Result<Vec<_>, StoreError> = figures.par_iter().map(|figure| pictures(figure, folder)).collect();
        contents.extend(pictures?.into_iter().flatten());
        vision = Some((predicted, took));
    }
    let write = |(name, content): (String, Vec<u8>)| {
        let path = folder.join(name);
        write_file(&path, &content).map(|()| path)
    };
    let files = contents.into_iter().map(write).collect::<Result<_, _>>()?;
    Ok(Written { files, vision })
}

fn predict(study: &Study, results: &Results) -> (Result<Predicted, Unpredicted>, Duration) {
    let start = Instant::now();
    let predicted = Predicted::of(&study.source, &results.measured.counts);
    (predicted, start.elapsed())
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
