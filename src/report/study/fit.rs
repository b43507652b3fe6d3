//! How well the model describes the ratings: simulated studies, and the influence of each participant.

use super::names;
use crate::{
    analysis::{Checks, Contrast, Influence, Model, Proportion, Results},
    report::{
        document::{
            Section,
            numbers::{count, fixed, list, range, short_list, unit, whole},
        },
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
    let row = |p: &&Proportion| {
        vec![
            names::factor(results, &p.factor).into(),
            names::level(results, &p.factor, &p.level),
            (&p.category).into(),
            unit(p.observed),
            unit(p.expected),
            range(Some(p.range), unit),
        ]
    };
    /// More rows would not be read.
    const MOST: usize = 24;
    let cells = checks.cells.iter().filter(is_outside).filter(|_| far <= MOST);
    let rows = outside.iter().copied().chain(cells).map(|p| row(&p)).collect::<Vec<_>>();
    if !rows.is_empty() {
        let numbers = ["Observed", "Expected", "Middle 95\u{a0}%"];
        section.table("Proportions outside the middle 95\u{a0}%", &["Factor", "Level", "Rating"], &numbers, rows);
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
    let heads: Vec<String> = (model.contrasts.iter())
        .map(|c| {
            format!(
                "{} {} – {}",
                names::factor(results, &c.factor),
                names::level(results, &c.factor, &c.level),
                names::level(results, &c.factor, &c.other)
            )
        })
        .collect();
    let mut rows = vec![
        std::iter::once("none".into()).chain(model.contrasts.iter().map(|c| fixed(c.estimate, 2))).collect::<Vec<_>>(),
    ];
    rows.extend(checks.influence.iter().map(|one| {
        std::iter::once((&one.subject).into()).chain(one.estimates.iter().map(|estimate| fixed(*estimate, 2))).collect()
    }));
    section.table(
        "Contrasts on the latent scale with one participant left out",
        &["Left out"],
        &heads.iter().map(String::as_str).collect::<Vec<_>>(),
        rows,
    );
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
