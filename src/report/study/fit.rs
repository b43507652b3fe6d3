//! How well the model describes the ratings: simulated studies, and the influence of each participant.

use super::names;
use crate::{
    analysis::{Checks, Contrast, Influence, Model, Proportion, Results},
    report::{
        document::{Section, TableOf, count, fixed, list, range, short_list, unit, whole},
        figures::Figure,
    },
};

/// Says how well the model describes the data.
pub(super) fn fit_of_model(
    section: &mut Section,
    results: &Results,
    model: &Model,
    checks: &Checks,
    figures: &[Figure],
) {
    section.heading("Does the model describe the ratings?");
    section.text(
        "Studies were simulated from the model. An observed proportion outside the middle 95\u{a0}% of them suggests that the \
         model does not describe these ratings. Because it was fitted to them, few should lie outside.",
    );
    section.figures(figures, &["predictive"]);
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
    influence(section, results, model, checks);
}

fn influence(section: &mut Section, results: &Results, model: &Model, checks: &Checks) {
    if checks.influence.is_empty() || model.contrasts.is_empty() {
        return;
    }
    let none = model.contrasts.iter().map(|contrast| Some(contrast.estimate)).collect();
    let left_out = checks.influence.iter().map(|one| (one.subject.as_str(), one.estimates.clone()));
    let rows: Vec<(&str, Vec<Option<f64>>)> = std::iter::once(("none", none)).chain(left_out).collect();
    let caption = "Contrasts on the latent scale with one participant left out";
    let mut table = TableOf::new(caption, &rows).text("Left out", |(who, _)| *who);
    for (place, contrast) in model.contrasts.iter().enumerate() {
        let [level, other] =
            [&contrast.level, &contrast.other].map(|level| names::level(results, &contrast.factor, level));
        let heading = format!("{} {level} – {other}", names::factor(results, &contrast.factor));
        table = table.number(heading, |(_, estimates)| fixed(estimates[place], 2));
    }
    table.add_to(section);
    let changes = |contrast: &Contrast, place: usize| -> Vec<String> {
        let flips = |one: &&Influence| one.estimates[place].is_some_and(|estimate| estimate * contrast.estimate < 0.0);
        checks.influence.iter().filter(flips).map(|one| one.subject.clone()).collect()
    };
    for (place, contrast) in model.contrasts.iter().enumerate() {
        let clear = contrast.interval.is_some_and(|interval| interval.low > 0.0 || interval.high < 0.0);
        let who = changes(contrast, place);
        if clear && !who.is_empty() {
            let name = names::factor(results, &contrast.factor);
            section.text(format!("Without {}, the effect of {name} changes its direction.", short_list(&who, 6)));
        }
    }
    if results.people() > checks.influence.len() {
        section.note("Participants are left out only in studies with up to 60 of them.");
    }
}
