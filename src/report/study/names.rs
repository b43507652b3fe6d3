//! Factors, levels and categories as sentences and tables name them.

use crate::{
    analysis::{Results, counts::Counts, number_of},
    experiment::Protocol,
};

/// The end of a column's name that says that its numbers are degrees.
const DEGREES: &str = "_deg";

/// The factor's name; `orientation` for `orientation_deg`, whose levels bear the unit.
pub(crate) fn factor(name: &str) -> &str {
    name.strip_suffix(DEGREES).filter(|name| !name.is_empty()).unwrap_or(name)
}

/// A level: `45°`, `∞`, `0.4`; `(none)` where the value is missing.
pub(crate) fn level(factor: &str, level: &str) -> String {
    match level {
        "" => "(none)".to_owned(),
        "inf" => "∞".to_owned(),
        _ if factor.ends_with(DEGREES) && number_of(level).is_some() => format!("{level}°"),
        _ => level.to_owned(),
    }
}

/// Whether going up through the levels leads back to the first: `rises with orientation` would mean nothing.
pub(crate) fn is_circular(factor: &str) -> bool {
    ["orientation", "angle", "hue", "direction"].iter().any(|word| factor.to_lowercase().contains(word))
}

/// Whether "more of it" has a meaning: numbers that are no directions.
pub(crate) fn is_ordered(counts: &Counts, name: &str) -> bool {
    let numbers = counts.factors.iter().find(|factor| factor.name == name).and_then(|factor| factor.numbers.as_ref());
    numbers.is_some() && !is_circular(name)
}

/// The answers of a definition: `0 (No band)`.
pub(crate) fn categories_of(protocol: &Protocol) -> Vec<String> {
    let categories = protocol.response.categories.iter().enumerate();
    categories.map(|(rating, category)| format!("{rating} ({})", category.label)).collect()
}

/// The lowest and the highest category, with what they mean where a definition tells.
pub(crate) fn ends(counts: &Counts, protocol: Option<&Protocol>) -> Option<(String, String)> {
    let names = match protocol {
        Some(protocol) if protocol.response.categories.len() == counts.categories.len() => categories_of(protocol),
        _ => counts.categories.clone(),
    };
    Some((names.first()?.clone(), names.last()?.clone()))
}

/// Whether the categories are texts, so that means count positions from 0.
pub(crate) fn categories_are_texts(counts: &Counts) -> bool {
    counts.categories.iter().any(|category| !number_of(category).is_some_and(f64::is_finite))
}

/// The factors that vary.
pub(crate) fn varied(results: &Results) -> impl Iterator<Item = &crate::analysis::results::FactorResults> {
    results.factors.iter().filter(|factor| factor.levels.len() > 1)
}
