//! The model: what was fitted, what came out, and whether its assumptions hold.

use maud::{Markup, html};

use super::{effects::around, names, summary::ALPHA};
use crate::analysis::{Coefficient, Link, Model, ModelReport, Note, Results, TermTest};
use crate::report::document::numbers::{fixed, maybe, p_is, percent, probability, range, ratio, whole};
use crate::report::skins::html::table::{Column, Kind, table};

/// The section.
pub(crate) fn section(results: &Results, figures: Markup) -> Markup {
    match &results.model {
        Err(error) => html! {
            p.warning { "No model could be fitted: " (error) "." }
            p { "The description above and the tests below do not depend on it." }
        },
        Ok(report) => html! {
            (formula(results, &report.model))
            (notes(&report.model))
            (figures)
            (coefficients(results, &report.model))
            (thresholds(results, &report.model))
            (random(&report.model))
            (fit(&report.model))
            @if results.is_inferential() { (tests(results, report)) }
        },
    }
}

/// The call that fits the same model with R's `ordinal`.
pub(crate) fn call(results: &Results, model: &Model) -> String {
    let terms = &results.spec.terms;
    let mut parts: Vec<String> = terms.iter().map(|term| term.to_string().replace("num:", "")).collect();
    if parts.is_empty() {
        parts.push("1".to_owned());
    }
    if model.random.is_some() {
        parts.push("(1 | subject)".to_owned());
    }
    let function = if model.random.is_some() { "clmm" } else { "clm" };
    let nodes = if results.spec.quadrature > 1 && model.random.is_some() {
        format!(", nAGQ = {}", results.spec.quadrature)
    } else {
        String::new()
    };
    format!("{function}(rating ~ {}, link = \"{}\"{nodes})", parts.join(" + "), model.link)
}

fn formula(results: &Results, model: &Model) -> Markup {
    let subject = model.random.is_some();
    let cdf = match model.link {
        Link::Logit => "the logistic distribution function",
        Link::Probit => "the normal distribution function",
    };
    html! {
        p {
            "Ratings are ordered, but nothing says that the step from one category to the next is always the same size. "
            "The model therefore takes no means of ratings: it places thresholds on a scale of its own, the latent scale, and every "
            "condition" @if subject { " and every participant" } " shifts the ratings along it. A positive shift means higher ratings."
        }
        p.formula {
            "P(rating of condition " i { "i" } @if subject { " by participant " i { "s" } } " ≤ " i { "j" } ") = "
            i { "F" } "(" i { "θ" } sub { i { "j" } } " − " i { "x" } sub { i { "i" } } i { "β" }
            @if subject { " − " i { "u" } sub { i { "s" } } } ")"
            @if subject { ", " i { "u" } sub { i { "s" } } " ~ N(0, " i { "σ" } sup { "2" } ")" }
        }
        p { i { "F" } " is " (cdf) ", " i { "θ" } " are the thresholds and " i { "β" } " the coefficients. In R’s notation:" }
        pre { code { (call(results, model)) } }
        @if subject && results.is_inferential() {
            p {
                "Participants differ in how high they rate, and in nothing else: the model takes every effect to be the same for all. "
                "Where it is not, the intervals of the model are too narrow; the rank tests below, for which each participant is one observation, do not assume it."
            }
        }
    }
}

fn notes(model: &Model) -> Markup {
    html! {
        @if !model.notes.is_empty() {
            h3 { "What was recognised in the data" }
            ul { @for note in &model.notes { li class=[grave(note)] { (note) "." } } }
        }
    }
}

fn grave(note: &Note) -> Option<&'static str> {
    let grave = matches!(note, Note::NotConverged { .. } | Note::RunawayVariance | Note::NoMixedModel | Note::Flat);
    grave.then_some("warning")
}

fn coefficients(results: &Results, model: &Model) -> Markup {
    let sure = results.is_inferential();
    let odds = model.link == Link::Logit;
    let mut columns: Vec<Column<'_>> = vec![("Coefficient", Kind::Code), ("Estimate", Kind::Number)];
    if sure {
        columns.extend([("SE", Kind::Number), ("z", Kind::Number), ("p", Kind::Number)]);
        columns.push(("95\u{a0}% interval", Kind::Number));
    }
    if odds {
        columns.push(("Odds ratio", Kind::Number));
    }
    if odds && sure {
        columns.push(("95\u{a0}% interval of the odds ratio", Kind::Number));
    }
    let row = |c: &Coefficient| -> Vec<String> {
        let interval = c.se.filter(|se| se.is_finite()).map(|se| around(c.estimate, se));
        let mut row = vec![c.name.clone(), fixed(c.estimate, 3)];
        if sure {
            row.extend([maybe(c.se, 3), maybe(c.z, 2), c.p.map_or_else(|| "–".to_owned(), probability)]);
            row.push(range(interval, |x| fixed(x, 2)));
        }
        if odds {
            row.push(ratio(c.estimate.exp()));
        }
        if odds && sure {
            row.push(range(interval, |x| ratio(x.exp())));
        }
        row
    };
    let rows: Vec<Vec<String>> = model.coefficients.iter().map(row).collect();
    html! {
        h3 { "Coefficients" }
        @if rows.is_empty() {
            p { "The model has no terms: it describes all ratings alike." }
        } @else {
            p { (reading_coefficients(results, model)) }
            (table("Coefficients of the model", &columns, rows))
        }
        @if !model.scale.is_empty() {
            (table("Effects on the spread of the ratings (log scale)", &columns[..columns.len().min(2)], model.scale.iter().map(|c| vec![c.name.clone(), fixed(c.estimate, 3)]).collect::<Vec<_>>()))
        }
    }
}

fn reading_coefficients(results: &Results, model: &Model) -> String {
    let factors = results.spec.terms.iter().flat_map(|term| &term.variables);
    let baseline = factors.filter(|v| matches!(v, crate::analysis::terms::Variable::Factor(_))).count();
    let against = if baseline > 0 {
        "A level’s coefficient is its shift against the factor’s baseline, the level without a coefficient. "
    } else {
        ""
    };
    let meaning = match model.link {
        Link::Logit => "An odds ratio above 1 means that higher ratings are more likely.",
        Link::Probit => "One unit is a standard deviation of the latent ratings.",
    };
    let sure = if results.is_inferential() {
        ""
    } else {
        " With one participant there are no intervals for other people, so none are given."
    };
    format!("{against}{meaning}{sure}")
}

fn thresholds(results: &Results, model: &Model) -> Markup {
    let sure = results.is_inferential();
    let mut columns: Vec<Column<'_>> = vec![("Between", Kind::Code), ("Estimate", Kind::Number)];
    if sure {
        columns.push(("SE", Kind::Number));
    }
    let rows: Vec<Vec<String>> = (model.thresholds.iter())
        .map(|threshold| {
            let mut row = vec![threshold.name.clone(), fixed(threshold.estimate, 3)];
            if sure {
                row.push(maybe(threshold.se, 3));
            }
            row
        })
        .collect();
    html! {
        h3 { "Thresholds" }
        (table("Thresholds between the categories, on the latent scale", &columns, rows))
    }
}

fn random(model: &Model) -> Markup {
    let Some(random) = &model.random else { return html! {} };
    let se = random.se.map(|se| format!(" (SE {})", fixed(se, 3))).unwrap_or_default();
    let rows: Vec<Vec<String>> =
        random.subjects.iter().map(|s| vec![s.subject.clone(), fixed(s.mode, 2), fixed(s.sd, 2)]).collect();
    html! {
        h3 { "Participants in the model" }
        p { "Between participants the shift has a standard deviation of " (fixed(random.sd, 3)) (se) " on the latent scale." }
        (table("Shift of each participant; positive gives higher ratings", &[("Participant", Kind::Text), ("Shift", Kind::Number), ("Conditional SD", Kind::Number)], rows))
    }
}

fn fit(model: &Model) -> Markup {
    let row = |what: &str, value: String| vec![what.to_owned(), value];
    let rows = vec![
        row("Method", model.method.clone()),
        row("Ratings", whole(model.nobs)),
        row("Parameters", whole(model.parameters as u64)),
        row("Log-likelihood", fixed(model.loglik, 2)),
        row("AIC", fixed(model.aic(), 2)),
        row("Iterations", whole(model.iterations as u64)),
        row("Largest gradient", format!("{:.1e}", model.gradient)),
        row("Converged", if model.converged() { "yes" } else { "no" }.to_owned()),
    ];
    html! {
        h3 { "Fit" }
        (table("The fit of the model", &[("What", Kind::Text), ("Value", Kind::Number)], rows))
    }
}

/// Likelihood-ratio tests as a table.
fn ratios(caption: &str, tests: &[TermTest]) -> Markup {
    let columns = [("Term", Kind::Code), ("χ²", Kind::Number), ("df", Kind::Number), ("p", Kind::Number)];
    let row = |test: &TermTest| {
        let p = test.p.map_or_else(|| "–".to_owned(), probability);
        vec![test.term.clone(), maybe(test.lr, 2), test.df.to_string(), p]
    };
    table(caption, &columns, tests.iter().map(row).collect::<Vec<_>>())
}

fn tests(results: &Results, report: &ModelReport) -> Markup {
    let violated: Vec<&TermTest> =
        report.proportional_odds.iter().filter(|test| test.p.is_some_and(|p| p < ALPHA)).collect();
    html! {
        @if !report.terms.is_empty() {
            h3 { "Does each term matter?" }
            p { "Each row compares the model with the one without the term. A small p says that ratings like these would be rare if the term had no effect. The probabilities are not corrected for the number of terms." }
            (ratios("Likelihood-ratio tests against the model without each term", &report.terms))
        }
        @if !report.proportional_odds.is_empty() {
            h3 { "Is one number for each effect enough?" }
            p {
                "The model gives a term the same effect at every threshold (proportional odds). Each row tests this against an effect of its own at each threshold; the differences between participants are left out of this test."
            }
            (ratios("Tests of proportional odds", &report.proportional_odds))
            @if violated.is_empty() {
                p { "No term shows a violation at " (percent(ALPHA)) ". With few ratings the test sees little." }
            } @else {
                @for test in violated {
                    p { "The effect of " (names::factor(&test.term)) " differs between the thresholds (" (p_is(test.p.unwrap_or(f64::NAN))) "). Its coefficients are averages over the scale: trust their direction more than their size, and look at the proportions of the categories." }
                }
            }
        }
        @if !results.scale.is_empty() {
            h3 { "Do ratings scatter more under some conditions?" }
            p { "Each row tests whether a term also changes the spread of the ratings; the differences between participants are left out." }
            (ratios("Tests of effects on the spread", &results.scale))
        }
    }
}
