//! Names of participants, factors, levels and categories, as used in sentences and tables.

use crate::{
    analysis::{
        Results,
        counts::{Counts, MISSING},
        number_of,
        results::{FactorResults, SubjectResults},
        summary::Group,
        terms::TermPart,
    },
    experiment::Protocol,
    report::document::{
        Shown,
        numbers::{count, list},
    },
    text::Cell,
};

/// The suffix of a column with values in degrees.
const DEGREES: &str = "_deg";

/// Returns the name of a factor or a term; `orientation` for `orientation_deg`, because its levels are shown with their
/// unit, and `age` for `num:age`.
pub(super) fn factor(name: &str) -> &str {
    let name = name.strip_prefix("num:").filter(|name| !name.contains(':')).unwrap_or(name);
    name.strip_suffix(DEGREES).filter(|name| !name.is_empty()).unwrap_or(name)
}

/// Formats a level, such as `45°`, `∞` or `0.4`; `(none)` if the value is missing.
pub(super) fn level(factor: &str, level: &str) -> Shown {
    let number = number_of(level);
    let text = match level {
        "" | MISSING => "(none)".to_owned(),
        "inf" => "∞".to_owned(),
        _ if factor.ends_with(DEGREES) && number.is_some() => format!("{level}°"),
        _ => level.to_owned(),
    };
    Shown::new(number.map_or_else(|| Cell::from(level), Cell::Number), text)
}

/// Returns the level of a group of ratings.
pub(super) fn level_of(factor: &FactorResults, group: &Group) -> Shown {
    level(&factor.name, group.names.first().map_or("", String::as_str))
}

/// Lists the levels of a condition, for the factors that vary: `width 0.4, depth ∞`.
pub(super) fn condition(counts: &Counts, condition: u32) -> String {
    let levels = counts.factors.iter().zip(counts.level_names(condition));
    let parts: Vec<String> = (levels.filter(|(one, _)| one.levels.len() > 1))
        .map(|(one, name)| format!("{} {}", factor(&one.name), level(&one.name, name)))
        .collect();
    if parts.is_empty() { "the only condition".to_owned() } else { parts.join(", ") }
}

/// Returns the participant's ID.
pub(super) fn participant(subject: &SubjectResults) -> &str {
    subject.group.names.first().map_or("", String::as_str)
}

/// Returns the participant for a sentence: `participant 97`, or an ID that is no number.
pub(super) fn who(subject: &SubjectResults) -> String {
    let id = participant(subject);
    if number_of(id).is_some() { format!("participant {id}") } else { id.to_owned() }
}

/// Returns a coefficient for a table, such as `depth ∞` or `width 0.4 × depth 2`.
pub(super) fn coefficient(parts: &[TermPart]) -> String {
    let part = |part: &TermPart| {
        let name = factor(part.variable.name());
        part.level
            .as_ref()
            .map_or_else(|| name.to_owned(), |own| format!("{name} {}", level(part.variable.name(), own)))
    };
    parts.iter().map(part).collect::<Vec<_>>().join(" × ")
}

/// Returns participants for the beginning of a sentence. An ID keeps its case.
pub(super) fn first_word(who: String) -> String {
    if who.starts_with("participant ") { capitalized(&who) } else { who }
}

/// Begins a sentence with a capital letter.
pub(super) fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Returns the answers of a definition, such as `0 (No band)`.
pub(super) fn categories_of(protocol: &Protocol) -> Vec<String> {
    let categories = protocol.response.categories.iter().enumerate();
    categories.map(|(rating, category)| format!("{rating} ({})", category.label)).collect()
}

/// Returns the lowest and the highest category, with their labels if there is a definition.
pub(super) fn ends(counts: &Counts, protocol: Option<&Protocol>) -> Option<(String, String)> {
    let names = match protocol {
        Some(protocol) if protocol.response.categories.len() == counts.categories.len() => categories_of(protocol),
        _ => counts.categories.clone(),
    };
    Some((names.first()?.clone(), names.last()?.clone()))
}

/// True if the categories are not numbers, so that means are computed from their positions, counted from 0.
pub(super) fn categories_are_texts(counts: &Counts) -> bool {
    counts.categories.iter().any(|category| !number_of(category).is_some_and(f64::is_finite))
}

/// Describes the sample in a sentence: `8 participants gave 1,920 ratings of 45 conditions, which differ in …`. The
/// sentence ends with the name of each factor that varies and the result of `levels` for it.
pub(super) fn rated(who: &str, results: &Results, differ: &str, levels: impl Fn(&FactorResults) -> String) -> String {
    let counts = &results.measured.counts;
    let varied: Vec<String> = varied(results).map(|one| format!("{} ({})", factor(&one.name), levels(one))).collect();
    let by = if varied.is_empty() { String::new() } else { format!(", {differ} {}", list(&varied)) };
    let (ratings, conditions) = (count(counts.total(), "rating"), count(counts.conditions.len() as u64, "condition"));
    format!("{who} gave {ratings} of {conditions}{by}.")
}

/// Returns the factors that vary.
pub(super) fn varied(results: &Results) -> impl Iterator<Item = &FactorResults> {
    results.factors.iter().filter(|factor| factor.levels.len() > 1)
}
