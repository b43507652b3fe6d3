//! Compares the vision model's prediction with ratings: fits the criterion, and measures the agreement in rank order.

use std::collections::{BTreeMap, HashMap};

use crate::{
    analysis::{
        ModelSpec,
        counts::{Counts, MeasuredBuilder},
        fit,
        rank_tests::ranks,
        summary::means_by_subject,
    },
    experiment::{Condition, Protocol},
    statistics::mean_and_sd,
    stimulus::Visible,
    store::ratings::{SessionRead, Source},
    vision::Criterion,
};

/// Lower values are raised to this one before they are compared with ratings. Below a tenth of the threshold, there is
/// nothing to distinguish, and some participants press a key other than 0 even if they see no band.
pub(super) const LEAST: f64 = 0.1;

/// A prediction compared with ratings.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Number of ratings in the conditions that are compared.
    pub ratings: u64,
    /// Number of conditions with both a prediction and ratings.
    pub conditions: usize,
    /// Number of participants whose ratings it rests on.
    pub participants: usize,
    /// The thresholds between ratings, estimated by maximum likelihood.
    pub criterion: Criterion,
    /// The approximate 95 % interval of each threshold, from the curvature of the likelihood; `None` if that is not
    /// known.
    #[serde(rename = "criterion_intervals")]
    pub intervals: [Option<[f64; 2]>; 3],
    /// Spearman's correlation between the prediction and the mean rating, over conditions.
    pub rank_correlation: Option<f64>,
}

/// Returns the width of the stimulus window in degrees: the mean over the sittings in the sidecars, or otherwise the
/// value that the definition plans.
pub(super) fn window_deg(source: &Source, protocol: &Protocol) -> f64 {
    let sittings = source.sessions.iter().flat_map(SessionRead::sittings);
    let widths = sittings.filter_map(|sitting| Some(sitting.viewing.as_ref()?.stimulus_deg));
    let widths: Vec<f64> = widths.filter(|deg| deg.is_finite() && *deg > 0.0).collect();
    if widths.is_empty() { protocol.viewing.window_deg } else { mean_and_sd(&widths).0 }
}

/// Compares predictions for the conditions of a definition with ratings. Columns that are not parameters of the stimulus are
/// ignored.
///
/// # Errors
/// The ratings are on another scale, the predictions and the ratings share no condition, no criterion can be fitted, or the
/// ratings do not record a factor of the definition.
pub(super) fn compare(
    counts: &Counts,
    protocol: &Protocol,
    conditions: &[Condition],
    predicted: &[Visible],
) -> Result<Comparison, String> {
    // The thresholds of a criterion lie between four categories.
    let categories = counts.categories.len();
    if categories != 4 {
        let noun = if categories == 1 { "category" } else { "categories" };
        return Err(format!("the scale has {categories} {noun}; expected the four categories of the scale 0–3"));
    }
    if predicted.iter().all(|visible| visible.rated().is_none()) {
        return Err(format!(
            "the stimuli are of the kind {}; expected mach-band, or a mesh whose smooth surface is known",
            protocol.stimulus.kind()
        ));
    }
    let is_missing = |name: &str, levels: usize| levels > 1 && counts.factor(name).is_none();
    if let Some(factor) = protocol.factors.iter().find(|factor| is_missing(&factor.name, factor.levels.len())) {
        return Err(format!(
            "the definition varies {}, which is not a factor of this analysis; expected it among the factors",
            factor.name
        ));
    }
    let names = counts.factors.iter().map(|factor| factor.name.as_str()).enumerate();
    let columns: Vec<(usize, &str)> = names.filter(|(_, name)| protocol.stimulus.get(name).is_some()).collect();
    let shown = |condition: &Condition| -> Option<Vec<String>> {
        columns.iter().map(|(_, name)| Some(canonical(&condition.stimulus.get(name)?.to_string()))).collect()
    };
    let known: HashMap<Vec<String>, f64> = (conditions.iter().zip(predicted))
        .filter_map(|(condition, visible)| Some((shown(condition)?, visible.rated()?)))
        .collect();
    let rated = |condition: u32| -> Vec<String> {
        let levels = counts.level_names(condition);
        columns.iter().map(|(column, _)| canonical(levels[*column])).collect()
    };
    // Of each condition of the counts; a condition that is not in the definition has none.
    let predicted: Vec<Option<f64>> =
        (0..counts.conditions.len() as u32).map(|condition| known.get(&rated(condition)).copied()).collect();
    let places = (0..).zip(&predicted);
    let (places, model): (Vec<u32>, Vec<f64>) = places.filter_map(|(place, value)| Some((place, (*value)?))).unzip();
    if places.is_empty() {
        return Err(
            "the ratings contain none of the predicted conditions; expected ratings from this experiment".to_owned()
        );
    }
    let ratings = counts.rows.iter().filter(|row| places.binary_search(&row.condition).is_ok()).map(|row| row.count);
    let means = means_by_subject(counts, places.len(), |_, condition| places.binary_search(&condition).ok());
    // A participant counts equally, whatever the number of ratings; NaN if nobody rated a condition.
    let mean = |own: &BTreeMap<u32, f64>| mean_and_sd(&own.values().copied().collect::<Vec<_>>()).0;
    let means: Vec<f64> = means.iter().map(mean).collect();
    let (criterion, intervals) = criterion(counts, &predicted)?;
    Ok(Comparison {
        criterion,
        intervals,
        participants: counts.subjects.len(),
        conditions: places.len(),
        ratings: ratings.sum(),
        rank_correlation: rank_correlation(&means, &model),
    })
}

/// Normalizes the text of a value, because the same number may be written in several ways.
fn canonical(text: &str) -> String {
    text.parse().map_or_else(|_| text.to_owned(), |number: f64| format!("{:.12e}", number + 0.0))
}

/// A criterion, and the 95 % interval of each of its thresholds.
type Fitted = (Criterion, [Option<[f64; 2]>; 3]);

fn criterion(counts: &Counts, predicted: &[Option<f64>]) -> Result<Fitted, String> {
    let fail = |error: &dyn std::fmt::Display| {
        format!("{error}; expected ratings that increase with the prediction and use the whole scale")
    };
    let mut builder = MeasuredBuilder::new(&["times"]).with_categories(&counts.categories);
    for row in &counts.rows {
        let Some(times) = predicted[row.condition as usize] else { continue };
        let log = times.max(LEAST).ln().to_string();
        let (subject, rating) = (&counts.subjects[row.subject as usize], &counts.categories[row.rating as usize]);
        builder.add_counts(subject, &[log], rating, row.count).map_err(|error| fail(&error))?;
    }
    let terms = "num:times".parse().map_err(|error| fail(&error))?;
    let model = fit(&builder.finish().counts, &ModelSpec::new(terms)).map_err(|error| fail(&error))?;
    let slope = model.coefficients.first().map_or(f64::NAN, |coefficient| coefficient.estimate);
    if !(slope.is_finite() && slope > 0.0) {
        return Err(fail(&format_args!("ratings change by {slope:.3} per unit of the log prediction")));
    }
    let logs: Vec<f64> = model.thresholds.iter().map(|threshold| threshold.estimate / slope).collect();
    let Some(logs) = <[f64; 3]>::try_from(logs).ok().filter(|logs| logs.iter().all(|log| log.exp().is_finite())) else {
        return Err(fail(&"at least one rating was never used"));
    };
    // The slope follows the thresholds. The variance of a ratio, by its derivatives.
    let variance = |a: usize, b: usize| model.covariance[(a, b)];
    let intervals = [0, 1, 2].map(|k| {
        let log: f64 = logs[k];
        let square = variance(k, k) - 2.0 * log * variance(k, 3) + log * log * variance(3, 3);
        let half = 1.96 * square.sqrt() / slope;
        half.is_finite().then(|| [(log - half).exp(), (log + half).exp()])
    });
    Ok((Criterion { thresholds: logs.map(f64::exp), spread: 1.0 / slope }, intervals))
}

/// Computes Spearman's correlation over complete pairs, with mean ranks for ties; `None` if a variable does not vary.
pub fn rank_correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let pairs = a.iter().copied().zip(b.iter().copied()).filter(|(a, b)| a.is_finite() && b.is_finite());
    let (a, b): (Vec<f64>, Vec<f64>) = pairs.unzip();
    let middle = 0.5 * (a.len() as f64 + 1.0);
    let centered = |values| -> Vec<f64> { ranks(values, 0.0).0.into_iter().map(|rank| rank - middle).collect() };
    let (a, b) = (centered(&a), centered(&b));
    let sum = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (aa, bb) = (sum(&a, &a), sum(&b, &b));
    (aa > 0.0 && bb > 0.0).then(|| sum(&a, &b) / (aa * bb).sqrt())
}
