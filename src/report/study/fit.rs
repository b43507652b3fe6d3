//! How well the model describes the ratings, by simulated studies.

use super::names;
use crate::{
    analysis::{Checks, Proportion, Results},
    report::document::{Section, TableOf, count, fixed, list, range, unit, whole},
};

/// Says how well the model describes the data.
pub(super) fn fit_of_model(section: &mut Section, results: &Results, checks: &Checks) {
    section.heading("Does the model describe the ratings?");
    section.text(
        "Studies were simulated from the model. An observed proportion outside the middle 95\u{a0}% of them suggests that the \
         model does not describe these ratings. Because it was fitted to them, few should lie outside.",
    );
    let is_outside = |p: &&Proportion| p.is_outside();
    let outside: Vec<&Proportion> = checks.proportions.iter().filter(is_outside).collect();
    let far = checks.cells.iter().filter(is_outside).count();
    let lie = |number: usize| match number {
        0 => "none lies".to_owned(),
        1 => "one lies".to_owned(),
        n => format!("{} lie", whole(n as u64)),
    };
    let poor = if checks.is_poor() { ": more than chance allows, so the model does not describe them" } else { "" };
    section.text(format!(
        "Of {} at the levels of the factors, {} outside{}.",
        count(checks.proportions.len() as u64, "proportion"),
        lie(outside.len()),
        if checks.cells.is_empty() { poor } else { "" }
    ));
    if !checks.cells.is_empty() {
        section.text(format!(
            "Of {} in the single combinations of {}, {} outside{}.",
            count(checks.cells.len() as u64, "proportion"),
            list(&results.factors.iter().map(|factor| names::factor(results, &factor.name)).collect::<Vec<_>>()),
            lie(far),
            if checks.is_poor() { poor } else { ": no more than chance allows" }
        ));
    }
    /// More rows would not be read.
    const MOST: usize = 24;
    let cells = checks.cells.iter().filter(is_outside).filter(|_| far <= MOST);
    let rows: Vec<&Proportion> = outside.iter().copied().chain(cells).collect();
    if !rows.is_empty() {
        TableOf::new("Proportions outside the middle 95\u{a0}%", &rows)
            .text("Factor", |own| names::factor(results, &own.factor))
            .text("Level", |own| names::level(results, &own.factor, &own.level))
            .text("Rating", |own| &own.category)
            .number("Observed", |own| unit(own.observed))
            .number("Expected", |own| unit(own.expected))
            .number("Middle 95\u{a0}%", |own| range(Some(own.range), unit))
            .add_to(section);
    }
    if let Some((observed, range_of_spread)) = checks.spread {
        let fits = observed >= range_of_spread.low && observed <= range_of_spread.high;
        section.text(format!(
            "The participants’ mean ratings have a standard deviation of {} categories; simulated studies have {}, which \
             is {} with the model.",
            fixed(observed, 2),
            range(Some(range_of_spread), |x| fixed(x, 2)),
            if fits { "consistent" } else { "not consistent" }
        ));
    }
}
