//! The section about the vision model's predictions: predicted and measured versions of the paper's Figure 4, the
//! agreement in rank order.

use super::health;
use crate::{
    analysis::{Results, counts::Counts},
    report::{
        document::{Section, Shown, count, fixed, list, significant, unit, whole},
        figures::Figure,
        prediction::{Comparison, StudyPrediction},
    },
    stimulus::ViewingConditions,
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
    let (counts, comparison) = (&results.measured.counts, &prediction.comparison);
    let is_ramp = source.protocol.as_ref().is_some_and(|protocol| protocol.stimulus.is_line());
    let what = if is_ramp {
        "how different the bright side of the ramp is from the nearest smooth edge"
    } else {
        "how different the picture is from that of the smooth surface"
    };
    let thresholds: Vec<Shown> = comparison.criterion.thresholds.iter().map(|t| significant(*t, *t, *t)).collect();
    let ViewingConditions { window_deg, white_cd_m2, .. } = prediction.viewing;
    section.text(format!(
        "A model of early vision receives the stimulus of every condition, in a window {}° wide on a screen with a white \
         of {} cd/m². It computes {what}, in times threshold: at 1, people just see the difference in a choice between the \
         two. It does not use the ratings; only the criterion is fitted to them: half of the ratings are above each of the \
         first three categories at {} times threshold, with a spread of {} in the logarithm. The model was fitted to thresholds, \
         not to ratings of bands; this section examines whether it orders bands as people do.",
        significant(window_deg, window_deg, window_deg),
        fixed(white_cd_m2, 0),
        list(&thresholds),
        fixed(comparison.criterion.spread, 2)
    ));
    section.figures(figures, &["figure4a", "figure4a_predicted", "figure4b", "figure4b_predicted"]);
    section.text(order(comparison, counts));
    let is_circular = health::all_sittings(source, results)
        .any(|(_, sitting)| matches!(sitting.observer, Some(SimulatedObserver::Vision { .. })));
    if is_circular {
        section.warning(
            "Some or all ratings of this study were simulated with this same model, so their agreement with it says nothing about human vision.",
        );
    }
    section
}

fn order(comparison: &Comparison, counts: &Counts) -> String {
    let Some(rho) = comparison.rank_correlation else {
        return "All conditions have the same prediction or the same rating, so there is no order to compare."
            .to_owned();
    };
    let all = counts.conditions.len();
    let of = if comparison.conditions < all { format!(" of {}", whole(all as u64)) } else { String::new() };
    format!(
        "Across {}{of} {} and {}, the rank correlation between the prediction and the mean rating (Spearman) is {}.",
        whole(comparison.conditions as u64),
        if all == 1 { "condition" } else { "conditions" },
        count(comparison.ratings, "rating"),
        unit(rho)
    )
}
