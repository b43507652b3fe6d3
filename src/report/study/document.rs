//! Reads a study from files, and arranges the sections of its document.

use std::path::{Path, PathBuf};

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
        FileErrors,
        ratings::{self, ReadOptions, Shape, Source},
    },
};

/// The ratings in the files, and the errors found in them.
#[derive(Clone, Debug)]
pub struct Study {
    /// Where the ratings come from.
    pub source: Source,
    pub measured: Measured,
}

impl Study {
    /// Reads files and folders of files.
    ///
    /// # Errors
    /// There is nothing to analyze, or the study is too large. If only part of the input has errors, they are in
    /// [`Source::errors`].
    pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<Self, FileErrors> {
        let new = |shape: &Shape| {
            let mut builder = MeasuredBuilder::new(&shape.factors);
            if let Some(categories) = &shape.categories {
                builder = builder.with_categories(categories);
            }
            if shape.guessed { builder.only_varied_factors() } else { builder }
        };
        let add =
            |builder: &mut MeasuredBuilder, row: &RatingRow<'_>| builder.add(row).map_err(|error| error.to_string());
        let mut all: Option<MeasuredBuilder> = None;
        let source = ratings::read(paths, options, new, add, |read, file| {
            let Some(all) = &mut all else {
                all = Some(file);
                return Ok(());
            };
            all.absorb(file).map_err(|error| FileErrors::whole(&read.path, error.to_string()))
        })?;
        let all = all.unwrap_or_else(|| new(&source.shape));
        let measured = all.finish();
        if !options.large {
            let file = source.files.first().map_or(Path::new("."), |file| &file.path);
            measured.counts.check_size().map_err(|message| FileErrors::whole(file, message))?;
        }
        Ok(Self { source, measured })
    }
}

/// What a document shows in addition to the results.
#[derive(Clone, Copy, Default)]
pub struct Parts<'a> {
    /// The charts.
    pub figures: &'a [Figure],
    /// Predictions of the vision model for the analyzed ratings; `figures` must include their charts. Without
    /// predictions, there is no section about that model.
    pub prediction: Option<&'a Result<StudyPrediction, PredictionError>>,
    /// How to repeat the analysis, for readers who do not have it open.
    pub provenance: Option<&'a Provenance>,
}

/// Describes a study in a document.
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
