//! What the model of vision predicts: the paper's Figure 4 beside the ratings', how far its order is theirs, and where
//! it is furthest from them.

use maud::{Markup, html};

use super::{names, sittings};
use crate::report::document::numbers::{count, fixed, list, mean, unit, whole};
use crate::{
    analysis::{Results, counts::Counts, summary::category_values},
    report::prediction::{Held, Predicted, Unpredicted},
    store::ratings::Source,
};

/// Conditions that are named for their distance from the ratings.
const FURTHEST: usize = 3;

/// The section; `figures` stand side by side, measured and predicted.
pub(crate) fn section(
    source: &Source,
    results: &Results,
    predicted: &Result<Predicted, Unpredicted>,
    figures: Markup,
) -> Markup {
    let predicted = match predicted {
        Ok(predicted) => predicted,
        Err(why) => return html! { p { "There is no prediction: " (why) "." } },
    };
    let counts = &results.measured.counts;
    html! {
        p {
            "A model of early vision looks at the stimulus of every condition, in a window " (degrees(predicted)) " wide on a screen whose white has "
            (fixed(predicted.sight.white_cd_m2, 0)) " cd/m², and says how visible its bands are: 0 for none, 1 for what is just seen. "
            "It knows no ratings. Only the criterion is fitted to them: " (criterion(&predicted.held, counts)) "."
        }
        (figures)
        p { (order(&predicted.held, counts)) }
        p { (ceiling(&predicted.held)) }
        @if let Some(sentence) = furthest(results, predicted) { p { (sentence) } }
        @if is_circular(source) {
            p.warning { "Ratings of this study were simulated with this very model: that it predicts them says nothing about eyes." }
        }
    }
}

/// The width of the window, with its unit.
pub(crate) fn degrees(predicted: &Predicted) -> String {
    let text = fixed(predicted.sight.window_deg, 2);
    format!("{}°", text.trim_end_matches('0').trim_end_matches('.'))
}

fn criterion(held: &Held, counts: &Counts) -> String {
    let below: Vec<String> = counts.categories.iter().take(3).map(|c| names::level("", c)).collect();
    let thresholds: Vec<String> = held.criterion.thresholds.iter().map(|t| visibility(*t)).collect();
    format!(
        "half of the ratings are above {} at a visibility of {}, with a spread of {} on its logarithm",
        list(&below),
        list(&thresholds),
        fixed(held.criterion.spread, 2)
    )
}

/// A visibility to three digits, without thousands: a threshold far from all stimuli can be anything.
fn visibility(value: f64) -> String {
    if (0.01..10_000.0).contains(&value) {
        fixed(value, if value < 10.0 { 2 } else { 1 })
    } else {
        format!("{value:.1e}")
    }
}

fn order(held: &Held, counts: &Counts) -> String {
    let all = counts.conditions.len();
    let of = if held.conditions < all { format!(" of {}", whole(all as u64)) } else { String::new() };
    let conditions = if all == 1 { "condition" } else { "conditions" };
    match held.rank_correlation {
        Some(rho) => format!(
            "Over {}{of} {conditions} and {}, the rank correlation of visibility and mean rating (Spearman) is {}.",
            whole(held.conditions as u64),
            count(held.ratings, "rating"),
            unit(rho)
        ),
        None => "All conditions are predicted, or rated, alike: there is no order to compare.".to_owned(),
    }
}

/// Where the prediction stands between nothing and all that can be predicted.
fn ceiling(held: &Held) -> String {
    let (Some(each), Some([low, high])) = (held.with_subjects, held.ceiling) else {
        return "How much of the order could be predicted at all is not known: that takes the agreement of two participants or more."
            .to_owned();
    };
    let verdict = if each < low {
        "The model is below it: participants predict each other better than the model does, so there is order in their ratings that it misses."
    } else if each <= high {
        "The model is at it: it predicts a participant as well as the other participants do, and these ratings cannot tell it from a perfect one."
    } else {
        "The model is above it, which is more than agreement allows: so many ratings are alike that the measure is coarse."
    };
    format!(
        "With single participants the correlation is {} on average. The noise ceiling, how well they agree with the mean of the others and with \
         the mean of all, is {} to {}. {verdict}",
        unit(each),
        unit(low),
        unit(high)
    )
}

/// The conditions whose mean ratings are furthest from what was predicted.
fn furthest(results: &Results, predicted: &Predicted) -> Option<String> {
    let counts = &results.measured.counts;
    let mut far: Vec<(u32, f64, f64)> = measured(counts)
        .into_iter()
        .filter_map(|(condition, mean)| Some((condition, mean, *predicted.ratings.get(condition as usize)?.as_ref()?)))
        .collect();
    // Of equal distances the first conditions, so that equal ratings give an equal page.
    far.sort_by(|a, b| (b.1 - b.2).abs().total_cmp(&(a.1 - a.2).abs()));
    far.truncate(FURTHEST);
    if far.is_empty() {
        return None;
    }
    let one = |(condition, rated, expected): &(u32, f64, f64)| {
        format!("{} (rated {}, predicted {})", condition_name(counts, *condition), mean(*rated), mean(*expected))
    };
    let named: Vec<String> = far.iter().map(one).collect();
    Some(format!("Furthest from the mean ratings are the predictions for {}.", named.join("; for ")))
}

fn condition_name(counts: &Counts, condition: u32) -> String {
    let levels = counts.level_names(condition);
    let named = counts.factors.iter().zip(levels).filter(|(factor, _)| factor.levels.len() > 1);
    let parts: Vec<String> = named
        .map(|(factor, level)| format!("{} {}", names::factor(&factor.name), names::level(&factor.name, level)))
        .collect();
    if parts.is_empty() { "the only condition".to_owned() } else { parts.join(", ") }
}

/// The mean rating of every condition that has ratings.
fn measured(counts: &Counts) -> Vec<(u32, f64)> {
    let values = category_values(counts);
    let mut sums = vec![(0.0, 0.0); counts.conditions.len()];
    for row in &counts.rows {
        let (sum, n) = &mut sums[row.condition as usize];
        *sum += values[usize::from(row.rating)] * row.count as f64;
        *n += row.count as f64;
    }
    (0..).zip(sums).filter(|(_, (_, n))| *n > 0.0).map(|(condition, (sum, n))| (condition, sum / n)).collect()
}

/// Whether the model itself, as an observer, gave ratings.
fn is_circular(source: &Source) -> bool {
    let observers =
        sittings::all(source).filter_map(|(_, sitting)| sitting.observer.as_ref()?.get("observer")?.as_str());
    observers.into_iter().any(|observer| observer == "vision")
}
