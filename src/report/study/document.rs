//! From files to a document: reading a study, and the sections of its document in order.

use std::path::PathBuf;

use super::{
    description, health, methods, model,
    provenance::{self, Provenance},
    ranks, summary, vision,
};
use crate::{
    analysis::{
        Results,
        counts::{Measured, MeasuredBuilder},
    },
    experiment::RatingRow,
    report::{
        document::Document,
        figures::Figure,
        prediction::{PredictionError, StudyPrediction},
    },
    store::{
        FileFaults,
        ratings::{self, ReadOptions, Shape, Source},
    },
};

/// The content of the files, and the faults found in them.
#[derive(Clone, Debug)]
pub struct Study {
    /// The source of the ratings.
    pub source: Source,
    pub measured: Measured,
}

impl Study {
    /// Reads files, and folders of them.
    ///
    /// # Errors
    /// There is nothing to analyze. Faults in part of the input are in [`Source::faults`].
    pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<Self, FileFaults> {
        let new = |shape: &Shape| {
            let mut builder = MeasuredBuilder::new(&shape.factors);
            if let Some(categories) = &shape.categories {
                builder = builder.with_categories(categories);
            }
            if shape.guessed { builder.only_varied_factors() } else { builder }
        };
        let add =
            |builder: &mut MeasuredBuilder, row: &RatingRow<'_>| builder.add(row).map_err(|error| error.to_string());
        let (source, files) = ratings::read(paths, options, new, add)?;
        let mut all = new(&source.shape);
        for (file, read) in files.into_iter().zip(&source.files) {
            let name = || read.path.display().to_string();
            all.absorb(file).map_err(|error| FileFaults::whole(name(), error.to_string()))?;
        }
        Ok(Self { source, measured: all.finish() })
    }
}

/// What a document shows in addition to the results.
#[derive(Clone, Copy, Default)]
pub struct Parts<'a> {
    /// The charts.
    pub figures: &'a [Figure],
    /// Predictions of the model of vision for the analyzed ratings, which `figures` include. Without them there is no
    /// section about that model.
    pub prediction: Option<&'a Result<StudyPrediction, PredictionError>>,
    /// How to repeat the analysis, for readers who do not have it open.
    pub provenance: Option<&'a Provenance>,
}

/// A study as a document.
pub fn document(source: &Source, results: &Results, parts: Parts<'_>) -> Document {
    let Parts { figures, prediction, provenance } = parts;
    let (methods, references) = methods::sections(source, results, prediction.and_then(|p| p.as_ref().ok()));
    let mut sections = vec![
        summary::section(source, results),
        description::design(source, results),
        health::section(source, results),
        description::section(results, figures),
        model::section(results, figures),
        ranks::section(results),
        ranks::agreement(results),
    ];
    sections.extend(prediction.map(|prediction| vision::section(source, results, prediction, figures)));
    sections.extend([description::times(results, figures), methods, references]);
    sections.extend(provenance.map(|provenance| provenance::section(source, results, provenance)));
    let (title, subtitle) = match &source.protocol {
        Some(protocol) => {
            let title = if protocol.title.trim().is_empty() { &protocol.name } else { &protocol.title };
            (title.clone(), format!("Experiment {}", protocol.name))
        }
        None => ("Analysis of ratings".to_owned(), "No definition of an experiment".to_owned()),
    };
    Document { title, subtitle, sections }
}
