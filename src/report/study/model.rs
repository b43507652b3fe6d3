//! The section about the model: its specification, its results, and whether its assumptions hold.

use super::{cautions::is_serious, findings::ALPHA};
use crate::{
    analysis::{Coefficient, Link, Model, Results, TermTest, Threshold, interval::Interval, terms::Variable},
    report::{
        document::{
            Section,
            numbers::{count, fixed, percent, probability, range, ratio},
        },
        figures::Figure,
    },
};

pub(super) fn section(results: &Results, figures: &[Figure]) -> Section {
    let mut section = Section::new("model", "Model");
    let report = match &results.model {
        Ok(report) => report,
        Err(error) => {
            section.warning(format!("No model could be fitted: {error}."));
            section.text("The descriptive statistics and the rank tests do not depend on it.");
            return section;
        }
    };
    let model = &report.model;
    formula(&mut section, results, model);
    let (serious, others): (Vec<_>, Vec<_>) = model.notes.iter().partition(|note| is_serious(note));
    serious.iter().for_each(|note| section.warning(format!("{note}.")));
    section.list(others.iter().map(|note| format!("{note}.")).collect());
    section.figures(figures, &["effects"]);
    coefficients(&mut section, results, model);
    let numbers: &[&str] = if results.is_inferential() { &["Estimate", "SE"] } else { &["Estimate"] };
    let threshold = |threshold: &Threshold| {
        let cells = [threshold.name.clone(), fixed(threshold.estimate, 3), fixed(threshold.se, 3)];
        cells.into_iter().take(1 + numbers.len()).collect()
    };
    let caption = "Thresholds between the categories, on the latent scale";
    section.table(caption, &["Between"], numbers, model.thresholds.iter().map(threshold).collect());
    if let Some(random) = &model.random {
        let se = random.se.map(|se| format!(" (SE {})", fixed(se, 3))).unwrap_or_default();
        section.text(format!(
            "The shifts of the participants on the latent scale have a standard deviation of {}{se}.",
            fixed(random.sd, 3)
        ));
        let rows = random.subjects.iter().map(|s| vec![s.subject.clone(), fixed(s.mode, 2), fixed(s.sd, 2)]).collect();
        let caption = "Shift of each participant; positive values mean higher ratings";
        section.table(caption, &["Participant"], &["Shift", "Conditional SD"], rows);
    }
    if results.is_inferential() {
        tests(
            &mut section,
            "Does each term matter?",
            "Each row compares the model with a model without the term. A small p means that ratings like these would \
             be rare if the term had no effect. The p values are not corrected for the number of terms.",
            "Likelihood-ratio tests against the model without each term",
            &report.terms,
        );
        tests(
            &mut section,
            "Is one coefficient per effect enough?",
            "The model assumes that a term has the same effect at every threshold (proportional odds). Each row tests this \
             against a separate effect at each threshold. This test ignores differences between participants.",
            "Tests of proportional odds",
            &report.proportional_odds,
        );
        let tested = !report.proportional_odds.is_empty();
        if tested && !report.proportional_odds.iter().any(|test| test.p.is_some_and(|p| p < ALPHA)) {
            let level = percent(ALPHA);
            section.text(format!("No term shows a violation at {level}. With few ratings, tests have little power."));
        }
        tests(
            &mut section,
            "Are ratings more variable in some conditions?",
            "Each row tests whether a term also changes the spread of the ratings. This test ignores differences between \
             participants.",
            "Tests of effects on the spread",
            &report.scale,
        );
    }
    section
}

/// Describes the fitted model in one line: `Fitted: cumulative-link mixed model (Laplace), logit link, terms width,
/// depth. …`.
fn sentence(results: &Results, model: &Model) -> String {
    let method = match model.method.as_str() {
        "clm" => "cumulative-link model".to_owned(),
        "clmm-laplace" => "cumulative-link mixed model (Laplace)".to_owned(),
        other => match other.strip_prefix("clmm-aghq-") {
            Some(nodes) => format!("cumulative-link mixed model (Gauss–Hermite, {nodes} nodes)"),
            None => other.to_owned(),
        },
    };
    let terms: Vec<String> = results.spec.terms.iter().map(ToString::to_string).collect();
    let terms = if terms.is_empty() { "no terms".to_owned() } else { format!("terms {}", terms.join(", ")) };
    let converged = if model.converged() {
        format!("converged in {}", count(model.iterations as u64, "iteration"))
    } else {
        "not converged".to_owned()
    };
    format!(
        "Fitted: {method}, {} link, {terms}. {}, {}; log-likelihood {}, AIC {}; {converged} (largest gradient {:.1e}).",
        model.link,
        count(model.nobs, "rating"),
        count(model.parameters as u64, "parameter"),
        fixed(model.loglik, 2),
        fixed(model.aic(), 2),
        model.gradient,
    )
}

/// Returns the call that fits the same model with R's `ordinal` package.
fn call(results: &Results, model: &Model) -> String {
    let mut parts: Vec<String> = results.spec.terms.iter().map(|term| term.to_string().replace("num:", "")).collect();
    if parts.is_empty() {
        parts.push("1".to_owned());
    }
    let mut function = "clm";
    let mut nodes = String::new();
    if model.random.is_some() {
        parts.push("(1 | subject)".to_owned());
        function = "clmm";
        if results.spec.quadrature > 1 {
            nodes = format!(", nAGQ = {}", results.spec.quadrature);
        }
    }
    format!("{function}(rating ~ {}, link = \"{}\"{nodes})", parts.join(" + "), model.link)
}

fn formula(section: &mut Section, results: &Results, model: &Model) {
    let mixed = model.random.is_some();
    let cdf = match model.link {
        Link::Logit => "logistic",
        Link::Probit => "normal",
    };
    let (who, by, shift, normal) = if mixed {
        (" and every participant", " by participant s", " − u[s]", ",   u[s] ~ N(0, σ²)")
    } else {
        ("", "", "", "")
    };
    section.text(format!(
        "Ratings are ordered, but the steps between categories are not necessarily equal. The model therefore does not \
         average ratings: it places thresholds on a latent scale, and every condition{who} shifts the ratings along this \
         scale. A positive shift means higher ratings."
    ));
    section.code(format!("P(rating of condition i{by} ≤ j) = F(θ[j] − x[i]·β{shift}){normal}"));
    section.text(format!(
        "F is the {cdf} distribution function, θ are the thresholds and β the coefficients. In R’s notation:"
    ));
    section.code(call(results, model));
    section.text(sentence(results, model));
    if mixed && results.is_inferential() {
        section.text(
            "In the model, participants differ only in how high they rate; every effect is the same for all. If effects \
             differ between participants, the model’s intervals are too narrow. The rank tests, which treat each participant \
             as one observation, do not make this assumption.",
        );
    }
}

fn coefficients(section: &mut Section, results: &Results, model: &Model) {
    section.heading("Coefficients");
    if model.coefficients.is_empty() {
        section.text("The model has no terms, so it describes all ratings in the same way.");
    } else {
        section.text(meaning(results, model));
        let odds = model.link == Link::Logit;
        coefficient_table(section, results, "Coefficients of the model", &model.coefficients, odds);
    }
    if !model.scale.is_empty() {
        let caption = "Effects on the spread of the ratings (log scale)";
        coefficient_table(section, results, caption, &model.scale, false);
    }
}

/// Adds a table of coefficients, with odds ratios if requested.
fn coefficient_table(section: &mut Section, results: &Results, caption: &str, all: &[Coefficient], odds: bool) {
    let inferential = results.is_inferential();
    let mut numbers = vec!["Estimate"];
    numbers.extend(inferential.then_some(["SE", "z", "p", "95\u{a0}% interval"]).into_iter().flatten());
    numbers.extend(odds.then_some("Odds ratio"));
    numbers.extend((odds && inferential).then_some("95\u{a0}% interval of the odds ratio"));
    let row = |c: &Coefficient| {
        let interval = Interval::wald(c.estimate, c.se);
        let mut cells = vec![c.name.clone(), fixed(c.estimate, 3)];
        if inferential {
            cells.extend([fixed(c.se, 3), fixed(c.z, 2), probability(c.p), range(interval, |x| fixed(x, 2))]);
        }
        cells.extend(odds.then(|| ratio(c.estimate.exp())));
        cells.extend((odds && inferential).then(|| range(interval, |x| ratio(x.exp()))));
        cells
    };
    section.table(caption, &["Coefficient"], &numbers, all.iter().map(row).collect());
}

fn meaning(results: &Results, model: &Model) -> String {
    let mut variables = results.spec.terms.iter().flat_map(|term| &term.variables);
    let mut text = String::new();
    if variables.any(|variable| matches!(variable, Variable::Factor(_))) {
        text +=
            "A level’s coefficient is its shift relative to the factor’s baseline, the level without a coefficient. ";
    }
    text += match model.link {
        Link::Logit => "An odds ratio above 1 means that higher ratings are more likely.",
        Link::Probit => "One unit is a standard deviation of the latent ratings.",
    };
    if !results.is_inferential() {
        text += " With one participant, there are no intervals that apply to other people, so none are given.";
    }
    text
}

/// Adds a table of likelihood-ratio tests, if there are any.
fn tests(section: &mut Section, heading: &str, about: &str, caption: &str, tests: &[TermTest]) {
    if tests.is_empty() {
        return;
    }
    let row = |test: &TermTest| vec![test.term.clone(), fixed(test.lr, 2), test.df.to_string(), probability(test.p)];
    section.heading(heading);
    section.text(about);
    section.table(caption, &["Term"], &["χ²", "df", "p"], tests.iter().map(row).collect());
}
