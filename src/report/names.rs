//! Names of factors and levels in words. A factor that is a parameter of the stimulus has the parameter's words and unit; any
//! other one is called as in the definition or the table.

use super::document::Shown;
use crate::{
    analysis::{
        Results,
        counts::MISSING,
        number_of,
        terms::{Term, TermPart},
    },
    experiment::{Category, Protocol},
    stimulus::{MachBand, Parameter},
    text::Cell,
};

/// The parameters of the stimulus that was shown; `None` for a table from elsewhere, whose columns may mean anything.
pub(crate) type Known = Option<&'static [Parameter]>;

impl From<&Results> for Known {
    fn from(results: &Results) -> Self {
        results.options.parameters
    }
}

/// A number is shown with at most this many significant digits, so that binary rounding noise does not appear.
const DIGITS: usize = 12;

fn parameter(known: Known, factor: &str) -> Option<&'static Parameter> {
    known?.iter().find(|parameter| parameter.name == factor)
}

fn is_degrees(parameter: &Parameter) -> bool {
    parameter.unit == "°"
}

/// Returns the name of a factor in a sentence, such as `orientation`, whose levels are shown with their unit.
pub(crate) fn factor(known: impl Into<Known>, factor: &str) -> String {
    parameter(known.into(), factor).map_or_else(|| factor.to_owned(), |parameter| parameter.option().replace('-', " "))
}

/// Returns a term in a sentence, such as `width`, or `width × depth` for `width:depth`.
pub(crate) fn term(known: impl Into<Known>, term: &Term) -> String {
    let known = known.into();
    term.variables.iter().map(|variable| factor(known, variable.name())).collect::<Vec<_>>().join(" × ")
}

/// Returns a coefficient, such as `depth ∞` or `width 0.4 × depth 2`.
pub(crate) fn coefficient(known: impl Into<Known>, parts: &[TermPart]) -> String {
    let known = known.into();
    let part = |TermPart { variable, level: own }: &TermPart| {
        let name = factor(known, variable.name());
        own.as_ref().map_or_else(|| name.clone(), |own| format!("{name} {}", level(known, variable.name(), own)))
    };
    parts.iter().map(part).collect::<Vec<_>>().join(" × ")
}

/// Formats a level, such as `45°`, `∞` or `−0.4`; `(none)` if the value is missing.
pub(crate) fn level(known: impl Into<Known>, factor: &str, level: &str) -> Shown {
    rounded_level(known, factor, level, DIGITS)
}

/// Formats a level as [`level`], with at most this many significant digits behind a point.
pub(crate) fn rounded_level(known: impl Into<Known>, factor: &str, level: &str, most: usize) -> Shown {
    let (known, number) = (known.into(), number_of(level));
    let text = match number {
        _ if ["", MISSING].contains(&level) => "(none)".to_owned(),
        Some(f64::INFINITY) => "∞".to_owned(),
        _ => {
            let digits = level.chars().filter(char::is_ascii_digit).count();
            let rounded = number
                .filter(|number| digits > most && number.fract() != 0.0 && number.is_finite())
                .and_then(|number| {
                    let after_first = (most - 1).max(number.abs().log10() as usize);
                    format!("{number:.after_first$e}").parse().ok().map(|number: f64| number.to_string())
                });
            let unit = if number.is_some() && parameter(known, factor).is_some_and(is_degrees) { "°" } else { "" };
            let shown = rounded.as_deref().unwrap_or(level);
            if number.is_some() { format!("{}{unit}", shown.replace('-', "−")) } else { shown.to_owned() }
        }
    };
    Shown::new(number.map_or_else(|| Cell::from(level), Cell::Number), text)
}

/// Returns the name of a factor as the title of an axis, with its unit.
pub(crate) fn axis(known: impl Into<Known>, factor: &str) -> String {
    let known = known.into();
    match parameter(known, factor).filter(|parameter| MachBand::PARAMETERS.contains(parameter)) {
        Some(Parameter { name: "width", .. }) => "Ramp width (proportion of the window)".to_owned(),
        Some(Parameter { name: "depth", .. }) => "Continuity depth n".to_owned(),
        _ => heading(known, factor),
    }
}

/// Returns the name of a factor as the heading of a legend, with its unit.
pub(crate) fn heading(known: impl Into<Known>, name: &str) -> String {
    let known = known.into();
    match parameter(known, name) {
        Some(parameter) if is_degrees(parameter) => format!("{} (°)", capitalized(&factor(known, name))),
        Some(_) => capitalized(&factor(known, name)),
        None => name.to_owned(),
    }
}

/// Returns the answers of a definition, such as `0 (No band)`, or `0` if this is its label.
pub(crate) fn categories_of(protocol: &Protocol) -> Vec<String> {
    let categories = protocol.response.categories.iter().enumerate();
    let name = |(rating, category): (usize, &Category)| match category.label == rating.to_string() {
        true => rating.to_string(),
        false => format!("{rating} ({})", category.label),
    };
    categories.map(name).collect()
}

/// Begins a sentence with a capital letter.
pub(crate) fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
