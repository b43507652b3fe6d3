//! The section about the vision model's predictions: predicted and measured versions of the paper's Figure 4, the
//! agreement in rank order.

use super::health;
use crate::{
    analysis::Results,
    report::{
        document::{Section, count, fixed, unit},
        figures::Figure,
        prediction::{Comparison, StudyPrediction},
    },
    store::{ratings::Source, sidecar::SimulatedObserver},
};

/// Writes the section; `figures` contains the measured and the predicted charts.
pub(super) fn section(
    source: &Source,
    results: &Results,
    prediction: &Result<StudyPrediction, String>,
    figures: &[Figure],
) -> Section {
    let mut section = Section::new("vision", "What the vision model predicts");
    let prediction = match prediction {
        Ok(prediction) => prediction,
        Err(error) => {
            section.text(format!("There is no prediction: {error}."));
            return section;
        }
    };
    let is_ramp = source.protocol.as_ref().is_some_and(|protocol| protocol.stimulus.is_line());
    section.text(format!(
        "A model of early vision receives the stimulus of every condition, in a window {}° wide on a screen with a \
         white of {} cd/m². It computes {}, in times threshold: at 1, people just see the difference in a choice \
         between the two. It does not use the ratings; only the criterion that turns times threshold into ratings is fitted to them. \
         The model was fitted to thresholds, not to ratings of bands; this section examines whether it orders bands as people do.",
        (100.0 * prediction.viewing.window_deg).round() / 100.0,
        fixed(prediction.viewing.white_cd_m2, 0),
        if is_ramp {
            "how different the bright side of the ramp is from the nearest smooth edge"
        } else {
            "how different the picture is from that of the smooth surface"
        }
    ));
    section.figures(figures, &["figure4a", "figure4a_predicted", "figure4b", "figure4b_predicted"]);
    let Comparison { conditions, ratings, rank_correlation, .. } = prediction.comparison;
    section.text(format!(
        "Across {} and {}, the rank correlation between the prediction and the mean rating (Spearman) is {}.",
        count(conditions as u64, "condition"),
        count(ratings, "rating"),
        unit(rank_correlation)
    ));
    let is_circular = health::all_sittings(source, results)
        .any(|(_, sitting)| matches!(sitting.observer, Some(SimulatedObserver::Vision { .. })));
    if is_circular {
        section.warning(
            "Some or all ratings of this study were simulated with this same model, so their agreement with it says nothing about human vision.",
        );
    }
    section
}
