//! The sections in their order, with the figures in their places.

use super::{
    agreement, description, design, health, methods, model,
    provenance::{self, Provenance},
    ranks, references, summary, times, vision,
};
use crate::{
    analysis::Results,
    report::{
        document::Document,
        figures::Figure,
        prediction::{PredictionError, StudyPrediction},
    },
    store::ratings::Source,
};

/// What a document shows besides the results.
#[derive(Clone, Copy, Default)]
pub struct Parts<'a> {
    /// The charts.
    pub figures: &'a [Figure],
    /// What the model of vision says of the ratings that the results are of; `figures` have it too. Without it there is
    /// no section about that model.
    pub prediction: Option<&'a Result<StudyPrediction, PredictionError>>,
    /// How to repeat the analysis, for readers who do not have it before them.
    pub provenance: Option<&'a Provenance>,
}

/// A study as a document.
pub fn document(source: &Source, results: &Results, parts: Parts<'_>) -> Document {
    let figures = |names: &'static [&str]| {
        names.iter().filter_map(|name| parts.figures.iter().find(|figure| figure.name == *name))
    };
    let predicted = parts.prediction.and_then(|prediction| prediction.as_ref().ok());
    let (methods, cited) = methods::section(source, results, predicted);
    let mut sections = vec![
        summary::section(source, results),
        design::section(source, results),
        health::section(source, results),
        description::section(results, figures(&["figure4a", "figure4b", "proportions", "subjects", "orientation"])),
        model::section(results, figures(&["effects"])),
        ranks::section(results),
        agreement::section(results),
    ];
    sections.extend(parts.prediction.map(|prediction| {
        let names = &["figure4a", "figure4a_predicted", "figure4b", "figure4b_predicted"];
        vision::section(source, results, prediction, figures(names))
    }));
    sections.extend([times::section(results, figures(&["times"])), methods, references::section(&cited)]);
    sections.extend(parts.provenance.map(|provenance| provenance::section(source, results, provenance)));
    let (title, subtitle) = titles(source);
    Document { title, subtitle, sections }
}

fn titles(source: &Source) -> (String, String) {
    match &source.protocol {
        Some(protocol) => {
            let title = if protocol.title.trim().is_empty() { &protocol.name } else { &protocol.title };
            (title.clone(), format!("Experiment {}", protocol.name))
        }
        None => ("Analysis of ratings".to_owned(), "No definition of an experiment".to_owned()),
    }
}
