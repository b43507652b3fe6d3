//! The output of `machband analyze` and of the export on the window's analysis page.

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use rayon::prelude::*;

use super::{
    figures::{self, Figure},
    prediction::{PredictionError, StudyPrediction},
    skins,
    study::{Parts, Provenance, Study, document},
    tables,
};
use crate::{
    analysis::Results,
    store::{StoreError, write_file},
};

/// The files that were written, and the prediction.
#[derive(Debug)]
pub struct AnalysisOutput {
    pub files: Vec<PathBuf>,
    /// The vision model's prediction, and the time it took; `None` if only tables were requested.
    pub prediction: Option<(Result<StudyPrediction, PredictionError>, Duration)>,
}

/// Writes an analysis into a folder: the tables and the model and, unless `tables_only` is set, the figures and the
/// report. Replaces the files of an earlier analysis.
///
/// # Errors
/// The folder cannot be created or written.
pub fn write_all(
    study: &Study,
    results: &Results,
    provenance: &Provenance,
    folder: &Path,
    tables_only: bool,
) -> Result<AnalysisOutput, StoreError> {
    fs::create_dir_all(folder).map_err(|error| StoreError::io(folder, "create the folder", error))?;
    let mut contents = tables(study, results);
    let mut prediction = None;
    if !tables_only {
        let start = Instant::now();
        let predict = || (StudyPrediction::of(&study.source, &results.measured.counts), start.elapsed());
        let ((predicted, took), mut figures) = rayon::join(predict, || figures::all(results));
        figures.extend(predicted.iter().flat_map(|predicted| figures::predicted(results, &predicted.ratings)));
        let parts = Parts { figures: &figures, prediction: Some(&predicted), provenance: Some(provenance) };
        let page = skins::html(&document(&study.source, results, parts), provenance);
        contents.push(("report.html".to_owned(), page.into_bytes()));
        let pictures: Result<Vec<_>, StoreError> = figures.par_iter().map(|figure| pictures(figure, folder)).collect();
        contents.extend(pictures?.into_iter().flatten());
        prediction = Some((predicted, took));
    }
    let write = |(name, content): (String, Vec<u8>)| {
        let path = folder.join(name);
        write_file(&path, &content).map(|()| path)
    };
    let files = contents.into_iter().map(write).collect::<Result<_, _>>()?;
    Ok(AnalysisOutput { files, prediction })
}

fn pictures(figure: &Figure, folder: &Path) -> Result<[(String, Vec<u8>); 2], StoreError> {
    let png = figure
        .png()
        .map_err(|error| StoreError::io(&folder.join(figure.name), "draw", std::io::Error::other(error.to_string())))?;
    Ok([(format!("{}.svg", figure.name), figure.svg.clone().into_bytes()), (format!("{}.png", figure.name), png)])
}

fn tables(study: &Study, results: &Results) -> Vec<(String, Vec<u8>)> {
    let mut model = serde_json::to_vec_pretty(&tables::model(results)).unwrap_or_default();
    model.push(b'\n');
    let mut files = vec![
        ("cells.csv".to_owned(), tables::cells(results).csv()),
        ("subjects.csv".to_owned(), tables::subjects(results).csv()),
        ("tests.csv".to_owned(), tables::tests(results).csv()),
        ("agreement.csv".to_owned(), tables::agreement(results).csv()),
        ("counts.csv".to_owned(), tables::counts(&results.measured.counts, &study.source.shape).csv()),
        ("model.json".to_owned(), model),
    ];
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

/// Makes a factor's name safe for a file name: all characters except letters, digits, hyphens and dots become
/// underscores.
fn file_part(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || c == '-' || c == '.' { c } else { '_' }).collect()
}
