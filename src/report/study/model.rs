//! The section about the model: its specification, its results, and whether its assumptions hold.

use super::names;
use crate::{
    analysis::{
        Checks, Coefficient, Comparison, Link, Model, ModelReport, RandomEffect, RandomSlope, Results, TermTest,
        Withheld, terms::Term,
    },
    report::{
        document::{Section, TableOf, count, fixed, list, mean, probability, range, ratio, unit, whole},
        figures::Figure,
    },
};

pub(super) fn section(results: &Results, figures: &[Figure]) -> Section {
    let mut section = Section::new("model", "Model");
    let report = match &results.model {
        Ok(report) => report,
        Err(error) => {
            section.warning(format!("No model could be fitted: {error}."));
            section.text("The descriptive statistics do not depend on it.");
            return section;
        }
    };
    let model = &report.model;
    formula(&mut section, results, model);
    section.list(model.notes.iter().map(|note| names::note(results, model, note)).collect());
    section.figures(figures, &["effects"]);
    coefficients(&mut section, results, model);
    TableOf::new("Thresholds between the categories, on the latent scale", &model.thresholds)
        .text("Between", |threshold| &threshold.name)
        .number("Estimate", |threshold| fixed(threshold.estimate, 3))
        .number("SE", |threshold| fixed(threshold.se, 3))
        .add_to(&mut section);
    if let Some(random) = &model.random {
        between_people(&mut section, results, model, random);
    }
    comparisons(&mut section, results, report);
    margins(&mut section, results, report);
    tests(&mut section, results, report);
    order(&mut section, report);
    if let Some(checks) = &report.checks {
        fit_of_model(&mut section, checks);
    }
    section
}

/// Describes how ratings depend on the order of the trials.
fn order(section: &mut Section, report: &ModelReport) {
    let Some(order) = &report.order else { return };
    section.heading("Do ratings depend on the order of the trials?");
    let facts = [
        ("Change of the latent rating from the first to the last trial of a session", fixed(order.drift, 2)),
        ("p of the change, from the signs of at least six participants", probability(order.drift_p)),
        ("Correlation of the residuals of successive trials", unit(order.lag_one)),
        ("p of the correlation, if any order of a session’s residuals is equally likely", probability(order.lag_one_p)),
        ("Ratings whose order is known", whole(order.ratings)),
    ];
    section.facts("Drift and dependence of successive ratings, beyond the effects in the model", facts);
    if order.drift.is_none() {
        section.note("A drift cannot be told from effects, because each condition has its place in the sessions.");
    }
}

/// Describes how much participants differ.
fn between_people(section: &mut Section, results: &Results, model: &Model, random: &RandomEffect) {
    section.heading("Differences between participants");
    let mut rows = vec![("Intercept".to_owned(), random.sd, random.se)];
    let of = |name: String, own: &RandomSlope| (name, own.sd, own.se);
    rows.extend(random.slopes.iter().map(|slope| of(names::slope(results, model, slope), slope)));
    let of_items = |items: &RandomSlope| of(format!("Intercept of {}", names::factor(results, &items.name)), items);
    rows.extend(random.items.as_ref().map(of_items));
    let items = if random.items.is_some() { " and between items" } else { "" };
    let caption = format!("Standard deviations between participants{items}, on the latent scale");
    TableOf::new(caption, &rows)
        .text("Of", |(name, ..)| name)
        .number("SD", |(_, sd, se)| fixed(*sd, decimals(*sd, *se)))
        .number("SE", |(_, sd, se)| fixed(*se, decimals(*sd, *se)))
        .add_to(section);
}

fn comparisons(section: &mut Section, results: &Results, report: &ModelReport) {
    if report.comparisons.is_empty() {
        return;
    }
    section.heading("Comparisons of levels");
    section.text(format!(
        "Differences on the latent scale, in the model: the later level minus the earlier one. Their p values and intervals come \
         from the likelihood ratio of each difference{}.{} Holm’s method corrects p for all comparisons of a factor; the intervals \
         are not corrected.",
        if report.terms.iter().any(|test| test.draws.is_some()) {
            ", scaled by the limit that simulated studies give for its term"
        } else {
            ""
        },
        if_interacting(
            results,
            " Those of differences at a level of another factor (simple effects) come from their standard errors, also among \
             the coefficients above."
        )
    ));
    let level = |c: &Comparison, level: &str| names::level(results, &c.factor, level);
    let at = |(factor, level): &(String, String)| {
        format!("{} {}", names::factor(results, factor), names::level(results, factor, level))
    };
    TableOf::new("Differences between levels", &report.comparisons)
        .text("Factor", |c| names::factor(results, &c.factor))
        .text("Levels", |c| format!("{} – {}", level(c, &c.level), level(c, &c.other)))
        .text("At", |c| match &c.at {
            Some(place) => at(place),
            None if c.average => "all, on average".to_owned(),
            None => String::new(),
        })
        .number("Difference", |c| fixed(c.estimate, 2))
        .number("95\u{a0}% interval", |c| range(c.interval, |x| fixed(x, 2)))
        .number("p", |c| probability(c.p))
        .number("Holm-corrected p", |c| probability(c.p_holm))
        .add_to(section);
    for of_factor in report.comparisons.chunk_by(|a, b| a.factor == b.factor) {
        if let Some((comparison, reason)) = of_factor.first().and_then(|first| Some((first, first.withheld?))) {
            section.note(format!("No p for differences of {}: {reason}.", names::factor(results, &comparison.factor)));
        }
    }
}

fn margins(section: &mut Section, results: &Results, report: &ModelReport) {
    if report.margins.is_empty() {
        return;
    }
    section.heading("Estimated marginal means");
    let covariates = if results.covariates.is_empty() { "" } else { ", with covariates at their means" };
    let over = match is_additive(results) {
        true if results.factors.len() == 1 => "",
        true => ", averaged over the conditions of the other factors",
        false => {
            ", averaged over the conditions of the other factors or, for a factor in an interaction, over those in which all of \
             its levels were rated"
        }
    };
    section.text(format!(
        "The rating that the model expects{}{over}{covariates}. Unequal numbers of ratings do not matter.",
        match &report.model.random {
            None => "",
            Some(random) if random.items.is_some() => " of a participant and an item with average random effects",
            Some(_) => " of a participant with average random effects",
        }
    ));
    TableOf::new("Expected ratings", &report.margins)
        .text("Factor", |margin| names::factor(results, &margin.factor))
        .text("Level", |margin| names::level(results, &margin.factor, &margin.level))
        .number("Expected rating", |margin| mean(margin.mean))
        .number("95\u{a0}% interval", |margin| range(margin.interval, mean))
        .add_to(section);
}

/// True if the model has no interaction.
pub(super) fn is_additive(results: &Results) -> bool {
    results.spec.terms.iter().all(Term::is_main)
}

/// Returns a text about interactions if the model has some.
fn if_interacting<'a>(results: &Results, text: &'a str) -> &'a str {
    if is_additive(results) { "" } else { text }
}

fn formula(section: &mut Section, results: &Results, model: &Model) {
    let cdf = match model.link {
        Link::Logit => "logistic",
        Link::Probit => "normal",
    };
    let (who, shift, effects) = match &model.random {
        None => ("", "", " and β the coefficients"),
        Some(random) if random.items.is_some() => (
            " and every participant",
            " − u",
            ", β the coefficients, and u the random effects of the participant and the item",
        ),
        Some(_) => {
            (" and every participant", " − u", ", β the coefficients, and u the random effects of the participant")
        }
    };
    section.text(format!(
        "Ratings are ordered, but the steps between categories are not necessarily equal. The model therefore does not \
         average ratings: it places thresholds on a latent scale, and every condition{who} shifts the ratings along this \
         scale. A positive shift means higher ratings."
    ));
    section.code(format!("P(rating ≤ j) = F(θ[j] − x·β{shift})"));
    let slopes = model.random.iter().flat_map(|random| &random.slopes);
    let slopes: Vec<String> = slopes.map(|slope| names::slope(results, model, slope)).collect();
    let differ = match &slopes[..] {
        _ if model.random.is_none() || !results.is_inferential() => String::new(),
        [] => " Participants differ only in how high they rate; every effect is the same for all.".to_owned(),
        slopes => format!(
            " Participants may also differ in the effects of {}, so tests and intervals of these effects allow for differences \
             between people.",
            list(slopes)
        ),
    };
    section.text(format!("F is the {cdf} distribution function, θ are the thresholds{effects}.{differ}"));
}

fn coefficients(section: &mut Section, results: &Results, model: &Model) {
    section.heading("Coefficients");
    if model.coefficients.is_empty() {
        section.text("The model has no terms, so it describes all ratings in the same way.");
        return;
    }
    section.text(format!(
        "A level’s coefficient is its shift relative to the factor’s baseline, the level without a coefficient. {}",
        match model.link {
            Link::Logit => "An odds ratio above 1 means that higher ratings are more likely.",
            Link::Probit => "One unit is a standard deviation of the latent ratings.",
        }
    ));
    let of = |c: &Coefficient| {
        let is_of_number = c.parts.iter().any(|part| part.level.is_none());
        if is_of_number { decimals(c.estimate, c.se) } else { 3 }
    };
    let mut table = TableOf::new("Coefficients of the model", &model.coefficients)
        .text("Coefficient", |c| names::coefficient(results, &c.parts))
        .number("Estimate", |c| fixed(c.estimate, of(c)))
        .number("SE", |c| fixed(c.se, of(c)))
        .number("95\u{a0}% interval", |c| range(c.interval, |x| fixed(x, of(c))));
    if model.link == Link::Logit {
        let odds_ratio = |c: &Coefficient, x: f64| if of(c) > 3 { fixed(x.exp(), of(c)) } else { ratio(x.exp()) };
        table = table
            .number("Odds ratio", |c| odds_ratio(c, c.estimate))
            .number("95\u{a0}% interval of the odds ratio", |c| range(c.interval, |x| odds_ratio(c, x)));
    }
    table.add_to(section);
}

/// Returns the decimals of an estimate: more than three if it is small, as that of a number with a large range.
fn decimals(estimate: f64, se: Option<f64>) -> usize {
    let size = estimate.abs().max(se.unwrap_or(0.0));
    if size > 0.0 && size < 0.01 { (2.0 - size.log10().floor()) as usize } else { 3 }
}

/// Adds the tests of the terms and of the interactions that the model leaves out.
fn tests(section: &mut Section, results: &Results, report: &ModelReport) {
    let interactions = report.interactions.iter().map(|own| ("interaction", &own.test));
    let rows: Vec<(&str, &TermTest)> = report.terms.iter().map(|test| ("effect", test)).chain(interactions).collect();
    if rows.is_empty() {
        return;
    }
    section.heading("Tests");
    section.text(format!(
        "A small p means that ratings like these would be rare if there were no such effect. Each effect is tested against the model \
         without its term{}.{}{} Methods says where p values come from.",
        if report.model.random.is_some() { ", with the same random effects" } else { "" },
        if_interacting(
            results,
            " For a main effect that is part of an interaction, its mean over the levels of the other factor is tested \
             (sum contrasts)."
        ),
        if report.interactions.is_empty() {
            ""
        } else {
            " Interactions that the model leaves out are tested because, in the model, the effect of each factor is the same at \
             every level of the other; their p is corrected for their number."
        }
    ));
    TableOf::new("Tests of terms", &rows)
        .text("Test of", |(kind, _)| *kind)
        .text("Term", |(_, test)| names::term(results, &test.term))
        .number("χ²", |(_, test)| fixed(test.chi_squared, 2))
        .number("df", |(_, test)| whole(test.df as u64))
        .number("p", |(_, test)| probability(test.p))
        .add_to(section);
    let mut withheld: Vec<(&str, Withheld, Vec<String>)> = Vec::new();
    for (kind, reason, test) in rows.iter().filter_map(|(kind, test)| Some((*kind, test.withheld?, test))) {
        let term = names::term(results, &test.term);
        match withheld.iter_mut().find(|own| (own.0, own.1) == (kind, reason)) {
            Some((.., terms)) => terms.push(term),
            None => withheld.push((kind, reason, vec![term])),
        }
    }
    for (kind, reason, terms) in withheld {
        let of = match (kind, terms.len()) {
            ("effect", _) => "",
            (_, 1) => "the interaction ",
            _ => "the interactions ",
        };
        section.note(format!("No p for {of}{}: {reason}.", list(&terms)));
    }
}

/// Says how well the model describes the data.
fn fit_of_model(section: &mut Section, checks: &Checks) {
    section.heading("Does the model describe the ratings?");
    let outside = match checks.proportions.iter().filter(|own| own.is_outside()).count() {
        0 => "none lies".to_owned(),
        1 => "one lies".to_owned(),
        n => format!("{} lie", whole(n as u64)),
    };
    let mut text = format!(
        "Studies were simulated from the model. An observed proportion outside the middle 95\u{a0}% of them suggests that the \
         model does not describe these ratings: for example, because an effect is not the same at every threshold, as the model \
         assumes (proportional odds). Because it was fitted to them, few should lie outside. Of {}, {outside} outside.",
        count(checks.proportions.len() as u64, "proportion")
    );
    if checks.is_poor() {
        text += " These are more than chance allows, so the model does not describe the ratings.";
    }
    section.text(text);
}
