//! Arranges the sections of the document of a study.

use super::{
    description, health, methods, model,
    provenance::{self, Provenance},
    summary,
};
use crate::{
    analysis::Results,
    report::{document::Document, figures::Figure},
    store::ratings::Source,
};

/// Describes a study in a document with these charts; `provenance` says how to repeat the analysis, for readers who do not
/// have it open.
pub fn document(source: &Source, results: &Results, figures: &[Figure], provenance: Option<&Provenance>) -> Document {
    let (methods, references) = methods::sections(source, results);
    let mut sections = vec![
        summary::section(source, results),
        health::section(source, results),
        description::section(results, figures),
        model::section(results, figures),
        description::agreement(results),
        methods,
        references,
    ];
    sections.extend(provenance.map(|provenance| provenance::section(source, provenance)));
    let (title, subtitle) = match &source.protocol {
        Some(protocol) => {
            let title = if protocol.title.trim().is_empty() { &protocol.name } else { &protocol.title };
            (title.clone(), format!("Experiment {}", protocol.name))
        }
        None => ("Analysis of ratings".to_owned(), "No definition of an experiment".to_owned()),
    };
    Document { title, subtitle, sections }
}
