//! The section about the vision model's predictions: predicted and measured versions of the paper's Figure 4, the
//! agreement in rank order.

use super::{health, names};
use crate::{
    analysis::{Results, counts::Counts},
    report::{
        document::{Section, Shown, count, fixed, list, significant, unit, whole},
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
    let (counts, comparison) = (&results.measured.counts, &prediction.comparison);
    section.text(format!(
        "A model of early vision receives the stimulus of every condition, in a window {} wide on a screen with a \
         white of {} cd/m². It computes {}, in times threshold: at 1, people just see the difference in a choice \
         between the two. It does not use the ratings; only the criterion is fitted to them: {}. The model was fitted \
         to thresholds, not to ratings of bands; this section examines whether it orders bands as people do.",
        degrees(prediction),
        fixed(prediction.viewing.white_cd_m2, 0),
        what(source),
        criterion(results, comparison)
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

/// Says what the model computes for the stimuli of this study.
fn what(source: &Source) -> &'static str {
    let is_ramp = source.protocol.as_ref().is_some_and(|protocol| protocol.stimulus.is_line());
    if is_ramp {
        "how different the bright side of the ramp is from the nearest smooth edge"
    } else {
        "how different the picture is from that of the smooth surface"
    }
}

/// Formats the width of the window with its unit.
fn degrees(prediction: &StudyPrediction) -> String {
    let text = fixed(prediction.viewing.window_deg, 2);
    format!("{}°", text.trim_end_matches('0').trim_end_matches('.'))
}

fn criterion(results: &Results, comparison: &Comparison) -> String {
    let counts = &results.measured.counts;
    let below: Vec<Shown> =
        counts.categories.iter().take(3).map(|category| names::level(results, "", category)).collect();
    let thresholds: Vec<Shown> = comparison.criterion.thresholds.iter().map(|t| significant(*t, *t, *t)).collect();
    format!(
        "half of the ratings are above {} at {} times threshold, with a spread of {} in the logarithm",
        list(&below),
        list(&thresholds),
        fixed(comparison.criterion.spread, 2)
    )
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
